"""A glTF of two meshes becomes a compressed GLB with its page and report, by the examples of the doors' README files: the
same bytes whatever the door. Arguments: the command, and a program a door, with ',' between its words."""

import hashlib
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "doors"))
import inputs  # noqa: E402


def asset():
    """A glTF of two meshes, under a node each."""
    document = json.loads(inputs.asset())
    [mesh] = document["meshes"]
    document["meshes"] = [mesh | {"name": f"sheet {number}"} for number in (0, 1)]
    document["nodes"] = [{"name": f"node {number}", "mesh": number, "translation": [4.0 * number, 0, 0]}
                         for number in (0, 1)]
    document["scenes"] = [{"nodes": [0, 1]}]
    return json.dumps(document)


def run(program, folder):
    """The digest of the GLB that a door makes; its page and report must be of it."""
    folder.mkdir()
    (folder / "chair.gltf").write_text(asset())
    subprocess.run(program, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    glb = (folder / "smooth.glb").read_bytes()
    length = struct.unpack("<I", glb[12:16])[0]
    document = json.loads(glb[20 : 20 + length])
    assert "EXT_meshopt_compression" in document["extensionsUsed"], document["extensionsUsed"]
    assert {"node 0", "node 1"} <= {node.get("name") for node in document["nodes"]}, document["nodes"]
    page = (folder / "smooth.html").read_text()
    assert page.count('class="payload"') == 2, "a view of each mesh"
    assert "chair: 2 meshes" in page and "sheet 0" in page and "sheet 1" in page
    report = json.loads((folder / "smooth.json").read_text())
    digest = hashlib.sha256(glb).hexdigest()
    assert report["outputs"][0]["sha256"] == digest
    assert [mesh["asset"]["name"] for mesh in report["meshes"]] == ["sheet 0", "sheet 1"]
    return digest


def main():
    command, doors = sys.argv[1], [words.split(",") for words in sys.argv[2:]]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        said = [command, "fit", "chair.gltf", "-o", "smooth.glb", "--compress", "meshopt", "--page", "smooth.html",
                "--report", "smooth.json", "--quiet"]
        wanted = run(said, folder / "command")
        (folder / "bench.gltf").write_text(asset())
        both = [command, "fit", "command/chair.gltf", "bench.gltf", "-o", "out/", "--page", "both.html", "--quiet"]
        subprocess.run(both, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        page = (folder / "both.html").read_text()
        assert page.count('class="payload"') == 4 and "<title>2 jobs" in page
        assert all(f"{name}: sheet {mesh}" in page for name in ("chair", "bench") for mesh in (0, 1))
        for number, program in enumerate(doors):
            found = run(program, folder / str(number))
            assert found == wanted, (program, found, wanted)
            print(Path(program[0]).name, found)


if __name__ == "__main__":
    main()

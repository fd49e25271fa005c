"""A glTF of two meshes becomes a compressed GLB with its page and report, by the examples of the doors' README files: the
same bytes whatever the door. Arguments: the command, and a program a door, with ',' between its words."""

import base64
import hashlib
import json
import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path


def ring(radius, sides=12, corners=8):
    """Places and triangles of a torus."""
    places, triangles = [], []
    for i in range(sides):
        for j in range(corners):
            a, b = 2 * math.pi * i / sides, 2 * math.pi * j / corners
            across = radius + 0.3 * math.cos(b)
            places.append((across * math.cos(a), 0.3 * math.sin(b), across * math.sin(a)))
            one, other = j, (j + 1) % corners
            here, there = i * corners, (i + 1) % sides * corners
            triangles += [(here + one, here + other, there + one), (there + one, here + other, there + other)]
    return places, triangles


def asset():
    """Two rings in a glTF, its numbers within."""
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [], "meshes": [],
                "accessors": [], "bufferViews": []}
    numbers = b""
    for mesh, radius in enumerate((1.0, 1.5)):
        places, triangles = ring(radius)
        for values, form, kind in ((places, "<3f", 5126), (triangles, "<3H", 5123)):
            piece = b"".join(struct.pack(form, *value) for value in values)
            view = {"buffer": 0, "byteOffset": len(numbers), "byteLength": len(piece)}
            accessor = {"bufferView": len(document["bufferViews"]), "componentType": kind}
            if kind == 5126:
                accessor |= {"count": len(values), "type": "VEC3", "min": [min(axis) for axis in zip(*values)],
                             "max": [max(axis) for axis in zip(*values)]}
            else:
                accessor |= {"count": 3 * len(values), "type": "SCALAR"}
            document["bufferViews"].append(view)
            document["accessors"].append(accessor)
            numbers += piece
        primitive = {"attributes": {"POSITION": 2 * mesh}, "indices": 2 * mesh + 1}
        document["meshes"].append({"name": f"ring {mesh}", "primitives": [primitive]})
        document["nodes"].append({"name": f"node {mesh}", "mesh": mesh, "translation": [4.0 * mesh, 0, 0]})
    uri = "data:application/octet-stream;base64," + base64.b64encode(numbers).decode()
    document["buffers"] = [{"byteLength": len(numbers), "uri": uri}]
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
    assert "chair: 2 meshes" in page and "ring 0" in page and "ring 1" in page
    report = json.loads((folder / "smooth.json").read_text())
    digest = hashlib.sha256(glb).hexdigest()
    assert report["outputs"][0]["sha256"] == digest
    assert [mesh["asset"]["name"] for mesh in report["meshes"]] == ["ring 0", "ring 1"]
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
        assert all(f"{name}: ring {mesh}" in page for name in ("chair", "bench") for mesh in (0, 1))
        for number, program in enumerate(doors):
            found = run(program, folder / str(number))
            assert found == wanted, (program, found, wanted)
            print(Path(program[0]).name, found)


if __name__ == "__main__":
    main()

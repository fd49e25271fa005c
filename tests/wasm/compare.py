"""compare.py NATIVE NPM [--all] [SCENE...]: fits scenes by the native command and by the package's, both methods,
levels, creases and chord errors, and holds the GLBs against each other: documents and triangles equal, numbers within
2e-10 of the diagonal or the next float32, exit codes and words equal. Four scenes, or all of them (--all), which takes half an hour, by
more flags. Prints one line a case and what all have in common; exit status 1 where one is further off."""
import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np

BOUND = 2e-10
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["goblet.obj", "rocker_arm.obj", "l_bracket.obj", "mapped_cube.obj"]
FLAGS = ["--interpolation progressive", "--interpolation fair --levels 3", "--creases auto --levels 1", "--chord-error 1e-3"]
MORE_FLAGS = ["--interpolation progressive --levels 0", "--interpolation fair --levels 1", "--preset paper --levels 1",
              "--creases auto:30 --interpolation progressive", "--creases ignore --interpolation fair", "--chord-error 1e-4",
              "--chord-error 1e-3 --interpolation progressive", "--scheme catmull-clark --levels 1", "--smooth 2 --levels 1",
              "--within 1e-3 --levels 1"]
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


def parts(path):
    data = path.read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + size]), data[28 + size:]


def arrays(document, binary):
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        kind = np.dtype(TYPES[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step = view.get("byteStride", width * kind.itemsize)
        raw = np.frombuffer(binary, "u1", (accessor["count"] - 1) * step + width * kind.itemsize, start)
        yield np.lib.stride_tricks.as_strided(raw, (accessor["count"], width * kind.itemsize), (step, 1)).copy().view(kind)


def rest(document):
    """What is said besides arrays: without what is measured of them."""
    for accessor in document["accessors"]:
        for bound in "min", "max":
            accessor.pop(bound, None)
    document["asset"]["extras"].pop("max_error", None)
    return document


def compare(native, other):
    """What differs: floats, indices, and by how much of the diagonal floats do beyond rounding; or words."""
    one, two = parts(native), parts(other)
    if rest(one[0]) != rest(two[0]):
        return "other documents"
    if one[1] == two[1]:
        return 0, 0, 0.0
    left, right = list(arrays(*one)), list(arrays(*two))
    box = left[0]
    diagonal = float(np.linalg.norm(box.max(0) - box.min(0)))
    floats, indices, far = 0, 0, 0.0
    for a, b in zip(left, right):
        if a.dtype.kind != "f":
            indices += int((a != b).sum())
            continue
        floats += int((a != b).sum())
        gap = np.abs(a.astype("f8") - b.astype("f8"))
        # The next float32 is no further than rounding takes it.
        near = gap <= np.spacing(np.maximum(np.abs(a), np.abs(b)))
        far = max(far, float(np.where(near, 0, gap).max()) / diagonal)
    return floats, indices, far


def run(command, scene, flags, output):
    output.unlink(missing_ok=True)
    done = subprocess.run([*command, "fit", scene, "-o", output, "--device", "cpu", "--force", "--quiet", *flags],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.replace(str(output), "OUTPUT")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("native")
    parser.add_argument("npm", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--all", action="store_true")
    given = parser.parse_args()
    commands = [[given.native], ["node", str(given.npm / "cli.js")]]
    folder = ROOT / "scenes"
    scenes = sorted(folder.glob("*.obj")) if given.all else [folder / name for name in given.scenes or SCENES]
    bad, same, most, furthest, count = [], 0, 0, 0.0, 0
    with tempfile.TemporaryDirectory() as name:
        files = [pathlib.Path(name) / file for file in ["native.glb", "wasm.glb"]]
        for scene in scenes:
            for flags in FLAGS + (MORE_FLAGS if given.all else []):
                runs = [run(command, scene, flags.split(), file) for command, file in zip(commands, files)]
                written = [file.exists() for file in files]
                case = f"{scene.name:20} {flags:50}"
                count += 1
                if runs[0] != runs[1] or written[0] != written[1]:
                    words = f"other words: {runs}"
                elif not written[0]:
                    words = (0, 0, 0.0)
                    case += f" exit code {runs[0][0]}"
                else:
                    words = compare(*files)
                if not isinstance(words, str):
                    floats, indices, far = words
                    same += floats == indices == 0
                    most, furthest = max(most, floats), max(furthest, far)
                    words = f"{floats} floats, {indices} indices, {far:.1e}"
                    if indices == 0 and far <= BOUND:
                        print(case, words, flush=True)
                        continue
                bad.append(f"{case} {words}")
                print(bad[-1], " NOT EQUAL", flush=True)
    print(f"{count} cases: {same} have the same numbers; in others at most {most} floats differ, beyond rounding by at "
          f"most {furthest:.1e} of the diagonal; {len(bad)} are not equal")
    sys.exit(1 if bad else 0)


main()

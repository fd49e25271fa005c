"""compare.py NATIVE NPM [SCENE...]: fits scenes by the native command and by the package's, both methods, levels,
creases and chord errors, and holds the GLBs against each other: documents and triangles equal, numbers within 2e-10 of
the diagonal or the next float32. Prints one line a case; exit status 1 where one is further off."""
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
FLAGS = [["--interpolation", "progressive"], ["--interpolation", "fair", "--levels", "3"], ["--creases", "auto", "--levels", "1"],
         ["--chord-error", "1e-3"]]
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


def compare(native, other):
    """What differs, in words; "" where it is nothing, and whether that is too much."""
    one, two = parts(native), parts(other)
    if one[1] == two[1]:
        return "same bytes", True
    left, right = list(arrays(*one)), list(arrays(*two))
    if [a.shape for a in left] != [a.shape for a in right]:
        return "other sizes", False
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
    return f"{floats} floats, {indices} indices differ, beyond rounding by {far:.1e}", far <= BOUND and indices == 0


def run(command, scene, flags, output):
    done = subprocess.run([*command, "fit", scene, "-o", output, "--device", "cpu", "--force", "--quiet", *flags],
                          capture_output=True, text=True, check=False)
    if done.returncode not in (0, 5):
        sys.exit(f"{command}: {done.stderr}")
    return done.returncode


def main():
    native, package, *names = sys.argv[1:]
    commands = [[native], ["node", str(pathlib.Path(package) / "cli.js")]]
    scenes = [ROOT / "scenes" / name for name in names or SCENES]
    good = True
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / name for name in ["native.glb", "wasm.glb"]]
        for scene in scenes:
            for flags in FLAGS:
                codes = [run(command, scene, flags, file) for command, file in zip(commands, files)]
                words, near = compare(*files)
                good = good and near and codes[0] == codes[1]
                print(f"{scene.name:20} {' '.join(flags):40} {words}" + ("" if near else "  TOO FAR"), flush=True)
    sys.exit(0 if good else 1)


main()

"""compare.py NATIVE NPM [--all] [SCENE...]: fits scenes by the native command and by the package's, both methods,
levels, creases and chord errors: the same bytes, exit codes and words. Of Catmull-Clark surfaces OpenSubdiv makes the masks, with
the system's sine: those are OBJ, with the same words and numbers within 2e-10 of the diagonal. Four scenes, or all of them (--all), by more flags. Prints what differs; exit
status 1 where anything does."""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

BOUND = 2e-10
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["goblet.obj", "rocker_arm.obj", "l_bracket.obj", "mapped_cube.obj"]
FLAGS = ["--interpolation progressive", "--interpolation fair --levels 3", "--creases auto --levels 1", "--chord-error 1e-3"]
MORE_FLAGS = ["--interpolation progressive --levels 0", "--interpolation fair --levels 1", "--preset paper --levels 1",
              "--creases auto:30 --interpolation progressive", "--creases ignore --interpolation fair", "--chord-error 1e-4",
              "--chord-error 1e-3 --interpolation progressive", "--scheme catmull-clark --levels 1", "--smooth 2 --levels 1",
              "--within 1e-3 --levels 1"]


def whole_numbers(folder):
    """A scene whose coordinates are whole numbers above 2^53, which tools/wasm/large_integers.cpp writes."""
    scene = folder / "whole_numbers.obj"
    scene.write_text("".join(" ".join([word, *(str(math.pi * 1e20 * float(x)) for x in rest)]) + "\n" if word == "v"
                             else " ".join([word, *rest]) + "\n"
                             for word, *rest in map(str.split, (ROOT / "scenes/cube.obj").read_text().splitlines())))
    return scene


def is_near(one, other):
    """Texts of OBJ: the same words, but for numbers that are off by rounding."""
    places = [list(map(float, line.split()[1:4])) for line in one.splitlines() if line.startswith(b"v ")]
    diagonal = math.dist(*(tuple(map(bound, zip(*places))) for bound in (min, max)))
    pairs = list(zip(one.split(), other.split()))
    return len(one.split()) == len(other.split()) and all(
        a == b or abs(float(a) - float(b)) <= BOUND * diagonal for a, b in pairs)


def are_alike(native, other, flags):
    if "catmull-clark" not in flags or not (native[2] and other[2]):
        return native == other
    return native[:2] == other[:2] and is_near(native[2], other[2])


def run(command, scene, flags, output):
    """Exit code, words, and what was written."""
    output.unlink(missing_ok=True)
    done = subprocess.run([*command, "fit", scene, "-o", output, "--device", "cpu", "--force", "--quiet", *flags.split()],
                          capture_output=True, text=True, check=False)
    written = output.read_bytes() if output.exists() else None
    return done.returncode, done.stderr.replace(str(output), "OUTPUT"), written


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
    different, count = 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cases = [(scene, flags, "out.obj" if "catmull-clark" in flags else "out.glb")
                 for scene in scenes for flags in FLAGS + (MORE_FLAGS if given.all else [])]
        for scene, flags, written in [*cases, (whole_numbers(folder), "--levels 1", "out.obj")]:
            count += 1
            output = folder / written
            native, other = (run(command, scene, flags, output) for command in commands)
            if are_alike(native, other, flags):
                continue
            different += 1
            what = f"{native[:2]}, {other[:2]}" if native[:2] != other[:2] else "other bytes"
            print(f"{scene.name} {flags}: {what}", flush=True)
    print(f"{count} cases, {different} differ")
    sys.exit(1 if different or not count else 0)


if __name__ == "__main__":
    main()

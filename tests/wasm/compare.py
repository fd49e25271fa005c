"""compare.py NATIVE NPM [--all] [SCENE...]: fits scenes by the native command and by the package's, both methods,
levels, creases and chord errors: the same bytes, exit codes and words. Of Catmull-Clark surfaces OpenSubdiv makes the masks, with
the system's sine: files of the same size. Four scenes, or all of them (--all), by more flags. Prints what differs; exit
status 1 where anything does."""
import argparse
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["goblet.obj", "rocker_arm.obj", "l_bracket.obj", "mapped_cube.obj"]
FLAGS = ["--interpolation progressive", "--interpolation fair --levels 3", "--creases auto --levels 1", "--chord-error 1e-3"]
MORE_FLAGS = ["--interpolation progressive --levels 0", "--interpolation fair --levels 1", "--preset paper --levels 1",
              "--creases auto:30 --interpolation progressive", "--creases ignore --interpolation fair", "--chord-error 1e-4",
              "--chord-error 1e-3 --interpolation progressive", "--scheme catmull-clark --levels 1", "--smooth 2 --levels 1",
              "--within 1e-3 --levels 1"]


def run(command, scene, flags, output):
    """Exit code, words, and what was written."""
    output.unlink(missing_ok=True)
    done = subprocess.run([*command, "fit", scene, "-o", output, "--device", "cpu", "--force", "--quiet", *flags.split()],
                          capture_output=True, text=True, check=False)
    written = output.read_bytes() if output.exists() else None
    if written and "catmull-clark" in flags:
        written = len(written)
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
        output = pathlib.Path(name) / "out.glb"
        for scene in scenes:
            for flags in FLAGS + (MORE_FLAGS if given.all else []):
                count += 1
                native, other = (run(command, scene, flags, output) for command in commands)
                if native == other:
                    continue
                different += 1
                what = f"{native[:2]}, {other[:2]}" if native[:2] != other[:2] else "other bytes"
                print(f"{scene.name} {flags}: {what}", flush=True)
    print(f"{count} cases, {different} differ")
    sys.exit(1 if different or not count else 0)


if __name__ == "__main__":
    main()

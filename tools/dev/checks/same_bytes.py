#!/usr/bin/env python3
"""Compares what two builds of the command write, byte by byte.

    tools/dev/checks/same_bytes.py BEFORE AFTER [--only WORD] [--without WORD] [--every N] [--jobs N] [FILE ...]
    tools/dev/checks/same_bytes.py --write HASHES.json AFTER [--only WORD]

BEFORE and AFTER are planish programs, or how they are called, for another processor for example:

    same_bytes.py build/bin/planish "qemu-aarch64-static build-arm64/bin/planish"

Every scene of scenes/ (meshes, scene files, files with a fault) goes through both with the calls
below, and so does every FILE, a mesh or points, in all formats and by all methods. Times, memory and
program versions of reports and how a system spells a path there are left out; all other bytes, exit
codes and messages must be the same.

BEFORE may also be a file of hashes as --write makes it. Then exit codes and surfaces are compared, not
words, reports and pages, which change more often, STEP of some scenes alone, since that of others is large,
and no streams of meshoptimizer, of which each version makes others.
Says what differs and ends with 1, else with 0.
"""

import argparse
import concurrent.futures
import hashlib
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
# What two runs of the same program need not have in common.
VARYING = {"argv", "git", "memory", "timing_ms"}
POINTS = {".xyz", ".pts", ".pcd", ".las", ".ptx"}

MESH_CALLS = {
    "glb": "-o o.glb --report report.json",
    "progressive": "-o o.glb --interpolation progressive --cage cage.obj --report report.json",
    "fair": "-o o.glb --interpolation fair --cage cage.ply --report report.json",
    "paper": "-o o.glb --preset paper --levels 1",
    "creases": "-o o.gltf --creases auto:30 --levels 3,1",
    "smooth": "-o o.ply --smooth 2 --attributes error,deviation,curvature",
    "obj": "-o o.obj --levels 1",
    "stl": "-o o.stl --levels 1",
    "off": "-o o.off --levels 0",
    "usda": "-o o.usda --levels 1",
    "step": "-o o.step",
    "freeform step": "-o o.step --step-analytic off",
    "meshopt": "-o o.glb --compress meshopt",
    "quantize": "-o o.glb --compress quantize",
    "tiles": "-o o.json --levels 2",
    "chord": "-o o.glb --chord-error 1e-3",
    "angle": "-o o.ply --angle 8",
    "page": "-o o.glb --page page.html",
    "catmull-clark": "--cage cage.obj --scheme catmull-clark -o o.glb --levels 1",
    "unrepaired": "-o o.glb --repair none --levels 1",
    "dry": "-o o.glb --dry-run",
}


# What a file of hashes has nothing of.
UNHASHED_FILES = ("report.json", "page.html")
# The scenes whose STEP it has: analytic faces of all kinds but cones, freeform faces beside them, holes, a large valence.
STEP_SCENES = ("bearing_block.obj", "cube.obj", "cube_with_holes.obj", "cube_with_windows.obj", "l_bracket.obj",
               "mapped_cube.obj", "pole64.obj", "rocker_arm.obj", "torus.obj", "wavy_patch.obj")


def is_hashed(name):
    """Whether a file of hashes has the call of that name."""
    if name.endswith(" step"):
        return name.startswith(STEP_SCENES)
    return not name.endswith(" meshopt")


def calls(files):
    """Pairs of a name and a command's arguments. Scenes are named from the folder on that outcome() runs them in."""
    meshes = [f"scenes/{path.name}" for path in sorted((ROOT / "scenes").glob("*.obj"))]
    for mesh in meshes + [str(path) for path in files]:
        name = pathlib.PurePath(mesh).name
        if pathlib.PurePath(mesh).suffix.lower() in POINTS:
            yield f"{name} points", ["fit", mesh, "-o", "o.glb", "--report", "report.json"]
            yield f"{name} mesh", ["reconstruct", mesh, "-o", "o.ply"]
            continue
        for kind, arguments in MESH_CALLS.items():
            if kind == "freeform step" and name not in STEP_SCENES:
                continue
            yield f"{name} {kind}", ["fit", mesh, *arguments.split()]
        yield f"{name} inspect", ["inspect", mesh]
    for bad in sorted((ROOT / "scenes" / "bad").iterdir()):
        for repair in "safe", "none":
            yield f"{bad.name} {repair}", ["fit", f"scenes/bad/{bad.name}", "-o", "o.glb", "--repair", repair]
    yield "schema", ["fit", "--help"]
    yield "scene goblet", ["run", "scenes/goblet.json", "--report", "report.json", "--force"]


def without_varying(value):
    if isinstance(value, dict):
        return {k: without_varying(v) for k, v in value.items() if k not in VARYING}
    if isinstance(value, list):
        return [without_varying(entry) for entry in value]
    return value


def plain_paths(text):
    """With slashes."""
    return text.replace("\\\\", "/")


def comparable(path):
    """The bytes of a file, or of a report and a page what does not vary."""
    data = path.read_bytes()
    if path.suffix == ".json" and b'"timing_ms"' in data:
        return plain_paths(json.dumps(without_varying(json.loads(data)), sort_keys=True)).encode()
    if path.suffix == ".html":
        # Times: in the report's words and numbers, and as widths of a bar.
        text = messages(data.decode(errors="replace"))
        text = re.sub(r'<rect class="(c\d+|t-[a-z]+)"[^>]*>|"(timing_ms|memory)": *\{[^}]*\}', "", text)
        text = re.sub(r"&#34;(timing_ms|memory)&#34;: \{[^}]*\}", "", text)
        text = re.sub(r"\(([0-9a-f]{12}|unknown)\)", "", text)  # the revision
        # From the beginning of a word only: the numbers of a scene are one word of a megabyte.
        text = re.sub(r"&#34;git&#34;: *&#34;[^&]*&#34;|(?<![^\s;])[^\s;]*/planish\b", "", text)
        return plain_paths(text).encode()
    return data


def messages(text):
    """Words without times and sizes of memory."""
    text = re.sub(r"^ *time .*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^.*: +\d+%, .*\n", "", text, flags=re.MULTILINE)  # how far a slow run is
    text = re.sub(r"(\de[-+]\d\d)( +[\d.,]+){2}$", r"\1", text, flags=re.MULTILINE)  # table of scenes
    text = re.sub(r"[\d.,]+ ?(ms|s|min|h|MB|GB|MiB|GiB|kB|KiB)\b", "", text)
    return re.sub(r"[ \t]+", " ", re.sub(r"under\b", "", text))


def files_below(folder):
    return {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}


def outcome(program, arguments):
    """Exit code, words, and the hash of each file that was written, in a folder with copies of the scenes."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        shutil.copytree(ROOT / "scenes", folder / "scenes", ignore=shutil.ignore_patterns("pictures", "out"))
        given = set(files_below(folder))
        done = subprocess.run([*program, *arguments], cwd=folder, capture_output=True, text=True,
                              errors="replace", timeout=1800, stdin=subprocess.DEVNULL)
        hashes = {path: hashlib.sha256(comparable(file)).hexdigest()[:16]
                  for path, file in files_below(folder).items() if path not in given}
    return done.returncode, messages(done.stdout + done.stderr), hashes


def hashed(made):
    """What a file of hashes keeps of an outcome."""
    return {"exit": made[0], **{path: made[2][path] for path in sorted(made[2])
                                if not path.endswith(UNHASHED_FILES)}}


def differences(name, first, second):
    """What differs between two outcomes, in a line each."""
    if first[0] != second[0]:
        return [f"{name}: exit code {first[0]}, then {second[0]}: {second[1].strip()[-200:]}"]
    lines = []
    if first[1] != second[1]:
        lines += [f"{name}: other words"] + [
            f"    {mark} {line}"
            for mark, words, others in (("-", first[1], second[1]), ("+", second[1], first[1]))
            for line in words.splitlines() if line not in others.splitlines()]
    for path in sorted(set(first[2]) | set(second[2])):
        if path not in first[2] or path not in second[2]:
            lines.append(f"{name}: {path} is written by one of them only")
        elif first[2][path] != second[2][path]:
            lines.append(f"{name}: {path} differs, sha256 {first[2][path]}, then {second[2][path]}")
    return lines


def call_of(text):
    *caller, program = shlex.split(text)
    return [*caller, str(pathlib.Path(program).resolve())]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", help="a program, or a file of hashes (.json)")
    parser.add_argument("after", type=call_of)
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    parser.add_argument("--only", default="", help="calls whose name has this word")
    parser.add_argument("--without", help="no calls whose name has this word")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="the first of each N of these calls alone")
    parser.add_argument("--write", action="store_true", help="write these calls' hashes instead")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    hashes = pathlib.Path(options.before) if options.before.endswith(".json") else None
    if options.write and not hashes:
        parser.error(f"--write makes a file of hashes (.json), not {options.before}")
    if hashes and options.files:
        parser.error(f"{hashes} has no hashes of other files")
    expected = json.loads(hashes.read_text()) if hashes and hashes.exists() else {}
    possible = [call for call in calls([path.resolve() for path in options.files])
                if not hashes or is_hashed(call[0])]
    wanted = [call for call in possible
              if options.only in call[0] and (not options.without or options.without not in call[0])]
    if options.every < 1:
        parser.error("--every wants a number from 1 on")
    wanted = wanted[::options.every]
    if not wanted:
        parser.error(f"no call has '{options.only}' in its name")

    def compare(call):
        name, arguments = call
        made = outcome(options.after, arguments)
        if not hashes:
            return differences(name, outcome(call_of(options.before), arguments), made)
        kept = hashed(made)
        if options.write:
            expected[name] = kept
            return []
        if name not in expected:
            return [f"{name}: {hashes} has no hash of it"]
        return differences(name, *((entry["exit"], made[1], {k: v for k, v in entry.items() if k != "exit"})
                                   for entry in (expected[name], kept)))

    different = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for lines in pool.map(compare, wanted):
            different += bool(lines)
            for line in lines:
                print(line, flush=True)
    if options.write:
        lines = [f"{json.dumps(name)}: {json.dumps(expected[name])}" for name, _ in possible if name in expected]
        hashes.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    print(f"{len(wanted)} calls, {different} differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())

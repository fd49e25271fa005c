#!/usr/bin/env python3
"""Compares what two builds of the command write, byte by byte.

    tools/dev/checks/same_bytes.py BEFORE AFTER [--only WORD] [--without WORD] [--jobs N] [FILE ...]

BEFORE and AFTER are planish programs, or how they are called, for another processor for example:

    same_bytes.py build/bin/planish "qemu-aarch64-static build-arm64/bin/planish"

Every scene of scenes/ (meshes, scene files, files with a fault) goes through both with the calls
below, and so does every FILE, a mesh or points, in all formats and by all methods. Times, memory and
program versions of reports and how a system spells a path there are left out; all other bytes, exit
codes and messages must be the same.
Says what differs and ends with 1, else with 0.
"""

import argparse
import concurrent.futures
import filecmp
import hashlib
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
# What two runs of the same program need not have in common.
VARYING = {"argv", "git", "memory", "timing_ms"}
POINTS = {".xyz", ".pts", ".pcd", ".las", ".ptx"}

MESH_CALLS = {
    "glb": "-o o.glb --report o.json",
    "progressive": "-o o.glb --interpolation progressive --cage cage.obj --report o.json",
    "fair": "-o o.glb --interpolation fair --cage cage.ply --report o.json",
    "paper": "-o o.glb --preset paper --levels 1",
    "creases": "-o o.gltf --creases auto:30 --levels 3,1",
    "smooth": "-o o.ply --smooth 2 --attributes error,deviation,curvature",
    "obj": "-o o.obj --levels 1",
    "stl": "-o o.stl --levels 1",
    "off": "-o o.off --levels 0",
    "usda": "-o o.usda --levels 1",
    "meshopt": "-o o.glb --compress meshopt",
    "quantize": "-o o.glb --compress quantize",
    "tiles": "-o o.json --levels 2",
    "chord": "-o o.glb --chord-error 1e-3",
    "angle": "-o o.ply --angle 8",
    "page": "-o o.glb --page o.html",
    "catmull-clark": "--cage cage.obj --scheme catmull-clark -o o.glb --levels 1",
    "unrepaired": "-o o.glb --repair none --levels 1",
    "dry": "-o o.glb --dry-run",
}


def calls(files):
    """Pairs of a name and a command's arguments."""
    scenes = ROOT / "scenes"
    meshes = sorted(scenes.glob("*.obj"))
    for mesh in meshes + files:
        if mesh.suffix.lower() in POINTS:
            yield f"{mesh.name} points", ["fit", str(mesh), "-o", "o.glb", "--report", "o.json"]
            yield f"{mesh.name} mesh", ["reconstruct", str(mesh), "-o", "o.ply"]
            continue
        for name, arguments in MESH_CALLS.items():
            yield f"{mesh.name} {name}", ["fit", str(mesh), *arguments.split()]
        yield f"{mesh.name} inspect", ["inspect", str(mesh)]
    for bad in sorted((scenes / "bad").iterdir()):
        for repair in "auto", "none":
            yield f"{bad.name} {repair}", ["fit", str(bad), "-o", "o.glb", "--repair", repair]
    yield "schema", ["fit", "--help"]
    yield "scene goblet", ["run", str(scenes / "goblet.json"), "--report", "o.json", "--force"]


def without_varying(value):
    if isinstance(value, dict):
        return {k: without_varying(v) for k, v in value.items() if k not in VARYING}
    if isinstance(value, list):
        return [without_varying(entry) for entry in value]
    return value


def plain_paths(text):
    """With slashes, and those of scenes from the root on, which pages name from the folder on where they can."""
    text = text.replace("\\\\", "/")
    return re.sub(r"(\.\./)+(?=" + re.escape(str(ROOT)[1:]) + ")", "/", text)


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


def run(program, arguments, folder):
    done = subprocess.run([*program, *arguments], cwd=folder, capture_output=True, text=True,
                          errors="replace", timeout=1800, stdin=subprocess.DEVNULL)
    return done.returncode, messages(done.stdout + done.stderr)


def files_below(folder):
    return {path.relative_to(folder): path for path in folder.rglob("*") if path.is_file()}


def compare(name, arguments, before, after):
    """What differs between the two programs, in a line each."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        first, second = run(before, arguments, one), run(after, arguments, two)
        if first[0] != second[0]:
            return [f"{name}: exit code {first[0]}, then {second[0]}: {second[1].strip()[-200:]}"]
        differences = []
        if first[1] != second[1]:
            differences += [f"{name}: other words"] + [
                f"    {mark} {line}"
                for mark, lines, others in (("-", first[1], second[1]), ("+", second[1], first[1]))
                for line in lines.splitlines() if line not in others.splitlines()]
        left, right = files_below(pathlib.Path(one)), files_below(pathlib.Path(two))
        for path in sorted(set(left) | set(right)):
            if path not in left or path not in right:
                differences.append(f"{name}: {path} is written by one of them only")
            elif not filecmp.cmp(left[path], right[path], shallow=False) and comparable(
                    left[path]) != comparable(right[path]):
                sums = [hashlib.sha256(p.read_bytes()).hexdigest()[:12]
                        for p in (left[path], right[path])]
                differences.append(f"{name}: {path} differs, sha256 {sums[0]}, then {sums[1]}")
        return differences


def call_of(text):
    *caller, program = shlex.split(text)
    return [*caller, str(pathlib.Path(program).resolve())]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=call_of)
    parser.add_argument("after", type=call_of)
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    parser.add_argument("--only", default="", help="calls whose name has this word")
    parser.add_argument("--without", help="no calls whose name has this word")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    programs = options.before, options.after
    wanted = [call for call in calls([path.resolve() for path in options.files])
              if options.only in call[0] and (not options.without or options.without not in call[0])]
    if not wanted:
        parser.error(f"no call has '{options.only}' in its name")
    different = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for lines in pool.map(lambda call: compare(*call, *programs), wanted):
            different += bool(lines)
            for line in lines:
                print(line, flush=True)
    print(f"{len(wanted)} calls, {different} differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())

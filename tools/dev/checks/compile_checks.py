"""Checks of sources by a compiler, with the flags that a build folder has for them.

compile_checks.py alone BUILD [--headers | FILE...]: compiles sources of the libraries and tools by themselves, which
finds a source that forgets an include: elsewhere several are compiled at once, behind headers compiled before. So it
does with every header that no source includes first; the others are compiled so with their sources. --headers: no
sources. With FILEs these alone.

compile_checks.py tidy BUILD: clang-tidy with the checks of .clang-tidy, on every source of a build folder. Sources that
are compiled together are checked together, which takes a quarter of the time. Tests and the tools that measure are not
asked for speed. What clang 14 finds wrong in headers of the system, it does not know the C++20 library well enough, is
not ours.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

from sources import ROOT, files

# Where a user's time is spent.
SHIPPED = re.compile("(src/planish|tools/(planish|python|products|dev/render))/")
FOR_SHIPPED = "-performance-*,-bugprone-suspicious-missing-comma"


def compile_commands(build):
    return json.loads((pathlib.Path(build) / "compile_commands.json").read_text())


def flags(entry):
    """The compiler and its flags, without the file, what it becomes, and a compiler cache."""
    words = shlex.split(entry["command"])
    while not os.path.basename(words[0]).startswith(("c++", "g++", "clang++")):
        words.pop(0)
    at = words.index("-o")
    return [word for word in words[:at] + words[at + 2 :] if word not in ("-c", entry["file"])]


def folder_flags(build):
    """The flags of C++ sources, by the folder of the CMakeLists.txt that lists them."""
    found = collections.defaultdict(list)
    for entry in compile_commands(build):
        if entry["file"].endswith(".c"):
            continue
        folder = os.path.relpath(entry["file"], build).split("/CMakeFiles/")[0]
        if folder.startswith(".."):
            folder = os.path.relpath(os.path.dirname(entry["file"]), ROOT)
        if flags(entry) not in found[folder]:
            found[folder].append(flags(entry))
    return found


def nearest(header, found):
    folder = os.path.dirname(header)
    while folder not in found and folder:
        folder = os.path.dirname(folder)
    return found[folder if folder in found else "src/planish"]


def compile_alone(file, commands):
    """What is wrong, or nothing where it compiles with any of the commands."""
    for command in commands:
        error = error_of(file, command)
        if not error:
            return []
    return [f"{file} does not compile by itself:\n  {error}"]


def error_of(file, command):
    # All tests find each other's headers so, but the library of what they share.
    tests = [f"-I{ROOT}/tests"] if file.startswith("tests/") else []
    result = subprocess.run([*command, *tests, "-fsyntax-only", "-O0", "-x", "c++", "-w", str(ROOT / file)],
                            capture_output=True, text=True)
    errors = re.findall(r"(?m)^.*error: .*$", result.stderr)
    return errors[0] if errors else None


def headers_alone():
    first = set()
    for source in files("src/*.cpp", "tools/*.cpp", "tests/*.cpp"):
        match = re.search(r'(?m)^#include ("[^"]+"|<[^>]+>)', (ROOT / source).read_text())
        if match and match[1].startswith('"'):
            first.add(match[1].strip('"'))
    return [header for header in files("src/*.h", "tools/*.h", "tests/*.h")
               if "tests/package/" not in header
               and "tools/wasm/serial/" not in header  # stands in for oneTBB where that is not
               and not any(header == name or header.endswith("/" + name) for name in first)]


def tidy(source, build):
    folder = build if source.startswith(build) else str(ROOT)
    is_shipped = SHIPPED.match(os.path.relpath(source, folder))
    result = subprocess.run(["clang-tidy", "--quiet", f"--config-file={ROOT / '.clang-tidy'}",
                             f"--checks={'' if is_shipped else FOR_SHIPPED}", "-p", build, source],
                            capture_output=True, text=True)
    ours = re.escape(f"{ROOT}/")
    return re.findall(rf"(?m)^{ours}(.*(?:error|warning): .*)$", result.stdout)


def findings_of(check, names):
    """What a check finds of each name, each once and in the names' order."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(dict.fromkeys(finding for found in pool.map(check, names) for finding in found))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    checks = parser.add_subparsers(dest="check", required=True)
    for_tidy, for_alone = checks.add_parser("tidy"), checks.add_parser("alone")
    for each in (for_tidy, for_alone):
        each.add_argument("build", type=os.path.abspath)
    for_alone.add_argument("--headers", action="store_true")
    for_alone.add_argument("files", nargs="*")
    arguments = parser.parse_args()
    build = arguments.build
    if arguments.check == "tidy":
        wanted = sorted({entry["file"] for entry in compile_commands(build)})
        findings = sorted(findings_of(lambda source: tidy(source, build), wanted))
        nothing = f"{len(wanted)} translation units: nothing found"
    else:
        wanted = arguments.files or headers_alone()
        if not arguments.files and not arguments.headers:
            wanted += files("src/*.cpp", "tools/*.cpp")
        found = folder_flags(build)
        findings = findings_of(lambda file: compile_alone(file, nearest(file, found)), wanted)
        nothing = f"{len(wanted)} files compile by themselves"
    print("\n".join(findings) or nothing)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())

"""alone.py BUILD [--headers | FILE...]: compiles sources of the libraries and tools by themselves, which finds a source
that forgets an include: elsewhere several are compiled at once, behind headers compiled before. So it does with every
header that no source includes first; the others are compiled so with their sources. --headers: no sources. With FILEs
these alone.
"""

import argparse
import collections
import concurrent.futures
import os
import re
import subprocess
import sys

from commands import ROOT, compile_commands, flags
from sources import files


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
    """What is wrong, or None where it compiles with any of the commands."""
    for command in commands:
        error = error_of(file, command)
        if not error:
            return None
    return f"{file} does not compile by itself:\n  {error}"


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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build")
    parser.add_argument("--headers", action="store_true")
    parser.add_argument("files", nargs="*")
    arguments = parser.parse_args()
    wanted = arguments.files or headers_alone()
    if not arguments.files and not arguments.headers:
        wanted += files("src/*.cpp", "tools/*.cpp")
    found = folder_flags(os.path.abspath(arguments.build))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda file: compile_alone(file, nearest(file, found)), wanted)
    findings = [result for result in results if result]
    print("\n".join(findings) or f"{len(wanted)} files compile by themselves")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())

"""headers.py BUILD: compiles every header that no source includes first, by itself.

The other headers have been compiled so with their sources, which include them before anything.
"""

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


def compile_alone(header, commands):
    """What is wrong, or None where it compiles with any of the commands."""
    for command in commands:
        error = error_of(header, command)
        if not error:
            return None
    return f"{header} does not compile by itself:\n  {error}"


def error_of(header, command):
    # All tests find each other's headers so, but the library of what they share.
    tests = [f"-I{ROOT}/tests"] if header.startswith("tests/") else []
    result = subprocess.run([*command, *tests, "-fsyntax-only", "-O0", "-x", "c++", "-w", str(ROOT / header)],
                            capture_output=True, text=True)
    errors = re.findall(r"(?m)^.*error: .*$", result.stderr)
    return errors[0] if errors else None


def main(build):
    first = set()
    for source in files("src/*.cpp", "tools/*.cpp", "tests/*.cpp"):
        match = re.search(r'(?m)^#include ("[^"]+"|<[^>]+>)', (ROOT / source).read_text())
        if match and match[1].startswith('"'):
            first.add(match[1].strip('"'))
    headers = [header for header in files("src/*.h", "tools/*.h", "tests/*.h")
               if "tests/package/" not in header
               and "tools/wasm/serial/" not in header  # stands in for oneTBB where that is not
               and not any(header == name or header.endswith("/" + name) for name in first)]
    found = folder_flags(build)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda h: compile_alone(h, nearest(h, found)), headers)
    findings = [result for result in results if result]
    print("\n".join(findings) or f"{len(headers)} headers compile by themselves")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1])))

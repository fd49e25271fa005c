"""tidy.py BUILD: clang-tidy with the checks of .clang-tidy, on every source of a build folder.

Sources that are compiled together are checked together, which takes a quarter of the time. Tests
and the tools that measure are not asked for speed. What clang 14 finds wrong in headers of the
system, it does not know the C++20 library well enough, is not ours.
"""

import concurrent.futures
import os
import re
import subprocess
import sys

from commands import ROOT, compile_commands


# Where a user's time is spent.
SHIPPED = re.compile("(src/planish|tools/(planish|python|render|viewer))/")
FOR_SHIPPED = "-performance-*,-bugprone-suspicious-missing-comma"


def check(build, source):
    folder = build if source.startswith(build) else str(ROOT)
    is_shipped = SHIPPED.match(os.path.relpath(source, folder))
    result = subprocess.run(["clang-tidy", "--quiet", f"--config-file={ROOT / '.clang-tidy'}",
                             f"--checks={'' if is_shipped else FOR_SHIPPED}", "-p", build, source],
                            capture_output=True, text=True)
    ours = re.escape(f"{ROOT}/")
    return set(re.findall(rf"(?m)^{ours}(.*(?:error|warning): .*)$", result.stdout))


def main(build):
    sources = sorted({entry["file"] for entry in compile_commands(build)})
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda source: check(build, source), sources)
    findings = sorted(set().union(*results))
    print("\n".join(findings) or f"{len(sources)} translation units: nothing found")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1])))

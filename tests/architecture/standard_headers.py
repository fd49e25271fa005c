#!/usr/bin/env python3
"""standard_headers.py BUILD: #include <format> is the compiler's own header, for every source of a build.

With the flags of each source by which includes are searched, all standard headers are compiled, and each must
come from the compiler's own folders. As this compiler may not know a header that another one includes
within its own, no folder on an include path may have a file of such a name either, in any case of letters.
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/dev/checks"))
from compile_checks import compile_commands, flags  # noqa: E402

# C++23's, and C's.
STANDARD = """
    algorithm any array atomic barrier bit bitset charconv chrono codecvt compare complex concepts condition_variable
    coroutine deque exception execution expected filesystem flat_map flat_set format forward_list fstream functional
    future generator initializer_list iomanip ios iosfwd iostream istream iterator latch limits list locale map mdspan
    memory memory_resource mutex new numbers numeric optional ostream print queue random ranges ratio regex
    scoped_allocator semaphore set shared_mutex source_location span spanstream sstream stack stacktrace stdexcept
    stdfloat stop_token streambuf string string_view strstream syncstream system_error thread tuple type_traits
    typeindex typeinfo unordered_map unordered_set utility valarray variant vector version
    cassert cctype cerrno cfenv cfloat cinttypes climits clocale cmath csetjmp csignal cstdarg cstddef cstdint cstdio
    cstdlib cstring ctime cuchar cwchar cwctype
    assert.h complex.h ctype.h errno.h fenv.h float.h inttypes.h iso646.h limits.h locale.h math.h setjmp.h signal.h
    stdalign.h stdarg.h stdatomic.h stdbool.h stddef.h stdint.h stdio.h stdlib.h string.h tgmath.h threads.h time.h
    uchar.h wchar.h wctype.h
""".split()
# Of C alone, or said to be going by a warning.
NOT_COMPILED = {"stdatomic.h", "threads.h", "strstream", "codecvt"}
PROGRAM = "".join(f"#if __has_include(<{name}>)\n#include <{name}>\n#endif\n"
                  for name in STANDARD if name not in NOT_COMPILED)
SEARCHED = re.compile(r"-(I|iquote|isystem|idirafter)(.*)")


def searched_folders(words):
    """Pairs of a flag and a folder, in the order of a command line."""
    found = []
    words = iter(words)
    for word in words:
        match = SEARCHED.fullmatch(word)
        if match:
            found.append((match[1], match[2] or next(words)))
    return tuple(found)


def preprocess(compiler, arguments, text):
    return subprocess.run([compiler, "-std=c++20", *arguments, "-fsyntax-only", "-x", "c++", "-"], input=text,
                          capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})


def own_folders(compiler):
    said = preprocess(compiler, ["-v"], "").stderr
    between = re.search(r"#include <\.\.\.> search starts here:\n(.*?)End of search list", said, re.DOTALL)
    return [os.path.realpath(line.split(" (framework")[0].strip()) for line in between[1].splitlines()]


def faults_of(compiler, own, searched):
    """What standard headers become where these folders are searched."""
    done = preprocess(compiler, ["-H", *(f"-{flag}{folder}" for flag, folder in searched)], PROGRAM)
    taken = [os.path.realpath(folder) for _, folder in searched]

    # Compilers' own headers may lie behind links elsewhere.
    def is_below(path, folders):
        return any(os.path.realpath(path).startswith(f"{folder}/") for folder in folders)

    faults = [f"{path} is included for a standard header" for path in re.findall(r"(?m)^\.+ (.*)$", done.stderr)
              if is_below(path, taken) and not is_below(path, own)]
    if done.returncode and not faults:
        faults = re.findall(r"(?m)^.*error: .*$", done.stderr)[:3] or [done.stderr[-400:]]
    return faults


def names_in(folder, own):
    """Files there that have a standard header's name."""
    if os.path.realpath(folder) in own:
        return []
    return [str(path) for path in pathlib.Path(folder).glob("*") if path.name.lower() in STANDARD and path.is_file()]


def main(build):
    commands = [flags(entry) for entry in compile_commands(build) if not entry["file"].endswith(".c")]
    wanted = {(words[0], searched_folders(words)) for words in commands}
    own = {compiler: own_folders(compiler) for compiler, _ in wanted}
    # What is only searched for #include "..." takes no part in #include <...>.
    compiled = {(compiler, tuple(pair for pair in searched if pair[0] != "iquote")) for compiler, searched in wanted}
    faults = set()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for found in pool.map(lambda one: faults_of(one[0], own[one[0]], one[1]), compiled):
            faults.update(found)
    for compiler, searched in wanted:
        for _, folder in searched:
            faults.update(f"{path} has a standard header's name and lies on an include path"
                          for path in names_in(folder, own[compiler]))
    print("\n".join(sorted(faults)) or f"{len(compiled)} sets of folders: standard headers are the compiler's own")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

#!/usr/bin/env python3
"""Runs the command on the corpus of odd files: tests/field/run.py build/bin/planish [PATTERN]

Names each case whose outcome is not the expected one; ends with 1 if there is one. PATTERN is as of
a shell: 'ply*'. With --keep FOLDER the files and all output stay there.
"""

import argparse
import fnmatch
import importlib.util
import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from case import Case, Result  # noqa: E402

TIMEOUT = 120  # seconds: a hang; none of them takes ten
MODULES = ("mesh_cases", "point_cases", "gltf_cases")


def all_cases() -> list[Case]:
    found = []
    for module in MODULES:
        if importlib.util.find_spec(module) is not None:
            found += importlib.import_module(module).cases()
    names = [case.name for case in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    assert not twice, f"two cases have one name: {', '.join(twice)}"
    return found


def result_of(case: Case, command: Path, folder: Path) -> Result:
    for name, data in case.files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    call = [command, "inspect", case.main, "--json", *case.args]
    if not case.inspects:
        call = [command, "fit", case.main, "-o", "out.glb", "--report", "report.json"]
        call += ["--device", "cpu", *case.args]
    done = subprocess.run(call, cwd=folder, capture_output=True, timeout=TIMEOUT, check=False)
    said = done.stdout.decode(errors="replace")
    errors = done.stderr.decode(errors="replace")
    (folder / "output.txt").write_text(said + errors)
    report, written = None, folder / "report.json"
    text = said if case.inspects else written.read_text() if written.exists() else ""
    try:
        report = json.loads(text)
    except ValueError:
        pass
    glb = folder / "out.glb"
    return Result(done.returncode, said + errors, report, glb if glb.exists() else None, folder)


def fault_of(case: Case, result: Result) -> str | None:
    """What is not as expected."""
    if result.code != case.exit:
        said = result.text.strip().splitlines() or [""]
        return f"exit code {result.code}, not {case.exit}: {said[0]}"
    for words in case.says:
        if words not in result.text:
            return f"does not say {words!r}: {result.text.strip()}"
    for words in case.silent:
        if words in result.text:
            return f"says {words!r}: {result.text.strip()}"
    return case.check(result) if case.check is not None else None


def run(case: Case, command: Path, root: Path) -> str | None:
    folder = root / case.name
    folder.mkdir(parents=True)
    try:
        return fault_of(case, result_of(case, command, folder))
    except subprocess.TimeoutExpired:
        return f"takes more than {TIMEOUT} seconds"
    except Exception as error:  # a check that meets what it does not expect is a fault, too
        return f"{type(error).__name__}: {error}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", type=Path)
    parser.add_argument("pattern", nargs="?", default="*")
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    command = given.command.resolve()
    chosen = [c for c in all_cases() if fnmatch.fnmatch(c.name, given.pattern)]
    if not chosen:
        print(f"no case is called {given.pattern}")
        return 1
    with tempfile.TemporaryDirectory() as temporary:
        root = given.keep.resolve() if given.keep else Path(temporary)
        with ThreadPoolExecutor(2) as pool:
            faults = list(pool.map(lambda case: run(case, command, root), chosen))
    for case, fault in zip(chosen, faults):
        if fault is not None:
            print(f"{case.name}: {fault}")
    failed = sum(fault is not None for fault in faults)
    print(f"{len(chosen)} cases, {failed} not as expected")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

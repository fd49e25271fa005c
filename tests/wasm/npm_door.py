"""npm_door.py NATIVE NPM: what fitFile() of the package makes of each option's values, against the native command: the same
bytes, the same values refused. The table of options and values is tests/doors/table.py."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "doors"))
import doors  # noqa: E402
import inputs  # noqa: E402
import table  # noqa: E402


class Npm:
    def __init__(self, package):
        self.node = subprocess.Popen(["node", HERE / "npm_door.mjs", pathlib.Path(package).resolve()], text=True,
                                     stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def __call__(self, source, output, options):
        print(json.dumps({"source": str(source), "output": str(output), "options": options}), file=self.node.stdin, flush=True)
        answer = json.loads(self.node.stdout.readline())
        if "refused" in answer:
            raise doors.Refused(answer["refused"])


def difference(is_other, made, wanted):
    """What is wrong with what npm made; None: nothing."""
    if isinstance(made, doors.Refused) or isinstance(wanted, doors.Refused):
        is_right = isinstance(made, doors.Refused) and isinstance(wanted, doors.Refused)
    elif is_other:
        is_right = made != wanted
    else:
        is_right = made == wanted
    return None if is_right else f"{doors.shown(made)} instead of {doors.shown(wanted)}"


def main():
    native, package = sys.argv[1:]
    os.environ["PLANISH_EXECUTABLE"] = native
    npm, wrong, count = Npm(package), [], 0

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        inputs.write(folder)

        def outcome(door, row, options):
            nonlocal count
            count += 1
            return doors.outcome(door, folder / row.input, row.output, options, folder / str(count))

        def compare(row, options, is_other=False):
            found = difference(is_other, outcome(npm, row, options), outcome(doors.command, row, options))
            if found:
                wrong.append(f"{options}: {found}")

        for name, row in table.ROWS.items():
            if "npm" in row.refused:
                made = outcome(npm, row, {**row.beside, name: row.value})
                if row.refused["npm"] not in str(made):
                    wrong.append(f"{name}: {doors.shown(made)} is no refusal with {row.refused['npm']!r}")
                continue
            for value in [row.value, *row.also, *row.wrong]:
                compare(row, {**row.beside, name: value}, row.other and value == row.value)
        for options in table.TOGETHER:
            compare(table.SEVERAL, options)
    print("\n".join(wrong))
    print(f"{count // 2} sets of options, {len(table.ROWS)} rows: {len(wrong)} are not what the command makes of them")
    sys.exit(1 if wrong else 0)


main()

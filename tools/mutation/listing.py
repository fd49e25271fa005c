"""Lists of mutations, one file a module: tests/mutations/README.md says how they read."""

import dataclasses
import pathlib


@dataclasses.dataclass
class Mutation:
    path: str
    operator: str
    was: str
    now: str
    place: int = 1  # among equal lines of the file, from 1
    killer: str = ""
    notes: dict = dataclasses.field(default_factory=dict)  # equivalent, survives: the reason; tried: verdict, commit
    name: str = ""

    def line(self, text):
        """The number, from 0, of the line that it changes; None where it is no longer there."""
        found = [i for i, line in enumerate(text.split("\n")) if line.strip() == self.was]
        return found[self.place - 1] if len(found) >= self.place else None

    def is_applicable(self, root):
        path = root / self.path
        return path.exists() and self.line(path.read_text()) is not None

    def applied(self, text):
        """The text with this change, or None."""
        at = self.line(text)
        if at is None:
            return None
        lines = text.split("\n")
        indent = lines[at][: len(lines[at]) - len(lines[at].lstrip())]
        lines[at] = indent + self.now
        return "\n".join(lines)


def quick_first(test, seconds, most=2.0):
    """The test of a whole program as two: what is quick, then what takes longer by ctest's notes of its runs."""
    program, _, chosen = test.partition(" ")
    kept, _, out = chosen.partition("-")
    prefix = program.removesuffix("_test") + "."
    slow = [name.removeprefix(prefix) for name, cost in seconds.items() if name.startswith(prefix) and cost > most]
    if program == "ctest" or kept or not slow:
        return [test]
    rest = f"-{out}" if out else ""
    return [f"{program} -{':'.join(slow + ([out] if out else []))}", f"{program} {':'.join(slow)}{rest}"]


@dataclasses.dataclass
class Module:
    name: str
    head: list  # comment lines
    sources: list
    tests: list
    programs: list
    mutations: list

    def tests_named_after(self, path):
        """Of the first program the tests that are named after a source: fold_cure.cpp, *FoldCure*."""
        program, _, chosen = self.tests[0].partition(" ") if self.tests else ("ctest", "", "")
        if program == "ctest" or chosen.partition("-")[0]:
            return []
        return [f"{program} *{pathlib.Path(path).stem.title().replace('_', '')}*{chosen}"]

    def write(self, folder):
        lines = list(self.head)
        for key in ("sources", "tests", "programs"):
            lines += [f"{key} {value}" for value in getattr(self, key)]
        for m in self.mutations:
            lines += ["", f"mutation {m.path} {m.operator}", f"was {m.was}", f"now {m.now}"]
            if m.place > 1:
                lines.append(f"place {m.place}")
            if m.killer:
                lines.append(f"killer {m.killer}")
            lines += [f"{key} {value}".rstrip() for key, value in m.notes.items()]
        (pathlib.Path(folder) / f"{self.name}.list").write_text("\n".join(lines) + "\n")


def read_module(path):
    path = pathlib.Path(path)
    module = Module(path.stem, [], [], [], [], [])
    for number, line in enumerate(path.read_text().split("\n"), 1):
        key, _, value = line.partition(" ")
        if line.startswith("#"):
            module.head.append(line)
        elif key in ("sources", "tests", "programs"):
            getattr(module, key).append(value)
        elif key == "mutation":
            file, _, operator = value.partition(" ")
            name = f"{module.name}-{len(module.mutations) + 1}"
            module.mutations.append(Mutation(file, operator, "", "", name=name))
        elif key in ("was", "now", "killer", "place") and module.mutations:
            setattr(module.mutations[-1], key, int(value) if key == "place" else value)
        elif key in ("equivalent", "survives", "sample", "tried") and module.mutations:
            module.mutations[-1].notes[key] = value
        elif line:
            raise SystemExit(f"{path}:{number}: unknown word {key!r}")
    return module


def read_lists(folder, only=None):
    paths = sorted(pathlib.Path(folder).glob("*.list"))
    modules = [read_module(path) for path in paths if not only or path.stem in only]
    missing = set(only or []) - {module.name for module in modules}
    if missing:
        raise SystemExit(f"no list of mutations: {', '.join(sorted(missing))}; there are: "
                         + ", ".join(path.stem for path in paths))
    return modules

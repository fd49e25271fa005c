"""The list of modules and of mutations with notes: tests/mutations/README.md says how it reads."""

import dataclasses
import pathlib


@dataclasses.dataclass
class Mutation:
    path: str
    operator: str
    was: str = ""
    now: str = ""
    place: int = 1  # among equal lines of the file, from 1
    name: str = ""
    drawn: bool = False
    notes: dict = dataclasses.field(default_factory=dict)  # equivalent, survives: the reason; sample: the test

    def applied(self, text):
        """The text with this change; None where its line is no longer there."""
        lines = text.split("\n")
        found = [i for i, line in enumerate(lines) if line.strip() == self.was]
        if len(found) < self.place:
            return None
        at = found[self.place - 1]
        indent = lines[at][: len(lines[at]) - len(lines[at].lstrip())]
        lines[at] = indent + self.now
        return "\n".join(lines)


@dataclasses.dataclass
class Module:
    name: str
    draw: int = 0  # how many mutations
    sources: list = dataclasses.field(default_factory=list)
    without: list = dataclasses.field(default_factory=list)
    tests: list = dataclasses.field(default_factory=list)
    programs: list = dataclasses.field(default_factory=list)
    noted: list = dataclasses.field(default_factory=list)

    def tests_named_after(self, path):
        """Of the first program the tests that are named after a source: fold_cure.cpp, *FoldCure*."""
        program, _, chosen = self.tests[0].partition(" ")
        if program == "ctest" or chosen.partition("-")[0]:
            return []
        return [f"{program} *{pathlib.Path(path).stem.title().replace('_', '')}*{chosen}"]


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


def read_modules(path, only=None):
    modules = []
    for number, line in enumerate(pathlib.Path(path).read_text().split("\n"), 1):
        key, _, value = line.partition(" ")
        module = modules[-1] if modules else None
        noted = module.noted[-1] if module and module.noted else None
        if not line or line.startswith("#"):
            continue
        if key == "module":
            modules.append(Module(value))
        elif module and key == "draw":
            module.draw = int(value)
        elif module and key in ("sources", "without", "tests", "programs"):
            getattr(module, key).append(value)
        elif module and key == "mutation":
            name = f"{module.name}-note-{len(module.noted) + 1}"
            module.noted.append(Mutation(*value.split(" "), name=name))
        elif noted and key in ("was", "now", "place"):
            setattr(noted, key, int(value) if key == "place" else value)
        elif noted and key in ("equivalent", "survives", "sample"):
            noted.notes[key] = value
        else:
            raise SystemExit(f"{path}:{number}: unknown word {key!r}")
    names = [module.name for module in modules]
    if missing := sorted(set(only or []) - set(names)):
        raise SystemExit(f"no module {', '.join(missing)}; there are: {', '.join(names)}")
    return [module for module in modules if not only or module.name in only]

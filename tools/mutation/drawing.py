"""Draws mutations by lot: lines of all sources of a module alike, then one of the changes of the line."""

import random

from listing import Mutation
from operators import candidates

SUFFIXES = (".cpp", ".comp", ".glsl")


def sources(module, root):
    for folder in module.sources:
        path = root / folder
        found = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.suffix in SUFFIXES)
        for file in found:
            yield file.relative_to(root).as_posix(), file.read_text()


def all_changes(module, root):
    """[(path, line number, text, changes)] of all lines that some operator changes."""
    return [(path, number, text, changes)
            for path, text in sources(module, root)
            for number, changes in sorted(candidates(text, not path.endswith(".cpp")).items())]


def draw(lines, module_name, seed, count):
    """`count` mutations of different lines. The same seed and sources draw the same; a larger count only adds."""
    chance = random.Random(f"{seed} {module_name}")
    order = list(range(len(lines)))
    chance.shuffle(order)
    for at in order[:count]:
        path, number, text, changes = lines[at]
        # An operator is drawn first: a line has more constants than conditions.
        operator = chance.choice(sorted({name for name, _ in changes}))
        now = chance.choice([new for name, new in changes if name == operator])
        all_lines = text.split("\n")
        was = all_lines[number].strip()
        place = sum(line.strip() == was for line in all_lines[: number + 1])
        yield Mutation(path, operator, was, now.strip(), place)


def quotas(sizes, total, least):
    """How many of each module: by its lines, at least `least`."""
    lines = sum(sizes.values())
    return {name: max(least, round(total * size / lines)) for name, size in sizes.items()}

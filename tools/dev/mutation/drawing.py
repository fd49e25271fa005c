"""Draws mutations by lot: lines of all sources of a module alike, then one of the changes of the line."""

import collections
import random

from listing import Mutation
from operators import candidates

SUFFIXES = (".cpp", ".comp", ".glsl")


def sources(module, root):
    for folder in module.sources:
        path = root / folder
        found = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.suffix in SUFFIXES)
        for file in found:
            name = file.relative_to(root).as_posix()
            if not f"{name}/".startswith(tuple(f"{left_out}/" for left_out in module.without)):
                yield name, file.read_text()


def lot(module, root, seed):
    """A mutation of each line that some operator changes, in the order in which they are drawn.

    What is drawn of a line, and when, is by its text and its file's name: it stays where other lines change.
    """
    found = []
    for path, text in sources(module, root):
        changes_of = candidates(text, not path.endswith(".cpp"))
        places = collections.Counter()
        for number, line in enumerate(text.split("\n")):
            was = line.strip()
            places[was] += 1
            if changes := changes_of.get(number):
                chance = random.Random(f"{seed} {path.rpartition('/')[2]} {was} {places[was]}")
                rank = chance.random()
                # An operator is drawn first: a line has more constants than conditions.
                operator = chance.choice(sorted({name for name, _ in changes}))
                now = chance.choice([new for name, new in changes if name == operator])
                found.append((rank, path, Mutation(path, operator, was, now.strip(), places[was])))
    return [mutation for *_, mutation in sorted(found, key=lambda each: each[:2])]


def mutations(module, root, seed):
    """As many of the lot as the module wants, and those with a note. A drawn line with a note has its change."""
    noted = {(m.path, m.was, m.place): m for m in module.noted}
    drawn = []
    for number, mutation in enumerate(lot(module, root, seed)[: module.draw], 1):
        mutation.name = f"{module.name}-{number}"
        drawn.append(noted.get((mutation.path, mutation.was, mutation.place), mutation))
        drawn[-1].drawn = True
    return drawn + [mutation for mutation in module.noted if not mutation.drawn]

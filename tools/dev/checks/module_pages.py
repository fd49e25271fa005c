"""Pages for Doxygen: of each module with its place among the levels.

module_pages.py FOLDER: writes them there. Levels are those that the architecture's test checks.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
SOURCE = ROOT / "src" / "planish"


def levels():
    """Level of each module."""
    text = (ROOT / "tests" / "architecture" / "levels.cmake").read_text()
    return {name: int(level) for name, level in re.findall(r"set\(level_(\w+) (\d+)\)", text)}


def includes(module):
    """The modules whose headers the sources of a module include."""
    found = set()
    for path in (SOURCE / module).rglob("*"):
        if path.suffix in (".h", ".cpp"):
            found |= set(re.findall(r'^#include "planish/([a-z]+)/', path.read_text(), re.M))
    return sorted(found - {module})


def picture(module, level_of):
    """A graph of a module between the levels: what it includes, and what includes it."""
    below = includes(module)
    above = [other for other in level_of if module in includes(other)]
    lines = ["digraph levels {", "  rankdir=BT;", '  node [shape=box, fontname="sans-serif"];']
    for name in sorted({module, *below, *above}):
        style = ", style=filled, fillcolor=lightgrey" if name == module else ""
        lines.append(f'  {name} [label="{level_of[name]}  {name}", URL="\\ref module_{name}"{style}];')
    for level in sorted(set(level_of.values())):
        same = " ".join(n for n in sorted({module, *below, *above}) if level_of[n] == level)
        if same:
            lines.append(f"  {{ rank=same; {same}; }}")
    lines += [f"  {module} -> {name};" for name in below]
    lines += [f"  {name} -> {module};" for name in above]
    return "\n".join(lines) + "\n}\n"


def module_page(module, level_of):
    """The page of a module: level, picture, its headers with their first sentences."""
    headers = sorted((SOURCE / module).rglob("*.h"))
    text = f"# {module} {{#module_{module}}}\n\nLevel {level_of[module]}.\n\n"
    text += "\\dot\n" + picture(module, level_of) + "\\enddot\n\n"
    for header in headers:
        text += f"- `planish/{header.relative_to(SOURCE)}`\n"
    return text


def main(folder):
    out = pathlib.Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    level_of = levels()
    for module in level_of:
        (out / f"{module}.md").write_text(module_page(module, level_of))
    text = (
        "# planish\n\nInterpolating Doo-Sabin subdivision surfaces: the library's headers. For C++ "
        "begin with `planish/job/fit_file.h`, for C with `planish/c/planish.h`; \\ref symbols "
        "ties the paper's symbols to names. Modules by level, each using lower ones only:\n\n"
    )
    for level in sorted(set(level_of.values()), reverse=True):
        names = ", ".join(f"\\ref module_{n} \"{n}\"" for n in level_of if level_of[n] == level)
        text += f"- Level {level}: {names}\n"
    (out / "modules.md").write_text(text)
    # References, so that Doxygen warns of names that are no more.
    symbols = (SOURCE / "symbols.md").read_text()
    (out / "symbols.md").write_text(re.sub(r"\bplanish::", r"\\ref planish::", symbols))


if __name__ == "__main__":
    main(sys.argv[1])

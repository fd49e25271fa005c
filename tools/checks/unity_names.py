"""Names that meet where a module's sources are compiled together (tools/cmake/FastBuild.cmake).

Unnamed namespaces of one module's sources become one there, so that a constant, a type or a
function may stand in one of them only. A function of other parameters would compile, but take calls
that are meant for its namesake. Nor may a constant have the name of one in a header of the module,
which another of its sources may include.
"""

import collections
import pathlib
import re


def unit_of(name):
    """The sources that may be compiled with this one: a module's, a tool's, a test's."""
    folders = pathlib.PurePath(name).parts
    if name.startswith("src/planish/reconstruct/cgal/"):
        return "src/planish/reconstruct/cgal"
    return "/".join(folders[:3] if folders[0] == "src" else folders[:2])


def unnamed_parts(text):
    # Its end is told from a function's by the blanks that the comment "namespace" leaves.
    return re.findall(r"(?ms)^namespace \{\n(.*?)^\}[ \t]+$", text)


def names_in(part):
    """(what must differ, how it was written) of each definition at the part's own level."""
    for match in re.finditer(r"(?m)^(?:class|struct|enum class|enum|union) (\w+)", part):
        yield match[1], match[1]
    for match in re.finditer(r"(?m)^using (\w+) = ([^;]*);", part):
        yield match[1], match[1] + " = " + " ".join(match[2].split())
    for match in re.finditer(r"(?m)^(?:inline |static )*(?:constexpr|const) [^;(){}]*?(\w+)(?:\[[^\]]*\])*(?: =|\{)",
                             part):
        yield match[1], match[1]
    for match in re.finditer(r"(?m)^[A-Za-z][\w:<>,&* \[\]]*?[ &*](\w+)\((?:[^(){};]|\([^()]*\))*\)"
                             r"(?: noexcept)?(?: ->[^{;]*)? \{", part):
        if match[1] not in ("if", "for", "while", "switch"):
            yield match[1], match[1] + "()"


def header_constants(text):
    return re.findall(r"(?m)^inline constexpr [^;(){}]*?(\w+)(?:\[[^\]]*\])*(?: =|\{)", text)


def met_names(texts):
    in_headers = collections.defaultdict(set)
    for name, text in texts.items():
        if name.endswith(".h"):
            for constant in header_constants(text):
                in_headers[unit_of(name), constant].add(name)
    places = collections.defaultdict(lambda: collections.defaultdict(set))
    for name, text in texts.items():
        if name.endswith(".cpp") and not name.endswith("/main.cpp"):  # compiled alone
            for part in unnamed_parts(text):
                for what, written in names_in(part):
                    places[unit_of(name), what][name].add(written)
                    for header in sorted(in_headers[unit_of(name), what]):
                        yield f"{what} is a name in {name} and in {header}"
    for (_, what), found in sorted(places.items()):
        written = set().union(*found.values())
        alias = all(" = " in each for each in written)
        if len(found) > 1 and not (alias and len(written) == 1):
            yield f"{what} is a name in {', '.join(sorted(found))}, which may be compiled together"

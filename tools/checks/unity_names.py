"""Names that meet where a module's sources are compiled together (tools/cmake/FastBuild.cmake).

Unnamed namespaces of one module's sources become one there, so that a constant, a type or a
function with the same parameters may stand in one of them only. Read from the text, as the other
checks: parameter types are compared as written.
"""

import collections
import pathlib
import re

# The brackets of parameters that are left when theirs are taken out, inmost first.
NESTED = re.compile(r"<[^<>]*>|\([^()]*\)")


def unit_of(name):
    """The sources that may be compiled with this one: a module's, a tool's, a test's."""
    folders = pathlib.PurePath(name).parts
    if name.startswith("src/planish/reconstruct/cgal/"):
        return "src/planish/reconstruct/cgal"
    return "/".join(folders[:3] if folders[0] == "src" else folders[:2])


def unnamed_parts(text):
    # Its end is told from a function's by the blanks that the comment "namespace" leaves.
    return re.findall(r"(?ms)^namespace \{\n(.*?)^\}[ \t]+$", text)


def parameter_types(text):
    """Each parameter without its name and default."""
    while NESTED.search(text):
        text = NESTED.sub(lambda part: "[" + re.sub(r"[,\s]+", ";", part[0][1:-1]) + "]", text)
    types = []
    for parameter in text.split(","):
        words = parameter.split("=")[0].split()
        if len(words) > 1 and re.fullmatch(r"[&*]*\w+", words[-1]):
            words[-1] = re.sub(r"\w+", "", words[-1])
        types.append("".join(words))
    return ",".join(types)


def names_in(part):
    """(what must differ, how it was written) of each definition at the part's own level."""
    for match in re.finditer(r"(?m)^(?:class|struct|enum class|enum|union) (\w+)", part):
        yield match[1], match[1]
    for match in re.finditer(r"(?m)^using (\w+) = ([^;]*);", part):
        yield match[1], match[1] + " = " + " ".join(match[2].split())
    for match in re.finditer(r"(?m)^(?:inline |static )*(?:constexpr|const) [^;(){}]*?(\w+)(?:\[[^\]]*\])*(?: =|\{)",
                             part):
        yield match[1], match[1]
    # A template's parameters are not told apart here.
    plain = re.sub(r"(?m)^template <.*\n.*", "", part)
    for match in re.finditer(r"(?m)^[A-Za-z][\w:<>,&* \[\]]*?[ &*](\w+)\(((?:[^(){};]|\([^()]*\))*)\)"
                             r"(?: noexcept)?(?: ->[^{;]*)? \{", plain):
        if match[1] not in ("if", "for", "while", "switch"):
            text = f"{match[1]}({parameter_types(match[2])})"
            yield text, text


def met_names(texts):
    places = collections.defaultdict(lambda: collections.defaultdict(set))
    for name, text in texts.items():
        if name.endswith(".cpp"):
            for part in unnamed_parts(text):
                for what, written in names_in(part):
                    places[unit_of(name), what][name].add(written)
    for (_, what), found in sorted(places.items()):
        written = set().union(*found.values())
        alias = all(" = " in each for each in written)
        if len(found) > 1 and not (alias and len(written) == 1):
            yield f"{what} is a name in {', '.join(sorted(found))}, which may be compiled together"

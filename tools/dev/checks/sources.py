"""What tools/check reads the sources for: repeated names, dead headers, includes without use.

Prints one line a finding, and ends with status 1 where there are any. Nothing here understands
C++: each check looks for what can be told from the text alone, and rather misses than errs.
"""

import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]

# Names of which at least one stands in a source that uses the header.
STANDARD = {
    "algorithm": r"(std|ranges)::(ranges::)?(sort|stable_sort|partial_sort|nth_element|min|max|"
    r"minmax|clamp|find\w*|copy\w*|fill\w*|count\w*|all_of|any_of|none_of|for_each|transform|"
    r"reverse|rotate|unique\w*|remove\w*|replace\w*|lower_bound|upper_bound|equal\w*|binary_search|"
    r"is_sorted\w*|partition\w*|stable_partition|merge|inplace_merge|set_\w+|includes|generate\w*|"
    r"mismatch|search|swap_ranges|min_element|max_element|minmax_element|lexicographical_compare|"
    r"shuffle|sample|next_permutation|adjacent_find|contains|move|move_backward|\w*_heap)\b",
    "array": r"\b(std::array|to_array|std::get|tuple_size)\b",
    "atomic": r"\b(atomic\w*|memory_order\w*)\b",
    "bit": r"\b(bit_cast|bit_ceil|bit_floor|bit_width|popcount|countl_\w+|countr_\w+|"
    r"has_single_bit|endian|rotl|rotr)\b",
    "charconv": r"\b(from_chars|to_chars|chars_format|to_chars_result)\b",
    "chrono": r"\b(chrono|steady_clock|system_clock)\b",
    "deque": r"\bdeque\b",
    "filesystem": r"\bfilesystem\b",
    "fstream": r"\b[oi]?fstream\b",
    "functional": r"\b(function|bind\w*|hash|less\w*|greater\w*|plus|minus|multiplies|invoke|"
    r"ref|cref|identity|equal_to|not_fn|reference_wrapper)\b",
    "iostream": r"\b(cout|cerr|clog|cin)\b",
    "limits": r"\bnumeric_limits\b",
    "list": r"\blist\b",
    "map": r"\bmap\b|\bmultimap\b",
    "memory": r"\b(unique_ptr|shared_ptr|weak_ptr|make_unique|make_shared|addressof|"
    r"allocator\w*|construct_at|destroy\w*|uninitialized_\w+|enable_shared_from_this)\b",
    "mutex": r"\b(mutex|lock_guard|unique_lock|scoped_lock|once_flag|call_once)\b",
    "numbers": r"\bnumbers\b",
    "numeric": r"\b(accumulate|iota|gcd|lcm|inner_product|partial_sum|reduce|transform_reduce|"
    r"exclusive_scan|inclusive_scan|adjacent_difference|midpoint)\b",
    "optional": r"\b(optional|nullopt)\b",
    "queue": r"\b(queue|priority_queue)\b",
    "random": r"\b(mt19937\w*|\w+_distribution|random_device|\w+_engine)\b",
    "regex": r"\bregex\w*\b",
    "set": r"\b(multi)?set\b",
    "span": r"\b(span|as_bytes|as_writable_bytes|dynamic_extent)\b",
    "sstream": r"\b[oi]?stringstream\b",
    "string_view": r"\b(string_view|sv)\b",
    "thread": r"\b(thread|jthread|this_thread)\b",
    "tuple": r"\b(tuple\w*|tie|make_tuple|forward_as_tuple|apply|std::get|ignore)\b",
    "type_traits": r"\b(\w+_v|\w+_t|is_\w+|enable_if|decay|conditional|true_type|false_type|"
    r"make_unsigned|make_signed|remove_\w+|underlying_type)\b",
    "unordered_map": r"\bunordered_(multi)?map\b",
    "unordered_set": r"\bunordered_(multi)?set\b",
    "variant": r"\b(variant\w*|visit|monostate|holds_alternative|get_if)\b",
    "vector": r"\bvector\b",
}
# Words of headers that say nothing of who uses them.
COMMON = set(
    "alignas auto bool break case catch char class const constexpr continue decltype default delete "
    "do double else enum explicit extern false float for friend if inline int long mutable "
    "namespace new noexcept nodiscard nullptr operator override private protected public return "
    "short signed sizeof static static_assert std string string_view struct switch template this "
    "throw true try typedef typename union unsigned using virtual void volatile while span vector "
    "optional pair array size_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t uint planish "
    "glm vec2 vec3 vec4 dvec2 dvec3 dvec4 include pragma once define ifdef ifndef endif defined "
    "maybe_unused requires concept move forward get size begin end data".split()
)


# Headers that come with another: whoever throws an Error has a message to write.
COME_WITH = {("src/planish/core/error.h", "src/planish/core/error.h")}

# planish::vulkan::Solve is the hosts' word for what planish::Solve is to a fit.
ACCEPTED_TYPES = {"Solve"}


def files(*patterns):
    found = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns],
        cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    return [name for name in found if (ROOT / name).exists()]


def without_comments(text):
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    return re.sub(r"(?m)//(?=([^\"\n]*\"[^\"\n]*\")*[^\"\n]*$).*$", "", text)


def repeated_types(texts):
    """A type defined in the headers of two modules, which a reader takes for one."""
    places = collections.defaultdict(set)
    for name, text in texts.items():
        if name.endswith(".h") and name.startswith("src/"):
            for match in re.finditer(r"(?m)^(?:struct|class|enum class) (\w+)(?: final)?"
                                     r"(?: : [^;{]*)? \{", text):
                places[match[1]].add(name)
    for type_name, names in sorted(places.items()):
        if len(names) > 1 and type_name not in ACCEPTED_TYPES:
            yield f"{type_name} is defined in {', '.join(sorted(names))}"


def repeated_headers(texts):
    stems = collections.defaultdict(set)
    for name in texts:
        # The interface for C is called what that for C++ is; both are named with their folders.
        if name.endswith(".h") and name.startswith("src/") and not name.startswith("src/planish/c/"):
            stems[pathlib.Path(name).name].add(name)
    for names in stems.values():
        if len(names) > 1:
            yield f"one name for several headers: {', '.join(sorted(names))}"


def repeated_functions(texts):
    """The same function, of some length, written out in two files."""
    places = collections.defaultdict(set)
    for name, text in texts.items():
        for match in re.finditer(r"(?m)^[A-Za-z\[][^;{}\n]*\([^;{}]*\)[^;{}]*\{\n(.*?)^\}", text, re.S):
            if match[1].count("\n") >= 3 and not match[0].startswith(("TEST", "INSTANTIATE")):
                places[re.sub(r"\s+", " ", match[0])].add(name)
    for body, names in places.items():
        if len(names) > 1:
            yield f"{body[: body.index('(')]}() stands in {', '.join(sorted(names))}"


def unit_of(name):
    """The sources that may be compiled with this one: a module's, a tool's, a test's."""
    folders = pathlib.PurePath(name).parts
    if name.startswith("src/planish/reconstruct/cgal/"):
        return "src/planish/reconstruct/cgal"
    if name.startswith("src/planish/core/platform/"):  # each alone, and one of them
        return name
    return "/".join(folders[:3] if folders[0] == "src" or folders[1] in ("dev", "products") else folders[:2])


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
    """Names that meet where a module's sources are compiled together (tools/cmake/FastBuild.cmake).

    Unnamed namespaces of one module's sources become one there, so that a constant, a type or a
    function may stand in one of them only. A function of other parameters would compile, but take calls
    that are meant for its namesake. Nor may a constant have the name of one in a header of the module,
    which another of its sources may include.
    """
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


def included(text):
    return re.findall(r'(?m)^#include "([^"]+)"', text)


def dead_headers(texts):
    used = {pathlib.PurePath(path).name for text in texts.values() for path in included(text)}
    for name in texts:
        if name.endswith(".h") and pathlib.PurePath(name).name not in used:
            # CMake has one included before all else; WebAssembly's are of its toolchain, and included by <>.
            if not name.endswith(("/planish.h", "/missing_cxx20.h")) and not name.startswith("tools/wasm/"):
                yield f"{name}: nobody includes it"


def resolve(include, includer, headers):
    """The file that an include names, where only one can be meant."""
    near = (pathlib.PurePath(includer).parent / include).as_posix()
    if near in headers:
        return near
    ends = [h for h in headers if h == include or h.endswith("/" + include)]
    return ends[0] if len(ends) == 1 else None


def unused_includes(texts):
    headers = {name for name in texts if name.endswith(".h")}
    words = {name: set(re.findall(r"\b[A-Za-z_]\w+\b", re.sub(r'"[^"\n]*"', "", text)))
             for name, text in texts.items()}
    for name, text in texts.items():
        if name == "src/planish/planish.h" or name.startswith("tests/support/test_headers"):
            continue
        if "define TINYGLTF_IMPLEMENTATION" in text:  # includes what tinygltf uses
            continue
        body = re.sub(r"(?m)^#include.*$", "", text)
        for header in re.findall(r"(?m)^#include <(\w+)>", text):
            if header in STANDARD and not re.search(STANDARD[header], body):
                yield f"{name}: <{header}> is not used"
        for include in included(text):
            path = resolve(include, name, headers)
            own = path and pathlib.PurePath(path).stem == pathlib.PurePath(name).stem
            if not path or own or (name, path) in COME_WITH:
                continue
            if path == "src/planish/planish.h":  # it holds includes alone
                continue
            if not (words[path] - COMMON) & set(re.findall(r"\b[A-Za-z_]\w+\b", body)):
                yield f'{name}: "{include}" is not used'


def own_json(texts):
    """json.h is nlohmann's with another destructor: all must see the same."""
    for name, text in texts.items():
        if re.search(r"#include <nlohmann/", text) and not name.startswith("src/planish/core/json"):
            yield f"{name}: includes planish/core/json.h or json_fwd.h in place of nlohmann's"


def main():
    texts = {name: without_comments((ROOT / name).read_text())
             for name in files("src/*.h", "src/*.cpp", "tools/*.h", "tools/*.cpp", "tests/*.h", "tests/*.c",
                               "tests/*.cpp", "shaders/*.h")}
    own = {name: text for name, text in texts.items() if not name.startswith("tests/package/")}
    checks = [repeated_types, repeated_headers, repeated_functions, met_names, dead_headers,
              unused_includes, own_json]
    findings = [line for check in checks for line in check(own)]
    print("\n".join(findings) if findings else f"{len(own)} files: nothing found")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())

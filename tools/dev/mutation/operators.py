"""What may be changed in a line of C++ or GLSL: each operator names all its changes of a line.

A line is looked at with its strings and comments blanked, so that only code changes. Operators know no
grammar: what they make of a line may not compile, and is then no mutation.
"""

import re

# Operators stand between blanks (clang-format), which tells comparisons from template brackets.
RELATIONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
LOGIC = {"&&": "||", "||": "&&"}
WORDS = {"true": "false", "false": "true", "min": "max", "max": "min", "floor": "ceil",
         "ceil": "floor", "front": "back", "back": "front", "x": "y", "y": "z", "z": "x"}
DECLARES = (r"(?:return|using|const|constexpr|auto|for|typedef|namespace|friend|case|public|private|"
            r"struct|class|enum|template|static|static_assert|extern|else|if|while|do|switch|default|goto|"
            r"layout|precise|shared|uniform|inout|out|in|delete|throw|assert|co_return)\b")
CALL_OR_ASSIGNMENT = re.compile(
    r"[*(]*[A-Za-z_][\w:]*(?:<[^;]*?>)?(?:(?:\.|->|\[|\().*| (?:[-+*/%|&^]|<<|>>)?= .*);$|(?:\+\+|--)\w.*;$"
    r"|\w+(?:\+\+|--);$")


def blanked(line):
    """The line with every character of strings and of a comment as \\0; same length."""
    def fill(match):
        return "\0" * len(match[0])

    return re.sub(r'"(?:[^"\\]|\\.)*"|\'(?:[^\'\\]|\\.)\'|//.*', fill, line)


def swapped_words(code, table, pattern):
    for match in re.finditer(pattern, code):
        yield match.start(1), match.end(1), table[match[1]]


def choices(words):
    return "|".join(sorted((re.escape(word) for word in words), key=len, reverse=True))


def relation(code):
    yield from swapped_words(code, RELATIONS, rf" ({choices(RELATIONS)}) ")


def arithmetic(code):
    if "\0" not in code:  # texts are put together by + alone
        yield from swapped_words(code, ARITHMETIC, rf"(?<=[\w)\]]) ({choices(ARITHMETIC)}) ")


def logic(code):
    yield from swapped_words(code, LOGIC, rf" ({choices(LOGIC)}) ")


def word(code):
    """The other of a pair: true and false, min and max, a neighbouring axis of a vector."""
    yield from swapped_words(code, WORDS, r"(?:(?<=\W)|^)(true|false|min|max|floor|ceil)(?=\W)")
    yield from swapped_words(code, WORDS, r"(?<=\.)(front|back)(?=\(\))")
    yield from swapped_words(code, WORDS, r"(?<=[\w\])]\.)([xyz])(?=\W)")


def constant(code):
    """Whole numbers one larger, others a quarter larger."""
    for match in re.finditer(r"(?<![\w.\"])(\d+)(u?)(?![\w.'])", code):
        yield match.start(1), match.end(1), str(int(match[1]) + 1)
    for match in re.finditer(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?=f?\b|\W)", code):
        value = float(match[1])
        yield match.start(1), match.end(1), repr(value * 1.25 if value else 1.0)


def condition(code):
    """A condition turned round, and one that never holds."""
    match = re.match(r"\s*(?:\} else )?if (?:constexpr )?\(", code)
    if not match:
        return
    depth, at = 1, match.end()
    while at < len(code) and depth:
        depth += {"(": 1, ")": -1}.get(code[at], 0)
        at += 1
    if depth or ";" in code[match.end() : at]:
        return
    inner = code[match.end() : at - 1]
    yield match.end(), at - 1, ("!(", ")")
    if "constexpr" not in match[0] and inner:
        yield match.end(), at - 1, ("false && (", ")")


def negation(code):
    for match in re.finditer(r"(?<![\w)])(!)(?=[\w(])", code):
        yield match.start(1), match.end(1), ""


def returned(code):
    """Returns nothing instead of something."""
    for match in re.finditer(r"\breturn ((?:[\w.:]|->)+\(.*\)|[\w.]+);", code):
        if match[1] not in ("{}", "true", "false", "0", "nullptr"):
            yield match.start(1), match.end(1), "{}"


def arguments(code):
    """Two simple arguments that stand beside one another."""
    for match in re.finditer(r"(?<=[(,])( ?)([\w.\[\]]+), ([\w.\[\]]+)(?=[,)])", code):
        if match[2] != match[3] and not match[2].isdigit():
            yield match.start(2), match.end(3), f"{match[3]}, {match[2]}"


def statement(code):
    """A call (a barrier, say) or an assignment that is left out; see `drops`."""
    text = code.strip()
    if (text.count("(") == text.count(")") and text.count("{") == text.count("}")
            and not re.match(DECLARES, text) and CALL_OR_ASSIGNMENT.match(text)):
        start = len(code) - len(code.lstrip())
        yield start, start + len(text), ";"


OPERATORS = [relation, arithmetic, logic, word, constant, condition, negation, returned, arguments, statement]
GLSL_OPERATORS = [rule for rule in OPERATORS if rule is not returned]


def candidates(text, glsl=False):
    """{line number from 0: [(operator, the new line)]} of a source."""
    result = {}
    before, comment = "", False
    for number, line in enumerate(text.split("\n")):
        code = blanked(line)
        if comment or "/*" in code:
            comment = "*/" not in code
            continue
        bare = code.replace("\0", "").strip()
        if bare and not re.match(r"#|static_assert|namespace|using |template|struct |class |enum |layout", bare):
            found = list(changes(line, code, before, GLSL_OPERATORS if glsl else OPERATORS))
            if found:
                result[number] = found
        if bare:
            before = bare
    return result


def changes(line, code, before, rules):
    for rule in rules:
        # What is left out must be whole, not the last line or the only branch of something.
        if rule is statement and not before.endswith((";", "{", "}", ":")):
            continue
        for start, end, new in rule(code):
            if isinstance(new, tuple):
                new = new[0] + line[start:end] + new[1]
            yield rule.__name__, line[:start] + new + line[end:]

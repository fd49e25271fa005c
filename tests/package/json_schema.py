"""The part of JSON Schema 2020-12 that planish's schemas take; any other keyword is an error."""

import re

TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None),
         "integer": int, "number": (int, float)}
NOTES = {"$schema", "$defs", "title", "description"}


def is_of(value, name):
    return isinstance(value, TYPES[name]) and (name == "boolean" or not isinstance(value, bool))


def problems(value, schema, document=None, place=""):
    """What of the value the schema does not allow, each with its place; empty where it is valid."""
    document = schema if document is None else document
    found = []

    def go_on(inner, rule, name):
        found.extend(problems(inner, rule, document, f"{place}/{name}"))

    for keyword, rule in schema.items():
        if keyword in NOTES:
            continue
        if keyword == "$ref":
            found.extend(problems(value, document["$defs"][rule.removeprefix("#/$defs/")], document, place))
        elif keyword == "type":
            if not any(is_of(value, name) for name in ([rule] if isinstance(rule, str) else rule)):
                found.append(f"{place}: is no {rule}")
        elif keyword in ("const", "enum"):
            if value not in (rule if keyword == "enum" else [rule]):
                found.append(f"{place}: {value!r} is not {rule!r}")
        elif keyword == "anyOf":
            if all(problems(value, choice, document, place) for choice in rule):
                found.append(f"{place}: is none of the choices")
        elif keyword == "required":
            found.extend(f"{place}: has no {name}" for name in rule if name not in value)
        elif keyword == "properties":
            for name in rule.keys() & value.keys() if isinstance(value, dict) else ():
                go_on(value[name], rule[name], name)
        elif keyword == "additionalProperties":
            for name in value.keys() - schema.get("properties", {}).keys() if isinstance(value, dict) else ():
                if rule is False:
                    found.append(f"{place}: {name} is not known")
                else:
                    go_on(value[name], rule, name)
        elif keyword == "items":
            for i, item in enumerate(value if isinstance(value, list) else ()):
                go_on(item, rule, i)
        elif keyword in ("minimum", "exclusiveMinimum"):
            if is_of(value, "number") and (value < rule or (value == rule and keyword != "minimum")):
                found.append(f"{place}: {value} is too small")
        elif keyword == "minLength":
            if isinstance(value, str) and len(value) < rule:
                found.append(f"{place}: is too short")
        elif keyword == "pattern":
            if isinstance(value, str) and not re.search(rule, value):
                found.append(f"{place}: {value!r} does not match {rule}")
        else:
            raise ValueError(f"{place}: {keyword}")
    return found

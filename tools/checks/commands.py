"""The compile commands of a build folder, for the other checks."""

import json
import os
import pathlib
import shlex

ROOT = pathlib.Path(__file__).resolve().parents[2]


def compile_commands(build):
    return json.loads((pathlib.Path(build) / "compile_commands.json").read_text())


def flags(entry):
    """The compiler and its flags, without the file, what it becomes, and a compiler cache."""
    words = shlex.split(entry["command"])
    while not os.path.basename(words[0]).startswith(("c++", "g++", "clang++")):
        words.pop(0)
    at = words.index("-o")
    return [word for word in words[:at] + words[at + 2 :] if word not in ("-c", entry["file"])]

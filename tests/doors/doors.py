"""Doors to the engine: what each makes of a file by options. Each is a function of the input, the output and
options by the names of the tables, with values as JSON has them; raises Refused."""

import ctypes
import hashlib
import json
import os
import subprocess
import tempfile
from pathlib import Path


class Refused(Exception):
    """The door takes no such option, or no such value, and says why."""


def text_of(value):
    """As flags and C have it: lists with commas between."""
    if isinstance(value, list):
        return ",".join(map(text_of, value))
    return value if isinstance(value, str) else json.dumps(value)


def finish(status, words):
    """Of exit codes, and of statuses of C that are the same: 5 has not converged, and wrote the file."""
    if status == 2:
        raise Refused(words)
    assert status in (0, 5), words


def run(*arguments):
    done = subprocess.run([os.environ["PLANISH_EXECUTABLE"], *map(str, arguments)], check=False,
                          capture_output=True, text=True)
    return done.returncode, done.stderr


def flags_of(options):
    for name, value in options.items():
        yield {"chord_errors": "--chord-error", "edge_lengths": "--edge"}.get(name, "--" + name.replace("_", "-"))
        if value is not True:
            yield text_of(value)


def command(source, output, options):
    finish(*run("fit", source, "-o", output, "-f", "-q", *flags_of(options)))


def scene(source, output, options):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "scene.json")
        job = {"input": str(source), "outputs": [{"path": str(output)}], **options}
        file.write_text(json.dumps({"version": 1, "jobs": [job]}))
        status, words = run("run", file, "-f", "-q")
    # 8: a job has not done all that it was asked for, where the scene by itself was well.
    if status == 8:
        status = 5 if Path(output).exists() else 2
    finish(status, words)


def c(source, output, options):
    library = ctypes.CDLL(os.environ["PLANISH_LOADABLE"])
    library.planish_last_error.restype = ctypes.c_char_p
    own = ctypes.c_void_p()
    assert library.planish_options_create(ctypes.byref(own)) == 0
    status = 0
    for name, value in options.items():
        status = status or library.planish_options_set(own, name.encode(), text_of(value).encode())
    if status == 0:
        status = library.planish_fit_file(os.fsencode(source), os.fsencode(output), own, None)
    library.planish_options_free(own)
    finish(status, library.planish_last_error().decode())


def python(source, output, options):
    import planish  # pylint: disable=import-outside-toplevel

    keywords = {{"interpolation": "method"}.get(name, name): value for name, value in options.items()}
    try:
        planish.fit_file(source, output, **keywords)
    except (planish.InvalidArgument, TypeError) as error:
        raise Refused(str(error)) from error


def outcome(door, source, output, options, folder):
    """What each file holds that is written into the folder, or Refused."""
    folder.mkdir()
    try:
        door(source, folder / output, options)
    except Refused as refusal:
        assert not list(folder.iterdir())
        return refusal
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def shown(made):
    """For messages."""
    if isinstance(made, Refused):
        return f"refused: {made}"
    return {name: hashlib.sha256(data).hexdigest() for name, data in made.items()}

"""One option, one meaning: the command, scene files, Python and C take and refuse the same values of every
option, and make the same bytes of them."""

import ast
import itertools
import json
import os
import subprocess
from pathlib import Path

import doors
import inputs
import pytest
import table

DOORS = {"command": doors.command, "scene": doors.scene, "c": doors.c, "python": doors.python}
if "PLANISH_LOADABLE" not in os.environ:
    del DOORS["c"]


@pytest.fixture(name="given", scope="module")
def given_fixture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("given")
    inputs.write(folder)
    return folder


@pytest.fixture(name="outcome")
def outcome_fixture(given, tmp_path):
    numbers = itertools.count()

    def outcome(door, row, options):
        return doors.outcome(DOORS[door], given / row.input, row.output, options, tmp_path / str(next(numbers)))

    return outcome


def agreed(outcomes):
    """What all doors made; None where all refused."""
    kinds = {door: None if isinstance(made, doors.Refused) else made for door, made in outcomes.items()}
    first = next(iter(kinds.values()))
    if any(made != first for made in kinds.values()):
        pytest.fail(str({door: doors.shown(made) for door, made in outcomes.items()}))
    return first


def rows():
    needs_program = pytest.mark.skipif("PLANISH_RECONSTRUCT" not in os.environ, reason="points need a program")
    for name, row in table.ROWS.items():
        yield pytest.param(name, marks=[needs_program] if row.refused is table.NO_POINTS else [])


@pytest.mark.parametrize("name", rows())
def test_a_row_means_the_same_by_every_door(name, outcome):
    row = table.ROWS[name]
    open_doors = [door for door in DOORS if door not in row.refused]
    for door in DOORS:
        if door in row.refused:
            refusal = outcome(door, row, {**row.beside, name: row.value})
            assert isinstance(refusal, doors.Refused) and row.refused[door] in str(refusal), refusal
    made = agreed({door: outcome(door, row, {**row.beside, name: row.value}) for door in open_doors})
    assert made, "nothing is written"
    is_same = made == outcome("scene", row, row.beside)
    assert is_same == bool(row.same), "the value's effect"
    for values, is_taken in ((row.also, True), (row.wrong, False)):
        for value in values:
            found = agreed({door: outcome(door, row, {**row.beside, name: value}) for door in open_doors})
            assert is_taken == (found is not None), value


@pytest.mark.parametrize("options", table.TOGETHER, ids=json.dumps)
def test_what_contradicts_each_other_does_so_by_every_door(options, outcome):
    agreed({door: outcome(door, table.SEVERAL, options) for door in DOORS})


def schema_rows():
    schema = json.loads(subprocess.check_output([os.environ["PLANISH_EXECUTABLE"], "manual", "--schema"]))
    return schema["$defs"]["settings"]["properties"]


def test_no_row_is_forgotten():
    assert set(table.ROWS) == set(schema_rows()) - {"solve"}


def test_words_and_defaults_of_blenders_panel_are_the_rows():
    """Its add-on cannot be imported without Blender, and gives flags by the names of its properties."""
    addon = Path(__file__).parents[2] / "tools/blender/planish_blender/settings.py"
    rows, seen = schema_rows(), []
    for property_ in ast.walk(ast.parse(addon.read_text())):
        if not isinstance(property_, ast.AnnAssign) or property_.target.id not in rows:
            continue
        row = rows[property_.target.id]
        given = {word.arg: word.value for word in property_.annotation.keywords}
        assert ast.literal_eval(given["default"]) == row.get("default", 0)
        if "enum" in row:
            assert {word for word, *_ in ast.literal_eval(given["items"])} <= set(row["enum"])
        seen.append(property_.target.id)
    assert len(seen) > 6

"""A case of the corpus: files as programs write them, and what the command has to make of them."""

import bisect
import json
import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Callable


@dataclass
class Case:
    """One call of the command on generated files.

    `main` is the file that is fitted; the call is `fit MAIN -o out.glb --report report.json ARGS`.
    With `inspects` it is `inspect MAIN --json ARGS`, and the result's report is what it says.
    """

    name: str
    files: dict[str, bytes]  # by path below an empty folder
    main: str
    args: tuple = ()
    exit: int = 0
    says: tuple[str, ...] = ()  # each stands in the output
    silent: tuple[str, ...] = ()  # none of these does
    check: Callable[["Result"], str | None] | None = None  # what is wrong; None: nothing
    inspects: bool = False


@dataclass
class Result:
    code: int  # exit code; negative: the signal that ended it
    text: str  # all output
    report: dict | None  # None: not written, or no JSON
    glb: Path | None  # the file that was written; None: none
    folder: Path  # where the command ran

    def output(self) -> "Glb":
        return Glb(self.glb.read_bytes())

    def warnings(self) -> dict[str, dict]:
        """The report's warnings by their codes; of several of one code the first."""
        found: dict[str, dict] = {}
        for warning in self.report["warnings"]:
            found.setdefault(warning["code"], warning)
        return found


# ---------------------------------------------------------------- glTF

_SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_KINDS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}


class Glb:
    """The document and the numbers of a GLB without compression."""

    def __init__(self, data: bytes):
        magic, version, total = struct.unpack_from("<4sII", data)
        assert magic == b"glTF" and version == 2 and total == len(data)
        length = struct.unpack_from("<I", data, 12)[0]
        self.document = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]

    def accessor(self, number: int) -> list[tuple]:
        """Rows; integers that are normalized as 0 to 1, or -1 to 1."""
        accessor = self.document["accessors"][number]
        width, kind = _SIZES[accessor["type"]], _KINDS[accessor["componentType"]]
        rows = [(0,) * width] * accessor["count"]
        if "bufferView" in accessor:
            rows = self._rows(accessor, accessor["bufferView"], accessor["count"], width, kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            places = sparse["indices"]
            kinds = _KINDS[places["componentType"]]
            at = self._rows(places, places["bufferView"], sparse["count"], 1, kinds)
            values = sparse["values"]
            given = self._rows(values, values["bufferView"], sparse["count"], width, kind)
            for (place,), row in zip(at, given):
                rows[place] = row
        if accessor.get("normalized"):
            most = {"b": 127, "B": 255, "h": 32767, "H": 65535}[kind]
            rows = [tuple(max(v / most, -1.0) for v in row) for row in rows]
        return rows

    def _rows(self, of: dict, view: int, count: int, width: int, kind: str) -> list[tuple]:
        entry = self.document["bufferViews"][view]
        begin = entry.get("byteOffset", 0) + of.get("byteOffset", 0)
        row = f"<{width}{kind}"
        stride = entry.get("byteStride") or struct.calcsize(row)
        return [struct.unpack_from(row, self.binary, begin + i * stride) for i in range(count)]

    def primitives(self) -> list[tuple[list[list[float]], dict]]:
        """The primitives of the scene, each with the matrix that moves it into the world."""
        document, found = self.document, []

        def visit(number: int, outer: list[list[float]]):
            node = document["nodes"][number]
            moved = _times(outer, _matrix(node))
            if "mesh" in node:
                found.extend((moved, p) for p in document["meshes"][node["mesh"]]["primitives"])
            for child in node.get("children", []):
                visit(child, moved)

        scenes = document.get("scenes", [])
        roots = range(len(document.get("nodes", [])))
        if scenes:
            roots = scenes[document.get("scene", 0)].get("nodes", [])
        for root in roots:
            visit(root, [[float(i == j) for j in range(4)] for i in range(4)])
        return found

    def positions(self) -> list[tuple]:
        """The vertices of all triangles of the scene, in the world's coordinates."""
        found = []
        for m, primitive in self.primitives():
            if primitive.get("mode", 4) not in (4, 5, 6) or "POSITION" not in primitive["attributes"]:
                continue
            for p in self.accessor(primitive["attributes"]["POSITION"]):
                found.append(tuple(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3] for r in m[:3]))
        return found

    def attribute(self, name: str) -> list[tuple]:
        """An attribute of all primitives that have it."""
        found = []
        for _, primitive in self.primitives():
            if name in primitive["attributes"]:
                found += self.accessor(primitive["attributes"][name])
        return found


def _matrix(node: dict) -> list[list[float]]:
    if "matrix" in node:
        return [list(node["matrix"][row::4]) for row in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    length = math.sqrt(x * x + y * y + z * z + w * w) or 1.0
    x, y, z, w = x / length, y / length, z / length, w / length
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    scale, move = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    rows = [[turn[i][j] * scale[j] for j in range(3)] + [move[i]] for i in range(3)]
    return rows + [[0.0, 0.0, 0.0, 1.0]]


def _times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


# ---------------------------------------------------------------- checks

def all_of(*checks):
    """The first thing that is wrong."""

    def check(result: Result) -> str | None:
        for one in checks:
            if (wrong := one(result)) is not None:
                return wrong
        return None

    return check


def counts(**expected):
    """What the report says of the input: vertices, faces, components, genus, boundary_loops ..."""

    def check(result: Result) -> str | None:
        said = result.report.get("input", result.report)
        wrong = [f"{k} {said.get(k)!r}, not {v!r}" for k, v in expected.items() if said.get(k) != v]
        return ", ".join(wrong) or None

    return check


def diagonal_of(points) -> float:
    return math.dist([min(p[k] for p in points) for k in range(3)],
                     [max(p[k] for p in points) for k in range(3)])


def farthest(points, among) -> float:
    """The largest distance of a point to the next of others."""
    others = sorted(among)
    firsts = [other[0] for other in others]
    worst = 0.0
    for point in points:
        at = bisect.bisect_left(firsts, point[0])
        best = math.inf
        for step, place in ((1, at), (-1, at - 1)):
            while 0 <= place < len(others) and abs(others[place][0] - point[0]) < best:
                best = min(best, math.dist(point, others[place]))
                place += step
        worst = max(worst, best)
    return worst


def passes(points, within=2e-6, of=None):
    """The surface has a vertex within so much of the diagonal of each point."""

    def check(result: Result) -> str | None:
        distance = farthest(points, result.output().positions())
        most = within * diagonal_of(of or points)
        return None if distance <= most else f"a point is {distance:g} off, not at most {most:g}"

    return check


def near(values, expected, within=1e-3) -> bool:
    return all(abs(a - b) <= within for a, b in zip(values, expected, strict=True))


def bounded(low, high, within=1e-3):
    """The bounds of the surface's vertices."""

    def check(result: Result) -> str | None:
        points = result.output().positions()
        found = [[f(p[k] for p in points) for k in range(3)] for f in (min, max)]
        if near(found[0], low, within) and near(found[1], high, within):
            return None
        return f"bounds {found}, not {[list(low), list(high)]}"

    return check


def warns(*codes):
    """The report has warnings of these codes."""

    def check(result: Result) -> str | None:
        missing = [code for code in codes if code not in result.warnings()]
        return f"no warning {', '.join(missing)}" if missing else None

    return check


def warns_nothing(result: Result) -> str | None:
    found = list(result.warnings())
    return f"warnings {', '.join(found)}" if found else None

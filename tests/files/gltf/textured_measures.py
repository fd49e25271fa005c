"""What rides on a surface, measured against the asset that it was made of: both files are read here, and nothing is known
of how the surface was made."""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "field"))
from case import Glb  # noqa: E402

FLOAT = 2.0 ** -23  # a step of float32, in parts of the number
VERTEX = 2e-6  # given vertices are hit to half of this, of the diagonal
PLANE = 2e-6  # of the diagonal: what lies in a plane
SHARP = 0.87  # a cosine: planes end at edges that turn by more


class Part:
    """A primitive: triangles, places and what rides on them, moves of targets as NAME@target."""

    def __init__(self, glb, entry):
        def rows(number):
            return np.array(glb.accessor(number), np.float64).astype(np.float32).astype(np.float64)

        self.place = rows(entry["attributes"]["POSITION"])
        order = np.arange(len(self.place))
        if "indices" in entry:
            order = rows(entry["indices"]).astype(int).reshape(-1)
        k, mode = np.arange(len(order) - 2), entry.get("mode", 4)
        if mode == 4:
            self.triangles = order.reshape(-1, 3)
        elif mode == 5:
            self.triangles = order[np.stack([k + k % 2, k + 1 - k % 2, k + 2], -1)]
        else:
            self.triangles = order[np.stack([0 * k, k + 1, k + 2], -1)]
        self.values = {name: rows(n) for name, n in entry["attributes"].items() if name != "POSITION"}
        for name, values in self.values.items():  # colours of three numbers are opaque
            if name.startswith("COLOR") and values.shape[1] == 3:
                self.values[name] = np.concatenate([values, np.ones_like(values[:, :1])], axis=1)
        for k, target in enumerate(entry.get("targets", [])):
            self.values.update({f"{name}@{k}": rows(n) for name, n in target.items()})
        if "WEIGHTS_0" in self.values:  # by joint, in whatever order a row has them
            joints, weights = self.values.pop("JOINTS_0").astype(int), self.values.pop("WEIGHTS_0")
            by_joint = np.zeros((len(weights), joints.max() + 1))
            np.add.at(by_joint, (np.arange(len(weights))[:, None], joints), weights)
            self.values["WEIGHTS"] = by_joint
        self.renew()

    def renew(self):
        """After a change."""
        self.corners = self.place[self.triangles]
        normals = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        self.areas = np.linalg.norm(normals, axis=1) / 2
        with np.errstate(invalid="ignore", divide="ignore"):
            self.normals = np.nan_to_num(normals / (2 * self.areas[:, None]))

    def take(self, other):
        """A part of the same primitive: what a material has with and without a layer on it comes as two."""
        self.triangles = np.concatenate([self.triangles, other.triangles + len(self.place)])
        self.place = np.concatenate([self.place, other.place])
        self.values = {name: np.concatenate([values, other.values[name]]) for name, values in self.values.items()
                       if name in other.values}
        self.renew()

    def rides(self):
        return [name for name in self.values if name.partition("@")[0] not in ("NORMAL", "TANGENT", "POSITION")]


def numbers_of(rows):
    """Equal rows have equal numbers."""
    return np.unique(rows + 0.0, axis=0, return_inverse=True)[1].reshape(-1)


def joined(count, pairs):
    """Components of so many triangles, of which pairs are neighbours."""
    parent = list(range(count))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in pairs:
        parent[root(a)] = root(b)
    return np.unique([root(k) for k in range(count)], return_inverse=True)[1]


def pairs_of(part):
    """Pairs of edges at one place, each 3 * triangle + corner, and the ends of each edge in the order of places."""
    names = numbers_of(part.place)
    ends = np.stack([part.triangles, np.roll(part.triangles, -1, axis=1)], -1).reshape(-1, 2)
    ends = np.where((names[ends[:, 0]] > names[ends[:, 1]])[:, None], ends[:, ::-1], ends)
    keys = numbers_of(names[ends])
    order = np.argsort(keys, kind="stable")
    found = [np.stack([order[:-k], order[k:]], -1)[keys[order][:-k] == keys[order][k:]] for k in range(1, 4)]
    return np.concatenate(found), ends


class Charts:
    """Triangles of a part by whether an attribute is continuous between them, but for rounding."""

    def __init__(self, part, name):
        self.value = part.values[name]
        pairs, ends = pairs_of(part)
        apart = np.abs(self.value[ends[pairs[:, 0]]] - self.value[ends[pairs[:, 1]]]).max(axis=(1, 2))
        smooth = pairs[apart <= 4 * FLOAT * max(1.0, np.abs(self.value).max())]
        if name.startswith("TEXCOORD") and "@" not in name:  # mirrored halves are two
            turns = turns_of(self.value[part.triangles])
            smooth = smooth[turns[smooth[:, 0] // 3] * turns[smooth[:, 1] // 3] >= 0]
        self.of = joined(len(part.triangles), smooth // 3)
        self.count = int(self.of.max()) + 1
        self.borders = np.full(3 * len(part.triangles), True)
        self.borders[smooth.reshape(-1)] = False
        self.seams = np.full(3 * len(part.triangles), False)
        self.seams[pairs.reshape(-1)] = True
        self.seams = (self.seams & self.borders).reshape(-1, 3)
        self.borders = self.borders.reshape(-1, 3)
        self.smooth = smooth
        self.value_corners = self.value[part.triangles]
        self.extents = np.array([np.ptp(self.value_corners[self.of == c].reshape(-1, self.value.shape[1]), axis=0).max()
                                 for c in range(self.count)])
        largest = self.extents.max()  # also for charts of one value
        self.extents[self.extents < 1e-6 * max(1.0, np.abs(self.value).max())] = largest if largest > 0 else 1.0

    def segments(self, part, chart):
        """Borders of a chart: their ends in space and in the attribute."""
        at = self.borders & (self.of == chart)[:, None]
        return [np.stack([c[at], np.roll(c, -1, axis=1)[at]], 1) for c in (part.corners, self.value_corners)]


def on_segments(points, segments):
    """The distance of each point to the nearest of the segments."""
    a, b = segments[:, 0], segments[:, 1]
    d = b - a
    length = np.maximum((d * d).sum(-1), 1e-300)
    t = np.clip(((points[:, None] - a) * d).sum(-1) / length, 0, 1)
    return np.linalg.norm(points[:, None] - a - t[..., None] * d, axis=-1).min(axis=1)


def to_triangles(points, corners):
    """The distance of each point to each triangle, and the nearest place there as weights of its corners. Based on: C.
    Ericson, "Real-Time Collision Detection", 2005, section 5.1.5."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    n = len(points)
    best = np.full((n, len(a)), np.inf)
    weights = np.zeros((n, len(a), 3))
    normal = np.cross(b - a, c - a)
    square = np.maximum((normal * normal).sum(-1), 1e-300)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        p, d = corners[:, first], corners[:, second] - corners[:, first]
        t = np.clip(((points[:, None] - p) * d).sum(-1) / np.maximum((d * d).sum(-1), 1e-300), 0, 1)
        far = np.linalg.norm(points[:, None] - p - t[..., None] * d, axis=-1)
        nearer = far < best
        best[nearer] = far[nearer]
        row = np.zeros(t.shape + (3,))
        row[..., first], row[..., second] = 1 - t, t
        weights[nearer] = row[nearer]
    u = (np.cross(points[:, None] - b, c - b) * normal).sum(-1) / -square
    v = (np.cross(points[:, None] - c, a - c) * normal).sum(-1) / -square
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (square > 1e-299)
    height = np.abs(((points[:, None] - a) * normal).sum(-1)) / np.sqrt(square)
    best[inside] = height[inside]
    weights[inside] = np.stack([u, v, 1 - u - v], -1)[inside]
    return best, weights


def hull_excess(points, of):
    """How far points lie outside of the convex hull of others, in the plane."""
    order = sorted(map(tuple, np.unique(of, axis=0)))
    if len(order) < 3:
        return 0.0

    def half(row):
        made = []
        for p in row:
            while len(made) > 1 and ((made[-1][0] - made[-2][0]) * (p[1] - made[-2][1]) -
                                     (made[-1][1] - made[-2][1]) * (p[0] - made[-2][0])) <= 0:
                made.pop()
            made.append(p)
        return made[:-1]

    loop = np.array(half(order) + half(order[::-1]))
    if len(loop) < 3:
        return float(on_segments(points, np.stack([loop, np.roll(loop, -1, 0)], 1)).max())
    d = np.roll(loop, -1, axis=0) - loop
    away = points[:, None] - loop
    out = ((d[:, 1] * away[..., 0] - d[:, 0] * away[..., 1]) / np.linalg.norm(d, axis=1)).max(axis=1)
    return max(float(out.max()), 0.0)


def turns_of(corners):
    """Areas of triangles of the plane, below 0 where they go around the other way."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def planes_of(part, charts, diagonal):
    """Charts' flat pieces that end at sharp edges, and on which the attribute is affine: their triangles, a point, a
    normal, the map, how far values may be off it, and what they change by. They may be off by a millionth, by rounding,
    and by as much as the map changes along the tolerance of given vertices."""
    pairs, _ = pairs_of(part)
    cosine = (part.normals[pairs[:, 0] // 3] * part.normals[pairs[:, 1] // 3]).sum(-1)
    bent = (cosine < 1 - 1e-9) & (cosine > SHARP)
    inner = charts.smooth // 3
    inner = inner[(part.normals[inner[:, 0]] * part.normals[inner[:, 1]]).sum(-1) > 1 - 1e-9]
    piece_of = joined(len(part.triangles), inner)
    round_ones = set(piece_of[pairs[bent] // 3].reshape(-1).tolist())
    found = []
    for piece in range(piece_of.max() + 1):
        at = np.flatnonzero(piece_of == piece)
        if piece in round_ones or part.areas[at].sum() < 1e-9 * part.areas.sum():
            continue
        normal = part.normals[at[np.argmax(part.areas[at])]]
        places = part.corners[at].reshape(-1, 3)
        value = charts.value_corners[at].reshape(len(places), -1)
        middle = places.mean(0)
        span = np.abs(places - middle).max()
        frame = np.linalg.svd(normal[None])[2][1:]
        basis = np.concatenate([(places - middle) @ frame.T / span, np.ones((len(places), 1))], axis=1)
        fitted, *_ = np.linalg.lstsq(basis, value, rcond=None)
        steep = np.abs(fitted[:2]).max() / span
        step = FLOAT * max(1.0, np.abs(value).max()) + FLOAT * np.abs(places).max() * steep
        if np.abs(basis @ fitted - value).max() > 4 * step or np.abs((places - middle) @ normal).max() > PLANE * diagonal:
            continue
        found.append((at, middle, normal, lambda p, o=middle, f=frame, s=span, m=fitted:
                      np.concatenate([(p - o) @ f.T / s, np.ones((len(p), 1))], axis=1) @ m,
                      1e-6 * max(1.0, np.abs(value).max()) + 4 * step + VERTEX / 2 * diagonal * steep,
                      np.ptp(value, axis=0).max()))
    return found


class Measured:
    """Figures of one attribute of one primitive; `faults`: words of what is wrong."""

    def __init__(self, asset, given, made, name, diagonal, near):
        self.asset, self.given, self.made, self.name, self.diagonal = asset, given, made, name, diagonal
        self.distance, self.weights = near  # of made triangles' middles to the given triangles
        self.faults, self.figures = {}, {}
        self.before, self.after = Charts(given, name), Charts(made, name)
        self.scale = max(1.0, np.abs(self.before.value).max())
        self.is_uv = name.startswith("TEXCOORD") and "@" not in name
        for check in (self.kept, self.affine, self.seams, self.folds, self.ranges, self.slides, self.truths, self.plain):
            check()

    def note(self, key, value, most=None):
        value = float(value)
        if most is not None and not value <= most and value >= self.figures.get(key, 0.0):
            self.faults[key] = f"{key} of {self.name} is {value:.3g}, not at most {most:.3g}"
        self.figures[key] = max(value, self.figures.get(key, 0.0))

    def kept(self):
        """Given vertices have their values to the bit, and no others; charts are as many."""
        value, used = self.before.value, np.unique(self.given.triangles)
        apart = np.linalg.norm(self.made.place[:, None] - self.given.place[used], axis=-1) <= VERTEX * self.diagonal
        shifts = np.abs(self.after.value[:, None] - value[used]).max(-1)
        # Joint weights are made to add up to 1; moves and they have a tolerance, as places have.
        equal = shifts == 0 if "@" not in self.name and self.name != "WEIGHTS" else shifts <= VERTEX * self.scale
        self.note("lost", (~(apart & equal).any(axis=0)).sum(), 0)
        self.note("foreign", (apart.any(axis=1) & ~(apart & equal).any(axis=1)).sum(), 0)
        votes = np.zeros((self.after.count, self.before.count), int)
        chart_of_vertex = np.zeros((len(used), self.before.count), bool)
        rank = np.searchsorted(used, self.given.triangles)
        chart_of_vertex[rank.reshape(-1), np.repeat(self.before.of, 3)] = True
        match = (apart & equal) @ chart_of_vertex  # of made vertices
        np.add.at(votes, np.repeat(self.after.of, 3), match[self.made.triangles.reshape(-1)])
        self.origin = votes.argmax(axis=1)  # the chart that each chart was
        self.note("charts", abs(self.after.count - self.before.count), 0)

    def affine(self):
        """On planes the attribute is the same affine function."""
        pieces = planes_of(self.given, self.before, self.diagonal)
        nearest, home = np.full(len(self.made.triangles), np.inf), np.full(len(self.made.triangles), -1)
        for k, (at, middle, normal, *_) in enumerate(pieces):
            height = np.abs((self.made.corners - middle) @ normal).max(axis=1)
            lies = (height <= PLANE * self.diagonal) & (self.made.normals @ normal > 0.99)
            lies &= self.origin[self.after.of] == self.before.of[at[0]]
            far = self.distance[:, at].min(axis=1)
            closer = lies & (far < nearest)
            nearest[closer], home[closer] = far[closer], k
        self.figures["flat"] = float(self.made.areas[home >= 0].sum() / self.made.areas.sum())
        for k, (_, _, _, truth, most, extent) in enumerate(pieces):
            at = home == k
            if at.any():
                off = np.abs(truth(self.made.corners[at].reshape(-1, 3)) -
                             self.after.value_corners[at].reshape(-1, self.before.value.shape[1])).max()
                if self.name == "WEIGHTS":  # of joints: by the map of places, which is not affine for fair surfaces
                    self.note("joints", off / extent, self.asset.slack)
                    continue
                self.note("affine", off, most)
                if extent > 1e-6 * self.scale:
                    self.note("affine_share", off / extent)
        if self.is_uv and self.figures["flat"] < self.asset.flat:
            self.faults["flat"] = f"only {self.figures['flat']:.3f} of {self.name} lies flat, not {self.asset.flat}"

    def seams(self):
        """Where a chart ends at another: on the border that it had, where that is straight on the surface, too."""
        for chart in range(self.after.count):
            at = self.after.seams & (self.after.of == chart)[:, None]
            source = self.origin[chart]
            extent = self.before.extents[source]
            space, values = self.before.segments(self.given, source)
            if not at.any() or not len(space):
                continue
            places, value = self.made.corners[at], self.after.value_corners[at]
            straight = on_segments(places, space) <= VERTEX * self.diagonal
            off = on_segments(value, values)
            if straight.any():
                self.note("seam", off[straight].max(), 1e-6 * self.scale + 8 * FLOAT * self.scale)
            if not straight.all():
                self.note("seam_bent", off[~straight].max() / extent, self.asset.slack)

    def folds(self):
        """Triangles that turn the other way than those that were there."""
        if not self.is_uv:
            return
        was, now = turns_of(self.before.value_corners), turns_of(self.after.value_corners)
        sides = np.abs(self.after.value_corners - np.roll(self.after.value_corners, 1, axis=1)).max(axis=(1, 2))
        noise = 1e-6 * np.median(np.abs(was)) + 2 * FLOAT * np.abs(self.before.value).max() * sides
        same = self.origin[self.after.of][:, None] == self.before.of
        far = np.where(same, self.distance, np.inf)
        beside = far <= far.min(axis=1, keepdims=True) + 0.02 * self.diagonal
        for sign in (1, -1):
            allowed = (beside & (sign * was > 1e-12 * np.abs(was).max())).any(axis=1)
            flat = ~(beside & (was != 0)).any(axis=1)
            self.note("folds", ((sign * now > noise) & ~allowed & ~flat).sum(), 0)

    def ranges(self):
        """Coordinates stay by their chart's hull, colours and numbers within those given."""
        value = self.before.value
        if not self.is_uv:
            out = np.maximum(self.after.value - value.max(0), value.min(0) - self.after.value).max()
            self.note("beyond", max(out, 0.0), 2 * FLOAT * self.scale)
            return
        for chart in range(self.after.count):
            source = self.origin[chart]
            points = np.unique(self.after.value_corners[self.after.of == chart].reshape(-1, 2), axis=0)
            hull = self.before.value_corners[self.before.of == source].reshape(-1, 2)
            extent = self.before.extents[source]
            self.note("hull", hull_excess(points, hull) / extent, self.asset.slack)

    def slides(self):
        """From what the nearest place of the given chart has: the middles of triangles."""
        same = self.origin[self.after.of][:, None] == self.before.of
        far = np.where(same, self.distance, np.inf)
        # Of several that are as near, as on both sides of a seam, that which is nearest in the attribute.
        had = np.einsum("nmk,mkd->nmd", self.weights, self.before.value_corners)
        off = np.abs(had - self.after.value_corners.mean(1)[:, None]).max(axis=-1)
        off = np.where(far <= far.min(axis=1, keepdims=True) + 5e-3 * self.diagonal, off, np.inf).min(axis=1)
        extent = self.before.extents[self.origin[self.after.of]]
        if self.name not in self.asset.plain:
            self.note("slide", (off / extent).max(), self.asset.slack)

    def truths(self):
        for number, name, truth, period in self.asset.truths:
            if name != self.name or number != self.made.number:
                continue

            def off(place, value, truth=truth, period=period):
                true, holds = truth(place)
                apart = value - true
                apart -= np.where(period > 0, np.rint(apart / np.maximum(period, 1e-9)) * period, 0)
                return np.abs(apart[holds]).max() / self.before.extents.max()

            steps = [(i / 4, j / 4, 1 - (i + j) / 4) for i in range(5) for j in range(5 - i)]
            flat = max(off(np.tensordot(self.given.corners, s, (1, 0)),
                           np.tensordot(self.before.value_corners, s, (1, 0))) for s in np.array(steps))
            self.note("truth_flat", flat)
            # The surface is round between the vertices where the faces are flat, but need not be the shape.
            self.note("truth", off(self.made.place, self.after.value), max(2 * flat, 1e-3))

    def plain(self):
        """Values of faces and ids: none but those given, one on each triangle, as much area as before."""
        if self.name not in self.asset.plain:
            return
        rows = np.unique(self.before.value, axis=0)
        which = np.abs(self.after.value[:, None] - rows).max(-1) == 0
        self.note("blended", (~which.any(axis=1)).sum(), 0)
        corners = np.where(which.any(axis=1), which.argmax(axis=1), -1)[self.made.triangles]
        had = (np.abs(self.before.value[:, None] - rows).max(-1) == 0).argmax(axis=1)[self.given.triangles]
        if (had != had[:, :1]).any():  # ids of vertices, not of faces
            return
        had = had[:, 0]
        self.note("mixed", (corners != corners[:, :1]).any(axis=1).sum(), 0)
        shares = [np.bincount(which, areas, len(rows) + 1) / areas.sum()
                  for which, areas in ((had, self.given.areas), (corners[:, 0] % (len(rows) + 1), self.made.areas))]
        self.note("area", np.abs(shares[0] - shares[1]).max(), 0.05)


def open_borders(parts):
    """Of all primitives of a mesh together: loops of edges that have one triangle."""
    places = np.concatenate([p.place for p in parts])
    at = np.cumsum([0] + [len(p.place) for p in parts])
    triangles = numbers_of(places)[np.concatenate([p.triangles + k for p, k in zip(parts, at)])]
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], -1).reshape(-1, 2), axis=1)
    edges, counts = np.unique(ends, axis=0, return_counts=True)
    edges = edges[counts == 1]
    order = np.argsort(edges.reshape(-1), kind="stable")
    names = edges.reshape(-1)[order]
    same = names[1:] == names[:-1]
    return len(np.unique(joined(len(edges), np.stack([order[:-1][same], order[1:][same]], -1) // 2)))


def is_same(one, other):
    """Whether two primitives are of one material, with and without a layer on it."""
    return all(one.get(key) == other.get(key) for key in ("material", "extensions", "extras"))


def runs_of(mesh):
    """Its primitives, of those that are one by is_same() the first."""
    entries = mesh["primitives"]
    return [p for k, p in enumerate(entries) if k == 0 or not is_same(entries[k - 1], p)]


def untouched(before, after):
    """Parts of the documents that differ though no surface does that."""
    a, b = before.document, after.document
    wrong = [key for key in ("materials", "textures", "samplers", "nodes", "scenes", "scene", "cameras", "animations",
                             "extensions", "extensionsUsed") if a.get(key) != b.get(key)]

    def images(glb):
        views = [glb.document["bufferViews"][image["bufferView"]] for image in glb.document.get("images", [])]
        return [glb.binary[v.get("byteOffset", 0):][:v["byteLength"]] for v in views]
    if images(before) != images(after):
        wrong.append("images")
    if [s["joints"] for s in a.get("skins", [])] != [s["joints"] for s in b.get("skins", [])]:
        wrong.append("skins")
    for one, other in zip(a["meshes"], b["meshes"]):
        for key in ("material", "extensions"):
            if [p.get(key) for p in runs_of(one)] != [p.get(key) for p in runs_of(other)]:
                wrong.append(f"{key} of primitives")
        if one.get("weights") != other.get("weights"):
            wrong.append("weights")
    return wrong


def tangents_of(part, name="TEXCOORD_0"):
    """The share of vertices whose tangents are no unit vectors across normals, or whose sign is not the texture's."""
    tangent, normal = part.values["TANGENT"], part.values["NORMAL"]
    wrong = np.abs(np.linalg.norm(tangent[:, :3], axis=1) - 1) > 1e-3
    wrong |= np.abs((tangent[:, :3] * normal).sum(1)) > 1e-2
    sides = np.zeros(len(part.place))
    np.add.at(sides, part.triangles.reshape(-1), np.repeat(np.sign(turns_of(part.values[name][part.triangles])), 3))
    return float((wrong | (sides * tangent[:, 3] > 0)).mean())


def measure(asset, before, after):
    """Faults of an output and its figures, the worst of all attributes. before and after: Files."""
    faults, figures = [f"{part} changed" for part in untouched(before.glb, after.glb)], {}
    if len(before.parts) != len(after.parts):
        return [f"{len(after.parts)} primitives, not {len(before.parts)}", *faults], figures
    diagonal = np.linalg.norm(np.ptp(np.concatenate([p.place for p in before.parts]), axis=0))
    loops = [open_borders(parts) for parts in (before.parts, after.parts)]
    if loops[0] != loops[1]:
        faults.append(f"{loops[1]} open borders, not {loops[0]}")
    for given, made in zip(before.parts, after.parts):
        missing = set(given.rides()) - set(made.rides())
        if missing:
            faults.append(f"{', '.join(sorted(missing))} missing")
        near = to_triangles(made.corners.mean(axis=1), given.corners)
        for name in given.rides():
            if name in made.values:
                one = Measured(asset, given, made, name, diagonal, near)
                faults += one.faults.values()
                for key, value in one.figures.items():
                    worst = min if key == "flat" else max
                    if key != "flat" or one.is_uv:
                        figures[key] = worst(value, figures.get(key, value))
        if "normalTexture" in before.glb.document["materials"][made.material]:
            wrong = tangents_of(made) if "TANGENT" in made.values else 1.0
            figures["tangents"] = wrong
            if wrong > 0:
                faults.append(f"{wrong:.3f} of the tangents are wrong")
    return faults, figures


class File:
    """A GLB and its primitives, of all meshes."""

    def __init__(self, data):
        self.glb = Glb(data)
        self.parts = []
        for mesh in self.glb.document["meshes"]:
            entries = mesh["primitives"]
            for k, entry in enumerate(entries):
                part = Part(self.glb, entry)
                if k > 0 and is_same(entries[k - 1], entry):
                    self.parts[-1].take(part)
                    continue
                part.number, part.material = len(self.parts), entry.get("material")
                self.parts.append(part)

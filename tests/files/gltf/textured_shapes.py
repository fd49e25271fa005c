"""Shapes with coordinates, textures, and the glTF files that hold them.

A shape is a soup of triangles: "P" (T, 3, 3), and for each attribute an array (T, 3, width). Vertices are made as
exporters do it: corners that agree in everything are one."""
import json
import math
import pathlib
import struct
import sys
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "field"))
import gltf_cases as gltf  # noqa: E402

TAU = 2 * math.pi


# ---------------------------------------------------------------- textures

def png(pixels):
    """An 8-bit PNG of rows of RGB or RGBA."""
    height, width, channels = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype(np.uint8))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) +
            chunk(b"IEND", b""))


def picture(kind, width=256, height=256, tint=(90, 130, 170)):
    """checker: a board with round logos; normal: bumps; leaf, logo: one on nothing."""
    y, x = (np.mgrid[0:height, 0:width] + 0.5) / np.array([height, width]).reshape(2, 1, 1)
    if kind == "normal":
        made = np.stack([np.sin(x * 8 * TAU) * 0.3, np.sin(y * 8 * TAU) * 0.3, np.ones_like(x)], -1)
        return np.rint((made / np.linalg.norm(made, axis=-1, keepdims=True) + 1) * 127.5)
    if kind == "leaf":
        inside = np.abs(x - 0.5) < 0.4 * np.sin(math.pi * y)
        return np.dstack([60 + 60 * (np.abs(x - 0.5) > 0.02), 140 + 40 * np.sin(40 * y), 40 + 0 * x, 255 * inside])
    logos = [(0.5, 0.5, 0.45)] if kind == "logo" else [(0.25, 0.25, 0.17), (0.75, 0.75, 0.17), (0.5, 0.5, 0.08)]
    made = np.array(tint) + ((np.floor(x * 8) + np.floor(y * 8)) % 2)[..., None] * 60 - 20
    alpha = np.zeros_like(x)
    for u, v, radius in logos:
        r = np.hypot(x - u, y - v) / radius
        made[r < 1], alpha[r < 1] = (250, 250, 245), 255
        made[(r < 0.92) & (r > 0.74)] = (200, 40, 40)
        made[(r < 0.5) & ((np.abs(x - u) < 0.12 * radius) | (np.abs(y - v) < 0.12 * radius))] = (30, 40, 60)
    return np.dstack([made, alpha]) if kind == "logo" else made


# ---------------------------------------------------------------- shapes

def soup(*parts):
    """Shapes together."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def with_uv(shape, uv):
    return {**shape, "TEXCOORD_0": np.array(uv(shape["P"]), float)}


def sheet(point, uv=lambda s, t: (s, t), nx=1, ny=1, cut="right", rng=None, jitter=0.0):
    """point(s, t) and uv(s, t) of a grid over the unit square. Its vertices jitter by so much of a cell, on its borders
    along these, and on both sides alike."""
    found = []
    for j in range(ny):
        for i in range(nx):
            a, b, c, d = (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
            odd = {"right": 0, "alternate": (i + j) % 2}[cut] if cut != "random" else rng.integers(2)
            found += [(a, b, d), (b, c, d)] if odd else [(a, b, c), (a, c, d)]
    whole = np.array(found)
    st = whole.astype(float)
    if jitter:
        moves = rng.uniform(-jitter, jitter, (nx + 1, ny + 1, 2))
        moves[[0, nx], :, 0] = moves[:, [0, ny], 1] = 0
        moves[nx, :, 1] = moves[0, :, 1]
        st += moves[whole[..., 0], whole[..., 1]]
    s, t = st[..., 0] / nx, st[..., 1] / ny

    def stack(values):
        return np.stack([np.broadcast_to(np.asarray(v, float), s.shape) for v in values], -1)

    return {"P": stack(point(s, t)), "TEXCOORD_0": stack(uv(s, t))}


def box(size=(1, 1, 1), n=1, cut="right", rng=None, uv=lambda face, s, t: (s, t)):
    def side(k):
        axis, sign = k // 2, 1 - 2 * (k % 2)

        def point(s, t):
            p = [None] * 3
            p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign + 0 * s, sign * (2 * s - 1), 2 * t - 1
            return [p[i] * size[i] / 2 for i in range(3)]

        return sheet(point, lambda s, t: uv(k, s, t), n, n, cut, rng)

    return soup(*map(side, range(6)))


def turned(profile, n, m, cut="right", rng=None, wraps=1.0, jitter=0.0, point=None):
    """A profile, radius and height by t, turned around z; u goes `wraps` times around. Where the radius is 0 each
    triangle has its own u, the middle of its other two. point(x, y, z) moves all."""
    def place(s, t):
        radius, height = profile(t)
        radius, angle = np.where(np.abs(radius) < 1e-12, 0, radius), s % 1.0 * TAU
        p = radius * np.cos(angle), radius * np.sin(angle), height
        return point(*p) if point else p

    made = sheet(place, lambda s, t: (s * wraps, t), n, m, cut, rng, jitter)
    sides = np.linalg.norm(np.roll(made["P"], 1, axis=1) - made["P"], axis=-1)
    made = {name: values[(sides > 1e-9).all(axis=1)] for name, values in made.items()}
    at_pole = np.abs(profile(made["TEXCOORD_0"][..., 1])[0]) < 1e-12
    u = made["TEXCOORD_0"][..., 0]
    u[at_pole] = ((u.sum(axis=1, keepdims=True) - u) / 2)[at_pole]
    return made


def wall(n=16, m=3, height=1.0, **how):
    return turned(lambda t: (1 + 0 * t, height * t), n, m, **how)


def ball(n, m, cut="alternate", **how):
    return turned(lambda t: (np.sin(math.pi * t), -np.cos(math.pi * t)), n, m, cut, **how)


def ears(loop, rng):
    """Triangles of a polygon of the plane, counter-clockwise, cut at ears drawn by lot."""
    loop = [np.asarray(p, float) for p in loop]

    def turn(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    found = []
    while len(loop) > 3:
        for i in rng.permutation(len(loop)):
            a, b, c = loop[i - 1], loop[i], loop[(i + 1) % len(loop)]
            others = [p for p in loop if not any(np.array_equal(p, q) for q in (a, b, c))]
            if turn(a, b, c) > 1e-9 and all(min(turn(a, b, p), turn(b, c, p), turn(c, a, p)) < -1e-12 for p in others):
                break
        found.append((a, b, c))
        loop.pop(i)
    return np.array(found + [tuple(loop)])


def with_hole(outer, hole):
    """An outline that goes into a hole and back, at the nearest corners."""
    inner = list(hole[::-1])
    i, j = min(((i, j) for i in range(len(outer)) for j in range(len(inner))),
               key=lambda k: math.dist(outer[k[0]], inner[k[1]]))
    return outer[:i + 1] + inner[j:] + inner[:j + 1] + outer[i:]


def circle(x, y, radius, n):
    return [(x + radius * math.cos(TAU * k / n), y + radius * math.sin(TAU * k / n)) for k in range(n)]


def lid(loop, z, rng, scale, up=True, origin=0.5):
    """A flat polygon in odd triangles, whose coordinates go by the place."""
    cut = ears(loop, rng)[:, ::1 if up else -1]
    return {"P": np.concatenate([cut, np.full(cut.shape[:2] + (1,), float(z))], axis=-1), "TEXCOORD_0": origin + cut * scale}


def prism(loop, depth, rng, scale=1.0, holes=()):
    """A plate of an outline in x and y, with holes; each wall of its own chart."""
    whole = list(loop)
    for hole in holes:
        whole = with_hole(whole, hole)
    sides = [lid(whole, depth / 2, rng, scale, True, 0.0), lid(whole, -depth / 2, rng, scale, False, 0.0)]

    def between(a, b):
        return sheet(lambda s, t: (a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), depth * (t - 0.5)),
                     lambda s, t: (s * math.dist(a, b) * scale, t * depth * scale))

    for outline in [list(loop), *(list(hole)[::-1] for hole in holes)]:
        sides += [between(a, b) for a, b in zip(outline, outline[1:] + outline[:1])]
    return soup(*sides)


# ---------------------------------------------------------------- files

def indexed(shape):
    """Vertices of a soup, and indices of its triangles. "split" keeps corners apart that differ in it."""
    stored = {name: np.asarray(v, np.float32).reshape(-1, v.shape[-1]) + np.float32(0) for name, v in shape.items()}
    _, first, places = np.unique(np.hstack(list(stored.values())), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # as the triangles come
    return {name: v[first[order]] for name, v in stored.items() if name != "split"}, np.argsort(order)[places.reshape(-1)]


class Asset:
    """A file, and what is known of it.

    flat: the least share of its surface that lies on planes between sharp edges. truths: what coordinates are meant to
    be, (primitive, attribute, function, period): the function gives values of places, and where they hold. plain:
    attributes that have no values but those given. slack: how far things may slide, in parts of a chart, where no plane
    says more. recorded: its faults are told, but do not count."""

    def __init__(self, flat=0.0, truths=(), plain=(), recorded=False, slack=0.05):
        self.flat, self.truths, self.plain, self.recorded, self.slack = flat, truths, plain, recorded, slack
        self.file = gltf.File(None, None)
        self.file.json.update(textures=[], images=[], materials=[], meshes=[{"primitives": []}],
                              samplers=[{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}])
        self.mesh = self.file.json["meshes"][0]

    def texture(self, kind="checker", **more):
        view = self.file.view(png(picture(kind, **more)))
        self.file.json["images"].append({"bufferView": view, "mimeType": "image/png"})
        self.file.json["textures"].append({"source": len(self.file.json["images"]) - 1, "sampler": 0})
        return len(self.file.json["textures"]) - 1

    def material(self, texture, transform=None, set=0, **more):
        info = {"index": texture, "texCoord": set}
        if transform:
            info["extensions"] = {"KHR_texture_transform": transform}
            self.file.uses("KHR_texture_transform")
        materials = self.file.json["materials"]
        materials.append({"name": f"m{len(materials)}", **more, "pbrMetallicRoughness": {
            "metallicFactor": 0, "roughnessFactor": 0.8, "baseColorTexture": info}})
        return len(materials) - 1

    def add(self, shape, material=0, kinds={}, layout="", targets=(), order=None, mode=4):
        """A primitive. kinds: component types of attributes; order: indices of a strip or fan, by the attributes."""
        given, indices = indexed(shape)
        numbers = self._interleaved(given) if layout == "interleaved" else {
            name: self._accessor(name, values, kinds.get(name, gltf.FLOAT), layout) for name, values in given.items()}
        numbers["POSITION"] = numbers.pop("P")
        chosen = indices if order is None else order(given)
        entry = {"attributes": numbers, "material": material, "mode": mode,
                 "indices": self.file.add([(int(k),) for k in chosen], gltf.USHORT)}
        if targets:
            entry["targets"] = [{name: self._accessor("P" if name == "POSITION" else name, move(given))
                                 for name, move in target.items()} for target in targets]
        self.mesh["primitives"].append(entry)

    def _accessor(self, name, values, kind=gltf.FLOAT, layout=""):
        rows = [tuple(map(float, row)) for row in values]
        if name == "P":
            return self.file.positions(rows)
        if layout == "sparse" and name == "TEXCOORD_0":
            places = [k for k, row in enumerate(rows) if any(row)]
            return self.file.accessor(**self.file.sparse([rows[k] for k in places], places, "VEC2", len(rows)))
        if kind == gltf.FLOAT:
            return self.file.add(rows)
        is_plain = name.startswith(("_", "JOINTS"))
        most = 1 if is_plain else {gltf.UBYTE: 255, gltf.USHORT: 65535}[kind]
        rows = [tuple(round(x * most) for x in row) for row in rows]
        width = struct.calcsize(f"{len(rows[0])}{gltf.KINDS[kind]}")
        return self.file.add(rows, kind, stride=-(-width // 4) * 4, **({} if is_plain else {"normalized": True}))

    def _interleaved(self, attributes):
        rows = np.hstack(list(attributes.values())).astype("<f4")
        view = self.file.view(rows.tobytes(), byteStride=4 * rows.shape[1])
        found, at = {}, 0
        for name, values in attributes.items():
            bounds = {"min": values.min(0).tolist(), "max": values.max(0).tolist()} if name == "P" else {}
            found[name] = self.file.accessor(bufferView=view, byteOffset=4 * at, componentType=gltf.FLOAT, count=len(values),
                                             type=f"VEC{values.shape[1]}", **bounds)
            at += values.shape[1]
        return found

    def bytes(self):
        document = self.file.json
        if "extensionsUsed" in document:
            document["extensionsUsed"] = sorted(set(document["extensionsUsed"]))
        return self.file.glb()

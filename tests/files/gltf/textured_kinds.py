"""The assets of textured_assets.py, by name: functions of a generator of random numbers."""
import math

import numpy as np

from textured_shapes import TAU, Asset, ball, box, circle, gltf, lid, prism, sheet, soup, turned, wall, with_uv

KINDS = {}
FLAT = 0.99


def kind(name, shape, texture="checker", wide=256, transform=None, set=0, after=None, flat=0.0, truths=(), plain=(),
         slack=0.05, recorded=False, **how):
    """An asset of one primitive with one texture: shape(rng), what is known of it, how it is stored, and after(asset)."""
    def make(rng):
        made = Asset(flat, truths, plain, recorded, slack)
        made.material(made.texture(texture, width=wide), transform, set)
        made.add(shape(rng), **how)
        if after:
            after(made)
        return made
    KINDS[name] = make


def several(*parts, flat=0.0, truths=()):
    """An asset of primitives, each with a material of its own: (shape, what its texture is, keys of the material)."""
    made = Asset(flat, truths)
    for shape, texture, more in parts:
        made.add(shape, made.material(made.texture(**texture), **more))
    return made


def some(shape, which):
    return {name: values[which] for name, values in shape.items()}


def plus(shape, **more):
    """Further attributes by the shape's own: functions."""
    for name, value in more.items():
        shape = {**shape, name: np.array(value(shape), float)}
    return shape


def apart(shape, labels):
    """Vertices of their own where triangles have other labels."""
    return plus(shape, split=lambda s: np.broadcast_to(np.asarray(labels(s)).reshape(-1, 1, 1), s["P"].shape[:2] + (1,)))


# ---------------------------------------------------------------- boxes and plates

def atlas(f, s, t):
    return (f % 3 + 0.05 + 0.9 * s) / 3, (f // 3 + 0.05 + 0.9 * t) / 2


def band(f, s, t):
    """One chart around all walls, over their sharp edges, and lids of their own."""
    return [(s / 4, t), ((2 + s) / 4, t), ((1 + t) / 4, s), ((3 + t) / 4, 1 - s), (s / 4, 1 + t), (s / 4, 2 + t)][f]


def cut_box(rng, n=2, **more):
    return box(n=n, cut="random", rng=rng, **more)


def instances(made):
    made.file.json["nodes"] = [{"mesh": 0, "name": "a", "scale": [1, 2, -1]},
                               {"mesh": 0, "translation": [3, 0, 0], "rotation": [0, 0.6, 0, 0.8], "extras": {"k": 1}}]
    made.file.json["scenes"] = [{"nodes": [0, 1]}]


def variants(made):
    made.material(made.texture(tint=(200, 120, 60)))
    made.file.json["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b"}]}}
    made.mesh["primitives"][0]["extensions"] = {"KHR_materials_variants": {
        "mappings": [{"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]}}
    made.file.uses("KHR_materials_variants")


def box_materials(rng):
    whole = cut_box(rng)
    return several(*((some(whole, slice(16 * k, 16 * k + 16)), {"tint": tint}, {})
                     for k, tint in enumerate([(160, 80, 80), (80, 160, 80), (80, 80, 160)])), flat=FLAT)


OCTAGON = [(0.8, -1), (1, -0.8), (1, 0.8), (0.8, 1), (-0.8, 1), (-1, 0.8), (-1, -0.8), (-0.8, -1)]
L = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
HOLES = [circle(1, 1, 0.5, 12), circle(3.2, 0.9, 0.6, 9), circle(2.1, 2.2, 0.4, 16)]
kind("box_textured", lambda rng: box(), flat=FLAT)
kind("box_non_square", lambda rng: box((2, 1, 0.5)), wide=64, flat=FLAT)
kind("box_atlas", lambda rng: cut_box(rng, 3, uv=atlas), flat=FLAT)
kind("box_band", lambda rng: plus(cut_box(rng, 3, uv=band), NORMAL=lambda s: np.repeat(
    np.repeat(np.eye(3), 2, 0) * np.resize([1, -1], 6)[:, None], 54, 0).reshape(-1, 3, 3)), flat=FLAT)
kind("box_chamfered", lambda rng: prism(OCTAGON, 1.2, rng, 0.5), flat=0.9)
kind("box_instances", lambda rng: box(n=2), flat=FLAT, after=instances)
kind("variants", lambda rng: box(n=2), flat=FLAT, after=variants)
KINDS["box_materials"] = box_materials
kind("plate_l", lambda rng: prism(L, 0.4, rng, 0.33), flat=FLAT)
kind("plate_holes", lambda rng: prism([(0, 0), (4.2, 0), (4.2, 3), (0, 3)], 0.3, rng, 0.25, HOLES), flat=0.5)


def truck(rng):
    """Flat sides of odd cuts with round logos; wheels of walls and discs."""
    body = prism([(0, 0), (5, 0), (5, 2.4), (1.7, 2.4), (1.4, 1.4), (0.2, 1.2)], 1.8, rng, 0.4)
    wheels = []
    for x, z in [(1, 1.0), (4, 1.0), (1, -1.0), (4, -1.0)]:
        disc, back = (lid(circle(0, 0, 0.5, 14), height, rng, 0.9, up) for height, up in ((0.3, True), (0, False)))
        wheel = soup(disc, back, turned(lambda t: (0.5 + 0 * t, 0.3 * t), 14, 1, wraps=3))
        wheels.append({**wheel, "P": wheel["P"] * [z, 1, z] + [x, 0, z]})
    return several((body, {"tint": (170, 170, 180)}, {}), (soup(*wheels), {"tint": (60, 60, 60)}, {}), flat=0.6)


def leaves(rng):
    cards = []
    for k in range(12):
        turn, tilt = rng.uniform(0, TAU), rng.uniform(0.1, 1.0)
        a = math.cos(turn), math.sin(turn), 0
        b = -math.sin(turn) * math.sin(tilt), math.cos(turn) * math.sin(tilt), math.cos(tilt)
        cards.append(sheet(lambda s, t: [a[i] * (s - 0.5) + b[i] * t + 0.3 * k * (i == 2) for i in range(3)]))
    return several((soup(*cards), {"kind": "leaf"}, {"alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": True}), flat=FLAT)


def decal(part):
    """A second material on the same places."""
    def make(rng):
        shape = cut_box(rng)
        return several((shape, {}, {}), (some(shape, part), {"kind": "logo"}, {"alphaMode": "BLEND"}), flat=FLAT)
    return make


KINDS.update(truck=truck, leaves=leaves, decal_whole=decal(slice(None)), decal_side=decal(slice(0, 8)))


# ---------------------------------------------------------------- planes

def plane(rng, nx=4, ny=4, cut="random", jitter=0.3, point=lambda s, t: (s, t, 0 * s), uv=lambda p: p[..., :2]):
    return with_uv(sheet(point, nx=nx, ny=ny, cut=cut, rng=rng, jitter=jitter), uv)


def tilted(s, t):
    return s + 0.3 * t, 0.6 * t - 0.2 * s, 0.8 * t + 0.1 * s


def ear_plane(rng):
    return lid([(0, 0), (2, 0), (2.5, 1), (2, 2), (1.2, 1.2), (0.6, 2.2), (-0.3, 1.8), (0.3, 1)], 0, rng, 0.5)


def fan(rng):
    rim = np.array([(0, 0), *circle(0, 0, 1, 17)])
    return with_uv({"P": np.hstack([rim, np.zeros((18, 1))])[:, None]}, lambda p: 0.5 + p[..., :2] / 2)


for name, how in {
        "plane_two_triangles": {"nx": 1, "ny": 1, "cut": "right", "jitter": 0},
        "plane_alternate": {"nx": 6, "ny": 6, "cut": "alternate", "jitter": 0},
        "plane_random": {"nx": 6, "ny": 6},
        "plane_uneven": {"nx": 7, "point": lambda s, t: (s ** 3, t ** 2, 0 * s), "jitter": 0},
        "plane_tilted": {"point": tilted, "uv": lambda p: p[..., [2, 0]] * 2 - 0.5},
        "uv_outside": {"uv": lambda p: p[..., :2] * 8 - 3.25},
        "uv_far": {"uv": lambda p: p[..., :2] + [1000, -500]},
        "scale_tiny": {"point": lambda s, t: (1e-5 * s, 1e-5 * t, 0 * s), "uv": lambda p: p[..., :2] * 1e5},
        "scale_huge": {"point": lambda s, t: (1e6 * s, 1e6 * t, 0 * s), "uv": lambda p: p[..., :2] * 1e-6}}.items():
    kind(name, lambda rng, how=how: plane(rng, **how), flat=FLAT)
kind("plane_ears", ear_plane, flat=FLAT)
kind("plane_disc", fan, flat=FLAT, mode=6, order=lambda _: [0, *(1 + k % 17 for k in range(18))])
kind("texture_transform", plane, flat=FLAT,
     transform={"offset": [0.2, 0.1], "rotation": 0.5, "scale": [2, 0.5], "texCoord": 0})


def seam(turn, jitter=0.0):
    """A seam across a flat sheet: beyond it the texture lies by another map."""
    def shape(rng):
        made = plane(rng, 6, 6, jitter=jitter)
        beyond = made["P"][..., 0].mean(axis=1) > 0.5
        made["TEXCOORD_0"][beyond] = made["TEXCOORD_0"][beyond] @ np.array(turn) + [0.3, 0.1]
        return made
    return shape


def label_flat(rng):
    """On one side of a box a strip that is wider in the texture."""
    made = box(n=4)
    front = (made["P"][..., 0].min(axis=1) > 0.49) & (np.abs(made["P"][..., 1].mean(axis=1)) < 0.25)
    made["TEXCOORD_0"][front] = made["TEXCOORD_0"][front] * [2, 1] - [0.5, 0]
    return made


def degenerate(rng):
    """Some triangles have one coordinate, some a line of them, the others a map."""
    made = plane(rng, 6, 6, jitter=0)
    column = made["P"][..., 0].mean(axis=1)
    made["TEXCOORD_0"][column < 1 / 3] = [1 / 3, 0.5]
    made["TEXCOORD_0"][(column > 1 / 3) & (column < 2 / 3), :, 1] = 0.25
    return made


def mirrored_plate(rng):
    return plane(rng, 6, 3, jitter=0, point=lambda s, t: (2 * s - 1, t, 0 * s), uv=lambda p: np.abs(p[..., :2]))


def two_sided(rng):
    """A cloth whose back has the same places and a chart of its own."""
    front = plane(rng)
    back = {name: values[:, ::-1] for name, values in front.items()}
    return soup(front, plus(back, TEXCOORD_0=lambda s: [2, 0] + s["TEXCOORD_0"] * [-1, 1]))


for name, turn, jitter in (("moved", [[1, 0], [0, 1]], 0), ("turned", [[0, 1], [-1, 0]], 0.3),
                           ("scaled", [[2, 0], [0, 2]], 0.3), ("mirrored", [[-1, 0], [0, 1]], 0),
                           ("stretched", [[3, 0], [0, 1]], 0)):
    kind(f"seam_{name}", seam(turn, jitter), flat=FLAT)
kind("uv_degenerate", degenerate, flat=FLAT)
kind("label_flat", label_flat, flat=FLAT)
kind("mirrored_plate", lambda rng: apart(mirrored_plate(rng), lambda s: s["P"][..., 0].mean(axis=1) > 0), flat=FLAT)
kind("mirrored_plate_shared", mirrored_plate, flat=FLAT)
kind("two_sided", two_sided, flat=FLAT, recorded=True)


# ---------------------------------------------------------------- round things

def around(wraps=1.0, start=0.0, height=1.0, name="TEXCOORD_0"):
    """The isometric map of a cylinder, off by whole turns."""
    def truth(p):
        turn = np.arctan2(p[:, 1], p[:, 0]) / TAU - start
        return np.stack([turn * wraps, p[:, 2] / height], -1), np.abs(np.hypot(p[:, 0], p[:, 1]) - 1) < 0.2
    return (0, name, truth, np.array([wraps, 0]))


def strip(rng):
    places = np.array([(k / 20, t) for k in range(21) for t in (1, 0)])
    angle = places[:, 0] % 1 * TAU
    return {"P": np.stack([np.cos(angle), np.sin(angle), places[:, 1]], -1)[:, None], "TEXCOORD_0": places[:, None]}


def rolled_off(angle, z):
    s, r = angle / math.hypot(1, 2), (2 - z) / 2
    return np.stack([r * np.cos(s), r * np.sin(s)], -1)


def cone_truth(p):
    angle = np.arctan2(p[:, 1], p[:, 0]) % TAU
    return rolled_off(angle, p[:, 2]), (p[:, 2] < 1.7) & (np.abs(angle - math.pi) < 2.9)


def cone(rng):
    made = turned(lambda t: (1 - 0.8 * t, 1.6 * t), 18, 4)
    return plus(made, TEXCOORD_0=lambda s: rolled_off(s["TEXCOORD_0"][..., 0] * TAU, s["P"][..., 2]))


def sphere_truth(p):
    b = np.arcsin(np.clip(p[:, 2] / np.linalg.norm(p, axis=1), -1, 1))
    return np.stack([np.arctan2(p[:, 1], p[:, 0]) / TAU, b / math.pi + 0.5], -1), np.abs(p[:, 2]) < 0.7


def duck(x, y, z):
    head = np.exp(-6 * ((x - 0.8) ** 2 + y ** 2 + (z - 0.9) ** 2))
    return 1.3 * x + 0.5 * head, 0.9 * y, 0.8 * z + 0.9 * head


def torus(s, t):
    a, b = s % 1 * TAU, t % 1 * TAU
    return (1 + 0.4 * np.cos(b)) * np.cos(a), (1 + 0.4 * np.cos(b)) * np.sin(a), 0.4 * np.sin(b)


def mirrored(own):
    """Half a head, and its mirror with the same coordinates; `own`: with indices of its own along the axis."""
    def half(s, t):
        a, b = s * math.pi / 2, (t - 0.5) * 2.6
        return np.cos(b) * np.cos(a) * (1.2 + 0.3 * np.sin(3 * t)), np.cos(b) * np.sin(a), 1.3 * np.sin(b)

    def shape(rng):
        right = sheet(half, lambda s, t: (s, t), 6, 8)
        left = {"P": right["P"][:, ::-1] * [1, -1, 1] + 0.0, "TEXCOORD_0": right["TEXCOORD_0"][:, ::-1]}
        both = soup(right, left)
        return apart(both, lambda s: np.arange(len(s["P"])) < len(right["P"])) if own else both
    return shape


def label(rng):
    """A part of a round wall has another material and chart."""
    whole = wall()
    front = (whole["TEXCOORD_0"][..., 0].mean(axis=1) * 16 // 4) == 1
    other = plus(some(whole, front), TEXCOORD_0=lambda s: (s["TEXCOORD_0"] - [0.25, 0]) * [4, 1])
    return several((some(whole, ~front), {}, {}), (other, {"kind": "logo"}, {}), truths=[around()])


def bumpy(made):
    made.file.json["materials"][0]["normalTexture"] = {"index": made.texture("normal")}


def terrain(rng):
    return sheet(lambda s, t: (s, t, 0.08 * np.sin(6 * s + 1) * np.cos(8 * t)), nx=14, ny=14, cut="random", rng=rng)


def caps(rng):
    lids = (lid(circle(0, 0, 1, 16), z, rng, 0.5, z == 1) for z in (0, 1))
    return soup(wall(m=2), *lids)


STILL = np.array([0, 0])
kind("cylinder", lambda rng: wall(), truths=[around()])
kind("cylinder_wraps", lambda rng: wall(24, 2, wraps=3.0, cut="alternate"), truths=[around(3.0)])
kind("cylinder_uneven", lambda rng: wall(14, 4, 2.0, rng=rng, jitter=0.3, cut="random"), truths=[around(height=2.0)])
kind("cylinder_caps", caps, flat=0.2)
kind("cylinder_strip", strip, truths=[around()], mode=5, order=lambda _: range(42))
kind("cone", cone, truths=[(0, "TEXCOORD_0", cone_truth, STILL)])
kind("cone_tip", lambda rng: turned(lambda t: (1 - t, 2 * t), 12, 3))
kind("sphere", lambda rng: ball(24, 12), truths=[(0, "TEXCOORD_0", sphere_truth, np.array([1, 0]))])
kind("sphere_six_charts", lambda rng: plus(box(n=4), P=lambda s: s["P"] / np.linalg.norm(s["P"], axis=-1, keepdims=True)))
kind("duck", lambda rng: ball(18, 12, point=duck))
kind("torus", lambda rng: sheet(torus, lambda s, t: (4 * s, t), 16, 9))
kind("terrain", terrain, truths=[(0, "TEXCOORD_0", lambda p: (p[:, :2], np.full(len(p), True)), STILL)])
# One map for both halves is flat at their axis, where the texture is a roof.
kind("mirrored_shared", mirrored(False), slack=0.1)
kind("mirrored_own", mirrored(True))
kind("normal_map", lambda rng: plus(wall(), NORMAL=lambda s: s["P"] * [1, 1, 0], TANGENT=lambda s: np.concatenate(
    [s["P"][..., [1, 0]] * [-1, 1], 0 * s["P"][..., :1], 0 * s["P"][..., :1] - 1], -1)), truths=[around()], after=bumpy)
KINDS["label"] = label


# ---------------------------------------------------------------- sets of coordinates, and how numbers are stored

def three_sets(rng):
    return plus(plane(rng), **{f"TEXCOORD_{k}": lambda s, m=m: s["P"][..., :2] @ np.array(m)
                               for k, m in enumerate([((1, 0), (0, 1)), ((2, 1), (-1, 2)), ((0, -3), (3, 0.5))])})


def two_seams(rng):
    """A cylinder whose sets begin a quarter of a turn apart."""
    def later(s):
        first = s["TEXCOORD_0"][..., :1].mean(axis=1, keepdims=True) < 0.25
        return s["TEXCOORD_0"] + np.where(first, 0.75, -0.25) * [1, 0]
    return plus(wall(), TEXCOORD_1=later)


def lightmap(rng):
    """A room whose second set has charts of its own, two of them on each lid."""
    def charts(s):
        k = np.arange(len(s["P"])) // 2
        return s["TEXCOORD_0"] / 20 + np.stack([k % 4 / 4, k // 4 / 4], -1)[:, None]
    room = plus(prism([(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)], 1.5, rng), TEXCOORD_1=charts)
    return several((room, {}, {"occlusionTexture": {"index": 0, "texCoord": 1, "strength": 0.7}}), flat=FLAT)


def steps(count):
    """Coordinates that whole numbers up to `count` have exactly."""
    return lambda rng: plane(rng, 5, 5, jitter=0, uv=lambda p: np.rint(p[..., :2] * 5) * (count // 5) / count)


kind("multi_uv", three_sets, set=1, flat=FLAT)
kind("two_seams", two_seams, truths=[around(), around(1.0, 0.25, name="TEXCOORD_1")])
KINDS["lightmap"] = lightmap
kind("uv_u16", steps(65535), kinds={"TEXCOORD_0": gltf.USHORT}, flat=FLAT)
kind("uv_u8", steps(255), kinds={"TEXCOORD_0": gltf.UBYTE}, flat=FLAT)
kind("uv_u8_round", lambda rng: ball(16, 8), kinds={"TEXCOORD_0": gltf.UBYTE}, slack=0.1)
kind("sparse", plane, layout="sparse", flat=FLAT)
kind("interleaved", cut_box, layout="interleaved", flat=FLAT)
kind("corners_apart", lambda rng: plus(cut_box(rng), split=lambda s: np.arange(s["P"].size / 3).reshape(-1, 3, 1)),
     flat=FLAT)


# ---------------------------------------------------------------- colours, ids, morphs, skins

def opaque(values):
    return np.concatenate([values, np.ones_like(values[..., :1])], -1)


def per_face(rng, count):
    """A colour for each run of triangles."""
    def values(s):
        faces = len(s["P"]) // count
        drawn = rng.integers(0, 2, (faces, 3)) * 0.75 + rng.integers(0, 2, (faces, 1)) * 0.25
        return np.repeat(np.repeat(drawn[:, None, :], 3, 1), count, 0)
    return values


def half_faded(s):
    """One colour up to a line, beyond it another that fades."""
    x = s["P"][..., :1]
    return np.where((x.mean(axis=1) > 0.5)[:, None], np.concatenate([x, 1 - x, 0.2 + 0 * x], -1), [0.9, 0.1, 0.1])


IDS = [3, 77, 1000, 40000]


def ids_of_faces(rng):
    """One for both triangles of a quad."""
    return plus(cut_box(rng, 3), _FEATURE_ID_0=lambda s: rng.choice(IDS, len(s["P"]) // 2).repeat(6).reshape(-1, 3, 1))


def ids_of_vertices(rng):
    def values(s):
        places, which = np.unique(s["P"].reshape(-1, 3), axis=0, return_inverse=True)
        return rng.choice(IDS, len(places))[which.reshape(-1)].reshape(-1, 3, 1)
    return plus(ball(12, 7), _FEATURE_ID_0=values)


def features(made):
    made.mesh["primitives"][0]["extensions"] = {"EXT_mesh_features": {"featureIds": [{"featureCount": 4, "attribute": 0}]}}
    made.file.uses("EXT_mesh_features")


def swollen(made):
    made.mesh["weights"] = [0.6] * len(made.mesh["primitives"][0]["targets"])


def skinned(made):
    document, lower = made.file.json, np.eye(4)
    lower[3, 1] = -0.5
    document["nodes"] = [{"mesh": 0, "skin": 0}, {"name": "root", "children": [2]}, {"translation": [0, 0.5, 0]}]
    document["scenes"] = [{"nodes": [0, 1]}]
    matrices = made.file.add([tuple(np.eye(4).ravel()), tuple(lower.ravel())])
    document["skins"] = [{"joints": [1, 2], "inverseBindMatrices": matrices}]


def affine_colours(s):
    return opaque(s["P"] @ np.array([[0.6, 0.2, 0.1], [0.3, 0.1, 0.8], [0, 0, 0]]))


kind("colours_affine", lambda rng: plus(plane(rng, 5, 5), COLOR_0=affine_colours, _HEAT=lambda s: s["P"][..., :1] * 40 - 7),
     flat=FLAT)
kind("colours_half", lambda rng: plus(plane(rng, 6, 4, jitter=0), COLOR_0=half_faded), flat=FLAT)
kind("colours_bytes", lambda rng: plus(ball(14, 8), COLOR_0=lambda s: np.rint(127.5 + 127.5 * s["P"]) / 255),
     kinds={"COLOR_0": gltf.UBYTE})
kind("colours_faces", lambda rng: plus(box(n=3), COLOR_0=per_face(rng, 2)), plain=("COLOR_0",), flat=FLAT)
kind("colours_faces_round", lambda rng: plus(ball(10, 6, cut="right"), COLOR_0=per_face(rng, 1)), plain=("COLOR_0",))
kind("feature_ids", ids_of_faces, kinds={"_FEATURE_ID_0": gltf.USHORT}, plain=("_FEATURE_ID_0",), flat=FLAT, after=features)
kind("feature_ids_vertices", ids_of_vertices, kinds={"_FEATURE_ID_0": gltf.USHORT}, plain=("_FEATURE_ID_0",))
kind("morph_uv", plane, flat=FLAT, after=swollen, targets=[
    {"POSITION": lambda v: v["P"][:, [2, 2, 0]] * 0.5, "TEXCOORD_0": lambda v: v["P"][:, :2] @ [[0.3, 0.2], [-0.4, 0.1]]},
    {"POSITION": lambda v: 0 * v["P"], "TEXCOORD_0": lambda v: 0 * v["P"][:, :2] + [0.25, 0]}])
kind("morph_colour", lambda rng: plus(cut_box(rng), COLOR_0=lambda s: opaque(0.2 + 0 * s["P"])), flat=FLAT, after=swollen,
     targets=[{"POSITION": lambda v: v["P"] * [0, 0, 0.5], "COLOR_0": lambda v: opaque(0.5 + v["P"]) * [1, 1, 1, 0]}])
kind("skinned_cloth", lambda rng: plus(
    plane(rng, 6, 6), JOINTS_0=lambda s: np.zeros(s["P"].shape[:2] + (4,)) + [0, 1, 0, 0],
    WEIGHTS_0=lambda s: s["P"][..., 1:2] * [-1, 1, 0, 0] + [1, 0, 0, 0]), kinds={"JOINTS_0": gltf.UBYTE}, flat=FLAT,
     after=skinned)

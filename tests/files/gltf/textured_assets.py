#!/usr/bin/env python3
"""textured_assets.py PLANISH [--short] [--only PATTERN] [--keep FOLDER] [--pictures FOLDER]: makes textured assets after
kinds of the Khronos sample assets, has `planish fit` make surfaces of them without flags and at levels 0 and 2, and
measures whether what rides on them lies where it lay. One line an asset, the worst of its surfaces:

  flat      the share of the surface on planes that end at sharp edges, where attributes are affine
  affine    how far they are off the same affine functions there; of ext.: in parts of what they change by on that plane
  truth     how far coordinates are off the isometric map of a round shape, in parts of the chart; faces': those of the
            given flat triangles
  seam      how far a chart's border is off its own in the texture where it is straight on the surface; bent: where it is
            not, in parts of the chart
  slide     how far attributes are off those of the nearest place of the given faces, in parts of the chart
  hull      how far coordinates leave their chart's hull, in parts of the chart
  beyond    how far colours and numbers leave the range of those given
  folds, blend: triangles folded in the texture, values of ids and faces' colours that nobody gave

What else is a fault: given vertices whose values are not the same to the bit, charts or open borders that are more or
fewer, tangents off their texture, materials, textures, nodes or images that are not as they were. Outputs that are
broken on purpose must be found, kind by kind. Ends with the number of faults, with 77 where numpy is missing."""
import argparse
import base64
import copy
import fnmatch
import functools
import http.server
import pathlib
import subprocess
import sys
import tempfile
import threading
import zlib
from concurrent.futures import ThreadPoolExecutor

try:
    import numpy as np
except ImportError:
    print("no numpy: install python3-numpy")
    sys.exit(77)

import check_asset
from textured_kinds import KINDS
from textured_measures import File, measure

LEVELS = {"auto": [], "0": ["--levels", "0"], "2": ["--levels", "2"]}
# Those of ctest, half a minute together.
SHORT = ("box_atlas", "box_band", "colours_affine", "colours_faces", "colours_half", "cylinder_caps", "cylinder_wraps",
         "decal_side", "feature_ids", "label", "lightmap", "mirrored_plate_shared", "morph_uv", "multi_uv", "normal_map",
         "plane_random", "plate_l", "seam_stretched", "seam_turned", "skinned_cloth", "terrain", "uv_degenerate", "uv_u8",
         "variants")
COLUMNS = {  # figure: its head
    "vertices": "vertices", "flat": "flat", "affine": "affine", "affine_share": "of ext.", "truth": "truth",
    "truth_flat": "faces'", "seam": "seam", "seam_bent": "bent", "slide": "slide", "hull": "hull", "beyond": "beyond",
    "folds": "folds", "blended": "blend"}
# Pictures: those that are drawn unless others are named; from where, with z up if nothing else is said.
DRAWN = ("truck", "colours_faces_round", "decal_side", "morph_colour", "cylinder_caps", "mirrored_own")
FROM = {"truck": ((0.5, 0.35, 1), (0, 1, 0)), "mirrored_own": ((1, -0.2, 0.3), (0, 0, 1)),
        "label": ((0.4, 1, 0.4), (0, 0, 1)), "seam_stretched": ((0, 0, 1), (0, 1, 0)),
        "colours_half": ((0, 0, 1), (0, 1, 0))}


def make(name):
    return KINDS[name](np.random.default_rng(zlib.crc32(name.encode())))


def fit(command, path, out, flags=()):
    call = [command, "fit", path, "-o", out, "--force", *flags]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr.strip()}")
    return File(out.read_bytes())


def run(command, name, folder):
    """The asset, its faults with the levels that have them, and the worst of its figures."""
    asset = make(name)
    path = folder / f"{name}.glb"
    path.write_bytes(asset.bytes())
    before = File(path.read_bytes())
    faults, figures = {}, {}
    for level, flags in LEVELS.items():
        try:
            after = fit(command, path, folder / f"{name}_{level}.glb", flags)
            found, said = measure(asset, before, after)
            if level == "auto":
                said["vertices"] = sum(len(p.place) for p in after.parts)
        except Exception as error:  # what no check expected is a fault, too
            found, said = [f"{type(error).__name__}: {error}"], {}
        for fault in found:
            faults.setdefault(fault, []).append(level)
        for key, value in said.items():
            figures[key] = (min if key == "flat" else max)(value, figures.get(key, value))
    return asset, faults, figures


def cell(figures, key):
    value = figures.get(key)
    if value is None:
        return "-"
    if key in ("vertices", "folds", "blended"):
        return f"{value:.0f}"
    return f"{value:.1e}" if 0 < value < 0.01 else f"{value:.3g}"


# ---------------------------------------------------------------- what is broken must be found

def changed(name, change):
    """A breaking of an attribute of the first primitive."""
    def of(file):
        part = file.parts[0]
        part.values[name] = change(part.values[name].copy(), part)
    return of


def at(rows, by):
    """Adds to chosen rows: rows(part) says which."""
    def change(values, part):
        values[rows(part)] += by
        return values
    return change


def inner(part):
    """A vertex in the middle, which is none of the given ones at level 2."""
    return [int(np.linalg.norm(part.place - part.place.mean(0) - 0.02, axis=1).argmin())]


def torn(file):
    """Vertices of their own for one triangle, whose coordinates are elsewhere."""
    part = file.parts[0]
    k = len(part.place)
    corners = part.triangles[10].copy()
    part.place = np.concatenate([part.place, part.place[corners]])
    part.values = {n: np.concatenate([v, v[corners] + (n == "TEXCOORD_0") * 0.25]) for n, v in part.values.items()}
    part.triangles[10] = [k, k + 1, k + 2]


def without_triangle(file):
    file.parts[0].triangles = np.delete(file.parts[0].triangles, 40, axis=0)


def crack(file):
    file.parts[0].place[17] += 1e-5


def bulged(file):
    file.parts[0].place[:, 2] += 0.05 * np.sin(3 * file.parts[0].place[:, 0])


def flag(key, value):
    def of(file):
        file.glb.document[key] = value
    return of


def image(file):
    view = file.glb.document["bufferViews"][file.glb.document["images"][0]["bufferView"]]
    offset = view.get("byteOffset", 0) + 50
    file.glb.binary = file.glb.binary[:offset] + b"?" + file.glb.binary[offset + 1:]


def moves(name, by):
    return changed(name, lambda v, _: v + by)


def next_number(values, _):
    return np.nextafter(values.astype(np.float32), np.float32(9)).astype(float)


def another_id(values, part):
    k = inner(part)
    values[k] = 77 + 923 * (values[k] == 77)
    return values


def flip_inner(values, part):
    values[inner(part)] = values.mean(0) + 0.4
    return values


BROKEN = [  # asset, what is done to its surface at level 2, what must be said
    ("plane_random", changed("TEXCOORD_0", next_number), "lost of"),
    ("plane_random", changed("TEXCOORD_0", at(lambda _: [0], 1e-7)), "foreign of"),
    ("plane_random", changed("TEXCOORD_0", at(inner, 1e-5)), "affine of TEXCOORD_0"),
    ("plane_random", changed("TEXCOORD_0", lambda v, _: v[:, ::-1].copy()), "affine of TEXCOORD_0"),
    ("plane_random", changed("TEXCOORD_0", flip_inner), "folds of"),
    ("plane_random", torn, "charts of"),
    ("plane_random", without_triangle, "open borders"),
    ("box_atlas", crack, "open borders"),
    ("plane_random", bulged, "lies flat"),
    ("plane_random", flag("materials", []), "materials changed"),
    ("plane_random", flag("nodes", []), "nodes changed"),
    ("plane_random", image, "images changed"),
    ("plane_random", lambda file: file.parts[0].values.pop("TEXCOORD_0"), "TEXCOORD_0 missing"),
    ("plane_random", lambda file: file.parts.append(file.parts[0]), "2 primitives"),
    ("decal_side", lambda file: file.parts.pop(), "1 primitives"),
    ("multi_uv", changed("TEXCOORD_2", at(inner, 1e-4)), "affine of TEXCOORD_2"),
    ("morph_uv", changed("TEXCOORD_0@1", at(inner, 1e-4)), "affine of TEXCOORD_0@1"),
    ("skinned_cloth", changed("WEIGHTS", at(inner, 0.1)), "joints of WEIGHTS"),
    ("colours_affine", changed("COLOR_0", at(inner, 1e-4)), "affine of COLOR_0"),
    ("colours_affine", moves("COLOR_0", 0.1), "beyond of COLOR_0"),
    ("colours_affine", moves("_HEAT", 4), "beyond of _HEAT"),
    ("box_atlas", changed("TEXCOORD_0", lambda v, p: v + 0.003 * (np.abs(p.place).max(1) > 0.499)[:, None]), "seam of"),
    ("cylinder_caps", changed("TEXCOORD_0", lambda v, p: v + 0.2 * (p.place[:, 2:] % 1 == 0)), "seam_bent of"),
    ("cylinder_wraps", changed("TEXCOORD_0", lambda v, p: v + 0.02 * np.sin(9 * p.place[:, :1])), "truth of"),
    ("cylinder_wraps", moves("TEXCOORD_0", [0.4, 0]), "hull of"),
    ("terrain", changed("TEXCOORD_0", lambda v, _: v[:, ::-1].copy()), "slide of"),
    ("feature_ids", changed("_FEATURE_ID_0", at(inner, 1)), "blended of"),
    ("feature_ids", changed("_FEATURE_ID_0", another_id), "mixed of"),
    ("feature_ids", changed("_FEATURE_ID_0", lambda v, _: 0 * v + 77), "area of"),
    ("colours_faces", changed("COLOR_0", lambda v, _: v * 0.999), "blended of COLOR_0"),
    ("normal_map", changed("TANGENT", lambda v, _: v * [1, 1, 1, -1]), "tangents are wrong"),
    ("variants", lambda file: file.glb.document["meshes"][0]["primitives"][0].pop("extensions"), "extensions of primitives"),
]


def prove(command, folder):
    """How many of the broken outputs are not found."""
    missed = 0
    for name, change, words in BROKEN:
        asset, path = make(name), folder / f"{name}.glb"
        path.write_bytes(asset.bytes())
        out = folder / f"{name}_2.glb"
        after = File(out.read_bytes()) if out.exists() else fit(command, path, out, LEVELS["2"])
        after = copy.deepcopy(after)
        change(after)
        for part in after.parts:
            part.renew()
        faults = measure(asset, File(path.read_bytes()), after)[0]
        if not any(words in fault for fault in faults):
            missed += 1
            print(f"NOT FOUND: {name}, broken so that it should say '{words}': {faults}")
    print(f"{len(BROKEN)} broken outputs, {missed} not found")
    return missed


# ---------------------------------------------------------------- pictures

def draw(command, names, folder, pictures):
    """Each asset as it is given, in flat triangles, and beside it its surface, by three.js."""
    if not (check_asset.MODULES / "three").is_dir():
        return check_asset.missing("three.js", "PLANISH_REQUIRE_NODE")
    if check_asset.browser.find() is None:
        return check_asset.missing("browser", "PLANISH_REQUIRE_BROWSER")
    handler = functools.partial(check_asset.Handler, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    pictures.mkdir(parents=True, exist_ok=True)
    with check_asset.browser.Browser(check_asset.browser.SOFTWARE_GL) as chromium:
        tab = chromium.open(f"http://127.0.0.1:{server.server_port}/draw_asset.html", size=(1240, 620))
        tab.wait("document.documentElement.dataset.ready")
        for name in names:
            path = folder / f"{name}.glb"
            path.write_bytes(make(name).bytes())
            fit(command, path, folder / f"{name}_auto.glb")
            look = FROM.get(name, ((1, -0.6, 0.8), (0, 0, 1)))
            found = tab.evaluate(f"pair(['{name}.glb', '{name}_auto.glb'], {list(look[0])}, {list(look[1])})")
            (pictures / f"{name}.png").write_bytes(base64.b64decode(found.partition(",")[2]))
    server.shutdown()
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", type=pathlib.Path)
    parser.add_argument("--short", action="store_true", help="a part of the assets, within a minute")
    parser.add_argument("--only", help="assets by a pattern as of a shell; nothing is broken on purpose")
    parser.add_argument("--keep", type=pathlib.Path, help="folder in which the files stay")
    parser.add_argument("--pictures", type=pathlib.Path, help="only draws six assets, or those of --only, before and after")
    given = parser.parse_args()
    command = given.command.resolve()
    names = [n for n in KINDS if (n in SHORT or not given.short) and fnmatch.fnmatch(n, given.only or "*")]
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        if given.pictures:
            return draw(command, names if given.only else DRAWN, folder, given.pictures)
        total = 0
        print(f"{'asset':21}" + "".join(f"{head:>9}" for head in COLUMNS.values()))
        with ThreadPoolExecutor(2) as pool:
            for name, (asset, faults, figures) in zip(names, pool.map(lambda n: run(command, n, folder), names)):
                word = "ok" if not faults else "recorded" if asset.recorded else "FAULT"
                print(f"{name:21}" + "".join(f"{cell(figures, key):>9}" for key in COLUMNS), word, flush=True)
                for fault, levels in faults.items():
                    print(f"    level {', '.join(levels)}: {fault}")
                total += word == "FAULT"
        print(f"{len(names)} assets, {total} with faults")
        if not given.only:
            total += prove(command, folder)
    return min(total, 76)


if __name__ == "__main__":
    sys.exit(main())

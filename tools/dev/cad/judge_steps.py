#!/usr/bin/env python3
"""Holds STEP files to the parts of make_parts.py that they were made from, with OpenCASCADE through FreeCAD.

    judge_steps.py TRUTH_FOLDER STEP_FOLDER [--filter WORD] [--json FILE]

A STEP file is named as the triangulation: a_box.fine.step is held to a_box.step of TRUTH_FOLDER, n_a_box.fine.step, too. Prints a row for
each and totals by chord error and half, and writes all figures as JSON. README.md beside it explains the columns.
"""

import argparse
import json
import math
import os
import resource
import signal
import subprocess
import sys
import time

import numpy as np

LEVELS = ("coarse", "medium", "fine")
KINDS = {"Plane": "plane", "Cylinder": "cylinder", "Cone": "cone", "Sphere": "sphere", "Toroid": "torus"}
CURVED = ("cylinder", "cone", "sphere", "torus")
POINTS = 2000  # samples of a STEP file's faces
TRUTH_POINTS = 60000  # samples of the truth, which say which of its faces are near
SLACK = 1e-4  # of the diagonal: faces of the truth that are this much further away than the nearest count as nearest, too
EXACT = 60  # samples whose distance from the truth OpenCASCADE computes
SECONDS = 120  # of CPU that a file may take: a machine that is busy otherwise changes no figure


# --- surfaces by formula -----------------------------------------------------------------------------------------------------------------


def vector(v):
    return np.array([v.x, v.y, v.z])


class Surface:
    """The unbounded surface of a face: distances of points and their nearest points, shapes (n, 3)."""

    def __init__(self, face):
        surface = self.surface = face.Surface
        self.name = type(surface).__name__
        self.kind = KINDS.get(self.name, "other")
        self.sizes = {}
        if self.kind == "plane":
            self.centre, self.axis = vector(surface.Position), vector(surface.Axis)
        elif self.kind == "cone":
            self.centre, self.axis, self.angle = vector(surface.Apex), vector(surface.Axis), abs(surface.SemiAngle)
            self.sizes = {"half_angle": self.angle}
        elif self.kind == "cylinder":
            self.centre, self.axis, self.sizes = vector(surface.Center), vector(surface.Axis), {"radius": surface.Radius}
        elif self.kind == "sphere":
            self.centre, self.sizes = vector(surface.Center), {"radius": surface.Radius}
        elif self.kind == "torus":
            self.centre, self.axis = vector(surface.Center), vector(surface.Axis)
            self.sizes = {"major": surface.MajorRadius, "minor": surface.MinorRadius}

    def nearest(self, points):
        """The nearest point of the surface for each point."""
        if self.kind == "other":
            return np.array([self.nearest_freeform(p) for p in points]).reshape(-1, 3)
        away = points - self.centre
        if self.kind == "sphere":
            return self.centre + self.sizes["radius"] * unit(away)
        height = away @ self.axis
        if self.kind == "plane":
            return points - height[:, None] * self.axis
        radial = away - height[:, None] * self.axis
        if self.kind == "cylinder":
            return points - radial + self.sizes["radius"] * unit(radial)
        if self.kind == "torus":
            ring = self.centre + self.sizes["major"] * unit(radial)
            return ring + self.sizes["minor"] * unit(points - ring)
        side = np.where(height < 0, -1.0, 1.0)  # a cone's surface runs on beyond its apex
        along = np.abs(height) * math.cos(self.angle) + np.linalg.norm(radial, axis=1) * math.sin(self.angle)
        return self.centre + along[:, None] * (
            (side * math.cos(self.angle))[:, None] * self.axis + math.sin(self.angle) * unit(radial))

    def nearest_freeform(self, point):
        import FreeCAD
        try:
            u, v = self.surface.parameter(FreeCAD.Vector(*point))
            return vector(self.surface.value(u, v))
        except Exception:  # the kernel throws what it likes
            return np.full(3, np.inf)

    def distance(self, points):
        return np.linalg.norm(points - self.nearest(points), axis=1)

    def size_error(self, truth):
        """The largest relative difference of radii and angles from another surface of the kind."""
        return max((abs(self.sizes[key] / truth.sizes[key] - 1) for key in self.sizes), default=0.0)


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


# --- samples -----------------------------------------------------------------------------------------------------------------------------


def sample(face, surface, count, deflection, draw, snap=True):
    """Points spread evenly over a face; fewer or none where the kernel finds no triangles."""
    try:
        places, triples = face.tessellate(deflection)
    except Exception:
        return np.zeros((0, 3))
    if not triples:
        return np.zeros((0, 3))
    corners = np.array([vector(p) for p in places])[np.array(triples)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return np.zeros((0, 3))
    marks = (np.arange(count) + draw.rand(count)) / count * areas.sum()
    chosen = np.minimum(np.searchsorted(np.cumsum(areas), marks), len(areas) - 1)
    a, b = np.sqrt(draw.rand(count))[:, None], draw.rand(count)[:, None]
    points = corners[chosen, 0] * (1 - a) + corners[chosen, 1] * (a * (1 - b)) + corners[chosen, 2] * (a * b)
    if snap:
        points = surface.nearest(points)
        points = points[np.isfinite(points).all(axis=1)]
    return points


def shares(areas, total, least):
    """How many samples each face gets: by area, at least `least` each; with very many faces some get none."""
    areas = np.maximum(np.array(areas, dtype=float), 0)
    if len(areas) * least > total:
        marks = (np.arange(total) + 0.5) / total * areas.sum()
        return np.bincount(np.minimum(np.searchsorted(np.cumsum(areas), marks), len(areas) - 1), minlength=len(areas))
    return np.maximum(np.round(areas / areas.sum() * total).astype(int), least)


class Truth:
    """The faces of the true shape, found by nearness."""

    def __init__(self, shape, diagonal):
        from scipy.spatial import cKDTree
        draw = np.random.RandomState(1)
        self.shape, self.diagonal = shape, diagonal
        self.surfaces = [Surface(face) for face in shape.Faces]
        points, owners = [], []
        counts = shares([face.Area for face in shape.Faces], TRUTH_POINTS, 60)
        for i, face in enumerate(shape.Faces):
            free = self.surfaces[i].kind == "other"
            found = sample(face.copy(), self.surfaces[i], counts[i], diagonal * (1e-4 if free else 5e-4), draw, snap=not free)
            points.append(found)
            owners.append(np.full(len(found), i))
        self.owners = np.concatenate(owners)
        self.tree = cKDTree(np.concatenate(points))

    def near(self, points):
        """For each point the distances (n, faces) from the near faces' surfaces, infinite for the others, and from the nearest sample."""
        gaps, rows = self.tree.query(points, k=24)
        distances = np.full((len(points), len(self.surfaces)), np.inf)
        owners = self.owners[rows]
        for i in np.unique(owners):
            have = np.nonzero((owners == i).any(axis=1))[0]
            distances[have, i] = self.surfaces[i].distance(points[have])
        return distances, gaps[:, 0]

    def exact_distance(self, point):
        import FreeCAD
        import Part
        return self.shape.distToShape(Part.Vertex(FreeCAD.Vector(*point)))[0]


# --- one file ----------------------------------------------------------------------------------------------------------------------------


def say(figures):
    """The process that started this one keeps the last line if the time is up."""
    print("JSON " + json.dumps(figures), flush=True)


def judge_faces(shape, truth, true_areas):
    """How much of the area is of the right kind, and how well sizes and places agree."""
    draw = np.random.RandomState(2)
    faces = shape.Faces
    areas = [face.Area for face in faces]
    counts = shares(areas, POINTS, 4)
    by_kind = {}
    points, weights, owners, surfaces = [], [], [], []
    lost = 0.0
    for i, face in enumerate(faces):
        surface = Surface(face)
        surfaces.append(surface)
        entry = by_kind.setdefault(surface.kind, {"faces": 0, "area": 0.0})
        entry["faces"] += 1
        entry["area"] += areas[i]
        if counts[i] == 0:
            continue
        found = sample(face, surface, counts[i], truth.diagonal * 1e-3, draw)
        if len(found) == 0:
            lost += areas[i]
            continue
        points.append(found)
        weights.append(np.full(len(found), areas[i] / len(found)))
        owners.append(np.full(len(found), i))
    points, weights, owners = np.concatenate(points), np.concatenate(weights), np.concatenate(owners)
    distances, gaps = truth.near(points)
    least = distances.min(axis=1)
    close = distances <= least[:, None] + SLACK * truth.diagonal
    kinds = np.array([surface.kind for surface in truth.surfaces])
    mine = np.array([surface.kind for surface in surfaces])[owners]
    fits = close & (kinds[None, :] == mine[:, None])
    right = fits.any(axis=1)
    theirs = np.where(right, mine, kinds[distances.argmin(axis=1)])
    total = weights.sum() + lost
    errors = {}
    all_errors = np.full(len(points), np.nan)
    for n in np.nonzero(right & np.isin(mine, CURVED))[0]:
        all_errors[n] = min(surfaces[owners[n]].size_error(truth.surfaces[i]) for i in np.nonzero(fits[n])[0])
    for kind in CURVED:
        has = all_errors[(mine == kind) & right]
        if len(has):
            errors[kind] = {"max": has.max(), "median": float(np.median(has)), "p90": float(np.percentile(has, 90))}
    # The formulas know no borders of faces, and a near face may have been missed: the kernel settles the doubtful ones.
    for n in {*np.argsort(-gaps, kind="stable")[:EXACT // 2], *np.argsort(-least, kind="stable")[:EXACT // 2]}:
        least[n] = truth.exact_distance(points[n])
    curved = np.isin(theirs, CURVED)
    known = all_errors[~np.isnan(all_errors)]
    confusion = {}
    for a in np.unique(theirs):
        for b in np.unique(mine):
            share = weights[(theirs == a) & (mine == b)].sum() / total
            if share > 0 and a != b:
                confusion["%s as %s" % (a, b)] = float(share)
    have = sum(entry["area"] for entry in by_kind.values())
    return {
        "kinds": by_kind,
        "surface_types": {name: sum(s.name == name for s in surfaces) for name in sorted({s.name for s in surfaces})},
        "share_by_area": sum(min(by_kind.get(k, {"area": 0})["area"], a) for k, a in true_areas.items()) / max(sum(true_areas.values()), have),
        "share_right": float(weights[right].sum() / total),
        "share_curved_right": float(weights[curved & right].sum() / weights[curved].sum()) if curved.any() else None,
        "share_false": float(weights[~right & (mine != "other")].sum() / total),
        "confusion": confusion,
        "share_without_samples": lost / total,
        "size_errors": errors,
        "size_error_max": float(known.max()) if len(known) else None,
        "size_error_median": float(np.median(known)) if len(known) else None,
        "distance_max": float(least.max() / truth.diagonal),
        "distance_rms": float(np.sqrt((weights * least**2).sum() / weights.sum()) / truth.diagonal),
    }


def judge_cut(shape, volume):
    """Cuts by a box that takes a bit less than half of the longest side: are both pieces valid, and are they the whole?"""
    import FreeCAD
    import Part
    bounds = shape.BoundBox
    size = [bounds.XLength, bounds.YLength, bounds.ZLength]
    low = [bounds.XMin, bounds.YMin, bounds.ZMin]
    margin = bounds.DiagonalLength * 0.1
    extent = [length + 2 * margin for length in size]
    longest = size.index(max(size))
    extent[longest] = size[longest] * 0.4873 + margin
    tool = Part.makeBox(*extent, FreeCAD.Vector(*[place - margin for place in low]))
    first, second = shape.common(tool), shape.cut(tool)
    off = abs(first.Volume + second.Volume - volume) / abs(volume)
    valid = bool(first.isValid() and second.isValid() and first.Solids and second.Solids)
    return {"cut_valid": valid, "cut_volume_off": off, "cut_good": bool(valid and off < 1e-4),
            "cut": "NO" if not valid else "yes" if off < 1e-4 else "vol"}


def judge_one(truth_path, step_path):
    """All figures of a file, said after each stage."""
    for folder in ("/usr/lib/freecad-python3/lib", "/usr/lib/freecad/Mod"):
        sys.path.append(folder)
    import FreeCAD  # noqa: F401
    import Part
    with open(truth_path + ".json") as file:
        report = json.load(file)
    figures = {"stage": "read"}
    say(figures)
    start = time.process_time()
    shape = Part.read(step_path)
    figures["seconds_to_read"] = time.process_time() - start
    diagonal = report["diagonal"]
    solids = shape.Solids
    loose = len(shape.Faces) - sum(len(solid.Faces) for solid in solids)
    figures.update(stage="check", solids=len(solids), true_solids=report["solids"], loose_faces=loose, faces=len(shape.Faces),
                   true_faces=report["face_count"], faces_relative=len(shape.Faces) / report["face_count"],
                   bytes=os.path.getsize(step_path))
    say(figures)
    figures["is_valid"] = bool(shape.isValid())
    figures["is_closed"] = bool(solids) and all(shell.isClosed() for solid in solids for shell in solid.Shells)
    figures["good_solid"] = bool(figures["is_valid"] and figures["is_closed"] and loose == 0 and len(solids) == report["solids"])
    volume = sum(solid.Volume for solid in solids)
    figures["volume_off"] = abs(volume / report["volume"] - 1)
    figures["area_off"] = abs(shape.Area / report["area"] - 1)
    figures["edge_tolerance"] = max((edge.Tolerance for edge in shape.Edges), default=0) / diagonal
    figures["vertex_tolerance"] = max((vertex.Tolerance for vertex in shape.Vertexes), default=0) / diagonal
    figures["tolerance"] = max(figures["edge_tolerance"], figures["vertex_tolerance"])
    figures["stage"] = "faces"
    say(figures)
    truth_shape = Part.read(truth_path + ".step")
    figures.update(judge_faces(shape, Truth(truth_shape, diagonal), report["area_by_kind"]))
    figures["stage"] = "cut"
    say(figures)
    if solids:
        start = time.process_time()
        figures.update(judge_cut(solids[0] if len(solids) == 1 else shape, volume))
        figures["seconds_to_cut"] = time.process_time() - start
    figures["stage"] = "done"
    say(figures)


def run_one(truth_path, step_path):
    """`judge_one` in a process of its own, which the kernel may crash or hang."""
    command = [sys.executable, os.path.abspath(__file__), "--one", truth_path, step_path]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    output, problem = result.stdout, ""
    if result.returncode == -signal.SIGXCPU:
        problem = "took more than %d s" % SECONDS
    elif result.returncode:
        problem = "crashed with %d: %s" % (result.returncode, (result.stderr.decode(errors="replace").strip().splitlines() or [""])[-1])
    figures = {"stage": "start"}
    for line in output.decode(errors="replace").splitlines():
        if line.startswith("JSON "):
            figures = json.loads(line[5:])
    if problem:
        figures["problem"] = "%s (at the stage %s)" % (problem, figures["stage"])
    return figures


# --- tables ------------------------------------------------------------------------------------------------------------------------------

COLUMNS = (  # head, width, key, how
    ("solid", 5, "good_solid", "yes"), ("faces", 6, "faces", "%d"), ("times", 6, "faces_relative", "%.2f"),
    ("right%", 7, "share_right", "share"), ("curved%", 7, "share_curved_right", "share"), ("false%", 6, "share_false", "share"),
    ("area%", 6, "share_by_area", "share"), ("sizemax", 8, "size_error_max", "%.1e"), ("sizemed", 8, "size_error_median", "%.1e"),
    ("distmax", 8, "distance_max", "%.1e"), ("volume", 8, "volume_off", "%.1e"), ("area", 8, "area_off", "%.1e"),
    ("toler.", 8, "tolerance", "%.1e"), ("cut", 4, "cut", "%s"), ("read s", 6, "seconds_to_read", "%.2f"))


def shown(value, how):
    if value is None:
        return "-"
    if how == "yes":
        return "yes" if value else "NO"
    return "%.1f" % (100 * value) if how == "share" else how % value


def row(figures):
    return " ".join(shown(figures.get(key), how).rjust(width) for _, width, key, how in COLUMNS)


def totals(results):
    """The figures of a group of files; a file without a figure counts as 0 or as failed."""
    def share(key):
        values = [figures.get(key) or 0.0 for figures in results.values() if key not in figures or figures[key] is not None]
        return sum(values) / len(values) if values else None

    def worst(key):
        found = [(figures[key], name) for name, figures in results.items() if figures.get(key) is not None]
        return list(max(found)) if found else None

    ranked = sorted(results, key=lambda name: (results[name].get("share_right") or 0.0, name))
    return {
        "files": len(results),
        "share_right": share("share_right"), "share_curved_right": share("share_curved_right"), "share_false": share("share_false"),
        "good_solids": sum(bool(figures.get("good_solid")) for figures in results.values()),
        "valid_cuts": sum(bool(figures.get("cut_valid")) for figures in results.values()),
        "good_cuts": sum(bool(figures.get("cut_good")) for figures in results.values()),
        "problems": sum("problem" in figures for figures in results.values()),
        "faces_relative_median": float(np.median([figures.get("faces_relative", np.inf) for figures in results.values()])),
        "lowest_shares": [[name, results[name].get("share_right")] for name in ranked[:5]],
        "largest": {key: worst(key) for key in ("size_error_max", "size_error_median", "distance_max", "volume_off", "area_off", "tolerance",
                                                "share_false", "faces_relative", "seconds_to_read")},
        "no_good_solid": [name for name in results if not results[name].get("good_solid")],
        "no_good_cut": [name for name in results if not results[name].get("cut_good")],
    }


def print_totals(title, total):
    print("\n%s: %d files; right kind %s %%, of curved %s %%, false %s %%; good solids %d, valid cuts %d, with the volume %d, problems %d; faces x%.2f" % (
        title, total["files"], shown(total["share_right"], "share"), shown(total["share_curved_right"], "share"),
        shown(total["share_false"], "share"), total["good_solids"], total["valid_cuts"], total["good_cuts"], total["problems"], total["faces_relative_median"]))
    print("  lowest shares: " + ", ".join("%s %s" % (name, shown(value, "share")) for name, value in total["lowest_shares"]))
    print("  largest: " + ", ".join("%s %.1e (%s)" % (key, *pair) for key, pair in total["largest"].items() if pair))
    for key in ("no_good_solid", "no_good_cut"):
        if total[key]:
            print("  %s: %s" % (key.replace("_", " "), " ".join(total[key])))


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "--one":
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
        judge_one(sys.argv[2], sys.argv[3])
        return
    parser = argparse.ArgumentParser(description="Holds STEP files to the parts that they were made from.")
    parser.add_argument("truth_folder")
    parser.add_argument("step_folder")
    parser.add_argument("--filter", default="", metavar="WORD", help="only files whose names contain this")
    parser.add_argument("--json", metavar="FILE", help="where to write the figures (STEP_FOLDER/judge.json)")
    arguments = parser.parse_args()
    results = {}
    print(" " * 28 + " ".join(head.rjust(width) for head, width, _, _ in COLUMNS))
    for file_name in sorted(os.listdir(arguments.step_folder)):
        name, extension = os.path.splitext(file_name)
        if extension not in (".step", ".stp") or arguments.filter not in name:
            continue
        part = name.split(".")[0]
        truth_path = os.path.join(arguments.truth_folder, part[2:] if part.startswith("n_") else part)
        if not os.path.exists(truth_path + ".json"):
            print("%-28s has no truth" % name)
            continue
        results[name] = run_one(truth_path, os.path.join(arguments.step_folder, file_name))
        print("%-28s%s %s" % (name, row(results[name]), results[name].get("problem", "")), flush=True)
    if not results:
        sys.exit("there are no STEP files to judge")
    groups = {}
    for half, title in (("a", "tuning"), ("b", "held out"), ("n", "with noise")):
        for level in LEVELS:
            members = {name: r for name, r in results.items() if name.startswith(half + "_") and name.split(".")[1:2] == [level]}
            if members:
                groups["%s %s" % (title, level)] = totals(members)
    groups["all"] = totals(results)
    for title, total in groups.items():
        print_totals(title, total)
    target = arguments.json or os.path.join(arguments.step_folder, "judge.json")
    with open(target, "w") as file:
        json.dump({"totals": groups, "files": results}, file, indent=1, sort_keys=True)
    print("\nfigures: " + target)


if __name__ == "__main__":
    main()

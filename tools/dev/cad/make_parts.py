#!/usr/bin/env python3
"""Builds 60 parts as a CAD user would, with OpenCASCADE through FreeCAD, for the recognition of analytic faces.

    make_parts.py FOLDER [--only WORD]

Writes for each part NAME.step (the truth), NAME.{coarse,medium,fine}.stl (OpenCASCADE's triangulation) and NAME.json (faces by kind, radii,
volume, area). Names a_* are for tuning, b_* are held out; n_a_*.fine.stl are fine triangulations with noise. Lengths are millimetres.
All is deterministic. README.md beside it says how to run it.
"""

import argparse
import hashlib
import json
import math
import os
import random
import re
import sys

import numpy as np

for folder in ("/usr/lib/freecad-python3/lib", "/usr/lib/freecad/Mod"):
    sys.path.append(folder)
import FreeCAD  # noqa: E402
import Part  # noqa: E402
from FreeCAD import Vector  # noqa: E402

# Chord error relative to the diagonal of the bounding box, and the angle between neighbouring facets in radians.
LEVELS = {"coarse": (3e-3, 0.5), "medium": (1e-3, 0.25), "fine": (2e-4, 0.1)}
NOISE = 2e-5  # standard deviation of each coordinate of a vertex, relative to the diagonal
NOISY = ("plate_bores", "bracket", "rounded_block", "boss", "bottle", "pulley", "dome", "pipe", "tray", "cross_cylinders", "loft", "shaft")

X, Y, Z = Vector(1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 1)
PARTS = {}


def part(function):
    """Enters a function that builds a part under its name."""
    PARTS[function.__name__] = function
    return function


# --- the words of a CAD user -----------------------------------------------------------------------------------------------------------


def box(x, y, z, at=(0, 0, 0)):
    return Part.makeBox(x, y, z, Vector(*at))


def cylinder(radius, height, at=(0, 0, 0), axis=Z):
    return Part.makeCylinder(radius, height, Vector(*at), Vector(axis))


def cone(bottom, top, height, at=(0, 0, 0), axis=Z):
    return Part.makeCone(bottom, top, height, Vector(*at), Vector(axis))


def sphere(radius, at=(0, 0, 0)):
    return Part.makeSphere(radius, Vector(*at))


def outline(start, *steps):
    """A closed wire from `start`: a step is a point (line to it) or a pair of points (arc through the first to the second)."""
    at, edges = Vector(*start), []
    for step in steps:
        if isinstance(step[0], tuple):
            middle, end = Vector(*step[0]), Vector(*step[1])
            edges.append(Part.Arc(at, middle, end).toShape())
        else:
            end = Vector(*step)
            edges.append(Part.makeLine(at, end))
        at = end
    if at.distanceToPoint(Vector(*start)) > 1e-9:
        edges.append(Part.makeLine(at, Vector(*start)))
    return Part.Wire(edges)


def extruded(wire, way):
    return Part.Face(wire).extrude(Vector(*way))


def flat(*points):
    """Points and pairs of points of the plane z = 0 as those of `outline`."""
    return [tuple((*p, 0.0) for p in q) if isinstance(q[0], tuple) else (*q, 0.0) for q in points]


def with_round_corners(profile):
    """A closed profile whose corners (x, y, radius) are replaced by the arcs that touch both lines."""
    steps = []
    for i, corner in enumerate(profile):
        if isinstance(corner[0], tuple) or len(corner) == 2:
            steps.append(corner)
            continue
        before, after = profile[i - 1], profile[(i + 1) % len(profile)]
        at, radius = np.array(corner[:2]), corner[2]
        before, after = [np.array(p[-1] if isinstance(p[0], tuple) else p[:2]) - at for p in (before, after)]
        before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
        half = math.acos(float(np.dot(before, after))) / 2
        inwards = (before + after) / np.linalg.norm(before + after)
        centre = at + inwards * radius / math.sin(half)
        start, end = [tuple(at + way * radius / math.tan(half)) for way in (before, after)]
        steps += [start, (tuple(centre - inwards * radius), end)]
    return steps


def torus_patch(edge):
    """What an arc in the plane y = 0 makes about the z axis, as a face of a torus. (OpenCASCADE's revolution makes no torus of it.)"""
    circle = edge.Curve
    torus = Part.Toroid()
    torus.Center, torus.MajorRadius, torus.MinorRadius = Vector(0, 0, circle.Center.z), circle.Center.x, circle.Radius
    angles = []
    for at in (edge.FirstParameter, (edge.FirstParameter + edge.LastParameter) / 2, edge.LastParameter):
        way = edge.valueAt(at) - circle.Center
        angles.append(math.atan2(way.z, way.x))
    first, half, last = angles
    span = 2 * math.remainder(half - first, 2 * math.pi)
    low = min(first, first + span)
    low = low if low >= 0 else low + 2 * math.pi
    return torus.toShape(0, 2 * math.pi, low, low + abs(span))


def turned(*profile):
    """The body that a profile of (radius, height) makes about the z axis; corners (radius, height, r) are rounded by r."""
    def lift(p):
        return (p[0], 0.0, p[1])
    steps = [tuple(lift(p) for p in q) if isinstance(q[0], tuple) else lift(q) for q in with_round_corners(profile)]
    wire = outline(steps[0], *steps[1:])
    faces = []
    for edge in wire.Edges:
        if all(abs(edge.valueAt(t).x) < 1e-9 for t in (edge.FirstParameter, edge.LastParameter)) and is_line(edge):
            continue
        if isinstance(edge.Curve, Part.Circle) and edge.Curve.Center.x > 1e-6:
            faces.append(torus_patch(edge))
        else:
            faces += edge.revolve(Vector(0, 0, 0), Z, 360).Faces
    shell = Part.makeShell(faces)
    shell.sewShape()
    body = Part.makeSolid(shell.Shells[0])
    if body.Volume < 0:
        body.reverse()
    return body


def polygon(sides, radius, turn=0.0):
    return [(radius * math.cos(turn + 2 * math.pi * i / sides), radius * math.sin(turn + 2 * math.pi * i / sides)) for i in range(sides)]


def around(shape, count, first=0.0, axis=Z):
    """Copies of a shape evenly round an axis through the origin."""
    copies = []
    for i in range(count):
        copy = shape.copy()
        copy.rotate(Vector(0, 0, 0), Vector(axis), first + 360.0 * i / count)
        copies.append(copy)
    return copies


def fused(first, *others):
    return first.multiFuse(list(others)).removeSplitter()


def cut(first, *others):
    return first.cut(list(others)).removeSplitter()


def one(shape):
    """The single solid of a shape."""
    if len(shape.Solids) != 1:
        raise RuntimeError("%d solids instead of one" % len(shape.Solids))
    return shape.Solids[0]


def middle(edge):
    return edge.valueAt((edge.FirstParameter + edge.LastParameter) / 2)


def is_line(edge):
    return isinstance(edge.Curve, (Part.Line, Part.LineSegment))


def along(edge, axis):
    """Whether an edge is straight and parallel to an axis."""
    return is_line(edge) and abs(edge.tangentAt(edge.FirstParameter).dot(axis)) > 1 - 1e-9


def in_plane(edge, axis, height):
    """Whether all of an edge is at a height along an axis."""
    at = [edge.FirstParameter + (edge.LastParameter - edge.FirstParameter) * t / 4 for t in range(5)]
    return all(abs(edge.valueAt(t).dot(axis) - height) < 1e-6 for t in at)


def chosen(shape, keep):
    edges = [edge for edge in shape.Edges if keep(edge)]
    if not edges:
        raise RuntimeError("no edge is chosen")
    return edges


def filleted(shape, radius, keep=lambda edge: True):
    shape = one(shape)
    return one(shape.makeFillet(radius, chosen(shape, keep)))


def chamfered(shape, length, keep=lambda edge: True):
    shape = one(shape)
    return one(shape.makeChamfer(length, chosen(shape, keep)))


def slot(length, width, height, at=(0, 0, 0), turn=0.0):
    """A body with two round ends, `length` between their axes along x."""
    r, h = width / 2, length / 2
    wire = outline(*flat((-h, -r), (h, -r), ((h + r, 0), (h, r)), (-h, r), ((-h - r, 0), (-h, -r))))
    body = extruded(wire, (0, 0, height))
    body.rotate(Vector(0, 0, 0), Z, turn)
    body.translate(Vector(*at))
    return body


def countersink(bore, head, thickness, at, angle=90.0):
    """What a countersunk screw leaves: a bore through a plate whose upper side is at height `at[2]`, and a cone."""
    depth = (head - bore) / math.tan(math.radians(angle / 2))
    x, y, z = at
    drill = cylinder(bore, thickness + 2, (x, y, z - thickness - 1))
    rise = 1.0
    sink = cone(bore, head + rise * math.tan(math.radians(angle / 2)), depth + rise, (x, y, z - depth))
    return drill.fuse(sink)


def drilled(radius, depth, at, axis=Z, tip=118.0):
    """A blind bore from `at` along `axis` with the cone that a drill leaves."""
    axis = Vector(axis)
    end = Vector(*at) + axis * depth
    return cylinder(radius, depth, at, axis).fuse(cone(radius, 0, radius / math.tan(math.radians(tip / 2)), tuple(end), axis))


def rounded_plate(x, y, z, radius):
    return filleted(box(x, y, z, (-x / 2, -y / 2, 0)), radius, lambda e: along(e, Z))


def spline_outline(points, pieces=3):
    """A smooth closed wire through points of the plane z = 0, in pieces: OpenCASCADE integrates volumes badly along long splines."""
    curve = Part.BSplineCurve()
    curve.interpolate([Vector(px, py, 0) for px, py in points], PeriodicFlag=True)
    knots, edges = curve.getKnots(), []
    cuts = [knots[round(i * (len(knots) - 1) / pieces)] for i in range(pieces + 1)]
    for first, last in zip(cuts, cuts[1:]):
        piece = curve.copy()
        piece.segment(first, last)
        edges.append(piece.toShape())
    return Part.Wire(edges)


def swept_pipe(radius, path):
    """A round rod along straight lines and elbows; `path` starts with a point and a direction and goes on with ("line", length) or
    ("elbow", axis, bend radius, angle in degrees), where the axis is at right angles to the direction."""
    at, way = Vector(*path[0]), Vector(*path[1]).normalize()
    pieces = []
    for step in path[2:]:
        if step[0] == "line":
            pieces.append(Part.makeCylinder(radius, step[1], at, way))
            at = at + way * step[1]
            continue
        axis, bend, angle = Vector(*step[1]).normalize(), step[2], step[3]
        centre = at + axis.cross(way) * bend
        elbow = Part.makeTorus(bend, radius, Vector(0, 0, 0), Z, 0, 360, angle)
        elbow.Placement = FreeCAD.Placement(centre, FreeCAD.Rotation(at - centre, way, axis, "ZXY"))
        pieces.append(elbow)
        spin = FreeCAD.Rotation(axis, angle)
        at, way = centre + spin.multVec(at - centre), spin.multVec(way)
    return one(fused(pieces[0], *pieces[1:])), at, way


# --- a: for tuning -----------------------------------------------------------------------------------------------------------------------


@part
def a_box():
    return box(40, 30, 20)


@part
def a_plate_bores():
    corners = [(10, 10), (70, 10), (70, 40), (10, 40)]
    through = [cylinder(4, 12, (x, y, -1)) for x, y in corners]
    return cut(box(80, 50, 10), *through, cylinder(9, 7, (40, 25, 4)), cylinder(2, 12, (25, 25, -1)))


@part
def a_countersunk():
    sinks = [countersink(2.5, 5, 8, (x, y, 8)) for x, y in ((12, 12), (48, 12), (48, 28), (12, 28))]
    counterbore = [cylinder(3, 10, (30, 20, -1)), cylinder(6, 5, (30, 20, 5))]
    return cut(box(60, 40, 8), *sinks, *counterbore)


@part
def a_bracket():
    wire = outline((0, 0, 0), (50, 0, 0), (50, 0, 6), (6, 0, 6), (6, 0, 45), (0, 0, 45))
    body = extruded(wire, (0, 40, 0))
    body = filleted(body, 5, lambda e: along(e, Y) and abs(middle(e).x - 6) < 1e-6 and abs(middle(e).z - 6) < 1e-6)
    body = filleted(body, 11, lambda e: along(e, Y) and abs(middle(e).x) < 1e-6 and abs(middle(e).z) < 1e-6)
    body = filleted(body, 8, lambda e: along(e, Z) and middle(e).x > 49)
    body = filleted(body, 1, lambda e: in_plane(e, Z, 6) and middle(e).x > 12)
    bores = [cylinder(3, 12, (36, y, -1)) for y in (12, 28)] + [cylinder(4.5, 12, (-1, 20, 30), X)]
    return cut(body, *bores)


@part
def a_rounded_block():
    return filleted(box(50, 35, 25), 5)


@part
def a_chamfered_block():
    body = chamfered(box(40, 28, 18), 3, lambda e: in_plane(e, Z, 18))
    return cut(body, drilled(4, 9, (20, 14, 18), -Z))


@part
def a_boss():
    plate = box(60, 60, 6, (-30, -30, -6))
    body = fused(plate, cone(14, 11.5, 22))
    body = filleted(body, 3, lambda e: in_plane(e, Z, 0) and middle(e).Length < 20)
    body = filleted(body, 1, lambda e: in_plane(e, Z, 22))
    return cut(body, cylinder(5, 20, (0, 0, 6)), *[cylinder(2.5, 10, (x, y, -8)) for x in (-23, 23) for y in (-23, 23)])


@part
def a_bottle():
    return turned((0, 0), (28, 0, 4), (28, 60, 6), (12, 78, 5), (12, 95), (10, 95), (10, 77.2, 7), (26, 59.2, 4), (26, 2, 2), (0, 2))


@part
def a_pulley():
    body = turned((0, 0), (40, 0), (40, 3), (28, 8), (28, 10), (40, 15), (40, 18), (0, 18))
    hub = cylinder(14, 30, (0, 0, -6))
    return cut(fused(body, hub), cylinder(7, 40, (0, 0, -10)), box(4, 9.5, 40, (-2, 0, -10)))


@part
def a_nozzle():
    return turned((14, 0), (20, 0), (20, 12), (16, 12), (9, 40), (6, 40), (6, 34), (14, 8))


@part
def a_ball():
    return sphere(17)


@part
def a_ring():
    return Part.makeTorus(30, 7)


@part
def a_dome():
    c = math.sqrt(0.5)
    return turned((30, -10), (36, -10), (36, -6), (32, -6), (32, 0), ((32 * c, 32 * c), (0, 32)), (0, 30), ((30 * c, 30 * c), (30, 0)))


@part
def a_pipe():
    path = ((0, 0, 0), (0, 0, 1), ("line", 30), ("elbow", (0, 1, 0), 25, 90), ("line", 40))
    outer, end, way = swept_pipe(10, path)
    inner, _, _ = swept_pipe(8, path)
    flange = cut(cylinder(20, 5), *around(cylinder(2.2, 7, (15, 0, -1)), 4))
    return cut(fused(outer, flange), inner)


@part
def a_l_profile():
    r = 4 * (1 - math.sqrt(0.5))
    wire = outline(*flat((0, 0), (40, 0), (40, 4), (8, 4), ((4 + r, 4 + r), (4, 8)), (4, 30), (0, 30)))
    return extruded(wire, (0, 0, 120))


@part
def a_t_profile():
    wire = outline(*flat((-25, 0), (25, 0), (25, 5), (3, 5), (3, 40), (-3, 40), (-3, 5), (-25, 5)))
    return cut(extruded(wire, (0, 0, 60)), *[cylinder(3.5, 10, (-5, 28, z), X) for z in (15, 45)])


@part
def a_hex_nut():
    body = extruded(outline(*flat(*polygon(6, 15))), (0, 0, 12))
    caps = turned((0, 0), (13, 0), (19, 3.5), (19, 8.5), (13, 12), (0, 12))
    body = body.common(caps)
    return cut(body, cylinder(8, 14, (0, 0, -1)), cone(10, 7, 3, (0, 0, -1)), cone(7, 10, 3, (0, 0, 10)))


@part
def a_gear():
    teeth, wire = 16, []
    for i in range(teeth):
        a = 2 * math.pi * i / teeth
        step = 2 * math.pi / teeth
        def at(radius, share):
            return (radius * math.cos(a + share * step), radius * math.sin(a + share * step))
        if not wire:
            wire.append(at(22, 0))
        wire += [(at(22, 0.2), at(22, 0.4)), at(27, 0.52), (at(27, 0.7), at(27, 0.88))]
        wire.append(at(22, 1.0) if i + 1 < teeth else wire[0])
    body = extruded(outline(*flat(*wire)), (0, 0, 9))
    return cut(body, cylinder(6, 11, (0, 0, -1)), box(4, 8, 11, (-2, 0, -1)), *around(cylinder(3, 11, (13, 0, -1)), 5))


@part
def a_slot_plate():
    body = rounded_plate(90, 50, 6, 8)
    return cut(body, slot(40, 10, 8, (0, 10, -1)), slot(20, 6, 8, (-25, -12, -1), 30), slot(24, 8, 4, (20, -12, 3)))


@part
def a_rib():
    wall = fused(box(60, 40, 5), box(5, 40, 45))
    ribs = [extruded(outline((5, y, 5), (45, y, 5), (5, y, 38)), (0, 4, 0)) for y in (8, 28)]
    body = fused(wall, *ribs)
    body = filleted(body, 2, lambda e: along(e, X) and abs(middle(e).z - 5) < 1e-6 and middle(e).y not in (0, 40) and 1 < middle(e).y < 39)
    return cut(body, cylinder(4, 8, (50, 20, -1)), cylinder(5, 8, (-1, 20, 35), X))


@part
def a_tray():
    body = filleted(box(100, 70, 22), 10, lambda e: along(e, Z))
    body = filleted(body, 4, lambda e: in_plane(e, Z, 0))
    hollow = filleted(box(96, 66, 22, (2, 2, 2)), 8, lambda e: along(e, Z))
    return cut(body, filleted(hollow, 2, lambda e: in_plane(e, Z, 2)))


@part
def a_cross_cylinders():
    return fused(cylinder(12, 70, (0, 0, -35)), cylinder(8, 60, (-30, 0, 4), X))


@part
def a_loft():
    base = box(40, 40, 8, (-20, -20, -8))
    square = outline(*[(x, y, 0) for x, y in ((-15, -15), (15, -15), (15, 15), (-15, 15))])
    middle_wire = Part.Wire(Part.makeCircle(11, Vector(0, 0, 18)))
    top = Part.Wire(Part.makeCircle(9, Vector(0, 0, 30)))
    neck = Part.makeLoft([square, middle_wire, top], True, False)
    return cut(fused(base, neck, cylinder(9, 12, (0, 0, 30))), cylinder(5, 60, (0, 0, -10)))


@part
def a_spline_wall():
    points = [(30, 0), (22, 16), (4, 22), (-14, 15), (-32, 18), (-36, -4), (-18, -16), (2, -12), (20, -18)]
    body = extruded(spline_outline(points), (0, 0, 15))
    return cut(body, cylinder(6, 17, (15, 0, -1)), cylinder(5, 8, (-22, 3, 8)))


@part
def a_cut_sphere():
    body = cut(sphere(20), box(50, 50, 20, (-25, -25, 14)), box(50, 50, 20, (-25, -25, -36)), box(20, 50, 50, (15, -25, -25)))
    return cut(body, cylinder(6, 60, (0, 0, -30)))


@part
def a_shaft():
    body = turned((0, 0), (8, 0), (8, 25), (12, 25), (12, 70), (15, 70), (15, 80), (10, 80), (10, 110), (0, 110))
    body = filleted(body, 1.5, lambda e: in_plane(e, Z, 25) and math.hypot(middle(e).x, middle(e).y) < 9)
    body = filleted(body, 2, lambda e: in_plane(e, Z, 70) and math.hypot(middle(e).x, middle(e).y) < 13)
    body = chamfered(body, 1, lambda e: (in_plane(e, Z, 0) or in_plane(e, Z, 110)) and math.hypot(middle(e).x, middle(e).y) > 7)
    key = slot(20, 5, 10, (0, 0, 0))
    key.rotate(Vector(0, 0, 0), Y, 90)
    key.translate(Vector(9, 0, 48))
    return cut(body, key)


@part
def a_flange():
    body = fused(cylinder(45, 10), cylinder(20, 32))
    body = filleted(body, 5, lambda e: in_plane(e, Z, 10) and abs(math.hypot(middle(e).x, middle(e).y) - 20) < 1e-6)
    body = chamfered(body, 1.5, lambda e: in_plane(e, Z, 32))
    return cut(body, cylinder(13, 40, (0, 0, -1)), *around(cylinder(4, 12, (34, 0, -1)), 6))


@part
def a_cone_cross():
    return cut(fused(cone(24, 9, 50), cylinder(7, 30, (0, 0, 20), X)), cylinder(4, 60, (0, -30, 30), Y))


@part
def a_bearing_block():
    base = filleted(box(90, 30, 12, (-45, -15, 0)), 6, lambda e: along(e, Z))
    wire = outline((-20, -11, 12), (20, -11, 12), (20, -11, 30), ((0, -11, 50), (-20, -11, 30)))
    body = fused(base, extruded(wire, (0, 22, 0)))
    body = filleted(body, 2.5, lambda e: along(e, Y) and abs(middle(e).z - 12) < 1e-6)
    return cut(body, cylinder(12, 40, (0, -20, 30), Y), cylinder(15, 10, (0, 8, 30), Y), slot(6, 7, 14, (-34, 0, -1)), slot(6, 7, 14, (34, 0, -1)))


@part
def a_cam():
    wire = tangent_outline((0, 0), 20, (28, 0), 8)
    body = fused(extruded(wire, (0, 0, 12)), cylinder(12, 22))
    return cut(body, cylinder(7, 26, (0, 0, -2)), box(3, 9, 26, (-1.5, 0, -2)))


def tangent_outline(first, big, second, small):
    """Two circles and the lines that touch both, as a belt round two pulleys; the second centre is in +x of the first."""
    d = second[0] - first[0]
    a = math.acos((big - small) / d)
    def on(centre, radius, angle):
        return (centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle))
    return outline(*flat(on(first, big, -a), on(second, small, -a), (on(second, small, 0), on(second, small, a)), on(first, big, a),
                         (on(first, big, math.pi), on(first, big, -a))))


# --- b: held out -------------------------------------------------------------------------------------------------------------------------


@part
def b_wedge():
    wire = outline((0, 0, 0), (55, 0, 0), (48, 0, 14), (20, 0, 31), (6, 0, 26))
    body = extruded(wire, (0, 33, 0))
    return cut(body, extruded(outline((-5, -5, -5), (20, -5, -5), (-5, 12, -5)), (0, 0, 60)))


@part
def b_manifold():
    body = chamfered(box(64, 44, 40), 2, lambda e: along(e, Z))
    return cut(body, drilled(7, 50, (0, 22, 20), X), drilled(4, 20, (18, 22, 40), -Z), drilled(4, 20, (40, 22, 40), -Z),
               drilled(3, 24, (29, 0, 20), Y), cylinder(9, 4, (0, 22, 20), X), *[cylinder(2, 46, (x, y, -1)) for x in (6, 58) for y in (6, 38)])


@part
def b_cover_plate():
    body = rounded_plate(110, 70, 7, 14)
    body = chamfered(body, 1.2, lambda e: in_plane(e, Z, 7))
    sinks = [countersink(3.2, 6.5, 7, (x, y, 7), 82) for x in (-42, 42) for y in (-22, 22)]
    return cut(body, *sinks, cylinder(16, 9, (0, 0, -1)), cylinder(21, 4, (0, 0, 4.5)), *[cylinder(1.6, 4.5, (x, 0, 4)) for x in (-32, 32)])


@part
def b_u_bracket():
    wire = outline((0, 0, 0), (54, 0, 0), (54, 0, 40), (49, 0, 40), (49, 0, 5), (5, 0, 5), (5, 0, 40), (0, 0, 40))
    body = extruded(wire, (0, 26, 0))
    body = filleted(body, 3, lambda e: along(e, Y) and abs(middle(e).z - 5) < 1e-6)
    body = filleted(body, 8, lambda e: along(e, Y) and abs(middle(e).z) < 1e-6)
    body = filleted(body, 12.9, lambda e: along(e, X) and middle(e).z > 39)
    return cut(body, cylinder(5, 60, (-2, 13, 27), X), slot(14, 6, 10, (27, 13, -2)))


@part
def b_rounded_slab():
    body = filleted(box(70, 44, 20), 9, lambda e: along(e, Z))
    body = filleted(body, 3, lambda e: in_plane(e, Z, 20))
    body = filleted(body, 1.5, lambda e: in_plane(e, Z, 0))
    return cut(body, sphere(12, (35, 22, 25)))


@part
def b_chamfered_step():
    body = fused(box(60, 36, 14), box(30, 36, 30))
    body = chamfered(body, 4, lambda e: along(e, Z) and middle(e).x > 59)
    body = chamfered(body, 2, lambda e: in_plane(e, Z, 30))
    body = chamfered(body, 1.2, lambda e: in_plane(e, Z, 0))
    return cut(body, countersink(4, 7, 30, (15, 18, 30), 120))


@part
def b_stud_plate():
    studs = [cone(4.2, 3.6, 5, (x, y, 8)) for x in (-12, 0, 12) for y in (-6, 6)]
    plate = filleted(box(40, 26, 8, (-20, -13, 0)), 1.5, lambda e: not in_plane(e, Z, 0))
    body = fused(plate, *studs)
    body = filleted(body, 0.8, lambda e: in_plane(e, Z, 13))
    return cut(body, box(36, 22, 6, (-18, -11, -1)))


@part
def b_flask():
    body = turned((0, 0), (24, 0, 3), (33, 45, 8), (11, 70, 12), (9, 100), (15, 104), (15, 108), (0, 108))
    inside = turned((0, 4), (20, 4), (29, 45), (7, 72), (6, 109), (0, 109))
    return cut(body, inside)


@part
def b_rope_roller():
    body = turned((0, 0), (30, 0), (30, 3), ((24, 9), (30, 15)), (30, 18), (0, 18))
    body = cut(body, cylinder(9, 20, (0, 0, -1)), *around(cylinder(4.5, 20, (16, 0, -1)), 5))
    return chamfered(body, 0.8, lambda e: math.hypot(middle(e).x, middle(e).y) > 29.9 and (in_plane(e, Z, 0) or in_plane(e, Z, 18)))


@part
def b_venturi():
    h = 20 - math.sqrt(20 * 20 - 10 * 10)
    return turned((7 + h, -10), (15, -30), (19, -30), (19, 42), (16, 42), (7 + h, 10), ((7, 0), (7 + h, -10)))


@part
def b_knob():
    body = fused(sphere(15), cylinder(6, 30, (0, 0, -34)), cylinder(11, 5, (0, 0, -34)))
    body = filleted(body, 2, lambda e: in_plane(e, Z, -29) and math.hypot(middle(e).x, middle(e).y) < 7)
    body = cut(body, box(40, 40, 10, (-20, -20, 11.5)), drilled(3, 20, (0, 0, -34)))
    return body


@part
def b_seal_disc():
    body = cylinder(40, 12)
    body = filleted(body, 1.5, lambda e: in_plane(e, Z, 0))
    return cut(body, Part.makeTorus(27, 4, Vector(0, 0, 12)), cylinder(15, 14, (0, 0, -1)), *around(cylinder(2, 14, (35.5, 0, -1)), 8))


@part
def b_lens():
    return one(sphere(40, (0, 0, -33)).common(sphere(60, (0, 0, 52))).common(cylinder(15, 60, (0, 0, -30))))


@part
def b_rod_s():
    rod, end, way = swept_pipe(5, ((0, 0, 0), (1, 0, 0), ("line", 25), ("elbow", (0, 0, 1), 14, 70), ("line", 18),
                                   ("elbow", (0, 0, -1), 20, 110), ("line", 22)))
    return fused(rod, sphere(9), Part.makeCylinder(8, 6, end, way))


@part
def b_u_profile():
    wire = outline(*flat((0, 0), (36, 0), (36, 30), (32, 30), (32, 4), (4, 4), (4, 30), (0, 30)))
    body = extruded(wire, (0, 0, 90))
    body = filleted(body, 3, lambda e: along(e, Z) and abs(middle(e).y - 4) < 1e-6)
    body = filleted(body, 7, lambda e: along(e, Z) and abs(middle(e).y) < 1e-6)
    return filleted(body, 1.99, lambda e: along(e, Z) and abs(middle(e).y - 30) < 1e-6)


@part
def b_i_beam():
    wire = outline(*flat((-20, 0), (20, 0), (20, 4), (2, 4), (2, 46), (20, 46), (20, 50), (-20, 50), (-20, 46), (-2, 46), (-2, 4), (-20, 4)))
    body = extruded(wire, (0, 0, 150))
    body = filleted(body, 4, lambda e: along(e, Z) and abs(abs(middle(e).x) - 2) < 1e-6)
    return cut(body, *[cylinder(9, 10, (-5, 25, z), X) for z in (30, 75, 120)], *[cylinder(2.5, 60, (11, -5, z), Y) for z in (15, 135)])


@part
def b_hex_bolt():
    head = extruded(outline(*flat(*polygon(6, 12, 0.3))), (0, 0, 8)).common(turned((0, 0), (14, 0), (14, 6.5), (10.8, 8.2), (0, 8.2)))
    body = fused(head, cylinder(6, 45, (0, 0, -45)))
    body = filleted(body, 0.8, lambda e: in_plane(e, Z, 0) and abs(math.hypot(middle(e).x, middle(e).y) - 6) < 1e-6)
    return chamfered(body, 1, lambda e: in_plane(e, Z, -45))


@part
def b_sprocket():
    body = cylinder(30, 6)
    body = cut(body, *around(cylinder(4, 8, (30, 0, -1)), 14))
    body = fused(body, cylinder(13, 15))
    ring = turned((24, 6.001), (31, 6.001), (31, 4.2))
    return cut(body, ring, cylinder(7, 20, (0, 0, -1)), *around(slot(5, 5, 8, (19, 0, -1)), 4, 20.0))


@part
def b_arc_slot():
    def at(radius, degrees):
        return (radius * math.cos(math.radians(degrees)), radius * math.sin(math.radians(degrees)))
    wire = outline(*flat(at(24, 20), at(34, 20), (at(34, 60), at(34, 100)), at(24, 100), (at(24, 60), at(24, 20))))
    piece = extruded(wire, (0, 0, 9))
    piece = filleted(piece, 3.5, lambda e: along(e, Z))
    piece.translate(Vector(0, 0, -1))
    return cut(cylinder(42, 7), *around(piece, 3), cone(13, 9, 10, (0, 0, -1)))


@part
def b_ribbed_tube():
    ribs = around(box(12, 3, 60, (13, -1.5, 0)), 8)
    body = fused(cylinder(16, 60), cylinder(25, 5), *ribs)
    body = cut(body, cylinder(12, 70, (0, 0, -1)))
    return cut(body, turned((18, 61), (30, 61), (30, 40)))


@part
def b_tray_two():
    body = filleted(box(120, 80, 26), 12, lambda e: along(e, Z))
    pockets = []
    for x, width in ((4, 66), (74, 42)):
        pocket = filleted(box(width, 72, 30, (x, 4, 4)), 8, lambda e: along(e, Z))
        pockets.append(filleted(pocket, 3, lambda e: in_plane(e, Z, 4)))
    body = cut(body, *pockets)
    lip = filleted(box(120, 80, 3, (0, 0, 23)), 12, lambda e: along(e, Z)).cut(filleted(box(116, 76, 5, (2, 2, 22)), 10, lambda e: along(e, Z)))
    return cut(body, lip)


@part
def b_y_branch():
    way = Vector(math.sin(math.radians(55)), 0, math.cos(math.radians(55)))
    outer = fused(cylinder(13, 80, (0, 0, -30)), cylinder(10, 50, (0, 0, 0), way))
    return cut(outer, cylinder(10, 90, (0, 0, -35)), cylinder(7.5, 60, (0, 0, 0), way))


@part
def b_duct():
    first = Part.Wire(Part.Ellipse(Vector(0, 0, 0), 18, 11).toShape())
    second = Part.Wire(Part.Ellipse(Vector(4, 0, 20), 14, 11).toShape())
    third = Part.Wire(Part.makeCircle(9, Vector(10, 0, 42)))
    duct = Part.makeLoft([first, second, third], True, False)
    lower = extruded(outline(*flat((-26, -18), (26, -18), (26, 18), (-26, 18))), (0, 0, -6))
    return cut(fused(duct, lower, cylinder(15, 5, (10, 0, 42))), *[cylinder(2, 8, (x, y, -7)) for x in (-22, 22) for y in (-14, 14)],
               drilled(5, 20, (10, 0, 47), -Z))


@part
def b_handle():
    points = [(0, 9), (18, 12), (40, 8), (62, 13), (80, 6), (84, -5), (62, -8), (38, -5), (16, -9), (-4, -6)]
    body = extruded(spline_outline(points), (0, 0, 14))
    body = filleted(body, 2, lambda e: in_plane(e, Z, 14))
    return cut(body, slot(16, 6, 20, (20, 2, -1)), cylinder(4, 20, (70, 2, -1)), cone(5.5, 4, 2, (70, 2, -0.5)))


@part
def b_ball_joint():
    body = cut(sphere(24), box(60, 60, 20, (-30, -30, 19)), box(60, 60, 20, (-30, -30, -40)))
    return cut(body, cylinder(7, 60, (-30, 0, 2), X), box(8, 60, 20, (-4, -30, 10)), cone(3, 9, 20, (0, 0, -22)))


@part
def b_spindle():
    body = turned((0, 0), (9, 0), (9, 18), (6.5, 20), (6.5, 28), (14, 28), (14, 40), ((12, 42), (14, 44)), (14, 56), (10, 62), (10, 90), (0, 90))
    body = filleted(body, 2, lambda e: in_plane(e, Z, 28) and math.hypot(middle(e).x, middle(e).y) < 7)
    hexagon = extruded(outline(*flat(*polygon(6, 7))), (0, 0, 16))
    hexagon.translate(Vector(0, 0, 90))
    return cut(fused(body, hexagon), cylinder(2, 8), cone(5, 0, 5, (0, 0, 0)))


@part
def b_elbow_flange():
    path = ((0, 0, 0), (0, 0, 1), ("line", 12), ("elbow", (1, 0, 0), 30, 60), ("line", 15))
    outer, end, way = swept_pipe(14, path)
    inner, _, _ = swept_pipe(11, path)
    square = rounded_plate(46, 46, 6, 7)
    disc = Part.makeCylinder(21, 5, end - way * 5, way)
    return cut(fused(outer, square, disc), inner, *[cylinder(2.7, 8, (x, y, -1)) for x in (-17, 17) for y in (-17, 17)])


@part
def b_funnel():
    body = turned((40, 60), (42, 60), (42, 56), (9, 24, 6), (7, 0), (5, 0), (7, 24.5), (38, 54.5), (40, 58))
    return cut(body, cylinder(5, 60, (0, 0, 48), X))


@part
def b_clevis():
    wire = outline((0, -15, 0), (40, -15, 0), ((55, 0, 0), (40, 15, 0)), (0, 15, 0))
    body = extruded(wire, (0, 0, 30))
    body = cut(body, box(45, 40, 12, (16, -20, 9)), cylinder(7, 40, (40, 0, -5)))
    stem = cylinder(10, 40, (-40, 0, 15), X)
    body = fused(body, stem)
    body = filleted(body, 3, lambda e: in_plane(e, X, 0) and not is_line(e))
    return chamfered(body, 1.5, lambda e: in_plane(e, X, -40))


@part
def b_rod():
    arm = tangent_outline((0, 0), 15, (80, 0), 10)
    body = fused(extruded(arm, (0, 0, 8)), cylinder(15, 16, (0, 0, -4)), cylinder(10, 14, (80, 0, -3)))
    pocket = tangent_outline((22, 0), 8, (63, 0), 5.5)
    pocket = extruded(pocket, (0, 0, 3))
    pocket = filleted(pocket, 1.2, lambda e: in_plane(e, Z, 0))
    pocket.translate(Vector(0, 0, 5.5))
    return cut(body, pocket, cylinder(9, 30, (0, 0, -8)), cylinder(5, 30, (80, 0, -8)))


# --- what is written ---------------------------------------------------------------------------------------------------------------------

KINDS = {"Plane": "plane", "Cylinder": "cylinder", "Cone": "cone", "Sphere": "sphere", "Toroid": "torus"}


def kind(face):
    """plane, cylinder, cone, sphere, torus or other."""
    return KINDS.get(type(face.Surface).__name__, "other")


def describe(face):
    surface = face.Surface
    entry = {"kind": kind(face), "surface": type(surface).__name__, "area": face.Area}
    if entry["kind"] in ("cylinder", "sphere"):
        entry["radius"] = surface.Radius
    elif entry["kind"] == "cone":
        entry["half_angle_degrees"] = abs(math.degrees(surface.SemiAngle))
    elif entry["kind"] == "torus":
        entry["major_radius"], entry["minor_radius"] = surface.MajorRadius, surface.MinorRadius
    return entry


def seed(name):
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "big")


def placed(shape, name):
    """The shape turned and shifted at random, the same for a name at each run."""
    draw = random.Random(seed(name))
    axis = Vector(draw.gauss(0, 1), draw.gauss(0, 1), draw.gauss(0, 1)).normalize()
    shift = Vector(*[draw.uniform(-1, 1) * shape.BoundBox.DiagonalLength for _ in range(3)])
    place = FreeCAD.Placement(shift, FreeCAD.Rotation(axis, draw.uniform(20, 340)))
    return shape.transformed(place.toMatrix(), copy=True)


def curvature_kind(face):
    """The kind that a freeform face has in truth, from its curvatures at a grid: plane, cylinder or sphere, else None."""
    first_u, last_u, first_v, last_v = face.ParameterRange
    found = []
    for i in range(1, 8):
        for j in range(1, 8):
            u, v = first_u + (last_u - first_u) * i / 8, first_v + (last_v - first_v) * j / 8
            try:
                found.append(sorted(abs(c) for c in face.curvatureAt(u, v)))
            except Part.OCCError:
                pass
    found = np.array(found) * face.BoundBox.DiagonalLength
    if len(found) == 0 or np.ptp(found, axis=0).max() > 1e-4:
        return None
    low, high = found.mean(axis=0)
    return "plane" if high < 1e-4 else "cylinder" if low < 1e-4 else "sphere" if high - low < 1e-4 else None


def check(shape):
    """Stops at a part that is no single valid closed solid or has freeform faces that are analytic in truth."""
    if not (shape.ShapeType == "Solid" and shape.isValid() and shape.isClosed() and shape.Volume > 0):
        raise RuntimeError("not a valid closed solid")
    try:
        shape.check(True)
    except ValueError as error:
        # That a curve on a surface runs a bit beside its edge is so in any result of OpenCASCADE's Boolean operations.
        bad = [line for line in str(error).splitlines() if "Error in" in line and "InvalidCurveOnSurface" not in line]
        if bad:
            raise RuntimeError("it intersects itself: %s" % bad[0])
    for face in shape.Faces:
        if kind(face) == "other" and curvature_kind(face):
            raise RuntimeError("a %s is a %s in truth" % (type(face.Surface).__name__, curvature_kind(face)))


def write_step(shape, path):
    """Writes STEP with a date that stays the same."""
    shape.exportStep(path)
    with open(path, encoding="latin-1") as file:
        text = file.read()
    text = re.sub(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", "2024-01-01T00:00:00", text, count=1)
    with open(path, "w", encoding="latin-1") as file:
        file.write(text)


def triangulate(shape, deflection, angle):
    """OpenCASCADE's triangles as places (n, 3) in float32 and triples of their numbers; vertices of one place are one."""
    import MeshPart
    mesh = MeshPart.meshFromShape(Shape=shape.copy(), LinearDeflection=deflection, AngularDeflection=angle, Relative=False)
    points, triples = mesh.Topology
    places = np.array([(p.x, p.y, p.z) for p in points], dtype=np.float32)
    places, number = np.unique(places, axis=0, return_inverse=True)
    triples = number.reshape(-1)[np.array(triples)]
    alive = (triples[:, 0] != triples[:, 1]) & (triples[:, 1] != triples[:, 2]) & (triples[:, 2] != triples[:, 0])
    return places, triples[alive]


def check_watertight(triples):
    sides = np.concatenate([triples[:, [0, 1]], triples[:, [1, 2]], triples[:, [2, 0]]]).astype(np.int64)
    there = sides[:, 0] << 32 | sides[:, 1]
    back = sides[:, 1] << 32 | sides[:, 0]
    if len(np.unique(there)) != len(there) or not np.array_equal(np.sort(there), np.sort(back)):
        raise RuntimeError("the triangulation is not watertight")


def check_volume(places, triples, shape):
    """Stops if the triangles do not enclose about the volume of the shape."""
    corners = (places - places.mean(axis=0))[triples].astype(float)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    if abs(volume / shape.Volume - 1) > 0.05:
        raise RuntimeError("the triangles enclose %g, the shape %g" % (volume, shape.Volume))


def write_stl(places, triples, path):
    corners = places[triples].astype(np.float32)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    rows = np.zeros(len(triples), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    rows["normal"], rows["corners"] = normals, corners
    with open(path, "wb") as file:
        file.write(b"binary STL".ljust(80, b" ") + np.uint32(len(rows)).tobytes() + rows.tobytes())


def make(name, folder, turn):
    shape = one(PARTS[name]())
    shape = shape.removeSplitter() if name not in ("a_ball", "a_ring") else shape
    shape = one(shape)
    if turn:
        shape = one(placed(shape, name))
    check(shape)
    path = os.path.join(folder, name)
    write_step(shape, path + ".step")
    shape = one(Part.read(path + ".step"))  # the truth is what the file says
    check(shape)
    diagonal = shape.optimalBoundingBox().DiagonalLength
    faces = [describe(face) for face in shape.Faces]
    areas = {}
    for face in faces:
        areas[face["kind"]] = areas.get(face["kind"], 0.0) + face["area"]
    counts = {k: sum(face["kind"] == k for face in faces) for k in areas}
    report = {"name": name, "turned": turn, "volume": shape.Volume, "area": shape.Area, "diagonal": diagonal, "solids": len(shape.Solids),
              "face_count": len(faces), "faces_by_kind": counts, "area_by_kind": areas, "faces": faces, "triangles": {}}
    for level, (deflection, angle) in LEVELS.items():
        places, triples = triangulate(shape, deflection * diagonal, angle)
        check_watertight(triples)
        check_volume(places, triples, shape)
        report["triangles"][level] = len(triples)
        write_stl(places, triples, "%s.%s.stl" % (path, level))
        if level == "fine" and name[:2] == "a_" and name[2:] in NOISY:
            draw = np.random.RandomState(seed("noise " + name) % 2**32)
            noisy = (places + draw.normal(0, NOISE * diagonal, places.shape)).astype(np.float32)
            write_stl(noisy, triples, os.path.join(folder, "n_%s.fine.stl" % name))
    with open(path + ".json", "w") as file:
        json.dump(report, file, indent=1, sort_keys=True)
    print("%-20s %-6s %4d faces  %s  triangles %s" % (
        name, "turned" if turn else "", len(faces), " ".join("%s %d" % pair for pair in sorted(counts.items())),
        " ".join(str(n) for n in report["triangles"].values())), flush=True)


def main():
    parser = argparse.ArgumentParser(description="Builds parts by OpenCASCADE: their STEP files, triangulations and figures.")
    parser.add_argument("folder")
    parser.add_argument("--only", default="", metavar="WORD", help="only parts whose names contain this")
    arguments = parser.parse_args()
    os.makedirs(arguments.folder, exist_ok=True)
    failed = []
    for i, name in enumerate(PARTS):
        if arguments.only not in name:
            continue
        try:
            make(name, arguments.folder, i % 3 == 2)
        except (RuntimeError, ValueError, Part.OCCError) as error:
            failed.append(name)
            print("%-20s FAILED: %s" % (name, error), flush=True)
    if failed:
        sys.exit("%d parts failed: %s" % (len(failed), " ".join(failed)))


if __name__ == "__main__":
    main()

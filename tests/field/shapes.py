"""Shapes of the corpus, and their files as other programs write them."""

import math
import struct

CUBE_POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
CUBE_FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def torus(rings=12, around=8, scale=1.0, at=(0.0, 0.0, 0.0)):
    """96 points and 96 quads of a ring of radius 1 with a tube of 0.4."""
    points, faces = [], []
    for i in range(rings):
        for j in range(around):
            a, b = 2 * math.pi * i / rings, 2 * math.pi * j / around
            r = 1 + 0.4 * math.cos(b)
            p = (r * math.cos(a), r * math.sin(a), 0.4 * math.sin(b))
            points.append(tuple(at[k] + scale * p[k] for k in range(3)))
            k, l = (i + 1) % rings, (j + 1) % around
            faces.append((i * around + j, k * around + j, k * around + l, i * around + l))
    return points, faces


def triangles(faces):
    return [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]


def sphere(count):
    """Points of the unit sphere along a spiral."""
    points = []
    for k in range(count):
        z = 1 - (2 * k + 1) / count
        a, r = k * math.pi * (3 - math.sqrt(5)), math.sqrt(1 - z * z)
        points.append((r * math.cos(a), r * math.sin(a), z))
    return points


def merged(points, faces):
    """With one point where several are equal."""
    numbers, kept = {}, []
    for p in points:
        if p not in numbers:
            numbers[p] = len(kept)
            kept.append(p)
    return kept, [tuple(numbers[points[i]] for i in f) for f in faces]


def moved(points, by):
    return [tuple(p[k] + by[k] for k in range(3)) for p in points]


def packed(kind, rows):
    return b"".join(struct.pack(kind, *row) for row in rows)


# ---------------------------------------------------------------- formats


def lines(form, rows):
    return "".join(form % tuple(row) + "\n" for row in rows)


def obj_faces(faces):
    return "".join("f " + " ".join(str(i + 1) for i in f) + "\n" for f in faces)


def obj(points, faces, number="%.9g"):
    return lines(f"v {number} {number} {number}", points) + obj_faces(faces)


def counted_faces(faces):
    return "".join(f"{len(f)} " + " ".join(map(str, f)) + "\n" for f in faces)


def off(points, faces, head="OFF\n96 96 0\n"):
    return head + lines("%.9g %.9g %.9g", points) + counted_faces(faces)


def ply_head(form, vertices, faces, kind="float", further=(), face="property list uchar int vertex_indices"):
    head = ["ply", f"format {form} 1.0", "comment made here", f"element vertex {vertices}"]
    head += [f"property {kind} {axis}" for axis in "xyz"] + [f"property {p}" for p in further]
    if faces is not None:
        head += [f"element face {faces}", face]
    return "\n".join(head + ["end_header", ""])


def ply(points, faces, kind="float", further=(), values=""):
    """Text; `values` stand behind each position."""
    head = ply_head("ascii", len(points), len(faces), kind, further)
    return head + lines("%.9g %.9g %.9g" + values, points) + counted_faces(faces)


_CODES = {"uchar": "B", "ushort": "H", "uint": "I", "int": "i", "float": "f", "double": "d"}


def ply_binary(points, faces, order="<", count="uchar", index="int", kind="float", end="\n", name="vertex_indices"):
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    face = f"property list {count} {index} {name}"
    head = ply_head(form, len(points), len(faces), kind, face=face)
    body = packed(f"{order}3{_CODES[kind]}", points)
    for f in faces:
        body += struct.pack(f"{order}{_CODES[count]}{len(f)}{_CODES[index]}", len(f), *f)
    return head.replace("\n", end).encode() + body


def stl_binary(corners, head=b"", count=None, behind=0, tail=b""):
    """`corners`: three points a triangle; `behind`: the two bytes after each."""
    data = head.ljust(80, b" ")[:80] + struct.pack("<I", len(corners) if count is None else count)
    for triangle in corners:
        data += struct.pack("<12fH", 0, 0, 0, *(c for p in triangle for c in p), behind)
    return data + tail


def stl_text(corners, name="part", normal="0 0 0", end="\n"):
    rows = [f"solid {name}"]
    for triangle in corners:
        rows += [f"facet normal {normal}", " outer loop"]
        rows += ["  vertex %.9e %.9e %.9e" % p for p in triangle] + [" endloop", "endfacet"]
    return end.join(rows + [f"endsolid {name}", ""])


def corners_of(points, faces):
    return [tuple(points[i] for i in t) for t in triangles(faces)]


def pcd(fields, sizes, types, counts, points, data, kind="binary", width=None, height=1, view="0 0 0 1 0 0 0"):
    rows = ["# .PCD v0.7", "VERSION 0.7", f"FIELDS {fields}", f"SIZE {sizes}", f"TYPE {types}"]
    rows += [f"COUNT {counts}", f"WIDTH {width or points}", f"HEIGHT {height}", f"VIEWPOINT {view}"]
    return "\n".join(rows + [f"POINTS {points}", f"DATA {kind}", ""]).encode() + data


_LAS_BYTES = {0: 20, 1: 28, 2: 26, 3: 34, 6: 30, 7: 36, 8: 38, 10: 67}


def las(points, minor=4, form=6, further=0, scale=0.001, offset=(0, 0, 0), legacy=0, count=None, padding=0, head=None, withheld=False):
    size = head or (375 if minor == 4 else 227)
    data = b"LASF" + struct.pack("<HH", 0, 0) + bytes(16) + bytes([1, minor]) + bytes(64)
    data += struct.pack("<HHHIIBHI", 1, 2026, size, size + padding, 0, form, _LAS_BYTES[form] + further, legacy)
    data += bytes(20) + struct.pack("<6d", *[scale] * 3, *offset)
    for k in range(3):
        data += struct.pack("<2d", max(p[k] for p in points), min(p[k] for p in points))
    if minor == 4:
        total = len(points) if count is None else count
        data += struct.pack("<QQIQ", 0, 0, 0, total) + bytes(120)
    data = data.ljust(size, b"\0") + b"\xab" * padding
    for k, p in enumerate(points):
        steps = [round((p[j] - offset[j]) / (scale or 0.001)) for j in range(3)]
        record = struct.pack("<3iH", *steps, 100)
        if form >= 6:
            record += struct.pack("<BBBBhHd", 0x11, 4 if withheld and k % 3 == 0 else 0, 2, 0, 0, 1, 1.0)
        else:
            record += struct.pack("<BBbBH", 0x11, 2, 0, 0, 1)
        data += record.ljust(_LAS_BYTES[form], b"\x22") + b"\x77" * further
    return data


UNIT = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]


def ptx(points, columns, rows, matrix=UNIT, behind=" 0.5", misses=lambda k: False):
    text = f"{columns}\n{rows}\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + lines("%.9g %.9g %.9g %.9g", matrix)
    for k, p in enumerate(points):
        text += ("0 0 0" if misses(k) else "%g %g %g" % p) + behind + "\n"
    return text

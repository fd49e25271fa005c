"""What the rows of the table are tried on."""

import base64
import json
import math
import random
import struct
import zlib


def sheet():
    """An open sheet of triangles, two of whose vertices are each there twice: at one place, and almost. An
    edge is tagged, and normals are split along another."""
    points = [(x, y, 0.3 * (x == 1) + 0.2 * (y == 2) - 0.05 * x * y) for y in range(4) for x in range(3)]
    points += [(1, 1, 0.25), (2.0000001, 2, 0)]
    faces = [(3 * y + x, 3 * y + x + 1, 3 * y + x + 4) for y in range(3) for x in range(2)]
    faces += [(3 * y + x, 3 * y + x + 4, 3 * y + x + 3) for y in range(3) for x in range(2)]
    faces[0], faces[-1] = (0, 1, 12), (7, 13, 10)
    return "".join(
        [f"v {x} {y} {z}\n" for x, y, z in points] + ["vn 0 0 1\nvn 1 0 1\n"] +
        ["f " + " ".join(f"{v + 1}//{2 if i % 2 else 1}" for v in face) + "\n" for i, face in enumerate(faces)] +
        ["t crease 2/1/0 4 7 10\n"])


def height(x, y):
    return 0.2 * math.sin(5 * x) * math.cos(4 * y)


def asset():
    """A glTF of one wavy sheet with texture coordinates, under a node with something of its own."""
    n = 4
    grid = [(x / n, y / n) for y in range(n + 1) for x in range(n + 1)]
    positions = [number for x, y in grid for number in (x, y, height(x, y))]
    corners = [(n + 1) * y + x + step for y in range(n) for x in range(n)
               for step in (0, 1, n + 2, 0, n + 2, n + 1)]
    parts = [struct.pack(f"<{len(positions)}f", *positions),
             struct.pack(f"<{2 * len(grid)}f", *[number for place in grid for number in place]),
             struct.pack(f"<{len(corners)}H", *corners)]
    starts = [sum(map(len, parts[:i])) for i in range(3)]
    buffer = b"".join(parts)
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "extras": {"kept": 1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(grid), "type": "VEC3",
             "min": [min(positions[i::3]) for i in range(3)], "max": [max(positions[i::3]) for i in range(3)]},
            {"bufferView": 1, "componentType": 5126, "count": len(grid), "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": len(corners), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": len(part)}
                        for start, part in zip(starts, parts)],
        "buffers": [{"byteLength": len(buffer),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()}]})


def picture():
    """A PNG of one brown point."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\x00\x80\x50\x20")) + chunk(b"IEND", b""))


BOX = """mtllib box.mtl\nusemtl wood
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
f 1/1 4/2 3/3 2/4\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/3 5/4\nf 2/1 3/2 7/3 6/4\nf 3/1 4/2 8/3 7/4\nf 4/1 1/2 5/3 8/4
"""

# A box one of whose vertices is off its planes.
ROUGH = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1.0004\nv 0 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""


def waves(faces_of, jitter=0.0, width=1.0):
    """A wavy sheet of 8 by 8 quads, each as faces_of(a, b, c, d) has it, its inner vertices off by up to so much
    of a quad's side."""
    n, numbers = 8, random.Random(5)
    lines = []
    for i in range((n + 1) ** 2):
        place = divmod(i, n + 1)
        y, x = (at + (jitter * numbers.uniform(-1, 1) if 0 < at < n else 0) for at in place)
        lines.append(f"v {x / n:.6g} {width * y / n:.6g} {height(x / n, y / n):.6g}")
    for y, x in ((y, x) for y in range(n) for x in range(n)):
        a = (n + 1) * y + x + 1
        lines += ["f " + " ".join(map(str, face)) for face in faces_of(a, a + 1, a + n + 2, a + n + 1)]
    return "\n".join(lines) + "\n"


def quad(*corners):
    return [corners]


def triangles(a, b, c, d):
    return [(a, b, c), (a, c, d)]


# An L of six corners, and a square in its notch.
NOTCH = """v 0 0 0\nv 2 0 0.2\nv 2 1 0\nv 1 1 0.3\nv 1 2 0\nv 0 2 0.2\nv 2 2 0.4
f 1 2 3 4 5 6\nf 4 3 7 5
"""


def ball():
    """Points with noise about a ball that is open at the top, about a small one beside it, and a few far off."""
    numbers = random.Random(3)

    def around(center, radius, count, top=1.0):
        for i in range(count):
            z = 1 - (2 * i + 1) / count
            if z > top:
                continue
            side, angle = math.sqrt(1 - z * z), i * math.pi * (3 - math.sqrt(5))
            far = radius * (1 + 0.004 * numbers.gauss(0, 1))
            yield (center + far * side * math.cos(angle), far * side * math.sin(angle), far * z)

    points = [*around(0, 1, 900, top=0.6), *around(2, 0.125, 14)]
    points += [tuple(numbers.uniform(-2, 3) for _ in range(3)) for _ in range(6)]
    return "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points)


def write(folder):
    (folder / "sheet.obj").write_text(sheet())
    (folder / "waves.obj").write_text(waves(quad))
    (folder / "uneven.obj").write_text(waves(triangles, jitter=0.35, width=0.3))
    (folder / "notch.obj").write_text(NOTCH)
    (folder / "asset.gltf").write_text(asset())
    (folder / "oak.png").write_bytes(picture())
    (folder / "rough.obj").write_text(ROUGH)
    (folder / "model").mkdir()
    (folder / "model/box.obj").write_text(BOX)
    (folder / "model/box.mtl").write_text("newmtl wood\nmap_Kd ../oak.png\n")
    (folder / "ball.xyz").write_text(ball())

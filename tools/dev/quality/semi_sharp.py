#!/usr/bin/env python3
"""How far semi-sharp edges turn, beside Catmull-Clark's of the same sharpness: semi_sharp.py PLANISH.

Two shapes: a cube of 6 x 6 quads a side whose twelve edges are tagged, and a torus of 24 x 4 quads, a ring of square section, with a
tagged circle along its outer equator. `planish fit` makes of each the default surface and, by OpenSubdiv's rules, the Catmull-Clark
surface through the same vertices. The table says within which distance of the edge, in edges of the mesh, half, three quarters and nine
tenths of the turn to 45 degrees are done."""

import math
import pathlib
import subprocess
import sys
import tempfile

SHARPNESS = [0, 0.5, 1, 2, 3, 4, 6, 10]
LEVEL = 5


def cube(n):
    """Unit cube, n x n quads a side; the vertices of its edges."""
    numbers, points, faces = {}, [], []

    def vertex(p):
        if p not in numbers:
            numbers[p] = len(points)
            points.append([c / n for c in p])
        return numbers[p]

    for axis in range(3):
        for side in (0, n):
            for i in range(n):
                for j in range(n):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, u, v
                        corners.append(vertex(tuple(p)))
                    faces.append(corners if side else corners[::-1])
    on_edge = {k for p, k in numbers.items() if sum(c in (0, n) for c in p) >= 2}
    return points, faces, on_edge


def torus(n, m):
    points = [[(1 + 0.4 * math.cos(2 * math.pi * j / m)) * math.cos(2 * math.pi * i / n),
               (1 + 0.4 * math.cos(2 * math.pi * j / m)) * math.sin(2 * math.pi * i / n),
               0.4 * math.sin(2 * math.pi * j / m)] for i in range(n) for j in range(m)]
    faces = [[i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m]
             for i in range(n) for j in range(m)]
    return points, faces, {i * m for i in range(n)}


def write(path, shape, sharpness):
    points, faces, on_edge = shape
    edges = {tuple(sorted((f[k], f[(k + 1) % len(f)]))) for f in faces for k in range(len(f))}
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points)
        file.writelines("f " + " ".join(str(v + 1) for v in f) + "\n" for f in faces)
        if sharpness > 0:
            file.writelines(f"t crease 2/1/0 {a} {b} {sharpness}\n" for a, b in sorted(edges)
                            if a in on_edge and b in on_edge)


def read(path):
    """Positions and normals of an OBJ."""
    rows = {"v": [], "vn": []}
    with open(path, encoding="ascii") as file:
        for line in file:
            word, *rest = line.split(maxsplit=1)
            if word in rows:
                rows[word].append([float(c) for c in rest[0].split()])
    return rows["v"], rows["vn"]


def profile_of_cube(points, normals, n):
    """(distance from the edge x = 1, z = 1 along the side z, angle of the normal from the corner's half) at the plane y = 1/2."""
    found = []
    for p, normal in zip(points, normals):
        if abs(p[1] - 0.5) < 1e-7 and p[2] > p[0] - 1e-9 and p[0] > 0.5 and normal[2] > 0:
            found.append(((1 - p[0]) * n, math.degrees(math.atan2(normal[2], normal[0])) - 45))
    return sorted(found)


def profile_of_torus(points, normals):
    """The same of the section y = 0 above the outer equator."""
    found = []
    for p, normal in zip(points, normals):
        if abs(p[1]) < 1e-7 and p[0] > 1 and p[2] >= -1e-9:
            distance = math.hypot(p[0] - 1.4, p[2]) / (0.4 * math.sqrt(2))
            found.append((distance, math.degrees(math.atan2(normal[2], normal[0]))))
    return sorted(found)


def width(profile, part):
    """Where the normal has turned by this part of the total for good."""
    last = 0.0
    for distance, angle in profile:
        if angle < part * 45:
            last = distance
    return last


def main():
    planish = pathlib.Path(sys.argv[1]).resolve()
    shapes = {"cube": (cube(6), lambda points, normals: profile_of_cube(points, normals, 6)),
              "torus": (torus(24, 4), profile_of_torus)}
    print("shape  sharpness   default: half, 3/4, 9/10   Catmull-Clark: the same")
    with tempfile.TemporaryDirectory() as folder:
        for name, (shape, profile_of) in shapes.items():
            for sharpness in SHARPNESS:
                source = pathlib.Path(folder) / f"{name}.obj"
                write(source, shape, sharpness)
                line = f"{name:6} {sharpness:8}  "
                for flags in (["--creases", "use", "--interpolation", "fair"], ["--scheme", "catmull-clark", "--creases", "use"]):
                    out = pathlib.Path(folder) / "out.obj"
                    done = subprocess.run([planish, "fit", source, "-f", "-o", out, "--levels", str(LEVEL), *flags],
                                          capture_output=True, text=True, check=False)
                    if done.returncode != 0:
                        line += f"   exit {done.returncode}: {done.stderr.strip().splitlines()[-1]}"
                        continue
                    profile = profile_of(*read(out))
                    line += "   " + " ".join(f"{width(profile, part):6.3f}" for part in (0.5, 0.75, 0.9))
                print(line, flush=True)


if __name__ == "__main__":
    main()

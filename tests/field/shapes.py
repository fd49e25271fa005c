"""Shapes of the corpus, and their files as other programs write them."""

import math

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

"""Meshes and points of all formats but glTF."""

from case import Case, all_of, counts, passes
from shapes import torus


def cases() -> list[Case]:
    points, faces = torus()
    text = "".join("v %.9g %.9g %.9g\n" % p for p in points)
    text += "".join("f %d %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)
    is_torus = all_of(counts(vertices=96, faces=96, genus=1), passes(points))
    return [Case("obj_torus", {"a.obj": text.encode()}, "a.obj", check=is_torus)]

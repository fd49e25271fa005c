"""The lines of README that join other libraries, where these are installed."""

import pathlib
import re

import numpy as np
import pytest

import planish

README = pathlib.Path(__file__).parents[2] / "tools" / "python" / "README.md"


def lines_for(library):
    """What README shows for a library: its block of Python that imports it."""
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    (found,) = [block for block in blocks if f"import {library}" in block]
    return found


def run(library, **given):
    pytest.importorskip(library)
    names = {"planish": planish, "np": np, **given}
    exec(lines_for(library), names)  # pylint: disable=exec-used
    return names


def expect_surface(points, triangles, colors):
    """Rounder than the octahedron that was given, whose vertices it has, closed, red to blue."""
    assert len(points) > 6 and triangles.shape[1] == 3
    for axis in range(3):
        for sign in (-1, 1):
            wanted = np.zeros(3)
            wanted[axis] = sign
            assert np.linalg.norm(points - wanted, axis=1).min() < 1e-5
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6
    assert 4 / 3 < volume < 4.2
    assert colors.min() < 1e-6 and abs(colors.max() - 1) < 1e-6


OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4],
                  [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
COLORS = np.array([[1, 0, 0]] * 3 + [[0, 0, 1]] * 3, float)


def test_open3d():
    open3d = pytest.importorskip("open3d")
    given = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(OCTAHEDRON),
                                         open3d.utility.Vector3iVector(FACES))
    given.vertex_colors = open3d.utility.Vector3dVector(COLORS)
    made = run("open3d", mesh=given)["smooth"]
    assert made.is_watertight()
    expect_surface(np.asarray(made.vertices), np.asarray(made.triangles),
                   np.asarray(made.vertex_colors))


def test_trimesh():
    trimesh = pytest.importorskip("trimesh")
    given = trimesh.Trimesh(OCTAHEDRON, FACES, process=False)
    given.visual.vertex_colors = np.uint8(255 * COLORS)
    made = run("trimesh", mesh=given)["smooth"]
    assert made.is_watertight
    expect_surface(made.vertices, made.faces, made.visual.vertex_colors / 255)


def test_pyvista():
    pyvista = pytest.importorskip("pyvista")
    given = pyvista.PolyData(OCTAHEDRON, np.insert(FACES, 0, 3, axis=1))
    given.point_data["heat"] = OCTAHEDRON @ [1, 2, 3]
    made = run("pyvista", mesh=given)["smooth"]
    expect_surface(made.points, made.faces.reshape(-1, 4)[:, 1:], (made["heat"] + 3) / 6)

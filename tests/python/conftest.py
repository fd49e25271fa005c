"""What the tests of the Python module share: the command, scenes, and meshes."""

import json
import os
import pathlib
import subprocess

import numpy as np
import pytest

SCENES = pathlib.Path(os.environ["PLANISH_SCENES"])


@pytest.fixture(name="scenes")
def scenes_fixture():
    return SCENES


@pytest.fixture(name="command")
def command_fixture(tmp_path):
    """Runs `planish fit` on the CPU: the report as a dict."""

    def run(*arguments):
        report = tmp_path / "report.json"
        subprocess.run(
            [os.environ["PLANISH_EXECUTABLE"], "fit", *map(str, arguments), "--device", "cpu",
             "--report", str(report), "-f", "-q"],
            check=True,
        )
        return json.loads(report.read_text())

    return run


def cube_arrays():
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    faces = np.array(
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
        dtype=np.int32,
    )
    return corners, faces


@pytest.fixture(name="cube")
def cube_fixture():
    return cube_arrays()


@pytest.fixture(name="grid")
def grid_fixture():
    """A wavy sheet of n by n quads, as vertices and faces."""

    def make(n):
        x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
        z = 0.1 * np.sin(9 * x) * np.cos(7 * y)
        vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
        first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1)
        faces = np.stack([first, first + 1, first + n + 2, first + n + 1], axis=-1)
        return vertices, faces.astype(np.int32)

    return make

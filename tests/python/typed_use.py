"""What a caller who checks types writes; mypy reads it, nothing runs it."""

import pathlib
from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import planish

vertices = np.zeros((8, 3))
fit = planish.fit(vertices, [[0, 1, 2, 3]], method="fair", tolerance=1e-6)
assert_type(fit, planish.Fit)
surface = fit.evaluate(3, progress=lambda step, fraction: print(step, fraction))
assert_type(surface.quads, NDArray[np.int32])
assert_type(surface.normals, NDArray[np.float32])
assert_type(fit.tessellate(chord_error=1e-3, angle=10), planish.Surface)
mesh = planish.read(pathlib.Path("mesh.obj"))
planish.write("cage.obj", planish.fit(mesh, creases="auto:40").cage)
found = planish.verify(fit.cage, mesh)
assert_type(found.confirmed, bool)
try:
    planish.fit_file("a.obj", "a.glb", levels=2, threads=4)
except planish.UnusableMesh as error:
    assert_type(error.element, int)
planish.fit(mesh, method="best")  # type: ignore[call-overload]
riding = planish.Mesh(vertices, [[0, 1, 2, 3]], attributes={"heat": np.zeros(8)}, groups=["a", ("b", "c")])
assert_type(planish.fit(riding, colors=np.zeros((8, 3))).evaluate().attributes["heat"], NDArray[np.float32])
assert_type(planish.LimitSurface(fit).attributes([0], [0.5], [0.5]), dict[str, NDArray[np.float32]])
edit = fit.edit(level=1)
assert_type(edit, planish.Editor)
assert_type(edit.positions[edit.move([3], [[0, 0, 1]]).rows], NDArray[np.float64])
assert_type(edit.set_sharp([[0, 1]], [2], False).rows, NDArray[np.int64])
assert_type(edit.fit(), planish.Fit)

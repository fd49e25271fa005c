"""The smooth surface through a mesh, drawn. Arguments: a mesh and a picture to write."""

import sys

import matplotlib.pyplot as plt
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

# README begins
import planish

mesh = planish.read(sys.argv[1])
fit = planish.fit(mesh.vertices, mesh.faces, tolerance=1e-6)
surface = fit.evaluate(level=2)  # numpy arrays: positions, normals, quads
print(f"{fit.method}: off by at most {fit.max_error:.1e} of the diagonal")
# README ends

light = surface.normals[surface.quads].mean(axis=1) @ [0.5, 0.4, 0.77]
quads = Poly3DCollection(surface.positions[surface.quads])
quads.set_facecolor(plt.cm.copper(0.55 + 0.45 * light))
axes = plt.figure(figsize=(7, 5)).add_subplot(projection="3d", computed_zorder=False)
axes.add_collection3d(quads)
axes.scatter(*mesh.vertices.T, s=6, color="black")  # the given points, on the surface
axes.auto_scale_xyz(*surface.positions.T)
axes.set_box_aspect(surface.positions.max(axis=0) - surface.positions.min(axis=0))
plt.savefig(sys.argv[2], dpi=100, bbox_inches="tight")

"""Smooth surfaces through the points of polygon meshes.

    import planish
    fit = planish.fit(vertices, faces)   # numpy arrays (n, 3) and (m, k)
    surface = fit.evaluate(level=3)      # surface.positions, surface.normals, surface.quads
    planish.write("surface.glb", fit)

Arrays of float64 (vertices) and int32 (faces) are read where they are; others are converted once.
What comes out are read-only views of the result's own memory. Work is done on all cores without
Python's lock. Errors are subclasses of planish.Error.
"""

from ._errors import (
    Cancelled,
    DeviceLost,
    Error,
    InvalidArgument,
    MissingProgram,
    NoDevice,
    OutOfMemory,
    UnreadableInput,
    UnusableMesh,
    UnwritableOutput,
)
from ._planish import (
    Change,
    Editor,
    Fit,
    LimitSurface,
    Mesh,
    Surface,
    Verification,
    __version__,
    fit,
    fit_file,
    fit_files,
    read,
    read_points,
    reconstruct,
    verify,
    write,
)

__all__ = [
    "Cancelled",
    "Change",
    "DeviceLost",
    "Editor",
    "Error",
    "Fit",
    "InvalidArgument",
    "LimitSurface",
    "Mesh",
    "MissingProgram",
    "NoDevice",
    "OutOfMemory",
    "Surface",
    "UnreadableInput",
    "UnusableMesh",
    "UnwritableOutput",
    "Verification",
    "__version__",
    "fit",
    "fit_file",
    "fit_files",
    "read",
    "read_points",
    "reconstruct",
    "verify",
    "write",
]

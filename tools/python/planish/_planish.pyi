import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]
Integers = NDArray[np.int32]
Path = str | bytes | os.PathLike[str] | os.PathLike[bytes]
Progress = Callable[[str, float], object]
Cancelled = Callable[[], object]
Method = Literal["auto", "progressive", "fair"]
Scheme = Literal["doo-sabin", "catmull-clark", "loop"]
GivenFaces = NDArray[Any] | tuple[ArrayLike, ArrayLike] | Sequence[Sequence[int]]
Faces = Integers | tuple[Integers, Integers]

class Mesh:
    def __init__(
        self,
        vertices: ArrayLike,
        faces: GivenFaces,
        *,
        crease_edges: ArrayLike | None = ...,
        corner_vertices: ArrayLike | None = ...,
    ) -> None: ...
    @property
    def vertices(self) -> Doubles: ...
    @property
    def faces(self) -> Faces: ...
    @property
    def offsets(self) -> Integers: ...
    @property
    def indices(self) -> Integers: ...
    @property
    def crease_edges(self) -> Integers: ...

class Surface:
    @property
    def positions(self) -> Doubles: ...
    @property
    def normals(self) -> Floats: ...
    @property
    def quads(self) -> Integers: ...
    @property
    def faces(self) -> Faces: ...
    @property
    def base_vertices(self) -> Integers: ...
    @property
    def level(self) -> int: ...

class Fit:
    @property
    def cage(self) -> Mesh: ...
    @property
    def mesh(self) -> Mesh: ...
    @property
    def method(self) -> Literal["progressive", "fair"]: ...
    @property
    def converged(self) -> bool: ...
    @property
    def max_error(self) -> float: ...
    @property
    def report(self) -> dict[str, Any]: ...
    def evaluate(
        self,
        level: int = ...,
        *,
        progress: Progress | None = ...,
        cancelled: Cancelled | None = ...,
    ) -> Surface: ...
    def tessellate(
        self,
        *,
        chord_error: float = ...,
        angle: float = ...,
        progress: Progress | None = ...,
        cancelled: Cancelled | None = ...,
    ) -> Surface: ...
    def quality(self, level: int = ...) -> dict[str, Any]: ...

class LimitSurface:
    def __init__(self, fit: Fit) -> None: ...
    def evaluate(self, faces: ArrayLike, u: ArrayLike, v: ArrayLike) -> dict[str, Doubles]: ...
    def closest_point(self, points: ArrayLike) -> dict[str, NDArray[Any]]: ...
    def rays(self, origins: ArrayLike, directions: ArrayLike) -> dict[str, NDArray[Any]]: ...

class Verification:
    @property
    def confirmed(self) -> bool: ...
    @property
    def max_error(self) -> float: ...
    @property
    def rms_error(self) -> float: ...
    @property
    def worst_vertex(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...

@overload
def fit(
    vertices: Mesh,
    *,
    method: Method = ...,
    tolerance: float = ...,
    scheme: Scheme = ...,
    weights: Literal["doo-sabin", "averaged"] = ...,
    solver: Literal["chebyshev", "plain", "cg"] = ...,
    boundary: Literal["edge", "edge-and-corner"] = ...,
    creases: str = ...,
    repair: Literal["safe", "none"] = ...,
    weld: float = ...,
    max_iterations: int = ...,
    polish: int = ...,
    precision: Literal["auto", "float", "double"] = ...,
    threads: int = ...,
    progress: Progress | None = ...,
    cancelled: Cancelled | None = ...,
    crease_edges: ArrayLike | None = ...,
    corner_vertices: ArrayLike | None = ...,
) -> Fit: ...
@overload
def fit(
    vertices: ArrayLike,
    faces: GivenFaces,
    *,
    method: Method = ...,
    tolerance: float = ...,
    scheme: Scheme = ...,
    weights: Literal["doo-sabin", "averaged"] = ...,
    solver: Literal["chebyshev", "plain", "cg"] = ...,
    boundary: Literal["edge", "edge-and-corner"] = ...,
    creases: str = ...,
    repair: Literal["safe", "none"] = ...,
    weld: float = ...,
    max_iterations: int = ...,
    polish: int = ...,
    precision: Literal["auto", "float", "double"] = ...,
    threads: int = ...,
    progress: Progress | None = ...,
    cancelled: Cancelled | None = ...,
    crease_edges: ArrayLike | None = ...,
    corner_vertices: ArrayLike | None = ...,
) -> Fit: ...
def fit_file(
    input: Path,
    output: Path,
    level: int = ...,
    cage: Path | None = ...,
    *,
    method: Method = ...,
    tolerance: float = ...,
    scheme: Scheme = ...,
    weights: Literal["doo-sabin", "averaged"] = ...,
    solver: Literal["chebyshev", "plain", "cg"] = ...,
    boundary: Literal["edge", "edge-and-corner"] = ...,
    creases: str = ...,
    repair: Literal["safe", "none"] = ...,
    weld: float = ...,
    max_iterations: int = ...,
    polish: int = ...,
    precision: Literal["auto", "float", "double"] = ...,
    threads: int = ...,
    progress: Progress | None = ...,
    cancelled: Cancelled | None = ...,
) -> Fit: ...
def read(path: Path, *, split_normals: bool = ...) -> Mesh: ...
def read_points(path: Path) -> Doubles: ...
def write(path: Path, what: Fit | Surface | Mesh, *, level: int = ...) -> None: ...
def reconstruct(
    points: ArrayLike,
    *,
    tolerance: float = ...,
    target_vertices: int = ...,
    quads: bool = ...,
    spacing: Literal["adaptive", "even"] = ...,
    progress: Progress | None = ...,
    cancelled: Cancelled | None = ...,
) -> Mesh: ...
def verify(
    cage: Mesh,
    given: Mesh,
    *,
    method: Method = ...,
    tolerance: float = ...,
    scheme: Scheme = ...,
    weights: Literal["doo-sabin", "averaged"] = ...,
    solver: Literal["chebyshev", "plain", "cg"] = ...,
    boundary: Literal["edge", "edge-and-corner"] = ...,
    creases: str = ...,
    repair: Literal["safe", "none"] = ...,
    weld: float = ...,
    max_iterations: int = ...,
    polish: int = ...,
    precision: Literal["auto", "float", "double"] = ...,
    threads: int = ...,
    progress: Progress | None = ...,
    cancelled: Cancelled | None = ...,
) -> Verification: ...

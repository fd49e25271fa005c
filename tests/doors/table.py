"""One row for each option of the tables: values that every door takes, and what each makes of them.

Doors are the ways to the engine: the command, scene files, C, Python and npm. test_doors.py opens the
first four, tests/wasm/npm_door.py the command and npm."""

import dataclasses
from typing import Any


@dataclasses.dataclass
class Row:
    """What doors are given: `value`, which is not the default and changes the file."""

    value: Any
    output: str = "out.ply"
    input: str = "waves.obj"
    #: Options without which the value means nothing.
    beside: dict = dataclasses.field(default_factory=dict)
    #: Further values that are taken, with their limits.
    also: list = dataclasses.field(default_factory=list)
    #: What lies just outside, and what is no value.
    wrong: list = dataclasses.field(default_factory=list)
    #: Doors that have no such option, with the words that they refuse it by.
    refused: dict = dataclasses.field(default_factory=dict)
    #: Why the value changes no byte.
    same: str = ""
    #: Why npm makes another thing of `value`.
    other: str = ""


FAIR = {"interpolation": "fair"}
PROGRESSIVE = {"interpolation": "progressive"}
# Tags name vertices: scene files have them as lists, libraries as arrays of a mesh.
TAGS = {"command": "is no flag of planish fit", "c": "planish_mesh_arrays has it", "python": "unexpected keyword",
        "npm": "planish_mesh_arrays has it"}
# So that points are left out.
COARSE = {"tolerance_mesh": 0.02}
# Of points CGAL makes a mesh, in a program of its own.
NO_POINTS = {"npm": "planish-reconstruct"}
# npm's fitFile() has one file in memory, and gives one back.
NO_TILES = {"npm": "has files beside it"}


def of_sheet(value, output="out.obj", **more):
    return Row(value, output, "sheet.obj", **more)


def of_points(value, **more):
    return Row(value, input="ball.xyz", refused=NO_POINTS, **more)


def of_tiles(value, **more):
    return Row(value, output="tiles.json", refused=NO_TILES, **more)


def of_gltf(value, **more):
    return Row(value, input="asset.gltf", output="out.glb", **more)


ROWS = {
    "preset": Row("paper", wrong=["papre", ""]),
    "scheme": of_sheet("loop", also=["doo-sabin", "catmull-clark"], wrong=["Loop"]),
    "interpolation": Row("progressive", "out.obj", also=["auto", "fair"], wrong=["best"]),
    "weights": Row("averaged", also=["doo-sabin"], wrong=["even"]),
    "solver": Row("plain", input="model/box.obj", beside={**PROGRESSIVE, "creases": "ignore"},
                  also=["chebyshev", "cg"], wrong=["jacobi"]),
    "precision": Row("double", "out.obj", beside=PROGRESSIVE, also=["auto", "float"], wrong=["half"]),
    "boundary": of_sheet("edge-and-corner", also=["edge"], wrong=["corner"]),
    "creases": of_sheet("auto:40",
                        also=["choose", "use", "ignore", "normals", "auto", "auto:0", "auto:22.5", "auto:030",
                              "auto:180", "auto:1e-5"],
                        wrong=["auto:180.5", "auto:999", "auto:1e1", "auto:", "auto:-1", "auto:+1", "auto:.5",
                               "auto:5.", "auto:nan", "auto:30 ", "40", "AUTO"]),
    "repair": Row("none", input="notch.obj", also=["safe"], wrong=["all"]),
    "quads": of_sheet("off", also=["auto", "on"], wrong=["yes"]),
    "refine": Row("off", "out.obj", "uneven.obj", beside={"quads": "off"}, also=["auto", "on"],
                  wrong=["yes"]),
    "up": Row("z", output="out.glb", also=["y"], wrong=["x"]),
    "attributes": Row("error,curvature", also=["fold"], wrong=["normal", "error,,fold"]),
    "cage_scheme": Row("catmull-clark", also=["surface"], wrong=["loop"], same="it is of cages alone"),
    "asset": of_gltf("merge", also=["keep"], wrong=["drop"]),
    "lods": of_gltf("msft", beside={"levels": [1, 0]}, wrong=["lod"]),
    "set": of_gltf("mesh=meshes[0]:levels=1", also=["mesh=*:quads=on; material=*:creases=use"],
                   wrong=["meshes[0]:levels=1", "mesh=meshes[0]", "mesh=meshes[0]:level=1", "mesh=no:quads=on"]),
    "textures": Row("anywhere", "out.glb", "model/box.obj", other="its one file has none beside it",
                    also=["beside"], wrong=["none"]),
    "compress": of_gltf("meshopt", also=["none", "quantize"], wrong=["zip"]),
    "bake": of_gltf(64, also=[16], wrong=[0, 2**31]),
    "device": Row("cpu", refused={"python": "unexpected keyword"}, wrong=[""],
                  same="it stands for auto, too"),
    "tolerance": Row(1e-3, "out.obj", beside=PROGRESSIVE, also=[1e-6, 0.5, 1],
                     wrong=[1.5, 0, -1e-6]),
    "max_iterations": Row(3, "out.obj", beside=PROGRESSIVE, also=[0, 1, 200, 1_000_000],
                          wrong=[1_000_001, -1, 2**31]),
    "polish": Row(2, beside=FAIR, also=[0, 8, 50], wrong=[1001, -1, 2**31]),
    "within": Row(0.001, also=[0, "auto", 0.0999, "1e-3"], wrong=[1e-6, 1e-7, 0.1, -1, -0.5, "Auto"]),
    "weld": of_sheet(1e-6, also=[0, 1e-12, 0.0999], wrong=[9e-13, 0.1, -1, -0.5, 1]),
    "tile_vertices": of_tiles(256, beside={"levels": [3]}, wrong=[255, 2**31]),
    "skirts": of_tiles(True, beside={"levels": [3]}),
    "step_unit": Row("m", "out.step", also=["mm", "cm", "in", "auto"], wrong=["km"]),
    "step_analytic": Row("off", "out.step", "model/box.obj", also=["auto"], wrong=["on"]),
    "step_analytic_tolerance": Row(1e-3, "out.step", "rough.obj", also=["auto", 1e-9, 0.1], wrong=[0, -1e-6, 0.11, "Auto"]),
    "step_angle": of_sheet(2, "out.step", also=[0.25, 90], wrong=[0, -1, 90.5]),
    "step_tolerance": of_sheet(1e-3, "out.step", also=[1e-6, 1], wrong=[0, -1e-6, 1.5]),
    "step_face_size": Row(1, "out.step", beside={"step_analytic": "off"}, also=[3, 4096], wrong=[0, 4097, 2**31]),
    "crease_edges": Row([[30, 31], [31, 32]], refused=TAGS),
    "corner_vertices": Row([40], refused=TAGS),
    "levels": Row([1], also=["auto", [0]], wrong=[[7], [-1], [1, 1], [0.5]]),
    "chord_errors": Row([0.01], also=[[1]], wrong=[[0], [1.5]]),
    "angle": Row(10, also=[180], wrong=[0, 181]),
    "faces": Row([100], also=[[1]], wrong=[[0], [0.5], [7, 7]]),
    "edge_lengths": Row([0.5], also=[[1e-3]], wrong=[[0], [-1]]),
    "pixels": Row("1@100", also=["0.5@1080"], wrong=["1", "1@", "2@1", "0@9", "-1@9", "1@100,"]),
    "tolerance_mesh": of_points(1e-2, also=[0], wrong=[-1, 2]),
    "target_vertices": of_points(100, beside=COARSE, wrong=[0, -1, 2**31]),
    "spacing": of_points("even", also=["adaptive"], wrong=["odd"]),
    "outliers": of_points("off", also=["auto", "8,3"], wrong=["12", "0,2", "12,0", "K,FACTOR"]),
    "smooth": of_points(3, also=[0], wrong=[-1, 101]),
    "noise": of_points("off", also=["auto"], wrong=["on"]),
    "fill_holes": of_points(1000, also=[0], wrong=[-1, 1001]),
    "components": of_points("all", also=["auto", "largest", 10], wrong=["none", 0]),
    "min_angle": of_points(30, beside=COARSE, also=[0], wrong=[-1, 46]),
    "max_valence": of_points(7, beside=COARSE, also=[6], wrong=[5, 1001]),
}

# Several options: some contradict each other.
SEVERAL = Row(None, "out.obj")
TOGETHER = [
    {"preset": "paper", "solver": "chebyshev"},
    {"scheme": "loop", "weights": "averaged"},
    {"scheme": "catmull-clark", "preset": "paper"},
    {"scheme": "catmull-clark", "interpolation": "fair"},
    {"scheme": "loop", "quads": "on"},
    {"weights": "averaged", "boundary": "edge-and-corner", "interpolation": "progressive"},
]

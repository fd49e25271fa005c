"""One option, one meaning: the command, scene files, Python and C take and refuse the same values of
every option, and make the same bytes of them."""

import ctypes
import inspect
import json
import os
import subprocess

import pytest

import planish

# Of every option that all have, by its name in scene files: values as they are in JSON, with their
# limits and what lies just outside.
VALUES = {
    "preset": ["paper", "papre", ""],
    "scheme": ["doo-sabin", "catmull-clark", "loop", "Loop"],
    "interpolation": ["auto", "progressive", "fair", "best"],
    "weights": ["doo-sabin", "averaged", "even"],
    "solver": ["chebyshev", "plain", "cg", "jacobi"],
    "precision": ["auto", "float", "double", "half"],
    "boundary": ["edge", "edge-and-corner", "corner"],
    "creases": ["choose", "use", "ignore", "normals", "auto", "auto:0", "auto:40", "auto:22.5", "auto:030",
                "auto:180", "auto:1e-5", "auto:180.5", "auto:999", "auto:1e1", "auto:", "auto:-1",
                "auto:+1", "auto:.5", "auto:5.", "auto:nan", "auto:30 ", "40", "AUTO"],
    "repair": ["safe", "none", "all"],
    "quads": ["auto", "on", "off", "yes"],
    "refine": ["auto", "on", "off", "yes"],
    "tolerance": [1e-6, 0.5, 1, 1.5, 0, -1e-6, 1e-300],
    "within": [0, "auto", 0.001, 1e-6, 1e-7, 0.0999, 0.1, -1, -0.5, "Auto", "1e-3"],
    "weld": [0, 1e-12, 9e-13, 1e-6, 0.0999, 0.1, -1, -0.5, 1],
    "max_iterations": [0, 1, 200, 1_000_000, 1_000_001, -1, 2**31],
    "polish": [0, 8, 50, 1001, -1, 2**31],
}
# Of those that only writing STEP has, likewise.
STEP_VALUES = {
    "step_unit": ["mm", "cm", "m", "in", "auto", "km"],
    "step_angle": [0.25, 2, 90, 0, -1, 90.5],
    "step_tolerance": [1e-6, 1, 0, -1e-6, 1.5],
    "step_face_size": [1, 3, 4096, 0, 4097, 2**31],
}
CASES = [(name, value) for name, values in VALUES.items() for value in values]
# What has no meaning without another one.
BESIDE = {"polish": {"interpolation": "fair"}, "solver": {"interpolation": "progressive"},
          "max_iterations": {"interpolation": "progressive"}}
# And what contradicts each other.
TOGETHER = [
    {"scheme": "loop", "weights": "averaged"},
    {"scheme": "catmull-clark", "preset": "paper"},
    {"scheme": "catmull-clark", "interpolation": "fair"},
    {"scheme": "loop", "quads": "on"},
    {"weights": "averaged", "boundary": "edge-and-corner", "interpolation": "progressive"},
    {"preset": "paper", "solver": "chebyshev"},
]
ALL = [{**BESIDE.get(name, {}), name: value} for name, value in CASES] + TOGETHER

# An open sheet of triangles, two of whose vertices are each there twice: at one place, and almost. An
# edge is tagged, and normals are split along another.
MESH = "".join(
    f"v {x} {y} {0.3 * (x == 1) + 0.2 * (y == 2) - 0.05 * x * y}\n" for y in range(4) for x in range(3)
) + "v 1 1 0.25\nv 2.0000001 2 0\nvn 0 0 1\nvn 1 0 1\n"
FACES = [(3 * y + x, 3 * y + x + 1, 3 * y + x + 4) for y in range(3) for x in range(2)]
FACES += [(3 * y + x, 3 * y + x + 4, 3 * y + x + 3) for y in range(3) for x in range(2)]
FACES[0] = (0, 1, 12)
FACES[-1] = (7, 13, 10)


@pytest.fixture(name="mesh")
def mesh_fixture(tmp_path):
    path = tmp_path / "sheet.obj"
    lines = [
        "f " + " ".join(f"{v + 1}//{2 if i % 2 else 1}" for v in face)
        for i, face in enumerate(FACES)
    ]
    path.write_text(MESH + "\n".join(lines) + "\nt crease 2/1/0 4 7 10\n")
    return path


def text_of(value):
    return value if isinstance(value, str) else repr(value)


def flags_of(options):
    return [word for name, value in options.items()
            for word in ("--" + name.replace("_", "-"), text_of(value))]


def by_command(mesh, options, folder, ending="ply"):
    out = folder / f"command.{ending}"
    done = subprocess.run(
        [os.environ["PLANISH_EXECUTABLE"], "fit", mesh, "-o", out, "--levels", "1", "--device", "cpu",
         "-f", "-q", *flags_of(options)], check=False, capture_output=True)
    if done.returncode in (0, 5):
        return out.read_bytes()
    assert done.returncode in (2, 4), done.stderr
    return done.returncode


def by_python(mesh, options, folder, ending="ply"):
    out = folder / f"python.{ending}"
    keywords = {"method" if name == "interpolation" else name: value
                for name, value in options.items()}
    try:
        planish.fit_file(mesh, out, 1, **keywords)
    except planish.InvalidArgument:
        return 2
    except planish.UnusableMesh:
        return 4
    return out.read_bytes()


def by_c(library, mesh, options, folder, ending="ply"):
    out = folder / f"c.{ending}"
    own = ctypes.c_void_p()
    assert library.planish_options_create(ctypes.byref(own)) == 0
    status = 0
    for name, value in {"levels": 1, **options}.items():
        status = status or library.planish_options_set(own, name.encode(), text_of(value).encode())
    if status == 0:
        status = library.planish_fit_file(str(mesh).encode(), str(out).encode(), own, None)
    library.planish_options_free(own)
    if status in (0, 5):
        return out.read_bytes()
    assert status in (2, 4), library.planish_last_error()
    return status


def scene_of(mesh, jobs, ending="ply"):
    return json.dumps({"version": 1, "defaults": {"levels": [1], "device": "cpu"}, "jobs": [
        {"name": str(i), "input": str(mesh), "outputs": [{"path": f"scene{i}.{ending}"}], **options}
        for i, options in jobs]})


def by_scenes(mesh, folder, expected):
    """Where the command took the options, all jobs in one scene; else each in a scene of its own."""
    scene = folder / "scene.json"

    def run(jobs):
        scene.write_text(scene_of(mesh, jobs))
        return subprocess.run([os.environ["PLANISH_EXECUTABLE"], "run", scene, "-f", "-q"],
                              check=False, capture_output=True)

    taken = [(i, options) for i, options in enumerate(ALL) if isinstance(expected[i], bytes)]
    done = run(taken)
    assert done.returncode in (0, 5, 8), done.stderr
    results = {i: (folder / f"scene{i}.ply").read_bytes() for i, _ in taken}
    for i, options in enumerate(ALL):
        if i not in results:
            code = run([(i, options)]).returncode
            # 8: a job failed; 2: the scene was refused before any work.
            results[i] = expected[i] if code == 8 else code
    return results


def library_for_c():
    if "PLANISH_LOADABLE" not in os.environ:
        return None
    library = ctypes.CDLL(os.environ["PLANISH_LOADABLE"])
    library.planish_last_error.restype = ctypes.c_char_p
    return library


def test_step_means_the_same_everywhere(mesh, tmp_path):
    library = library_for_c()
    fit = planish.fit_file(mesh, tmp_path / "a.step")
    taken = set()
    for name, values in STEP_VALUES.items():
        for value in values:
            options = {name: value}
            expected = by_command(mesh, options, tmp_path, "step")
            assert by_python(mesh, options, tmp_path, "step") == expected, options
            if library:
                assert by_c(library, mesh, options, tmp_path, "step") == expected, options
            scene = tmp_path / "step.json"
            scene.write_text(scene_of(mesh, [(0, options)], "step"))
            done = subprocess.run([os.environ["PLANISH_EXECUTABLE"], "run", scene, "-f", "-q"],
                                  check=False, capture_output=True)
            if isinstance(expected, int):
                assert done.returncode == expected, options
                with pytest.raises(planish.InvalidArgument, match=name):
                    planish.write(tmp_path / "b.step", fit, **options)
            else:
                assert (tmp_path / "scene0.step").read_bytes() == expected, options
                planish.write(tmp_path / "b.step", fit, **options)
                assert (tmp_path / "b.step").read_bytes() == expected, options
                taken.add(expected)
    assert len(taken) > 6
    with pytest.raises(TypeError, match="step_unit"):
        planish.fit(fit.mesh, step_unit="m")


def test_every_value_means_the_same_everywhere(mesh, tmp_path):
    expected = [by_command(mesh, options, tmp_path) for options in ALL]
    in_python = [by_python(mesh, options, tmp_path) for options in ALL]
    in_scenes = by_scenes(mesh, tmp_path, expected)
    library = library_for_c()
    for i, options in enumerate(ALL):
        shown = expected[i] if isinstance(expected[i], int) else "taken"
        assert in_python[i] == expected[i], f"Python: {options}, by the command {shown}"
        assert in_scenes[i] == expected[i], f"scene: {options}, by the command {shown}"
        if library:
            in_c = by_c(library, mesh, options, tmp_path)
            assert in_c == expected[i], f"C: {options}, by the command {shown}"
    # The values do what they are there for.
    results = {json.dumps(options): expected[i] for i, options in enumerate(ALL)}
    assert len({result for result in results.values() if isinstance(result, bytes)}) > 15
    assert results['{"weld": 0}'] != results['{"weld": 1e-06}']
    assert [results[json.dumps({"weld": value})] for value in VALUES["weld"]].count(2) == 5


def test_no_option_is_forgotten():
    """Those of the table that all have are the keys of VALUES."""
    text = inspect.getdoc(planish.fit)
    keywords = [line.split(":")[0].strip() for line in text.splitlines()
                if line.startswith("    ") and ":" in line and line[4] != " "]
    others = {"vertices", "crease_edges", "uvs", "colors", "groups", "attributes", "threads",
              "progress", "cancelled"}
    assert {"interpolation" if name == "method" else name for name in keywords} - others == set(VALUES)


def test_none_is_the_default_and_minus_one_is_refused(cube):
    planish.fit(*cube, weld=None, tolerance=None, creases=None)
    with pytest.raises(planish.InvalidArgument, match="weld: -1 is out of range; 0, or a fraction"):
        planish.fit(*cube, weld=-1)

"""What goes in and comes out: shapes, types, memory, errors."""

import gc

import numpy as np
import pytest

import planish

# More than indices reach, in a few bytes.
MANY_POINTS = np.broadcast_to(0.0, (2**33, 3))
MANY_FACES = np.broadcast_to(np.int32(0), (2**33, 3))


def test_all_forms_of_faces_mean_the_same(cube):
    vertices, faces = cube
    forms = [
        faces,
        faces.astype(np.int64),
        faces.astype(np.uint8),
        np.asfortranarray(faces),
        faces.tolist(),
        [tuple(face) for face in faces],
        (np.full(6, 4), faces.ravel()),
        ([4] * 6, faces.ravel().tolist()),
    ]
    expected = planish.fit(vertices, faces).evaluate(1).positions
    for form in forms:
        assert np.array_equal(planish.fit(vertices, form).evaluate(1).positions, expected)
    assert np.array_equal(planish.Mesh(vertices, faces).faces, faces)


def test_mixed_polygons_keep_their_sizes(cube):
    vertices, _ = cube
    mesh = planish.Mesh(vertices, [[0, 1, 2], [2, 1, 3, 7]])
    sizes, indices = mesh.faces
    assert sizes.tolist() == [3, 4] and indices.tolist() == [0, 1, 2, 2, 1, 3, 7]
    assert mesh.offsets.tolist() == [0, 3, 7]


def test_other_types_are_converted_once(cube):
    vertices, faces = cube
    expected = planish.Mesh(vertices, faces).vertices
    for form in (vertices.astype(np.float32), vertices.astype(int), vertices.tolist(),
                 np.asfortranarray(vertices), vertices[::-1][::-1]):
        assert np.array_equal(planish.Mesh(form, faces).vertices, expected)


def test_what_comes_out_is_a_view(cube):
    surface = planish.fit(*cube).evaluate(2)
    for name, dtype, columns in (("positions", np.float64, 3), ("normals", np.float32, 3),
                                 ("quads", np.int32, 4)):
        array = getattr(surface, name)
        assert array.dtype == dtype and array.shape[1] == columns
        assert array.flags.c_contiguous and not array.flags.owndata
        assert not array.flags.writeable
        # Asked twice, the same memory.
        assert np.shares_memory(array, getattr(surface, name))


def test_views_outlive_what_they_are_of(cube):
    positions = planish.fit(*cube).evaluate(3).positions
    kept = positions.copy()
    gc.collect()
    planish.fit(*cube).evaluate(3)
    assert np.array_equal(positions, kept)


def test_given_arrays_are_left_alone(cube):
    vertices, faces = cube
    before = vertices.copy(), faces.copy()
    fit = planish.fit(vertices, faces)
    assert np.array_equal(vertices, before[0]) and np.array_equal(faces, before[1])
    vertices += 1
    assert np.array_equal(fit.mesh.vertices, before[0])


@pytest.mark.parametrize(
    "vertices, faces, error, words",
    [
        ([[0, 0]], [[0, 0, 0]], planish.InvalidArgument, r"vertices: shape \(1, 2\)"),
        ([["a", "b", "c"]], [[0, 0, 0]], planish.InvalidArgument, "vertices: an array of"),
        (np.zeros((3, 3), complex), [[0, 1, 2]], planish.InvalidArgument, "complex128"),
        (np.zeros((3, 3)), np.zeros((1, 3)), planish.InvalidArgument, "integers are wanted"),
        (MANY_POINTS, [[0, 1, 2]], planish.InvalidArgument, "vertices: shape .* has more"),
        (np.zeros((3, 3)), MANY_FACES, planish.InvalidArgument, "faces: shape .* has more"),
        (np.zeros((3, 3)), (MANY_FACES[:, 0], [0]), planish.InvalidArgument, "faces.0.: shape .* has"),
        (np.zeros((3, 3)), np.zeros((2**40, 0), int), planish.InvalidArgument, "has more than 2"),
        (np.zeros((3, 3)), np.zeros((5, 0), int), planish.InvalidArgument, "so none has a corner"),
        (np.zeros((3, 3)), np.zeros(3, int), planish.InvalidArgument, r"shape \(3,\)"),
        (np.zeros((3, 3)), np.array([[0, 1, 2**40]]), planish.InvalidArgument, "32 bits"),
        (np.zeros((3, 3)), np.array([[0, 1, 2**64 - 1]], np.uint64), planish.UnusableMesh, "-1"),
        (np.zeros((3, 3)), ([4], [0, 1, 2]), planish.InvalidArgument, "add up to 4"),
        (np.zeros((3, 3)), ([-3, 6], [0, 1, 2]), planish.InvalidArgument, "size -3"),
        (np.zeros((3, 3)), ([2], [0, 1, 2]), planish.InvalidArgument, "add up to 2"),
        (np.zeros((3, 3)), [[0, 1, 3]], planish.UnusableMesh, "names vertex 3 of 3"),
        (np.zeros((3, 3)), [[0, 1, -1]], planish.UnusableMesh, "names vertex -1 of 3"),
        (np.zeros((3, 3)), [0, 1, 2], planish.InvalidArgument, "no sequence"),
        (np.zeros((3, 3)), [[0, 1, 2]], planish.UnusableMesh, "mesh"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], planish.UnusableMesh, "mesh"),
        (np.zeros((0, 3)), [], planish.UnusableMesh, "mesh"),
        ([], [], planish.UnusableMesh, "mesh"),
    ],
)
def test_wrong_arrays_are_refused(vertices, faces, error, words):
    with pytest.raises(error, match=words):
        planish.fit(vertices, faces)
    if "names" in words or error is planish.InvalidArgument:
        with pytest.raises(error, match=words):
            planish.Mesh(vertices, faces)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"method": "best"}, "method: \"best\" is not one of auto, progressive, fair"),
        ({"scheme": "doosabin"}, "one of doo-sabin"),
        ({"tolerance": 0}, "tolerance: 0 is out of range"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"tolerance": "small"}, "a number is wanted"),
        ({"creases": "40"}, "auto:DEGREES"),
        ({"creases": "auto:x"}, "no angle of 0 to 180 degrees"),
        ({"repair": True}, "repair"),
        ({"weld": 0.5}, "weld: 0.5 is out of range"),
        ({"max_iterations": -1}, "max_iterations"),
        ({"threads": 10**6}, "threads"),
        ({"method": "fair", "scheme": "loop"}, "[Ff]air"),
        ({"crease_edges": [[0, 1, 2]]}, r"shape \(m, 2\)"),
    ],
)
def test_wrong_options_are_refused(cube, options, words):
    with pytest.raises(planish.InvalidArgument, match=words):
        planish.fit(*cube, **options)


def test_unknown_options_are_refused(cube):
    with pytest.raises(TypeError, match="unexpected keyword argument 'tolerence'"):
        planish.fit(*cube, tolerence=1e-3)


def test_errors_are_one_family(cube):
    with pytest.raises(planish.Error) as caught:
        planish.fit(cube[0], [[0, 1, 9]])
    assert caught.value.element == 0 and isinstance(caught.value, ValueError)
    for name in ("InvalidArgument", "UnreadableInput", "UnusableMesh", "NoDevice", "DeviceLost",
                 "OutOfMemory", "UnwritableOutput", "Cancelled"):
        assert issubclass(getattr(planish, name), planish.Error)


def test_files_that_are_none(cube, tmp_path):
    with pytest.raises(planish.UnreadableInput, match="none.obj"):
        planish.read(tmp_path / "none.obj")
    (tmp_path / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(planish.UnreadableInput, match="bad.obj:2"):
        planish.read(str(tmp_path / "bad.obj"))
    fit = planish.fit(*cube)
    with pytest.raises(planish.UnwritableOutput):
        planish.write(tmp_path / "none" / "a.glb", fit)
    with pytest.raises(planish.InvalidArgument, match="glb"):
        planish.write(tmp_path / "a.iges", fit)
    with pytest.raises(planish.InvalidArgument):
        fit.evaluate(7)
    with pytest.raises(TypeError):
        planish.write(tmp_path / "a.glb", 7)
    assert not (tmp_path / "a.iges").exists()


def test_repair_can_be_refused(cube):
    vertices, faces = cube
    turned = faces.copy()
    turned[0] = turned[0][::-1]
    with pytest.raises(planish.UnusableMesh, match=r"repair\(\) mends this"):
        planish.fit(vertices, turned, repair="none")
    fit = planish.fit(vertices, turned)
    assert fit.report["warnings"][0]["code"] == "turned-faces"


def test_readers_warn_of_what_they_pass_over(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    mesh = tmp_path / "odd.ply"
    mesh.write_text(head + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                    "0 0 0\n1 0 0 7\n0 1 0\n3 0 1 2\n")
    with pytest.warns(UserWarning, match="odd.ply:11"):
        assert planish.read(mesh).vertices.shape == (3, 3)
    points = tmp_path / "points.ply"
    points.write_text(head + "end_header\n0 0 0\n1 0 0 7\n0 1 0\n")
    with pytest.warns(UserWarning, match="points.ply:9"):
        assert planish.read_points(points).shape == (3, 3)


def test_memory_that_runs_out_is_an_error_of_the_family(grid):
    resource = pytest.importorskip("resource")
    points, faces = grid(100)
    points = np.tile(points, (40, 1))
    before = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used, before[1]))
    try:
        with pytest.raises(planish.OutOfMemory, match="out of memory; take") as caught:
            planish.fit(points, faces)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
    assert isinstance(caught.value, MemoryError)

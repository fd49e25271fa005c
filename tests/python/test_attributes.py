"""What rides on meshes and surfaces, and copies of all objects."""

import copy
import pickle

import numpy as np
import pytest

import planish


def riding(cube):
    """A cube with everything on it; its numbers are linear in the position."""
    vertices, faces = cube
    return planish.Mesh(
        vertices, faces,
        uvs=[[0, 0], [1, 0], [1, 1], [0, 1]], face_uvs=np.tile([0, 1, 2, 3], 6),
        colors=np.linspace(0, 1, 24).reshape(8, 3),
        groups=["top", ("rest", "stone")], face_groups=[0, 1, 1, 1, 1, 1],
        attributes={"heat": vertices @ [1, 2, 3], "flow": vertices * 7,
                    "wide": np.arange(8 * 9).reshape(8, 9)},
    )


def test_a_mesh_gives_back_what_it_was_given(cube):
    mesh = riding(cube)
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert mesh.face_uvs.tolist() == [0, 1, 2, 3] * 6
    assert np.allclose(mesh.colors[:, :3], np.linspace(0, 1, 24).reshape(8, 3))
    assert np.all(mesh.colors[:, 3] == 1)
    assert mesh.groups == [("top", ""), ("rest", "stone")]
    assert mesh.face_groups.tolist() == [0, 1, 1, 1, 1, 1]
    assert mesh.attributes["heat"].shape == (8,) and mesh.attributes["flow"].shape == (8, 3)
    assert np.array_equal(mesh.attributes["wide"], np.arange(72).reshape(8, 9))
    for array in (mesh.uvs, mesh.colors, mesh.attributes["heat"]):
        assert not array.flags.writeable and not array.flags.owndata
    plain = planish.Mesh(*cube)
    assert plain.uvs.shape == (0, 2) and plain.colors.shape == (0, 4) and plain.attributes == {}


@pytest.mark.parametrize("method", ["progressive", "fair"])
@pytest.mark.parametrize("level", [0, 1, 3])
def test_numbers_go_from_vertex_to_vertex(cube, method, level):
    mesh = riding(cube)
    x, y = cube[0][:, 0], cube[0][:, 1]
    shares = np.stack([0.5 * x * x, y / 3, 1 - 0.5 * x * x - y / 3], axis=1)
    attributes = dict(mesh.attributes) | {"shares": shares}
    fit = planish.fit(planish.Mesh(*cube, colors=mesh.colors, attributes=attributes), method=method)
    surface = fit.evaluate(level)
    heat = surface.attributes["heat"]
    assert np.allclose(heat[:8], mesh.attributes["heat"], atol=1e-5)
    assert heat.min() >= mesh.attributes["heat"].min() and heat.max() <= mesh.attributes["heat"].max()
    # Shares of a whole stay such.
    assert np.allclose(surface.attributes["shares"].sum(axis=1), 1, atol=1e-5)
    assert np.array_equal(surface.attributes["wide"][:8], np.arange(72).reshape(8, 9))
    assert len(heat) == len(surface.positions) == len(surface.colors)
    # The corners of the cube and the means of its faces and edges.
    first = np.unique(np.round(planish.fit(riding(cube)).evaluate(1).attributes["flow"], 4), axis=0)
    assert len(first) == 8 + 6 + 12


def test_places_have_what_levels_have(cube):
    fit = planish.fit(riding(cube))
    limit = planish.LimitSurface(fit)
    places = [[f, u, v] for f in range(6) for u in (0, 0.5, 1) for v in (0, 0.5, 1)]
    f, u, v = np.array(places).T
    f = f.astype(int)
    found = limit.attributes(f, u, v)
    points = limit.evaluate(f, u, v)["position"]
    surface = fit.evaluate(1)
    for k, point in enumerate(points):
        row = np.argmin(np.linalg.norm(surface.positions - point, axis=1))
        for name, values in surface.attributes.items():
            assert np.allclose(found[name][k], values[row], atol=1e-5), name
    assert found["heat"].shape == (54,) and found["wide"].shape == (54, 9)
    with pytest.raises(planish.InvalidArgument):
        limit.attributes([6], [0.5], [0.5])


@pytest.mark.parametrize("scheme, level", [("catmull-clark", 2), ("doo-sabin", None)])
def test_every_surface_has_them(grid, scheme, level):
    vertices, faces = grid(4)
    z = vertices[:, 2].astype(np.float32)
    fit = planish.fit(vertices, faces, scheme=scheme, attributes={"height": z})
    surface = fit.tessellate(chord_error=1e-3) if level is None else fit.evaluate(level)
    height = surface.attributes["height"]
    given = surface.base_vertices
    assert len(height) == len(surface.positions)
    assert np.array_equal(height[: len(given)], z[given])
    assert z.min() <= height.min() and height.max() <= z.max()


def test_repair_and_welding_keep_rows_together(cube):
    vertices, faces = cube
    # Each face has vertices of its own, and one vertex is of none.
    split = np.concatenate([[[9.0, 9, 9]], vertices[faces].reshape(-1, 3)])
    apart = 1 + np.arange(24).reshape(6, 4)
    heat = split @ [1, 2, 3]
    fit = planish.fit(split, apart, weld=0, attributes={"heat": heat})
    fitted = fit.mesh
    used = np.unique(fitted.indices)
    assert len(used) == 8
    assert np.allclose(fitted.attributes["heat"], fitted.vertices @ [1, 2, 3])
    surface = fit.evaluate(0)
    assert np.allclose(surface.attributes["heat"], surface.positions @ [1, 2, 3], atol=1e-4)


def test_files_keep_them(cube, tmp_path):
    fit = planish.fit(riding(cube))
    planish.write(tmp_path / "a.ply", fit, level=2)
    read = planish.read(tmp_path / "a.ply")
    surface = fit.evaluate(2)
    assert np.array_equal(read.attributes["heat"], surface.attributes["heat"])
    flow = np.stack([read.attributes[f"flow_{k}"] for k in range(3)], axis=1)
    assert np.array_equal(flow, surface.attributes["flow"])
    planish.write(tmp_path / "b.ply", surface)
    again = planish.read(tmp_path / "b.ply")
    assert np.array_equal(again.attributes["wide_8"], surface.attributes["wide"][:, 8])
    planish.write(tmp_path / "mesh.ply", riding(cube))
    assert np.array_equal(planish.read(tmp_path / "mesh.ply").attributes["heat"],
                          riding(cube).attributes["heat"])
    planish.write(tmp_path / "c.glb", fit, level=1)
    data = (tmp_path / "c.glb").read_bytes()
    assert b'"_HEAT"' in data and b'"_FLOW"' in data and b'"_WIDE_8"' in data


def test_bytes_are_srgb_colors(cube):
    colors = np.zeros((8, 4), np.uint8)
    colors[0] = [255, 188, 0, 128]
    mesh = planish.Mesh(*cube, colors=colors)
    assert np.allclose(mesh.colors[0], [1, 0.5029, 0, 128 / 255], atol=1e-4)


def test_texture_coordinates_of_vertices_and_of_corners(cube):
    vertices, faces = cube
    mesh = planish.Mesh(vertices, faces, uvs=vertices[:, :2])
    assert np.array_equal(mesh.face_uvs, faces.ravel())
    mesh = planish.Mesh(vertices, faces, uvs=vertices[faces.ravel(), :2])
    assert np.array_equal(mesh.face_uvs, np.arange(24))


@pytest.mark.parametrize(
    "keywords, words",
    [
        ({"uvs": np.zeros((7, 2))}, "uvs: 7 entries where the mesh has 8 vertices; name others"),
        ({"uvs": np.zeros((8, 3))}, r"uvs: shape \(8, 3\); numbers of shape \(n, 2\)"),
        ({"uvs": np.full((8, 2), np.nan)}, "uvs: entry 0 is nan"),
        ({"face_uvs": [0]}, "face_uvs: name texture coordinates; give uvs"),
        ({"uvs": np.zeros((1, 2)), "face_uvs": [0]}, "face_uvs: 1 entries where .* 24 corners"),
        ({"uvs": np.zeros((1, 2)), "face_uvs": [1] * 24}, "face_uvs: entry 0 is 1 of 1"),
        ({"uvs": np.zeros((1, 2)), "face_uvs": [-2] * 24}, "face_uvs: entry 0 is -2 of 1"),
        ({"colors": np.zeros((8, 2))}, r"colors: shape \(8, 2\)"),
        ({"colors": np.zeros((9, 3))}, "colors: 9 entries where the mesh has 8 vertices"),
        ({"colors": np.full((8, 3), 1e300)}, "colors: entry 0 is 1e.?300; finite"),
        ({"groups": ["a"]}, "give both"),
        ({"groups": [1], "face_groups": [0] * 6}, "names, or tuples"),
        ({"groups": ["a"], "face_groups": [0, 0, 0, 0, 0, 1]}, "face_groups: entry 5 is 1 of 1"),
        ({"groups": ["a"], "face_groups": [0]}, "face_groups: 1 entries .* 6 faces"),
        ({"attributes": [1]}, "a dict of arrays"),
        ({"attributes": {"": [0] * 8}}, 'attribute "": is no name'),
        ({"attributes": {"2d": [0] * 8}}, "no digit first"),
        ({"attributes": {"a b": [0] * 8}}, "no name that files hold"),
        ({"attributes": {"a": [0] * 8, "A": [0] * 8}}, "there twice"),
        ({"attributes": {"a": [0] * 7}}, r'attributes\["a"\]: 7 entries where the mesh has 8'),
        ({"attributes": {"a": [[[0]]] * 8}}, r'attributes\["a"\]: shape \(8, 1, 1\)'),
        ({"attributes": {"a": np.zeros((8, 0))}}, r"shape \(8, 0\)"),
        ({"attributes": {"a": np.broadcast_to(0.0, (8, 2000))}}, "k up to 1024"),
        ({"attributes": {"a": np.broadcast_to(0.0, (2**40,))}}, "has more than 2"),
        ({"attributes": {"a": [0] * 7 + [np.inf]}}, 'attribute "a": of vertex 7 is inf; finite'),
        ({"attributes": {"a": [[0, 1e300]] * 8}}, 'attribute "a": of vertex 0 is inf'),
        ({"attributes": {"a": ["x"] * 8}}, "an array of"),
    ],
)
def test_what_does_not_fit_is_refused(cube, keywords, words):
    with pytest.raises(planish.InvalidArgument, match=words):
        planish.Mesh(*cube, **keywords)
    with pytest.raises(planish.InvalidArgument, match=words):
        planish.fit(*cube, **keywords)


def test_what_a_mesh_has_is_not_given_twice(cube):
    mesh = riding(cube)
    with pytest.raises(planish.InvalidArgument, match="colors: the mesh has its own"):
        planish.fit(mesh, colors=np.zeros((8, 3)))
    with pytest.raises(planish.InvalidArgument, match="Heat.* there twice"):
        planish.fit(mesh, attributes={"Heat": np.zeros(8)})
    more = planish.fit(mesh, attributes={"more": np.ones(8)})
    assert set(more.mesh.attributes) == {"heat", "flow", "wide", "more"}
    assert set(mesh.attributes) == {"heat", "flow", "wide"}
    with pytest.raises(planish.InvalidArgument, match="colors: belongs to fit"):
        planish.fit_file("a.obj", "b.glb", colors=np.zeros((8, 3)))


def same(one, other):
    """Whether all arrays and plain values of two objects are the same."""
    names = [name for name in dir(type(one)) if not name.startswith("_")]
    for name in names:
        a, b = getattr(one, name), getattr(other, name)
        if callable(a):
            continue
        if isinstance(a, planish.Mesh):
            same(a, b)
        elif isinstance(a, dict) and name == "attributes":
            assert a.keys() == b.keys()
            assert all(np.array_equal(a[key], b[key]) for key in a)
        elif isinstance(a, tuple):
            assert all(np.array_equal(x, y) for x, y in zip(a, b))
        elif isinstance(a, np.ndarray):
            assert a.dtype == b.dtype and np.array_equal(a, b), name
        else:
            assert a == b, name


@pytest.mark.parametrize("options", [{}, {"method": "fair"}, {"within": 1e-2, "method": "fair"},
                                     {"scheme": "catmull-clark"}, {"quads": "on"}])
def test_pickles_are_the_same_objects(cube, grid, options, tmp_path):
    mesh = riding(cube) if "scheme" not in options else planish.Mesh(*grid(3))
    fit = planish.fit(mesh, **options)
    surface = fit.evaluate(2)
    for protocol in (2, pickle.HIGHEST_PROTOCOL):
        again = pickle.loads(pickle.dumps((mesh, fit, surface), protocol))
        for one, other in zip((mesh, fit, surface), again):
            assert type(one) is type(other) and one is not other
    same(mesh, again[0])
    same(again[2], surface)
    other = again[1]
    assert np.array_equal(other.evaluate(3).positions, fit.evaluate(3).positions)
    same(other.cage, fit.cage)
    same(other.mesh, fit.mesh)
    assert other.report == fit.report and other.quality(1) == fit.quality(1)
    planish.write(tmp_path / "a.glb", fit)
    planish.write(tmp_path / "b.glb", other)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
    if "scheme" not in options:
        given = planish.LimitSurface(fit).evaluate([0], [0.3], [0.4])
        assert np.array_equal(given["position"],
                              planish.LimitSurface(other).evaluate([0], [0.3], [0.4])["position"])


def test_objects_that_do_not_change_are_their_own_copies(cube):
    fit = planish.fit(*cube)
    for one in (fit, fit.mesh, fit.evaluate(1)):
        assert copy.copy(one) is one and copy.deepcopy(one) is one


def test_damaged_pickles_are_refused(cube):
    fit = planish.fit(*cube)
    state = fit.__getstate__()
    for end in range(0, len(state), max(1, len(state) // 97)):
        with pytest.raises(planish.UnreadableInput, match="pickle: "):
            type(fit).__new__(type(fit)).__setstate__(state[:end])
    with pytest.raises(planish.UnreadableInput, match="more bytes"):
        type(fit).__new__(type(fit)).__setstate__(state + b"x")
    with pytest.raises(planish.UnreadableInput, match="another kind"):
        planish.Mesh.__new__(planish.Mesh).__setstate__(state)
    with pytest.raises(planish.UnreadableInput, match="another version"):
        planish.Mesh.__new__(planish.Mesh).__setstate__(b"planish 0.0.1\nM")

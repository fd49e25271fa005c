"""fit(), evaluate(), files: against the command, to the last bit."""

import json
import os
import re
import subprocess

import numpy as np
import pytest

import planish

REPORTED_OF_INPUT = [
    "vertices", "faces", "face_sizes", "boundary_loops", "components", "genus", "sharp_edges",
    "corners", "folded_edges", "separated_edges", "changed_faces",
]


@pytest.mark.parametrize("scene", ["goblet", "mixed_polygons", "wavy_patch", "bearing_block"])
@pytest.mark.parametrize("method", ["auto", "progressive", "fair"])
def test_results_are_the_commands_to_the_last_bit(scene, method, scenes, command, tmp_path):
    path = scenes / f"{scene}.obj"
    report = command(path, "-o", tmp_path / "command.ply", "--interpolation", method)
    fit = planish.fit(planish.read(path), method=method)
    assert fit.report["solve"] == report["solve"]
    assert {key: fit.report["input"][key] for key in REPORTED_OF_INPUT} == {
        key: report["input"][key] for key in REPORTED_OF_INPUT
    }
    # Sheets that repair separates, which these scenes do not have, are the report's own.
    assert report["surface"].pop("sheet_gap") is None
    level = report["surface"]["level"]
    assert fit.quality(level) == report["surface"]
    planish.write(tmp_path / "python.ply", fit)
    assert (tmp_path / "python.ply").read_bytes() == (tmp_path / "command.ply").read_bytes()
    # Text holds every digit of a double.
    planish.write(tmp_path / "evaluated.obj", fit.evaluate(level))
    command(path, "-o", tmp_path / "command.obj", "--interpolation", method)
    assert (tmp_path / "evaluated.obj").read_bytes() == (tmp_path / "command.obj").read_bytes()


def test_cage_is_the_commands(scenes, command, tmp_path):
    command(scenes / "goblet.obj", "--cage", tmp_path / "cage.obj")
    cage = planish.read(tmp_path / "cage.obj")
    fit = planish.fit(planish.read(scenes / "goblet.obj"), method="progressive")
    assert np.array_equal(fit.cage.vertices, cage.vertices)
    assert np.array_equal(fit.cage.indices, cage.indices)


def test_fit_file_tells_how_far_it_is_and_reports(scenes, command, tmp_path):
    mesh, steps = scenes / "goblet.obj", []
    report = command(mesh, "-o", tmp_path / "command.glb", "--levels", "1")
    fit = planish.fit_file(mesh, tmp_path / "python.glb", 1, report=tmp_path / "python.json",
                           progress=lambda step, fraction: steps.append((step, fraction)))
    assert json.loads((tmp_path / "python.json").read_text())["surface"] == report["surface"]
    assert {"read", "solve", "write"} <= {step for step, _ in steps}
    assert all(0 <= fraction <= 1 for _, fraction in steps)
    # What was made of the file is written as the file is.
    planish.write(tmp_path / "again.glb", fit, level=1)
    assert (tmp_path / "again.glb").read_bytes() == (tmp_path / "python.glb").read_bytes()


def test_fit_files_makes_a_contact_sheet_as_the_command_does(scenes, tmp_path):
    (tmp_path / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    inputs = [scenes / "cube.obj", tmp_path / "bad.obj", scenes / "torus.obj"]
    steps = []
    made = planish.fit_files(inputs, tmp_path / "python", 1, pages=tmp_path / "pages",
                             progress=lambda step, fraction: steps.append(fraction))
    assert made[0] is None and made[2] is None
    assert "bad.obj:2" in made[1]
    assert sorted(steps) == steps and steps[-1] == 1
    subprocess.run([os.environ["PLANISH_EXECUTABLE"], "fit", *inputs, "-o", tmp_path / "command/", "--page", tmp_path / "sheet/",
                    "--levels", "1", "--device", "cpu", "-q"], check=False)
    for name in ("cube", "torus"):
        assert (tmp_path / f"python/{name}.glb").read_bytes() == (tmp_path / f"command/{name}.glb").read_bytes()
    rows = [re.findall(r'<th scope="row">.*?<td>[^<]*|src="[^"]*"', (tmp_path / folder / "index.html").read_text())
            for folder in ("pages", "sheet")]
    assert rows[0] == rows[1] and len(rows[0]) > 4
    assert sorted(path.name for path in (tmp_path / "pages").iterdir()) == ["cube.html", "index.html", "torus.html"]
    with pytest.raises(planish.InvalidArgument, match="cube"):
        planish.fit_files([inputs[0], inputs[0]], tmp_path / "python")


def test_write_takes_options_of_step(scenes, tmp_path):
    fit = planish.fit_file(scenes / "wavy_patch.obj", tmp_path / "a.step")
    for options in ({"step_unit": "m"}, {"step_angle": 2}, {"step_tolerance": 1e-3}, {"step_face_size": 1}):
        planish.fit_file(scenes / "wavy_patch.obj", tmp_path / "a.step", **options)
        planish.write(tmp_path / "b.step", fit, **options)
        assert (tmp_path / "b.step").read_bytes() == (tmp_path / "a.step").read_bytes(), options
    with pytest.raises(planish.InvalidArgument, match="step_angle: 91"):
        planish.write(tmp_path / "b.step", fit, step_angle=91)
    with pytest.raises(TypeError, match="step_unit"):
        planish.fit(fit.mesh, step_unit="m")


def test_none_is_the_default_and_minus_one_is_refused(cube):
    planish.fit(*cube, weld=None, tolerance=None, creases=None)
    with pytest.raises(planish.InvalidArgument, match="weld: -1 is out of range; 0, or a fraction"):
        planish.fit(*cube, weld=-1)


def test_split_normals_are_creases_where_asked(tmp_path):
    roof = tmp_path / "roof.obj"
    roof.write_text("v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 3 0\nv 1 3 1\nv 2 3 0\nvn -1 0 1\nvn 1 0 1\n"
                    "f 1//1 2//1 5//1 4//1\nf 2//2 3//2 6//2 5//2\n")
    fit = planish.fit_file(roof, tmp_path / "python.glb", creases="normals")
    assert fit.report["solve"]["creases"] == "normals"
    assert planish.read(roof, split_normals=True).crease_edges.tolist() == [[1, 4]]
    mesh = planish.read(roof)
    assert len(mesh.crease_edges) == 0
    with pytest.raises(planish.InvalidArgument, match="read.. with split_normals"):
        planish.fit(mesh, creases="normals")


def test_surface_passes_through_the_vertices(cube):
    vertices, faces = cube
    fit = planish.fit(vertices, faces, tolerance=1e-12)
    assert fit.converged and fit.max_error <= 1e-12
    for level in range(4):
        surface = fit.evaluate(level)
        given = vertices[surface.base_vertices]
        error = np.linalg.norm(surface.positions[: len(given)] - given, axis=1)
        assert error.max() <= 1.01e-12 * np.sqrt(3)
        assert np.allclose(np.linalg.norm(surface.normals, axis=1), 1, atol=1e-6)
    assert fit.evaluate(2).quads.shape == (6 * 4 * 4, 4)


def test_any_number_of_threads_gives_the_same_bits(grid):
    vertices, faces = grid(40)
    one, all_cores = (planish.fit(vertices, faces, threads=n).evaluate(2) for n in (1, 0))
    assert np.array_equal(one.positions, all_cores.positions)
    assert np.array_equal(one.normals, all_cores.normals)


def test_cage_is_verified(cube):
    given = planish.Mesh(*cube)
    fit = planish.fit(given, method="progressive")
    found = planish.verify(fit.cage, given)
    assert found.confirmed and found.max_error <= 1e-6 and found.vertex_count == 8
    moved = fit.cage.vertices.copy()
    moved[3] += 0.1
    found = planish.verify(planish.Mesh(moved, fit.cage.faces), given)
    assert not found.confirmed and found.worst_vertex == 3
    fair = planish.fit(given, method="fair")
    assert planish.verify(fair.cage, given, method="fair").confirmed
    with pytest.raises(planish.UnusableMesh, match="is no cage of"):
        planish.verify(fair.cage, given)


def test_schemes_and_creases(cube):
    vertices, faces = cube
    edges = [[0, 1], [1, 3], [3, 2], [2, 0]]
    creased = planish.fit(vertices, faces, crease_edges=edges, method="progressive")
    assert creased.report["input"]["sharp_edges"] == 4
    assert np.array_equal(creased.mesh.crease_edges, edges)
    ignored = planish.fit(vertices, faces, crease_edges=edges, creases="ignore")
    assert ignored.report["input"]["sharp_edges"] == 0
    found = planish.fit(vertices, faces, creases="auto:40")
    assert found.report["solve"]["creases"] == "auto:40"
    assert planish.fit(vertices, faces, scheme="catmull-clark").report["solve"]["weights"] is None
    tetrahedron = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                   np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    loop = planish.fit(*tetrahedron, scheme="loop", tolerance=0.5).evaluate(1)
    assert loop.faces.shape == (16, 3)
    with pytest.raises(planish.InvalidArgument, match="take faces"):
        loop.quads


def test_limit_surface(grid):
    vertices, faces = grid(8)
    fit = planish.fit(vertices, faces, method="progressive", tolerance=1e-10)
    limit = planish.LimitSurface(fit)
    # The corner (0, 0) of a face is its first vertex.
    at = limit.evaluate(np.arange(64), np.zeros(64), np.zeros(64))
    assert np.abs(at["position"] - vertices[faces[:, 0]]).max() < 1e-9
    closest = limit.closest_point(vertices)
    assert closest["distance"].max() < 1e-9
    above = vertices + [0, 0, 5]
    inner = np.setdiff1d(np.arange(81), np.r_[0:9, 72:81, 0:81:9, 8:81:9])
    hits = limit.rays(above[inner], np.tile([0, 0, -1.0], (len(inner), 1)))
    assert np.abs(hits["t"] - 5).max() < 1e-8
    missed = limit.rays([[9, 9, 9]], [[0, 0, -1]])
    assert missed["face"][0] == -1 and np.isnan(missed["t"][0])
    with pytest.raises(planish.InvalidArgument):
        limit.evaluate([64], [0], [0])
    with pytest.raises(planish.InvalidArgument, match="1 for 2 origins"):
        limit.rays(vertices[:2], vertices[:1])


def test_triangles_as_fine_as_asked_for(cube, grid):
    for mesh in (cube, grid(6)):
        fit = planish.fit(*mesh, creases="use")
        limit = planish.LimitSurface(fit)
        corners = np.asarray(mesh[0], dtype=float)
        diagonal = np.linalg.norm(corners.max(axis=0) - corners.min(axis=0))
        count = 0
        for error in (1e-2, 1e-3):
            surface = fit.tessellate(chord_error=error)
            middles = surface.positions[surface.faces].mean(axis=1)
            assert limit.closest_point(middles)["distance"].max() <= error * diagonal
            assert len(surface.faces) > count
            count = len(surface.faces)
        assert len(fit.tessellate(chord_error=1e-2, angle=5).faces) > len(
            fit.tessellate(chord_error=1e-2).faces
        )
    edges = np.sort(
        np.concatenate([surface.faces[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1
    )
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.max() == 2
    tips = planish.fit([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]],
                       [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], creases="use", method="fair")
    with pytest.warns(UserWarning, match="an angle of 0.7 degrees is not kept beneath"):
        tips.tessellate(angle=0.7)
    with pytest.raises(planish.InvalidArgument, match="neither a chord error nor an angle"):
        fit.tessellate()
    with pytest.raises(planish.OutOfMemory, match="allow an error of"):
        fit.tessellate(chord_error=1e-14)
    loop = planish.fit(*cube, scheme="catmull-clark")
    with pytest.raises(planish.InvalidArgument, match="doo-sabin"):
        loop.tessellate(chord_error=1e-3)


def test_points_become_a_mesh(grid):
    points, _ = grid(30)
    mesh = planish.reconstruct(points, tolerance=0, quads=False)
    assert len(mesh.vertices) == len(points)
    assert {tuple(p) for p in mesh.vertices} == {tuple(p) for p in points}


def test_what_points_have_comes_to_their_mesh(grid, tmp_path):
    points, _ = grid(12)
    colors = np.column_stack([np.linspace(0, 1, len(points))] * 3)
    heat = np.arange(len(points), dtype=np.float32)
    up = np.tile([0, 0, -1.0], (len(points), 1))
    mesh = planish.reconstruct(points, tolerance=0, quads=False, normals=up, colors=colors,
                               attributes={"heat": heat, "pair": np.column_stack([heat, -heat])})
    place = {tuple(p): i for i, p in enumerate(points)}
    given = [place[tuple(p)] for p in mesh.vertices]
    assert np.array_equal(mesh.attributes["heat"], heat[given])
    assert np.array_equal(mesh.attributes["pair"][:, 1], -heat[given])
    assert np.allclose(mesh.colors[:, 0], colors[given, 0])
    # From a file to a surface.
    rows = [f"{x} {y} {z} 0 0 -1 {i}" for i, (x, y, z) in enumerate(points)]
    (tmp_path / "p.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" +
        "".join(f"property double {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "heat")) +
        "end_header\n" + "\n".join(rows) + "\n")
    read, keywords = planish.read_points(tmp_path / "p.ply", keywords=True)
    assert sorted(keywords) == ["attributes", "normals"]
    assert keywords["normals"].shape == (len(points), 3)
    fitted = planish.fit(planish.reconstruct(read, tolerance=0, **keywords))
    assert fitted.evaluate(1).attributes["heat"].max() == len(points) - 1
    for wrong in ({"normals": up[1:]}, {"colors": colors[1:]}, {"attributes": {"heat": heat[1:]}}):
        with pytest.raises(planish.InvalidArgument, match=next(iter(wrong))):
            planish.reconstruct(points, **wrong)


def test_no_program_for_points_is_said(grid, monkeypatch, tmp_path):
    monkeypatch.setenv("PLANISH_RECONSTRUCT", str(tmp_path / "none"))
    with pytest.raises(planish.MissingProgram, match="planish-reconstruct.* PLANISH_RECONSTRUCT.*CGAL") as raised:
        planish.reconstruct(grid(4)[0])
    assert isinstance(raised.value, planish.NoDevice)


def test_a_file_of_points_without_a_surface_is_refused(tmp_path):
    (tmp_path / "p.xyz").write_text("0 0 0\n")
    with pytest.raises(planish.UnusableMesh, match="p.xyz: 1 point is left"):
        planish.fit_file(tmp_path / "p.xyz", tmp_path / "s.glb")


def test_reading_points(tmp_path):
    (tmp_path / "p.xyz").write_text("1 2 3\n4 5 6.5\n")
    assert planish.read_points(tmp_path / "p.xyz").tolist() == [[1, 2, 3], [4, 5, 6.5]]


def test_none_is_refused(cube):
    mesh = planish.Mesh(*cube)
    for call in (
        lambda: planish.LimitSurface(None),
        lambda: planish.verify(None, mesh),
        lambda: planish.verify(mesh, None),
    ):
        with pytest.raises(TypeError):
            call()


def named_by(tmp_path, cube_obj):
    """An OBJ with materials and a glTF with a buffer, whose names an output may have."""
    (tmp_path / "y.mtl").write_text("newmtl wood\n# mine\nmap_Kd ../oak.png\n")
    (tmp_path / "x.obj").write_text("mtllib y.mtl\nusemtl wood\n" + cube_obj)
    planish.fit_file(tmp_path / "x.obj", tmp_path / "a.gltf", 1)
    (tmp_path / "a.bin").rename(tmp_path / "b.bin")
    text = (tmp_path / "a.gltf").read_text().replace("a.bin", "b.bin")
    (tmp_path / "a.gltf").write_text(text)


CUBE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""


def test_what_an_input_names_is_not_written(tmp_path):
    named_by(tmp_path, CUBE)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for name, output, cage in [("a.gltf", "b.gltf", None), ("x.obj", "y.obj", None),
                               ("x.obj", "z.ply", tmp_path / "y.obj")]:
        with pytest.raises(planish.InvalidArgument, match=f"is read with the input .*{name}"):
            planish.fit_file(tmp_path / name, tmp_path / output, 1, cage)
    # What was made of a file knows of it.
    for name, output in [("a.gltf", "b.gltf"), ("x.obj", "y.obj")]:
        mesh = planish.read(tmp_path / name)
        fit = planish.fit(mesh)
        made = [fit, fit.evaluate(1), fit.tessellate(chord_error=0.1), fit.edit(1).fit()]
        if output.endswith("obj"):
            made += [mesh, fit.cage, fit.mesh]
        for one in made:
            with pytest.raises(planish.InvalidArgument, match=f"is read with the input .*{name}"):
                planish.write(tmp_path / output, one)
    with pytest.raises(planish.InvalidArgument, match="x.obj is the input itself"):
        planish.write(tmp_path / "x.obj", planish.read(tmp_path / "x.obj"))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    planish.write(tmp_path / "w.obj", planish.read(tmp_path / "x.obj"))


def test_files_of_other_folders_are_read_where_they_are_wanted(tmp_path):
    (tmp_path / "model").mkdir()
    named_by(tmp_path / "model", CUBE)
    (tmp_path / "model" / "b.bin").rename(tmp_path / "b.bin")
    (tmp_path / "model" / "b.bin").symlink_to("../b.bin")
    asset, made = tmp_path / "model" / "a.gltf", tmp_path / "made.ply"
    for call in [lambda **more: planish.read(asset, **more),
                 lambda **more: planish.fit_file(asset, made, 1, **more)]:
        with pytest.raises(planish.UnreadableInput, match="leads away from the folder of the file"):
            call()
        call(textures="anywhere")
    with pytest.raises(planish.InvalidArgument, match="textures: \"elsewhere\""):
        planish.read(asset, textures="elsewhere")
    with pytest.raises(TypeError, match="textures"):
        planish.fit([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], textures="anywhere")


def test_what_is_odd_about_a_mesh_is_told(cube, tmp_path):
    def codes(fit):
        return [warning["code"] for warning in fit.report["warnings"]]

    vertices, faces = cube
    assert codes(planish.fit(vertices, faces)) == []
    assert codes(planish.fit(vertices, faces[:, ::-1])) == ["inside-out"]
    # The same with a vertex more.
    more = planish.fit(np.vstack([vertices, [[5, 5, 5]]]), faces[:, ::-1])
    assert codes(more) == ["unused-vertices", "inside-out"]
    assert "1 of 9 vertices belongs to no face (8)" in more.report["warnings"][0]["message"]
    corners = vertices[faces.reshape(-1)]
    torn = tmp_path / "torn.obj"
    torn.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners)
                    + "".join(f"f {i} {i + 1} {i + 2} {i + 3}\n" for i in range(1, 24, 4)))
    told = planish.fit_file(torn, tmp_path / "torn.ply", 1).report["warnings"]
    assert [warning["code"] for warning in told] == ["torn-vertices"]
    assert "16 vertices at open edges lie exactly where another one does" in told[0]["message"]


def test_a_level_that_is_not_named_is_the_meshs(cube):
    """2; of a dense mesh 1, whoever asks: evaluate(), edit() and files."""
    around, along = np.meshgrid(np.arange(200), np.arange(100), indexing="ij")
    u, v = 2 * np.pi * around / 200, 2 * np.pi * along / 100
    points = np.stack([(1 + 0.4 * np.cos(v)) * np.cos(u), (1 + 0.4 * np.cos(v)) * np.sin(u),
                       0.4 * np.sin(v)], axis=-1).reshape(-1, 3)
    corner = lambda i, j: (i % 200) * 100 + j % 100
    faces = np.stack([corner(around, along), corner(around + 1, along),
                      corner(around + 1, along + 1), corner(around, along + 1)], axis=-1).reshape(-1, 4)
    dense = planish.fit(points, faces, method="progressive")
    assert len(dense.evaluate().quads) == 4 * 20_000
    assert len(dense.edit().positions) == len(dense.evaluate().positions)
    coarse = planish.fit(*cube, method="progressive")
    assert len(coarse.evaluate().quads) == 16 * 6

"""Fit.edit(): vertices move, rows change in place, and what was not named keeps its bits."""

import copy
import pickle
import threading

import numpy as np
import pytest

import planish


@pytest.fixture(name="torus")
def torus_fixture():
    a, b = np.meshgrid(np.arange(96), np.arange(72), indexing="ij")
    u, v = a * 2 * np.pi / 96, b * 2 * np.pi / 72
    ring = 1 + 0.4 * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)], axis=-1)
    number = lambda i, k: i % 96 * 72 + k % 72
    faces = np.stack([number(a, b), number(a + 1, b), number(a + 1, b + 1), number(a, b + 1)], -1)
    return vertices.reshape(-1, 3), faces.reshape(-1, 4).astype(np.int32)


@pytest.mark.parametrize("method", ["progressive", "fair"])
def test_moves_change_rows_in_place(torus, method):
    fit = planish.fit(*torus, method=method)
    diagonal = np.linalg.norm(np.ptp(torus[0], axis=0))
    edit = fit.edit()
    rows, normals = edit.positions, edit.normals
    assert np.abs(rows - fit.evaluate(2).positions).max() < 2e-6 * diagonal
    before = rows.copy(), normals.copy()
    to = torus[0][[700, 5]] + [[0, 0, 0.05], [0.03, 0, 0]]
    change = edit.move([700, 5], to)
    assert list(change.vertices) == [5, 700] and not change.is_whole
    assert {5, 700} <= set(change.control_points)
    assert (edit.points[[700, 5]] == to).all() and not rows.flags.writeable
    expanded = np.concatenate([np.arange(first, first + count) for first, count in change.ranges])
    assert (change.rows == expanded).all() and (np.diff(change.rows) > 0).all()
    rest = np.setdiff1d(np.arange(len(rows)), change.rows)
    assert len(rest) > len(rows) / 2
    assert (rows[rest] == before[0][rest]).all() and (normals[rest] == before[1][rest]).all()
    assert np.abs(rows[change.rows] - before[0][change.rows]).max() > 0.02

    now = edit.fit()
    surface = now.evaluate(2)
    assert np.abs(surface.positions - rows).max() < 1e-12
    assert np.abs(surface.normals - normals).max() < 1e-5
    off = surface.positions[: len(torus[0])] - edit.points[surface.base_vertices]
    assert np.linalg.norm(off, axis=1).max() <= 1e-6 * diagonal
    assert now.converged and now.max_error <= edit.error_bound + 1e-14
    assert (now.mesh.vertices == edit.points).all() and now.method == method
    if method == "progressive":  # against a fit from scratch, which has not seen the editor
        scratch = planish.fit(now.mesh, method=method, tolerance=1e-11).evaluate(2)
        assert np.abs(scratch.positions - rows).max() < 2e-6 * diagonal
    again = pickle.loads(pickle.dumps(now))
    assert again.evaluate(2).positions.tobytes() == surface.positions.tobytes()

    edit.undo()
    assert (edit.points == torus[0]).all() and edit.can_redo and not edit.can_undo
    assert np.abs(rows - before[0]).max() < 1e-6 * diagonal
    assert (surface.positions == now.evaluate(2).positions).all()  # a fit does not follow
    edit.redo()
    assert (edit.points[[700, 5]] == to).all()
    assert len(edit.redo().rows) == 0
    told = []
    assert edit.settle(progress=lambda step, fraction: told.append(fraction)).is_whole
    assert len(edit.settle().rows) == len(rows)
    kept = edit.positions
    assert edit.refit(progress=lambda step, fraction: told.append(fraction)).is_whole
    assert edit.can_undo and edit.positions.shape == kept.shape


def test_a_fit_of_another_pose_keeps_the_rules_of_the_first():
    """A corner that turns inward once its neighbour has moved: sectors are those of the fit."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0))
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    first = (np.arange(6)[:, None] * 7 + np.arange(6)).reshape(-1)
    faces = np.stack([first, first + 1, first + 8, first + 7], axis=-1)
    fit = planish.fit(vertices, faces, creases="use", corner_vertices=[24, 3],
                      crease_edges=[[24, 25], [24, 31]], method="progressive")
    edit = fit.edit()
    edit.move([25, 31], vertices[[25, 31]] + [[-1.8, -0.4, 0], [0.3, -1.7, 0]])
    now = edit.fit()
    assert np.abs(now.evaluate(2).positions - edit.positions).max() < 1e-12
    assert np.abs(pickle.loads(pickle.dumps(now)).evaluate(2).positions - edit.positions).max() < 1e-12
    other = planish.fit(now.mesh, creases="use", method="progressive")
    assert np.abs(other.evaluate(2).positions - edit.positions).max() > 1e-3


def test_selections_move_with_a_falloff(torus):
    edit = planish.fit(*torus, method="progressive").edit(level=1)
    vertices, weights = edit.select([100], 0.15)
    assert vertices[0] == 100 and weights[0] == 1 and 9 < len(vertices) < 60
    assert (np.diff(weights) <= 0).all() and weights.min() > 0
    turn = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]])
    whole = torus[0] @ turn[:3, :3].T + turn[:3, 3]
    edit.transform(vertices, turn, weights)
    blended = torus[0][vertices] + weights[:, None] * (whole - torus[0])[vertices]
    assert np.abs(edit.points[vertices] - blended).max() < 1e-12
    edit.undo()
    edit.transform(vertices, turn[:3])
    assert np.abs(edit.points[vertices] - whole[vertices]).max() < 1e-12


@pytest.mark.parametrize("method", ["progressive", "fair"])
def test_creases_are_set_and_taken_away(torus, method):
    fit = planish.fit(*torus, method=method)
    edit = fit.edit(level=1)
    edit.move([700], torus[0][[700]] + [[0, 0, 0.03]])
    smooth, smooth_surface = edit.positions, edit.limit_surface()
    kept = smooth.copy()
    ring = np.stack([np.arange(72) + 288, (np.arange(72) + 1) % 72 + 288], axis=-1)
    told = []
    change = edit.set_sharp(ring, [5], progress=lambda step, fraction: told.append(fraction))
    assert change.is_whole and len(change.rows) == len(edit.positions) > len(smooth) and told
    assert edit.points[700, 2] == torus[0][700, 2] + 0.03  # what was moved stays
    now = edit.fit()
    assert now.converged and now.report["input"]["sharp_edges"] == 72
    assert now.report["input"]["corners"] == 1 and now.report["solve"]["creases"] == "use"
    assert np.abs(now.evaluate(1).positions - edit.positions).max() < 1e-12
    assert pickle.loads(pickle.dumps(now)).evaluate(1).positions.tobytes() == now.evaluate(1).positions.tobytes()
    if method == "progressive":
        scratch = planish.fit(now.mesh, creases="use", method=method, tolerance=1e-11).evaluate(1)
        assert np.abs(scratch.positions - edit.positions).max() < 4e-6

    # What was given before stays, and does not follow.
    edit.move([300], torus[0][[300]] * 1.01)
    assert (smooth == kept).all()
    at = torus[0][[300]] * 1.01
    assert edit.limit_surface().closest_point(at)["distance"][0] < 4e-6
    assert smooth_surface.closest_point(at)["distance"][0] > 1e-3
    edit.undo()
    edit.undo()
    assert (edit.points == torus[0]).all() and not edit.can_undo
    edit.set_sharp(ring.tolist(), [5], sharp=False)
    assert len(edit.positions) == len(smooth)
    assert np.abs(edit.positions - fit.evaluate(1).positions).max() < (1e-6 if method == "fair" else 4e-6)
    edit.set_sharp(corner_vertices=[9])
    assert edit.fit().report["input"]["corners"] == 1


def test_creases_are_refused_and_cancelled(cube):
    edit = planish.fit(*cube, creases="use").edit(level=1)
    rows = edit.positions
    for call, words in [
        (lambda: edit.set_sharp([[0, 99]]), "vertex 99"),
        (lambda: edit.set_sharp([[0, 0]]), "no edge"),
        (lambda: edit.set_sharp([0, 1]), "crease_edges"),
        (lambda: edit.set_sharp(corner_vertices=[[0]]), "corner_vertices"),
        (lambda: edit.set_sharp(corner_vertices=[-1]), "vertex -1"),
    ]:
        with pytest.raises(planish.InvalidArgument, match=words):
            call()
    with pytest.raises(planish.Cancelled):
        edit.set_sharp(corner_vertices=[3], cancelled=lambda: True)
    assert edit.positions.ctypes.data == rows.ctypes.data
    assert edit.fit().report["input"]["corners"] == 0


def test_wrong_calls_are_refused(cube, torus):
    edit = planish.fit(*torus).edit()
    # Where a smooth surface leaves vertices it bends less.
    noisy = torus[0] + 0.004 * np.random.default_rng(1).standard_normal(torus[0].shape)
    for call, words in [
        (lambda: edit.move([7000], [[0, 0, 0]]), "no vertex 7000"),
        (lambda: edit.move([3], [[0, np.nan, 0]]), "vertex 3"),
        (lambda: edit.move([3, 4], [[0, 0, 0]]), "2 vertices and 1 positions"),
        (lambda: edit.move([[3]], [[0, 0, 0]]), "vertices"),
        (lambda: edit.transform([3], np.eye(3)), "matrix"),
        (lambda: edit.transform([3], np.ones((4, 4))), "last row"),
        (lambda: edit.transform([3], np.eye(4), [1, 1]), "1 vertices and 2 weights"),
        (lambda: edit.select([3], -1), "radius"),
        (lambda: planish.fit(*cube).edit(level=7), "level"),
        (lambda: planish.fit(noisy, torus[1], within=0.01).edit(), "within"),
        (lambda: planish.fit(*torus, max_iterations=1, method="progressive").edit(), "tolerance"),
        (lambda: planish.fit(*torus, scheme="catmull-clark").edit(), "doo-sabin"),
    ]:
        with pytest.raises(planish.InvalidArgument, match=words):
            call()
    assert (edit.points == torus[0]).all() and not edit.can_undo
    with pytest.raises(TypeError):
        copy.deepcopy(edit)


def test_an_editor_at_work_refuses_others(torus):
    edit = planish.fit(*torus).edit()
    said = []

    def reenter(step, fraction):
        try:
            edit.move([3], [[0, 0, 0]])
        except planish.InvalidArgument as error:
            said.append(str(error))

    edit.settle(progress=reenter)
    assert said and all("at work" in text for text in said)
    assert (edit.points == torus[0]).all()
    edit.move([3], [[0, 0, 0]])

    refused, moved = [], []

    def work(first):
        for vertex in range(first, first + 40):
            while True:  # who is refused asks again
                try:
                    change = edit.move([vertex], torus[0][[vertex]] * 1.01)
                except planish.InvalidArgument as error:
                    refused.append(str(error))
                    continue
                moved.append(change.vertices[0])
                break

    threads = [threading.Thread(target=work, args=(k * 100,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(moved)) == len(moved) == 160
    assert all("at work" in text for text in refused)
    assert (edit.points[moved] == torus[0][moved] * 1.01).all()
    assert edit.fit().max_error <= 1e-6


def test_an_editor_keeps_what_it_reads(torus):
    edit = planish.fit(*torus).edit(level=1)
    positions = edit.positions
    edit.move([9], torus[0][[9]] * 1.1)
    expected = positions.tobytes()
    del edit
    assert positions.tobytes() == expected

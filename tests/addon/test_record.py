# SPDX-License-Identifier: GPL-3.0-or-later
"""The way of a run: what of it is kept, and that earlier levels' states are the surfaces that they were."""

import numpy as np
import pytest
import shapes
from addon.binding import library
from addon.binding.values import Cage
from addon.core import job, record


def cage_of(points, faces):
    sizes, vertices = shapes.packed(faces)
    return Cage(np.asarray(points, float), np.array(sizes, np.int32), np.array(vertices, np.int32))


def walked(steps, start):
    """The path of a run on one level that shifts all vertices by these steps along x, one after the other."""
    recorder, xyz = record.Recorder(start), start
    for step in steps:
        xyz = xyz + (step, 0, 0)
        recorder.see(xyz)
    with library.Mesh.create(library.load(), len(start), *shapes.packed(shapes.cube()[1])) as mesh:
        return recorder, recorder.path(mesh, xyz)


def test_states_are_equally_far_from_each_other_however_long_the_steps_are():
    """Many short steps after a few long ones: more than are kept at a time."""
    start = shapes.cube()[0]
    steps = np.concatenate([np.full(40, 0.05), np.full(4000, 0.0005), np.full(10, 0.1)])
    recorder, path = walked(steps, start)
    assert len(recorder._kept) <= record._ROOM
    places = np.array([state[0, 0] for state in path]) - start[0, 0]
    assert places[0] == 0 and places[-1] == pytest.approx(steps.sum()) and len(path) > 0.8 * record.STATES
    gaps = np.diff(places)
    assert gaps.min() > 0.02 and gaps.max() < 0.15 + steps.sum() / 24, gaps
    assert all(np.ptp(state - start, axis=0).max() < 1e-12 for state in path)  # states, not mixtures


def test_a_way_there_and_back_is_a_way():
    start = shapes.cube()[0]
    _, path = walked([0.1] * 10 + [-0.1] * 10, start)
    places = [state[0, 0] - start[0, 0] for state in path]
    assert len(path) > 15 and max(places) == pytest.approx(1.0) and places[-1] == pytest.approx(0)


def test_where_nothing_moves_there_is_no_way():
    start = shapes.cube()[0]
    assert len(walked([], start)[1]) == 1 and len(walked([0.0, 0.0], start)[1]) == 1
    _, path = walked([1e-9], start)
    assert len(path) == 2


def test_a_run_on_several_levels_is_kept_on_the_vertices_of_the_last_one():
    """The first state shows the original's surface, energies fall from state to state, and the last one is the result."""
    points, faces = shapes.torus()
    cage = cage_of(points + 0.05 * np.random.default_rng(2).normal(size=points.shape), faces)
    solution = job.solve(cage, job.Request("willmore", 3, records=True))
    assert job.solve(cage, job.Request("willmore", 1)).path == ()
    n, lib = len(solution.cage.positions), library.load()
    assert 10 < len(solution.path) <= record.STATES and all(state.shape == (n, 3) for state in solution.path)
    assert np.array_equal(solution.path[-1], solution.cage.positions)
    assert solution.path[0] == pytest.approx(solution.start_positions, abs=1e-12)
    with library.Mesh.of_cage(lib, solution.cage) as mesh:
        with library.Problem.create(mesh, lib.options({"willmore": 1.0})) as problem:
            energies = [problem.evaluate(state)[0].objective for state in solution.path]
    assert energies[0] == pytest.approx(solution.start.objective, rel=1e-5)
    assert energies[-1] == pytest.approx(solution.end.objective, rel=1e-5)
    assert (np.diff(energies) < 1e-4 * energies[0]).all(), energies
    gaps = [np.linalg.norm(a - b) / np.sqrt(n) for a, b in zip(solution.path, solution.path[1:])]
    assert max(gaps) < 0.5 * sum(gaps), gaps  # no jump: not all of the way is in one step


def test_a_cancelled_run_has_the_way_so_far():
    cage = cage_of(*shapes.torus())
    solution = job.solve(cage, job.Request("mvs", 3, records=True), lambda progress: progress.iteration >= 5)
    assert solution.stop == "cancelled" and len(solution.path) >= 2
    assert np.array_equal(solution.path[-1], solution.cage.positions)

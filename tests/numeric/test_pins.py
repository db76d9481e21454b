# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices that are held on several levels: coarse ones hold where they will be (libcurvopt/notes/126)."""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import lib
from ccref import mesh_from_faces

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import cages  # noqa: E402

LIMIT_POINT = 4  # CURVOPT_FREEDOM_OF_LIMIT_POINT
SEEDS = (1, 13, 16, 31, 42)  # with poles, n-gons; 16 is open


def pinned_cage(seed: int):
    """A corpus cage, and some of its vertices; not all of a face."""
    points, faces, _ = cages.cage(seed)
    cage = mesh_from_faces(points, [list(face) for face in faces])
    pins = np.sort(np.random.default_rng(seed).choice(cage.n_vertices, 3 + seed % 3, replace=False))
    assert not any(set(face) <= set(pins) for face in faces)
    return cage, pins


@pytest.mark.parametrize("seed", SEEDS)
def test_a_finer_level_begins_on_the_surface_of_the_one_before_where_vertices_are_held(seed):
    """Put back after each subdivision they would be spikes, of 5 to 11 times the energy."""
    (cage, pins), first = pinned_cage(seed), {}

    def note(report):
        first.setdefault(report.level, report.energy)

    result = lib.minimize(cage, levels=3, constraints=lib.constraints(pins), progress=note)
    ends = [level.energy for level in result.levels]
    assert [first[2], first[3]] == pytest.approx(ends[:2], rel=5e-3)
    assert result.verdict == "minimum" and np.array_equal(result.mesh.xyz[pins], cage.xyz[pins])


@pytest.mark.parametrize("steps", [3, 30])
@pytest.mark.parametrize("seed", SEEDS[:3])
def test_a_cancelled_run_has_held_vertices_where_they_are_to_be(seed, steps):
    cage, pins = pinned_cage(seed)
    seen = []

    def stop(report: lib.Progress) -> bool:
        seen.append(report.energy)
        return len(seen) == steps

    result = lib.minimize(cage, levels=3, constraints=lib.constraints(pins), progress=stop)
    assert result.stop == "cancelled" and result.summary.n_levels < 3
    assert result.mesh.n_vertices == result.summary.n_vertices == lib.refine(lib.refine(cage)).n_vertices
    assert np.abs(result.mesh.xyz[pins] - cage.xyz[pins]).max() <= 1e-13 * np.abs(cage.xyz).max()
    assert lib.evaluate(result.mesh, tolerance=1e-6).objective == pytest.approx(seen[-1], rel=5e-3)


def test_a_boundary_goes_smoothly_through_a_vertex_that_is_held_on_it():
    """The boundary is held as a curve; a vertex put back on it after each subdivision is a corner, of second difference .5."""
    points = np.stack(np.meshgrid(range(5), range(5), [0]), -1).reshape(-1, 3).astype(float)
    faces = [[at, at + 1, at + 6, at + 5] for row in range(4) for at in range(5 * row, 5 * row + 4)]
    points[2] += 0, -1, 1  # the middle of a side
    result = lib.minimize(mesh_from_faces(points, faces), levels=3, constraints=lib.constraints([2]))
    assert np.array_equal(result.mesh.xyz[2], points[2])
    columns = [result.mesh.xyz[np.isclose(result.mesh.xyz[:, 0], x)] for x in (1.75, 2.25)]
    beside = sum(column[column[:, 1].argmin()] for column in columns)  # the boundary is the outermost
    assert np.abs(beside - 2 * points[2]).max() <= 0.2


@pytest.mark.parametrize("freedom", ([LIMIT_POINT] * 7 + [0], [0] * 3 + [LIMIT_POINT] * 5))
def test_vertices_that_depend_on_others_ahead_are_held_themselves(freedom):
    """A cube's limit points cannot all be chosen freely, nor can the places of its vertices after a subdivision."""
    points = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
    points += 0.1 * np.random.default_rng(0).standard_normal(points.shape)
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    result = lib.minimize(mesh_from_faces(points, faces), levels=2, constraints=lib.constraints(range(8), freedom))
    held = [v for v in range(8) if freedom[v] == 0]
    assert result.verdict == "minimum" and np.array_equal(result.mesh.xyz[held], points[held])


def test_where_the_first_level_is_lost_vertices_are_held_themselves():
    """Three faces round a tube: it shrinks so much that seven vertices are far from where they will be."""
    points, faces, _ = cages.cage(9)
    cage = mesh_from_faces(points, [list(face) for face in faces])
    pins = [2, 9, 10, 12, 16, 20, 21]
    result = lib.minimize(cage, levels=4, constraints=lib.constraints(pins))
    assert np.array_equal(result.mesh.xyz[pins], cage.xyz[pins])
    assert result.summary.end.objective < 0.5 * result.summary.start.objective


def test_places_that_doubles_cannot_tell_from_the_cage_are_refused():
    """From 1e9 sizes of the cage on; a vertex that stays where it is is as far as it is."""
    mesh, _ = pinned_cage(13)
    size = float(np.sqrt(((mesh.xyz - mesh.xyz.mean(axis=0)) ** 2).sum(axis=1).mean()))
    far = lib.constraints([0, 5], places=[mesh.xyz[0], mesh.xyz.mean(axis=0) + [1.1e9 * size, 0, 0]])
    with pytest.raises(lib.CurvoptError, match="constraint 1 on vertex 5 has the place .* more than 1e\\+09 times the cage's size"):
        lib.minimize(mesh, levels=1, constraints=far)
    wrong = lib.constraints([0], places=[mesh.xyz[0]])
    wrong.has_places = 2
    with pytest.raises(lib.CurvoptError, match="has_places is 2; it must be 0 or 1"):
        lib.minimize(mesh, levels=1, constraints=wrong)

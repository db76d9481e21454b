# SPDX-License-Identifier: GPL-3.0-or-later
"""A solver that stays, through the Python package: along drags it ends where a cold run ends, by another solver's energies;
what it shows on the way; where held vertices and limit points are."""
from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("CURVOPT_BUILD", ROOT / "build" / "release")).resolve()
os.environ["CURVOPT_LIBRARY"] = str(BUILD / "libcurvopt.so")
sys.path.insert(0, str(ROOT / "libcurvopt" / "python"))
import curvopt  # noqa: E402
from ccref import Mesh, mesh_from_faces  # noqa: E402
from nets import read_obj  # noqa: E402
from osd import osd_jets  # noqa: E402
import lib  # noqa: E402

PINS = np.array([0, 11, 23, 40])
DRAGS = 300 if lib.LONG else 4
TIGHT = {"tolerance": 1e-7, "decrement_tolerance": 1e-9}


@pytest.fixture(scope="module")
def pretzel() -> curvopt.Cage:
    """48 vertices of genus 2, fair and without symmetry."""
    mesh = read_obj(ROOT / "blend_files" / "obj" / "pretzel_g2.obj")
    random = np.random.default_rng(5)
    points = mesh.xyz + 0.04 * size(mesh.xyz) * random.normal(size=mesh.xyz.shape)
    return curvopt.minimize(curvopt.cage(points, mesh.face_list()), "willmore", levels=1).cage


def size(points: np.ndarray) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def drags(cage: curvopt.Cage, start: np.ndarray, n: int, amount: float = 0.05):
    """Places of the pins: one of them off by a part of the size."""
    random = np.random.default_rng(1)
    for _ in range(n):
        places = start.copy()
        places[random.integers(len(start))] += amount * size(cage.positions) * random.normal(size=3)
        yield places


def test_warm_ends_where_cold_ends(pretzel):
    start = pretzel.positions[PINS]
    options = {"held": PINS, "threads": 2, **TIGHT}
    gaps = []  # relative; where several minima are in reach, the cold one may be lower
    with curvopt.Solver(pretzel, "willmore", places=start, **options) as warm, curvopt.Problem(
        pretzel, "willmore", tolerance=1e-9
    ) as problem:
        warm.solve()
        for places in drags(pretzel, start, DRAGS):
            warm.set_places(places)
            warm.solve(settle=False)
            found = warm.solve()
            assert found.verification.verdict == "minimum"
            assert np.array_equal(warm.positions[PINS], places)
            with curvopt.Solver(pretzel, "willmore", places=places, **options) as cold:
                cold.solve()
                least = problem.energies(cold.positions).objective
            gaps += [problem.energies(warm.positions).objective / least - 1]
    worse, better = (np.mean(sign * np.array(gaps) > 1e-6) for sign in (1, -1))
    print(f"of {DRAGS} drags {worse:.1%} worse, by {max(gaps):.1e} at most, and {better:.1%} better, by {-min(gaps):.1e}")
    assert worse <= 0.05


def test_with_strength_it_ends_where_a_run_ends(pretzel):
    start = pretzel.positions[PINS]
    options = {"held": PINS, "strength": 0.3, **TIGHT}
    with curvopt.Solver(pretzel, "willmore", places=start, **options) as warm:
        warm.solve()
        for places in drags(pretzel, start, DRAGS):
            warm.set_places(places)
            assert warm.solve().verification.verdict == "minimum"
            run = curvopt.minimize(pretzel, "willmore", levels=1, places=places, **options).cage.positions
            assert np.abs(warm.positions - run).max() < 1e-4 * size(run)


@pytest.mark.parametrize("c0", [-2.0, 4.0])
def test_with_spontaneous_curvature_it_ends_where_a_run_ends(pretzel, c0):
    """Objectives are negative there; a state that passes has figures all the same."""
    start = pretzel.positions[PINS]
    options = {"held": PINS, "spontaneous_curvature": c0 / size(pretzel.positions), "strength": 0.4, **TIGHT}
    with curvopt.Solver(pretzel, "willmore", places=start, **options) as warm:
        warm.solve()
        for places in drags(pretzel, start, 2):
            warm.set_places(places)
            passing = warm.solve(settle=False)
            assert np.isfinite(passing.end.objective) and passing.stop in ("converged", "settled")
            assert warm.solve().verification.verdict == "minimum"
            run = curvopt.minimize(pretzel, "willmore", levels=1, places=places, **options)
            assert np.abs(warm.positions - run.cage.positions).max() < 1e-4 * size(run.cage.positions)
            assert run.energies.objective == pytest.approx(passing.end.objective, abs=1)


def test_what_it_shows_on_the_way(pretzel):
    """Of seven drags the first picture leaves a tenth of what passing states gain in the middle; how much it is of one drag
    hangs on the last digits of where it begins."""
    left: list[float] = []
    start = pretzel.positions[PINS]
    with curvopt.Solver(pretzel, "mvs", held=PINS, places=start, threads=2) as solver, curvopt.Problem(
        pretzel, "mvs"
    ) as problem:
        solver.solve()
        for places in drags(pretzel, start, 7, 0.02):
            jumped = solver.positions
            jumped[PINS] = places
            shown: list[np.ndarray] = []
            solver.set_places(places)
            passing = solver.solve(settle=False, on_positions=shown.append)
            assert passing.verification.verdict == "unknown"
            assert len(shown) == solver.report.iterations + 1
            before, first, last = (problem.energies(x).objective for x in (jumped, shown[0], solver.positions))
            assert last <= first * (1 + 1e-3) and first <= before
            left.append((first - last) / (before - last))
            assert np.allclose(solver.positions, shown[-1], rtol=0, atol=1e-12)
            assert passing.end.objective == pytest.approx(last, rel=1e-3)
            with curvopt.Cancel() as cancel:
                cancel.request()
                assert solver.solve(cancel=cancel).stop == "cancelled"
            assert np.allclose(solver.positions, shown[-1], rtol=0, atol=1e-12)
            with pytest.raises(KeyError):
                solver.solve(on_progress=lambda _: {}["raised in a callback"])
            assert solver.solve().verification.verdict == "minimum"
    assert np.median(left) < 0.1, left


def test_limit_points_are_where_they_are_to_be(pretzel):
    mesh = read_obj(ROOT / "blend_files" / "obj" / "pretzel_g2.obj")
    limits = osd_jets(with_points(mesh, pretzel), [0], [0], [[0.5, 0.5]], level=4).limit[PINS]
    with curvopt.Solver(pretzel, "willmore", held=PINS, places=limits, limit_points=True) as solver:
        solver.solve()
        for places in drags(pretzel, limits, 2):
            solver.set_places(places)
            solver.solve()
            moved = osd_jets(with_points(mesh, solver.cage()), [0], [0], [[0.5, 0.5]], level=4).limit[PINS]
            assert np.abs(moved - places).max() < 1e-5 * size(pretzel.positions)


def with_points(mesh: Mesh, cage: curvopt.Cage) -> Mesh:
    return mesh_from_faces(cage.positions, [list(face) for face in mesh.face_list()])


def test_other_options_and_back(pretzel):
    start = pretzel.positions[PINS]
    with curvopt.Solver(pretzel, "willmore", held=PINS, places=start) as solver:
        solver.solve()
        solver.set_options("willmore", held=[3, 8], strength=0.3)
        near = solver.solve()
        cold = curvopt.minimize(pretzel, "willmore", levels=1, held=[3, 8], strength=0.3)
        assert near.end.objective == pytest.approx(cold.energies.objective, rel=1e-3)
        solver.set_positions()
        assert np.array_equal(solver.positions, pretzel.positions)
        with pytest.raises(curvopt.CurvoptError):
            solver.set_options("willmore", slide=True)
        with pytest.raises(ValueError):
            solver.set_places(np.zeros((3, 3)))
        assert solver.solve().verification.verdict == "minimum"


def test_a_piece_that_nothing_holds_stays(pretzel):
    """Beside one with pins, which ends where it ends alone: it has the same energy there."""
    n = len(pretzel.positions)
    other = 0.5 * pretzel.positions + [5 * size(pretzel.positions), 0, 0]
    both = curvopt.Cage(np.concatenate([pretzel.positions, other]), np.tile(pretzel.face_sizes, 2),
                        np.concatenate([pretzel.face_vertices, pretzel.face_vertices + n]))
    places = pretzel.positions[PINS].copy()
    places[0] += 0.05 * size(pretzel.positions)
    options = {"held": PINS, "places": places, **TIGHT}
    with curvopt.Solver(both, "willmore", **options) as pair, curvopt.Solver(pretzel, "willmore", **options) as alone, \
            curvopt.Problem(pretzel, "willmore", tolerance=1e-9) as problem:
        pair.solve()
        alone.solve()
        assert np.array_equal(pair.positions[n:], other)
        got, want = (problem.energies(solver.positions[:n]).objective for solver in (pair, alone))
    assert got == pytest.approx(want, rel=1e-5), (got, want)


def test_a_volume_of_all_pieces_is_held(pretzel):
    """That ties pieces together: those without a handle go along."""
    n = len(pretzel.positions)
    both = curvopt.Cage(np.concatenate([pretzel.positions, pretzel.positions + [5 * size(pretzel.positions), 0, 0]]),
                        np.tile(pretzel.face_sizes, 2), np.concatenate([pretzel.face_vertices, pretzel.face_vertices + n]))
    with curvopt.Problem(both, "willmore", tolerance=1e-7) as problem:
        volume = 1.02 * problem.energies(both.positions).volume
        with curvopt.Solver(both, "willmore", held=PINS, volume=volume, tolerance=1e-6) as pair:
            pair.solve()
            assert problem.energies(pair.positions).volume == pytest.approx(volume, rel=1e-5)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact gradients against central differences, coordinate by coordinate.

The difference is extrapolated from steps h and h / 2, error O(h^4) and rounding eps E / h. h is chosen per coordinate
from a ladder of halvings, where two consecutive extrapolations agree best. The quadrature rule must
not change between the two ends of a difference: it is the fixed one of `joshi_sequin`; the default one is tried too.
"""
from __future__ import annotations

import numpy as np
import pytest

import lib
from ccref import refine, topology
from nets import mixed_cage, perturbed, quad_cage, sphere_like, subdivided_cube, torus_cage, trapezohedron, valences

CAGES = {
    "torus": perturbed(torus_cage(8, 6, 0.45), 0.15, 1),
    "valence_3": perturbed(sphere_like(3, "star_xyz"), 0.1, 3),
    "valence_5": quad_cage(trapezohedron(5), 5, 0.1),
    "valence_6": quad_cage(trapezohedron(6), 6, 0.1),
    "valence_7": quad_cage(trapezohedron(7), 7, 0.1),
    "n_gons": mixed_cage(0),
}
WIDE = {  # with blends over 2 x 2 faces of each sector
    "wide_3": perturbed(sphere_like(8, "star_xyz", subdivided_cube), 0.1, 3),
    "wide_5": perturbed(refine(refine(quad_cage(trapezohedron(5)))), 0.1, 5),
}
POLES = {  # discs of width 1 (blend_disc.h)
    "valence_10": quad_cage(trapezohedron(10), 10, 0.1),
    "valence_60": quad_cage(trapezohedron(60), 60, 0.01),
}
LADDER = [0.016 * 2.0 ** -k for k in range(7)]  # in mean edges
CASES = [(name, "limit", "willmore") for name in CAGES]
CASES += [("torus", "limit", term) for term in ("mvs", "mvs_cross", "variation", "mehlum_tarrou", "mean_curvature")]
CASES += [(name, "plane", term) for name in CAGES for term in ("willmore", "mvs", "mvs_cross")]
CASES += [(name, "polynomial", term) for name in ("valence_3", "valence_6", *WIDE) for term in ("willmore", "mvs")]
CASES += [("valence_10", "polynomial", "mvs"), ("valence_60", "limit", "willmore")]
CAGES |= WIDE | POLES
TRIED = 24 if lib.LONG else 6


def mean_edge(mesh) -> float:
    """Mean edge length."""
    ends = topology(mesh).ends
    return float(np.linalg.norm(mesh.xyz[ends[:, 0]] - mesh.xyz[ends[:, 1]], axis=1).mean())


def difference(problem: lib.Problem, xyz: np.ndarray, at: tuple[int, int], edge: float) -> float:
    """Extrapolated central difference with the step chosen from the ladder."""
    def central(h: float) -> float:
        values = []
        for sign in (1, -1):
            moved = xyz.copy()
            moved[at] += sign * h
            values.append((problem.evaluate(moved).objective, moved[at]))
        return (values[0][0] - values[1][0]) / (values[0][1] - values[1][1])

    slopes = [central(h * edge) for h in LADDER]
    found = [(4 * b - a) / 3 for a, b in zip(slopes, slopes[1:])]
    gaps = [abs(a - b) for a, b in zip(found, found[1:])]
    return found[int(np.argmin(gaps)) + 1]


def coordinates(mesh, gradient: np.ndarray, n: int) -> list[tuple[int, int]]:
    """Coordinates to try: those of extraordinary vertices first, then random ones; no vanishing component."""
    rng = np.random.default_rng(4)
    odd = np.flatnonzero(valences(mesh) != 4)
    order = np.r_[rng.permutation(odd)[:n // 2], rng.permutation(mesh.n_vertices)]
    floor = 1e-3 * np.abs(gradient).max()  # below it a relative error says nothing in double precision
    out = []
    for vertex in order:
        axis = int(rng.integers(0, 3))
        if abs(gradient[vertex, axis]) > floor and (int(vertex), axis) not in out:
            out.append((int(vertex), axis))
    assert len(out) >= n
    return out[:n]


def compare(mesh, problem: lib.Problem) -> str:
    """Assert 1e-6 in every coordinate tried; returns the worst in words."""
    energies, gradient = problem.evaluate(mesh.xyz, gradient=True)
    assert np.isfinite(gradient).all() and energies.objective > 0
    edge = mean_edge(mesh)
    worst = (0.0, None)
    for at in coordinates(mesh, gradient, TRIED):
        wanted = difference(problem, mesh.xyz, at, edge)
        error = abs(gradient[at] - wanted) / abs(gradient[at])
        worst = max(worst, (error, at), key=lambda pair: pair[0])
    assert worst[0] <= 1e-6, f"relative error {worst[0]:.2e} at (vertex, axis) {worst[1]}"
    return f"worst relative error {worst[0]:.1e} at (vertex, axis) {worst[1]}"


@pytest.mark.parametrize("name, surface, term", CASES)
def test_gradient(name, surface, term, capsys):
    mesh = CAGES[name]
    problem = lib.Problem(mesh, lib.options(term, surface, joshi_sequin=1))
    assert problem.evaluate(mesh.xyz).surface == lib.SURFACES[surface]
    words = compare(mesh, problem)
    with capsys.disabled():
        print(f"\n  {name} {surface} {term}: {words}")


@pytest.mark.parametrize("name, term", [("torus", "willmore"), ("torus", "mvs"), ("torus", "mvs_cross"),
                                        ("valence_3", "willmore"), ("valence_7", "willmore"), ("n_gons", "willmore")])
def test_gradient_with_the_default_rule_on_limit(name, term):
    compare(CAGES[name], lib.Problem(CAGES[name], lib.options(term, "limit")))


def test_gradient_of_a_weighted_sum_is_the_weighted_sum():
    mesh = CAGES["torus"]
    weights = {"willmore": 2.0, "mvs": 0.25, "mvs_cross": 0.5}
    parts = {}
    for term in weights:
        parts[term] = lib.Problem(mesh, lib.options(term, "limit", tolerance=1e-8)).evaluate(mesh.xyz, gradient=True)
    problem = lib.Problem(mesh, lib.options(weights, "limit", tolerance=1e-8))
    energies, gradient = problem.evaluate(mesh.xyz, gradient=True)
    value = sum(w * parts[t][0].value(t) for t, w in weights.items())
    slope = sum(w * parts[t][1] for t, w in weights.items())
    assert energies.objective == pytest.approx(value, rel=1e-6)
    assert np.abs(gradient - slope).max() <= 1e-5 * np.abs(slope).max()


@pytest.mark.parametrize("name, surface, term", [("torus", "limit", "mvs_cross"), ("valence_5", "plane", "mvs")])
def test_taylor_remainder_is_quadratic(name, surface, term):
    """E(x + t d) - E(x) - t g.d falls as t^2, in a random direction."""
    mesh = CAGES[name]
    problem = lib.Problem(mesh, lib.options(term, surface, joshi_sequin=1))
    energies, gradient = problem.evaluate(mesh.xyz, gradient=True)
    direction = np.random.default_rng(8).normal(size=mesh.xyz.shape) * mean_edge(mesh)
    steps = np.array([4e-3, 2e-3, 1e-3, 5e-4])
    rest = [abs(problem.evaluate(mesh.xyz + t * direction).objective - energies.objective
                - t * float((gradient * direction).sum())) for t in steps]
    slope = np.polyfit(np.log(steps), np.log(rest), 1)[0]
    assert 1.8 <= slope <= 2.4, rest

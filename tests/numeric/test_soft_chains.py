# SPDX-License-Identifier: GPL-3.0-or-later
"""Chains of edges that springs draw to curves (libcurvopt/notes/123-soft-chains.md): their forces and energies against B-splines,
SciPy's splines and OpenSubdiv; what weights tend to; chains that contradict each other; what is refused."""
from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import lib
import test_chain_on_curve as chains
import test_through as points
import test_through_springs as springs
from ccref import Mesh
from nets import torus_cage, write_obj
from osd import osd_jets

NONE, FREE_SPACING = 1, 2
WEIGHT = 0.8
STIFFNESS = springs.STIFFNESS["mvs"] * WEIGHT / (1 - WEIGHT)
TIGHT = dict(tolerance=1e-7, decrement_tolerance=1e-13)


class Drawn:
    """A chain of a torus of 12 by 7 faces, and its curve: open, six vertices in a row on a helix with waves; or closed, a meridian
    of seven on a circle that is wider. `at` are places [k, 3] for parameters [k] along the chain, in edges of the input."""

    def __init__(self, is_closed: bool) -> None:
        self.mesh, self.is_closed = torus_cage(12, 7, 0.4), is_closed
        if is_closed:
            self.vertices = list(range(7))
            limits = points.limits(self.mesh)[:7]
            middle, sign = limits.mean(axis=0), np.sign(limits[1, 2] - limits[:, 2].mean())
            curve = middle + 0.5 * np.column_stack([np.cos(chains.TURN), 0 * chains.TURN, sign * np.sin(chains.TURN)])
            self.parameters = 200 * np.arange(7) / 7 + np.array([0, 3, -2, 4, 1, 0, -3.0])
        else:
            curve = chains.helix()[2] + np.outer(0.1 * np.sin(np.linspace(0, 12.4, 200)), [0, 0, 1])
            self.vertices, self.parameters = [7 * i for i in range(6)], np.array([5, 40, 70, 105, 142, 180.0])
        self.curve, spline, n = curve, chains.by_length(curve, is_closed), len(self.vertices)
        if not is_closed:
            s = CubicSpline(np.arange(n), np.interp(self.parameters, np.arange(200), spline.x))
            self.at = lambda u: spline(s(u))
            return
        turn = spline.x[-1]
        t = np.interp(self.parameters, np.arange(201), spline.x)
        s = CubicSpline(np.arange(n + 1), np.r_[t, t[0] + turn] - turn / n * np.arange(n + 1), bc_type="periodic")
        self.at = lambda u: spline((s(u % n) + turn / n * u) % turn)

    def given(self) -> lib.Chain:
        return lib.chain(self.vertices, self.curve, self.is_closed, self.is_closed, self.parameters)

    def run(self, weight: float | None = WEIGHT, levels: int = 1, **more) -> lib.Result:
        through = lib.through(chains=[self.given()], chain_weights=None if weight is None else [weight])
        return lib.minimize(self.mesh, "mvs", levels=levels, symmetry=NONE, spacing=FREE_SPACING, through=through, **more)

    def rule(self, pieces: int) -> tuple[np.ndarray, np.ndarray]:
        """Parameters and weights of the quadrature, with so many edges of a level for one of the input."""
        n = len(self.vertices) if self.is_closed else len(self.vertices) - 1
        if self.is_closed:
            return np.arange(n * pieces) / pieces, np.full(n * pieces, 1 / pieces)
        u, weights = np.arange(n * pieces + 1) / pieces, np.full(n * pieces + 1, 1 / pieces)
        weights[[0, -1]], weights[[1, -2]] = 1 / 6 / pieces, (1 / 2 + 1 / 6) / pieces
        return np.r_[u, 0.5 / pieces, n - 0.5 / pieces], np.r_[weights, 2 / 3 / pieces, 2 / 3 / pieces]

    def limit_curve(self, mesh: Mesh, levels: int, u: np.ndarray) -> np.ndarray:
        """Points [k, 3] of the chain's limit curve, by OpenSubdiv."""
        pieces = 2 ** (levels - 1)
        edges = chains.edges_of(chains.on_level(self.mesh, self.vertices, self.is_closed, levels), self.is_closed)
        number = np.minimum((u * pieces).astype(int), len(edges) - 1)
        where = [chains.place_on(mesh, *edges[k], t) for k, t in zip(number, u * pieces - number)]
        return osd_jets(mesh, [f for f, _ in where], [0] * len(where), [p for _, p in where], level=6).jets[:, 0]


@pytest.mark.parametrize("is_closed", [False, True])
def test_forces_balance(is_closed, capsys):
    """At the end the energy's gradient, by the public evaluation, is what the chain draws with, by B-splines; and the report says
    what the springs add."""
    drawn = Drawn(is_closed)
    result = drawn.run(**TIGHT)
    u, weights = drawn.rule(1)
    along = u.astype(int)
    if is_closed:
        rows = np.array([springs.rows_on_torus(12, 7, k, 0, 0)[0] for k in along])
    else:
        rows = np.array([springs.rows_on_torus(12, 7, 7 * k, t, 0)[0] for k, t in zip(along, u - along)])
    found, size = result.mesh.xyz, springs.radius(drawn.mesh)
    off = (rows @ found - drawn.at(u)) / size
    pull = STIFFNESS / size * np.einsum("k,kv,kc->vc", weights, rows, off)
    _, gradient = lib.Problem(drawn.mesh, lib.options("mvs", tolerance=1e-7)).evaluate(found, gradient=True)
    share, total = np.linalg.norm(gradient + pull) / np.linalg.norm(pull), STIFFNESS / 2 * weights @ (off ** 2).sum(axis=1)
    with capsys.disabled():
        print(f"\n  {'closed' if is_closed else 'open'}: {result.verdict}; of the chain's forces {share:.1e} is left")
    assert result.verdict == "minimum" and share <= 1e-3 and total > 1
    assert abs(result.summary.spring_energy - total) <= 1e-8 * total


@pytest.mark.parametrize("is_closed", [False, True])
def test_a_chain_is_as_stiff_on_every_level(is_closed):
    """The springs' energy is the integral of the squared distance, by a fine rule and OpenSubdiv."""
    drawn = Drawn(is_closed)
    n = 7 if is_closed else 5
    u, fine = (np.arange(200 * n) + 0.5) / 200, np.full(200 * n, 1 / 200)
    for levels, most in ((2, 0.2), (3, 0.02)) if lib.LONG else ((2, 0.2),):  # it is coarse where the distance is of the grid's own
        result, size = drawn.run(levels=levels), springs.radius(drawn.mesh)

        def total(at: np.ndarray, weights: np.ndarray) -> float:
            off = (drawn.limit_curve(result.mesh, levels, at) - drawn.at(at)) / size
            return STIFFNESS / 2 * weights @ (off ** 2).sum(axis=1)

        assert result.verdict == "minimum"
        assert abs(result.summary.spring_energy / total(*drawn.rule(2 ** (levels - 1))) - 1) <= 1e-6
        assert abs(result.summary.spring_energy / total(u, fine) - 1) <= most


@pytest.mark.parametrize("is_closed", [False, True] if lib.LONG else [False])
def test_a_large_weight_tends_to_what_holds_exactly(is_closed, capsys):
    """Distances of limit points from their places fall like 1 - w; the energy is below that of the exact result."""
    drawn, found = Drawn(is_closed), []
    exact, places = drawn.run(None, **TIGHT), drawn.at(np.arange(len(drawn.vertices)))
    assert exact.verdict == "minimum" and np.abs(points.limits(exact.mesh)[drawn.vertices] - places).max() < 1e-9
    for softness in (1e-4, 1e-5, 1e-6):
        result = drawn.run(1 - softness, **TIGHT)
        assert result.verdict == "minimum"
        found.append(np.linalg.norm(points.limits(result.mesh)[drawn.vertices] - places, axis=1).max())
        assert result.summary.end.objective < exact.summary.end.objective
    ratios = np.array(found[:-1]) / found[1:]
    with capsys.disabled():
        print(f"\n  {'closed' if is_closed else 'open'}: distances {np.array(found)}, ratios {ratios}")
    assert (ratios > 9).all() and (ratios < 11).all()
    assert np.array_equal(drawn.run(1 - 1e-12).mesh.xyz, drawn.run(1.0).mesh.xyz)


def test_chains_may_contradict_each_other_and_other_constraints():
    """One chain drawn to two curves ends as one drawn to the mean of both; beside points that are held, and a pin. (MVS has so
    many minima that rounding chooses among them.)"""
    drawn = Drawn(False)
    shift = np.array([0, 0.1, 0.2])
    here = lib.chain(drawn.vertices, drawn.curve, parameters=drawn.parameters)
    there = lib.chain(drawn.vertices, drawn.curve + shift, parameters=drawn.parameters)
    middle = lib.chain(drawn.vertices, drawn.curve + 3 / 4 * shift, parameters=drawn.parameters)
    entries = dict(vertices=[14, 50], places=[[springs.NAN] * 3] * 2)

    def run(given: list[lib.Chain], weights: list[float]) -> np.ndarray:
        result = lib.minimize(drawn.mesh, "variation", levels=1, symmetry=NONE, spacing=FREE_SPACING, **TIGHT,
                              constraints=lib.constraints([7]), through=lib.through(**entries, chains=given, chain_weights=weights))
        assert result.verdict == "minimum"
        limits = points.limits(result.mesh)
        assert np.abs(limits[[14, 50]] - points.limits(drawn.mesh)[[14, 50]]).max() < 1e-12
        return limits

    assert np.abs(run([here, there], [0.5, 0.75]) - run([middle], [0.8])).max() < 1e-5


def test_a_weight_of_0_holds_nothing():
    drawn = Drawn(False)
    free = lib.minimize(drawn.mesh, "mvs", levels=1, symmetry=NONE, spacing=FREE_SPACING)
    none = drawn.run(0.0)
    assert np.array_equal(free.mesh.xyz, none.mesh.xyz) and none.summary.spring_energy == 0


def test_callers_of_before_have_no_weights_of_chains():
    """A struct without the member, whatever is behind it."""
    drawn = Drawn(False)
    through = lib.through(chains=[drawn.given()], chain_weights=[WEIGHT])
    through.struct_size = 112
    old = lib.minimize(drawn.mesh, levels=1, symmetry=NONE, spacing=FREE_SPACING, max_iterations=2, through=through)
    new = lib.minimize(drawn.mesh, levels=1, symmetry=NONE, spacing=FREE_SPACING, max_iterations=2, through=lib.through(chains=[drawn.given()]))
    assert np.array_equal(old.mesh.xyz, new.mesh.xyz) and old.summary.spring_energy == 0


@pytest.mark.parametrize("weight", [-0.1, 1.1, float("nan"), float("inf")])
def test_weights_are_from_0_to_1(weight):
    with pytest.raises(lib.CurvoptError, match="chain 0 has the weight .*; it must be 0 to 1"):
        Drawn(False).run(weight)


def crossing(levels: int, weights: list[float] | None) -> tuple[list[int], str]:
    """Two chains of a flat patch that have a vertex in common. How many progress reports a run of one step a level gave, and
    what was refused."""
    mesh, seen = chains.patch(), []
    x = np.linspace(-1, 1, 61)
    along, across = np.column_stack([x, 0 * x, 0.3 * (1 - x ** 2)]), np.column_stack([0 * x, x, 0.3 * (1 - x ** 4)])
    given = [lib.chain(v, c, parameters=np.linspace(0, 60, 7)) for v, c in ((list(range(21, 28)), along), (list(range(3, 49, 7)), across))]
    try:
        lib.minimize(mesh, levels=levels, symmetry=NONE, progress=lambda report: seen.append(0) or True,
                     through=lib.through(chains=given, chain_weights=weights))
    except lib.CurvoptError as error:
        return seen, str(error)
    return seen, ""


def test_chains_that_hang_together_are_refused_at_once_where_they_become_too_long():
    """768 edges each on the eighth level; the run would have come to the seventh."""
    seen, told = crossing(8, None)
    assert not seen and "chain 1, with the chains that it hangs together with by vertices, holds 1541 limit points on level 8" in told
    assert "use fewer levels, weights below 1, or chains that do not touch" in told
    for levels, weights in ((7, None), (8, [1, 0.5])):
        seen, told = crossing(levels, weights)
        assert seen and not told


def test_the_command_line_reads_weights_of_chains(tmp_path):
    drawn = Drawn(False)
    cage, out, report = tmp_path / "cage.obj", tmp_path / "out.obj", tmp_path / "report.json"
    write_obj(cage, drawn.mesh)
    chain = {"vertices": drawn.vertices, "curve": drawn.curve.tolist(), "parameters": drawn.parameters.tolist(), "weight": WEIGHT}
    command = [lib.BUILD / "curvopt", "minimize", cage, "-o", out, "--levels", "1", "--through", "-", "--json", report, "--quiet"]
    subprocess.run(command, input=json.dumps({"chains": [chain]}), text=True, check=True)
    through = lib.through(chains=[drawn.given()], chain_weights=[WEIGHT])
    wanted = lib.minimize(drawn.mesh, levels=1, through=through).summary.spring_energy
    assert json.loads(report.read_text())["spring_energy"] == pytest.approx(wanted, rel=1e-9)
    told = subprocess.run(command, input=json.dumps({"chains": [chain | {"weight": 2}]}), text=True, capture_output=True)
    assert told.returncode and 'chain 0, line 1: "weight" must be a number, 0 to 1' in told.stderr

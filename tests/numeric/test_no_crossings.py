# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs whose surface is to come to cross itself nowhere, against triangles and dense samples that share no code with the
library (dense_surface.py), and against the same runs without."""
from __future__ import annotations

import functools
import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

import lib
from ccref import Mesh, mesh_from_faces
from dense_surface import crossing_faces, triangles
from nets import read_obj, torus_cage, write_obj
from test_measure import corpus_cage, joined, linked, trefoil

REACH = 0.2  # mean edges: base/tuning.h


def mean_edge(mesh: Mesh) -> float:
    """Of a cage of quads."""
    quads = mesh.xyz[mesh.flat.reshape(-1, 4)]
    return float(np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2).mean())


def touching(mesh: Mesh, pairs, levels: int) -> float:
    """The least distance of corners of triangles of one face from corners of those of another one, over the pairs."""
    tri, owner, _ = triangles(mesh, levels)
    points = {int(f): tri[owner == f].reshape(-1, 3) for f in np.unique(pairs)}
    return min(float(cKDTree(points[int(f)]).query(points[int(g)])[0].min()) for f, g in pairs)


KNOTS = [(0.65, "mvs", 1), (66, "mvs", 2)] + [(0.6, "willmore", 1)] * lib.LONG


def knot(name) -> Mesh:
    """A tube of that radius round a trefoil, or a cage of the corpus."""
    return trefoil(name) if name < 1 else corpus_cage(name)


@pytest.mark.parametrize("name, energy, levels", KNOTS)
def test_knots_do_not_cross(name, energy, levels):
    """What crosses itself without the option is held by contact with it, a minimum: no triangle five refinements below
    the input passes through another one, and the clearance is that of dense samples."""
    mesh = knot(name)
    assert lib.crossings(mesh).n_pairs == 0
    free = lib.minimize(mesh, energy, levels=levels)
    assert lib.crossings(free.mesh).n_pairs > 0 and np.isnan(free.summary.clearance)
    held = lib.minimize(mesh, energy, levels=levels, no_crossings=1)
    assert held.verdict == "minimum" and held.summary.n_touching > 0 and held.summary.n_crossing_before == 0
    assert lib.crossings(held.mesh).n_pairs == 0 and not crossing_faces(held.mesh, 6 - levels)
    assert held.summary.end.objective > free.summary.end.objective
    assert 0 < held.summary.clearance < 1.1 * REACH * mean_edge(held.mesh)
    assert (held.touching[:, 0] < held.touching[:, 1]).all() and held.touching.max() < mesh.n_faces
    if levels == 1:
        assert touching(held.mesh, held.touching, 4) == pytest.approx(held.summary.clearance, rel=0.03)


@functools.cache
def held_trefoil():
    """The run that several tests compare theirs with: by one thread."""
    return lib.minimize(trefoil(0.6), levels=1, no_crossings=1, threads=1)


def test_nothing_changes_without_contact():
    """A cage that comes close to itself nowhere ends in the same minimum with and without."""
    mesh = corpus_cage(4)
    one, two = (lib.minimize(mesh, levels=2, no_crossings=k) for k in (0, 1))
    assert one.verdict == two.verdict == "minimum" and two.summary.n_touching == two.summary.n_refused == 0
    assert np.isnan(two.summary.clearance)
    assert two.summary.end.objective == pytest.approx(one.summary.end.objective, rel=1e-5)


def test_threads():
    """The same bits for any number of threads."""
    one, three = held_trefoil(), lib.minimize(trefoil(0.6), levels=1, no_crossings=1, threads=3)
    assert np.array_equal(one.mesh.xyz, three.mesh.xyz) and one.touching.tolist() == three.touching.tolist()
    assert one.summary.clearance == three.summary.clearance


def test_decrement_by_differences():
    """The Hessian leaves second derivatives of distances out: the decrement agrees with that by differences to a third at
    minima (1.00 to 1.32 of it on seven cages), where it is a thousandth of what the certificate asks for."""
    held = lib.minimize(corpus_cage(66), "willmore", levels=1, no_crossings=1, verify=1)
    assert held.verdict == "minimum" and held.summary.n_touching > 0
    assert held.summary.difference_decrement == pytest.approx(held.summary.shape_decrement, rel=0.35)
    assert held.summary.difference_decrement < 1e-8 * held.summary.end.objective


@pytest.mark.parametrize("steps", (3, 11))
def test_cancelled_runs_do_not_cross(steps):
    """What a run has reached when it is cancelled."""
    reached = lib.minimize(trefoil(0.6), "mvs", levels=2, no_crossings=1, progress=lambda p: p.iteration == steps)
    assert reached.stop == "cancelled" and lib.crossings(reached.mesh).n_pairs == 0


COMBINED = {"within": {"within": 0.3}, "strength": {"strength": 0.7}, "rotations": {"symmetry": 2},
            "volume": {"hold": {"volume": "keep"}}, "lmvm": {"method": "lmvm", "max_iterations": 60}}


@pytest.mark.parametrize("fields", COMBINED.values(), ids=COMBINED)
def test_with_other_options(fields):
    """Each of these runs crosses without the option."""
    mesh = trefoil(0.5)
    crossed = lib.minimize(mesh, levels=1, **fields)
    held = lib.minimize(mesh, levels=1, no_crossings=1, **fields)
    assert lib.crossings(crossed.mesh).n_pairs > 0
    assert lib.crossings(held.mesh).n_pairs == 0 and not crossing_faces(held.mesh, 4) and held.summary.n_touching > 0
    if "within" in fields:
        assert np.linalg.norm(held.mesh.xyz - mesh.xyz, axis=1).max() < 0.3
    if "hold" in fields:
        assert abs(held.summary.scalar_residual[0]) < 1e-8


def sheets(top: float, rise: float = 0.25, n: int = 8) -> Mesh:
    """A square of n x n faces that rises at its boundary to a plateau, and a plane one above it."""
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1), indexing="ij")
    inside = (np.abs(x) < 1) & (np.abs(y) < 1)
    faces = [[i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1]
             for i in range(n) for j in range(n)]
    sheet = [mesh_from_faces(np.stack([x, y, z + 0 * x], -1).reshape(-1, 3), faces) for z in (rise * inside, top)]
    return joined(*sheet)


@pytest.mark.parametrize("top", (0.3, 0.4))
def test_open_sheets(top):
    """Both keep boundaries and tangents there: the lower one bulges through the plane, or lifts it."""
    mesh = sheets(top)
    crossed = lib.minimize(mesh, levels=1, boundary=1)
    held = lib.minimize(mesh, levels=1, boundary=1, no_crossings=1)
    assert lib.crossings(mesh).n_pairs == 0 and lib.crossings(crossed.mesh).n_pairs > 0
    assert held.verdict == "minimum" and held.summary.n_touching > 0
    assert lib.crossings(held.mesh).n_pairs == 0 and not crossing_faces(held.mesh, 4)
    assert (held.touching[:, 0] < 64).all() and (held.touching[:, 1] >= 64).all()
    middle = held.mesh.xyz[81 + 40, 2], held.mesh.xyz[40, 2]
    assert middle[0] > top and middle[0] > middle[1]


def test_crossings_of_the_input():
    """Two linked tori that cross: said, and allowed to go away; never more pairs of faces. Where the surface crosses itself
    nothing repels, so that the run may end before a minimum (note 113); to its end with CURVOPT_LONG=1, a minute."""
    mesh = linked(0.45, sides=12)
    before = lib.crossings(mesh)
    held = lib.minimize(mesh, levels=1, no_crossings=1, **({} if lib.LONG else {"max_iterations": 40}))
    after = lib.crossings(held.mesh)
    assert held.summary.n_crossing_before == before.n_pairs > 40
    assert after.n_pairs <= before.n_pairs and held.summary.end.objective < 0.65 * held.summary.start.objective
    few = lib.minimize(mesh, levels=1, no_crossings=1, max_iterations=1)
    assert 0 < lib.crossings(few.mesh).n_pairs <= before.n_pairs


@pytest.mark.parametrize("distance", (1.2, 1.5))
def test_symmetric_crossings_of_the_input(distance):
    """Coarse tori that cross at corners of faces: which pairs cross is a matter of rounding there, and the run begins."""
    one = torus_cage(4, 3, 0.45)
    mesh = joined(one, one.with_xyz(one.xyz + [distance, 0, 0]))
    held = lib.minimize(mesh, levels=1, no_crossings=1)
    assert held.summary.n_crossing_before == lib.crossings(mesh).n_pairs > 4
    assert held.verdict == "minimum" and lib.crossings(held.mesh).n_pairs == 0


def test_places_that_cross_are_refused():
    """Limit points of two linked tori, pushed into each other."""
    mesh = linked(0.9)
    n = mesh.n_vertices // 2
    some = np.r_[np.arange(0, n, 7), n + np.arange(0, n, 7)]
    for shift, fits in ((0.05, True), (0.4, False)):
        places = mesh.xyz[some] + np.where(some >= n, shift, 0)[:, None] * [1, 0, 0]
        pins = lib.constraints(some, [4] * len(some), places=places)
        if fits:
            held = lib.minimize(mesh, levels=1, constraints=pins, no_crossings=1, max_iterations=5)
            assert lib.crossings(held.mesh).n_pairs == 0
        else:
            with pytest.raises(lib.CurvoptError, match="with the constraints at their places the surface crosses itself"):
                lib.minimize(mesh, levels=1, constraints=pins, no_crossings=1)


@pytest.mark.parametrize("fields, sentence", (({"slide": 1}, "slide exclude"), ({"joshi_sequin": 1}, "joshi_sequin exclude")))
def test_refused(fields, sentence):
    """What does not look for crossings."""
    with pytest.raises(lib.CurvoptError, match=sentence):
        lib.minimize(trefoil(0.6), levels=1, no_crossings=1, **fields)


def test_command_line(tmp_path):
    """--no-crossings: keys of the JSON, faces of the input; nothing of it without."""
    cage = write_obj(tmp_path / "cage.obj", trefoil(0.6))
    out, report = tmp_path / "out.obj", tmp_path / "out.json"
    run = lib.run_cli("minimize", str(cage), "-o", str(out), "--levels", "1", "--no-crossings", "--json", str(report))
    assert run.returncode == 0, run.stderr
    told = json.loads(report.read_text())
    held = held_trefoil()
    assert told["no_crossings"]["touching"] == held.touching.tolist() and told["n_crossings"] == 0
    assert told["no_crossings"]["clearance"] == held.summary.clearance
    assert told["no_crossings"]["crossings_before"] == [] and told["no_crossings"]["n_crossings_before"] == 0
    assert "held by contact" in run.stdout and f"{held.summary.n_touching} pairs of faces" in run.stdout
    assert "no_crossings" not in lib.cli_minimize(trefoil(0.6), "--levels", "1")[0]
    crossed = write_obj(tmp_path / "linked.obj", linked(0.45))
    run = lib.run_cli("minimize", str(crossed), "-o", str(out), "--levels", "1", "--no-crossings", "--json", str(report),
                      "--max-iterations", "1")
    told = json.loads(report.read_text())
    assert told["no_crossings"]["crossings_before"] == lib.crossings(linked(0.45)).pairs.tolist()
    assert "crossed before" in run.stdout

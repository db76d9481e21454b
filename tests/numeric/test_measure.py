# SPDX-License-Identifier: GPL-3.0-or-later
"""Deviation and crossings against dense sampling that shares no code with the library, and against closed forms.

With CURVOPT_LONG=1 all 300 cages of the corpus, else a few of each.
"""
from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces, refine
from dense_surface import crossing_faces, distances, sampled
from nets import periodic_net, read_obj, torus, torus_cage, write_obj

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import cages  # noqa: E402

SEEDS = range(300) if lib.LONG else (4, 6, 7, 8, 9, 18, 22, 29)
PROMISED = 1.2  # curvopt_deviation.bound
BLEND_CAGES = sorted((lib.ROOT / "blend_files" / "obj").glob("*.obj"))


def corpus_cage(seed: int) -> Mesh:
    """The seed's cage."""
    xyz, faces, _ = cages.cage(seed)
    return mesh_from_faces(xyz, faces)


def size_of(mesh: Mesh) -> float:
    """Root mean square distance of the vertices from their mean."""
    return math.sqrt(((mesh.xyz - mesh.xyz.mean(0)) ** 2).sum(1).mean())


def moved(mesh: Mesh, seed: int) -> Mesh:
    """The cage, subdivided if the seed is odd, every coordinate moved by up to 10^-3 .. 10^-1 of the size."""
    rng = np.random.default_rng(seed)
    fine = refine(mesh) if seed % 2 else mesh
    return fine.with_xyz(fine.xyz + size_of(mesh) * 10 ** rng.uniform(-3, -1) * rng.uniform(-1, 1, fine.xyz.shape))


def joined(a: Mesh, b: Mesh) -> Mesh:
    """Two cages in one."""
    return Mesh(np.r_[a.sizes, b.sizes], np.r_[a.flat, b.flat + a.n_vertices], np.r_[a.xyz, b.xyz])


# --------------------------------------------------------------------------------------------------- deviation --

@pytest.mark.parametrize("seed", SEEDS)
def test_bound_holds_and_is_close(seed):
    """The bound is at least the largest distance of dense samples, and at most 1.2 times it; `max` and `rms` agree."""
    a = corpus_cage(seed)
    b = moved(a, seed)
    got, of_vertices = lib.deviation(a, b)
    n, true = 8 if seed % 2 else 6, 0.0
    while not got.max < 1.01 * true and n < 32:  # samples come to the largest distance from below
        n *= 2
        of_a, of_b = sampled(a, n), sampled(b, n // (1 + seed % 2))
        from_a, from_b = distances(of_a.points, of_b), distances(of_b.points, of_a)
        true = max(from_a.max(), from_b.max())
    rms = math.sqrt((from_a ** 2 * of_a.area).sum() / of_a.area.sum())
    assert got.bound >= true * (1 - 1e-6)
    assert got.bound <= PROMISED * max(got.max, true)
    assert got.bound <= PROMISED * true * 1.005  # samples are not everywhere
    assert 0.85 * true < got.max < 1.01 * true
    assert abs(got.rms - rms) < 0.01 * rms
    assert abs(got.size - size_of(a)) < 1e-12 * got.size
    assert np.nanmax(of_vertices) <= got.max * 1.15
    m = len(of_b.jets)
    limits = of_b.points[m:m + b.n_vertices]
    farthest = np.argsort(-distances(limits, of_a))[:20]
    by_samples = distances(limits[farthest], of_a)  # of so few, every one by closer samples
    if not np.allclose(of_vertices[farthest], by_samples, rtol=2e-2, atol=0):  # they are from above, near a pole by much
        by_samples = np.minimum(by_samples, distances(limits[farthest], sampled(a, 96)))
    np.testing.assert_allclose(of_vertices[farthest], by_samples, rtol=2e-2)


@pytest.mark.parametrize("shift", (0.3, 1e-3, 1e-6))
def test_translation(shift):
    """A closed surface and the same moved by t are |t| apart: at the top in the direction of t nothing is nearer."""
    a = torus_cage(8, 8, 0.5)
    t = shift * np.array([0.48, 0.6, 0.64])
    got, _ = lib.deviation(a, a.with_xyz(a.xyz + t))
    assert 0.98 * shift < got.max <= shift * (1 + 1e-6) and shift * (1 - 1e-9) <= got.bound <= PROMISED * shift
    assert abs(np.linalg.norm(np.array(got.point) - np.array(got.other_point)) - got.max) < 1e-9


@pytest.mark.parametrize("name, floor", (("torus_050_8x8", 1e-9), ("mug_g1", 1e-4), ("trefoil_g1", 1e-9)))
def test_same_surface(name, floor):
    """Subdividing a cage does not change its surface: exact up to the tips at extraordinary vertices."""
    a = read_obj(lib.ROOT / "blend_files" / "obj" / f"{name}.obj")
    equal, _ = lib.deviation(a, a)
    assert max(equal.max, equal.bound) < 1e-9 * equal.size
    for b in (refine(a), refine(refine(a))):
        got, _ = lib.deviation(a, b)
        assert max(got.max, got.bound) < floor * got.size and got.rms < 1e-9 * got.size


def test_both_directions_count():
    """A second component far off is far from the first surface, though every point of that is on the other one."""
    a = torus_cage(8, 8, 0.3)
    b = joined(a, a.with_xyz(0.1 * a.xyz + [0, 0, 5]))
    for one, two in ((a, b), (b, a)):
        got, _ = lib.deviation(one, two)
        assert 4 < got.max < 6 and got.max <= got.bound <= PROMISED * got.max
    assert lib.deviation(a, b)[0].rms < 1e-9
    assert lib.deviation(b, a)[0].rms > 0.1


def test_units_and_threads():
    """Lengths scale with the cages; the bits do not depend on the number of threads."""
    a = corpus_cage(13)
    b = moved(a, 13)
    one, of_one = lib.deviation(a, b, threads=1)
    three, of_three = lib.deviation(a, b, threads=3)
    assert bytes(one) == bytes(three) and of_one.tobytes() == of_three.tobytes()
    big, _ = lib.deviation(a.with_xyz(1024 * a.xyz), b.with_xyz(1024 * b.xyz))
    assert (big.max, big.rms, big.bound) == pytest.approx((1024 * one.max, 1024 * one.rms, 1024 * one.bound), rel=1e-6)


# --------------------------------------------------------------------------------------------------- crossings --

@pytest.mark.parametrize("path", BLEND_CAGES, ids=lambda p: p.stem)
def test_no_false_alarm_on_blend_files(path):
    """No cage to start from crosses itself, by dense sampling, and none is said to."""
    mesh = read_obj(path)
    got = lib.crossings(mesh)
    assert not crossing_faces(mesh, 3)
    assert (got.n_pairs, got.n_contacts, got.n_unresolved) == (0, 0, 0)


@pytest.mark.parametrize("seed", SEEDS)
def test_corpus(seed):
    """Moved cages of the corpus: what samples show is found, and what is found is shown by finer samples."""
    mesh = corpus_cage(seed)
    rng = np.random.default_rng(seed)
    for amount in (0, 0.3):
        cage = mesh.with_xyz(mesh.xyz + amount * size_of(mesh) * rng.uniform(-1, 1, mesh.xyz.shape))
        got = lib.crossings(cage)
        found = {tuple(pair) for pair in got.pairs.tolist()}
        coarse = crossing_faces(cage, 3)
        undecided = got.n_contacts + got.n_unresolved
        if not coarse and found:
            assert found <= crossing_faces(cage, 5)
        if coarse:  # triangles of neighbours cross near folds: pairs need not agree, but that something crosses
            assert found or undecided
        assert len(coarse - found) <= 0.25 * len(coarse) + 2 + undecided
        if amount == 0:
            assert not found or coarse


def first_crossing(cage_of, low: float, high: float, crosses) -> float:
    """The parameter from which on a cage crosses itself, by halving."""
    assert not crosses(cage_of(low)) and crosses(cage_of(high))
    for _ in range(12):
        middle = (low + high) / 2
        low, high = (low, middle) if crosses(cage_of(middle)) else (middle, high)
    return high


def is_found(mesh: Mesh) -> bool:
    """Whether the library finds a crossing."""
    return lib.crossings(mesh).n_pairs > 0


def linked(distance: float, sides: int = 24) -> Mesh:
    """Two tori of radii 1 and 0.3 at right angles, linked, their middles so far apart."""
    one = periodic_net(torus(0.3), sides, 2 * sides)
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0.0]])
    return joined(one, one.with_xyz(one.xyz @ turn.T + [distance, 0, 0]))


def test_linked_tori():
    """Circles of radius 1 at right angles are |d| apart near each other: tubes of 0.3 meet at d = 0.6."""
    found = first_crossing(lambda x: linked(1 - x), 0, 0.7, is_found)
    assert abs((1 - found) - 0.6) < 1e-3  # nets interpolate: 3e-4 at these sizes


def trefoil(thickness: float) -> Mesh:
    """A tube of eight sides round a trefoil."""
    n, m = 48, 8
    t = 2 * np.pi * np.arange(n) / n
    curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    along = np.stack([np.cos(t) + 4 * np.cos(2 * t), -np.sin(t) + 4 * np.sin(2 * t), -3 * np.cos(3 * t)], axis=1)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, [0, 0, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, along)
    a = 2 * np.pi * np.arange(m) / m
    xyz = curve[:, None] + thickness * (np.cos(a)[None, :, None] * side[:, None] + np.sin(a)[None, :, None] * up[:, None])
    faces = [[i * m + j, i * m + (j + 1) % m, (i + 1) % n * m + (j + 1) % m, (i + 1) % n * m + j]
             for i in range(n) for j in range(m)]
    return mesh_from_faces(xyz.reshape(-1, 3), faces)


def test_trefoil_tubes():
    """A tube round a trefoil crosses itself from a thickness on, which triangles four levels down agree on."""
    found = first_crossing(trefoil, 0.3, 1.2, is_found)
    assert not crossing_faces(trefoil(found - 2e-3), 4) and crossing_faces(trefoil(found + 2e-3), 4)


def test_shaken_grids():
    """A grid that is shaken until faces near each other cross."""
    n = 6
    xy = np.stack(np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij"), axis=-1).reshape(-1, 2)
    faces = [[i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1]
             for i in range(n) for j in range(n)]
    xyz = np.c_[xy, 0.1 * np.sin(xy[:, 0]) * np.cos(xy[:, 1])]
    assert lib.crossings(mesh_from_faces(xyz, faces)).n_pairs == 0
    rng = np.random.default_rng(1)
    for _ in range(5):
        folded = mesh_from_faces(xyz + rng.uniform(-1.5, 1.5, xyz.shape), faces)
        assert crossing_faces(folded, 4) and lib.crossings(folded).n_pairs > 0


def test_large_cage_and_threads():
    """100 000 faces in less than two seconds of one processor; pairs do not depend on threads."""
    big = torus_cage(400, 250, 0.5)
    begin = time.process_time()
    got = lib.crossings(big, threads=1)
    assert got.n_pairs == 0 and got.n_unresolved == 0 and time.process_time() - begin < 2
    mesh = linked(0.45)
    one, three = lib.crossings(mesh, threads=1), lib.crossings(mesh, threads=3)
    assert one.n_pairs > 8 and one.pairs.tolist() == three.pairs.tolist() and bytes(one) == bytes(three)
    some = lib.crossings(mesh, room=5)
    assert (some.n_pairs, some.n_listed) == (one.n_pairs, 5) and some.pairs.tolist() == one.pairs.tolist()[:5]


# ------------------------------------------------------------------------------------------------------- units --

@pytest.mark.parametrize("exponent", [-330, -200, 40, 200, 330])
def test_any_unit_has_the_same_digits(exponent):
    """Coordinates from 1e-99 to 1e99: lengths in another unit, a power of two, are the same to the last bit."""
    def in_unit(mesh):
        return mesh_from_faces(np.ldexp(mesh.xyz, exponent), mesh.face_list())

    cage, crossed = torus_cage(7, 5, 0.5), linked(0.45)
    other = mesh_from_faces(cage.xyz + 0.05 * np.sin(7 * cage.xyz[:, ::-1]), cage.face_list())
    (one, far), (two, scaled) = lib.deviation(cage, other), lib.deviation(in_unit(cage), in_unit(other))
    for key in ("max", "rms", "bound", "size"):
        assert getattr(two, key) == np.ldexp(getattr(one, key), exponent) > 0
    assert list(two.point) == list(np.ldexp(one.point, exponent)) and (scaled == np.ldexp(far, exponent)).all()
    assert lib.crossings(in_unit(crossed)).pairs.tolist() == lib.crossings(crossed).pairs.tolist() != []
    cage.xyz[3] = 2 * cage.xyz[9] - cage.xyz[3]
    assert lib.folds(in_unit(cage)).tolist() == lib.folds(cage).tolist()
    assert lib.folds(in_unit(other)).tolist() == []


# ------------------------------------------------------------------------------------------------ command line --

def test_command_line(tmp_path):
    """`minimize` and `evaluate --deviation-from` report the same deviation; crossings are faces of the cage given."""
    cage = lib.ROOT / "blend_files" / "obj" / "torus_050_8x8.obj"
    tool, out = lib.BUILD / "curvopt", tmp_path / "out.obj"
    run = subprocess.run([tool, "minimize", cage, "-o", out, "--levels", "2", "--json", tmp_path / "run.json"],
                         capture_output=True, text=True, check=True)
    assert "deviation" in run.stdout and "crosses" not in run.stdout
    subprocess.run([tool, "evaluate", out, "--deviation-from", cage, "--json", tmp_path / "again.json", "--quiet"], check=True)
    first, again = (json.loads((tmp_path / name).read_text()) for name in ("run.json", "again.json"))
    got, _ = lib.deviation(read_obj(cage), read_obj(out))
    for key in ("max", "rms", "bound", "size"):
        assert first["deviation"][key] == pytest.approx(again["deviation"][key], rel=1e-6)
        assert first["deviation"][key] == pytest.approx(getattr(got, key), rel=1e-6)
    assert first["crossings"] == again["crossings"] == []
    crossed = write_obj(tmp_path / "linked.obj", linked(0.45))
    run = subprocess.run([tool, "evaluate", crossed, "--json", tmp_path / "linked.json"], capture_output=True, text=True,
                         check=True)
    told = json.loads((tmp_path / "linked.json").read_text())
    assert told["crossings"] == lib.crossings(linked(0.45)).pairs.tolist() and "crosses itself" in run.stdout
    assert told["n_crossings"] == len(told["crossings"]) and "deviation" not in told
    wrong = subprocess.run([tool, "evaluate", cage, "--deviation-from", tmp_path / "none.obj"], capture_output=True, text=True)
    assert wrong.returncode == 1 and "none.obj" in wrong.stderr

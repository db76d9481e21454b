# SPDX-License-Identifier: GPL-3.0-or-later
"""Points, normals and tangents of the surface that springs draw (curvopt_through.weights): forces balance, by B-splines and limit
masks; the springs' energy is its definition, by OpenSubdiv, on every level; between weight 0, the free result, and 1, the
exact one; any number of places."""
from __future__ import annotations

import json
import math
import subprocess

import numpy as np
import pytest

import lib
import test_slide as sliding
import test_through as points
import test_through_frames as frames
from ccref import Mesh
from nets import read_obj, sphere_like, torus_cage, write_obj
from osd import osd_jets

NONE, FREE_SPACING = 1, 2
HELD, LINE, PLANE, FREE = range(4)
NAN = float("nan")
STIFFNESS = {"willmore": 24 * np.pi, "mvs": 2979.1973808604575}  # of a sphere: libcurvopt/notes/80-soft-constraints.md


def radius(mesh: Mesh) -> float:
    """Root mean square distance of the vertices from their mean."""
    return float(np.sqrt(((mesh.xyz - mesh.xyz.mean(axis=0)) ** 2).sum(axis=1).mean()))


def projector(freedom: int, direction: np.ndarray) -> np.ndarray:
    """Onto the directions in which a point of that freedom is held."""
    along = np.outer(direction, direction) / (direction @ direction)
    return {HELD: np.eye(3), LINE: np.eye(3) - along, PLANE: along, FREE: np.zeros((3, 3))}[freedom]


def orthonormal(tangents: np.ndarray) -> np.ndarray:
    """Coefficients [2, 2] that combine two tangents [2, 3] to two at right angles, of length 1, the first as it was."""
    return np.linalg.inv(np.linalg.qr(tangents.T)[1]).T


def sum_of(firmness: np.ndarray, off: np.ndarray, slope: np.ndarray) -> float:
    """Half the sum over entries: of distances `off` [n, 3], in radii, and slopes [n, 2] of tangents along a normal."""
    return float((firmness * ((off ** 2).sum(axis=1) + (slope ** 2).sum(axis=1))).sum() / 2)


# ------------------------------------------------------------------------------------------------------- forces --

def spline(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Weights [4] of a uniform cubic B-spline, and their derivatives."""
    return (np.array([(1 - t) ** 3, 3 * t ** 3 - 6 * t * t + 4, -3 * t ** 3 + 3 * t * t + 3 * t + 1, t ** 3]) / 6,
            np.array([-(1 - t) ** 2, 3 * t * t - 4 * t, -3 * t * t + 2 * t + 1, t * t]) / 2)


def rows_on_torus(m: int, n: int, face: int, u: float, v: float) -> np.ndarray:
    """Rows [3, m n] of S, S_u and S_v on a face of torus_cage(m, n): a regular bicubic patch."""
    (a, da), (b, db) = spline(u), spline(v)
    out = np.zeros((3, m * n))
    for i in range(4):
        for j in range(4):
            at = (face // n + i - 1) % m * n + (face % n + j - 1) % n
            out[:, at] += a[i] * b[j], da[i] * b[j], a[i] * db[j]
    return out


def scene(name: str):
    """A cage, its fields of lib.through() that say where, and rows [n, 3, n_vertices] of points and two tangents there: places
    in faces of a torus, or poles and other vertices of a subdivided cube."""
    if name == "faces":
        mesh, faces = torus_cage(9, 7, 0.4), np.array([3, 4, 11, 30, 52])
        uv = np.array([[0.2, 0.9], [0.25, 0.5], [0.5, 0.75], [0.1, 0.1], [0.8, 0.3]])
        return mesh, dict(faces=faces, uv=uv), np.array([rows_on_torus(9, 7, f, *at) for f, at in zip(faces, uv)])
    mesh, vertices = lib.refine(lib.refine(points.shaken_cube())), np.array([41, 3, 0, 7, 20, 60, 26])
    toward = [next(f[(f.index(v) + 1) % 4] for f in mesh.face_list() if v in f) for v in vertices]
    rows = [np.vstack([mask, frames.tangent_masks(mesh, v, w)])
            for mask, v, w in zip(points.masks(mesh, vertices), vertices, toward)]
    return mesh, dict(vertices=vertices), np.array(rows)


@pytest.mark.parametrize("name, energy, most", [("faces", "willmore", 1e-3), ("vertices", "willmore", 1e-3), ("faces", "mvs", 1e-3)])
def test_forces_balance(name, energy, most, capsys):
    """At the end the surface's gradient, by the public evaluation, is what springs draw with, at every vertex of the cage, but
    for a combination of the rows of one point that is held exactly beside them."""
    mesh, where, rows = scene(name)
    random, n, size = np.random.default_rng(2), len(rows), radius(mesh)
    freedom, weights, directions = np.arange(n) % 4, random.uniform(0.3, 0.95, n), random.normal(size=(n, 3))
    first = rows[:, 1:] @ mesh.xyz
    tangents = np.array([orthonormal(t) @ r for t, r in zip(first, rows[:, 1:])])
    normals = frames.unit(frames.unit(np.cross(first[:, 0], first[:, 1])) + 0.3 * random.normal(size=(n, 3)))
    places = rows[:, 0] @ mesh.xyz + 0.1 * size * random.normal(size=(n, 3))
    freedom[0], weights[0], normals[0] = HELD, 1, NAN
    result = lib.minimize(mesh, energy, levels=1, spacing=FREE_SPACING, tolerance=1e-7, decrement_tolerance=1e-13,
                          through=lib.through(**where, freedom=freedom, directions=directions, normals=normals, weights=weights,
                                              places=np.where((freedom == FREE)[:, None], NAN, places)))
    found = result.mesh.xyz
    _, gradient = lib.Problem(mesh, lib.options(energy, tolerance=1e-7)).evaluate(found, gradient=True)
    k = STIFFNESS[energy] * weights[1:] / (1 - weights[1:])
    held = np.array([projector(f, d) for f, d in zip(freedom, directions)])
    off = ((rows[:, 0] @ found - places)[:, None] @ held)[1:, 0] / size
    slope = np.einsum("nkv,vc,nc->nk", tangents, found, normals)[1:]
    pull = np.einsum("n,nv,nc->vc", k, rows[1:, 0], off) / size + np.einsum("n,nk,nkv,nc->vc", k, slope, tangents[1:], normals[1:])
    rest = gradient + pull
    of_held = rows[0, 0][:, None]
    left = rest - of_held @ (of_held.T @ rest) / (of_held.T @ of_held)
    share = np.linalg.norm(left) / np.linalg.norm(pull)
    with capsys.disabled():
        print(f"\n  {name}, {energy}, {n} entries: {result.verdict}, springs {result.summary.spring_energy:.4g} beside "
              f"{result.summary.end.objective:.4g}; of their forces {share:.1e} is left")
    assert result.verdict == "minimum" and share <= most and np.linalg.norm(rest) > 10 * np.linalg.norm(left)
    assert abs(result.summary.spring_energy - sum_of(k, off, slope)) <= 1e-9 * result.summary.spring_energy
    assert np.abs(rows[0, 0] @ found - places[0]).max() <= 1e-12


# ------------------------------------------------------------------------------------------------------- levels --

def slopes(first: Mesh, last: Mesh, where: frames.Places, levels: int, normals: np.ndarray) -> np.ndarray:
    """Of two tangents that have length 1 and are at right angles on `first` [n, 2], what they have of the normals on `last`,
    two cages of that level: by OpenSubdiv inside faces, by masks of tangents, one subdivision on, at vertices."""
    before, after = (osd_jets(mesh, *where.on(levels)).jets[:, 1:3] for mesh in (first, last))
    fine, faces = lib.refine(last), lib.refine(first).face_list()
    out = []
    for v in where.vertices:
        masks = frames.tangent_masks(fine, v, next(f[(f.index(v) + 1) % 4] for f in faces if v in f))
        out.append((masks @ lib.refine(first).xyz, masks @ fine.xyz))
    return np.array([orthonormal(a) @ b @ normal for (a, b), normal in zip([*out, *zip(before, after)], normals)])


@pytest.mark.parametrize("levels", [1, 2, 3] if lib.LONG else [1, 3])
def test_the_same_places_are_drawn_on_every_level(levels):
    """Vertices of 3, 4 and 5 faces, places in quads and in other faces: the springs' energy is the sum by OpenSubdiv."""
    mesh, random = points.corpus_cage(13), np.random.default_rng(5)
    where = frames.Places(mesh, random, 8)
    n, size = where.n, points.size(mesh)
    freedom, directions = random.integers(0, 3, n), frames.unit(random.normal(size=(n, 3)))
    at, normals = where.look(mesh, 1)
    places, weights = at + 0.1 * size * random.normal(size=(n, 3)), random.uniform(0.1, 0.7, n)
    goal = frames.unit(normals + 0.3 * random.normal(size=(n, 3)))
    result = lib.minimize(mesh, levels=levels, through=lib.through(
        **where.fields(), freedom=freedom, directions=directions, places=places, normals=goal, weights=weights))
    first = mesh
    for _ in range(levels - 1):
        first = lib.refine(first)
    found = where.look(result.mesh, levels)[0] - places
    off = np.array([projector(f, d) @ x for f, d, x in zip(freedom, directions, found)]) / radius(mesh)
    slope = slopes(first, result.mesh, where, levels, goal)
    total = sum_of(STIFFNESS["willmore"] * weights / (1 - weights), off, slope)
    assert result.verdict == "minimum" and (slope ** 2).sum() > 1e-3 < (off ** 2).sum()
    assert abs(result.summary.spring_energy - total) <= 1e-6 * total


def test_a_tangent_is_drawn_on_every_level():
    """Along v inside a face, with a normal, among points that are held. The springs' energy is the sum of squares of sines."""
    mesh, levels = torus_cage(8, 5, 0.4), 2
    jet = osd_jets(mesh, [7], [0], [[0.3, 0.6]]).jets[0]
    normal = frames.unit(np.cross(jet[1], jet[2]))
    goal = frames.unit(frames.unit(jet[2]) + 0.4 * normal + 0.3 * frames.unit(jet[1]))
    weight, nan, held = 0.8, [NAN] * 3, [6, 7, 8, 11, 12, 13]
    result = lib.minimize(mesh, levels=levels, through=lib.through(
        [-1, *held], [7] + [0] * 6, uv=[[0.3, 0.6]] + [[0, 0]] * 6, freedom=[FREE] + [HELD] * 6, tangents=[goal] + [nan] * 6,
        toward=[1] + [-1] * 6, normals=[frames.unit(np.cross(goal, jet[1]))] + [nan] * 6, weights=[weight] + [1] * 6))
    first, last = lib.refine(mesh), result.mesh
    where = (4 * 7 + 3, 0, 2 - 2 * 0.6, 2 * 0.3)  # the child at the last corner, whose parameters are turned by a quarter
    before, after = (osd_jets(m, [where[0]], [0], [where[2:]]).jets[0] for m in (first, last))
    tangent, other = after[1] / np.linalg.norm(before[1]), orthonormal(before[1:3]) @ after[1:3]
    square = tangent @ tangent - (tangent @ goal) ** 2 + (other[1] @ frames.unit(np.cross(goal, jet[1]))) ** 2
    total = STIFFNESS["willmore"] * weight / (1 - weight) * square / 2
    assert result.verdict == "minimum" and total > 1e-3
    assert abs(result.summary.spring_energy - total) <= 1e-6 * total


# ------------------------------------------------------------------------------------------------------- limits --

def frames_of_a_ball() -> tuple[Mesh, dict]:
    """A cage, and places and normals at some of its vertices that no smooth surface goes through easily."""
    mesh, random = sphere_like(3), np.random.default_rng(8)
    vertices = random.choice(mesh.n_vertices, 6, replace=False)
    return mesh, dict(vertices=vertices, places=points.limits(mesh)[vertices] * (1 + 0.2 * random.uniform(-1, 1, (6, 1))))


def test_a_large_weight_tends_to_what_holds_exactly(capsys):
    """Distances from places, and how far the energy is below that of the exact result, fall like 1 - w."""
    mesh, fields = frames_of_a_ball()

    def run(weights) -> lib.Result:
        return lib.minimize(mesh, levels=1, symmetry=NONE, spacing=FREE_SPACING, decrement_tolerance=1e-13, tolerance=1e-7,
                            through=lib.through(**fields, weights=weights))

    exact, found = run(None), []
    for softness in (1e-2, 1e-3, 1e-4):
        result = run(np.full(6, 1 - softness))
        assert result.verdict == "minimum"
        off = np.linalg.norm(points.limits(result.mesh)[fields["vertices"]] - fields["places"], axis=1).max()
        found.append((off, exact.summary.end.objective - result.summary.end.objective))
    ratios = np.array(found[:-1]) / found[1:]
    with capsys.disabled():
        print(f"\n  distances from places, and energy below the exact result's:\n{np.array(found)}\n{ratios}")
    assert (ratios > 9).all() and (ratios < 11).all() and found[-1][0] < 1e-4


def test_weights_of_0_hold_nothing():
    mesh, fields = frames_of_a_ball()
    free, drawn = (lib.minimize(mesh, levels=2, **held) for held in ({}, dict(through=lib.through(**fields, weights=np.zeros(6)))))
    assert np.array_equal(free.mesh.xyz, drawn.mesh.xyz) and drawn.summary.spring_energy == 0
    both = lib.through(np.r_[fields["vertices"], 0], places=np.vstack([fields["places"], [9, 9, 9]]), weights=[1] * 6 + [0])
    exact, other = (lib.minimize(mesh, levels=1, symmetry=NONE, through=t) for t in (lib.through(**fields), both))
    assert np.array_equal(exact.mesh.xyz, other.mesh.xyz)


def test_weights_next_to_1_hold_exactly():
    """Springs so stiff that no digits are left for the energy are none."""
    mesh, fields = frames_of_a_ball()
    exact, soft, next_to_1 = (lib.minimize(mesh, levels=1, symmetry=NONE, through=lib.through(**fields, weights=np.full(6, w)))
                              for w in (1.0, 1 - 1e-8, 1 - 1e-12))
    assert np.array_equal(exact.mesh.xyz, next_to_1.mesh.xyz) and exact.summary.spring_energy == 0
    assert soft.verdict == "minimum" and not np.array_equal(exact.mesh.xyz, soft.mesh.xyz)


def test_there_may_be_more_places_than_freedom(capsys):
    """400 places near a sphere, on a cage of 26 vertices; the same point drawn to two places ends between them by weights."""
    mesh, random = sphere_like(2), np.random.default_rng(3)
    faces, uv = random.integers(0, len(mesh.face_list()), 400), random.uniform(0.05, 0.95, (400, 2))
    at = osd_jets(mesh, faces, np.zeros(400, int), uv).jets[:, 0]
    places = frames.unit(at) + 0.02 * random.normal(size=at.shape)
    result = lib.minimize(mesh, levels=3, through=lib.through(faces=faces, uv=uv, places=places, weights=np.full(400, 0.5)))
    far = np.linalg.norm(points.limits(result.mesh), axis=1) - 1
    two = lib.minimize(mesh, levels=2, spacing=FREE_SPACING, decrement_tolerance=1e-11, through=lib.through(
        [5, 5], places=points.limits(mesh)[[5, 5]] * [[1], [1.2]], weights=[0.9, 0.999]))
    with capsys.disabled():
        print(f"\n  distances to the sphere up to {np.abs(far).max():.1e}, noise .02; {result.verdict}")
    assert result.verdict == "minimum" and two.verdict == "minimum" and np.abs(far).max() < 0.02
    apart = points.limits(two.mesh)[5] / points.limits(mesh)[5]
    assert np.allclose(apart, (9 + 999 * 1.2) / 1008, rtol=1e-4)


@pytest.mark.parametrize("steps", [None, 0, 2])
def test_cancelled_runs_report_their_springs(steps):
    """Cancelled before it begins (None) or while vertices slide: the energy of a spring of the cage that is returned."""
    mesh, weight, v = sliding.cap(0.5)[0], 0.75, 0
    place = points.limits(mesh)[v] + [0.2, 0.1, 0]
    cancel = lib.make_cancel()
    if steps is None:
        lib.library().curvopt_cancel_request(cancel.pointer)
    result = lib.minimize(mesh, levels=1, slide=int(steps is not None), through=lib.through([v], places=[place], weights=[weight]),
                          progress=lambda report: report.iteration == steps, cancel=cancel)
    off = (points.limits(result.mesh)[v] - place) / radius(mesh)
    total = STIFFNESS["willmore"] * weight / (1 - weight) * (off @ off) / 2
    assert result.stop == "cancelled" and abs(result.summary.spring_energy - total) <= 1e-6 * total


# --------------------------------------------------------------------------------------------- what is refused --

@pytest.mark.parametrize("weight", [-0.1, 1.1, NAN, math.inf])
def test_weights_are_from_0_to_1(weight):
    with pytest.raises(lib.CurvoptError, match="entry 1 has the weight .*; it must be 0 to 1"):
        lib.minimize(torus_cage(8, 5, 0.4), levels=1, through=lib.through([1, 2], weights=[0.5, weight]))


def test_tangents_need_a_tangent_plane_to_begin_with():
    mesh = torus_cage(8, 5, 0.4)
    mesh.xyz[:] = mesh.xyz[:, [0, 0, 0]]  # a line
    with pytest.raises(lib.CurvoptError, match="entry 0: the surface has no tangent plane there|no surface|degenerate"):
        lib.minimize(mesh, levels=1, through=lib.through([1], normals=[[0, 0, 1]], weights=[0.5]))


# ------------------------------------------------------------------------------------------ the command line --

def test_the_command_line_reads_weights_and_standard_input(tmp_path):
    """The same cage, bit by bit, as by the library; the springs' energy is in the report."""
    mesh = torus_cage(8, 5, 0.4)
    cage, out, report = tmp_path / "cage.obj", tmp_path / "out.obj", tmp_path / "report.json"
    write_obj(cage, mesh)
    place = np.round(points.limits(mesh)[5] * 1.1, 6).tolist()
    entries = [{"vertex": 5, "at": place, "weight": 0.75}, {"vertex": 22, "at": "here"}]
    subprocess.run([lib.BUILD / "curvopt", "minimize", cage, "-o", out, "--levels", "1", "--through", "-", "--json", report, "--quiet"],
                   input=json.dumps(entries), text=True, check=True)
    result = lib.minimize(mesh, levels=1, through=lib.through([5, 22], places=[place, [NAN] * 3], weights=[0.75, 1]))
    assert np.array_equal(read_obj(out).xyz, result.mesh.xyz)
    assert json.loads(report.read_text())["spring_energy"] == result.summary.spring_energy > 0

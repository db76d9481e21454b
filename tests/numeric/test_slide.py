# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices that slide along boundaries and creases: the curve stays, spacing and energies get better."""
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import torus_cage

NONE, PLANES = 1, 4  # curvopt_symmetry
TANGENT, FREE = 1, 3  # curvopt_boundary
N, RINGS = 16, 4


def cap(bunched: float, n: int = N, rings: int = RINGS) -> tuple[Mesh, np.ndarray]:
    """A dome over a wavy closed boundary of n vertices, bunched on one side, and the boundary's vertices in order."""
    angle = 2 * np.pi * np.arange(n) / n
    angle = angle + bunched * np.sin(angle)
    radius = np.repeat(np.arange(1, rings + 1) / rings, n)
    all_angles = np.tile(angle, rings)
    height = 0.6 * (1 - radius ** 2) + 0.3 * radius ** 2 * np.cos(2 * all_angles)
    ring = np.stack([radius * np.cos(all_angles), radius * np.sin(all_angles), height], axis=1)
    at = lambda j, i: 1 + (j - 1) * n + i % n
    faces = [[0, at(1, i), at(1, i + 1), at(1, i + 2)] for i in range(0, n, 2)]
    faces += [[at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)] for j in range(1, rings) for i in range(n)]
    return mesh_from_faces(np.vstack([[[0, 0, 0.6]], ring]), faces), np.array([at(rings, i) for i in range(n)])


def plate(n: int = 6) -> Mesh:
    """A square of n x n faces with sharp corners, vertices bunched along two sides, with a bump."""
    t = np.linspace(0, 1, n + 1) ** 2
    x, y = np.meshgrid(t, np.linspace(0, 1, n + 1), indexing="ij")
    z = 0.3 * np.sin(np.pi * x) * np.sin(np.pi * y)
    at = lambda i, j: i * (n + 1) + j
    faces = [[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(n) for j in range(n)]
    corners = np.zeros(x.size)
    corners[[at(i, j) for i in (0, n) for j in (0, n)]] = 10
    return replace(mesh_from_faces(np.stack([x, y, z], -1).reshape(-1, 3), faces), vertex_sharpness=corners)


def closed_curve(control: np.ndarray, per_span: int) -> np.ndarray:
    """Points of the uniform cubic B-spline of a closed control polygon (n, 3)."""
    u = np.arange(per_span)[:, None] / per_span
    basis = np.stack([(1 - u) ** 3, 3 * u ** 3 - 6 * u ** 2 + 4, -3 * u ** 3 + 3 * u ** 2 + 3 * u + 1, u ** 3]) / 6
    rolled = [np.roll(control, k, axis=0) for k in (1, 0, -1, -2)]
    return sum(b[None] * p[:, None] for b, p in zip(basis, rolled)).reshape(-1, 3)


def distances(points: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Of points (k, 3) from a closed polyline (m, 3)."""
    a, d = curve, np.roll(curve, -1, axis=0) - curve
    off = points[:, None] - a[None]
    t = np.clip((off * d).sum(-1) / (d * d).sum(-1), 0, 1)
    return np.linalg.norm(off - t[..., None] * d, axis=-1).min(axis=1)


def limit_points(control: np.ndarray) -> np.ndarray:
    return (np.roll(control, 1, axis=0) + 4 * control + np.roll(control, -1, axis=0)) / 6


def boundary_loop(mesh: Mesh, start: int) -> np.ndarray:
    """The boundary's vertices in order, of a mesh with one boundary."""
    sides = {}
    for face in mesh.face_list():
        for a, b in zip(face, np.roll(face, -1)):
            sides[(int(a), int(b))] = True
    after = {a: b for a, b in sides if (b, a) not in sides}
    loop = [start]
    while after[loop[-1]] != start:
        loop.append(after[loop[-1]])
    return np.array(loop)


def mean_edge(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).mean())


@pytest.mark.parametrize("levels,most", [(1, 1e-2), (2, 2e-3), (3, 5e-4)])
def test_limit_curve_of_a_boundary_stays(levels, most):
    """On the input's curve at the vertices to rounding, and between them within `most` edges of the input."""
    mesh, boundary = cap(0.8)
    result = lib.minimize(mesh, "willmore", levels=levels, slide=1, symmetry=NONE)
    loop = result.mesh.xyz[boundary_loop(result.mesh, boundary[0])]
    before, edge = closed_curve(mesh.xyz[boundary], 2000), mean_edge(mesh.xyz[boundary])
    assert result.summary.n_sliding == N and len(loop) == N * 2 ** (levels - 1)
    assert distances(limit_points(loop), before).max() < 1e-6 * edge  # chords of the polyline
    off = distances(closed_curve(loop, 8), before).max()
    assert off < most * edge
    assert result.summary.curve_deviation == pytest.approx(off, rel=0.02, abs=1e-6 * edge)


@pytest.mark.parametrize("energy,levels", [("willmore", 1), ("mvs", 1), ("mvs", 2)])
def test_energy_ends_lower(energy, levels):
    """And the boundary is spaced more evenly."""
    mesh, boundary = cap(0.8)
    held, slid = (lib.minimize(mesh, energy, levels=levels, slide=k, symmetry=NONE) for k in (0, 1))
    assert held.verdict == slid.verdict == "minimum"
    assert slid.summary.end.objective < held.summary.end.objective
    spread = []
    for result in (held, slid):
        loop = result.mesh.xyz[boundary_loop(result.mesh, boundary[0])]
        edges = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
        spread.append(edges.max() / edges.min())
    assert spread[0] > 5 and spread[1] < 2


def test_verdict_is_on_vertices_where_they_are():
    """A run from the result without sliding finds next to nothing to do, and leaves the boundary as it is."""
    mesh, boundary = cap(0.8)
    slid = lib.minimize(mesh, "willmore", levels=1, slide=1, symmetry=NONE)
    again = lib.minimize(slid.mesh, "willmore", levels=1, symmetry=NONE)
    assert slid.verdict == again.verdict == "minimum"
    assert np.array_equal(again.mesh.xyz[boundary], slid.mesh.xyz[boundary])
    assert again.summary.end.objective == pytest.approx(slid.summary.end.objective, rel=1e-3)


def test_straight_sides_stay_straight_and_corners_where_they_are():
    mesh = plate()
    held, slid = (lib.minimize(mesh, "willmore", levels=1, slide=k, symmetry=NONE) for k in (0, 1))
    corners = mesh.vertex_sharpness > 0
    assert np.array_equal(slid.mesh.xyz[corners], mesh.xyz[corners])
    assert slid.summary.n_sliding == 4 * 5 and slid.summary.curve_deviation < 1e-13
    x, y, _ = slid.mesh.xyz.reshape(7, 7, 3).transpose(2, 0, 1)
    assert max(np.abs(y[:, 0]).max(), np.abs(y[:, -1] - 1).max(), np.abs(x[0]).max()) < 1e-13
    for sides in (x[:, 0], x[:, -1]):
        assert np.diff(sides).min() > 2 * np.diff(mesh.xyz.reshape(7, 7, 3)[:, 0, 0]).min()
    assert slid.summary.end.min_jacobian > held.summary.end.min_jacobian


@pytest.mark.parametrize("strength,least", [(0.5, 1e-4), (1, 0.1)])
def test_mirror_planes_are_kept(strength, least):
    """The bunched cap is its own mirror image in y: vertices on the plane stay on it. Springs to the input hold the
    others, too, so that little slides below strength 1."""
    mesh, _ = cap(0.6)
    result = lib.minimize(mesh, "willmore", levels=1, slide=1, symmetry=PLANES, symmetry_planes=2, strength=strength)
    partner = np.r_[0, 1 + (np.arange(RINGS)[:, None] * N + -np.arange(N)[None] % N).ravel()]
    assert np.abs(mesh.xyz[partner] * [1, -1, 1] - mesh.xyz).max() < 1e-12
    assert np.abs(result.mesh.xyz[partner] * [1, -1, 1] - result.mesh.xyz).max() < 1e-12
    assert result.summary.n_sliding == N and np.abs(result.mesh.xyz[-N:] - mesh.xyz[-N:]).max() > least


def test_pinned_vertices_do_not_slide():
    """Nor move; the curve stays to some thousandths of an edge at them, too."""
    mesh, boundary = cap(0.5)
    pinned = boundary[[0, 7, 8]]
    result = lib.minimize(mesh, "willmore", levels=1, slide=1, symmetry=NONE, constraints=lib.constraints(pinned))
    assert np.array_equal(result.mesh.xyz[pinned], mesh.xyz[pinned])
    assert result.summary.n_sliding == N - 3
    moved = np.linalg.norm(result.mesh.xyz - mesh.xyz, axis=1)[boundary]
    assert moved.max() > 0.1 * mean_edge(mesh.xyz[boundary])
    off = distances(closed_curve(result.mesh.xyz[boundary], 8), closed_curve(mesh.xyz[boundary], 2000)).max()
    assert off < 2e-2 * mean_edge(mesh.xyz[boundary])
    assert result.summary.curve_deviation == pytest.approx(off, rel=0.05)


@pytest.mark.parametrize("boundary", [TANGENT, FREE])
def test_nothing_slides_where_more_or_nothing_is_held(boundary):
    mesh, _ = cap(0.5)
    one, two = (lib.minimize(mesh, "willmore", levels=1, symmetry=NONE, boundary=boundary, slide=k,
                             max_iterations=20) for k in (0, 1))
    assert two.summary.n_sliding == 0 and np.array_equal(one.mesh.xyz, two.mesh.xyz)


def test_creases_slide_unless_they_fade():
    mesh = torus_cage(12, 6, 0.4)
    ring = [i * 6 for i in range(12)]
    bunched = mesh.xyz.copy()
    turn = 0.4 * np.sin(2 * np.pi * np.arange(12) / 12)
    c, s = np.cos(turn), np.sin(turn)
    for i in range(12):
        x, y = mesh.xyz[i * 6:(i + 1) * 6, :2].T
        bunched[i * 6:(i + 1) * 6, :2] = np.stack([c[i] * x - s[i] * y, s[i] * x + c[i] * y], axis=1)
    for sharpness, sliding in ((10, 12), (2, 0)):
        creases = {(ring[i], ring[(i + 1) % 12]): 10.0 for i in range(12)}
        if sharpness < 10:  # one fading edge that meets the curve: it is a corner there, for now
            creases[(ring[3], ring[3] + 1)] = float(sharpness)
        cage = mesh_from_faces(bunched, mesh.face_list(), creases)
        result = lib.minimize(cage, "willmore", levels=1, slide=1, symmetry=NONE)
        assert result.summary.n_sliding == sliding
        moved = np.linalg.norm(result.mesh.xyz[ring] - cage.xyz[ring], axis=1).max()
        assert moved > 0.05 if sliding else moved == 0
        off = distances(limit_points(result.mesh.xyz[ring]), closed_curve(cage.xyz[ring], 2000)).max()
        assert off < 1e-6


@pytest.mark.parametrize("steps", [1, 4, 12])
def test_cancelled_run_has_its_curve(steps):
    """The callback sees one run, and the cage that it saw last, on the curve, is the result, with its energy."""
    mesh, boundary = cap(0.8)
    seen = []

    def watch(report) -> bool:
        seen.append((report.level, report.iteration, np.ctypeslib.as_array(report.xyz, (mesh.n_vertices * 3,)).copy()))
        return len(seen) > steps

    result = lib.minimize(mesh, "willmore", progress=watch, levels=1, slide=1, symmetry=NONE)
    assert result.stop == "cancelled" and [iteration for _, iteration, _ in seen] == list(range(steps + 1))
    curve = closed_curve(mesh.xyz[boundary], 2000)
    for _, _, xyz in seen:
        assert distances(limit_points(xyz.reshape(-1, 3)[boundary]), curve).max() < 1e-6
    assert np.abs(result.mesh.xyz.ravel() - seen[-1][2]).max() < 1e-12
    assert result.summary.end.objective == pytest.approx(lib.evaluate(result.mesh).objective, rel=1e-2)


def test_command_line_reports_what_slides():
    mesh, _ = cap(0.5)
    figures, _ = lib.cli_minimize(mesh, "--slide", "--levels", "1")
    assert figures["n_sliding"] == N and 0 < figures["curve_deviation"] < 0.02
    figures, _ = lib.cli_minimize(mesh, "--levels", "1")
    assert figures["n_sliding"] == 0 and figures["curve_deviation"] == 0

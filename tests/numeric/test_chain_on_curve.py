# SPDX-License-Identifier: GPL-3.0-or-later
"""A chain of edges whose limit curve goes through places of a given curve, level by level: how fast it comes to that curve, by
OpenSubdiv (libcurvopt/notes/122-a-chain-of-edges-on-a-curve.md). Each level is a run on the subdivided result."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import lib
import test_through as points
from ccref import Mesh
from nets import torus_cage
from osd import osd_jets

NONE = 1  # CURVOPT_SYMMETRY_NONE
LEVELS = 4 if lib.LONG else 3
Curve = Callable[[np.ndarray], np.ndarray]


def place_on(mesh: Mesh, a: int, b: int, t: float) -> tuple[int, tuple[float, float]]:
    """Face, and u and v, at the part t of the edge from a to b, in a mesh of quads."""
    faces = np.array(mesh.face_list())
    (f,), (k,) = np.nonzero((faces == a) & (np.roll(faces, -1, axis=1) == b))
    return f, ((t, 0), (1, t), (1 - t, 1), (0, 1 - t))[k]


def divided(mesh: Mesh, fine: Mesh, chain: list[int], is_closed: bool) -> list[int]:
    """The same chain on the subdivided mesh of quads, whose child at a corner goes on to the middle of the edge there."""
    out, children = [], fine.face_list()
    for a, b in zip(chain, chain[1:] + chain[:is_closed]):
        f, _ = place_on(mesh, a, b, 0)
        out += [a, children[4 * f + mesh.face_list()[f].index(a)][1]]
    return out if is_closed else out + chain[-1:]


def deviations(mesh: Mesh, chain: list[int], is_closed: bool, curve: Curve, distance: Curve, at: Curve, with_ends: bool) -> np.ndarray:
    """Largest distance [LEVELS] of the chain's limit curve from `curve`, on which its vertices' limit points are held at the
    parameters at(number of the vertex on the first level); with_ends: and the middles of the first and last edge."""
    out, step = [], 1.0
    for _ in range(LEVELS):
        edges = list(zip(chain, chain[1:] + chain[:is_closed]))
        numbers = step * np.arange(len(chain))
        vertices, faces, uv = list(chain), [0] * len(chain), [(0.0, 0.0)] * len(chain)
        for k in (0, len(edges) - 1) if with_ends else ():
            face, where = place_on(mesh, *edges[k], 0.5)
            vertices, faces, uv = vertices + [-1], faces + [face], uv + [where]
            numbers = np.r_[numbers, step * (k + 0.5)]
        held = lib.through(vertices, faces, uv=uv, places=curve(at(numbers)))
        result = lib.minimize(mesh, levels=1, symmetry=NONE, through=held)
        assert result.verdict == "minimum"
        where = [place_on(result.mesh, a, b, t) for a, b in edges for t in (0.1, 0.25, 0.5, 0.75, 0.9)]
        found = osd_jets(result.mesh, [f for f, _ in where], [0] * len(where), [p for _, p in where], level=6).jets[:, 0]
        out.append(distance(found).max())
        mesh, old, step = lib.refine(result.mesh), result.mesh, step / 2
        chain = divided(old, mesh, chain, is_closed)
    return np.array(out)


def orders(found: np.ndarray) -> np.ndarray:
    return np.log2(found[:-1] / found[1:])


def ring() -> tuple[Mesh, list[int], Curve, Curve]:
    """A meridian of a torus, and a circle in its plane, wider by 15 %."""
    mesh = torus_cage(9, 8, 0.4)
    limits = points.limits(mesh)[:8]
    middle, size = limits.mean(axis=0), 1.15 * np.linalg.norm(limits - limits.mean(axis=0), axis=1).mean()
    out, up = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    sign = np.sign((limits[2] - middle) @ up)

    def curve(t: np.ndarray) -> np.ndarray:
        return middle + size * (np.outer(np.cos(t), out) + sign * np.outer(np.sin(t), up))

    def distance(x: np.ndarray) -> np.ndarray:
        return np.hypot((x - middle)[:, 1], np.hypot((x - middle)[:, 0], (x - middle)[:, 2]) - size)

    return mesh, list(range(8)), curve, distance


def periodic(t: np.ndarray) -> Curve:
    """The periodic cubic spline through parameters t [n + 1] of a closed curve, the last one turn on."""
    n, turn = len(t) - 1, 2 * np.pi
    rest = t - turn * np.arange(n + 1) / n
    spline = CubicSpline(np.arange(n + 1), np.r_[rest[:-1], rest[0]], bc_type="periodic")
    return lambda x: spline(np.mod(x, n)) + turn * x / n


def test_a_closed_chain_comes_to_a_circle_with_order_4(capsys):
    """At uneven places, between which parameters are those of a spline. Were they piecewise linear, the limit curve, which is a
    spline itself, could not follow their kinks: with CURVOPT_LONG=1 that is tried, and even places, too."""
    mesh, chain, curve, distance = ring()
    even = 2 * np.pi * np.arange(9) / 8
    uneven = even + 0.25 * np.r_[np.random.default_rng(1).uniform(-1, 1, 8), 0]
    uneven[-1] = uneven[0] + 2 * np.pi
    ways = [periodic(uneven), lambda x: 2 * np.pi * x / 8, lambda x: np.interp(x, np.arange(9), uneven)]
    found = [deviations(mesh, chain, True, curve, distance, at, False) for at in (ways if lib.LONG else ways[:1])]
    with capsys.disabled():
        print("\n  spline, even, linear:", *found, sep="\n  ")
    for of in found[:2]:
        assert (orders(of) > 3.7).all() and (orders(of) < 4.6).all()
    for of in found[2:]:
        assert orders(of)[-1] < 2.5 and of[-1] > 5 * found[0][-1]


@pytest.mark.parametrize("with_ends, least, most", [(True, 3.7, 4.4), (False, 0.5, 2)])
def test_an_open_chain_needs_the_middles_of_its_end_edges(with_ends, least, most, capsys):
    """On an arc of a helix: without them the curve's two last freedoms are the energy's, and it does not come near at the ends."""
    mesh, rise, chain = torus_cage(12, 7, 0.4), 0.08, [7 * i for i in range(6)]
    size = 1.05 * np.hypot(*points.limits(mesh)[0, :2])

    def curve(t: np.ndarray) -> np.ndarray:
        return np.column_stack([size * np.cos(t), size * np.sin(t), rise * t])

    def distance(x: np.ndarray) -> np.ndarray:
        t = np.arctan2(x[:, 1], x[:, 0])
        for _ in range(20):  # Newton's method for the foot
            tangent = np.column_stack([-size * np.sin(t), size * np.cos(t), np.full(len(t), rise)])
            bend = np.column_stack([-size * np.cos(t), -size * np.sin(t), 0 * t])
            off = curve(t) - x
            t = t - (off * tangent).sum(axis=1) / ((tangent ** 2).sum(axis=1) + (off * bend).sum(axis=1))
        return np.linalg.norm(curve(t) - x, axis=1)

    found = deviations(mesh, chain, False, curve, distance, lambda x: 2 * np.pi * x / 12, with_ends)
    with capsys.disabled():
        print(f"\n  {'with' if with_ends else 'without'} the middles of end edges:", found)
    assert (orders(found) > least).all() and (orders(found) < most).all()

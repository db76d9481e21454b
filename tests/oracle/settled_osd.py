# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of second order on `limit` by OpenSubdiv's positions and derivatives, of any cage, open ones too.

Faces at extraordinary vertices are refined (ccref.py) until what is left of them counts for little; OpenSubdiv approximates
the surface there, and is asked for regular faces only, at boundaries and inside. Squares of these are cut in four until they
stand still (settled_ref.py).
"""
from __future__ import annotations

import numpy as np

from ccref import Mesh, Topology, refine, restrict, topology
from energy_ref import second_order
from osd import osd_jets
from settled_ref import FIRST_CUTS, NAMES, cut, gauss_square, settle

LEVELS = 18  # at most: derivatives then have 1e-5 of rounding left
LEFT = 1e-6  # of the whole, in the levels that are estimated


def regular(mesh: Mesh, topo: Topology) -> np.ndarray:
    """Faces [n_faces], quads among quads, all of whose vertices have four faces, or two on a boundary."""
    n_faces = np.bincount(mesh.flat, minlength=mesh.n_vertices)
    on_boundary = np.zeros(mesh.n_vertices, bool)
    on_boundary[topo.ends[topo.n_edge_faces == 1].ravel()] = True
    bad = n_faces != np.where(on_boundary, 2, 4)
    bad[mesh.flat[(mesh.sizes != 4)[topo.face]]] = True
    return np.bincount(topo.face, weights=bad[mesh.flat], minlength=mesh.n_faces) == 0


def over_faces(mesh: Mesh, faces: np.ndarray, cuts: int, digits: float) -> tuple[np.ndarray, np.ndarray]:
    """NAMES["limit"] [3] over some quads, cut so often at first, and how far these are off."""
    gs, gt, gw = gauss_square()

    def measured(squares: tuple) -> np.ndarray:
        at, s, t, side = (a[:, None] for a in squares)
        face = np.repeat(faces[squares[0]], len(gw))
        uv = np.stack([(s + side * gs).ravel(), (t + side * gt).ravel()], axis=1)
        found = second_order(osd_jets(mesh, face, np.zeros_like(face), uv, level=2).jets)
        weights = (side ** 2 * gw).ravel() * found["area"]
        sums = [weights * found["willmore"], weights * found["h2"], weights]
        return np.stack([a.reshape(len(at), -1).sum(1) for a in sums], axis=1)

    n = len(faces)
    squares = np.arange(n), np.zeros(n), np.zeros(n), np.ones(n)
    for _ in range(cuts):
        squares = cut(squares)
    return settle(measured, squares, [0, 1, 2], digits, 60_000)


def settled_osd(mesh: Mesh, digits: float = 1e-5) -> dict[str, tuple[float, float]]:
    """NAMES["limit"] of a cage, each with an estimate of how far it is off."""
    wanted, levels, off = np.ones(mesh.n_faces, bool), [], np.zeros(3)
    for level in range(LEVELS):
        here = wanted & regular(mesh, topology(mesh))
        found, error = over_faces(mesh, np.flatnonzero(here), max(FIRST_CUTS - level, 0), digits) if here.any() else np.zeros((2, 3))
        levels.append(found)
        off += error
        wanted &= ~here
        if not wanted.any() or (level > 2 and (found < LEFT * np.sum(levels, axis=0)).all()):
            break
        mesh, new_face = restrict(mesh, np.flatnonzero(wanted))
        wanted = np.repeat(wanted[new_face >= 0], mesh.sizes)
        mesh = refine(mesh)
    value = np.sum(levels, axis=0)
    if wanted.any():  # levels become a geometric series, whose rest is added, known to a quarter
        ratio = np.minimum(levels[-1] / levels[-2], 0.95)
        rest = levels[-1] * ratio / (1 - ratio)
        value, off = value + rest, off + rest / 4
    return {name: (float(v), float(e)) for name, v, e in zip(NAMES["limit"], value, off)}

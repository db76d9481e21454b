# SPDX-License-Identifier: GPL-3.0-or-later
"""The `polynomial` surface over m x m faces of each sector at one extraordinary vertex, written a second time.

From the library's jets on `limit` alone, which have tests of their own: of the mesh, and of the characteristic map, whose
control points are found here by refining the mesh. Blend, products, monomials and fit share nothing with the library but
the definition: which samples the fit is over, and with which weights.
"""
from __future__ import annotations

from math import factorial

import numpy as np

import lib
from ccref import JET_ORDERS, Mesh, deep_jets, refine, topology

DEGREE, FAR_WEIGHT, FIT_GAUSS, FIT_RINGS, ITERATIONS = 5, 1e-3, 4, 5, 30
PLACE = {at: k for k, at in enumerate(JET_ORDERS)}
FACTORIALS = np.array([factorial(p) * factorial(q) for p, q in JET_ORDERS], float)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of Taylor coefficients [n, 10]."""
    out = np.zeros_like(a)
    for i, (p, q) in enumerate(JET_ORDERS):
        for j, (r, s) in enumerate(JET_ORDERS):
            if (p + r, q + s) in PLACE:
                out[:, PLACE[p + r, q + s]] += a[:, i] * b[:, j]
    return out


def sectors(mesh: Mesh, vertex: int, size: int) -> list[np.ndarray]:
    """Of each sector at a vertex the faces and their corners nearest to it: [size (v), size (u), 2]."""
    quads = mesh.flat.reshape(-1, 4)
    side = {(quad[k], quad[(k + 1) % 4]): (f, k) for f, quad in enumerate(quads) for k in range(4)}

    def step(face: int, corner: int, towards: int) -> tuple[int, int]:
        """The face across the edge u = 1 (towards 1) or v = 1 (towards 2), and its corner at the same place."""
        twin, at = side[quads[face][(corner + towards + 1) % 4], quads[face][(corner + towards) % 4]]
        return twin, (at + 1) % 4 if towards == 1 else at

    out = []
    for face in np.flatnonzero((quads == vertex).any(axis=1)):
        here, rows = (face, int(np.flatnonzero(quads[face] == vertex)[0])), []
        for _ in range(size):
            row = [here]
            while len(row) < size:
                row.append(step(*row[-1], 1))
            rows.append(row)
            here = step(*here, 2)
        out.append(np.array(rows))
    return out


def sector_vertices(mesh: Mesh, sector: np.ndarray) -> np.ndarray:
    """Vertices at u, v = 0 of a sector's faces [size, size]."""
    return mesh.flat.reshape(-1, 4)[sector[..., 0], sector[..., 1]]


def characteristic_map(mesh: Mesh, vertex: int, size: int) -> Mesh:
    """The mesh with the characteristic map's control points (plane z = 0, up to scale) near a vertex, by refining."""
    fine = refine(mesh)
    coarse_at = [sector_vertices(mesh, s) for s in sectors(mesh, vertex, size)]
    fine_at = [sector_vertices(fine, s) for s in sectors(fine, vertex, size)]
    ray = [[(m.xyz[at[0, 1]] - m.xyz[vertex]) for at in ats] for m, ats in ((mesh, coarse_at), (fine, fine_at))]
    cosine = np.array([[a @ b / np.linalg.norm(b) for b in ray[1]] for a in ray[0]])
    fine_at = [fine_at[k] for k in cosine.argmax(axis=1)]  # in the same order
    frame = np.linalg.svd(mesh.xyz[vertex][None])[2][1:]
    near = np.zeros_like(mesh.xyz)
    for at in coarse_at:
        near[at, :2] = mesh.xyz[at] @ frame.T
    for _ in range(ITERATIONS):  # the other eigenvectors of this symmetry die out
        once = refine(mesh.with_xyz(near)).xyz
        near = np.zeros_like(near)
        for at, from_ in zip(coarse_at, fine_at):
            near[at] = once[from_]
        near -= near[vertex]
        near /= abs(near).max()
    return mesh.with_xyz(near)


def sector_taylor(mesh: Mesh, face: int, corner: int, st: np.ndarray, surface: str = "limit") -> np.ndarray:
    """Taylor coefficients [n, 10, 3] at coordinates (s, t) that start from a corner; surface "deep": the limit by ccref."""
    s, t = st.T
    uv = [(s, t), (1 - t, s), (1 - s, 1 - t), (t, 1 - s)][corner]
    at = np.full(len(st), face), np.zeros(len(st)), np.stack(uv, axis=1)
    jets = deep_jets(mesh, *at).astype(float) if surface == "deep" else lib.jets(mesh, *at, surface)
    taylor = jets / FACTORIALS[:, None]
    along_u, along_v = [(1, 1), (-1, 1), (-1, -1), (1, -1)][corner]  # signs of d(uv); u and v swap at odd corners
    out = np.empty_like(taylor)
    for k, (p, q) in enumerate(JET_ORDERS):
        out[:, PLACE[(q, p) if corner % 2 else (p, q)]] = along_u ** p * along_v ** q * taylor[:, k]
    return out


def weight(t: np.ndarray) -> np.ndarray:
    """Taylor coefficients [n, 4] of the library's blend of degree 7."""
    s = 1 - t
    return np.stack([1 - t ** 4 * (35 - 84 * t + 70 * t ** 2 - 20 * t ** 3), -140 * t ** 3 * s ** 3,
                     -210 * t ** 2 * s ** 2 * (1 - 2 * t), -140 * t * s * (1 - 5 * t * s)], axis=1)


def monomials(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Taylor coefficients [n, 10, terms] of the monomials up to DEGREE."""
    one = np.zeros_like(x)
    one[:, 0] = 1
    out = last = [one]
    for _ in range(DEGREE):
        last = [multiply(x, p) for p in last] + [multiply(y, last[-1])]
        out = out + last
    return np.stack(out, axis=2)


def gauss_points(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points [n^2, 2] and weights of the unit square."""
    node, gauss = np.polynomial.legendre.leggauss(n)
    node = (node + 1) / 2
    return np.stack(np.meshgrid(node, node, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(gauss, gauss).ravel() / 4


def fit_samples(i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights of face (i, j); towards the vertex in rings of three cells."""
    st, weights = gauss_points(FIT_GAUSS)
    if i or j:
        return st, weights
    cells = [(2.0 ** -ring, at) for ring in range(1, FIT_RINGS + 1) for at in ((1, 0), (1, 1), (0, 1))]
    return (np.concatenate([side * (st + at) for side, at in cells]),
            np.concatenate([side ** 2 * weights for side, _ in cells]))


class WideBlend:
    """One vertex of a mesh and the m x m faces of each of its sectors.

    `flat` is a mesh of the same connectivity whose shape near the vertex the characteristic map's iteration begins with.
    """

    def __init__(self, flat: Mesh, mesh: Mesh, vertex: int, m: int):
        self.m, self.mesh = m, mesh
        self.plane = characteristic_map(flat, vertex, m + 2)
        self.cells = [(int(face), int(corner), i, j) for sector in sectors(flat, vertex, m)
                      for j, row in enumerate(sector) for i, (face, corner) in enumerate(row)]
        samples = [(cell, *fit_samples(*cell[2:])) for cell in self.cells]
        maps = [sector_taylor(self.plane, *cell[:2], st)[:, 0] for cell, st, _ in samples]
        self.scale = 1 / max(abs(at).max() for at in maps)
        rows, right = [], []
        for (cell, st, weights), at in zip(samples, maps):
            root = np.sqrt(weights * (self.blend(cell, st)[:, 0] + FAR_WEIGHT))[:, None]
            jets = np.pad(self.scale * at[:, None, :2], ((0, 0), (0, 9), (0, 0)))
            rows.append(root * monomials(jets[..., 0], jets[..., 1])[:, 0])
            right.append(root * sector_taylor(mesh, *cell[:2], st)[:, 0])
        self.fit = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]

    def blend(self, cell: tuple[int, int, int, int], st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10] of the weight on a cell (face, corner, i, j)."""
        along = weight((cell[2] + st[:, 0]) / self.m), weight((cell[3] + st[:, 1]) / self.m)
        return np.stack([along[0][:, p] * along[1][:, q] / self.m ** (p + q) for p, q in JET_ORDERS], axis=1)

    def taylor(self, cell: tuple[int, int, int, int], st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10, 3] of the blended surface on a cell."""
        surface, at = sector_taylor(self.mesh, *cell[:2], st), self.scale * sector_taylor(self.plane, *cell[:2], st)
        gap, blend = monomials(at[..., 0], at[..., 1]) @ self.fit - surface, self.blend(cell, st)
        return surface + np.stack([multiply(blend, gap[..., a]) for a in range(3)], axis=-1)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What `polynomial` would leave of its floor if it blended over m x m faces of each sector instead of over one.

On fitted nets of 6 n^2 faces, of surfaces whose eight extraordinary vertices are alike (sphere, ellipsoids, star_P2): the
error of the variation for several m. The surface is made here, from the library's jets on `limit` and of the characteristic
map, with the library's weight and fit; m = 1 is the library's own. `python3 wide_blend.py [SURFACE [N [M...]]]`;
CURVOPT_BUILD as in orders.py.
"""
from __future__ import annotations

import sys
from math import factorial

import numpy as np

from orders import exact, lib, sphere_like, subdivided_cube, variation_density
from ccref import JET_ORDERS, Mesh, refine, topology

DEGREE, GAUSS, FAR_WEIGHT = 5, 14, 1e-3
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
    for _ in range(14):  # the other eigenvectors of this symmetry die out
        once = refine(mesh.with_xyz(near)).xyz
        near = np.zeros_like(near)
        for at, from_ in zip(coarse_at, fine_at):
            near[at] = once[from_]
        near -= near[vertex]
        near /= abs(near).max()
    return mesh.with_xyz(near)


def sector_taylor(mesh: Mesh, face: int, corner: int, st: np.ndarray) -> np.ndarray:
    """Taylor coefficients [n, 10, 3] on `limit` at coordinates (s, t) that start from a corner."""
    s, t = st.T
    uv = [(s, t), (1 - t, s), (1 - s, 1 - t), (t, 1 - s)][corner]
    taylor = lib.jets(mesh, np.full(len(st), face), np.zeros(len(st)), np.stack(uv, axis=1)) / FACTORIALS[:, None]
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


class Rings:
    """The first `size` rings round one vertex of a fitted net, sampled."""

    def __init__(self, name: str, n: int, size: int):
        grid = subdivided_cube(n)
        valence = np.bincount(topology(grid).ends.ravel())
        vertex = int(np.flatnonzero(valence == 3)[0])
        self.mesh = mesh = sphere_like(n, name, subdivided_cube)
        plane = characteristic_map(grid, vertex, size + 2)
        node, gauss = np.polynomial.legendre.leggauss(GAUSS)
        self.st = np.stack(np.meshgrid((node + 1) / 2, (node + 1) / 2, indexing="ij"), axis=-1).reshape(-1, 2)
        self.gauss = np.outer(gauss, gauss).ravel() / 4
        self.cells = [(i, j, sector_taylor(mesh, *sector[j, i], self.st), sector_taylor(plane, *sector[j, i], self.st))
                      for sector in sectors(grid, vertex, size) for j in range(size) for i in range(size)]

    def _blend(self, i: int, j: int, m: int) -> np.ndarray:
        along = weight((i + self.st[:, 0]) / m), weight((j + self.st[:, 1]) / m)
        return np.stack([along[0][:, p] * along[1][:, q] / m ** (p + q) for p, q in JET_ORDERS], axis=1)

    def variation(self, m: int) -> list[float]:
        """8 times the integral of |grad h|^2, ring by ring, with the blend over m x m faces of each sector."""
        inner = {k: cell for k, cell in enumerate(self.cells) if max(cell[:2]) < m}
        scale = 1 / max(abs(cell[3][:, 0]).max() for cell in inner.values())
        terms = {k: monomials(scale * cell[3][:, :, 0], scale * cell[3][:, :, 1]) for k, cell in inner.items()}
        blends = {k: self._blend(*cell[:2], m) for k, cell in inner.items()}
        root = {k: np.sqrt(self.gauss * (blends[k][:, 0] + FAR_WEIGHT))[:, None] for k in inner}
        fit = np.linalg.lstsq(np.concatenate([root[k] * terms[k][:, 0] for k in inner]),
                              np.concatenate([root[k] * inner[k][2][:, 0] for k in inner]), rcond=None)[0]
        sums = np.zeros(1 + max(cell[0] for cell in self.cells))
        for k, (i, j, surface, _) in enumerate(self.cells):
            if k in inner:
                gap = terms[k] @ fit - surface
                surface = surface + np.stack([multiply(blends[k], gap[..., a]) for a in range(3)], axis=-1)
            sums[max(i, j)] += self.gauss @ variation_density(surface * FACTORIALS[:, None])[0]
        return list(8 * sums)


def main() -> None:
    """Command line."""
    words = sys.argv[1:]
    name = words[0] if words else "sphere"
    n, *widths = [int(word) for word in words[1:]] or [32]
    widths = widths or [1, 2, 3, 4, 6, 8]
    rings = Rings(name, n, max(widths))
    whole = lib.evaluate(rings.mesh, "variation", "polynomial", tolerance=1e-6)
    error, first = whole.value("variation") - exact(name)["gradh2A"], rings.variation(1)
    for m in widths:
        found = rings.variation(m)
        print(f"m = {m}: error {error + whole.area * (sum(found) - sum(first)):.2f}; change by ring",
              ", ".join(f"{whole.area * (b - a):.2f}" for a, b in zip(first, found)), flush=True)


if __name__ == "__main__":
    main()

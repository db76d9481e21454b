# SPDX-License-Identifier: GPL-3.0-or-later
"""The `polynomial` surface at poles on boundaries and creases, at darts and at vertices of two edges, a second time.

The limit surface and the map of the natural net are both refined deeply (ccref), so that nothing comes from the library.
What the two have in common is the definition: the natural net, the prescribed curve, samples and weights of the fit.
"""
from __future__ import annotations

import numpy as np

from ccref import SHARP, Mesh, bspline_rows, mesh_from_faces, topology
from wide_ref import DEGREE, FAR_WEIGHT, JET_ORDERS, fit_samples, monomials, multiply, sector_taylor, weight

CURVE_TERMS = DEGREE * (DEGREE + 1) // 2  # monomials of Q, whose degree is lower by 1


def star(n: int, m: int, is_open: bool, creases: dict[int, int] | None = None) -> Mesh:
    """m x m faces of each of n sectors round vertex 0, at the places of the natural net, z = 0.

    Open: a half turn. `creases`: sectors along whose first edges the star is infinitely sharp, and how many edges long.
    Face (i, j) of sector s is number (s m + j) m + i, and its corner 0 is at (i, j).
    """
    index: dict[tuple[int, int, int], int] = {(0, 0, 0): 0}
    points = [np.zeros(3)]
    sector_angle = (1 if is_open else 2) * np.pi / n

    def vertex(s: int, x: int, y: int) -> int:
        if x == 0:
            s, x, y = (s + 1, y, 0) if y else (0, 0, 0)
        key = (s if is_open or x == 0 else s % n, x, y)
        if key not in index:
            index[key] = len(points)
            angle = sector_angle * (key[0] + np.arctan2(y, x) * 2 / np.pi)
            radius = np.hypot(x, y)
            if not is_open and n == 2:
                radius, angle = x + y, sector_angle * (key[0] + y / (x + y))
            flat = np.array([radius * np.cos(angle), radius * np.sin(angle), 0])
            points.append(np.array([x - y, x * y, 0.0]) if is_open and n == 1 and key[0] == 0 else
                          np.array([-x, 0.0, 0.0]) if is_open and n == 1 else flat)
        return index[key]

    faces = [[vertex(s, i, j), vertex(s, i + 1, j), vertex(s, i + 1, j + 1), vertex(s, i, j + 1)]
             for s in range(n) for j in range(m) for i in range(m)]
    sharp = {(vertex(s, i, 0), vertex(s, i + 1, 0)): SHARP for s, k in (creases or {}).items() for i in range(k)}
    return mesh_from_faces(points, faces, sharp)


def fans(mesh: Mesh, vertex: int) -> list[tuple[bool, list[tuple[int, int]]]]:
    """Fans at a vertex: whether open, and (face, corner) of each sector, counter-clockwise from a sharp edge on."""
    topo = topology(mesh)
    corners = np.flatnonzero(mesh.flat == vertex)
    is_sharp = topo.sharpness >= SHARP
    n_sharp = int(is_sharp[(topo.ends == vertex).any(axis=1)].sum())
    starts = [h for h in corners if is_sharp[topo.edge[h]]] if n_sharp else [corners[0]]
    out = []
    for first in starts:
        fan, h = [], first
        while True:
            fan.append((int(topo.face[h]), int(h - topo.start[topo.face[h]])))
            h = topo.twin[topo.prv[h]]
            if h < 0 or is_sharp[topo.edge[h]] or h == first:
                break
        out.append((n_sharp > 1, fan))
    return out


def cusp(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Taylor coefficients [n, 10] of (x^2 + y^2)^(3/2), by the binomial series."""
    s = multiply(x, x) + multiply(y, y)
    e = s / s[:, :1]
    e[:, 0] = 0
    ee = multiply(e, e)
    series = 1.5 * e + 0.375 * ee - 0.0625 * multiply(ee, e)
    series[:, 0] = 1
    return s[:, :1] ** 1.5 * series


class CutBlend:
    """One fan at a vertex of a mesh: the faces of its sectors are blended."""

    def __init__(self, mesh: Mesh, vertex: int, fan: int = 0):
        self.mesh = mesh
        self.is_open, self.cells = fans(mesh, vertex)[fan]
        n = len(self.cells)
        has_dart = not self.is_open and bool(len(mesh.creases))
        self.net = star(n, 2, self.is_open, {0: 2} if has_dart else None)
        st, weights = fit_samples(0, 0)
        self.curve = self.find_curve(vertex) if self.is_open else np.zeros((5, 3))
        rows, right = [], []
        for sector in range(n):
            functions, curve = self.functions(sector, st)
            root = np.sqrt(weights * (self.blend(st)[:, 0] + FAR_WEIGHT))[:, None]
            rows.append(root * functions[:, 0])
            right.append(root * (sector_taylor(mesh, *self.cells[sector], st, "deep")[:, 0] - curve[:, 0]))
        self.fit = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]

    def find_curve(self, vertex: int) -> np.ndarray:
        """Coefficients [5, 3] of 1, x, x^2, x^3 and the cusp, from the segments of the sharp curve either side."""
        topo, flat = topology(self.mesh), self.mesh.flat
        ends = topo.ends[topo.sharpness >= SHARP]
        (face, corner), (last, last_corner) = self.cells[0], self.cells[-1]
        near = [flat[topo.start[face] + (corner + 1) % 4], flat[topo.start[last] + (last_corner + 3) % 4]]
        far = []
        for at in near:
            beside = set(ends[(ends == at).any(axis=1)].ravel().tolist()) - {int(at), vertex}
            assert len(beside) == 1, "the next vertex of the curve is a corner"
            far.append(beside.pop())
        points = self.mesh.xyz[[far[1], near[1], vertex, near[0], far[0]]]
        right = bspline_rows(np.zeros(1))[0] @ points[1:]
        left = bspline_rows(np.ones(1))[0] @ points[:4]
        return np.stack([right[0], right[1], right[2] / 2, (right[3] + left[3]) / 12, (right[3] - left[3]) / 12])

    def chi(self, sector: int, st: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Taylor coefficients [n, 10] of the map's coordinates."""
        at = sector_taylor(self.net, 4 * sector, 0, st, "deep")
        return at[..., 0], at[..., 1]

    def functions(self, sector: int, st: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Taylor coefficients of the functions that are fitted [n, 10, terms], and of the curve [n, 10, 3]."""
        x, y = self.chi(sector, st)
        all_terms = monomials(x, y)
        if not self.is_open:
            return all_terms, np.zeros(x.shape + (3,))
        fitted = np.stack([multiply(y, all_terms[..., k]) for k in range(CURVE_TERMS)], axis=-1)
        along = np.concatenate([all_terms[..., [0, 1, 3, 6]], cusp(x, y)[..., None]], axis=-1)
        return fitted, along @ self.curve

    def blend(self, st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10] of the weight."""
        along = weight(st[:, 0]), weight(st[:, 1])
        return np.stack([along[0][:, p] * along[1][:, q] for p, q in JET_ORDERS], axis=1)

    def taylor(self, sector: int, st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10, 3] of the blended surface."""
        surface = sector_taylor(self.mesh, *self.cells[sector], st, "deep")
        functions, curve = self.functions(sector, st)
        gap, blend = functions @ self.fit + curve - surface, self.blend(st)
        return surface + np.stack([multiply(blend, gap[..., a]) for a in range(3)], axis=-1)


def ring_jacobians(n: int, is_open: bool, has_dart: bool, rings: list[int]) -> list[float]:
    """Least Jacobian of the natural net's map over the mean one, ring by ring."""
    net, (st, _) = star(n, 2, is_open, {0: 2} if has_dart else None), fit_samples(1, 0)
    out = []
    for ring in rings:
        at = np.concatenate([2.0 ** -ring * (st + place) for place in ((1, 0), (1, 1), (0, 1))])
        taylor = np.concatenate([sector_taylor(net, 4 * s, 0, at, "deep") for s in range(n)])
        jacobian = taylor[:, 1, 0] * taylor[:, 2, 1] - taylor[:, 1, 1] * taylor[:, 2, 0]
        out.append(float(jacobian.min() / jacobian.mean()))
    return out


def main() -> None:
    """Prints the Jacobians that notes/16-blends-at-boundaries.md shows."""
    rings = [1, 2, 3, 6, 9, 12]
    for label, *kind in (("boundary 1", 1, True, False), ("boundary 3", 3, True, False), ("boundary 4", 4, True, False),
                         ("boundary 6", 6, True, False), ("boundary 16", 16, True, False), ("dart 3", 3, False, True),
                         ("dart 5", 5, False, True), ("closed 2", 2, False, False)):
        print(f"| {label} |", " | ".join(f"{x:.3g}" for x in ring_jacobians(*kind, rings)), "|")


if __name__ == "__main__":
    main()

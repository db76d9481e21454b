# SPDX-License-Identifier: GPL-3.0-or-later
"""The `polynomial` surface over m x m faces of each sector at a pole on a boundary or crease, a second time.

Limit surface and map are refined deeply (ccref); nothing comes from the library. What the two have in common is the
definition: the natural net, subdivided some steps ago; the curve's polynomial, fitted before the rest; samples and weights;
and what is added along the curve, so that it stays as it is.
"""
from __future__ import annotations

import numpy as np

from ccref import Mesh, bspline_rows
from cut_ref import CURVE_TERMS, cusp, fans, star
from wide_ref import (DEGREE, FAR_WEIGHT, FIT_GAUSS, JET_ORDERS, PLACE, fit_samples, monomials, multiply, sector_taylor,
                      weight)

ALONG_U = [PLACE[p, 0] for p in range(4)]
ALONG_V = [PLACE[0, p] for p in range(4)]
POWERS = [0, 1, 3, 6, 10, 15]  # numbers of 1, x, .. x^5 among the monomials


def grid(mesh: Mesh, first: tuple[int, int], size: int) -> list[list[tuple[int, int]]]:
    """Faces [j][i] of a sector with their corners at places (i, j), from the (face, corner) at the vertex."""
    quads = mesh.flat.reshape(-1, 4)
    side = {(quad[k], quad[(k + 1) % 4]): (f, k) for f, quad in enumerate(quads) for k in range(4)}

    def right(face: int, corner: int) -> tuple[int, int]:
        twin, at = side[quads[face][(corner + 2) % 4], quads[face][(corner + 1) % 4]]
        return twin, (at + 1) % 4

    def up(face: int, corner: int) -> tuple[int, int]:
        return side[quads[face][(corner + 3) % 4], quads[face][(corner + 2) % 4]]

    rows = []
    for _ in range(size):
        row = [first]
        while len(row) < size:
            row.append(right(*row[-1]))
        rows.append(row)
        if len(rows) < size:
            first = up(*first)
    return rows


def along(values: np.ndarray, places: list[int]) -> np.ndarray:
    """Taylor coefficients [n, 10] of a function of one parameter from its own [n, 4]."""
    out = np.zeros((len(values), 10))
    out[:, places] = values
    return out


class WideCutBlend:
    """One fan at a vertex of a mesh; `steps` subdivisions ago its net was like the natural one."""

    def __init__(self, mesh: Mesh, vertex: int, m: int, steps: int = 0, fan: int = 0):
        self.mesh, self.m, self.steps = mesh, m, steps
        is_open, cells = fans(mesh, vertex)[fan]
        assert is_open
        self.n = len(cells)
        self.grids = [grid(mesh, first, m + 1) for first in cells]
        self.net_size = m // 2 ** steps + 3
        self.net = star(self.n, self.net_size, True)
        self.points = self.find_points()
        self.p, self.j = self.fit_curve()
        rows, right = [], []
        for cell in self.cells():
            st, weights = fit_samples(*cell[1:])
            fitted, curve = self.functions(cell, st)
            root = np.sqrt(weights * (self.blend(cell, st)[:, 0] + FAR_WEIGHT))[:, None]
            rows.append(root * fitted[:, 0])
            right.append(root * (self.limit(cell, st)[:, 0] - curve[:, 0]))
        self.fit = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]

    def cells(self) -> list[tuple[int, int, int]]:
        """Sector and place (i, j) of each face."""
        return [(s, i, j) for s in range(self.n) for j in range(self.m) for i in range(self.m)]

    def face(self, cell: tuple[int, int, int]) -> tuple[int, int]:
        return self.grids[cell[0]][cell[2]][cell[1]]

    def limit(self, cell: tuple[int, int, int], st: np.ndarray) -> np.ndarray:
        return sector_taylor(self.mesh, *self.face(cell), st, "deep")

    def find_points(self) -> np.ndarray:
        """The curve's points [2 m + 3, 3], from x = -(m + 1) on."""
        quads = self.mesh.flat.reshape(-1, 4)
        ahead = [quads[f][(c + 1) % 4] for f, c in self.grids[0][0]]
        back = [quads[f][(c + 3) % 4] for f, c in (row[0] for row in self.grids[-1])]
        face, corner = self.grids[0][0][0]
        return self.mesh.xyz[back[::-1] + [quads[face][corner]] + ahead]

    def curve(self, x: np.ndarray, segment: int) -> np.ndarray:
        """Taylor coefficients [n, 4, 3] of c at x of a segment from `segment` to the next whole number."""
        first = segment + self.m
        derivatives = bspline_rows(x - segment) @ self.points[first:first + 4]
        return derivatives / np.array([1, 1, 2, 6])[:, None]

    def fit_curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of p, and of the cusp."""
        node, gauss = np.polynomial.legendre.leggauss(FIT_GAUSS)
        rows, right = [], []
        for segment in range(-self.m, self.m):
            x = segment + (node + 1) / 2
            root = np.sqrt(gauss / 2 * (weight(abs(x) / self.m)[:, 0] + FAR_WEIGHT))[:, None]
            y = x / self.m
            rows.append(root * np.stack([y ** k for k in range(DEGREE + 1)] + [abs(y) ** 3], axis=1))
            right.append(root * self.curve(x, segment)[:, 0])
        found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]
        return found[:-1], found[-1]

    def chi(self, cell: tuple[int, int, int], st: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Taylor coefficients [n, 10] of the map, whose x is u / m along the curve."""
        s, scale = cell[0], 2 ** self.steps
        coarse = cell[1] // scale, cell[2] // scale
        at = (st + cell[1:]) / scale - coarse
        taylor = sector_taylor(self.net, (s * self.net_size + coarse[1]) * self.net_size + coarse[0], 0, at, "deep")
        taylor = taylor * (scale / self.m / np.array([float(scale) ** (p + q) for p, q in JET_ORDERS]))[:, None]
        return taylor[..., 0], taylor[..., 1]

    def functions(self, cell: tuple[int, int, int], st: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Taylor coefficients of y Q's functions [n, 10, terms], and of p(x) + j r^3 [n, 10, 3]."""
        x, y = self.chi(cell, st)
        terms = monomials(x, y)
        fitted = np.stack([multiply(y, terms[..., k]) for k in range(CURVE_TERMS)], axis=-1)
        return fitted, terms[..., POWERS] @ self.p + cusp(x, y)[..., None] * self.j

    def blend(self, cell: tuple[int, int, int], st: np.ndarray, m: int | None = None) -> np.ndarray:
        """Taylor coefficients [n, 10] of w(u / m) w(v / m)."""
        m = m or self.m
        u, v = weight((cell[1] + st[:, 0]) / m), weight((cell[2] + st[:, 1]) / m)
        return np.stack([u[:, p] * v[:, q] / m ** (p + q) for p, q in JET_ORDERS], axis=1)

    def missing(self, cell: tuple[int, int, int], st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10, 3] of E."""
        s, i, j = cell
        out = np.zeros((len(st), 10, 3))
        if i == j == 0:
            x, y = self.chi(cell, st)
            right, left = self.curve(np.zeros(1), 0)[0], self.curve(np.zeros(1), -1)[0]
            q = [right[0], right[1], right[2], (right[3] + left[3]) / 2]
            gap = monomials(x, y)[..., POWERS[:4]] @ np.array([self.m ** k * q[k] for k in range(4)])
            gap += cusp(x, y)[..., None] * self.m ** 3 * (right[3] - left[3]) / 2
            gap -= self.functions(cell, st)[1]
            narrow = self.blend(cell, st, 1)
            out += np.stack([multiply(narrow, gap[..., a]) for a in range(3)], axis=-1)
        for is_first, places, here, across in ((True, ALONG_U, i, 0), (False, ALONG_V, j, 1)):
            if s != (0 if is_first else self.n - 1) or (j if is_first else i) > 0:
                continue
            t, other = st[:, across], st[:, 1 - across]
            sign = 1 if is_first else -1
            x = sign * (here + t)
            c = self.curve(x, here if is_first else -here - 1)
            y = x / self.m
            p = np.stack([np.polyval(np.polyder(np.poly1d(self.p[::-1, a]), k).c if k else self.p[::-1, a], y)
                          / (1, 1, 2, 6)[k] for a in range(3) for k in range(4)], axis=-1).reshape(-1, 3, 4)
            cube = np.stack([abs(y) ** 3, 3 * y * abs(y), 3 * abs(y), np.sign(y)], axis=1)
            p = p.transpose(0, 2, 1) + cube[..., None] * self.j
            gap = c - p / np.array([self.m ** k for k in range(4)])[:, None]
            gap = gap * np.array([sign ** k for k in range(4)])[:, None]
            ramp = np.eye(1, 4) - weight(t) if here == 0 else np.eye(1, 4) + 0 * weight(t)
            part = multiply(along(ramp, places), along(weight(other), ALONG_V if is_first else ALONG_U))
            out += np.stack([multiply(part, along(gap[..., a], places)) for a in range(3)], axis=-1)
        return out

    def taylor(self, cell: tuple[int, int, int], st: np.ndarray) -> np.ndarray:
        """Taylor coefficients [n, 10, 3] of the blended surface."""
        surface = self.limit(cell, st)
        fitted, curve = self.functions(cell, st)
        gap, blend = fitted @ self.fit + curve + self.missing(cell, st) - surface, self.blend(cell, st)
        return surface + np.stack([multiply(blend, gap[..., a]) for a in range(3)], axis=-1)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What `polynomial` leaves of its error at extraordinary vertices by the width of its blend there.

On fitted nets of 6 n^2 faces, of surfaces whose eight extraordinary vertices are alike (sphere, ellipsoids, star_P2): the
error of the variation for several widths m, whatever the library's own is, by the second implementation of the tests
(wide_ref.py). `python3 wide_blend.py [SURFACE [N [M...]]]`; CURVOPT_BUILD as in orders.py.
"""
from __future__ import annotations

import sys

import numpy as np

from orders import exact, lib, sphere_like, subdivided_cube, variation_density
from ccref import topology
from wide_ref import FACTORIALS, WideBlend, gauss_points, sector_taylor

GAUSS, LARGEST, DISTANCE_PER_WIDTH = 14, 8, 4  # the last two: the library's rule for m


def variation(name: str, n: int, m: int, rings: int) -> list[float]:
    """8 times the integral of |grad h|^2, ring by ring, with the blend over m x m faces of each sector."""
    grid, mesh = subdivided_cube(n), sphere_like(n, name, subdivided_cube)
    vertex = int(np.flatnonzero(np.bincount(topology(grid).ends.ravel()) == 3)[0])
    blend, everything = WideBlend(grid, mesh, vertex, m), WideBlend(grid, mesh, vertex, rings)
    st, weights = gauss_points(GAUSS)
    sums = np.zeros(rings)
    for cell in everything.cells:
        ring = max(cell[2:])
        taylor = blend.taylor(cell, st) if ring < m else sector_taylor(mesh, *cell[:2], st)
        sums[ring] += weights @ variation_density(taylor * FACTORIALS[:, None])[0]
    return list(8 * sums)


def main() -> None:
    """Command line."""
    words = sys.argv[1:]
    name = words[0] if words else "sphere"
    n, *widths = [int(word) for word in words[1:]] or [32]
    widths = widths or [1, 2, 3, 4, 6, 8]
    own = max(1, min(LARGEST, n // DISTANCE_PER_WIDTH))
    mesh = sphere_like(n, name, subdivided_cube)
    whole = lib.evaluate(mesh, "variation", "polynomial", tolerance=1e-6)
    error, first = whole.value("variation") - exact(name)["gradh2A"], variation(name, n, own, max(*widths, own))
    for m in widths:
        found = variation(name, n, m, max(*widths, own))
        print(f"m = {m}: error {error + whole.area * (sum(found) - sum(first)):.2f}; change by ring",
              ", ".join(f"{whole.area * (b - a):.2f}" for a, b in zip(first, found)), flush=True)


if __name__ == "__main__":
    main()

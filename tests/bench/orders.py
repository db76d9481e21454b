# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and orders of the energies on nets with extraordinary vertices, `polynomial` beside `plane`.

Cube-like nets of 6 n^2 faces, fitted to the sphere, the ellipsoids and the star-shaped surfaces of refvals.json.
`python3 orders.py [SIZE...]` (8 16 32; powers of two) prints the table that README.md shows, `--grids` what the choice
of grid does, `--rings` where on a sphere the error sits. CURVOPT_BUILD names the folder with the library.
"""
from __future__ import annotations

import argparse
import json
import sys
from math import log2, nan, pi
from pathlib import Path
from typing import Callable

import numpy as np

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "oracle"), str(TESTS / "numeric")]

import lib  # noqa: E402
from ccref import Mesh, mesh_from_faces, refine, topology  # noqa: E402
from nets import CUBE, cube_grid, limit_mask, sphere_like, subdivided_cube  # noqa: E402

SPHERE = {"A": 4 * pi, "W": 8 * pi, "MVS": 0.0, "MVScross": 0.0, "gradh2A": 0.0}
NAMES = {"willmore": "W", "mvs": "MVS", "mvs_cross": "MVScross", "variation": "gradh2A"}
SURFACES = ("ellipsoid_1_1_2", "ellipsoid_1_1_0.5", "ellipsoid_1_2_3", "star_P2", "star_xyz")


def exact(name: str) -> dict[str, float]:
    """Energies of a surface by refvals.json's keys."""
    if name == "sphere":
        return SPHERE
    refs = json.loads((TESTS / "oracle" / "refvals.json").read_text(encoding="utf-8"))
    found = refs["ellipsoids"].get(name) or refs["surfaces"][name]
    return {key: float(found[key]) for key in SPHERE}


def errors(name: str, n: int, kind: str, grid: Callable[[int], Mesh] = subdivided_cube) -> dict[str, float]:
    """Computed minus exact on a surface kind, by term; the third order only where the kind has it."""
    mesh, refs = sphere_like(n, name, grid), exact(name)
    got = {"willmore": lib.evaluate(mesh, "willmore", kind, tolerance=1e-9)}
    if kind != "limit":
        third = lib.evaluate(mesh, "mvs", kind, tolerance=1e-6 if kind == "polynomial" else 1e-5)
        got |= {term: third for term in ("mvs", "mvs_cross", "variation")}
    return {term: energies.value(term) - refs[NAMES[term]] for term, energies in got.items()}


def order(coarse: float, fine: float) -> float:
    """Observed order of a halving; nan where the two have opposite signs or nothing is left."""
    return log2(coarse / fine) if coarse and fine and coarse / fine > 0 else nan


# --------------------------------------------------------------------------------------------------- tables --

def print_table(sizes: list[int]) -> None:
    """Relative errors at the last two sizes, and their order."""
    coarse, fine = sizes[-2:]
    heads = [f"6·{coarse}²", f"6·{fine}²", "order"]
    print("| surface | energy | exact |", " | ".join(["`polynomial` " + heads[0], *heads[1:],
                                                       "`plane` " + heads[0], *heads[1:]]), "|")
    print("| --- " * 9 + "|")
    for name in SURFACES:
        found = {kind: [errors(name, n, kind) for n in (coarse, fine)] for kind in ("polynomial", "plane")}
        for term, key in NAMES.items():
            value = exact(name)[key]
            cells = []
            for series in found.values():
                a, b = (e[term] for e in series)
                cells += [f"{a / value:.2g}", f"{b / value:.2g}", f"{order(a, b):.2f}"]
            print(f"| {name} | {term} | {value:.6g} |", " | ".join(cells), "|", flush=True)
    print()
    print("W on `limit`, relative:")
    for name in SURFACES:
        series = [errors(name, n, "limit")["willmore"] / exact(name)["W"] for n in sizes]
        print(f"  {name}:", ", ".join(f"{e:.2g}" for e in series), "orders",
              ", ".join(f"{order(a, b):.2f}" for a, b in zip(series, series[1:])), flush=True)
    print()
    print("Third order on `polynomial` at all sizes, MVS and variation:")
    for name in ("sphere", *SURFACES):
        found = [errors(name, n, "polynomial") for n in sizes]
        for term in ("mvs", "variation"):
            series = [e[term] for e in found]
            print(f"  {name} {term}:", ", ".join(f"{e:.3g}" for e in series), "orders",
                  ", ".join(f"{order(a, b):.2f}" for a, b in zip(series, series[1:])), flush=True)


def print_grids(sizes: list[int]) -> None:
    """What each grid makes of a sphere and of an ellipsoid."""
    grids = {"equal angles": cube_grid, "conformal": conformal_cube, "limit points, once": limit_cube,
             "projected every step": subdivided_cube}
    print("| grid | surface |", " | ".join(f"6·{n}²" for n in sizes), "|")
    print("| --- " * (2 + len(sizes)) + "|")
    for label, grid in grids.items():
        for name in ("sphere", "ellipsoid_1_1_2"):
            series = [errors(name, n, "polynomial", grid)["mvs"] for n in sizes]
            print(f"| {label} | {name} |", " | ".join(f"{e:.4g}" for e in series), "|", flush=True)


def print_rings(sizes: list[int]) -> None:
    """MVS and variation of the fitted sphere by the faces' distance from the extraordinary vertices."""
    for n in sizes:
        mesh = sphere_like(n, "sphere", subdivided_cube)
        distance = face_distance(mesh)
        found = face_variation(mesh, "polynomial")
        parts = [found[distance == k].sum() for k in range(1, 4)] + [found[distance > 3].sum()]
        print(f"6·{n}²: |∇h|² {sum(parts):.2f}; rings 1, 2, 3 and the rest:", ", ".join(f"{p:.2f}" for p in parts),
              flush=True)


# ---------------------------------------------------------------------------------------------- other grids --

def limit_cube(n: int) -> Mesh:
    """Unit sphere as the limit points of a subdivided cube, put on the sphere at the end alone."""
    mesh = mesh_from_faces(*CUBE)
    while mesh.n_faces < 6 * n * n:
        mesh = refine(mesh)
    apply, _ = limit_mask(mesh)
    points = apply(mesh.xyz)
    return mesh.with_xyz(points / np.linalg.norm(points, axis=1)[:, None])


def conformal_cube(n: int) -> Mesh:
    """Unit sphere as a conformal cube of 6 n^2 quads (Rancic, Purser and Mesinger 1996), here in closed form.

    In stereographic coordinates z about a face's centre the cube's corners are the roots of z^8 + 14 z^4 + 1, and the
    flat metric of the cube's surface is |z^8 + 14 z^4 + 1|^(-1/4) |dz|.
    """
    flat = cube_grid(n).xyz
    axis = abs(flat).argmax(axis=1)
    row = np.arange(len(flat))
    sign = np.sign(flat[row, axis])
    sides = [flat[row, (axis + k) % 3] / abs(flat[row, axis]) for k in (1, 2)]
    x, y = (np.arctan(side) * 4 / pi for side in sides)  # the uniform grid [-1, 1]^2 behind equal angles
    z = _conformal(x + 1j * y)
    xyz = np.empty_like(flat)
    for k, part in ((0, sign * (1 - abs(z) ** 2)), (1, 2 * z.real), (2, 2 * z.imag)):
        xyz[row, (axis + k) % 3] = part / (1 + abs(z) ** 2)
    return cube_grid(n).with_xyz(xyz)


def _conformal(square: np.ndarray) -> np.ndarray:
    """Square [-1, 1]^2 to the stereographic cube face, by Newton on the integral of dz (z^8 + 14 z^4 + 1)^(-1/4)."""
    corner = (7 - 4 * np.sqrt(3)) ** 0.25
    roots = np.array([-corner, 1j * corner, -1j * corner, 1 / corner, -1 / corner, 1j / corner, -1j / corner])
    node, gauss = np.polynomial.legendre.leggauss(60)
    tau, gauss = (node + 1) / 2, gauss / 2

    def others(z: np.ndarray) -> np.ndarray:  # the integrand without the factor of the corner at hand
        return np.prod((1 - z[..., None] / roots) ** -0.25, axis=-1)

    def to_corner(z: np.ndarray) -> np.ndarray:
        between = corner - tau ** 4 * (corner - z[..., None])
        return corner ** 0.25 * (corner - z) ** 0.75 * (4 * tau ** 2 * others(between) * gauss).sum(axis=-1)

    half = to_corner(np.zeros(1, complex))[0].real
    w = square * np.exp(-0.25j * pi) / np.sqrt(2) * half
    turn = np.exp(0.5j * pi * np.where(abs(w) < 1e-12, 0, np.round(np.angle(w) / (pi / 2))))
    goal = half - w / turn
    s = goal * corner ** 0.75 / half  # (corner - z)^(3/4), in which the map is nearly linear
    for _ in range(30):
        z = corner - s ** (4 / 3)
        s = s - (to_corner(z) - goal) / (4 / 3 * corner ** 0.25 * others(z))
        s = np.where(s.real < 0, 0, s)
    return (corner - s ** (4 / 3)) * turn * np.exp(0.25j * pi)


# ------------------------------------------------------------------------------------------- shares by ring --

def face_distance(mesh: Mesh) -> np.ndarray:
    """1 for faces at an extraordinary vertex, 2 for those around them, and so on."""
    quads = mesh.flat.reshape(-1, 4)
    valence = np.bincount(topology(mesh).ends.ravel(), minlength=mesh.n_vertices)
    distance = np.where(valence == 4, mesh.n_faces, 0)
    for _ in range(mesh.n_faces):
        before = distance.copy()
        np.minimum.at(distance, quads.ravel(), np.repeat(before[quads].min(axis=1) + 1, 4))
        if (distance == before).all():
            break
    return distance[quads].min(axis=1) + 1


def face_variation(mesh: Mesh, kind: str, n_gauss: int = 14) -> np.ndarray:
    """A times the integral of |grad h|^2 over each face, from the library's jets."""
    node, gauss = np.polynomial.legendre.leggauss(n_gauss)
    u, v = (a.ravel() for a in np.meshgrid((node + 1) / 2, (node + 1) / 2, indexing="ij"))
    weight = np.outer(gauss, gauss).ravel() / 4
    sums = []
    for face in range(mesh.n_faces):
        jets = lib.jets(mesh, np.full(len(u), face), np.zeros(len(u)), np.c_[u, v], kind)
        sums.append([weight @ part for part in variation_density(jets)])
    variation, area = np.array(sums).T
    return area.sum() * variation


def variation_density(jets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """|grad h|^2 dA and dA at jets [n, 10, 3]."""
    d1 = jets[:, 1:3]
    d2 = jets[:, [[3, 4], [4, 5]]]
    d3 = jets[:, [[[6, 7], [7, 8]], [[7, 8], [8, 9]]]]
    cross = np.cross(d1[:, 0], d1[:, 1])
    area = np.linalg.norm(cross, axis=1)
    normal = cross / area[:, None]
    inverse = np.linalg.inv(np.einsum("mia,mja->mij", d1, d1))
    h = np.einsum("mija,ma->mij", d2, normal)
    gamma = np.einsum("mija,mla,mlk->mijk", d2, d1, inverse)
    slope = np.einsum("mijka,ma->mijk", d3, normal)
    for term in ("mkl,mijl->mijk", "mjl,mikl->mijk", "mil,mjkl->mijk"):
        slope -= np.einsum(term, h, gamma)
    return area * np.einsum("mijk,mabc,mia,mjb,mkc->m", slope, slope, inverse, inverse, inverse), area


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sizes", type=int, nargs="*", default=[8, 16, 32])
    parser.add_argument("--grids", action="store_true")
    parser.add_argument("--rings", action="store_true")
    given = parser.parse_args()
    if given.grids:
        print_grids(given.sizes)
    elif given.rings:
        print_rings(given.sizes)
    else:
        print_table(given.sizes)


if __name__ == "__main__":
    main()

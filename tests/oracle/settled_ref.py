# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of closed cages by squares that are cut in four until they stand still: `limit` and `polynomial` (blends of one
face), to as many digits as wanted.

Written from the definitions, by numpy alone. Round an extraordinary vertex the surface is made of bicubic cells in rings, by
powers of the subdivision matrix, which comes from refining a disc; the characteristic map is made of the same cells. A
square is one of a cell's parameters, so that cutting it changes no surface. `polynomial` blends (polynomial.h, patches.h)
over the faces round an extraordinary vertex of the first of the meshes, each refined from the one before, where these are
quads and all their other vertices regular. MVS is the regularized one of functional.h.
"""
from __future__ import annotations

from functools import lru_cache
from typing import Callable, NamedTuple

import numpy as np

from ccref import Mesh, Topology, mesh_from_faces, patch_jets, patch_points, refine, topology
from energy_ref import gauss_rule, monge_route, second_order
from wide_ref import FACTORIALS, FAR_WEIGHT, FIT_RINGS, gauss_points, monomials, multiply, weight

GAUSS = 4        # points a side of a square, whose change by a cut is that to 8
FIRST_CUTS = 2   # of a face at first, against folds between points; one less of the first ring's cells, none of others
CUTS_AT_MOST = 12
LEFT_OUT = 1e-7  # of a vertex's energy, in the rings inside the last one, which are estimated
UMBILIC = 2e-2   # of the definition of MVS, over the cage's root mean square radius
CHUNK = 200      # squares at once

THIRD = ("mvs", "mvs_cross", "variation", "mehlum_tarrou")
NAMES = {"limit": ("willmore", "mean_curvature", "surface area"),
         "polynomial": ("willmore", "mean_curvature", *THIRD, "surface area")}  # energies that are integrated together


class Disc(NamedTuple):
    """What discs of a valence have in common."""

    step: np.ndarray    # [n, n] points of the two-ring from those one level up
    cells: np.ndarray   # [3, sectors, 4, 4, n] control points of a ring's cells over them
    limit: np.ndarray   # [n] the vertex's limit position
    map: np.ndarray     # [n, 3] the characteristic map's control points, in the plane z = 0
    ratio: float        # of successive rings' energies on `limit`, at most


CELL_AT = ((1, 0), (1, 1), (0, 1))


def place_number(valence: int, sector: int, x: int, y: int) -> int:
    """Two-ring number of place (x, y) of a sector, -1 <= x, y <= 2."""
    if y < 0:
        return place_number(valence, sector - 1, -y, x)
    if x < 0:
        return place_number(valence, sector + 1, y, -x)
    if x == 0:
        return place_number(valence, sector + 1, y, 0) if y else 0
    return 1 + 6 * (sector % valence) + 2 * y + x - 1


@lru_cache(maxsize=None)
def disc(valence: int) -> Disc:
    """By refining unit vectors."""
    n = 6 * valence + 1
    faces = [[place_number(valence, s, i + a, j + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
             for s in range(valence) for j in range(2) for i in range(2)]
    fine = refine(mesh_from_faces(np.zeros((n, 3)), faces).with_xyz(np.eye(n)))
    quads, at = fine.flat.reshape(-1, 4), {}
    for s in range(valence):
        for j in range(2):
            for i in range(2):
                for k, (a, b) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
                    quad = quads[4 * (4 * s + 2 * j + i) + k]
                    for corner, (p, q) in zip(quad, ((0, 0), (1, 0), (1, 1), (0, 1))):
                        at[s, 2 * i + a + p, 2 * j + b + q] = corner

    def fine_at(s: int, x: int, y: int) -> int:
        if y < 0:
            return fine_at(s - 1, -y, x)
        return fine_at(s + 1, y, -x) if x < 0 else at[s % valence, x, y]

    order = np.zeros(n, int)
    for s in range(valence):
        for y in range(3):
            for x in range(3):
                order[place_number(valence, s, x, y)] = fine_at(s, x, y)
    cells = np.array([[[[fine.xyz[fine_at(s, a - 1 + i, b - 1 + j)] for j in range(4)] for i in range(4)]
                       for s in range(valence)] for a, b in CELL_AT])
    step = fine.xyz[order]
    values, vectors = np.linalg.eig(step)
    first, *rest = np.argsort(-abs(values))
    left_values, left = np.linalg.eig(step.T)
    limit = left[:, abs(left_values - 1).argmin()].real
    span = vectors[:, rest[:2]]
    span = np.linalg.svd(np.concatenate([span.real, span.imag], axis=1))[0][:, :2]
    size, next_size = abs(values[rest[0]]), abs(values[rest[2]])
    chart = np.pad(span / abs(span).max(), ((0, 0), (0, 1)))
    return Disc(step, cells, limit / limit.sum(), chart, max(size ** 2, (next_size / size) ** 2))


class Cells(NamedTuple):
    """Bicubic pieces of the surface, and what is blended into them."""

    points: np.ndarray  # [n, 4, 4, 3]
    chart: np.ndarray   # [n, 4, 4, 3] of the characteristic map; 0 where nothing is blended
    origin: np.ndarray  # [n, 2] in the face, from the extraordinary vertex on
    side: np.ndarray    # [n] of 1
    fit: np.ndarray     # [n] which polynomial; -1: none
    cuts: np.ndarray    # [n] at first
    factor: np.ndarray  # [n] 1; more in the last ring, which stands for those inside
    area_factor: np.ndarray  # [n] the same, of the area


def corner_walk(topo: Topology, vertex: int, flat: np.ndarray) -> list[int]:
    """Half-edges that leave an inner vertex, in order."""
    first = here = int(np.flatnonzero(flat == vertex)[0])
    out = []
    while not out or here != first:
        out.append(here)
        here = int(topo.twin[topo.prv[here]])
    return out


def two_ring(mesh: Mesh, topo: Topology, corners: list[int]) -> np.ndarray:
    """Vertices of the two-ring in the disc's order."""
    n, out = len(corners), np.zeros(6 * len(corners) + 1, int)
    out[0] = mesh.flat[corners[0]]
    for s, h in enumerate(corners):
        one = topo.nxt[h]
        beyond = topo.twin[one]                                  # (1, 1) -> (1, 0), in the face beyond
        far = topo.twin[topo.prv[beyond]]                        # (1, 1) -> (2, 1), in the face across the corner
        for (x, y), corner in {(1, 0): one, (1, 1): topo.nxt[one], (2, 0): topo.nxt[topo.nxt[beyond]],
                               (2, 1): topo.prv[beyond], (2, 2): topo.nxt[topo.nxt[far]],
                               (1, 2): topo.prv[far]}.items():
            out[place_number(n, s, x, y)] = mesh.flat[corner]
    return out


def ring_cells(mesh: Mesh, topo: Topology, vertex: int, blended: bool, number: int) -> tuple[Cells, np.ndarray]:
    """The faces round an extraordinary vertex, and the polynomial's coefficients [21, 3] there."""
    corners = corner_walk(topo, vertex, mesh.flat)
    d = disc(len(corners))
    points = mesh.xyz[two_ring(mesh, topo, corners)]
    points, chart = points - d.limit @ points, d.map
    area_ratio = np.linalg.norm(d.step @ d.map) ** 2 / np.linalg.norm(d.map) ** 2
    ratio = area_ratio if blended else d.ratio
    n_rings, parts = int(np.ceil(np.log(LEFT_OUT) / np.log(ratio))), []
    for ring in range(1, n_rings + 1):
        for cell, at in zip(d.cells, CELL_AT):
            n = len(cell)
            parts.append(Cells(cell @ points, cell @ chart, np.tile(np.array(at) * 0.5 ** ring, (n, 1)),
                               np.full(n, 0.5 ** ring), np.full(n, number if blended else -1),
                               np.full(n, max(FIRST_CUTS - ring, 0)),
                               np.full(n, 1 / (1 - ratio) if ring == n_rings else 1.0),
                               np.full(n, 1 / (1 - area_ratio) if ring == n_rings else 1.0)))
        points, chart = d.step @ points, d.step @ chart
        points = points - d.limit @ points
    cells = Cells(*(np.concatenate(a) for a in zip(*parts)))
    return cells, fit(Cells(*(a[:3 * len(corners) * FIT_RINGS] for a in cells))) if blended else np.zeros((21, 3))


def fit(cells: Cells) -> np.ndarray:
    """Least squares over the first rings' cells, at 4 x 4 points of each."""
    st, weights = gauss_points(4)
    index = np.repeat(np.arange(len(cells.side)), len(st))
    s, t = np.tile(st, (len(cells.side), 1)).T
    along = [weight(cells.origin[index, c] + cells.side[index] * x)[:, 0] for c, x in enumerate((s, t))]
    root = np.sqrt(np.tile(weights, len(cells.side)) * cells.side[index] ** 2 * (along[0] * along[1] + FAR_WEIGHT))
    at = np.pad(patch_jets(cells.chart[index], s, t)[:, :1], ((0, 0), (0, 9), (0, 0)))
    rows = monomials(at[..., 0], at[..., 1])[:, 0]
    where = patch_jets(cells.points[index], s, t)[:, 0]
    return np.linalg.lstsq(root[:, None] * rows, root[:, None] * where, rcond=None)[0]


def all_cells(mesh: Mesh, blended: bool) -> tuple[Cells, np.ndarray]:
    """Every cell of a closed cage, and all polynomials [n, 21, 3]."""
    parts, fits, wanted = [], [], np.ones(mesh.n_faces, bool)
    while wanted.any():
        topo = topology(mesh)
        quads = np.bincount(mesh.flat, weights=(mesh.sizes != 4)[topo.face], minlength=mesh.n_vertices) == 0
        regular = quads & (np.bincount(mesh.flat, minlength=mesh.n_vertices) == 4)
        n_odd = np.bincount(topo.face, weights=~regular[mesh.flat], minlength=mesh.n_faces)
        single = (mesh.sizes == 4) & (n_odd == 1)
        good = quads & (np.bincount(mesh.flat, weights=~single[topo.face], minlength=mesh.n_vertices) == 0) & ~regular
        at_good = np.bincount(topo.face, weights=good[mesh.flat], minlength=mesh.n_faces) > 0
        plain = np.flatnonzero(wanted & (mesh.sizes == 4) & (n_odd == 0))
        if len(plain):
            n = len(plain)
            parts.append(Cells(patch_points(mesh, topo, plain), np.zeros((n, 4, 4, 3)), np.zeros((n, 2)), np.ones(n),
                               np.full(n, -1), np.full(n, FIRST_CUTS), np.ones(n), np.ones(n)))
        for vertex in np.unique(mesh.flat[(wanted & at_good)[topo.face] & good[mesh.flat]]):
            cells, coefficients = ring_cells(mesh, topo, int(vertex), blended, len(fits))
            parts.append(cells)
            fits.append(coefficients)
        left = wanted.copy()
        left[plain], left[at_good] = False, False
        wanted = np.repeat(left, mesh.sizes)
        mesh = refine(mesh)
    return Cells(*(np.concatenate(a) for a in zip(*parts))), np.array(fits).reshape(-1, 21, 3)


def jets(cells: Cells, fits: np.ndarray, index: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Jets [n, 10, 3] at (s, t) of cells, with respect to these."""
    out = patch_jets(cells.points[index], s, t)
    at = np.flatnonzero(cells.fit[index] >= 0)
    if len(at) == 0:
        return out
    k, orders = index[at], np.array([(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)])
    surface = out[at] / FACTORIALS[:, None]
    chart = patch_jets(cells.chart[k], s[at], t[at]) / FACTORIALS[:, None]
    along = [weight(cells.origin[k, c] + cells.side[k] * x[at]) * cells.side[k, None] ** np.arange(4)
             for c, x in enumerate((s, t))]
    blend = along[0][:, orders[:, 0]] * along[1][:, orders[:, 1]]
    gap = monomials(chart[..., 0], chart[..., 1]) @ fits[cells.fit[k]] - surface
    out[at] = (surface + np.stack([multiply(blend, gap[..., a]) for a in range(3)], axis=-1)) * FACTORIALS[:, None]
    return out


def densities(points: np.ndarray, surface: str, eps4: float) -> list[np.ndarray]:
    """Densities [n] of NAMES[surface] by area, the area's last. X of MVS is smooth at umbilics as its definition has it; the
    mean over all directions (MVS_cross) is a third of the variation's and two of MVS."""
    if surface == "limit":
        found = second_order(points)
        return [found["willmore"], found["h2"], found["area"]]
    z2, z3, area = monge_route(points)
    f1 = 0.75 * ((z3[:, 0] + z3[:, 2]) - 1j * (z3[:, 1] + z3[:, 3]))
    f3 = 0.25 * ((z3[:, 0] - 3 * z3[:, 2]) - 1j * (3 * z3[:, 1] - z3[:, 3]))
    q = (z2[:, 0] - z2[:, 2]) / 2 + 1j * z2[:, 1]
    square = abs(q) ** 2
    mvs = abs(f1) ** 2 + abs(f3) ** 2 + 2 * (f1 * f3 * q * q).real * square / (square * square + eps4)
    variation = z3 ** 2 @ [1, 3, 3, 1]
    directions = np.arange(4) * np.pi / 4  # exact for the square of a trigonometric polynomial of degree 3
    c, s = np.cos(directions), np.sin(directions)
    along = z3 @ np.stack([c ** 3, 3 * c * c * s, 3 * c * s * s, s ** 3])
    return [z2 ** 2 @ [1, 2, 1], (z2[:, 0] + z2[:, 2]) ** 2 / 4, mvs, (variation + 2 * mvs) / 3, variation,
            2 * (along ** 2).mean(axis=1), area]


def measure(cells: Cells, fits: np.ndarray, surface: str, eps4: float, squares: tuple) -> np.ndarray:
    """Integrals [n, energies] of NAMES[surface] over squares (cell, s, t, side)."""
    gs, gt, gw = gauss_square()
    out = []
    for begin in range(0, len(squares[0]), CHUNK):
        cell, s, t, side = (a[begin:begin + CHUNK, None] for a in squares)
        shape = (len(cell), len(gs))
        points = jets(cells, fits, np.broadcast_to(cell, shape).ravel(), (s + side * gs).ravel(), (t + side * gt).ravel())
        *found, area = (a.reshape(shape) for a in densities(points, surface, eps4))
        weights = side ** 2 * gw * area
        out.append(np.stack([(weights * cells.factor[cell] * a).sum(1) for a in found]
                            + [(weights * cells.area_factor[cell]).sum(1)], axis=1))
    return np.concatenate(out)


def gauss_square() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places and weights of a square's points, GAUSS a side."""
    x, w = gauss_rule(GAUSS)
    return tuple(np.ravel(a) for a in (*np.meshgrid(x, x, indexing="ij"), np.outer(w, w)))


def cut(squares: tuple) -> tuple:
    """Each in four, which follow one another."""
    cell, s, t, side = (np.repeat(a, 4) for a in squares)
    which = np.tile(np.arange(4), len(squares[0]))
    return cell, s + side / 2 * (which % 2), t + side / 2 * (which // 2), side / 2


def settle(measured: Callable[[tuple], np.ndarray], squares: tuple, drivers: list[int], digits: float,
           most: int) -> tuple[np.ndarray, np.ndarray]:
    """Integrals [n] over squares of what `measured` gives by square, and estimates of how far they are off.

    Squares are cut while that changes their share of a driver by more than `digits` of the whole, over the root of their
    number: a quarter of the last changes is taken for their errors, which add up by squares. It ends where more than
    `most` squares would be left in one step, whose last changes then add up as they are.
    """
    value = measured(squares)
    bound = digits * value.sum(0)[drivers] / np.sqrt(len(squares[0]))
    done, off, left = (np.zeros(value.shape[1]) for _ in range(3))
    for step in range(CUTS_AT_MOST):
        parts = cut(squares)
        finer = measured(parts)
        change = abs(finer.reshape(-1, 4, value.shape[1]).sum(1) - value)
        moving = (change[:, drivers] > bound).any(axis=1)
        off += (change[~moving] ** 2).sum(0) / 16
        if 4 * moving.sum() > most or step == CUTS_AT_MOST - 1:
            left, moving[:] = change[moving].sum(0), False
        keep = np.repeat(moving, 4)
        done += finer[~keep].sum(0)
        squares, value = tuple(a[keep] for a in parts), finer[keep]
        if not len(value):
            break
    return done, np.sqrt(off) + left


def settled_all(mesh: Mesh, surface: str, digits: float = 1e-6, most: int = 60_000,
                drivers: tuple[str, ...] = ()) -> dict[str, tuple[float, float]]:
    """NAMES[surface] of a closed cage on `limit`, or on `polynomial` with blends of one face, each with an estimate of how
    far it is off. Squares are cut (settle) until the drivers stand still; none: all of them."""
    names = NAMES[surface]
    cells, fits = all_cells(mesh, surface == "polynomial")
    eps4 = (UMBILIC / np.sqrt(((mesh.xyz - mesh.xyz.mean(0)) ** 2).sum(1).mean())) ** 4
    parts = []
    for cuts in range(FIRST_CUTS + 1):
        at = np.flatnonzero(cells.cuts == cuts)
        squares = at, np.zeros(len(at)), np.zeros(len(at)), np.ones(len(at))
        for _ in range(cuts):
            squares = cut(squares)
        parts.append(squares)
    value, off = settle(lambda squares: measure(cells, fits, surface, eps4, squares),
                        tuple(np.concatenate(a) for a in zip(*parts)), [names.index(d) for d in drivers or names], digits, most)
    off += 1e-2 * LEFT_OUT * abs(value)  # the rings that are estimated
    factor = np.array([value[-1] if name in THIRD else 1.0 for name in names])
    return {name: (float(v), float(e)) for name, v, e in zip(names, value * factor, off * factor)}


def settled(mesh: Mesh, energy: str, digits: float = 1e-6, most: int = 60_000) -> tuple[float, float]:
    """One energy, `willmore` on `limit` or `mvs` on `polynomial`, and an estimate of how far it is off."""
    surface = "limit" if energy == "willmore" else "polynomial"
    return settled_all(mesh, surface, digits, most, (energy,))[energy]

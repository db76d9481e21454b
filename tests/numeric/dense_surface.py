# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances and crossings of limit surfaces by dense sampling: points by OpenSubdiv or by repeated refinement, nearest
points by a k-d tree and Taylor's series, crossings by triangles. Shares no code with the library.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ccref import Mesh, refine
from osd import osd_jets


class Samples(NamedTuple):
    """Samples of a limit surface: points [n, 3], of which the first m are the middles of cells; jets [m, 6, 3] with u and v
    over one cell; area [n], 0 of points that are no middles; where each cell is on the mesh."""

    mesh: Mesh
    boundary: str
    points: np.ndarray
    jets: np.ndarray
    area: np.ndarray
    face: np.ndarray
    corner: np.ndarray
    uv: np.ndarray
    cells: np.ndarray


def sampled(mesh: Mesh, n: int, boundary: str = "all") -> Samples:
    """n x n cells of every quad, (n / 2) x (n / 2) of every quarter of another face; and points on edges, and vertices' limits."""
    face, corner, uv = [], [], []
    for f, size in enumerate(mesh.sizes):
        m = n if size == 4 else max(1, n // 2)
        at = (np.arange(m) + 0.5) / m
        grid = np.stack(np.meshgrid(at, at, indexing="ij"), axis=-1).reshape(-1, 2)
        for k in range(1 if size == 4 else size):
            face.append(np.full(m * m, f))
            corner.append(np.full(m * m, k))
            uv.append(grid)
    face, corner, uv = np.concatenate(face), np.concatenate(corner), np.concatenate(uv)
    cells = np.where(mesh.sizes[face] == 4, n, max(1, n // 2)).astype(float)
    found = osd_jets(mesh, face, corner, uv, boundary)
    jets = found.jets.copy()
    jets[:, 1:3] /= cells[:, None, None]
    jets[:, 3:] /= (cells ** 2)[:, None, None]
    area = np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1)
    rest = np.concatenate([found.limit[np.unique(mesh.flat)], _on_edges(mesh, n, boundary)])
    return Samples(mesh, boundary, np.concatenate([jets[:, 0], rest]), jets, np.r_[area, np.zeros(len(rest))], face,
                   corner, uv, cells)


def _on_edges(mesh: Mesh, n: int, boundary: str) -> np.ndarray:
    """Points [m, 3] on the sides of every quad, and of every quarter of another face."""
    at = (np.arange(n) + 0.5) / n
    sides = np.concatenate([np.stack([at, 0 * at], axis=1), np.stack([0 * at, at], axis=1),
                            np.stack([at, 0 * at + 1], axis=1), np.stack([0 * at + 1, at], axis=1)])
    place = [(f, k) for f, size in enumerate(mesh.sizes) for k in range(1 if size == 4 else size)]
    face, corner = np.repeat(np.array(place), len(sides), axis=0).T
    return osd_jets(mesh, face, corner, np.tile(sides, (len(place), 1)), boundary).jets[:, 0]


def _on_taylor(x: np.ndarray, jets: np.ndarray, low=-0.5, high=0.5) -> np.ndarray:
    """Distance [n] from points x [n, 3] to a cell by the series round its middle, (u, v) between low and high [n, 2]."""
    low, high = np.broadcast_to(low, (len(x), 2)).T, np.broadcast_to(high, (len(x), 2)).T
    s, su, sv, suu, suv, svv = (jets[:, k] for k in range(6))
    u = v = np.zeros(len(x))
    for _ in range(8):
        r = s + u[:, None] * su + v[:, None] * sv + (u * u)[:, None] * suu / 2 + (u * v)[:, None] * suv + (
            v * v)[:, None] * svv / 2 - x
        du, dv = su + u[:, None] * suu + v[:, None] * suv, sv + u[:, None] * suv + v[:, None] * svv
        a, b, c = (du * du).sum(1), (du * dv).sum(1), (dv * dv).sum(1)
        g, h = (r * du).sum(1), (r * dv).sum(1)
        det = np.maximum(a * c - b * b, 1e-300)
        u, v = (np.clip(u - (c * g - b * h) / det, low[0], high[0]),
                np.clip(v - (a * h - b * g) / det, low[1], high[1]))
    r = s + u[:, None] * su + v[:, None] * sv + (u * u)[:, None] * suu / 2 + (u * v)[:, None] * suv + (
        v * v)[:, None] * svv / 2 - x
    return np.linalg.norm(r, axis=1)


def distances(points: np.ndarray, other: Samples, tried: int = 12, looked_at: int = 48, rounds: int = 6) -> np.ndarray:
    """Distance [n] from each point to the other surface: of `tried` nearest cells the least by Taylor's series. Those of
    the largest distance again, by points of these cells that come closer and closer, until the largest is one of them."""
    m = len(other.jets)
    to_samples = cKDTree(other.points).query(points)[0]
    best = to_samples.copy()
    index = cKDTree(other.points[:m]).query(points, k=min(tried, m))[1]
    for k in range(index.shape[1]):
        best = np.minimum(best, _on_taylor(points, other.jets[index[:, k]]))
    done = np.zeros(len(points), bool)
    for _ in range(rounds):
        worst = np.argsort(-best)[:looked_at]
        if done[worst[0]]:
            return best
        worst = worst[~done[worst]]
        best[worst] = np.minimum(to_samples[worst], _zoomed(points[worst], other, index[worst, :8]))
        done[worst] = True
    raise AssertionError("the largest distance was not found")


def _zoomed(points: np.ndarray, surface: Samples, index: np.ndarray, rounds: int = 16) -> np.ndarray:
    """Distance [n] from each point to the nearest of 5 x 5 points of each of its cells, index [n, k], and then of grids round
    the nearest, half as wide each time. Grids may leave their cells, not their faces."""
    k = index.shape[1]
    cell, x = index.ravel(), np.repeat(points, k, axis=0)
    at, width = surface.uv[cell], 0.5 / surface.cells[cell]
    step = np.linspace(-1, 1, 5)
    grid = np.stack(np.meshgrid(step, step, indexing="ij"), axis=-1).reshape(-1, 2)
    for _ in range(rounds):
        uv = np.clip(at[:, None] + width[:, None, None] * grid, 0, 1)
        found = osd_jets(surface.mesh, np.repeat(surface.face[cell], len(grid)), np.repeat(surface.corner[cell], len(grid)),
                         uv.reshape(-1, 2), surface.boundary).jets[:, 0].reshape(len(cell), len(grid), 3)
        distance = np.linalg.norm(found - x[:, None], axis=2)
        nearest = distance.argmin(axis=1)
        at, width = uv[np.arange(len(cell)), nearest], width / 2
    return distance.min(axis=1).reshape(-1, k).min(axis=1)


def triangles(mesh: Mesh, levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners [n, 3, 3] of triangles of the cage after so many refinements, and the cage's face of each [n]."""
    owner = np.arange(mesh.n_faces)
    for _ in range(levels):
        owner = np.repeat(owner, mesh.sizes)
        mesh = refine(mesh)
    quads = mesh.flat.reshape(-1, 4)
    index = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return mesh.xyz[index], np.concatenate([owner, owner]), index


def _segments_cross(p: np.ndarray, q: np.ndarray, tri: np.ndarray) -> np.ndarray:
    """Whether segments p q [n, 3] pass through triangles [n, 3, 3], not nearly in their plane (Moeller, Trumbore 1997)."""
    e1, e2, d, t = tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0], q - p, p - tri[:, 0]
    h, k = np.cross(d, e2), np.cross(t, e1)
    det = (e1 * h).sum(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, s = (t * h).sum(1) / det, (d * k).sum(1) / det, (e2 * k).sum(1) / det
    steep = np.abs(det) > 1e-6 * np.linalg.norm(d, axis=1) * np.linalg.norm(np.cross(e1, e2), axis=1)
    with np.errstate(invalid="ignore"):
        return steep & (u >= 0) & (v >= 0) & (u + v <= 1) & (s >= 0) & (s <= 1)


def _sides(tri: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether corners of the triangles [n, 3, 3] lie on both sides of the plane of the other ones, or nearly in it."""
    normal = np.cross(other[:, 1] - other[:, 0], other[:, 2] - other[:, 0])
    height = ((tri - other[:, :1]) * normal[:, None]).sum(2)
    slack = 1e-9 * np.abs(height).max(1)
    return (height.min(1) <= slack) & (height.max(1) >= -slack)


def crossing_faces(mesh: Mesh, levels: int) -> set[tuple[int, int]]:
    """Pairs (f, g), f <= g, of the cage's faces whose triangles after so many refinements pass through each other;
    triangles with a common vertex are not looked at."""
    tri, owner, index = triangles(mesh, levels)
    middle, radius = tri.mean(1), np.linalg.norm(tri - tri.mean(1, keepdims=True), axis=2).max(1)
    pairs = cKDTree(middle).query_pairs(2 * radius.max(), output_type="ndarray")
    a, b = pairs.T
    slack = 1e-12 * np.abs(tri).max()
    low, high = tri.min(1) - slack, tri.max(1) + slack
    for k in range(3):
        boxes_meet = (low[a, k] <= high[b, k]) & (low[b, k] <= high[a, k])
        a, b = a[boxes_meet], b[boxes_meet]
    apart = ~(index[a][:, :, None] == index[b][:, None, :]).any((1, 2))
    a, b = a[apart], b[apart]
    across = _sides(tri[b], tri[a]) & _sides(tri[a], tri[b])
    a, b = a[across], b[across]
    hit = np.zeros(len(a), bool)
    for k in range(3):
        hit |= _segments_cross(tri[a, k], tri[a, (k + 1) % 3], tri[b])
        hit |= _segments_cross(tri[b, k], tri[b, (k + 1) % 3], tri[a])
    f, g = owner[a[hit]], owner[b[hit]]
    return {(int(min(x, y)), int(max(x, y))) for x, y in zip(f, g)}

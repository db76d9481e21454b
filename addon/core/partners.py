# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror images within a mesh: vertices and their partners across planes through the object's origin. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..binding.values import Cage, rms_radius
from .crease import edge_keys
from .layout import sides

NEAR = 1e-5  # of the size: how far from its mirrored position a partner may be
_EXACT = 5e-6  # of the root mean square radius: half of what the library takes for symmetric (CO_SYMMETRY_TOLERANCE)


@dataclass(frozen=True)
class Pairs:
    """For each vertex of a mesh (n,) its partner across the plane `axis` = 0, or -1. One in the plane is its own."""

    axis: int
    partner: np.ndarray

    @classmethod
    def of_points(cls, points: np.ndarray, axis: int) -> Pairs:
        """The vertex nearest to the mirrored position of each of points (n, 3), finite ones, if it is near enough."""
        size = float(np.ptp(points, axis=0).max(initial=0.0)) or 1.0
        return cls(axis, _nearest(points, points * mirror_signs(axis), NEAR * size))


def mirror_signs(axis: int) -> np.ndarray:
    """(3,): what coordinates are multiplied with by the reflection."""
    return np.where(np.arange(3) == axis, -1.0, 1.0)


def _nearest(points: np.ndarray, wanted: np.ndarray, radius: float) -> np.ndarray:
    """For each of wanted (k, 3) the nearest of points (n, 3) within the radius, or -1. Of several points in one cell of
    that size the first one counts."""
    low = np.minimum(points.min(axis=0), wanted.min(axis=0)) - 2 * radius
    shape = np.ceil((np.maximum(points.max(axis=0), wanted.max(axis=0)) - low) / radius).astype(np.int64) + 3

    def keys(cells: np.ndarray) -> np.ndarray:
        return (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]

    taken, first = np.unique(keys(((points - low) / radius).astype(np.int64)), return_index=True)
    cell = ((wanted - low) / radius).astype(np.int64)
    found, best = np.full(len(wanted), -1), np.full(len(wanted), radius)
    for step in product((-1, 0, 1), repeat=3):
        key = keys(cell + step)
        at = np.minimum(np.searchsorted(taken, key), len(taken) - 1)
        distance = np.linalg.norm(points[first[at]] - wanted, axis=1)
        nearer = (taken[at] == key) & (distance <= best)
        found[nearer], best[nearer] = first[at[nearer]], distance[nearer]
    return found


def with_partners(chosen: np.ndarray, pairs: Sequence[Pairs]) -> np.ndarray:
    """The vertices (n,) and their images across all planes."""
    chosen = chosen.copy()
    for pair in pairs:
        images = pair.partner[chosen]
        chosen[images[images >= 0]] = True
    return chosen


def mean_of_sides(points: np.ndarray, moving: np.ndarray, pairs: Sequence[Pairs]) -> np.ndarray:
    """Points (n, 3), those of `moving` (n,) that have a moving partner exactly symmetric."""
    points = points.copy()
    for pair in pairs:
        vertices = np.flatnonzero(moving & (pair.partner >= 0))
        images = pair.partner[vertices]
        both = moving[images] & (pair.partner[images] == vertices)
        vertices, images = vertices[both], images[both]
        points[vertices] = (points[vertices] + points[images] * mirror_signs(pair.axis)) / 2
    return points


def is_symmetric(cage: Cage, moving: np.ndarray, pair: Pairs) -> bool:
    """Whether a cage, whose vertices those of `pair` are, its faces and `moving` (n,) are their own mirror images, so
    exactly that the library finds them to be."""
    partner = pair.partner
    if (partner < 0).any() or not np.array_equal(moving, moving[partner]):
        return False
    points = cage.positions
    off = np.abs(points[partner] * mirror_signs(pair.axis) - points).max()
    directed = sides(cage.face_sizes, cage.face_vertices).astype(np.int64)
    numbers, n = directed @ (len(points), 1), len(points)
    alike = np.array_equal(np.sort(numbers), np.sort(partner[directed] @ (1, n)))
    return bool(off <= _EXACT * rms_radius(points) and alike and _creases_are_symmetric(cage, partner))


def _creases_are_symmetric(cage: Cage, partner: np.ndarray) -> bool:
    creases, n = cage.creases, len(partner)
    sharp = np.zeros(n)
    sharp[creases.vertices] = creases.vertex_sharpness
    edges = [edge_keys(ends, n) for ends in (creases.edges, partner[creases.edges])]
    orders = [np.argsort(keys, kind="stable") for keys in edges]
    keys_alike = np.array_equal(edges[0][orders[0]], edges[1][orders[1]])
    values = [creases.edge_sharpness[order] for order in orders]
    return keys_alike and np.array_equal(*values) and np.array_equal(sharp, sharp[partner])

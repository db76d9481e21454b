# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of a cage as dense meshes with exact normals and curvatures, by the library's own jets. No bpy.

Blender's modifier shows the limit surface alone; this shows `plane` and `polynomial` as well. Signs of curvatures are
those of addon/core/curvature.py: normals look outwards, and a sphere has positive mean curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from addon.binding import library
from addon.binding.values import Cage
from addon.core import curvature, surface_points


@dataclass(frozen=True)
class Dense:
    """Points (n, 3), unit normals (n, 3), mean and Gauss curvatures (n,), areas that the points stand for (n,), and
    quads (m, 4) between the points. Neighbouring faces of the cage have their own points along their common edge."""

    points: np.ndarray
    normals: np.ndarray
    mean: np.ndarray
    gauss: np.ndarray
    areas: np.ndarray
    quads: np.ndarray


def dense(cage: Cage, surface: str, n_quads: int = 40_000, faces: np.ndarray | None = None) -> Dense:
    """The surface of abi.SURFACES, but for `auto`, in about `n_quads` quads; of some `faces` (k,) of the cage only.
    CurvoptError if it has none."""
    sizes = np.asarray(cage.face_sizes)
    some = sizes if faces is None else sizes[faces]
    patches = np.where(some == 4, 1, some).sum()
    side = max(2, round((n_quads / patches) ** 0.5))
    net = surface_points.grids(sizes, side, faces)
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        jets = net.jets(mesh, cage.positions, surface)
    found = curvature.of_jets(jets)
    weight = np.ones(side + 1)
    weight[[0, -1]] = 0.5
    rule = np.tile(np.outer(weight, weight).ravel(), patches) / side**2  # trapezoids
    areas = rule * np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1)
    return Dense(jets[:, 0], found.normals, found.H, found.K, areas, net.quads)


def faceted(cage: Cage, edge: float, side: int = 40) -> tuple[Dense, np.ndarray]:
    """The quads of a cage itself, flat between its edges, by side x side pieces each; and which points (n,) lie within
    `edge` faces of an edge. ValueError if it has other faces."""
    if (np.asarray(cage.face_sizes) != 4).any():
        raise ValueError("Only a cage of quads can be shown by its faces.")
    corners = np.asarray(cage.positions)[np.asarray(cage.face_vertices).reshape(-1, 4)]
    t = np.linspace(0.0, 1.0, side + 1)
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(t, t, indexing="ij"))
    a, b, c, d = (corners[:, None, k] for k in range(4))
    points = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
    crossed = np.cross((1 - v) * (b - a) + v * (c - d), (1 - u) * (d - a) + u * (c - b))
    length = np.linalg.norm(crossed, axis=2, keepdims=True)
    first = np.arange(side)[:, None] * (side + 1) + np.arange(side)
    quad = np.stack([first, first + side + 1, first + side + 2, first + 1], -1).reshape(-1, 4)
    quads = (np.arange(len(corners))[:, None, None] * (side + 1) ** 2 + quad).reshape(-1, 4)
    none = np.zeros(points.shape[0] * points.shape[1])
    near = np.tile((np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)) < edge).ravel(), len(corners))
    shape = Dense(points.reshape(-1, 3), (crossed / np.maximum(length, 1e-300)).reshape(-1, 3), none, none,
                  length.ravel() / (side + 1) ** 2, quads)  # fmt: skip
    return shape, near


def centre_and_size(shape: Dense) -> tuple[np.ndarray, float]:
    """Centroid (3,) of the surface and the root mean square distance of its points from there, by area."""
    weight = shape.areas / shape.areas.sum()
    centre = weight @ shape.points
    return centre, float(np.sqrt(weight @ ((shape.points - centre) ** 2).sum(1)))


def torus_ratio(points: np.ndarray) -> float:
    """Minor over major radius of a torus about the z axis, points (n, 3)."""
    distance = np.hypot(points[:, 0], points[:, 1])
    return float((distance.max() - distance.min()) / (distance.max() + distance.min()))

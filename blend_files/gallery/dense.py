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


def centre_and_size(shape: Dense) -> tuple[np.ndarray, float]:
    """Centroid (3,) of the surface and the root mean square distance of its points from there, by area."""
    weight = shape.areas / shape.areas.sum()
    centre = weight @ shape.points
    return centre, float(np.sqrt(weight @ ((shape.points - centre) ** 2).sum(1)))


def torus_ratio(points: np.ndarray) -> float:
    """Minor over major radius of a torus about the z axis, points (n, 3)."""
    distance = np.hypot(points[:, 0], points[:, 1])
    return float((distance.max() - distance.min()) / (distance.max() + distance.min()))

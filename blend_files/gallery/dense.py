# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of a cage as dense meshes with exact normals and curvatures, by the library's own jets. No bpy.

Blender's modifier shows the limit surface alone; this shows `plane` and `polynomial` as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import native
from .values import Cage

_NEAR = 1e-4  # of a face: where an extraordinary vertex has no derivatives, those this far off it are taken


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
    """The surface of header.SURFACES, but for `auto`, in about `n_quads` quads; of some `faces` (k,) of the cage only.
    CurvoptError if it has none."""
    patch_face, patch_corner = _patches(cage, faces)
    side = max(2, round((n_quads / len(patch_face)) ** 0.5))
    grid = np.linspace(0.0, 1.0, side + 1)
    u, v = (axis.ravel() for axis in np.meshgrid(grid, grid, indexing="ij"))
    n = len(u)
    face, corner = np.repeat(patch_face, n), np.repeat(patch_corner, n)
    uv = np.tile(np.stack([u, v], -1), (len(patch_face), 1))
    jets = _jets(cage, surface, face, corner, uv)
    normals, mean, gauss, density = _curvatures(jets)
    weight = np.ones(side + 1)
    weight[[0, -1]] = 0.5
    areas = density * np.tile(np.outer(weight, weight).ravel(), len(patch_face)) / side**2
    i, j = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    first = (i * (side + 1) + j).ravel()
    quads = np.stack([first, first + side + 1, first + side + 2, first + 1], -1)
    quads = (quads[None] + n * np.arange(len(patch_face))[:, None, None]).reshape(-1, 4)
    return Dense(jets[:, 0], normals, mean, gauss, areas, quads)


def _patches(cage: Cage, faces: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """(face, corner) of each piece with parameters of its own: a quad, or a quarter of another polygon."""
    faces = np.arange(len(cage.face_sizes)) if faces is None else np.asarray(faces)
    parts = np.where(cage.face_sizes[faces] == 4, 1, cage.face_sizes[faces])
    corner = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.repeat(faces, parts).astype(np.int32), corner.astype(np.int32)


def _jets(cage: Cage, surface: str, face: np.ndarray, corner: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Jets (n, 10, 3), with those from nearby for derivatives that do not exist."""
    library = native.library()
    with native.Mesh.create(library, len(cage.positions), cage.face_sizes, cage.face_vertices, cage.creases) as mesh:
        jets = mesh.jets(cage.positions, face, corner, uv, surface)
        gone = np.flatnonzero(~np.isfinite(jets).all(axis=(1, 2)))
        if len(gone):
            near = _NEAR + (1 - 2 * _NEAR) * uv[gone]
            places = jets[gone, 0]
            jets[gone] = mesh.jets(cage.positions, face[gone], corner[gone], near, surface)
            jets[gone, 0] = np.where(np.isfinite(places), places, jets[gone, 0])
    return jets


def _curvatures(jets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Normals (n, 3), mean and Gauss curvature (n,), |S_u x S_v| (n,). The mean curvature of a sphere is negative if
    its normals look outwards, as here."""
    su, sv, suu, suv, svv = (jets[:, k] for k in range(1, 6))
    normal = np.cross(su, sv)
    density = np.linalg.norm(normal, axis=1)
    normal = normal / np.maximum(density, 1e-300)[:, None]

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a * b).sum(-1)

    e, f, g = dot(su, su), dot(su, sv), dot(sv, sv)
    l, m, n = dot(suu, normal), dot(suv, normal), dot(svv, normal)
    det = np.maximum(e * g - f * f, 1e-300)
    return normal, (e * n - 2 * f * m + g * l) / (2 * det), (l * n - m * m) / det, density


def centre_and_size(shape: Dense) -> tuple[np.ndarray, float]:
    """Centroid (3,) of the surface and the root mean square distance of its points from there, by area."""
    weight = shape.areas / shape.areas.sum()
    centre = weight @ shape.points
    return centre, float(np.sqrt(weight @ ((shape.points - centre) ** 2).sum(1)))


def torus_ratio(points: np.ndarray) -> float:
    """Minor over major radius of a torus about the z axis, points (n, 3)."""
    distance = np.hypot(points[:, 0], points[:, 1])
    return float((distance.max() - distance.min()) / (distance.max() + distance.min()))

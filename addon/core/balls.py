# SPDX-License-Identifier: GPL-3.0-or-later
"""Balls that a surface touches, and is curved like them there. No bpy.

A ball is the unit sphere under a linear map: an ellipsoid. The surface touches it at the tip of its Z axis, from outside or from
inside, and has the ellipsoid's principal curvatures there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Touch:
    """Where the surface touches a ball: the `tip` (3,), the `normal` (3,) there, out of the ball, the `curvatures` (2,) of the
    ball, positive, and the `direction` (3,) of the first one."""

    tip: np.ndarray
    normal: np.ndarray
    curvatures: np.ndarray
    direction: np.ndarray


def touch(middle: np.ndarray, axes: np.ndarray) -> Touch:
    """Of the ball round `middle` (3,) whose X, Y and Z axes are the columns of `axes` (3, 3). ValueError for a flat one.

    Near its tip it is M (u, v, 1 - (u^2 + v^2) / 2): with g the products of the X and Y axes, and h the Z axis' part along the
    normal, the curvatures k solve (h / k) e = g e."""
    x, y, z = axes.T
    normal = np.cross(x, y)
    with np.errstate(all="ignore"):
        normal = normal / np.linalg.norm(normal) * np.sign(normal @ z)
        depth = normal @ z
        metric = np.array([[x @ x, x @ y], [x @ y, y @ y]])
        curvatures = depth / np.linalg.eigvalsh(metric) if np.isfinite(metric).all() else np.full(2, np.nan)
    if not (np.isfinite(normal).all() and np.isfinite(curvatures).all() and (curvatures > 0).all()):
        raise ValueError("is flat: give it a size on all three axes")
    across = np.linalg.eigh(metric)[1][:, 0]
    direction = axes[:, :2] @ across
    return Touch(middle + z, normal, curvatures, direction / np.linalg.norm(direction))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Is a surface a torus of revolution up to a Moebius map, and which one? Judged by its curvature spheres.

Oriented spheres are unit vectors of R^{4,1}, on which Moebius maps act by isometries. The curvature sphere of a
point p with normal n and principal curvature k is the vector N + k P with P = (p, (|p|^2 - 1)/2, (|p|^2 + 1)/2) and
N = (n, p.n, p.n). A surface is the Moebius image of a round torus with radii R = 1, r = rho exactly when the vectors of
each principal curvature trace a circle (Dupin cyclide), and then those circles' radii in R^{4,1} are the invariants

    radius 1 / rho  and  radius 1 / sqrt(1 - rho^2);

for the tube spheres of the round torus (centre on the unit circle, radius rho) the first is seen at once. So no
Moebius map has to be searched for: fit a circle to each family; its misfit says how far the surface is from a cyclide,
its radius which torus it is. The Clifford torus has both radii sqrt(2). Positions are first brought to unit size.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ccref import Mesh
from energy_ref import samples, second_order

FORM = np.array([1.0, 1, 1, 1, -1])


class CircleFit(NamedTuple):
    """Radius in R^{4,1} and the largest distance of a sphere vector from the circle, relative to the radius."""

    radius: float
    misfit: float


def curvature_spheres(mesh: Mesh, n_gauss: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Sphere vectors [n, 5] of the larger and of the smaller principal curvature at points of every regular face."""
    jets = np.concatenate([batch[4] for batch in samples(mesh, n_gauss, 0, 0)])
    centre = jets[:, 0].mean(axis=0)
    size = np.sqrt(((jets[:, 0] - centre) ** 2).sum(axis=1).mean())
    jets = jets / size
    p = jets[:, 0] - centre / size
    density = second_order(jets)
    normal = np.cross(jets[:, 1], jets[:, 2])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    e, f, g = ((jets[:, a] * jets[:, b]).sum(axis=1) for a, b in ((1, 1), (1, 2), (2, 2)))
    l, m, n = ((jets[:, a] * normal).sum(axis=1) for a in (3, 4, 5))
    h = (e * n - 2 * f * m + g * l) / (2 * (e * g - f * f))
    root = np.sqrt(np.maximum(h * h - density["gauss"], 0))
    square = (p * p).sum(axis=1)[:, None]
    point = np.concatenate([p, (square - 1) / 2, (square + 1) / 2], axis=1)
    height = (p * normal).sum(axis=1)[:, None]
    plane = np.concatenate([normal, height, height], axis=1)
    # with S_uu . n = k |S_u|^2 the sphere's centre is p + n / k: the vector is N + k P up to the sign of k
    return plane + (h + root)[:, None] * point, plane + (h - root)[:, None] * point


def fit_circle(vectors: np.ndarray) -> CircleFit:
    """Best plane by principal components, then the circle in the Lorentz metric by least squares."""
    centre = vectors.mean(axis=0)
    _, _, axes = np.linalg.svd(vectors - centre, full_matrices=False)
    flat = (vectors - centre) @ axes[:2].T
    gram = (axes[:2] * FORM) @ axes[:2].T
    square = np.einsum("ni,ij,nj->n", flat, gram, flat)
    # |x - c|^2 = r^2  <=>  2 x.c + (r^2 - c.c) = |x|^2
    solution = np.linalg.lstsq(np.c_[2 * flat @ gram, np.ones(len(flat))], square, rcond=None)[0]
    middle = solution[:2]
    radius_square = solution[2] + middle @ gram @ middle
    if radius_square <= 0 or np.linalg.eigvalsh(gram)[0] <= 0:
        return CircleFit(float("nan"), float("inf"))
    radius = float(np.sqrt(radius_square))
    moved = flat - middle
    length = np.sqrt(np.einsum("ni,ij,nj->n", moved, gram, moved))
    off_plane = np.linalg.norm((vectors - centre) - flat @ axes[:2], axis=1)
    scale = np.linalg.norm(moved, axis=1).mean()
    return CircleFit(radius, float(np.sqrt((length / radius - 1) ** 2 + (off_plane / scale) ** 2).max()))


def torus_fits(mesh: Mesh) -> tuple[CircleFit, CircleFit]:
    """Circle fits of both families, the one with the larger radius (smaller rho) first."""
    return tuple(sorted((fit_circle(v) for v in curvature_spheres(mesh)), key=lambda fit: -fit.radius))

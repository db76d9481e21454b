# SPDX-License-Identifier: GPL-3.0-or-later
"""From jets of a surface to its curvatures. No bpy.

Signs: normals are S_u x S_v, outwards on a cage whose faces are counter-clockwise seen from outside; curvature is
positive where the surface bends towards the inside, so that a sphere has k1 = k2 = 1 / radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SECOND, _THIRD = 3, 6  # where they begin in a jet: S_uu S_uv S_vv; S_uuu S_uuv S_uvv S_vvv


@dataclass(frozen=True)
class Curvatures:
    """At n points: unit normals (n, 3); principal curvatures k1 >= k2, mean H and Gauss K; `variation` |grad h|, how
    fast curvature changes with distance. Units 1 / length, K and `variation` 1 / length^2. NAN where there is none."""

    normals: np.ndarray
    k1: np.ndarray
    k2: np.ndarray
    H: np.ndarray
    K: np.ndarray
    variation: np.ndarray


@dataclass(frozen=True)
class Forms:
    """At n points, in the parameters u and v: unit normals (n, 3), first form `metric` and `second` form (n, 2, 2), and
    `change` (n, 2, 2, 2), the covariant derivative of the second form, which is symmetric (Codazzi)."""

    normals: np.ndarray
    metric: np.ndarray
    second: np.ndarray
    change: np.ndarray


def forms_of_jets(jets: np.ndarray) -> Forms:
    """Of jets (n, 10, 3), as library.Mesh.jets gives them."""
    first, second = jets[:, 1:3], jets[:, [_SECOND, _SECOND + 1, _SECOND + 1, _SECOND + 2]].reshape(-1, 2, 2, 3)
    cross = np.cross(first[:, 0], first[:, 1])
    normals = cross / np.linalg.norm(cross, axis=1)[:, None]
    metric = np.einsum("nix,njx->nij", first, first)
    form = -np.einsum("nijx,nx->nij", second, normals)
    return Forms(normals, metric, form, _gradient_of_form(jets, second, first, normals, inverse_of(metric), form))


def of_jets(jets: np.ndarray) -> Curvatures:
    """Curvatures of jets (n, 10, 3), as library.Mesh.jets gives them.

    `variation` is the length of C = grad h, with C_ijk = S_ijk . N minus the three Christoffel terms; it does not need
    principal directions, which umbilics do not have."""
    with np.errstate(invalid="ignore", divide="ignore"):
        forms = forms_of_jets(jets)
        inverse = inverse_of(forms.metric)
        trace = np.einsum("nij,nji->n", inverse, forms.second)
        determinant = _determinant(forms.second) / _determinant(forms.metric)
        mean = trace / 2
        root = np.sqrt(np.maximum(mean**2 - determinant, 0))
        raised = np.einsum("nijk,nil,njm,nko->nlmo", forms.change, inverse, inverse, inverse, optimize=True)
        variation = np.sqrt(np.maximum(np.einsum("nijk,nijk->n", forms.change, raised), 0))
    return Curvatures(forms.normals, mean + root, mean - root, mean, determinant, variation)


def _gradient_of_form(
    jets: np.ndarray, second: np.ndarray, first: np.ndarray, normals: np.ndarray, inverse: np.ndarray, form: np.ndarray
) -> np.ndarray:
    """C_ijk (n, 2, 2, 2): the covariant derivative of the second form."""
    count = np.add.outer(np.add.outer([0, 1], [0, 1]), [0, 1])  # how many of i, j, k are v
    third = -np.einsum("nijkx,nx->nijk", jets[:, _THIRD + count], normals)
    christoffel = np.einsum("nlm,nijx,nmx->nijl", inverse, second, first, optimize=True)
    turned = np.einsum("nijl,nlk->nijk", christoffel, form)
    return third - turned - np.swapaxes(turned, 2, 3) - np.transpose(turned, (0, 3, 2, 1))


def _determinant(matrices: np.ndarray) -> np.ndarray:
    return matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]


def inverse_of(matrices: np.ndarray) -> np.ndarray:
    """Of symmetric 2 x 2 matrices (n, 2, 2); NAN and infinities where there is none."""
    adjugate = np.stack([matrices[:, 1, 1], -matrices[:, 0, 1], -matrices[:, 1, 0], matrices[:, 0, 0]], -1)
    return adjugate.reshape(-1, 2, 2) / _determinant(matrices)[:, None, None]

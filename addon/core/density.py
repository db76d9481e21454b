# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of an energy is at a point of a surface: what curvopt.h, "The terms of the objective", integrates. No bpy."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .curvature import forms_of_jets


def densities(jets: np.ndarray, area: float, radius: float) -> dict[str, np.ndarray]:
    """Of jets (n, 10, 3), by the names of the energies: what each has per unit of area (n,), in 1 / length^2. `area` is that of
    the surface, with which energies of third order are multiplied, and `radius` the RMS radius of the cage. At umbilics, which
    have no principal directions, the parts of "mvs" and "mvs_cross" belong to some directions."""
    forms = forms_of_jets(jets)
    root = np.linalg.cholesky(forms.metric)
    inverse = np.linalg.inv(root)
    k, turn = np.linalg.eigh(inverse @ forms.second @ inverse.transpose(0, 2, 1))
    frame = inverse.transpose(0, 2, 1) @ turn  # columns: parameters of unit vectors in principal directions
    change = np.einsum("nijk,nip,njq,nkr->npqr", forms.change, frame, frame, frame, optimize=True)
    a, b, c, d = change[:, 0, 0, 0], change[:, 0, 0, 1], change[:, 0, 1, 1], change[:, 1, 1, 1]
    ends, middles = a**2 + d**2, b**2 + c**2
    return {
        "willmore": (k**2).sum(axis=1),
        "mean_curvature": k.mean(axis=1) ** 2,
        "mvs": area * ends,
        "mvs_cross": area * (ends + middles),
        "variation": area * (ends + 3 * middles),
        "mehlum_tarrou": area * (5 * ends + 9 * middles + 6 * (a * c + b * d)) / 8,
        "area": np.full(len(jets), 1 / radius**2),
    }


def mixed(weights: Mapping[str, float], parts: Mapping[str, np.ndarray]) -> np.ndarray:
    """The density (n,) of a mix of energies."""
    return sum(weight * parts[name] for name, weight in weights.items())

# SPDX-License-Identifier: GPL-3.0-or-later
"""What is minimized: one energy, or a mix of several, as text such as "mvs" or "mvs:1,willmore:0.1". No bpy."""

from __future__ import annotations

import math
from collections.abc import Mapping

# What can be minimized by itself: every term but the area, whose least is no surface.
ENERGY_LABELS = {
    "willmore": "Willmore",
    "mvs": "MVS",
    "mvs_cross": "MVS_cross",
    "variation": "Variation",
    "mehlum_tarrou": "Mehlum-Tarrou",
    "mean_curvature": "Mean curvature",
}
AREA = "area"  # may be part of a mix


def weights_of(text: str) -> dict[str, float]:
    """The weight of each energy that `text` names. ValueError, with a sentence, if it is no mix of energies."""
    weights: dict[str, float] = {}
    for part in text.split(",") if text else ():
        name, colon, number = part.strip().partition(":")
        if name not in (*ENERGY_LABELS, AREA):
            raise ValueError(f"There is no energy '{name}'; there are {', '.join((*ENERGY_LABELS, AREA))}.")
        if name in weights:
            raise ValueError(f"Energy '{name}' is named twice in '{text}'.")
        try:
            weights[name] = float(number) if colon else 1.0
        except ValueError:
            raise ValueError(f"'{number}' is no weight of energy '{name}'.") from None
        if not (math.isfinite(weights[name]) and weights[name] >= 0):
            raise ValueError(f"The weight of energy '{name}' is {number}: it must be 0 or more.")
    if not any(weight for name, weight in weights.items() if name != AREA):
        raise ValueError("The mix is empty: give an energy other than the area a weight above 0.")
    return weights


def text_of(weights: Mapping[str, float]) -> str:
    """The other way round; energies of weight 0 are left out."""
    some = {name: weight for name, weight in weights.items() if weight}
    return ",".join(name if weight == 1 else f"{name}:{weight:.6g}" for name, weight in some.items())


def label_of(text: str) -> str:
    """For people: "MVS", or "MVS + 0.1 Willmore"."""
    weights = weights_of(text)
    if len(weights) == 1:
        return _name(next(iter(weights)))
    return " + ".join(_name(name) if w == 1 else f"{w:.3g} {_name(name)}" for name, w in weights.items() if w)


def _name(term: str) -> str:
    return ENERGY_LABELS.get(term, "Area")


def number_text(value: float) -> str:
    """An energy for people: 5 digits, and no exponent where plain digits are readable."""
    if not math.isfinite(value):
        return "–"
    return f"{value:,.0f}" if 1e4 <= abs(value) < 1e8 else f"{value:.5g}"

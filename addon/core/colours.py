# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvature as colour: which numbers, over which range, in which colours. No bpy."""

from __future__ import annotations

import numpy as np

from .curvature import Curvatures

# What can be shown: name, label, tooltip; by attribute of Curvatures.
QUANTITIES = (
    ("H", "Mean H", "Mean curvature: half the sum of both principal curvatures. Willmore makes it even"),
    ("K", "Gauss K", "Gauss curvature: the product of both. Positive on domes, 0 on cylinders, negative on saddles"),
    ("k1", "Largest k1", "The larger principal curvature"),
    ("k2", "Smallest k2", "The smaller principal curvature"),
    ("variation", "Variation", "How fast curvature changes with distance. Third-order energies such as MVS punish it"),
)
DISTANCE = "distance"  # from another surface, in the same colours as what is never negative
_OUTLIERS = 2.0  # percent of the points at either end that may be out of range

# Seen as evenly spaced steps: blue, white, red for signed numbers; dark to light for others. sRGB.
_SIGNED = ((0.13, 0.25, 0.62), (0.38, 0.62, 0.86), (0.93, 0.93, 0.93), (0.93, 0.58, 0.38), (0.66, 0.10, 0.16))
_PLAIN = ((0.07, 0.05, 0.22), (0.38, 0.10, 0.47), (0.75, 0.22, 0.42), (0.96, 0.52, 0.30), (0.99, 0.94, 0.66))


def signed(quantity: str) -> bool:
    """Whether 0 is in the middle of its colours."""
    return quantity not in ("variation", DISTANCE)


def value_range(quantity: str, values: np.ndarray) -> tuple[float, float]:
    """(low, high) of the colours for values (n,): symmetric about 0 for signed numbers; a few outliers at poles, where
    curvature may be infinite, do not count."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return (-1.0, 1.0) if signed(quantity) else (0.0, 1.0)
    if signed(quantity):
        high = max(abs(np.percentile(finite, [_OUTLIERS, 100 - _OUTLIERS]))) or 1.0
        return -float(high), float(high)
    return 0.0, float(np.percentile(finite, 100 if quantity == DISTANCE else 100 - _OUTLIERS)) or 1.0


def colours(quantity: str, values: np.ndarray, low: float, high: float) -> np.ndarray:
    """RGBA (n, 4) float32, sRGB, of values (n,); those out of range have the colour of its end."""
    stops = np.array(_SIGNED if signed(quantity) else _PLAIN)
    place = np.clip((np.nan_to_num(values, nan=low, posinf=high, neginf=low) - low) / (high - low), 0, 1)
    place = place * (len(stops) - 1)
    rgb = [np.interp(place, np.arange(len(stops)), stops[:, channel]) for channel in range(3)]
    return np.stack([*rgb, np.ones_like(place)], -1).astype(np.float32)


def linear(srgb: np.ndarray) -> np.ndarray:
    """Scene-linear RGBA of sRGB, which is how Blender keeps colours."""
    rgb = srgb[:, :3]
    values = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.concatenate([values, srgb[:, 3:]], 1).astype(np.float32)


def of_curvatures(curvatures: Curvatures) -> dict[str, np.ndarray]:
    """Values (n,) of every quantity."""
    return {name: getattr(curvatures, name) for name, _, _ in QUANTITIES}

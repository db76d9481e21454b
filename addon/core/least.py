# SPDX-License-Identifier: GPL-3.0-or-later
"""Least bending energies that theorems know: of all closed surfaces of a genus, whatever their shape or symmetry.

  genus 0    int H^2 >= 4 pi, with equality for round spheres only (Willmore 1965)
  genus 1    int H^2 >= 2 pi^2, with equality for the Clifford torus and its Moebius images only (Marques and Neves 2014)

Willmore's energy is 4 int H^2 - 4 pi chi. No bpy."""

from __future__ import annotations

import math

LEAST_H2 = {0: 4 * math.pi, 1: 2 * math.pi**2}
SOURCES = {0: "Willmore 1965", 1: "Marques and Neves 2014"}
_MOST_OPEN = 0.01  # of an energy: what is left open more widely is not taken for the least


def genus(euler: int) -> int:
    """Of a closed surface in one piece with an Euler characteristic."""
    return 1 - euler // 2


def least(energy: str, euler: int) -> float | None:
    """The least `energy`, "willmore" or "mean_curvature", of closed surfaces; None where no theorem says."""
    h2 = LEAST_H2.get(genus(euler)) if euler % 2 == 0 else None
    if h2 is None or energy not in ("willmore", "mean_curvature"):
        return None
    return 4 * (h2 - math.pi * euler) if energy == "willmore" else h2


def is_least(value: float, known: float | None, net_share: float, error: float) -> bool:
    """Whether an energy is the known least one within its stated errors: not below it by more than the quadrature's
    `error`, and not above by more than that and the net's share. False where that leaves too much open, or is NAN."""
    if known is None or not net_share + error <= _MOST_OPEN * known:
        return False
    return -error <= value - known <= net_share + error

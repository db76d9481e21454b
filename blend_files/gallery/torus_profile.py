# SPDX-License-Identifier: GPL-3.0-or-later
"""Willmore's energy of tori of revolution whose profile is a cubic B-spline, by fixed rules of few points. No bpy.

Shares no code with the library. The report's torus cages have turns about their axis, and its optimizer nearly
keeps them; in the limit of many turns only the profile is left, a closed curve in the half-plane x > 0: so few
variables that rules and ratios can be scanned. The report does not name its rule; the library's fixed one has many
points.
"""

from __future__ import annotations

import math

import numpy as np

from .store import Item, Store

CLIFFORD, SPHERES = 8 * math.pi**2, 16 * math.pi
RULES = (1, 2, 3, 8)  # Gauss points a span
RATIOS = (0.02, 0.05, *(k / 10 for k in range(1, 10)), 0.95, 0.98)
_ITERATIONS = 400  # a level
_MEMORY = 8
_FINE = 200  # points a span of the rule that a result is held against
_TINY = 1e-30


class Profile:
    """The energy of a closed cubic B-spline profile of n control points (n, 2), x from the axis and z along it, by a
    Gauss rule of `points` a span."""

    def __init__(self, n: int, points: int) -> None:
        nodes, weights = np.polynomial.legendre.leggauss(points)
        t = (nodes + 1) / 2
        basis = np.array([
            [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3],
            [-3 * (1 - t) ** 2, 9 * t**2 - 12 * t, -9 * t**2 + 6 * t + 3, 3 * t**2],
            [6 * (1 - t), 18 * t - 12, -18 * t + 6, 6 * t],
        ]) / 6  # fmt: skip
        self.rows = np.zeros((3, n * points, n))
        for span in range(n):
            for k in range(4):
                at = slice(span * points, (span + 1) * points)
                self.rows[:, at, (span + k) % n] += basis[:, k]
        self.weights = np.tile(weights / 2, n) * 2 * math.pi

    def jets(self, control: np.ndarray) -> list[np.ndarray]:
        """x, x', x'', z, z', z'' at the rule's points."""
        return [self.rows[order] @ control[:, axis] for axis in (0, 1) for order in (0, 1, 2)]

    def value(self, control: np.ndarray) -> float:
        """The energy; infinite if a point of the rule has left the half-plane."""
        jets = self.jets(control)
        return math.inf if jets[0].min() <= 0 else float(self.weights @ _bending(*jets))

    def gradient(self, control: np.ndarray) -> np.ndarray:
        """The exact gradient (n, 2), by complex steps."""
        jets = self.jets(control)
        found = np.zeros_like(control)
        for k in range(6):
            moved = [jet + (1j * _TINY if k == j else 0) for j, jet in enumerate(jets)]
            found[:, k // 3] += self.rows[k % 3].T @ (self.weights * _bending(*moved).imag / _TINY)
        return found

    def gauss(self, control: np.ndarray) -> float:
        """The integral of the Gauss curvature: 0 for a torus that the rule resolves."""
        x, dx, ddx, z, dz, ddz = self.jets(control)
        return float(self.weights @ ((dx * ddz - dz * ddx) * dz / (dx * dx + dz * dz) ** 1.5))


def _bending(
    x: np.ndarray, dx: np.ndarray, ddx: np.ndarray, z: np.ndarray, dz: np.ndarray, ddz: np.ndarray
) -> np.ndarray:
    """(k1^2 + k2^2) dA / (dt dphi) at points (n,) of a profile, given by its coordinates and two derivatives."""
    square = dx * dx + dz * dz
    along = (dx * ddz - dz * ddx) ** 2 / square**3
    across = dz * dz / (square * x * x)
    return (along + across) * x * np.sqrt(square)


def minimize(energy: Profile, control: np.ndarray) -> np.ndarray:
    """Limited-memory BFGS (Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm 7.4) with backtracking."""
    value, gradient = energy.value(control), energy.gradient(control)
    pairs: list[tuple[np.ndarray, np.ndarray]] = []
    for _ in range(_ITERATIONS):
        step = -_two_loops(gradient, pairs)
        slope = float((step * gradient).sum())
        if slope >= 0:
            step, pairs, slope = -gradient, [], -float((gradient**2).sum())
        longest = np.sqrt((step**2).sum(1).max())
        length = min(1.0, 0.3 * np.sqrt((np.diff(control, axis=0) ** 2).sum(1).mean()) / max(longest, _TINY))
        while length > 1e-12 and energy.value(control + length * step) > value + 1e-4 * length * slope:
            length /= 2
        if length <= 1e-12:
            break
        moved = control + length * step
        new = energy.gradient(moved)
        if ((moved - control) * (new - gradient)).sum() > 0:
            pairs = [*pairs[1 - _MEMORY :], (moved - control, new - gradient)]
        control, gradient, before, value = moved, new, value, energy.value(moved)
        if before - value < 1e-12 * value:
            break
    return control


def _two_loops(gradient: np.ndarray, pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    direction, kept = gradient.copy(), []
    for moved, change in reversed(pairs):
        rho = 1 / (moved * change).sum()
        alpha = rho * (moved * direction).sum()
        direction -= alpha * change
        kept.append((rho, alpha))
    if pairs:
        moved, change = pairs[-1]
        direction *= (moved * change).sum() / (change * change).sum()
    for (moved, change), (rho, alpha) in zip(pairs, reversed(kept)):
        direction += moved * (alpha - rho * (change * direction).sum())
    return direction


def subdivided(control: np.ndarray) -> np.ndarray:
    """The same curve with twice as many control points."""
    before, after = np.roll(control, 1, axis=0), np.roll(control, -1, axis=0)
    return np.stack([(before + 6 * control + after) / 8, (control + after) / 2], 1).reshape(-1, 2)


def circle(ratio: float, n: int = 4) -> np.ndarray:
    """Control points (n, 2) whose curve passes through n points of the circle of radius `ratio` about (1, 0)."""
    angle = 2 * math.pi * np.arange(n) / n
    radius = ratio * 3 / (2 + math.cos(2 * math.pi / n))
    return np.stack([1 + radius * np.cos(angle), radius * np.sin(angle)], 1)


def run(ratio: float, points: int, levels: int) -> dict[str, float | str]:
    """Level by level from a round torus, as far as the rule still sees a surface; the energy by the rule after each
    level and by a fine rule at the end, and where it went."""
    control, values = circle(ratio), []
    while len(values) < levels:
        energy = Profile(len(control), points)
        control = minimize(energy, control)
        values.append(energy.value(control))
        if len(values) < levels and math.isfinite(Profile(2 * len(control), points).value(subdivided(control))):
            control = subdivided(control)
        else:
            break
    fine = Profile(len(control), _FINE)
    value, resolved, gauss = values[-1], fine.value(control), fine.gauss(control)
    went = "Clifford torus" if abs(resolved / CLIFFORD - 1) < 0.01 else "hole in the rule"
    return {
        "ratio": ratio, "points": points, "value": value, "levels": values,
        "resolved": resolved if math.isfinite(resolved) else None,
        "gauss_bonnet_defect": abs(gauss) if math.isfinite(gauss) else None, "went": went,
        "profile": control.tolist(),
    }  # fmt: skip


def scan(store: Store, item: Item) -> list[dict[str, float | str]]:
    """Every ratio by every rule."""
    return [run(ratio, points, item.inputs["levels"]) for points in RULES for ratio in RATIOS]

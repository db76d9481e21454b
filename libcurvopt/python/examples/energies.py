# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of a cage and their gradient: a torus that is nearly the Clifford torus."""

# %% A cage: 48 x 32 points of the torus of radii 1 and 1/sqrt(2), as positions (n, 3) and faces.
import numpy as np

import curvopt

around, across, ratio = 48, 32, np.sqrt(0.5)
u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
points = np.stack([(1 + ratio * np.cos(v)) * np.cos(u), (1 + ratio * np.cos(v)) * np.sin(u), ratio * np.sin(v)], -1)
index = np.arange(around * across).reshape(around, across)
faces = np.stack([index, np.roll(index, -1, 0), np.roll(index, (-1, -1), (0, 1)), np.roll(index, -1, 1)], -1)
torus = curvopt.cage(points.reshape(-1, 3), faces.reshape(-1, 4))

# %% All energies at once, each with an estimate of its quadrature error. The Clifford torus has int H^2 dA = 2 pi^2.
found = curvopt.energies(torus)
print(f"int H^2 dA {found.h2:.5f} (Clifford torus {2 * np.pi**2:.5f})   int K dA {found.gauss:.1e}   area {found.area:.4f}")
print({name: round(value, 4) for name, value in found.terms.items()}, f"error {found.objective_error:.1e}")

# %% The exact gradient, against a difference quotient: the change when the torus is stretched upwards.
direction, step = torus.positions * (0, 0, 1), 1e-4
with curvopt.Problem(torus, "mvs", tolerance=1e-8) as problem:
    value, gradient = problem.gradient(torus.positions)
    up, down = (problem.gradient(torus.positions + sign * step * direction)[0] for sign in (1, -1))
slope, quotient = float(np.vdot(gradient, direction)), (up - down) / (2 * step)
print(f"slope {slope:.6f}, difference quotient {quotient:.6f}")

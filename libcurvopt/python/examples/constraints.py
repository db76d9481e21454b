# SPDX-License-Identifier: GPL-3.0-or-later
"""Constraints: a bumpy sheet in a held boundary; pins; how much of the shape may go."""

# %% 12 x 12 quads over a square, with bumps inside.
import numpy as np

import curvopt

n = 13
x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
inside = (np.abs(x) < 0.8) & (np.abs(y) < 0.8)
z = 0.15 * inside * np.sin(9 * x) * np.sin(7 * y)
index = np.arange(n * n).reshape(n, n)
faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4)
sheet = curvopt.cage(np.stack([x, y, z], -1), faces)
rim = np.concatenate([index[0], index[-1], index[1:-1, 0], index[1:-1, -1]])

# %% Boundary "position" holds the boundary curves. The bumps go: a plane has no energy.
flat = curvopt.minimize(sheet, "willmore", levels=1, boundary="position")
print(f"Willmore {flat.summary.start.objective:.3f} -> {flat.energies.objective:.1e}, highest point {np.abs(flat.cage.positions[:, 2]).max():.1e}")

# %% Pins hold vertices of the cage; with weights below 1, springs draw them back.
middle = [int(index[n // 2, n // 2])]
raised = sheet.positions.copy()
raised[middle, 2] = 0.5
tent = curvopt.minimize(curvopt.cage(raised, faces), "willmore", levels=1, held=middle)
soft = curvopt.minimize(curvopt.cage(raised, faces), "willmore", levels=1, held=middle, weights=[0.01])
print(f"a pin at height .5 stays at {tent.cage.positions[middle[0], 2]:.3f}, one with weight .01 is at {soft.cage.positions[middle[0], 2]:.3f}")

# %% With limit_points the surface goes through its own points there, and the vertices move as that needs.
through = curvopt.minimize(curvopt.cage(raised, faces), "willmore", levels=1, held=middle, limit_points=True)
before = (16 * 0.5) / 36  # of the surface in the middle: the vertex counts 16/36 there, its neighbours are at height 0
vertex = through.cage.positions[middle[0], 2]
print(f"the surface stays at height {before:.3f} in the middle, with the vertex at {vertex:.3f}")

# %% Places are where held vertices or limit points are to be: the sheet goes through a point above its middle.
above = curvopt.minimize(sheet, "willmore", levels=1, held=middle, limit_points=True, places=[[0, 0, 0.3]])
print(f"through a point at height .3: highest vertex at {above.cage.positions[:, 2].max():.3f}")

# %% Points of the surface at vertices and inside faces have places, normals and tangents: here one inside a face leans.
leaning = curvopt.Through(face=int(n * n / 3), uv=(0.25, 0.5), at="here", normal=[0.3, 0, 1])
with curvopt.Sampler(curvopt.minimize(sheet, "willmore", levels=1, through=[leaning]).cage) as surface:
    _, normal, _, _ = surface.curvatures([leaning.face], [0], [leaning.uv])
print(f"normal inside the face, over its height: {normal[0] / normal[0, 2]}")

# %% Strength below 1: short waves go, long ones stay.
heights = {s: float(np.abs(curvopt.minimize(sheet, levels=1, strength=s).cage.positions[:, 2]).max()) for s in (0.1, 0.3, 0.5, 0.7)}
print("highest point by strength:", {s: round(height, 4) for s, height in heights.items()})

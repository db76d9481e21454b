# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of the surface with normals and curvatures, as a table: python3 sampler.py [OUT.csv]"""

# %% A surface: the minimizer of Willmore's energy that a cube leads to, nearly a sphere.
import sys

import numpy as np

import curvopt

corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
cube = curvopt.cage(corners, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
ball = curvopt.minimize(cube, levels=4).cage

# %% Gauss points of every quad, which avoid the extraordinary vertices.
nodes, node_weights = np.polynomial.legendre.leggauss(4)
s, t = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2)
one = np.stack([s.ravel(), t.ravel()], -1)
face = np.repeat(np.arange(len(ball.face_sizes)), len(one))
uv = np.tile(one, (len(ball.face_sizes), 1))

# %% Points, normals, mean and Gauss curvature. Two integrals by hand: int K dA = 4 pi, and the area.
with curvopt.Sampler(ball) as surface:
    point, normal, mean, gauss = surface.curvatures(face, np.zeros_like(face), uv)
    jets = surface.jets(face, np.zeros_like(face), uv)
weight = np.tile(np.outer(node_weights, node_weights).ravel() / 4, len(ball.face_sizes))
area_element = weight * np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1)
radius = np.linalg.norm(point - point.mean(0), axis=1)
total_gauss, area = float(gauss @ area_element), float(area_element.sum())
print(f"{len(point)} points, radius {radius.min():.4f} .. {radius.max():.4f}, H R {(mean * radius).min():.3f} .. {(mean * radius).max():.3f}")
print(f"int K dA {total_gauss:.6f} (4 pi is {4 * np.pi:.6f}), area {area:.5f}")

# %% Out, for any program.
if len(sys.argv) > 1:
    table = np.column_stack([point, normal, mean, gauss])
    np.savetxt(sys.argv[1], table, delimiter=",", header="x,y,z,nx,ny,nz,mean,gauss", comments="")

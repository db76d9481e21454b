# SPDX-License-Identifier: GPL-3.0-or-later
"""Small cages as plain arrays: positions (n, 3), faces a list of index lists, counter-clockwise seen from outside."""

import numpy as np


def torus(
    around: int = 8, across: int = 4, major: float = 1.0, minor: float = 0.5
) -> tuple[np.ndarray, list[list[int]]]:
    """A grid of around x across quads."""
    u, v = np.meshgrid(np.arange(around) / around, np.arange(across) / across, indexing="ij")
    u, v = 2 * np.pi * u, 2 * np.pi * v
    radius = major + minor * np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), minor * np.sin(v)], -1).reshape(-1, 3)

    def index(i: int, j: int) -> int:
        return i % around * across + j % across

    faces = [
        [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]
        for i in range(around)
        for j in range(across)
    ]
    return points, faces


def cube() -> tuple[np.ndarray, list[list[int]]]:
    """The cube of edge length 2."""
    points = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    return points, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def quad_sphere(n: int = 4) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices on the unit sphere, (6 n^2 + 2, 3), and quads: n x n on each side of a cube."""
    faces, at = [], {}
    for axis in range(3):
        for side in (-n, n):
            for i in range(-n, n, 2):
                for j in range(-n, n, 2):
                    square = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)][:: 1 if side > 0 else -1]
                    corners = [tuple(np.roll([side, *uv], axis)) for uv in square]
                    faces.append([at.setdefault(corner, len(at)) for corner in corners])
    points = np.array(list(at), float)
    return points / np.linalg.norm(points, axis=1)[:, None], faces


def grid(n: int = 4) -> tuple[np.ndarray, list[list[int]]]:
    """n x n quads, open and waved; vertex y * (n + 1) + x is over (x, y)."""
    points = [(x, y, 0.3 * np.sin(2 * x + y)) for y in range(n + 1) for x in range(n + 1)]
    starts = [y * (n + 1) + x for y in range(n) for x in range(n)]
    return np.array(points, float), [[i, i + 1, i + n + 2, i + n + 1] for i in starts]


def dome(n: int = 16, rings: int = 4, bunched: float = 0.8) -> tuple[np.ndarray, list[list[int]]]:
    """A dome over a wavy boundary of n vertices, bunched on one side; its top, then rings, the last one the boundary."""
    angle = 2 * np.pi * np.arange(n) / n
    angles = np.tile(angle + bunched * np.sin(angle), rings)
    radius = np.repeat(np.arange(1, rings + 1) / rings, n)
    height = 0.6 * (1 - radius**2) + 0.3 * radius**2 * np.cos(2 * angles)
    points = np.stack([radius * np.cos(angles), radius * np.sin(angles), height], -1)
    first = [[1 + i, 1 + (i + 1) % n] for i in range(n)]
    faces = [[0, *first[i], first[i + 1][1]] for i in range(0, n, 2)]
    faces += [[a + r * n, a + (r + 1) * n, b + (r + 1) * n, b + r * n] for r in range(rings - 1) for a, b in first]
    return np.vstack([[(0, 0, 0.6)], points]), faces


def prism() -> tuple[np.ndarray, list[list[int]]]:
    """Two triangles and three quads."""
    points = [(0, 0, 0), (2, 0, 0), (1, 2, 0), (0, 0, 2), (2, 0, 2.5), (1, 2, 2)]
    return np.array(points, float), [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]


def packed(faces: list[list[int]]) -> tuple[list[int], list[int]]:
    """(face sizes, face vertices)."""
    return [len(face) for face in faces], [vertex for face in faces for vertex in face]


def enclosed_volume(points: np.ndarray, faces: list[list[int]]) -> float:
    """Positive if the faces are counter-clockwise seen from outside."""
    points = np.asarray(points)
    triangles = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    return float(np.linalg.det(points[triangles]).sum() / 6)


# Radius and height of each ring, from the bottom to the edge of the mouth.
BOTTLE = (
    (0.55, 0.02), (0.9, 0.05), (1, 0.3), (1, 0.8), (1, 1.3), (1, 1.8), (0.95, 2.2), (0.75, 2.55), (0.45, 2.8),
    (0.35, 3.1), (0.35, 3.4), (0.35, 3.7), (0.42, 3.8), (0.42, 3.95), (0.3, 4.0),
)  # fmt: skip
BOTTLE_LIP = 12, 13  # rings


def bottle(noise: float = 0.04, sides: int = 16) -> tuple[np.ndarray, list[list[int]]]:
    """A bottle with a neck and a lip, bumpy by noise of that standard deviation; rings of vertices from the bottom
    upwards, and a polygon at either end."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), np.full(sides, z)], -1) for r, z in BOTTLE]
    points = np.concatenate(rings)
    faces = [
        [sides * k + i, sides * k + (i + 1) % sides, sides * (k + 1) + (i + 1) % sides, sides * (k + 1) + i]
        for k in range(len(BOTTLE) - 1)
        for i in range(sides)
    ]
    last = len(points) - sides
    faces += [list(range(sides))[::-1], list(range(last, last + sides))]
    return points + noise * np.random.default_rng(83).normal(size=points.shape), faces

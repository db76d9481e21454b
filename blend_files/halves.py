#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Halves of cages, each with the axis across which a Mirror modifier completes it; without Blender.

A half is (vertices (n, 3) float64, faces as tuples of indices), counter-clockwise seen from outside; its seam lies on the
plane through the origin exactly. HALVES names them; make_blends.py turns them into .blend files. They have no OBJ twins:
the Add menu offers whole cages.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cages import polycube
from frames import Cage


def half_mug() -> Cage:
    """A mug, a handle on one side, cut along the handle (y = 0): sixteen columns, the inner four hollow, made round."""
    body = {(i, j, k) for i in range(4) for j in range(4) for k in range(4) if k == 0 or not {i, j} <= {1, 2}}
    handle = {(i, j, k) for j in (1, 2) for i, k in ((4, 1), (5, 1), (5, 2), (4, 3), (5, 3))}
    vertices, faces = polycube(body | handle)
    x, y, z = (vertices - [2, 2, 0]).T
    square = np.maximum(np.abs(x), np.abs(y))
    reach = np.hypot(x, y)
    round_off = np.where(reach > 0, square / np.where(reach > 0, reach, 1), 1.0)
    wall = np.where(square > 1, 0.6, 0.85)
    on_body = x < 2.5
    outward = np.where(on_body, x * round_off * wall, 1.2 + 0.4 * (x - 2))
    across = np.where(on_body, y * round_off * wall, 0.3 * y)
    flare = np.where(on_body, 1 + 0.05 * (z - 2), 1.0)
    height = 0.7 * z - 0.2 * (on_body & (z == 1) & (square < 2))
    return kept((np.stack([outward * flare, across * flare, height], axis=1), faces), 1)


def half_face() -> Cage:
    """A head with a nose, holes for the eyes and an open neck, cut along x = 0; it looks along -y."""
    vertices, faces = polycube({(i, j, k) for i in range(4) for j in range(3) for k in range(5)})
    centre = vertices - [2, 1.5, 2.5]
    middles = [centre[list(face)].mean(axis=0) for face in faces]
    eyes = [bool(m[1] == -1.5 and abs(m[0]) == 1.5 and m[2] == 1) for m in middles]
    neck = [bool(m[2] == -2.5 and abs(m[0]) < 1 and abs(m[1]) < 1) for m in middles]
    faces = [face for face, eye, open_below in zip(faces, eyes, neck) if not (eye or open_below)]
    x, y, z = centre.T
    ball = centre / [2, 1.5, 2.5]
    ball = ball * (np.abs(ball).max(axis=1) / np.linalg.norm(ball, axis=1))[:, None]
    x, y, z = (ball * [0.85, 1.0, 1.25]).T + 0.12 * (centre / [2, 1.5, 2.5] * [0.85, 1.0, 1.25]).T
    nose = (centre[:, 1] == -1.5) & (centre[:, 0] == 0) & (centre[:, 2] == -0.5)
    lips = (centre[:, 1] == -1.5) & (np.abs(centre[:, 0]) <= 1) & (centre[:, 2] == -1.5)
    y = y - 0.35 * nose - 0.06 * lips
    return kept((np.stack([x, y, z], axis=1), faces), 0)


def kept(cage: Cage, axis: int) -> Cage:
    """The faces of a cage where the coordinate along `axis` is not negative, and their vertices."""
    vertices, faces = cage
    here = [face for face in faces if (vertices[list(face), axis] >= -1e-12).all()]
    used = sorted({vertex for face in here for vertex in face})
    number = {vertex: i for i, vertex in enumerate(used)}
    positions = vertices[used] + 0.0
    positions[np.abs(positions) < 1e-12] = 0.0
    return positions, [tuple(number[vertex] for vertex in face) for face in here]


@dataclass(frozen=True)
class HalfEntry:
    """A half: its title, what makes it, and the axis, 0 .. 2, that its Mirror modifier has."""

    title: str
    make: Callable[[], Cage]
    axis: int


HALVES = {
    "half_mug": HalfEntry("Half a mug under a Mirror modifier", half_mug, 1),
    "half_face": HalfEntry("Half a face under a Mirror modifier", half_face, 0),
}

#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Halves of cages, each with the axis across which a Mirror modifier completes it; without Blender.

A half is (vertices (n, 3) float64, faces as tuples of indices), counter-clockwise seen from outside; its seam lies on
the plane through the origin exactly. HALVES names them; make_blends.py turns them into .blend files. They have no OBJ
twins: the Add menu offers whole cages.
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
    """A head with a nose, lips, holes for the eyes and an open neck, cut along x = 0; it looks along -y."""
    cells = {(i, j, k) for i in range(6) for j in range(4) for k in range(7)}
    vertices, faces = polycube(cells)
    centre = vertices - [3, 2, 3.5]
    middles = np.array([centre[list(face)].mean(axis=0) for face in faces])
    eye = (middles[:, 1] == -2) & (np.abs(middles[:, 0]) == 1.5) & (middles[:, 2] == 1)
    neck = (middles[:, 2] == -3.5) & (np.abs(middles[:, 0]) < 2) & (middles[:, 1] > -1)
    faces = [face for face, hole in zip(faces, eye | neck) if not hole]
    unit = centre / [3, 2, 3.5]
    ball = unit * (np.abs(unit).max(axis=1) / np.linalg.norm(unit, axis=1))[:, None]
    x, y, z = ((0.75 * ball + 0.25 * unit) * [0.8, 0.95, 1.2]).T
    front, aside, height = centre[:, 1] == -2, np.abs(centre[:, 0]), centre[:, 2]
    nose = front * (aside == 0) * np.select([height == 0.5, height == -0.5], [0.22, 0.42], 0.0)
    wing = front * (aside == 1) * (height == -0.5) * 0.1
    lips = front * (aside <= 1) * np.select([height == -1.5, height == -2.5], [0.1, 0.06], 0.0)
    brow = front * (aside >= 1) * (aside <= 2) * (height == 1.5) * 0.08
    socket = front * (aside >= 1) * (aside <= 2) * (height == 0.5) * -0.04
    return kept((np.stack([x, y - nose - wing - lips - brow - socket, z], axis=1), faces), 0)


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

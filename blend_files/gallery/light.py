# SPDX-License-Identifier: GPL-3.0-or-later
"""The studio's light on dense shapes, without grain: what every point sees of a bright sky and of two wide lamps is
summed over fixed directions, by a depth map each (Williams 1978), instead of drawn by lot. No bpy.

Directions are the camera's: right, up, towards it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .dense import Dense


@dataclass(frozen=True)
class Lamp:
    """A round patch of the sky: its middle, its half angle in degrees, its colour, and in how many directions it is
    sampled."""

    middle: tuple[float, float, float]
    half_angle: float
    colour: tuple[float, float, float]
    count: int


KEY = Lamp((-0.62, 0.85, 0.72), 16.0, (1.02, 0.98, 0.92), 56)
RIM = Lamp((0.95, 0.05, 0.12), 28.0, (0.20, 0.23, 0.28), 20)
SKY = Lamp((0.15, 0.75, 0.65), 180.0, (0.44, 0.45, 0.47), 144)  # all round: ambient light
GROUND = 0.55  # of the sky's light comes from straight below
_GLOSS, _SHARPNESS = 0.30, 42.0  # of the key lamp's reflection (Blinn 1977)
_SHEEN = 0.10  # at grazing angles
_BIN = 3.0  # of the mean distance of points: the width of a depth map's cell
_STEEPEST = 4.0  # tangent of the angle up to which a surface does not shade itself
_ROUNDS = 6  # of smoothing what is seen, over a quad each


def shaded(shape: Dense, colour: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Linear colours (n, 3) of a shape's points as seen on the side of its normals, and on the other; `colour` (3,) or
    (n, 3) is its own, `axes` (3, 3) has the camera's directions as columns."""
    sides = (shape.normals, -shape.normals)
    light = [np.zeros((len(shape.points), 3)) for _ in sides]
    key = np.zeros(len(shape.points))
    rng = np.random.default_rng(0)
    for lamp in (SKY, KEY, RIM):
        for direction, share in directions(lamp):
            sky = np.array(lamp.colour) * (_sky(direction) if lamp is SKY else 1.0)
            toward = axes @ direction
            seen = share * visible(shape, toward, rng.random(2))
            facing = _along(shape.normals, toward)
            for side, turned in enumerate((facing, -facing)):
                light[side] += (seen * np.maximum(turned, 0.0))[:, None] * sky
            if lamp is KEY:
                key += seen
    smooth = _smoothed(shape, np.concatenate([*light, key[:, None]], 1))
    return tuple(
        np.clip(np.asarray(colour) * smooth[:, 3 * side : 3 * side + 3] + _shine(normals, smooth[:, 6], axes), 0.0, 1.0)
        for side, normals in enumerate(sides)
    )


def _smoothed(shape: Dense, values: np.ndarray) -> np.ndarray:
    """Values (n, k) of the points averaged over the quads round each, several times: cells of the depth maps do not
    show. Points in the same place and with the same normal are one, so edges of the cage's faces do not show either."""
    size = np.sqrt(shape.areas.sum())
    key = np.concatenate([shape.points / (1e-5 * size), shape.normals / 1e-2], 1).round().astype(np.int64)
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    group, count = group.ravel(), len(first)
    corners = group[shape.quads]
    around = np.bincount(corners.ravel(), minlength=count)
    found = values[first]
    for _ in range(_ROUNDS):
        means = np.repeat(found[corners].mean(1), 4, axis=0)
        sums = [np.bincount(corners.ravel(), mean, count) for mean in means.T]
        found = np.stack(sums, 1) / around[:, None]
    return found[group]


def _sky(direction: np.ndarray) -> float:
    """How bright the sky is in a direction: less from below. Times 2: half of it a surface does not face."""
    return 2.0 * (GROUND + (1 - GROUND) * (0.5 + 0.5 * float(direction[1])))


def _shine(normals: np.ndarray, seen: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Reflections of the key lamp, and a sheen where the surface turns away from the camera."""
    toward_camera = axes[:, 2]
    middle = axes @ _unit(KEY.middle) + toward_camera
    spot = np.maximum(_along(normals, middle / np.linalg.norm(middle)), 0.0) ** _SHARPNESS
    turned = (1.0 - np.maximum(_along(normals, toward_camera), 0.0)) ** 4
    return (_GLOSS * spot * seen)[:, None] * np.array(KEY.colour) + (_SHEEN * turned * (0.3 + 0.7 * seen))[:, None]


def directions(lamp: Lamp) -> Iterator[tuple[np.ndarray, float]]:
    """Unit vectors (3,) spread evenly over a lamp (a spiral of golden angles), and the share of each."""
    middle = _unit(lamp.middle)
    across = _unit(np.cross(middle, (0.0, 0.0, 1.0) if abs(middle[2]) < 0.9 else (1.0, 0.0, 0.0)))
    frame = np.stack([across, np.cross(middle, across), middle], 1)
    low = np.cos(np.radians(lamp.half_angle))
    height = 1.0 - (1.0 - low) * (np.arange(lamp.count) + 0.5) / lamp.count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(lamp.count)
    flat = np.sqrt(np.maximum(0.0, 1.0 - height**2))
    for vector in np.stack([flat * np.cos(turn), flat * np.sin(turn), height], 1):
        yield frame @ vector, 1.0 / lamp.count


def _along(vectors: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Products (n,) of vectors (n, 3) with one. Without BLAS, whose threads wait for each other on a busy machine."""
    return vectors[:, 0] * direction[0] + vectors[:, 1] * direction[1] + vectors[:, 2] * direction[2]


def _unit(vector: object) -> np.ndarray:
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def visible(shape: Dense, toward: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """How far (n,), 0 to 1, each point sees a light that is far away `toward` (3,): what lies higher in the same cell of
    a depth map shades it. `offset` (2,) in [0, 1) moves the cells."""
    width = _BIN * np.sqrt(shape.areas.sum() / len(shape.points))
    across = _unit(np.cross(toward, (0.0, 0.0, 1.0) if abs(toward[2]) < 0.9 else (1.0, 0.0, 0.0)))
    plane = np.stack([_along(shape.points, axis) for axis in (across, np.cross(toward, across))], 1)
    cell = np.floor((plane - plane.min(0)) / width + offset).astype(np.int64)
    index = cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1]
    height = _along(shape.points, toward)
    highest = np.full(index.max() + 1, -np.inf)
    order = np.argsort(height)
    highest[index[order]] = height[order]  # of several the last, so the highest, stays
    cosine = np.abs(_along(shape.normals, toward))
    slope = np.minimum(np.sqrt(1 - np.minimum(cosine, 1) ** 2) / np.maximum(cosine, 1e-9), _STEEPEST)
    own = width * (0.6 + 1.4 * slope)  # by so much a smooth surface itself is higher in its cell
    return np.clip(1.0 + (own - (highest[index] - height)) / width, 0.0, 1.0)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages as artists have them, bumpy from modelling by hand or from a scan: what a first press of *Minimize* is for. No
bpy. Faces are counter-clockwise seen from outside."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from addon.binding.values import Cage

_HALVES = Path(__file__).resolve().parents[1] / "halves.py"
_BOTTLE = (  # radius and height of rings, from the bottom to the lip
    (0.35, 0.0), (0.66, 0.0), (0.78, 0.12), (0.80, 0.45), (0.80, 0.85), (0.80, 1.25), (0.76, 1.60), (0.55, 1.90),
    (0.33, 2.12), (0.27, 2.40), (0.27, 2.72), (0.34, 2.78), (0.34, 2.90), (0.16, 2.93),
)  # fmt: skip
_FENDER = (15, 10)  # vertices along a car, and from the bonnet down to the sill
_CREATURE = (  # boxes of unit cubes, first and last in x, y and z: body, legs, neck, head, muzzle, ears, tail
    ((0, 5), (0, 2), (3, 4)), ((0, 0), (0, 0), (0, 2)), ((0, 0), (2, 2), (0, 2)), ((4, 4), (0, 0), (0, 2)),
    ((4, 4), (2, 2), (0, 2)), ((5, 5), (1, 1), (5, 5)), ((5, 7), (0, 2), (6, 7)), ((8, 8), (1, 1), (6, 6)),
    ((5, 5), (0, 0), (8, 8)), ((5, 5), (2, 2), (8, 8)), ((-2, -1), (1, 1), (4, 4)), ((-2, -2), (1, 1), (5, 6)),
)  # fmt: skip


def bottle(sides: int = 16) -> Cage:
    """A closed bottle with neck and lip."""
    angle = 2 * np.pi * np.arange(sides) / sides
    points = np.concatenate([np.stack([r * np.cos(angle), r * np.sin(angle), np.full(sides, z)], 1) for r, z in _BOTTLE])
    side = [
        (sides * k + i, sides * k + (i + 1) % sides, sides * (k + 1) + (i + 1) % sides, sides * (k + 1) + i)
        for k in range(len(_BOTTLE) - 1)
        for i in range(sides)
    ]
    last = len(points) - sides
    return _cage(points, [*side, tuple(range(sides))[::-1], tuple(range(last, last + sides))], 0.030)


def mug() -> Cage:
    """A mug with a handle: the half under a Mirror modifier that is in blend_files, whole."""
    return _whole("half_mug", 1, 0.060)


def face() -> Cage:
    """A head with nose, lips and holes for the eyes, likewise."""
    return _whole("half_face", 0, 0.032)


def fender() -> Cage:
    """A car's front fender, an open sheet: bulging over the wheel, rolled in at the top and with an arch below."""
    along, down = (np.linspace(-1, 1, n) for n in _FENDER)
    u, v = np.meshgrid(along, down, indexing="ij")
    arch = 0.55 * np.exp(-((u / 0.55) ** 2))  # by so much the lower edge is higher over the wheel
    height = 0.75 - (v + 1) / 2 * (1.25 - arch) - 0.12 * u**2
    outward = 0.42 * np.sin(np.pi * (v + 1) / 3) + 0.16 * np.exp(-((u / 0.7) ** 2) - ((v - 0.5) / 0.5) ** 2) - 0.18 * u**2
    points = np.stack([1.6 * u, -outward, height], -1).reshape(-1, 3)
    rows, columns = _FENDER
    faces = [
        (columns * i + j, columns * i + j + 1, columns * (i + 1) + j + 1, columns * (i + 1) + j)
        for i in range(rows - 1)
        for j in range(columns - 1)
    ]
    inner = np.zeros(_FENDER, bool)
    inner[2:-2, 2:-2] = True  # the edges are clean: the run keeps them
    return _cage(points, faces, 0.022, inner.ravel())


def creature(rounds: int = 2) -> Cage:
    """An animal on four legs, extruded from cubes: what bounds these, its vertices drawn to the middle of their
    neighbours."""
    cubes = {
        (x, y, z)
        for (x0, x1), (y0, y1), (z0, z1) in _CREATURE
        for x in range(x0, x1 + 1)
        for y in range(y0, y1 + 1)
        for z in range(z0, z1 + 1)
    }
    number: dict[tuple[int, int, int], int] = {}
    faces: list[tuple[int, ...]] = []
    for cube in sorted(cubes):
        for axis in range(3):
            for side in (0, 1):
                if tuple(c + (2 * side - 1) * (k == axis) for k, c in enumerate(cube)) not in cubes:
                    faces.append(_side(cube, axis, side, number))
    points = np.array(list(number), float)
    edges = np.unique(np.sort([(face[k - 1], face[k]) for face in faces for k in range(4)], axis=1), axis=0)
    degree = np.bincount(edges.ravel())[:, None]
    for _ in range(rounds):
        sums = np.zeros_like(points)
        np.add.at(sums, edges, points[edges[:, ::-1]])
        points = (points + sums / degree) / 2
    return _cage(0.3 * points, faces, 0.035)


def _side(cube: tuple[int, int, int], axis: int, side: int, number: dict[tuple[int, int, int], int]) -> tuple[int, ...]:
    """A face of a cube, by numbers of its corners, which are made where there are none."""
    square = ((0, 0), (1, 0), (1, 1), (0, 1)) if side else ((0, 0), (0, 1), (1, 1), (1, 0))
    corners = []
    for pair in square:
        corner = list(cube)
        corner[axis] += side
        corner[(axis + 1) % 3] += pair[0]
        corner[(axis + 2) % 3] += pair[1]
        corners.append(number.setdefault((corner[0], corner[1], corner[2]), len(number)))
    return tuple(corners)


def _cage(points: np.ndarray, faces: list[tuple[int, ...]], bumps: float, moved: np.ndarray | None = None) -> Cage:
    """A cage with bumps of that standard deviation, at the vertices that are `moved` (all)."""
    noise = bumps * np.random.default_rng(46).standard_normal(points.shape)
    if moved is not None:
        noise[~moved] = 0.0
    corners = np.concatenate([np.array(face, np.int32) for face in faces])
    return Cage(points + noise, np.array([len(face) for face in faces], np.int32), corners)


def _whole(name: str, axis: int, bumps: float) -> Cage:
    """A half of halves.py and its image across the plane of an axis, joined along the seam."""
    points, faces = _halves()[name].make()
    seam = np.abs(points[:, axis]) < 1e-9
    number = np.where(seam, np.arange(len(points)), len(points) + np.cumsum(~seam) - 1)
    image = points[~seam] * np.where(np.arange(3) == axis, -1.0, 1.0)
    mirrored = [tuple(int(number[vertex]) for vertex in face[::-1]) for face in faces]
    return _cage(np.concatenate([points, image]), [*faces, *mirrored], bumps)


def _halves() -> Mapping[str, object]:
    sys.path[:0] = [str(_HALVES.parent)] if str(_HALVES.parent) not in sys.path else []
    spec = importlib.util.spec_from_file_location("curvopt_halves", _HALVES)
    sys.modules["curvopt_halves"] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.HALVES


CAGES: Mapping[str, Callable[[], Cage]] = {
    "bottle": bottle, "mug": mug, "face": face, "fender": fender, "creature": creature,
}  # fmt: skip
STRENGTHS: Mapping[str, float] = {  # the panel begins at 0.3
    "bottle": 0.3, "mug": 0.5, "face": 0.5, "fender": 0.3, "creature": 0.4,
}  # fmt: skip

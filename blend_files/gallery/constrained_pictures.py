# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of minimizers that have to do something: shapes of one area that enclose less and less, and a vase through
rings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from addon.core.energy import ENERGY_LABELS, number_text
from addon.render import studio
from . import constrained, light, pictures, png
from . import dense as dense_shapes
from .dense import Dense, centre_and_size, dense
from .png import write_png
from .store import Item, Store

USES = (constrained, pictures, light, dense_shapes, png, studio)  # (`store`)
_QUADS = 40_000
_FROM_ABOVE = np.array([-0.40, -0.62, 0.68]) / np.linalg.norm([-0.40, -0.62, 0.68])
_FROM_THE_SIDE = np.array([-0.42, -0.86, 0.28]) / np.linalg.norm([-0.42, -0.86, 0.28])
_WIRE, _SIDES = 0.014, 10  # a ring's tube: its radius in sizes of the surface, and its sides
_INK = (0.05, 0.05, 0.06)


def draw_vesicles(store: Store, item: Item) -> dict[str, object]:
    """The surfaces of the item's needs in a row, all of one area."""
    cells = []
    for need in item.needs:
        record = store.result(need)
        kind = constrained.VESICLES[need.split(".")[1]].kind
        lines = (f"{kind}, volume {record['volume']:.2f}", f"int H² {record['h2']:.4f}", pictures.left_open(record), record["verdict"])
        cells.append(pictures.Cell(_of_one_area(dense(store.cage(need), "limit", _QUADS)), pictures.COLOURS["willmore"], lines))
    store.write(item.files[0], write_png(pictures.row_pixels(store, item, cells, _FROM_ABOVE)))
    return {"view": _FROM_ABOVE.tolist()}


def draw_rings(store: Store, item: Item) -> dict[str, object]:
    """The vase's cage and what becomes of it, with the rings."""
    (cage,) = item.cages.values()
    first = dense(cage, "limit", _QUADS)
    centre, size = centre_and_size(first)
    wires = [_tube((ring - centre) / size, _WIRE) for ring in constrained.rings()]
    shown = [(first, pictures.COLOURS["input"], ("the cage's surface", "five rings"))]
    for need in item.needs:
        record, energy = store.result(need), need.split(".")[1]
        words = f"{ENERGY_LABELS[energy]} {number_text(record['value'])}"
        shown.append((dense(store.cage(need), "limit", _QUADS), pictures.COLOURS[energy], (words, pictures.left_open(record), record["verdict"])))
    cells = [_with_wires(replace(shape, points=(shape.points - centre) / size), colour, wires, lines)
             for shape, colour, lines in shown]  # fmt: skip
    store.write(item.files[0], write_png(pictures.row_pixels(store, item, cells, _FROM_THE_SIDE)))
    return {"view": _FROM_THE_SIDE.tolist()}


def _of_one_area(shape: Dense) -> Dense:
    """The shape round the origin, of the area of the unit sphere."""
    centre, _ = centre_and_size(shape)
    scale = math.sqrt(4 * math.pi / shape.areas.sum())
    return replace(shape, points=scale * (shape.points - centre))


def _with_wires(
    shape: Dense, colour: Sequence[float], wires: Sequence[Dense], lines: tuple[str, ...]
) -> pictures.Cell:
    """A surface and wires as one shape, coloured by point."""
    parts = [shape, *wires]
    first = np.cumsum([0, *(len(part.points) for part in parts)])
    quads = np.concatenate([part.quads + start for part, start in zip(parts, first)])
    joined = Dense(*(np.concatenate([getattr(part, field) for part in parts]) for field in _BY_POINT), quads)
    colours = np.tile(np.array(_INK), (len(joined.points), 1))
    colours[: first[1]] = colour
    return pictures.Cell(joined, tuple(colour), lines, colours)


_BY_POINT = ("points", "normals", "mean", "gauss", "areas")


def _tube(line: np.ndarray, radius: float) -> Dense:
    """A thin tube round a closed polygon (n, 3) that is nearly a circle."""
    n, middle = len(line), line.mean(0)
    along = np.roll(line, -1, 0) - np.roll(line, 1, 0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    outward = line - middle
    outward -= (outward * along).sum(1)[:, None] * along
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    across = np.cross(along, outward)
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    normals = outward[:, None] * np.cos(angle)[:, None] - across[:, None] * np.sin(angle)[:, None]
    points = line[:, None] + radius * normals
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(_SIDES), indexing="ij"))
    following, beside = (i + 1) % n, (j + 1) % _SIDES
    quads = np.stack([_SIDES * i + j, _SIDES * following + j, _SIDES * following + beside, _SIDES * i + beside], 1)
    none = np.zeros(n * _SIDES)
    return Dense(points.reshape(-1, 3), normals.reshape(-1, 3), none, none, none, quads)


DRAW = {"vesicles": draw_vesicles, "rings": draw_rings}

# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of minimizers with more holes: what settles, and what is pinching."""

from __future__ import annotations

from addon.render import studio
from . import contents, light, pictures, png
from . import dense as dense_shapes
from .dense import dense
from .png import write_png
from .store import Item, Store

USES = (pictures, light, dense_shapes, png, studio)  # (`store`)
_QUADS = 40_000


def draw_holes(store: Store, item: Item) -> dict[str, object]:
    """One row for each of contents.HOLES, whose minimizers the item needs."""
    rows = []
    for row in contents.HOLES:
        cells = [_cell(store, *entry) for entry in row]
        rows.append(pictures.row_pixels(store, item, cells, studio.view_direction(cells[0].shape.points)))
    store.write(item.files[0], write_png(pictures.stack(rows)))
    return {"rows": len(rows)}


def _cell(store: Store, family: str, cage: str, energy: str, levels: int) -> pictures.Cell:
    name = contents.holes_name(family, cage, energy, levels)
    record = store.result(name)
    lines = (f"{family}: {cage}", *pictures.result_lines(cage, record))
    shape = pictures.unit(dense(store.cage(name), "limit", _QUADS))
    return pictures.Cell(shape, pictures.COLOURS[energy], lines)


DRAW = {"holes": draw_holes}

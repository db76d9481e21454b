# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of pairs: a surface before and after, as clay and as zebra stripes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from addon.core.energy import number_text
from addon.render import studio
from . import dense as dense_shapes
from . import light, pictures, png
from .dense import centre_and_size, dense
from .png import write_below
from .store import Item, Store

USES = (pictures, light, dense_shapes, png, studio)  # (`store`)
_QUADS = 40_000
_BYTES = 1_000_000
_VIEW = np.array([-0.42, -0.80, 0.42]) / np.linalg.norm([-0.42, -0.80, 0.42])


def draw(store: Store, item: Item) -> dict[str, object]:
    """Before and after at one scale; stripes below."""
    (cage,) = item.cages.values()
    (solved,) = item.needs
    record = store.result(solved)
    before = dense(cage, "limit", _QUADS)
    centre, size = centre_and_size(before)  # of the original, for both: the panel's runs stay in place
    shapes = [replace(shape, points=(shape.points - centre) / size)
              for shape in (before, dense(store.cage(solved), "limit", _QUADS))]  # fmt: skip
    lines = (
        (f"before: Willmore {number_text(record['start'])}",),
        (f"after: {number_text(record['value'])}, moved {100 * record['deviation']:.1f} % of the size",),
    )
    cells = [pictures.Cell(shape, pictures.COLOURS["input"], words) for shape, words in zip(shapes, lines)]
    cells[1] = replace(cells[1], colour=(0.80, 0.30, 0.10))
    rows = []
    for look, shown in (("zebra", [replace(cell, lines=()) for cell in cells]), ("clay", cells)):
        rows.append(pictures.row_pixels(store, item, shown, _VIEW, look))
    store.write(item.files[0], write_below(np.concatenate(rows), _BYTES))
    return {"view": _VIEW.tolist()}

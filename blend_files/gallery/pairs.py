# SPDX-License-Identifier: GPL-3.0-or-later
"""Before and after: what Blender's panel makes of a cage, with its figures. No bpy."""

from __future__ import annotations

from addon.core import job
from . import solve
from .store import Item, Store


def minimize(store: Store, item: Item) -> dict[str, object]:
    """An item of inputs `energy`, `levels`, `strength`, of one cage, by the library's own defaults for the rest; keeps
    the result's cage. The figures of `solve.figures`, and how far the surface has moved, `deviation` as a part of the
    size."""
    ((_, cage),) = item.cages.items()
    inputs = item.inputs
    request = job.Request(inputs["energy"], inputs["levels"], {"threads": 1}, strength=inputs["strength"])
    solution = job.solve(cage, request)
    store.save_cage(item.name, solution.cage)
    far = solution.deviation
    return {
        **solve.figures(solution, inputs["energy"], "default"), "strength": inputs["strength"],
        "deviation": far.max / far.size if far is not None else None,
        "before": {name: solve.plain(value) for name, value in solution.start.terms.items()},
    }  # fmt: skip

# SPDX-License-Identifier: GPL-3.0-or-later
"""MVS and MVS_cross of surfaces with more than one hole: from many cages, level by level, is there a least energy, or does
it fall for ever, and towards what? The campaign takes about an hour of two cores; its figures are committed as data/genus.csv
beside this file. No bpy."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from addon.binding.values import Cage
from addon.core import job
from . import dense as dense_shapes
from . import layouts, solve
from .dense import dense
from .store import Item, Store

USES = (dense_shapes, layouts, solve)  # (`store`)
FILE = Path(__file__).with_name("data") / "genus.csv"
FIELDS = (
    "family", "cage", "energy", "symmetry", "symmetry_order", "levels", "vertices", "value", "net_share",
    "quadrature_error", "mvs", "mvs_cross", "h2", "least_radius", "verdict", "seconds",
)  # fmt: skip
_WORDS = ("family", "cage", "energy", "symmetry", "verdict")
_FIRST_LEVEL = 3
_QUADS = 100_000
Row = Mapping[str, object]


def descend(store: Store, item: Item) -> list[dict[str, object]]:
    """Minimizes `energy` (a term or a mix) of one cage of a `family` with `symmetry`, a run of its own for each number of
    levels from three to `levels`, as long as no more than `room` vertices are left that no symmetry takes to each other. A
    row of FIELDS each; none where fewer symmetries are asked for than all, and there are none."""
    ((name, cage),) = item.cages.items()
    inputs, found = item.inputs, []
    if inputs["symmetry"] != solve.SYMMETRY and not _has_symmetry(store, item):
        return []
    for levels in range(_FIRST_LEVEL, inputs["levels"] + 1):
        request = job.Request(inputs["energy"], levels, {"threads": 1}, symmetry=inputs["symmetry"])
        solution = job.solve(cage, request)
        found.append(row_of(solution, inputs["family"], name, request))
        if 4 * found[-1]["vertices"] / solution.symmetry_order > inputs["room"]:
            break
    return found


def _has_symmetry(store: Store, item: Item) -> bool:
    """Whether the same run with all symmetries, which the item needs, had any."""
    return any(row["symmetry_order"] > 1 for row in store.result(item.needs[0]))


def row_of(solution: job.Solution, family: str, cage: str, request: job.Request) -> dict[str, object]:
    """A run's row. `least_radius`: the least radius of curvature anywhere, in radii of the sphere of the same area."""
    end = solution.end
    shape = dense(solution.cage, end.surface, _QUADS)
    steepest = float((np.abs(shape.mean) + np.sqrt(np.maximum(shape.mean**2 - shape.gauss, 0))).max())
    return {
        "family": family, "cage": cage, "energy": request.energy, "symmetry": request.symmetry,
        "symmetry_order": solution.symmetry_order, "levels": request.levels, "vertices": len(solution.cage.positions),
        "value": solve.plain(end.objective), "net_share": solve.plain(solution.discretization_error),
        "quadrature_error": solve.plain(end.objective_error), "mvs": solve.plain(end.terms["mvs"]),
        "mvs_cross": solve.plain(end.terms["mvs_cross"]), "h2": solve.plain(end.h2),
        "least_radius": 1 / (steepest * math.sqrt(end.area / (4 * math.pi))),
        "verdict": solution.verification.verdict, "seconds": round(solution.seconds, 1),
    }  # fmt: skip


def table(store: Store, item: Item) -> int:
    """genus.csv of all runs; their number."""
    rows = [row for need in item.needs for row in store.result(need)]
    store.write(item.files[0], as_csv(rows).encode())
    return len(rows)


def as_csv(rows: Sequence[Row]) -> str:
    """Rows of FIELDS as CSV; numbers to six digits."""
    text = io.StringIO()
    writer = csv.DictWriter(text, FIELDS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})
    return text.getvalue()


def read(text: str) -> list[dict[str, object]]:
    """Rows of as_csv's text; None where a number is not known."""
    return [
        {key: value if key in _WORDS else (float(value) if value else None) for key, value in row.items()}
        for row in csv.DictReader(io.StringIO(text))
    ]


# ------------------------------------------------------------------------------------------------------- the list --

TAG = "genus"  # of the campaign: made when asked for by name, never with the rest
ENERGIES = ("mvs", "mvs_cross")
BENT = (30.0, 10.0, 3.0, 1.0, 0.3)  # weights of Willmore's energy beside MVS
BENT_CAGES = {
    "genus 2": ("eight", "lawson"), "genus 3": ("three in an L", "lawson"),
    "tetrahedral": ("pole hubs, 1 ring",), "cubical": ("pole hubs, 1 ring",),
}  # fmt: skip
_MOST_LEVELS, _ROOM = 6, 7000  # a run of so many vertices takes two minutes
_DEEP = {("genus 2", "eight", "mvs"): (7, 26_000)}  # the lowest of genus 2: a level more, in seven
_LEVELS_OF_FEWER = 4  # where symmetries may go


def items(make: layouts.Make) -> list[Item]:
    """The campaign: each cage of each family, for both energies, with all symmetries and with fewer; some with Willmore's
    energy added; and their table."""
    parts: list[Item] = []
    for family, cages in layouts.families(make).items():
        for name, cage in cages.items():
            for energy in ENERGIES:
                kept = _run(family, name, cage, energy, solve.SYMMETRY, _MOST_LEVELS, ())
                parts += [kept, _run(family, name, cage, energy, "auto", _LEVELS_OF_FEWER, (kept.name,))]
        for name in BENT_CAGES[family]:
            for weight in BENT:
                energy = f"mvs:1,willmore:{weight:g}"
                parts.append(_run(family, name, cages[name], energy, solve.SYMMETRY, _MOST_LEVELS - 1, ()))
    needs = tuple(part.name for part in parts)
    return [*parts, Item("genus.table", table, {}, frozenset({TAG}), needs, ("genus.csv",), cost=0.1)]


def file_name(words: str) -> str:
    """Words as a part of a file's name."""
    return "".join(c if c.isalnum() else "_" for c in words)


def _run(
    family: str, name: str, cage: Cage, energy: str, symmetry: str, levels: int, needs: tuple[str, ...]
) -> Item:
    levels, room = _DEEP.get((family, name, energy), (levels, _ROOM)) if symmetry == solve.SYMMETRY else (levels, _ROOM)
    inputs = {"family": family, "energy": energy, "symmetry": symmetry, "levels": levels, "room": room}
    words = file_name(f"{family}.{name}.{energy}.{symmetry}")
    return Item(f"genus.{words}", descend, inputs, frozenset({TAG}), needs, cages={name: cage}, cost=20.0)

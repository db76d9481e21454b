# SPDX-License-Identifier: GPL-3.0-or-later
"""What the campaign of `genus` found: plots by family, and what may be said of each energy in words. No bpy."""

from __future__ import annotations

from collections.abc import Sequence

from addon.core.energy import ENERGY_LABELS
from . import genus, solve
from .plot import Axis, Series, plot
from .store import Item, Store

USES = (genus,)  # (`store`)
FAMILIES = tuple(genus.BENT_CAGES)
PLOTS = ("mvs", "radius", "mvs_cross")
_SAME = 0.05  # shapes whose int H^2 differs by less are taken for one, if radii differ by less than four times that
_PINCHING = 0.75  # what is left of the least radius after the last level where it is on its way to nothing


def plot_file(family: str, which: str) -> str:
    """Where a family's plot of PLOTS lies in the gallery."""
    return f"pictures/holes.{family.replace(' ', '_')}.{which}.svg"


BENT_FILE = "pictures/holes.bent.svg"
FILES = (*(plot_file(family, which) for family in FAMILIES for which in PLOTS), BENT_FILE)


def draw(store: Store, item: Item) -> dict[str, object]:
    """The plots of the committed figures; what is found of each family and energy, and the finest run of each cage."""
    rows = genus.read(genus.FILE.read_text(encoding="utf-8"))
    for family in FAMILIES:
        for which in PLOTS:
            store.write(plot_file(family, which), _by_vertices(rows, family, which).encode())
    store.write(BENT_FILE, _bent(rows).encode())
    found = [finding(rows, family, energy) for family in FAMILIES for energy in genus.ENERGIES]
    return {"findings": found, "runs": [dict(row) for row in finest(rows)], "fewer": fewer(rows)}


def runs(rows: Sequence[genus.Row], family: str, energy: str, symmetry: str = solve.SYMMETRY) -> dict[str, list[genus.Row]]:
    """By cage: its runs, from few levels to many."""
    found: dict[str, list[genus.Row]] = {}
    for row in rows:
        if (row["family"], row["energy"], row["symmetry"]) == (family, energy, symmetry):
            found.setdefault(str(row["cage"]), []).append(row)
    return {cage: sorted(some, key=lambda row: row["levels"]) for cage, some in found.items()}


def finest(rows: Sequence[genus.Row]) -> list[genus.Row]:
    """The run of most levels of each cage, for both energies."""
    return [
        some[-1] for family in FAMILIES for energy in genus.ENERGIES for some in runs(rows, family, energy).values()
    ]


def is_pinching(some: Sequence[genus.Row]) -> bool:
    """Whether the runs of a cage, by levels, are on their way to necks of no radius: the last level took a good part of the
    least radius and still added to int H^2."""
    if len(some) < 2:
        return False
    before, last = some[-2:]
    return last["least_radius"] < _PINCHING * before["least_radius"] and last["h2"] > (1 + _SAME) * before["h2"]


def is_one_shape(one: genus.Row, other: genus.Row) -> bool:
    """Whether two results are taken for one shape."""
    close = abs(one["h2"] / other["h2"] - 1) < _SAME
    return close and abs(one["least_radius"] / other["least_radius"] - 1) < 4 * _SAME


def finding(rows: Sequence[genus.Row], family: str, energy: str) -> dict[str, object]:
    """What the cages of a family say of an energy: the lowest result, which cages end at its shape (as it is on
    as many levels), which are pinching, and of the rest how far above."""
    by_cage = runs(rows, family, energy)
    last = {cage: some[-1] for cage, some in by_cage.items()}
    lowest = min(last.values(), key=lambda row: row["value"])
    pinching = [cage for cage, some in by_cage.items() if is_pinching(some)]
    beside = {row["levels"]: row for row in by_cage[str(lowest["cage"])]}
    same = [cage for cage, row in last.items() if cage not in pinching and is_one_shape(row, beside.get(row["levels"], lowest))]
    return {
        "family": family, "energy": energy, "cages": len(last), "lowest": dict(lowest), "same": same,
        "pinching": pinching, "highest": max(row["value"] for row in last.values()),
        "lowest_pinching": min((last[cage]["value"] for cage in pinching), default=None),
        "settled": len(last) - len(pinching),
    }  # fmt: skip


def fewer(rows: Sequence[genus.Row]) -> list[dict[str, object]]:
    """For each family and energy, of the cages that have symmetries: how many end lower where these may go, on the same
    level, and by how much at most."""
    found = []
    for family in FAMILIES:
        for energy in genus.ENERGIES:
            kept, free = runs(rows, family, energy), runs(rows, family, energy, "auto")
            parts = []
            for cage, some in free.items():
                level = some[-1]["levels"]
                parts += [some[-1]["value"] / row["value"] for row in kept[cage] if row["levels"] == level]
            gone = sum(part < 1 - 1e-3 for part in parts)
            found.append({"family": family, "energy": energy, "cages": len(parts), "lower": gone,
                          "least": min(parts, default=None)})  # fmt: skip
    return found


def _by_vertices(rows: Sequence[genus.Row], family: str, which: str) -> str:
    energy = "mvs" if which == "radius" else which
    field = "least_radius" if which == "radius" else "value"
    series = [
        Series(cage, [(row["vertices"], row[field]) for row in some], "dashes" if k >= 8 else "line")
        for k, (cage, some) in enumerate(runs(rows, family, energy).items())
    ]
    label = ENERGY_LABELS[energy]
    words, across = (f"Least radius of curvature under {label}", "radius / size") if which == "radius" else (label, label)
    return plot(f"{words}, {family}", Axis("vertices", log=True), Axis(across, log=True), series)


def _bent(rows: Sequence[genus.Row]) -> str:
    """MVS against int H^2 where Willmore's energy is added with less and less weight, on the finest level of each."""
    series = []
    for family, cages in genus.BENT_CAGES.items():
        for cage in cages:
            places = []
            for weight in genus.BENT:
                some = runs(rows, family, f"mvs:1,willmore:{weight:g}")[cage]
                places.append((some[-1]["h2"], some[-1]["mvs"]))
            level = some[-1]["levels"]
            places += [(row["h2"], row["mvs"]) for row in runs(rows, family, "mvs")[cage] if row["levels"] == level]
            series.append(Series(family if len(cages) == 1 else f"{family}: {cage}", places))
    return plot("MVS where bending counts less and less", Axis("∫H²", log=True), Axis("MVS", log=True), series)

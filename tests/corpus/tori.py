# SPDX-License-Identifier: GPL-3.0-or-later
"""Nets of n x m quads on tori of revolution, and which of their results stand out among the neighbours'."""
from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle")]

from ccref import Mesh  # noqa: E402
from nets import torus_cage, write_obj  # noqa: E402
from tables import Runs, is_certified, is_done, shown, table, verdict  # noqa: E402

ALONG, ACROSS = range(5, 15), range(4, 9)
RATIOS = (0.3, 0.5, 0.7, 0.85)  # of the radii
TIMES = 3                       # a neighbour's energy


class Torus(NamedTuple):
    """A net: vertices round the axis, vertices round the tube, and the ratio of the radii in percent."""

    along: int
    across: int
    ratio: int

    @property
    def stem(self) -> str:
        """Of its file's name."""
        return f"torus_{self.along:02d}x{self.across}_{self.ratio}"

    def neighbours(self) -> list["Torus"]:
        """The nets with one vertex more or less round the axis or the tube."""
        return [self._replace(along=self.along + i, across=self.across + j) for i, j in ((-1, 0), (1, 0), (0, -1), (0, 1))]

    @property
    def cage(self) -> Mesh:
        """Its mesh."""
        return torus_cage(self.along, self.across, self.ratio / 100)


NETS = [Torus(n, m, round(100 * ratio)) for ratio in RATIOS for n in ALONG for m in ACROSS]


def write_all(folder: Path) -> list[Path]:
    """The OBJ files of all nets."""
    return [write_obj(folder / f"{net.stem}.obj", net.cage) for net in NETS]


def high(runs: Runs) -> list[list[str]]:
    """Runs that end over TIMES the energy of a neighbour's: net, energy, its own value, the least neighbour and its value."""
    out = []
    for key, record in runs.items():
        stem, rest = key.split("|", 1)
        net = Torus(*map(int, re.findall(r"\d+", stem)))
        beside = {f"{other.stem}|{rest}" for other in net.neighbours()}
        values = {name: runs[name]["objective"] for name in beside if name in runs and is_done(runs[name])}
        least = min(values, key=values.__getitem__, default="")
        if is_done(record) and least and record["objective"] > TIMES * values[least]:
            out.append([shown(key), f"{record['objective']:.6g}", least.split("|")[0], f"{values[least]:.6g}"])
    return out


def report(runs: Runs) -> str:
    """What is no certified minimum, and what is high."""
    open_ends = [[shown(key), verdict(r), f"{r['cpu']:.2f}", f"{r.get('objective', float('nan')):.6g}"]
                 for key, r in runs.items() if not is_certified(r)]
    return (f"{len(open_ends)} of {len(runs)} runs are no certified minima.\n\n"
            + table(["run", "verdict", "CPU s", "energy"], open_ends)
            + f"\nEnergies over {TIMES} times a neighbour's:\n\n"
            + table(["run", "energy", "neighbour", "energy"], high(runs)))

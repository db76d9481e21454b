# SPDX-License-Identifier: GPL-3.0-or-later
"""Results shaken a little and minimized again: a minimum stays where it is.

The energy of a result and that of the touched one have quadrature errors; a fall is beyond doubt if it exceeds their sum.
"""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle")]

from ccref import SHARP, topology  # noqa: E402
from draw import Draw  # noqa: E402
from families import mean_edge  # noqa: E402
from measures import read_cage  # noqa: E402
from nets import write_obj  # noqa: E402
from tables import Record, Runs, group, is_certified, is_done, quantile, shown, split, table  # noqa: E402

SHARE = 1e-3  # of a mean edge
WAYS = 10
FALLS = (1e-4, 1e-3, 1e-2)


def touched(path: Path, folder: Path) -> list[Path]:
    """The cage's WAYS touched copies: vertices moved along random directions by SHARE of a mean edge.

    Those of the boundary and of infinitely sharp creases, which a run keeps, are not moved. Tags are copied.
    """
    mesh, out = read_cage(path), []
    topo = topology(mesh)
    moves = np.ones((mesh.n_vertices, 1))
    moves[topo.ends[topo.sharpness >= SHARP].ravel()] = 0  # edges of the boundary among them
    moves[mesh.vertex_sharpness >= SHARP] = 0
    tags = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("t ")]
    for way in range(WAYS):
        xyz = mesh.xyz + SHARE * mean_edge(mesh) * moves * Draw(way, mesh.n_vertices).directions(mesh.n_vertices)
        out.append(write_obj(folder / f"touched_{path.stem}.{way}.obj", mesh.with_xyz(xyz)))
        with out[-1].open("a", encoding="ascii") as file:
            file.writelines(f"{tag}\n" for tag in tags)
    return out


def falls(record: Record, ways: list[Record]) -> list[float]:
    """By how much of the result's energy each of the touched ones that came to its end is below it."""
    return [(record["objective"] - way["objective"]) / abs(record["objective"]) for way in ways if is_done(way)]


def report(runs: Runs, ways: dict[str, list[Record]]) -> str:
    """By how much each of the results fell at most and in the median, and how many of each energy fell."""
    each, sums = [], []
    for name, part in split({key: runs[key] for key in ways}, group).items():
        most, n_beyond = [], 0
        for key, record in part.items():
            some = falls(record, ways[key])
            errors = [r["quadrature_error"] for r in ways[key] if is_done(r)]
            doubt = (record["quadrature_error"] + max(errors, default=0.0)) / abs(record["objective"])
            most.append(max(some, default=0.0))
            n_beyond += most[-1] > doubt
            each.append([shown(key), f"{record['objective']:.8g}", len(some), sum(map(is_certified, ways[key])),
                         *(f"{quantile(some, q):.2g}" for q in (0.5, 1)), f"{doubt:.1g}",
                         "yes" if most[-1] > doubt else ""])
        sums.append([name, len(part), *(sum(x > fall for x in most) for fall in FALLS), n_beyond,
                     f"{quantile(most, 1):.2g}"])
    return (table(["results", "touched", *(f"fall by over {fall:g}" for fall in FALLS), "beyond doubt", "most"], sums) + "\n"
            + table(["result", "energy", "ended again", "certified", "fall: median", "most", "doubt", "beyond doubt"], each))

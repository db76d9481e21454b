# SPDX-License-Identifier: GPL-3.0-or-later
"""What the gallery finds out about tori: third-order energies of round ones on coarse nets, against the law of their
discretization, and where optimization goes. No bpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from . import solve
from .plot import Axis, Series, plot
from .store import Item, Store
from .torus_profile import CLIFFORD, RULES, SPHERES


def exact_cross(ratio: float) -> float:
    """MVS_cross of the round torus."""
    return 8 * math.pi**4 * (1 - ratio**2) ** -1.5


def lawful(energy: str, ratio: float, around: int, tube: int) -> float:
    """To leading order, the energy of a B-spline net of around x tube vertices over a round torus: the exact value and
    what the net adds. The same for both energies; only MVS_cross has an exact value other than 0."""
    by_tube = 4 * math.pi**4 / 3 * (2 * math.pi / tube) ** 2 / ratio**2
    by_turn = 2 * math.pi**4 / 3 * (2 * math.pi / around) ** 2
    by_turn *= ratio**2 * (1 + 2 * ratio**2) * (1 - ratio**2) ** -2.5
    return (exact_cross(ratio) if energy == "mvs_cross" else 0.0) + by_tube + by_turn


def lawful_best(energy: str, around: int, tube: int) -> float:
    """The ratio where that is least, to 1e-4."""
    ratios = np.arange(0.01, 0.99, 1e-4)
    return float(ratios[np.argmin([lawful(energy, ratio, around, tube) for ratio in ratios])])


def curves(store: Store, item: Item) -> list[dict[str, float]]:
    """The energy of every round torus of the item, cages named AROUNDxTUBE.THOUSANDTHS."""
    found = []
    for name, cage in item.cages.items():
        net, thousandths = name.split(".")
        around, tube = (int(number) for number in net.split("x"))
        energies = solve.evaluate(cage, item.inputs["energy"], "limit")
        ratio = int(thousandths) / 1000
        found.append({
            "around": around, "tube": tube, "ratio": ratio, "value": energies.objective,
            "law": lawful(item.inputs["energy"], ratio, around, tube),
        })  # fmt: skip
    return found


def plot_tori(store: Store, item: Item) -> dict[str, object]:
    """Answer (a): the energy after a fixed rule's optimization, by the start's ratio."""
    library, profile = [], []
    for name in item.needs:
        result = store.result(name)
        if name == "tori.profile":
            profile = result
            continue
        _, net, thousandths, *_ = name.split(".")
        library.append({
            "net": net, "ratio": int(thousandths) / 1000, "value": result["value"],
            "resolved": result["resolved"]["value"], "end_ratio": result["ratio"],
        })  # fmt: skip
    series = [
        Series(f"profile, {points} point{'s' if points > 1 else ''} a span", _finite(profile, points))
        for points in RULES
    ]
    for net in dict.fromkeys(run["net"] for run in library):
        places = [(run["ratio"], run["value"]) for run in library if run["net"] == net]
        series.append(Series(f"library, as the report, {net}", places, "dots"))
    text = plot(
        "Where tori go under a fixed rule", Axis("minor over major radius of the start", 0, 1),
        Axis("Willmore energy as the rule sees it", 0, 100), series,
        (("8π², Clifford", CLIFFORD), ("16π, two spheres", SPHERES), ("8π, one sphere", SPHERES / 2)),
    )  # fmt: skip
    store.write(item.files[0], text.encode())
    brief = [{name: value for name, value in run.items() if name != "profile"} for run in profile]
    return {"library": library, "profile": brief}


def _finite(profile: Sequence[dict], points: int) -> list[tuple[float, float]]:
    runs = [run for run in profile if run["points"] == points]
    return [(run["ratio"], max(run["value"], 0.0)) for run in runs if math.isfinite(run["value"])]


def plot_third(store: Store, item: Item) -> dict[str, object]:
    """Answers (b) and (c): the energy of round tori by net, and the ratio that optimization ends at, by net and by
    level."""
    answer = item.inputs["answer"]
    energy, title = {"cross": ("mvs_cross", "MVS_cross"), "mvs": ("mvs", "MVS")}[answer]
    measured = store.result(f"{answer}.curves")
    nets, levels = [], []
    for name in item.needs:
        if name == f"{answer}.curves":
            continue
        result = store.result(name)
        _, net, _, setting, level = name.split(".")
        around, tube = (int(number) for number in net.split("x"))
        row = {
            "net": net, "level": int(level), "ratio": result["ratio"], "value": result["value"],
            "h2": result["h2"], "verdict": result["verdict"], "vertices": result["vertices"],
            "net_share": result["net_share"], "quadrature_error": result["quadrature_error"],
        }  # fmt: skip
        if int(level) == 1:
            best = lawful_best(energy, around, tube)
            nets.append({**row, "law_ratio": best, "curve_ratio": _least(measured, around, tube)})
        if net == "8x4":
            levels.append(row)
    series = []
    for around, tube in dict.fromkeys((row["around"], row["tube"]) for row in measured):
        mine = [row for row in measured if (row["around"], row["tube"]) == (around, tube)]
        series.append(Series(f"net {around} x {tube}", [(row["ratio"], row["value"]) for row in mine]))
    if energy == "mvs_cross":
        ratios = np.linspace(0.05, 0.9, 60)
        series.append(Series("exact", [(r, exact_cross(r)) for r in ratios], "dashes", "#000000"))
    series.append(Series("optimized, level 1", [(row["ratio"], row["value"]) for row in nets], "dots", "#000000"))
    levels.sort(key=lambda row: row["level"])
    series.append(
        Series("optimized, 8 x 4, levels 1 ...", [(row["ratio"], row["value"]) for row in levels], "dots", "#d08a00")
    )
    low, high = (700, 5000) if energy == "mvs_cross" else (1, 10000)
    text = plot(
        f"{title} of round tori on B-spline nets", Axis("minor over major radius", 0, 1),
        Axis(title, low, high, log=True), series,
    )  # fmt: skip
    store.write(item.files[0], text.encode())
    return {"nets": nets, "levels": levels}


def _least(measured: Sequence[dict], around: int, tube: int) -> float:
    """Where the measured curve of a net is least, by a parabola in the logarithm through the three lowest points."""
    mine = sorted(
        ((row["ratio"], math.log(row["value"])) for row in measured if (row["around"], row["tube"]) == (around, tube))
    )
    at = min(range(len(mine)), key=lambda k: mine[k][1])
    if at in (0, len(mine) - 1):
        return mine[at][0]
    (a, p), (b, q), (c, r) = mine[at - 1 : at + 2]
    top = (b - a) ** 2 * (q - r) - (b - c) ** 2 * (q - p)
    return b - 0.5 * top / ((b - a) * (q - r) - (b - c) * (q - p))

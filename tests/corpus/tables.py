# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown tables of campaigns: distributions over the runs, and ratios of the runs that two campaigns share."""
from __future__ import annotations

import math
from typing import Any, Iterable, Sequence

Record = dict[str, Any]
Runs = dict[str, Record]  # by cage|energy|levels
TIMES = (1, 5, 20)        # CPU seconds
OVER = (1e-4, 1e-2)       # of the best known energy
FAMILIES = ("torus", "heap", "frame", "knot", "polyhedron", "triangles", "arms", "open", "poles")  # as in families.py
LARGE_FAMILIES = ("blocks", "tubes", "shaken", "sheet", "can", "globe", "ball", "ring", "facets", "ngons", "limbs",
                  "loop")  # as in large.py
FIRST_LARGE = 1000        # seed


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def quantile(values: Sequence[float], share: float) -> float:
    """Linear between the neighbours; NAN of nothing."""
    if not values:
        return math.nan
    order, at = sorted(values), share * (len(values) - 1)
    low = int(at)
    high = min(low + 1, len(order) - 1)
    return order[low] + (at - low) * (order[high] - order[low]) if high > low else order[low]


def group(key: str) -> str:
    """Energy and levels of a run."""
    _, energy, levels = key.split("|")
    return f"{energy}, {levels} level" + "s" * (levels != "1")


def family(key: str) -> str:
    """A run's family of cages."""
    stem = key.split("|")[0]
    return family_of_seed(int(stem[5:])) if stem.startswith("seed_") else "catalogue"


def family_of_seed(seed: int) -> str:
    """A seed's family of cages."""
    if seed < FIRST_LARGE:
        return FAMILIES[seed % len(FAMILIES)]
    return LARGE_FAMILIES[(seed - FIRST_LARGE) // 2 % len(LARGE_FAMILIES)]


def is_certified(record: Record) -> bool:
    """A minimum, by its Hessian."""
    return record.get("verdict") == "minimum"


def is_done(record: Record) -> bool:
    """Whether the run came to its end."""
    return record["outcome"] == "done"


# ---------------------------------------------------------------------------------------------------- one campaign --

def outcomes(runs: Runs) -> list[int]:
    """Runs, refused ones, certified, other verdicts (saddle, not stationary, unknown), out of time, failed."""
    records = list(runs.values())
    verdicts = [sum(is_done(r) and r["verdict"] == verdict for r in records)
                for verdict in ("minimum", "saddle", "not stationary", "unknown")]
    by = [sum(r["outcome"] == outcome for r in records) for outcome in ("refused", "out of time", "failed")]
    return [len(records), by[0], *verdicts, by[1], by[2]]


OUTCOMES = ["runs", "refused", "minimum", "saddle", "not stationary", "unknown", "out of time", "failed"]


def split(runs: Runs, by: Any) -> dict[str, Runs]:
    """The runs of each group, groups in order of appearance."""
    out: dict[str, Runs] = {}
    for key, record in runs.items():
        out.setdefault(by(key), {})[key] = record
    return out


def summary(runs: Runs) -> str:
    """Outcomes by energy and by family, and what the certified runs took."""
    groups = split(runs, group)
    text = [table(["", *OUTCOMES], [[name, *outcomes(part)] for name, part in groups.items()])]
    rows = []
    for name, part in groups.items():
        wanted = [r for r in part.values() if r["outcome"] != "refused"]
        cpu = [r["cpu"] for r in wanted if is_certified(r)]
        rows.append([name, *(f"{sum(c <= t for c in cpu)} of {len(wanted)}" for t in TIMES),
                     *(f"{quantile(cpu, q):.2f}" for q in (0.25, 0.5, 0.75, 1)),
                     f"{quantile([r['iterations'] for r in wanted if is_certified(r)], 0.5):.0f}",
                     f"{quantile([r['iterations'] for r in wanted if is_certified(r)], 1):.0f}"])
    text.append(table(["certified", *(f"within {t} s" for t in TIMES), "CPU s: quartile", "median", "quartile", "most",
                       "iterations: median", "most"], rows))
    rows = []
    for name, part in sorted(split(runs, family).items()):
        for energy, some in split(part, group).items():
            tried = [r for r in some.values() if r["outcome"] != "refused"]
            cpu = [r["cpu"] for r in tried]
            rows.append([name, energy, len(tried), sum(map(is_certified, tried)),
                         sum(r["outcome"] == "out of time" for r in tried), f"{quantile(cpu, 0.5):.2f}"])
    text.append(table(["family", "energy", "runs", "minimum", "out of time", "CPU s: median"], rows))
    return "\n".join(text)


# -------------------------------------------------------------------------------------------------- two campaigns --

def spread(values: Sequence[float]) -> list[str]:
    """Least, quartiles and most."""
    return [f"{quantile(values, q):.3g}" for q in (0, 0.25, 0.5, 0.75, 1)]


def over_best(runs: Runs, others: Runs) -> list[float]:
    """By how much of the best known energy each run of both ends above it."""
    out = []
    for key in shared(runs, others):
        mine, theirs = runs[key]["objective"], others[key]["objective"]
        best = min(mine, theirs)
        out.append((mine - best) / abs(best) if best else 0.0)
    return out


def shared(one: Runs, other: Runs) -> list[str]:
    """Runs that came to an end in both campaigns."""
    return [key for key, record in one.items() if key in other and is_done(record) and is_done(other[key])]


def worst(one: Runs, other: Runs, what: str) -> str:
    """The run whose ratio of other to one is largest."""
    keys = [key for key in shared(one, other) if one[key][what]]
    if not keys:
        return ""
    key = max(keys, key=lambda k: other[k][what] / one[k][what])
    return f"{shown(key)} ({one[key][what]:.6g} -> {other[key][what]:.6g})"


def shown(key: str) -> str:
    """A run's name without what ends a table's cell."""
    return key.replace("|", " ")


def compare(first: tuple[str, Runs], second: tuple[str, Runs]) -> str:
    """Outcomes of both, and of the runs done in both the ratios B / A and the energies over the best known."""
    (name_a, all_a), (name_b, all_b) = first, second
    keys = [key for key in all_a if key in all_b]
    lines = [f"A: {name_a}, B: {name_b}; {len(keys)} runs are in both.\n"]
    rows, ratios, energies, changed = [], [], [], []
    for name, a in split({key: all_a[key] for key in keys}, group).items():
        b = {key: all_b[key] for key in a}
        rows += [[name, letter, *outcomes(runs)] for letter, runs in (("A", a), ("B", b))]
        both = shared(a, b)
        for what in ("cpu", "iterations", "evaluations"):
            values = [b[key][what] / a[key][what] for key in both if a[key][what]]
            total = sum(b[key][what] for key in both) / max(sum(a[key][what] for key in both), 1e-9)
            ratios.append([name, what, len(values), *spread(values), f"{total:.3g}", worst(a, b, what)])
        for letter, mine, theirs in (("A", a, b), ("B", b, a)):
            over = over_best(mine, theirs)
            within = [f"{100 * sum(x <= limit for x in over) / max(len(over), 1):.1f} %" for limit in OVER]
            energies.append([name, letter, len(over), *within, f"{max(over, default=math.nan):.2g}"])
        changed += [[shown(key), verdict(a[key]), verdict(b[key])] for key in keys
                    if key in a and verdict(a[key]) != verdict(b[key])]
    lines.append(table(["", "", *OUTCOMES], rows))
    lines.append(table(["B / A", "of", "runs", "least", "quartile", "median", "quartile", "most", "of the sums", "largest"],
                       ratios))
    lines.append(table(["energy over the best known", "", "runs", *(f"within {limit:g}" for limit in OVER), "worst"],
                       energies))
    if changed:
        lines.append(table(["verdict changed", "A", "B"], changed))
    return "\n".join(lines)


def verdict(record: Record) -> str:
    """The verdict, or why there is none."""
    return record["verdict"] if is_done(record) else record["outcome"]

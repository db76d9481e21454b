# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown tables of what is asked of a campaign: certified minima, CPU time, energies, and how vertices lie in the results.

A result keeps its Jacobian if the least one is at least half of the input's, or 0.3; and its edges if their spread exceeds the
input's by no more than a third. measures.py defines both; `sampled` is the program's own least |S_u x S_v| over its face's
mean, at the quadrature's points. Only runs that came to their end are asked for that.
"""
from __future__ import annotations

from typing import Sequence

from tables import OVER, Record, Runs, group, is_certified, is_done, quantile, split, table

JACOBIAN_SHARE, JACOBIAN = 0.5, 0.3
SPREAD = 4 / 3
TAIL = 95         # percent of the inputs and results that are no worse
RELIABLE = 1e-3   # error of the quadrature, by the energy, up to which that may be the best known
Best = dict[str, float]  # by cage|energy|levels


def keeps_jacobian(before: float, after: float) -> bool:
    """By the rule above."""
    return after >= min(JACOBIAN_SHARE * before, JACOBIAN)


def keeps_edges(before: float, after: float) -> bool:
    """By the rule above."""
    return after <= SPREAD * before


KEPT = {"jacobian": keeps_jacobian, "sampled_jacobian": keeps_jacobian, "edges": keeps_edges}


def share(flags: Sequence[bool]) -> str:
    """How many of how many, in percent."""
    return f"{100 * sum(flags) / len(flags):.1f} %" if flags else ""


def wanted(runs: Runs) -> list[Record]:
    """The runs that the program did not refuse."""
    return [r for r in runs.values() if r["outcome"] != "refused"]


def over_best(runs: Runs, best: Best) -> list[float]:
    """By how much of itself the best known energy is exceeded by each run that came to its end and has one.

    Negative: a new best one.
    """
    return [(r["objective"] - best[key]) / abs(best[key]) for key, r in runs.items() if is_done(r) and best.get(key)]


def acceptance(runs: Runs, best: Best) -> str:
    """Tables by energy and levels; that of energies only if best known ones are given."""
    effort, energies, shapes = [], [], []
    for name, part in split(runs, group).items():
        tried = wanted(part)
        cpu, steps = ([r[what] for r in tried if what in r] for what in ("cpu", "iterations"))
        stopping = [r["stopping"] for r in tried if "stopping" in r]
        effort.append([name, len(tried), share([is_certified(r) for r in tried]),
                       *(f"{quantile(cpu, q):.2f}" for q in (0.5, 0.95, 1)),
                       *(f"{quantile(steps, q):.0f}" for q in (0.5, 0.95, 1)),
                       len(stopping), f"{max(stopping):.2f}" if stopping else ""])
        over = over_best(part, best)
        energies.append([name, len(over), *(share([x <= limit for x in over]) for limit in OVER),
                         *((f"{quantile(over, q):.2g}" for q in (0, 0.5, 1)) if over else [""] * 3)])
        for what, keeps in KEPT.items():
            pairs = [r[what] for r in part.values() if is_done(r) and what in r]
            quantiles = (0.5, TAIL / 100, 1) if keeps is keeps_edges else (0.5, 1 - TAIL / 100, 0)
            shapes.append([name, what.replace("_", " "), len(pairs), share([keeps(*pair) for pair in pairs]),
                           *(f"{quantile(side, q):.3g}" for side in (list(zip(*pairs)) or [[], []]) for q in quantiles)])
    texts = [
        table(["", "runs", "certified minima", "CPU s: median", "95 %", "most", "steps: median", "95 %", "most",
               "interrupted", "s until the end: most"], effort),
        table(["energy over the best known", "runs", *(f"within {limit:g}" for limit in OVER), "least", "median", "most"],
              energies) if best else "",
        table(["", "measure", "runs", "kept", "input: median", f"{TAIL} %", "worst", "result: median", f"{TAIL} %",
               "worst"], shapes)]
    return "\n".join(filter(None, texts))


def known(key: str, record: Record) -> bool:
    """Whether a run's energy may be the best known: of an odd seed, at the run's end, by a quadrature to be relied on."""
    stem = key.split("|")[0]
    return (stem.startswith("seed_") and int(stem[5:]) % 2 == 1 and is_done(record)
            and record["quadrature_error"] <= RELIABLE * abs(record["objective"]))


def lowered(best: Best, runs: Runs) -> Best:
    """The best known energies, with those of the runs that are lower, or the first."""
    out = dict(best)
    for key, record in runs.items():
        if known(key, record):
            out[key] = min(out.get(key, record["objective"]), record["objective"])
    return out

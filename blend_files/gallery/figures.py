# SPDX-License-Identifier: GPL-3.0-or-later
"""Every figure of the gallery's tables as rows, for CSV, JSON and the page. No bpy."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Collection, Mapping

from . import contents, solve, theorems
from .store import Store

FIELDS = (
    "table", "cage", "energy", "setting", "surface", "value", "resolved", "resolved_error", "quadrature_error",
    "net_share", "exact", "inside", "theorem", "h2", "exact_h2", "h2_off", "exact_from", "gauss_bonnet_defect",
    "verdict", "certified", "newton_decrement", "negative_directions", "symmetry_order", "stop", "iterations",
    "vertices", "ratio", "seconds",
)  # fmt: skip

LEFT_OPEN = (("net", "net_share"), ("rule", "quadrature_error"))  # what is left open of an energy: its name and field


def rows(store: Store, fresh: Collection[str]) -> list[dict[str, object]]:
    """One row for every minimizer of the tables that is finished, by FIELDS; `h2_off` is relative to what is exact, for
    Willmore's minimizers; `exact`, `inside` and `theorem` are those of `theorems`."""
    found = []
    for table, names in contents.TABLES.items():
        for name in names:
            for energy, setting in contents.columns(table):
                solved = contents.solve_name(name, energy, setting)
                if solved in fresh:
                    found.append(_row(table, name, store.result(solved), _exact(store, fresh, name)))
    return found


def seen(value: float, resolved: float | None) -> bool:
    """Whether the rule that gave an energy saw the surface: a fine rule agrees to 1 %."""
    return resolved is not None and abs(resolved - value) <= 0.01 * abs(value)


def error_text(value: float | None) -> str:
    """An error for people, to two digits or whole; "not known" for none."""
    if value is None:
        return "not known"
    return f"{value:,.0f}" if 10 <= value < 1e8 else f"{value:.2g}"


def mark(cage: str, record: Mapping[str, object]) -> str:
    """What is certain of a result, in a word or two."""
    if not seen(record["value"], record["resolved"]["value"]):
        return "the rule does not see it"
    if theorems.is_global(cage, record):
        return "global minimum"
    return {"minimum": "minimum, certified", "unknown": "not certified"}.get(record["verdict"], record["verdict"])


def _exact(store: Store, fresh: Collection[str], name: str) -> tuple[float, str] | None:
    """int H^2 of a cage's Willmore minimizer and where that is known from."""
    extrapolated = f"limit.{name}"
    if extrapolated not in fresh:
        return solve.exact_h2(name)
    found = store.result(extrapolated)
    doubt = max(abs(off) for off in found["tried"].values())
    return found["h2"], f"not exact: extrapolated from two levels, by a rule that is off by {doubt:.0e} elsewhere"


def _row(table: str, name: str, record: dict, known: tuple[float, str] | None) -> dict[str, object]:
    exact = known if record["energy"] == "willmore" else None
    least = theorems.exact(name, record["energy"], record["euler"])
    more = {
        "exact": least, "inside": theorems.inside(record, least), "theorem": theorems.said(name, record),
        "table": table, "cage": name, "resolved": record["resolved"]["value"],
        "resolved_error": record["resolved"]["error"], "iterations": sum(record["iterations"]),
        "exact_h2": exact[0] if exact else None, "exact_from": exact[1] if exact else None,
        "h2_off": record["h2"] / exact[0] - 1 if exact else None,
    }  # fmt: skip
    return {field: more[field] if field in more else record[field] for field in FIELDS}


def write(store: Store, found: list[dict[str, object]]) -> None:
    """figures.csv and figures.json."""
    text = io.StringIO()
    writer = csv.DictWriter(text, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(found)
    store.write("figures.csv", text.getvalue().encode())
    store.write("figures.json", (json.dumps(found, indent=1) + "\n").encode())

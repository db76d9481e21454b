# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's page: index.html, with relative pictures and nothing from elsewhere. It shows what is finished. No bpy.

What it says in words holds whatever the figures are; what depends on them is written from the data of the run.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from pathlib import Path

from . import answers_page, contents, figures
from .markup import grid, picture, section, significant
from .store import Item, Store

_STYLE = """
body { font: 16px/1.5 sans-serif; color: #222; max-width: 1500px; margin: 2em auto; padding: 0 1.5em }
p, li { max-width: 60em } img { max-width: 100%; height: auto } figure { margin: 1em 0 }
figcaption { color: #555; font-size: 14px } table { border-collapse: collapse; font-size: 13px; margin: 1em 0 }
td, th { border-bottom: 1px solid #ddd; padding: .2em .7em; text-align: right; white-space: nowrap }
td:first-child, th:first-child { text-align: left } th { background: #f4f4f4 } code, pre { background: #f4f4f4 }
pre { padding: .6em 1em; overflow-x: auto } nav a { margin-right: 1.2em } summary { cursor: pointer; color: #1f5fa8 }
"""

_TABLE_TEXTS = {
    "table1": (
        "Table 1: tori",
        "The report's table 1: cages of 8 x 4 vertices on round tori, and what they become. One camera and one scale "
        "a row; every shape has the same mean square distance from its centroid. The first three minimizers are by "
        "curvopt, the cage's symmetries kept, the last three by the report's (LMVM on all coordinates, a fixed rule, "
        "1 000 steps a level, `plane` for third order).",
    ),
    "table2": (
        "Table 2: high genus",
        "The report's table 2, likewise: Lawson's surfaces of genus 2 to 6 and the frames of a tetrahedron, a cube "
        "and an octahedron.",
    ),
    "shapes": (
        "A sphere and free forms",
        "Default settings, three levels. The branching pipe is open: its ends stay. Nothing keeps a surface from "
        "passing through itself: that is how the trefoil comes undone, or winds round one torus twice.",
    ),
}


def command(options: str) -> str:
    """What makes a part of the gallery."""
    start = "blender -b --factory-startup --python-exit-code 1 -P blend_files/gallery/make.py -- --output DIR"
    return f"{start} {options}".rstrip()


def write(store: Store, fresh: Collection[str], items: Mapping[str, Item]) -> Path:
    """index.html, figures.csv and figures.json of all that is finished; the page's path."""
    found = figures.rows(store, fresh)
    figures.write(store, found)
    seconds = sum(store.entry(name)["seconds"] for name in fresh)
    parts = [_table(store, fresh, table, found) for table in contents.TABLES]
    parts += [_figures(store, fresh), *answers_page.sections(store, fresh)]
    parts = [part for part in parts if part]
    names = [part.split('id="', 1)[1].split('"', 1)[0] for part in parts]
    lacking = len(items) - len(fresh)
    head = [
        "<h1>curvopt: the report's experiments</h1>",
        "<p>Minimizers of curvature energies of Catmull–Clark surfaces, after Joshi and Séquin's report <i>Minimizers "
        "of Curvature-Based Surface Energy</i>. All of it is made by one command:</p>",
        f"<pre>{command('')}</pre>",
        f"<p>libcurvopt {escape(store.version.split()[0])}; {len(fresh)} of {len(items)} parts are "
        f"finished{f', {lacking} are not' if lacking else ''}; they took {seconds / 60:.1f} minutes of work. All "
        "figures: "
        '<a href="figures.csv">figures.csv</a>, <a href="figures.json">figures.json</a>.</p>',
        "<nav>" + "".join(f'<a href="#{name}">{name}</a>' for name in names) + "</nav>",
    ]
    page = (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>curvopt gallery</title>'
        f"<style>{_STYLE}</style></head>\n<body>\n" + "\n".join([*head, *parts]) + "\n</body></html>\n"
    )
    store.write("index.html", page.encode())
    return store.path("index.html")


def _table(store: Store, fresh: Collection[str], table: str, found: Sequence[Mapping[str, object]]) -> str:
    """A sheet, or the rows of it that are finished, and the figures."""
    title, text = _TABLE_TEXTS[table]
    if f"sheet.{table}" in fresh:
        shown = picture(f"pictures/{table}.png", title)
    else:
        rows = [name for name in contents.TABLES[table] if f"row.{name}" in fresh]
        shown = "".join(picture(f"pictures/row.{name}.png", name) for name in rows)
    mine = [row for row in found if row["table"] == table]
    if not shown and not mine:
        return ""
    heads = ("cage", "energy", "setting", "value", "by a fine rule", "int H²", "exact", "off by", "Gauss–Bonnet",
             "verdict", "decrement", "stop", "symmetries", "vertices", "r/R", "s")  # fmt: skip
    body = [
        (row["cage"], row["energy"], row["setting"], significant(row["value"], 7), significant(row["resolved"], 7),
         significant(row["h2"], 9), significant(row["exact_h2"], 9), _off(row["h2_off"]),
         significant(row["gauss_bonnet_defect"], 2), row["verdict"], significant(row["newton_decrement"], 2),
         row["stop"], row["symmetry_order"], row["vertices"], significant(row["ratio"], 4),
         f"{row['seconds']:.1f}")
        for row in mine
    ]  # fmt: skip
    return section(
        table, title, f"<p>{escape(text)}</p>", _accuracy(mine), shown,
        f"<details><summary>All figures</summary>{grid(heads, body)}</details>",
        f"<pre>{command('--only ' + table)}</pre>",
    )  # fmt: skip


def _off(value: float | None) -> str:
    return "" if value is None else f"{value:+.1e}"


def _accuracy(mine: Sequence[Mapping[str, object]]) -> str:
    """How far Willmore's minimizers by the default settings are from what is exact, and what is certified."""
    ours = [row for row in mine if row["setting"] == "default"]
    compared = [row for row in ours if row["h2_off"] is not None]
    known = [abs(row["h2_off"]) for row in compared if not row["exact_from"].startswith("not exact")]
    certified = sum(row["verdict"] == "minimum" for row in ours)
    parts = []
    if known:
        parts.append(f"∫H² of Willmore's minimizers is within {max(known):.1e} of the exact value where one is known.")
    if ours:
        parts.append(
            f"{certified} of {len(ours)} results by the default settings are certified minima among shapes of their "
            "symmetry; the others say what they are."
        )
    for row in mine:
        if not figures.seen(row["value"], row["resolved"]):
            truth = "refuses it" if row["resolved"] is None else f"gives {row['resolved']:.4g}"
            parts.append(
                f"{row['cage']}, {row['energy']}, setting {row['setting']}: the rule says {row['value']:.5g}, a fine "
                f"rule {truth}; |∫K − 2πχ| is {row['gauss_bonnet_defect']:.2g}. This optimization has found a hole in "
                "its rule."
            )
    for source in sorted({row["exact_from"] for row in compared}):
        names = ", ".join(row["cage"] for row in compared if row["exact_from"] == source)
        parts.append(f"Compared with: {names}: {source}.")
    return f"<p>{escape(' '.join(parts))}</p>" if parts else ""


def _figures(store: Store, fresh: Collection[str]) -> str:
    """The report's figures 1 to 3."""
    parts = []
    if "figure.flat" in fresh:
        rows = store.result("figure.flat")
        body = [(row["surface"], *_spot_figures(row)) for row in rows]
        parts.append(
            "<p>Figure 1: the surfaces of one cage, a sphere of 26 vertices, eight of them of valence 3. As clay, as "
            "stripes, and coloured by mean curvature: grey is the usual, blue flat, red twice the usual. "
            "<code>plane</code>, the report's, is flat at each of the eight; the limit surface is not, but its "
            "curvature has no derivative there that could be integrated; <code>polynomial</code> has.</p>"
            + picture("pictures/figure1.png", "limit, plane, polynomial")
            + grid(("surface", "Willmore (sphere: 25.1327)", "MVS (sphere: 0)", "flat, % of the area"), body)
        )
    if "figure.refined" in fresh:
        rows = store.result("figure.refined")
        body = [(str(row["vertices"]), *_spot_figures(row)) for row in rows]
        parts.append(
            "<p>Figure 2: <code>plane</code> of the same cage, subdivided. Its flat spots shrink as the report says, "
            "and so does what they cost in bending. What they cost in MVS does not: the smaller the spot, the faster "
            "the curvature falls in it.</p>"
            + picture("pictures/figure2.png", "plane, subdivided")
            + grid(("vertices", "Willmore", "MVS", "flat, % of the area"), body)
        )
    if "figure.blend" in fresh:
        body = [
            (row["function"], *(significant(row[f"above_{level}"], 4) for level in (0.999, 0.99, 0.9, 0.5)),
             significant(row["integral"], 4))
            for row in store.result("figure.blend")
        ]  # fmt: skip
        parts.append(
            "<p>Figure 3: the blend function (1), its denominator mended, and the C⁴ spline over five equal spans. "
            "The table has the t up to which each stays above a level: how far its platform reaches.</p>"
            + picture("pictures/figure3.svg", "both blend functions")
            + grid(("function", "above .999", ".99", ".9", ".5", "integral"), body)
        )
    return section("figures", "Figures 1 to 3", *parts, f"<pre>{command('--only figures')}</pre>") if parts else ""


def _spot_figures(row: Mapping[str, object]) -> tuple[str, str, str]:
    mvs = "does not exist" if row["mvs"] is None else significant(row["mvs"], 5)
    return significant(row["willmore"], 7), mvs, f"{100 * row['flat']:.3f}"

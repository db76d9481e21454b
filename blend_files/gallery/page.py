# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's page: index.html, with relative pictures and nothing from elsewhere. It shows what is finished. No bpy.

What it says in words holds whatever the figures are; what depends on them is written from the data of the run.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from pathlib import Path

from addon.core.energy import ENERGY_LABELS, number_text
from . import answers_page, artists, constrained_page, contents, figures, solve
from .markup import cells, command, grid, picture, section, significant
from .store import Item, Store

_STYLE = """
body { font: 16px/1.55 sans-serif; color: #222; max-width: 1180px; margin: 0 auto; padding: 1em }
p, li { max-width: 46em } img { max-width: 100%; height: auto; display: block } figure { margin: 0 }
h1 { font-size: 1.9em; line-height: 1.2 } h2 { margin-top: 2.2em; border-top: 1px solid #ddd; padding-top: .8em }
h3 { margin: 1.6em 0 .3em; font-size: 1em }
figcaption { color: #444; font-size: 13px; line-height: 1.4; padding: .3em 0 1em }
.cells { display: grid; grid-template-columns: repeat(4, minmax(0, 1fr)); gap: 0 1em }
.cells figure { display: flex; flex-direction: column; justify-content: flex-end }
.wide { overflow-x: auto } table { border-collapse: collapse; font-size: 13px; margin: 1em 0 }
td, th { border-bottom: 1px solid #ddd; padding: .2em .7em; text-align: right; white-space: nowrap }
td:first-child, th:first-child { text-align: left } th { background: #f4f4f4 } code, pre { background: #f4f4f4 }
pre { padding: .6em 1em; overflow-x: auto } code { overflow-wrap: anywhere }
nav a { display: inline-block; padding: .4em 1.2em .4em 0 } summary { cursor: pointer; color: #1f5fa8; padding: .4em 0 }
a { color: #1f5fa8 } td.text { white-space: normal }
@media (max-width: 640px) { .cells { grid-template-columns: repeat(2, minmax(0, 1fr)) } h1 { font-size: 1.5em } }
"""

_TABLE_TEXTS = {
    "table1": (
        "Tori",
        "Cages of 8 x 4 vertices on round tori, and what they become. One camera and one scale a row; every shape has "
        "the same mean square distance from its centroid. Willmore's energy has one answer, the Clifford torus; MVS "
        "is 0 for every round torus, so what is left of it is the net's.",
    ),
    "table2": (
        "High genus",
        "Lawson's surfaces of genus 2 to 6, and the frames of a tetrahedron, a cube and an octahedron, with all their "
        "symmetries kept.",
    ),
    "shapes": (
        "A sphere and free forms",
        "Three levels. The branching pipe is open: its ends stay. Nothing keeps a surface from passing through itself "
        "here: that is how the trefoil comes undone, or winds round one torus twice.",
    ),
}
_INTRO = (
    "Take a rough cage of a few dozen vertices, let it be smoothed as Blender's Subdivision Surface modifier does "
    "(Catmull–Clark), and move the vertices until the surface is as fair as its number of holes allows. What comes out "
    "depends on what one calls fair. <b>Willmore</b> punishes bending, ∫(k₁² + k₂²) dA: soap-film-like shapes. "
    "<b>MVS</b> punishes change of curvature along the lines of curvature: round arms of even thickness. "
    "<b>MVS_cross</b> punishes it in all directions: rounder bodies, thinner arms. None of the three depends on size.",
    "The energies and the experiments are those of Pushkar Joshi and Carlo Séquin (<i>Energy Minimizers for "
    "Curvature-Based Surface Functionals</i>, 2007, and the report <i>Minimizers of Curvature-Based Surface Energy</i>, "
    "2006). New is that the figures can be trusted: the surface is evaluated exactly, integrals have a stated error, "
    "every result says whether it is a minimum, and how much of its energy is the net's. The questions that the report "
    "left open have answers here, each with its plots.",
)
_READING = (
    "Under each shape stand its energy, <b>net</b>, <b>rule</b> and what is certain. <b>net</b> is how much finer nets "
    "would still take away: an estimate from the last levels, typically three (MVS) to eight (Willmore) times too "
    "large, and not known after one level. Where it is as large as the energy, the figure says nothing about the "
    "smooth surface but that it has no more. <b>rule</b> is the error of the integration. <b>minimum, certified</b>: by its Hessian the "
    "shape is a minimum among shapes nearby of the same symmetry. <b>global minimum</b>: a theorem says so. A click on "
    "a picture shows its whole row, large.",
)
_OWN = (
    "To make your own, install the add-on, add a mesh (<i>Add ▸ Mesh ▸ Curvature Shapes</i> has the cages of this "
    "page), open the sidebar with N, and press <i>Minimize</i>; the preset <i>Global Minimum</i> does what was done "
    "here. Or by the command line: <code>curvopt minimize CAGE.obj -o OUT.obj --energy mvs --levels 4</code>.",
)


def write(store: Store, fresh: Collection[str], items: Mapping[str, Item]) -> Path:
    """index.html, figures.csv and figures.json of all that is finished; the page's path."""
    found = figures.rows(store, fresh)
    figures.write(store, found)
    seconds = sum(store.entry(name)["seconds"] for name in fresh)
    parts = [*(_table(store, fresh, table, found) for table in contents.TABLES), _theorems(found)]
    parts += [_pairs(store, fresh), *constrained_page.sections(store, fresh), _figures(store, fresh), *answers_page.sections(store, fresh)]
    parts = [part for part in parts if part]
    links = [_link(part) for part in parts]
    lacking = len(items) - len(fresh)
    head = [
        "<h1>curvopt: the fairest surfaces of their topology</h1>",
        *(f"<p>{text}</p>" for text in _INTRO), _cover(fresh),
        *(f"<p>{text}</p>" for text in (*_READING, *_OWN)),
        "<p>One command makes this page and all figures, and goes on where it was interrupted:</p>",
        f"<pre>{command('')}</pre>",
        f"<p>libcurvopt {escape(store.version.split()[0])}; {len(fresh)} of {len(items)} parts are "
        f"finished{f', {lacking} are not' if lacking else ''}; they took {seconds / 60:.1f} minutes of work. All "
        "figures: "
        '<a href="figures.csv">figures.csv</a>, <a href="figures.json">figures.json</a>.</p>',
        f"<nav>{''.join(links)}</nav>",
    ]  # fmt: skip
    page = (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>curvopt gallery</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{_STYLE}</style></head>\n<body>\n" + "\n".join([*head, *parts]) + "\n</body></html>\n"
    )
    store.write("index.html", page.encode())
    return store.path("index.html")


def _link(part: str) -> str:
    """A link to a section, by its name and title."""
    name, title = (part.split(start, 1)[1].split(end, 1)[0] for start, end in (('id="', '"'), ("<h2>", "</h2>")))
    return f'<a href="#{name}">{title}</a>'


def _cover(fresh: Collection[str]) -> str:
    if "cover" not in fresh:
        return ""
    return picture("pictures/lawson_g2_mvs.png", "a cage of genus 2, its surface, and the same minimized")


def _theorems(found: Sequence[Mapping[str, object]]) -> str:
    """What theorems say of the results, and which known energies lie within what is stated."""
    mine = [row for row in found if row["setting"] == "default"]
    compared = [row for row in mine if row["inside"] is not None]
    lines = []
    for text in dict.fromkeys(row["theorem"] for row in mine if row["theorem"]):
        names = ", ".join(row["cage"] for row in mine if row["theorem"] == text)
        lines.append(f"<li>{escape(names)} (Willmore): {escape(text)}.</li>")
    parts = [f"<ul>{''.join(lines)}</ul>"] if lines else []
    if lines:
        parts.append(
            "<p>Lawson's symmetries in the 3-sphere are conformal maps of space; the rotations and reflections that a "
            "run keeps are some of them. So it is by its value that a result is taken for Lawson's surface: it agrees "
            "within what net and rule leave open.</p>"
        )
    if compared:
        good = sum(row["inside"] for row in compared)
        parts.append(
            f"<p>{good} of {len(compared)} known least energies lie within what net and rule leave open of the figure.</p>"
        )
    return section("theorems", "What theorems say of these minimizers", *parts) if parts else ""


def _table(store: Store, fresh: Collection[str], table: str, found: Sequence[Mapping[str, object]]) -> str:
    """The rows of a table that are finished, and the figures."""
    title, text = _TABLE_TEXTS[table]
    mine = [row for row in found if row["table"] == table]
    shown = "".join(_row(store, name, "default", mine) for name in contents.TABLES[table] if f"row.{name}" in fresh)
    report = "".join(
        _row(store, name, "report", mine) for name in contents.TABLES[table] if f"row.{name}.report" in fresh
    )
    if report:
        report = (
            "<details><summary>The same under the report's settings</summary><p>LMVM on all coordinates, a fixed rule, "
            f"{solve.REPORT_STEPS} steps a level, <code>plane</code> for third order.</p>{report}</details>"
        )
    if not shown and not mine:
        return ""
    heads = ("cage", "energy", "setting", "value", "net", "rule", "exact", "inside", "by a fine rule", "int H²",
             "exact int H²", "off by", "Gauss–Bonnet", "verdict", "decrement", "stop", "symmetries", "vertices", "r/R",
             "s")  # fmt: skip
    body = [
        (row["cage"], row["energy"], row["setting"], significant(row["value"], 7), significant(row["net_share"], 2),
         significant(row["quadrature_error"], 2), significant(row["exact"], 7), _yes(row["inside"]),
         significant(row["resolved"], 7),
         significant(row["h2"], 9), significant(row["exact_h2"], 9), _off(row["h2_off"]),
         significant(row["gauss_bonnet_defect"], 2), row["verdict"], significant(row["newton_decrement"], 2),
         row["stop"], row["symmetry_order"], row["vertices"], significant(row["ratio"], 4),
         f"{row['seconds']:.1f}")
        for row in mine
    ]  # fmt: skip
    return section(
        table, title, f"<p>{escape(text)}</p>", shown, report, _accuracy(mine),
        f"<details><summary>All figures</summary>{grid(heads, body)}</details>",
        f"<pre>{command('--only ' + table)}</pre>",
    )  # fmt: skip


def _row(store: Store, name: str, setting: str, mine: Sequence[Mapping[str, object]]) -> str:
    """A cage and its minimizers as small pictures with their figures."""
    start = store.result(f"input.{name}")
    solved = {row["energy"]: row for row in mine if row["cage"] == name and row["setting"] == setting}
    energies = [energy for energy in solve.ENERGIES if energy in solved]
    large, *small = contents.row_files(name, setting, 1 + len(energies))
    lines = [("input", *(f"{ENERGY_LABELS[energy]} {number_text(start[energy])}" for energy in solve.ENERGIES))]
    lines += [_lines(name, store.result(contents.solve_name(name, energy, setting))) for energy in energies]
    return f"<h3>{escape(name.replace('_', ' '))}</h3>" + cells(large, list(zip(small, lines)))


def _lines(name: str, record: Mapping[str, object]) -> tuple[str, ...]:
    """Under a minimizer."""
    left_open = ", ".join(f"{label} {figures.error_text(record[key])}" for label, key in figures.LEFT_OPEN)
    return (
        f"{ENERGY_LABELS[record['energy']]} {number_text(record['value'])}", left_open,
        f"∫H² {record['h2']:.4f}", figures.mark(name, record),
    )  # fmt: skip


def _yes(value: bool | None) -> str:
    return "" if value is None else ("yes" if value else "no")


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


def _pairs(store: Store, fresh: Collection[str]) -> str:
    """Artists' shapes before and after."""
    body, shown = [], []
    for name in artists.CAGES:
        if f"picture.{name}" not in fresh:
            continue
        record = store.result(f"pair.{name}")
        shown.append(f"<h3>{escape(name)}</h3>" + picture(f"pictures/pair.{name}.png", f"{name}, before and after"))
        body.append((
            name, record["vertices"], f"{record['strength']:g}", significant(record["start"], 5),
            significant(record["value"], 5),
            significant(record["quadrature_error"], 2), f"{100 * record['deviation']:.1f}",
            f"{record['seconds']:.2f}", record["verdict"],
        ))  # fmt: skip
    if not shown:
        return ""
    heads = ("shape", "vertices", "strength", "Willmore before", "after", "rule", "moved, % of the size", "s", "verdict")
    return section(
        "pairs", "Before and after",
        "<p>Shapes as artists have them, with the bumps of modelling by hand or of a scan, and what one press of "
        "<i>Minimize</i> makes of them at a strength of 0.3, where the panel begins, or 0.5: their own "
        "vertices move, bumps go, and what is larger stays. The stripes are reflections; they waver where the surface "
        "does. The minimum is one of energy and nearness to the original together; the net's share is not known after "
        "one level.</p>", *shown, grid(heads, body), f"<pre>{command('--only pairs')}</pre>",
    )  # fmt: skip


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

# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's list: which cages stand in which table, and every item with what it needs. No bpy until items draw."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from addon.binding.values import Cage
from . import answers, artists, constrained, falling, genus, genus_plots, layouts, pairs, solve, torus_nets, torus_profile
from .store import Item, Store

Draw = Callable[[Store, Item], object]

TABLES = {
    "table1": tuple(f"torus_{percent:03d}" for percent in range(10, 100, 10)),
    "table2": (
        *(f"lawson_g{genus}" for genus in range(2, 7)),
        "tetrahedral_g3", "cubical_g5", "octahedral_g7",
    ),
    "shapes": ("sphere_cube", "mug_g1", "trefoil_g1", "pretzel_g2", "branch_open"),
}  # fmt: skip
REPORT_TABLES = ("table1", "table2")  # those that the report has, so its settings are tried, too
ANSWERS = ("tori", "cross", "mvs", "plane", "saddles", "holes")
README = "readme"
PAIRS = "pairs"
CONSTRAINED = "constrained"
CAMPAIGN = genus.TAG  # an hour of two cores: made when asked for by name, never with the rest
GROUPS = (README, *TABLES, PAIRS, CONSTRAINED, "figures", "answers", *ANSWERS, CAMPAIGN)
COVER = "lawson_g2"
README_ROWS = {
    "table1": ("torus_010", "torus_030", "torus_060", "torus_090"),
    "table2": ("lawson_g2", "lawson_g3", "tetrahedral_g3", "cubical_g5"),
}  # fmt: skip
OCTAHEDRAL = "octahedral_g7"
SADDLES = ("tetrahedral_g3", "cubical_g5")
PLANE_CAGES = ("lawson_g2", "tetrahedral_g3", "cubical_g5", "sphere_cube")
PLANE_LEVELS = 3  # at the fourth the optimization on `plane` alone takes many minutes a shape
SHAPE_LEVELS = 3  # free forms have no symmetry: the fourth level takes minutes and changes nothing that shows
CROSS_NETS = ((6, 4), (8, 6), (8, 8), (12, 12), (16, 8), (16, 16), (32, 32))
SHAKES = ((0.003, 12), (0.01, 12), (0.03, 12), (0.03, 48), (0.1, 48))  # of the size, and rounds of smoothing
THIRD_SHAKES = ((0.03, 12),)  # for third-order energies
FALLING = ("tetrahedral_g3",)  # the cubical one is held by 1 528 vertices, and a dense matrix of more takes minutes
SIDES = {"out": 0.05, "in": -0.05}  # how far a saddle is moved along the mode in which it falls, of the size

HOLES = (  # family, cage of `layouts`, energy, levels: pictures in rows
    (("genus 2", "eight", "mvs", 5), ("genus 2", "lawson", "mvs", 5),
     ("genus 2", "eight", "mvs_cross", 5), ("genus 2", "lawson", "mvs_cross", 5)),
    (("genus 3", "three in an L", "mvs", 4), ("genus 3", "lawson", "mvs", 5),
     ("genus 3", "three in an L", "mvs_cross", 4), ("genus 3", "lawson", "mvs_cross", 5)),
    (("tetrahedral", "pole hubs, 1 ring", "mvs", 5), ("tetrahedral", "pole hubs, 1 ring", "mvs_cross", 5),
     ("cubical", "pole hubs, 1 ring", "mvs", 5), ("cubical", "pole hubs, 1 ring", "mvs_cross", 5)),
)  # fmt: skip


@dataclass(frozen=True)
class Measure:
    """What the command line chooses: levels of an optimization, pixels of a cell's width, samples per pixel."""

    levels: int = 4
    width: int = 640
    samples: int = 12


def all_cages() -> tuple[str, ...]:
    """Every cage that some table shows."""
    return tuple(name for names in TABLES.values() for name in names)


def solve_name(cage: str, energy: str, setting: str) -> str:
    """The item that minimizes `energy` from a cage with a setting."""
    return f"solve.{cage}.{energy}.{setting}"


def shaken_name(cage: str, energy: str, share: float, rounds: int) -> str:
    """The item that minimizes again from a minimizer which was shaken."""
    return f"shaken.{cage}.{energy}.{round(1000 * share)}x{rounds}"


def mode_name(cage: str) -> str:
    """The item that finds in which direction Willmore's minimizer of a cage falls."""
    return f"mode.{cage}.willmore"


def fall_name(cage: str, side: str) -> str:
    """The item that follows it there, to a side."""
    return f"fall.{cage}.willmore.{side}"


def columns(table: str) -> list[tuple[str, str]]:
    """(energy, setting) of a table's minimizers, left to right."""
    settings = ("default", "report") if table in REPORT_TABLES else ("default",)
    return [(energy, setting) for setting in settings for energy in solve.ENERGIES]


def published() -> tuple[str, ...]:
    """The items that draw the README's pictures."""
    return ("cover", *(f"sheet.{table}" for table in README_ROWS))


def solves(items: Mapping[str, Item], item: Item) -> list[str]:
    """The minimizers that an item shows, by name, in their order."""
    found: list[str] = []
    for need in item.needs:
        if need.startswith(("solve.", "cover.")):
            found.append(need)
        elif need.startswith("row."):
            found += solves(items, items[need])
    return found


def items(
    cages: Mapping[str, Cage], make: Callable[..., Cage], measure: Measure, draw: Mapping[str, Draw]
) -> list[Item]:
    """Every item, after what it needs. `cages` are those of the tables, by name; `make(kind, ...)` makes more, by the
    functions of cages.py; `draw` has the functions that need Blender: "cover", "row",
    "sheet", "pair", "vesicles", "rings", "flat", "refined", "look", "modes", "holes"."""

    def torus(ratio: float, around: int, tube: int) -> Cage:
        return make("torus", ratio, around, tube, interpolate=True)

    found = _cover(cages[COVER], measure, draw["cover"])
    for table, names in TABLES.items():
        for name in names:
            found += _row(table, name, cages[name], measure, draw["row"])
        if table in README_ROWS:
            found.append(_sheet(table, README_ROWS[table], measure, draw["sheet"]))
    found.append(_extrapolation(cages, measure))
    found += _pairs(measure, draw["pair"])
    found += _constrained(make, measure, draw)
    found += _figures(make("sphere_cube", 2), measure, draw)
    found += _answers_on_tori(torus, measure)
    found += _answer_plane(cages, measure)
    found += _answer_saddles(cages, measure, draw)
    found += _answer_holes(make, measure, draw["holes"])
    return found + genus.items(make)


def _levels(table: str, name: str, energy: str, setting: str, measure: Measure) -> int:
    """Levels of a table's minimizer. The octahedral cage is coarse for its shape: at four levels its Willmore energy
    is 3e-4 above the least and not stationary yet, at five 8e-5."""
    if table not in REPORT_TABLES:
        return min(measure.levels, SHAPE_LEVELS)
    return measure.levels + ((name, energy, setting) == (OCTAHEDRAL, "willmore", "default"))


def _cover(cage: Cage, measure: Measure, draw: Draw) -> list[Item]:
    """The README's first pictures, by the library's own defaults."""
    tags, cages = frozenset({README}), {COVER: cage}
    inputs = {"energy": "mvs", "levels": measure.levels, "strength": 1.0}
    solved = Item(f"cover.{COVER}", pairs.minimize, inputs, tags, cages=cages, cost=5.0)
    files = ("pictures/lawson_g2_mvs.png", "pictures/lawson_g2_zebra.png")
    sizes = {"total": 4 * measure.width, "samples": 2 * measure.samples}
    return [solved, Item("cover", draw, sizes, tags, (solved.name,), files, True, 30.0, cages)]


def _row(table: str, name: str, cage: Cage, measure: Measure, draw: Draw) -> list[Item]:
    """The cage's figures, its minimizers and their pictures, one row for each setting."""
    tags, cages = frozenset({table, name}), {name: cage}
    start = Item(f"input.{name}", solve.inputs_figures, {}, tags, cages=cages, cost=0.2)
    parts = [start]
    for setting in dict.fromkeys(setting for _, setting in columns(table)):
        solved = []
        for energy in (energy for energy, found in columns(table) if found == setting):
            levels = _levels(table, name, energy, setting, measure)
            inputs = {"energy": energy, "setting": setting, "levels": levels}
            cost = (1.5 if energy == "willmore" else 20.0) if setting == "report" else 4.0
            item = solve_name(name, energy, setting)
            solved.append(Item(item, solve.minimize, inputs, tags, cages=cages, cost=cost))
        inputs = {"table": table, "cage": name, "setting": setting, "width": measure.width, "samples": measure.samples}
        needs = (start.name, *(item.name for item in solved))
        files = row_files(name, setting, 1 + len(solved))
        parts += [*solved, Item(row_name(name, setting), draw, inputs, tags, needs, files, True, 15.0, cages)]
    return parts


def _pairs(measure: Measure, draw: Draw) -> list[Item]:
    """Artists' shapes before and after the first press."""
    found: list[Item] = []
    for name, make in artists.CAGES.items():
        tags, cages = frozenset({PAIRS}), {name: make()}
        inputs = {"energy": "willmore", "levels": 1, "strength": artists.STRENGTHS[name]}
        solved = Item(f"pair.{name}", pairs.minimize, inputs, tags, cages=cages, cost=2.0)
        inputs = {"width": measure.width, "samples": measure.samples}
        files = (f"pictures/pair.{name}.png",)
        found += [solved, Item(f"picture.{name}", draw, inputs, tags, (solved.name,), files, True, 20.0, cages)]
    return found


def _constrained(make: Callable[..., Cage], measure: Measure, draw: Mapping[str, Draw]) -> list[Item]:
    """Closed surfaces that enclose a volume, and a vase through rings."""
    tags, parts, levels = frozenset({CONSTRAINED}), [], min(measure.levels, SHAPE_LEVELS)
    rows: dict[str, list[str]] = {"vesicles": [], "tori_by_volume": []}  # needs by picture
    for name, vesicle in constrained.VESICLES.items():
        inputs = {"levels": levels, "volume": vesicle.volume, "exact": vesicle.exact, "source": vesicle.source}
        cage = constrained.vesicle_cage(vesicle.kind, make)
        parts.append(Item(f"vesicle.{name}", constrained.enclose, inputs, tags, cages={name: cage}, cost=2.0))
        rows["tori_by_volume" if vesicle.kind == "torus" else "vesicles"].append(f"vesicle.{name}")
    vase = {"vase": constrained.vase()}
    rings = [
        Item(f"rings.{energy}", constrained.pass_through, {"energy": energy, "levels": levels}, tags, cages=vase, cost=5.0)
        for energy in constrained.RING_ENERGIES
    ]
    inputs = {"width": measure.width, "samples": measure.samples}
    for row, needs in rows.items():
        file = (f"pictures/{row}.png",)
        parts.append(Item(f"constrained.{row}", draw["vesicles"], inputs, tags, tuple(needs), file, True, 30.0))
    needs = tuple(item.name for item in rings)
    picture = Item("constrained.rings", draw["rings"], inputs, tags, needs, ("pictures/rings.png",), True, 30.0, vase)
    seen = {"digest": hashlib.sha256(constrained.DIAGRAM.read_bytes()).hexdigest()}
    file = ("pictures/vesicle_phases.svg",)
    return [*parts, *rings, picture, Item("constrained.diagram", constrained.diagram, seen, tags, files=file, cost=0.1)]


def row_name(cage: str, setting: str) -> str:
    """The item that draws what a setting makes of a cage."""
    return f"row.{cage}" if setting == "default" else f"row.{cage}.{setting}"


def row_files(cage: str, setting: str, count: int) -> tuple[str, ...]:
    """A row's picture, and that of each of its cells."""
    name = row_name(cage, setting)
    return f"pictures/{name}.png", *(f"pictures/{name}.{index}.png" for index in range(count))


def _sheet(table: str, names: tuple[str, ...], measure: Measure, draw: Draw) -> Item:
    needs = tuple(row_name(name, "default") for name in names)
    inputs = {"table": table, "width": measure.width, "samples": measure.samples}
    return Item(f"sheet.{table}", draw, inputs, frozenset({table, README}), needs, (f"pictures/{table}.png",), True, 5.0)


def _extrapolation(cages: Mapping[str, Cage], measure: Measure) -> Item:
    """What Willmore's minimizer of the octahedral cage ought to have, for want of an exact value."""
    inputs = {"of": OCTAHEDRAL, "levels": measure.levels}
    used = {name: cages[name] for name in (*SADDLES, OCTAHEDRAL)}
    return Item(f"limit.{OCTAHEDRAL}", solve.extrapolate, inputs, frozenset({"table2"}), cages=used, cost=6.0)


def _figures(sphere: Cage, measure: Measure, draw: Mapping[str, Draw]) -> list[Item]:
    """The report's figures 1 to 3, on a sphere of few vertices."""
    cages = {"sphere": sphere}
    tags, inputs = frozenset({"figures"}), {"width": measure.width, "samples": measure.samples}
    return [
        Item("figure.flat", draw["flat"], inputs, tags, (), ("pictures/figure1.png",), True, 30.0, cages),
        Item("figure.refined", draw["refined"], inputs, tags, (), ("pictures/figure2.png",), True, 30.0, cages),
        Item("figure.blend", answers.blend_functions, {}, tags, (), ("pictures/figure3.svg",), cost=0.1),
    ]


def _answers_on_tori(torus: Callable[..., Cage], measure: Measure) -> list[Item]:
    """(a) Willmore by ratio and net; (b) and (c) third order by net and level."""
    parts: list[Item] = []

    def add(answer: str, net: tuple[int, int], ratio: float, energy: str, setting: str, levels: int) -> None:
        name = f"{answer}.{net[0]}x{net[1]}.{round(1000 * ratio):03d}.{setting}.{levels}"
        inputs = {"energy": energy, "setting": setting, "levels": levels, "net": net, "ratio": ratio}
        tags = frozenset({"answers", answer})
        cages = {name: torus(ratio, *net)}
        parts.append(Item(name, solve.minimize, inputs, tags, cages=cages, cost=1.5))

    for net in ((8, 4), (8, 8)):
        for ratio in (0.02, 0.05, *(k / 10 for k in range(1, 10)), 0.95, 0.98):
            add("tori", net, ratio, "willmore", "report", measure.levels)
    for answer, energy in (("cross", "mvs_cross"), ("mvs", "mvs")):
        for net in CROSS_NETS:
            add(answer, net, 0.5, energy, "default", 1)
        for levels in range(2, measure.levels + 2):
            add(answer, (8, 4), 0.5, energy, "default", levels)
    profile = Item(
        "tori.profile", torus_profile.scan, {"levels": measure.levels}, frozenset({"answers", "tori"}), cost=60.0
    )
    curves = [
        Item(f"{answer}.curves", torus_nets.curves, {"energy": energy}, frozenset({"answers", answer}),
             cages={f"{m}x{n}.{round(1000 * ratio)}": torus(ratio, m, n) for m, n in CROSS_NETS for ratio in RATIOS},
             cost=3.0)
        for answer, energy in (("cross", "mvs_cross"), ("mvs", "mvs"))
    ]  # fmt: skip
    return [*parts, profile, *curves, *_plots(parts)]


RATIOS = tuple(round(0.05 * k, 2) for k in range(2, 18))


def _plots(parts: list[Item]) -> list[Item]:
    """The plots of the answers on tori."""
    found = []
    for answer, work, more in (
        ("tori", torus_nets.plot_tori, ("tori.profile",)),
        ("cross", torus_nets.plot_third, ("cross.curves",)),
        ("mvs", torus_nets.plot_third, ("mvs.curves",)),
    ):
        needs = tuple(part.name for part in parts if answer in part.tags) + more
        tags, picture = frozenset({"answers", answer}), f"pictures/{answer}.svg"
        found.append(Item(f"answer.{answer}", work, {"answer": answer}, tags, needs, (picture,), cost=0.2))
    return found


def _answer_plane(cages: Mapping[str, Cage], measure: Measure) -> list[Item]:
    """(d): the minimizers of `plane` beside those of `polynomial`, at the same level."""
    tags, parts, pairs = frozenset({"answers", "plane"}), [], []
    for name in PLANE_CAGES:
        for energy in ("mvs", "mvs_cross"):
            pair = []
            for setting in ("default", "plane"):
                inputs = {"energy": energy, "setting": setting, "levels": min(measure.levels, PLANE_LEVELS)}
                part = f"plane.{name}.{energy}.{setting}"
                parts.append(Item(part, solve.minimize, inputs, tags, cages={name: cages[name]}, cost=6.0))
                pair.append(part)
            pairs.append((name, energy, *pair))
    inputs, needs = {"pairs": pairs}, tuple(part.name for part in parts)
    plot = ("pictures/plane.svg",)
    return [*parts, Item("answer.plane", answers.compare_plane, inputs, tags, needs, plot, cost=60.0)]


def _answer_saddles(
    cages: Mapping[str, Cage], measure: Measure, draw: Mapping[str, Draw]
) -> list[Item]:
    """(e): certificates without symmetry, where shapes go that are shaken, and where along the mode in which they
    fall."""
    tags, parts = frozenset({"answers", "saddles"}), []
    for name in SADDLES:
        for energy in solve.ENERGIES:
            for levels in {max(1, measure.levels - 1), measure.levels}:
                inputs = {"energy": energy, "levels": levels}
                verified = f"verify.{name}.{energy}.{levels}"
                parts.append(Item(verified, solve.verify, inputs, tags, cages={name: cages[name]}, cost=8.0))
            of = solve_name(name, energy, "default")
            for share, rounds in SHAKES if energy == "willmore" else THIRD_SHAKES:
                inputs = {"energy": energy, "of": of, "share": share, "rounds": rounds, "iterations": 400}
                shaken = shaken_name(name, energy, share, rounds)
                parts.append(Item(shaken, solve.shaken, inputs, tags, (of,), cost=20.0))
    for name in FALLING:
        parts += _falls(name, tags)
    needs = tuple(part.name for part in parts)
    inputs = {"width": measure.width, "samples": measure.samples}
    picture = Item("look.saddles", draw["look"], inputs, tags, needs, ("pictures/saddles.png",), True, 30.0)
    modes = Item("look.modes", draw["modes"], inputs, tags, needs, ("pictures/modes.png",), True, 20.0)
    plot = Item("answer.saddles", answers.plot_saddles, {}, tags, needs, ("pictures/saddles.svg",))
    return [*parts, picture, modes, plot]


def _answer_holes(make: Callable[..., Cage], measure: Measure, draw: Draw) -> list[Item]:
    """(f): minimizers of third order with more holes, and what the campaign's committed figures say."""
    tags, parts, families = frozenset({"answers", "holes"}), [], layouts.families(make)
    for family, cage, energy, levels in (entry for row in HOLES for entry in row):
        inputs = {"energy": energy, "setting": "default", "levels": min(levels, measure.levels + 1)}
        name = holes_name(family, cage, energy, levels)
        parts.append(Item(name, solve.minimize, inputs, tags, cages={cage: families[family][cage]}, cost=10.0))
    needs = tuple(part.name for part in parts)
    inputs = {"width": measure.width, "samples": measure.samples}
    picture = Item("look.holes", draw, inputs, tags, needs, ("pictures/holes.png",), True, 40.0)
    seen = {"digest": hashlib.sha256(genus.FILE.read_bytes()).hexdigest()}
    plots = Item("answer.holes", genus_plots.draw, seen, tags, ("look.holes",), genus_plots.FILES, cost=0.5)
    return [*parts, picture, plots]


def holes_name(family: str, cage: str, energy: str, levels: int) -> str:
    """The item that minimizes a third-order energy of a cage of `layouts`."""
    return f"holes.{genus.file_name(f'{family}_{cage}')}.{energy}.{levels}"


def _falls(name: str, tags: frozenset[str]) -> list[Item]:
    """The mode in which Willmore's minimizer of a cage falls, and both sides followed."""
    of, mode = solve_name(name, "willmore", "default"), mode_name(name)
    parts = [Item(mode, falling.mode, {"energy": "willmore"}, tags, (of,), cost=60.0)]
    for side, share in SIDES.items():
        inputs = {"energy": "willmore", "mode": mode, "share": share, "iterations": 400}
        parts.append(Item(fall_name(name, side), falling.fall, inputs, tags, (of, mode), cost=15.0))
    return parts

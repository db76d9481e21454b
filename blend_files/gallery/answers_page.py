# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's open questions and their answers, as sections of the page, written from the run's figures. No bpy."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape

from addon.core.energy import ENERGY_LABELS
from . import genus_page, solve
from .markup import command, grid, picture, section, significant
from .store import Store
from .torus_nets import exact_cross
from .torus_profile import CLIFFORD, RULES

_NOISE = 3e-4  # what net and quadrature leave open of int H^2


def sections(store: Store, fresh: Collection[str]) -> list[str]:
    """Those of the answers that are finished."""
    made = {"tori": _tori, "cross": _cross, "mvs": _mvs, "plane": _plane, "saddles": _saddles, "holes": genus_page.holes}
    return [write(store.result(f"answer.{name}")) for name, write in made.items() if f"answer.{name}" in fresh]


def _answer(name: str, title: str, text: Sequence[str], *parts: str) -> str:
    paragraphs = "".join(f"<p>{escape(paragraph)}</p>" for paragraph in text)
    return section(
        name, title, paragraphs, picture(f"pictures/{name}.svg", title), *parts, f"<pre>{command('--only ' + name)}</pre>"
    )


def _tori(result: Mapping[str, Sequence[Mapping]]) -> str:
    runs, profile = result["library"], result["profile"]
    there = [run for run in runs if run["resolved"] is not None and abs(run["resolved"] / CLIFFORD - 1) < 1e-4]
    text = [
        "The report: for most tori Willmore's optimization gave the Clifford torus; for a thin one a 'double sphere' "
        "with twice the energy of a sphere. Which go where?",
        f"Under the report's settings as the library has them (LMVM, its fixed rule), {len(there)} of {len(runs)} "
        f"tori, of ratio {min(run['ratio'] for run in runs):g} to {max(run['ratio'] for run in runs):g} on two nets, "
        f"end at the Clifford torus: 8π² = {CLIFFORD:.5f} by a fine rule, to 1e-4. (Or at one of its Moebius images, "
        "which have the same energy but another ratio of their extents.)",
        "The other outcome belongs to the rule, not to the torus. For tori of revolution we let a program that shares "
        "no code with the library minimize the same energy over the profile alone, level by level, with a fixed Gauss "
        "rule of 1, 2, 3 or 8 points a span: " + "; ".join(_rule(profile, points) for points in RULES) + ".",
        "With one or two points the optimizer finds shapes that the rule cannot see: the fold lies between its "
        "points. Which energy it stops at (16π = 50.27 is that of two spheres) depends on steps and levels, not on "
        "the ratio of the start: there is no range of ratios that goes there. What it calls two spheres cannot be one "
        "of energy 16π: a torus has ∫K = 0, so two nested spheres need necks between them; catenoids cost 8π each, "
        "two of them make it 32π = 100.5, more than the Clifford torus. The column of the fine rule says what these "
        "shapes really cost.",
    ]
    body = [
        (run["points"], f"{run['ratio']:g}", " ".join(significant(value, 4) for value in run["levels"]),
         significant(run["resolved"], 6), significant(run["gauss_bonnet_defect"], 2), run["went"])
        for run in profile
    ]  # fmt: skip
    heads = ("points a span", "ratio", "energy by the rule after each level", "by a fine rule", "|∫K|", "went to")
    more = [(run["net"], f"{run['ratio']:g}", significant(run["value"], 8), significant(run["resolved"], 8),
             significant(run["end_ratio"], 5)) for run in runs]  # fmt: skip
    more_heads = ("net", "ratio", "energy by the fixed rule", "by a fine rule", "r/R at the end")
    tables = (
        f"<details><summary>The library, as the report</summary>{grid(more_heads, more)}</details>"
        f"<details><summary>Profiles</summary>{grid(heads, body)}</details>"
    )
    return _answer("tori", "(a) Clifford torus or double sphere?", text, tables)


def _rule(profile: Sequence[Mapping], points: int) -> str:
    mine = [run for run in profile if run["points"] == points]
    there = sum(run["went"] == "Clifford torus" for run in mine)
    low = min(run["value"] for run in mine)
    return f"{points}: {there} of {len(mine)} at the Clifford torus, least energy by the rule {low:.2f}"


_NET_HEADS = ("net", "r/R at the end", "by the law", "least of the measured curve", "energy", "rule", "∫H²", "verdict")


def _third(result: Mapping[str, Sequence[Mapping]]) -> str:
    nets = [
        (row["net"], significant(row["ratio"], 4), significant(row["law_ratio"], 4), significant(row["curve_ratio"], 4),
         significant(row["value"], 6), significant(row["quadrature_error"], 2), significant(row["h2"], 6),
         row["verdict"])
        for row in result["nets"]
    ]  # fmt: skip
    levels = [
        (row["level"], row["vertices"], significant(row["ratio"], 4), significant(row["value"], 6),
         significant(row["net_share"], 2), significant(row["quadrature_error"], 2), significant(row["h2"], 7),
         row["verdict"])
        for row in result["levels"]
    ]  # fmt: skip
    heads = ("levels", "vertices", "r/R at the end", "energy", "net", "rule", "∫H²", "verdict")
    return (
        f"<p>One level, by net:</p>{grid(_NET_HEADS, nets)}<p>From a net of 8 x 4, by levels (each subdivides the "
        f"cage once more):</p>{grid(heads, levels)}"
    )


def _cross(result: Mapping[str, Sequence[Mapping]]) -> str:
    first, last = result["nets"][0], result["nets"][-1]
    text = [
        "The report: MVS_cross has an optimum torus of ratio about 0.5; which exactly?",
        "None. For the round torus of ratio ρ the energy is 8π⁴ (1 − ρ²)^(−3/2), which falls all the way to 8π⁴ = "
        f"{exact_cross(0):.2f} at ρ = 0. What stops it is the net: with m vertices round the axis and n round the "
        "tube, cubic B-splines add (4π⁴/3) (2π/n)² ρ⁻² + (2π⁴/3) (2π/m)² ρ² (1 + 2ρ²) (1 − ρ²)^(−5/2) to leading "
        "order, and the sum has a least value at a ratio that goes to 0 as nets become finer.",
        f"Measured: from {first['ratio']:.3f} on {first['net']} to {last['ratio']:.3f} on {last['net']} vertices; the "
        f"law says {first['law_ratio']:.3f} and {last['law_ratio']:.3f} for round tori (an optimizer may also leave "
        "those). The report's 0.5 is that of a coarse net. (Without the factor of area, and with the major radius "
        "held, the optimum would be 1/2 exactly.)",
    ]
    return _answer("cross", "(b) The MVS_cross torus", text, _third(result))


def _mvs(result: Mapping[str, Sequence[Mapping]]) -> str:
    levels = result["levels"]
    text = [
        "The report: MVS goes towards the Clifford torus and stops at a torus close to it. Why there, where all tori "
        "have MVS = 0?",
        "Because B-splines have no exact tori, and what they add decides: the two terms of (b), without the exact "
        "one. The first grows for thin tubes, the second for wide ones; their sum is least at a ratio of about 0.60 "
        "on a net of as many vertices round as across, and 0.69 on one with twice as many round the axis. The "
        "Clifford torus has 1/√2 = 0.707: near, by coincidence, and nothing draws MVS there.",
        f"Measured from 8 x 4: ratio {levels[0]['ratio']:.3f} with MVS {levels[0]['value']:.4g} at level "
        f"{levels[0]['level']}, {levels[-1]['ratio']:.3f} with {levels[-1]['value']:.4g} at level "
        f"{levels[-1]['level']}: the energy goes to 0 while the ratio stays near what the shape of the net gives it. "
        "(It ends a little above the law's since the optimizer also slides the net's lines, which the law holds "
        "equally spaced.)",
    ]
    return _answer("mvs", "(c) The MVS torus", text, _third(result))


def _plane(rows: Sequence[Mapping]) -> str:
    near, far = min(rows, key=lambda row: row["distance"]), max(rows, key=lambda row: row["distance"])
    text = [
        "The report: the surface representation does not greatly affect the minimizers. Does it?",
        "Here both surfaces are minimized alike, by our optimizer and adaptive quadrature; then shapes are laid over "
        f"each other. The mean distance is {100 * near['distance']:.2g} % ({near['cage']}, {ENERGY_LABELS[near['energy']]}) "
        f"to {100 * far['distance']:.2g} % ({far['cage']}, {ENERGY_LABELS[far['energy']]}) of the size. Energies differ by "
        "more: each flat spot of plane costs MVS, whatever the refinement, so its minimizers flatten what lies "
        "around; put on polynomial the same cages are not its minimizers, as the fifth column says.",
    ]
    heads = ("cage", "energy", "polynomial's minimizer", "plane's minimizer", "plane's, on polynomial",
             "polynomial's, on plane", "net", "rule", "mean distance, %", "farthest, %", "∫H²", "∫H², plane", "verdicts")  # fmt: skip
    body = [
        (row["cage"], ENERGY_LABELS[row["energy"]], significant(row["polynomial"], 5), significant(row["plane"], 5),
         significant(row["plane_minimizer_on_polynomial"], 5), significant(row["polynomial_minimizer_on_plane"], 5),
         _both(row["net_shares"]), _both(row["quadrature_errors"]),
         f"{100 * row['distance']:.2f}", f"{100 * row['farthest']:.1f}", significant(row["h2"][0], 5),
         significant(row["h2"][1], 5), " / ".join(row["verdicts"]))
        for row in rows
    ]  # fmt: skip
    return _answer("plane", "(d) How far plane moves the minimizers", text, grid(heads, body))


def _both(values: Sequence[float | None]) -> str:
    """Of `polynomial` and of `plane`."""
    return " / ".join(significant(value, 2) for value in values)


def _saddles(result: Mapping[str, Sequence[Mapping]]) -> str:
    verified, shaken = result["verified"], result["shaken"]
    text = [
        "The report: shapes of tetrahedral and cubical symmetry kept it. Are they minima?",
        "Among shapes of their symmetry, yes, where the table says so. To look at all others we count the negative "
        "directions of the Hessian without symmetry (--verify), and we shake: every vertex is moved at random, "
        "smoothly, by some part of the size, and the run goes on without symmetry for at most 400 steps. "
        + " ".join(_fate(shaken, cage, genus) for cage, genus in (("tetrahedral_g3", 3), ("cubical_g5", 5))),
        "The count needs a fine net: coarse ones hold a saddle that smooth surfaces do not. A small shake may "
        "therefore stay where it is for the net's sake; what falls under a larger one was no global minimum at any "
        "rate.",
    ]
    heads = ("cage", "energy", "levels", "vertices", "value", "net", "rule", "∫H²", "verdict, symmetry kept",
             "negative, symmetry kept", "negative, none kept")  # fmt: skip
    body = [
        (row["cage"], ENERGY_LABELS[row["energy"]], row["levels"], row["vertices"], significant(row["value"], 7),
         significant(row["net_share"], 2), significant(row["quadrature_error"], 2), significant(row["h2"], 7),
         row["verdict"], _counted(row["negative_directions"]),
         _counted(row["free_negative_directions"]))
        for row in verified
    ]  # fmt: skip
    more_heads = ("cage", "energy", "shaken by", "smoothed", "energy before", "shaken", "after", "∫H² before", "after",
                  "steps", "stop", "verdict")  # fmt: skip
    more = [
        (row["cage"], ENERGY_LABELS[row["energy"]], f"{row['share']:g}", row["rounds"],
         *(significant(row[k], 6) for k in ("before", "start", "value", "h2_before", "h2")),
         row["steps"], row["stop"], row["verdict"])
        for row in shaken
    ]  # fmt: skip
    return _answer(
        "saddles", "(e) Minima or saddles?", text, picture("pictures/saddles.png", "shaken"),
        f"<p>By the Hessian:</p>{grid(heads, body)}<p>Shaken:</p>{grid(more_heads, more)}", _modes(result["modes"]),
    )  # fmt: skip


def _modes(modes: Sequence[Mapping]) -> str:
    """The mode in which each saddle falls, and what it falls to."""
    text = (
        "In which direction do they fall? The middle column is coloured by the lowest eigenvector of the second "
        "variation for motion along normals, no symmetry kept: red moves outwards while blue moves inwards, or the other "
        "way round. Left and right of it is what the run comes to from either side. Where the eigenvalue is positive, "
        "this net holds the shape; rotations, translations and the other maps that keep Willmore's energy have "
        "eigenvalues that fall to 0 as nets become finer."
    )
    heads = ("cage", "∫H²", "lowest eigenvalues × size⁴", "directions", "side", "∫H² there", "net", "rule", "verdict")
    body = [
        (row["cage"], significant(row["h2"], 7), ", ".join(f"{value:.2f}" for value in row["lowest"][:8]),
         row["directions"], f"{side['share']:+g} of the size", significant(side["h2"], 7),
         significant(side["net_share"], 2), significant(side["quadrature_error"], 2), side["verdict"])
        for row in modes
        for side in row["sides"]
    ]  # fmt: skip
    return f"<p>{escape(text)}</p>{picture('pictures/modes.png', 'the mode in which saddles fall')}{grid(heads, body)}"


def _counted(number: int) -> str:
    return "not counted" if number < 0 else str(number)


def _fate(shaken: Sequence[Mapping], cage: str, genus: int) -> str:
    """Where Willmore's minimizer of a cage goes, in a sentence."""
    mine = [row for row in shaken if row["cage"] == cage and row["energy"] == "willmore"]
    fallen = [row for row in mine if row["h2"] < (1 - _NOISE) * row["h2_before"]]
    back = [row for row in mine if abs(row["h2"] / row["h2_before"] - 1) <= _NOISE]
    start, aim = mine[0]["h2_before"], solve.lawson_h2(genus)
    parts = [f"{cage}: Willmore's minimizer (∫H² {start:.4f})"]
    if fallen:
        lowest = min(row["h2"] for row in fallen)
        parts.append(
            f"fell from {len(fallen)} of {len(mine)} shakes ({_shakes(fallen)}), as far as to {lowest:.4f}, "
            f"{100 * (lowest / aim - 1):.2f} % above Lawson's surface of genus {genus} ({aim:.4f})"
        )
    if back:
        parts.append(f"{'and ' if fallen else ''}came back from {len(back)} ({_shakes(back)})")
    others = len(mine) - len(fallen) - len(back)
    if others:
        parts.append(f"({others} ended above: not resolved, or not at an end)")
    return " ".join(parts) + "."


def _shakes(rows: Sequence[Mapping]) -> str:
    return ", ".join(f"{row['share']:g} smoothed {row['rounds']} times" for row in rows)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's answer about MVS and MVS_cross of surfaces with more holes, from the campaign's figures. No bpy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from addon.core.energy import ENERGY_LABELS
from . import genus, genus_plots
from .markup import command, grid, picture, section, significant

_ARGUMENT = (
    "The report found MVS of genus 2 at one value, on one net. Is there a least value, and a shape that has it? MVS is the "
    "integral of (dk₁/de₁)² + (dk₂/de₂)²: how much each principal curvature changes along its own lines. It is 0 where "
    "neither does, which is so on Dupin's cyclides alone, spheres and tori among them; they have one hole at most. So with "
    "more holes MVS is above 0, and the question is whether a surface has the least, or whether one comes nearer to it for "
    "ever without getting there.",
    "A handle cannot just become small: multiplied by the area MVS does not see size, so a handle of a hundredth of the "
    "size costs ten thousand times what it costs at full size. But a neck may become thin. MVS does not ask how k₁ changes from one of its "
    "lines to the next: a surface of revolution has MVS = A · 2π ∫ r (dk/ds)² ds, with k the curvature of its profile "
    "alone, and a profile that is an arc of a circle costs nothing, however near it comes to the axis. The torus of ratio ρ "
    "has MVS = 0 for each ρ up to 1, where its hole closes and ∫H² = π² / (ρ √(1 − ρ²)) is infinite. Nothing in MVS "
    "holds a neck open; if the rest of the surface gains by it, the neck will close. MVS_cross does ask: its torus costs "
    "8π⁴ (1 − ρ²)^(−3/2), which is infinite for a closed neck.",
    "So we start from cages of ten layouts and more a family (arms with few or many rings, poles in the hubs or beside "
    "them, lines along the arms or across them, blocks of cubes), keep their symmetries, go as many levels as fit (up to "
    "7 000 vertices that no symmetry takes to each other; one more for the lowest of genus 2), and look at three figures: does the energy stop falling, do cages agree, and does "
    "the least radius of curvature stay? Where it falls by more than a quarter with a level while ∫H² rises, the surface is "
    "pinching.",
)
_BENT = (
    "The same without the net's help: Willmore's energy, which is infinite for a neck that closes along an arc, is added with "
    "less and less weight (30, 10, 3, 1, 0.3, and none), on the finest level. A curve on which MVS goes on falling while ∫H² rises "
    "speaks of necks that close; one that comes to an end speaks of a least value."
)
_HEADS = ("family", "cage", "energy", "symmetries", "levels", "vertices", "value", "net", "rule", "∫H²", "least radius",
          "verdict", "s")  # fmt: skip


def holes(result: Mapping[str, Sequence[Mapping]]) -> str:
    """The section, from the result of genus_plots.draw."""
    said = "".join(f"<li>{escape(sentence(found))}</li>" for found in result["findings"])
    plots = []
    for family in genus_plots.FAMILIES:
        names = [genus_plots.plot_file(family, which) for which in genus_plots.PLOTS]
        plots += [f"<h3>{escape(family)}</h3>", *(picture(name, f"{family}, by vertices") for name in names)]
    body = [
        (row["family"], row["cage"], ENERGY_LABELS[row["energy"]], f"{row['symmetry_order']:.0f}", f"{row['levels']:.0f}",
         f"{row['vertices']:.0f}", significant(row["value"], 5), significant(row["net_share"], 2),
         significant(row["quadrature_error"], 1), significant(row["h2"], 4), significant(row["least_radius"], 3),
         row["verdict"], f"{row['seconds']:.0f}")
        for row in result["runs"]
    ]  # fmt: skip
    free = "; ".join(
        f"{row['family']}, {ENERGY_LABELS[row['energy']]}: {row['lower']} of {row['cages']}"
        + (f", at most to {row['least']:.2f} of it" if row["lower"] else "")
        for row in result["fewer"]
        if row["cages"]
    )
    return section(
        "holes", "(f) MVS with more holes: is there a least?",
        *(f"<p>{escape(text)}</p>" for text in _ARGUMENT),
        picture("pictures/holes.png", "minimizers of MVS and MVS_cross with more holes"), f"<ul>{said}</ul>",
        f"<p>{escape(_BENT)}</p>", picture(genus_plots.BENT_FILE, "MVS against bending"),
        f"<p>With symmetries given up where that lowers the energy (four levels), lower than with all of them kept: {escape(free)}.</p>",
        *plots, f"<details><summary>All cages, finest level</summary>{grid(_HEADS, body)}</details>",
        "<p>These figures are those of a campaign, an hour of two cores, committed as "
        "<code>blend_files/gallery/data/genus.csv</code>; certificates are for up to 50 000 vertices (beyond: unknown).</p>"
        f"<pre>{command('--only holes')}</pre><pre>{command('--only ' + genus.TAG)}</pre>",
    )  # fmt: skip


def sentence(found: Mapping[str, object]) -> str:
    """What a family's cages say of an energy."""
    low = found["lowest"]
    head = f"{ENERGY_LABELS[found['energy']]}, {found['family']} ({found['cages']} cages): "
    lowest = (
        f"{significant(low['value'], 4)} on {low['vertices']:.0f} vertices from '{low['cage']}' "
        f"(net {significant(low['net_share'], 2)}, ∫H² {low['h2']:.2f}, least radius {low['least_radius']:.3f})"
    )
    others = [cage for cage in found["same"] if cage != low["cage"]]
    pinching = "; ".join(found["pinching"])
    if low["cage"] in found["pinching"]:
        text = f"the lowest is {lowest}, and is pinching: none of these shapes is a least one. Pinching are {pinching}"
    else:
        text = f"the lowest is {lowest}; {len(others)} more end at this shape" + (f" ({'; '.join(others)})" if others else "")
        if pinching:
            text += f"; pinching are {pinching}, from {significant(found['lowest_pinching'], 4)} on"
    rest = found["settled"] - len(found["same"])
    return f"{head}{text}." + (f" {rest} settle at other shapes, up to {significant(found['highest'], 4)}." if rest else "")

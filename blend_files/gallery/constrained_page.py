# SPDX-License-Identifier: GPL-3.0-or-later
"""The page's section on minimizers that enclose a volume or pass through rings. No bpy."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from html import escape

from addon.core.energy import ENERGY_LABELS
from . import constrained, theorems
from .markup import command, grid, picture, section, significant
from .store import Store

_VESICLES = (
    "Closed surfaces of one area that enclose a given part of a sphere's volume (the reduced volume), with the least "
    "bending ∫H²: what red blood cells and lipid vesicles look like. Long ones (prolate), flat ones (oblate) and cups "
    "(stomatocytes) are least in turn as the volume falls; the diagram has their energies, as lines by a program that shares "
    "no code with the library (the axisymmetric equations), as dots by the library."
)
_TORI = (
    "With a hole, every volume above the Clifford torus' (0.71) can be had for the same ∫H² = 2π²: the minimizers are its Moebius "
    "images, whose hole moves to the side and shrinks."
)
_RINGS = (
    "A vase through five rings: the middle three are curves that rows of the cage follow, the outer two are its open ends, "
    "which stay. In between the surface is as fair as it can be."
)
_HEADS = ("shape", "reduced volume", "∫H²", "exact", "net", "rule", "inside", "volume off by", "verdict", "vertices", "s")


def sections(store: Store, fresh: Collection[str]) -> list[str]:
    """The section, if its pictures are finished."""
    names = [name for name in constrained.VESICLES if f"vesicle.{name}" in fresh]
    if not {"constrained.vesicles", "constrained.tori_by_volume", "constrained.rings", "constrained.diagram"} <= set(fresh):
        return []
    body = [_row(name, store.result(f"vesicle.{name}")) for name in names]
    sources = sorted({vesicle.source for vesicle in constrained.VESICLES.values()})
    rings = [_ring_row(energy, store.result(f"rings.{energy}")) for energy in constrained.RING_ENERGIES]
    heads = ("energy", "before", "after", "net", "rule", "verdict", "vertices", "s")
    return [section(
        "constrained", "Shapes that have something to do",
        f"<p>{escape(_VESICLES)}</p>", picture("pictures/vesicles.png", "vesicles of one area"),
        picture("pictures/vesicle_phases.svg", "bending energy by reduced volume"),
        f"<p>{escape(_TORI)}</p>", picture("pictures/tori_by_volume.png", "tori of one area and one bending energy"),
        grid(_HEADS, body), f"<p>Exact values: {escape('; '.join(sources))}.</p>",
        f"<p>{escape(_RINGS)}</p>", picture("pictures/rings.png", "a vase through five rings"), grid(heads, rings),
        f"<pre>{command('--only constrained')}</pre>",
    )]  # fmt: skip


def _row(name: str, record: Mapping[str, object]) -> tuple[object, ...]:
    return (
        constrained.VESICLES[name].kind, f"{record['volume']:.2f}", significant(record["h2"], 8),
        significant(record["exact"], 8), significant(record["net_share"], 2), significant(record["quadrature_error"], 2),
        "yes" if theorems.inside(record, record["exact"]) else "no", significant(record["missed"], 1), record["verdict"], record["vertices"],
        f"{record['seconds']:.1f}",
    )  # fmt: skip


def _ring_row(energy: str, record: Mapping[str, object]) -> tuple[object, ...]:
    return (
        ENERGY_LABELS[energy], significant(record["start"], 5), significant(record["value"], 5),
        significant(record["net_share"], 2), significant(record["quadrature_error"], 2), record["verdict"],
        record["vertices"], f"{record['seconds']:.1f}",
    )  # fmt: skip

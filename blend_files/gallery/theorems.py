# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of least energies: exact values, whether a result's stated errors hold them, and what theorems make of
that. No bpy.

A run says that its result is a minimum among shapes nearby and of the symmetries that it kept. Theorems say more, where
the value is theirs within what net and quadrature leave open:

  genus 0, 1 `addon/core/least.py`
  Lawson's   least among surfaces of their genus with the symmetries of xi_{g,1} in the 3-sphere (Kusner, Lue, Wang 2024,
             arXiv 2410.12582). These are conformal maps of space; the rotations and reflections that a run keeps are some
             of them, so a run's own class is wider than the theorem's, and only the value says which surface it is. That
             the value is least of all surfaces of that genus is a conjecture (Kusner 1989)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from addon.core import least
from . import solve

SPHERES = ("sphere_cube",)
OPEN = ("branch_open",)  # with a boundary: none of this is about them
_GLOBAL = {
    0: "global minimum: no closed surface has less, and of genus 0 only round spheres have as little",
    1: "global minimum of genus 1",
}  # fmt: skip
_LAWSON = (
    "least among surfaces of its genus with all symmetries of Lawson's in the 3-sphere (Kusner, Lü, Wang 2024, arXiv "
    "2410.12582); among all of its genus a conjecture (Kusner 1989)"
)


def exact(cage: str, energy: str, euler: int) -> float | None:
    """The least energy of a cage's smooth shape; None where nobody knows it. W = 4 int H^2 - 4 pi chi; MVS is 0 for
    spheres and all round tori, MVS_cross for spheres."""
    if energy == "willmore":
        known = solve.exact_h2(cage)
        return 4 * (known[0] - math.pi * euler) if known else None
    round_shape = cage in SPHERES or (energy == "mvs" and cage.startswith("torus_"))
    return 0.0 if round_shape else None


def inside(record: Mapping[str, object], known: float | None) -> bool | None:
    """Whether the least energy lies within what a result says: not above it by more than the quadrature's error, and
    not below by more than that and the net's share. None where nothing is claimed: no minimum, or no estimate."""
    if known is None or record["net_share"] is None or record["verdict"] != "minimum":
        return None
    error = record["quadrature_error"]
    return -error <= record["value"] - known <= record["net_share"] + error


def said(cage: str, record: Mapping[str, object]) -> str:
    """What a theorem says of a result, or nothing. Of Willmore's energy of closed surfaces only."""
    if record["energy"] != "willmore" or cage in OPEN:
        return ""
    found = least.genus(record["euler"])
    if found in _GLOBAL:
        known = least.least("willmore", record["euler"])
        sure = inside(record, known) and least.is_least(
            record["value"], known, record["net_share"], record["quadrature_error"]
        )
        return f"{_GLOBAL[found]} ({least.SOURCES[found]})" if sure else ""
    lawson = cage.startswith("lawson_g") and inside(record, exact(cage, "willmore", record["euler"]))
    return _LAWSON if lawson else ""


def is_global(cage: str, record: Mapping[str, object]) -> bool:
    """Whether a result is known to be a global minimum."""
    return said(cage, record).startswith("global")

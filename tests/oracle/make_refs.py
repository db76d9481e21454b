# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the cages of tests/cages/numeric and their energies, cage_refvals.json, by the oracle alone (20 minutes).

Each value stands beside `error`, its largest change from coarser rules of the oracle. `limit` holds what exists without
third derivatives at extraordinary vertices; `plane` is there for cages whose extraordinary vertices are apart.
"""
from __future__ import annotations

import json
from pathlib import Path

from ccref import Mesh
from energy_ref import energies
from nets import check_manifold, euler, named_cages, read_obj, sphere_like, write_obj

HERE = Path(__file__).resolve().parent
CAGES = HERE.parent / "cages" / "numeric"
PLANE = ("star_xyz_2", "star_xyz_3", "kites_5_quads", "kites_6_quads", "kites_7_quads")


def pair(fine: dict[str, float], *coarse: dict[str, float]) -> dict[str, dict[str, float]]:
    """Values with their largest change from a coarser rule."""
    return {name: {"value": fine[name], "error": max(abs(fine[name] - c[name]) for c in coarse)} for name in fine}


def plane_refs(mesh: Mesh) -> dict[str, dict[str, float]]:
    """Values on `plane`. MVS converges slowly and not monotonically: its integrand jumps at umbilics."""
    rules = ((12, 4), (12, 3), (11, 4), (9, 4))
    return pair(*(energies(mesh, "plane", n_gauss=n, levels=levels, depth=24) for n, levels in rules))


def main() -> None:
    """Write cages and values."""
    cages = named_cages()
    for n in (2, 3):
        cages[f"star_xyz_{n}"] = sphere_like(n, "star_xyz")
    CAGES.mkdir(parents=True, exist_ok=True)
    out: dict[str, dict] = {}
    for name, mesh in sorted(cages.items()):
        check_manifold(mesh)
        mesh = read_obj(write_obj(CAGES / f"{name}.obj", mesh))
        out[name] = {"euler": euler(mesh)}
        out[name]["limit"] = pair(energies(mesh, n_gauss=8, levels=2, depth=60),
                                  energies(mesh, n_gauss=6, levels=2, depth=50))
        if name in PLANE:
            out[name]["plane"] = plane_refs(mesh)
        print(name, out[name], flush=True)
    text = json.dumps(out, indent=1, sort_keys=True)
    (HERE / "cage_refvals.json").write_text(text + "\n", encoding="ascii")


if __name__ == "__main__":
    main()

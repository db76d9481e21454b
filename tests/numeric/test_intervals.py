# SPDX-License-Identifier: GPL-3.0-or-later
"""What is claimed of every energy, value +- quadrature error, is an interval that others of the same energy overlap: by a
finer rule, of the subdivided cage, and by an evaluator that shares no code with the library. Cages are the corpus's, which
chose no constant.

By default 36 cages, and of them three by the oracle; with CURVOPT_LONG=1 1000, of the first 500 all that the oracle can do. Claims were
chosen on even seeds below 500, but the part of the last change on all of these: seeds from 500 on chose nothing.

    python3 tests/numeric/test_intervals.py 0:500 --oracle willmore:1 mvs:4

prints how far the claims are used up: 1 is an error as large as both claims together. WILLMORE:N is each N-th cage by the
oracle.
"""
from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Iterator, NamedTuple

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / name) for name in ("oracle", "cages", "corpus")]

import lib  # noqa: E402
import cages  # noqa: E402
from ccref import Mesh, mesh_from_faces, topology  # noqa: E402
from settled_ref import settled  # noqa: E402

SEEDS = range(1000 if lib.LONG else 36)
BY_ORACLE = range(500) if lib.LONG else (0, 4, 6)
FINER = 100      # times the tolerance of the finer rule goes into the default
ROUNDING = 1e-12  # of the value
BLENDED = 12     # faces of a pole from which `limit` has a blend, which subdivision makes narrower
SECOND = ("willmore", "mean_curvature")
THIRD = ("mvs", "mvs_cross", "variation", "mehlum_tarrou")
MIX = {name: 1.0 for name in (*SECOND, *THIRD)}

# Claims that are known to fall short (libcurvopt/notes/23-claimed-quadrature-error.md): of each seed how far at most, rounded
# up. All others hold. Who mends one takes it out.
KNOWN = {89: 1.02, 865: 1.14, 982: 1.12}
TORN = {204: 3.44}  # by the oracle: the claim is larger than the energy


class Claim(NamedTuple):
    """An energy and how far off it is at most, by whoever computed it."""

    value: float
    error: float


def excess(one: Claim, other: Claim) -> float:
    """Distance of the values over what both claims allow; above 1 the intervals do not overlap."""
    allowed = one.error + other.error + ROUNDING * abs(one.value)
    return abs(one.value - other.value) / allowed if allowed else float(one.value != other.value)


def cage(seed: int) -> Mesh:
    """The corpus's cage."""
    xyz, faces, _ = cages.cage(seed)
    return mesh_from_faces(xyz, faces)


def is_closed(mesh: Mesh) -> bool:
    """Whether each edge has two faces."""
    return bool((topology(mesh).n_edge_faces == 2).all())


def most_faces(mesh: Mesh) -> int:
    """Of a vertex."""
    return int(np.bincount(mesh.flat).max())


def claims(mesh: Mesh, weights: dict[str, float] | str, surface: str, **fields) -> dict[str, Claim]:
    """Everything that an evaluation claims: the objective, the area and the terms that the surface has."""
    got = lib.evaluate(mesh, weights, surface, threads=1, **fields)
    out = {"objective": Claim(got.objective, got.objective_error), "surface area": Claim(got.area, got.area_error)}
    for i, name in enumerate(lib.WEIGHTS):
        if np.isfinite(got.term[i]):
            out[name] = Claim(got.term[i], got.term_error[i])
    return out


def compare(one: dict[str, Claim], other: dict[str, Claim], names: tuple[str, ...], kind: str) -> dict[str, float]:
    """Excess of each of these energies that both have."""
    return {f"{kind}: {name}": excess(one[name], other[name]) for name in names if name in one and name in other}


def by_finer_rules(mesh: Mesh) -> dict[str, float]:
    """Both surfaces, all energies, and a mix of all as the objective."""
    found, names = {}, ("objective", "surface area", *lib.WEIGHTS)
    for surface, weights in (("limit", "willmore"), ("polynomial", MIX)):
        try:
            one, other = (claims(mesh, weights, surface, tolerance=t) for t in (1e-4, 1e-4 / FINER))
        except lib.CurvoptError as error:
            if "no face is left" not in str(error):
                raise
            continue
        found |= compare(one, other, names, f"finer, {surface}")
    return found


def by_subdivided_cage(mesh: Mesh) -> dict[str, float]:
    """Energies on `limit`, whose surface subdivision does not change: without blends, on closed cages. The term `area` is
    over the size of the cage, and MVS is smoothed at umbilics by it; both change."""
    if not is_closed(mesh) or most_faces(mesh) >= BLENDED:
        return {}
    names = ("objective", "surface area", *SECOND, "variation", "mehlum_tarrou")
    return compare(claims(mesh, "willmore", "limit"), claims(lib.refine(mesh), "willmore", "limit"), names, "subdivided")


def by_oracle(mesh: Mesh, energy: str) -> dict[str, float]:
    """WILLMORE on `limit` or MVS on `polynomial` of one face, by squares that are cut until they stand still."""
    if not is_closed(mesh) or (energy == "willmore" and most_faces(mesh) >= BLENDED):
        return {}
    surface = "limit" if energy == "willmore" else "polynomial"
    value, error = settled(mesh, energy, 1e-5)
    return {f"oracle: {energy}": excess(claims(mesh, energy, surface, blend_width=1)["objective"], Claim(value, error))}


def check(found: dict[str, float], most: float = 1.0) -> None:
    """No interval apart from another; or, where that is known, by so much. Those of the subdivided cage never are."""
    apart = {name: value for name, value in found.items() if not value <= (1 if name.startswith("subdivided") else most)}
    assert not apart, apart


@pytest.mark.parametrize("seed", SEEDS)
def test_claims_hold_by_finer_rules_and_of_the_subdivided_cage(seed: int):
    mesh = cage(seed)
    found = by_finer_rules(mesh)
    assert found
    found |= by_subdivided_cage(mesh)
    check(found, KNOWN.get(seed, 1.0))
    if seed in KNOWN:
        assert max(found.values()) > 1, "the claims hold now: take the seed out of KNOWN"


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
@pytest.mark.parametrize("seed", BY_ORACLE)
def test_claims_hold_by_an_evaluator_of_its_own(seed: int, energy: str):
    mesh = cage(seed)
    found = by_oracle(mesh, energy)
    assert found or lib.LONG, "the oracle cannot do this cage: take another seed"
    check(found, TORN.get(seed, 1.0))


def test_intervals_that_do_not_overlap_are_seen():
    one = Claim(10.0, 0.1)
    assert excess(one, Claim(10.15, 0.1)) < 1 < excess(one, Claim(10.25, 0.1))
    with pytest.raises(AssertionError):
        check({"apart": excess(one, Claim(10.25, 0.1))})
    with pytest.raises(AssertionError):
        check({"nothing": float("nan")})
    with pytest.raises(AssertionError):
        check({"subdivided": 1.1}, 1.2)
    check({"finer": 1.1}, 1.2)


def measure(seeds: range, oracle: dict[str, int]) -> Iterator[tuple[int, str, float]]:
    """Seed, what was compared, and its excess."""
    for seed in seeds:
        mesh = cage(seed)
        found = by_finer_rules(mesh) | by_subdivided_cage(mesh)
        for energy, every in oracle.items():
            if seed % every == 0:
                found |= by_oracle(mesh, energy)
        for name, value in found.items():
            yield seed, name, value


def main() -> None:
    """Prints a table of how far claims are used up."""
    parser = argparse.ArgumentParser(description="How far the claimed errors of energies are used up.")
    parser.add_argument("seeds", type=cages.parse_seeds, metavar="FIRST:END")
    parser.add_argument("--oracle", nargs="*", default=[], metavar="ENERGY:N")
    arguments = parser.parse_args()
    every = {name: int(n) for name, n in (text.split(":") for text in arguments.oracle)}
    table: dict[str, list[tuple[float, int]]] = {}
    for seed, name, value in measure(arguments.seeds, every):
        table.setdefault(name, []).append((value, seed))
        if not value <= 1:
            print(f"seed {seed}, {name}: {value:.3f}", flush=True)
    print("| compared | cages | median | 95 % | most | seed | beyond |\n| --- | --- | --- | --- | --- | --- | --- |")
    for name, rows in table.items():
        values = np.sort([value for value, _ in rows])
        print(f"| {name} | {len(rows)} | {np.median(values):.3f} | {values[int(.95 * (len(values) - 1))]:.3f} | "
              f"{values[-1]:.3f} | {max(rows)[1]} | {(~(values <= 1)).sum()} |")


if __name__ == "__main__":
    main()

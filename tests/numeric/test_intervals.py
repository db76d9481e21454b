# SPDX-License-Identifier: GPL-3.0-or-later
"""What is claimed of every energy, value +- quadrature error, is an interval that others of the same energy overlap: by a
finer rule, of the subdivided cage, and by two evaluators that share no code with the library: numpy's, of closed cages
(settled_ref.py), and OpenSubdiv's, of any (settled_osd.py). Cages are the corpus's, which chose no constant.

By default 36 cages, and three whose errors at umbilics finer rules hide; of them a few by the other evaluators. With
CURVOPT_LONG=1 1003, of the first 500 all that the evaluators can do. Claims were chosen on even seeds below 500, but the part
of the last change on all of these: seeds from 500 on chose nothing.

    python3 tests/numeric/test_intervals.py 0:500 --oracle limit:1 polynomial:1 opensubdiv:4

prints how far the claims are used up: 1 is an error as large as both claims together. LIMIT:N is each N-th cage on `limit` by
numpy, and OPENSUBDIV:N by OpenSubdiv.
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
from settled_osd import settled_osd  # noqa: E402
from settled_ref import settled_all  # noqa: E402

AT_UMBILICS = (89, 865, 982)  # rules agree with each other there, and not with the integral
IN_WIDE_BLENDS = (1612, 1613)
SEEDS = (*range(1000), 1081, *IN_WIDE_BLENDS) if lib.LONG else (*range(36), *AT_UMBILICS)
ORACLES = {"limit": (0, 4, 6), "polynomial": (0, 4, 6, *AT_UMBILICS), "opensubdiv": (6, 25, 430)}  # seeds by default
BY_ORACLE = [(oracle, seed) for oracle, few in ORACLES.items() for seed in (range(500) if lib.LONG else few)]
FINER = 100      # times the tolerance of the finer rule goes into the default
ROUNDING = 1e-12  # of the value
DIGITS = 1e-10   # of an evaluator: of seed 9's area, known to 1e-12, OpenSubdiv's sums are 5e-11 off, and estimate 4e-11
BLENDED = 12     # faces of a pole from which `limit` has a blend, which subdivision makes narrower
SECOND = ("willmore", "mean_curvature")
THIRD = ("mvs", "mvs_cross", "variation", "mehlum_tarrou")
MIX = {name: 1.0 for name in (*SECOND, *THIRD)}

# Claims that are known to fall short (libcurvopt/notes/23-claimed-quadrature-error.md): of each seed how far at most, rounded
# up. All others hold. Who mends one takes it out.
KNOWN = {1612: 2.24, 1613: 1.02}
TORN = {204: 3.44, 402: 1.34, 465: 2.39}  # by numpy's evaluator: the claims are larger than the energies


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


def by_oracle(mesh: Mesh, oracle: str) -> dict[str, float]:
    """All that another evaluator has, by squares that are cut until they stand still: numpy's energies of closed cages on
    `limit`, without blends, or `polynomial` with blends of one face; or OpenSubdiv's on `limit`. None: it has no such."""
    surface = "polynomial" if oracle == "polynomial" else "limit"
    if (surface == "limit" and most_faces(mesh) >= BLENDED) or (oracle != "opensubdiv" and not is_closed(mesh)):
        return {}
    found = settled_osd(mesh, 1e-5) if oracle == "opensubdiv" else settled_all(mesh, surface, 1e-5)
    ours = claims(mesh, "willmore" if surface == "limit" else MIX, surface, blend_width=1)
    theirs = {name: Claim(value, off + DIGITS * abs(value)) for name, (value, off) in found.items()}
    return compare(ours, theirs, tuple(found), f"oracle, {oracle}")


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


@pytest.mark.parametrize("oracle,seed", BY_ORACLE)
def test_claims_hold_by_an_evaluator_of_its_own(oracle: str, seed: int):
    mesh = cage(seed)
    found = by_oracle(mesh, oracle)
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
        for name, every in oracle.items():
            if seed % every == 0:
                found |= by_oracle(mesh, name)
        for name, value in found.items():
            yield seed, name, value


def main() -> None:
    """Prints a table of how far claims are used up."""
    parser = argparse.ArgumentParser(description="How far the claimed errors of energies are used up.")
    parser.add_argument("seeds", type=cages.parse_seeds, metavar="FIRST:END")
    parser.add_argument("--oracle", nargs="*", default=[], metavar="EVALUATOR:N")
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

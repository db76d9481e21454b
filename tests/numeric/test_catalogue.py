# SPDX-License-Identifier: GPL-3.0-or-later
"""The catalogue of cages: deep refinement against OpenSubdiv on all of it, the library on what it takes in."""
from __future__ import annotations

import numpy as np
import pytest

import lib
from catalogue import Case, catalogue, closed_cases
from ccref import deep_jets
from osd import osd_jets

CASES = catalogue()
CLOSED = closed_cases()


def locations(case: Case, n: int, seed: int):
    """Random points of the cage's faces, not closer to an edge than OpenSubdiv isolates."""
    mesh = case.mesh
    rng = np.random.default_rng(seed)
    face = rng.integers(0, mesh.n_faces, n)
    corner = np.where(mesh.sizes[face] == 4, 0, rng.integers(0, 27720, n) % mesh.sizes[face])
    return face, corner, rng.uniform(0.02, 0.98, (n, 2))


def relative(one: np.ndarray, two: np.ndarray, size: float) -> np.ndarray:
    """Errors [n, 6] relative to the size, or to the derivative where that is larger."""
    return np.abs(one - two).max(axis=2) / np.maximum(np.abs(two).max(axis=2), size)


def test_catalogue_is_large_enough():
    valences = {int(name.split("_")[1]) for name in CLOSED if name.startswith("bipyramid")}
    assert len(CASES) >= 60 and valences == set(range(3, 13))
    assert sum(case.boundary == "corners" for case in CASES.values()) >= 10
    assert sum(len(case.mesh.creases) > 0 for case in CASES.values()) >= 15


@pytest.mark.parametrize("name", CASES)
def test_deep_refinement_agrees_with_opensubdiv(name):
    case = CASES[name]
    face, corner, uv = locations(case, 60, 1)
    ours = deep_jets(case.reference(), face, corner, uv)[:, :6].astype(float)
    theirs = osd_jets(case.mesh, face, corner, uv, case.boundary).jets
    error = relative(ours, theirs, np.ptp(case.mesh.xyz, axis=0).max())
    at = int(error.max(axis=1).argmax())
    where = f"worst {error.max():.1e} at face {face[at]}, corner {corner[at]}, uv {uv[at]}"
    assert error[:, 0].max() <= 1e-10, where
    assert error[:, 1:].max() <= 1e-8, where


@pytest.mark.parametrize("name", CASES)
def test_library_agrees_with_opensubdiv(name, capsys):
    case = CASES[name]
    face, corner, uv = locations(case, 200, 2)
    ours = lib.jets(case.mesh, face, corner, uv, boundary_rule=int(case.boundary == "corners"))[:, :6]
    theirs = osd_jets(case.mesh, face, corner, uv, case.boundary).jets
    error = relative(ours, theirs, np.ptp(case.mesh.xyz, axis=0).max())
    at = int(error.max(axis=1).argmax())
    with capsys.disabled():
        print(f"\n  {name}: worst {error.max():.1e} at face {face[at]}")
    assert error[:, 0].max() <= 1e-10 and error[:, 1:].max() <= 1e-8

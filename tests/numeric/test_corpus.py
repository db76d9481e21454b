# SPDX-License-Identifier: GPL-3.0-or-later
"""The held-out corpus stays what it is: cages are manifolds, accepted, alike in every call and on every machine."""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import lib
from ccref import mesh_from_faces, topology
from nets import connected, euler

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import cages  # noqa: E402
from tables import FAMILIES  # noqa: E402

SEEDS = range(30)
CHECKSUM = "5b6e60a7cb5654607f47a645b35385fb3878cc58629bb068b7117f6d5aa2ad50"


@pytest.mark.parametrize("seed", SEEDS)
def test_cage(seed):
    """A connected manifold, closed unless its name says so, that the library takes."""
    xyz, faces, name = cages.cage(seed)
    mesh = mesh_from_faces(xyz, faces)
    cages.check(mesh)
    assert connected(mesh) and 6 <= len(xyz) <= cages.LARGEST and min(map(len, faces)) >= 3
    assert (topology(mesh).n_edge_faces == 2).all() != name.startswith("open")
    assert name.startswith(FAMILIES[seed % len(FAMILIES)])
    got = lib.evaluate(mesh, "willmore", threads=1)
    assert np.isfinite(got.objective) and (got.objective >= 4 * np.pi or name.startswith("open"))
    if name.startswith("frame"):
        assert euler(mesh) == 2 - 2 * int(name.split("_")[2])


def test_cages_are_the_same_in_every_call():
    for seed in SEEDS:
        one, other = cages.cage(seed), cages.cage(seed)
        assert np.array_equal(one[0], other[0]) and one[1:] == other[1:]


def test_cages_are_the_same_on_every_machine():
    """What was published holds for these cages; a generator that changes them makes another corpus."""
    assert cages.checksum(SEEDS) == CHECKSUM


@pytest.mark.parametrize("faces, why", [
    ([[0, 1, 2], [0, 1, 3]], "an edge has two faces on one side"),
    ([[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]], "a vertex joins two fans"),
    ([[0, 1, 2], [0, 2, 3]], "has one face"),
])
def test_check_refuses(faces, why):
    with pytest.raises(ValueError, match=why):
        cages.check(mesh_from_faces(np.eye(7)[:, :3], faces))

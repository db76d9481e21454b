# SPDX-License-Identifier: GPL-3.0-or-later
"""Principal curvatures that springs draw (curvopt_through.weights below 1): the springs' energy is its definition, by OpenSubdiv, on
every level; forces balance, by B-splines; curvatures tend to the wanted ones as the weight goes to 1; size and pose do not matter;
what is refused, by number. With CURVOPT_LONG=1 more cages and energies."""
from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

import lib
import test_through as points
import test_through_curvatures as curved
import test_through_frames as frames
import test_through_springs as springs
from ccref import Mesh
from nets import read_obj, torus_cage, write_obj
from osd import osd_jets

NONE, FREE_SPACING = 1, 2
HELD, LINE, PLANE, FREE = range(4)
NAN = float("nan")
unit = frames.unit


def turned(tensors: np.ndarray, normals: np.ndarray, to: np.ndarray) -> np.ndarray:
    """Tensors [n, 3, 3] in planes across `normals`, turned to planes across `to` by the least turn: of the axis across both, by
    Rodrigues' formula."""
    goal = to * np.sign((normals * to).sum(1))[:, None]
    out = []
    for tensor, a, b in zip(tensors, normals, goal):
        x, y, z = np.cross(a, b)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + cross + cross @ cross / (1 + a @ b)
        out.append(turn @ tensor @ turn.T)
    return np.array(out)


def off(jets: np.ndarray, wanted: curved.Wishes) -> np.ndarray:
    """Frobenius norms [n] of second forms less those that are wanted."""
    normals, found = curved.forms(jets)
    wish = curved.tensors(wanted.normals, wanted.directions, wanted.k)
    return np.sqrt(((found - turned(wish, wanted.normals, normals)) ** 2).sum((1, 2)))


def soft(wanted: curved.Wishes, weights: np.ndarray) -> lib.Through:
    through = dict(**wanted.where.fields(), freedom=wanted.freedom, directions=wanted.normals, places=wanted.places,
                   normals=wanted.normals, curvatures=wanted.k, curvature_directions=wanted.directions)
    return lib.through(**through, weights=weights)


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("seed, refined, energies", curved.CAGES + curved.MORE if lib.LONG else curved.CAGES[::2])
def test_the_springs_energy_is_its_definition(seed, refined, energies, levels, capsys):
    wanted = curved.Wishes(seed, refined)
    n, size, energy = wanted.where.n, springs.radius(wanted.mesh), {"w": "willmore", "m": "mvs"}[energies[levels - 1]]
    weights = np.random.default_rng(seed).uniform(0.2, 0.8, n)
    result = lib.minimize(wanted.mesh, energy, levels=levels, through=soft(wanted, weights))
    jets, first = curved.look(wanted.where, result.mesh, levels), wanted.mesh
    for _ in range(levels - 1):
        first = lib.refine(first)
    before = curved.look(wanted.where, first, levels)
    k = springs.STIFFNESS[energy] * weights / (1 - weights)
    far = np.array([springs.projector(f, d) @ np.where(f == FREE, 0, x) for f, d, x in
                    zip(wanted.freedom, wanted.normals, np.where(wanted.freedom[:, None] == FREE, 0, jets[:, 0] - wanted.places))]) / size
    tangents = np.array([springs.orthonormal(a) @ b for a, b in zip(before[:, 1:3], jets[:, 1:3])])
    slope = np.einsum("nkc,nc->nk", tangents, wanted.normals)
    bent = off(jets, wanted)
    total = springs.sum_of(k, far, slope) + (k * (size * bent) ** 2).sum() / 2
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels, {energy}, {wanted.where.n_v} vertices and {len(wanted.where.faces)} places: "
              f"{result.verdict}, {result.summary.seconds:.2f} s, springs {total:.4g}, by curvatures {(k * (size * bent) ** 2).sum() / 2:.4g}, "
              f"beside {result.summary.end.objective:.4g}; {abs(result.summary.spring_energy / total - 1):.1e}")
    assert result.verdict == "minimum"
    assert abs(result.summary.spring_energy - total) <= 1e-6 * total

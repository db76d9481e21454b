# SPDX-License-Identifier: GPL-3.0-or-later
"""Long campaigns on what a result says about its own error; they run with CURVOPT_LONG=1, a sample of them always.

`quadrature_error` must be at least a tenth of the true error in 99 % of the cages and never more than 1e3 times it
(errors below 1e-9 of the energy count as rounding); the true error is that against the oracle.
"""
from __future__ import annotations

from math import pi

import numpy as np
import pytest

import energy_ref
import lib
from ccref import Mesh
from nets import euler, genus_cage, mixed_cage, perturbed, random_voxels, torus_cage

COUNT = 500 if lib.LONG else 4
SEEDS = 20 if lib.LONG else 2


def random_cage(seed: int) -> Mesh:
    """Tori, frames, voxel surfaces of genus 0 to 5 and mixed polygons, moved by up to 30 % of an edge."""
    rng = np.random.default_rng(seed)
    kind, genus = seed % 4, int(rng.integers(0, 6))
    if kind == 0:
        mesh = torus_cage(int(rng.integers(5, 13)), int(rng.integers(4, 9)), float(rng.uniform(0.2, 0.7)))
    elif kind == 1:
        mesh = genus_cage(max(genus, 1))
    elif kind == 2:
        mesh = random_voxels(genus, seed, 15)
    else:
        mesh = mixed_cage(seed % 7)
    return perturbed(mesh, float(rng.uniform(0, 0.15)), seed)


def test_random_cages_know_their_error(capsys):
    low, high, gauss = [], [], []
    for seed in range(COUNT):
        mesh = random_cage(seed)
        got = lib.evaluate(mesh, "willmore", "limit")
        oracle = energy_ref.energies(mesh, n_gauss=8, levels=1, depth=50)
        floor = 1e-9 * oracle["willmore"]
        true = max(abs(got.objective - oracle["willmore"]), floor)
        claimed = max(got.objective_error, floor)
        low += [seed] if claimed < true / 10 else []
        high += [seed] if claimed > 1e3 * true else []
        if abs(got.gauss - 2 * pi * euler(mesh)) > got.gauss_bonnet_defect * (1 + 1e-9) + 1e-12:
            gauss.append(seed)
    with capsys.disabled():
        print(f"\n  {COUNT} cages: claimed error too small {low}, too large {high}, Gauss-Bonnet {gauss}")
    assert len(low) <= 0.01 * COUNT and not high and not gauss


@pytest.mark.parametrize("seed", range(SEEDS))
def test_strong_runs_do_not_fall_through_the_quadrature(seed):
    """Torus 8 x 4, perturbed starts, many iterations: W stays above 8 pi^2 less its error, and the oracle confirms."""
    start = perturbed(torus_cage(8, 4, 0.5), 0.15, seed)
    result = lib.minimize(start, "willmore", levels=4 if lib.LONG else 2, max_iterations=2000)
    end = result.summary.end
    oracle = energy_ref.energies(result.mesh, n_gauss=8, levels=0)["willmore"]
    assert end.objective >= 8 * pi ** 2 - end.objective_error - 1e-6
    assert abs(end.objective - oracle) <= 10 * end.objective_error + 1e-6 * oracle

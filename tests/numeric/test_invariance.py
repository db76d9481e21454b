# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies do not change with place, orientation, size, numbering or the number of threads."""
from __future__ import annotations

import functools

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import mixed_cage, perturbed, quad_cage, sphere_like, subdivided_cube, torus_cage, trapezohedron

CASES = {
    "torus": (perturbed(torus_cage(8, 6, 0.45), 0.15, 1), "limit"),
    "mixed": (mixed_cage(0), "limit"),
    "star": (sphere_like(3, "star_xyz"), "plane"),
    "kites_7": (quad_cage(trapezohedron(7), 7, 0.1), "plane"),
    "wide": (perturbed(sphere_like(8, "star_xyz", subdivided_cube), 0.05, 2), "polynomial"),
}


def terms(mesh: Mesh, surface: str, **fields) -> np.ndarray:
    """The scale invariant numbers of a cage; third-order ones where the surface gives them."""
    weights = "willmore" if surface == "limit" else "mvs"
    got = lib.evaluate(mesh, weights, surface, **fields)
    values = [got.value(name) for name in lib.TERMS if not np.isnan(got.value(name))]
    assert len(values) == (1 if surface == "limit" and (mesh.sizes != 4).any() else 5)
    return np.array([*values, got.h2])


@functools.cache
def of_case(case: str) -> np.ndarray:
    """The numbers of the case as it is."""
    return terms(*CASES[case])


def rotation(seed: int) -> np.ndarray:
    """A random proper rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def relabelled(mesh: Mesh, seed: int) -> Mesh:
    """The same cage with vertices and faces renumbered and faces starting at other corners."""
    rng = np.random.default_rng(seed)
    to = rng.permutation(mesh.n_vertices)
    xyz = np.empty_like(mesh.xyz)
    xyz[to] = mesh.xyz
    faces = mesh.face_list()
    faces = [faces[i] for i in rng.permutation(len(faces))]
    faces = [list(np.roll([int(to[i]) for i in f], int(rng.integers(0, len(f))))) for f in faces]
    return mesh_from_faces(xyz, faces)


@pytest.mark.parametrize("case", CASES)
def test_rigid_motion(case):
    mesh, surface = CASES[case]
    one = of_case(case)
    for seed in range(2):
        moved = mesh.with_xyz(mesh.xyz @ rotation(seed).T + [3.0, -2.0, 5.0])
        assert np.abs(terms(moved, surface) / one - 1).max() <= 1e-10


@pytest.mark.parametrize("case", CASES)
def test_scaling(case):
    mesh, surface = CASES[case]
    one = of_case(case)
    for scale in (1e-3, 1e4):
        assert np.abs(terms(mesh.with_xyz(mesh.xyz * scale), surface) / one - 1).max() <= 1e-10


@pytest.mark.parametrize("case", CASES)
def test_relabelling(case):
    mesh, surface = CASES[case]
    one = of_case(case)
    for seed in range(2):
        assert np.abs(terms(relabelled(mesh, seed), surface) / one - 1).max() <= 1e-10


@pytest.mark.parametrize("case", CASES)
def test_mirror_image(case):
    """Reflected and turned inside out again: all energies are even in the normal."""
    mesh, surface = CASES[case]
    mirror = mesh_from_faces(mesh.xyz * [1, 1, -1], [f[::-1] for f in mesh.face_list()])
    assert np.abs(terms(mirror, surface) / of_case(case) - 1).max() <= 1e-10


@pytest.mark.parametrize("case", CASES)
def test_number_of_threads(case):
    mesh, surface = CASES[case]
    weights = "willmore" if surface == "limit" else "mvs"
    found = []
    for threads in (1, 2, 3):
        problem = lib.Problem(mesh, lib.options(weights, surface, threads=threads))
        energies, gradient = problem.evaluate(mesh.xyz, gradient=True)
        found.append((energies.objective, gradient))
    for objective, gradient in found[1:]:
        assert objective == pytest.approx(found[0][0], rel=1e-12)
        assert np.abs(gradient - found[0][1]).max() <= 1e-10 * np.abs(found[0][1]).max()


@pytest.mark.parametrize("case", CASES)
def test_gradient_is_orthogonal_to_the_invariances(case):
    """No change under translations, rotations and scaling, to first order."""
    mesh, surface = CASES[case]
    weights = "willmore" if surface == "limit" else "mvs_cross"
    energies, g = lib.Problem(mesh, lib.options(weights, surface)).evaluate(mesh.xyz, gradient=True)
    centred = mesh.xyz - mesh.xyz.mean(axis=0)
    size = np.linalg.norm(g) * np.linalg.norm(centred)
    assert size > 1e-3 * energies.objective
    assert np.abs(g.sum(axis=0)).max() * np.linalg.norm(centred) <= 1e-10 * size
    assert np.abs(np.cross(centred, g).sum(axis=0)).max() <= 1e-10 * size
    assert abs((centred * g).sum()) <= 1e-10 * size

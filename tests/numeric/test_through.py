# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit points that are held, or slide on lines and in planes: where OpenSubdiv says that they are, on cages of the corpus;
what holds them is all that the energy's gradient is made of. With CURVOPT_LONG=1 sixty cages."""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import read_obj, torus_cage
from osd import osd_jets

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))
import cages  # noqa: E402

LIMIT_POINT = 4  # CURVOPT_FREEDOM_OF_LIMIT_POINT
HELD, LINE, PLANE = range(3)
AUTO, NONE = range(2)
SEEDS = range(60) if lib.LONG else (3, 4, 6, 7, 9, 13)


def corpus_cage(seed: int) -> Mesh:
    points, faces, _ = cages.cage(seed)
    return mesh_from_faces(points, [list(face) for face in faces])


def limits(mesh: Mesh) -> np.ndarray:
    """Limit points of the cage's vertices [n_vertices, 3], by OpenSubdiv."""
    return osd_jets(mesh, [0], [0], [[0.5, 0.5]], level=4).limit


def size(mesh: Mesh) -> float:
    return float(np.ptp(mesh.xyz, axis=0).max())


def interior(mesh: Mesh) -> np.ndarray:
    """Vertices all of whose edges have two faces."""
    edges: dict[tuple[int, int], int] = {}
    for face in mesh.face_list():
        for a, b in zip(face, face[1:] + face[:1]):
            edges[min(a, b), max(a, b)] = edges.get((min(a, b), max(a, b)), 0) + 1
    rim = {v for edge, n in edges.items() if n != 2 for v in edge}
    return np.array(sorted(set(range(mesh.n_vertices)) - rim))


def wishes(mesh: Mesh, seed: int):
    """Some vertices, neighbours among them, what is left to their limit points, and directions."""
    random = np.random.default_rng(seed)
    inside = interior(mesh)
    vertices = random.choice(inside, max(3, len(inside) // 6), replace=False)
    freedom = random.choice([HELD, HELD, LINE, PLANE], len(vertices))
    direction = random.normal(size=(len(vertices), 3))
    return vertices, freedom, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def off(moved: np.ndarray, freedom: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """How far from their points, lines and planes these are that moved so."""
    along = (moved * direction).sum(1)
    across = np.linalg.norm(moved - along[:, None] * direction, axis=1)
    return np.where(freedom == HELD, np.linalg.norm(moved, axis=1), np.where(freedom == LINE, across, np.abs(along)))


def masks(mesh: Mesh, vertices) -> np.ndarray:
    """Limit masks [n, n_vertices] of vertices inside a mesh of quads: 16, 4 and 1 of 36, by valence."""
    out = np.zeros((len(vertices), mesh.n_vertices))
    for row, v in zip(out, vertices):
        faces = [face for face in mesh.face_list() if v in face]
        n = len(faces)
        row[v] = n * n
        for face in faces:
            at = face.index(v)
            row[face[(at + 1) % 4]] += 2
            row[face[(at + 3) % 4]] += 2
            row[face[(at + 2) % 4]] += 1
        row /= n * (n + 5)
    return out


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("seed", SEEDS)
def test_limit_points_stay_where_they_are_held(seed, levels, capsys):
    mesh = corpus_cage(seed)
    vertices, freedom, direction = wishes(mesh, seed)
    energy = ("willmore", "mvs")[seed % 2]
    result = lib.minimize(mesh, energy, levels=levels, symmetry=NONE, max_iterations=400,
                          constraints=lib.constraints(vertices, freedom + LIMIT_POINT, direction))
    moved = limits(result.mesh)[vertices] - limits(mesh)[vertices]
    far = off(moved, freedom, direction).max() / size(mesh)
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels, {energy}: {result.summary.start.objective:.5g} -> "
              f"{result.summary.end.objective:.5g}, {result.verdict}, {result.summary.seconds:.2f} s; off by {far:.1e}")
    assert far <= 1e-9
    assert np.abs(moved[freedom != HELD]).max(initial=0) > 1e-4 * size(mesh)
    assert result.summary.end.objective < result.summary.start.objective


@pytest.mark.parametrize("seed", (4, 6, 7))
def test_only_what_is_held_bears_the_gradient(seed, capsys):
    """Of a minimum with held limit points M x = y the gradient is a combination of the rows of M."""
    mesh = lib.refine(corpus_cage(seed))  # quads
    vertices = interior(mesh)[::9]
    result = lib.minimize(mesh, "willmore", levels=1, symmetry=NONE, spacing=2,
                          constraints=lib.constraints(vertices, np.full(len(vertices), LIMIT_POINT)))
    found = result.mesh
    rows = masks(found, vertices)
    assert np.abs(rows @ found.xyz - limits(found)[vertices]).max() <= 1e-12 * size(mesh)
    _, gradient = lib.Problem(found, lib.options("willmore")).evaluate(found.xyz, gradient=True)
    inside = interior(mesh)  # what a boundary holds is another force
    gradient, rows = gradient[inside], rows[:, inside]
    force, *_ = np.linalg.lstsq(rows.T, gradient, rcond=None)
    rest = np.linalg.norm(gradient - rows.T @ force) / np.linalg.norm(gradient)
    outside = np.linalg.norm(gradient[~np.isin(inside, vertices)]) / np.linalg.norm(gradient)
    with capsys.disabled():
        print(f"\n  seed {seed}: {result.verdict}, of the gradient {rest:.1e} is left; {outside:.2f} is at vertices that are free")
    assert result.verdict == "minimum" and rest <= 2e-2 and outside > 0.1

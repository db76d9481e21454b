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
SEEDS = range(60) if lib.LONG else (3, 4, 6, 9)


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


@pytest.mark.parametrize("vertices, points", [([1, 31], [50, 60, 7]), ([1, 31], [2, 32, 60])])
def test_limit_points_stay_beside_vertices_that_are_held(vertices, points):
    """Coarse levels hold where these will be, also where their masks overlap those of limit points."""
    mesh = torus_cage(12, 6, 0.5)
    freedom = [HELD] * len(vertices) + [HELD + LIMIT_POINT] * len(points)
    result = lib.minimize(mesh, levels=3, constraints=lib.constraints(vertices + points, freedom))
    assert result.verdict == "minimum" and np.array_equal(result.mesh.xyz[vertices], mesh.xyz[vertices])
    assert np.abs(limits(result.mesh)[points] - limits(mesh)[points]).max() <= 1e-12


@pytest.mark.parametrize("seed", (4, 6))
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


# ------------------------------------------------------------------------------------------------------- places --

@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("seed", SEEDS)
def test_limit_points_go_where_they_are_to_be(seed, levels, capsys):
    mesh = corpus_cage(seed)
    vertices, freedom, direction = wishes(mesh, seed)
    random = np.random.default_rng(1000 + seed)
    places = limits(mesh)[vertices] + 0.02 * size(mesh) * random.uniform(-1, 1, (len(vertices), 3))
    result = lib.minimize(mesh, ("willmore", "mvs")[seed % 2], levels=levels, symmetry=NONE, max_iterations=400,
                          constraints=lib.constraints(vertices, freedom + LIMIT_POINT, direction, places=places))
    far = off(limits(result.mesh)[vertices] - places, freedom, direction).max() / size(mesh)
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels: {result.verdict}, {result.summary.seconds:.2f} s; off by {far:.1e}")
    assert far <= 1e-9


def test_vertices_and_springs_go_to_places(capsys):
    mesh = torus_cage(8, 5, 0.4)
    places = mesh.xyz[[3, 11, 20]] + [[0, 0, 0.1], [0.05, 0, 0], [0, -0.1, 0]]
    places[1] = np.nan  # where it is
    hard = lib.minimize(mesh, levels=1, constraints=lib.constraints([3, 11, 20], places=places))
    assert np.array_equal(hard.mesh.xyz[[3, 20]], places[[0, 2]]) and np.array_equal(hard.mesh.xyz[11], mesh.xyz[11])
    soft = lib.minimize(mesh, levels=1, symmetry=NONE,
                        constraints=lib.constraints([3, 11, 20], weights=[0.9, 1, 0.9], places=places))
    gone = np.linalg.norm(soft.mesh.xyz[[3, 20]] - places[[0, 2]], axis=1)
    was = np.linalg.norm(mesh.xyz[[3, 20]] - places[[0, 2]], axis=1)
    assert (gone < 0.2 * was).all()


def test_with_strength_a_point_is_pulled_and_the_rest_stays_near(capsys):
    """What is held exactly can have a place; a place on a line, or of a spring, would be at odds with the input's pull."""
    mesh = torus_cage(8, 5, 0.4)
    place = limits(mesh)[[3]] + [[0.05, 0, 0.05]]
    result = lib.minimize(mesh, levels=2, strength=0.5, constraints=lib.constraints([3], [LIMIT_POINT], places=place))
    moved = np.linalg.norm(limits(result.mesh)[:40] - limits(mesh), axis=1)
    assert np.abs(limits(result.mesh)[3] - place[0]).max() <= 1e-9 and np.median(moved) < 0.3 * moved[3]
    for freedom, weight in ((LIMIT_POINT + PLANE, 1), (HELD, 0.5)):
        with pytest.raises(lib.CurvoptError, match="place for vertex 3 and does not hold it exactly"):
            lib.minimize(mesh, strength=0.5, constraints=lib.constraints([3], [freedom], [[0, 0, 1]], weight, place))


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_a_patch_of_springs_goes_to_its_places_on_every_level(levels):
    mesh = torus_cage(8, 5, 0.4)
    patch = [0, 1, 5, 6, 10, 11]
    places = mesh.xyz[patch] + [0, 0, 0.5]
    result = lib.minimize(mesh, levels=levels, symmetry=NONE, constraints=lib.constraints(patch, weights=0.999, places=places))
    risen = (limits(result.mesh)[patch] - limits(mesh)[patch])[:, 2].mean()  # not all of it: the edge of the patch sags
    assert 0.3 < risen < 0.5


def test_symmetric_places_keep_the_symmetry_and_others_do_not():
    mesh = torus_cage(8, 4, 0.4)
    order = lib.minimize(mesh, levels=1, max_iterations=0).summary.symmetry_order
    lifted = limits(mesh) * [1, 1, 1.2]
    everywhere = lib.minimize(mesh, levels=1, max_iterations=0, constraints=lib.constraints(
        range(32), np.full(32, LIMIT_POINT + PLANE), np.tile([0.0, 0, 1], (32, 1)), places=lifted))
    assert everywhere.summary.symmetry_order == order
    for weight, freedom in ((1, LIMIT_POINT), (1, 0), (0.5, 0)):
        one = lib.minimize(mesh, levels=1, max_iterations=0, constraints=lib.constraints(
            [0], [freedom], weights=[weight], places=[mesh.xyz[0] + [0.01, 0.02, 0.03]]))
        assert one.summary.symmetry_order == 1


def shaken_cube() -> Mesh:
    grid = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return mesh_from_faces(grid + 0.05 * np.random.default_rng(1).uniform(-1, 1, grid.shape), quads)


def test_points_that_do_not_move_independently_are_refused_by_name():
    """Limit points of a cube's vertices have 7 dimensions, not 8: the mask of alternating signs is 9 - 12 + 3 of 24."""
    cube = shaken_cube()
    with pytest.raises(lib.CurvoptError, match="8 vertices that touch each other, vertex 0 among them, do not move indep"):
        lib.minimize(cube, levels=2, constraints=lib.constraints(range(8), np.full(8, LIMIT_POINT), places=cube.xyz))


@pytest.mark.parametrize("n", [6, 12, 24])
def test_sphere_through_points_of_it(n, capsys):
    """The least Willmore energy of all closed surfaces is a sphere's. Where the places lie on one, it is this one: points of
    the result come closer to it with every level, and the energy closer to 8 pi."""
    mesh = lib.refine(shaken_cube())  # 26 vertices
    vertices = np.random.default_rng(n).permutation(26)[:n]
    places = mesh.xyz[vertices] / np.linalg.norm(mesh.xyz[vertices], axis=1, keepdims=True)
    errors, energies = [], []
    for levels in (1, 2, 3, 4):
        result = lib.minimize(mesh, levels=levels, symmetry=NONE, constraints=lib.constraints(
            vertices, np.full(n, LIMIT_POINT), places=places))
        points = limits(result.mesh)
        assert np.abs(points[vertices] - places).max() <= 1e-9
        errors.append(np.abs(np.linalg.norm(points, axis=1) - 1).max())
        energies.append(result.summary.end.objective / (8 * np.pi) - 1)
    with capsys.disabled():
        print(f"\n  {n} points: largest distance to the sphere by level {' '.join(f'{e:.1e}' for e in errors)}; "
              f"energy over the least {' '.join(f'{e:.1e}' for e in energies)}")
    assert errors[-1] < 0.1 * errors[1] and energies[-1] < energies[-2] / 3 and min(energies) > -1e-6

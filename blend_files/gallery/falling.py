# SPDX-License-Identifier: GPL-3.0-or-later
"""In which direction a saddle falls, and where to on either side. No bpy.

A surface of symmetric shape may be a minimum among those of its symmetry alone. Its second variation, for motion along
normals, no symmetry kept, is a matrix of second differences; the lowest of its eigenvectors, each vertex weighed by its
area, is the mode in which the energy falls the fastest. Rotations, translations, and for Willmore's energy all maps that
keep it (Blaschke 1929), are eigenvectors of nearly 0.
"""

from __future__ import annotations

import numpy as np

from addon.binding import library
from addon.binding.values import Cage
from addon.core import job
from . import dense as dense_shapes
from . import solve
from .dense import centre_and_size, dense
from .store import Item, Store

USES = (dense_shapes, solve)  # (`store`)
_STEP = 1e-5  # of differences, in sizes
_LOWEST = 16  # eigenvectors that are looked for
_ROUNDS = 60  # of subspace iteration
_BELOW = 30.0  # the shift, 1 / size^4: below all eigenvalues that are looked for
_SAME = 0.02  # eigenvalues that differ by less, of the lowest, are one of several directions
_PER_VERTEX = 12  # quads by which a vertex' area is measured


def mode(store: Store, item: Item) -> dict[str, object]:
    """The mode of the minimizer of the item's need, energy `energy`: keeps heights (n,) along normals (n, 3), of unit
    mean square. `lowest`: eigenvalues in 1 / size^4; `directions`: of how many the lowest is one."""
    (of,) = item.needs
    cage = store.cage(of)
    shape = dense(cage, "limit", _PER_VERTEX * len(cage.positions))
    size = centre_and_size(shape)[1]
    normals = vertex_normals(cage)
    matrix = second_variation(cage, item.inputs["energy"], normals, _STEP * size)
    mass = _masses(cage, shape)
    values, vectors = lowest(matrix / np.sqrt(np.outer(mass, mass)), _BELOW / size**4)
    directions = int((values < values[0] + _SAME * abs(values[0])).sum())
    heights = _most_lopsided(vectors[:, :directions] / np.sqrt(mass)[:, None], mass)
    store.save_arrays(item.name, heights=heights, normals=normals)
    return {"lowest": (values * size**4).tolist(), "directions": directions, "size": size, "of": of}


def fall(store: Store, item: Item) -> dict[str, object]:
    """Minimizes `energy` from what the mode's item `mode` was made of, moved by `share` of its size along the mode (to
    the other side where it is negative), no symmetry kept; keeps the cage. Figures as of `solve.minimize`."""
    inputs = item.inputs
    found = store.result(inputs["mode"])
    cage = moved(store, inputs["mode"], inputs["share"])
    request = job.Request(inputs["energy"], 1, {"threads": 1, "max_iterations": inputs["iterations"]}, symmetry="none")
    solution = job.solve(cage, request)
    store.save_cage(item.name, solution.cage)
    return {**solve.figures(solution, inputs["energy"], "default"), "from": found["of"], "share": inputs["share"]}


def moved(store: Store, mode_name: str, share: float) -> Cage:
    """The cage that a mode is of, moved by `share` of its size along it."""
    found = store.result(mode_name)
    cage = store.cage(found["of"])
    with np.load(store.path(f"data/{mode_name}.npz")) as kept:
        shift = share * found["size"] * kept["heights"][:, None] * kept["normals"]
    return Cage(cage.positions + shift, cage.face_sizes, cage.face_vertices)


def heights_on(store: Store, mode_name: str, n_quads: int) -> np.ndarray:
    """How far a mode moves the points of dense(.., "limit", n_quads) along their normals, (m,), the most being 1."""
    cage = store.cage(store.result(mode_name)["of"])
    here, there = (dense(one, "limit", n_quads) for one in (cage, moved(store, mode_name, _STEP)))
    heights = ((there.points - here.points) * here.normals).sum(1)
    return heights / np.abs(heights).max()


# ------------------------------------------------------------------------------------------------ second variation --


def vertex_normals(cage: Cage) -> np.ndarray:
    """Unit normals (n, 3) of the limit surface beside the cage's vertices, all of whose faces are quads."""
    faces = np.asarray(cage.face_vertices).reshape(-1, 4)
    first = np.unique(faces, return_index=True)[1]
    uv = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])[first % 4]
    uv = np.clip(uv, 1e-3, 1 - 1e-3)  # at poles derivatives vanish
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        jets = mesh.jets(cage.positions, first // 4, np.zeros(len(first), int), uv, "limit")
    crossed = np.cross(jets[:, 1], jets[:, 2])
    return crossed / np.linalg.norm(crossed, axis=1)[:, None]


def second_variation(cage: Cage, energy: str, normals: np.ndarray, step: float) -> np.ndarray:
    """The Hessian (n, n) of an energy for heights along `normals` (n, 3), by central differences of its gradient, by the
    rules that the cage gets. Vertices with which no other has a face's stencil in common are moved together."""
    lib = library.load()
    near = _neighbours(cage)
    matrix = np.zeros((len(near), len(near)))
    options = lib.options({energy: 1.0}, tolerance=solve.FINE, threads=1)
    with library.Mesh.of_cage(lib, cage) as mesh, library.Problem.create(mesh, options) as problem:
        problem.evaluate(cage.positions)
        for group in _groups(near):
            shift = np.zeros_like(normals)
            shift[group] = step * normals[group]
            high, low = (problem.evaluate(cage.positions + side * shift, True)[1] for side in (1, -1))
            column = ((high - low) * normals).sum(1) / (2 * step)
            for vertex in group:
                rows = list(near[vertex])
                matrix[rows, vertex] = column[rows]
    return (matrix + matrix.T) / 2


def _neighbours(cage: Cage) -> list[set[int]]:
    """For each vertex those with which it has some face's stencil in common: the face's vertices and their faces'."""
    faces = np.asarray(cage.face_vertices).reshape(-1, 4)
    around: list[set[int]] = [set() for _ in range(len(cage.positions))]
    for face in faces.tolist():
        for vertex in face:
            around[vertex].update(face)
    near: list[set[int]] = [set() for _ in around]
    for face in faces.tolist():
        stencil = set().union(*(around[vertex] for vertex in face))
        for vertex in stencil:
            near[vertex] |= stencil
    return near


def _groups(near: list[set[int]]) -> list[list[int]]:
    """Vertices in groups, none of which has a neighbour in common with another of its group."""
    groups: list[list[int]] = []
    taken: list[set[int]] = []
    for vertex, others in enumerate(near):
        for group, rows in zip(groups, taken):
            if rows.isdisjoint(others):
                group.append(vertex)
                rows |= others
                break
        else:
            groups.append([vertex])
            taken.append(set(others))
    return groups


def lowest(matrix: np.ndarray, below: float) -> tuple[np.ndarray, np.ndarray]:
    """The least eigenvalues of a symmetric matrix (n, n), of which none is below -`below`, in their order, and their
    vectors in columns (n, k), by subspace iteration with the shifted inverse and Rayleigh and Ritz' method."""
    n = len(matrix)
    inverse = np.linalg.inv(matrix + below * np.eye(n))
    vectors = np.random.default_rng(0).standard_normal((n, min(n, 2 * _LOWEST)))
    for _ in range(_ROUNDS):
        vectors = np.linalg.qr(inverse @ vectors)[0]
    values, turn = np.linalg.eigh(vectors.T @ matrix @ vectors)
    return values[:_LOWEST], (vectors @ turn)[:, :_LOWEST]


def _masses(cage: Cage, shape: dense_shapes.Dense) -> np.ndarray:
    """For each vertex (n,) the area that it stands for: a quarter of each of its faces'."""
    per_face = shape.areas.reshape(len(cage.face_sizes), -1).sum(1)
    return np.bincount(cage.face_vertices, np.repeat(per_face / 4, 4), len(cage.positions))


def _most_lopsided(vectors: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Of the combinations of `vectors` (n, k) that with the greatest mean cube: among those of a symmetric shape it keeps
    more of the symmetry than most. Its mean square is 1."""
    draws = np.random.default_rng(0).standard_normal((4000, vectors.shape[1]))
    draws /= np.linalg.norm(draws, axis=1)[:, None]
    cubes = [mass @ (vectors @ draw) ** 3 for draw in draws]
    best = vectors @ draws[int(np.argmax(cubes))]
    return best / np.sqrt((best**2).mean())

# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages of one topology by many layouts: does a minimizer depend on the net? No bpy.

A layout is which vertices and faces a cage has: how many arms' rings, where its poles lie, how its lines run. Cages of
cubes have the layout that blocking out gives them; `diagonal` turns a cage's lines by 45 degrees, and `dual` swaps its
faces and vertices, which moves the poles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from addon.binding import api
from addon.binding.values import Cage

Cell = tuple[int, int, int]
Make = Callable[..., Cage]  # the functions of cages.py by name: make("lawson", 2, rings=5)


def families(make: Make) -> dict[str, dict[str, Cage]]:
    """Ten cages or more of each family, by name: of genus 2 and 3, and of the symmetries of a tetrahedron's frame
    (genus 3) and of a cube's (genus 5)."""
    return {
        "genus 2": _genus_2(make), "genus 3": _genus_3(make),
        "tetrahedral": _polyhedral(make, "tetrahedron"), "cubical": _polyhedral(make, "cube"),
    }  # fmt: skip


def _lawson(make: Make, genus: int, other: str, **changes: object) -> dict[str, Cage]:
    """Lawson's cage of a genus by five layouts, one of them by `changes` of its frame."""
    lawson = make("lawson", genus)
    return {
        "lawson": lawson, f"lawson, {other}": make("lawson", genus, **changes),
        "lawson, long arms": make("lawson", genus, rings=5), "lawson, diagonal": diagonal(lawson), "lawson, dual": dual(lawson),
    }  # fmt: skip


def _genus_2(make: Make) -> dict[str, Cage]:
    return {
        **_lawson(make, 2, "split hubs", hub="split", shoulder=0.25),
        "pretzel": make("pretzel"),
        "eight": _cubes(make, _slab(5, 3), {(1, 1, 0), (3, 1, 0)}),
        "thick eight": _cubes(make, _block(5, 3, 2), {(x, 1, z) for x in (1, 3) for z in (0, 1)}),
        "spectacles": _cubes(make, _slab(7, 3), {(1, 1, 0), (5, 1, 0), (3, 0, 0), (3, 2, 0)}),
        "upright ring": _cubes(make, _slab(3, 3) | {(x, 1, z) for x in (3, 4, 5) for z in (0, 1, 2)},
                               {(1, 1, 0), (4, 1, 1)}),
        "three openings": _cubes(make, _block(3, 3, 3), {(1, 1, 1), (0, 1, 1), (1, 0, 1), (1, 1, 0)}),
        "two tunnels": _cubes(make, _block(3, 3, 5), {(x, 1, 1) for x in range(3)} | {(1, y, 3) for y in range(3)}),
    }  # fmt: skip


def _genus_3(make: Make) -> dict[str, Cage]:
    middle, openings = {(1, 1, 1)}, {"x": (0, 1, 1), "y": (1, 0, 1), "z": (1, 1, 0), "X": (2, 1, 1), "Y": (1, 2, 1)}
    return {
        **_lawson(make, 3, "poles", hub="pole", rings=3),
        "three in a row": _cubes(make, _slab(7, 3), {(1, 1, 0), (3, 1, 0), (5, 1, 0)}),
        "three in an L": _cubes(make, _slab(5, 5) - {(4, 4, 0), (3, 4, 0), (4, 3, 0)},
                                {(1, 1, 0), (3, 1, 0), (1, 3, 0)}),
        "crossing tunnels": _cubes(make, _block(3, 3, 3), middle | {openings[k] for k in "xXyY"}),
        "four openings": _cubes(make, _block(3, 3, 3), middle | {openings[k] for k in "xXyz"}),
        "three tunnels": _cubes(make, _block(3, 3, 7), {(x, 1, 1) for x in range(3)} | {(1, y, 3) for y in range(3)}
                                | {(x, 1, 5) for x in range(3)}),
        "tetrahedral": make("polyhedral", "tetrahedron"),
    }  # fmt: skip


def _polyhedral(make: Make, solid: str) -> dict[str, Cage]:
    """The frame of a solid: arms of one to three rings, hubs of either kind, lines along the arms or across them, poles at
    vertices or in faces."""
    frames = {
        f"{hub} hubs, {rings} ring{'s' if rings > 1 else ''}": make("polyhedral", solid, hub=hub, rings=rings, **more)
        for hub, more in (("pole", {}), ("split", {"shoulder": 0.25}))
        for rings in (1, 2, 3)
    }
    first, split = frames["pole hubs, 1 ring"], frames["split hubs, 1 ring"]
    return {
        **frames, "diagonal": diagonal(first), "dual": dual(first), "split hubs, diagonal": diagonal(split),
        "split hubs, dual": dual(split),
    }  # fmt: skip


def _slab(x: int, y: int) -> set[Cell]:
    return _block(x, y, 1)


def _block(x: int, y: int, z: int) -> set[Cell]:
    return {(i, j, k) for i in range(x) for j in range(y) for k in range(z)}


def _cubes(make: Make, cells: set[Cell], without: Iterable[Cell]) -> Cage:
    return make("polycube", cells - set(without))


# ------------------------------------------------------------------------------------------------------ other nets --


def diagonal(cage: Cage) -> Cage:
    """The cage with a vertex more in each face, and a quad across each edge instead of the faces: lines run diagonally.
    Its vertices lie where a round of averaging puts them, so that both kinds lie on one shape. Closed cages only."""
    faces, points = _faces(cage), np.asarray(cage.positions)
    centres = _centres(cage)
    quads = [(a, len(points) + right, b, len(points) + left) for (a, b), (left, right) in _edges(faces).items()]
    near = np.zeros_like(points)
    count = np.zeros(len(points))
    for centre, face in zip(centres, faces):
        near[face] += centre
        count[face] += 1
    moved = (points + near / count[:, None]) / 2
    return api.cage(np.concatenate([moved, centres]), quads)


def dual(cage: Cage) -> Cage:
    """The cage whose vertices are the centres of the cage's faces, and whose faces go round its vertices. Closed cages
    only."""
    faces = _faces(cage)
    following: list[dict[int, int]] = [{} for _ in range(len(cage.positions))]  # of a face round a vertex the next one
    for (a, b), (left, right) in _edges(faces).items():
        following[a][right] = left
        following[b][left] = right
    found = []
    for ring in following:
        face = [next(iter(ring))]
        while ring[face[-1]] != face[0]:
            face.append(ring[face[-1]])
        found.append(tuple(face))
    return api.cage(_centres(cage), found)


def _faces(cage: Cage) -> list[list[int]]:
    ends = np.cumsum(cage.face_sizes)[:-1]
    return [face.tolist() for face in np.split(np.asarray(cage.face_vertices), ends)]


def _centres(cage: Cage) -> np.ndarray:
    return np.array([np.asarray(cage.positions)[face].mean(0) for face in _faces(cage)])


def _edges(faces: list[list[int]]) -> dict[tuple[int, int], tuple[int, int]]:
    """By edge (a, b), a < b: the faces left and right of it, looking from a to b from outside."""
    left = {edge: index for index, face in enumerate(faces) for edge in zip(face, face[1:] + face[:1])}
    return {(a, b): (index, left[b, a]) for (a, b), index in left.items() if a < b}

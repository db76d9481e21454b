# SPDX-License-Identifier: GPL-3.0-or-later
"""Part of a cage: which of its selected vertices move, and which faces change with them. No bpy.

A face is selected if all its vertices are. A rim edge lies between a selected face and one that is not. It holds rows
of vertices, counted by faces as the library counts those of a boundary (co_constraints_boundary), but over selected
faces only: 1 keeps the rim, 2 also the limit surface beyond it, 3 also how curvature changes at it. The limit surface
of a face depends on the vertices of all faces that share a vertex with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..binding.abi import SHARPNESS_INFINITE
from ..binding.values import Cage
from .crease import edge_keys
from .layout import sides

ROWS = {"free": 0, "position": 1, "tangent": 2, "curvature": 3}  # of vertices that are held; keys are abi.BOUNDARIES
MARKS = ("", "position", "tangent", "curvature", "free")  # by the value of an edge's mark; 0: as the setting says


@dataclass(frozen=True)
class Part:
    """What is chosen of a cage of n vertices: `selected` (n,) bool; marked edges (k, 2), each once, with their marks
    (k,), indices of MARKS."""

    selected: np.ndarray
    edges: np.ndarray
    marks: np.ndarray


def moving_vertices(cage: Cage, part: Part, rim: str, boundary: str) -> np.ndarray:
    """Which vertices (n,) move; `rim` and `boundary`, of ROWS, are for edges without a mark."""
    inside = _every_corner(cage, part.selected)
    ends, n_faces, n_inside, mark = _edges(cage, part, inside)
    at_rim, at_boundary = (n_inside > 0) & (n_inside < n_faces), n_faces == 1
    held = _held_rows(cage, ends[at_rim], _rows(mark[at_rim], rim), inside)
    held |= _held_rows(cage, ends[at_boundary], _rows(mark[at_boundary], boundary), np.ones_like(inside))
    if rim != "free":
        held |= _beside(cage, part.selected, inside, ends[at_rim])
    if boundary != "free":
        held |= _infinitely_sharp(cage)
    return part.selected & ~held & (np.bincount(cage.face_vertices, minlength=len(held)) > 0)


@dataclass(frozen=True)
class MarkedBoundary:
    """The boundary of a whole cage of n vertices, some of whose edges are marked: the library is to hold `boundary`, of
    ROWS, everywhere, and the vertices `held` (n,) beside that; `count` boundary edges are marked. Unless it is
    `refinable`, one row of vertices keeps a curve, and does so on the cage's own level alone."""

    boundary: str
    held: np.ndarray
    count: int
    refinable: bool


def marked_boundary(cage: Cage, edges: np.ndarray, marks: np.ndarray, boundary: str) -> MarkedBoundary:
    """What marked edges (k, 2) with their marks (k,) hold; `boundary` is for those without one, and for creases."""
    everything = np.ones(len(cage.face_sizes), bool)
    part = Part(np.ones(len(cage.positions), bool), edges, marks)
    ends, n_faces, _, mark = _edges(cage, part, everything)
    ends, mark = ends[n_faces == 1], mark[n_faces == 1]
    count = int(((mark > 0) & (mark < len(MARKS))).sum())
    if not count:
        return MarkedBoundary(boundary, np.zeros_like(part.selected), 0, True)
    rows = _rows(mark, boundary)
    least = 0 if boundary == "free" else int(rows.min())
    held = _held_rows(cage, ends, np.where(rows > least, rows, 0), everything)
    sharp = _infinitely_sharp(cage) & (boundary != "free" and least == 0)
    refinable = least > 0 or not ((rows == 1).any() or sharp.any())
    return MarkedBoundary(list(ROWS)[least], held | sharp, count, refinable)


def sliding_vertices(cage: Cage, part: Part, rim: str, boundary: str) -> np.ndarray:
    """Vertices (n,) that only the boundary `position` holds, for the sake of the curve. None if another boundary is
    chosen, or a mark lets vertices on boundaries or creases move freely."""
    none = np.zeros(len(cage.positions), bool)
    if boundary != "position":
        return none
    moving = moving_vertices(cage, part, rim, boundary)
    return none if moves_curves(cage, moving) else moving_vertices(cage, part, rim, "free") & ~moving


def is_open(cage: Cage) -> bool:
    """Whether the surface has a boundary."""
    return bool(_on_boundary(cage).any())


def has_curves(cage: Cage, boundary: str) -> bool:
    """Whether the library has curves along which vertices slide that `boundary` holds. It may still hold their
    vertices for another reason."""
    if boundary == "free":
        return False
    return bool((_on_curves(cage) if boundary == "position" else _infinitely_sharp(cage)).any())


def moves_curves(cage: Cage, moving: np.ndarray) -> bool:
    """Whether one of the moving vertices (n,) is on a boundary or an infinitely sharp crease."""
    return bool((moving & _on_curves(cage)).any())


def changing_faces(cage: Cage, moving: np.ndarray) -> np.ndarray:
    """The faces (m,) whose limit surface depends on moving vertices (n,)."""
    return _any_corner(cage, _of_faces(cage, _any_corner(cage, moving)))


def _starts(cage: Cage) -> np.ndarray:
    return np.cumsum(cage.face_sizes) - cage.face_sizes


def _any_corner(cage: Cage, vertices: np.ndarray) -> np.ndarray:
    """Faces (m,) with one of the vertices (n,)."""
    return np.logical_or.reduceat(vertices[cage.face_vertices], _starts(cage))


def _every_corner(cage: Cage, vertices: np.ndarray) -> np.ndarray:
    """Faces (m,) all of whose vertices are among these (n,)."""
    return np.logical_and.reduceat(vertices[cage.face_vertices], _starts(cage))


def _of_faces(cage: Cage, faces: np.ndarray) -> np.ndarray:
    """Vertices (n,) of faces (m,)."""
    corners = cage.face_vertices[np.repeat(faces, cage.face_sizes)]
    return np.bincount(corners, minlength=len(cage.positions)) > 0


def _edges(cage: Cage, part: Part, inside: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of every edge of a face: its ends (e, 2), the number of its faces (e,), of those `inside` (e,), its mark (e,)."""
    pairs, n = sides(cage.face_sizes, cage.face_vertices), len(cage.positions)
    keys, first, which = np.unique(edge_keys(pairs, n), return_index=True, return_inverse=True)
    which = which.reshape(-1)  # numpy 2.0 gives it another shape
    n_inside = np.bincount(which, weights=np.repeat(inside, cage.face_sizes), minlength=len(keys))
    mark, marked = np.zeros(len(keys), np.intp), edge_keys(part.edges, n)
    there = np.isin(marked, keys)
    mark[np.searchsorted(keys, marked[there])] = part.marks[there]
    return pairs[first], np.bincount(which, minlength=len(keys)), n_inside, mark


def _rows(marks: np.ndarray, otherwise: str) -> np.ndarray:
    """Rows (e,) that edges with these marks (e,) hold."""
    known = np.array([ROWS[name or otherwise] for name in MARKS])
    return known[np.where((marks > 0) & (marks < len(MARKS)), marks, 0)]


def _held_rows(cage: Cage, ends: np.ndarray, rows: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertices (n,) in the rows (e,) that edges with these ends (e, 2) hold, counted over `faces` (m,)."""
    held = np.zeros(len(cage.positions), bool)
    for count in (1, 2, 3):
        row = np.zeros(len(cage.positions), bool)
        row[ends[rows >= count]] = True
        for _ in range(count - 1):
            row |= _of_faces(cage, _any_corner(cage, row) & faces)
        held |= row
    return held


def _beside(cage: Cage, selected: np.ndarray, inside: np.ndarray, rim: np.ndarray) -> np.ndarray:
    """Selected vertices (n,) that are part of no selected face, or that touch others without an edge of the rim,
    whose edges' ends are rim (r, 2)."""
    within, without = _of_faces(cage, inside), _of_faces(cage, ~inside)
    on_rim = np.zeros(len(selected), bool)
    on_rim[rim] = True
    return selected & (~within | (without & ~on_rim))


def _on_curves(cage: Cage) -> np.ndarray:
    """Vertices (n,) on boundaries and infinitely sharp creases."""
    return _infinitely_sharp(cage) | _on_boundary(cage)


def _on_boundary(cage: Cage) -> np.ndarray:
    """Vertices (n,) on boundaries."""
    found, pairs = np.zeros(len(cage.positions), bool), sides(cage.face_sizes, cage.face_vertices)
    _, which, count = np.unique(edge_keys(pairs, len(found)), return_inverse=True, return_counts=True)
    found[pairs[count[which.reshape(-1)] == 1]] = True  # numpy 2.0 gives `which` another shape
    return found


def _infinitely_sharp(cage: Cage) -> np.ndarray:
    """Vertices (n,) that are infinitely sharp, or on an infinitely sharp crease."""
    held, creases = np.zeros(len(cage.positions), bool), cage.creases
    held[creases.vertices[creases.vertex_sharpness >= SHARPNESS_INFINITE]] = True
    held[creases.edges[creases.edge_sharpness >= SHARPNESS_INFINITE]] = True
    return held

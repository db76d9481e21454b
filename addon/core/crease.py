# SPDX-License-Identifier: GPL-3.0-or-later
"""Creases as Blender's meshes have them, 0 .. 1, and as the library wants them: sharpness. No bpy.

Follows what the Subdivision Surface modifier hands to OpenSubdiv, in Blender 3.4 to 5.2 alike:
`BKE_subdiv_crease_to_sharpness_f` (blenkernel/intern/subdiv_inline.h), 10 crease^2 in single precision, and
`assignComponentTags` (intern/opensubdiv, topology_refiner_factory.cc): an edge below 1e-6 is smooth, and a vertex of
two edges is as sharp as itself and the less sharp of them together, 10 at most. From 10 on it is infinite.
"""

from __future__ import annotations

import numpy as np

from ..binding.abi import SHARPNESS_INFINITE
from ..binding.values import Cage, Creases

# The modifier's boundary_smooth for each of abi.BOUNDARY_RULES.
BOUNDARY_SMOOTH = {"smooth": "ALL", "corners": "PRESERVE_CORNERS"}
RULE_OF_BOUNDARY_SMOOTH = {name: rule for rule, name in BOUNDARY_SMOOTH.items()}

_SMOOTH_BELOW = 1e-6


def sharpness_of(crease: np.ndarray) -> np.ndarray:
    """Sharpness (n,) float64, 0 .. 10, of creases (n,)."""
    crease = np.minimum(np.abs(np.asarray(crease, np.float32)), np.float32(1))
    return (crease * crease * np.float32(SHARPNESS_INFINITE)).astype(np.float64)


def crease_of(sharpness: np.ndarray) -> np.ndarray:
    """Creases (n,) float32, 0 .. 1, of sharpness (n,)."""
    return np.sqrt(np.minimum(sharpness, SHARPNESS_INFINITE) / SHARPNESS_INFINITE).astype(np.float32)


def from_blender(edges: np.ndarray, edge_crease: np.ndarray, vertex_crease: np.ndarray, rule: str) -> Creases:
    """What creases of all edges (e, 2), (e,), and of all vertices, (n,), mean to the modifier."""
    sharp = sharpness_of(edge_crease)
    sharp[sharp < _SMOOTH_BELOW] = 0
    vertex = sharpness_of(vertex_crease) + _less_sharp_of_two(edges, sharp, len(vertex_crease))
    creased, corners = np.flatnonzero(sharp), np.flatnonzero(vertex)
    vertex = np.minimum(vertex[corners], SHARPNESS_INFINITE)
    return Creases(edges[creased].astype(np.int32), sharp[creased], corners.astype(np.int32), vertex, rule)


def to_blender(cage: Cage, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The creases of edges (e, 2), (e,), and of vertices, (n,), with which the modifier shows the cage's surface, under
    the rule of the cage's creases: what that rule keeps has none for it."""
    n, creases = len(cage.positions), cage.creases
    sharp, vertex = np.zeros(len(edges)), np.zeros(n)
    sharp[edge_indices(edges, creases.edges, n)] = creases.edge_sharpness
    vertex[creases.vertices] = creases.vertex_sharpness
    if creases.rule == "corners":
        vertex[np.bincount(cage.face_vertices, minlength=n) == 1] = 0
    own = np.maximum(vertex - _less_sharp_of_two(edges, sharp, n), 0)
    return crease_of(sharp), crease_of(np.where(vertex < SHARPNESS_INFINITE, own, vertex))


def _less_sharp_of_two(edges: np.ndarray, sharpness: np.ndarray, n_vertices: int) -> np.ndarray:
    """For each vertex (n_vertices,), the smaller sharpness of its edges if it has exactly two of them, else 0."""
    if not sharpness.any():
        return np.zeros(n_vertices)
    least = np.full(n_vertices, np.inf)
    np.minimum.at(least, edges.reshape(-1), np.repeat(sharpness, 2))
    return np.where(np.bincount(edges.reshape(-1), minlength=n_vertices) == 2, least, 0.0)


def edge_keys(pairs: np.ndarray, n_vertices: int) -> np.ndarray:
    """A number for each of pairs (k, 2), whichever way round."""
    return np.sort(pairs.astype(np.int64), axis=1) @ (n_vertices, 1)


def edge_indices(edges: np.ndarray, wanted: np.ndarray, n_vertices: int) -> np.ndarray:
    """Where in edges (e, 2) each of wanted (k, 2) is; all are there, in one direction or the other."""
    keys, wanted_keys = (edge_keys(pairs, n_vertices) for pairs in (edges, wanted))
    order = np.argsort(keys)
    return order[np.searchsorted(keys, wanted_keys, sorter=order)]

# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of a cage that a run with holes depends on: faces that count, and two rings of faces round them. No bpy.

Two rings decide how the library evaluates a face (CO_PATCHES_HALO), blends one face wide included. So a run takes as
long as that part is large, however large the cage is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..binding.library import CurvoptError
from ..binding.values import Cage, Creases, Exceptions, Held, rms_radius
from .crease import edge_keys
from .layout import renumbered, sides

_RINGS = 2  # CO_PATCHES_HALO
_NOTHING_IS_LEFT = "nothing may move: where the selection is, the surface has no finite energy, and stays as it is"


@dataclass(frozen=True)
class Crop:
    """`cage` is that part of `whole`; its `vertices` (k,) and `faces` (l,) are numbers there."""

    whole: Cage
    cage: Cage
    vertices: np.ndarray
    faces: np.ndarray

    @classmethod
    def of_faces(cls, whole: Cage, counted: np.ndarray) -> Crop:
        """Around the faces `counted` (m,) bool, one at least."""
        starts, n = np.cumsum(whole.face_sizes) - whole.face_sizes, len(whole.positions)
        kept = counted
        for _ in range(_RINGS):
            near = np.bincount(whole.face_vertices[np.repeat(kept, whole.face_sizes)], minlength=n) > 0
            kept = np.logical_or.reduceat(near[whole.face_vertices], starts)
        sizes, corners = whole.face_sizes[kept], whole.face_vertices[np.repeat(kept, whole.face_sizes)]
        vertices = np.unique(corners)
        number = np.full(n, -1, np.int32)
        number[vertices] = np.arange(len(vertices))
        edges = np.unique(edge_keys(sides(sizes, corners), n))
        creases = _creases(whole.creases, number, np.isin(edge_keys(whole.creases.edges, n), edges))
        cage = Cage(whole.positions[vertices], sizes, number[corners], creases)
        return cls(whole, cage, vertices, np.flatnonzero(kept))

    def held(self, held: Held) -> Held:
        """Vertices of the whole that may not move freely."""
        there = np.isin(held.vertices, self.vertices)
        numbers = np.searchsorted(self.vertices, np.asarray(held.vertices)[there])
        return Held(numbers.astype(np.int32), np.asarray(held.weights)[there])

    def holes(self, holes: np.ndarray) -> np.ndarray:
        """Faces (h,) of the whole, those that are in the part."""
        return np.flatnonzero(np.isin(self.faces, holes)).astype(np.int32)

    def strength(self, strength: float) -> float:
        """The same strength: the length of the wave of which half stays is in units of the cage's radius."""
        ratio = rms_radius(self.cage.positions) / rms_radius(self.whole.positions)
        return strength / (strength + (1 - strength) * ratio)

    def expanded(self, positions: np.ndarray) -> Cage:
        """The whole with the part's vertices at positions (k, 3)."""
        everywhere = self.whole.positions.copy()
        everywhere[self.vertices] = positions
        return replace(self.whole, positions=everywhere)

    def exceptions(self, found: Exceptions) -> Exceptions:
        """Those of the part, in numbers of the whole."""
        return replace(found, reasons=tuple((reason, self.vertices[v]) for reason, v in found.reasons))

    def error(self, error: CurvoptError) -> CurvoptError:
        """The library's refusal of the part, in numbers of the whole."""
        if error.message.startswith(("nothing may move", "no face is left")):  # the numbers are those of the part
            return CurvoptError(error.code, -1, _NOTHING_IS_LEFT)
        text = renumbered(error.message, "vertex|vertices|partner", self.vertices)
        return CurvoptError(error.code, error.element, renumbered(text, "face|faces", self.faces))

    def euler(self) -> int:
        """The whole's Euler characteristic, of what has faces."""
        n = len(self.whole.positions)
        edges = np.unique(edge_keys(sides(self.whole.face_sizes, self.whole.face_vertices), n))
        return len(np.unique(self.whole.face_vertices)) - len(edges) + len(self.whole.face_sizes)


def _creases(creases: Creases, number: np.ndarray, edges_kept: np.ndarray) -> Creases:
    """Creases of the vertices that have a number, and of those edges."""
    kept = number[creases.vertices] >= 0
    return Creases(
        number[creases.edges[edges_kept]].reshape(-1, 2), creases.edge_sharpness[edges_kept],
        number[creases.vertices[kept]], creases.vertex_sharpness[kept], creases.rule,
    )  # fmt: skip

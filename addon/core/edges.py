# SPDX-License-Identifier: GPL-3.0-or-later
"""The edges of a cage as curves of its surface: where on which faces each of them runs, and what is beyond it. No bpy.

A *side* is an edge as one of its faces has it, from the face's corner to the next one; sides have the numbers of
face_vertices. Along a side t runs from 0 to 1. On a face with other than four corners it goes over two quarters, half of t
on each: curvopt_sampler_jets() says how they are parametrized.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .crease import edge_keys
from .layout import sides

_QUAD = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])  # parameters of a quad's corners


@dataclass(frozen=True)
class Places:
    """Points on sides: face, corner (n,) and uv (n, 2) as the sampler wants them; `along` (n, 2), the derivative of uv by
    t; `inwards` (n, 2), the way into the face."""

    face: np.ndarray
    corner: np.ndarray
    uv: np.ndarray
    along: np.ndarray
    inwards: np.ndarray


@dataclass(frozen=True)
class EdgeTable:
    """ends (s, 2): the two vertices of each side; face, corner (s,): whose it is; edge (s,): its edge; edges (e, 2), their
    vertices, ascending; first (e,): a side of each edge."""

    sizes: np.ndarray
    ends: np.ndarray
    face: np.ndarray
    corner: np.ndarray
    edge: np.ndarray
    edges: np.ndarray
    first: np.ndarray

    @classmethod
    def of_faces(cls, sizes: np.ndarray, vertices: np.ndarray) -> EdgeTable:
        """Of polygons: sizes (m,), vertices (sum of sizes,)."""
        ends, n = sides(sizes, vertices), int(vertices.max(initial=-1)) + 1
        _, first, edge = np.unique(edge_keys(ends, n), return_index=True, return_inverse=True)
        face = np.repeat(np.arange(len(sizes)), sizes)
        corner = np.arange(len(vertices)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        return cls(np.asarray(sizes), ends, face, corner, edge.reshape(-1), np.sort(ends[first], axis=1), first)

    def of_edge(self, edge: int) -> np.ndarray:
        """The sides (k,) of an edge."""
        return np.flatnonzero(self.edge == edge)

    def of_face(self, face: int) -> np.ndarray:
        """The sides (k,) of a face, in order."""
        begin = int(self.sizes[:face].sum())
        return np.arange(begin, begin + int(self.sizes[face]))

    def places(self, side: np.ndarray, t: np.ndarray) -> Places:
        """At t (n,), 0 .. 1, of sides (n,)."""
        side, t = np.broadcast_arrays(np.asarray(side, np.intp), np.asarray(t, float))
        face, k = self.face[side], self.corner[side]
        size = self.sizes[face]
        quad = size == 4
        here, there, back = _QUAD[k % 4], _QUAD[(k + 1) % 4], _QUAD[(k + 3) % 4]
        late = t > 0.5  # of a polygon: the quarter at the side's end
        polygon = np.where(late[:, None], np.stack([0 * t, 2 - 2 * t], -1), np.stack([2 * t, 0 * t], -1))
        uv = np.where(quad[:, None], here + t[:, None] * (there - here), polygon)
        along = np.where(quad[:, None], there - here, np.where(late[:, None], (0.0, -2.0), (2.0, 0.0)))
        inwards = np.where(quad[:, None], back - here, np.where(late[:, None], (1.0, 0.0), (0.0, 1.0)))
        corner = np.where(quad, 0, np.where(late, (k + 1) % size, k))
        return Places(face.astype(np.int32), corner.astype(np.int32), uv, along, inwards)

    def chosen(self, pairs: np.ndarray) -> np.ndarray:
        """The edges (k,) that pairs of vertices (p, 2) are; pairs that are none do not count."""
        n = int(self.edges.max(initial=-1)) + 1
        inside = np.asarray(pairs, np.int64).reshape(-1, 2)
        inside = inside[((inside >= 0) & (inside < n)).all(axis=1)]
        return np.flatnonzero(np.isin(edge_keys(self.edges, n), edge_keys(inside, n)))

    def loops(self, edges: np.ndarray) -> np.ndarray:
        """These edges (k,) and those that go on from them, ascending: through inner vertices of four edges straight on, and
        along boundaries. As Blender's Select Edge Loops."""
        around: dict[int, list[int]] = {}
        for number, pair in enumerate(self.edges.tolist()):
            for vertex in pair:
                around.setdefault(vertex, []).append(number)
        faces: list[set[int]] = [set() for _ in self.edges]
        for number, face in zip(self.edge.tolist(), self.face.tolist()):
            faces[number].add(face)
        found, waiting = set(map(int, edges)), list(map(int, edges))
        while waiting:
            edge = waiting.pop()
            for vertex in self.edges[edge].tolist():
                for other in _straight_on(edge, around[vertex], faces):
                    if other not in found:
                        found.add(other)
                        waiting.append(other)
        return np.array(sorted(found), np.intp)


def _straight_on(edge: int, around: list[int], faces: list[set[int]]) -> list[int]:
    """The edges, one at most, in which a loop goes on from `edge` at a vertex with the edges `around`."""
    if len(faces[edge]) == 1:
        others = [other for other in around if other != edge and len(faces[other]) == 1]
        return others if len(others) == 1 else []
    if len(around) != 4 or any(len(faces[other]) != 2 for other in around):
        return []
    return [other for other in around if other != edge and not faces[other] & faces[edge]]

# SPDX-License-Identifier: GPL-3.0-or-later
"""How a mesh of Blender's becomes the cage that is optimized, and the optimized cage a mesh again. No bpy.

On the way in, loose vertices and edges are left out, and half a cage under a Mirror modifier is completed (mirror.py).
On the way back, half of the result is taken, and what was loose is put where it was; behind the others if the result
has more vertices than the mesh.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from ..binding.abi import SHARPNESS_INFINITE
from ..binding.values import Cage, Creases, Held
from .crease import edge_keys, from_blender, to_blender
from .mirror import Half, Halves

_COINCIDENT = 1e-5  # of the size: vertices so near are in one place
_ONE_PLACE = 1e-6  # of the size, for vertices of a torn mesh, which are copies of each other: float32 has 1e-7


@dataclass(frozen=True)
class MeshArrays:
    """A mesh of Blender's: positions (n, 3) in the object's coordinates; edges (e, 2), whether each is `loose` (e,):
    belongs to no face; creases of edges (e,) and of vertices (n,); face_sizes (m,), face_vertices (sum of sizes,)."""

    positions: np.ndarray
    edges: np.ndarray
    loose: np.ndarray
    edge_crease: np.ndarray
    vertex_crease: np.ndarray
    face_sizes: np.ndarray
    face_vertices: np.ndarray

    def with_faces(self) -> np.ndarray:
        """Which vertices (n,) belong to a face."""
        return np.bincount(self.face_vertices, minlength=len(self.positions)) > 0

    def collapsed_faces(self) -> np.ndarray:
        """The faces that have neighbouring corners in one place, ascending: their surface may have no tangent plane."""
        one, other = sides(self.face_sizes, self.face_vertices).T
        length = np.linalg.norm(self.positions[one] - self.positions[other], axis=1)
        faces = np.repeat(np.arange(len(self.face_sizes)), self.face_sizes)
        return np.unique(faces[length <= _COINCIDENT * np.ptp(self.positions, axis=0).max()])

    def n_torn(self) -> int:
        """The number of vertices at the boundary that are in one place with another vertex at the boundary."""
        ends = sides(self.face_sizes, self.face_vertices)
        keys = edge_keys(ends, len(self.positions))
        order = np.argsort(keys)
        ahead = np.diff(keys[order], append=-1) != 0  # from the next one
        alone = order[ahead & np.roll(ahead, 1)]
        points = self.positions[np.unique(ends[alone])]
        if not len(points):
            return 0
        cells = np.round((points - self.positions.min(axis=0)) / (_ONE_PLACE * np.ptp(self.positions, axis=0).max()))
        counts = np.unique(cells, axis=0, return_counts=True)[1]
        return int(counts[counts > 1].sum())


def sides(sizes: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """The two vertices of each side (sum of sizes, 2) of faces."""
    last = np.cumsum(sizes) - 1
    following = np.arange(1, len(vertices) + 1)
    following[last] = last + 1 - sizes
    return np.stack([vertices, vertices[following]], -1)


@dataclass(frozen=True)
class Layout:
    """`kept` (h,) and `loose` (l,) are the mesh's vertices with faces and without, loose_edges (k, 2) its edges without
    faces; `halves` says what of the whole cage each of `kept` is; face_sizes (m,) are the mesh's."""

    kept: np.ndarray
    loose: np.ndarray
    loose_edges: np.ndarray
    halves: Halves
    face_sizes: np.ndarray

    @classmethod
    def of_mesh(cls, mesh: MeshArrays, axes: tuple[int, ...] = (), on_plane: np.ndarray | None = None) -> Layout:
        """Mirrored across `axes`; on_plane (n, 3) says which vertices of the mesh are merged with their images."""
        has_faces = mesh.with_faces()
        kept = np.flatnonzero(has_faces)
        merged = np.zeros((len(kept), 3), bool) if on_plane is None else on_plane[kept]
        halves = Halves.of_planes(axes, merged)
        return cls(kept, np.flatnonzero(~has_faces), mesh.edges[mesh.loose], halves, mesh.face_sizes)

    @property
    def is_plain(self) -> bool:
        """Whether the cage is the mesh."""
        return not (len(self.loose) or len(self.loose_edges) or self.halves.axes)

    def face_in_plane(self, mesh: MeshArrays) -> int:
        """The first face that lies in a mirror plane, or -1."""
        return self.halves.in_plane(mesh.face_sizes, self._numbers()[mesh.face_vertices])

    def edge_across(self, mesh: MeshArrays) -> int:
        """The first edge of the mesh that lies in a mirror plane and has faces on both sides, or -1: its images are
        faces of the same edge, which then has four."""
        merged = np.zeros((len(mesh.positions), 3), bool)
        merged[self.kept] = self.halves.on_plane
        flat = merged[mesh.edges].all(axis=1).any(axis=1)
        n = len(mesh.positions)
        used, counts = np.unique(edge_keys(sides(mesh.face_sizes, mesh.face_vertices), n), return_counts=True)
        several = np.isin(edge_keys(mesh.edges, n), used[counts > 1])
        found = np.flatnonzero(flat & several)
        return int(found[0]) if len(found) else -1

    def is_its_own_image(self, points: np.ndarray) -> int:
        """The first axis across which the mesh, at `points` (n, 3) in the frame, is symmetric already without a vertex
        in the plane, or -1: its image would lie on itself."""
        places = np.round(points[self.kept] / (_COINCIDENT * np.ptp(points, axis=0).max())).astype(np.int64)
        there = set(map(tuple, places.tolist()))
        for axis in self.halves.axes:
            image = places * np.where(np.arange(3) == axis, -1, 1)
            if not self.halves.on_plane[:, axis].any() and all(tuple(place) in there for place in image.tolist()):
                return axis
        return -1

    # ------------------------------------------------------------------------------------------------- way in --

    def cage(
        self, mesh: MeshArrays, positions: np.ndarray, face_vertices: np.ndarray, rule: str, creased: bool
    ) -> Cage:
        """The cage that is optimized. positions (n, 3) are the mesh's in the frame, whose planes through 0 mirror it;
        face_vertices run as they are to run; `creased`: creases count."""
        half_vertices = self._numbers()[face_vertices]
        sizes, vertices = self.halves.faces(mesh.face_sizes, half_vertices)
        return Cage(self.halves.positions(positions[self.kept]), sizes, vertices, self._creases(mesh, rule, creased))

    def _numbers(self) -> np.ndarray:
        """For each vertex of the mesh its number among `kept`, -1 for loose ones."""
        numbers = np.full(len(self.kept) + len(self.loose), -1, np.int32)
        numbers[self.kept] = np.arange(len(self.kept))
        return numbers

    def _creases(self, mesh: MeshArrays, rule: str, creased: bool) -> Creases:
        """The whole's. A vertex at which a loose edge ends is infinitely sharp to the Subdivision Surface modifier,
        with and without creases (`initialize_manifold_indices`, blenkernel/intern/subdiv_converter_mesh.cc)."""
        creases = Creases(rule=rule)
        if creased:
            tight = ~mesh.loose
            edges, values = self.halves.edges(self._numbers()[mesh.edges[tight]], mesh.edge_crease[tight])
            creases = from_blender(edges, values, mesh.vertex_crease[self.kept][self.halves.origin], rule)
        ends = np.isin(self.kept[self.halves.origin], self.loose_edges)
        if not ends.any():
            return creases
        sharpness = np.where(ends, SHARPNESS_INFINITE, 0.0)
        sharpness[creases.vertices] = np.maximum(sharpness[creases.vertices], creases.vertex_sharpness)
        corners = np.flatnonzero(sharpness).astype(np.int32)
        return Creases(creases.edges, creases.edge_sharpness, corners, sharpness[corners], rule)

    def held(self, held: Held) -> Held:
        """Vertices of the mesh that may not move freely, as vertices of the cage; loose ones never move."""
        numbers = self._numbers()[held.vertices.astype(np.intp)]
        there = numbers >= 0
        weights = np.asarray(held.weights, float)[there]
        return self.halves.held(replace(held, vertices=numbers[there], weights=weights))

    def in_cage(self, vertices: np.ndarray) -> np.ndarray:
        """The numbers (k,) in the cage of vertices (k,) of the mesh, -1 for loose ones."""
        numbers = self._numbers()[np.asarray(vertices, np.intp)]
        return np.where(numbers >= 0, self.halves.index[0][numbers], -1)

    def places(self, vertices: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Places (N, 3) of the cage's vertices from places (k, 3), in the frame, of vertices (k,) of the mesh, none of them
        loose: theirs and those of their images, exactly symmetric; NAN for all others."""
        half = np.full((len(self.kept), 3), np.nan)
        half[self._numbers()[np.asarray(vertices, np.intp)]] = places
        whole = self.halves.positions(half)
        whole[np.isnan(half[self.halves.origin]).any(axis=1)] = np.nan
        return whole

    def in_mesh_numbers(self, text: str) -> str:
        """The library's sentence with vertices and faces numbered as the mesh numbers them."""
        vertex = self.kept[self.halves.origin]
        return renumbered(renumbered(text, "vertex|vertices|partner", vertex), "face|faces", self._faces())

    def _faces(self) -> np.ndarray:
        return np.tile(np.arange(len(self.face_sizes)), len(self.halves.copies))

    # ----------------------------------------------------------------------------------------------- way back --

    def written(self, cage: Cage) -> Written:
        """What of an optimized cage is to be in the mesh, and where."""
        half = self.halves.half_of(cage)
        same = len(cage.positions) == len(self.halves.origin)
        behind = len(half.vertices) + np.arange(len(self.loose))
        place, loose_place = (self.kept, self.loose) if same else (np.arange(len(half.vertices)), behind)
        moved = np.empty(len(self.kept) + len(self.loose), np.int32)  # from the mesh's numbers to those of the result
        moved[self.kept], moved[self.loose] = place[: len(self.kept)], loose_place
        edges, of_edges, of_vertices = _creases_of(cage, half, place, len(place) + len(loose_place))
        return Written(
            half, place, loose_place, place[half.face_vertices].astype(np.int32), moved[self.loose_edges], edges,
            of_edges, of_vertices,
        )  # fmt: skip


def renumbered(text: str, nouns: str, numbers: np.ndarray) -> str:
    """The text with numbers (n,) for the indices that follow one of the nouns; other ones stay."""

    def number(found: re.Match) -> str:
        return str(numbers[int(found[0])]) if int(found[0]) < len(numbers) else found[0]

    wanted = re.compile(rf"\b(?:{nouns}) \d+(?: (?:and|to) \d+)?\b", re.IGNORECASE)
    return wanted.sub(lambda found: re.sub(r"\d+", number, found[0]), text)


def _creases_of(
    cage: Cage, half: Half, place: np.ndarray, n_vertices: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges (c, 2) of the half that have creases, numbered by `place`; their creases (c,); those of its n_vertices."""
    of_vertices = np.zeros(n_vertices, np.float32)
    if not (len(cage.creases.edges) or len(cage.creases.vertices)):
        return np.empty((0, 2), np.int32), np.empty(0, np.float32), of_vertices
    edges = np.unique(np.sort(sides(cage.face_sizes, cage.face_vertices), axis=1), axis=0)
    edge, vertex = to_blender(cage, edges)
    number = np.full(len(cage.positions), -1, np.int32)
    number[half.vertices] = place
    ends = number[edges]
    chosen = (edge > 0) & (ends >= 0).all(axis=1)
    of_vertices[place] = vertex[half.vertices]
    return ends[chosen], edge[chosen], of_vertices


@dataclass(frozen=True)
class Written:
    """The mesh that a result becomes: `half` of the optimized cage, whose vertices have the numbers `place` (p,);
    loose_place (l,), those of the loose ones; face_vertices; loose_edges (k, 2); crease_edges (c, 2) with their creases
    edge_crease (c,); vertex_crease (p + l,)."""

    half: Half
    place: np.ndarray
    loose_place: np.ndarray
    face_vertices: np.ndarray
    loose_edges: np.ndarray
    crease_edges: np.ndarray
    edge_crease: np.ndarray
    vertex_crease: np.ndarray

    @property
    def face_sizes(self) -> np.ndarray:
        """(m,)"""
        return self.half.face_sizes

    def positions(self, whole: np.ndarray, loose: np.ndarray) -> np.ndarray:
        """Positions (p + l, 3) from those of the optimized cage (N, 3) and of the loose vertices (l, 3)."""
        values = np.empty((len(self.place) + len(self.loose_place), 3))
        values[self.place], values[self.loose_place] = self.half.positions(whole), loose
        return values

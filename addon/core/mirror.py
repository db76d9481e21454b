# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a cage and the whole one that a Mirror modifier makes of it. No bpy.

Follows `BKE_mesh_mirror_apply_mirror_on_axis_for_modifier` (blenkernel/intern/mesh_mirror.c, Blender 3.4 to 5.x): axis
by axis the mesh is doubled; a face of a copy has the first corner of its original, and the others backwards; a vertex
is merged with its own image, never with another vertex, if they are nearer than the threshold in the object's own
coordinates, and goes to their middle, which is on the plane.

The whole consists of *copies* of the half, 2 for one axis, 8 for three. Copy c is reflected across those axes whose bit
(x 1, y 2, z 4) it has. Copy 0 is the half itself: its vertices and faces are the first of the whole, in their order. A
vertex on a plane is the same in the copies on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..binding.values import Cage, Held


@dataclass(frozen=True)
class Halves:
    """n vertices of a half in the N of the whole: `copies` (k,), the bits of each; `index` (k, n), where in the whole
    each copy of a vertex is; `origin` (N,) and `bits` (N,), the vertex and the copy that each one of the whole is;
    `on_plane` (n, 3), whether a vertex is merged with its image across x, y, z."""

    copies: np.ndarray
    index: np.ndarray
    origin: np.ndarray
    bits: np.ndarray
    on_plane: np.ndarray

    @classmethod
    def of_planes(cls, axes: tuple[int, ...], on_plane: np.ndarray) -> Halves:
        """Mirrored across `axes`, of 0 .. 2, ascending; without one the whole is the half. on_plane (n, 3) bool."""
        n = len(on_plane)
        copies = np.array([sum(1 << axis for i, axis in enumerate(axes) if c >> i & 1) for c in range(1 << len(axes))])
        merged = on_plane @ (1, 2, 4)  # as bits
        own = copies[:, None] & ~merged[None, :]  # the copy that a vertex of a copy is
        new = own == copies[:, None]
        number = np.cumsum(new.reshape(-1)).reshape(new.shape) - 1
        row = np.zeros(8, np.intp)
        row[copies] = np.arange(len(copies))
        index = number[row[own], np.arange(n)[None, :]]
        return cls(copies, index.astype(np.int32), np.nonzero(new)[1], copies[np.nonzero(new)[0]], on_plane)

    @property
    def axes(self) -> tuple[int, ...]:
        """The axes of the planes, 0 .. 2."""
        return tuple(axis for axis in range(3) if self.copies[-1] >> axis & 1)

    def positions(self, half: np.ndarray) -> np.ndarray:
        """Positions of the whole (N, 3), exactly symmetric, from those of the half (n, 3); planes go through 0."""
        flat = np.where(self.on_plane, 0.0, half)
        signs = 1.0 - 2.0 * (self.bits[:, None] >> np.arange(3) & 1)
        return flat[self.origin] * signs + 0.0

    def faces(self, sizes: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Faces of the whole, copy by copy, from those of the half: sizes (m,), vertices (sum of sizes,)."""
        start = np.cumsum(sizes) - sizes
        place = np.arange(len(vertices)) - np.repeat(start, sizes)
        backwards = vertices[np.repeat(start, sizes) + (-place) % np.repeat(sizes, sizes)]
        turned = [bin(copy).count("1") % 2 for copy in self.copies]
        corners = [self.index[c][backwards if odd else vertices] for c, odd in enumerate(turned)]
        return np.tile(sizes, len(self.copies)), np.concatenate(corners).astype(np.int32)

    def edges(self, edges: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the whole, each once, with their values, from those of the half (e, 2), (e,)."""
        if len(self.copies) == 1:
            return edges.astype(np.int32), values
        images = np.concatenate([index[edges] for index in self.index])
        _, first = np.unique(np.sort(images.astype(np.int64), axis=1) @ (len(self.origin), 1), return_index=True)
        return images[first].astype(np.int32), np.tile(values, len(self.copies))[first]

    def held(self, held: Held) -> Held:
        """Vertices of the half that may not move freely, with all their images."""
        weight = np.zeros(len(self.on_plane))
        weight[held.vertices] = held.weights
        vertices = np.flatnonzero(weight[self.origin])
        assert held.places is None  # no control of Blender's gives any
        return replace(held, vertices=vertices.astype(np.int32), weights=weight[self.origin[vertices]])

    def half_of(self, whole: Cage) -> Half:
        """What is to be kept of an optimized whole: the faces that come from the half, and their vertices. Subdivision
        keeps the order of faces, and puts the vertices of the cage first."""
        n_faces = len(whole.face_sizes) // len(self.copies)
        corners = [part for part in np.split(whole.face_vertices, self._corner_ends(whole, n_faces))]
        used = [np.bincount(part, minlength=len(whole.positions)) > 0 for part in corners]
        vertices = np.flatnonzero(used[0])
        number = np.full(len(whole.positions), -1, np.int32)
        number[vertices] = np.arange(len(vertices))
        on_plane = np.zeros((len(vertices), 3), bool)
        for copy, there in zip(self.copies, used):
            if copy in (1, 2, 4):  # a vertex of the half that is in the copy across the plane, too, is on it
                on_plane[:, (1, 2, 4).index(copy)] = there[vertices]
        return Half(vertices, whole.face_sizes[:n_faces], number[corners[0]], on_plane)

    def _corner_ends(self, whole: Cage, n_faces: int) -> np.ndarray:
        """Where in face_vertices each copy ends, the last excepted."""
        return np.cumsum(whole.face_sizes)[n_faces - 1 :: n_faces][:-1]

    def in_plane(self, sizes: np.ndarray, vertices: np.ndarray) -> int:
        """The first face of the half that lies in a plane, or -1. Blender keeps it once, as a wall inside, and its
        edges then have three faces."""
        flat = np.logical_and.reduceat(self.on_plane[vertices], np.cumsum(sizes) - sizes, axis=0).any(axis=1)
        return int(np.argmax(flat)) if flat.any() else -1


@dataclass(frozen=True)
class Half:
    """A half taken from a whole: its `vertices` (p,) there; faces, numbered in the half; on_plane (p, 3)."""

    vertices: np.ndarray
    face_sizes: np.ndarray
    face_vertices: np.ndarray
    on_plane: np.ndarray

    def positions(self, whole: np.ndarray) -> np.ndarray:
        """Its positions (p, 3) among those of the whole (N, 3), those on a plane exactly there."""
        return np.where(self.on_plane, 0.0, whole[self.vertices])


def planes_text(symmetry: str, axes: tuple[int, ...]) -> str:
    """The symmetry of a run on a mirrored cage: the planes of the mirror, and those that were chosen besides. Without
    a mirror, what was chosen."""
    chosen = {axis for axis in symmetry.split(",") if axis in ("x", "y", "z")}
    return ",".join(sorted(chosen | {"xyz"[axis] for axis in axes})) if axes else symmetry



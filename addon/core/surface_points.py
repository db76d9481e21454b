# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a cage's surface, and the quads between them: what is drawn, coloured and measured. No bpy.

Every point knows a face of the cage and its parameters there, so that positions and derivatives are exact, however few
points there are. `lattice` takes the vertices of the subdivided cage, `grids` a grid on each face.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..binding import library

_AT_ONCE = 2048  # points between two looks at whether they are still wanted: some 10 ms
_NUDGE = 1e-3  # of a quad, towards its middle, where derivatives do not exist at its corner


@dataclass(frozen=True)
class SurfacePoints:
    """quads (q, 4): vertices of each, counter-clockwise seen from outside. For every vertex (n,): a face of the cage,
    corner and parameters (n, 2) in it, as curvopt_sampler_jets() wants them; `inside` (n, 2), a little further in."""

    quads: np.ndarray
    face: np.ndarray
    corner: np.ndarray
    uv: np.ndarray
    inside: np.ndarray

    def jets(self, mesh: library.Mesh, xyz: np.ndarray, surface: str = "limit") -> np.ndarray:
        """Points and derivatives (n, 10, 3) of the surface of the cage `mesh` at xyz (v, 3), as of jets_of()."""
        return self.jets_unless(mesh, xyz, lambda: False, surface)

    def jets_unless(
        self, mesh: library.Mesh, xyz: np.ndarray, is_over: Callable[[], bool], surface: str = "limit"
    ) -> np.ndarray | None:
        """The same; None if meanwhile nobody wants them any more."""
        options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index(surface))
        parts = [slice(begin, begin + _AT_ONCE) for begin in range(0, len(self.face), _AT_ONCE)]
        found = []
        with library.Sampler.create(mesh, xyz, options) as sampler:
            for part in parts:
                if is_over():
                    return None
                found.append(self.jets_of(sampler, part))
        return np.concatenate(found) if found else np.empty((0, 10, 3))

    def jets_of(self, sampler: library.Sampler, part: slice = slice(None)) -> np.ndarray:
        """Points and derivatives (n, 10, 3) of its surface, at a part of the points (n). Derivatives at extraordinary vertices,
        where there are none, are those close by."""
        face, corner, inside = self.face[part], self.corner[part], self.inside[part]
        jets = sampler.jets(face, corner, self.uv[part])
        bad = np.flatnonzero(~np.isfinite(jets).all(axis=(1, 2)))
        if bad.size:
            near = sampler.jets(face[bad], corner[bad], inside[bad])
            near[:, 0] = np.where(np.isfinite(jets[bad, 0]), jets[bad, 0], near[:, 0])
            jets[bad] = near
        return jets


@dataclass(frozen=True)
class Net:
    """What is drawn: points of a surface; for each of its quads (q,) face, corner and the parameters of its corners (q, 4, 2)."""

    points: SurfacePoints
    triangles: np.ndarray
    face: np.ndarray
    corner: np.ndarray
    uv: np.ndarray


def lattice(mesh: library.Mesh, levels: int) -> SurfacePoints:
    """The quads of `mesh` subdivided `levels` times, at least once if it has other faces than quads. Neighbouring faces
    share the points of their common edge."""
    info = mesh.info()
    sizes, vertices = mesh.faces()
    if not info.all_quads:
        levels = max(levels, 1)
    face, corner, uv = parameters(sizes, levels)
    fine = mesh
    for _ in range(levels):
        fine, _xyz = fine.refine(np.zeros((fine.info().n_vertices, 3)))
    quads = fine.faces()[1].reshape(-1, 4) if levels else vertices.reshape(-1, 4)
    n = fine.info().n_vertices
    first = np.empty(n, np.int64)  # one corner of a quad for each vertex
    first[quads.reshape(-1)[::-1]] = np.arange(quads.size)[::-1]
    middle = uv.mean(axis=1, keepdims=True)
    inside = (uv + _NUDGE * (middle - uv)).reshape(-1, 2)
    return SurfacePoints(quads, face[first // 4], corner[first // 4], uv.reshape(-1, 2)[first], inside[first])


def grids(sizes: np.ndarray, side: int, faces: np.ndarray | None = None) -> SurfacePoints:
    """`side` x `side` quads on each patch of a cage with faces of these sizes (m,), or of some `faces` (k,) only. A patch
    is a quad, or one of the quads into which another polygon is subdivided. Each has points of its own, (side + 1)^2 in
    rows: surfaces whose derivatives jump from face to face show it, and an integral is a product rule on each patch."""
    chosen = np.arange(len(sizes)) if faces is None else np.asarray(faces)
    parts = np.where(sizes[chosen] == 4, 1, sizes[chosen])
    corner = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    step = np.linspace(0.0, 1.0, side + 1)
    grid = np.stack(np.meshgrid(step, step, indexing="ij"), -1).reshape(-1, 2)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(side), np.arange(side), indexing="ij"))
    first = i * (side + 1) + j
    quads = np.stack([first, first + side + 1, first + side + 2, first + 1], -1)
    n, patches = len(grid), len(corner)
    quads = (quads[None] + n * np.arange(patches)[:, None, None]).reshape(-1, 4)
    face = np.repeat(np.repeat(chosen, parts), n).astype(np.int32)
    uv = np.tile(grid, (patches, 1))
    inside = uv + _NUDGE / side * (0.5 - uv)
    return SurfacePoints(quads, face, np.repeat(corner, n).astype(np.int32), uv, inside)


def grid_net(sizes: np.ndarray, side: int) -> Net:
    """A grid on each patch: exact where derivatives jump, as at creases."""
    points = grids(sizes, side)
    first = points.quads[:, 0]
    return Net(points, triangles(points.quads), points.face[first], points.corner[first], points.uv[points.quads])


def lattice_net(mesh: library.Mesh, levels: int) -> Net:
    """The vertices of the subdivided cage, of which the library measures distances."""
    levels = levels if mesh.info().all_quads else max(levels, 1)
    points = lattice(mesh, levels)
    return Net(points, triangles(points.quads), *parameters(mesh.faces()[0], levels))


def parameters(sizes: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For the quads that faces of these sizes have after `levels` subdivisions: face (q,), corner (q,), and uv of the
    quads' corners (q, 4, 2). Child k of a face starts at its corner k, as curvopt_mesh_refine() has it."""
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    face = np.arange(len(sizes), dtype=np.int32)
    corner = np.zeros(len(sizes), np.int32)
    uv = np.tile(unit, (len(sizes), 1, 1))
    for level in range(levels):
        counts = sizes if level == 0 else np.full(len(face), 4)
        k = (np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)).astype(np.int32)
        quarters = _quarters(uv)[np.repeat(np.arange(len(face)), counts), k % 4]
        if level == 0:
            polygon = np.repeat(sizes != 4, counts)
            quarters[polygon] = unit
            corner = np.where(polygon, k, 0).astype(np.int32)
        else:
            corner = np.repeat(corner, counts)
        face, uv = np.repeat(face, counts), quarters
    return face, corner, uv


def _quarters(uv: np.ndarray) -> np.ndarray:
    """Corners (q, 4, 4, 2) of the four children of quads with corners uv (q, 4, 2)."""
    ahead, back = (uv + np.roll(uv, -1, 1)) / 2, (uv + np.roll(uv, 1, 1)) / 2
    middle = np.broadcast_to(uv.mean(axis=1, keepdims=True), uv.shape)
    return np.stack([uv, ahead, middle, back], 2)


def levels_for(n_faces: int, wanted: int) -> int:
    """Subdivisions, 0 .. 4, after which a cage of `n_faces` has about `wanted` quads, but not many more."""
    levels = 0
    while levels < 4 and n_faces * 4 ** (levels + 1) <= wanted:
        levels += 1
    return levels


def triangles(quads: np.ndarray) -> np.ndarray:
    """Two triangles (2 q, 3) int32 for each quad (q, 4)."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.int32)


def face_edges(sizes: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """The edges (e, 2) int32 of polygons, each once."""
    start = np.cumsum(sizes) - sizes
    following = np.arange(len(vertices)) + 1
    following[start + sizes - 1] = start
    pairs = np.sort(np.stack([vertices, vertices[following]], -1), 1)
    return np.unique(pairs, axis=0).astype(np.int32)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) of length 1; what has none stays 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)

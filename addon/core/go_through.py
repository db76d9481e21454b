# SPDX-License-Identifier: GPL-3.0-or-later
"""Places in space that the surface is to go through, and which points of the surface go there. No bpy.

The point of the surface that goes to a place is the one that is nearest to it on the original: a vertex' own if it is near
that, else one inside a face.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from ..binding import library
from ..binding.library import CurvoptError
from ..binding.through import Through
from ..binding.values import Cage
from . import surface_points

_SIDE = 4  # quads along a patch in which the nearest point is first looked for
_STEPS = 20  # of Gauss and Newton's method from there
_NEAR = 0.15  # of a patch: up to here a vertex' own point is taken, whose values are better conditioned
_INSIDE = 0.9  # of the patch of a face that is no quad: its last corner is the face's middle, where nothing can be held
_CHUNK = 64  # places that are compared with all samples at once


@dataclass(frozen=True)
class Places:
    """points (k, 3); normals (k, 3) of the surface there, NAN where it is free; and what each is of, for people."""

    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    normals: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    names: tuple[str, ...] = ()

    def named(self, error: BaseException) -> BaseException:
        """The library's refusal with the names of what entries are of; other errors as they are."""
        if not isinstance(error, CurvoptError):
            return error

        def name(found: re.Match) -> str:
            index = int(found[1])
            return self.names[index] if index < len(self.names) else found[0]

        text = re.sub(r"\bentry (\d+)", name, error.message)
        return CurvoptError(error.code, error.element, text)

    def entries(self, cage: Cage) -> tuple[Through, ...]:
        """What the cage's limit surface is to go through. ValueError for numbers that are none; LibraryError,
        CurvoptError."""
        if not self.names:
            return ()
        bad = np.flatnonzero(~np.isfinite(self.points).all(axis=1))
        if bad.size:
            raise ValueError(f"{self.names[bad[0]]} is at no place: {self.points[bad[0]]}.")
        with library.Mesh.of_cage(library.load(), cage) as mesh:
            face, corner, uv = nearest(mesh, cage.positions, self.points)
        sizes = np.asarray(cage.face_sizes)
        vertex = _vertices(cage, face, corner, uv, self.points)
        uv = np.where(sizes[face, None] == 4, uv, np.minimum(uv, _INSIDE))
        return tuple(
            Through(vertex=None if v < 0 else int(v), face=int(f) if v < 0 else None, uv=tuple(p) if v < 0 else None,
                    corner=int(c) if v < 0 else 0, at=place, normal=normal if np.isfinite(normal).all() else None)
            for v, f, c, p, place, normal in zip(vertex, face, corner, uv, self.points, self.normals)
        )  # fmt: skip


def nearest(mesh: library.Mesh, xyz: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Face (k,), corner (k,) and parameters (k, 2), as of Sampler.jets(), of the points of the limit surface that are
    nearest to `points` (k, 3), as far as samples and steps from there tell."""
    samples = surface_points.grids(mesh.faces()[0], _SIDE)
    options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
    with library.Sampler.create(mesh, xyz, options) as sampler:
        at = samples.jets_of(sampler)[:, 0]
        best = np.concatenate([
            np.linalg.norm(at[None] - part[:, None], axis=2).argmin(axis=1)
            for part in np.array_split(points, -(-len(points) // _CHUNK))
        ])  # fmt: skip
        face, corner, uv = samples.face[best], samples.corner[best], samples.inside[best].copy()
        for _ in range(_STEPS):
            jets = sampler.jets(face, corner, uv)
            uv = np.clip(uv + _step(jets, points), 1e-6, 1 - 1e-6)
    return face, corner, uv


def _step(jets: np.ndarray, points: np.ndarray) -> np.ndarray:
    """A step (k, 2) in the parameters towards `points` (k, 3); 0 where the surface has no tangents."""
    tangents, gap = jets[:, 1:3], points - jets[:, 0]
    metric = tangents @ tangents.transpose(0, 2, 1)
    slope = (tangents @ gap[:, :, None])[:, :, 0]
    determinant = metric[:, 0, 0] * metric[:, 1, 1] - metric[:, 0, 1] ** 2
    raw = np.stack([metric[:, 1, 1] * slope[:, 0] - metric[:, 0, 1] * slope[:, 1],
                    metric[:, 0, 0] * slope[:, 1] - metric[:, 0, 1] * slope[:, 0]], -1)  # fmt: skip
    good = np.isfinite(raw).all(axis=1) & (determinant > 0)
    return np.where(good[:, None], raw / np.where(good, determinant, 1.0)[:, None], 0.0)


def _vertices(cage: Cage, face: np.ndarray, corner: np.ndarray, uv: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The vertex (k,) whose own point is taken, each for one place at most; -1: a point inside the face."""
    sizes, vertices = np.asarray(cage.face_sizes), np.asarray(cage.face_vertices)
    start = np.cumsum(sizes) - sizes
    side = np.rint(uv).astype(int)
    off = np.abs(uv - side).max(axis=1)
    of_quad = np.array([[0, 3], [1, 2]])[side[:, 0], side[:, 1]]
    is_quad = sizes[face] == 4
    found = vertices[start[face] + np.where(is_quad, of_quad, corner)]
    found = np.where((off <= _NEAR) & (is_quad | (side == 0).all(axis=1)), found, -1)
    taken: set[int] = set()
    for k in np.argsort(off, kind="stable"):
        if found[k] in taken:
            found[k] = -1
        elif found[k] >= 0:
            taken.add(int(found[k]))
    return found

# SPDX-License-Identifier: GPL-3.0-or-later
"""Places in space that the surface is to go through, and which points of the surface go there; chains of edges on curves. No bpy.

The point of the surface that goes to a place is the one that is nearest to it on the original: a vertex' own if it is near
that, else one inside a face.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..binding import library
from ..binding.library import CurvoptError
from ..binding.through import Chain, Through
from ..binding.values import Cage
from . import surface_points
from .balls import Touch

_SAMPLES = 100_000  # of the surface, about; from 1 to 4 quads along a patch have one at each corner
_PATCHES = 6  # whose nearest samples Newton's method begins at: a patch of the nearest sample alone need not have the point
_STEPS = 20  # of Newton's method
_NEAR = 0.15  # of a patch: up to here a vertex' own point is taken, whose values are better conditioned
_INSIDE = 0.9  # of the patch of a face that is no quad: its last corner is the face's middle, where nothing can be held
_AT_ONCE = 4_000_000  # distances
_EDGE = 1e-6  # of a patch: derivatives need not exist at its corners


@dataclass(frozen=True)
class Places:
    """points (k, 3); normals (k, 3) of the surface there, NAN where it is free; and what each is of, for people. `weight`, 0 to 1,
    says how firmly. `balls` by number of the places at which the surface is curved like a ball, too. Of the cage also `chains`,
    on curves of those names. `remark` is what may not be as it was meant, in a sentence."""

    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    normals: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    names: tuple[str, ...] = ()
    weight: float = 1.0
    chains: tuple[Chain, ...] = ()
    chain_names: tuple[str, ...] = ()
    balls: Mapping[int, Touch] = field(default_factory=dict)
    remark: str = ""

    def named(self, error: BaseException, cage: Cage) -> BaseException:
        """The library's refusal with the names of what entries are of, and, for the vertex of `cage` that it blames among those
        that depend on each other, the nearest place; other errors as they are."""
        if not isinstance(error, CurvoptError):
            return error

        def name(names: tuple[str, ...], found: re.Match) -> str:
            index = int(found[1])
            return names[index] if index < len(names) else found[0]

        text = re.sub(r"\bentry (\d+)", partial(name, self.names), error.message)
        text = re.sub(r"\bchain (\d+)", partial(name, tuple(f"the chain of '{of}'" for of in self.chain_names)), text)
        if self.names and 0 <= error.element < len(cage.positions):
            near = self.names[int(np.linalg.norm(self.points - cage.positions[error.element], axis=1).argmin())]
            touch = r"\bthe limit points of (\d+) vertices that touch each other, vertex \d+ among them,"
            text = re.sub(touch, lambda found: f"{found[1]} places near each other, {near} among them,", text)
        return CurvoptError(error.code, error.element, text)

    def mirrored(self, axes: tuple[int, ...], near: float) -> Places:
        """With the images of all places across the planes through 0 at right angles to `axes`, of 0 .. 2, each once: a place
        nearer than `near` to a plane lies in it, and where an image is that near to a place there is none. Of no chains and
        balls."""
        points, normals, names = self.points, self.normals, self.names
        for axis in axes:
            flat = np.abs(points[:, axis]) <= near
            points = np.where(flat[:, None] & (np.arange(3) == axis), 0.0, points)
            across = np.where(np.arange(3) == axis, -1.0, 1.0)
            new = [k for k in np.flatnonzero(~flat) if not (np.abs(points - points[k] * across).max(axis=1) <= near).any()]
            points = np.concatenate([points, points[new] * across])
            normals = np.concatenate([normals, normals[new] * across])
            names += tuple(names[k] for k in new)
        return replace(self, points=points, normals=normals, names=names)

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
            outward = _normals(mesh, cage.positions, face, corner, uv) if self.balls else self.normals
        sizes = np.asarray(cage.face_sizes)
        vertex = _vertices(cage, face, corner, uv)
        vertex[[k for k in self.balls if vertex[k] >= 0 and not _has_curvatures(cage, vertex[k])]] = -1
        middle = (sizes[face] != 4) & (uv > _INSIDE).all(axis=1)
        uv = np.where(middle[:, None], _INSIDE, uv)
        return tuple(
            Through(vertex=None if v < 0 else int(v), face=int(f) if v < 0 else None, uv=tuple(p) if v < 0 else None,
                    corner=int(c) if v < 0 else 0, at=place, normal=normal if np.isfinite(normal).all() else None,
                    weight=self.weight, **self._curvatures(k, outward[k]))
            for k, (v, f, c, p, place, normal) in enumerate(zip(vertex, face, corner, uv, self.points, self.normals))
        )  # fmt: skip

    def _curvatures(self, k: int, outward: np.ndarray) -> dict[str, np.ndarray]:
        """Of place k, where the original's normal (3,) points `outward`: a ball on that side is in a hollow."""
        if k not in self.balls:
            return {}
        ball = self.balls[k]
        sign = -1.0 if ball.normal @ outward < 0 else 1.0
        return {"curvatures": sign * ball.curvatures, "curvature_direction": ball.direction}


def nearest(mesh: library.Mesh, xyz: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Face (k,), corner (k,) and parameters (k, 2), as of Sampler.jets(), of the points of the limit surface that are
    nearest to `points` (k, 3): the best that Newton's method finds from the nearest samples of several patches."""
    sizes = mesh.faces()[0]
    n_patches = int(np.where(sizes == 4, 1, sizes).sum())
    side = int(np.clip(np.sqrt(_SAMPLES / n_patches) - 1, 1, 4))
    samples = surface_points.grids(sizes, side)
    options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
    with library.Sampler.create(mesh, xyz, options) as sampler:
        at = samples.jets_of(sampler)[:, 0].reshape(n_patches, -1, 3)
        rows = -(-len(points) * len(samples.face) // _AT_ONCE)
        first = np.concatenate([_first(at, part) for part in np.array_split(points, rows)])
        tried, first = first.shape[1], first.reshape(-1)
        face, corner = samples.face[first], samples.corner[first]
        uv, distance = _descend(sampler, face, corner, samples.inside[first], np.repeat(points, tried, axis=0))
    best = np.arange(0, len(first), tried) + distance.reshape(-1, tried).argmin(axis=1)
    return face[best], corner[best], uv[best]


def _normals(
    mesh: library.Mesh, xyz: np.ndarray, face: np.ndarray, corner: np.ndarray, uv: np.ndarray
) -> np.ndarray:
    """Normals (k, 3), of any length, of the limit surface at these points."""
    options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
    with library.Sampler.create(mesh, xyz, options) as sampler:
        jets = sampler.jets(face, corner, uv)
    return np.cross(jets[:, 1], jets[:, 2])


def _has_curvatures(cage: Cage, vertex: int) -> bool:
    """Whether the library holds curvatures at a vertex: four faces meet there, all round it."""
    of_corner = np.repeat(np.arange(len(cage.face_sizes)), cage.face_sizes)
    faces = of_corner[np.asarray(cage.face_vertices) == vertex]
    edges = surface_points.face_edges(cage.face_sizes, cage.face_vertices)
    return len(faces) == 4 and len(np.unique(np.sort(edges[(edges == vertex).any(axis=1)], axis=1), axis=0)) == 4


def _first(at: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The nearest sample, of those `at` (patches, samples of each, 3), on each of the nearest patches to `points` (k, 3):
    numbers (k, patches that are tried)."""
    flat = np.where(np.isfinite(at), at, 1e150).reshape(-1, 3)
    centre = points.mean(axis=0)  # far from 0 squares would have no digits left
    flat, points = flat - centre, points - centre
    square = (flat * flat).sum(axis=1) - 2 * points @ flat.T
    square = square.reshape(len(points), *at.shape[:2])
    sample, least = square.argmin(axis=2), square.min(axis=2)
    tried = min(_PATCHES, len(at))
    patch = np.argpartition(least, tried - 1, axis=1)[:, :tried]
    return patch * at.shape[1] + np.take_along_axis(sample, patch, axis=1)


def _descend(
    sampler: library.Sampler, face: np.ndarray, corner: np.ndarray, uv: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (k, 2), from `uv` and in their patches, where the distance (k,) from `points` (k, 3) is least, and it. A
    step that does not lead nearer is not made, and the next one is a quarter of it."""
    uv, part = np.clip(uv, _EDGE, 1 - _EDGE), np.ones(len(uv))
    jets = sampler.jets(face, corner, uv)
    distance = _distance(jets, points)
    for _ in range(_STEPS):
        trial = np.clip(uv + part[:, None] * _step(jets, points, uv), _EDGE, 1 - _EDGE)
        there = sampler.jets(face, corner, trial)
        reached = _distance(there, points)
        nearer = reached < distance
        uv, jets = np.where(nearer[:, None], trial, uv), np.where(nearer[:, None, None], there, jets)
        distance, part = np.where(nearer, reached, distance), np.where(nearer, 1.0, part / 4)
    return uv, distance


def _distance(jets: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances (k,); infinite where there is no surface."""
    distance = np.linalg.norm(points - jets[:, 0], axis=1)
    return np.where(np.isfinite(distance), distance, np.inf)


def _step(jets: np.ndarray, points: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Newton's step (k, 2) in the parameters towards `points` (k, 3), with the absolute values of the Hessian's
    eigenvalues, so that it leads down; along a patch's side where it would leave it; 0 without derivatives."""
    tangents, gap = jets[:, 1:3], points - jets[:, 0]
    metric = tangents @ tangents.transpose(0, 2, 1)
    slope = (tangents @ gap[:, :, None])[:, :, 0]
    bends = jets[:, 3:6] @ gap[:, :, None]
    hessian = metric - bends[:, [0, 1, 1, 2], 0].reshape(-1, 2, 2)
    good = np.isfinite(hessian).all(axis=(1, 2)) & np.isfinite(slope).all(axis=1)
    hessian, slope = np.where(good[:, None, None], hessian, np.eye(2)), np.where(good[:, None], slope, 0.0)
    stays = ((uv <= _EDGE) & (slope < 0)) | ((uv >= 1 - _EDGE) & (slope > 0))
    slope, coupled = np.where(stays, 0.0, slope), ~stays.any(axis=1)
    hessian = hessian * np.where(coupled[:, None, None], 1.0, np.eye(2))
    values, axes = np.linalg.eigh(hessian)
    values = np.maximum(np.abs(values), 1e-6 * np.abs(values).max(axis=1, keepdims=True) + 1e-300)
    along = (axes.transpose(0, 2, 1) @ slope[:, :, None])[:, :, 0] / values
    return np.clip((axes @ along[:, :, None])[:, :, 0], -1.0, 1.0)


def _vertices(cage: Cage, face: np.ndarray, corner: np.ndarray, uv: np.ndarray) -> np.ndarray:
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


def polylines(points: np.ndarray, ends: np.ndarray) -> Iterator[np.ndarray]:
    """Points (k, 3), of all (n, 3), of each line that edges (e, 2) in their order make; a closed one ends where it begins."""
    first = 0
    for i in range(1, len(ends) + 1):
        if i == len(ends) or ends[i, 0] != ends[i - 1, 1]:
            yield points[[*ends[first:i, 0], ends[i - 1, 1]]]
            first = i


def evenly(line: np.ndarray, spacing: float, most: int) -> np.ndarray:
    """Points (k, 3) along a line, about `spacing` apart and evenly; both its ends, or, of a closed one, one of them. Not
    many more than `most`; one that is no place, if the line is none."""
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    whole = lengths[-1]
    if not np.isfinite(whole):
        return np.full((1, 3), np.nan)
    if not whole > 0:
        return line[:1]
    closed = bool(np.linalg.norm(line[-1] - line[0]) <= 1e-3 * min(spacing, whole))
    pieces = max(3 if closed else 1, round(min(whole / spacing, most)))
    at = np.linspace(0, whole, pieces + 1)[: pieces if closed else None]
    return np.stack([np.interp(at, lengths, line[:, axis]) for axis in range(3)], -1)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport shows of a run: taken by the worker when the main thread has asked for it. No bpy."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..binding import library
from ..binding.values import Cage, Progress
from .surface_points import SurfacePoints, face_edges, grids, lattice, levels_for, triangles, unit

_SHOWN_QUADS = 24_000  # of the surface, more or less
_MOVING_QUADS = 6_000  # of a surface that follows the hand: note 66
_SHARE = 5.0  # the worker works at least that many times longer than it takes pictures


@dataclass(frozen=True)
class Snapshot:
    """The limit surface as points and normals (n, 3) float32 with triangles (t, 3) int32, and the cage as points (v, 3)
    float32 with edges (e, 2) int32, in the source's frame. Arrays of connectivity are the same object while the level
    and the fineness are the same."""

    points: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    cage: np.ndarray
    edges: np.ndarray
    progress: Progress | None


class Watcher:
    """Takes snapshots: `ask` from the main thread, calls from the worker, `latest` for both."""

    def __init__(self) -> None:
        self._faces: np.ndarray | None = None
        self.latest: Snapshot | None = None
        self._asked = threading.Event()
        self._asked.set()
        self._shapes: dict[int, tuple[SurfacePoints, np.ndarray, np.ndarray]] = {}  # by the number of quads wanted
        self._level = -1  # of the shapes
        self._not_before = 0.0

    def ask(self) -> None:
        """The latest one has been shown: another one is welcome."""
        self._asked.set()

    def start(self, mesh: library.Mesh, cage: Cage, faces: np.ndarray | None = None) -> None:
        """The cage that the run starts from; of a run on one level, some `faces` (k,) only."""
        self._faces = faces
        self.latest = self._take(0, mesh, cage.positions, None)

    def __call__(self, iterate: library.Iterate) -> None:
        """A step was made: take a picture if one is wanted and the last one did not cost too much."""
        begin = time.monotonic()
        if not self._asked.is_set() or begin < self._not_before:
            return
        self._asked.clear()
        progress = iterate.progress
        with iterate.mesh() as mesh:
            self.latest = self._take(progress.level, mesh, iterate.positions(), progress)
        end = time.monotonic()
        self._not_before = end + _SHARE * (end - begin)

    def take(self, mesh: library.Mesh, xyz: np.ndarray) -> Snapshot:
        """Now, and quickly, of a cage on one level: a quarter of the quads, whose corners are those of the subdivided cage in
        place of the surface's: a hundredth of the cost, note 66."""
        net, faces, edges = self._shape_of(0, mesh, _MOVING_QUADS)
        fine, points = mesh, xyz
        while len(points) < len(net.face):
            fine, points = fine.refine(points)
        single = np.float32
        return Snapshot(points.astype(single), _normals(points, net.quads).astype(single), faces, xyz.astype(single), edges, None)

    def take_exact(self, mesh: library.Mesh, xyz: np.ndarray, is_over: Callable[[], bool]) -> Snapshot | None:
        """Now, of a cage on one level, the surface itself; None if meanwhile nobody wants it any more."""
        return self._take(0, mesh, xyz, None, is_over)

    def _take(
        self, level: int, mesh: library.Mesh, xyz: np.ndarray, progress: Progress | None,
        is_over: Callable[[], bool] = lambda: False,
    ) -> Snapshot | None:  # fmt: skip
        net, faces, edges = self._shape_of(level, mesh, _SHOWN_QUADS)
        jets = net.jets_unless(mesh, xyz, is_over)
        if jets is None:
            return None
        normals = unit(np.cross(jets[:, 1], jets[:, 2]))
        single = np.float32
        return Snapshot(jets[:, 0].astype(single), normals.astype(single), faces, xyz.astype(single), edges, progress)

    def _shape_of(self, level: int, mesh: library.Mesh, wanted: int) -> tuple[SurfacePoints, np.ndarray, np.ndarray]:
        """What stays while the level does."""
        if level != self._level:
            self._level, self._shapes = level, {}
        if wanted not in self._shapes:
            net, edges = self._net(mesh, wanted)
            self._shapes[wanted] = net, triangles(net.quads), edges
        return self._shapes[wanted]

    def _net(self, mesh: library.Mesh, wanted: int) -> tuple[SurfacePoints, np.ndarray]:
        """Points of the surface, and edges (e, 2) of the cage."""
        sizes, vertices = mesh.faces()
        if self._faces is None:
            return lattice(mesh, levels_for(len(sizes), wanted)), face_edges(sizes, vertices)
        shown = np.zeros(len(sizes), bool)
        shown[self._faces] = True
        side = 2 ** levels_for(len(self._faces), wanted)
        return grids(sizes, side, self._faces), face_edges(sizes[shown], vertices[np.repeat(shown, sizes)])


def _normals(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) at points (n, 3): the mean over the quads (q, 4) round each, by their area."""
    a, b, c, d = (points[quads[:, corner]] for corner in range(4))
    areas = np.repeat(np.cross(c - a, d - b), 4, axis=0)
    corners = quads.reshape(-1)
    return unit(np.stack([np.bincount(corners, areas[:, axis], len(points)) for axis in range(3)], -1))

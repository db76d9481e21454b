# SPDX-License-Identifier: GPL-3.0-or-later
"""The way of a run from the original to its result, as a few states that are about equally far from each other. No bpy.

How far vertices have moved is the root mean square over the cage, summed over all steps. States of earlier levels are subdivided
to the vertices of the last one, which does not change their surface.
"""

from __future__ import annotations

import contextlib

import numpy as np

from ..binding import library
from ..binding.values import rms_radius

STATES = 25  # original and result among them
_ROOM = 4 * STATES  # states that are kept during a run
_FIRST_STEP = 1e-4  # of the RMS radius: between states that are kept, at the beginning


class Recorder:
    """Called by the worker after every step; `path` at the end."""

    def __init__(self, start: np.ndarray) -> None:
        self._start = self._last = start.copy()
        self._step = _FIRST_STEP * rms_radius(start)
        self._length = 0.0
        self._kept: list[tuple[float, np.ndarray]] = []  # how far it was until then, and vertices (n, 3)

    def __call__(self, iterate: library.Iterate) -> None:
        """A step was made."""
        self.see(iterate.positions())

    def see(self, xyz: np.ndarray) -> None:
        """The cage (n, 3) after a step; with more vertices than before, the first of another level."""
        if len(xyz) == len(self._last):
            self._length += _apart(xyz, self._last)
        self._last = xyz
        if self._length >= self._step + (self._kept[-1][0] if self._kept else 0.0):
            self._kept.append((self._length, xyz))
        if len(self._kept) > _ROOM:
            self._step *= 2
            kept, self._kept = self._kept, []
            for length, state in kept:
                if not self._kept or length >= self._kept[-1][0] + self._step:
                    self._kept.append((length, state))

    def path(self, mesh: library.Mesh, final: np.ndarray) -> tuple[np.ndarray, ...]:
        """States (n, 3), STATES at most, on the vertices of the result `final` (n, 3); the first one is the original, on `mesh`,
        and the last one the result. Only the last, if nothing has moved."""
        if len(final) == len(self._last):
            self._length += _apart(final, self._last)
        if not self._length > 0:
            return (final,)
        lengths = np.array([length for length, _ in self._kept])
        chosen = []
        for target in np.linspace(0.0, self._length, STATES)[1:-1]:
            nearest = int(np.argmin(np.abs(lengths - target))) if len(lengths) else -1
            if nearest >= 0 and nearest not in chosen and 0 < lengths[nearest] < self._length:
                chosen.append(nearest)
        states = [self._start, *(self._kept[index][1] for index in sorted(chosen))]
        return (*_on_vertices(mesh, states, len(final)), final)


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square distance of vertices (n, 3)."""
    return float(np.linalg.norm(one - other) / np.sqrt(len(one)))


def _on_vertices(mesh: library.Mesh, states: list[np.ndarray], n_vertices: int) -> list[np.ndarray]:
    """The states, each subdivided until it has so many vertices; `mesh` is that of the first one."""
    with contextlib.ExitStack() as stack:
        meshes = {len(states[0]): mesh}
        while max(meshes) < n_vertices:
            finer, _ = meshes[max(meshes)].refine(np.zeros((max(meshes), 3)))
            meshes[finer.info().n_vertices] = stack.enter_context(finer)
        found = []
        for xyz in states:
            while len(xyz) < n_vertices:
                finer, xyz = meshes[len(xyz)].refine(xyz)
                finer.close()
            found.append(xyz)
        return found

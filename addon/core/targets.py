# SPDX-License-Identifier: GPL-3.0-or-later
"""From handles that were moved to what the solver holds, and where. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..binding import library
from ..binding.values import Cage, Held
from .layout import Layout
from .partners import Pairs, mirror_signs
from .surface_points import lattice


@dataclass(frozen=True)
class Base:
    """A cage, its `layout`, and where handles of its vertices begin (N, 3): at the vertices themselves or, `on_surface`,
    at the points of the surface that belong to them."""

    cage: Cage
    layout: Layout
    points: np.ndarray
    on_surface: bool

    @classmethod
    def of_cage(cls, cage: Cage, layout: Layout, on_surface: bool) -> Base:
        """LibraryError, CurvoptError."""
        return cls(cage, layout, limit_points(cage) if on_surface else cage.positions, on_surface)

    def without_point(self, vertices: np.ndarray) -> int:
        """The first of vertices (k,) of the mesh to which no point of the surface belongs that could be held, as where a crease
        fades; -1 if there is none, or the vertices themselves are held. LibraryError, CurvoptError."""
        if not self.on_surface or not len(vertices):
            return -1
        held = replace(Held.exactly(self.layout.in_cage(vertices).astype(np.int32)), limit_points=True)
        with library.Mesh.of_cage(library.load(), self.cage) as mesh:
            try:
                mesh.moving_level(self.cage.positions, mesh.lib.options({"willmore": 1.0}, held))
            except library.CurvoptError as error:
                if "on the limit point of vertex" in error.message:  # all else is for the run to say
                    return int(vertices[error.element])
        return -1

    def of_vertices(self, vertices: np.ndarray) -> np.ndarray:
        """Where handles of vertices (k,) of the mesh, none of them loose, begin (k, 3)."""
        return self.points[self.layout.in_cage(vertices)]

    def held(
        self, pins: Held, vertices: np.ndarray, shifts: np.ndarray, planes: Sequence[int] = ()
    ) -> tuple[Held, np.ndarray]:
        """What the cage's vertices are held by, and at which places (k, 3), NAN for where they are: `pins` of the cage, and
        exactly the vertices (h,) of the mesh, each shifted (h, 3), with their images by a Mirror modifier. The image of a
        handle across `planes`, axes of a symmetry that was chosen, moves as it does; of two handles that are images of each
        other the one that was moved farther decides. Loose vertices do not count."""
        kept = self.layout.in_cage(vertices) >= 0
        vertices, shifts = np.asarray(vertices, np.intp)[kept], np.asarray(shifts, float).reshape(-1, 3)[kept]
        places = self.layout.places(vertices, self.of_vertices(vertices) + shifts)
        for axis in planes:
            self._make_symmetric(places, axis)
        weights = np.zeros(len(places))
        weights[pins.vertices] = pins.weights
        weights[~np.isnan(places[:, 0])] = 1
        held = np.flatnonzero(weights).astype(np.int32)
        return Held(held, weights[held], self.on_surface), places[held]

    def _make_symmetric(self, places: np.ndarray, axis: int) -> None:
        """Places (N, 3), NAN for no handle, across the middle of the cage."""
        points, middle = self.cage.positions, np.zeros(3)
        middle[axis] = (points[:, axis].min() + points[:, axis].max()) / 2
        partner, signs = Pairs.of_points(points - middle, axis).partner, mirror_signs(axis)
        far = np.linalg.norm(places - self.points, axis=1)  # NAN for no handle
        far[np.isnan(far)] = -1.0
        to_do = (far >= 0) & (partner >= 0)
        for vertex in np.argsort(-far, kind="stable"):
            if to_do[vertex]:
                image = (places[vertex] - middle) * signs + middle
                in_plane = partner[vertex] == vertex
                places[partner[vertex]] = (places[vertex] + image) / 2 if in_plane else image
                to_do[partner[vertex]] = False


def any_in_one_place(places: np.ndarray, size: float) -> bool:
    """Whether two of places (k, 3), NAN for none, are the same to a millionth or so of a size."""
    there = np.round(places[~np.isnan(places).any(axis=1)] / (1e-6 * size))
    return len(np.unique(there, axis=0)) < len(there)


def limit_points(cage: Cage) -> np.ndarray:
    """The points (n, 3) of the surface that belong to the cage's vertices."""
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        return lattice(mesh, 0).jets(mesh, cage.positions)[: len(cage.positions), 0]

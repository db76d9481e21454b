# SPDX-License-Identifier: GPL-3.0-or-later
"""What of an object in Edit Mode is to move: its selection, marked edges, the mesh's own symmetry.

The mesh is read from a copy: in Edit Mode Blender does not show the attributes of the mesh itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..binding.values import Held
from ..core.job import Request
from ..core.mirror import planes_text
from ..core.partners import Pairs, is_symmetric, with_partners
from ..core.rims import Part, changing_faces, moves_curves, moving_vertices, sliding_vertices
from .modifiers import CageError
from .read_cage import Source, check_object, source_of
from .read_marks import read_marks


@dataclass(frozen=True)
class Edit:
    """A source in Edit Mode, and which part of its cage is chosen, images included; `pairs` of the mesh's vertices for
    each axis of the mesh's own symmetry."""

    source: Source
    part: Part
    pairs: tuple[Pairs, ...]

    def request(self, base: Request, rim: str) -> Request:
        """What moves the selection and no more, with everything else as in `base`. CageError if nothing may move."""
        cage = self.source.cage
        moving = moving_vertices(cage, self.part, rim, base.boundary)
        if not moving.any():
            raise CageError(self._why_nothing_moves(base))
        sliding, boundary = np.zeros_like(moving), "free"
        if base.options.get("slide"):
            sliding = sliding_vertices(cage, self.part, rim, base.boundary)
        if sliding.any():  # the library holds them on their curves
            moving, boundary = moving | sliding, "position"
        elif base.keeps_volume and not moves_curves(cage, moving):  # a part has a boundary, which the library is to hold
            boundary = "position"
        holes = np.flatnonzero(~changing_faces(cage, moving)).astype(np.int32)
        held, symmetry = Held.exactly(np.flatnonzero(~moving)), self._symmetry(base.symmetry, moving)
        return replace(base, levels=1, records=False, boundary=boundary, symmetry=symmetry, held=held, holes=holes)

    def moving(self, request: Request) -> np.ndarray:
        """The vertices of the mesh (n,) that such a request moves."""
        kept, free = self.source.layout.kept, request.free(len(self.source.cage.positions))
        moving = np.zeros(len(self.source.mesh.positions), bool)
        moving[kept] = free[: len(kept)]
        return moving

    def _why_nothing_moves(self, base: Request) -> str:
        free = Part(self.part.selected, self.part.edges, np.full(len(self.part.marks), 4))
        if not self.part.selected.any():
            return f"Nothing may move: no vertex of a face of object '{self.source.name}' is selected, select some."
        if moving_vertices(self.source.cage, free, "free", base.boundary).any():
            return "Nothing may move: the rim holds all that is selected, choose Rim Free or select more."
        return "Nothing may move: boundary and creases hold all that is selected, choose Boundary Free or select more."

    def _symmetry(self, chosen: str, moving: np.ndarray) -> str:
        """The library's part in the mesh's own symmetry; where it can have none, the result is made symmetric
        afterwards (core/partners.py)."""
        halves, axes = self.source.layout.halves, tuple(pair.axis for pair in self.pairs)
        if halves.axes or not axes:
            return planes_text(chosen, halves.axes)
        return planes_text(chosen, axes) if self.is_symmetric(moving) else "none"

    def is_symmetric(self, moving: np.ndarray) -> bool:
        """Whether the cage, of which the vertices `moving` (N,) move, has the mesh's own symmetry by itself."""
        layout, shape = self.source.layout, self.source.space.shape
        if layout.halves.axes or np.abs(shape - np.diag(np.diag(shape))).any():
            return False
        number = np.full(len(self.source.mesh.positions) + 1, -1)  # the last one is for -1
        number[layout.kept] = np.arange(len(layout.kept))
        pairs = (Pairs(pair.axis, number[pair.partner[layout.kept]]) for pair in self.pairs)
        return all(is_symmetric(self.source.cage, moving, pair) for pair in pairs)


def read_edit(context: bpy.types.Context, obj: bpy.types.Object | None) -> Edit:
    """The object in Edit Mode, which is only read. CageError if it cannot be used."""
    check_object(obj, mode="EDIT")
    with edited_mesh(obj) as mesh:
        source = source_of(context, obj, mesh)
        pairs = _pairs(obj, mesh, source)
        chosen = with_partners(_selected(mesh), pairs) & ~_flags(mesh.vertices, "hide")
        marks = read_marks(mesh, source)
    layout = source.layout
    return Edit(source, Part(chosen[layout.kept][layout.halves.origin], *marks), pairs)


def selection_text(obj: bpy.types.Object | None) -> str:
    """What a run would move, in a sentence. Quick."""
    count = obj.data.total_vert_sel if obj is not None and obj.type == "MESH" else 0
    if not count:
        return "Nothing is selected: moves all vertices"
    images = " and their images" if any((obj.data.use_mirror_x, obj.data.use_mirror_y, obj.data.use_mirror_z)) else ""
    return f"Moves {count} selected {'vertex' if count == 1 else 'vertices'}{images}"


@contextmanager
def edited_mesh(obj: bpy.types.Object) -> Iterator[bpy.types.Mesh]:
    """A copy of the mesh as it is now; it is gone afterwards."""
    obj.update_from_editmode()
    mesh = obj.data.copy()
    try:
        yield mesh
    finally:
        bpy.data.meshes.remove(mesh)


def _flags(elements: bpy.types.bpy_prop_collection, name: str) -> np.ndarray:
    values = np.empty(len(elements), bool)
    elements.foreach_get(name, values)
    return values


def _selected(mesh: bpy.types.Mesh) -> np.ndarray:
    """The vertices (n,) that are selected; all, if none is."""
    selected = _flags(mesh.vertices, "select") & ~_flags(mesh.vertices, "hide")
    return selected if selected.any() else np.ones_like(selected)


def _pairs(obj: bpy.types.Object, mesh: bpy.types.Mesh, source: Source) -> tuple[Pairs, ...]:
    """For each axis across which Edit Mode mirrors what is done to the mesh, other than those of a Mirror modifier."""
    points = source.mesh.positions
    if not np.isfinite(points).all():
        return ()  # the library will name the vertex
    wanted = (obj.data.use_mirror_x, obj.data.use_mirror_y, obj.data.use_mirror_z)
    of_modifier = source.layout.halves.axes
    return tuple(Pairs.of_points(points, axis) for axis in range(3) if wanted[axis] and axis not in of_modifier)

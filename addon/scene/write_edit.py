# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a run in Edit Mode into the mesh that is edited: vertices that moved, and nothing else of it."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from ..core.job import Request, Solution
from ..core.layout import Written
from ..core.partners import mean_of_sides
from .modifiers import CageError, mirror_modifier
from .placement import local_positions, what_changed
from .read_cage import Source
from .read_edit import Edit, edited_mesh
from .write_result import local_object, smaller_threshold

_ROUNDING = 1e-7  # of the mesh's size: what is held comes back from the frame of the run so far off


@dataclass(frozen=True)
class Moved:
    """What was moved: `count` vertices of the object `name`, of them `vertex` most, which was at `place` (3,); what
    else the user should know, or ""."""

    count: int
    remark: str
    name: str
    vertex: int
    place: np.ndarray

    def is_undone(self) -> bool:
        """Whether that vertex is where it was. Quick."""
        obj = local_object(self.name)
        if obj is None or obj.type != "MESH":
            return True
        vertices = obj.data.vertices
        if obj.mode == "EDIT":
            vertices = bmesh.from_edit_mesh(obj.data).verts
            vertices.ensure_lookup_table()
        return self.vertex >= len(vertices) or np.array_equal(vertices[self.vertex].co, self.place)


def write_edit(edit: Edit, request: Request, solution: Solution, amount: float) -> Moved:
    """Move the vertices that may move so far towards the result. CageError if the object or its mesh is not as it
    was."""
    source = edit.source
    obj = local_object(source.name)
    why = _changed(obj, edit)
    if why:
        raise CageError(f"{why} meanwhile, so nothing was written: run it again.")
    moving, before = edit.moving(request), source.mesh.positions
    written = source.layout.written(solution.cage)
    end = local_positions(source, written, solution.cage.positions)
    end = mean_of_sides(end, moving, edit.pairs)
    after = before + amount * (end - before)
    distance = np.linalg.norm(after - before, axis=1) * moving
    moved = distance > _ROUNDING * np.ptp(before, axis=0).max()
    edited = bmesh.from_edit_mesh(obj.data)
    edited.verts.ensure_lookup_table()
    for vertex in np.flatnonzero(moved).tolist():
        edited.verts[vertex].co = after[vertex]
    edited.normal_update()
    bmesh.update_edit_mesh(obj.data, destructive=False)
    most = int(np.argmax(distance))
    remark = ". ".join(part for part in (_on_symmetry(edit, request), _on_merging(obj, source, written, after)) if part)
    return Moved(int(moved.sum()), remark, source.name, most, before[most])


def _changed(obj: bpy.types.Object | None, edit: Edit) -> str:
    """What has happened to the object since it was read, or ""."""
    name = edit.source.name
    if obj is None or obj.type != "MESH":
        return f"'{name}' was renamed or deleted"
    if obj.mode != "EDIT":
        return f"'{name}' went into another mode"
    with edited_mesh(obj) as mesh:
        return what_changed(obj, mesh, edit.source)


def _on_merging(obj: bpy.types.Object, source: Source, written: Written, local: np.ndarray) -> str:
    """Whether a Mirror modifier now merges vertices that were apart. It is no part of Edit Mode's undo: it stays."""
    modifier = mirror_modifier(obj)
    if modifier is None:
        return ""
    smaller = smaller_threshold(modifier, written, source.space.gaps(source.space.to_frame(local)))
    if smaller is None:
        return ""
    return f"Modifier '{modifier.name}' merges vertices that were apart: set its Merge distance to {smaller:.2g}"


def _on_symmetry(edit: Edit, request: Request) -> str:
    """Whether symmetry was made afterwards."""
    if not edit.pairs or edit.is_symmetric(request.free(len(edit.source.cage.positions))):
        return ""
    axes = " and ".join("XYZ"[pair.axis] for pair in edit.pairs)
    return f"The mesh is not symmetric across {axes}: pairs of vertices got the mean of both sides"

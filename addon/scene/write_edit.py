# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a run in Edit Mode into the mesh that is edited: vertices that moved, and nothing else of it."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from ..core.job import Request, Solution
from ..core.partners import mean_of_sides
from .modifiers import CageError
from .placement import local_positions, what_changed
from .read_edit import Edit, edited_mesh
from .write_result import local_object


def write_edit(edit: Edit, request: Request, solution: Solution, amount: float) -> tuple[int, str]:
    """Move the vertices that may move so far towards the result; how many they are, and what else the user should
    know, or "". CageError if the object or its mesh is not as it was."""
    source = edit.source
    obj = local_object(source.name)
    why = _changed(obj, edit)
    if why:
        raise CageError(f"{why} meanwhile, so nothing was written: run it again.")
    moving, before = edit.moving(request), source.mesh.positions
    end = local_positions(source, source.layout.written(solution.cage), solution.cage.positions)
    end = mean_of_sides(end, moving, edit.pairs)
    after = before + amount * (end - before)
    edited = bmesh.from_edit_mesh(obj.data)
    edited.verts.ensure_lookup_table()
    for vertex in np.flatnonzero(moving).tolist():
        edited.verts[vertex].co = after[vertex]
    edited.normal_update()
    bmesh.update_edit_mesh(obj.data, destructive=False)
    return int(moving.sum()), _remark(edit, request)


def _changed(obj: bpy.types.Object | None, edit: Edit) -> str:
    """What has happened to the object since it was read, or ""."""
    name = edit.source.name
    if obj is None or obj.type != "MESH":
        return f"'{name}' was deleted"
    if obj.mode != "EDIT":
        return f"'{name}' went into another mode"
    with edited_mesh(obj) as mesh:
        return what_changed(obj, mesh, edit.source)


def _remark(edit: Edit, request: Request) -> str:
    """Whether symmetry was made afterwards."""
    free = np.ones(len(edit.source.cage.positions), bool)
    free[request.held.vertices] = False
    if not edit.pairs or edit.is_symmetric(free):
        return ""
    axes = " and ".join("XYZ"[pair.axis] for pair in edit.pairs)
    return f"The mesh is not symmetric across {axes}: pairs of vertices got the mean of both sides"

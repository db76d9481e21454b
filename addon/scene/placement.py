# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a result goes: a new object (write_result.py), the object's own mesh, or a shape key of it.

Only the name of the object was kept while the run was on. If it is gone by now, or its mesh is not the one that was
read, the result becomes a new object, whatever was asked for: hours of work are not thrown away.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..binding.values import Cage
from ..core.crease import BOUNDARY_SMOOTH
from ..core.job import Request, Solution
from .amount import has_blend, store_blend
from .read_cage import CageError, Source, read_faces, read_positions, subdivision, turned_over
from .write_result import (
    add_result,
    add_subdivision,
    carry_materials,
    face_parents,
    local_object,
    make_mesh,
    shown_levels,
    store,
)

KEY_PREFIX = "Curvopt "
_SAME = 1e-5  # of the shape's size: float32 positions times the object's scale


def check_outcome(outcome: str, levels: int) -> None:
    """CageError, before a run, for an outcome that is not possible."""
    if not is_possible(outcome, levels):
        raise CageError("A shape key needs the vertices of your cage: set Resolution to Same Vertices, or Levels to 1.")


def is_possible(outcome: str, levels: int) -> bool:
    """Whether a run of so many levels can end there."""
    return outcome != "SHAPE_KEY" or levels == 1


def set_amount(obj: bpy.types.Object, amount: float) -> None:
    """Show so much of a result that write() has put there."""
    key = active_key(obj)
    if key is not None:
        key.value = amount
    elif has_blend(obj):
        obj.curvopt_amount = amount


def write(
    context: bpy.types.Context, source: Source, request: Request, solution: Solution, outcome: str
) -> tuple[bpy.types.Object, str]:
    """Put the result where it was wanted; the object, and what else the user should know, or "". CageError if it cannot
    be there."""
    check_outcome(outcome, request.levels)
    if outcome == "NEW":
        return add_result(context, source, request, solution), ""
    obj = local_object(source.name)
    why = _changed(obj, source)
    if why:
        return add_result(context, source, request, solution), f"{why} meanwhile, so the result is a new object"
    if outcome == "REPLACE" and obj.data.shape_keys:
        raise CageError(f"Object '{obj.name}' has shape keys: the result can be another one, or a new object.")
    if outcome == "SHAPE_KEY":
        _add_key(obj, source, request, solution)
    else:
        _replace(obj, source, solution)
    store(obj, source.name, request, solution)
    return obj, ""


def _changed(obj: bpy.types.Object | None, source: Source) -> str:
    """What has happened to the object since it was read, or ""."""
    if obj is None or obj.type != "MESH":
        return f"'{source.name}' was deleted"
    if obj.mode != "OBJECT":
        return f"'{source.name}' went into another mode"
    sizes, vertices = read_faces(obj.data)
    if source.mirrored:
        vertices = turned_over(sizes, vertices)
    same = np.array_equal(sizes, source.cage.face_sizes) and np.array_equal(vertices, source.cage.face_vertices)
    if not same or len(obj.data.vertices) != len(source.cage.positions):
        return f"The mesh of '{source.name}' was changed"
    moved = np.abs(read_positions(obj.data) @ source.shape.T - source.cage.positions).max()
    return f"The mesh of '{source.name}' was changed" if moved > _SAME * np.ptp(source.cage.positions) else ""


def _local(source: Source, positions: np.ndarray) -> np.ndarray:
    """Positions (n, 3) of the frame in the object's own coordinates."""
    return positions @ np.linalg.inv(source.shape).T


def _add_key(obj: bpy.types.Object, source: Source, request: Request, solution: Solution) -> None:
    """A shape key at 1; those of earlier runs go to 0, so that there is one result at a time."""
    if obj.data.users > 1:
        obj.data = obj.data.copy()
    if not obj.data.shape_keys:
        obj.shape_key_add(name="Basis")
    for key in obj.data.shape_keys.key_blocks:
        if key.name.startswith(KEY_PREFIX):
            key.value = 0.0
    key = obj.shape_key_add(name=KEY_PREFIX + request.label, from_mix=False)
    key.data.foreach_set("co", _local(source, solution.cage.positions).astype(np.float32).reshape(-1))
    key.value = 1.0
    obj.active_shape_key_index = len(obj.data.shape_keys.key_blocks) - 1
    _show_limit(obj, solution.cage)


def _replace(obj: bpy.types.Object, source: Source, solution: Solution) -> None:
    """The object's mesh becomes the result; with the same vertices, everything else about it is kept."""
    start, end = (_local(source, xyz) for xyz in (solution.start_positions, solution.cage.positions))
    if len(end) == len(obj.data.vertices):
        if obj.data.users > 1:
            obj.data = obj.data.copy()
        obj.data.vertices.foreach_set("co", end.astype(np.float32).reshape(-1))
        obj.data.update()
    else:
        cage = solution.cage
        vertices = turned_over(cage.face_sizes, cage.face_vertices) if source.mirrored else cage.face_vertices
        mesh = make_mesh(obj.data.name, Cage(end, cage.face_sizes, vertices, cage.creases))
        parents = face_parents(source.cage, solution.cage)
        carry_materials(obj, mesh, parents, source.face_material)
        obj.data = mesh
    _show_limit(obj, solution.cage)
    store_blend(obj, start, end)


def _show_limit(obj: bpy.types.Object, cage: Cage) -> None:
    """A Subdivision Surface modifier if there is none."""
    modifier = subdivision(obj)
    if modifier is None:
        add_subdivision(obj, cage.creases)
    else:
        modifier.levels = min(modifier.levels, shown_levels(len(cage.face_sizes)))
        modifier.boundary_smooth = BOUNDARY_SMOOTH[cage.creases.rule]


def active_key(obj: bpy.types.Object | None) -> bpy.types.ShapeKey | None:
    """The shape key of the last run on the object, if it has one."""
    if obj is None or obj.type != "MESH" or not obj.data.shape_keys:
        return None
    ours = [key for key in obj.data.shape_keys.key_blocks if key.name.startswith(KEY_PREFIX)]
    return ours[-1] if ours else None

# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of a surface that follows the hand: empties, children of the object, each bound to a vertex of its mesh; and
vertices that are moved in Edit Mode. What is read here is looked up by name every time: undo replaces all objects.

While it lasts the object is drawn as wire, because the surface that follows is where the object is. The object remembers
how it was drawn, so that a file that was saved meanwhile can be put right by the next session.
"""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ..core.targets import Base
from .frame import space_of
from .modifiers import CageError, read_mirror
from .read_cage import Source, read_positions
from .write_result import link_beside, local_object, select_alone

_VERTEX, _START = "curvopt_handle", "curvopt_start"  # of an empty: the vertex, and where it began in the mesh
_DISPLAY = "curvopt_display"  # of the object: how it was drawn
_SIZE = 0.03  # of an empty, in sizes of the mesh
_STILL = 2e-6  # sizes of the mesh up to which a handle counts as not moved: matrices are float32
MOST_HANDLES = 200  # empties that one session makes


@dataclass(frozen=True)
class Observation:
    """Vertices (h,) of the mesh that are handles, how far each was moved (h, 3) in the cage's frame, and where that frame
    is by now."""

    vertices: np.ndarray
    shifts: np.ndarray
    frame: Matrix


def find(name: str) -> bpy.types.Object | None:
    """The object of a session, also if it has another name by now."""
    obj = local_object(name)
    if obj is not None and _DISPLAY in obj:
        return obj
    return next((o for o in bpy.data.objects if _DISPLAY in o and o.library is None), None)


def owner(obj: bpy.types.Object | None) -> bpy.types.Object | None:
    """The object whose handles are there: `obj`, or the parent of a handle."""
    obj = obj.parent if obj is not None and _VERTEX in obj else obj
    return obj if obj is not None and _DISPLAY in obj else None


def begin(context: bpy.types.Context, obj: bpy.types.Object, source: Source, base: Base, vertices: np.ndarray) -> None:
    """Draw the object as wire, and make an empty for each of vertices (k,) of its mesh that has none."""
    if _DISPLAY not in obj:
        obj[_DISPLAY] = obj.display_type
    obj.display_type = "WIRE"
    there = set(empties(obj))
    places = source.space.to_mesh(base.of_vertices(vertices))
    size = _SIZE * float(np.ptp(source.mesh.positions, axis=0).max())
    for vertex, place in zip(vertices.tolist(), places.astype(np.float32).tolist()):
        if vertex not in there:
            empty = bpy.data.objects.new("Handle", None)
            empty.empty_display_type, empty.empty_display_size = "SPHERE", size
            empty.parent, empty.location = obj, place
            empty[_VERTEX], empty[_START] = vertex, place
            link_beside(context, obj, empty)
    context.view_layer.update()
    made = empties(obj)
    if made and context.mode == "OBJECT":
        select_alone(context, made[min(made)])


def empties(obj: bpy.types.Object) -> dict[int, bpy.types.Object]:
    """The object's handles by vertex; of copies of a handle the first one by name."""
    found: dict[int, bpy.types.Object] = {}
    for child in sorted(obj.children, key=lambda child: child.name):
        if _VERTEX in child:
            found.setdefault(int(child[_VERTEX]), child)
    return found


def observe(obj: bpy.types.Object, source: Source, chosen: np.ndarray) -> Observation:
    """The handles as they are: empties, `chosen` vertices (k,), and whatever vertices were moved. CageError where the object
    is no longer what was read."""
    n, size = len(source.mesh.positions), float(np.ptp(source.mesh.positions, axis=0).max())
    moved = _positions(obj, source) - source.mesh.positions
    moved[np.abs(moved).max(axis=1) <= _STILL * size] = 0.0
    is_handle = moved.any(axis=1)
    is_handle[chosen] = True
    world = np.linalg.inv(np.array(obj.matrix_world, np.float64))
    for vertex, empty in empties(obj).items():
        if vertex < n:
            place = world @ np.array((*empty.matrix_world.translation, 1.0))
            shift = place[:3] - np.array(empty[_START])
            moved[vertex] = 0.0 if np.abs(shift).max() <= _STILL * size else shift
            is_handle[vertex] = True
    vertices = np.flatnonzero(is_handle)
    return Observation(vertices, moved[vertices] @ source.space.shape.T, _frame(obj, source))


def _frame(obj: bpy.types.Object, source: Source) -> Matrix:
    mirror = read_mirror(obj)
    space = space_of(obj, mirror)
    if mirror != source.mirror or not space.is_like(source.space):
        raise CageError(f"Object '{obj.name}' was scaled, or its Mirror modifier changed: start Live again.")
    return space.frame


def _positions(obj: bpy.types.Object, source: Source) -> np.ndarray:
    """Positions (n, 3) of the mesh, also while it is edited. CageError if it has other vertices, edges or faces."""
    mesh, was = obj.data, source.mesh
    if obj.mode == "EDIT" and mesh.shape_keys:
        raise CageError(f"Object '{obj.name}' went into Edit Mode with shape keys: start Live again.")
    edited = bmesh.from_edit_mesh(mesh) if obj.mode == "EDIT" else None
    parts = (mesh.vertices, mesh.edges, mesh.polygons) if edited is None else (edited.verts, edited.edges, edited.faces)
    if tuple(map(len, parts)) != (len(was.positions), len(was.edges), len(was.face_sizes)):
        raise CageError(f"The mesh of '{obj.name}' has other vertices or faces by now: start Live again.")
    if edited is None:
        return read_positions(mesh)
    return np.array([vertex.co for vertex in edited.verts], np.float64).reshape(-1, 3)


def is_there(name: str) -> bool:
    """Whether a session has left something in the scene that `end` takes away."""
    return find(name) is not None or any(_is_orphan(obj) for obj in bpy.data.objects)


def end(context: bpy.types.Context, name: str, source: Source | None) -> None:
    """Take the handles away, leave Edit Mode, and put the object back as it was read, if that is known, selected and active.
    For operators: removing what is being moved crashes Blender."""
    obj = find(name)
    if obj is not None:
        if obj.mode != "OBJECT" and context.view_layer.objects.active == obj:
            bpy.ops.object.mode_set(mode="OBJECT")
        if source is not None:
            _put_back(obj, source)
        obj.display_type = obj.pop(_DISPLAY)
    for handle in [o for o in bpy.data.objects if _is_orphan(o) or (obj is not None and o.parent == obj and _VERTEX in o)]:
        bpy.data.objects.remove(handle)
    if obj is not None and obj.name in context.view_layer.objects:
        select_alone(context, obj)


def _is_orphan(obj: bpy.types.Object) -> bool:
    """Whether it is the handle of an object that was deleted."""
    return _VERTEX in obj and obj.parent is None and obj.library is None


def _put_back(obj: bpy.types.Object, source: Source) -> None:
    """The mesh's vertices, if it still is the mesh that was read."""
    mesh = obj.data
    if obj.mode != "OBJECT" or mesh.shape_keys or len(mesh.vertices) != len(source.mesh.positions):
        return
    if not np.array_equal(read_positions(mesh), source.mesh.positions):
        mesh.vertices.foreach_set("co", source.mesh.positions.astype(np.float32).reshape(-1))
        mesh.update()

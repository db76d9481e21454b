# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of a surface that follows the hand: empties, children of the object, each bound to a vertex of its mesh; and
vertices that are moved in Edit Mode. What is read here is looked up every time: undo replaces all objects.

The object and its handles bear the same mark, another one for each session: a handle may get another parent, and the
object another name. Copies bear it, too, and lose it at the end.

While it lasts the object is drawn as wire, because the surface that follows is where the object is. The object remembers
how it was drawn, so that a file that was saved meanwhile can be put right by the next session.
"""

from __future__ import annotations

from dataclasses import dataclass
from uuid import uuid4

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ..core.targets import Base
from .frame import inverse, space_of
from .modifiers import CageError, read_mirror
from .read_cage import Source, has_faces_of, read_positions
from .write_result import link_beside, select_alone

_SESSION = "curvopt_live"  # of the object and of its handles: whose they are
_VERTEX = "curvopt_handle"  # of an empty: its vertex
# Of the object: how it was drawn, the number of its vertices, and whether handles are points of the surface.
_DISPLAY, _COUNT, _SURFACE = "curvopt_display", "curvopt_vertices", "curvopt_on_surface"
_SIZE = 0.03  # of an empty, in sizes of the mesh
_STILL = 2e-6  # sizes of the mesh up to which a handle counts as not moved: matrices are float32
MOST_HANDLES = 200  # empties that one session makes


@dataclass(frozen=True)
class Observation:
    """Vertices (h,) of the mesh that are handles, how far each was moved (h, 3) in the cage's frame, where that frame is by
    now, and where the mesh's vertices are (n, 3)."""

    vertices: np.ndarray
    shifts: np.ndarray
    frame: Matrix
    positions: np.ndarray


def session_of(obj: bpy.types.Object | None) -> str:
    """Whose object or handle it is; "" for none."""
    mark = obj.get(_SESSION) if obj is not None and obj.library is None else None
    return mark if isinstance(mark, str) else ""


def _marked(session: str) -> list[bpy.types.Object]:
    return [obj for obj in bpy.data.objects if session and session_of(obj) == session]


def find(session: str, name: str) -> bpy.types.Object | None:
    """The object of a session, whatever it is called by now: of copies the one with handles, then that of this name, then
    the one that is edited."""
    marked = _marked(session)
    parents = [obj.parent for obj in marked if _VERTEX in obj]
    objects = [obj for obj in marked if _VERTEX not in obj and obj.type == "MESH"]
    return max(objects, key=lambda obj: (obj in parents, obj.name == name, obj.mode == "EDIT"), default=None)


def owner(obj: bpy.types.Object | None) -> bpy.types.Object | None:
    """The object whose handles are there: `obj`, or that of a handle."""
    return find(session_of(obj), obj.name) if session_of(obj) else None


def left_by_another(obj: bpy.types.Object) -> tuple[np.ndarray, bool] | None:
    """Handles that an earlier session has left, to be taken up: their vertices (k,), and whether they are points of the
    surface. None for none. CageError if the mesh has more or fewer vertices by now."""
    if not any(_VERTEX in handle for handle in _marked(session_of(obj))):
        return None
    if obj.get(_COUNT) != len(obj.data.vertices):
        raise CageError(
            f"The handles of object '{obj.name}' belong to a mesh with more or fewer vertices than it has by now: take them "
            "away with Cancel first."
        )
    return np.array(sorted(empties(obj)), np.intp), bool(obj.get(_SURFACE))


def begin(context: bpy.types.Context, obj: bpy.types.Object, source: Source, base: Base, vertices: np.ndarray) -> str:
    """Draw the object as wire, and make an empty for each of vertices (k,) of its mesh that has none. The mark of this
    session, which handles that are there get, too."""
    session, old = uuid4().hex, session_of(obj)
    there = set(empties(obj))
    if _DISPLAY not in obj:
        obj[_DISPLAY] = obj.display_type
    obj.display_type = "WIRE"
    for marked in [obj, *_marked(old)]:
        marked[_SESSION] = session
    obj[_COUNT], obj[_SURFACE] = len(source.mesh.positions), base.on_surface
    places = source.space.to_mesh(base.of_vertices(vertices))
    size = _SIZE * float(np.ptp(source.mesh.positions, axis=0).max())
    for vertex, place in zip(vertices.tolist(), places.astype(np.float32).tolist()):
        if vertex not in there:
            empty = bpy.data.objects.new("Handle", None)
            empty.empty_display_type, empty.empty_display_size = "SPHERE", size
            empty.parent, empty.location = obj, place
            empty[_VERTEX], empty[_SESSION] = vertex, session
            link_beside(context, obj, empty)
    context.view_layer.update()
    made = empties(obj)
    if made and context.mode == "OBJECT":
        select_alone(context, made[min(made)])
    return session


def empties(obj: bpy.types.Object) -> dict[int, bpy.types.Object]:
    """The object's handles by vertex; of copies of a handle a child of the object, and then the first one by name."""
    found: dict[int, bpy.types.Object] = {}
    for handle in sorted(_marked(session_of(obj)), key=lambda handle: (handle.parent != obj, handle.name)):
        vertex = handle.get(_VERTEX)
        if isinstance(vertex, int) and 0 <= vertex < len(obj.data.vertices):
            found.setdefault(vertex, handle)
    return found


def observe(
    obj: bpy.types.Object, source: Source, base: Base, chosen: np.ndarray, before: np.ndarray | None = None
) -> Observation:
    """The handles as they are: empties, `chosen` vertices (k,), and whatever vertices were moved; `before`, where the
    vertices (n, 3) were the last time, makes it quicker. CageError where the object is no longer what was read."""
    frame, size = frame_of(obj, source), float(np.ptp(source.mesh.positions, axis=0).max())
    positions = _positions(obj, source, before)
    moved = positions - source.mesh.positions
    moved[np.abs(moved).max(axis=1) <= _STILL * size] = 0.0
    is_handle = moved.any(axis=1)
    is_handle[chosen] = True
    world, found = np.array(obj.matrix_world, np.float64), empties(obj)
    back, origin = inverse(world[:3, :3]), world[:3, 3]
    bound = np.array([vertex for vertex in found if vertex < len(moved)], np.intp)
    bound = bound[source.layout.in_cage(bound) >= 0]
    begins = source.space.to_mesh(base.of_vertices(bound)).astype(np.float32)  # as empties have it
    for vertex, place in zip(bound.tolist(), begins):
        shift = back @ (np.array(found[vertex].matrix_world.translation) - origin) - place
        moved[vertex] = 0.0 if np.abs(shift).max() <= _STILL * size else shift
        is_handle[vertex] = True
    vertices = np.flatnonzero(is_handle)
    return Observation(vertices, moved[vertices] @ source.space.shape.T, frame, positions)


def frame_of(obj: bpy.types.Object, source: Source) -> Matrix:
    """Where the frame of its cage is by now. CageError if the cage is another one there."""
    mirror = read_mirror(obj)
    space = space_of(obj, mirror)
    if mirror != source.mirror or not space.is_like(source.space):
        raise CageError(f"Object '{obj.name}' was scaled, or its Mirror modifier changed: start Live again.")
    return space.frame


def _positions(obj: bpy.types.Object, source: Source, before: np.ndarray | None) -> np.ndarray:
    """Positions (n, 3) of the mesh, also while it is edited. CageError if it has other vertices or faces. Faces that are
    edited are slow to read: only where a vertex has begun to move since `before`."""
    mesh, was = obj.data, source.mesh
    if obj.mode == "EDIT" and mesh.shape_keys:
        raise CageError(f"Object '{obj.name}' went into Edit Mode with shape keys: start Live again.")
    if obj.mode != "EDIT":
        same = has_faces_of(mesh, was)
        positions = read_positions(mesh)
    else:
        edited = bmesh.from_edit_mesh(mesh)
        counts = len(edited.verts), len(edited.edges), len(edited.faces)
        same = counts == (len(was.positions), len(was.edges), len(was.face_sizes))
        positions = np.array([vertex.co for vertex in edited.verts], np.float64).reshape(-1, 3)
        if same and (before is None or ((positions != before) & (before == was.positions)).any()):
            edited.verts.index_update()
            faces = [[vertex.index for vertex in face.verts] for face in edited.faces]
            same = [len(face) for face in faces] == was.face_sizes.tolist() and sum(faces, []) == was.face_vertices.tolist()
    if not same:
        raise CageError(f"The mesh of '{obj.name}' has other vertices or faces by now: start Live again.")
    return positions


def is_there(session: str) -> bool:
    """Whether a session has left something in the scene that `end` takes away."""
    return bool(_marked(session))


def end(
    context: bpy.types.Context, session: str, name: str, source: Source | None = None, last: np.ndarray | None = None
) -> bool:
    """Take the handles away, leave Edit Mode, and put the object back as it was read, if that is known, selected and active;
    with `last`, where vertices (n, 3) were, only those that are there still. False if the mesh is another one by now, and
    left alone. For operators: removing what is being moved crashes Blender."""
    obj, is_back = find(session, name), True
    is_shown = obj is not None and obj.name in context.view_layer.objects
    if is_shown and obj.mode != "OBJECT":
        context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="OBJECT")
    if obj is not None and source is not None:
        is_back = _put_back(obj, source, last)
    for marked in _marked(session):
        if _VERTEX in marked and marked.type == "EMPTY":
            bpy.data.objects.remove(marked)
        else:
            _clear(marked)
    if is_shown:
        select_alone(context, obj)
    return is_back


def _clear(obj: bpy.types.Object) -> None:
    """An object, or a copy of it, without marks."""
    for mark in (_SESSION, _VERTEX, _COUNT, _SURFACE):
        obj.pop(mark, None)
    display = obj.pop(_DISPLAY, None)
    kinds = bpy.types.Object.bl_rna.properties["display_type"].enum_items
    if display is not None:
        obj.display_type = display if display in kinds.keys() else "TEXTURED"


def _put_back(obj: bpy.types.Object, source: Source, last: np.ndarray | None) -> bool:
    """The mesh's vertices, if it still is the mesh that was read; whether it is."""
    mesh = obj.data
    if obj.mode != "OBJECT" or not has_faces_of(mesh, source.mesh):
        return False
    now = read_positions(mesh)
    is_ours = np.ones(len(now), bool) if last is None else (now == last).all(axis=1)
    wanted = np.where(is_ours[:, None], source.mesh.positions, now)
    if not np.array_equal(now, wanted):
        for points in [mesh.vertices, *([mesh.shape_keys.reference_key.data] if mesh.shape_keys else [])]:
            points.foreach_set("co", wanted.astype(np.float32).reshape(-1))
        mesh.update()
    return True

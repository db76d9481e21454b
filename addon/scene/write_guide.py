# SPDX-License-Identifier: GPL-3.0-or-later
"""A curve along selected edges of a mesh in Edit Mode, which their chain follows from then on (read_targets.py)."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from ..core import guides
from ..core.surface_points import face_edges
from ..core.targets import limit_points
from .modifiers import CageError
from .read_cage import check_object, source_of
from .read_edit import edited_mesh

_COLLECTION = "Guides"


def add_guide(context: bpy.types.Context, obj: bpy.types.Object | None, collection: str) -> bpy.types.Object:
    """A Bezier curve through the points of the surface that belong to the selected vertices, which are one chain of edges, and a
    vertex group of its name with them. It goes into the collection of that name, if there is one, or into one of the scene.
    CageError, CurvoptError, before anything was made."""
    check_object(obj, mode="EDIT")
    with edited_mesh(obj) as mesh:
        source = source_of(context, obj, mesh)
        chosen = [vertex.index for vertex in mesh.vertices if vertex.select and not vertex.hide]
    if source.mirror is not None:
        raise CageError(f"Object '{obj.name}' has a Mirror modifier, with which no curve can be followed: apply it first.")
    used = source.layout.in_cage(np.array(chosen, int))
    if not len(chosen) or (used < 0).any():
        what = f"Vertex {chosen[int((used < 0).argmax())]}, which has no face, is selected" if len(chosen) else "No vertex is selected"
        raise CageError(f"{what}: select the vertices of a chain of edges.")
    edges = source.layout.kept[face_edges(source.cage.face_sizes, source.cage.face_vertices)]
    try:
        chain, is_closed = guides.ordered(np.array(chosen), edges)
    except ValueError as error:
        raise CageError(f"The selection {error}: select the vertices of one chain of edges.") from error
    points = limit_points(source.cage)[source.layout.in_cage(chain)]
    frame = np.array(source.frame, np.float64)
    parent = _collection_of(context, collection)
    name = _free_name(obj)
    _assign(obj, name, chosen)
    guide = bpy.data.objects.new(name, _curve(name, points @ frame[:3, :3].T + frame[:3, 3], is_closed))
    if parent is None:
        parent = bpy.data.collections.new(_COLLECTION)
        context.scene.collection.children.link(parent)
    parent.objects.link(guide)
    return guide


def _free_name(obj: bpy.types.Object) -> str:
    """A name that no object, curve or vertex group of the object has."""
    number, name = 1, "Guide"
    while name in bpy.data.objects or name in bpy.data.curves or name in obj.vertex_groups:
        name = f"Guide.{number:03}"
        number += 1
    return name


def _assign(obj: bpy.types.Object, name: str, vertices: list[int]) -> None:
    """A new vertex group of the object, which is in Edit Mode."""
    index = obj.vertex_groups.new(name=name).index
    edited = bmesh.from_edit_mesh(obj.data)
    layer = edited.verts.layers.deform.verify()
    edited.verts.ensure_lookup_table()
    for vertex in vertices:
        edited.verts[vertex][layer][index] = 1.0
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)


def _curve(name: str, points: np.ndarray, is_closed: bool) -> bpy.types.Curve:
    """A Bezier curve with automatic handles through points (k, 3)."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("BEZIER")
    spline.bezier_points.add(len(points) - 1)
    for knot, point in zip(spline.bezier_points, points):
        knot.co, knot.handle_left_type, knot.handle_right_type = point, "AUTO", "AUTO"
    spline.use_cyclic_u = is_closed
    return data


def _collection_of(context: bpy.types.Context, name: str) -> bpy.types.Collection | None:
    """The collection of that name, or None. CageError for one that cannot take what the scene shows."""
    found = bpy.data.collections.get(name) if name else None
    if found is not None and found.library is not None:
        raise CageError(f"The collection '{name}' is from a library, and nothing can be added to it: choose another one at Go Through.")
    if found is not None and found not in context.scene.collection.children_recursive:
        raise CageError(f"The collection '{name}' is not in this scene: link it to the scene, or choose another one at Go Through.")
    return found

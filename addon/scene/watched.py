# SPDX-License-Identifier: GPL-3.0-or-later
"""The cage of an object as it is shown now: while it is edited, moved by shape keys, or dragged. For looks many times a
second: what stays is not read again.

An object in Edit Mode is read from the mesh that is edited, and nothing is copied or written, because a grab may be on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ..binding.values import Cage
from ..core.layout import Layout, MeshArrays
from .amount import start_of
from .frame import space_of
from .modifiers import CageError, check_detail, read_mirror
from .read_cage import Source, check_object, check_relative, read_positions, source_of, source_of_arrays

_CREASES = ("crease_edge", "crease_vert")  # layers, from Blender 4.0 on


@dataclass(frozen=True)
class Seen:
    """A cage in `frame`; `selected` (p, 2): its selected edges, in vertices of the cage; `original` (N, 3): where its vertices
    were before the run or runs that it comes from, or None if that is not known."""

    cage: Cage
    frame: Matrix
    selected: np.ndarray
    original: np.ndarray | None


class Watched:
    """Looks at one object after the other."""

    def __init__(self) -> None:
        self._source: Source | None = None

    def look(
        self, context: bpy.types.Context, obj: bpy.types.Object | None, thorough: bool, with_selected: bool = True,
        with_original: bool = True,
    ) -> Seen:  # fmt: skip
        """The object as it is now. More or fewer vertices, edges or faces are always seen; other faces, creases and modifiers by
        a `thorough` look. Selected edges only `with_selected`, the original only `with_original`. CageError if it cannot be used."""
        mode = "EDIT" if obj is not None and obj.mode == "EDIT" else "OBJECT"
        check_object(obj, mode == "OBJECT", mode)
        source = self._source
        fits = source is not None and source.name == obj.name and not thorough
        positions = _positions_of(obj) if fits else None
        if not fits or not _has_counts_of(obj, source) or len(positions) != len(source.mesh.positions):
            source = self._source = _read(context, obj)
            positions = _positions_of(obj)
        space = space_of(obj, read_mirror(obj))
        if not space.is_like(source.space):
            source = self._source = _read(context, obj)
            space = source.space
        points = source.layout.halves.positions(space.to_frame(positions)[source.layout.kept])
        cage = replace(source.cage, positions=points)
        selected = selected_pairs(obj, source.layout) if with_selected else np.empty((0, 2), np.int32)
        return Seen(cage, space.frame, selected, self._original(obj, source) if with_original else None)

    def _original(self, obj: bpy.types.Object, source: Source) -> np.ndarray | None:
        """Of a result: from the attribute that Amount uses; of shape keys the first one."""
        start = start_of(obj) if obj.mode == "OBJECT" else None
        if start is None and obj.data.shape_keys:
            start = read_positions(obj.data)
        if start is None or len(start) != len(source.mesh.positions):
            return None
        return source.layout.halves.positions(source.space.to_frame(start)[source.layout.kept])


def _read(context: bpy.types.Context, obj: bpy.types.Object) -> Source:
    if obj.mode != "EDIT":
        return source_of(context, obj, obj.data)
    check_detail(obj)
    mesh = _edited(bmesh.from_edit_mesh(obj.data))
    if not len(mesh.face_sizes):
        raise CageError(f"Object '{obj.name}' has no faces.")
    return source_of_arrays(obj, mesh, np.zeros(len(mesh.face_sizes), np.int32))


def _edited(edit: bmesh.types.BMesh) -> MeshArrays:
    """A mesh that is edited; without lists, which would wake the garbage collector for 30 ms."""
    edit.verts.index_update()
    edges = np.fromiter((vertex.index for edge in edit.edges for vertex in edge.verts), np.int32).reshape(-1, 2)
    loose = np.fromiter((edge.is_wire for edge in edit.edges), bool)
    sizes = np.fromiter((len(face.verts) for face in edit.faces), np.int32)
    vertices = np.fromiter((vertex.index for face in edit.faces for vertex in face.verts), np.int32)
    creases = (_layer(parts, name) for parts, name in zip((edit.edges, edit.verts), _CREASES))
    return MeshArrays(_edited_positions(edit), edges, loose, *creases, sizes, vertices)


def _layer(parts: bmesh.types.BMEdgeSeq | bmesh.types.BMVertSeq, name: str) -> np.ndarray:
    """Creases of all edges or vertices, float32."""
    layers = parts.layers
    layer = layers.float.get(name) if bpy.app.version >= (4, 0, 0) else layers.crease.active
    if layer is None:
        return np.zeros(len(parts), np.float32)
    return np.fromiter((part[layer] for part in parts), np.float32)


def _edited_positions(edit: bmesh.types.BMesh) -> np.ndarray:
    numbers = chain.from_iterable(vertex.co for vertex in edit.verts)
    return np.fromiter(numbers, np.float64, 3 * len(edit.verts)).reshape(-1, 3)  # a sixth of the time of np.array()


def _has_counts_of(obj: bpy.types.Object, source: Source) -> bool:
    """Whether the object has as many vertices, edges and faces."""
    was = source.mesh
    if obj.mode == "EDIT":
        edit = bmesh.from_edit_mesh(obj.data)
        now = len(edit.verts), len(edit.edges), len(edit.faces)
    else:
        now = len(obj.data.vertices), len(obj.data.edges), len(obj.data.polygons)
    return now == (len(was.positions), len(was.edges), len(was.face_sizes))


def _positions_of(obj: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) as they are shown before modifiers: edited, or mixed of shape keys."""
    if obj.mode == "EDIT":
        return _edited_positions(bmesh.from_edit_mesh(obj.data))
    keys = obj.data.shape_keys
    return read_positions(obj.data) if keys is None else _mixed(obj, keys)


def _mixed(obj: bpy.types.Object, keys: bpy.types.Key) -> np.ndarray:
    """What relative shape keys with their values make. CageError for what it cannot mix."""
    if obj.show_only_shape_key:
        return _key_positions(obj.active_shape_key or keys.reference_key)
    check_relative(obj)
    mixed = _key_positions(keys.reference_key)
    for key in keys.key_blocks[1:]:
        if key.mute or key.value == 0:
            continue
        if key.vertex_group:
            raise CageError(f"Shape key '{key.name}' of object '{obj.name}' has a vertex group: clear it, or set its value to 0.")
        mixed = mixed + key.value * (_key_positions(key) - _key_positions(key.relative_key))
    return mixed


def _key_positions(key: bpy.types.ShapeKey) -> np.ndarray:
    values = np.empty((len(key.data), 3), np.float32)
    key.data.foreach_get("co", values.reshape(-1))
    return values.astype(np.float64)


def selected_pairs(obj: bpy.types.Object, layout: Layout) -> np.ndarray:
    """The selected edges (p, 2) in vertices of the cage."""
    pairs = layout.in_cage(_selected_edges(obj).reshape(-1)).reshape(-1, 2)
    return pairs[(pairs >= 0).all(axis=1)]


def _selected_edges(obj: bpy.types.Object) -> np.ndarray:
    """The vertices (p, 2) of the mesh's selected edges; in Object Mode those that Edit Mode has left."""
    if obj.mode == "EDIT":
        edges = bmesh.from_edit_mesh(obj.data).edges
        chosen = (vertex.index for edge in edges if edge.select and not edge.hide for vertex in edge.verts)
        return np.fromiter(chosen, np.int32).reshape(-1, 2)
    mesh = obj.data
    selected, ends = np.empty(len(mesh.edges), bool), np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("select", selected)
    mesh.edges.foreach_get("vertices", ends.reshape(-1))
    return ends[selected]

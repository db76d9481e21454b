# SPDX-License-Identifier: GPL-3.0-or-later
"""From a mesh object to arrays, and every reason to refuse one.

Energies are those of the shape in the world. A cage is read in a rigid *frame*, the object's location and rotation; its
scale (uniform or not, mirrored or not) is worked into the positions. So lengths are the world's and numbers stay small.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix

from .values import Cage

_SAME_SCALE = 1e-6  # float32 matrices: a scale this close to uniform is uniform


class CageError(RuntimeError):
    """The object cannot be used; the message is a sentence that says what is wrong, where, and what to do."""


@dataclass(frozen=True)
class Source:
    """An object's cage, holding no reference to Blender's data.

    `cage` is in `frame` (rigid, 4 x 4), turned so that its faces are counter-clockwise seen from outside in the world;
    face_material (m,) is the material slot of each face."""

    name: str
    frame: Matrix
    cage: Cage
    face_material: np.ndarray


def read_source(context: bpy.types.Context, obj: bpy.types.Object | None) -> Source:
    """The cage of `obj`, which is only read. CageError if it cannot be used."""
    check_object(obj)
    check_mesh(obj.name, obj.data)
    context.view_layer.update()  # matrix_world lags behind what scripts set
    frame, shape = split_matrix(obj)
    sizes, vertices = read_faces(obj.data)
    if np.linalg.det(shape) < 0:
        vertices = turned_over(sizes, vertices)
    material = np.empty(len(sizes), np.int32)
    obj.data.polygons.foreach_get("material_index", material)
    return Source(obj.name, frame, Cage(read_positions(obj.data) @ shape.T, sizes, vertices), material)


def check_object(obj: bpy.types.Object | None) -> None:
    """CageError unless `obj` is a local mesh object in Object Mode whose mesh is the cage that is shown."""
    if obj is None or obj.type != "MESH":
        found = "nothing is active" if obj is None else f"'{obj.name}' is a {obj.type.lower()}"
        raise CageError(f"Select a mesh object first: {found}.")
    if obj.library or obj.override_library or obj.data.library or obj.data.override_library:
        raise CageError(f"Object '{obj.name}' or its mesh is linked from another file: make it local first.")
    if obj.mode != "OBJECT":
        mode = obj.mode.replace("_", " ").title()
        raise CageError(f"Object '{obj.name}' is in {mode} Mode: switch to Object Mode first.")
    for modifier in obj.modifiers:
        if modifier.show_viewport or modifier.show_render:
            _check_modifier(obj, modifier)


def _check_modifier(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> None:
    where = f"Modifier '{modifier.name}' of object '{obj.name}'"
    if modifier.type != "SUBSURF":
        raise CageError(f"{where} changes the cage or its surface: apply or remove it first.")
    if modifier.subdivision_type != "CATMULL_CLARK":
        raise CageError(f"{where} is set to Simple: set it to Catmull-Clark first.")


def check_mesh(name: str, mesh: bpy.types.Mesh) -> None:
    """CageError for what the arrays could not carry: shape keys, creases, loose edges, no faces."""
    if mesh.shape_keys:
        raise CageError(f"Object '{name}' has shape keys: apply or remove them first.")
    if not mesh.polygons:
        raise CageError(f"Object '{name}' has no faces.")
    for kind, crease in (("Edge", _edge_creases(mesh)), ("Vertex", _vertex_creases(mesh))):
        if crease.any():
            index = int(np.flatnonzero(crease)[0])
            where = f"{kind} {index} of object '{name}'"
            raise CageError(f"{where} has a crease of {crease[index]:.3g}: set it to 0, creases cannot be kept.")
    used = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", used)
    loose = np.flatnonzero(np.bincount(used, minlength=len(mesh.edges)) == 0)
    if loose.size:
        raise CageError(f"Edge {loose[0]} of object '{name}' belongs to no face: delete loose edges first.")


def _edge_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    if bpy.app.version >= (4, 0, 0):
        return _attribute_values(mesh, "crease_edge")
    values = np.zeros(len(mesh.edges), np.float32)
    mesh.edges.foreach_get("crease", values)
    return values


def _vertex_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    if bpy.app.version >= (4, 0, 0):
        return _attribute_values(mesh, "crease_vert")
    values = np.zeros(len(mesh.vertices) if mesh.vertex_creases else 0, np.float32)
    if len(values):
        mesh.vertex_creases[0].data.foreach_get("value", values)
    return values


def _attribute_values(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    attribute = mesh.attributes.get(name)
    values = np.zeros(len(attribute.data) if attribute else 0, np.float32)
    if len(values):
        attribute.data.foreach_get("value", values)
    return values


def read_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Local vertex positions (n, 3) float64; Blender stores them as float32."""
    values = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", values.reshape(-1))
    return values.astype(np.float64)


def read_faces(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(face_sizes (m,), face_vertices (sum of sizes,)), int32, in polygon order."""
    start, size = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", start)
    mesh.polygons.foreach_get("loop_total", size)
    vertex = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertex)
    packed_start = np.cumsum(size) - size
    return size, vertex[np.repeat(start - packed_start, size) + np.arange(size.sum())]


def turned_over(sizes: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """face_vertices with every face's corners in reverse order."""
    start = np.cumsum(sizes) - sizes
    return vertices[np.repeat(2 * start + sizes - 1, sizes) - np.arange(len(vertices))]


def split_matrix(obj: bpy.types.Object) -> tuple[Matrix, np.ndarray]:
    """matrix_world as frame @ shape: a rigid 4 x 4 Matrix and what is left, (3, 3) float64. CageError if flat."""
    world = obj.matrix_world
    frame = Matrix.Translation(world.to_translation()) @ world.to_quaternion().to_matrix().to_4x4()
    linear = np.array(world.to_3x3(), np.float64)
    shape = np.array(frame.to_3x3(), np.float64).T @ linear
    scale = np.linalg.norm(linear, 2)
    if not np.isfinite(scale) or abs(np.linalg.det(linear)) <= 1e-9 * scale**3:
        raise CageError(f"Object '{obj.name}' is scaled to zero: give it a scale other than 0 on every axis.")
    uniform = np.trace(shape) / 3
    if np.abs(shape - uniform * np.eye(3)).max() <= _SAME_SCALE * abs(uniform):
        uniform = 1.0 if abs(uniform - 1.0) <= _SAME_SCALE else uniform
        shape = uniform * np.eye(3)
    return frame, shape

# SPDX-License-Identifier: GPL-3.0-or-later
"""From a mesh object to arrays, and every reason to refuse one.

Energies are those of the shape in the world. A cage is read in a rigid *frame*, the object's location and rotation; its
scale (uniform or not, mirrored or not) is worked into the positions. So lengths are the world's and numbers stay small.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np
from mathutils import Matrix

from ..binding.values import Cage, Creases, Held
from ..core.crease import RULE_OF_BOUNDARY_SMOOTH, from_blender
from ..core.messages import UserError

_SAME_SCALE = 1e-6  # float32 matrices: a scale this close to uniform is uniform


class CageError(UserError):
    """The object cannot be used; the message is a sentence that says what is wrong, where, and what to do."""


@dataclass(frozen=True)
class Source:
    """An object's cage, holding no reference to Blender's data.

    `cage` is in `frame` (rigid, 4 x 4), turned so that its faces are counter-clockwise seen from outside in the world:
    its positions are those of the mesh times `shape` (3, 3); face_material (m,) is the material slot of each face."""

    name: str
    frame: Matrix
    cage: Cage
    face_material: np.ndarray
    shape: np.ndarray

    @property
    def mirrored(self) -> bool:
        """Whether the faces of `cage` run the other way round than the mesh's."""
        return bool(np.linalg.det(self.shape) < 0)


def read_source(context: bpy.types.Context, obj: bpy.types.Object | None, with_keys: bool = False) -> Source:
    """The cage of `obj`, which is only read; `with_keys`, that of its first shape key if there are any. CageError if it
    cannot be used."""
    check_object(obj, with_keys)
    check_mesh(obj.name, obj.data)
    context.view_layer.update()  # matrix_world lags behind what scripts set
    frame, shape = split_matrix(obj)
    sizes, vertices = read_faces(obj.data)
    material = np.empty(len(sizes), np.int32)
    obj.data.polygons.foreach_get("material_index", material)
    positions = read_positions(obj.data) @ shape.T
    source = Source(obj.name, frame, Cage(positions, sizes, vertices, read_creases(obj)), material, shape)
    if source.mirrored:
        return replace(source, cage=replace(source.cage, face_vertices=turned_over(sizes, vertices)))
    return source


def check_object(obj: bpy.types.Object | None, with_keys: bool = False) -> None:
    """CageError unless `obj` is a local mesh object in Object Mode whose mesh is the cage that is shown, or its first
    shape key `with_keys`. Quick enough for every redraw of a panel."""
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
    if obj.data.shape_keys and not with_keys:
        raise CageError(f"Object '{obj.name}' has shape keys: remove them, or choose Shape Key as the result.")


def _check_modifier(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> None:
    where = f"Modifier '{modifier.name}' of object '{obj.name}'"
    if modifier.type != "SUBSURF":
        raise CageError(f"{where} changes the cage or its surface: apply or remove it first.")
    if modifier.subdivision_type != "CATMULL_CLARK":
        raise CageError(f"{where} is set to Simple: set it to Catmull-Clark first.")


def check_mesh(name: str, mesh: bpy.types.Mesh) -> None:
    """CageError for what the arrays could not carry: creases that are no numbers, loose edges, no faces."""
    if not mesh.polygons:
        raise CageError(f"Object '{name}' has no faces.")
    for kind, crease in (("Edge", _edge_creases(mesh)), ("Vertex", _vertex_creases(mesh))):
        if not np.isfinite(crease).all():
            index = int(np.flatnonzero(~np.isfinite(crease))[0])
            raise CageError(f"{kind} {index} of object '{name}' has a crease of {crease[index]}: set it to 0 .. 1.")
    used = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", used)
    loose = np.flatnonzero(np.bincount(used, minlength=len(mesh.edges)) == 0)
    if loose.size:
        raise CageError(f"Edge {loose[0]} of object '{name}' belongs to no face: delete loose edges first.")


def read_creases(obj: bpy.types.Object) -> Creases:
    """Creases and boundary rule as the object's Subdivision Surface modifier uses them, or as a new one would."""
    modifier = subdivision(obj)
    mesh, rule = obj.data, "smooth" if modifier is None else RULE_OF_BOUNDARY_SMOOTH[modifier.boundary_smooth]
    if modifier is not None and not modifier.use_creases:
        return Creases(rule=rule)
    return from_blender(read_edges(mesh), _edge_creases(mesh), _vertex_creases(mesh), rule)


def subdivision(obj: bpy.types.Object) -> bpy.types.SubsurfModifier | None:
    """The first Subdivision Surface modifier that is switched on."""
    shown = (m for m in obj.modifiers if m.type == "SUBSURF" and (m.show_viewport or m.show_render))
    return next(shown, None)


def read_edges(mesh: bpy.types.Mesh) -> np.ndarray:
    """Vertices (e, 2) of each edge, int32."""
    vertices = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", vertices.reshape(-1))
    return vertices


def _edge_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """Creases (e,) of all edges."""
    if bpy.app.version >= (4, 0, 0):
        return _attribute_values(mesh, "crease_edge", "EDGE", len(mesh.edges))
    values = np.zeros(len(mesh.edges), np.float32)
    mesh.edges.foreach_get("crease", values)
    return values


def _vertex_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """Creases (n,) of all vertices."""
    if bpy.app.version >= (4, 0, 0):
        return _attribute_values(mesh, "crease_vert", "POINT", len(mesh.vertices))
    values = np.zeros(len(mesh.vertices), np.float32)
    if mesh.vertex_creases:
        mesh.vertex_creases[0].data.foreach_get("value", values)
    return values


def _attribute_values(mesh: bpy.types.Mesh, name: str, domain: str, count: int) -> np.ndarray:
    """The attribute's values (count,), 0 without it. CageError if it is something else than Blender makes."""
    values, attribute = np.zeros(count, np.float32), mesh.attributes.get(name)
    if attribute is None:
        return values
    if (attribute.domain, attribute.data_type) != (domain, "FLOAT"):
        kind = f"{attribute.data_type} on {attribute.domain}"
        raise CageError(f"Attribute '{name}' of mesh '{mesh.name}' is {kind}: delete it, or make it FLOAT on {domain}.")
    attribute.data.foreach_get("value", values)
    return values


def read_held(obj: bpy.types.Object, pin: str, group: str = "") -> Held:
    """Vertices of the cage of `obj` that may not move freely, by `pin`: NOTHING; GROUP, as firmly as the weights of
    the vertex group named `group` say; SELECTED or UNSELECTED, by the selection that Edit Mode has left. CageError if
    these are none where some were asked for; there is no harm in all being selected."""
    if pin == "NOTHING":
        return Held()
    if pin == "GROUP":
        return _read_group(obj, group)
    selected = np.empty(len(obj.data.vertices), bool)
    obj.data.vertices.foreach_get("select", selected)
    if not selected.any():
        raise CageError(f"No vertex of object '{obj.name}' is selected: select some in Edit Mode first.")
    return Held.exactly(np.flatnonzero(selected if pin == "SELECTED" else ~selected))


def _read_group(obj: bpy.types.Object, name: str) -> Held:
    if not name:
        raise CageError(f"No vertex group of object '{obj.name}' is chosen: choose one first, or set Pin to Nothing.")
    group = obj.vertex_groups.get(name)
    if group is None:
        raise CageError(f"Object '{obj.name}' has no vertex group '{name}': choose another one.")
    weighted = ((v.index, g) for v in obj.data.vertices for g in v.groups)
    held = [(vertex, g.weight) for vertex, g in weighted if g.group == group.index and g.weight > 0]
    if not held:
        raise CageError(
            f"Vertex group '{name}' of object '{obj.name}' pins nothing: give some vertices a weight above 0."
        )
    return Held(*map(np.array, zip(*held)))


def read_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Local vertex positions (n, 3) float64, of the first shape key if there are any; Blender stores float32."""
    values = np.empty((len(mesh.vertices), 3), np.float32)
    points = mesh.shape_keys.reference_key.data if mesh.shape_keys else mesh.vertices
    points.foreach_get("co", values.reshape(-1))
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

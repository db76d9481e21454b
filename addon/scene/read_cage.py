# SPDX-License-Identifier: GPL-3.0-or-later
"""From a mesh object to arrays, and every reason to refuse one; modifiers.py and frame.py have more of these.

Loose vertices and edges are no part of the cage, and under a Mirror modifier the cage is the whole: layout.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np
from mathutils import Matrix

from ..binding.abi import SHAPE_ERRORS
from ..binding.library import CurvoptError
from ..binding.values import Cage, Held
from ..core.crease import RULE_OF_BOUNDARY_SMOOTH
from ..core.job import Request
from ..core.layout import Layout, MeshArrays
from ..core.messages import collapsed_text
from ..core.mirror import planes_text
from .frame import Space, space_of
from .modifiers import CageError, Mirror, check_detail, check_modifiers, mirror_modifier, read_mirror, subdivision


# What people call objects that Blender can convert to meshes, and others whose types are no words.
_KINDS = {"CURVE": "curve", "SURFACE": "NURBS surface", "META": "metaball", "FONT": "text"}
_OTHER_KINDS = {
    "CURVES": "hair curves object", "POINTCLOUD": "point cloud", "GPENCIL": "Grease Pencil object",
    "GREASEPENCIL": "Grease Pencil object",
}  # fmt: skip


@dataclass(frozen=True)
class Source:
    """An object's mesh and the cage that it stands for, holding no reference to Blender's data.

    `cage` is in `space.frame`, turned so that its faces are counter-clockwise seen from outside in the world, and
    `layout` says what of it the mesh is; face_material (m,) is the material slot of each face of the mesh."""

    name: str
    mesh: MeshArrays
    space: Space
    layout: Layout
    cage: Cage
    face_material: np.ndarray
    mirror: Mirror | None = None

    @property
    def frame(self) -> Matrix:
        """Rigid, 4 x 4."""
        return self.space.frame

    @property
    def mirrored(self) -> bool:
        """Whether the faces of `cage` run the other way round than the mesh's."""
        return self.space.mirrored

    def fitted(self, request: Request) -> Request:
        """A request whose pins are vertices of the mesh, for the cage; with a Mirror modifier, for its symmetry."""
        symmetry = planes_text(request.symmetry, self.layout.halves.axes)
        return replace(request, symmetry=symmetry, held=self.layout.held(request.held))

    def loose_lines(self) -> np.ndarray:
        """The ends (2 k, 3) of loose edges in the frame."""
        return self.space.to_frame(self.mesh.positions[self.layout.loose_edges.reshape(-1)])

    def named(self, error: BaseException) -> BaseException:
        """The library's refusal with vertices and faces numbered as the mesh numbers them, and with what is to be done
        about a shape that has no surface; other errors as they are."""
        if not isinstance(error, CurvoptError):
            return error
        text = error.message if self.layout.is_plain else self.layout.in_mesh_numbers(error.message)
        if error.code in SHAPE_ERRORS:
            text += collapsed_text(self.mesh.collapsed_faces())
        return CurvoptError(error.code, error.element, text)


def read_source(context: bpy.types.Context, obj: bpy.types.Object | None, with_keys: bool = False) -> Source:
    """The cage of `obj`, which is only read; `with_keys`, that of its first shape key if there are any. CageError if it
    cannot be used."""
    check_object(obj, with_keys)
    return source_of(context, obj, obj.data)


_MOST_EDGES = 50_000  # counting their faces takes 3 ms; the panel asks at every mouse move over it


def has_boundary(obj: bpy.types.Object | None) -> bool:
    """Whether an edge of the object's mesh has one face. Quick: False for large meshes, and for halves of a surface, which
    have edges in the plane of their Mirror modifier."""
    if obj is None or obj.type != "MESH" or mirror_modifier(obj) is not None:
        return False
    mesh = obj.data
    if not 0 < len(mesh.edges) <= _MOST_EDGES or not len(mesh.loops):
        return False
    used = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", used)
    return bool((np.bincount(used) == 1).any())


def source_of(context: bpy.types.Context, obj: bpy.types.Object, data: bpy.types.Mesh) -> Source:
    """The cage of a mesh, that of an object which was checked, or a copy of it. CageError as above."""
    check_mesh(obj.name, data)
    check_detail(obj)
    context.view_layer.update()  # matrix_world lags behind what scripts set
    material = np.empty(len(data.polygons), np.int32)
    data.polygons.foreach_get("material_index", material)
    return source_of_arrays(obj, read_mesh(data), material)


def source_of_arrays(obj: bpy.types.Object, mesh: MeshArrays, material: np.ndarray) -> Source:
    """The cage of a mesh that was read, on an object that was checked; material (m,) of its faces. CageError as above."""
    mirror = read_mirror(obj)
    space = space_of(obj, mirror)
    layout = _layout(obj, mesh, space, mirror)
    vertices = turned_over(mesh.face_sizes, mesh.face_vertices) if space.mirrored else mesh.face_vertices
    cage = layout.cage(mesh, space.to_frame(mesh.positions), vertices, *_crease_rule(obj))
    return Source(obj.name, mesh, space, layout, cage, material, mirror)


def _layout(obj: bpy.types.Object, mesh: MeshArrays, space: Space, mirror: Mirror | None) -> Layout:
    """CageError for a mesh that is no half."""
    if mirror is None:
        return Layout.of_mesh(mesh)
    points = space.to_frame(mesh.positions)
    near = space.gaps(points).astype(np.float32) < np.float32(mirror.threshold)
    layout = Layout.of_mesh(mesh, mirror.axes, near & np.isin(np.arange(3), mirror.axes))
    _check_half(obj, mesh, layout, points, mirror.name)
    return layout


def _check_half(obj: bpy.types.Object, mesh: MeshArrays, layout: Layout, points: np.ndarray, modifier: str) -> None:
    """CageError for a mesh, at points (n, 3) in the frame, that is on both sides of a mirror plane, or in it."""
    flat, across = layout.face_in_plane(mesh), layout.edge_across(mesh)
    if flat >= 0:
        raise CageError(
            f"Face {flat} of object '{obj.name}' lies in the plane of modifier '{modifier}' and is a wall inside the "
            "surface: delete the face first."
        )
    if across >= 0:
        raise CageError(
            f"Edge {across} of object '{obj.name}' lies in the plane of modifier '{modifier}' and has faces on both "
            "sides of it: delete the half that the modifier makes, or remove the modifier."
        )
    if np.isfinite(points).all() and layout.is_its_own_image(points) >= 0:
        raise CageError(
            f"Object '{obj.name}' is symmetric without modifier '{modifier}', which puts its image on top of it: "
            "remove the modifier, or delete half of the mesh."
        )


def read_mesh(mesh: bpy.types.Mesh) -> MeshArrays:
    """The mesh, positions of its first shape key if there are any. CageError for creases that cannot be read."""
    used = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", used)
    loose = np.bincount(used, minlength=len(mesh.edges)) == 0
    return MeshArrays(
        read_positions(mesh), read_edges(mesh), loose, edge_creases(mesh), vertex_creases(mesh), *read_faces(mesh)
    )


def _kind(kind: str) -> str:
    """A type of objects with its article."""
    word = {**_KINDS, **_OTHER_KINDS}.get(kind, kind.lower().replace("_", " "))
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def check_object(obj: bpy.types.Object | None, with_keys: bool = False, mode: str = "OBJECT") -> None:
    """CageError unless `obj` is a local mesh object in that mode whose mesh is the cage that is shown, or its first
    shape key `with_keys`. Quick enough for every redraw of a panel."""
    if obj is None or obj.type != "MESH":
        found = "nothing is active" if obj is None else f"'{obj.name}' is {_kind(obj.type)}"
        convert = ", which Object > Convert > Mesh makes a mesh of" if obj is not None and obj.type in _KINDS else ""
        raise CageError(f"Select a mesh object first: {found}{convert}.")
    if obj.library or obj.override_library or obj.data.library or obj.data.override_library:
        raise CageError(f"Object '{obj.name}' or its mesh is linked from another file: make it local first.")
    if obj.mode != mode:
        found = obj.mode.replace("_", " ").title()
        raise CageError(f"Object '{obj.name}' is in {found} Mode: switch to {mode.title()} Mode first.")
    check_modifiers(obj)
    if obj.data.shape_keys and mode == "EDIT":
        raise CageError(f"Object '{obj.name}' has shape keys: choose Shape Key as the result in Object Mode.")
    if obj.data.shape_keys and not with_keys:
        raise CageError(f"Object '{obj.name}' has shape keys: remove them, or choose Shape Key as the result.")


def check_relative(obj: bpy.types.Object) -> None:
    """CageError for shape keys of `obj` whose values do not mix them."""
    if obj.data.shape_keys and not obj.data.shape_keys.use_relative:
        raise CageError(f"The shape keys of object '{obj.name}' are not relative: tick Relative first.")


def check_mesh(name: str, mesh: bpy.types.Mesh) -> None:
    """CageError for what the arrays could not carry: creases that are no numbers, no faces."""
    if not mesh.polygons:
        raise CageError(f"Object '{name}' has no faces.")
    for kind, crease in (("Edge", edge_creases(mesh)), ("Vertex", vertex_creases(mesh))):
        if not np.isfinite(crease).all():
            index = int(np.flatnonzero(~np.isfinite(crease))[0])
            raise CageError(f"{kind} {index} of object '{name}' has a crease of {crease[index]}: set it to 0 .. 1.")


def _crease_rule(obj: bpy.types.Object) -> tuple[str, bool]:
    """The boundary rule, of abi.BOUNDARY_RULES, and whether creases count: as the object's Subdivision Surface modifier
    has it, or as a new one would."""
    modifier = subdivision(obj)
    if modifier is None:
        return "smooth", True
    return RULE_OF_BOUNDARY_SMOOTH[modifier.boundary_smooth], modifier.use_creases


def read_edges(mesh: bpy.types.Mesh) -> np.ndarray:
    """Vertices (e, 2) of each edge, int32."""
    vertices = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", vertices.reshape(-1))
    return vertices


def edge_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """Creases (e,) of all edges."""
    if bpy.app.version >= (4, 0, 0):
        return _attribute_values(mesh, "crease_edge", "EDGE", len(mesh.edges))
    values = np.zeros(len(mesh.edges), np.float32)
    mesh.edges.foreach_get("crease", values)
    return values


def vertex_creases(mesh: bpy.types.Mesh) -> np.ndarray:
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


def read_held(obj: bpy.types.Object, pin: str, group: str = "", on_surface: bool = False) -> Held:
    """Vertices of the mesh of `obj` that may not move freely, by `pin`: NOTHING; GROUP, as firmly as the weights of
    the vertex group named `group` say; SELECTED or UNSELECTED, by the selection that Edit Mode has left. `on_surface`:
    their limit points in their place. CageError if these are none where some were asked for; there is no harm in all
    being selected."""
    return replace(_read_vertices(obj, pin, group), limit_points=on_surface)


def _read_vertices(obj: bpy.types.Object, pin: str, group: str) -> Held:
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
    if obj.vertex_groups.get(name) is None:
        raise CageError(f"Object '{obj.name}' has no vertex group '{name}': choose another one.")
    held = group_weights(obj, name)
    if not held:
        raise CageError(
            f"Vertex group '{name}' of object '{obj.name}' pins nothing: give some vertices a weight above 0."
        )
    return Held(*map(np.array, zip(*held)))


def group_weights(obj: bpy.types.Object, name: str) -> list[tuple[int, float]]:
    """Vertices of the mesh that a vertex group of the object has with weights above 0, and these."""
    index = obj.vertex_groups[name].index
    weighted = ((v.index, g) for v in obj.data.vertices for g in v.groups)
    return [(vertex, g.weight) for vertex, g in weighted if g.group == index and g.weight > 0]


def read_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Local vertex positions (n, 3) float64, of the first shape key if there are any; Blender stores float32."""
    values = np.empty((len(mesh.vertices), 3), np.float32)
    points = mesh.shape_keys.reference_key.data if mesh.shape_keys else mesh.vertices
    points.foreach_get("co", values.reshape(-1))
    return values.astype(np.float64)


def has_faces_of(mesh: bpy.types.Mesh, was: MeshArrays) -> bool:
    """Whether it still has the vertices, edges and faces that were read, wherever these are."""
    if (len(mesh.vertices), len(mesh.edges), len(mesh.polygons)) != tuple(map(len, (was.positions, was.edges, was.face_sizes))):
        return False
    sizes, vertices = read_faces(mesh)
    return np.array_equal(sizes, was.face_sizes) and np.array_equal(vertices, was.face_vertices)


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

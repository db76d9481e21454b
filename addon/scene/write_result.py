# SPDX-License-Identifier: GPL-3.0-or-later
"""From arrays to the new object beside the original, and the energies that it remembers.

The result is a new object, e.g. "Genus2 MVS", standing to the right of the original (world X, in the first place that
is free of other results), so that both are seen at once and nothing about the original changes; or in the original's
place, if its surface goes through places of the scene. Its mesh is the optimized cage
with scale 1 and the creases that subdividing has left; a Subdivision Surface modifier with the original's boundary rule
shows the limit surface; if the original is half of a cage, so is the result, and it has the original's Mirror
modifier. Loose vertices and edges are carried along. Materials are those of the original; energies are custom
properties `curvopt_before_<name>` and `curvopt_after_<name>`, what was found of the result is `curvopt_verdict`, and
`curvopt_symmetry_order` how many symmetries were kept (1: none). Selected and active, as new objects are.

A result with the vertices and faces of the original has a copy of its mesh with new positions and creases: UV maps,
vertex groups, colours, attributes, seams and custom properties of the mesh stay; faces are shaded smooth. Shape keys, animation and
custom normals do not. Where the result is refined, where the original was changed meanwhile, and where its scale turns
its faces over, the mesh is new, and these belong to the old cage and are not carried over.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ..binding.abi import SHARPNESS_INFINITE
from ..binding.values import Cage, Creases, Energies
from ..core.crease import BOUNDARY_SMOOTH, edge_indices, to_blender
from ..core.energy import ENERGY_LABELS
from ..core.job import Request, Solution
from ..core.layout import Written
from ..core.messages import deviation_text, verdict_of
from .amount import store_blend
from .modifiers import with_images
from .read_cage import (
    Source,
    edge_creases,
    has_faces_of,
    read_edges,
    read_positions,
    turned_over,
    vertex_creases,
)

_GAP = 0.1  # between original and result, in sizes of the larger
_TERMS = {name: label for name, label in ENERGY_LABELS.items() if name != "mean_curvature"}  # that is h2
# Numbers of a report that are no energies to minimize.
_BESIDES = {"helfrich": "Helfrich", "h2": "∫H²", "gauss": "∫K", "area": "Area", "volume": "Volume"}
_SHOWN_FACES = 30_000  # the modifier subdivides until there are about that many
_MAX_SHOWN_LEVELS = 5
_QUALITY = 10  # vertices are on the limit surface if quality >= levels
_OF_MIRROR = (  # settings that a result's Mirror modifier has from the original's
    "use_clip", "use_mirror_vertex_groups", "use_mirror_u", "use_mirror_v", "use_mirror_udim", "mirror_offset_u",
    "mirror_offset_v", "offset_u", "offset_v",
)  # fmt: skip
_MAX_CREASE_PARTS = 20_000  # each takes 13 kB of Blender's memory


def add_result(context: bpy.types.Context, source: Source, request: Request, solution: Solution) -> bpy.types.Object:
    """Create the object, link it where the original is, place, select and activate it."""
    name = _name_of(source.name, request.label)
    original = local_object(source.name)
    written = source.layout.written(solution.cage)
    loose = source.space.to_frame(source.mesh.positions[source.layout.loose])
    start, end = (written.positions(xyz, loose) for xyz in (solution.start_positions, solution.cage.positions))
    same = original is not None and original.type == "MESH" and _is_alike(original.data, source, written)
    mesh = original.data.copy() if same else make_result_mesh(name, written, end)
    result = bpy.data.objects.new(name, mesh)
    if same:
        _become(result, written, end)
    result.matrix_world = source.frame  # where the surface goes through places, among these
    if not request.goes_through:
        result.matrix_world = beside(context.scene, source, solution.cage.positions) @ source.frame
    if original is not None and original.type == "MESH":
        carry_materials(original, mesh, source, written)
    if source.mirror is not None:
        add_mirror(result, source, written, end)
    add_subdivision(result, solution.cage.creases)
    store(result, source.name, request, solution)
    store_blend(result, start, end)
    link_beside(context, original, result)
    select_alone(context, result)
    return result


def _name_of(source_name: str, label: str) -> str:
    """A result's, which Blender counts on where it is taken: a result that is minimized again is not called so twice."""
    return source_name if re.fullmatch(rf".* {re.escape(label)}(\.\d+)?", source_name) else f"{source_name} {label}"


def select_alone(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Make it the active and only selected object, as new ones are, unless the user is in another mode."""
    if context.mode == "OBJECT":
        for other in list(context.view_layer.objects.selected):
            other.select_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj


def local_object(name: str) -> bpy.types.Object | None:
    """The object of this file that is called so."""
    return next((o for o in bpy.data.objects if o.name == name and o.library is None), None)


def make_mesh(name: str, cage: Cage) -> bpy.types.Mesh:
    """A smooth-shaded mesh of the cage, with its creases."""
    mesh = _polygons(name, cage.positions, cage.face_sizes, cage.face_vertices)
    _set_creases(mesh, *to_blender(cage, read_edges(mesh)))
    return mesh


def make_result_mesh(name: str, written: Written, positions: np.ndarray, turned: bool = False) -> bpy.types.Mesh:
    """The same of a result, whose vertices are at `positions` (n, 3); its faces are `turned` over."""
    vertices = turned_over(written.face_sizes, written.face_vertices) if turned else written.face_vertices
    mesh = _polygons(name, positions, written.face_sizes, vertices, written.loose_edges)
    _set_result_creases(mesh, written)
    return mesh


def _is_alike(mesh: bpy.types.Mesh, source: Source, written: Written) -> bool:
    """Whether the mesh has vertices, edges and faces of the result, numbered as the result numbers them."""
    was = source.mesh
    return (
        has_faces_of(mesh, was)
        and len(written.place) + len(written.loose_place) == len(was.positions)
        and np.array_equal(written.face_sizes, was.face_sizes)
        and np.array_equal(written.face_vertices, was.face_vertices)
    )


def _become(result: bpy.types.Object, written: Written, positions: np.ndarray) -> None:
    """Give the object, whose mesh is a copy of the original's, the result's positions (n, 3) and creases."""
    mesh = result.data
    mesh.name, mesh.use_fake_user = result.name, False
    mesh.animation_data_clear()
    if mesh.shape_keys:
        result.shape_key_clear()
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.materials.clear()  # an object can have others than its mesh
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).reshape(-1))
    _set_result_creases(mesh, written)
    if mesh.has_custom_normals:
        mesh.normals_split_custom_set(np.zeros((len(mesh.loops), 3)))  # 0 stands for the normal that Blender computes
    mesh.update()


def _set_result_creases(mesh: bpy.types.Mesh, written: Written) -> None:
    """Give a mesh with the result's vertices and edges its creases."""
    edges = read_edges(mesh)
    creases = np.zeros(len(edges), np.float32)
    creases[edge_indices(edges, written.crease_edges, len(mesh.vertices))] = written.edge_crease
    _set_creases(mesh, creases, written.vertex_crease)


def _polygons(
    name: str, positions: np.ndarray, sizes: np.ndarray, vertices: np.ndarray, loose_edges: np.ndarray | tuple = ()
) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).reshape(-1))
    mesh.loops.add(len(vertices))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(vertices, np.int32))
    mesh.polygons.add(len(sizes))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(sizes) - sizes).astype(np.int32))
    if bpy.app.version < (3, 6, 0):  # later it follows from loop_start
        mesh.polygons.foreach_set("loop_total", np.ascontiguousarray(sizes, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(sizes), bool))
    if len(loose_edges):
        mesh.edges.add(len(loose_edges))
        mesh.edges.foreach_set("vertices", np.ascontiguousarray(loose_edges, np.int32).reshape(-1))
    mesh.update(calc_edges=True, calc_edges_loose=True)
    return mesh


def _set_creases(mesh: bpy.types.Mesh, edge: np.ndarray, vertex: np.ndarray) -> None:
    if not np.array_equal(edge, edge_creases(mesh)):
        _set_edge_creases(mesh, edge)
    if not np.array_equal(vertex, vertex_creases(mesh)):
        _set_vertex_creases(mesh, vertex)


def _set_edge_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    if bpy.app.version >= (4, 0, 0):
        _float_attribute(mesh, "crease_edge", "EDGE").data.foreach_set("value", values)
    else:
        mesh.edges.foreach_set("crease", values)


def _set_vertex_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    if bpy.app.version >= (4, 0, 0):
        _float_attribute(mesh, "crease_vert", "POINT").data.foreach_set("value", values)
        return
    if not mesh.vertex_creases:
        edit = bmesh.new()  # nothing else can make the layer
        edit.from_mesh(mesh)
        edit.verts.layers.crease.verify()
        edit.to_mesh(mesh)
        edit.free()
    mesh.vertex_creases[0].data.foreach_set("value", values)


def _float_attribute(mesh: bpy.types.Mesh, name: str, domain: str) -> bpy.types.FloatAttribute:
    """The mesh's own, or a new one."""
    return mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", domain)


def add_mirror(obj: bpy.types.Object, source: Source, written: Written, positions: np.ndarray) -> None:
    """The source's Mirror modifier on an object whose coordinates are those of the frame: its own axes reflect."""
    modifier = obj.modifiers.new(source.mirror.name, "MIRROR")
    modifier.use_axis = [axis in source.mirror.axes for axis in range(3)]
    original = local_object(source.name)
    theirs = None if original is None else original.modifiers.get(source.mirror.name)
    if theirs is not None and theirs.type == "MIRROR":
        for name in _OF_MIRROR:
            setattr(modifier, name, getattr(theirs, name))
    modifier.use_mirror_merge = source.mirror.threshold > 0
    if source.mirror.threshold > 0:
        scale = np.linalg.norm(source.space.shape, axis=1)[list(source.mirror.axes)].min()
        modifier.merge_threshold = source.mirror.threshold * scale
        keep_apart(modifier, written, 2 * np.abs(positions))


def keep_apart(modifier: bpy.types.MirrorModifier, written: Written, gaps: np.ndarray) -> bool:
    """Have the modifier merge the vertices on its planes and no others; gaps (n, 3) are the distances of the object's
    vertices from their images. Whether that takes a smaller threshold than it had."""
    smaller = smaller_threshold(modifier, written, gaps)
    if smaller is not None:
        modifier.merge_threshold = smaller
    return smaller is not None


def smaller_threshold(modifier: bpy.types.MirrorModifier, written: Written, gaps: np.ndarray) -> float | None:
    """The threshold that this takes, or None if it has one that does."""
    apart = gaps[written.place][~written.half.on_plane & np.array(modifier.use_axis)]
    if not modifier.use_mirror_merge or not (apart <= modifier.merge_threshold).any():
        return None
    return 0.5 * float(apart.min())


def add_subdivision(obj: bpy.types.Object, creases: Creases) -> bpy.types.SubsurfModifier:
    """A Subdivision Surface modifier that shows the limit surface of a mesh with these creases, by their boundary rule,
    finely enough to look smooth."""
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type = "CATMULL_CLARK"
    modifier.use_limit_surface = True
    modifier.use_creases = True
    modifier.boundary_smooth = BOUNDARY_SMOOTH[creases.rule]
    modifier.levels = modifier.render_levels = shown_levels(len(obj.data.polygons))
    modifier.quality = shown_quality(creases, modifier.levels)
    return modifier


def shown_quality(creases: Creases, levels: int) -> int:
    """The modifier's quality, levels .. 10: 10 unless that takes Blender too many patches. Of an edge whose sharpness
    fades it makes as many as the edge has parts after `sharpness` subdivisions, or after `quality` of them."""
    fading = creases.edge_sharpness[creases.edge_sharpness < SHARPNESS_INFINITE]
    quality = _QUALITY
    while quality > levels and np.exp2(np.minimum(fading, quality)).sum() > _MAX_CREASE_PARTS:
        quality -= 1
    return quality


def shown_levels(n_faces: int) -> int:
    """Subdivisions after which a cage of `n_faces` looks smooth, 1 .. 5."""
    levels = 1
    while levels < _MAX_SHOWN_LEVELS and n_faces * 4**levels < _SHOWN_FACES:
        levels += 1
    return levels


def face_parents(sizes: np.ndarray, n_faces: int) -> np.ndarray:
    """For each of n_faces, the one that it came from (Catmull-Clark, any number of times), of `sizes` (m,)."""
    parents = np.arange(len(sizes))
    while len(parents) < n_faces:
        parents = np.repeat(parents, sizes)
        sizes = np.full(len(parents), 4)
    return parents


def carry_materials(original: bpy.types.Object, mesh: bpy.types.Mesh, source: Source, written: Written) -> None:
    """Give `mesh` the materials of `original`, each face that of its parent."""
    for slot in original.material_slots:
        mesh.materials.append(slot.material)
    if original.material_slots:
        parents = face_parents(source.mesh.face_sizes, len(written.face_sizes))
        mesh.polygons.foreach_set("material_index", source.face_material[parents].astype(np.int32))


def beside(scene: bpy.types.Scene, source: Source, positions: np.ndarray) -> Matrix:
    """The translation along world X that puts positions (n, 3) in the source's frame into the first place to the right of
    the original that is free of other results, those of other originals as well."""
    before, after = (_transformed(points, source.frame) for points in (source.cage.positions, positions))
    low, high = after.min(axis=0), after.max(axis=0)
    gap = _GAP * max(np.ptp(before[:, 0]), np.ptp(after[:, 0]))
    left = before[:, 0].max() + gap
    boxes = sorted(tuple(map(tuple, box)) for box in _result_boxes(scene))  # by their left sides
    for (x, *others_low), (other_right, *others_high) in boxes:
        in_line = (low[1:] <= others_high).all() and (others_low <= high[1:]).all()
        if in_line and x < left + high[0] - low[0] + gap / 2 and left < other_right + gap:
            left = other_right + gap
    return Matrix.Translation((left - low[0], 0.0, 0.0))


def _result_boxes(scene: bpy.types.Scene) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The lowest and the highest coordinates (3,) of each result in the world."""
    for obj in scene.objects:
        if obj.type == "MESH" and obj.data.vertices and "curvopt_source" in obj:
            points = with_images(obj, _transformed(read_positions(obj.data), obj.matrix_world))
            yield points.min(axis=0), points.max(axis=0)


def _transformed(points: np.ndarray, matrix: Matrix) -> np.ndarray:
    """Points (n, 3) mapped by a 4 x 4 matrix."""
    rows = np.array(matrix, np.float64)
    return points @ rows[:3, :3].T + rows[:3, 3]


def link_beside(context: bpy.types.Context, original: bpy.types.Object | None, result: bpy.types.Object) -> None:
    """Into the original's first collection that this view layer shows, else the scene's own."""
    for collection in original.users_collection if original is not None else ():
        collection.objects.link(result)
        context.view_layer.update()
        if result.name in context.view_layer.objects:
            return
        collection.objects.unlink(result)
    context.scene.collection.objects.link(result)


def store(obj: bpy.types.Object, source_name: str, request: Request, solution: Solution) -> None:
    """Make the object remember what was done and found."""
    verdict = verdict_of(request, solution)
    obj["curvopt_source"] = source_name
    obj["curvopt_energy"] = request.energy
    obj["curvopt_strength"] = request.strength
    obj["curvopt_within"] = request.within
    obj["curvopt_surface"] = solution.end.surface
    obj["curvopt_stop"] = solution.stop
    obj["curvopt_verdict"] = verdict
    obj["curvopt_deviation"] = deviation_text(solution)
    obj["curvopt_symmetry_order"] = solution.symmetry_order
    for when, energies in (("before", solution.start), ("after", solution.end)):
        for name, value in _numbers(energies, request).items():
            key = f"curvopt_{when}_{name}"
            if np.isfinite(value):
                obj[key] = value
            elif key in obj:
                del obj[key]


def _numbers(energies: Energies, request: Request) -> dict[str, float]:
    """Every number of a report, by name; Helfrich's energy is another one than Willmore's with a spontaneous curvature only."""
    of_energies = {term: energies.terms[term] for term in _TERMS}
    besides = {**{name: getattr(energies, name) for name in _BESIDES}, "gauss": round(energies.gauss, 6) + 0.0}
    if not request.options.get("spontaneous_curvature"):
        besides["helfrich"] = np.nan
    return {**of_energies, **besides}  # a total curvature of 0 comes with rounding errors


def stored_energies(obj: bpy.types.Object | None) -> list[tuple[str, float, float]]:
    """(label, before, after) of a report's numbers, as a result object remembers them, NAN for those that the surface
    cannot give; empty for other objects."""
    if obj is None or "curvopt_verdict" not in obj:
        return []
    names = {**_TERMS, **_BESIDES}
    keys = ((label, f"curvopt_before_{name}", f"curvopt_after_{name}") for name, label in names.items())
    rows = [(label, obj.get(before, np.nan), obj.get(after, np.nan)) for label, before, after in keys]
    return [row for row in rows if np.isfinite(row[1:]).any()]


def stored_deviation(obj: bpy.types.Object | None) -> str:
    """How far a result is from its original, as the object remembers it; empty for other objects."""
    return "" if obj is None else str(obj.get("curvopt_deviation", ""))


def stored_verdict(obj: bpy.types.Object | None) -> str:
    """What the check of a result found, as the object remembers it; empty for other objects."""
    return "" if obj is None else str(obj.get("curvopt_verdict", ""))

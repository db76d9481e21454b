# SPDX-License-Identifier: GPL-3.0-or-later
"""From arrays to the new object beside the original, and the energies that it remembers.

The result is a new object, e.g. "Genus2 MVS", standing to the right of the original (world X, past earlier results of
the same original), so that both are seen at once and nothing about the original changes. Its mesh is the optimized cage
with scale 1 and the creases that subdividing has left; a Subdivision Surface modifier with the original's boundary rule
shows the limit surface; materials are those of the original; energies are custom properties `curvopt_before_<name>` and
`curvopt_after_<name>`, what was found of the result is `curvopt_verdict`, and `curvopt_symmetry_order` how many
symmetries were kept (1: none). Selected and active, as new objects are. UV maps, vertex groups and the like belong to
the old cage and are not carried over.
"""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ..binding.abi import SHARPNESS_INFINITE
from ..binding.values import Cage, Creases, Energies
from ..core.crease import BOUNDARY_SMOOTH, to_blender
from ..core.energy import ENERGY_LABELS
from ..core.job import Request, Solution
from ..core.messages import verdict_of
from .amount import store_blend
from .read_cage import Source, read_edges, read_positions

_GAP = 0.1  # between original and result, in sizes of the larger
_TERMS = {name: label for name, label in ENERGY_LABELS.items() if name != "mean_curvature"}  # that is h2
_BESIDES = {"h2": "∫H²", "gauss": "∫K", "area": "Area"}  # numbers of a report that are no energies to minimize
_SHOWN_FACES = 30_000  # the modifier subdivides until there are about that many
_MAX_SHOWN_LEVELS = 5
_QUALITY = 10  # vertices are on the limit surface if quality >= levels
_MAX_CREASE_PARTS = 20_000  # each takes 13 kB of Blender's memory


def add_result(context: bpy.types.Context, source: Source, request: Request, solution: Solution) -> bpy.types.Object:
    """Create the object, link it where the original is, place, select and activate it."""
    name = f"{source.name} {request.label}"
    original = local_object(source.name)
    mesh = make_mesh(name, solution.cage)
    result = bpy.data.objects.new(name, mesh)
    result.matrix_world = beside(context.scene, source, solution.cage.positions) @ source.frame
    if original is not None and original.type == "MESH":
        carry_materials(original, mesh, face_parents(source.cage, solution.cage), source.face_material)
    add_subdivision(result, solution.cage.creases)
    store(result, source.name, request, solution)
    store_blend(result, solution.start_positions, solution.cage.positions)
    link_beside(context, original, result)
    select_alone(context, result)
    return result


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
    mesh = bpy.data.meshes.new(name)
    sizes = cage.face_sizes
    mesh.vertices.add(len(cage.positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(cage.positions, np.float32).reshape(-1))
    mesh.loops.add(len(cage.face_vertices))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(cage.face_vertices, np.int32))
    mesh.polygons.add(len(sizes))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(sizes) - sizes).astype(np.int32))
    if bpy.app.version < (3, 6, 0):  # later it follows from loop_start
        mesh.polygons.foreach_set("loop_total", np.ascontiguousarray(sizes, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(sizes), bool))
    mesh.update(calc_edges=True)
    edge, vertex = to_blender(cage, read_edges(mesh))
    if edge.any():
        _set_edge_creases(mesh, edge)
    if vertex.any():
        _set_vertex_creases(mesh, vertex)
    return mesh


def _set_edge_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    if bpy.app.version >= (4, 0, 0):
        mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", values)
    else:
        mesh.edges.foreach_set("crease", values)


def _set_vertex_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    if bpy.app.version >= (4, 0, 0):
        mesh.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", values)
        return
    edit = bmesh.new()  # nothing else can make the layer
    edit.from_mesh(mesh)
    edit.verts.layers.crease.verify()
    edit.to_mesh(mesh)
    edit.free()
    mesh.vertex_creases[0].data.foreach_set("value", values)


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


def face_parents(coarse: Cage, fine: Cage) -> np.ndarray:
    """For each face of `fine`, the face of `coarse` that it came from (Catmull-Clark, any number of times)."""
    parents, sizes = np.arange(len(coarse.face_sizes)), coarse.face_sizes
    while len(parents) < len(fine.face_sizes):
        parents = np.repeat(parents, sizes)
        sizes = np.full(len(parents), 4)
    return parents


def carry_materials(
    original: bpy.types.Object, mesh: bpy.types.Mesh, parents: np.ndarray, face_material: np.ndarray
) -> None:
    """Give `mesh` the materials of `original`, each face that of its parent."""
    for slot in original.material_slots:
        mesh.materials.append(slot.material)
    if original.material_slots:
        mesh.polygons.foreach_set("material_index", face_material[parents].astype(np.int32))


def beside(scene: bpy.types.Scene, source: Source, positions: np.ndarray) -> Matrix:
    """The translation along world X that puts positions (n, 3) in the source's frame past the original and what else
    stands beside it."""
    row = np.array(source.frame)[0]
    before, after = source.cage.positions @ row[:3] + row[3], positions @ row[:3] + row[3]
    edge = before.max()
    for other in scene.objects:
        if other.type == "MESH" and other.data.vertices and other.get("curvopt_source") == source.name:
            row = np.array(other.matrix_world)[0]
            edge = max(edge, (read_positions(other.data) @ row[:3] + row[3]).max())
    gap = _GAP * max(np.ptp(before), np.ptp(after))
    return Matrix.Translation((edge + gap - after.min(), 0.0, 0.0))


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
    obj["curvopt_surface"] = solution.end.surface
    obj["curvopt_stop"] = solution.stop
    obj["curvopt_verdict"] = verdict
    obj["curvopt_symmetry_order"] = solution.symmetry_order
    for when, energies in (("before", solution.start), ("after", solution.end)):
        for name, value in _numbers(energies).items():
            key = f"curvopt_{when}_{name}"
            if np.isfinite(value):
                obj[key] = value
            elif key in obj:
                del obj[key]


def _numbers(energies: Energies) -> dict[str, float]:
    """Every number of a report, by name."""
    of_energies = {term: energies.terms[term] for term in _TERMS}
    besides = {**{name: getattr(energies, name) for name in _BESIDES}, "gauss": round(energies.gauss, 6) + 0.0}
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


def stored_verdict(obj: bpy.types.Object | None) -> str:
    """What the check of a result found, as the object remembers it; empty for other objects."""
    return "" if obj is None else str(obj.get("curvopt_verdict", ""))

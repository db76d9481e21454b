# SPDX-License-Identifier: GPL-3.0-or-later
"""What a collection says the surface is to go through: empties, vertices of meshes, points along curves; and which chains of edges
follow which curves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import bpy
import numpy as np

from ..binding.through import Chain
from ..core import balls, guides
from ..core.go_through import Places, evenly, polylines
from ..core.surface_points import face_edges
from .modifiers import CageError
from .read_cage import Source, group_weights, read_edges, read_positions

NORMAL = "curvopt_normal"  # attribute of a mesh's points, FLOAT_VECTOR: the surface's normals there
_KINDS = ("EMPTY", "MESH", "CURVE")
_MOST_DRAWN = 10_000  # places of a weight below 1, for which no vertex has to move: one second of looking for the nearest points
_FINEST = 12  # resolution of curves that are evaluated, at least; what Blender gives to new ones
_EDGES_APART = 1.5  # of a curve's points: where they are an edge apart, those of a row may hang on each other



@dataclass(frozen=True)
class _Place:
    """A place, its normal (NAN: free) and its ball, in the world, and a name."""

    point: np.ndarray
    normal: np.ndarray
    name: str
    ball: balls.Touch | None = None


def read_targets(
    context: bpy.types.Context, name: str, with_normals: bool, with_balls: bool, source: Source, weight: float = 1.0
) -> Places:
    """Places in the frame of `source`. Of the collection's objects, those of its collections too, an empty is a place, and
    `with_normals` its Z axis is the surface's normal there; `with_balls` one that is shown as a sphere is a ball that the surface
    touches at the tip of its Z axis, and is curved like there; of a mesh the vertices are, with normals by its attribute
    curvopt_normal; of a curve, points along it, two for three edges of the cage that it is long. A curve that has the name of a vertex group of the
    source is followed by the chain of edges between the group's vertices instead. All as firmly as `weight` says. Modifiers and shape keys do
    not count. By a Mirror modifier of the source all places have images. The source's own object and results of it are left out, and what Blender does not evaluate: it excludes its
    collection, or has it disabled in viewports. Nothing for no name. CageError if there is no such collection, nothing in
    it, or more than the cage can go through."""
    if not name:
        return Places()
    collection = bpy.data.collections.get(name)
    if collection is None:
        raise CageError(f"There is no collection '{name}': choose another at Go Through, or none.")
    most = len(source.cage.positions) if weight == 1 else _MOST_DRAWN
    spacing = max(_EDGES_APART * _mean_edge(source), 1e-30)
    depsgraph = context.evaluated_depsgraph_get()
    objects = [obj for obj in collection.all_objects if _counts(obj, source, depsgraph)]
    cage = bpy.data.objects[source.name, None]
    followed = [obj for obj in objects if obj.type == "CURVE" and obj.name in cage.vertex_groups]
    if source.mirror is not None and followed:
        raise _without_mirror(source, f"the chain on curve '{followed[0].name}'")
    chains = tuple(_chain_of(obj, cage, source, weight) for obj in followed)
    places = (place for obj in objects if obj not in followed for place in _places_of(obj, with_normals, with_balls, spacing, most))
    found = list(islice(places, most + 1))
    if not found and not chains:
        raise CageError(
            f"Collection '{name}' has no empty, mesh or curve that the surface could go through. What is excluded from the "
            "view layer or disabled in viewports does not count."
        )
    points = np.array([place.point for place in found]).reshape(-1, 3)
    normals = np.array([place.normal for place in found]).reshape(-1, 3)
    turn = np.array(source.frame, np.float64)[:3, :3]
    touched = {
        k: replace(place.ball, tip=_in_frame(place.point, source), normal=place.ball.normal @ turn, direction=place.ball.direction @ turn)
        for k, place in enumerate(found) if place.ball is not None
    }  # fmt: skip
    names, followed = tuple(place.name for place in found), tuple(obj.name for obj in followed)
    all_places = Places(_in_frame(points, source), normals @ turn, names, weight, chains, followed, touched)
    if source.mirror is not None:
        all_places = _with_images(all_places, source)
    else:
        loose = [obj.name for obj in objects if obj.type == "CURVE" and obj.name not in all_places.chain_names]
        groups = _chains_without_curve(cage, source, all_places.chain_names) if loose else []
        all_places = replace(all_places, remark=guides.unpaired_text(loose, groups, cage.name))
    if len(all_places.names) > most and weight < 1:
        raise CageError(f"Collection '{name}' has more than {most} places: take some out.")
    if len(all_places.names) > most:
        raise CageError(
            f"Collection '{name}' has more places than '{source.name}' has vertices, {most}, and one vertex has to move for each: "
            "take some out, set a Weight below 1, or subdivide the cage."
        )
    return all_places


_IN_PLANE = 1e-4  # of a mean edge: up to here a place is in a plane of the Mirror modifier, or at another's image


def _with_images(places: Places, source: Source) -> Places:
    """With their images by the source's Mirror modifier. CageError where there are balls."""
    if places.balls:
        raise _without_mirror(source, f"the ball of {places.names[min(places.balls)]}")
    return places.mirrored(source.layout.halves.axes, _IN_PLANE * _mean_edge(source))


def _without_mirror(source: Source, what: str) -> CageError:
    """For what symmetries are not kept with."""
    return CageError(f"Object '{source.name}' has a Mirror modifier, which cannot be had with {what}: apply the modifier first.")


def _in_frame(points: np.ndarray, source: Source) -> np.ndarray:
    """Points (k, 3) of the world in the source's frame, which is rigid: its transpose goes back."""
    frame = np.array(source.frame, np.float64)
    return (points - frame[:3, 3]) @ frame[:3, :3]


def _chain_of(obj: bpy.types.Object, cage: bpy.types.Object, source: Source, weight: float) -> Chain:
    """The chain of edges of the cage's vertex group of that name, on the curve. CageError."""
    group = f"Vertex group '{obj.name}' of object '{cage.name}', whose chain of edges is to follow the curve of that name,"
    members = np.array([vertex for vertex, _ in group_weights(cage, obj.name)], int)
    if not len(members):
        raise CageError(f"{group} has no vertex with a weight above 0: assign those of a chain of edges, or rename the curve.")
    used = source.layout.in_cage(members)
    if (used < 0).any():
        raise CageError(f"{group} has vertex {members[used < 0][0]}, which has no face: take it out of the group.")
    edges = source.layout.kept[face_edges(source.cage.face_sizes, source.cage.face_vertices)]  # in numbers of the mesh
    try:
        chain, is_closed = guides.ordered(members, edges)
    except ValueError as error:
        raise CageError(f"{group} {error}: assign the vertices of one chain.") from error
    points, is_curve_closed = _line_of(obj)
    try:
        line = _in_frame(_moved(points, np.array(obj.matrix_world, np.float64)), source)
        return guides.followed(source.layout.in_cage(chain).tolist(), is_closed, line, is_curve_closed, weight)
    except ValueError as error:
        raise CageError(f"Curve '{obj.name}' {error}.") from error


def _chains_without_curve(cage: bpy.types.Object, source: Source, chain_names: tuple[str, ...]) -> list[str]:
    """Vertex groups of the cage that are chains of edges and follow no curve."""
    members: dict[int, list[int]] = {}
    for vertex in cage.data.vertices:
        for group in vertex.groups:
            if group.weight > 0:
                members.setdefault(group.group, []).append(vertex.index)
    edges = source.layout.kept[face_edges(source.cage.face_sizes, source.cage.face_vertices)]  # in numbers of the mesh
    others = (group for group in cage.vertex_groups if group.index in members and group.name not in chain_names)
    return [group.name for group in others if guides.is_chain(np.array(members[group.index]), edges)]


def _line_of(obj: bpy.types.Object) -> tuple[np.ndarray, bool]:
    """Points (k, 3) along a curve of one spline, in its own space, and whether it is closed; then the last one repeats the first."""
    n = len(obj.data.splines)
    if n != 1:
        told = "has no spline: draw one" if not n else f"has {n} splines: give each a curve of its own (Separate)"
        raise CageError(f"Curve '{obj.name}', which a chain of edges is to follow, {told}, or rename it.")
    _check_splines(obj)
    points, ends = _lines_of(obj)
    lines = list(polylines(points, ends))
    if not lines:
        raise CageError(f"Curve '{obj.name}' has too few points for its kind: add some, or change its kind (Set Spline Type).")
    return lines[0], obj.data.splines[0].use_cyclic_u


def _counts(obj: bpy.types.Object, source: Source, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether the surface is to go through an object of the collection."""
    if obj.type not in _KINDS or obj.name_full == source.name or obj.get("curvopt_source") == source.name:
        return False
    return obj.evaluated_get(depsgraph).is_evaluated  # else its matrix is out of date


def _mean_edge(source: Source) -> float:
    """Mean length of the cage's edges."""
    ends = source.cage.positions[face_edges(source.cage.face_sizes, source.cage.face_vertices)]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())


def _places_of(obj: bpy.types.Object, with_normals: bool, with_balls: bool, spacing: float, most: int) -> Iterator[_Place]:
    """Of a curve more than `most` points are not made."""
    world = np.array(obj.matrix_world, np.float64)
    free = np.full(3, np.nan)
    if obj.type == "EMPTY" and with_balls and obj.empty_display_type == "SPHERE":
        yield _ball_of(obj, world)
    elif obj.type == "EMPTY":
        place, axis = world[:3, 3] if np.isfinite(world).all() else free, world[:3, 2]
        yield _Place(place, axis if with_normals and axis.any() else free, f"empty '{obj.name}'")
    elif obj.type == "MESH":
        normals = _normals_of(obj, world, with_normals)
        for index, point in enumerate(_moved(read_positions(obj.data), world)):
            yield _Place(point, normals[index], f"vertex {index} of '{obj.name}'")
    else:
        _check_splines(obj)
        points, ends = _lines_of(obj)
        lines = (evenly(line, spacing, most) for line in polylines(_moved(points, world), ends))
        for index, point in enumerate(point for line in lines for point in line):
            yield _Place(point, free, f"point {index} along '{obj.name}'")


def _ball_of(obj: bpy.types.Object, world: np.ndarray) -> _Place:
    """Of an empty that is shown as a sphere."""
    try:
        ball = balls.touch(world[:3, 3], obj.empty_display_size * world[:3, :3])
    except ValueError as error:
        raise CageError(f"Empty '{obj.name}', a ball that the surface is to touch, {error}.") from error
    return _Place(ball.tip, ball.normal, f"empty '{obj.name}'", ball)


def _check_splines(obj: bpy.types.Object) -> None:
    if any(len(spline.bezier_points) + len(spline.points) == 1 for spline in obj.data.splines):
        raise CageError(f"Curve '{obj.name}' has a spline of one point, which is no line: delete it, or add a second point.")


def _moved(points: np.ndarray, world: np.ndarray) -> np.ndarray:
    return points @ world[:3, :3].T + world[:3, 3]


def _normals_of(obj: bpy.types.Object, world: np.ndarray, wanted: bool) -> np.ndarray:
    """Normals (n, 3) in the world by the mesh's attribute; NAN without it, and where they are 0."""
    n, attribute = len(obj.data.vertices), obj.data.attributes.get(NORMAL)
    if not wanted or attribute is None:
        return np.full((n, 3), np.nan)
    if (attribute.domain, attribute.data_type) != ("POINT", "FLOAT_VECTOR"):
        raise CageError(f"Attribute '{NORMAL}' of mesh '{obj.data.name}' is no vector of points: delete it, or make it one.")
    values = np.empty(3 * n, np.float32)
    attribute.data.foreach_get("vector", values)
    normals = values.reshape(-1, 3).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(normals).all(axis=1))
    if bad.size:
        raise CageError(f"Attribute '{NORMAL}' of vertex {bad[0]} of '{obj.name}' is {normals[bad[0]]}: give it three numbers.")
    normals[~normals.any(axis=1)] = np.nan
    rows = world[:3, :3]  # by their cross products, a multiple of the inverse, flat objects have normals, too
    return normals @ np.stack([np.cross(rows[1], rows[2]), np.cross(rows[2], rows[0]), np.cross(rows[0], rows[1])]).T


def _lines_of(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) of a curve without its bevel and extrusion, and the edges (e, 2) between them, spline by spline."""
    shape = obj.copy()
    shape.data = data = obj.data.copy()
    try:
        for key in data.shape_keys.key_blocks if data.shape_keys else ():
            key.value = 0
        data.bevel_depth = data.extrude = 0
        data.resolution_u = max(data.resolution_u, _FINEST)
        for spline in data.splines:
            spline.resolution_u = max(spline.resolution_u, _FINEST)
        data.bevel_object, data.fill_mode = None, "FULL" if data.dimensions == "3D" else "NONE"
        mesh = shape.to_mesh()  # None without splines
        points, ends = (np.empty((0, 3)), np.empty((0, 2), int)) if mesh is None else (read_positions(mesh), read_edges(mesh))
        shape.to_mesh_clear()
    finally:
        bpy.data.objects.remove(shape)
        bpy.data.curves.remove(data)
    return points, ends

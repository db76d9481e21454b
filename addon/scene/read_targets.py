# SPDX-License-Identifier: GPL-3.0-or-later
"""What a collection says the surface is to go through: empties, vertices of meshes, points along curves."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np

from ..core.go_through import Places
from .modifiers import CageError
from .read_cage import Source

NORMAL = "curvopt_normal"  # attribute of a mesh's points, FLOAT_VECTOR: the surface's normals there
_KINDS = ("EMPTY", "MESH", "CURVE")
_EDGES_APART = 1.5  # of a curve's points: where they are an edge apart, those of a row may hang on each other

# A place and its normal in the world, and a name.
_Place = tuple[np.ndarray, np.ndarray, str]


def read_targets(context: bpy.types.Context, name: str, with_normals: bool, source: Source) -> Places:
    """Places in the frame of `source`. Of the collection's objects, those of its collections too, an empty is a place, and
    `with_normals` its Z axis is the surface's normal there; of a mesh the vertices are, with normals by its attribute
    curvopt_normal; of a curve, points along it, two for three edges of the cage that it is long. The source's own object is
    left out. Nothing for no name. CageError if there is no such collection, or nothing in it."""
    if not name:
        return Places()
    if source.mirror is not None:
        raise CageError(f"Object '{source.name}' has a Mirror modifier, with which the surface cannot go through places: apply it first.")
    collection = bpy.data.collections.get(name)
    if collection is None:
        raise CageError(f"There is no collection '{name}': choose another at Go Through, or none.")
    objects = [obj for obj in collection.all_objects if obj.type in _KINDS and obj.name != source.name]
    spacing = _EDGES_APART * _mean_edge(source)
    found = [place for obj in objects for place in _places_of(context, obj, with_normals, spacing)]
    if not found:
        raise CageError(f"Collection '{name}' has no empty, mesh or curve that the surface could go through.")
    frame = np.array(source.frame, np.float64)
    points = np.array([place[0] for place in found]).reshape(-1, 3)
    normals = np.array([place[1] for place in found]).reshape(-1, 3)
    turn = frame[:3, :3]  # rigid: its transpose goes back
    return Places((points - frame[:3, 3]) @ turn, normals @ turn, tuple(place[2] for place in found))


def _mean_edge(source: Source) -> float:
    """Mean length of the cage's sides."""
    sizes, vertices = source.cage.face_sizes, source.cage.face_vertices
    following = np.arange(len(vertices)) + 1
    following[np.cumsum(sizes) - 1] = np.cumsum(sizes) - sizes
    xyz = source.cage.positions
    return float(np.linalg.norm(xyz[vertices[following]] - xyz[vertices], axis=1).mean())


def _places_of(context: bpy.types.Context, obj: bpy.types.Object, with_normals: bool, spacing: float) -> Iterator[_Place]:
    world = np.array(obj.matrix_world, np.float64)
    free = np.full(3, np.nan)
    if obj.type == "EMPTY":
        axis = world[:3, 2]
        yield world[:3, 3], axis if with_normals and axis.any() else free, f"empty '{obj.name}'"
    elif obj.type == "MESH":
        points = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.vertices.foreach_get("co", points)
        normals = _normals_of(obj, with_normals)
        for index, point in enumerate(_moved(points.reshape(-1, 3), world)):
            yield point, normals[index], f"vertex {index} of '{obj.name}'"
    else:
        for index, point in enumerate(_along(context, obj, world, spacing)):
            yield point, free, f"point {index} along '{obj.name}'"


def _moved(points: np.ndarray, world: np.ndarray) -> np.ndarray:
    return points.astype(np.float64) @ world[:3, :3].T + world[:3, 3]


def _normals_of(obj: bpy.types.Object, wanted: bool) -> np.ndarray:
    """Normals (n, 3) in the world by the mesh's attribute; NAN without it, and where they are 0."""
    n, attribute = len(obj.data.vertices), obj.data.attributes.get(NORMAL)
    if not wanted or attribute is None:
        return np.full((n, 3), np.nan)
    if (attribute.domain, attribute.data_type) != ("POINT", "FLOAT_VECTOR"):
        raise CageError(f"Attribute '{NORMAL}' of mesh '{obj.data.name}' is no vector of points: delete it, or make it one.")
    values = np.empty(3 * n, np.float32)
    attribute.data.foreach_get("vector", values)
    normals = values.reshape(-1, 3).astype(np.float64)
    normals[~normals.any(axis=1)] = np.nan
    return normals @ np.linalg.inv(np.array(obj.matrix_world, np.float64)[:3, :3])


def _along(context: bpy.types.Context, obj: bpy.types.Object, world: np.ndarray, spacing: float) -> np.ndarray:
    """Points (k, 3) in the world along the curve without its bevel and extrusion, about `spacing` apart on each spline."""
    shape = obj.copy()
    shape.data = obj.data.copy()
    try:
        shape.data.bevel_depth = shape.data.extrude = 0
        shape.data.bevel_object, shape.data.fill_mode = None, "FULL" if shape.data.dimensions == "3D" else "NONE"
        mesh = shape.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        ends = np.array([edge.vertices[:] for edge in mesh.edges]).reshape(-1, 2)
        shape.to_mesh_clear()
    finally:
        data = shape.data
        bpy.data.objects.remove(shape)
        bpy.data.curves.remove(data)
    lines = [_evenly(line, spacing) for line in _polylines(_moved(points.reshape(-1, 3), world), ends)]
    return np.concatenate(lines) if lines else np.empty((0, 3))


def _polylines(points: np.ndarray, ends: np.ndarray) -> Iterator[np.ndarray]:
    """Points (k, 3) of each line that edges (e, 2) in their order make; a closed one ends where it begins."""
    first = 0
    for i in range(1, len(ends) + 1):
        if i == len(ends) or ends[i, 0] != ends[i - 1, 1]:
            yield points[[*ends[first:i, 0], ends[i - 1, 1]]]
            first = i


def _evenly(line: np.ndarray, spacing: float) -> np.ndarray:
    """Points (k, 3) along a line, evenly spaced; both its ends, or, of a closed one, one of them."""
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    closed = bool(np.allclose(line[0], line[-1]))
    pieces = max(3 if closed else 1, round(lengths[-1] / spacing)) if lengths[-1] > 0 else 0
    at = np.linspace(0, lengths[-1], pieces + 1)[: pieces if closed and pieces else None]
    return np.stack([np.interp(at, lengths, line[:, axis]) for axis in range(3)], -1)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The slider from the original to the optimum: `Object.curvopt_amount`, 0 .. 1.

A result's mesh keeps both shapes as attributes of its vertices: `curvopt_start`, the original cage subdivided as often
as the result, which shows the original's surface, and `curvopt_end`. The slider sets the vertices in between. What was
edited by hand since is kept: it is the difference from where the slider left the vertices. Where all vertices together
were moved, turned, scaled or sheared, as by Object > Apply, both shapes are first moved with them.

The amount that the vertices show is stored with the mesh, because several objects can show one mesh.
"""

from __future__ import annotations

import bpy
import numpy as np

_START, _END = "curvopt_start", "curvopt_end"
_APPLIED = "curvopt_applied"  # custom property of the mesh, in old files of the object: the amount that the vertices show
_ROUNDING = 1e-6  # of the shape's size: differences below it are no edits. Single precision rounds by 6e-8
_FLAT = 1e-5  # of the largest singular value: vertices whose smallest one is below it do not span space


def store_blend(obj: bpy.types.Object, start: np.ndarray, end: np.ndarray) -> None:
    """Remember both shapes, (n, 3) in the object's own coordinates; its vertices are at the end."""
    for name, positions in ((_START, start), (_END, end)):
        attribute = obj.data.attributes.get(name)
        if attribute is not None:
            obj.data.attributes.remove(attribute)
        obj.data.attributes.new(name, "FLOAT_VECTOR", "POINT")
        _set_vectors(obj.data.attributes[name].data, "vector", positions)
    obj.data[_APPLIED] = 1.0
    if hasattr(obj, "curvopt_amount"):  # the batch command registers nothing
        obj.curvopt_amount = 1.0


def has_blend(obj: bpy.types.Object | None) -> bool:
    """Whether the object's slider would move anything."""
    if obj is None or obj.type != "MESH":
        return False
    return (_APPLIED in obj.data or _APPLIED in obj) and _END in obj.data.attributes


def start_of(obj: bpy.types.Object) -> np.ndarray | None:
    """The vertices (n, 3) of the original's surface in the object's own coordinates, or None if there is none."""
    if not has_blend(obj):
        return None
    return _shapes(obj)[0]


def _applied(obj: bpy.types.Object) -> float:
    """The amount that the vertices of the object's mesh show."""
    return obj.data[_APPLIED] if _APPLIED in obj.data else obj[_APPLIED]


def _shapes(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Start and end, (n, 3) each, moved with the vertices if all of these were moved by one affine map."""
    mesh, applied = obj.data, _applied(obj)
    count = len(mesh.vertices)
    start, end = (_vectors(mesh.attributes[name].data, "vector", count) for name in (_START, _END))
    affine = _affine_map(_mixed(start, end, applied), _vectors(mesh.vertices, "co", count))
    if affine is None:
        return start, end
    return _with_ones(start) @ affine, _with_ones(end) @ affine


def _affine_map(before: np.ndarray, after: np.ndarray) -> np.ndarray | None:
    """The matrix (4, 3) that maps points (n, 3) with a 1 each to others (n, 3); None if they are the same up to rounding,
    if no such map is exact up to rounding, or if more than one is."""
    if len(before) <= 4 or _is_rounding(after - before, before):
        return None
    centre = before.mean(axis=0)
    turned, _, rank, _ = np.linalg.lstsq(before - centre, after - after.mean(axis=0), rcond=_FLAT)
    affine = np.concatenate([turned, [after.mean(axis=0) - centre @ turned]])
    largest = max(np.abs(before).max(), np.abs(after).max())
    exact = np.abs(_with_ones(before) @ affine - after).max() <= _ROUNDING * largest
    return affine if rank == 3 and exact else None


def _with_ones(points: np.ndarray) -> np.ndarray:
    """(n, 4)"""
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)


def _is_rounding(difference: np.ndarray, shape: np.ndarray) -> bool:
    """Whether differences (n, 3) are no edits of a shape (n, 3)."""
    return bool(np.abs(difference).max(initial=0.0) <= _ROUNDING * np.ptp(shape, axis=0).max(initial=0.0))


def _vectors(data: object, name: str, count: int) -> np.ndarray:
    values = np.empty((count, 3), np.float32)
    data.foreach_get(name, values.reshape(-1))
    return values.astype(np.float64)


def _set_vectors(data: object, name: str, values: np.ndarray) -> None:
    data.foreach_set(name, np.ascontiguousarray(values, np.float32).reshape(-1))


def _apply(obj: bpy.types.Object, _context: bpy.types.Context) -> None:
    """The slider was moved. Those of other objects with the same mesh follow, which calls this again for each of them."""
    if not has_blend(obj) or obj.mode != "OBJECT" or obj.data.shape_keys or obj.data.library:
        return
    mesh, applied, amount = obj.data, _applied(obj), obj.curvopt_amount
    if amount == applied:
        return
    start, end = _shapes(obj)
    edited = _vectors(mesh.vertices, "co", len(mesh.vertices)) - _mixed(start, end, applied)
    if _is_rounding(edited, end):
        edited = 0.0
    for data, name, values in (
        (mesh.attributes[_START].data, "vector", start),
        (mesh.attributes[_END].data, "vector", end),
        (mesh.vertices, "co", _mixed(start, end, amount) + edited),
    ):
        _set_vectors(data, name, values)
    mesh.update()
    mesh[_APPLIED] = amount
    for other in bpy.data.objects:
        if other.data == mesh and other.curvopt_amount != amount:
            other.curvopt_amount = amount


def _mixed(start: np.ndarray, end: np.ndarray, amount: float) -> np.ndarray:
    return (1 - amount) * start + amount * end


def register() -> None:
    bpy.types.Object.curvopt_amount = bpy.props.FloatProperty(
        name="Amount",
        description="0 shows the surface of the original, 1 the result. Vertices edited by hand keep their edits",
        min=0.0, max=1.0, default=1.0, subtype="FACTOR", update=_apply,
    )  # fmt: skip


def unregister() -> None:
    del bpy.types.Object.curvopt_amount

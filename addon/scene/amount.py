# SPDX-License-Identifier: GPL-3.0-or-later
"""The slider from the original to the optimum: `Object.curvopt_amount`, 0 .. 1.

A result's mesh keeps both shapes as attributes of its vertices: `curvopt_start`, the original cage subdivided as often
as the result, which shows the original's surface, and `curvopt_end`. The slider sets the vertices in between. What was
edited by hand since is kept: it is the difference from where the slider left the vertices.
"""

from __future__ import annotations

import bpy
import numpy as np

_START, _END = "curvopt_start", "curvopt_end"
_APPLIED = "curvopt_applied"  # custom property: the amount that the vertices show
_ROUNDING = 1e-6  # of the shape's size: differences below it are no edits


def store_blend(obj: bpy.types.Object, start: np.ndarray, end: np.ndarray) -> None:
    """Remember both shapes, (n, 3) in the object's own coordinates; its vertices are at the end."""
    for name, positions in ((_START, start), (_END, end)):
        attribute = obj.data.attributes.get(name)
        if attribute is not None:
            obj.data.attributes.remove(attribute)
        attribute = obj.data.attributes.new(name, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", np.ascontiguousarray(positions, np.float32).reshape(-1))
    obj[_APPLIED] = 1.0
    if hasattr(obj, "curvopt_amount"):  # the batch command registers nothing
        obj.curvopt_amount = 1.0


def has_blend(obj: bpy.types.Object | None) -> bool:
    """Whether the object's slider would move anything."""
    return obj is not None and obj.type == "MESH" and _APPLIED in obj and _END in obj.data.attributes


def start_of(obj: bpy.types.Object) -> np.ndarray | None:
    """The vertices (n, 3) of the original's surface in the object's own coordinates, or None if there is none."""
    if not has_blend(obj):
        return None
    return _vectors(obj.data.attributes[_START].data, "vector", len(obj.data.vertices))


def _vectors(data: object, name: str, count: int) -> np.ndarray:
    values = np.empty((count, 3), np.float32)
    data.foreach_get(name, values.reshape(-1))
    return values.astype(np.float64)


def _apply(obj: bpy.types.Object, _context: bpy.types.Context) -> None:
    """The slider was moved."""
    if not has_blend(obj) or obj.mode != "OBJECT" or obj.data.shape_keys or obj.data.library:
        return
    mesh, applied = obj.data, obj[_APPLIED]
    count = len(mesh.vertices)
    start, end = (_vectors(mesh.attributes[name].data, "vector", count) for name in (_START, _END))
    edited = _vectors(mesh.vertices, "co", count) - _mixed(start, end, applied)
    if np.abs(edited).max(initial=0.0) <= _ROUNDING * np.ptp(end, axis=0).max(initial=0.0):
        edited = 0.0
    moved = _mixed(start, end, obj.curvopt_amount) + edited
    mesh.vertices.foreach_set("co", moved.astype(np.float32).reshape(-1))
    mesh.update()
    obj[_APPLIED] = obj.curvopt_amount


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

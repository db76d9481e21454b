# SPDX-License-Identifier: GPL-3.0-or-later
"""What length of waves a strength below 1 takes away, as a line of the panel."""

from __future__ import annotations

import bpy
import numpy as np

from ..binding.values import rms_radius
from ..scene.modifiers import with_images
from ..scene.read_cage import read_positions

_MOST_VERTICES = 50_000  # reading them takes 1 ms; the panel is drawn at every mouse move over it


def wave_text(context: bpy.types.Context, obj: bpy.types.Object | None, strength: float) -> str:
    """The line for an object, in the scene's units; "" at strength 1, in other modes than Object Mode, and
    without a mesh to measure."""
    if strength >= 1 or obj is None or obj.type != "MESH" or obj.mode != "OBJECT":
        return ""
    if not 0 < len(obj.data.vertices) <= _MOST_VERTICES:
        return ""
    units = context.scene.unit_settings
    length = wave_length(obj, strength) * units.scale_length
    if not np.isfinite(length):
        return ""
    shown = bpy.utils.units.to_string(units.system, "LENGTH", length, precision=3).strip()
    return f"Waves below {shown} go"


def wave_length(obj: bpy.types.Object, strength: float) -> float:
    """The length of the wave of which half the height stays, in the world; see `strength` in curvopt.h."""
    world = np.array(obj.matrix_world, np.float64)
    points = with_images(obj, read_positions(obj.data) @ world[:3, :3].T + world[:3, 3])
    return rms_radius(points) * strength / (1 - strength)

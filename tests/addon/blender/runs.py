# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of the operator on an object, and what it leaves."""

import bpy
import numpy as np


def minimize(obj, **arguments):
    """The active object after a run on `obj`, with its own vertices unless `arguments` say otherwise."""
    bpy.context.view_layer.objects.active = obj
    arguments = {"energy": "WILLMORE", "resolution": "SAME", **arguments}
    assert bpy.ops.curvopt.minimize(**arguments) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def positions(obj):
    """Local positions (n, 3) of the vertices."""
    values = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", values)
    return values.reshape(-1, 3).astype(float)

# SPDX-License-Identifier: GPL-3.0-or-later
"""A run as an animation: the states of its way as relative shape keys with keyframes.

The mesh itself, and so the first key, is the result: that is what every frame before and behind the run shows. In the frame
after the current one the original appears, and from there it goes on to the result, one state every second frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import bpy
import numpy as np

PREFIX = "Run "  # of the keys' names
FRAMES = 2  # from one state to the next


def animate(obj: bpy.types.Object, states: Sequence[np.ndarray], frame: int) -> tuple[int, int]:
    """Give an object, which has no shape keys, those of states (n, 3) in its coordinates, the result last; at `frame` it shows the
    result still. The first and the last frame of the run."""
    obj.shape_key_add(name="Basis", from_mix=False)
    times = [frame, *(frame + 1 + FRAMES * number for number in range(len(states)))]
    for number, state in enumerate(states[:-1]):
        key = obj.shape_key_add(name=f"{PREFIX}{number + 1}", from_mix=False)
        key.data.foreach_set("co", np.ascontiguousarray(state, np.float32).reshape(-1))
        for value, time in zip((0.0, 1.0, 0.0), times[number:]):
            key.value = value
            key.keyframe_insert("value", frame=time)
    for curve in _curves(obj.data.shape_keys.animation_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    obj.active_shape_key_index = 0
    return times[1], times[-1]


def is_animated(obj: bpy.types.Object | None) -> bool:
    """Whether the object has a run's shape keys."""
    keys = obj.data.shape_keys if obj is not None and obj.type == "MESH" else None
    return keys is not None and any(key.name.startswith(PREFIX) for key in keys.key_blocks)


def _curves(animation: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """Of an action; from Blender 5 on it has them by slots only."""
    action = animation.action
    if hasattr(action, "fcurves"):
        yield from action.fcurves
        return
    for layer in action.layers:
        for strip in layer.strips:
            yield from strip.channelbag(animation.action_slot).fcurves

# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a Multiresolution modifier holds sculpted detail.

Python cannot read the detail (the layer of displacements). But without it the modifier shows what Subdivision Surface
shows: both are evaluated on copies, in a scene of their own that is gone afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np

_SAME = 1e-5  # of the shape's size


def has_detail(obj: bpy.types.Object, modifier: bpy.types.MultiresModifier) -> bool:
    """Whether `modifier` of `obj` moves any vertex of its finest level."""
    with _copies(obj) as (scene, sculpted, plain):
        own = sculpted.modifiers[modifier.name]
        for other in list(sculpted.modifiers):
            if other != own:
                sculpted.modifiers.remove(other)
        own.show_viewport, own.levels = True, own.total_levels
        _as_subdivision(plain, own)
        shown, wanted = _points(scene, sculpted), _points(scene, plain)
    return shown.shape != wanted.shape or bool(np.abs(shown - wanted).max() > _SAME * np.ptp(wanted, axis=0).max())


@contextmanager
def _copies(obj: bpy.types.Object) -> Iterator[tuple[bpy.types.Scene, bpy.types.Object, bpy.types.Object]]:
    """A scene with a copy of the object and one of its mesh alone; all gone at the end."""
    mesh = obj.data.copy()
    scene, sculpted = bpy.data.scenes.new("Curvopt"), obj.copy()
    sculpted.data = mesh
    made = [sculpted, bpy.data.objects.new("Curvopt plain", mesh)]
    try:
        for copy in made:
            scene.collection.objects.link(copy)
        yield scene, *made
    finally:
        for copy in made:
            bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        bpy.data.scenes.remove(scene)


def _as_subdivision(obj: bpy.types.Object, multires: bpy.types.MultiresModifier) -> None:
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.use_limit_surface = multires.total_levels, True
    for name in ("quality", "boundary_smooth", "use_creases"):
        setattr(modifier, name, getattr(multires, name))


def _points(scene: bpy.types.Scene, obj: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) that the object shows."""
    layer = scene.view_layers[0]
    layer.update()
    evaluated = obj.evaluated_get(layer.depsgraph)
    mesh = evaluated.to_mesh()
    values = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", values.reshape(-1))
    evaluated.to_mesh_clear()
    return values

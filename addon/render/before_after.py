# SPDX-License-Identifier: GPL-3.0-or-later
"""Before and after side by side in one picture, without a display: both limit surfaces stand in one temporary scene
before one camera."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..binding.values import Cage
from ..scene.write_result import add_subdivision, make_mesh
from .studio import (
    Picture,
    RenderError,
    add_camera,
    add_caption,
    add_light,
    add_surface,
    render,
    set_up_render,
    temporary_scene,
    view_direction,
    view_rotation,
)

__all__ = ["Picture", "RenderError", "render_side_by_side"]

_MARGIN, _CAPTION = 1.12, 0.16  # of the larger shape's extent


def render_side_by_side(shapes: Sequence[tuple[Cage, str]], path: Path, picture: Picture) -> None:
    """Render the limit surfaces of world-space cages, left to right, each with its caption, to a PNG at `path`.

    Leaves no data behind. RenderError if the file does not appear, or whatever Blender raises."""
    with temporary_scene() as scene:
        set_up_render(scene, picture)
        surfaces = []
        for cage, _ in shapes:
            surfaces.append(add_surface(scene, make_mesh("Curvopt picture", cage), picture))
            add_subdivision(surfaces[-1], cage.creases)
        add_light(scene, _arrange(scene, surfaces, [caption for _, caption in shapes], picture))
        render(scene, path)


def _arrange(
    scene: bpy.types.Scene, surfaces: Sequence[bpy.types.Object], captions: Sequence[str], picture: Picture
) -> Matrix:
    """Stand the surfaces in a row across the view, add captions and camera; the camera's rotation."""
    scene.view_layers[0].update()
    points = [_evaluated_points(scene, surface) for surface in surfaces]
    rotation = view_rotation(view_direction(points[0]))
    axes = np.array(rotation)
    boxes = [((p @ axes).min(0), (p @ axes).max(0)) for p in points]
    extent = np.max([high - low for low, high in boxes], axis=0)
    cell, caption = _MARGIN * extent[0], _CAPTION * max(extent[0], extent[1])
    content = _MARGIN * extent[1] + caption
    width = max(cell * len(surfaces), content * picture.width / picture.height)
    for index, (surface, (low, high)) in enumerate(zip(surfaces, boxes)):
        across = (index - (len(surfaces) - 1) / 2) * max(cell, width / len(surfaces))
        middle = axes @ ((low + high) / 2)
        surface.location = Vector(axes @ (across, caption / 2, 0.0)) - Vector(middle)
        low_edge = -content / 2 + caption * 0.45
        add_caption(scene, captions[index], Vector(axes @ (across, low_edge, 0.0)), rotation, caption * 0.42, picture)
    add_camera(scene, rotation, width, width * picture.height / picture.width, float(np.linalg.norm(extent)))
    return rotation


def _evaluated_points(scene: bpy.types.Scene, surface: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) of the surface as its modifier makes it."""
    evaluated = surface.evaluated_get(scene.view_layers[0].depsgraph)
    mesh = evaluated.to_mesh()
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    evaluated.to_mesh_clear()
    return points.astype(np.float64)

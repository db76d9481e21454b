# SPDX-License-Identifier: GPL-3.0-or-later
"""Before and after side by side in one picture, without a display.

Both limit surfaces stand in one temporary scene before one orthographic camera, lit from afar: scale, direction and
light are the same for both. Look "clay" is neutral; "zebra" reflects stripes, and kinks in them show where curvature is
not smooth. Engine "cycles" needs no graphics at all, "workbench" is quicker and needs EGL.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .values import Cage
from .result import add_subdivision, make_mesh

LOOKS = ("clay", "zebra")
ENGINES = {"cycles": "CYCLES", "workbench": "BLENDER_WORKBENCH"}

_CLAY = (0.40, 0.46, 0.54)
_PAPER = (0.90, 0.90, 0.90)
_INK = (0.05, 0.05, 0.06)
_STRIPES = 18.0  # radians of stripe per unit of the reflected direction
_ZEBRA_MATCAPS = ("reflection_check_horizontal.exr", "check_reflection_horizontal.exr")  # until 4.x, from 5.x
_MARGIN, _CAPTION = 1.12, 0.16  # of the larger shape's extent
_FLAT = 0.8  # a shape is flat if its least extent is below this part of the middle one


class RenderError(RuntimeError):
    """The picture could not be made; the message says why."""


@dataclass(frozen=True)
class Picture:
    """Size in pixels, samples per pixel, engine of ENGINES, look of LOOKS."""

    width: int = 1400
    height: int = 700
    samples: int = 64
    engine: str = "cycles"
    look: str = "clay"


def render_side_by_side(shapes: Sequence[tuple[Cage, str]], path: Path, picture: Picture) -> None:
    """Render the limit surfaces of world-space cages, left to right, each with its caption, to a PNG at `path`.

    Leaves no data behind. RenderError if the file does not appear, or whatever Blender raises."""
    with _temporary_scene() as scene:
        _set_up_render(scene, path, picture)
        surfaces = [_add_surface(scene, cage, picture) for cage, _ in shapes]
        extents = _arrange(scene, surfaces, shapes, picture)
        _add_light(scene, extents)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.is_file() or path.stat().st_size == 0:
        raise RenderError(f"Blender rendered nothing to {path}.")


@contextmanager
def _temporary_scene() -> Iterator[bpy.types.Scene]:
    """A new scene; afterwards it and all data that came into being meanwhile are removed."""
    kinds = ("scenes", "objects", "meshes", "curves", "cameras", "lights", "materials", "worlds")
    before = {kind: set(getattr(bpy.data, kind)) for kind in kinds}
    try:
        yield bpy.data.scenes.new("Curvopt picture")
    finally:
        new = [item for kind in kinds for item in getattr(bpy.data, kind) if item not in before[kind]]
        bpy.data.batch_remove(new)


def _set_up_render(scene: bpy.types.Scene, path: Path, picture: Picture) -> None:
    render = scene.render
    try:
        render.engine = ENGINES[picture.engine]
    except TypeError as error:
        raise RenderError(f"This Blender has no {picture.engine} engine.") from error
    render.resolution_x, render.resolution_y, render.resolution_percentage = picture.width, picture.height, 100
    render.image_settings.file_format = "PNG"
    render.image_settings.color_mode = "RGB"
    render.use_file_extension = False
    render.filepath = str(path)
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("Curvopt picture")
    scene.world.color = _PAPER
    if picture.engine == "cycles":
        scene.cycles.device = "CPU"
        scene.cycles.samples = picture.samples
        scene.cycles.use_denoising = False  # not in every build
        scene.cycles.max_bounces = 3
        _paper_world(scene.world)
    else:
        _set_up_workbench(scene, picture)


def _set_up_workbench(scene: bpy.types.Scene, picture: Picture) -> None:
    display = scene.display
    display.render_aa = "16"
    display.shading.color_type = "OBJECT"
    if picture.look == "zebra":
        display.shading.light = "MATCAP"
        present = {light.name for light in bpy.context.preferences.studio_lights}
        found = [name for name in _ZEBRA_MATCAPS if name in present]
        if not found:
            raise RenderError("This Blender has no zebra matcap: use the cycles engine.")
        display.shading.studio_light = found[0]
    else:
        display.shading.light = "STUDIO"
        display.shading.show_cavity = True


def _paper_world(world: bpy.types.World) -> None:
    """Paper for the camera, soft light for everything else."""
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output, mix = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeMixShader")
    seen, light = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeBackground")
    seen.inputs[0].default_value = (*_PAPER, 1.0)
    light.inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)
    light.inputs[1].default_value = 0.30
    links.new(nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"], mix.inputs[0])
    links.new(light.outputs[0], mix.inputs[1])
    links.new(seen.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])


def _add_surface(scene: bpy.types.Scene, cage: Cage, picture: Picture) -> bpy.types.Object:
    mesh = make_mesh("Curvopt picture", cage)
    surface = bpy.data.objects.new("Curvopt picture", mesh)
    surface.color = (*_CLAY, 1.0) if picture.look == "clay" else (1.0, 1.0, 1.0, 1.0)
    if picture.engine == "cycles":
        mesh.materials.append(_zebra() if picture.look == "zebra" else _clay())
    add_subdivision(surface, cage.creases)
    scene.collection.objects.link(surface)
    return surface


def _new_material() -> tuple[bpy.types.Material, bpy.types.Nodes, bpy.types.NodeLinks, bpy.types.Node]:
    material = bpy.data.materials.new("Curvopt picture")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    return material, nodes, material.node_tree.links, nodes.new("ShaderNodeOutputMaterial")


def _clay() -> bpy.types.Material:
    material, nodes, links, output = _new_material()
    shader = nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (*_CLAY, 1.0)
    shader.inputs["Roughness"].default_value = 0.35
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def _ink() -> bpy.types.Material:
    material, nodes, links, output = _new_material()
    shader = nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (*_INK, 1.0)
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def _zebra() -> bpy.types.Material:
    """A mirror in a room of soft-edged horizontal stripes, darkened a little where it turns away."""
    material, nodes, links, output = _new_material()

    def math(operation: str, first: object, second: object) -> object:
        node = nodes.new("ShaderNodeMath")
        node.operation = operation
        node.use_clamp = operation == "MULTIPLY_ADD"
        for slot, value in zip(node.inputs, (first, second, 0.5)):
            if isinstance(value, float):
                slot.default_value = value
            else:
                links.new(value, slot)
        return node.outputs[0]

    split = nodes.new("ShaderNodeSeparateXYZ")
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Reflection"], split.inputs[0])
    wave = math("SINE", math("MULTIPLY", split.outputs["Z"], _STRIPES), 0.0)
    stripes = math("MULTIPLY_ADD", wave, 4.0)  # 4 x + 0.5, clamped: steep but not aliased
    facing = nodes.new("ShaderNodeLayerWeight").outputs["Facing"]
    shade = math("SUBTRACT", 0.95, math("MULTIPLY", facing, 0.35))
    shader = nodes.new("ShaderNodeEmission")
    links.new(math("MULTIPLY", math("ADD", math("MULTIPLY", stripes, 0.94), 0.03), shade), shader.inputs["Strength"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def view_direction(points: np.ndarray) -> np.ndarray:
    """The unit vector (3,) from points (n, 3) to the camera: from the front and above; for a flat shape, such as a
    double torus, turned so that it is seen at a slant to its thin axis, holes open."""
    usual = np.array([-0.35, -0.72, 0.60])
    usual /= np.linalg.norm(usual)
    variance, axes = np.linalg.eigh(np.cov(points.T))
    if variance[0] >= _FLAT**2 * variance[1]:
        return usual
    azimuth, height = np.meshgrid(np.radians(np.arange(-85, 86, 5)), np.radians(np.arange(15, 66, 5)))
    choices = np.stack([np.sin(azimuth), -np.cos(azimuth), np.tan(height)], -1).reshape(-1, 3)
    choices /= np.linalg.norm(choices, axis=1, keepdims=True)
    slant = np.abs(np.abs(choices @ axes[:, 0]) - np.cos(np.radians(38)))
    return choices[np.argmin(slant - 0.05 * (choices @ usual))]


def _arrange(
    scene: bpy.types.Scene, surfaces: Sequence[bpy.types.Object], shapes: Sequence[tuple[Cage, str]], picture: Picture
) -> tuple[Matrix, float]:
    """Stand the surfaces in a row across the view, add captions and camera; the camera's (rotation, view width)."""
    scene.view_layers[0].update()
    points = [_evaluated_points(scene, surface) for surface in surfaces]
    direction = Vector(view_direction(points[0]))
    rotation = direction.to_track_quat("Z", "Y").to_matrix()  # columns: right, up, towards the camera
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
        _add_caption(scene, shapes[index][1], Vector(axes @ (across, low_edge, 0.0)), rotation, caption * 0.42, picture)
    camera = bpy.data.objects.new("Curvopt picture", bpy.data.cameras.new("Curvopt picture"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = max(width, width * picture.height / picture.width)
    distance = 2.0 * float(np.linalg.norm(extent))
    camera.data.clip_start, camera.data.clip_end = distance / 100, distance * 10
    camera.matrix_world = Matrix.Translation(direction * distance) @ rotation.to_4x4()
    scene.collection.objects.link(camera)
    scene.camera = camera
    return rotation, width


def _evaluated_points(scene: bpy.types.Scene, surface: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) of the surface as its modifier makes it."""
    evaluated = surface.evaluated_get(scene.view_layers[0].depsgraph)
    mesh = evaluated.to_mesh()
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    evaluated.to_mesh_clear()
    return points.astype(np.float64)


def _add_caption(
    scene: bpy.types.Scene, text: str, place: Vector, rotation: Matrix, size: float, picture: Picture
) -> None:
    curve = bpy.data.curves.new("Curvopt picture", "FONT")
    curve.body, curve.size = text, size
    curve.align_x, curve.align_y = "CENTER", "CENTER"
    caption = bpy.data.objects.new("Curvopt picture", curve)
    caption.color = (*_INK, 1.0)
    if picture.engine == "cycles":
        curve.materials.append(_ink())
    caption.matrix_world = Matrix.Translation(place) @ rotation.to_4x4()
    scene.collection.objects.link(caption)


def _add_light(scene: bpy.types.Scene, view: tuple[Matrix, float]) -> None:
    """A warm sun from the upper left of the camera and a weak cool one from the right, both soft."""
    warm, cool = ((-0.8, 1.1, 0.9), 2.6, (1.0, 0.97, 0.92)), ((1.0, 0.1, 0.5), 0.6, (0.9, 0.95, 1.0))
    for place, strength, colour in (warm, cool):
        sun = bpy.data.lights.new("Curvopt picture", "SUN")
        sun.energy, sun.color, sun.angle = strength, colour, 0.35
        lamp = bpy.data.objects.new("Curvopt picture", sun)
        lamp.rotation_euler = (view[0] @ Vector(place)).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What every picture needs: a scene of its own that goes away, render settings, materials, captions, light, a camera.

All pictures are orthographic on paper, lit from afar: scale, direction and light are the same for everything in one.
Look "clay" is neutral; "zebra" reflects stripes, and kinks in them show where curvature is not smooth. Engine "cycles"
needs no graphics at all, "workbench" is quicker and needs EGL.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..core.messages import UserError

LOOKS = ("clay", "zebra")
ENGINES = {"cycles": "CYCLES", "workbench": "BLENDER_WORKBENCH"}
CLAY = (0.40, 0.46, 0.54)
INK = (0.05, 0.05, 0.06)
PAPER = (0.90, 0.90, 0.90)

_NAME = "Curvopt picture"
_STRIPES = 18.0  # radians of stripe per unit of the reflected direction
_ZEBRA_MATCAPS = ("reflection_check_horizontal.exr", "check_reflection_horizontal.exr")  # until 4.x, from 5.x
_FLAT = 0.8  # a shape is flat if its least extent is below this part of the middle one

Rgb = tuple[float, float, float]


class RenderError(UserError):
    """The picture could not be made; the message says why."""


@dataclass(frozen=True)
class Picture:
    """Size in pixels, samples per pixel, engine of ENGINES, look of LOOKS."""

    width: int = 1400
    height: int = 700
    samples: int = 64
    engine: str = "cycles"
    look: str = "clay"


@contextmanager
def temporary_scene() -> Iterator[bpy.types.Scene]:
    """A new scene; afterwards it and all data that came into being meanwhile are removed."""
    kinds = ("scenes", "objects", "meshes", "curves", "cameras", "lights", "materials", "worlds")
    before = {kind: set(getattr(bpy.data, kind)) for kind in kinds}
    try:
        yield bpy.data.scenes.new(_NAME)
    finally:
        new = [item for kind in kinds for item in getattr(bpy.data, kind) if item not in before[kind]]
        bpy.data.batch_remove(new)


def render(scene: bpy.types.Scene, path: Path) -> None:
    """Render a scene that is set up to a PNG at `path`. RenderError if the file does not appear, or whatever Blender
    raises."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.is_file() or path.stat().st_size == 0:
        raise RenderError(f"Blender rendered nothing to {path}.")


def set_up_render(scene: bpy.types.Scene, picture: Picture, paper: Rgb = PAPER) -> None:
    """Engine, size, samples and background. RenderError if this Blender has no such engine."""
    settings = scene.render
    try:
        settings.engine = ENGINES[picture.engine]
    except TypeError as error:
        raise RenderError(f"This Blender has no {picture.engine} engine.") from error
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = picture.width, picture.height, 100
    settings.image_settings.file_format = "PNG"
    settings.image_settings.color_mode = "RGB"
    settings.use_file_extension = False
    settings.dither_intensity = 0.0
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new(_NAME)
    scene.world.color = paper
    if picture.engine == "cycles":
        scene.cycles.device = "CPU"
        scene.cycles.samples = picture.samples
        scene.cycles.use_denoising = False  # not in every build
        scene.cycles.max_bounces = 3
        _paper_world(scene.world, paper)
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


def _paper_world(world: bpy.types.World, paper: Rgb) -> None:
    """Paper for the camera, soft light for everything else."""
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output, mix = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeMixShader")
    seen, light = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeBackground")
    seen.inputs[0].default_value = (*paper, 1.0)
    light.inputs[0].default_value = (1.0, 1.0, 1.0, 1.0)
    light.inputs[1].default_value = 0.30
    links.new(nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"], mix.inputs[0])
    links.new(light.outputs[0], mix.inputs[1])
    links.new(seen.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])


def add_surface(
    scene: bpy.types.Scene, mesh: bpy.types.Mesh, picture: Picture, colour: Rgb = CLAY, attribute: str = ""
) -> bpy.types.Object:
    """An object of `mesh` in the picture's look; with `attribute`, a colour attribute of the mesh, in those colours
    (cycles only)."""
    surface = bpy.data.objects.new(_NAME, mesh)
    surface.color = (*colour, 1.0) if picture.look == "clay" else (1.0, 1.0, 1.0, 1.0)
    if picture.engine == "cycles":
        mesh.materials.append(_zebra() if picture.look == "zebra" else _clay(colour, attribute))
    scene.collection.objects.link(surface)
    return surface


def add_painted(scene: bpy.types.Scene, mesh: bpy.types.Mesh, front: str, back: str) -> bpy.types.Object:
    """An object of `mesh` that shines in the colours of two attributes of the mesh, by the side that is seen: light and
    shadow are in them already (cycles only)."""
    material, nodes, links, output = _new_material()
    shader, mix = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeMixRGB")
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs["Fac"])
    for name, socket in ((front, "Color1"), (back, "Color2")):
        source = nodes.new("ShaderNodeAttribute")
        source.attribute_name = name
        links.new(source.outputs["Color"], mix.inputs[socket])
    links.new(mix.outputs["Color"], shader.inputs["Color"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    painted = bpy.data.objects.new(_NAME, mesh)
    scene.collection.objects.link(painted)
    return painted


def _new_material() -> tuple[bpy.types.Material, bpy.types.Nodes, bpy.types.NodeLinks, bpy.types.Node]:
    material = bpy.data.materials.new(_NAME)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    return material, nodes, material.node_tree.links, nodes.new("ShaderNodeOutputMaterial")


def _clay(colour: Rgb, attribute: str) -> bpy.types.Material:
    material, nodes, links, output = _new_material()
    shader = nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = 0.35
    if attribute:
        source = nodes.new("ShaderNodeAttribute")
        source.attribute_name = attribute
        links.new(source.outputs["Color"], shader.inputs["Base Color"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def _ink() -> bpy.types.Material:
    material, nodes, links, output = _new_material()
    shader = nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (*INK, 1.0)
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


def view_rotation(direction: np.ndarray) -> Matrix:
    """Columns: right, up, towards the camera, for a unit vector (3,) to the camera."""
    return Vector(direction).to_track_quat("Z", "Y").to_matrix()


def add_camera(scene: bpy.types.Scene, rotation: Matrix, width: float, height: float, depth: float) -> None:
    """An orthographic camera that sees width x height round the origin, and as far before and behind it as `depth`."""
    camera = bpy.data.objects.new(_NAME, bpy.data.cameras.new(_NAME))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = max(width, height)
    distance = 2.0 * depth
    camera.data.clip_start, camera.data.clip_end = distance / 100, distance * 10
    camera.matrix_world = Matrix.Translation(rotation.col[2] * distance) @ rotation.to_4x4()
    scene.collection.objects.link(camera)
    scene.camera = camera


def add_caption(
    scene: bpy.types.Scene, text: str, place: Vector, rotation: Matrix, size: float, picture: Picture
) -> None:
    """A line of text, centred at `place`, facing the camera; `size` is its height in the scene's units."""
    curve = bpy.data.curves.new(_NAME, "FONT")
    curve.body, curve.size = text, size
    curve.align_x, curve.align_y = "CENTER", "CENTER"
    caption = bpy.data.objects.new(_NAME, curve)
    caption.color = (*INK, 1.0)
    if picture.engine == "cycles":
        curve.materials.append(_ink())
    caption.matrix_world = Matrix.Translation(place) @ rotation.to_4x4()
    scene.collection.objects.link(caption)


def add_light(scene: bpy.types.Scene, rotation: Matrix) -> None:
    """A warm sun from the upper left of the camera and a weak cool one from the right, both soft."""
    warm, cool = ((-0.8, 1.1, 0.9), 2.6, (1.0, 0.97, 0.92)), ((1.0, 0.1, 0.5), 0.6, (0.9, 0.95, 1.0))
    for place, strength, colour in (warm, cool):
        sun = bpy.data.lights.new(_NAME, "SUN")
        sun.energy, sun.color, sun.angle = strength, colour, 0.35
        lamp = bpy.data.objects.new(_NAME, sun)
        lamp.rotation_euler = (rotation @ Vector(place)).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)

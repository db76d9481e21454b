# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the gallery's .blend files from the cages in cages.py, and their OBJ twins; and those of halves.py.

    blender -b --factory-startup --python-exit-code 1 -P blend_files/make_blends.py -- [--only NAME ...] [--output DIR]
    blender -b --factory-startup --python-exit-code 1 -P blend_files/make_blends.py -- --check

Each file holds one mesh object, the cage, with a Subdivision Surface modifier that shows the limit surface, a camera
and a light. A half has a Mirror modifier before that one, and no twin. Blender writes addresses into its files, so two
runs differ in bytes, never in content; --check compares the files that are there with the cages.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from cages import CATALOGUE, Cage, read_obj, write_obj
from halves import HALVES

ENTRIES = {**CATALOGUE, **HALVES}
COMMITTED = tuple(name for name in ENTRIES if name != "lawson_g1")  # that one is a torus again
MAX_BYTES = 300_000
ROUNDING = 1e-14  # sines differ in their last digit from machine to machine
SINGLE_ROUNDING = 1e-7  # a mesh in Blender keeps single precision
VIEW_FROM = (1.0, -1.5, 0.9)
COLOUR = (0.62, 0.30, 0.16, 1.0)


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    """The options after Blender's own `--`."""
    own = arguments[arguments.index("--") + 1 :] if "--" in arguments else []
    parser = argparse.ArgumentParser(prog="make_blends.py", description="Writes the gallery's .blend files.")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=list(ENTRIES), default=list(COMMITTED))
    parser.add_argument("--output", type=Path, default=HERE, metavar="DIR", help="default: beside this script")
    parser.add_argument("--check", action="store_true", help="write nothing, compare with the files in DIR")
    return parser.parse_args(own)


def add_cage(name: str, cage: Cage) -> bpy.types.Object:
    """The cage as the scene's active object, seen as its limit surface."""
    vertices, faces = cage
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [], [list(face) for face in faces])
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    if mesh.validate(verbose=True):
        raise RuntimeError(f"Blender had to repair the cage {name}")
    mesh.update()
    mesh.materials.append(make_material())
    cage_object = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(cage_object)
    if name in HALVES:
        mirror = cage_object.modifiers.new("Mirror", "MIRROR")
        mirror.use_axis = [axis == HALVES[name].axis for axis in range(3)]
        mirror.use_clip = True
    subdivision = cage_object.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = 3
    subdivision.render_levels = 4
    subdivision.quality = 6  # not below the levels: only then are the vertices on the limit surface
    subdivision.use_limit_surface = True
    subdivision.show_on_cage = False
    bpy.context.view_layer.objects.active = cage_object
    cage_object.select_set(True)
    return cage_object


def make_material() -> bpy.types.Material:
    """A plain clay, the same in solid view and in renders."""
    material = bpy.data.materials.new("Clay")
    material.diffuse_color = COLOUR
    material.use_nodes = True
    principled = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    principled.inputs["Base Color"].default_value = COLOUR
    principled.inputs["Roughness"].default_value = 0.35
    return material


def add_camera(centre: Vector, radius: float) -> None:
    """A camera that sees a ball of this centre and radius whole, but for what the surface shrinks from its cage."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 70
    direction = Vector(VIEW_FROM).normalized()
    distance = 0.9 * radius / np.sin(camera.data.angle_y / 2)
    camera.location = centre + float(distance) * direction
    camera.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def add_light(centre: Vector, radius: float) -> None:
    """A large soft light from the upper left of the camera, and a grey world to fill the shadows."""
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "AREA"))
    light.data.size = 3 * radius
    light.data.energy = 120 * radius**2
    direction = Vector((-0.6, -1.0, 1.4)).normalized()
    light.location = centre + 4 * radius * direction
    light.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(light)
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.55, 0.58, 0.62, 1.0)
    background.inputs["Strength"].default_value = 0.5
    bpy.context.scene.world = world


def set_scene(title: str) -> None:
    """Render settings, and a three-dimensional view that opens on the shape."""
    scene = bpy.context.scene
    scene.name = title
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 64
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 960, 720
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.region_3d.view_perspective = "CAMERA"
                    space.shading.type = "SOLID"
                    space.shading.color_type = "MATERIAL"
                    space.shading.show_cavity = False


def make_blend(name: str, output: Path) -> Path:
    """Writes one cage's .blend file and returns its path."""
    entry = ENTRIES[name]
    cage = entry.make()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)
    cage_object = add_cage(name, cage)
    seen = cage[0]
    if name in HALVES:
        seen = np.concatenate([seen, seen * [-1 if axis == HALVES[name].axis else 1 for axis in range(3)]])
    low, high = seen.min(axis=0), seen.max(axis=0)
    centre = Vector(((low + high) / 2).tolist())
    radius = float(np.linalg.norm(seen - np.array(centre), axis=1).max())
    add_camera(centre, radius)
    add_light(centre, radius)
    set_scene(entry.title)
    bpy.context.view_layer.update()
    if cage_object.matrix_world != Matrix.Identity(4):
        raise RuntimeError(f"the object {name} is not at the origin")
    bpy.data.orphans_purge(do_recursive=True)
    path = output / f"{name}.blend"
    with tempfile.TemporaryDirectory() as neutral:  # a .blend remembers where it was saved
        draft = Path(neutral) / path.name
        bpy.ops.wm.save_as_mainfile(filepath=str(draft), compress=True, check_existing=False)
        shutil.move(draft, path)
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise RuntimeError(f"{path} has {size} bytes, more than {MAX_BYTES}")
    return path


def check_twin(twin: Path, vertices: np.ndarray, faces: list[tuple[int, ...]]) -> list[str]:
    """What is wrong with the OBJ twin of a cage."""
    written, polygons = read_obj(twin)
    same = polygons == faces and written.shape == vertices.shape and np.abs(written - vertices).max() < ROUNDING
    return [] if same else [f"{twin} has another cage"]


def check_blend(name: str, output: Path) -> list[str]:
    """What is wrong with a .blend file and its OBJ twin, one sentence per fault."""
    vertices, faces = ENTRIES[name].make()
    path, twin = output / f"{name}.blend", output / "obj" / f"{name}.obj"
    missing = [f"{file} is missing" for file in (path, *([] if name in HALVES else [twin])) if not file.is_file()]
    if missing:
        return missing
    faults = [] if name in HALVES else check_twin(twin, vertices, faces)
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    cages = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    if [cage.name for cage in cages] != [name]:
        return [*faults, f"{path} holds the meshes {[cage.name for cage in cages]}"]
    mesh = cages[0].data
    points = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", points)
    if [tuple(polygon.vertices) for polygon in mesh.polygons] != faces:
        faults.append(f"{path} has other faces than its cage")
    elif np.abs(points.reshape(-1, 3) - vertices).max() > SINGLE_ROUNDING * np.abs(vertices).max():
        faults.append(f"{path} has other vertices than its cage")
    modifiers = [modifier.type for modifier in cages[0].modifiers]
    wanted = ["MIRROR", "SUBSURF"] if name in HALVES else ["SUBSURF"]
    if modifiers != wanted or not cages[0].modifiers[-1].use_limit_surface:
        faults.append(f"{path} has the modifiers {modifiers}")
    return faults


def check_blends(names: list[str], output: Path) -> int:
    """Checks files against their cages, prints the outcome, and returns how many are wrong."""
    wrong = 0
    for name in names:
        faults = check_blend(name, output)
        for fault in faults:
            print(f"make_blends: {fault}", file=sys.stderr)
        wrong += bool(faults)
    print(f"{len(names) - wrong} passed, {wrong} failed")
    return wrong


def main() -> None:
    """Writes, or checks, every .blend file asked for and its OBJ twin."""
    options = parse_arguments(sys.argv)
    if options.check:
        sys.exit(1 if check_blends(options.only, options.output) else 0)
    bpy.context.preferences.filepaths.save_version = 0
    twins = options.output / "obj"
    twins.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        path = make_blend(name, options.output)
        if name in CATALOGUE:
            write_obj(twins / f"{name}.obj", name, CATALOGUE[name].make())
        print(f"make_blends: {path} ({path.stat().st_size} bytes)")


if __name__ == "__main__":
    main()

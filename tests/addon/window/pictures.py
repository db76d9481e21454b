# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: a new user's first five minutes, with pictures for the manual.
CURVOPT_ACTS names some of its functions, if not all are to run."""

import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
import driver  # noqa: E402
from driver import (  # noqa: E402
    click,
    invoke,
    log,
    open_sidebar_tab,
    part,
    press,
    screenshot,
    setup,
    shapes,
    start,
    state,
    turns,
    viewport,
    window,
)


def in_viewport(function, *arguments, **named):
    """Call an operator as from the 3D view."""
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        return function(*arguments, **named)


def settled():
    """Let everything be drawn."""
    for area in window().screen.areas:
        area.tag_redraw()
    yield from turns(12)


def frame():
    """All objects in view, seen from the front and above; the right half of the view is the sidebar's."""
    in_viewport(bpy.ops.view3d.view_all)
    space = viewport()[0].spaces.active
    space.region_3d.view_distance *= 1.25
    yield from settled()


def preferences():
    """The add-on in the list of add-ons, which takes the 3D view's place for this."""
    setup()
    bpy.ops.preferences.addon_enable(module="curvopt")
    area = viewport()[0]
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Curvopt"
    yield from settled()
    screenshot("0_install")
    area.type = "VIEW_3D"
    yield from settled()


def add_lawson():
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    for name in ("strength", "resolution"):
        bpy.context.scene.curvopt.property_unset(name)  # as in a new file
    yield from open_sidebar_tab()
    in_viewport(bpy.ops.wm.call_menu, name="VIEW3D_MT_mesh_add")
    yield from settled()
    screenshot("1_add")
    press("ESC")
    yield from turns(4)
    in_viewport(bpy.ops.curvopt.add_shape, shape="lawson_g2")
    bpy.ops.ed.undo_push(message="Lawson")
    yield from frame()
    screenshot("2_panel")


def minimize():
    settings = bpy.context.scene.curvopt
    settings.energy, settings.strength, settings.resolution, settings.levels = "MVS", 1.0, "REFINE", 4
    assert invoke() == {"RUNNING_MODAL"}
    run = part("ui.operators")._run
    yield lambda: run.job.latest is not None and run.job.latest.level >= 2
    in_viewport(bpy.ops.view3d.view_all)
    viewport()[0].spaces.active.region_3d.view_location.x += 1.5
    viewport()[0].spaces.active.region_3d.view_distance *= 2.2
    yield from turns(8)
    screenshot("3_running")
    yield lambda: not state().running
    yield from frame()
    screenshot("4_finished")


def undo_and_redo():
    """The whole run in one step, there and back."""
    count = len(bpy.data.objects)
    press("Z", ctrl=True)
    yield lambda: len(bpy.data.objects) == count - 1
    yield from settled()
    screenshot("4_undone")
    press("Z", ctrl=True, shift=True)
    yield lambda: len(bpy.data.objects) == count
    yield from settled()


def adjust_panel():
    """The adjust panel, opened by its header and closed again."""
    hud = next(region for region in viewport()[0].regions if region.type == "HUD")
    closed = hud.height
    yield from click(hud.x + 40, hud.y + hud.height - 10)
    yield lambda: hud.height > closed + 40
    yield from settled()
    screenshot("10_adjust")
    yield from click(hud.x + 40, hud.y + hud.height - 10)
    yield from settled()


def pins_and_planes():
    """A cage that is symmetric about two planes, part of it painted, and what the panel says to that."""
    settings, cage = bpy.context.scene.curvopt, bpy.data.objects["Lawson genus 2"]
    cage.modifiers.remove(cage.modifiers["Array"])
    group = cage.vertex_groups.new(name="Pins")
    for vertex in cage.data.vertices:
        group.add([vertex.index], min(1.0, abs(vertex.co.x)), "REPLACE")
    settings.symmetry, settings.symmetry_planes = "PLANES", (False, True, True)
    settings.pin, settings.vertex_group = "GROUP", "Pins"
    yield from settled()
    screenshot("11_planes")


def compare():
    obj = bpy.context.object
    obj.curvopt_amount = 0.4
    yield from settled()
    screenshot("5_amount")
    obj.curvopt_amount = 1.0
    bpy.context.window_manager.curvopt_look = "ZEBRA"
    yield from settled()
    screenshot("6_zebra")
    in_viewport(bpy.ops.curvopt.curvature, levels=2, quantity="H")
    yield from frame()
    screenshot("7_curvature")
    bpy.context.window_manager.curvopt_look = "PLAIN"


def cancel_and_refusal():
    in_viewport(bpy.ops.ed.undo_push)
    cage = bpy.data.objects["Lawson genus 2"]
    for obj in list(bpy.data.objects):
        if obj is not cage:
            bpy.data.objects.remove(obj)
    cage.select_set(True)
    bpy.context.view_layer.objects.active = cage
    assert invoke() == {"RUNNING_MODAL"}
    run = part("ui.operators")._run
    yield lambda: run.job.latest is not None
    press("ESC")
    yield lambda: not state().running
    yield from frame()
    screenshot("8_cancelled")
    state().message = ""
    cage.modifiers.new("Array", "ARRAY")
    in_viewport(bpy.ops.object.modifier_move_to_index, modifier="Array", index=0)
    yield from settled()
    screenshot("9_refused")


def begin_live(shape, energy, strength, chosen_of):
    """Live on a shape of the Add menu with handles at chosen_of(points (n, 3)), its minimum on the screen; a generator. Its
    points."""
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    settings = bpy.context.scene.curvopt
    settings.energy, settings.strength, settings.symmetry, settings.resolution = energy, strength, "AUTO", "SAME"
    in_viewport(bpy.ops.curvopt.add_shape, shape=shape)
    mesh = bpy.context.object.data
    points = np.array([vertex.co for vertex in mesh.vertices])
    for parts, chosen in ((mesh.vertices, chosen_of(points)), (mesh.edges, ()), (mesh.polygons, ())):
        parts.foreach_set("select", [index in chosen for index in range(len(parts))])
    in_viewport(bpy.ops.curvopt.live)
    session = part("ui.live")._session
    yield lambda: session.live is not None and session.live.is_settled and "Checked" in state().message
    viewport()[0].spaces.active.overlay.show_cursor = False
    return points


def pull(chosen, way):
    """Handles along `way` (3,) in ten steps, until the surface has settled; a generator."""
    live = part("ui.live")._session.live
    for empty in handles():
        empty.select_set(empty in chosen)
    bpy.context.view_layer.objects.active = chosen[0]
    for _ in range(10):
        for handle in chosen:
            handle.location = [place + 0.1 * step for place, step in zip(handle.location, way)]
        number = live.number
        yield lambda: live.number > number
    yield lambda: live.is_settled and "Checked" in state().message
    print(state().message, flush=True)
    yield from settled()


def handles():
    """Those that are there, the one with the largest x first."""
    found = [obj for obj in bpy.data.objects if "curvopt_handle" in obj]
    return sorted(found, key=lambda empty: -empty.location.x)


def live():
    """Four handles on a cage of genus 2, one of them pulled; then a mug whose handle is bent."""
    view = viewport()[0].spaces.active.region_3d
    ends = lambda points: {int(np.argmax(sign * points[:, axis])) for axis in (0, 2) for sign in (1, -1)}  # noqa: E731
    points = yield from begin_live("lawson_g2", "MVS", 1.0, ends)
    size = np.ptp(points, axis=0).max()
    view.view_perspective, view.view_rotation = "PERSP", Euler((1.2, 0, 0.5)).to_quaternion()
    view.view_location, view.view_distance = (0.9, 0, 0), 2.6 * size
    yield from open_sidebar_tab()
    yield from settled()
    screenshot("16_live")
    yield from pull(handles()[:1], (0.5 * np.ptp(points[:, 0]), 0, 0.2 * np.ptp(points[:, 0])))
    screenshot("17_live_pulled")
    bpy.ops.curvopt.live_cancel()
    yield from turns(2)
    outer = lambda points: set(np.flatnonzero(points[:, 0] > 0.7 * points[:, 0].max()))  # noqa: E731
    points = yield from begin_live("mug_g1", "WILLMORE", 0.5, outer)
    size = np.ptp(points, axis=0).max()
    print(len(handles()), "handles", flush=True)
    yield from pull(handles(), (0.18 * size, 0, 0.2 * size))
    bpy.ops.curvopt.live_finish("INVOKE_DEFAULT")
    yield lambda: not state().live
    view.view_rotation = Euler((1.25, 0, 0)).to_quaternion()
    view.view_location, view.view_distance = (1.2 * size, 0, 0.4 * size), 3.5 * size
    yield from settled()
    screenshot("18_mug")


def label(text, place):
    """Words in the view, above this place (x, y)."""
    empty = bpy.data.objects.new(text, None)
    empty.location, empty.empty_display_size, empty.show_name = (*place, 0), 0.01, True
    bpy.context.scene.collection.objects.link(empty)
    empty.select_set(True)  # for a bright colour


def slide():
    """A dome whose boundary is bunched, and what Minimize makes of it without and with Slide."""
    setup()
    settings, view = bpy.context.scene.curvopt, viewport()[0].spaces.active.region_3d
    points, faces = shapes.dome()
    dome = bpy.data.objects.new("Dome", bpy.data.meshes.new("Dome"))
    dome.data.from_pydata(points.tolist(), [], faces)
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    bpy.context.scene.collection.objects.link(dome)
    dome.modifiers.new("Subdivision", "SUBSURF").levels = 3
    dome.rotation_euler.z = 1.4  # the bunched side to the front
    settings.energy, settings.strength, settings.resolution, settings.symmetry = "MVS", 1.0, "SAME", "AUTO"
    shown = [dome]
    for slides in (False, True):
        in_viewport(bpy.ops.object.select_all, action="DESELECT")
        bpy.context.view_layer.objects.active = dome
        settings.slide = slides
        assert invoke() == {"RUNNING_MODAL"}
        yield lambda: not state().running
        shown.append(bpy.context.object)
        print(state().message, flush=True)
    places = (1.2, 2.3), (0, 0), (2.4, 0)
    in_viewport(bpy.ops.object.select_all, action="DESELECT")
    for obj, (x, y), text in zip(shown, places, ("Original", "Without Slide", "With Slide")):
        obj.location, obj.show_wire = (x, y, 0), True
        label(text, (x - 0.35, y - 1.2))
    view.view_perspective, view.view_rotation = "ORTHO", Euler((0.7, 0, 0)).to_quaternion()
    view.view_location, view.view_distance = (1.9, 1, 0), 5.6
    viewport()[0].spaces.active.overlay.show_cursor = False
    yield from open_sidebar_tab()
    yield from settled()
    screenshot("15_slide")


def beside(ball, targets, tilt, distance):
    """Looks at `ball` and its result, which is moved aside, among copies of the targets."""
    print(state().message, flush=True)
    result, view = bpy.context.object, viewport()[0].spaces.active.region_3d
    aside = Vector((1.1 * (ball.dimensions.x + result.dimensions.x) / 2, 0, 0))
    result.location += aside
    for target in targets:
        copy = target.copy()
        copy.location = target.location + aside
        bpy.context.scene.collection.objects.link(copy)
    view.view_perspective, view.view_rotation = "PERSP", Euler((tilt, 0, 0)).to_quaternion()
    view.view_location, view.view_distance = result.location / 2 + ball.location / 2, distance
    view.view_location += Vector((0.9, 0, 0.3))
    viewport()[0].spaces.active.overlay.show_cursor = False
    yield from open_sidebar_tab()
    yield from settled()


def add_ball():
    """A ball of quads with a Subdivision Surface modifier, alone in the scene."""
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    points, faces = shapes.quad_sphere()
    ball = bpy.data.objects.new("Ball", bpy.data.meshes.new("Ball"))
    ball.data.from_pydata(points.tolist(), [], faces)
    bpy.context.scene.collection.objects.link(ball)
    ball.modifiers.new("Subdivision", "SUBSURF").levels = 3
    return ball


def choose(ball):
    """The ball alone, selected and active."""
    in_viewport(bpy.ops.object.select_all, action="DESELECT")
    bpy.context.view_layer.objects.active = ball
    ball.select_set(True)


def go_through():
    """A ball whose surface is to go through three rings, and the result beside it, among copies of the rings."""
    ball = add_ball()
    settings = bpy.context.scene.curvopt
    rings = bpy.data.collections.new("Rings")
    bpy.context.scene.collection.children.link(rings)
    for radius, height in ((0.95, -0.5), (0.5, 0.45), (0.75, 0.95)):
        in_viewport(bpy.ops.curve.primitive_bezier_circle_add, radius=radius, location=(0, 0, height))
        ring = bpy.context.object
        for collection in list(ring.users_collection):
            collection.objects.unlink(ring)
        rings.objects.link(ring)
        ring.data.bevel_depth = 0.012
    choose(ball)
    settings.energy, settings.strength, settings.resolution, settings.symmetry = "MVS", 1.0, "SAME", "AUTO"
    settings.through = rings.name
    assert invoke() == {"RUNNING_MODAL"}
    yield lambda: not state().running
    yield from beside(ball, list(rings.objects), 1.3, 8)
    screenshot("25_go_through")
    settings.through = ""


def touched_balls():
    """A ball that is to touch four others, one of them from outside, and the result beside it, among copies of them."""
    ball = add_ball()
    settings = bpy.context.scene.curvopt
    touched = bpy.data.collections.new("Balls")
    bpy.context.scene.collection.children.link(touched)
    for name, place, axis, size in (
        ("Left", (-0.9, 0, 0.3), (-1, 0, 0.4), 0.35), ("Right", (0.75, 0, 0.3), (1, 0, 0.4), 0.55),
        ("Below", (0, 0, -0.5), (0, 0, -1), 0.6), ("Above", (0, 0, 1.05), (0, 0, -1), 0.7),
    ):  # fmt: skip
        empty = bpy.data.objects.new(name, None)
        empty.empty_display_type, empty.empty_display_size, empty.location, empty.show_in_front = "SPHERE", size, place, True
        empty.rotation_euler = Vector(axis).to_track_quat("Z", "Y").to_euler()
        touched.objects.link(empty)
    choose(ball)
    settings.energy, settings.strength, settings.resolution, settings.symmetry = "MVS", 1.0, "REFINE", "AUTO"
    settings.levels, settings.through, settings.through_balls = 2, touched.name, True
    assert invoke() == {"RUNNING_MODAL"}
    yield lambda: not state().running
    yield from beside(ball, list(touched.objects), 1.3, 8)
    screenshot("28_balls")
    settings.through, settings.through_balls = "", False


def select(obj, vertices):
    """Select vertices of a mesh in Edit Mode."""
    for elements in (obj.data.vertices, obj.data.edges, obj.data.polygons):
        elements.foreach_set("select", [False] * len(elements))
    for vertex in vertices:
        obj.data.vertices[int(vertex)].select = True
    in_viewport(bpy.ops.object.mode_set, mode="EDIT")


def guides():
    """A ball with two guides by New Guide, one of them bent up and down, and the result beside it, among copies of them."""
    ball = add_ball()
    settings = bpy.context.scene.curvopt
    bpy.context.view_layer.objects.active = ball
    ball.select_set(True)
    points = shapes.quad_sphere()[0]
    x, y, z = np.abs(points).T
    for chain in (z < 1e-6, (x < 1e-6) & (y < 0.75) & (points[:, 2] > 0.3)):
        select(ball, np.flatnonzero(chain))
        in_viewport(bpy.ops.curvopt.new_guide)
        in_viewport(bpy.ops.object.mode_set, mode="OBJECT")
    ring, arch = bpy.data.objects["Guide"], bpy.data.objects["Guide.001"]
    for knot in ring.data.splines[0].bezier_points:
        knot.co *= 1.2
        knot.co.z += 0.2 * np.cos(3 * np.arctan2(knot.co.y, knot.co.x))
    for knot in arch.data.splines[0].bezier_points:
        knot.co *= 1.1
    for guide in (ring, arch):
        guide.data.bevel_depth = 0.012
    settings.energy, settings.strength, settings.resolution, settings.symmetry = "MVS", 1.0, "REFINE", "AUTO"
    settings.levels = 2
    assert invoke() == {"RUNNING_MODAL"}
    yield lambda: not state().running
    yield from beside(ball, (ring, arch), 1.2, 7)
    screenshot("27_guides")
    settings.through = ""


def inspect():
    """A bumpy bottle with zebra stripes on it; combs on two rings, and the probe; how far a fairer one is from it."""
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    points, faces = shapes.bottle()
    bottle = bpy.data.objects.new("Bottle", bpy.data.meshes.new("Bottle"))
    bottle.data.from_pydata(points.tolist(), [], faces)
    bpy.context.scene.collection.objects.link(bottle)
    bottle.modifiers.new("Subdivision", "SUBSURF").levels = 3
    bpy.context.view_layer.objects.active = bottle
    panels, space = part("ui.panel"), viewport()[0].spaces.active
    panels.CURVOPT_PT_inspect.bl_options = set()  # open
    for panel in (panels.CURVOPT_PT_inspect, panels.CURVOPT_PT_advanced):  # in this order
        bpy.utils.unregister_class(panel)
        bpy.utils.register_class(panel)
    yield from open_sidebar_tab()
    chosen, view, settings = bpy.context.window_manager.curvopt_inspect, space.region_3d, bpy.context.scene.curvopt
    space.overlay.show_cursor = False
    view.view_perspective, view.view_rotation = "PERSP", Euler((1.35, 0, 0)).to_quaternion()
    view.view_location, view.view_distance = (0.65, 0, 1.95), 6.3
    settings.energy, settings.strength, settings.resolution = "WILLMORE", 0.3, "SAME"
    chosen.is_on, chosen.kind, chosen.width = True, "ZEBRA", 0.2
    session = part("ui.inspect")._session
    is_shown = lambda: session._shown is not None and session.inspector.is_settled and not session.is_dirty  # noqa: E731
    yield is_shown
    yield from settled()
    screenshot("19_inspect")
    chosen.kind, chosen.combs, chosen.comb_length = "PLAIN", True, 0.12
    marked = [tuple(sorted(pair)) for pair in ((64, 65), (144, 145))]  # of two rings
    wanted = [tuple(sorted(edge.vertices)) in marked for edge in bottle.data.edges]
    bottle.data.edges.foreach_set("select", wanted)
    bottle.data.update()
    bpy.context.view_layer.update()
    chosen.probe = True
    yield is_shown
    region = viewport()[1]
    for step in range(3):
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=region.x + 300 + step, y=region.y + 270)
        yield from turns(3)
    yield from settled()
    screenshot("20_combs")
    chosen.probe, chosen.comb_curves, chosen.comb_sections, chosen.comb_length = False, "Z", 9, 0.06
    view.view_rotation = Euler((1.1, 0, 0)).to_quaternion()
    yield is_shown
    yield from settled()
    screenshot("26_sections")
    view.view_rotation = Euler((1.35, 0, 0)).to_quaternion()
    chosen.combs = False
    assert invoke() == {"RUNNING_MODAL"}
    yield lambda: not state().running
    chosen.kind = "DISTANCE"
    view.view_location, view.view_distance = (2.0, 0, 1.9), 7.6
    yield is_shown
    yield from settled()
    screenshot("21_distance")
    chosen.is_on = False


def animation():
    """A run of two levels as shape keys, in its middle, and the keyframes in the timeline."""
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    in_viewport(bpy.ops.curvopt.add_shape, shape="lawson_g2")
    settings, view = bpy.context.scene.curvopt, viewport()[0].spaces.active.region_3d
    settings.energy, settings.strength, settings.resolution, settings.levels = "MVS", 1.0, "REFINE", 3
    settings.animation = True
    yield from open_sidebar_tab()
    assert invoke() == {"RUNNING_MODAL"}
    yield lambda: not state().running
    print(state().message, flush=True)
    yield from frame()
    view.view_rotation = Euler((1.2, 0, 0.2)).to_quaternion()
    view.view_location.x += 1.5
    view.view_distance *= 1.2
    bpy.context.scene.frame_end = 60
    bpy.context.scene.frame_set(14)
    timeline = next(area for area in window().screen.areas if area.type == "DOPESHEET_EDITOR")
    below = next(region for region in timeline.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window(), area=timeline, region=below):
        bpy.ops.action.view_all()
    yield from settled()
    screenshot("22_animation")
    settings.animation = False


def everything():
    acts = (
        preferences, add_lawson, minimize, adjust_panel, undo_and_redo, compare, cancel_and_refusal, pins_and_planes, slide,
        go_through, touched_balls, guides, live, inspect, animation,
    )  # fmt: skip
    wanted = os.environ.get("CURVOPT_ACTS", "").split()
    try:
        for act in acts:
            if wanted and act.__name__ not in wanted:
                continue
            yield from act()
            log(f"PASS {act.__name__}")
    except Exception as error:
        traceback.print_exc()
        log(f"FAIL {error!r}")
    bpy.ops.wm.quit_blender()


driver.PATIENCE = 300.0  # the run of four levels takes a minute or more on a busy machine
start(everything())

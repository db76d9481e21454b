# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: Live, where the surface follows handles. As drive.py, with lines in the same
file RESULTS."""

import sys
import threading
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import driver  # noqa: E402
from driver import (  # noqa: E402
    RESULTS,
    contents,
    log,
    open_sidebar_tab,
    part,
    press,
    run_checks,
    screenshot,
    setup,
    start,
    state,
    turns,
    viewport,
    window,
)

CHECKS = []
BEFORE = {}  # contents of the scene before Live, of the last `begin`
PINS = (0, 9, 18, 27)


def check(function):
    """Register a generator function as a check, run in order."""
    CHECKS.append(function)
    return function


def call(operator):
    """As a button would. Only while no worker is there: see driver.py."""
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        return operator("INVOKE_DEFAULT", True)


def session():
    return part("ui.live")._session


def torus():
    return bpy.data.objects["Torus"]


def handles():
    return part("scene.handles").empties(torus())


def begin(mode="OBJECT", selected=PINS, pin="SELECTED"):
    """A torus without symmetry, some of its vertices selected, and Live on it at its first optimum; a generator."""
    if state().live:  # of the check before
        bpy.ops.curvopt.live_cancel()
    setup(noise=0.05)
    settings = bpy.context.scene.curvopt
    settings.energy, settings.resolution, settings.pin = "WILLMORE", "SAME", pin
    chosen = np.isin(np.arange(32), selected)
    torus().data.vertices.foreach_set("select", chosen)
    torus().data.edges.foreach_set("select", np.zeros(len(torus().data.edges), bool))
    torus().data.polygons.foreach_set("select", np.zeros(len(torus().data.polygons), bool))
    if mode == "EDIT":
        bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="Before Live")
    BEFORE.clear()
    BEFORE.update(contents())
    assert no_thread() and call(bpy.ops.curvopt.live) == {"FINISHED"}
    assert state().live == "ON"
    yield settled


def settled():
    return state().live == "ON" and session().live is not None and session().live.is_settled and "Checked" in state().message


def at(vertex):
    """Where the surface's cage has a vertex, in the world."""
    return np.array(session().live.latest.snapshot.cage[vertex])


def newest_is_shown():
    live = session().live
    return live.latest.number == live.number and session().view._picture._drawn is live.latest.snapshot


def no_thread():
    return not [thread for thread in threading.enumerate() if thread.name == "curvopt"]


def is_off():
    return state().live == "" and session() is None and no_thread()


def nothing_left():
    assert contents() == BEFORE, "the scene is another one"
    assert torus().display_type == "TEXTURED" and not torus().keys(), list(torus().keys())


def move_mouse(x, y):
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)


def middle():
    region = viewport()[1]
    return region.x + region.width // 2, region.y + region.height // 2


def grab(steps):
    """G, and the mouse away from the middle; the number of targets that came meanwhile. A generator."""
    press("G")
    yield from turns(3)
    x, y = middle()
    for step in range(1, steps + 1):
        move_mouse(x + 6 * step, y + 4 * step)
        yield from turns(2)


def click_there(steps):
    x, y = middle()
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type="LEFTMOUSE", value=value, x=x + 6 * steps, y=y + 4 * steps)


@check
def the_surface_follows_an_empty_and_esc_restores():
    setup(noise=0.05)
    yield from open_sidebar_tab()
    yield from begin()
    assert sorted(handles()) == list(PINS) and torus().display_type == "WIRE"
    assert "true local minimum" in state().message
    first = session().live.latest.energy
    handle = handles()[0]
    shown = 0
    for step in range(1, 9):
        handle.location.z += 0.05
        number = session().live.number
        yield lambda: session().live.number > number and newest_is_shown()
        shown += 1
        assert np.abs(at(0) - np.array(handle.matrix_world.translation)).max() < 1e-5
    yield settled
    assert shown == 8 and session().live.latest.energy > first
    assert np.abs(at(9) - np.array(torus().data.vertices[9].co)).max() < 1e-5
    yield from turns(3)
    screenshot("live")
    press("ESC")
    yield is_off
    nothing_left()
    assert "nothing was changed" in state().message


@check
def the_surface_moves_in_the_same_picture_as_the_hand():
    """Where the first answer comes in time, which here has all the time."""
    yield from begin()
    live, wait, drawn = session().live, part("ui.live")._WAIT, []
    handler = bpy.types.SpaceView3D.draw_handler_add(
        lambda: drawn.append((np.array(handles()[0].location), live.latest.number, live.number)), (), "WINDOW", "PRE_VIEW"
    )
    part("ui.live")._WAIT = 300.0
    try:
        for step in range(1, 6):
            handles()[0].location.z += 0.02
            goal, number = np.array(handles()[0].location), live.number
            yield lambda: live.number > number and drawn and np.array_equal(drawn[-1][0], goal)
    finally:
        part("ui.live")._WAIT = wait
        bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
    assert all(latest == newest for _, latest, newest in drawn), drawn
    yield settled


def contents_of_meshes():
    return {obj.name: [tuple(v.co) for v in obj.data.vertices] for obj in bpy.data.objects if obj.type == "MESH"}


@check
def grabbing_with_g_moves_the_surface_and_is_undone_in_one_step():
    yield from begin()
    live, number, place = session().live, session().live.number, at(0)
    assert bpy.context.view_layer.objects.active == handles()[0]
    yield from grab(6)
    assert live.number >= number + 3, "nothing followed during the grab"
    assert state().live == "ON"
    click_there(6)
    yield from turns(3)
    yield settled
    moved = at(0)
    assert np.abs(moved - place).max() > 0.1
    assert np.abs(moved - np.array(handles()[0].matrix_world.translation)).max() < 1e-5
    press("Z", ctrl=True)
    yield lambda: settled() and np.abs(at(0) - place).max() < 1e-5
    assert session().live is live and state().live == "ON"
    press("Z", ctrl=True, shift=True)
    yield lambda: settled() and np.abs(at(0) - moved).max() < 1e-5
    yield from grab(3)
    press("ESC")  # of the grab, not of Live
    yield from turns(4)
    yield lambda: settled() and np.abs(at(0) - moved).max() < 1e-5
    assert state().live == "ON"


@check
def finishing_writes_the_optimum_as_one_step():
    expected = at(0), session().live.latest.energy
    bpy.ops.curvopt.live_finish("INVOKE_DEFAULT")
    yield is_off
    yield lambda: "Torus Willmore" in bpy.data.objects
    result = bpy.data.objects["Torus Willmore"]
    assert result["curvopt_verdict"].startswith("Checked: a true local minimum")
    assert abs(result["curvopt_after_willmore"] - expected[1]) < 1e-6 * expected[1]
    assert any(modifier.type == "SUBSURF" for modifier in result.modifiers)
    assert not part("scene.handles").is_there("Torus") and bpy.context.object == result
    assert {obj.name for obj in bpy.data.objects} == {"Torus", "Torus Willmore"}
    shift = np.array(result.matrix_world.translation) - np.array(torus().matrix_world.translation)
    assert np.abs(np.array(result.data.vertices[0].co) - expected[0]).max() < 1e-4 and shift[0] > 1
    press("Z", ctrl=True)
    yield lambda: "Torus Willmore" not in bpy.data.objects
    assert len(handles()) == 4 and state().live == ""
    bpy.context.view_layer.objects.active = torus()
    assert bpy.ops.curvopt.live_cancel.poll()
    assert bpy.ops.curvopt.live() == {"FINISHED"}  # goes on with the handles that are there
    yield settled
    assert len(handles()) == 4 and np.abs(at(0) - expected[0]).max() < 1e-4
    bpy.ops.curvopt.live_cancel()
    assert list(contents()) == ["Torus"] and state().live == ""


@check
def vertices_dragged_in_edit_mode_are_handles():
    yield from begin("EDIT")
    before = [tuple(co) for co in session().source.mesh.positions]
    assert not handles()
    place = at(0)
    yield from grab(6)
    click_there(6)
    yield from turns(3)
    yield settled
    shifts = [np.abs(at(pin) - np.array(before[pin])) for pin in PINS]
    assert np.min(shifts, axis=0).max() > 0.1, shifts
    press("Z", ctrl=True)
    yield lambda: settled() and np.abs(at(0) - place).max() < 1e-5
    press("TAB")
    yield lambda: bpy.context.mode == "OBJECT"
    yield from turns(3)
    assert state().live == "ON"
    press("TAB")
    yield lambda: bpy.context.mode == "EDIT_MESH"
    yield from grab(2)
    click_there(2)
    yield from turns(3)
    yield settled
    bpy.ops.curvopt.live_finish("INVOKE_DEFAULT")
    yield is_off
    yield lambda: "Torus Willmore" in bpy.data.objects
    assert bpy.context.mode == "OBJECT"
    assert np.abs(np.array(contents_of_meshes()["Torus"]) - np.array(before)).max() < 1e-6
    moved = np.array(contents_of_meshes()["Torus Willmore"])[list(PINS)] - np.array(before)[list(PINS)]
    assert np.abs(moved).max(axis=1).min() > 0.03


@check
def settings_handles_frames_saving_and_rendering_while_it_is_on():
    yield from begin()
    live, settings = session().live, bpy.context.scene.curvopt
    energy = live.latest.energy
    settings.strength = 0.1
    yield lambda: settled() and "nearness to the original" in state().message
    assert live.latest.energy > energy
    bpy.data.objects.remove(handles()[9])
    yield lambda: settled() and 9 not in session().request.held.vertices
    settings.keep_volume = True
    yield lambda: settled() and session().request.keeps_volume
    settings.keep_volume = False
    settings.energy = "MIX"
    for term in part("ui.properties").WEIGHT_TERMS:
        setattr(settings, f"weight_{term}", 0.0)
    yield lambda: state().failed
    assert state().live == "ON", state().message
    settings.energy = "WILLMORE"
    yield lambda: settled() and not state().failed
    bpy.context.scene.frame_set(7)
    bpy.ops.wm.save_as_mainfile(filepath=str(RESULTS.with_name("live.blend")), copy=True)
    render = bpy.context.scene.render
    render.engine, render.resolution_x, render.resolution_y = "BLENDER_WORKBENCH", 32, 32
    bpy.context.scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.ops.render.render()
    handles()[0].location.z += 0.2
    number = live.number
    yield lambda: live.number > number and settled()
    assert not bpy.ops.curvopt.minimize.poll() and not bpy.ops.curvopt.live.poll()
    torus().name = "Renamed"
    yield from turns(5)
    assert state().live == "ON" and session().name == "Renamed"
    press("ESC")
    yield is_off
    assert "Renamed" in bpy.data.objects


@check
def an_esc_that_ends_playback_ends_nothing_else():
    yield from begin()
    screen = window().screen
    press("SPACE")
    yield lambda: screen.is_animation_playing
    press("ESC")
    yield lambda: not screen.is_animation_playing
    yield from turns(10)
    assert state().live == "ON" and len(handles()) == len(PINS)
    press("ESC")
    yield is_off
    nothing_left()


@check
def deleting_the_object_ends_it():
    yield from begin()
    live = session().live
    bpy.data.objects.remove(torus())
    yield lambda: state().live == "ENDED"
    assert state().failed and "was deleted" in state().message and not live.running
    press("ESC")  # is for Live that is on
    yield from turns(5)
    assert state().live == "ENDED" and len(bpy.data.objects) == len(PINS)
    bpy.ops.curvopt.live_cancel()
    assert is_off()
    assert not list(bpy.data.objects)


@check
def undoing_its_start_ends_it():
    yield from begin()
    press("Z", ctrl=True)
    yield lambda: is_off() and state().failed
    assert "undone" in state().message and list(contents()) == ["Torus"] and torus().display_type == "TEXTURED"
    yield from begin()
    bpy.ops.object.mode_set(mode="OBJECT")
    for handle in list(handles().values()):
        bpy.data.objects.remove(handle)
    yield lambda: state().live == "ENDED"
    assert "All handles were deleted" in state().message
    bpy.ops.curvopt.live_cancel()
    assert is_off()
    yield from begin()
    other = torus().data.copy()
    other.vertices.add(1)
    torus().data = other
    yield lambda: state().live == "ENDED"
    assert "other vertices" in state().message
    bpy.ops.curvopt.live_cancel()
    assert is_off()
    assert torus().display_type == "TEXTURED"


@check
def sessions_that_begin_in_the_turn_in_which_their_objects_are_made_anew():
    """Blender drew nothing between the end of the one, other objects, and the begin of the next one."""
    for session_number in range(12):
        yield from begin("EDIT" if session_number % 3 == 2 else "OBJECT")
        assert len(handles()) == (0 if session_number % 3 == 2 else len(PINS))
    bpy.ops.curvopt.live_cancel()
    assert is_off()
    nothing_left()


@check
def loading_a_file_ends_it():
    yield from begin()
    handles()[0].location.z += 0.3
    live = session().live
    yield from turns(1)
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield is_off
    assert not live.running and part("ui.live")._session is None


@check
def without_pin_the_handles_are_on_the_surface():
    yield from begin(pin="NOTHING")
    for step in range(4):
        handles()[0].location.x += 0.05
        number = session().live.number
        yield lambda: session().live.number > number and newest_is_shown()
    yield settled
    yield lambda: session().live.latest.snapshot is not None and newest_is_shown()
    points = session().live.latest.snapshot.points
    for handle in handles().values():
        assert np.linalg.norm(points - np.array(handle.matrix_world.translation), axis=1).min() < 1e-3
    press("ESC")
    yield is_off


@check
def what_has_no_handles_is_refused():
    for selected, words in (((), "selected"), (range(32), "would become a handle")):
        try:
            yield from begin(selected=selected)
            raise AssertionError("it was accepted")
        except RuntimeError as error:
            assert words in str(error), error
        assert is_off() and state().failed and list(contents()) == ["Torus"] and torus().display_type == "TEXTURED"
        yield from turns(2)


def give_up():
    """End Live after a check that failed."""
    press("ESC")
    yield from turns(3)
    if state().live:
        bpy.ops.curvopt.live_cancel()


def everything():
    """All checks; then quit while Live is on."""
    yield from run_checks(CHECKS, give_up)
    yield from begin()
    handles()[0].location.z += 0.3
    yield from turns(1)
    log("QUITTING LIVE")
    bpy.ops.wm.quit_blender()


if __name__ == "__main__":
    driver.PATIENCE = 120.0
    start(everything())

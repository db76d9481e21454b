# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: sequences of random actions while runs or Live are on, one after the other.

After each, the run or Live that may be on is cancelled, and then there must be no worker left, nothing of ours on the screen,
and the object, unless an action took it away. Environment: CURVOPT_CAMPAIGN is "first last"; the seed of a sequence is
its number. A third word, "live", has every one begin with Live. Lines in RESULTS: "BEGIN n actions", then "PASS n" or "FAIL n why". One in ten ends by quitting Blender in
the middle of a run: "QUITTING n".
"""

import os
import random
import sys
import threading
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from driver import RESULTS, invoke, log, part, press, setup, start, state, turns, viewport, window  # noqa: E402

FIRST, LAST = map(int, os.environ["CURVOPT_CAMPAIGN"].split()[:2])
STARTS = ["live"] if os.environ["CURVOPT_CAMPAIGN"].split()[2:] == ["live"] else ["start", "live"]
SPARED = {
    "start", "live", "drag", "grab", "finish live", "wait", "escape", "enter", "keys", "save", "rename", "mode", "colour",
    "settings", "coincide", "through", "far", "delete handle", "frame", "render",
}  # keep the object  # fmt: skip


def torus():
    return bpy.data.objects.get("Torus") or bpy.data.objects.get("Renamed")


def is_live():
    return bool(state().live)


def begin_live(chance):
    """Handles at four vertices, in Object Mode or Edit Mode."""
    if torus() is None or part("ui.operators")._run is not None:
        return
    bpy.context.view_layer.objects.active = torus()
    settings = bpy.context.scene.curvopt
    settings.energy, settings.pin = chance.choice(["WILLMORE", "MVS"]), chance.choice(["SELECTED", "NOTHING"])
    settings.outcome, settings.strength = chance.choice(["NEW", "REPLACE", "SHAPE_KEY"]), chance.choice([0.3, 1.0])
    if bpy.context.mode == "OBJECT":
        mesh = torus().data
        for parts, chosen in ((mesh.vertices, chance.sample(range(32), 4)), (mesh.edges, ()), (mesh.polygons, ())):
            parts.foreach_set("select", [index in chosen for index in range(len(parts))])
    bpy.ops.curvopt.live()


def handles():
    return [obj for obj in bpy.data.objects if "curvopt_handle" in obj]


def drag(chance):
    """Move a handle, or a vertex in Edit Mode."""
    if handles():
        chance.choice(handles()).location.z += chance.uniform(-0.5, 0.5)
    elif is_live() and bpy.context.mode == "EDIT_MESH":
        bpy.ops.transform.translate(value=(0, 0, 0.2))


def grab(_chance):
    """A grab that moves nothing; what comes while it is on is in live.py."""
    press("G")
    press("RET")


def coincide(chance):
    """One handle to where another one is."""
    if len(handles()) > 1:
        one, other = chance.sample(handles(), 2)
        one.location = other.location


def drag_through(chance):
    """Two handles each through the other to where that was, in steps."""
    if len(handles()) > 1:
        pair = [obj.name for obj in chance.sample(handles(), 2)]
        places = [bpy.data.objects[name].location.copy() for name in pair]
        for step in range(1, 9):
            if not all(name in bpy.data.objects for name in pair):
                return
            for name, begin, end in zip(pair, places, reversed(places)):
                bpy.data.objects[name].location = begin.lerp(end, step / 8)
            yield from turns(1)


def drag_far(chance):
    """A handle as far as nobody means to."""
    if handles():
        chance.choice(handles()).location[chance.randrange(3)] = chance.choice([1e10, -1e10, 3e38, float("inf")])


def delete_handle(chance):
    if handles():
        bpy.data.objects.remove(chance.choice(handles()))


def delete_while_grabbed(_chance):
    """The object, while one of its handles is moved. Not what is moved: to remove that crashes Blender."""
    if torus() is None or bpy.context.mode != "OBJECT" or not handles():
        return
    handle = handles()[0]
    for obj in bpy.data.objects:
        obj.select_set(obj == handle)
    bpy.context.view_layer.objects.active = handle
    press("G")
    yield from turns(2)
    bpy.data.objects.remove(torus())
    yield from turns(3)
    press("RET")


def change_frame(chance):
    bpy.context.scene.frame_set(chance.randrange(1, 100))


def render(_chance):
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "BLENDER_WORKBENCH", 32, 32
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.ops.render.render()


def begin_run(chance):
    if is_live():
        return  # refused; and see driver.py
    if torus() is not None:
        bpy.context.view_layer.objects.active = torus()
    energy = chance.choice(["WILLMORE", "MVS", "MIX"])
    outcome = chance.choice(["NEW", "NEW", "REPLACE", "SHAPE_KEY"])
    resolution = "SAME" if outcome == "SHAPE_KEY" else chance.choice(["SAME", "REFINE"])
    symmetry = chance.choice(["AUTO", "NONE"])
    animation = outcome != "SHAPE_KEY" and chance.random() < 0.3
    levels = chance.choice([2, 6])
    invoke(energy=energy, outcome=outcome, resolution=resolution, levels=levels, symmetry=symmetry, animation=animation)


def delete_object(_chance):
    if torus() is not None:
        bpy.data.objects.remove(torus())


def delete_mesh(_chance):
    if torus() is not None:
        bpy.data.meshes.remove(torus().data)


def rename(_chance):
    if torus() is not None:
        torus().name = "Renamed"


def change_mode(chance):
    if torus() is not None:  # the active object may be a handle
        bpy.context.view_layer.objects.active = torus()
    bpy.ops.object.mode_set(mode=chance.choice(["EDIT", "SCULPT", "OBJECT"]))


def load(_chance):
    bpy.ops.wm.read_homefile(use_factory_startup=True)


def save(_chance):
    bpy.ops.wm.save_as_mainfile(filepath=str(RESULTS.with_name("campaign.blend")), copy=True)


def press_some_key(chance):
    """Without a run on, G starts Blender's own moving, and Blender 3.4 crashes, with or without us, when an object is
    removed while it is moved in Edit Mode and that is undone: so it is ended at once."""
    press(chance.choice(["X", "TAB", "G", "DEL", "A"]))
    if part("ui.operators")._run is None:
        press("ESC")


def slide(chance):
    if bpy.context.object is not None:
        bpy.context.object.curvopt_amount = chance.random()


def settings(chance):
    bpy.context.scene.curvopt.levels = chance.randrange(1, 5)
    bpy.context.window_manager.curvopt_look = chance.choice(["PLAIN", "ZEBRA", "COLOURS"])


def inspect(chance):
    """On, three times of four, with any settings; the mouse over the middle for the probe."""
    chosen = bpy.context.window_manager.curvopt_inspect
    chosen.kind = chance.choice(["ZEBRA", "ISOPHOTES", "CURVATURE", "DISTANCE", "NOTHING"])
    chosen.combs, chosen.comb_curves = chance.random() < 0.5, chance.choice(["SELECTED", "LOOPS", "ALL", "X"])
    chosen.probe, chosen.in_front = chance.random() < 0.5, chance.random() < 0.5
    chosen.is_on = chance.random() < 0.75
    region = viewport()[1]
    x, y = region.x + region.width // 2, region.y + region.height // 2
    for step in range(3):
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x + step, y=y)


ACTIONS = {
    "start": begin_run,
    "live": begin_live,
    "drag": drag,
    "grab": grab,
    "coincide": coincide,
    "through": drag_through,
    "far": drag_far,
    "delete handle": delete_handle,
    "delete while grabbed": delete_while_grabbed,
    "frame": change_frame,
    "render": render,
    "finish live": lambda _: is_live() and bpy.ops.curvopt.live_finish("INVOKE_DEFAULT"),
    "wait": None,
    "escape": lambda _: press("ESC"),
    "enter": lambda _: press("RET"),
    "undo": lambda _: press("Z", ctrl=True),
    "redo": lambda _: press("Z", ctrl=True, shift=True),
    "script undo": lambda _: bpy.ops.ed.undo(),
    "keys": press_some_key,
    "mode": change_mode,
    "delete object": delete_object,
    "delete mesh": delete_mesh,
    "rename": rename,
    "load": load,
    "save": save,
    "slide": slide,
    "colour": lambda _: bpy.ops.curvopt.curvature(levels=1),
    "settings": settings,
    "inspect": inspect,
}


def sequence(number):
    """The names of its actions."""
    chance = random.Random(number)
    names = [name for name in ACTIONS if name not in ("start", "wait")]
    middle = [chance.choice([*names, "wait", "wait", "start", "start", "drag"]) for _ in range(chance.randrange(3, 9))]
    return [chance.choice(STARTS), "wait", *middle, *(["drag", "finish live"] if number % 3 == 0 else [])]


def play(number):
    chance = random.Random(-number)
    setup()
    undone = False
    for name in sequence(number):
        if name == "wait":
            yield from turns(chance.randrange(1, 8))
            continue
        try:
            steps = ACTIONS[name](chance)
            yield from steps if isinstance(steps, Iterator) else ()
        except (RuntimeError, TypeError) as error:  # an operator that says no, a mode that the active object has not
            if "Traceback" in str(error):
                raise
        yield from turns(2)
        undone = undone or name not in SPARED
    if bpy.context.mode != "OBJECT":
        press("ESC")
        yield from turns(3)
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
    for _ in range(3):  # a first one may end something else, such as moving
        press("ESC")
        yield from turns(3)
    if state().live == "ENDED":  # by itself, as where the object was deleted: the button takes its handles away, no Esc does
        bpy.ops.curvopt.live_cancel()
    bpy.context.window_manager.curvopt_inspect.is_on = False
    yield lambda: part("ui.operators")._run is None and not is_live()
    assert not state().running and not part("ui.display")._at_end
    yield lambda: not [thread for thread in threading.enumerate() if thread.name.startswith("curvopt")]
    assert undone or "keys" in sequence(number) or torus() is not None, "the object was lost"


def everything():
    for number in range(FIRST, LAST + 1):
        log(f"BEGIN {number} {', '.join(sequence(number))}")
        try:
            yield from play(number)
            log(f"PASS {number}")
        except Exception as error:
            traceback.print_exc()
            log(f"FAIL {number} {error!r}")
            if part("ui.operators")._run is not None:
                part("ui.operators")._run.escape()
                yield lambda: part("ui.operators")._run is None
            if is_live():
                bpy.ops.curvopt.live_cancel()
        if number % 10 == 0 or number == LAST:
            setup()
            invoke(energy="MVS", levels=6)
            yield from turns(random.Random(number).randrange(1, 12))
            log(f"QUITTING {number}")
            bpy.ops.wm.quit_blender()
            yield lambda: False  # it quits when the event loop turns


start(everything())

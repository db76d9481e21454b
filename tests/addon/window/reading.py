# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: Inspect, which draws the true surface on the object itself. As drive.py, with lines
in the same file RESULTS. Prints how long the main thread was busy with it at a time."""

import subprocess
import sys
import threading
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from driver import (  # noqa: E402
    RESULTS,
    both_clocks,
    contents,
    log,
    part,
    press,
    run_checks,
    setup,
    start,
    state,
    turns,
    viewport,
    window,
)

CHECKS = []
TIMES = []  # processor seconds of each step of the timer


def check(function):
    """Register a generator function as a check, run in order."""
    CHECKS.append(function)
    return function


def settings():
    return bpy.context.window_manager.curvopt_inspect


def session():
    return part("ui.inspect")._session


def settled():
    """Everything sampled and drawn."""
    on = session()
    return on._shown is not None and on.inspector.is_settled and on.view._drawn is on._shown and not on.is_dirty


def drawn():
    """All of the view drawn once more; a generator."""
    viewport()[1].tag_redraw()
    yield from turns(10)


def switch_on(kind="ZEBRA", **more):
    """On, with the settings of a new session but for these; a generator."""
    chosen = settings()
    for name in chosen.bl_rna.properties.keys():
        chosen.property_unset(name)
    chosen.kind = kind
    for name, value in more.items():
        setattr(chosen, name, value)
    chosen.is_on = True
    step = session().step

    def timed():
        begin = both_clocks()
        step()
        TIMES.append((both_clocks() - begin)[0])

    session().step = timed
    yield settled
    yield from drawn()


def off():
    settings().is_on = False
    if state().live:
        bpy.ops.curvopt.live_cancel()
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    yield from turns(3)


def view_pixels():
    """Grey values of the middle of the 3D view, without its tools and sidebar."""
    path, region = RESULTS.with_name("pixels.gray"), viewport()[1]
    left, top = region.x + 150, 700 - (region.y + region.height) + 100
    crop = f"{region.width - 450}x{region.height - 220}+{left}+{top}"
    subprocess.run(["import", "-window", "root", "-crop", crop, "-depth", "8", f"gray:{path}"], check=True)
    return np.fromfile(path, np.uint8).astype(int)


def look_at_torus(distance=4.0):
    view = viewport()[0].spaces.active.region_3d
    view.view_perspective, view.view_location, view.view_distance = "PERSP", (0, 0, 0), distance
    view.view_rotation = (0.9, 0.4, 0.1, 0.1)
    viewport()[0].spaces.active.overlay.show_cursor = False
    viewport()[0].spaces.active.show_region_ui = False


def begin():
    if state().live:
        bpy.ops.curvopt.live_cancel()
    setup(noise=0.05)
    bpy.data.objects["Torus"].modifiers.new("Subdivision", "SUBSURF").levels = 2
    look_at_torus()
    yield from drawn()


@check
def stripes_are_on_the_object_and_gone_when_it_is_switched_off():
    yield from begin()
    before, scene = view_pixels(), contents()
    yield from switch_on()
    zebra = view_pixels()
    shares = [(picture < 30).mean() for picture in (before, zebra)], [(picture > 200).mean() for picture in (before, zebra)]
    assert all(first < 0.01 and then > 0.03 for first, then in shares), shares
    assert contents() == scene, "it has changed the file"
    yield from off()
    yield from drawn()
    differs = np.abs(view_pixels() - before)
    assert (differs > 8).mean() < 1e-3, f"something is left in the view: {(differs > 0).mean()} of it, by up to {differs.max()}"
    assert not [thread for thread in threading.enumerate() if thread.name == "curvopt reading"]


@check
def zebra_turns_with_the_view_and_isophotes_with_the_light():
    """A camera that turns round its own axis of sight shows the same picture, turned: not looked at here. From the other side
    of a ball zebra stripes are the same, isophotes are not."""
    yield from begin()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        bpy.ops.curvopt.add_shape(shape="sphere_cube", size=0.7)
        bpy.context.object.location = (0, 0, 0)
    view = area.spaces.active.region_3d
    pictures = {}
    for kind in ("ZEBRA", "ISOPHOTES"):
        yield from switch_on(kind, light=(0.3, 0.2, 1.0), width=np.radians(20))
        for name, turn in (("one", (1, 0, 0, 0)), ("other", (0.7071, 0.7071, 0, 0))):
            view.view_rotation = turn
            yield from drawn()
            pictures[kind, name] = view_pixels()
        settings().light = (1, 0, 0)
        yield lambda: not session().is_dirty
        yield from drawn()
        pictures[kind, "light"] = view_pixels()
        yield from off()
    differs = {key: np.mean(np.abs(pictures[key] - pictures[key[0], "other"]) > 60) for key in pictures}
    assert differs["ZEBRA", "light"] > 0.03 and differs["ISOPHOTES", "light"] > 0.03, differs
    assert differs["ISOPHOTES", "one"] > 0.03 and differs["ZEBRA", "one"] > 0.03, differs


@check
def the_probe_reads_what_is_under_the_mouse_and_undo_works_meanwhile():
    yield from begin()
    torus = bpy.data.objects["Torus"]
    yield from switch_on("PLAIN", probe=True, width=0.3)
    region, view = viewport()[1], viewport()[0].spaces.active.region_3d
    points = np.c_[session()._shown.points, np.ones(len(session()._shown.points))]
    clip = points @ np.array(view.perspective_matrix).T
    seen = view.perspective_matrix @ torus.data.vertices[0].co.to_4d()
    seen.x, seen.y, seen.z, seen.w = clip[np.argmin(clip[:, 2] / clip[:, 3])]  # nearest to the eye
    for shift in (0, 2):
        x = region.x + int((1 + seen.x / seen.w) * region.width / 2) + shift
        y = region.y + int((1 + seen.y / seen.w) * region.height / 2)
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
        yield from turns(3)
    yield lambda: session().view._reading is not None
    reading = session().view._reading
    place = view.perspective_matrix @ (torus.matrix_world @ part("ui.inspect").Vector(reading.point)).to_4d()
    where = region.x + (1 + place.x / place.w) * region.width / 2, region.y + (1 + place.y / place.w) * region.height / 2
    assert np.abs(np.array(where) - (x, y)).max() < 1.0, (where, x, y)
    assert np.isfinite((reading.k1, reading.k2, reading.density)).all() and reading.edge.n_faces == 2
    bpy.context.view_layer.objects.active.location.x += 1.0
    bpy.ops.ed.undo_push(message="Moved")
    assert bpy.ops.ed.undo.poll()
    press("Z", ctrl=True)
    yield lambda: bpy.data.objects["Torus"].location.x == 0.0
    yield settled
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=region.x + 200, y=region.y + 30)  # nothing is there
    yield lambda: session().view._reading is None
    yield from off()


@check
def it_follows_a_grab_in_edit_mode_and_its_cancel():
    yield from begin()
    torus = bpy.data.objects["Torus"]
    torus.data.vertices.foreach_set("select", [index == 0 for index in range(32)])
    for parts in (torus.data.edges, torus.data.polygons):
        parts.foreach_set("select", [False] * len(parts))
    yield from switch_on()
    bpy.ops.object.mode_set(mode="EDIT")
    yield settled
    before = session()._shown.subject
    press("G")
    yield from turns(3)
    region, numbers = viewport()[1], set()
    for step in range(1, 20):
        x, y = region.x + region.width // 2 + 5 * step, region.y + region.height // 2 + 3 * step
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
        yield from turns(2)
        numbers.add(session()._shown.subject.number)
    assert len(numbers) >= 3, numbers
    yield settled
    moved = np.abs(session()._shown.subject.cage.positions - before.cage.positions).max(axis=1)
    assert np.flatnonzero(moved > 1e-6).tolist() == [0] and moved[0] > 0.05
    press("ESC")
    yield lambda: settled() and np.abs(session()._shown.subject.cage.positions - before.cage.positions).max() < 1e-6
    yield from off()


@check
def a_cage_of_5000_vertices_is_followed():
    """Prints how long the main thread is busy with it at a time, in Edit Mode, where Blender's mesh is slowest to read."""
    yield from begin()
    setup(100, 50, noise=0.005)
    look_at_torus()
    torus = bpy.data.objects["Torus"]
    for parts, count in ((torus.data.vertices, 1), (torus.data.edges, 0), (torus.data.polygons, 0)):
        parts.foreach_set("select", [index < count for index in range(len(parts))])
    yield from switch_on("CURVATURE")
    uploads, upload = [], session().view._batches_of

    def timed(shown):
        begin = both_clocks()
        batches = upload(shown)
        uploads.append((both_clocks() - begin)[0])
        return batches

    session().view._batches_of = timed
    bpy.ops.object.mode_set(mode="EDIT")
    yield settled
    TIMES.clear()
    first = session()._shown.subject.number
    press("G")
    yield from turns(3)
    region = viewport()[1]
    for step in range(1, 25):
        x, y = region.x + region.width // 2 + 5 * step, region.y + region.height // 2 + 3 * step
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
        yield from turns(2)
    press("RET")
    yield lambda: settled() and session()._shown.subject.number > first + 3
    for name, times in (("looks", TIMES), ("uploads to the GPU", uploads)):
        middle, most = 1000 * np.median([t for t in times if t > 5e-4]), 1000 * max(times)
        print(f"INSPECT, 5000 vertices: {len(times)} {name}, of those with work {middle:.1f} ms (median), {most:.1f} ms at most", flush=True)
    yield from off()


@check
def it_draws_what_live_pulls_in_place_of_the_clay():
    yield from begin()
    torus, chosen = bpy.data.objects["Torus"], (0, 9, 18, 27)
    torus.data.vertices.foreach_set("select", [index in chosen for index in range(32)])
    for parts in (torus.data.edges, torus.data.polygons):
        parts.foreach_set("select", [False] * len(parts))
    bpy.context.scene.curvopt.energy, bpy.context.scene.curvopt.pin = "WILLMORE", "SELECTED"
    yield from turns(3)
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        assert bpy.ops.curvopt.live("INVOKE_DEFAULT", True) == {"FINISHED"}
    live = part("ui.live")
    yield lambda: live._session.live is not None and live._session.live.is_settled
    yield from switch_on()
    picture = live._session.view._picture
    empty = part("scene.handles").empties(torus)[9]
    drawn_before = picture._drawn
    for _ in range(12):
        empty.location.z += 0.04
        number = live._session.live.number
        yield lambda: live._session.live.number > number
    newest = lambda: live._session.live.latest.snapshot  # noqa: E731
    yield lambda: live._session.live.is_settled and settled() and np.abs(session()._shown.subject.cage.positions - newest().cage).max() < 1e-6
    yield from drawn()
    assert picture._drawn is drawn_before, "the clay is drawn as well"
    settings().is_on = False
    yield lambda: picture._drawn is newest()
    bpy.ops.curvopt.live_cancel()
    yield from off()


@check
def objects_that_go_modes_and_files_do_no_harm():
    yield from begin()
    yield from switch_on("CURVATURE", combs=True, comb_curves="ALL", probe=True)
    bpy.ops.object.mode_set(mode="SCULPT")
    yield lambda: "Sculpt Mode" in session().message
    yield from drawn()
    bpy.ops.object.mode_set(mode="OBJECT")
    yield settled
    draws = session().view.draws
    bpy.data.objects["Torus"].hide_set(True)
    yield from drawn()
    count = session().view.draws
    yield from drawn()
    assert session().view.draws == count >= draws, "it is drawn though it is hidden"
    bpy.data.objects["Torus"].hide_set(False)
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    yield lambda: "nothing is active" in session().message
    yield from drawn()
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield from turns(5)
    assert session() is None and not settings().is_on
    assert not [thread for thread in threading.enumerate() if thread.name == "curvopt reading"]


def everything():
    yield from run_checks(CHECKS, off)
    if TIMES:
        low, high = np.percentile(np.array(TIMES) * 1000, [50, 99])
        print(f"INSPECT: {len(TIMES)} looks, {low:.1f} ms (median), {high:.1f} ms (99 %), {1000 * max(TIMES):.1f} ms at most", flush=True)
    log("QUITTING INSPECT")
    bpy.ops.wm.quit_blender()


start(everything())

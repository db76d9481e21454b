# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: how soon the surface follows. Simulated drags of 60 steps a second, a second each,
then rest until the optimum is on the screen. From the moment of a step to the first drawing of a surface that belongs to it
or to a later one, and the same to where that surface was ready, which the drawing without a GPU does not slow down.
Environment: CURVOPT_DRAGS, how many (20); CURVOPT_CASE, which; CURVOPT_BARE, with nothing but a viewport, drawn as cheaply as
Blender can, which is still dearer than with a GPU."""

import importlib
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import driver  # noqa: E402
from driver import both_clocks, log, part, setup, shapes, start, state, turns, viewport  # noqa: E402
from live import call, handles, session  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
DRAGS = int(os.environ.get("CURVOPT_DRAGS", 20))
STEPS, RATE, WAY = 60, 60.0, 0.05  # of a drag; a second; sizes of the cage


def pretzel():
    """48 vertices of genus 2, shaken."""
    lines = [line.split() for line in (ROOT / "blend_files/obj/pretzel_g2.obj").read_text().splitlines() if line]
    points = np.array([line[1:4] for line in lines if line[0] == "v"], float)
    faces = [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines if line[0] == "f"]
    return points + 0.04 * size_of(points) * np.random.default_rng(5).normal(size=points.shape), faces


def suzanne():
    """507 vertices of Blender's monkey."""
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    found = np.array([v.co for v in mesh.vertices]), [list(face.vertices) for face in mesh.polygons]
    bpy.data.objects.remove(bpy.context.object)
    return found


def large():
    """5000 vertices of a shaken torus."""
    points, faces = shapes.torus(100, 50)
    return points + 0.002 * np.random.default_rng(5).normal(size=points.shape), faces


CASES = {
    "48 vertices of genus 2, MVS": (pretzel, "MVS", 1.0, (0, 11, 23, 40)),
    "507 vertices, Willmore, strength 0.3": (suzanne, "WILLMORE", 0.3, (30, 120, 260, 400)),
    "5000 vertices, Willmore, strength 0.3": (large, "WILLMORE", 0.3, (0, 1200, 2500, 3700)),
}


def size_of(points):
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


class Times:
    """What happened when: steps of the hand, targets, drawings, optima, and how long our callbacks took."""

    def __init__(self):
        self.waiting = []  # times of steps that are no targets yet
        self.steps = []  # (time, number of its targets)
        self.aims = []  # the same of targets, which wait for Blender's next turn
        self.ready, self.drawn, self.calls = [], [], []
        self.firsts, self.ends = [], []  # the worker's processor time for a first answer, and for an optimum
        self._begun = 0.0
        live, view = part("core.live").Live, importlib.import_module("curvopt.ui.live_view").LiveView
        self._undo = [
            self._after(live, "aim", self._aimed), self._after(live, "_publish", self._published), self._begin_with(live),
            self._around(view, "_surface", self._shown), self._around(view, "_dots", None),
            self._around(part("ui.live"), "_look", None), self._around(part("ui.live"), "_follow", None),
            self._around(part("ui.panel").CURVOPT_PT_minimize, "draw", None),
        ]  # fmt: skip

    def end(self):
        for undo in self._undo:
            undo()

    def _after(self, owner, name, then):
        function = getattr(owner, name)

        def call(one, *arguments, **named):
            result = function(one, *arguments, **named)
            then(one)
            return result

        setattr(owner, name, call)
        return lambda: setattr(owner, name, function)

    def _around(self, owner, name, then):
        function = getattr(owner, name)

        def timed(*arguments):
            begin = both_clocks()
            try:
                return function(*arguments)
            finally:
                self.calls.append(both_clocks() - begin)
                if then is not None:
                    then(*arguments)

        wrapped = {0: lambda: timed(), 1: lambda a: timed(a), 2: lambda a, b: timed(a, b)}[function.__code__.co_argcount]
        setattr(owner, name, wrapped)
        return lambda: setattr(owner, name, function)

    def _aimed(self, live):
        self.steps += [(at, live.number) for at in self.waiting]
        self.aims += [(time.monotonic(), live.number)] if self.waiting else []
        self.waiting = []

    def _begin_with(self, owner):
        solve = owner._solve

        def timed(*arguments, **named):
            self._begun = time.thread_time()
            return solve(*arguments, **named)

        owner._solve = timed
        return lambda: setattr(owner, "_solve", solve)

    def _published(self, live):
        view, took = live.latest, 1e3 * (time.thread_time() - self._begun)
        if view.is_first:
            self.firsts.append(took)
        elif view.summary is not None and not (self.ready and self.ready[-1][1:] == (view.number, True)):
            self.ends.append(took)
        self.ready.append((view.time, view.number, view.summary is not None))

    def _shown(self, view):
        shown = view.live.latest if view.live is not None else None
        if shown is not None:
            self.drawn.append((time.monotonic(), shown.number, shown.summary is not None))

    def delays(self, events, since=None):
        """Milliseconds (s,) from each step, or other moment, to the first of events (time, number, ...) that belongs to it."""
        found = []
        for at, number in since or self.steps:
            after = [event[0] for event in events if event[1] >= number and event[0] >= at]
            found += [1e3 * (min(after) - at)] if after else []
        return np.array(found)

    def rests(self, events, lasts):
        """Milliseconds from the last step of each drag to the optimum."""
        numbers = dict(self.steps)
        return np.array([
            1e3 * (min(event[0] for event in events if event[2] and event[1] >= numbers[at]) - at) for at in lasts
        ])  # fmt: skip


def words(values):
    return f"{np.median(values):.0f} / {np.percentile(values, 95):.0f}"


def drag(handle, way, times):
    """STEPS steps at the rate of a hand; the time of the last one."""
    begin, place, steps = time.monotonic(), handle.location.copy(), []

    def step():
        steps.append(time.monotonic())
        part_of = min(1.0, (steps[-1] - begin) * RATE / STEPS)
        handle.location = [a + part_of * b for a, b in zip(place, way)]
        times.waiting.append(steps[-1])
        return None if part_of == 1.0 else 1 / RATE

    bpy.app.timers.register(step)
    yield lambda: (steps[-1:] or [0])[0] - begin >= STEPS / RATE
    return steps[-1]


def bare():
    """A viewport alone, without what takes long where there is no GPU: overlays (but for ours) and anti-aliasing."""
    bpy.context.preferences.system.viewport_aa = "OFF"
    viewport()[0].spaces.active.overlay.show_overlays = False
    with bpy.context.temp_override(area=viewport()[0]):
        bpy.ops.screen.screen_full_area(use_hide_panels=True)


def turns_of_blender():
    """Milliseconds (n,) between drawings while something moves and nothing of ours is on."""
    drawn, begin, torus = [], time.monotonic(), bpy.data.objects["Torus"]

    def move():
        torus.location.x = 0.1 * np.sin(5 * time.monotonic())
        return 1 / RATE if time.monotonic() < begin + 3 else None

    handle = bpy.types.SpaceView3D.draw_handler_add(lambda: drawn.append(time.monotonic()), (), "WINDOW", "POST_VIEW")
    bpy.app.timers.register(move)
    yield lambda: time.monotonic() > begin + 3.2
    bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    return 1e3 * np.diff(drawn)


def measure(name):
    make, energy, strength, pins = CASES[name]
    setup()
    if os.environ.get("CURVOPT_BARE"):
        bare()
    points, faces = make()
    bpy.context.view_layer.objects.active = bpy.data.objects["Torus"]
    mesh = bpy.data.objects["Torus"].data
    mesh.clear_geometry()
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.vertices.foreach_set("select", np.isin(np.arange(len(points)), pins))
    own = yield from turns_of_blender()
    settings = bpy.context.scene.curvopt
    settings.energy, settings.strength, settings.pin, settings.symmetry = energy, strength, "SELECTED", "NONE"
    settings.resolution = "SAME"
    times, random, lasts = Times(), np.random.default_rng(1), []
    assert call(bpy.ops.curvopt.live) == {"FINISHED"}
    yield lambda: session().live is not None and session().live.is_settled and times.drawn
    times.calls.clear()
    minima, begin = 0, both_clocks()
    for _ in range(DRAGS):
        handle = handles()[int(random.choice(pins))]
        before = handle.location.copy()
        way = WAY * size_of(points) * random.normal(size=3)
        lasts.append((yield from drag(handle, way, times)))
        yield lambda: not times.waiting and session().live.is_settled and times.drawn[-1][2] and (
            times.drawn[-1][1] == session().live.number)  # fmt: skip
        minima += session().live.latest.summary.verification.verdict == "minimum"
        handle.location = before
        times.waiting = []
        yield from turns(2)
        yield lambda: session().live.is_settled
    took = both_clocks() - begin
    times.end()
    calls = 1e3 * np.array(times.calls)
    log(f"{name}: {DRAGS} drags, {len(times.steps)} steps, {minima} minima; load {os.getloadavg()[0]:.1f}; "
        f"a turn of Blender's own {words(own)} ms")  # fmt: skip
    log(f"  a step to its surface, ms, median / 95 %: ready {words(times.delays(times.ready))}, "
        f"drawn {words(times.delays(times.drawn))}; from the worker's targets on: ready {words(times.delays(times.ready, times.aims))}")
    log(f"  the last step to the optimum: ready {words(times.rests(times.ready, lasts))}, "
        f"drawn {words(times.rests(times.drawn, lasts))}")  # fmt: skip
    log(f"  the worker's processor time: first answer with its picture {words(times.firsts)}, optimum {words(times.ends)}")
    log(f"  our calls on the main thread, ms, [processor, clock]: median {np.median(calls, axis=0).round(2)}, "
        f"99 % {np.percentile(calls, 99, axis=0).round(2)}, share {(calls.sum(axis=0) / took / 1e3).round(3)}")  # fmt: skip
    bpy.ops.curvopt.live_cancel()
    yield lambda: state().live == ""


def everything():
    try:
        yield from measure(list(CASES)[int(os.environ["CURVOPT_CASE"])])
    except Exception as error:
        traceback.print_exc()
        log(f"FAIL {error!r}")
    bpy.ops.wm.quit_blender()


if __name__ == "__main__":
    driver.PATIENCE = 300.0
    start(everything())

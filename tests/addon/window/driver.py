# SPDX-License-Identifier: GPL-3.0-or-later
"""Driving a Blender with a real window from inside: events, clicks, screenshots, and generators that wait on conditions
and never for fixed times. For drive.py, campaign.py and pictures.py.

While a run is on, no operator is called under `temp_override`. Operators run without Python's lock, and Blender reads the
override's dictionary (BPY_context_member_get) without it, too, whenever any thread holds it: PyC_IsInterpreterActive asks
whether there is a current thread state, which before Python 3.12 is that of whichever thread. The thread's memory is damaged,
and Blender crashes at times, there or later; so does Blender 3.4 without the add-on, beside a thread that makes strings."""

import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import addon_utils
import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import shapes  # noqa: E402

RESULTS = Path(os.environ["CURVOPT_WINDOW_RESULTS"])
PATIENCE = 300.0  # seconds for any one condition; at load 10 they take five to ten times as long


def window():
    return bpy.context.window_manager.windows[0]


def viewport():
    """(area, its main region) of the 3D view."""
    area = next(area for area in window().screen.areas if area.type == "VIEW_3D")
    return area, next(region for region in area.regions if region.type == "WINDOW")


def invoke(**arguments):
    """Start the operator as a button would."""
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        return bpy.ops.curvopt.minimize("INVOKE_DEFAULT", **arguments)


def press(key, **modifiers):
    """A key over the middle of the viewport."""
    _, region = viewport()
    x, y = region.x + region.width // 2, region.y + region.height // 2
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=x, y=y, **modifiers)


def click(x, y):
    """The left button at window coordinates; a generator, for the mouse has to arrive before it is pressed."""
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    yield from turns(2)
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type="LEFTMOUSE", value=value, x=x, y=y)
    yield from turns(2)


def turns(count):
    """Let Blender's event loop turn `count` times."""
    for _ in range(count):
        yield lambda: True


def open_sidebar_tab():
    """Click down the tabs at the sidebar's right edge until our panel is drawn."""
    panel, drawn = bpy.types.CURVOPT_PT_minimize, []
    draw = panel.draw

    def noticed(self, context):
        drawn.append(True)
        draw(self, context)

    panel.draw = noticed
    region = next(region for region in viewport()[0].regions if region.type == "UI")
    yield lambda: region.width > 50
    for y in range(region.height - 40, 40, -25):
        yield from click(region.x + region.width - 9, region.y + y)
        if drawn:
            break
    panel.draw = draw
    assert drawn, "the tab was not found"


def subpanels(shown):
    """Show those below the main panel, or take them away, so that from below there are labels only."""
    panel = part("ui.panel")
    for cls in panel._CLASSES[1:]:
        if cls.is_registered != shown:
            (bpy.utils.register_class if shown else bpy.utils.unregister_class)(cls)


def click_up_the_panel(until):
    """Click in the middle of the sidebar, from below upwards, until something has happened."""
    region = next(region for region in viewport()[0].regions if region.type == "UI")
    for y in range(10, region.height, 20):
        yield from click(region.x + region.width // 4, region.y + y)
        yield from turns(4)  # on a busy machine a click may need them; a second one would hit another button
        if until():
            return
    raise AssertionError("there is no such button")


def part(name):
    return sys.modules[f"curvopt.{name}"]


def state():
    return part("ui.properties").state


def contents():
    """Everything that the checks compare."""
    return {
        obj.name: ([tuple(v.co) for v in obj.data.vertices], tuple(obj.location), obj.select_get(), obj.visible_get())
        for obj in bpy.context.scene.objects
    }


def screenshot(name):
    """A picture of the whole screen; fails if it is black."""
    path = RESULTS.with_name(f"{name}.png")
    subprocess.run(["import", "-window", "root", str(path)], check=True)
    mean = subprocess.run(["identify", "-format", "%[fx:mean]", str(path)], check=True, capture_output=True, text=True)
    assert float(mean.stdout) > 0.02, f"{path.name} is black"


def both_clocks():
    """Processor time of this thread and time on the clock. On a busy machine only the first one says how long a call
    is; the second one then counts other programs, too."""
    return np.array([time.thread_time(), time.perf_counter()])


def without_waiting():
    """As both_clocks, but the clock stands still while this thread waits for a processor: what it waits for otherwise, such
    as a lock or the screen, counts. Linux says so in schedstat, second number, in nanoseconds; kernels without it do not."""
    thread, clock = both_clocks()
    schedule = Path("/proc/thread-self/schedstat")
    return np.array([thread, clock - int(schedule.read_text().split()[1]) / 1e9 if schedule.exists() else clock])


def setup(around=8, across=4, noise=0.0):
    """A file with a torus alone, active, nothing pinned, the settings those of minimizers, and the sidebar open;
    `noise` takes its symmetries away."""
    settings = bpy.context.scene.curvopt
    settings.pin, settings.strength, settings.resolution, settings.outcome = "NOTHING", 1.0, "REFINE", "NEW"  # not what was left
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    points, faces = shapes.torus(around, across)
    points = points + noise * np.random.default_rng(1).normal(size=points.shape)
    mesh = bpy.data.meshes.new("Torus")
    mesh.from_pydata([tuple(p) for p in points], [], faces)
    torus = bpy.data.objects.new("Torus", mesh)
    bpy.context.scene.collection.objects.link(torus)
    bpy.context.view_layer.objects.active = torus
    torus.select_set(True)
    viewport()[0].spaces.active.show_region_ui = True
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="Torus")


class Driver:
    """Advances a generator whenever its condition holds; a condition that never does becomes its exception."""

    def __init__(self, steps):
        self.steps, self.condition, self.deadline = steps, lambda: True, time.monotonic() + PATIENCE

    def __call__(self):
        try:
            if self.condition():
                self.condition = next(self.steps)
            elif time.monotonic() > self.deadline:
                self.condition = self.steps.throw(TimeoutError("the awaited condition never came true"))
            else:
                return 0.05
        except StopIteration:
            return None
        except BaseException:
            traceback.print_exc()
            os._exit(1)  # the results so far are on disk; what is missing counts as failed
        self.deadline = time.monotonic() + PATIENCE
        return 0.05


def start(steps):
    """Switch the add-on on and run the generator."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.system.viewport_aa = "OFF"
    assert addon_utils.enable("curvopt", default_set=True) is not None
    bpy.app.timers.register(Driver(steps), first_interval=1.0, persistent=True)


def run_checks(checks, give_up):
    """All checks one after the other, each to its end or failure; after a failure `give_up` ends what is on. Generators."""
    for function in checks:
        try:
            yield from function()
            line = f"PASS {function.__name__}"
        except Exception as error:
            traceback.print_exc()
            line = f"FAIL {function.__name__}: {error!r}"
            yield from give_up()
        log(line)


def log(line):
    """One more line of the results."""
    with RESULTS.open("a") as results:
        results.write(line + "\n")
    print(line, flush=True)

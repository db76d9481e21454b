# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: drives the modal operator by simulated events.

One generator, advanced by a timer, waits on conditions and never for fixed times. Every check appends "PASS name" or
"FAIL name: why" to the file RESULTS; screenshots go beside it. The last act quits Blender while a run is on.
"""

import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import shapes  # noqa: E402

RESULTS = Path(os.environ["CURVOPT_WINDOW_RESULTS"])
PATIENCE = 60.0  # seconds for any one condition
CHECKS = []


def check(function):
    """Register a generator function as a check, run in order."""
    CHECKS.append(function)
    return function


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
    panel = part("panel")
    for cls in panel._CLASSES[1:]:
        if cls.is_registered != shown:
            (bpy.utils.register_class if shown else bpy.utils.unregister_class)(cls)


def click_up_the_panel(until):
    """Click in the middle of the sidebar, from below upwards, until something has happened."""
    region = next(region for region in viewport()[0].regions if region.type == "UI")
    for y in range(10, region.height, 10):
        yield from click(region.x + region.width // 4, region.y + y)
        if until():
            return
    raise AssertionError("there is no such button")


def part(name):
    return sys.modules[f"curvopt.{name}"]


def state():
    return part("properties").state


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


def setup():
    """A file with the torus alone, active, and the sidebar open on our tab."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    points, faces = shapes.torus()
    mesh = bpy.data.meshes.new("Torus")
    mesh.from_pydata([tuple(p) for p in points], [], faces)
    torus = bpy.data.objects.new("Torus", mesh)
    bpy.context.scene.collection.objects.link(torus)
    bpy.context.view_layer.objects.active = torus
    torus.select_set(True)
    viewport()[0].spaces.active.show_region_ui = True
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="Torus")


@check
def run_to_its_end():
    setup()
    before = contents()
    assert invoke(energy="WILLMORE", levels=2) == {"RUNNING_MODAL"}
    assert state().running and state().message.startswith("Minimizing Willmore")
    yield lambda: not state().running
    after = contents()
    assert after.pop("Torus Willmore")[2] and bpy.context.view_layer.objects.active.name == "Torus Willmore"
    assert after["Torus"][:2] == before["Torus"][:2] and set(after) == {"Torus"}
    assert state().message.startswith("Willmore ") and not state().failed
    yield lambda: True
    screenshot("finished")


@check
def undo_takes_one_step_and_redo_brings_it_back():
    before = contents()["Torus"][:2]
    press("Z", ctrl=True)
    yield lambda: "Torus Willmore" not in bpy.data.objects
    assert set(contents()) == {"Torus"} and contents()["Torus"][:2] == before
    assert bpy.context.view_layer.objects.active.name == "Torus" and contents()["Torus"][2]
    press("Z", ctrl=True, shift=True)
    yield lambda: "Torus Willmore" in bpy.data.objects


@check
def the_button_in_the_sidebar_starts_a_run():
    setup()
    bpy.context.scene.curvopt.energy, bpy.context.scene.curvopt.levels = "WILLMORE", 2
    yield from open_sidebar_tab()
    subpanels(False)
    yield from turns(6)
    before = contents()["Torus"][:2]
    yield from click_up_the_panel(lambda: state().running or "Torus Willmore" in bpy.data.objects)
    subpanels(True)
    yield lambda: not state().running
    assert set(contents()) == {"Torus", "Torus Willmore"}
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=300, y=300)
    yield from turns(6)
    screenshot("panel")
    press("Z", ctrl=True)
    yield lambda: "Torus Willmore" not in bpy.data.objects
    assert set(contents()) == {"Torus"} and contents()["Torus"][:2] == before


@check
def the_button_minds_the_vertex_group_that_the_sidebar_shows():
    setup()
    torus, settings = bpy.data.objects["Torus"], bpy.context.scene.curvopt
    torus.vertex_groups.new(name="Pins").add([0, 16], 1.0, "REPLACE")
    settings.energy, settings.levels, settings.keep, settings.vertex_group = "WILLMORE", 1, "GROUP", "Pins"
    subpanels(False)
    yield from turns(6)
    yield from click_up_the_panel(lambda: state().running or "Torus Willmore" in bpy.data.objects)
    subpanels(True)
    yield lambda: not state().running
    yield from turns(6)
    screenshot("pins")
    pairs = zip(bpy.data.objects["Torus"].data.vertices, bpy.data.objects["Torus Willmore"].data.vertices)
    assert [v.index for v, w in pairs if v.co == w.co] == [0, 16]
    bpy.context.scene.curvopt.keep = "NOTHING"


@check
def escape_cancels_with_nothing_changed():
    setup()
    before = contents(), len(bpy.data.meshes)
    assert invoke(energy="MVS", levels=6) == {"RUNNING_MODAL"}
    yield lambda: "iteration" in state().message
    screenshot("running")
    start = time.monotonic()
    press("ESC")
    yield lambda: not state().running
    print(f"cancelled {time.monotonic() - start:.2f} s after ESC", flush=True)
    assert (contents(), len(bpy.data.meshes)) == before
    assert "cancelled, nothing was changed" in state().message and not state().failed
    assert part("operators")._run is None
    yield lambda: True
    screenshot("cancelled")


def snapshots():
    """The worker's pictures of the run that is on."""
    return part("operators")._run.job.watcher


@check
def enter_keeps_the_best_so_far():
    setup()
    meshes = len(bpy.data.meshes)
    assert invoke(energy="MVS", levels=6, symmetry="NONE") == {"RUNNING_MODAL"}
    first = snapshots().latest
    yield lambda: snapshots().latest is not first and snapshots().latest.progress is not None
    assert set(contents()) == {"Torus"} and len(bpy.data.meshes) == meshes  # the preview is no data
    yield from turns(4)
    screenshot("preview")
    press("RET")
    yield lambda: not state().running
    result = bpy.data.objects["Torus MVS"]
    assert result["curvopt_stop"] == "cancelled" and "stopped early" in result["curvopt_verdict"]
    assert result["curvopt_after_mvs"] < result["curvopt_before_mvs"]
    assert not part("operators")._on_screen
    yield from turns(4)
    screenshot("kept")


@check
def the_keep_button_is_within_reach_during_a_run():
    setup()
    subpanels(False)
    assert invoke(energy="MVS", levels=6, symmetry="NONE") == {"RUNNING_MODAL"}
    run = part("operators")._run
    yield lambda: run.job.latest is not None
    yield from turns(4)
    yield from click_up_the_panel(lambda: run.phase.name != "RUNNING")
    subpanels(True)
    yield lambda: not state().running
    assert run.phase.name == "FINISHED" and "Torus MVS" in bpy.data.objects


@check
def keys_do_not_reach_the_scene_during_a_run():
    setup()
    assert invoke(energy="MVS", levels=6) == {"RUNNING_MODAL"}
    yield lambda: "iteration" in state().message
    before = contents()
    for key in ("X", "TAB", "DEL", "G"):
        press(key)
    seen = state().message
    yield lambda: state().message != seen
    assert contents() == before and bpy.context.mode == "OBJECT" and state().running
    press("ESC")
    yield lambda: not state().running


@check
def only_one_run_at_a_time():
    setup()
    assert invoke(energy="MVS", levels=6) == {"RUNNING_MODAL"}
    try:
        invoke(energy="MVS", levels=1)
        raise AssertionError("a second run was started")
    except RuntimeError as error:
        assert "poll" in str(error), error
    press("ESC")
    yield lambda: not state().running
    assert set(contents()) == {"Torus"}


@check
def refusal_is_reported_and_nothing_changes():
    setup()
    bpy.context.object.modifiers.new("Mirror", "MIRROR")
    before = contents()
    try:
        invoke(energy="MVS", levels=1)
        raise AssertionError("the modifier was accepted")
    except RuntimeError as error:
        assert "Modifier 'Mirror' of object 'Torus'" in str(error), error
    assert contents() == before and state().failed
    yield lambda: True
    screenshot("refused")


@check
def loading_a_file_during_a_run_ends_it():
    setup()
    assert invoke(energy="MVS", levels=6) == {"RUNNING_MODAL"}
    yield lambda: "iteration" in state().message
    job = part("operators")._run.job
    with bpy.context.temp_override(window=window()):
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield lambda: not state().running
    assert not job.running and part("operators")._run is None
    assert "Torus MVS" not in bpy.data.objects
    setup()
    assert invoke(energy="WILLMORE", levels=1) == {"RUNNING_MODAL"}
    yield lambda: "Torus Willmore" in bpy.data.objects


def everything():
    """All checks one after the other, each to its end or failure; then quit in the middle of a run."""
    for function in CHECKS:
        try:
            yield from function()
            line = f"PASS {function.__name__}"
        except Exception as error:
            traceback.print_exc()
            line = f"FAIL {function.__name__}: {error!r}"
            if part("operators")._run is not None:
                press("ESC")
                yield lambda: part("operators")._run is None
        with RESULTS.open("a") as results:
            results.write(line + "\n")
        print(line, flush=True)
    setup()
    assert invoke(energy="MVS", levels=6) == {"RUNNING_MODAL"}
    yield lambda: "iteration" in state().message
    with RESULTS.open("a") as results:
        results.write("QUITTING\n")
    with bpy.context.temp_override(window=window()):
        bpy.ops.wm.quit_blender()


class Driver:
    """Advances the generator whenever its condition holds; a condition that never does becomes its exception."""

    def __init__(self):
        self.steps, self.condition, self.deadline = everything(), lambda: True, time.monotonic() + PATIENCE

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


preferences = bpy.context.preferences
preferences.view.show_splash = False
preferences.system.viewport_aa = "OFF"
assert addon_utils.enable("curvopt", default_set=True) is not None
bpy.app.timers.register(Driver(), first_interval=1.0, persistent=True)

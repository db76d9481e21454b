# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator `curvopt.minimize`: modal from the user interface, synchronous (`execute`) from scripts; and the buttons
that end it.

Thin: read_cage.py reads, job.py runs, display.py shows, adjust.py writes; in Edit Mode read_edit.py and adjust_edit.py.
Between invoke and the end the operator holds arrays only, no Blender data. Every way out passes through `_end`.

Undo and the adjust-last-operation panel belong to the operators of adjust.py and adjust_edit.py, with which every run
ends. `UNDO` in the options of this one would hide that: Blender lets no operator register while one with `UNDO` runs.
"""

from __future__ import annotations

import time
from dataclasses import replace

import bpy

from ..binding.values import Held
from ..core import job, messages
from ..core.go_through import Places
from ..scene import placement, read_cage, read_edit, read_marks, read_targets
from . import adjust, adjust_edit, display, properties
from .reports import report_failure

_TICK = 0.05  # seconds between looks at the worker
_LAST_WAIT = 5.0  # seconds that quitting or disabling the add-on waits for workers
_MOST_LEAVING = 2  # workers of cancelled runs that may still be busy when a new run starts

# During a run these events go on to Blender, so that the user can look around. All others could change the scene.
_LOOKING_AROUND = {"MIDDLEMOUSE", "MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "NDOF_MOTION"}
_LOOKING_AROUND |= {"TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM", "WINDOW_DEACTIVATE"}

_run: job.ModalRun | None = None  # the modal run that is on; there is one at a time
_leaving: list[job.Job] = []  # cancelled, and not yet at the end of their last step


class CURVOPT_OT_minimize(properties.RunSettings, bpy.types.Operator):
    """Make the surface of the active mesh fairer, as far as Strength lets it go; 1 is the surface of least energy. In \
Edit Mode the selected vertices move, and all others stay"""

    bl_idname = "curvopt.minimize"
    bl_label = "Minimize Curvature"
    bl_options = set()

    _source: read_cage.Source | None = None  # what is optimized, once it was read
    _places = Places()  # that the surface goes through
    _edit: read_edit.Edit | None = None  # the same in Edit Mode, with what of it moves

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if _run is not None or properties.state.live:
            cls.poll_message_set("A run is on already" if _run is not None else "Live is on: finish or cancel it first")
        return _run is None and not properties.state.live

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The whole run at once. A refusal or failure raises RuntimeError in scripts, as operator errors do."""
        try:
            self._read(context)
            return self._write(context, job.solve(self._source.cage, self._request))
        except Exception as error:
            return self._fail(context, error)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start the worker and return to the user."""
        global _run
        try:
            self._read(context)
            _leaving[:] = [old for old in _leaving if old.running]
            if len(_leaving) >= _MOST_LEAVING:
                raise read_cage.CageError("Earlier runs are still at the end of their last step: wait a few seconds.")
            work = job.Job.minimize(self._source.cage, self._request)
            _run = job.ModalRun(work, self._request.label)
            self._show_run(context)
        except Exception as error:
            if _run is not None:
                _run.escape()
                self._end(context)
            return self._fail(context, error)
        return {"RUNNING_MODAL"}

    def _show_run(self, context: bpy.types.Context) -> None:
        """Preview, timer, message; from here on Blender calls `modal`."""
        in_place = self._edit is not None or self._request.goes_through
        display.start_preview(context, self._source, _run, in_place)
        manager = context.window_manager
        timer = manager.event_timer_add(_TICK, window=context.window)
        display.at_end(lambda: manager.event_timer_remove(timer))
        display.show(context, messages.status_text(_run), running=True)
        manager.modal_handler_add(self)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """One event: Esc and Enter end the run, the timer looks at it, and what could change the scene is held back."""
        ours = event.type in ("ESC", "RET", "NUMPAD_ENTER") and event.value == "PRESS"
        if ours:
            (_run.escape if event.type == "ESC" else _run.finish)()
        elif event.type != "TIMER":
            harmless = event.type in _LOOKING_AROUND or _over_sidebar(context, event)
            return {"PASS_THROUGH"} if harmless else {"RUNNING_MODAL"}
        try:
            if not _run.tick().ended:
                display.show(context, messages.status_text(_run), running=True)
                display.refresh(context, _run)
                return {"RUNNING_MODAL"} if ours else {"PASS_THROUGH"}
        except Exception as error:  # showing it went wrong: without this the run would never end
            _run.escape()
            self._end(context)
            return self._fail(context, error)
        return self._end(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: it quits, loads a file, closes the window."""
        _run.abandon(_LAST_WAIT)
        self._end(context)

    def _end(self, context: bpy.types.Context) -> set[str]:
        """Write the result, say what failed, or say that nothing was changed."""
        global _run
        run, _run = _run, None
        display.clear()
        if run.job.running:
            _leaving.append(run.job)
        try:
            if run.phase is job.Phase.FINISHED and run.job.solution.is_empty:
                display.show(context, messages.nothing_found_text(run.label))
                return {"CANCELLED"}
            if run.phase is job.Phase.FINISHED:
                return self._write(context, run.job.solution)
            if run.phase is job.Phase.FAILED:
                return self._fail(context, run.job.error)
        except Exception as error:
            return self._fail(context, error)
        display.show(context, f"Minimizing {run.label} was cancelled, nothing was changed.")
        return {"CANCELLED"}

    def _read(self, context: bpy.types.Context) -> None:
        """The active object, and the settings of the scene unless the call gives its own."""
        given = self.properties.is_property_set
        values = {
            name: getattr(self if given(name) else context.scene.curvopt, name) for name in properties.SETTINGS
        }
        obj = context.view_layer.objects.active
        if obj is not None and obj.mode == "EDIT":
            self._read_edit(context, obj, values)
            return
        self._outcome = values["outcome"]
        self._source = read_cage.read_source(context, obj, with_keys=self._outcome == "SHAPE_KEY")
        held = read_cage.read_held(obj, values["pin"], values["vertex_group"], values["pin_surface"])
        request, cage = self._source.fitted(properties.request_of(values, held)), self._source.cage
        marks = read_marks.read_marks(obj.data, self._source)
        weight = properties.strength_of(values["through_weight"])
        wanted = values["through"], values["through_normals"], values["through_balls"]
        self._places = read_targets.read_targets(context, *wanted, self._source, weight)
        request = job.with_marks(cage, request, *marks)
        request = replace(request, through=self._places.entries(cage), chains=self._places.chains)
        self._request = job.freed(cage, request)
        placement.check_outcome(self._outcome, self._request, obj)

    def _read_edit(self, context: bpy.types.Context, obj: bpy.types.Object, values: dict[str, object]) -> None:
        """The selection. The vertices stay the same, and the result goes into the mesh that is edited."""
        self._edit, self._rim = read_edit.read_edit(context, obj), values["rim"].lower()
        self._source = self._edit.source
        self._base = properties.request_of({**values, "resolution": "SAME"}, Held())
        self._request = self._edit.request(self._base, self._rim)

    def _write(self, context: bpy.types.Context, solution: job.Solution) -> set[str]:
        if self._edit is not None:
            text = adjust_edit.apply(self._edit, self._base, self._rim, self._request, solution)
            warns = solution.exceptions.n_held or messages.volume_text(self._request, solution)
            self.report({"WARNING" if warns else "INFO"}, text)
            return {"FINISHED"}
        remark, warns = adjust.apply(self._source, self._request, solution, self._outcome, self._places.remark)
        self.report({"WARNING" if warns else "INFO"}, messages.solution_text(self._request, solution, remark))
        return {"FINISHED"}

    def _fail(self, context: bpy.types.Context, error: BaseException) -> set[str]:
        if self._source is not None:
            error = self._places.named(self._source.named(error), self._source.cage)
        display.show(context, messages.failure_text(error), failed=True)
        return report_failure(self, error)


class _EndButton:
    """A button of a run that is on."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _run is not None


class CURVOPT_OT_finish(_EndButton, bpy.types.Operator):
    """End the run now; the result is the best surface so far (Enter)"""

    bl_idname = "curvopt.finish"
    bl_label = "Finish"

    def execute(self, context: bpy.types.Context) -> set[str]:
        _run.finish()
        return {"FINISHED"}


class CURVOPT_OT_cancel(_EndButton, bpy.types.Operator):
    """End the run now and change nothing (Esc)"""

    bl_idname = "curvopt.cancel"
    bl_label = "Cancel"

    def execute(self, context: bpy.types.Context) -> set[str]:
        _run.escape()
        return {"FINISHED"}


def _over_sidebar(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether a mouse button is for a sidebar, where Finish and Cancel are."""
    if event.type != "LEFTMOUSE":
        return False
    for area in context.screen.areas:
        if area.type == "VIEW_3D":
            for region in area.regions:
                x, y = event.mouse_x - region.x, event.mouse_y - region.y
                if region.type == "UI" and 0 <= x < region.width and 0 <= y < region.height:
                    return True
    return False


_CLASSES = (CURVOPT_OT_minimize, CURVOPT_OT_finish, CURVOPT_OT_cancel)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Quitting Blender comes here, too: workers end first, as far as they do in time."""
    global _run
    deadline = time.monotonic() + _LAST_WAIT
    if _run is not None:
        _run.abandon(_LAST_WAIT)
        display.clear()
        _run = None
    for old in _leaving:
        old.join(max(0.0, deadline - time.monotonic()))
    _leaving.clear()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

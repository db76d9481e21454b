# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator `curvopt.minimize`: modal from the user interface, synchronous (`execute`) from scripts; and the buttons
that end it.

Thin: reading is cage.py's, running job.py's, showing preview.py's, writing outcome.py's. Between invoke and the end it
holds arrays only, no Blender data; one place, `_end`, is passed on every way out.

What is undone, and adjusted by the adjust-last-operation panel, is apply.py's operator, which both ways end with. An
`UNDO` of this one's would hide that: Blender lets no operator register while one with `UNDO` runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import bpy

from . import apply, cage, job, outcome, properties, result
from .header import SURFACES
from .values import Held

_TICK = 0.05  # seconds between looks at the worker
_REDRAW = 0.15  # seconds, at least, between drawings of a run
_LAST_WAIT = 5.0  # seconds that quitting or disabling the add-on waits for workers
_MOST_LEAVING = 2  # workers of cancelled runs that may still be busy when a new run starts

# While a run is on, these events go on to Blender, so that one can look around; all others could change the scene.
_LOOKING_AROUND = {"MIDDLEMOUSE", "MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "NDOF_MOTION"}
_LOOKING_AROUND |= {"TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM", "WINDOW_DEACTIVATE"}

_run: job.ModalRun | None = None  # the modal run that is on; there is one at a time
_leaving: list[job.Job] = []  # cancelled, and not yet at the end of their last step
_refreshed: tuple[object, object, float] = (None, None, 0.0)  # progress and picture that were drawn, and when
_on_screen: list[Callable[[], object]] = []  # what takes away the timer and the drawing of the run


class CURVOPT_OT_minimize(properties.RunSettings, bpy.types.Operator):
    """Find the surface of least energy, starting from the active mesh's cage"""

    bl_idname = "curvopt.minimize"
    bl_label = "Minimize Curvature"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if _run is not None:
            cls.poll_message_set("A run is on already")
        return _run is None

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
                raise cage.CageError("Earlier runs are still at the end of their last step: wait a few seconds.")
            work = job.Job.minimize(self._source.cage, self._request)
            _run = job.ModalRun(work, self._request.label)
        except Exception as error:
            return self._fail(context, error)
        _start_preview(context, self._source, _run)
        manager = context.window_manager
        timer = manager.event_timer_add(_TICK, window=context.window)
        _on_screen.append(lambda: manager.event_timer_remove(timer))
        manager.modal_handler_add(self)
        _show(context, _run.status, running=True)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        ours = event.type in ("ESC", "RET", "NUMPAD_ENTER") and event.value == "PRESS"
        if ours:
            (_run.escape if event.type == "ESC" else _run.keep)()
        elif event.type != "TIMER":
            harmless = event.type in _LOOKING_AROUND or _over_sidebar(context, event)
            return {"PASS_THROUGH"} if harmless else {"RUNNING_MODAL"}
        try:
            if not _run.tick().ended:
                _show(context, _run.status, running=True)
                _refresh(context, _run)
                return {"RUNNING_MODAL"} if ours else {"PASS_THROUGH"}
        except Exception:  # showing it went wrong: without this the run would never end
            _run.escape()
            self._end(context)
            raise
        return self._end(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: it quits, loads a file, closes the window."""
        _run.abandon(_LAST_WAIT)
        self._end(context)

    def _end(self, context: bpy.types.Context) -> set[str]:
        global _run
        run, _run = _run, None
        _clear_screen()
        if run.job.running:
            _leaving.append(run.job)
        try:
            if run.phase is job.Phase.FINISHED:
                return self._write(context, run.job.solution)
            if run.phase is job.Phase.FAILED:
                return self._fail(context, run.job.error)
        except Exception as error:
            return self._fail(context, error)
        _show(context, f"Minimizing {run.label} was cancelled, nothing was changed.")
        return {"CANCELLED"}

    def _read(self, context: bpy.types.Context) -> None:
        """The active object, and the settings of the scene unless the call gives its own."""
        given = self.properties.is_property_set
        values = {
            name: getattr(self if given(name) else context.scene.curvopt, name) for name in properties.SETTINGS
        }
        obj = context.view_layer.objects.active
        self._outcome = values["outcome"]
        self._source = cage.read_source(context, obj, with_keys=self._outcome == "SHAPE_KEY")
        self._request = _request(values, cage.read_held(obj, values["keep"], values["vertex_group"]))
        outcome.check_outcome(self._outcome, self._request.levels)

    def _write(self, context: bpy.types.Context, solution: job.Solution) -> set[str]:
        remark = apply.apply(self._source, self._request, solution, self._outcome)
        text = job.solution_text(self._request, solution)
        if remark:
            text = f"{text}. {remark}"
        self.report({"WARNING" if remark else "INFO"}, text)
        _show(context, text, about=context.view_layer.objects.active.name)
        return {"FINISHED"}

    def _fail(self, context: bpy.types.Context, error: BaseException) -> set[str]:
        text = str(error) if isinstance(error, cage.CageError) else job.failure_text(error)
        _show(context, text, failed=True)
        self.report({"ERROR"}, text)
        return {"CANCELLED"}


def _request(values: dict[str, object], held: Held) -> job.Request:
    """Settings as job.py wants them."""
    limits = {
        "surface": SURFACES.index(values["surface"].lower()),
        "max_iterations": values["max_iterations"],
        "threads": values["threads"],
        "escape": int(values["escape"]),
    }
    levels = 1 if values["resolution"] == "KEEP" else values["levels"]
    energy, symmetry = properties.energy_text_of(values), properties.symmetry_text_of(values)
    return job.Request(energy, levels, limits, values["boundary"].lower(), symmetry, held)


class _EndButton:
    """A button of a run that is on."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _run is not None


class CURVOPT_OT_finish(_EndButton, bpy.types.Operator):
    """End the run now and keep the best surface so far (Enter)"""

    bl_idname = "curvopt.finish"
    bl_label = "Keep"

    def execute(self, context: bpy.types.Context) -> set[str]:
        _run.keep()
        return {"FINISHED"}


class CURVOPT_OT_cancel(_EndButton, bpy.types.Operator):
    """End the run now and change nothing (Esc)"""

    bl_idname = "curvopt.cancel"
    bl_label = "Cancel"

    def execute(self, context: bpy.types.Context) -> set[str]:
        _run.escape()
        return {"FINISHED"}


def _over_sidebar(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether a mouse button is for a sidebar, where Keep and Cancel are."""
    if event.type != "LEFTMOUSE":
        return False
    for area in context.screen.areas:
        if area.type == "VIEW_3D":
            for region in area.regions:
                x, y = event.mouse_x - region.x, event.mouse_y - region.y
                if region.type == "UI" and 0 <= x < region.width and 0 <= y < region.height:
                    return True
    return False


def _start_preview(context: bpy.types.Context, source: cage.Source, run: job.ModalRun) -> None:
    """Draw the run, where a new object would stand; not in background."""
    if bpy.app.background:
        return
    from .preview import Preview  # needs a GPU

    placement = result.beside(context.scene, source, source.cage.positions) @ source.frame
    _on_screen.append(Preview(context.scene.name, placement, run.job, run.label).end)


def _refresh(context: bpy.types.Context, run: job.ModalRun) -> None:
    """Have the viewports drawn if there is something new, but not too often."""
    global _refreshed
    seen = (run.job.latest, run.job.watcher.latest, time.monotonic())
    if seen[:2] == _refreshed[:2] or seen[2] < _refreshed[2] + _REDRAW:
        return
    from .overlay import redraw

    _refreshed = seen
    redraw(context, ("WINDOW",))
    run.job.watcher.ask()


def _show(
    context: bpy.types.Context, text: str, running: bool = False, failed: bool = False, about: str = ""
) -> None:
    """Put `text` into the sidebar and, while running, the status bar; `about`: the object it tells the making of."""
    state = properties.state
    changed = state.message != text or state.running != running
    state.message, state.running, state.failed, state.about = text, running, failed, about
    if bpy.app.background:
        return
    if changed:
        from .overlay import redraw

        redraw(context)
    if running and context.workspace is not None:
        context.workspace.status_text_set(f"{text}   |   Enter: keep this   |   Esc: cancel")


def _clear_screen() -> None:
    """Take away timer, drawing and status; that in every workspace, for the user may have changed to another one."""
    while _on_screen:
        _on_screen.pop()()
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)


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
        _clear_screen()
        _run = None
    for old in _leaving:
        old.join(max(0.0, deadline - time.monotonic()))
    _leaving.clear()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

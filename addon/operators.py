# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator `curvopt.minimize`: modal from the user interface, synchronous (`execute`) from scripts and in batch.

Thin: reading is cage.py's, running job.py's, writing result.py's. Between invoke and the end it holds arrays only, no
Blender data; one place, `_end`, is passed on every way out.
"""

import bpy

from . import cage, job, properties, result

_TICK = 0.1  # seconds between looks at the worker
_LAST_WAIT = 5.0  # seconds that quitting or disabling the add-on waits for the worker

# While a run is on, these events go on to Blender, so that one can look around; all others could change the scene.
_LOOKING_AROUND = {"MIDDLEMOUSE", "MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "NDOF_MOTION"}
_LOOKING_AROUND |= {"TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSESMARTZOOM", "WINDOW_DEACTIVATE"}

_run: job.ModalRun | None = None  # the modal run that is on; there is one at a time


class CURVOPT_OT_minimize(bpy.types.Operator):
    """Make a new object whose surface has the least energy, starting from the active mesh's cage"""

    bl_idname = "curvopt.minimize"
    bl_label = "Minimize"
    bl_options = {"UNDO"}

    energy: properties.energy_property()
    levels: properties.levels_property()
    boundary: properties.boundary_property()
    symmetry: properties.symmetry_property()
    keep: properties.keep_property()
    vertex_group: properties.vertex_group_property()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if _run is not None:
            cls.poll_message_set("A run is on already")
        return _run is None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The whole run at once. A refusal or failure raises RuntimeError in scripts, as operator errors do."""
        try:
            source, request = self._read(context)
            return self._write(context, source, request, job.solve(source.cage, request))
        except Exception as error:
            return self._fail(context, error)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start the worker and return to the user."""
        global _run
        try:
            self._source, self._request = self._read(context)
            _run = job.ModalRun(job.Job.minimize(self._source.cage, self._request), self._request.label)
        except Exception as error:
            return self._fail(context, error)
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        _show(context, _run.status, running=True)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            _run.escape()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in _LOOKING_AROUND else {"RUNNING_MODAL"}
        if not _run.tick().ended:
            _show(context, _run.status, running=True)
            return {"RUNNING_MODAL"} if event.type == "ESC" else {"PASS_THROUGH"}
        return self._end(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: it quits, loads a file, closes the window."""
        _run.abandon(_LAST_WAIT)
        self._end(context)

    def _end(self, context: bpy.types.Context) -> set[str]:
        global _run
        run, _run = _run, None
        context.window_manager.event_timer_remove(self._timer)
        _clear_status()
        try:
            if run.phase is job.Phase.FINISHED:
                return self._write(context, self._source, self._request, run.job.solution)
            if run.phase is job.Phase.FAILED:
                return self._fail(context, run.job.error)
        except Exception as error:
            return self._fail(context, error)
        _show(context, f"Minimizing {run.label} was cancelled, nothing was changed.")
        return {"CANCELLED"}

    def _read(self, context: bpy.types.Context) -> tuple[cage.Source, job.Request]:
        """The active object, and the settings of the scene unless the call gives its own."""
        given = self.properties.is_property_set
        energy, levels, boundary, symmetry, keep, group = (
            getattr(self if given(name) else context.scene.curvopt, name)
            for name in ("energy", "levels", "boundary", "symmetry", "keep", "vertex_group")
        )
        obj = context.view_layer.objects.active
        source = cage.read_source(context, obj)
        held = cage.read_held(obj, keep, group)
        return source, job.Request(energy.lower(), levels, {}, boundary.lower(), symmetry.lower(), held)

    def _write(
        self, context: bpy.types.Context, source: cage.Source, request: job.Request, solution: job.Solution
    ) -> set[str]:
        result.add_result(context, source, request, solution)
        text = job.solution_text(request, solution)
        self.report({"INFO"}, text)
        _show(context, text)
        return {"FINISHED"}

    def _fail(self, context: bpy.types.Context, error: BaseException) -> set[str]:
        text = str(error) if isinstance(error, cage.CageError) else job.failure_text(error)
        _show(context, text, failed=True)
        self.report({"ERROR"}, text)
        return {"CANCELLED"}


def _show(context: bpy.types.Context, text: str, running: bool = False, failed: bool = False) -> None:
    """Put `text` into the sidebar and, while running, the status bar."""
    state = properties.state
    state.running, state.failed = running, failed
    if state.message != text:
        state.message = text
        _redraw_sidebars(context)
    if running and context.workspace is not None:
        context.workspace.status_text_set(text)


def _redraw_sidebars(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def _clear_status() -> None:
    """In every workspace: the user may have changed to another one meanwhile."""
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_minimize)


def unregister() -> None:
    global _run
    if _run is not None:
        _run.abandon(_LAST_WAIT)
        _clear_status()
        _run = None
    bpy.utils.unregister_class(CURVOPT_OT_minimize)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Live: the surface follows handles that are dragged. The operators `curvopt.live`, `curvopt.live_finish` and
`curvopt.live_cancel`.

No modal operator runs while Live is on, because Blender's own grab, undo, saving and modes are to work as ever, and Blender
refuses undo while a modal operator is there. A timer of the application looks at handles and settings in its place, also in
the middle of a grab, and so does a handler that Blender calls when something has moved. They change nothing in the file.
Only the three operators do, each as one undo step: to remove what is being moved would crash Blender.
"""

from __future__ import annotations

import contextlib
import threading
import time

import bpy

from ..core import messages
from ..scene import handles
from . import adjust, display, properties
from .live_session import Session
from .reports import report_failure

_TICK = 0.016  # seconds between looks at the handles
_SHARE = 4.0  # the timer waits that many times longer than a look takes: a fifth of the main thread at most
_WAIT = 0.01  # seconds that Blender's drawing is kept back at most, for the surface that belongs to it
_FINISH_TICK = 0.02  # seconds between looks at a worker that settles

_session: Session | None = None
_plays = False  # whether an animation was played at the last look
_keys: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def current() -> Session | None:
    """The session that is on, or that has ended by itself and has left handles."""
    return _session


def _tick() -> float | None:
    """Seconds until the next look, or None at the end."""
    begin = time.perf_counter()
    goes_on = _look()
    return max(_TICK, _SHARE * (time.perf_counter() - begin)) if goes_on else None


@bpy.app.handlers.persistent
def _on_moved(*_: object) -> None:
    """Blender has moved what is grabbed, and draws next."""
    if threading.current_thread() is threading.main_thread():  # and not a render's
        _follow()


def _follow() -> None:
    """The surface goes with the hand into the same picture, if it comes in time. To find out what is wrong, and to begin a
    worker, is for the timer."""
    session = _session
    if session is None or session.ended or session.finishing or session.live is None or session.view is None:
        return
    begin = time.perf_counter()
    with contextlib.suppress(Exception):
        before = session.live.number
        session.look()
        if session.live.number > before and session.live.await_first(_WAIT - (time.perf_counter() - begin)):
            session.speak()


def _look() -> bool:
    """Handles and settings to the worker, its answers to the screen; whether to go on."""
    global _plays
    if _session is None or _session.ended:
        return False
    _plays = any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)
    try:
        if not _session.finishing:
            _session.look()
        _session.speak()
    except Exception as error:
        _break(error)
        return False
    return True


def _break(error: BaseException) -> None:
    """Live cannot go on. What it has put into the file stays until the user has it taken away."""
    _session.stop()
    text = messages.failure_text(_session.source.named(error))
    left = handles.is_there(_session.id)
    _set_state("ENDED" if left else "")
    display.show(bpy.context, f"{text} Cancel takes the handles away." if left else text, failed=True)


def _set_state(live: str) -> None:
    global _session
    properties.state.live = live
    if not live:
        _session = None


class CURVOPT_OT_live(bpy.types.Operator):
    """Drag handles, and the surface follows. In Object Mode the vertices that Pin names, or those that are selected, get \
empties to drag; in Edit Mode you move vertices. Finish writes the result, Esc leaves the mesh as it was"""

    bl_idname = "curvopt.live"
    bl_label = "Live"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        is_on = properties.state.live == "ON"
        if properties.state.running or is_on:
            cls.poll_message_set("Live is on already" if is_on else "A run is on already")
        return not (properties.state.running or is_on)

    def execute(self, context: bpy.types.Context) -> set[str]:
        global _session
        begun = None
        try:
            obj = context.view_layer.objects.active
            obj = handles.owner(obj) or obj
            begun = Session(context, obj)
            begun.begin(context, obj)
        except Exception as error:
            if begun is not None:
                begun.stop()
                error = begun.source.named(error)
            display.show(context, messages.failure_text(error), failed=True)
            return report_failure(self, error)
        _session = begun
        _set_state("ON")
        display.show(context, "Live: preparing")
        if not bpy.app.timers.is_registered(_tick):
            bpy.app.timers.register(_tick)
        return {"FINISHED"}


class CURVOPT_OT_live_finish(bpy.types.Operator):
    """Settle, and write the result as the setting Result says. The handles go"""

    bl_idname = "curvopt.live_finish"
    bl_label = "Finish"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return properties.state.live == "ON" and not _session.finishing

    def execute(self, context: bpy.types.Context) -> set[str]:
        """At once, for scripts."""
        if not self._begin(context):
            return {"CANCELLED"}
        _session.live.join()
        return self._write(context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Wait for the optimum, and let Blender draw meanwhile."""
        if not self._begin(context):
            return {"CANCELLED"}
        _session.finishing = True
        display.show(context, "Live: settling")
        manager = context.window_manager
        self._timer = manager.event_timer_add(_FINISH_TICK, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _begin(self, context: bpy.types.Context) -> bool:
        """Have the worker settle and end; False, with a report, where Live cannot go on, or the result cannot be written."""
        try:
            _session.look(thorough=True)
        except Exception as error:
            _break(error)
            report_failure(self, error)
            return False
        try:
            _session.check_finish(context.scene.curvopt.outcome, context.scene.curvopt.animation)
        except Exception as error:
            display.show(context, messages.failure_text(error), failed=True)
            report_failure(self, error)
            return False
        _session.live.finish()
        return True

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Esc goes back to dragging."""
        if properties.state.live != "ON":  # a file was loaded
            return self._leave(context, {"CANCELLED"})
        if event.type == "ESC" and event.value == "PRESS":
            _session.resume()
            return self._leave(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        if _session.live.running:
            return {"PASS_THROUGH"}
        return self._leave(context, self._write(context))

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: it quits, loads a file, closes the window. As Esc."""
        if properties.state.live == "ON":
            _session.resume()
        self._leave(context, {"CANCELLED"})

    def _leave(self, context: bpy.types.Context, result: set[str]) -> set[str]:
        context.window_manager.event_timer_remove(self._timer)
        return result

    def _write(self, context: bpy.types.Context) -> set[str]:
        session, live, settings = _session, _session.live, context.scene.curvopt
        try:
            if live.solution is None:
                raise session.source.named(live.error or RuntimeError("The worker has ended without a result"))
            session.check_finish(settings.outcome, settings.animation)
        except Exception as error:
            session.resume()
            display.show(context, messages.failure_text(error), failed=True)
            return report_failure(self, error)
        session.stop()
        _set_state("")
        try:
            source, (request, solution) = session.source_there(), session.found(settings.animation)
            handles.end(context, session.id, session.name, session.source)
            remark, warns = adjust.apply(source, request, solution, settings.outcome)
        except Exception as error:
            display.show(context, messages.failure_text(error), failed=True)
            bpy.ops.ed.undo_push(message=self.bl_label)
            return report_failure(self, error)
        self.report({"WARNING" if warns else "INFO"}, messages.solution_text(request, solution, remark))
        return {"FINISHED"}


class CURVOPT_OT_live_cancel(bpy.types.Operator):
    """End Live, take its handles away, and leave the mesh as it was (Esc)"""

    bl_idname = "curvopt.live_cancel"
    bl_label = "Cancel"
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(properties.state.live or handles.session_of(context.view_layer.objects.active))

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Esc is for Live that is on, unless it is the one that has ended playback, which Blender passes on."""
        if event.type == "ESC" and (properties.state.live != "ON" or _plays):
            return {"CANCELLED", "PASS_THROUGH"}
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            text = _cancel(context)
        except Exception as error:
            display.show(context, messages.failure_text(error), failed=True)
            return report_failure(self, error)
        _set_state("")
        display.show(context, text)
        return {"FINISHED"}


def _cancel(context: bpy.types.Context) -> str:
    """Take the handles away; what to say."""
    session = _session
    if session is None:  # left by undo, or in a file that was saved
        active = context.view_layer.objects.active
        handles.end(context, handles.session_of(active), active.name)
        return "The handles of Live were taken away."
    had_ended = session.ended
    session.stop()
    if not handles.end(context, session.id, session.name, session.source, session.positions if had_ended else None):
        return "Live was cancelled. The mesh is another one by now, and was left alone."
    if had_ended:
        return "The handles of Live were taken away. What was changed since it ended stays."
    return "Live was cancelled, nothing was changed."


@bpy.app.handlers.persistent
def _on_load(*_: object) -> None:
    """Another file: its handles are none of ours."""
    if _session is not None:
        _session.stop()
        _set_state("")
        display.show(bpy.context, "Live has ended, because a file was loaded.")


_CLASSES = (CURVOPT_OT_live, CURVOPT_OT_live_finish, CURVOPT_OT_live_cancel)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_pre.append(_on_load)
    bpy.app.handlers.depsgraph_update_post.append(_on_moved)
    config = bpy.context.window_manager.keyconfigs.addon
    if config is not None:  # none in background
        keymap = config.keymaps.new("3D View", space_type="VIEW_3D")
        _keys.append((keymap, keymap.keymap_items.new(CURVOPT_OT_live_cancel.bl_idname, "ESC", "PRESS")))


def unregister() -> None:
    """Quitting Blender comes here, too: the worker ends first, as far as it does in time."""
    if _session is not None:
        _session.stop()
        _set_state("")
    for keymap, item in _keys:
        keymap.keymap_items.remove(item)
    _keys.clear()
    bpy.app.handlers.load_pre.remove(_on_load)
    bpy.app.handlers.depsgraph_update_post.remove(_on_moved)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

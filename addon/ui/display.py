# SPDX-License-Identifier: GPL-3.0-or-later
"""What the screen shows of a run: the message in the sidebar, the status bar, and the preview in the viewports."""

from __future__ import annotations

import time
from collections.abc import Callable

import bpy

from ..core.job import ModalRun
from ..core.messages import failure_text
from ..scene.handles import owner
from ..scene.modifiers import CageError
from ..scene.read_cage import Source, check_object
from ..scene.write_result import beside
from . import properties

_REDRAW = 0.15  # seconds, at least, between two drawings of a run

_refreshed: tuple[object, object, float] = (None, None, 0.0)  # progress and picture that were drawn, and when
_at_end: list[Callable[[], object]] = []  # what takes away everything that a run has put on the screen


def show(
    context: bpy.types.Context, text: str, running: bool = False, failed: bool = False,
    is_undone: Callable[[], bool] | None = None,
) -> None:  # fmt: skip
    """Put `text` into the sidebar and, while running, into the status bar. `is_undone` says of a text that reports a
    result whether that has been undone or deleted since. A text that `failed` is about the active object."""
    state = properties.state
    changed = state.message != text or state.running != running
    state.message, state.running, state.failed, state.is_undone = text, running, failed, is_undone
    if failed:
        state.about, state.is_checked = _name(active_object(context)), text == refusal(context)
    if bpy.app.background:
        return
    if changed:
        from .overlay import redraw  # needs a GPU

        redraw(context)
    if running and context.workspace is not None:
        context.workspace.status_text_set(f"{text}   |   Enter: finish now   |   Esc: cancel")


def active_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The active object, or that of the handle which is active."""
    active = context.view_layer.objects.active
    return owner(active) or active


def refusal(context: bpy.types.Context) -> str:
    """Why the active object cannot be used, as far as check_object sees that; "" if it can be. Quick."""
    try:
        with_keys = context.scene.curvopt.outcome == "SHAPE_KEY"
        check_object(active_object(context), with_keys, "EDIT" if context.mode == "EDIT_MESH" else "OBJECT")
    except CageError as error:
        return failure_text(error)
    return ""


def message(context: bpy.types.Context) -> tuple[str, bool]:
    """What the sidebar is to say, and whether in red. A refusal is for the object that it is about, and for as long as
    check_object says the same, if it was the one that refused; what tells of a result, until that is undone or deleted.
    Live speaks for itself."""
    state = properties.state
    is_over = state.is_undone is not None and state.is_undone()
    if state.failed and not state.live:
        is_over = state.about != _name(active_object(context)) or (state.is_checked and state.message != refusal(context))
    return ("", False) if is_over else (state.message, state.failed)


def _name(obj: bpy.types.Object | None) -> str:
    return "" if obj is None else obj.name_full


def start_preview(context: bpy.types.Context, source: Source, run: ModalRun, in_place: bool) -> None:
    """Draw the run where a new object would stand, or in front of the object itself; not in background."""
    if bpy.app.background:
        return
    from .preview import Preview  # needs a GPU

    placement, loose = source.frame, source.loose_lines()
    if in_place:
        loose = loose[:0]  # Blender draws them
    else:
        placement = beside(context.scene, source, source.cage.positions) @ placement
    at_end(Preview(context.scene.name, placement, run.job, run.label, loose, in_place).end)


def refresh(context: bpy.types.Context, run: ModalRun) -> None:
    """Have the viewports drawn if there is something new, but not too often."""
    global _refreshed
    seen = (run.job.latest, run.job.watcher.latest, time.monotonic())
    if (seen[0] is _refreshed[0] and seen[1] is _refreshed[1]) or seen[2] < _refreshed[2] + _REDRAW:
        return
    from .overlay import redraw  # needs a GPU

    _refreshed = seen
    redraw(context, ("WINDOW",))
    run.job.watcher.ask()


def at_end(action: Callable[[], object]) -> None:
    """Have `clear` call `action`."""
    _at_end.append(action)


def clear() -> None:
    """Take away timer, preview and status text. The status text goes from every workspace, because the user may have
    changed to another one."""
    while _at_end:
        _at_end.pop()()
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)

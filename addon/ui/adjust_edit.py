# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a run in Edit Mode as an operator of its own, `curvopt.apply_edit`, as adjust.py has one for Object Mode.

Its undo step is one of Edit Mode, which has the mesh and nothing else: no numbers are stored on the object.
"""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..core import messages, rims
from ..core.job import Request, Solution
from ..core.variants import Variants
from ..scene.placement import is_shown_smooth
from ..scene.read_edit import Edit
from ..scene.write_edit import write_edit
from . import display, properties
from .reports import NOT_THE_LAST, call_operator, report_failure

# With its number; runs by strength, rim and slide; whether Slide is offered.
_finished: tuple[int, Edit, Request, Variants, bool] | None = None
_text = ""  # of the last execution


def apply(edit: Edit, base: Request, rim: str, request: Request, solution: Solution) -> str:
    """Write a solution of edit.request(base, rim) as an undo step that can be adjusted; the report of it. UserError if
    it cannot be written."""
    global _finished
    cage, slide = edit.source.cage, bool(base.options.get("slide"))
    variants = Variants(cage, (base.strength, rim, slide), request, solution)
    may_slide = bool(rims.sliding_vertices(cage, edit.part, "free", base.boundary).any())
    _finished = (1 if _finished is None else _finished[0] + 1, edit, base, variants, may_slide)
    chosen = {"strength": base.strength, "rim": rim.upper(), "slide": slide, "amount": 1.0}
    call_operator(bpy.ops.curvopt.apply_edit, number=_finished[0], **chosen)
    return _text


def _with(strength: float, rim: str, slide: bool) -> tuple[Request, Solution]:
    """The last run, or one like it with another strength, rim or slide. UserError if that is not possible."""
    _, edit, base, variants, _ = _finished
    wanted = properties.with_slide(replace(base, strength=strength), slide)
    name = f"Rim {rim.title()}"
    if strength != base.strength:
        name = f"Strength {strength:.3g}"
    elif slide != bool(base.options.get("slide")):
        name = "Slide"
    return variants.get((strength, rim, slide), lambda: edit.request(wanted, rim), name)


class CURVOPT_OT_apply_edit(properties.AdjustSettings, bpy.types.Operator):
    """Move the vertices of the last run in Edit Mode, or run again with another strength or rim, or with Slide"""

    bl_idname = "curvopt.apply_edit"
    bl_label = "Minimized"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    rim: bpy.props.EnumProperty(
        name="Rim", description="What stays at the rim of the selection: runs again", items=properties.RIMS,
        default="FREE", options={"SKIP_SAVE"},
    )  # fmt: skip

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the last solution, or one of another strength, rim or slide. An error is reported, and nothing changes."""
        global _text
        if _finished is None or _finished[0] != self.number:
            self.report({"ERROR"}, NOT_THE_LAST)
            return {"CANCELLED"}
        try:
            edit = _finished[1]
            request, solution = _with(properties.strength_of(self.strength), self.rim.lower(), self.slide)
            moved = write_edit(edit, request, solution, self.amount)
            held = edit.source.layout.in_mesh_numbers(messages.exceptions_text(solution.exceptions))
            name = edit.source.name
            smooth = "" if is_shown_smooth(name) else messages.not_smooth_text(name)
            parts = held, messages.crossings_text(solution), moved.remark, messages.sliding_text(request, solution), smooth
            remark = ". ".join(part for part in parts if part)
            _text = messages.part_text(request, solution, moved.count, remark)
            text = f"{_text}. {messages.verdict_of(request, solution)}"
            display.show(context, text, is_undone=moved.is_undone)
        except Exception as error:
            return report_failure(self, error)
        return {"FINISHED"}

    def draw(self, context: bpy.types.Context) -> None:
        again = self.layout.column()
        again.enabled = _finished is not None and _finished[3].is_quick
        again.prop(self, "strength", slider=True)
        again.prop(self, "rim")
        if _finished is not None and _finished[4]:
            again.prop(self, "slide")
        self.layout.prop(self, "amount", slider=True)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_apply_edit)


def unregister() -> None:
    global _finished
    _finished = None
    bpy.utils.unregister_class(CURVOPT_OT_apply_edit)

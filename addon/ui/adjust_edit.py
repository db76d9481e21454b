# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a run in Edit Mode as an operator of its own, `curvopt.apply_edit`, as adjust.py has one for Object Mode.

Its undo step is one of Edit Mode, which has the mesh and nothing else: no numbers are stored on the object.
"""

from __future__ import annotations

import bpy

from ..core import messages, rims
from ..core.job import Request, Solution
from ..core.variants import Variants
from ..scene.placement import is_shown_smooth
from ..scene.read_edit import Edit
from ..scene.write_edit import write_edit
from . import display, properties
from .reports import NOT_THE_LAST, call_operator, report_failure

# With its number; runs by strength, rim, slide and volume; whether Slide is offered.
_finished: tuple[int, Edit, Request, Variants, bool] | None = None
_text = ""  # of the last execution


def apply(edit: Edit, base: Request, rim: str, request: Request, solution: Solution) -> str:
    """Write a solution of edit.request(base, rim) as an undo step that can be adjusted; the report of it. UserError if
    it cannot be written."""
    global _finished
    cage, slide = edit.source.cage, bool(base.options.get("slide"))
    variants = Variants(cage, (base.strength, rim, slide, base.keeps_volume), request, solution)
    may_slide = bool(rims.sliding_vertices(cage, edit.part, "free", base.boundary).any())
    _finished = (1 if _finished is None else _finished[0] + 1, edit, base, variants, may_slide)
    chosen = {"strength": base.strength, "rim": rim.upper(), "slide": slide, "amount": 1.0}
    chosen["keep_volume"] = base.keeps_volume
    call_operator(bpy.ops.curvopt.apply_edit, number=_finished[0], **chosen)
    return _text


def _with(strength: float, rim: str, slide: bool, keeps_volume: bool) -> tuple[Request, Solution]:
    """The last run, or one like it with another strength, rim, slide or volume. UserError if that is not possible."""
    _, edit, base, variants, _ = _finished
    wanted = properties.with_other(base, strength, slide, keeps_volume)
    name = properties.other_name(base, strength, slide, keeps_volume) or f"Rim {rim.title()}"
    return variants.get((strength, rim, slide, keeps_volume), lambda: edit.request(wanted, rim), name)


class CURVOPT_OT_apply_edit(properties.AdjustSettings, bpy.types.Operator):
    """Move the vertices of the last run in Edit Mode, or run again with another strength or rim, with Slide, or with Keep \
Volume"""

    bl_idname = "curvopt.apply_edit"
    bl_label = "Minimized"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    rim: bpy.props.EnumProperty(
        name="Rim", description="What stays at the rim of the selection: runs again", items=properties.RIMS,
        default="FREE", options={"SKIP_SAVE"},
    )  # fmt: skip

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the last solution, or one of another strength, rim, slide or volume. An error is reported, and nothing
        changes."""
        global _text
        if _finished is None or _finished[0] != self.number:
            self.report({"ERROR"}, NOT_THE_LAST)
            return {"CANCELLED"}
        try:
            edit = _finished[1]
            strength, rim = properties.strength_of(self.strength), self.rim.lower()
            request, solution = _with(strength, rim, self.slide, self.keep_volume)
            moved = write_edit(edit, request, solution, self.amount)
            in_mesh_numbers = edit.source.layout.in_mesh_numbers
            held, folded = in_mesh_numbers(messages.exceptions_text(solution.exceptions)), in_mesh_numbers(messages.folds_text(solution))
            name = edit.source.name
            smooth = "" if is_shown_smooth(name) else messages.not_smooth_text(name)
            grown, crossed = messages.growth_text(request, solution), messages.crossings_text(solution)
            torn = messages.torn_text(edit.source.mesh.n_torn()) if solution.stop == "unresolved" else ""
            found = torn, messages.volume_text(request, solution), held, folded, grown, crossed, moved.remark
            parts = *found, messages.unchanged_text(request, solution), messages.sliding_text(request, solution), messages.contact_text(request, solution), smooth
            remark = ". ".join(part for part in parts if part)
            _text = messages.part_text(request, solution, moved.count, remark)
            text = f"{_text}. {messages.verdict_of(request, solution)}"
            display.show(context, text, is_undone=moved.is_undone if moved.count else None)
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
        again.prop(self, "keep_volume")
        self.layout.prop(self, "amount", slider=True)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_apply_edit)


def unregister() -> None:
    global _finished
    _finished = None
    bpy.utils.unregister_class(CURVOPT_OT_apply_edit)

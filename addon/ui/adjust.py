# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a run as an operator of its own, `curvopt.apply_result`, and with it the adjust-last-operation panel (F9).

To adjust an operation, Blender undoes it and runs `execute` again with other properties. A whole optimization would
freeze Blender for minutes. Hence this operator, which writes a finished solution, is the one that registers and
that can be undone. This module holds the latest solution as arrays; Blender remembers its number.

Another strength, *Slide* or *Keep Volume* is another run. It is offered where the first one was quick, and ends without a
result where it is not.
"""

from __future__ import annotations

from functools import partial

import bpy

from ..core import messages, rims
from ..core.job import Request, Solution
from ..core.variants import Variants
from ..scene import placement
from ..scene.read_cage import Source
from ..scene.write_result import stored_verdict
from . import display, properties
from .reports import NOT_THE_LAST, call_operator, report_failure

# With its number; runs by strength, slide and volume; a remark on what was read; whether Slide is offered.
_finished: tuple[int, Source, Variants, str, bool] | None = None
_remark, _warns = "", False  # of the last execution: what else the user should know, and whether as a warning


def apply(source: Source, request: Request, solution: Solution, where: str, read: str = "") -> tuple[str, bool]:
    """Write a solution as `where`, of properties.OUTCOMES, says, as an undo step that can be adjusted; what else the
    user should know, `read` included, or "", and whether that is a warning. `read` is a remark on what was read, or "". UserError if the
    solution cannot be written there."""
    global _finished
    slide = bool(request.options.get("slide"))
    variants = Variants(source.cage, (request.strength, slide, request.keeps_volume), request, solution)
    may_slide = rims.has_curves(source.cage, request.boundary)
    _finished = (1 if _finished is None else _finished[0] + 1, source, variants, read, may_slide)
    chosen = {"outcome": where, "strength": request.strength, "slide": slide, "amount": 1.0}
    chosen["keep_volume"] = request.keeps_volume
    call_operator(bpy.ops.curvopt.apply_result, number=_finished[0], **chosen)
    return _remark, _warns


def _with(strength: float, slide: bool, keeps_volume: bool) -> tuple[Request, Solution]:
    """The last run, or one like it with another strength, slide or volume. UserError if that takes too long."""
    variants = _finished[2]
    wanted = properties.with_other(variants.first[0], strength, slide, keeps_volume)
    name = properties.other_name(variants.first[0], strength, slide, keeps_volume)
    return variants.get((strength, slide, keeps_volume), lambda: wanted, name)


def _is_gone(name: str) -> bool:
    """Whether there is no result of that name."""
    return not stored_verdict(bpy.data.objects.get(name))


class CURVOPT_OT_apply_result(properties.AdjustSettings, bpy.types.Operator):
    """Put the result of the last run into a new object, in place, or into a shape key, or run again with another \
strength, with Slide, or with Keep Volume"""

    bl_idname = "curvopt.apply_result"
    bl_label = "Minimized"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    outcome: bpy.props.EnumProperty(
        name="Result", description="Where the result goes", items=properties.OUTCOMES, default="NEW",
        options={"SKIP_SAVE"},
    )  # fmt: skip

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the last solution, or one of another strength, slide or volume. An error is reported, and the result of
        before stays."""
        global _remark, _warns
        if _finished is None or _finished[0] != self.number:
            self.report({"ERROR"}, NOT_THE_LAST)
            return {"CANCELLED"}
        try:
            _, source, variants, read, _ = _finished
            first, given = variants.first[0], self.properties.is_property_set
            strength = properties.strength_of(self.strength) if given("strength") else first.strength
            slide = self.slide if given("slide") else bool(first.options.get("slide"))
            keeps_volume = self.keep_volume if given("keep_volume") else first.keeps_volume
            request, solution = _with(strength, slide, keeps_volume)
            placement.check_amount(self.amount, request)
            is_shown_smooth = placement.is_shown_smooth(source.name)
            obj, remark = placement.write(context, source, request, solution, self.outcome)
            shown = placement.animate_run(context, obj, source, solution)
            in_mesh_numbers = source.layout.in_mesh_numbers
            held, folded = in_mesh_numbers(messages.exceptions_text(solution.exceptions)), in_mesh_numbers(messages.folds_text(solution))
            grown, crossed = messages.growth_text(request, solution), messages.crossings_text(solution)
            warnings = messages.refined_text(request), messages.volume_text(request, solution), held, folded, grown, crossed, remark
            smoothed = "" if is_shown_smooth else messages.smoothed_text(source.name, obj.name == source.name)
            torn = messages.torn_text(source.mesh.n_torn())
            told = torn, read, messages.marks_text(request), messages.sliding_text(request, solution), messages.contact_text(request, solution)
            parts = *warnings, messages.unchanged_text(request, solution), *told, smoothed, shown
            _remark, _warns = ". ".join(part for part in parts if part), any(warnings)
            placement.set_amount(obj, self.amount)
            text = messages.solution_text(request, solution, _remark)
            display.show(context, text, is_undone=partial(_is_gone, obj.name))
        except Exception as error:
            return report_failure(self, error)
        return {"FINISHED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        for identifier, *_ in properties.OUTCOMES:
            row = column.row(align=True)
            row.enabled = _finished is not None and placement.is_possible(identifier, _finished[2].first[0])
            row.prop_enum(self, "outcome", identifier)
        again = layout.column()
        again.enabled = _finished is not None and _finished[2].is_quick
        again.prop(self, "strength", slider=True)
        if _finished is not None and _finished[4]:
            again.prop(self, "slide")
        again.prop(self, "keep_volume")
        of_amount = layout.column()
        of_amount.enabled = _finished is not None and not _finished[2].first[0].records
        of_amount.prop(self, "amount", slider=True)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_apply_result)


def unregister() -> None:
    global _finished
    _finished = None
    bpy.utils.unregister_class(CURVOPT_OT_apply_result)

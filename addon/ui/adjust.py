# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a run as an operator of its own, `curvopt.apply_result`, and with it the adjust-last-operation panel (F9).

To adjust an operation, Blender undoes it and runs `execute` again with other properties. A whole optimization would
freeze Blender for minutes. Hence this operator, which only writes a finished solution, is the one that registers and
that can be undone. This module holds the latest solution as arrays; Blender remembers its number.
"""

from __future__ import annotations

import bpy

from ..core.job import Request, Solution
from ..scene import placement
from ..scene.read_cage import CageError, Source
from . import properties
from .reports import report_failure

_finished: tuple[int, Source, Request, Solution] | None = None  # with its number
_remark = ""  # of the last execution


def apply(source: Source, request: Request, solution: Solution, where: str) -> str:
    """Write a solution as `where`, of properties.OUTCOMES, says, as an undo step that can be adjusted; what else the
    user should know, or "". CageError if it cannot be written there."""
    global _finished
    _finished = (1 if _finished is None else _finished[0] + 1, source, request, solution)
    try:
        bpy.ops.curvopt.apply_result("EXEC_DEFAULT", True, number=_finished[0], outcome=where, amount=1.0)
    except RuntimeError as error:  # its report
        raise CageError(str(error).strip().removeprefix("Error: ")) from error
    return _remark


class CURVOPT_OT_apply_result(bpy.types.Operator):
    """Put the result of the last run into a new object, in place, or into a shape key, without running again"""

    bl_idname = "curvopt.apply_result"
    bl_label = "Minimized"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    number: bpy.props.IntProperty(options={"HIDDEN", "SKIP_SAVE"})
    outcome: bpy.props.EnumProperty(
        name="Result", description="Where the result goes", items=properties.OUTCOMES, default="NEW",
        options={"SKIP_SAVE"},
    )  # fmt: skip
    amount: bpy.props.FloatProperty(
        name="Amount", description="0 is the surface of the original, 1 the optimum", min=0.0, max=1.0, default=1.0,
        subtype="FACTOR", options={"SKIP_SAVE"},
    )  # fmt: skip

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the last solution. An error is reported, and the result of before stays."""
        global _remark
        if _finished is None or _finished[0] != self.number:
            self.report({"ERROR"}, "Only the result of the last run can be applied again: run it again.")
            return {"CANCELLED"}
        try:
            obj, _remark = placement.write(context, *_finished[1:], self.outcome)
            placement.set_amount(obj, self.amount)
        except Exception as error:
            return report_failure(self, error)
        return {"FINISHED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        for identifier, *_ in properties.OUTCOMES:
            row = column.row(align=True)
            row.enabled = _finished is not None and placement.is_possible(identifier, _finished[2].levels)
            row.prop_enum(self, "outcome", identifier)
        layout.prop(self, "amount", slider=True)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_apply_result)


def unregister() -> None:
    global _finished
    _finished = None
    bpy.utils.unregister_class(CURVOPT_OT_apply_result)

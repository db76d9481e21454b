# SPDX-License-Identifier: GPL-3.0-or-later
"""How operators end when something fails: with a report, never with an exception; and that report as an exception
again, for who has called one."""

from __future__ import annotations

import traceback
from collections.abc import Callable

import bpy

from ..core.messages import UserError, failure_text, is_foreseen

NOT_THE_LAST = "Only the result of the last run can be applied again: run it again."


def call_operator(operator: Callable[..., set[str]], **properties: object) -> None:
    """Call one of bpy.ops as an undo step of its own. UserError with its report if it fails."""
    try:
        operator("EXEC_DEFAULT", True, **properties)
    except RuntimeError as error:
        raise UserError(str(error).strip().removeprefix("Error: ")) from error


def report_failure(operator: bpy.types.Operator, error: BaseException) -> set[str]:
    """Report an error as one sentence; what was not foreseen goes to the console as well. The result of `execute`."""
    if not is_foreseen(error):
        traceback.print_exception(type(error), error, error.__traceback__)
    operator.report({"ERROR"}, failure_text(error))
    return {"CANCELLED"}

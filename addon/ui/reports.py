# SPDX-License-Identifier: GPL-3.0-or-later
"""How operators end when something fails: with a report, never with an exception."""

from __future__ import annotations

import traceback

import bpy

from ..core.messages import failure_text, is_foreseen


def report_failure(operator: bpy.types.Operator, error: BaseException) -> set[str]:
    """Report an error as one sentence; what was not foreseen goes to the console as well. The result of `execute`."""
    if not is_foreseen(error):
        traceback.print_exception(type(error), error, error.__traceback__)
    operator.report({"ERROR"}, failure_text(error))
    return {"CANCELLED"}

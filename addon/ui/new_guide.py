# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator `curvopt.new_guide`: a curve along selected edges, which they follow from then on."""

from __future__ import annotations

import bpy

from ..scene.write_guide import add_guide
from .reports import report_failure


class CURVOPT_OT_new_guide(bpy.types.Operator):
    """Make a curve along the selected chain of edges, for you to shape, and put it into the collection of Go Through: the chain \
follows it when you minimize in Object Mode"""

    bl_idname = "curvopt.new_guide"
    bl_label = "New Guide"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "EDIT_MESH"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The curve, its vertex group, and the collection at Go Through."""
        settings, active = context.scene.curvopt, context.view_layer.objects.active
        try:
            guide = add_guide(context, active, settings.through)
        except Exception as error:
            return report_failure(self, error)
        settings.through = guide.users_collection[0].name
        self.report({"INFO"}, f"Curve '{guide.name}' and a vertex group of its name: shape the curve, then minimize in Object Mode.")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_new_guide)


def unregister() -> None:
    bpy.utils.unregister_class(CURVOPT_OT_new_guide)

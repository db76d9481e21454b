# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Curvopt" of the 3D view. It draws and decides nothing."""

import textwrap

import bpy

from .job import energy_text
from .properties import state
from .result import stored_energies, stored_verdict

_CHARACTER = 6.5  # pixels, about, at interface scale 1


class CURVOPT_PT_minimize(bpy.types.Panel):
    """Settings, Minimize; energies before and after, and the verdict; the last message"""

    bl_label = "Curvopt"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Curvopt"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        settings = layout.column()
        settings.use_property_split = True
        settings.use_property_decorate = False
        settings.enabled = not state.running
        for name in ("energy", "levels", "boundary", "symmetry", "keep"):
            settings.prop(context.scene.curvopt, name)
        active = context.view_layer.objects.active
        if context.scene.curvopt.keep == "GROUP" and active is not None and active.type == "MESH":
            settings.prop_search(context.scene.curvopt, "vertex_group", active, "vertex_groups", text="Group")
        layout.operator("curvopt.minimize", icon="SPHERECURVE")
        self._draw_energies(context)
        self._draw_message(context)

    def _draw_energies(self, context: bpy.types.Context) -> None:
        rows = stored_energies(context.view_layer.objects.active)
        if not rows:
            return
        box = self.layout.box()
        table = box.column(align=True)
        for label, *values in (("Energy", "Before", "After"), *rows):
            split = table.split(factor=0.4)
            split.label(text=label)
            pair = split.row()
            for value in values:
                pair.label(text=value if isinstance(value, str) else energy_text(value))
        verdict = box.column(align=True)
        for line in _lines(context, stored_verdict(context.view_layer.objects.active)):
            verdict.label(text=line)

    def _draw_message(self, context: bpy.types.Context) -> None:
        icon = "ERROR" if state.failed else "NONE"
        column = self.layout.column(align=True)
        column.alert = state.failed
        for line in _lines(context, state.message):
            column.label(text=line, icon=icon)
            icon = "BLANK1" if state.failed else "NONE"


def _lines(context: bpy.types.Context, text: str) -> list[str]:
    """The text broken to the sidebar's width."""
    width = context.region.width / context.preferences.system.ui_scale - 60
    return textwrap.wrap(text, max(16, int(width / _CHARACTER)))


def register() -> None:
    bpy.utils.register_class(CURVOPT_PT_minimize)


def unregister() -> None:
    bpy.utils.unregister_class(CURVOPT_PT_minimize)

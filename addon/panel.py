# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Curvopt" of the 3D view. It draws and decides nothing."""

import textwrap

import bpy

from .properties import state
from .result import stored_energies

_LINE = 40  # characters of a message per line


class CURVOPT_PT_minimize(bpy.types.Panel):
    """Energy, levels, Minimize; energies before and after; the last message"""

    bl_label = "Curvopt"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Curvopt"

    def draw(self, context):
        layout = self.layout
        settings = layout.column()
        settings.use_property_split = True
        settings.use_property_decorate = False
        settings.enabled = not state.running
        settings.prop(context.scene.curvopt, "energy")
        settings.prop(context.scene.curvopt, "levels")
        layout.operator("curvopt.minimize", icon="SPHERECURVE")
        self._draw_energies(context)
        self._draw_message()

    def _draw_energies(self, context):
        rows = stored_energies(context.view_layer.objects.active)
        if not rows:
            return
        grid = self.layout.box().grid_flow(row_major=True, columns=3, align=True)
        for text in ("Energy", "Before", "After"):
            grid.label(text=text)
        for label, before, after in rows:
            for text in (label, f"{before:.6g}", f"{after:.6g}"):
                grid.label(text=text)

    def _draw_message(self):
        icon = "ERROR" if state.failed else "NONE"
        column = self.layout.column(align=True)
        column.alert = state.failed
        for line in textwrap.wrap(state.message, _LINE):
            column.label(text=line, icon=icon)
            icon = "BLANK1" if state.failed else "NONE"


def register() -> None:
    bpy.utils.register_class(CURVOPT_PT_minimize)


def unregister() -> None:
    bpy.utils.unregister_class(CURVOPT_PT_minimize)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Curvopt" of the 3D view. It draws and decides nothing."""

from __future__ import annotations

import textwrap

import bpy

from ..core.energy import number_text
from ..core.messages import GO_THROUGH_EDIT, GO_THROUGH_LIVE, GO_THROUGH_STRENGTH
from ..scene.amount import has_blend
from ..scene.animation import is_animated
from ..scene.handles import session_of
from ..scene.modifiers import mirror_modifier
from ..scene.placement import active_key
from ..scene.read_cage import has_boundary
from ..scene.read_edit import selection_text
from ..scene.write_result import stored_deviation, stored_energies, stored_verdict
from . import display, inspect
from .display import active_object
from .properties import WEIGHT_TERMS, state
from .wave_length import wave_text

_CHARACTER = 6.5  # pixels, about, at interface scale 1
FREE_BOUNDARY = "Keep Volume needs a boundary that stays: choose another Boundary"


class _Tab:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Curvopt"


class CURVOPT_PT_minimize(_Tab, bpy.types.Panel):
    """Settings, Minimize, and what is going on"""

    bl_label = "Curvopt"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        """The menu of presets, at the right of the panel's title."""
        self.layout.menu("CURVOPT_MT_presets", text="", icon="PRESET")

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, context.scene.curvopt
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.enabled = not state.running
        column.prop(settings, "energy")
        if settings.energy == "MIX":
            weights = column.box().column(align=True)
            for term in WEIGHT_TERMS:
                weights.prop(settings, f"weight_{term}", slider=True)
        column.prop(settings, "strength", slider=True)
        wave = wave_text(context, active_object(context), settings.strength)
        if wave:
            column.label(text=wave)
        if not state.live:
            column.prop(settings, "within")
            column.prop(settings, "no_crossings")
        self._draw_volume(context, column)
        if state.live:
            self._draw_live(context, column)
        elif context.mode == "EDIT_MESH":
            self._draw_edit(context, column)
        else:
            self._draw_object(context, column)
        self._draw_buttons(context)
        self._draw_message(context)

    def _draw_volume(self, context: bpy.types.Context, column: bpy.types.UILayout) -> None:
        """Grey where the run would be refused; it can still be ticked off. In Edit Mode that depends on the selection."""
        settings, active = context.scene.curvopt, active_object(context)
        loose = settings.boundary == "FREE" and context.mode == "OBJECT" and has_boundary(active)
        part = column.column()
        part.active = not loose
        part.prop(settings, "keep_volume")
        if loose:
            for line in _lines(context, FREE_BOUNDARY):
                part.label(text=line)

    def _draw_object(self, context: bpy.types.Context, column: bpy.types.UILayout) -> None:
        settings, active = context.scene.curvopt, active_object(context)
        choice = column.row()
        choice.use_property_split = False
        choice.prop(settings, "resolution", expand=True)
        if settings.resolution == "REFINE":
            column.prop(settings, "levels")
        column.prop(settings, "boundary")
        if settings.boundary != "FREE":  # then nothing is held that could slide
            column.prop(settings, "slide")
        self._draw_symmetry(context, column)
        column.prop(settings, "pin")
        if settings.pin == "GROUP" and active is not None and active.type == "MESH":
            column.prop_search(settings, "vertex_group", active, "vertex_groups", text="Group")
        if settings.pin != "NOTHING":
            column.prop(settings, "pin_surface")
        column.prop_search(settings, "through", bpy.data, "collections")
        if settings.through:
            column.prop(settings, "through_normals")
            column.prop(settings, "through_balls")
            column.prop(settings, "through_weight", slider=True)
            for line in _lines(context, GO_THROUGH_STRENGTH) if settings.strength < 1 else ():
                column.label(text=line)
        self._draw_outcome(context, column, True)

    def _draw_edit(self, context: bpy.types.Context, column: bpy.types.UILayout) -> None:
        """The vertices stay the same, the selection says which move, and the result is where they are."""
        settings = context.scene.curvopt
        sentence = column.column(align=True)
        for line in _lines(context, selection_text(context.view_layer.objects.active)):
            sentence.label(text=line)
        column.prop(settings, "rim")
        column.operator_menu_enum("curvopt.mark_rim", "rim")
        column.operator("curvopt.new_guide")
        column.prop(settings, "boundary")
        if settings.boundary != "FREE":  # then nothing is held that could slide
            column.prop(settings, "slide")
        self._draw_symmetry(context, column)
        self._draw_ignored(context, column, GO_THROUGH_EDIT)

    def _draw_live(self, context: bpy.types.Context, column: bpy.types.UILayout) -> None:
        """What can be changed while the surface follows its handles."""
        column.prop(context.scene.curvopt, "boundary")
        self._draw_symmetry(context, column)
        self._draw_ignored(context, column, GO_THROUGH_LIVE)
        self._draw_outcome(context, column, context.mode == "OBJECT")

    def _draw_outcome(self, context: bpy.types.Context, column: bpy.types.UILayout, has_animation: bool) -> None:
        settings = context.scene.curvopt
        column.prop(settings, "outcome")
        if settings.outcome != "SHAPE_KEY" and has_animation:
            column.prop(settings, "animation")

    def _draw_ignored(self, context: bpy.types.Context, column: bpy.types.UILayout, sentence: str) -> None:
        """That the collection which the surface is to go through does not count here, if one is chosen."""
        if context.scene.curvopt.through:
            lines = column.column(align=True)
            for number, line in enumerate(_lines(context, sentence)):
                lines.label(text=line, icon="NONE" if number else "INFO")

    def _draw_symmetry(self, context: bpy.types.Context, column: bpy.types.UILayout) -> None:
        """With a Mirror modifier there is nothing to choose but further planes."""
        settings, active = context.scene.curvopt, active_object(context)
        mirrored = active is not None and active.type == "MESH" and mirror_modifier(active) is not None
        column.prop(settings, "symmetry")
        if settings.symmetry == "PLANES":
            planes = column.row(heading="Mirror", align=True)
            for index, axis in enumerate("XYZ"):
                planes.prop(settings, "symmetry_planes", index=index, text=axis, toggle=True)
        if mirrored:
            column.label(text="Kept: Mirror modifier", icon="MOD_MIRROR")

    def _draw_buttons(self, context: bpy.types.Context) -> None:
        row = self.layout.row(align=True)
        row.scale_y = 1.4
        if state.running:
            row.operator("curvopt.finish", icon="CHECKMARK")
            row.operator("curvopt.cancel", icon="X")
            return
        if state.live == "ON":
            row.operator("curvopt.live_finish", icon="CHECKMARK")
            row.operator("curvopt.live_cancel", icon="X")
            return
        row.operator("curvopt.minimize", text="Minimize", icon="SPHERECURVE")
        row.operator("curvopt.live", icon="HOOK")
        if state.live or session_of(context.view_layer.objects.active):
            self.layout.operator("curvopt.live_cancel", icon="X")

    def _draw_message(self, context: bpy.types.Context) -> None:
        text, failed = display.message(context)
        has_news = bool(text) and is_animated(active_object(context))  # its shape keys would be refused in place of the news
        if not state.running and not state.live and not failed and not has_news:
            refusal = display.refusal(context)
            failed, text = bool(refusal), refusal or text
        icon = "ERROR" if failed else "NONE"
        column = self.layout.column(align=True)
        column.alert = failed
        for line in _lines(context, text):
            column.label(text=line, icon=icon)
            icon = "BLANK1" if failed else "NONE"


class CURVOPT_PT_report(_Tab, bpy.types.Panel):
    """Energies of the active result before and after, the verdict, and the amount"""

    bl_label = "Report"
    bl_parent_id = "CURVOPT_PT_minimize"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT" and bool(stored_verdict(context.view_layer.objects.active))

    def draw(self, context: bpy.types.Context) -> None:
        active = context.view_layer.objects.active
        key = active_key(active)
        if key is not None:
            self.layout.prop(key, "value", text="Amount", slider=True)
        elif has_blend(active) and not is_animated(active):
            self.layout.prop(active, "curvopt_amount", slider=True)
        table = self.layout.box().column(align=True)
        for label, *values in (("Energy", "Before", "After"), *stored_energies(active)):
            split = table.split(factor=0.4)
            split.label(text=label)
            pair = split.row()
            for value in values:
                pair.label(text=value if isinstance(value, str) else number_text(value))
        verdict = self.layout.column(align=True)
        for line in (*_lines(context, stored_deviation(active)), *_lines(context, stored_verdict(active))):
            verdict.label(text=line)


class CURVOPT_PT_look(_Tab, bpy.types.Panel):
    """Zebra stripes and colours of curvature"""

    bl_label = "Look"
    bl_parent_id = "CURVOPT_PT_minimize"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.row(align=True).prop(context.window_manager, "curvopt_look", expand=True)
        layout.operator("curvopt.curvature", icon="COLOR")
        active = context.view_layer.objects.active
        if active is not None and "curvopt_ranges" in active:
            layout.prop(active, "curvopt_quantity", text="Colour")


class CURVOPT_PT_inspect(_Tab, bpy.types.Panel):
    """Stripes, combs, colours and a probe on the active object itself"""

    bl_label = "Inspect"
    bl_parent_id = "CURVOPT_PT_minimize"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        """The switch, at the left of the panel's title."""
        self.layout.prop(context.window_manager.curvopt_inspect, "is_on", text="")

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.window_manager.curvopt_inspect
        column = self.layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.active = settings.is_on
        column.prop(settings, "kind")
        if settings.kind in ("ZEBRA", "ISOPHOTES"):
            column.prop(settings, "width")
            column.prop(settings, "light")
        if settings.kind == "CURVATURE":
            column.prop(settings, "quantity")
        column.prop(settings, "in_front")
        column.prop(settings, "combs")
        if settings.combs:
            by_planes = settings.comb_curves in inspect.AXES
            for name in ("comb_curves", *(("comb_sections",) if by_planes else ()), "comb_length", "comb_teeth"):
                column.prop(settings, name)
        column.prop(settings, "probe")
        icon = "ERROR"
        for line in _lines(context, inspect.message()):
            column.label(text=line, icon=icon)
            icon = "BLANK1"


class CURVOPT_PT_advanced(_Tab, bpy.types.Panel):
    """What one seldom needs"""

    bl_label = "Advanced"
    bl_parent_id = "CURVOPT_PT_minimize"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.enabled = not state.running
        for name in ("surface", "spontaneous_curvature", "escape", "max_iterations", "threads"):
            column.prop(context.scene.curvopt, name)


def _lines(context: bpy.types.Context, text: str) -> list[str]:
    """The text broken to the sidebar's width."""
    width = context.region.width / context.preferences.system.ui_scale - 60
    return textwrap.wrap(text, max(16, int(width / _CHARACTER)))


_CLASSES = (CURVOPT_PT_minimize, CURVOPT_PT_report, CURVOPT_PT_look, CURVOPT_PT_inspect, CURVOPT_PT_advanced)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

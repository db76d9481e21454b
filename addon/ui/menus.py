# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways in beside the sidebar: menus of Object Mode and of Edit Mode (and so F3), Add > Mesh > Curvature Shapes, presets
of the settings."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from mathutils import Matrix

from ..core import catalogue
from ..scene import write_result
from . import properties
from .reports import report_failure

_PRESETS = "curvopt"  # folder of the user's own, beside those of render sizes and the like
_SHIPPED = Path(__file__).resolve().parents[1] / "presets"
_items: list[tuple[str, str, str]] = []  # kept, because Blender does not keep what a callback returns


def _shapes(_self: object, _context: bpy.types.Context) -> list[tuple[str, str, str]]:
    """The choices of the enumeration `shape`."""
    _items[:] = [(name, catalogue.label(name), "Add this cage") for name in catalogue.names()]
    return _items


class CURVOPT_OT_add_shape(bpy.types.Operator):
    """Add an example cage whose curvature can be minimized"""

    bl_idname = "curvopt.add_shape"
    bl_label = "Curvature Shape"
    bl_options = {"REGISTER", "UNDO"}

    shape: bpy.props.EnumProperty(name="Shape", description="The cage to add", items=_shapes)
    size: bpy.props.FloatProperty(
        name="Size", description="Factor by which the cage is scaled", default=1.0, min=1e-3, max=1e3,
        subtype="DISTANCE",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add it at the 3D cursor, active and alone selected."""
        try:
            cage = catalogue.load(self.shape)
        except (OSError, ValueError) as error:
            return report_failure(self, error)
        name = catalogue.label(self.shape)
        mesh = write_result.make_mesh(name, cage)
        mesh.transform(Matrix.Scale(self.size, 4))
        obj = bpy.data.objects.new(name, mesh)
        obj.location = context.scene.cursor.location
        write_result.add_subdivision(obj, cage.creases)
        context.collection.objects.link(obj)
        write_result.select_alone(context, obj)
        return {"FINISHED"}


class CURVOPT_MT_shapes(bpy.types.Menu):
    """Cages to start from"""

    bl_idname = "CURVOPT_MT_shapes"
    bl_label = "Curvature Shapes"

    def draw(self, context: bpy.types.Context) -> None:
        for name in catalogue.names():
            self.layout.operator("curvopt.add_shape", text=catalogue.label(name)).shape = name


class CURVOPT_MT_presets(bpy.types.Menu):
    """Settings for common tasks, and your own"""

    bl_label = "Curvopt Presets"

    def draw(self, context: bpy.types.Context) -> None:
        folders = [str(_SHIPPED), *bpy.utils.preset_paths(_PRESETS)]
        chosen = {"menu_idname": "CURVOPT_MT_presets"}
        self.path_menu(folders, "script.execute_preset", props_default=chosen, filter_ext=lambda end: end == ".py")
        self.layout.separator()
        self.layout.operator("curvopt.preset_add", text="Save These Settings…", icon="ADD")
        self.layout.operator("curvopt.preset_add", text="Remove Last Chosen", icon="REMOVE").remove_active = True


class CURVOPT_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Save the settings of this panel under a name, or remove the preset that was chosen last"""

    bl_idname = "curvopt.preset_add"
    bl_label = "Add Curvopt Preset"
    preset_menu = "CURVOPT_MT_presets"
    preset_subdir = _PRESETS
    preset_values = [f"bpy.context.scene.curvopt.{name}" for name in properties.SETTINGS if name not in ("vertex_group", "through")]


def _in_object_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.operator("curvopt.minimize", icon="SPHERECURVE")
    menu.layout.operator("curvopt.curvature", icon="COLOR")


def _in_edit_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.operator("curvopt.minimize", icon="SPHERECURVE")


def _in_edge_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.operator_menu_enum("curvopt.mark_rim", "rim")
    menu.layout.operator("curvopt.new_guide")


def _in_vertex_context_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The context menu of Edit Mode is one for vertices, edges and faces."""
    if context.tool_settings.mesh_select_mode[0]:
        _in_edit_menu(menu, context)


def _in_add_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.menu("CURVOPT_MT_shapes", icon="SPHERECURVE")


_ADDED = (
    ("VIEW3D_MT_object", _in_object_menu),
    ("VIEW3D_MT_mesh_add", _in_add_menu),
    ("VIEW3D_MT_edit_mesh_clean", _in_edit_menu),
    ("VIEW3D_MT_edit_mesh_vertices", _in_edit_menu),
    ("VIEW3D_MT_edit_mesh_context_menu", _in_vertex_context_menu),
    ("VIEW3D_MT_edit_mesh_edges", _in_edge_menu),
)
_CLASSES = (CURVOPT_OT_add_shape, CURVOPT_MT_shapes, CURVOPT_MT_presets, CURVOPT_OT_preset_add)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for name, draw in _ADDED:
        getattr(bpy.types, name).append(draw)


def unregister() -> None:
    for name, draw in reversed(_ADDED):
        getattr(bpy.types, name).remove(draw)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator `curvopt.mark_rim`: what single edges hold where they are the rim of a selection, or a boundary."""

from __future__ import annotations

import bmesh
import bpy

from ..core.rims import MARKS
from ..scene.read_marks import MARK
from . import properties

_CLEAR = ("CLEAR", "Clear", "Takes the marks away: Rim and Boundary say what stays")


class CURVOPT_OT_mark_rim(bpy.types.Operator):
    """Say for the selected edges what stays there when they are the rim of what is made fair, or a boundary"""

    bl_idname = "curvopt.mark_rim"
    bl_label = "Mark Rim"
    bl_options = {"REGISTER", "UNDO"}

    rim: bpy.props.EnumProperty(
        name="Rim", description="What stays at these edges", items=(*properties.RIMS, _CLEAR), default="TANGENT"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "EDIT_MESH"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Mark the selected edges of all meshes that are edited."""
        value = 0 if self.rim == "CLEAR" else MARKS.index(self.rim.lower())
        count = sum(_mark(obj.data, value) for obj in context.objects_in_mode_unique_data if obj.type == "MESH")
        if not count:
            self.report({"ERROR"}, "No edge is selected: select some first.")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} {'edge' if count == 1 else 'edges'} {'marked' if value else 'cleared'}")
        return {"FINISHED"}


def _mark(mesh: bpy.types.Mesh, value: int) -> int:
    """Mark the selected edges of a mesh that is edited; how many they are."""
    edited = bmesh.from_edit_mesh(mesh)
    layer = edited.edges.layers.int.get(MARK)
    if layer is None and value and any(edge.select for edge in edited.edges):
        layer = edited.edges.layers.int.new(MARK)
    chosen = [edge for edge in edited.edges if edge.select and not edge.hide]  # after the layer, which moves edges
    if layer is not None:
        for edge in chosen:
            edge[layer] = value
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
    return len(chosen)


def register() -> None:
    bpy.utils.register_class(CURVOPT_OT_mark_rim)


def unregister() -> None:
    bpy.utils.unregister_class(CURVOPT_OT_mark_rim)

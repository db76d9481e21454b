# SPDX-License-Identifier: GPL-3.0-or-later
"""How fair is a surface? The operator that makes a surface coloured by curvature, and the viewport's looks.

The coloured surface is a new object beside the cage: points of the limit surface itself, with a colour attribute of
each quantity, and the numbers as attributes called `H`, `K` and so on. The legend is drawn over the viewport while such
an object is active.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..binding import library
from ..binding.values import Cage
from ..core import colours, curvature, surface_points
from ..scene import read_cage, write_result
from .reports import report_failure

_PREFIX = "Curvopt "  # of colour attributes
_ZEBRA = ("reflection_check_horizontal.exr", "check_reflection_horizontal.exr")  # matcaps, until 4.x, from 5.x
_QUANTITY_ITEMS = [(name, label, tip) for name, label, tip in colours.QUANTITIES]
_LOOKS = (
    ("PLAIN", "Plain", "Studio light and material colours"),
    ("ZEBRA", "Zebra", "Reflected stripes. They have kinks where the surface is not smooth"),
    ("COLOURS", "Curvature", "Shows colour attributes, such as those of Colour by Curvature"),
)
_MOST_QUADS = 400_000


class CURVOPT_OT_curvature(bpy.types.Operator):
    """Make a copy of the active cage's limit surface, coloured by curvature"""

    bl_idname = "curvopt.curvature"
    bl_label = "Colour by Curvature"
    bl_options = {"REGISTER", "UNDO"}

    quantity: bpy.props.EnumProperty(
        name="Colour", description="The curvature that is shown; the others are attributes of the result, too",
        items=_QUANTITY_ITEMS, default="H",
    )  # fmt: skip
    levels: bpy.props.IntProperty(
        name="Levels", description="How often the cage is subdivided. Curvature is measured at the vertices that this "
        "gives", default=3, min=0, max=6,
    )  # fmt: skip

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make it, and show colours in all viewports."""
        try:
            source = read_cage.read_source(context, context.view_layer.objects.active)
            if len(source.cage.face_sizes) * 4**self.levels > _MOST_QUADS:
                raise read_cage.CageError(f"More than {_MOST_QUADS:,} faces would come out: choose fewer levels.")
            add_coloured(context, source, self.levels, self.quantity)
        except Exception as error:
            return report_failure(self, error)
        if not bpy.app.background:
            context.window_manager.curvopt_look = "COLOURS"
        return {"FINISHED"}


def add_coloured(context: bpy.types.Context, source: read_cage.Source, levels: int, quantity: str) -> bpy.types.Object:
    """The coloured surface as a new, active object beside the cage."""
    with library.Mesh.of_cage(library.load(), source.cage) as mesh:
        net = surface_points.lattice(mesh, levels)
        jets = net.jets(mesh, source.cage.positions)
    points = jets[:, 0]
    surface = write_result.make_mesh(
        f"{source.name} Curvature",
        Cage(points, np.full(len(net.quads), 4, np.int32), net.quads.reshape(-1).astype(np.int32)),
    )
    ranges = _colour(surface, colours.of_curvatures(curvature.of_jets(jets)))
    obj = bpy.data.objects.new(f"{source.name} Curvature", surface)
    obj.matrix_world = write_result.beside(context.scene, source, points) @ source.frame
    obj["curvopt_ranges"], obj["curvopt_source"] = ranges, source.name
    write_result.link_beside(context, write_result.local_object(source.name), obj)
    write_result.select_alone(context, obj)
    obj.curvopt_quantity = quantity
    return obj


def _colour(surface: bpy.types.Mesh, values: dict[str, np.ndarray]) -> dict[str, list[float]]:
    """Attributes for every quantity; the ranges of their colours."""
    ranges = {}
    for name, numbers in values.items():
        low, high = colours.value_range(name, numbers)
        ranges[name] = [low, high]
        plain = surface.attributes.new(name, "FLOAT", "POINT")
        plain.data.foreach_set("value", np.nan_to_num(numbers).astype(np.float32))
        painted = surface.color_attributes.new(_PREFIX + name, "FLOAT_COLOR", "POINT")
        rgba = colours.linear(colours.colours(name, numbers, low, high))
        painted.data.foreach_set("color", np.ascontiguousarray(rgba).reshape(-1))
    return ranges


def _choose_quantity(obj: bpy.types.Object, _context: bpy.types.Context) -> None:
    if obj.type != "MESH":
        return
    attribute = obj.data.color_attributes.get(_PREFIX + obj.curvopt_quantity)
    if attribute is not None:
        obj.data.color_attributes.active_color = attribute
        obj.data.update()


def _choose_look(manager: bpy.types.WindowManager, _context: bpy.types.Context) -> None:
    """Set solid shading of all 3D views to a look."""
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                _set_look(area.spaces.active.shading, manager.curvopt_look)


def _set_look(shading: bpy.types.View3DShading, look: str) -> None:
    shading.type = "SOLID"
    shading.light = "MATCAP" if look == "ZEBRA" else "STUDIO"
    shading.color_type = {"PLAIN": "MATERIAL", "ZEBRA": "SINGLE", "COLOURS": "VERTEX"}[look]
    if look == "ZEBRA":
        shading.single_color = (1.0, 1.0, 1.0)
        present = {light.name for light in bpy.context.preferences.studio_lights if light.type == "MATCAP"}
        shading.studio_light = next((name for name in _ZEBRA if name in present), shading.studio_light)


def legend(obj: bpy.types.Object | None) -> tuple[str, str, float, float] | None:
    """(quantity, label, low, high) of the colours that a coloured surface shows; None for other objects."""
    if obj is None or "curvopt_ranges" not in obj:
        return None
    name = obj.curvopt_quantity
    low, high = obj["curvopt_ranges"][name]
    return name, dict((n, label) for n, label, _ in colours.QUANTITIES)[name], low, high


def _draw_legend() -> None:
    """At the lower right of a viewport whose active object is coloured."""
    from . import overlay  # needs a GPU

    found = legend(bpy.context.view_layer.objects.active)
    if found is None or not bpy.context.space_data.overlay.show_overlays:
        return
    name, label, low, high = found
    overlay.legend(label, low, high, lambda values: colours.colours(name, values, low, high))


_handler = None


def register() -> None:
    global _handler
    bpy.utils.register_class(CURVOPT_OT_curvature)
    bpy.types.Object.curvopt_quantity = bpy.props.EnumProperty(
        name="Colour", description="What the colours of this surface mean", items=_QUANTITY_ITEMS,
        update=_choose_quantity,
    )  # fmt: skip
    bpy.types.WindowManager.curvopt_look = bpy.props.EnumProperty(
        name="Look", description="How 3D views show surfaces", items=_LOOKS, update=_choose_look
    )
    if not bpy.app.background:
        from .overlay import Handler  # needs a GPU

        _handler = Handler(_draw_legend, "POST_PIXEL")


def unregister() -> None:
    global _handler
    if _handler is not None:
        _handler.remove()
        _handler = None
    del bpy.types.WindowManager.curvopt_look, bpy.types.Object.curvopt_quantity
    bpy.utils.unregister_class(CURVOPT_OT_curvature)

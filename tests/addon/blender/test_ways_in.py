# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus, presets, shapes, tooltips; colours of curvature and looks."""

import ast
import re
from pathlib import Path

import bpy
import numpy as np
import pytest
import shapes


def drawn_by(menu, part):
    """Operators and menus that a menu of Blender's draws because of us."""

    class Layout:
        def __init__(self):
            self.seen = []

        def operator(self, name, **_):
            self.seen.append(name)
            return type("Arguments", (), {})()

        def operator_menu_enum(self, name, _property):
            self.seen.append(name)

        def menu(self, name, **_):
            self.seen.append(name)

        def separator(self, **_):
            pass

    layout = Layout()
    for function in menu._dyn_ui_initialize():
        if function.__module__ == part("ui.menus").__name__:
            function(type("Menu", (), {"layout": layout})(), bpy.context)
    return layout.seen


def test_object_menu_and_add_menu_lead_here(part):
    assert drawn_by(bpy.types.VIEW3D_MT_object, part) == ["curvopt.minimize", "curvopt.curvature"]
    assert drawn_by(bpy.types.VIEW3D_MT_mesh_add, part) == ["CURVOPT_MT_shapes"]


def test_menus_of_edit_mode_lead_here(part):
    for name in ("clean", "vertices", "context_menu"):
        assert drawn_by(getattr(bpy.types, f"VIEW3D_MT_edit_mesh_{name}"), part) == ["curvopt.minimize"]
    assert drawn_by(bpy.types.VIEW3D_MT_edit_mesh_edges, part) == ["curvopt.mark_rim", "curvopt.new_guide"]


def test_every_control_has_a_tooltip(part):
    names = [name for name in dir(bpy.ops.curvopt) if not name.startswith("__")]
    assert {"minimize", "finish", "cancel", "curvature", "add_shape", "preset_add"} <= set(names)
    for name in names:
        assert len(getattr(bpy.ops.curvopt, name).get_rna_type().description) > 10, name
    settings = part("ui.properties").CURVOPT_PG_settings.bl_rna.properties
    types = ((bpy.types.Object, "curvopt_amount"), (bpy.types.WindowManager, "curvopt_look"))
    others = [owner.bl_rna.properties[name] for owner, name in types]
    inspect = part("ui.inspect").CURVOPT_PG_inspect
    others += [inspect.bl_rna.properties[name] for name in inspect.__annotations__]
    for prop in [*(settings[name] for name in part("ui.properties").SETTINGS), *others]:
        assert len(prop.description) > 10, prop.identifier
        for item in getattr(prop, "enum_items", ()):
            assert len(item.description) > 10, (prop.identifier, item.identifier)


def test_what_the_adjust_panel_repeats_is_writing_a_result_not_a_run(part):
    """A run's own operator neither registers nor is an undo step: adjusting would freeze Blender for as long as it
    takes. What applies its result is both."""
    assert part("ui.operators").CURVOPT_OT_minimize.bl_options == set()
    assert {"REGISTER", "UNDO"} <= part("ui.adjust").CURVOPT_OT_apply_result.bl_options
    assert "REGISTER" in part("ui.analysis").CURVOPT_OT_curvature.bl_options


# ------------------------------------------------------------------------------------------------ shapes, presets --


def test_every_shape_of_the_catalogue_can_be_added(part):
    catalogue = part("core.catalogue")
    assert len(catalogue.names()) >= 14
    bpy.context.scene.cursor.location = (1, 2, 3)
    for name in catalogue.names():
        assert bpy.ops.curvopt.add_shape(shape=name, size=2.0) == {"FINISHED"}
        obj = bpy.context.view_layer.objects.active
        assert tuple(obj.location) == (1, 2, 3) and obj.name == catalogue.label(name)
        assert len(obj.data.vertices) == len(catalogue.load(name).positions) and obj.modifiers[0].type == "SUBSURF"
        reach = np.abs(catalogue.load(name).positions).max()
        assert max(abs(c) for v in obj.data.vertices for c in v.co) == pytest.approx(2 * reach, rel=1e-5)


def test_shapes_can_be_minimized_as_they_are():
    bpy.ops.curvopt.add_shape(shape="torus_050")
    assert bpy.ops.curvopt.minimize(energy="WILLMORE", levels=2) == {"FINISHED"}


def test_shipped_presets_set_the_settings(part):
    settings = bpy.context.scene.curvopt
    presets = sorted((Path(part("ui").__file__).parents[1] / "presets").glob("*.py"))
    assert len(presets) >= 5
    for path in presets:
        settings.energy = "VARIATION"  # of no preset
        assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname="CURVOPT_MT_presets") == {"FINISHED"}
        written = dict(re.findall(r"^settings\.(\w+) = (.+)$", path.read_text(), re.MULTILINE))
        assert {"strength", "resolution"} <= set(written), path
        for name, value in written.items():
            wanted = ast.literal_eval(value)
            wanted = pytest.approx(wanted) if isinstance(wanted, float) else wanted
            assert getattr(settings, name) == wanted, (path, name)
        assert (settings.energy != "VARIATION") == ("energy" in written), path


@pytest.mark.parametrize("name", ["Global_Minimum", "Soap_Film", "Round_Arms"])
def test_presets_of_minimizers_go_all_the_way(newcomer, part, name):
    path = Path(part("ui").__file__).parents[1] / "presets" / f"{name}.py"
    bpy.ops.script.execute_preset(filepath=str(path), menu_idname="CURVOPT_MT_presets")
    assert (newcomer.strength, newcomer.resolution, newcomer.levels) == (1.0, "REFINE", 4)


def test_own_presets_are_saved_and_read_back(monkeypatch, tmp_path):
    settings = bpy.context.scene.curvopt
    settings.energy, settings.weight_area, settings.levels = "MIX", 0.125, 3
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_, **__: str(tmp_path))
    assert bpy.ops.curvopt.preset_add(name="Mine") == {"FINISHED"}
    saved = next(tmp_path.rglob("*.py"))
    settings.energy, settings.weight_area, settings.levels = "MVS", 0.0, 1
    bpy.ops.script.execute_preset(filepath=str(saved), menu_idname="CURVOPT_MT_presets")
    assert (settings.energy, settings.weight_area, settings.levels) == ("MIX", 0.125, 3)


# -------------------------------------------------------------------------------------------- colours of curvature --


def coloured(levels=2, quantity="H"):
    assert bpy.ops.curvopt.curvature(levels=levels, quantity=quantity) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def test_coloured_surface_lies_on_the_limit_surface_and_has_every_quantity(torus, part):
    obj = coloured()
    assert obj.name == "Torus Curvature" and len(obj.data.vertices) == 512
    names = [name for name, _, _ in part("core.colours").QUANTITIES]
    assert [a.name for a in obj.data.color_attributes] == ["Curvopt " + name for name in names]
    for name in names:
        values = np.empty(512, np.float32)
        obj.data.attributes[name].data.foreach_get("value", values)
        assert np.isfinite(values).all() and np.ptp(values) > 0
    assert torus.location.x < obj.location.x


def test_numbers_are_those_of_a_sphere_on_a_nearly_round_cage(part):
    bpy.ops.curvopt.add_shape(shape="sphere_cube")
    bpy.ops.curvopt.minimize(energy="WILLMORE", levels=2, outcome="REPLACE")
    cage = bpy.context.view_layer.objects.active
    reach = np.array([v.co.length for v in cage.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices])
    obj = coloured()
    values = np.empty(len(obj.data.vertices), np.float32)
    obj.data.attributes["H"].data.foreach_get("value", values)
    assert np.median(values) == pytest.approx(1 / reach.mean(), rel=1e-2)


def test_quantity_chooses_the_colours_and_the_legend(torus, part):
    obj = coloured(quantity="K")
    legend = part("ui.analysis").legend
    assert obj.data.color_attributes.active_color.name == "Curvopt K" and legend(obj)[:2] == ("K", "Gauss K")
    obj.curvopt_quantity = "variation"
    assert obj.data.color_attributes.active_color.name == "Curvopt variation"
    name, _, low, high = legend(obj)
    assert name == "variation" and low == 0 < high
    assert legend(torus) is None and legend(None) is None


def test_colours_at_the_ends_of_the_range(torus):
    """Most positive is red, most negative blue, in scene-linear colour."""
    obj = coloured(quantity="K", levels=3)
    values, rgba = np.empty(len(obj.data.vertices), np.float32), np.empty(4 * len(obj.data.vertices), np.float32)
    obj.data.attributes["K"].data.foreach_get("value", values)
    obj.data.color_attributes["Curvopt K"].data.foreach_get("color", rgba)
    rgba = rgba.reshape(-1, 4)
    low, high = rgba[values.argmin()], rgba[values.argmax()]
    assert low[2] > 2 * low[0] and high[0] > 2 * high[2]


def test_too_many_faces_are_refused(torus, contents):
    bpy.context.view_layer.objects.active = torus
    points, faces = shapes.torus(60, 30)
    torus.data.clear_geometry()
    torus.data.from_pydata([tuple(p) for p in points], [], faces)
    before = contents()
    with pytest.raises(RuntimeError, match="choose fewer levels"):
        bpy.ops.curvopt.curvature(levels=6)
    assert contents() == before


def test_what_cannot_be_coloured_is_refused(torus, contents):
    torus.modifiers.new("Row", "ARRAY")
    before = contents()
    with pytest.raises(RuntimeError, match="Modifier 'Row'"):
        bpy.ops.curvopt.curvature()
    assert contents() == before


@pytest.mark.parametrize("look, light, colour", [("ZEBRA", "MATCAP", "SINGLE"), ("COLOURS", "STUDIO", "VERTEX")])
def test_looks_set_solid_shading(look, light, colour, part):
    shading = bpy.context.scene.display.shading
    part("ui.analysis")._set_look(shading, look)
    assert (shading.light, shading.color_type) == (light, colour)
    part("ui.analysis")._set_look(shading, "PLAIN")
    assert (shading.light, shading.color_type) == ("STUDIO", "MATERIAL")

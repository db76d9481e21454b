# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.curvopt.minimize` from end to end, and the object that comes out."""

import os

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Matrix
from mathutils.kdtree import KDTree
from runs import positions


def minimize(energy="WILLMORE", levels=2):
    assert bpy.ops.curvopt.minimize(energy=energy, levels=levels) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def world_positions(obj):
    bpy.context.view_layer.update()
    matrix = np.array(obj.matrix_world)
    return positions(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def test_result_is_a_new_object_and_the_original_is_kept(torus, contents):
    before = contents()["objects"]["Torus"]
    result = minimize()
    assert contents()["objects"]["Torus"] == before
    assert result is not torus and result.data is not torus.data and result.name == "Torus Willmore"
    assert len(result.data.vertices) == 128 and len(result.data.polygons) == 128
    assert result.select_get() and not torus.select_get()
    assert not result.data.validate() and all(polygon.use_smooth for polygon in result.data.polygons)
    assert result["curvopt_after_willmore"] < result["curvopt_before_willmore"]
    assert (result["curvopt_source"], result["curvopt_energy"]) == ("Torus", "willmore")


def test_a_result_that_is_minimized_again_is_counted_on(torus):
    names = [minimize(energy, levels=1).name for energy in ("WILLMORE", "WILLMORE", "WILLMORE", "MVS")]
    assert names == ["Torus Willmore", "Torus Willmore.001", "Torus Willmore.002", "Torus Willmore.002 MVS"]


def test_open_cage_keeps_its_boundary(add):
    points, faces = shapes.torus()
    add(points, faces[1:])
    result = minimize(levels=1)
    assert result["curvopt_after_willmore"] < result["curvopt_before_willmore"]
    moved = np.linalg.norm(positions(result) - points, axis=1)
    assert moved[faces[0]].max() < 1e-6 < moved.max()


def test_result_stands_beside_the_original_and_earlier_results(torus):
    first = minimize(levels=1)
    bpy.context.view_layer.objects.active = torus
    second = minimize("MVS", levels=1)
    ends = [(p[:, 0].min(), p[:, 0].max()) for p in map(world_positions, (torus, first, second))]
    assert ends[0][1] < ends[1][0] < ends[1][1] < ends[2][0]
    assert first.location.yz == second.location.yz == torus.location.yz


@pytest.mark.parametrize("energy, label", [("WILLMORE", "Willmore"), ("MVS", "MVS"), ("MVS_CROSS", "MVS_cross")])
def test_every_energy_of_the_panel_falls(torus, energy, label):
    result = minimize(energy, levels=1)
    assert result.name == f"Torus {label}"
    term = energy.lower()
    assert 0 < result[f"curvopt_after_{term}"] < result[f"curvopt_before_{term}"]


def test_settings_of_the_scene_are_used_when_the_call_gives_none(torus):
    bpy.context.scene.curvopt.energy = "MVS_CROSS"
    bpy.context.scene.curvopt.levels = 1
    assert bpy.ops.curvopt.minimize() == {"FINISHED"}
    result = bpy.context.view_layer.objects.active
    assert result.name == "Torus MVS_cross" and len(result.data.vertices) == 32


def test_invoke_in_background_is_the_whole_run(torus):
    assert bpy.ops.curvopt.minimize("INVOKE_DEFAULT", energy="WILLMORE", levels=1) == {"FINISHED"}
    assert bpy.context.view_layer.objects.active.name == "Torus Willmore"


def test_modifier_shows_the_limit_surface(torus, part):
    result = minimize()
    modifier = result.modifiers[0]
    assert len(result.modifiers) == 1 and modifier.type == "SUBSURF"
    assert modifier.use_limit_surface and modifier.boundary_smooth == "ALL"
    assert modifier.quality >= modifier.levels == modifier.render_levels >= 1
    assert _distance_to_limit(result, part) < 1e-6 * max(result.dimensions)


def test_modifier_shows_the_limit_surface_at_extraordinary_vertices(add, part):
    points, faces = shapes.cube()
    add(points * [1.0, 1.3, 0.8], faces)
    assert _distance_to_limit(minimize(levels=1), part) < 1e-6 * 2.6


def _distance_to_limit(result, part):
    """Largest distance of the limit points at face corners and middles from the evaluated mesh's vertices."""
    library, cage = part("binding.library"), part("scene.read_cage")
    sizes, vertices = cage.read_faces(result.data)
    n = len(sizes)
    assert (sizes == 4).all()
    uv = [[0, 0]] * n + [[0.5, 0.5]] * n
    xyz = cage.read_positions(result.data)
    with library.Mesh.create(library.load(), len(xyz), sizes, vertices) as mesh:
        limit = mesh.jets(xyz, list(range(n)) * 2, [0] * 2 * n, uv)[:, 0]
    assert np.isfinite(limit).all()
    shown = result.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    tree = KDTree(len(shown.vertices))
    for vertex in shown.vertices:
        tree.insert(vertex.co, vertex.index)
    tree.balance()
    return max(tree.find(point)[2] for point in limit)


def test_stored_energies_are_those_of_the_two_cages(torus, part):
    """To the default quadrature tolerance, 1e-4 each."""
    library, cage = part("binding.library"), part("scene.read_cage")
    result = minimize("WILLMORE", 1)
    lib = library.load()
    for obj, when in ((torus, "before"), (result, "after")):
        with library.Mesh.create(lib, len(obj.data.vertices), *cage.read_faces(obj.data)) as mesh:
            with library.Problem.create(mesh, lib.options({"willmore": 1.0})) as problem:
                energies, _ = problem.evaluate(cage.read_positions(obj.data))
        assert result[f"curvopt_{when}_willmore"] == pytest.approx(energies.terms["willmore"], rel=2e-4)


def test_materials_follow_their_faces(torus):
    for name in ("Red", "Blue"):
        torus.data.materials.append(bpy.data.materials.new(name))
    torus.data.polygons.foreach_set("material_index", [1] * 5 + [0] * 27)
    result = minimize()
    assert [material.name for material in result.data.materials] == ["Red", "Blue"]
    assert [polygon.material_index for polygon in result.data.polygons] == [1] * 20 + [0] * 108


def test_result_is_linked_where_the_original_is(torus):
    inner = bpy.data.collections.new("Inner")
    bpy.context.scene.collection.children.link(inner)
    inner.objects.link(torus)
    bpy.context.scene.collection.objects.unlink(torus)
    assert [collection.name for collection in minimize(levels=1).users_collection] == ["Inner"]


def test_catmull_clark_modifier_on_the_original_is_welcome(torus):
    torus.modifiers.new("Subdivision", "SUBSURF")
    assert len(minimize(levels=1).data.vertices) == 32


def test_modifier_that_is_switched_off_is_ignored(torus):
    mirror = torus.modifiers.new("Mirror", "MIRROR")
    mirror.show_viewport = mirror.show_render = False
    assert len(minimize(levels=1).data.vertices) == 32


# ------------------------------------------------------------------------------------------ the object's matrix --


def test_energies_are_those_of_the_world_space_shape(torus, add):
    points, faces = shapes.torus()
    torus.scale = (1.0, 1.0, 1.6)
    torus.rotation_euler = (0.3, -0.2, 0.9)
    scaled = minimize("WILLMORE", 1)
    add(points * [1.0, 1.0, 1.6], faces, "Applied")
    applied = minimize("WILLMORE", 1)
    for key in ("curvopt_before_willmore", "curvopt_after_willmore"):
        assert scaled[key] == pytest.approx(applied[key], rel=1e-5)
    assert tuple(scaled.scale) == pytest.approx((1, 1, 1), abs=1e-6)


def test_location_rotation_and_size_are_kept(torus):
    torus.matrix_world = Matrix.Translation((5, -3, 2)) @ Matrix.Rotation(0.7, 4, "X") @ Matrix.Scale(3, 4)
    bpy.context.view_layer.update()
    result = minimize(levels=1)
    assert result.rotation_euler.x == pytest.approx(0.7, abs=1e-6)
    middle, original = world_positions(result).mean(0), world_positions(torus).mean(0)
    assert middle[1:] == pytest.approx(original[1:], abs=1e-4)
    assert 0.5 < np.ptp(world_positions(result)) / np.ptp(world_positions(torus)) < 2


@pytest.mark.parametrize("scale", [(-1, 1, 1), (1, -2, 1), (-1, -1, -1), (-1, -1, 1)])
def test_mirrored_object_gives_a_surface_that_faces_outwards(torus, scale):
    torus.scale = scale
    result = minimize(levels=1)
    faces = [list(polygon.vertices) for polygon in result.data.polygons]
    assert shapes.enclosed_volume(positions(result), faces) > 0
    assert result.matrix_world.determinant() == pytest.approx(1, abs=1e-5)
    if max(map(abs, scale)) == 1:
        assert result["curvopt_before_willmore"] == pytest.approx(_plain_willmore(), rel=1e-5)


def _plain_willmore():
    points, faces = shapes.torus()
    mesh = bpy.data.meshes.new("Plain")
    mesh.from_pydata([tuple(p) for p in points], [], faces)
    plain = bpy.data.objects.new("Plain", mesh)
    bpy.context.scene.collection.objects.link(plain)
    bpy.context.view_layer.objects.active = plain
    return minimize(levels=1)["curvopt_before_willmore"]


# -------------------------------------------------------------------------------------------------- panel, undo --


def test_sidebar_reads_energies_of_a_result_only(torus, part):
    stored = part("scene.write_result").stored_energies
    assert stored(None) == [] and stored(torus) == []
    rows = {label: (before, after) for label, before, after in stored(minimize(levels=1))}
    assert rows["Willmore"][1] < rows["Willmore"][0]
    assert part("ui.properties").state.message.startswith("Willmore ")
    assert not part("ui.properties").state.running and not part("ui.properties").state.failed


def test_run_is_one_undo_step(torus, contents):
    bpy.ops.ed.undo_push(message="Torus added")
    before = contents()
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy="WILLMORE", levels=1) == {"FINISHED"}
    assert "Torus Willmore" in bpy.data.objects
    bpy.ops.ed.undo()
    assert contents() == before
    bpy.ops.ed.redo()
    assert "Torus Willmore" in bpy.data.objects


def test_addon_goes_off_and_on_again(torus):
    import addon_utils

    name = os.environ["CURVOPT_TEST_NAME"]
    addon_utils.disable(name)
    assert not hasattr(bpy.types.Scene, "curvopt") and not hasattr(bpy.types, "CURVOPT_PT_minimize")
    assert addon_utils.enable(name) is not None
    assert hasattr(bpy.types, "CURVOPT_PT_minimize")
    assert minimize(levels=1).name == "Torus Willmore"


def test_addon_that_goes_on_again_has_no_part_of_its_former_self(torus, part):
    import addon_utils

    old = {name: part(name) for name in ("core.job", "core.memory", "scene.read_cage")}
    addon_utils.disable(os.environ["CURVOPT_TEST_NAME"])
    assert addon_utils.enable(os.environ["CURVOPT_TEST_NAME"]) is not None
    operators = part("ui.operators")
    assert operators.job is part("core.job") is not old["core.job"]
    assert operators.read_cage is part("scene.read_cage") is not old["scene.read_cage"]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Live from scripts: where handles are, what they hold, where the result is, and what is left in the file."""

import bpy
import numpy as np
import pytest
import shapes
from test_mirror import quarter_torus, with_modifiers
from test_pins import add_group, positions, select

HANDLES = [0, 9, 18, 27]


@pytest.fixture
def shaken(add):
    """A torus without symmetry, four vertices of which are selected."""
    points, faces = shapes.torus()
    obj = add(points + 0.05 * np.random.default_rng(3).normal(size=points.shape), faces)
    select(obj, HANDLES)
    for parts in (obj.data.edges, obj.data.polygons):  # else Edit Mode selects their vertices
        parts.foreach_set("select", np.zeros(len(parts), bool))
    return obj


@pytest.fixture(autouse=True)
def quick():
    settings = bpy.context.scene.curvopt
    settings.energy, settings.pin, settings.symmetry = "WILLMORE", "SELECTED", "AUTO"


@pytest.fixture
def empties(part):
    return part("scene.handles").empties


def world(obj):
    """Its vertices (n, 3) in the world."""
    matrix = np.array(obj.matrix_world, float)
    return positions(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def finish():
    bpy.context.view_layer.update()
    assert bpy.ops.curvopt.live_finish() == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def is_clean(obj):
    return not any(name.startswith("curvopt_h") for o in bpy.data.objects for name in o.keys()) and (
        obj.display_type == "TEXTURED" and "curvopt_display" not in obj
    )


def test_the_result_goes_through_the_handles(shaken, empties):
    """Also of an object that is moved, turned and scaled unevenly."""
    shaken.location, shaken.rotation_euler, shaken.scale = (3, -2, 1), (0.3, 0.2, 0.1), (1, 2, 0.5)
    before = positions(shaken)
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    found = empties(shaken)
    assert sorted(found) == HANDLES and shaken.display_type == "WIRE"
    bpy.context.view_layer.update()
    assert all(np.abs(np.array(found[v].matrix_world.translation) - world(shaken)[v]).max() < 1e-5 for v in HANDLES)
    for handle in found.values():
        handle.location.z += 0.2
    bpy.context.view_layer.update()
    wanted = np.array([found[v].matrix_world.translation for v in HANDLES])
    result = finish()
    assert result != shaken and is_clean(shaken) and len(bpy.data.objects) == 2
    assert np.array_equal(positions(shaken), before)
    shift = np.array(result.matrix_world.translation) - np.array(shaken.matrix_world.translation)
    assert np.abs(world(result)[HANDLES] - shift - wanted).max() < 1e-4
    assert np.abs(np.delete(world(result) - shift - world(shaken), HANDLES, 0)).max() > 0.05
    assert result["curvopt_verdict"].startswith("Checked: a true local minimum")


def test_another_strength_goes_through_the_handles_too(shaken, empties, part):
    """As F9 asks for it after the end."""
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(shaken)[0].location.z += 0.2
    wanted = positions(shaken)[0] + (0, 0, 0.2)
    first = positions(finish())
    number = part("ui.adjust")._finished[0]
    assert bpy.ops.curvopt.apply_result(number=number, outcome="NEW", strength=0.3) == {"FINISHED"}
    other = positions(bpy.context.view_layer.objects.active)
    assert np.abs(other - first).max() > 0.02
    assert max(np.abs(found[0] - wanted).max() for found in (first, other)) < 1e-5


def test_a_handle_in_world_space_counts_however_it_got_there(shaken, empties):
    """By a constraint, here."""
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    goal.location = (2.0, 0.3, 0.4)
    empties(shaken)[0].constraints.new("COPY_LOCATION").target = goal
    result = finish()
    shift = np.array(result.matrix_world.translation) - np.array(shaken.matrix_world.translation)
    assert np.abs(world(result)[0] - shift - (2.0, 0.3, 0.4)).max() < 1e-4


def test_cancelling_leaves_everything_as_it_was(shaken):
    shaken.display_type = "SOLID"
    before = positions(shaken)
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert np.array_equal(positions(shaken), before) and shaken.display_type == "SOLID" and list(shaken.keys()) == []
    assert list(bpy.data.objects) == [shaken] and bpy.context.view_layer.objects.active == shaken and shaken.select_get()


def test_vertices_that_edit_mode_moves_are_handles(shaken, empties):
    before = positions(shaken)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.curvopt.pin = "NOTHING"
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert not empties(shaken)
    bpy.ops.transform.translate(value=(0, 0, 0.3))
    result = finish()
    assert bpy.context.mode == "OBJECT" and np.array_equal(positions(shaken), before)
    assert np.abs(positions(result)[HANDLES] - before[HANDLES] - (0, 0, 0.3)).max() < 1e-5
    bpy.context.view_layer.objects.active = shaken
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    bpy.ops.transform.translate(value=(0, 0, 0.3))
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert bpy.context.mode == "OBJECT" and np.array_equal(positions(shaken), before)


def test_without_pin_points_of_the_surface_are_dragged(shaken, empties):
    bpy.context.scene.curvopt.pin = "NOTHING"
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(shaken)[0].location.z += 0.1
    bpy.context.view_layer.update()
    wanted = np.array(empties(shaken)[0].matrix_world.translation)
    assert np.abs(wanted - world(shaken)[0]).max() > 0.05
    result = finish()
    modifier = next(m for m in result.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.quality = 2, 10
    evaluated = result.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices[0].co
    assert np.abs(np.array(result.matrix_world.translation) + np.array(evaluated) - np.array(
        (result.matrix_world.translation - shaken.matrix_world.translation)) - wanted).max() < 1e-3


def test_a_group_gives_handles_and_springs(shaken, empties):
    settings, moved = bpy.context.scene.curvopt, []
    settings.pin = "GROUP"
    for weight in (0.0, 0.95):
        settings.vertex_group = add_group(shaken, {2: 1.0, 13: 1.0, 24: weight}, f"Pins {weight}").name
        assert bpy.ops.curvopt.live() == {"FINISHED"}
        assert sorted(empties(shaken)) == [2, 13]
        moved.append(np.linalg.norm(positions(finish()) - positions(shaken), axis=1))
        bpy.context.view_layer.objects.active = shaken
    assert max(found[[2, 13]].max() for found in moved) < 1e-6 < 1e-4 < moved[1][24] < 0.5 * moved[0][24]


def test_images_of_a_mirror_modifier_move_along(add, empties):
    obj = with_modifiers(add(*quarter_torus(), name="Quarter"), axes=(0, 1))
    inner = int(np.flatnonzero((positions(obj)[:, :2] > 0.1).all(axis=1))[0])
    select(obj, [inner])
    before = positions(obj)
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(obj)[inner].location.z += 0.3
    result = finish()
    flat = np.abs(before[:, :2]) < 1e-6
    assert np.abs(positions(result)[inner] - before[inner] - (0, 0, 0.3)).max() < 1e-5
    assert np.abs(positions(result)[:, :2][flat]).max() < 1e-6
    assert [m.type for m in result.modifiers] == ["MIRROR", "SUBSURF"]


@pytest.mark.parametrize("outcome", ["REPLACE", "SHAPE_KEY"])
def test_results_go_where_result_says(shaken, empties, outcome):
    before = positions(shaken)
    bpy.context.scene.curvopt.outcome = outcome
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(shaken)[9].location.x += 0.2
    assert finish() == shaken and is_clean(shaken)
    found = positions(shaken)
    if outcome == "SHAPE_KEY":
        assert np.array_equal(found, before)
        found = np.array([point.co for point in shaken.data.shape_keys.key_blocks[-1].data])
    assert np.abs(found[9] - before[9] - (0.2, 0, 0)).max() < 1e-5 and np.abs(found - before).max(axis=1).min() >= 0


def test_handles_that_are_there_are_taken_up_again(shaken, empties):
    """As in a file that was saved while Live was on."""
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(shaken)[0].location.z += 0.25
    bpy.data.objects.remove(empties(shaken)[27])
    path = bpy.app.tempdir + "live.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Cage"]
    bpy.context.view_layer.objects.active = obj
    bpy.context.scene.curvopt.pin = "SELECTED"
    assert bpy.ops.curvopt.live_cancel.poll() and bpy.ops.curvopt.live() == {"FINISHED"}
    assert sorted(empties(obj)) == [0, 9, 18] and len(obj.children) == 3
    before = positions(obj)
    result = finish()
    assert np.abs(positions(result)[0] - before[0] - (0, 0, 0.25)).max() < 1e-5
    assert obj.display_type == "TEXTURED" and is_clean(obj)


def test_it_is_refused_where_it_could_not_end(shaken, part):
    settings = bpy.context.scene.curvopt
    for pin, words in (("GROUP", "No vertex group"), ("UNSELECTED", "gives no handles")):
        settings.pin = pin
        with pytest.raises(RuntimeError, match=words):
            bpy.ops.curvopt.live()
        assert is_clean(shaken) and part("ui.properties").state.live == ""
    settings.pin, settings.within = "SELECTED", 0.1
    with pytest.raises(RuntimeError, match="set Within to 0"):
        bpy.ops.curvopt.live()
    settings.within, settings.energy = 0.0, "MIX"
    settings.weight_mvs = settings.weight_willmore = 0.0
    with pytest.raises(RuntimeError, match="The mix is empty"):
        bpy.ops.curvopt.live()
    assert is_clean(shaken)
    settings.energy = "WILLMORE"
    shaken.modifiers.new("Row", "ARRAY")
    with pytest.raises(RuntimeError, match="Modifier 'Row'"):
        bpy.ops.curvopt.live()
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="Select a mesh object first"):
        bpy.ops.curvopt.live()
    assert len(bpy.data.objects) == 1


def test_no_other_run_while_it_is_on(shaken, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert not bpy.ops.curvopt.minimize.poll() and not bpy.ops.curvopt.live.poll()
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert bpy.ops.curvopt.minimize.poll() and bpy.ops.curvopt.live.poll() and not bpy.ops.curvopt.live_finish.poll()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Live from scripts: where handles are, what they hold, where the result is, and what is left in the file."""

from types import SimpleNamespace

import bmesh
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
    assert np.abs(found[9] - before[9] - (0.2, 0, 0)).max() < 1e-5
    assert np.abs(np.delete(found - before, 9, 0)).max() > 0.02


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
    settings.within, settings.no_crossings = 0.0, True
    with pytest.raises(RuntimeError, match="turn No Crossings off"):
        bpy.ops.curvopt.live()
    settings.no_crossings, settings.energy = False, "MIX"
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


def look(part):
    """As the timer does, which does not run in background; whether Live goes on."""
    bpy.context.view_layer.update()
    return part("ui.live")._look()


def forget(part):
    """As if the file were opened anew: the handles are there, and nothing follows them."""
    part("ui.live")._session.stop()
    part("ui.live")._set_state("")


def end_it(part, obj):
    """Live ends by itself, because the object is scaled."""
    assert look(part)
    obj.scale.x = 1.2
    assert not look(part) and part("ui.properties").state.live == "ENDED"


def faces(obj):
    return [tuple(polygon.vertices) for polygon in obj.data.polygons]


def edges_lengths(obj):
    places = positions(obj)
    return sorted(np.linalg.norm(places[edge.vertices[0]] - places[edge.vertices[1]]) for edge in obj.data.edges)


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_mesh_whose_vertices_have_another_order_is_left_alone(shaken, part, mode):
    """By Cancel, and Live does not go on with it."""
    lengths = edges_lengths(shaken)
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    bpy.context.view_layer.objects.active = shaken
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.sort_elements(type="REVERSE", elements={"VERT"})
    bpy.ops.object.mode_set(mode=mode)
    state = part("ui.properties").state
    assert not look(part) and "other vertices or faces" in state.message
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert "left alone" in state.message and is_clean(shaken)
    assert np.allclose(edges_lengths(shaken), lengths, atol=1e-6)


def test_a_mesh_that_was_changed_without_a_look_is_left_alone(shaken, part):
    """An edge turned in Edit Mode, which moves no vertex, and another order of vertices just before Cancel."""
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    bpy.context.view_layer.objects.active = shaken
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(shaken.data)
    edited.edges.ensure_lookup_table()
    bmesh.ops.rotate_edges(edited, edges=[edited.edges[0]])
    bmesh.update_edit_mesh(shaken.data)
    with pytest.raises(RuntimeError, match="other vertices or faces"):
        bpy.ops.curvopt.live_finish()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0, 0, 1))
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = positions(shaken)
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert np.array_equal(positions(shaken), moved) and "left alone" in part("ui.properties").state.message


def test_edits_after_it_ended_stay_and_those_before_are_taken_back(shaken, part):
    before = positions(shaken)
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    shaken.data.vertices[5].co.z += 0.3
    end_it(part, shaken)
    shaken.data.vertices[20].co.z += 0.7
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert positions(shaken)[20, 2] == pytest.approx(before[20, 2] + 0.7) and is_clean(shaken)
    assert np.array_equal(np.delete(positions(shaken), 20, 0), np.delete(before, 20, 0))
    assert "stays" in part("ui.properties").state.message


def test_the_first_shape_key_is_put_back(shaken, part):
    bpy.context.scene.curvopt.outcome = "SHAPE_KEY"
    for name in ("Basis", "Other"):
        shaken.shape_key_add(name=name)
    place = tuple(shaken.data.shape_keys.key_blocks[0].data[5].co)
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    shaken.data.shape_keys.key_blocks[0].data[5].co.z += 0.2
    assert look(part) and bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert tuple(shaken.data.shape_keys.key_blocks[0].data[5].co) == place


def test_the_result_stands_where_the_object_is_by_now(shaken, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    shaken.location, shaken.rotation_euler = (0, 0, 50), (1, 0, 0)
    result = finish()
    assert result.location.z == pytest.approx(50) and result.rotation_euler.x == pytest.approx(1)
    assert np.array_equal(result.location.yz, shaken.location.yz)


def test_a_refusal_takes_no_handles_away(shaken, empties, part):
    settings = bpy.context.scene.curvopt
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    forget(part)
    settings.energy, settings.weight_mvs, settings.weight_willmore = "MIX", 0.0, 0.0
    with pytest.raises(RuntimeError, match="The mix is empty"):
        bpy.ops.curvopt.live()
    assert sorted(empties(shaken)) == HANDLES and shaken.display_type == "WIRE"


def test_handles_of_another_mesh_are_not_taken_up(shaken, empties, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    forget(part)
    edited = bmesh.new()
    edited.from_mesh(shaken.data)
    edited.verts.ensure_lookup_table()
    bmesh.ops.dissolve_verts(edited, verts=[edited.verts[3]])
    edited.to_mesh(shaken.data)
    edited.free()
    bpy.context.view_layer.objects.active = shaken
    with pytest.raises(RuntimeError, match="more or fewer vertices"):
        bpy.ops.curvopt.live()
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"} and is_clean(shaken)


def test_handles_are_taken_up_as_they_were_made(shaken, empties, part):
    """Points of the surface, whatever Pin says by now, and with nothing selected."""
    settings = bpy.context.scene.curvopt
    settings.pin = "NOTHING"
    assert bpy.ops.curvopt.live() == {"FINISHED"} and part("ui.live")._session.base.on_surface
    places = {vertex: tuple(handle.matrix_world.translation) for vertex, handle in empties(shaken).items()}
    forget(part)
    settings.pin = "SELECTED"
    select(shaken, [])
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    request = part("ui.live")._session.request
    assert request.held.limit_points and sorted(places) == request.held.vertices.tolist()
    assert np.abs(np.array([places[vertex] for vertex in sorted(places)]) - request.held.places).max() < 1e-6


def test_live_goes_on_after_it_ended_by_itself(shaken, empties, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    end_it(part, shaken)
    assert bpy.ops.curvopt.live.poll() and not bpy.ops.curvopt.live_finish.poll()
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert sorted(empties(shaken)) == HANDLES and part("ui.properties").state.live == "ON" and look(part)
    assert is_clean(finish()) and is_clean(shaken)


@pytest.mark.parametrize("ends", ["live_finish", "live_cancel"])
def test_a_handle_of_another_parent_is_a_handle(shaken, empties, part, ends):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    goal = bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    handle = empties(shaken)[0]
    place = np.array(handle.matrix_world.translation)
    handle.parent, handle.matrix_parent_inverse = goal, shaken.matrix_world
    goal.location.z = 0.3
    assert look(part)
    request = part("ui.live")._session.request
    assert np.abs(request.held.places[0] - place - (0, 0, 0.3)).max() < 1e-6
    assert getattr(bpy.ops.curvopt, ends)() == {"FINISHED"}
    assert is_clean(shaken) and all(obj.type == "MESH" or obj == goal for obj in bpy.data.objects)


def test_copies_are_no_part_of_it(shaken, empties, part):
    """Whatever they are called; at the end they lose the marks that they have copied."""
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    copy = shaken.copy()
    copy.data = shaken.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    shaken.name, copy.name = "Other", "Cage"
    copy.data.vertices[5].co.z += 1.0
    assert look(part)
    session = part("ui.live")._session
    assert session.name == shaken.name and session.request.held.vertices.tolist() == HANDLES
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert is_clean(shaken) and is_clean(copy) and not set(copy.keys()) - {"curvopt"} and len(bpy.data.objects) == 2


def test_another_session_has_another_mark(add, part):
    """The end of one leaves the handles of the other."""
    found = []
    for name in ("One", "Two"):
        obj = add(*shapes.torus(), name=name)
        select(obj, HANDLES)
        assert bpy.ops.curvopt.live() == {"FINISHED"}
        forget(part)
        found.append(obj)
    bpy.context.view_layer.objects.active = found[0]
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert found[0].display_type == "TEXTURED" and not found[0].children
    assert found[1].display_type == "WIRE" and len(found[1].children) == 4


@pytest.mark.parametrize("what", ["keys", "mix", "within"])
def test_what_finish_cannot_write_is_said_and_nothing_is_changed(shaken, empties, part, what):
    settings, state = bpy.context.scene.curvopt, part("ui.properties").state
    settings.outcome = "REPLACE"
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    words = {"keys": "has shape keys", "mix": "The mix is empty", "within": "set Within to 0"}[what]
    if what == "keys":
        shaken.shape_key_add(name="Basis")
    elif what == "mix":
        settings.energy, settings.weight_mvs, settings.weight_willmore = "MIX", 0.0, 0.0
    else:
        settings.within = 0.1
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.curvopt.live_finish()
    assert state.live == "ON" and state.failed and sorted(empties(shaken)) == HANDLES and shaken.display_type == "WIRE"
    settings.outcome, settings.energy, settings.within = "NEW", "WILLMORE", 0.0
    if what != "keys":
        assert is_clean(finish())


@pytest.mark.parametrize("outcome", ["NEW", "REPLACE"])
def test_with_animation_the_result_keeps_the_way(shaken, empties, part, outcome):
    before, settings = positions(shaken), bpy.context.scene.curvopt
    settings.outcome = outcome
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    empties(shaken)[9].location.x += 0.2
    settings.animation = True  # also where that is ticked at last
    result = finish()
    end, keys = positions(result), result.data.shape_keys.key_blocks
    assert "Frames " in part("ui.properties").state.message and keys[0].name == "Basis" and 2 <= len(keys) <= 25
    first = np.array([point.co for point in keys[1].data])
    assert np.abs((first - first.mean(axis=0)) - (before - before.mean(axis=0))).max() < 1e-5
    assert np.abs(np.array([point.co for point in keys[0].data]) - end).max() < 1e-6
    if outcome == "REPLACE":
        assert result == shaken and np.abs(end[9] - before[9] - (0.2, 0, 0)).max() < 1e-5
    settings.animation, settings.outcome = False, "NEW"


def test_a_shape_key_cannot_keep_the_way(shaken, empties, part):
    settings = bpy.context.scene.curvopt
    settings.outcome = "SHAPE_KEY"
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    settings.animation = True
    with pytest.raises(RuntimeError, match="Animation gives the result shape keys"):
        bpy.ops.curvopt.live_finish()
    assert part("ui.properties").state.live == "ON" and sorted(empties(shaken)) == HANDLES and not shaken.data.shape_keys
    settings.animation, settings.outcome = False, "NEW"
    assert is_clean(finish())


def test_a_scale_of_zero_is_a_sentence(shaken, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    shaken.scale = (0, 0, 0)
    assert not look(part) and "is scaled to zero" in part("ui.properties").state.message


def test_marks_that_make_no_sense_do_no_harm(shaken, empties, part):
    """As a file can have them."""
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    found = empties(shaken)
    forget(part)
    found[9]["curvopt_handle"], found[18]["curvopt_handle"], found[27]["curvopt_handle"] = "nine", -3, 10**6
    shaken["curvopt_display"], shaken["curvopt_on_surface"] = "NONSENSE", "yes"
    bpy.context.view_layer.objects.active = shaken
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    assert part("ui.live")._session.request.held.vertices.tolist() == [0]
    forget(part)
    shaken["curvopt_vertices"] = "many"
    with pytest.raises(RuntimeError, match="more or fewer vertices"):
        bpy.ops.curvopt.live()
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert is_clean(shaken) and list(bpy.data.objects) == [shaken]


def test_cancelling_leaves_edit_mode_of_an_object_that_is_not_active(shaken):
    before = positions(shaken)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    bpy.ops.transform.translate(value=(0, 0, 0.3))
    other = bpy.data.objects.new("Other", None)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer.objects.active = other
    assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    assert shaken.mode == "OBJECT" and np.array_equal(positions(shaken), before) and is_clean(shaken)


def test_a_second_start_has_one_timer(shaken, part):
    for _ in range(2):
        assert bpy.ops.curvopt.live() == {"FINISHED"}
        assert bpy.ops.curvopt.live_cancel() == {"FINISHED"}
    timers, tick = bpy.app.timers, part("ui.live")._tick
    assert timers.is_registered(tick)
    timers.unregister(tick)
    assert not timers.is_registered(tick)


def test_the_panel_speaks_of_the_object_whose_handle_is_active(shaken, empties, part):
    with pytest.raises(part("scene.modifiers").CageError, match="'Goal' is an empty"):
        part("scene.read_cage").check_object(bpy.data.objects.new("Goal", None))
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert bpy.context.view_layer.objects.active == empties(shaken)[0]
    assert part("ui.display").active_object(bpy.context) == shaken


def test_esc_is_for_live_that_is_on_and_first_of_all_for_playback(shaken, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    live, passed = part("ui.live"), {"CANCELLED", "PASS_THROUGH"}
    executed = SimpleNamespace(execute=lambda context: {"FINISHED"})

    def invoked(kind, plays):
        live._plays = plays
        return live.CURVOPT_OT_live_cancel.invoke(executed, bpy.context, SimpleNamespace(type=kind))

    assert invoked("ESC", True) == passed and invoked("ESC", False) == invoked("LEFTMOUSE", True) == {"FINISHED"}
    end_it(part, shaken)
    assert invoked("ESC", False) == passed and invoked("LEFTMOUSE", False) == {"FINISHED"}


def test_closing_the_window_of_finish_goes_back_to_dragging(shaken, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"} and look(part)
    session, left = part("ui.live")._session, []
    session.finishing = True
    session.live.finish()
    assert not bpy.ops.curvopt.live_finish.poll()
    operator = SimpleNamespace(_leave=lambda context, result: left.append(result))
    part("ui.live").CURVOPT_OT_live_finish.cancel(operator, bpy.context)
    assert left == [{"CANCELLED"}] and bpy.ops.curvopt.live_finish.poll()
    assert look(part) and session.live.running and is_clean(finish())

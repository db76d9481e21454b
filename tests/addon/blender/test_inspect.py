# SPDX-License-Identifier: GPL-3.0-or-later
"""Inspect from scripts: which cage it looks at, when it samples again, and what it says when it cannot."""

import os
import time

import addon_utils
import bmesh
import bpy
import numpy as np
import pytest
import shapes
from test_mirror import quarter_torus, with_modifiers
from test_pins import positions


@pytest.fixture
def look(part):
    """The cage of the active object as it is shown now."""
    watched = part("scene.watched").Watched()
    return lambda thorough=False: watched.look(bpy.context, bpy.context.view_layer.objects.active, thorough)


@pytest.fixture
def inspect(part):
    """The settings, switched on; `settle` does what the timer does until everything is sampled."""
    module, settings = part("ui.inspect"), bpy.context.window_manager.curvopt_inspect
    for name in settings.bl_rna.properties.keys():
        settings.property_unset(name)
    settings.is_on = True
    session = module._session

    def settle():
        for _ in range(6000):
            session.step()
            if session.inspector.is_settled and not session.is_dirty:
                session.step()
                return session._shown
            time.sleep(0.005)
        raise AssertionError("it does not settle")

    session.settle = settle
    yield session
    settings.is_on = False
    assert module._session is None and not session.inspector._thread.is_alive()


@pytest.fixture
def settings():
    return bpy.context.window_manager.curvopt_inspect


def truth(part, obj, with_keys=False):
    return part("scene.read_cage").read_source(bpy.context, obj, with_keys)


def is_like(seen, source):
    """Whether two cages are one in the world."""
    frames = np.abs(np.array(seen.frame) - np.array(source.frame)).max() < 1e-6
    faces = np.array_equal(seen.cage.face_vertices, source.cage.face_vertices)
    return frames and faces and np.abs(seen.cage.positions - source.cage.positions).max() < 1e-6


def test_it_is_the_cage_that_is_optimized_also_when_it_moves(torus, look, part):
    torus.scale, torus.location = (1, 2, -0.5), (3, 0, 1)
    assert is_like(look(), truth(part, torus))
    torus.data.vertices[3].co.z += 0.2
    torus.rotation_euler, torus.location = (0.3, 0.1, 0), (0, 0, 0)
    bpy.context.view_layer.update()
    assert is_like(look(), truth(part, torus))
    torus.scale = (1, 1, 1)
    bpy.context.view_layer.update()
    assert is_like(look(), truth(part, torus))


def test_other_faces_are_seen_at_once_and_other_creases_by_a_thorough_look(torus, look, part, crease):
    look()
    crease(torus, edges={(0, 1): 1.0})
    assert not len(look().cage.creases.edges)
    assert look(thorough=True).cage.creases.edges.tolist() == [[0, 1]]
    points, faces = shapes.cube()
    torus.data.clear_geometry()
    torus.data.from_pydata([tuple(p) for p in points], [], faces)
    assert is_like(look(), truth(part, torus))
    edit = bmesh.new()
    edit.from_mesh(torus.data)
    edit.faces.ensure_lookup_table()
    bmesh.ops.delete(edit, geom=[edit.faces[2]], context="FACES_ONLY")
    edit.to_mesh(torus.data)
    edit.free()
    assert is_like(look(), truth(part, torus)) and len(look().cage.face_sizes) == 5


def test_of_a_half_it_is_the_whole(add, look, part):
    obj = with_modifiers(add(*quarter_torus()), (0, 1))
    look()
    obj.data.vertices[0].co.z += 0.1
    seen = look()
    assert is_like(seen, truth(part, obj)) and len(seen.cage.positions) > len(obj.data.vertices)


def test_the_mesh_that_is_edited_is_read_without_leaving_edit_mode(torus, look, part, crease):
    crease(torus, edges={(0, 1): 0.7}, vertices={5: 1.0})
    torus.data.vertices.add(1)  # loose, and an edge to it, which makes a spike
    torus.data.edges.add(1)
    torus.data.edges[-1].vertices = (9, 32)
    torus.data.update()
    bpy.ops.object.mode_set(mode="EDIT")
    seen = look()
    edit = bmesh.from_edit_mesh(torus.data)
    edit.verts.ensure_lookup_table()
    edit.verts[7].co.x += 0.25
    assert torus.mode == "EDIT"
    after = look()
    assert np.flatnonzero(np.abs(after.cage.positions - seen.cage.positions).max(axis=1)).tolist() == [7]
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    fine = look()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert is_like(fine, truth(part, torus)) and len(fine.cage.positions) == 128
    creases = truth(part, torus).cage.creases
    assert fine.cage.creases.edges.tolist() == creases.edges.tolist() and fine.cage.creases.edge_sharpness == pytest.approx(creases.edge_sharpness)
    assert fine.cage.creases.vertices.tolist() == creases.vertices.tolist() and {5, 9} <= set(creases.vertices.tolist())


def test_shape_keys_are_mixed_as_blender_mixes_them(torus, look, part):
    torus.shape_key_add(name="Basis")
    for name, value, shift in (("One", 0.4, 0.3), ("Two", 0.9, -0.2), ("Mute", 1.0, 5.0)):
        key = torus.shape_key_add(name=name, from_mix=False)
        key.data[4].co.z += shift
        key.value, key.mute = value, name == "Mute"
    shown = torus.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    wanted = np.array([vertex.co for vertex in shown.vertices])
    seen = look()
    assert np.abs(seen.cage.positions - wanted).max() < 1e-6
    assert seen.original == pytest.approx(positions(torus)) and np.abs(seen.original - wanted).max() > 0.03
    torus.active_shape_key_index, torus.show_only_shape_key = 2, True
    assert look().cage.positions[4, 2] - seen.original[4, 2] == pytest.approx(-0.2, abs=1e-6)
    torus.show_only_shape_key = False
    torus.data.shape_keys.key_blocks["One"].vertex_group = torus.vertex_groups.new(name="G").name
    with pytest.raises(Exception, match="Shape key 'One' of object 'Torus' has a vertex group"):
        look()


def test_selected_edges_are_those_of_the_cage(torus, look):
    edges = torus.data.edges
    edges.foreach_set("select", [index in (2, 5) for index in range(len(edges))])
    wanted = sorted(tuple(sorted(edges[index].vertices)) for index in (2, 5))
    assert sorted(map(tuple, np.sort(look().selected, 1).tolist())) == wanted
    torus.data.vertices.foreach_set("select", [index in wanted[0] for index in range(32)])
    edges.foreach_set("select", [index == 2 for index in range(len(edges))])
    bpy.ops.object.mode_set(mode="EDIT")
    assert len(look().selected) >= 1


def test_a_result_knows_its_original(torus, look):
    assert look().original is None
    before = positions(torus)
    bpy.ops.curvopt.minimize(energy="WILLMORE", levels=1, outcome="REPLACE")
    assert look().original == pytest.approx(before, abs=1e-6)


def test_it_samples_what_is_active_and_again_only_when_that_has_changed(torus, inspect, settings, add):
    first = inspect.settle()
    assert first.subject.cage.positions == pytest.approx(positions(torus)) and first.is_fine and inspect.message == ""
    inspect.is_dirty = True
    assert inspect.settle() is first
    settings.width = 0.3  # of the drawing only
    assert inspect.is_dirty and inspect.settle() is first
    torus.location.x += 1
    bpy.context.view_layer.update()
    assert inspect.is_dirty and inspect.settle() is first
    torus.data.vertices[0].co.z += 0.1
    torus.data.update()
    bpy.context.view_layer.update()
    second = inspect.settle()
    assert second is not first and second.subject.cage.positions == pytest.approx(positions(torus), abs=1e-6)
    other = add(*shapes.cube(), name="Box")
    assert len(inspect.settle().subject.cage.face_sizes) == 6 and inspect._target[0] == other.name


def test_colours_and_combs_are_those_of_the_settings(torus, inspect, settings):
    settings.kind, settings.quantity = "CURVATURE", "K"
    seen = inspect.settle()
    assert seen.subject.quantity == "K" and seen.tints is not None
    settings.quantity = "H"
    assert inspect.settle().span != seen.span
    settings.kind, settings.combs, settings.comb_curves, settings.comb_teeth = "ZEBRA", True, "ALL", 3
    seen = inspect.settle()
    assert seen.tints is None and seen.combs.feet.shape == (64 * 4, 3)
    settings.comb_teeth = 5
    assert inspect.settle().combs.feet.shape == (64 * 6, 3)
    settings.comb_curves = "SELECTED"
    assert len(inspect.settle().combs.feet) == 6 * sum(edge.select for edge in torus.data.edges)
    settings.comb_curves, settings.comb_sections = "Z", 3
    seen = inspect.settle()
    heights = seen.combs.feet @ np.array(seen.subject.choice.normal)
    assert seen.subject.choice.count == 3 and len(np.unique(np.round(heights, 5))) == 3
    assert hasattr(bpy.types, "CURVOPT_PT_inspect")
    settings.kind = "DISTANCE"
    inspect.settle()
    assert "The original of 'Torus' is not known" in inspect.message
    bpy.ops.curvopt.minimize(energy="WILLMORE", levels=1, outcome="NEW")
    seen = inspect.settle()
    assert inspect.message == "" and seen.subject.quantity == "distance" and seen.span[1] > 0.01


def test_what_cannot_be_inspected_says_why_and_comes_back(torus, inspect):
    assert inspect.settle() is not None
    bpy.ops.object.mode_set(mode="SCULPT")
    inspect.step()
    assert "is in Sculpt Mode" in inspect.message and inspect._target is None
    bpy.ops.object.mode_set(mode="OBJECT")
    inspect.settle()
    assert inspect.message == "" and inspect._target is not None
    row = torus.modifiers.new("Row", "ARRAY")
    bpy.context.view_layer.update()
    inspect.step()
    assert "Modifier 'Row'" in inspect.message
    torus.modifiers.remove(row)
    torus.data.vertices[0].co.x = np.nan
    torus.data.update()
    bpy.context.view_layer.update()
    inspect.settle()
    assert "finite" in inspect.message
    bpy.data.objects.remove(torus)
    bpy.context.view_layer.update()
    inspect.step()
    assert "nothing is active" in inspect.message


def test_it_follows_live(add, inspect, settings, part):
    points, faces = shapes.torus()
    obj = add(points + 0.05 * np.random.default_rng(3).normal(size=points.shape), faces)
    obj.data.vertices.foreach_set("select", [index in (0, 9, 18, 27) for index in range(32)])
    for parts in (obj.data.edges, obj.data.polygons):
        parts.foreach_set("select", [False] * len(parts))
    bpy.context.scene.curvopt.energy = "WILLMORE"
    settings.kind = "DISTANCE"
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    live = part("ui.live")
    try:
        for _ in range(6000):
            live._look()
            inspect.step()
            done = live._session.live is not None and live._session.live.is_settled
            if done and inspect.settle().subject.cage.positions == pytest.approx(live._session.live.latest.snapshot.cage):
                break
            time.sleep(0.005)
        shown = inspect._shown
        assert shown.subject.cage.positions == pytest.approx(live._session.live.latest.snapshot.cage)
        assert shown.subject.original == pytest.approx(positions(obj), abs=1e-6) and shown.span[1] > 0.01
        assert inspect._target[0] == obj.name != bpy.context.view_layer.objects.active.name
    finally:
        bpy.ops.curvopt.live_cancel()


@pytest.mark.parametrize("how", ["another file", "off"])
def test_another_file_and_the_add_on_switched_off_end_it(torus, part, how):
    module = part("ui.inspect")
    bpy.context.window_manager.curvopt_inspect.is_on = True
    session, handlers = module._session, bpy.app.handlers
    session.step()
    assert any("ui.inspect" in function.__module__ for function in handlers.depsgraph_update_post)
    if how == "off":
        addon_utils.disable(os.environ["CURVOPT_TEST_NAME"])
        assert not hasattr(bpy.types.WindowManager, "curvopt_inspect")
        assert addon_utils.enable(os.environ["CURVOPT_TEST_NAME"]) is not None
    else:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not bpy.context.window_manager.curvopt_inspect.is_on and not session.inspector._thread.is_alive()
    for name in ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_pre"):
        assert not any("ui.inspect" in function.__module__ for function in getattr(handlers, name)), name
    assert not bpy.app.timers.is_registered(module._tick)

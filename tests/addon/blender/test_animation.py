# SPDX-License-Identifier: GPL-3.0-or-later
"""The run as an animation: shape keys with keyframes on the result."""

import bpy
import numpy as np
import pytest
import shapes
from test_mirror import quarter_torus, with_modifiers
from test_pins import positions


@pytest.fixture
def shaken(add):
    """A torus without symmetry."""
    points, faces = shapes.torus()
    return add(points + 0.05 * np.random.default_rng(3).normal(size=points.shape), faces, name="Torus")


def minimize(**settings):
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy="WILLMORE", animation=True, **settings) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def at(obj, frame, part_of_frame=0.0):
    """The object's vertices (n, 3), before its modifiers, as `frame` shows them."""
    shown = [(modifier, modifier.show_viewport) for modifier in obj.modifiers]
    for modifier, _ in shown:
        modifier.show_viewport = False
    bpy.context.scene.frame_set(frame, subframe=part_of_frame)
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    for modifier, was in shown:
        modifier.show_viewport = was
    return points.astype(float)


def start(obj):
    """The original's surface on the result's vertices."""
    points = np.empty((len(obj.data.vertices), 3), np.float32)
    obj.data.attributes["curvopt_start"].data.foreach_get("vector", points.reshape(-1))
    return points.astype(float)


def frames_of(part):
    words = part("ui.properties").state.message.split()
    first = words.index("Frames") + 1
    return int(words[first]), int(words[first + 2])


def test_the_timeline_shows_the_run_and_the_current_frame_the_result(shaken, part):
    bpy.context.scene.frame_set(7)
    result = minimize(levels=2)
    first, last = frames_of(part)
    keys = result.data.shape_keys.key_blocks
    assert part("ui.adjust")._warns is False
    assert (first, last) == (8, 8 + 2 * (len(keys) - 1)) and 10 <= len(keys) <= 25
    assert len(result.data.vertices) > len(shaken.data.vertices) and keys[0].name == "Basis"
    end = positions(result)
    for frame in (1, 7, last, last + 20):
        assert np.abs(at(result, frame) - end).max() < 1e-6, frame
    assert np.abs(at(result, first) - start(result)).max() < 1e-6
    middles = [at(result, frame) for frame in range(first, last + 1)]
    jumps = [np.abs(b - a).max() for a, b in zip(middles, middles[1:])]
    assert max(jumps) < 0.5 * np.abs(end - start(result)).max(), jumps
    halfway = at(result, first + 1)
    assert np.abs(halfway - (at(result, first) + at(result, first + 2)) / 2).max() < 1e-6  # linear
    quarter = at(result, first, 0.5)
    assert np.abs(quarter - (3 * at(result, first) + at(result, first + 2)) / 4).max() < 1e-5
    assert positions(shaken).shape == (32, 3) and shaken.data.shape_keys is None


def test_inspect_follows_the_timeline_and_without_its_keys_the_mesh_is_the_result(shaken, part):
    result = minimize(levels=1)
    first, last = frames_of(part)
    watched, end = part("scene.watched").Watched(), positions(result)
    for frame in (first, first + 3, last):
        wanted = at(result, frame)
        assert np.abs(watched.look(bpy.context, result, False).cage.positions - wanted).max() < 1e-6
        assert np.abs(watched.look(bpy.context, result, False).original - start(result)).max() < 1e-6
    bpy.context.scene.frame_set(first)
    bpy.ops.object.shape_key_remove(all=True)
    assert result.data.shape_keys is None and np.abs(positions(result) - end).max() < 1e-6
    assert minimize(levels=1) != result


def test_energies_fall_along_the_timeline(shaken, part):
    result = minimize(levels=1)
    first, last = frames_of(part)
    library, energies = part("binding.library"), []
    source = part("scene.read_cage").read_source(bpy.context, result, True)
    with library.Mesh.of_cage(library.load(), source.cage) as mesh:
        with library.Problem.create(mesh, library.load().options({"willmore": 1.0})) as problem:
            energies = [problem.evaluate(at(result, frame))[0].objective for frame in range(first, last + 1, 2)]
    assert energies[0] == pytest.approx(result["curvopt_before_willmore"], rel=1e-4)
    assert energies[-1] == pytest.approx(result["curvopt_after_willmore"], rel=1e-4)
    assert (np.diff(energies) < 1e-3 * energies[0]).all()


def test_in_place_of_an_object_with_any_scale(shaken, part):
    shaken.scale, shaken.location = (1, -2, 0.5), (1, 2, 3)
    before = positions(shaken)
    result = minimize(levels=1, outcome="REPLACE")
    first, last = frames_of(part)
    assert result == shaken
    assert np.abs(at(result, first) - before).max() < 1e-5 and np.abs(at(result, last) - positions(result)).max() < 1e-6


def test_half_a_cage_and_loose_vertices(add, part):
    points, faces = quarter_torus()
    obj = with_modifiers(add([*points, (9, 9, 9)], faces), (0, 1))
    result = minimize(levels=2)
    first, last = frames_of(part)
    assert np.abs(at(result, first) - start(result)).max() < 1e-6
    for frame in (first, first + 5, last):
        shown = at(result, frame)
        assert shown[-1] == pytest.approx([9, 9, 9], abs=1e-5) and (np.abs(shown[:, 0]) < 1e-9).sum() == (np.abs(positions(result)[:, 0]) < 1e-9).sum()
    assert obj.data.shape_keys is None


def test_one_undo_step_takes_all_of_it_back(shaken, part, contents):
    bpy.ops.ed.undo_push(message="Before")
    before = contents()
    result = minimize(levels=1)
    assert result.data.shape_keys is not None and len(bpy.data.actions) == 1
    bpy.ops.ed.undo()
    assert contents() == before and not [key for key in bpy.data.shape_keys] and not bpy.data.actions
    bpy.ops.ed.redo()
    again = bpy.context.scene.objects["Torus Willmore"]
    first, _ = frames_of(part)
    assert np.abs(at(again, first) - start(again)).max() < 1e-6


def test_a_shape_key_as_result_amount_and_a_second_run_are_refused(shaken, contents):
    before = contents()
    with pytest.raises(RuntimeError, match="Animation gives the result shape keys of its own"):
        minimize(levels=1, outcome="SHAPE_KEY")
    assert contents() == before
    result = minimize(levels=1)
    with pytest.raises(RuntimeError, match="has shape keys: remove them"):
        minimize(levels=1)
    assert bpy.context.view_layer.objects.active == result


def test_adjusting_with_less_than_all_of_it_is_refused(shaken, part, contents):
    minimize(levels=1)
    number, before = part("ui.adjust")._finished[0], contents()
    with pytest.raises(RuntimeError, match="Amount cannot be less than 1"):
        bpy.ops.curvopt.apply_result("EXEC_DEFAULT", True, number=number, amount=0.5)
    assert contents() == before


def test_without_it_nothing_is_animated(shaken, newcomer):
    assert not newcomer.animation
    assert bpy.ops.curvopt.minimize(energy="WILLMORE", levels=1) == {"FINISHED"}
    assert bpy.context.view_layer.objects.active.data.shape_keys is None and not bpy.data.actions
    newcomer.animation = True
    bpy.context.view_layer.objects.active = shaken
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    assert bpy.ops.curvopt.minimize(energy="WILLMORE", outcome="SHAPE_KEY", animation=True) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert shaken.data.shape_keys is None  # Edit Mode has no use for it


def test_frames_can_be_rendered_in_the_background(shaken, part, tmp_path):
    """The first frame of the run and the last one are different pictures, by Workbench."""
    result = minimize(levels=1)
    shaken.hide_render = True
    first, last = frames_of(part)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = np.array(result.location) + (0, 0, 6)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "BLENDER_WORKBENCH", 96, 96
    scene.frame_start, scene.frame_end, scene.frame_step = first, last, last - first
    scene.render.filepath = str(tmp_path / "frame")
    bpy.ops.render.render(animation=True)
    pictures = [np.array(bpy.data.images.load(str(path)).pixels) for path in sorted(tmp_path.glob("*.png"))]
    assert len(pictures) == 2 and np.abs(pictures[0] - pictures[1]).max() > 0.1

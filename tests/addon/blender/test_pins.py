# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept: vertices, by group or selection, and symmetries; in the operator."""

import bpy
import numpy as np
import pytest
import shapes

HELD = [0, 5, 6, 17]


def minimize(levels=1, **arguments):
    assert bpy.ops.curvopt.minimize(energy="WILLMORE", levels=levels, **arguments) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def positions(obj):
    values = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def unmoved(result, original):
    """The vertices whose coordinates are the same to the last bit."""
    n = len(original.data.vertices)
    return np.flatnonzero((positions(result)[:n] == positions(original)).all(axis=1)).tolist()


def add_group(obj, weights, name="Pins"):
    group = obj.vertex_groups.new(name=name)
    for vertex, weight in weights.items():
        group.add([vertex], weight, "REPLACE")
    return group


def select(obj, vertices):
    flags = np.zeros(len(obj.data.vertices), bool)
    flags[vertices] = True
    obj.data.vertices.foreach_set("select", flags)


@pytest.fixture
def pinned(torus):
    """The torus with HELD in the group Pins, others in it with no weight or in another group."""
    add_group(torus, {9: 1.0}, "Other")
    add_group(torus, {**dict.fromkeys(HELD, 1.0), 1: 0.0, 3: 0.0})
    return torus


# -------------------------------------------------------------------------------------------------------- vertices --


@pytest.mark.parametrize("symmetry", ["AUTO", "NONE"])
def test_vertices_of_weight_1_in_the_group_stay_to_the_last_bit(pinned, symmetry):
    assert unmoved(minimize(pin="GROUP", vertex_group="Pins", symmetry=symmetry), pinned) == HELD


def test_lesser_weights_hold_the_less(torus):
    """Vertex 17 is drawn back by its weight in the group; the others stay as they do."""
    moved = []
    for weight in (0.05, 0.5, 0.95):
        group = add_group(torus, {**dict.fromkeys(HELD, 1.0), 17: weight}, f"Pins {weight}")
        result = minimize(pin="GROUP", vertex_group=group.name, symmetry="NONE")
        assert unmoved(result, torus) == [v for v in HELD if v != 17]
        moved.append(float(np.linalg.norm(positions(result)[17] - positions(torus)[17])))
        bpy.context.view_layer.objects.active = torus
    assert 0 < moved[2] < 0.5 * moved[1] < 0.5 * moved[0], moved


def test_weights_hold_alike_at_any_scale(torus):
    """In the object's own units, ten times as large."""
    add_group(torus, {0: 0.5, 6: 0.25, 17: 0.75, 30: 0.5})
    small = positions(minimize(pin="GROUP", vertex_group="Pins", symmetry="NONE"))
    bpy.context.view_layer.objects.active = torus
    torus.scale = (10, 10, 10)
    large = positions(minimize(pin="GROUP", vertex_group="Pins", symmetry="NONE"))
    assert np.abs(large - 10 * small).max() < 1e-2 and np.abs(small - positions(torus)).max() > 1e-1


def blender_limit(obj, n):
    """Of the first n vertices (n, 3): the cage's after three subdivisions by Blender, as its limit."""
    modifier = next((m for m in obj.modifiers if m.type == "SUBSURF"), None) or obj.modifiers.new("Limit", "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 3, True, 10
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    values = np.empty(3 * len(evaluated.data.vertices), np.float32)
    evaluated.data.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)[:n]


@pytest.mark.parametrize("levels", [1, 2])
def test_pins_on_the_surface_keep_its_points_and_not_the_vertices(torus, levels):
    """As Blender's own limit surface has them, of the cage and of the result."""
    select(torus, HELD)
    was = blender_limit(torus, 32)[HELD].copy()
    result = minimize(levels=levels, pin="SELECTED", pin_surface=True)
    assert unmoved(result, torus) == []
    off = np.linalg.norm(blender_limit(result, 32)[HELD] - was, axis=1)
    others = np.linalg.norm(blender_limit(result, 32) - blender_limit(torus, 32), axis=1)
    assert off.max() < 2e-6 and others.max() > 1e-2


def test_selection_stays(torus):
    select(torus, HELD)
    assert unmoved(minimize(pin="SELECTED"), torus) == HELD


def test_only_the_selection_moves(torus):
    select(torus, HELD)
    assert unmoved(minimize(pin="UNSELECTED"), torus) == [v for v in range(32) if v not in HELD]


def test_selection_is_that_of_edit_mode(torus):
    """As an artist makes it, here in face mode."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    torus.data.polygons[10].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert unmoved(minimize(pin="SELECTED"), torus) == sorted(torus.data.polygons[10].vertices)


def test_nothing_is_kept_by_default(pinned):
    select(pinned, HELD)
    assert unmoved(minimize(), pinned) == []


def test_vertices_stay_through_all_levels(torus):
    """Every other vertex is held; the result's first vertices are the cage's."""
    add_group(torus, dict.fromkeys(range(0, 32, 2), 1.0))
    before = positions(torus)
    result = minimize(3, pin="GROUP", vertex_group="Pins")
    moved = np.linalg.norm(positions(result)[:32] - before, axis=1)
    assert moved[::2].max() < 1e-6 and moved.max() > 1e-3


def test_the_surface_stays_where_faces_and_their_neighbours_are_kept(torus, part):
    """Five of eight rings are held: the surface's points over the vertices of the middle two."""
    add_group(torus, dict.fromkeys(range(20), 1.0))
    start = limit_points(torus, part, range(4, 12))
    for levels in (1, 2):
        bpy.context.view_layer.objects.active = torus
        result = minimize(levels, pin="GROUP", vertex_group="Pins")
        faces = np.arange(4, 12) * 4 ** (levels - 1)  # the first child is the one at the face's first corner
        assert np.abs(limit_points(result, part, faces) - start).max() < 1e-6


def limit_points(obj, part, faces):
    library, cage, n = part("binding.library"), part("scene.read_cage"), len(obj.data.vertices)
    with library.Mesh.create(library.load(), n, *cage.read_faces(obj.data)) as mesh:
        return mesh.jets(cage.read_positions(obj.data), list(faces), [0] * len(faces), [[0, 0]] * len(faces))[:, 0]


def test_turned_and_scaled_object_keeps_its_vertices_in_the_world(pinned):
    pinned.location, pinned.rotation_euler, pinned.scale = (3, -1, 2), (0.3, -0.2, 0.9), (1.0, -0.7, 1.6)
    bpy.context.view_layer.update()
    result = minimize(pin="GROUP", vertex_group="Pins")
    bpy.context.view_layer.update()
    beside = result.matrix_world.translation - pinned.matrix_world.translation
    now = [np.array(result.matrix_world @ result.data.vertices[v].co - beside) for v in HELD]
    assert np.abs(now - np.array([pinned.matrix_world @ pinned.data.vertices[v].co for v in HELD])).max() < 2e-6


def test_energy_before_does_not_depend_on_what_is_kept(pinned):
    """After does, in either direction: pins that break a symmetry can lead past the least of the symmetric shapes."""
    free = minimize()
    bpy.context.view_layer.objects.active = pinned
    held = minimize(pin="GROUP", vertex_group="Pins")
    assert held["curvopt_before_willmore"] == pytest.approx(free["curvopt_before_willmore"], rel=1e-9)
    assert held["curvopt_after_willmore"] < held["curvopt_before_willmore"]


def test_settings_of_the_scene_are_used_when_the_call_gives_none(pinned):
    settings = bpy.context.scene.curvopt
    settings.pin, settings.vertex_group, settings.symmetry = "GROUP", "Pins", "NONE"
    result = minimize()
    assert unmoved(result, pinned) == HELD and result["curvopt_symmetry_order"] == 1


def test_a_run_with_pins_is_one_undo_step_and_runs_again_the_same(pinned, contents):
    settings = bpy.context.scene.curvopt
    settings.pin, settings.vertex_group = "GROUP", "Pins"
    bpy.ops.ed.undo_push(message="Pinned")
    before = contents()
    ends = []
    for _ in range(2):
        assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy="WILLMORE", levels=1) == {"FINISHED"}
        result, original = bpy.data.objects["Torus Willmore"], bpy.data.objects["Torus"]
        assert unmoved(result, original) == HELD
        ends.append(positions(result))
        bpy.ops.ed.undo()
        assert contents() == before
        settings = bpy.context.scene.curvopt
        assert (settings.pin, settings.vertex_group) == ("GROUP", "Pins")
        assert [group.name for group in bpy.data.objects["Torus"].vertex_groups] == ["Other", "Pins"]
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


# ------------------------------------------------------------------------------------------------------ symmetries --


def test_symmetric_cage_gives_a_symmetric_result(torus, part):
    result = minimize(2)
    assert result["curvopt_symmetry_order"] == 32
    assert "(128 vertices, 32 symmetries kept, " in part("ui.properties").state.message
    points = positions(result).astype(float)
    turn = np.array([[np.cos(np.pi / 4), -np.sin(np.pi / 4), 0], [np.sin(np.pi / 4), np.cos(np.pi / 4), 0], [0, 0, 1]])
    for image in (points * [-1, 1, 1], points * [1, -1, 1], points * [1, 1, -1], points @ turn.T):
        assert np.linalg.norm(image[:, None] - points[None], axis=2).min(axis=1).max() < 5e-7


def test_symmetries_are_those_of_the_shape_in_the_world(torus):
    torus.scale = (1.0, 1.5, 1.0)
    assert minimize()["curvopt_symmetry_order"] == 8


def test_symmetry_can_be_switched_off(torus, part):
    assert minimize(symmetry="NONE")["curvopt_symmetry_order"] == 1
    assert "symmetr" not in part("ui.properties").state.message


def test_pins_leave_the_symmetries_that_they_have(pinned):
    group = add_group(pinned, {0: 1.0, 16: 1.0}, "Opposite")
    assert minimize(pin="GROUP", vertex_group=group.name)["curvopt_symmetry_order"] == 8


@pytest.mark.parametrize("planes", [(True, False, False), (False, True, True)])
def test_chosen_planes_of_the_object_are_kept_and_no_others(torus, planes):
    """Planes of its own axes, through its middle, wherever it is and its origin."""
    shift = np.array([0.5, 0.25, -1.0], np.float32)
    torus.data.vertices.foreach_set("co", (positions(torus) + shift).reshape(-1))
    torus.location, torus.rotation_euler = (3, -1, 2), (0.3, -0.2, 0.9)
    result = minimize(2, symmetry="PLANES", symmetry_planes=planes)
    assert result["curvopt_symmetry_order"] == 2 ** sum(planes)
    points = positions(result).astype(float)
    points -= points.mean(axis=0)
    for axis in np.flatnonzero(planes):
        image = points * np.where(np.arange(3) == axis, -1, 1)
        assert np.linalg.norm(image[:, None] - points[None], axis=2).min(axis=1).max() < 2e-6


def test_planes_of_the_scene_are_used_when_the_call_gives_none(torus):
    settings = bpy.context.scene.curvopt
    settings.symmetry, settings.symmetry_planes = "PLANES", (False, False, True)
    assert minimize()["curvopt_symmetry_order"] == 2


def test_choices_of_the_panel_are_the_librarys(part):
    assert {item[0].lower() for item in part("ui.properties").SYMMETRIES} == set(part("binding.abi").SYMMETRIES)


@pytest.mark.parametrize(
    "name",
    [
        "energy", "strength", "resolution", "levels", "boundary", "rim", "symmetry", "symmetry_planes", "pin",
        "vertex_group",
    ],
)
def test_operator_and_scene_have_the_same_properties(torus, name):
    """Same names, tooltips, choices, defaults: what scripts, shortcuts and menus set is what the panel shows."""
    settings = bpy.context.scene.curvopt.bl_rna.properties[name]
    operator = bpy.ops.curvopt.minimize.get_rna_type().properties[name]
    for shared in ("name", "description", "default", "type"):
        assert getattr(settings, shared) == getattr(operator, shared)
    assert settings.description and not settings.description.endswith(".")
    if settings.type == "ENUM":
        choices = [[(c.identifier, c.name, c.description) for c in p.enum_items] for p in (settings, operator)]
        assert choices[0] == choices[1] and all(description for _, _, description in choices[0])

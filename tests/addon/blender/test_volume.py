# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Volume: what shrinks without it keeps its volume with it, where it cannot be said so, and where it is refused."""

import bmesh
import bpy
import numpy as np
import pytest
import shapes
from runs import minimize, positions

FAIR = {"strength": 0.3, "resolution": "SAME"}


PINNED = [0, 40, 60, 130]
PART = set(range(30, 110))  # vertices


@pytest.fixture
def ring(add):
    """The active object: a bumpy torus of 160 vertices."""
    points, faces = shapes.torus(16, 10)
    return add(points + 0.03 * np.random.default_rng(3).normal(size=points.shape), faces, name="Ring")


def measured(obj, part):
    """The volume inside the limit surface of an object's mesh, by the library."""
    source = part("scene.read_cage").read_source(bpy.context, obj)
    lib = part("binding.library").load()
    with part("binding.library").Mesh.of_cage(lib, source.cage) as mesh:
        options = lib.options({"willmore": 1.0}, tolerance=1e-8)
        with part("binding.library").Problem.create(mesh, options, source.cage.positions) as problem:
            return problem.evaluate(source.cage.positions)[0].volume


def shown(obj, levels):
    """The volume inside what Blender shows of an object's limit surface, subdivided so often."""
    mesh = obj.data.copy()
    copy = bpy.data.objects.new("Copy", mesh)
    bpy.context.scene.collection.objects.link(copy)
    modifier = copy.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = levels, True, 10
    edit = bmesh.new()
    edit.from_object(copy, bpy.context.evaluated_depsgraph_get())
    volume = edit.calc_volume(signed=True)
    edit.free()
    bpy.data.objects.remove(copy)
    return volume


def off(result, original, part):
    """The relative difference of their volumes."""
    return abs(measured(result, part) / measured(original, part) - 1)


def pinned(obj):
    """Pins a few vertices of it, by a vertex group."""
    obj.vertex_groups.new(name="Pins").add(PINNED, 1.0, "REPLACE")
    return {"pin": "GROUP", "vertex_group": "Pins", "strength": 1.0, "resolution": "SAME", "max_iterations": 40}


def test_settings(newcomer, part):
    """Off by default, on the scene with all others, and so in presets; the operator takes it from the scene."""
    assert newcomer.keep_volume is False and "keep_volume" in part("ui.properties").SETTINGS
    wanted = part("ui.properties").request_of
    values = {name: getattr(newcomer, name) for name in part("ui.properties").SETTINGS}
    held = part("binding.values").Held()
    assert not wanted(values, held).keeps_volume and wanted({**values, "keep_volume": True}, held).keeps_volume
    assert "bpy.context.scene.curvopt.keep_volume" in part("ui.menus").CURVOPT_OT_preset_add.preset_values


def test_scene_setting_is_used_when_the_call_gives_none(newcomer, ring, part):
    newcomer.keep_volume = True
    assert off(minimize(ring), ring, part) < 1e-6
    assert off(minimize(ring, keep_volume=False), ring, part) > 3e-4


@pytest.mark.parametrize("arguments", [FAIR, {"strength": 0.5, "resolution": "REFINE", "levels": 2}])
def test_a_ring_made_fair_keeps_its_volume(ring, part, arguments):
    free, kept = minimize(ring, **arguments), minimize(ring, keep_volume=True, **arguments)
    assert off(free, ring, part) > 3e-4
    assert off(kept, ring, part) < 1e-6
    assert kept["curvopt_after_volume"] == pytest.approx(kept["curvopt_before_volume"], rel=1e-6)
    assert kept["curvopt_before_volume"] == pytest.approx(free["curvopt_before_volume"], rel=1e-12)
    assert kept["curvopt_verdict"].startswith("Checked: a local minimum of energy and nearness")
    assert "volume" not in part("ui.properties").state.message


def test_what_blender_shows_has_the_volume(ring):
    """Subdivided five times, its polyhedra miss a small part of the volume, and alike."""
    free, kept = minimize(ring, **FAIR), minimize(ring, keep_volume=True, **FAIR)
    start, with_it, without = (shown(obj, 5) for obj in (ring, kept, free))
    assert abs(with_it / start - 1) < 1e-5 < 3e-4 < abs(without / start - 1)
    assert start == pytest.approx(kept["curvopt_before_volume"], rel=1e-3)


def test_a_pinned_ring_keeps_its_volume(ring, part):
    arguments = pinned(ring)
    free, kept = minimize(ring, **arguments), minimize(ring, keep_volume=True, **arguments)
    assert off(free, ring, part) > 1e-2
    assert off(kept, ring, part) < 5e-6  # by finer quadrature than the run's, whose tolerance is 1e-4
    assert kept["curvopt_after_volume"] == pytest.approx(kept["curvopt_before_volume"], rel=1e-8)
    assert np.abs(positions(kept)[PINNED] - positions(ring)[PINNED]).max() < 1e-6


def test_by_itself_it_sets_the_size(torus, part):
    free = minimize(torus, strength=1.0)
    kept = minimize(torus, strength=1.0, keep_volume=True)
    assert off(kept, torus, part) < 1e-6 < 1e-2 < off(free, torus, part)
    assert kept["curvopt_after_willmore"] == pytest.approx(free["curvopt_after_willmore"], rel=1e-6)


def test_under_a_mirror_modifier_the_volume_of_the_whole_stays(add, part):
    points, faces = shapes.torus()
    half = [face for face in faces if points[face][:, 0].min() > -1e-9]
    used = np.unique(half)
    number = {vertex: i for i, vertex in enumerate(used)}
    rough = points[used] * (1 + 0.1 * np.random.default_rng(1).normal(size=(len(used), 1)))
    obj = add(rough, [[number[vertex] for vertex in face] for face in half], name="Half")
    obj.modifiers.new("Mirror", "MIRROR").merge_threshold = 1e-4
    assert not part("scene.read_cage").has_boundary(obj)
    kept = minimize(obj, keep_volume=True, **FAIR)
    assert kept.modifiers[0].type == "MIRROR" and off(kept, obj, part) < 1e-6


# --------------------------------------------------------------------------------------------------- open surfaces --


def test_an_open_surface_keeps_what_is_between_it_and_its_boundary(add, part):
    dome = add(*shapes.dome(), name="Dome")
    volumes = []
    for keep_volume in (False, True):
        result = minimize(dome, strength=1.0, keep_volume=keep_volume)
        assert "curvopt_before_volume" not in result and "curvopt_after_volume" not in result
        labels = [row[0] for row in part("scene.write_result").stored_energies(result)]
        assert "Area" in labels and "Volume" not in labels
        volumes.append(_under(part, result) / _under(part, dome) - 1)
    assert abs(volumes[0]) > 1e-2 and abs(volumes[1]) < 1e-5


def _under(part, obj):
    """The volume between a dome and the cone from its boundary to the origin, by Gauss's rule on many small quads of the limit
    surface."""
    source = part("scene.read_cage").read_source(bpy.context, obj)
    library = part("binding.library")
    mesh, points = library.Mesh.of_cage(library.load(), source.cage), source.cage.positions
    for _ in range(3):
        mesh, points = mesh.refine(points)
    faces = np.arange(mesh.info().n_faces)
    nodes = 0.5 + np.array([-0.5, 0, 0.5]) * 0.6**0.5
    total = 0.0
    for u, wu in zip(nodes, (5 / 18, 8 / 18, 5 / 18)):
        for v, wv in zip(nodes, (5 / 18, 8 / 18, 5 / 18)):
            jets = mesh.jets(points, faces, np.zeros_like(faces), np.tile([u, v], (len(faces), 1)))
            total += wu * wv * np.einsum("ij,ij->", jets[:, 0], np.cross(jets[:, 1], jets[:, 2])) / 3
    return total


def test_a_free_boundary_is_grey_in_the_panel_and_refused_by_the_run(newcomer, add, torus, part):
    has_boundary = part("scene.read_cage").has_boundary
    assert not has_boundary(None) and not has_boundary(torus)
    dome = add(*shapes.dome(), name="Dome")
    assert has_boundary(dome)
    newcomer.keep_volume, newcomer.boundary = True, "FREE"
    before = positions(dome)
    with pytest.raises(RuntimeError, match="volume cannot be held.*choose another Boundary, or turn off Keep Volume"):
        bpy.ops.curvopt.minimize()
    assert np.array_equal(positions(dome), before) and set(bpy.data.objects.keys()) == {"Torus", "Dome"}
    for obj, boundary, grey in ((dome, "FREE", True), (dome, "POSITION", False), (torus, "FREE", False)):
        bpy.context.view_layer.objects.active, newcomer.boundary = obj, boundary
        assert _drawn(part) == (not grey, [part("ui.panel").FREE_BOUNDARY] if grey else [])


class Layout:
    """What the panel draws into: remembers the properties and the labels."""

    def __init__(self):
        self.active, self.names, self.labels, self.parts = True, [], [], []

    def column(self):
        self.parts.append(Layout())
        return self.parts[-1]

    def prop(self, _settings, name):
        self.names.append(name)

    def label(self, text):
        self.labels.append(text)


def _drawn(part):
    """(whether the checkbox is not grey, the sentence below it)"""
    layout, panel = Layout(), part("ui.panel")
    lines, panel._lines = panel._lines, lambda _context, text: [text]
    try:
        panel.CURVOPT_PT_minimize._draw_volume(None, bpy.context, layout)
    finally:
        panel._lines = lines
    assert layout.parts[0].names == ["keep_volume"]
    return layout.parts[0].active, layout.parts[0].labels


# ------------------------------------------------------------------------------------------------------- Edit Mode --


def selected(obj, vertices):
    """The object in Edit Mode with these vertices selected."""
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    for vertex in edit.verts:
        vertex.select_set(vertex.index in vertices)
    edit.select_flush_mode()
    bmesh.update_edit_mesh(obj.data)
    bpy.ops.ed.undo_push(message="Selected")


@pytest.mark.parametrize("boundary", ["POSITION", "FREE"])
def test_a_part_keeps_the_volume_of_the_whole(ring, part, boundary):
    """Whatever Boundary says, since a ring has no boundary; others stay where they are."""
    start, volume, offs = positions(ring), measured(ring, part), []
    for keep_volume in (False, True):
        selected(ring, PART)
        arguments = {"energy": "WILLMORE", "strength": 0.5, "rim": "POSITION", "boundary": boundary}
        assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, keep_volume=keep_volume, **arguments) == {"FINISHED"}
        bpy.ops.object.mode_set(mode="OBJECT")
        moved = np.flatnonzero(np.abs(positions(ring) - start).max(axis=1) > 0)
        assert len(moved) and set(moved) <= PART
        assert "volume" not in part("ui.properties").state.message
        offs.append(abs(measured(ring, part) / volume - 1))
        ring.data.vertices.foreach_set("co", start.astype(np.float32).reshape(-1))
    assert offs[0] > 1e-4 and offs[1] < 1e-6


@pytest.mark.parametrize("boundary", ["POSITION", "FREE"])
def test_a_part_of_an_open_surface_keeps_its_volume(add, part, boundary):
    """A selection inside moves no boundary, which may be called free."""
    dome = add(*shapes.dome(rings=8), name="Dome")
    start, volume = positions(dome), _under(part, dome)
    inside = np.flatnonzero(np.linalg.norm(start[:, :2], axis=1) < 0.6)
    selected(dome, set(inside))
    arguments = {"energy": "WILLMORE", "strength": 1.0, "boundary": boundary, "keep_volume": True}
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, **arguments) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = np.flatnonzero(np.abs(positions(dome) - start).max(axis=1) > 1e-4)
    assert len(moved) and set(moved) <= set(inside)
    assert abs(_under(part, dome) / volume - 1) < 1e-5


def test_a_part_with_a_crease_that_is_free_keeps_the_volume(ring, part, crease):
    """The run then is on the whole: the library does not hold the boundary of a part whose creases are free."""
    crease(ring, {(10 * i, 10 * ((i + 1) % 16)): 1.0 for i in range(16)})
    start, volume = positions(ring), measured(ring, part)
    selected(ring, PART)
    arguments = {"energy": "WILLMORE", "strength": 0.5, "boundary": "FREE", "keep_volume": True}
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, **arguments) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = np.abs(positions(ring) - start).max(axis=1) > 0
    assert moved[40] and set(np.flatnonzero(moved)) <= PART
    assert abs(measured(ring, part) / volume - 1) < 1e-6


# --------------------------------------------------------------------------------------------- again, and the words --


def test_adjusting_runs_again(newcomer, ring, part, monkeypatch):
    """F9 runs again with and without; another strength keeps what was chosen."""
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 600.0)  # a busy machine takes long
    first = positions(minimize(ring, keep_volume=True, **FAIR))
    adjust = part("ui.adjust")

    def again(**chosen):
        bpy.data.objects.remove(bpy.data.objects["Ring Willmore"])
        bpy.context.view_layer.objects.active = ring
        assert bpy.ops.curvopt.apply_result(number=adjust._finished[0], **chosen) == {"FINISHED"}
        return bpy.data.objects["Ring Willmore"]

    assert off(again(keep_volume=False), ring, part) > 3e-4
    assert np.array_equal(positions(again()), first)
    assert off(again(strength=0.5), ring, part) < 1e-6
    assert np.array_equal(positions(again(keep_volume=True)), first)
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 0.0)
    assert adjust._finished[2].first[0].keeps_volume
    adjust._finished[2]._others.clear()
    with pytest.raises(RuntimeError, match="Keep Volume takes over 0 s: set it in the sidebar"):
        bpy.ops.curvopt.apply_result(number=adjust._finished[0], keep_volume=False)


def _edited(part):
    """The cage of the object in Edit Mode."""
    return part("scene.read_edit").read_edit(bpy.context, bpy.context.object).source.cage


def test_adjusting_in_edit_mode_runs_again(ring, part, monkeypatch):
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 600.0)
    volume = measured(ring, part)
    selected(ring, PART)
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy="WILLMORE", strength=0.5, keep_volume=True) == {"FINISHED"}
    number, offs = part("ui.adjust_edit")._finished[0], []
    for keep_volume in (False, True):
        bpy.ops.ed.undo()
        chosen = {"strength": 0.5, "rim": "FREE", "keep_volume": keep_volume}
        assert bpy.ops.curvopt.apply_edit("EXEC_DEFAULT", True, number=number, **chosen) == {"FINISHED"}
        copy = bpy.data.objects.new("Copy", part("scene.write_result").make_mesh("Copy", _edited(part)))
        offs.append(abs(measured(copy, part) / volume - 1))
        bpy.data.objects.remove(copy)
    assert offs[0] > 1e-4 and offs[1] < 1e-6


def test_a_run_that_does_not_reach_the_volume_says_so(newcomer, ring, part, monkeypatch):
    job, solve = part("core.job"), part("core.job").solve

    def missed(*arguments):
        found = solve(*arguments)
        object.__setattr__(found, "scalar_residuals", {**found.scalar_residuals, "volume": -0.0123})
        return found

    monkeypatch.setattr(job, "solve", missed)
    minimize(ring, keep_volume=True, **FAIR)
    assert "The volume could not be kept, it is 1.2 % off" in part("ui.properties").state.message
    assert part("ui.adjust")._warns
    minimize(ring, **FAIR)
    assert "volume" not in part("ui.properties").state.message

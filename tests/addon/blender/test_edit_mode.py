# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator in Edit Mode: the selection moves, everything else stays, and Rim says what stays in between."""

import bmesh
import bpy
import numpy as np
import pytest
import shapes
from mathutils import Vector
from runs import positions

N = 12  # quads of the sheet along a side


@pytest.fixture
def sheet(add):
    """The active object: N x N quads, bumpy, open, its corners kept; vertex y * (N + 1) + x is over (x, y)."""
    points, faces = shapes.grid(N)
    points[:, 2] += 0.15 * np.random.default_rng(11).normal(size=len(points))
    obj = add(points, faces, name="Sheet")
    limit = obj.modifiers.new("Limit", "SUBSURF")
    limit.boundary_smooth, limit.levels, limit.quality, limit.use_limit_surface = "PRESERVE_CORNERS", 2, 10, True
    return obj


def block(low, high):
    """The sheet's vertices low .. high along both axes, as a mask."""
    at = np.arange(N + 1)
    inside = (at >= low) & (at <= high)
    return (inside[:, None] & inside[None, :]).reshape(-1)


def edit(obj, selected=None, mode="VERT"):
    """Go into Edit Mode with those vertices (n,) selected; with None, no one."""
    bpy.context.view_layer.objects.active = obj
    if obj.mode != "EDIT":
        bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="VERT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(obj.data)
    for vertex, chosen in zip(edited.verts, [] if selected is None else selected):
        vertex.select = bool(chosen)
    edited.select_flush_mode()
    bpy.ops.mesh.select_mode(type=mode)
    bmesh.update_edit_mesh(obj.data)
    return edited


def now(obj):
    """Local positions (n, 3) of the vertices that are edited."""
    obj.update_from_editmode()
    return positions(obj)


def run(**arguments):
    arguments = {"energy": "WILLMORE", "strength": 0.5, **arguments}
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, **arguments) == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"


def moved_by(obj, before):
    return (now(obj) != before).any(axis=1)


def mark(obj, pairs, rim):
    """Select these edges alone and mark them; the selection is lost."""
    edited = edit(obj)
    wanted = {tuple(sorted(pair)) for pair in pairs}
    bpy.ops.mesh.select_mode(type="EDGE")
    edited.edges.ensure_lookup_table()
    for edge in edited.edges:
        edge.select = tuple(sorted(vertex.index for vertex in edge.verts)) in wanted
    bmesh.update_edit_mesh(obj.data)
    assert bpy.ops.curvopt.mark_rim(rim=rim) == {"FINISHED"}


def row(y, low, high):
    """The sheet's edges along x over that y."""
    return [(y * (N + 1) + x, y * (N + 1) + x + 1) for x in range(low, high)]


# -------------------------------------------------------------------------------------------------- what is moved --


@pytest.mark.parametrize("rim, rows", [("FREE", 0), ("POSITION", 1), ("TANGENT", 2), ("CURVATURE", 3)])
@pytest.mark.parametrize("boundary", ["POSITION", "FREE"])
def test_the_selection_moves_but_for_the_rows_of_the_rim(sheet, rim, rows, boundary):
    before = positions(sheet)
    edit(sheet, block(2, 10))
    run(rim=rim, boundary=boundary, resolution="REFINE", levels=4, outcome="NEW", pin="SELECTED")
    assert np.array_equal(moved_by(sheet, before), block(2 + rows, 10 - rows))
    assert len(bpy.data.objects) == 1 and len(bpy.data.meshes) == 1


def test_nothing_selected_means_everything_that_is_not_hidden(sheet, part):
    before = positions(sheet)
    edited = edit(sheet)
    run()
    assert np.array_equal(moved_by(sheet, before), block(1, N - 1))
    edited = edit(sheet)
    for number in (6 * (N + 1) + 6, 6 * (N + 1) + 7):
        edited.verts.ensure_lookup_table()
        edited.verts[number].hide_set(True)
    before = now(sheet)
    run()
    still = np.flatnonzero(block(1, N - 1) & ~moved_by(sheet, before))
    assert still.tolist() == [6 * (N + 1) + 6, 6 * (N + 1) + 7]


@pytest.mark.parametrize("mode", ["VERT", "EDGE", "FACE"])
def test_every_select_mode_moves_the_vertices_of_what_is_selected(sheet, mode):
    before = positions(sheet)
    edit(sheet, block(3, 6), mode)
    run()
    assert np.array_equal(moved_by(sheet, before), block(3, 6))
    assert bpy.context.tool_settings.mesh_select_mode[:] == tuple(mode == m for m in ("VERT", "EDGE", "FACE"))


def test_selection_uv_maps_groups_and_creases_are_kept(sheet, crease):
    crease(sheet, {(80, 81): 0.5})
    layer = sheet.data.uv_layers.new(name="Map")
    uv = np.random.default_rng(2).random(2 * len(sheet.data.loops)).astype(np.float32)
    layer.data.foreach_set("uv", uv)
    sheet.vertex_groups.new(name="Some").add([1, 80], 0.25, "REPLACE")
    edit(sheet, block(3, 8))
    names = [name for name in sheet.data.attributes.keys() if not name.startswith(".")]  # others are Edit Mode's
    run()
    assert bmesh.from_edit_mesh(sheet.data).is_valid
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal([vertex.select for vertex in sheet.data.vertices], block(3, 8))
    found = np.empty_like(uv)
    sheet.data.uv_layers["Map"].data.foreach_get("uv", found)
    assert np.array_equal(found, uv) and sheet.data.vertices[80].groups[0].weight == 0.25
    assert set(names) <= {attribute.name for attribute in sheet.data.attributes}
    assert not [name for name in sheet.keys() if name.startswith("curvopt")]


def test_loose_vertices_and_other_objects_stay(add):
    points, faces = shapes.torus()
    other = add(*shapes.torus(), name="Other")
    torus = add([*points, (5, 5, 5)], faces, name="Torus")
    other.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    before = positions(torus)
    run(strength=1.0)
    assert np.flatnonzero(~moved_by(torus, before)).tolist() == [32]
    assert np.array_equal(now(other), shapes.torus()[0].astype(np.float32))


def test_numbers_of_the_report_are_of_the_faces_that_change(sheet, part):
    edit(sheet, block(5, 7))
    run()
    message = part("ui.properties").state.message
    assert message.startswith("Willmore of the 36 faces that change: ") and "(9 vertices moved, " in message
    assert "held" not in message and "Checked: a local minimum" in message


def test_a_bad_face_elsewhere_does_not_matter_and_one_beside_is_named(sheet, part):
    """A fin on an edge."""
    edited = edit(sheet)
    edited.verts.ensure_lookup_table()
    a_number = 5 * (N + 1) + 5
    a, b = edited.verts[a_number], edited.verts[a_number + 1]
    edited.faces.new((a, b, *(edited.verts.new(v.co + Vector((0, 0, 1))) for v in (b, a))))
    bmesh.update_edit_mesh(sheet.data)
    before = now(sheet)
    edit(sheet, [*block(1, 2), False, False])
    run()
    assert "held" not in part("ui.properties").state.message
    edit(sheet, [*block(4, 7), False, False])
    before = now(sheet)
    run()
    message = part("ui.properties").state.message
    assert "10 vertices held as they are, 6 faces left out of the energy: three or more faces share an edge" in message
    assert "(4 vertices moved" in message
    assert f"(vertex {a_number}, vertex {a_number + 1})" in message
    assert np.array_equal(np.flatnonzero(moved_by(sheet, before)), 7 * (N + 1) + np.arange(4, 8))


# --------------------------------------------------------------------------------------------------------- the rim --


def limit(obj):
    """Points (n, 3) of the limit surface by the modifier, and of them those of each of the sheet's faces (m, 16, 4)."""
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    points = np.array([vertex.co for vertex in shown.vertices])
    faces = np.array([list(face.vertices) for face in shown.polygons])
    return points, faces.reshape(-1, 16, 4)


def test_tangent_leaves_the_limit_surface_outside_and_its_tangent_planes_alone(sheet, part):
    """By Blender's own modifier; at the rim, seen from inside, by the library's normals."""
    cage_faces = np.array([list(face.vertices) for face in sheet.data.polygons])
    before, faces = limit(sheet)
    start = normals_inside(sheet, part)
    outside = ~block(2, 10)[cage_faces].all(axis=1)
    edit(sheet, block(2, 10))
    run(rim="TANGENT", strength=1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    after, _ = limit(sheet)
    assert np.abs(after - before)[faces[outside]].max() < 1e-6
    assert np.abs(after - before)[faces[~outside]].max() > 0.1
    turned = np.degrees(np.linalg.norm(normals_inside(sheet, part) - start, axis=1))
    assert turned.max() < 1e-3


def normals_inside(obj, part):
    """Unit normals (k, 3) along the lower rim of the block 2 .. 10, in the limit of the faces inside."""
    library, cage = part("binding.library"), part("scene.read_cage")
    faces, along = np.repeat(2 * N + np.arange(2, 10), 5), np.tile(np.linspace(0, 0.999, 5), 8)
    with library.Mesh.create(library.load(), len(obj.data.vertices), *cage.read_faces(obj.data)) as mesh:
        uv = np.stack([along, np.zeros(40)], -1)
        jets = mesh.jets(positions(obj), faces, np.zeros(40, int), uv)
    normals = np.cross(jets[:, 1], jets[:, 2])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def whole_energy(obj, part):
    """Willmore's energy of everything that can have one."""
    job, cage = part("core.job"), part("scene.read_cage")
    request = job.Request("willmore", 1, {"max_iterations": 1})
    return job.solve(cage.read_source(bpy.context, obj).cage, request).start.objective


def test_the_more_rows_stay_the_more_energy_is_left(sheet, part):
    energies, before = [], positions(sheet)
    for rim in ("FREE", "POSITION", "TANGENT", "CURVATURE"):
        edit(sheet, block(2, 10))
        run(rim=rim, strength=1.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        energies.append(whole_energy(sheet, part))
        sheet.data.vertices.foreach_set("co", before.astype(np.float32).reshape(-1))
        sheet.data.update()
    energies.append(whole_energy(sheet, part))
    assert all(low < 0.99 * high for low, high in zip(energies, energies[1:])), energies


def test_it_ends_where_a_run_with_pins_on_the_whole_cage_does(sheet, part):
    """Spacing apart, in which the mean edge of the faces that count has a part."""
    job, before, values = part("core.job"), positions(sheet), part("binding.values")
    held = values.Held.exactly(np.flatnonzero(~block(3, 8)))
    cage = part("scene.read_cage").read_source(bpy.context, sheet).cage
    pinned = job.solve(cage, job.Request("willmore", 1, held=held))
    edit(sheet, block(3, 8))
    run(strength=1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.abs(positions(sheet) - before).max() > 0.2
    assert whole_energy(sheet, part) == pytest.approx(pinned.end.objective, rel=2e-2)


def test_marks_say_for_single_edges_what_stays(sheet):
    before = positions(sheet)
    mark(sheet, row(3, 3, 8), "TANGENT")
    edit(sheet, block(3, 8))
    run()
    wanted = block(3, 8)
    wanted[: 5 * (N + 1)] = False
    assert np.array_equal(moved_by(sheet, before), wanted)
    mark(sheet, row(3, 3, 8), "CLEAR")
    edit(sheet, block(3, 8))
    before = now(sheet)
    run()
    assert np.array_equal(moved_by(sheet, before), block(3, 8))


def test_marks_on_the_boundary_of_the_mesh_override_boundary(sheet):
    mark(sheet, row(0, 0, N), "FREE")
    before = now(sheet)
    edit(sheet, block(0, N))
    run(strength=0.5)
    moved = moved_by(sheet, before).reshape(N + 1, N + 1)
    assert moved[:N, 2 : N - 1].all() and not moved[N].any() and not moved[:, [0, N]].any()
    mark(sheet, row(0, 0, N), "CURVATURE")
    edit(sheet, block(0, N))
    before = now(sheet)
    run(boundary="FREE", strength=0.5)
    moved = moved_by(sheet, before).reshape(N + 1, N + 1)
    assert not moved[:3].any() and moved[4 : N - 1].all()


def test_marks_are_an_attribute_of_edges_that_modes_and_files_keep(sheet, tmp_path):
    mark(sheet, row(3, 3, 8), "POSITION")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "marked.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "marked.blend"))
    attribute = bpy.data.objects["Sheet"].data.attributes["curvopt_rim"]
    assert (attribute.domain, attribute.data_type) == ("EDGE", "INT")
    assert sorted(value.value for value in attribute.data)[-6:] == [0, 1, 1, 1, 1, 1]


def test_marking_needs_a_selected_edge(sheet):
    edit(sheet)
    with pytest.raises(RuntimeError, match="No edge is selected: select some first"):
        bpy.ops.curvopt.mark_rim(rim="TANGENT")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not bpy.ops.curvopt.mark_rim.poll() and "curvopt_rim" not in sheet.data.attributes


# -------------------------------------------------------------------------------------------------------- symmetry --


def bumpy_torus(add, symmetric):
    points, faces = shapes.torus(16, 8)
    noise = 0.04 * np.random.default_rng(4).normal(size=points.shape)
    if symmetric:
        image = np.array([np.argmin(np.linalg.norm(points - p * (-1, 1, 1), axis=1)) for p in points])
        noise = (noise + noise[image] * (-1, 1, 1)) / 2
    return add(points + noise, faces, name="Torus")


def test_the_meshs_own_symmetry_moves_the_images_as_well(add, part):
    torus = bumpy_torus(add, symmetric=True)
    torus.data.use_mirror_x = True
    before = positions(torus)
    edit(torus, before[:, 0] > 0.8)
    run(symmetry="AUTO")
    moved = moved_by(torus, before)
    assert np.array_equal(moved, np.abs(before[:, 0]) > 0.8) and 10 < moved.sum() < 100
    points = positions(torus)
    gaps = np.linalg.norm(points[:, None] * (-1, 1, 1) - points[None], axis=2).min(axis=1)
    assert gaps.max() < 1e-6
    assert "2 symmetries kept" in part("ui.properties").state.message
    assert "not symmetric" not in part("ui.properties").state.message


def test_where_the_mesh_is_not_symmetric_pairs_get_the_mean_of_both_sides(add, part):
    points, faces = shapes.torus(16, 8)
    points = points + np.where((points[:, :1] > 1.2), 0.3, 0.0) * (0, 0, 1)
    torus = add(points, faces, name="Torus")
    torus.data.use_mirror_x = True
    before = positions(torus)
    chosen = (before[:, 0] > 0.3) & (before[:, 1] > 0.3)
    edit(torus, chosen)
    run(strength=0.6)
    pairs = part("core.partners").Pairs.of_points(before, 0)
    moved = moved_by(torus, before)
    assert np.array_equal(moved, part("core.partners").with_partners(chosen, [pairs]))
    points, with_partner = positions(torus), np.flatnonzero(moved & (pairs.partner >= 0))
    assert 0 < len(with_partner) < moved.sum()
    assert np.abs(points[with_partner] * (-1, 1, 1) - points[pairs.partner[with_partner]]).max() < 1e-6
    remark = "The mesh is not symmetric across X: pairs of vertices got the mean of both sides"
    assert remark in part("ui.properties").state.message


def test_a_mirror_modifier_that_would_merge_more_is_named(sheet, part):
    """It is no part of what undo in Edit Mode brings back, so that it is left alone."""
    sheet.modifiers.new("Mirror", "MIRROR")
    bpy.ops.object.modifier_move_to_index(modifier="Mirror", index=0)
    points = positions(sheet)
    points[:, 0] = np.where(points[:, 0] > 0, points[:, 0] + 0.5, 0)
    sheet.data.vertices.foreach_set("co", points.astype(np.float32).reshape(-1))
    sheet.modifiers["Mirror"].merge_threshold = 2.99  # vertices at x = 1.5 are just not merged
    edit(sheet, block(1, 6))
    run(strength=1.0)
    least = now(sheet)[:, 0][now(sheet)[:, 0] > 0].min()
    assert 0.5 < least < 1.49
    wanted = f"Modifier 'Mirror' merges vertices that were apart: set its Merge distance to {least:.2g}"
    assert wanted in part("ui.properties").state.message
    assert sheet.modifiers["Mirror"].merge_threshold == pytest.approx(2.99)


def test_half_a_cage_under_a_mirror_modifier(sheet, part):
    """The sheet's edge at x = 0 is the seam: what is selected there moves, in the plane."""
    sheet.modifiers.new("Mirror", "MIRROR")
    bpy.ops.object.modifier_move_to_index(modifier="Mirror", index=0)
    before = positions(sheet)
    chosen, inner = (np.zeros((N + 1, N + 1), bool) for _ in range(2))
    chosen[2:11, :7] = inner[4:9, :5] = True
    edit(sheet, chosen.reshape(-1))
    run()
    assert np.array_equal(moved_by(sheet, before), chosen.reshape(-1))
    assert (now(sheet)[:: N + 1, 0] == 0).all()
    before = now(sheet)
    run(rim="TANGENT")  # the seam is neither rim nor boundary
    assert np.array_equal(moved_by(sheet, before), inner.reshape(-1))


# ------------------------------------------------------------------------------------------- undo, adjusting, text --


def test_one_undo_step_takes_it_back_and_redo_brings_it_again(sheet):
    edit(sheet, block(3, 8))
    bpy.ops.ed.undo_push(message="Selected")
    before = now(sheet)
    run()
    after = now(sheet)
    assert not np.array_equal(after, before)
    bpy.ops.ed.undo()
    assert bpy.context.mode == "EDIT_MESH" and np.array_equal(now(bpy.context.object), before)
    bpy.ops.ed.redo()
    assert bpy.context.mode == "EDIT_MESH" and np.array_equal(now(bpy.context.object), after)


def test_adjusting_amount_strength_and_rim(sheet, part, monkeypatch):
    """What the adjust panel does between undo and undo."""
    edit(sheet, block(2, 10))
    bpy.ops.ed.undo_push(message="Selected")
    before = now(sheet)
    run(strength=0.3)
    end, number = now(sheet), part("ui.adjust_edit")._finished[0]
    job, calls = part("core.job"), []
    solve = job.solve
    monkeypatch.setattr(job, "solve", lambda *arguments: calls.append(arguments) or solve(*arguments))

    def again(**properties):
        bpy.ops.ed.undo()
        assert np.array_equal(now(bpy.context.object), before)
        chosen = {"strength": 0.3, "rim": "FREE", **properties}
        assert bpy.ops.curvopt.apply_edit("EXEC_DEFAULT", True, number=number, **chosen) == {"FINISHED"}
        return now(bpy.context.object)

    assert np.abs(again(amount=0.5) - (before + end) / 2).max() < 1e-6
    assert np.array_equal(again(amount=0.0), before) and not calls
    assert np.array_equal(again(), end) and not calls
    tangent = again(rim="TANGENT")
    assert np.array_equal((tangent != before).any(axis=1), block(4, 8)) and len(calls) == 1
    assert np.abs(again(strength=0.8) - before).max() > np.abs(end - before).max() and len(calls) == 2
    assert np.array_equal(again(rim="TANGENT"), tangent) and len(calls) == 2


def test_an_object_that_shows_its_cage_is_told_so(sheet, part):
    edit(sheet, block(3, 8))
    run()
    assert "Subdivision" not in part("ui.properties").state.message
    sheet.modifiers.clear()
    run()
    assert "Object 'Sheet' shows its cage: give it a Subdivision Surface modifier" in part("ui.properties").state.message


def test_slide_can_be_switched_afterwards(sheet, part):
    """A selection at the boundary; one inside has nothing that slides."""
    edit(sheet, block(3, 8))
    run()
    assert not part("ui.adjust_edit")._finished[-1]
    at_the_side = np.zeros((N + 1) ** 2, bool)
    at_the_side.reshape(N + 1, N + 1)[:4, 1:-1] = True
    edit(sheet, at_the_side)
    bpy.ops.ed.undo_push(message="Selected")
    before, side = now(sheet), np.arange(3, N - 2)
    run(strength=1.0)
    held, finished = now(sheet), part("ui.adjust_edit")._finished
    assert finished[-1] and np.array_equal(held[side], before[side])
    for slide in (True, False):
        bpy.ops.ed.undo()
        chosen = {"strength": 1.0, "rim": "FREE", "slide": slide}
        assert bpy.ops.curvopt.apply_edit("EXEC_DEFAULT", True, number=finished[0], **chosen) == {"FINISHED"}
        after = now(bpy.context.object)
        assert ("Slide lets " in part("ui.properties").state.message) == slide
        assert (after[side] != before[side]).any() == slide and (slide or np.array_equal(after, held))


def test_a_mesh_that_was_edited_meanwhile_is_left_alone(sheet, part):
    edited = edit(sheet, block(3, 8))
    run()
    number = part("ui.adjust_edit")._finished[0]
    edited = bmesh.from_edit_mesh(sheet.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co.z += 1
    bmesh.update_edit_mesh(sheet.data)
    before = now(sheet)
    with pytest.raises(RuntimeError, match="The mesh of 'Sheet' was changed meanwhile, so nothing was written"):
        bpy.ops.curvopt.apply_edit(number=number, strength=0.5)
    assert np.array_equal(now(sheet), before)
    bpy.ops.object.mode_set(mode="OBJECT")
    with pytest.raises(RuntimeError, match="'Sheet' went into another mode meanwhile"):
        bpy.ops.curvopt.apply_edit(number=number, strength=0.5)


def refused(obj, sentence, **arguments):
    before = now(obj)
    with pytest.raises(RuntimeError, match=sentence):
        run(**arguments)
    assert bpy.context.mode == "EDIT_MESH"
    np.testing.assert_array_equal(now(obj), before)
    assert len(bpy.data.meshes) == len({o.data.name for o in bpy.data.objects})


def test_refusals_are_one_sentence(sheet, add):
    edit(sheet, block(5, 6))
    refused(sheet, "Nothing may move: the rim holds all that is selected, choose Rim Free or", rim="POSITION")
    edit(sheet, block(0, 0))
    refused(sheet, "Nothing may move: boundary and creases hold all that is selected, choose Boundary Free")
    bpy.ops.object.mode_set(mode="OBJECT")
    sheet.shape_key_add(name="Basis")
    edit(sheet, block(3, 8))
    refused(sheet, "Object 'Sheet' has shape keys: choose Shape Key as the result in Object Mode")
    bpy.ops.object.mode_set(mode="OBJECT")
    edge = add([(0, 0, 0), (1, 0, 0)], [], name="Edge")
    edit(edge, [True, True])
    refused(edge, "Object 'Edge' has no faces")
    bpy.ops.object.mode_set(mode="OBJECT")
    points, faces = shapes.torus()
    points[5, 1] = np.nan
    broken = add([*points, (3, 3, 3)], faces, name="Broken")
    edit(broken, np.arange(33) == 20)
    refused(broken, "vertex 5|Vertex 5")
    edit(broken, np.arange(33) == 32)
    refused(broken, "Nothing may move: no vertex of a face of object 'Broken' is selected")


def test_the_panels_sentence(sheet, part):
    text = part("scene.read_edit").selection_text
    edit(sheet, block(3, 8))
    assert text(sheet) == "Moves 36 selected vertices"
    edit(sheet, block(3, 3))
    assert text(sheet) == "Moves 1 selected vertex"
    sheet.data.use_mirror_x = True
    assert text(sheet) == "Moves 1 selected vertex and their images"
    edit(sheet)
    assert text(sheet) == "Nothing is selected: moves all vertices"


def test_slide_moves_boundary_vertices_along_the_boundary(sheet):
    """The side y = 0, bunched, is straight: it stays straight, and only selected vertices move."""
    points = positions(sheet)
    side = np.arange(N + 1)
    points[side, 2], points[side, 0] = 0, N * (side / N) ** 1.4
    sheet.data.vertices.foreach_set("co", points.ravel().astype(np.float32))
    before, selected = positions(sheet), np.zeros((N + 1) ** 2, bool)
    selected.reshape(N + 1, N + 1)[:4, 1:-1] = True
    edit(sheet, selected)
    run(strength=1.0, slide=True)
    moved = moved_by(sheet, before)
    assert moved[side[2:-2]].all() and not moved[~selected].any() and not moved[[0, N]].any()
    assert np.abs(now(sheet)[side, 1:] - before[side, 1:]).max() < 1e-6
    assert (np.diff(now(sheet)[side, 0]) > 0).all()


def test_the_panel_shows_the_report_also_where_nothing_moved(sheet, part):
    sheet.data.vertices.foreach_set("co", (positions(sheet) * (1, 1, 0)).reshape(-1))
    edit(sheet, block(5, 7))
    run()
    text, failed = part("ui.display").message(bpy.context)
    assert text.startswith("Willmore of the 36 faces that change is 0 already, the least that there is (0 vertices moved, ")
    assert not failed

# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a cage under a Mirror modifier: the whole is optimized, the half is written back, the modifiers are kept."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Matrix
from runs import minimize, positions

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "blend_files"))
from cages import write_obj  # noqa: E402
from halves import HALVES  # noqa: E402

SEAM = 1e-6  # of the size


@pytest.fixture
def half(add):
    """Adds half a mug or half a face, with its Mirror modifier and a Subdivision Surface."""

    def add_half(name):
        entry = HALVES[name]
        obj = add(*entry.make(), name=name)
        return with_modifiers(obj, axes=(entry.axis,))

    return add_half


@pytest.fixture
def quarter(add):
    """The quarter x, y >= 0 of a torus, mirrored across x and y."""
    return with_modifiers(add(*quarter_torus(), name="Quarter"), axes=(0, 1))


def quarter_torus():
    points, faces = shapes.torus(8, 4)
    faces = [face for face in faces if (points[face][:, :2] > -1e-9).all()]
    used = np.unique(np.concatenate(faces))
    number = {vertex: i for i, vertex in enumerate(used)}
    return np.where(np.abs(points[used]) < 1e-9, 0, points[used]), [[number[v] for v in face] for face in faces]


def with_modifiers(obj, axes, subdivided=True):
    modifier = obj.modifiers.new("Mirror", "MIRROR")
    modifier.use_axis = [axis in axes for axis in range(3)]
    if subdivided:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    return obj


def shown(obj):
    """(points (n, 3) in the world, faces as lists) that Blender shows with Subdivision Surface switched off."""
    states = [(modifier, modifier.show_viewport) for modifier in obj.modifiers]
    for modifier, _ in states:
        modifier.show_viewport = modifier.type == "MIRROR"
    bpy.context.view_layer.update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    matrix = np.array(obj.matrix_world, float)
    points = np.array([vertex.co for vertex in mesh.vertices], float) @ matrix[:3, :3].T + matrix[:3, 3]
    faces = [list(polygon.vertices) for polygon in mesh.polygons]
    evaluated.to_mesh_clear()
    for modifier, state in states:
        modifier.show_viewport = state
    return points, faces


def faces_of(cage):
    return [part.tolist() for part in np.split(cage.face_vertices, np.cumsum(cage.face_sizes)[:-1])]


def in_world(points, frame):
    matrix = np.array(frame, float)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def assert_same_cage(points, faces, others, other_faces, turned=False):
    """The same vertices, to single precision, and the same faces as cycles, whatever the order of either."""
    assert len(points) == len(others) and len(faces) == len(other_faces)
    distance = np.linalg.norm(points[:, None] - others[None], axis=2)
    size = np.ptp(points, axis=0).max()
    cycles = {cycle(face) for face in other_faces}
    near = [np.flatnonzero(row <= 2e-6 * size) for row in distance]
    assert all(len(found) for found in near)
    if all(len(found) == 1 for found in near):
        partner = np.array([found[0] for found in near])
        assert len(set(partner)) == len(points)
        assert {cycle(partner[face[::-1] if turned else face]) for face in faces} == cycles
    else:  # vertices in one place: at least the faces' places
        assert places(points, faces, size) == places(others, other_faces, size)


def cycle(face):
    """The same for the same corners in the same order, wherever they begin."""
    face = list(map(int, face))
    start = face.index(min(face))
    return tuple(face[start:] + face[:start])


def places(points, faces, size):
    return sorted(tuple(np.round(np.mean(points[face], axis=0) / size, 4) + 0.0) for face in faces)


def source_of(part, obj):
    return part("scene.read_cage").read_source(bpy.context, obj)


def seam(obj, axis):
    """Vertices of the half that lie in the plane of its own axis."""
    return np.flatnonzero(np.abs(positions(obj)[:, axis]) < 1e-9)


# ----------------------------------------------------------------------------------------------------- the whole --


SCALES = {
    "plain": ((0, 0, 0), (1, 1, 1)),
    "turned": ((0.3, -0.7, 1.1), (1, 1, 1)),
    "scaled": ((0.3, 0.2, 0), (2, 2, 2)),
    "uneven": ((0.3, -0.7, 1.1), (0.5, 2, 1)),
    "negative": ((0.1, 0.2, 0.3), (-1, 1.5, 1)),
}


@pytest.mark.parametrize("name", list(HALVES))
@pytest.mark.parametrize("how", list(SCALES))
def test_whole_cage_is_the_one_that_blender_shows(half, part, name, how):
    obj = half(name)
    obj.rotation_euler, obj.scale = SCALES[how]
    obj.location = (1, -2, 0.5)
    source = source_of(part, obj)
    points, faces = shown(obj)
    assert_same_cage(in_world(source.cage.positions, source.frame), faces_of(source.cage), points, faces,
                     turned=source.mirrored)  # fmt: skip


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1), (0, 2), (0, 1, 2)])
@pytest.mark.parametrize("merge", [True, False])
def test_whole_cage_with_several_axes(add, part, axes, merge):
    obj = with_modifiers(add(*quarter_torus()), axes)
    obj.data.transform(Matrix.Translation((0, 0, 0.7 if 2 in axes else 0)))
    obj.modifiers[0].use_mirror_merge = merge
    obj.scale = (1, 2, 0.7)
    source = source_of(part, obj)
    assert_same_cage(in_world(source.cage.positions, source.frame), faces_of(source.cage), *shown(obj))


@pytest.mark.parametrize("threshold", [1e-4, 0.02, 0.0399, 0.0401, 0.1])
def test_merge_threshold_is_blenders(half, part, threshold):
    """Two vertices of the seam are 0.02 from the plane, so 0.04 from their images."""
    obj = half("half_mug")
    at = seam(obj, 1)[:2]
    for vertex in at:
        obj.data.vertices[vertex].co.y = 0.02
    obj.modifiers[0].merge_threshold = threshold
    source = source_of(part, obj)
    points, faces = shown(obj)
    assert_same_cage(in_world(source.cage.positions, source.frame), faces_of(source.cage), points, faces)
    assert len(points) == 2 * 88 - 30 + (2 if threshold < 0.04 else 0)


@pytest.mark.parametrize("carrier", [False, True])
def test_merge_distance_is_in_the_units_of_the_object(half, part, carrier):
    """Scaled unevenly and turned; with and without another object's plane."""
    obj = half("half_mug")
    obj.rotation_euler, obj.scale, obj.location = (0.5, 0.1, -0.4), (1, 3, 0.5), (1, 2, 3)
    if carrier:
        obj.modifiers[0].mirror_object = mirror_object((0.2, 0.6, -0.3), (2, 0.5, 3), (1, 2, 3))
    read = part("scene.modifiers").read_mirror
    merged = []
    for threshold in np.linspace(0.05, 2.5, 12):
        obj.modifiers[0].merge_threshold = threshold
        shown_vertices = len(shown(obj)[0])
        space = part("scene.frame").space_of(obj, read(obj))
        gaps = space.gaps(space.to_frame(positions(obj)))[:, 1]
        merged.append((gaps < threshold).sum())
        assert shown_vertices == 2 * 88 - merged[-1]
    assert len(set(merged)) > 4


def mirror_object(rotation, scale, location=(0.2, 0.1, -0.3)):
    empty = bpy.data.objects.new("Plane", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.rotation_euler, empty.scale, empty.location = rotation, scale, location
    return empty


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 0.5, 3), (1, -1, 1)])
def test_whole_cage_across_the_planes_of_another_object(half, part, scale):
    """The object itself is scaled unevenly and turned: the reflection is in the other object's axes all the same."""
    obj = half("half_mug")
    obj.rotation_euler, obj.scale, obj.location = (0.5, 0.1, -0.4), (1, 2, 0.5), (1, 2, 3)
    obj.modifiers[0].mirror_object = mirror_object((0.2, 0.6, -0.3), scale)
    obj.modifiers[0].merge_threshold = 0.2
    source = source_of(part, obj)
    assert_same_cage(in_world(source.cage.positions, source.frame), faces_of(source.cage), *shown(obj))


# -------------------------------------------------------------------------------------------------------- results --


def of_command_line(tmp_path, cage, axis, levels):
    """The command line's report on a cage, with all digits, and the symmetry of one plane."""
    start = np.cumsum(cage.face_sizes) - cage.face_sizes
    faces = [tuple(cage.face_vertices[a : a + n]) for a, n in zip(start, cage.face_sizes)]
    write_obj(tmp_path / "whole.obj", "whole", (cage.positions, faces))
    command = [ROOT / "build/release/curvopt", "minimize", "whole.obj", "-o", "out.obj", "--energy", "willmore",
               "--levels", str(levels), "--symmetry", "xyz"[axis], "--json", "-"]  # fmt: skip
    found = subprocess.run(list(map(str, command)), cwd=tmp_path, capture_output=True, text=True, check=True)
    return json.loads(found.stdout)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", list(HALVES))
def test_result_is_half_of_what_the_command_line_finds_of_the_whole(half, part, tmp_path, name, levels):
    obj, axis = half(name), HALVES[name].axis
    cage = source_of(part, obj).cage
    report = of_command_line(tmp_path, cage, axis, levels)
    result = minimize(obj, resolution="REFINE", levels=levels)
    assert result["curvopt_symmetry_order"] == 2 == report["symmetry_order"]
    assert result["curvopt_after_willmore"] == pytest.approx(report["willmore"], rel=1e-9)
    points, faces = shown(result)
    assert len(points) == report["vertices"] and len(faces) == report["faces"]
    size = np.ptp(points, axis=0).max()
    flat = np.abs(positions(result)[:, axis])
    assert len(faces) == 2 * len(result.data.polygons)
    assert (flat < SEAM * size).sum() == (flat == 0).sum() == 2 * len(flat) - len(points)
    assert [modifier.type for modifier in result.modifiers] == ["MIRROR", "SUBSURF"]
    assert list(result.modifiers[0].use_axis) == [i == axis for i in range(3)]


@pytest.mark.parametrize("name", list(HALVES))
def test_committed_halves(name):
    """As the manual says: open the file, press the button."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "blend_files" / f"{name}.blend"), load_ui=False)
    obj = bpy.data.objects[name]
    kept = [(modifier.name, modifier.type) for modifier in obj.modifiers]
    before = seam(obj, HALVES[name].axis)
    minimize(obj, outcome="REPLACE")
    assert [(modifier.name, modifier.type) for modifier in obj.modifiers] == kept
    assert [kind for _, kind in kept] == ["MIRROR", "SUBSURF"] and obj["curvopt_verdict"].startswith("Checked: a local")
    assert np.array_equal(seam(obj, HALVES[name].axis), before)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("how", list(SCALES))
def test_in_place_shows_what_a_new_object_shows(half, how, levels):
    obj = half("half_face")
    obj.rotation_euler, obj.scale = SCALES[how]
    new = minimize(obj, resolution="REFINE", levels=levels)
    points, faces = shown(new)
    points -= np.array(new.matrix_world.translation - obj.matrix_world.translation)
    before = [modifier.name for modifier in obj.modifiers]
    assert minimize(obj, resolution="REFINE", levels=levels, outcome="REPLACE") is obj
    assert [modifier.name for modifier in obj.modifiers] == before
    assert (np.abs(positions(obj)[:, 0]) < 1e-9).sum() == 2 * len(obj.data.vertices) - len(points)
    assert_same_cage(*shown(obj), points, faces, turned=how == "negative")


def test_shape_key_is_of_the_half(half):
    obj = half("half_face")
    new = minimize(obj)
    assert minimize(obj, outcome="SHAPE_KEY") is obj
    key = np.array([point.co for point in obj.data.shape_keys.key_blocks[1].data])
    assert key == pytest.approx(positions(new), abs=1e-6) and len(key) == len(new.data.vertices)
    assert_same_cage(*shown(obj), *[shown(new)[0] - np.array(new.location), shown(new)[1]])
    assert [modifier.type for modifier in obj.modifiers] == ["MIRROR", "SUBSURF"]


def test_two_axes_keep_four_symmetries(quarter):
    result = minimize(quarter)
    assert result["curvopt_symmetry_order"] == 4 and len(result.data.vertices) == 12
    points, faces = shown(result)
    assert len(points) == 32 and len(faces) == 32
    for axis in (0, 1):
        assert np.array_equal(seam(result, axis), seam(quarter, axis)) and len(seam(result, axis)) == 4


def test_chosen_planes_are_kept_besides(quarter):
    quarter.modifiers[0].use_axis = (True, True, False)
    result = minimize(quarter, symmetry="PLANES", symmetry_planes=(False, False, True))
    assert result["curvopt_symmetry_order"] == 8


@pytest.mark.parametrize("symmetry", ["NONE", "KEEP", "AUTO", "ROTATIONS"])
def test_mirror_is_kept_whatever_the_symmetry(half, symmetry):
    assert minimize(half("half_face"), symmetry=symmetry)["curvopt_symmetry_order"] == 2


def test_across_another_object(half):
    """In place the seam is in the other object's plane; a new object has its own axes there."""
    obj = half("half_mug")
    obj.scale, obj.rotation_euler = (1, 2, 0.5), (0.1, 0.2, 0.3)
    empty = mirror_object((0.1, 0.2, 0.3), (1, 3, 1), (0, 0, 0))
    obj.modifiers[0].mirror_object = empty
    new = minimize(obj)
    points, faces = shown(new)
    assert new.modifiers[0].mirror_object is None and len(points) == 146 == len(faces)
    minimize(obj, outcome="REPLACE")
    assert obj.modifiers[0].mirror_object is empty
    mine, my_faces = shown(obj)
    assert_same_cage(mine, my_faces, points - (points.mean(axis=0) - mine.mean(axis=0)), faces)
    matrix = np.array((empty.matrix_world.inverted() @ obj.matrix_world), float)
    across = (positions(obj) @ matrix[:3, :3].T + matrix[:3, 3])[:, 1]
    assert (np.abs(across) < SEAM * np.ptp(across)).sum() == 30


def test_unmerged_halves_stay_apart(half):
    """Without merging there are two open parts; the seam is a boundary that is held."""
    obj = half("half_mug")
    obj.modifiers[0].use_mirror_merge = False
    before = positions(obj)[seam(obj, 1)]
    result = minimize(obj)
    assert not result.modifiers[0].use_mirror_merge and len(shown(result)[0]) == 176
    assert positions(result)[seam(obj, 1)] == pytest.approx(before, abs=1e-6)


def test_threshold_shrinks_where_it_would_merge_more(half):
    """Vertices that a finer cage has near the plane are not merged with their images."""
    obj = half("half_face")
    obj.modifiers[0].merge_threshold = 0.3
    points = len(shown(minimize(obj, resolution="REFINE", levels=3))[0])
    minimize(obj, resolution="REFINE", levels=3, outcome="REPLACE")
    assert obj.modifiers[0].merge_threshold < 0.3 and len(shown(obj)[0]) == points


def test_undo_takes_it_back_in_one_step(half, contents):
    half("half_face")
    bpy.ops.ed.undo_push(message="Half added")
    before = contents()
    run = {"energy": "WILLMORE", "resolution": "SAME", "outcome": "REPLACE"}
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, **run) == {"FINISHED"}
    assert contents() != before
    bpy.ops.ed.undo()
    assert contents() == before


def test_amount_goes_back_to_the_half(half):
    obj = half("half_face")
    result = minimize(obj)
    result.curvopt_amount = 0.0
    assert positions(result) == pytest.approx(positions(obj), abs=1e-6)
    result.curvopt_amount = 0.5
    assert (positions(result)[:, 0] == 0).sum() == (positions(obj)[:, 0] == 0).sum()


# --------------------------------------------------------------------------------------- what belongs to vertices --


@pytest.mark.parametrize("pin", ["GROUP", "SELECTED"])
def test_pins_hold_a_vertex_and_its_image(half, pin):
    obj = half("half_mug")
    held = [3, 17, int(seam(obj, 1)[4])]
    obj.vertex_groups.new(name="Pins").add(held, 1.0, "REPLACE")
    flags = np.zeros(len(obj.data.vertices), bool)
    flags[held] = True
    obj.data.vertices.foreach_set("select", flags)
    result = minimize(obj, pin=pin, vertex_group="Pins")
    moved = np.linalg.norm(positions(result) - positions(obj), axis=1)
    assert moved[held].max() < 1e-6 and np.delete(moved, held).min() > 1e-5
    assert result["curvopt_symmetry_order"] == 2


def test_materials_are_those_of_the_half(half):
    obj = half("half_face")
    for name in ("Red", "Green"):
        obj.data.materials.append(bpy.data.materials.new(name))
    obj.data.polygons.foreach_set("material_index", [index % 2 for index in range(len(obj.data.polygons))])
    result = minimize(obj, resolution="REFINE", levels=2)
    got = [polygon.material_index for polygon in result.data.polygons]
    assert got == [index % 2 for index in range(len(obj.data.polygons)) for _ in range(4)]


def edge_creases(obj):
    """Creases by pairs of vertices."""
    edges = [tuple(sorted(edge.vertices)) for edge in obj.data.edges]
    if bpy.app.version >= (4, 0, 0):
        attribute = obj.data.attributes.get("crease_edge")
        values = [0.0] * len(edges) if attribute is None else [item.value for item in attribute.data]
    else:
        values = [edge.crease for edge in obj.data.edges]
    return {edge: value for edge, value in zip(edges, values) if value > 0}


def test_creases_run_across_the_seam(half, crease, part):
    """An edge in the plane and one beside it; the result has them in its half."""
    obj = half("half_face")
    on = set(map(int, seam(obj, 0)))
    pairs = [tuple(sorted(edge.vertices)) for edge in obj.data.edges]
    inside = next(pair for pair in pairs if set(pair) <= on)
    beside = next(pair for pair in pairs if not set(pair) & on)
    crease(obj, {inside: 0.5, beside: 0.7})
    source = source_of(part, obj)
    assert sorted(source.cage.creases.edge_sharpness.tolist()) == pytest.approx([2.5, 4.9, 4.9], rel=1e-6)
    assert edge_creases(minimize(obj)) == pytest.approx({inside: 0.5, beside: 0.7}, abs=1e-6)
    refined = edge_creases(minimize(obj, resolution="REFINE", levels=2))
    assert len(refined) == 4 and sorted(refined.values()) == pytest.approx([0.15**0.5] * 2 + [0.39**0.5] * 2, abs=1e-6)


def test_modifiers_below_subdivision_are_left_alone(half, contents):
    obj = half("half_mug")
    solid = obj.modifiers.new("Solid", "SOLIDIFY")
    solid.thickness = 0.123
    obj.modifiers.new("Row", "ARRAY").count = 3
    minimize(obj, outcome="REPLACE")
    assert [modifier.name for modifier in obj.modifiers] == ["Mirror", "Subdivision", "Solid", "Row"]
    assert solid.thickness == pytest.approx(0.123) and obj.modifiers["Row"].count == 3


def test_mirror_alone_gets_a_subdivision_below(add):
    obj = with_modifiers(add(*quarter_torus()), (0, 1), subdivided=False)
    minimize(obj, outcome="REPLACE")
    assert [modifier.type for modifier in obj.modifiers] == ["MIRROR", "SUBSURF"]


def test_a_new_object_stands_past_the_whole(quarter):
    first = minimize(quarter)
    second = minimize(quarter)
    ends = [(points[:, 0].min(), points[:, 0].max()) for points in (shown(o)[0] for o in (quarter, first, second))]
    assert ends[0][1] < ends[1][0] and ends[1][1] < ends[2][0]


def test_colours_are_of_the_whole(half):
    obj = half("half_mug")
    assert bpy.ops.curvopt.curvature(levels=0) == {"FINISHED"}
    surface = bpy.context.view_layer.objects.active
    assert len(surface.data.vertices) == 2 * 88 - 30 and [m.type for m in obj.modifiers] == ["MIRROR", "SUBSURF"]


# ------------------------------------------------------------------------------------------------------- refusals --


def refused(obj, pattern):
    before = positions(obj)
    with pytest.raises(RuntimeError, match=pattern) as caught:
        minimize(obj)
    sentence = str(caught.value).removeprefix("Error: ").strip()
    assert sentence.endswith(".") and "\n" not in sentence
    assert np.array_equal(positions(obj), before) and len(bpy.data.objects) <= 3


def test_bisect(half):
    obj = half("half_mug")
    obj.modifiers[0].use_bisect_axis[0] = True  # of an axis that is not used
    minimize(obj)
    obj.modifiers[0].use_bisect_axis[1] = True
    refused(obj, "Modifier 'Mirror' of object 'half_mug' cuts the mesh: delete the half that it cuts away and switch Bisect off")


def test_second_mirror(half):
    obj = half("half_mug")
    obj.modifiers.new("Again", "MIRROR")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.modifier_move_to_index(modifier="Again", index=1)
    refused(obj, "Modifier 'Again' of object 'half_mug' is a second Mirror")


def test_whole_object_under_a_mirror(torus):
    with_modifiers(torus, (0,))
    refused(torus, "^Error: Edge [0-9]+ of object 'Torus' lies in the plane of modifier 'Mirror' and has faces on both")


def test_whole_object_without_a_vertex_in_the_plane(add):
    obj = with_modifiers(add(*shapes.cube()), (1,))
    refused(obj, "^Error: Object 'Cage' is symmetric without modifier 'Mirror', which puts its image on top of it")


def test_wall_in_the_plane(add):
    points, faces = shapes.cube()
    obj = with_modifiers(add(points + (1, 0, 0), faces), (0,))
    refused(obj, "^Error: Face 0 of object 'Cage' lies in the plane of modifier 'Mirror' and is a wall inside")


def test_sheared_mirror_object(half):
    obj = half("half_mug")
    parent = mirror_object((0, 0, 0.5), (1, 2, 1))
    child = mirror_object((0, 0, 0.6), (1, 1, 1))
    child.parent = parent
    parent.scale = (1, 3, 1)
    obj.modifiers[0].mirror_object = child
    refused(obj, "reflects along the Y axis of object 'Plane.001', which is sheared")


def test_flat_mirror_object(half):
    obj = half("half_mug")
    obj.modifiers[0].mirror_object = mirror_object((0, 0, 0), (1, 0, 1))
    refused(obj, "Object 'Plane' is scaled to zero")


def test_array_before_subdivision(half):
    obj = half("half_mug")
    obj.modifiers.new("Row", "ARRAY")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.modifier_move_to_index(modifier="Row", index=1)
    refused(obj, "Modifier 'Row' of object 'half_mug' changes the cage: move it below Subdivision Surface")


def test_vertices_have_the_numbers_of_the_mesh(half):
    obj = half("half_mug")
    obj.data.vertices[20].co.x = float("nan")
    with pytest.raises(RuntimeError, match="^Error: Vertex 20 has coordinate x = nan"):
        minimize(obj)


def test_mirror_that_was_changed_during_the_run_gives_a_new_object(half, part):
    obj = half("half_face")
    source, job = source_of(part, obj), part("core.job")
    request = source.fitted(job.Request("willmore", 1))
    solution = job.solve(source.cage, request)
    obj.modifiers[0].merge_threshold = 0.01
    new, remark = part("scene.placement").write(bpy.context, source, request, solution, "REPLACE")
    assert new is not obj and "Mirror modifier" in remark
    bpy.data.objects.remove(obj)
    last, remark = part("scene.placement").write(bpy.context, source, request, solution, "REPLACE")
    assert "was renamed or deleted" in remark and list(last.modifiers[0].use_axis) == [True, False, False]
    assert len(shown(last)[0]) == len(shown(new)[0]) == len(solution.cage.positions)


def test_the_boundary_in_a_mirror_plane_is_no_tear(quarter, part):
    """It meets its image there, merged or not. One that is there twice in the mesh itself is a tear."""
    for merges in (True, False):
        quarter.modifiers["Mirror"].use_mirror_merge = merges
        minimize(quarter, strength=0.3)
        assert "torn" not in part("ui.properties").state.message

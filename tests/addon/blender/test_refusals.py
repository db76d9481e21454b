# SPDX-License-Identifier: GPL-3.0-or-later
"""Each input that cannot be used gives one sentence that names what and where, and changes nothing."""

import bpy
import numpy as np
import pytest
import shapes


@pytest.fixture
def refused(contents, part):
    """Runs the operator, expects the sentence `pattern`, and that nothing in the file changed."""

    def run(pattern, **arguments):
        before = contents()
        with pytest.raises(RuntimeError, match=pattern) as caught:
            bpy.ops.curvopt.minimize(energy="WILLMORE", levels=2, **arguments)
        sentence = str(caught.value).removeprefix("Error: ").strip()
        assert "\n" not in sentence and sentence.endswith(".") and "Traceback" not in sentence
        assert contents() == before
        state = part("ui.properties").state
        assert state.failed and state.message == sentence and not state.running

    return run


def test_nothing_active(refused):
    refused("Select a mesh object first: nothing is active")


def test_active_object_is_no_mesh(refused):
    camera = bpy.data.objects.new("Cam", bpy.data.cameras.new("Cam"))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.view_layer.objects.active = camera
    refused("Select a mesh object first: 'Cam' is a camera")


def test_active_object_can_be_made_a_mesh(refused):
    text = bpy.data.objects.new("Word", bpy.data.curves.new("Word", "FONT"))
    bpy.context.scene.collection.objects.link(text)
    bpy.context.view_layer.objects.active = text
    refused("'Word' is a text, which Object > Convert > Mesh makes a mesh of")


def test_sculpt_mode(torus, refused):
    bpy.ops.object.mode_set(mode="SCULPT")
    refused("'Torus' is in Sculpt Mode")


@pytest.mark.parametrize("kind", ["ARRAY", "SOLIDIFY", "ARMATURE", "BEVEL", "NODES"])
def test_modifier_before_the_subdivision(torus, refused, kind):
    torus.modifiers.new("Mine", kind)
    torus.modifiers.new("Subdivision", "SUBSURF")
    refused("Modifier 'Mine' of object 'Torus' changes the cage: move it below Subdivision Surface, or apply or remove it")


def test_modifier_without_a_subdivision(torus, refused):
    torus.modifiers.new("Bend", "SIMPLE_DEFORM")
    refused("Modifier 'Bend' of object 'Torus' changes the cage")


def test_simple_subdivision(torus, refused):
    torus.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    refused("Modifier 'Subdivision' of object 'Torus' is set to Simple")


def test_shape_keys(torus, refused):
    torus.shape_key_add(name="Basis")
    refused("'Torus' has shape keys")


def set_edge_crease(mesh, index, value):
    if bpy.app.version >= (4, 0, 0):
        mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data[index].value = value
    else:
        mesh.edges[index].crease = value


def test_crease_that_is_no_number(torus, refused):
    set_edge_crease(torus.data, 7, float("nan"))
    if bpy.app.version < (4, 0, 0) and not np.isnan(torus.data.edges[7].crease):
        torus.data.edge_creases[0].data[7].value = float("nan")  # the property takes 0 .. 1 only
    refused("Edge 7 of object 'Torus' has a crease of nan: set it to 0 .. 1")


@pytest.mark.skipif(bpy.app.version < (4, 0, 0), reason="creases are no attributes yet")
def test_crease_attribute_of_another_kind(torus, refused):
    torus.data.attributes.new("crease_edge", "INT", "POINT")
    refused("Attribute 'crease_edge' of mesh 'Torus' is INT on POINT: delete it, or make it FLOAT on EDGE")


def test_vertex_group_that_is_not_chosen_or_not_there(torus, refused):
    refused("^Error: No vertex group of object 'Torus' is chosen", pin="GROUP")
    refused("^Error: Object 'Torus' has no vertex group 'Pins'", pin="GROUP", vertex_group="Pins")


def test_vertex_group_that_holds_nothing(torus, refused):
    torus.vertex_groups.new(name="Full").add(range(32), 1.0, "REPLACE")
    torus.vertex_groups.new(name="Pins").add(range(32), 0.0, "REPLACE")
    refused("Vertex group 'Pins' of object 'Torus' pins nothing", pin="GROUP", vertex_group="Pins")


def test_vertex_group_that_holds_everything(torus, refused):
    torus.vertex_groups.new(name="Pins").add(range(32), 1.0, "REPLACE")
    refused("^Error: Nothing may move: all 32 vertices are held", pin="GROUP", vertex_group="Pins")


def test_plane_that_the_cage_is_not_symmetric_about(torus, refused):
    torus.data.vertices[5].co.y += 0.1
    refused(
        r"^Error: The cage is not symmetric about the plane x = 0: vertex 5 has no partner, the nearest to its mirror "
        r"image is vertex 13, 0\.1 away", symmetry="PLANES", symmetry_planes=(True, False, False),
    )  # fmt: skip


def test_weights_that_are_not_symmetric(torus, refused):
    torus.vertex_groups.new(name="Pins").add([5], 0.5, "REPLACE")
    refused("vertex 5 and its partner 13 differ in creases or in how they are held", pin="GROUP", vertex_group="Pins",
            symmetry="PLANES")  # fmt: skip


def test_no_plane_is_chosen(torus, refused):
    refused("^Error: No mirror plane is chosen", symmetry="PLANES", symmetry_planes=(False, False, False))


@pytest.mark.parametrize("pin", ["SELECTED", "UNSELECTED"])
def test_pinning_by_a_selection_of_nothing(torus, refused, pin):
    torus.data.vertices.foreach_set("select", [False] * 32)
    refused("No vertex of object 'Torus' is selected: select some in Edit Mode first", pin=pin)


@pytest.fixture
def library_file(tmp_path, torus):
    """A .blend with the object Torus; the open file is empty again."""
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return path


def test_linked_object(library_file, refused):
    with bpy.data.libraries.load(library_file, link=True) as (_, into):
        into.objects = ["Torus"]
    bpy.context.scene.collection.objects.link(into.objects[0])
    bpy.context.view_layer.objects.active = into.objects[0]
    refused("'Torus' or its mesh is linked")


def test_linked_mesh(library_file, refused):
    with bpy.data.libraries.load(library_file, link=True) as (_, into):
        into.meshes = ["Torus"]
    local = bpy.data.objects.new("Local", into.meshes[0])
    bpy.context.scene.collection.objects.link(local)
    bpy.context.view_layer.objects.active = local
    refused("'Local' or its mesh is linked")


def test_library_override(library_file, refused):
    with bpy.data.libraries.load(library_file, link=True) as (_, into):
        into.objects = ["Torus"]
    bpy.context.scene.collection.objects.link(into.objects[0])
    override = into.objects[0].override_create(remap_local_usages=True)
    bpy.context.view_layer.objects.active = override
    refused("'Torus' or its mesh is linked")


def test_cage_beyond_memory(torus, refused, part, monkeypatch):
    monkeypatch.setattr(part("core.memory"), "available", lambda: 1e5)
    refused("The cage has 32 vertices, for which a run takes")


def test_no_faces(add, refused):
    add([(0, 0, 0), (1, 0, 0)], [], "Empty")
    refused("'Empty' has no faces")


def test_zero_scale(torus, refused):
    torus.scale.z = 0
    refused("'Torus' is scaled to zero")


def test_position_that_is_no_number(torus, refused, contents):
    torus.data.vertices[5].co.x = float("nan")
    refused("^Error: Vertex 5 has coordinate x = nan")


def test_infinite_position(torus, refused):
    torus.data.vertices[5].co.x = float("inf")  # Blender keeps the largest float32 instead
    refused("(?i)area|resolve|coordinate|in one place")


def test_cage_without_area(add, refused):
    points, faces = shapes.cube()
    add(points * 0, faces)
    refused("(?i)area|size|point|extent")


def test_missing_library(torus, refused, monkeypatch, tmp_path):
    monkeypatch.setenv("CURVOPT_LIBRARY", str(tmp_path / "libcurvopt.so"))
    refused("The curvopt library is missing: looked for .*libcurvopt.so")


def test_older_library(torus, refused, monkeypatch, tmp_path):
    import subprocess

    code, old = tmp_path / "old.c", tmp_path / "libcurvopt.so"
    code.write_text('const char *curvopt_version(void) { return "0.0.9"; }')
    subprocess.run(["cc", "-shared", "-fPIC", str(code), "-o", str(old)], check=True)
    monkeypatch.setenv("CURVOPT_LIBRARY", str(old))
    refused("version 0.0.9, but this add-on or package needs 0.1")


def test_addon_registers_without_a_library(torus, monkeypatch, tmp_path):
    import addon_utils

    monkeypatch.setenv("CURVOPT_LIBRARY", str(tmp_path / "libcurvopt.so"))
    addon_utils.disable("curvopt")
    assert addon_utils.enable("curvopt") is not None
    with pytest.raises(RuntimeError, match="library is missing"):
        bpy.ops.curvopt.minimize()


def test_corners_in_one_place(add, refused):
    """Two quads back to back are folded flat, with or without."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 0), (0, 1, 0)]
    add(points, [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0]])
    refused(r"; 2 faces have corners in one place \(face 0\): merge them by distance")


def test_everything_is_no_manifold(add, refused):
    """Three quads that share an edge."""
    add([(0, 0, 0), (0, 0, 1), *((x, y, z) for x, y in ((1, 0), (0, 1), (-1, -1)) for z in (0, 1))],
        [[0, 1, k + 1, k] for k in (2, 4, 6)])  # fmt: skip
    refused("^Error: No face is left in the energy: all 3 are held as they are, the first at vertex 0, where three or more")


@pytest.fixture
def said(part):
    """What the sidebar says, and whether in red."""
    return lambda: part("ui.display").message(bpy.context)


def test_a_refusal_is_for_the_object_that_it_is_about(torus, add, refused, said):
    add(*shapes.torus(), name="Other")
    bpy.context.view_layer.objects.active = torus
    refused("Nothing may move|No vertex group", pin="GROUP")
    text, failed = said()
    assert failed and "No vertex group of object 'Torus'" in text
    bpy.context.view_layer.objects.active = bpy.data.objects["Other"]
    assert said() == ("", False)
    bpy.context.view_layer.objects.active = torus
    assert said() == (text, True)


def test_a_refusal_goes_when_its_reason_has_gone(torus, refused, said):
    """Of those that the panel looks for by itself."""
    torus.modifiers.new("Mine", "ARRAY")
    refused("Modifier 'Mine' of object 'Torus' changes the cage")
    assert said()[1]
    torus.modifiers.clear()
    assert said() == ("", False)


def test_a_refusal_without_an_active_object_goes_with_one(refused, add, said):
    refused("nothing is active")
    assert said()[1]
    add(*shapes.torus())
    assert said() == ("", False)


def test_a_refusal_does_not_outlive_its_file(torus, refused, part, add):
    torus.shape_key_add(name="Basis")
    refused("'Torus' has shape keys")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    state = part("ui.properties").state
    assert (state.message, state.failed) == ("", False)


def test_modifier_without_a_subdivision_is_told_to_get_one(torus, refused):
    torus.modifiers.new("Mine", "ARRAY")
    refused("changes the cage: add a Subdivision Surface modifier above it, or apply or remove it first")


def test_no_crossings_and_slide(torus, refused):
    refused("^Error: No Crossings and Slide exclude each other: turn one of them off", no_crossings=True, slide=True)


@pytest.mark.parametrize("kind, words", [
    ("CURVES", "is a hair curves object"), ("POINTCLOUD", "is a point cloud"), ("GPENCIL", "is a Grease Pencil object"),
    ("GREASEPENCIL", "is a Grease Pencil object"), ("LIGHT_PROBE", "is a light probe"), ("EMPTY", "is an empty"),
])  # fmt: skip
def test_types_of_objects_have_words(part, kind, words):
    class Other:
        name, type = "Thing", kind

    with pytest.raises(part("scene.modifiers").CageError, match=f"'Thing' {words}"):
        part("scene.read_cage").check_object(Other())

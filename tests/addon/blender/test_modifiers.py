# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers beside Mirror: those below Subdivision Surface stay; Multiresolution is its base cage without detail."""

import bpy
import numpy as np
import pytest
from runs import minimize, positions


@pytest.fixture
def plain(torus):
    """What a torus without modifiers gives."""
    found = positions(minimize(torus))
    bpy.context.view_layer.objects.active = torus
    return found


BELOW = ["SOLIDIFY", "ARRAY", "MIRROR", "BEVEL", "SIMPLE_DEFORM", "ARMATURE", "SUBSURF", "DECIMATE", "NODES"]


@pytest.mark.parametrize("outcome", ["NEW", "REPLACE", "SHAPE_KEY"])
def test_all_that_is_below_subdivision_stays(torus, plain, outcome):
    torus.modifiers.new("Subdivision", "SUBSURF")
    for kind in BELOW:
        torus.modifiers.new(kind, kind)
    before = [(modifier.name, modifier.type) for modifier in torus.modifiers]
    result = minimize(torus, outcome=outcome)
    assert [(modifier.name, modifier.type) for modifier in torus.modifiers] == before
    if outcome == "NEW":
        assert [modifier.type for modifier in result.modifiers] == ["SUBSURF"]
    if outcome == "SHAPE_KEY":
        found = np.array([point.co for point in torus.data.shape_keys.key_blocks[1].data])
    else:
        found = positions(result)
    assert found == pytest.approx(plain, abs=1e-6)


def test_a_mirror_below_subdivision_is_no_symmetry(torus):
    torus.modifiers.new("Subdivision", "SUBSURF")
    torus.modifiers.new("Mirror", "MIRROR")
    assert minimize(torus, symmetry="NONE")["curvopt_symmetry_order"] == 1


@pytest.fixture
def multires(torus):
    torus.modifiers.new("Multires", "MULTIRES")
    for _ in range(2):
        bpy.ops.object.multires_subdivide(modifier="Multires")
    return torus


def sculpt(obj):
    """Detail of a twentieth of the size at every third point."""
    helper = obj.copy()
    helper.data = obj.data.copy()
    helper.modifiers.clear()
    helper.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.context.scene.collection.objects.link(helper)
    bpy.context.view_layer.update()
    mesh = bpy.data.meshes.new_from_object(helper.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    for vertex in mesh.vertices:
        vertex.co *= 1 + 0.05 * (vertex.index % 3 == 0)
    helper.modifiers.clear()
    helper.data = mesh
    helper.select_set(True)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.object.multires_reshape(modifier="Multires") == {"FINISHED"}
    bpy.data.objects.remove(helper)


def test_multires_that_was_never_subdivided_is_idle(torus, plain):
    torus.modifiers.new("Multires", "MULTIRES")
    assert positions(minimize(torus)) == pytest.approx(plain, abs=1e-6)
    minimize(torus, outcome="REPLACE")
    assert [modifier.type for modifier in torus.modifiers] == ["MULTIRES", "SUBSURF"]


def test_multires_without_detail_shows_the_optimum_of_its_base_cage(torus, plain, multires):
    names = {kind: len(getattr(bpy.data, kind)) for kind in ("scenes", "objects", "meshes")}
    minimize(multires, outcome="REPLACE")
    assert positions(multires) == pytest.approx(plain, abs=1e-6)
    assert [modifier.type for modifier in multires.modifiers] == ["MULTIRES"]
    assert multires.modifiers[0].total_levels == 2
    assert {kind: len(getattr(bpy.data, kind)) for kind in names} == names
    bpy.context.view_layer.update()
    evaluated = multires.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert len(evaluated.to_mesh().vertices) == 512
    evaluated.to_mesh_clear()
    assert [modifier.type for modifier in minimize(multires, outcome="NEW").modifiers] == ["SUBSURF"]


def test_multires_with_detail_is_refused(multires, contents):
    sculpt(multires)
    before = contents()
    with pytest.raises(RuntimeError, match="Modifier 'Multires' of object 'Torus' has sculpted detail: remove"):
        minimize(multires)
    assert contents() == before


def test_multires_refined_in_place_is_refused(multires, contents):
    before = contents()
    with pytest.raises(RuntimeError, match="Object 'Torus' has a Multires modifier.*Same Vertices, or Result to New"):
        minimize(multires, outcome="REPLACE", resolution="REFINE", levels=2)
    assert contents() == before
    assert len(minimize(multires, resolution="REFINE", levels=2).data.vertices) == 128


def test_multires_of_a_mesh_that_only_refining_would_move(add, contents):
    plane = add([(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0)], [[0, 1, 2, 3]], "Plane")
    plane.modifiers.new("Multires", "MULTIRES")
    before = contents()
    with pytest.raises(RuntimeError, match="the vertices of its mesh, and all of these are held: set Result to New Object"):
        minimize(plane, outcome="REPLACE")
    assert contents() == before
    assert len(minimize(plane).data.vertices) == 9

# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose vertices and edges are no part of the surface; every result has them where they were."""

import bpy
import numpy as np
import pytest
import shapes

LOOSE = (0, 5, 34)  # vertices of the mesh


@pytest.fixture
def littered(add):
    """A torus with loose vertices before, among and after its own, two of them joined by an edge."""
    points, faces = shapes.torus()
    kept = [index for index in range(35) if index not in LOOSE]
    places = np.full((35, 3), 3.0)
    places[kept] = points
    places[list(LOOSE)] += [[0, 0, 0], [1, 0, 0.5], [0, 1, 0.25]]
    obj = add(places, [[kept[vertex] for vertex in face] for face in faces], name="Littered")
    obj.data.edges.add(1)
    obj.data.edges[64].vertices = (0, 5)
    return obj


@pytest.fixture
def optimum(part):
    """The torus without litter, optimized on its own: (32, 3)."""
    points, faces = shapes.torus()
    sizes, vertices = shapes.packed(faces)
    cage = part("binding.values").Cage(points.astype(np.float32).astype(float), np.array(sizes), np.array(vertices))
    return part("core.job").solve(cage, part("core.job").Request("willmore", 1)).cage.positions


def minimize(**arguments):
    arguments = {"energy": "WILLMORE", "levels": 1, **arguments}
    assert bpy.ops.curvopt.minimize(**arguments) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def positions(points):
    return np.array([point.co for point in points], float)


def loose_edges(mesh):
    used = {edge for polygon in mesh.polygons for edge in polygon.edge_keys}
    return [tuple(edge.vertices) for edge in mesh.edges if tuple(sorted(edge.vertices)) not in used]


def assert_littered(found, before, optimum):
    kept = [index for index in range(35) if index not in LOOSE]
    assert found[kept] == pytest.approx(optimum, abs=1e-6)
    assert np.array_equal(found[list(LOOSE)], before[list(LOOSE)])


@pytest.mark.parametrize("outcome", ["NEW", "REPLACE"])
def test_same_vertices(littered, optimum, outcome):
    before, mesh = positions(littered.data.vertices), littered.data
    result = minimize(outcome=outcome)
    assert_littered(positions(result.data.vertices), before, optimum)
    assert loose_edges(result.data) == [(0, 5)] and len(result.data.polygons) == 32
    assert (result is littered) == (outcome == "REPLACE") == (result.data is mesh)
    result.curvopt_amount = 0.0
    assert positions(result.data.vertices) == pytest.approx(before, abs=1e-6)


def test_shape_key(littered, optimum):
    before = positions(littered.data.vertices)
    minimize(outcome="SHAPE_KEY")
    assert_littered(positions(littered.data.shape_keys.key_blocks[1].data), before, optimum)
    assert loose_edges(littered.data) == [(0, 5)]


@pytest.mark.parametrize("outcome", ["NEW", "REPLACE"])
def test_refined_result_has_them_behind_its_own(littered, outcome):
    before = positions(littered.data.vertices)[list(LOOSE)]
    littered.scale, littered.rotation_euler, littered.location = (2, 1, 1), (0.2, 0.3, 0), (1, 1, 1)
    bpy.context.view_layer.update()
    in_world = [littered.matrix_world @ littered.data.vertices[index].co for index in LOOSE]
    result = minimize(outcome=outcome, levels=2)
    found = positions(result.data.vertices)
    assert len(found) == 131 and loose_edges(result.data) == [(128, 129)]
    if outcome == "REPLACE":
        assert np.array_equal(found[128:], before)
    else:
        bpy.context.view_layer.update()
        shift = result.location - littered.location
        got = [result.matrix_world @ result.data.vertices[index].co - shift for index in (128, 129, 130)]
        assert np.array(got) == pytest.approx(np.array(in_world), abs=1e-5)


def test_under_a_mirror(add):
    """The loose edge is in the half only; the modifier shows its image."""
    points, faces = shapes.cube()
    points = np.array(points) + (1, 0, 0)
    obj = add([*points, (5, 0, 0), (5, 1, 0)], faces[1:], name="Half")  # without the face in the plane
    obj.modifiers.new("Mirror", "MIRROR")
    obj.data.edges.add(1)
    obj.data.edges[len(obj.data.edges) - 1].vertices = (8, 9)
    result = minimize()
    assert loose_edges(result.data) == [(8, 9)] and len(result.data.vertices) == 10
    assert (positions(result.data.vertices)[:4, 0] == 0).all()


@pytest.mark.parametrize("pin", ["GROUP", "SELECTED"])
def test_pins_have_the_numbers_of_the_mesh(littered, pin):
    held = [0, 6, 17]
    littered.vertex_groups.new(name="Pins").add(held, 1.0, "REPLACE")
    littered.data.vertices.foreach_set("select", [index in held for index in range(35)])
    before = positions(littered.data.vertices)
    found = positions(minimize(pin=pin, vertex_group="Pins").data.vertices)
    assert np.flatnonzero((found == before).all(axis=1)).tolist() == sorted({*held, *LOOSE})


def test_surface_at_the_end_of_a_loose_edge_is_sharp_as_blender_shows_it(add, part):
    points, faces = shapes.torus()
    obj = add([*points, (0, 0, 3)], faces)
    obj.data.edges.add(1)
    obj.data.edges[64].vertices = (9, 32)
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.quality = 5
    bpy.context.view_layer.update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    shown = positions(evaluated.to_mesh().vertices)
    assert np.linalg.norm(shown - points[9], axis=1).min() < 1e-6  # the limit surface goes through the vertex
    creases = part("scene.read_cage").read_source(bpy.context, obj).cage.creases
    assert creases.vertices.tolist() == [9] and creases.vertex_sharpness.tolist() == [10]


def test_numbers_in_sentences_are_the_meshs(littered):
    littered.data.vertices[20].co.x = float("nan")
    with pytest.raises(RuntimeError, match="^Error: Vertex 20 has coordinate x = nan"):
        minimize()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages that have no finite energy everywhere, or are no manifold: there they stay as they are, and the panel says so."""
import bpy
import numpy as np
import pytest
import shapes
from runs import positions


@pytest.fixture
def held(part):
    """Runs the operator in place and returns what the panel says; exactly the vertices `stay` must be where they were,
    and all `others` must not."""

    def run(obj, stay, others=(), **arguments):
        before = positions(obj)
        settings = {"energy": "WILLMORE", "resolution": "SAME", "outcome": "REPLACE", "boundary": "FREE", **arguments}
        assert bpy.ops.curvopt.minimize(**settings) == {"FINISHED"}
        moved = np.abs(positions(obj) - before).max(1)
        assert (moved[list(stay)] == 0).all() and (moved[list(others)] > 0).all()
        return part("ui.properties").state.message

    return run


def vertices_of(faces, *of):
    """Vertices of the faces that have one of these."""
    return sorted({v for face in faces if set(face) & set(of) for v in face})


def rest(obj, stay):
    return sorted(set(range(len(obj.data.vertices))) - set(stay))


def test_cone(torus, held, crease):
    stay = vertices_of(shapes.torus()[1], 6)
    crease(torus, vertices={6: 1.0})
    text = held(torus, stay, rest(torus, stay))
    assert "9 vertices held as they are, 4 faces left out of the energy" in text and "cone (vertex 6)" in text


def test_corners_of_a_grid_are_no_exception(add, held):
    """Blender's boundary runs smoothly through them; each has one face."""
    points, faces = shapes.grid()
    points = np.array(points, float)
    points[:, 2] = 0.3 * np.cos(2 * points[:, 0] + 1) * np.sin(points[:, 1] + 2)
    obj = add(points, faces)
    assert "held" not in held(obj, [], rest(obj, []), strength=0.5)


def test_end_of_a_loose_edge(add, held):
    """Blender makes a spike there: the vertex is infinitely sharp. The loose vertex is no part of the cage."""
    points, faces = shapes.torus()
    faces = [[vertex + 1 for vertex in face] for face in faces]
    obj = add([(9, 9, 9), *points], faces)
    obj.data.edges.add(1)
    obj.data.edges[64].vertices = (0, 9)
    stay = [0, *vertices_of(faces, 9)]
    text = held(obj, stay, rest(obj, stay))
    assert "a vertex crease of 1, or the end of a loose edge, makes a cone (vertex 9)" in text


def test_flipped_face(add, held):
    points, faces = shapes.torus()
    faces[6] = faces[6][::-1]
    obj = add(points, faces)
    text = held(obj, vertices_of(faces, *faces[6]))
    assert "one of them is flipped (vertex " in text


def test_edge_of_three_faces(add, held):
    points, faces = shapes.torus()
    a, b = faces[0][:2]
    faces = [*faces, [a, b, 32]]
    obj = add([*points, (0, 0, 5)], faces)
    stay = vertices_of(faces, a, b)
    assert "three or more faces share an edge" in held(obj, stay, rest(obj, stay))


def test_vertex_on_two_boundary_loops(add, held):
    points, faces = shapes.torus()
    faces = [face for i, face in enumerate(faces) if i not in (0, 5)]  # they meet in vertex 5 only
    obj = add(points, faces)
    assert "(vertex 5)" in held(obj, vertices_of(faces, 5))


def test_suzanne(held):
    """All of her gets fairer, her inner vertex of two edges too, and she stays who she is."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.object
    size = max(obj.dimensions)
    before = positions(obj)
    assert "held as they are" not in held(obj, [], [137], boundary="POSITION", strength=0.3)
    assert np.abs(positions(obj) - before).max() < 0.1 * size
    assert obj["curvopt_after_willmore"] < 0.6 * obj["curvopt_before_willmore"]


@pytest.mark.parametrize("energy", ["WILLMORE", "MVS"])
def test_poles_of_many_vertices_in_one_place(held, energy):
    """Of a NURBS sphere that was converted: each pole is a boundary of 32 vertices."""
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    bpy.ops.object.convert(target="MESH")
    obj = bpy.context.object
    points, faces = positions(obj), [list(face.vertices) for face in obj.data.polygons]
    poles = np.flatnonzero(np.abs(points[:, 2]) > 0.999 * np.abs(points[:, 2]).max())
    stay = vertices_of(faces, *poles)
    text = held(obj, stay, energy=energy, strength=0.3)
    assert len(poles) == 64 and "128 vertices held as they are, 64 faces left out of the energy" in text
    assert "vertices in one place, or next to it, leave no tangent plane, Merge by Distance joins them (vertex " in text
    assert "local minimum" in obj["curvopt_verdict"]
    assert (positions(obj)[rest(obj, stay)] != points[rest(obj, stay)]).any(axis=1).mean() > 0.9


def test_quad_that_is_a_triangle_is_no_exception(torus, held):
    torus.data.vertices[6].co = torus.data.vertices[5].co
    assert "held" not in held(torus, [], range(32), strength=0.3)


def test_nothing_is_left_to_move(add, part):
    points, faces = shapes.cube()
    add([*points, (0, 0, 5)], [*faces, [0, 1, 8], [6, 7, 8]])
    with pytest.raises(RuntimeError, match="(?i)^Error: (nothing may move|no face is left in the energy)"):
        bpy.ops.curvopt.minimize(energy="WILLMORE", resolution="SAME")
    assert part("ui.properties").state.failed

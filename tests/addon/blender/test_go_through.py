# SPDX-License-Identifier: GPL-3.0-or-later
"""Go Through: by Blender's own limit surface, the result goes through empties, vertices of meshes and points of curves."""

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree
from runs import minimize, positions

AXES = np.array([[1.2, 0, 0], [0, 0.9, 0.2], [-0.9, 0.3, 0.2], [0.1, -0.2, -1.1]])


@pytest.fixture
def ball(add):
    """A cage of 98 vertices that is no sphere, turned and moved."""
    points, faces = shapes.quad_sphere(4)
    points = np.asarray(points) * [1.0, 0.9, 1.1]
    obj = add(points, faces, name="Ball")
    obj.matrix_world = Matrix.Translation((3, 1, -2)) @ Matrix.Rotation(0.7, 4, (1.0, 2.0, 0.5))
    return obj


@pytest.fixture
def targets():
    """An empty collection of the scene."""
    found = bpy.data.collections.new("Targets")
    bpy.context.scene.collection.children.link(found)
    return found


def add_empty(collection, obj, place, axis):
    """An empty at a place of the object's space, its Z axis along `axis` there."""
    empty = bpy.data.objects.new("Place", None)
    collection.objects.link(empty)
    turn = Vector(axis).to_track_quat("Z", "Y").to_matrix().to_4x4()
    empty.matrix_world = obj.matrix_world @ Matrix.Translation(place) @ turn
    return empty


def surface_of(obj):
    """Blender's limit surface, finely, in the object's space, which is the original's: a new result stands beside it."""
    modifier = next(m for m in obj.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 5, True, 10
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return BVHTree.FromPolygons([vertex.co for vertex in mesh.vertices], [polygon.vertices[:] for polygon in mesh.polygons])


@pytest.mark.parametrize("resolution, levels", [("SAME", 1), ("REFINE", 2)])
def test_through_empties_with_their_normals(ball, targets, part, resolution, levels):
    empties = [add_empty(targets, ball, place, place + [0.2, -0.1, 0.1]) for place in AXES]
    axes = [(ball.matrix_world.inverted() @ empty.matrix_world).to_3x3().col[2] for empty in empties]
    result = minimize(ball, resolution=resolution, levels=levels, through="Targets")
    surface = surface_of(result)
    free = [surface.find_nearest(Vector(place)) for place in AXES]
    assert max(found[3] for found in free) < 2e-4
    cosines = [abs(np.dot(found[1], axis)) for found, axis in zip(free, axes)]
    assert min(cosines) < 0.995  # nothing holds them
    assert "through 4 places" in part("ui.properties").state.message
    result = minimize(ball, resolution=resolution, levels=levels, through="Targets", through_normals=True)
    surface = surface_of(result)
    held = [surface.find_nearest(Vector(place)) for place in AXES]
    assert max(found[3] for found in held) < 2e-4
    assert min(abs(np.dot(found[1], axis)) for found, axis in zip(held, axes)) > 0.9995


def test_through_vertices_of_a_mesh_and_their_normals(ball, targets, add):
    world = np.array(ball.matrix_world)
    cloud = add(AXES @ world[:3, :3].T + world[:3, 3], [[0, 1, 2]], name="Cloud")
    targets.objects.link(cloud)
    normals = AXES + [0.2, -0.1, 0.1]
    normals[3] = 0  # not held
    turned = normals @ world[:3, :3].T
    cloud.data.attributes.new("curvopt_normal", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turned.ravel())
    result = minimize(ball, through="Targets", through_normals=True)
    surface = surface_of(result)
    found = [surface.find_nearest(Vector(place)) for place in AXES]
    assert max(each[3] for each in found) < 2e-4
    cosines = [abs(np.dot(each[1], n)) / np.linalg.norm(n) for each, n in zip(found, normals) if n.any()]
    assert min(cosines) > 0.9995
    assert len(cloud.data.vertices) == 4 and bpy.data.objects.get("Cloud.001") is None


def test_along_a_curve(ball, targets):
    """A closed curve round it, which bevel and extrusion do not make another one; the curve stays as it is."""
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.05)
    circle = bpy.context.view_layer.objects.active
    circle.matrix_world, circle.data.bevel_depth = ball.matrix_world, 0.1
    targets.objects.link(circle)
    before = [(point.co[:], point.handle_left[:]) for point in circle.data.splines[0].bezier_points]
    was = {"objects": len(bpy.data.objects), "curves": len(bpy.data.curves), "meshes": len(bpy.data.meshes)}
    result = minimize(ball, resolution="REFINE", levels=2, through="Targets")
    angles = np.linspace(0, 2 * np.pi, 40)
    places = [(1.05 * np.cos(a), 1.05 * np.sin(a), 0) for a in angles]
    surface = surface_of(result)
    assert max(surface.find_nearest(Vector(place))[3] for place in places) < 1e-2  # between the points, too; a Bezier circle is off by 3e-4
    assert [(point.co[:], point.handle_left[:]) for point in circle.data.splines[0].bezier_points] == before
    assert circle.data.bevel_depth == pytest.approx(0.1)
    now = {"objects": len(bpy.data.objects), "curves": len(bpy.data.curves), "meshes": len(bpy.data.meshes)}
    assert now == {**was, "objects": was["objects"] + 1, "meshes": was["meshes"] + 1}  # the result


def test_refusals_name_what_is_meant(ball, targets):
    def refused(match, **arguments):
        cage = positions(ball).copy()
        with pytest.raises(RuntimeError, match=match):
            minimize(ball, **arguments)
        assert (positions(ball) == cage).all() and len(bpy.data.meshes) == 1

    refused("There is no collection 'Nothing'", through="Nothing")
    refused("Collection 'Targets' has no empty, mesh or curve", through="Targets")
    add_empty(targets, ball, AXES[0], AXES[0])
    refused("strength", through="Targets", strength=0.5)
    add_empty(targets, ball, AXES[0] * [1.1, 1, 1], AXES[0])
    add_empty(targets, ball, AXES[0] * [1.2, 1, 1], AXES[0])
    refused(r"empty 'Place\.00[12]'", through="Targets", through_normals=True)


def test_mirror_modifier_is_refused(add, targets):
    half = add(*shapes.grid(), name="Half")
    half.modifiers.new("Mirror", "MIRROR")
    targets.objects.link(bpy.data.objects.new("Place", None))
    with pytest.raises(RuntimeError, match="'Half' has a Mirror modifier, with which the surface cannot go through places"):
        minimize(half, through="Targets")

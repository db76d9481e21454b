# SPDX-License-Identifier: GPL-3.0-or-later
"""Go Through: by Blender's own limit surface, the result goes through empties, vertices of meshes and points of curves."""

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Euler, Matrix, Vector
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


def add_empty(collection, obj, place, axis):
    """An empty at a place of the object's space, its Z axis along `axis` there."""
    empty = bpy.data.objects.new("Place", None)
    collection.objects.link(empty)
    turn = Vector(axis).to_track_quat("Z", "Y").to_matrix().to_4x4()
    empty.matrix_world = obj.matrix_world @ Matrix.Translation(place) @ turn
    return empty


def surface_of(obj):
    """Blender's limit surface, finely, in the object's space, which is the original's."""
    modifier = next(m for m in obj.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 5, True, 10
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return BVHTree.FromPolygons([vertex.co for vertex in mesh.vertices], [polygon.vertices[:] for polygon in mesh.polygons])


@pytest.mark.parametrize("scale, out", [((1, 1, 1), 1), ((1.5, 0.8, 1), 1), ((1, 1, 1), -1)])
def test_balls_are_touched_and_the_surface_is_curved_like_them(ball, targets, part, scale, out):
    """By the library's derivatives at the nearest point of the result: the ellipsoid's curvatures, in a hollow negative."""
    size, library = 0.5, part("binding.library")
    before = {obj.name for obj in bpy.data.objects}
    empty = add_empty(targets, ball, (0, 0, 1.0), (0.1, 0, out))
    empty.empty_display_type, empty.empty_display_size, empty.scale = "SPHERE", size, scale
    bpy.context.view_layer.update()
    tip = ball.matrix_world.inverted() @ empty.matrix_world @ Vector((0, 0, size))
    result = minimize(ball, through="Targets", through_balls=True, resolution="SAME")
    assert {obj.name for obj in bpy.data.objects} == before | {empty.name, result.name}
    read = part("scene.read_cage").source_of(bpy.context, result, result.data)
    cage, at = read.cage, np.array([(result.matrix_world @ tip)])
    frame = np.array(read.frame, float)
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        place = (at - frame[:3, 3]) @ frame[:3, :3]
        face, corner, uv = part("core.go_through").nearest(mesh, cage.positions, place)
        options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
        with library.Sampler.create(mesh, cage.positions, options) as sampler:
            jets = sampler.jets(face, corner, uv)
    assert np.linalg.norm(jets[0, 0] - place[0]) < 1e-5
    found = part("core.curvature").of_jets(jets)
    wanted = out * np.array([scale[2] / scale[0] ** 2, scale[2] / scale[1] ** 2]) / size
    mean, gauss = wanted.mean(), wanted.prod()
    assert [found.H[0], found.K[0]] == pytest.approx([mean, gauss], rel=1e-4)


def test_balls_that_cannot_be_are_refused(ball, targets):
    empty = add_empty(targets, ball, (0, 0, 0.6), (0, 0, 1))
    empty.empty_display_type = "SPHERE"
    for scale, weight, match in (((1, 0, 1), 1.0, "Empty 'Place', a ball that the surface is to touch, is flat"),
                                 ((1e-8, 1e-8, 1e-8), 0.5, "Empty 'Place' has curvatures that are too large")):  # fmt: skip
        empty.scale, cage = scale, positions(ball).copy()
        with pytest.raises(RuntimeError, match=match):
            minimize(ball, through="Targets", through_balls=True, through_weight=weight)
        assert (positions(ball) == cage).all() and len(bpy.data.meshes) == 1


@pytest.mark.parametrize("resolution, levels", [("SAME", 1), ("REFINE", 2)])
def test_through_empties_with_their_normals(ball, targets, part, resolution, levels):
    empties = [add_empty(targets, ball, place, place + [0.2, -0.1, 0.1]) for place in AXES]
    axes = [(ball.matrix_world.inverted() @ empty.matrix_world).to_3x3().col[2] for empty in empties]
    result = minimize(ball, resolution=resolution, levels=levels, through="Targets")
    surface, stands = surface_of(result), result.matrix_world.inverted() @ ball.matrix_world  # among its places
    free = [surface.find_nearest(stands @ Vector(place)) for place in AXES]
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
    for vertex in ball.data.vertices:
        vertex.select = vertex.index == 0

    def refused(match, **arguments):
        cage = positions(ball).copy()
        with pytest.raises(RuntimeError, match=match):
            minimize(ball, **arguments)
        assert (positions(ball) == cage).all() and len(bpy.data.meshes) == 1

    refused("There is no collection 'Nothing'", through="Nothing")
    refused("Collection 'Targets' has no empty, mesh or curve", through="Targets")
    dot = bpy.data.objects.new("Dot", bpy.data.curves.new("Dot", "CURVE"))
    dot.data.splines.new("POLY")
    targets.objects.link(dot)
    refused("Curve 'Dot' has a spline of one point", through="Targets")
    bpy.data.objects.remove(dot)
    add_empty(targets, ball, AXES[0], AXES[0])
    refused("Go Through needs a Strength of 1", through="Targets", strength=0.5)
    refused("Go Through needs a Within of 0", through="Targets", within=0.5)
    refused("Empty 'Place': the surface is held there by Boundary, creases or pins", through="Targets", pin="UNSELECTED")
    add_empty(targets, ball, AXES[0] * [1.1, 1, 1], AXES[0])
    add_empty(targets, ball, AXES[0] * [1.2, 1, 1], AXES[0])
    refused(r"empty 'Place\.00[12]'", through="Targets", through_normals=True)


def test_too_many_for_the_cage(ball, targets, add):
    """Points of 45 vertices depend on each other; once the cage is subdivided they do not."""
    random = np.random.default_rng(0).normal(size=(45, 3))
    cloud = add(random / np.linalg.norm(random, axis=1)[:, None], [], name="Cloud")
    cloud.matrix_world = ball.matrix_world
    targets.objects.link(cloud)
    with pytest.raises(RuntimeError, match="(?i)vertex [0-9]+ of 'Cloud' and those that touch it hold 45 points, .* cannot be chosen freely: .* or subdivide the cage"):
        minimize(ball, through="Targets", resolution="REFINE")
    bpy.context.view_layer.objects.active = ball
    ball.modifiers.new("Once", "SUBSURF").levels = 1
    bpy.ops.object.modifier_apply(modifier="Once")
    minimize(ball, through="Targets", max_iterations=5)


def halved(add, axes):
    """A part of the ball, at x > 0 and so on, with a Mirror modifier across these axes, turned and moved."""
    points, faces = shapes.quad_sphere(4)
    points = np.asarray(points) * [1.0, 0.9, 1.1]
    faces = [face for face in faces if all((points[list(face), axis] > -1e-9).all() for axis in axes)]
    used = sorted({v for face in faces for v in face})
    half = add(points[used], [[used.index(v) for v in face] for face in faces], name="Half")
    half.matrix_world = Matrix.Translation((3, 1, -2)) @ Matrix.Rotation(0.7, 4, (1.0, 2.0, 0.5))
    half.modifiers.new("Mirror", "MIRROR").use_axis = [axis in axes for axis in range(3)]
    return half


@pytest.mark.parametrize("energy", ["WILLMORE", "MVS"])
@pytest.mark.parametrize("axes", [(0,), (0, 1)], ids=["half", "quarter"])
def test_places_beside_a_mirror_modifier_have_images(add, targets, axes, energy):
    """One is on the side of the mesh, one on the other, one in the plane, one given on both sides."""
    half = halved(add, axes)
    places = np.array([[0.7, 0.6, 0.5], [-0.6, 0.3, -0.8], [0, 0.2, 1.25], [0.8, 0.2, -0.6], [-0.8, 0.2, -0.6]])
    for place in places:
        add_empty(targets, half, place, (0, 0, 1))
    before = positions(half).copy()
    result = minimize(half, through="Targets", energy=energy, resolution="SAME")
    assert [m.type for m in result.modifiers] == ["MIRROR", "SUBSURF"] and (positions(half) == before).all()
    tree = surface_of(result)
    for place in places:
        for sign in (1, -1):
            found, _, _, distance = tree.find_nearest(Vector(place * [sign, 1, 1]))
            assert distance < 2e-3, (place, sign, distance)


def test_what_breaks_the_symmetry_of_a_mirror_modifier_is_refused(add, targets):
    half = halved(add, (0,))
    empty = add_empty(targets, half, (0, 0.2, 1.25), (1, 0, 1))
    before = positions(half).copy()
    with pytest.raises(RuntimeError, match="not symmetric about the plane x"):
        minimize(half, through="Targets", through_normals=True)
    empty.empty_display_type = "SPHERE"
    with pytest.raises(RuntimeError, match="'Half' has a Mirror modifier, which cannot be had with the ball of empty 'Place': apply the modifier first"):
        minimize(half, through="Targets", through_balls=True)
    assert (positions(half) == before).all() and len(bpy.data.meshes) == 1


@pytest.mark.parametrize("scale, turn", [((-1, 1.2, 1), (0, 0, 0)), ((1, 2, 0.5), (0.4, 0.2, 0.5))], ids=["mirrored", "sheared"])
def test_in_place_in_the_world(ball, targets, scale, turn):
    """Empties of negative and uneven scale on a cage that a parent mirrors or shears."""
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale, ball.parent, ball.matrix_basis = scale, parent, Euler(turn).to_matrix().to_4x4()
    bpy.context.view_layer.update()
    world, held = ball.matrix_world.copy(), []
    for place, sign in zip(AXES, (1, -2, 0.5, -1)):
        normal = (world.inverted().transposed().to_3x3() @ Vector(place + [0.1, -0.1, 0.05])).normalized()
        empty = bpy.data.objects.new("Place", None)
        targets.objects.link(empty)
        along = normal.to_track_quat("Z", "Y").to_matrix().to_4x4()
        empty.matrix_world = Matrix.Translation(world @ Vector(place)) @ along @ Matrix.Diagonal((1, -1, sign, 1))
        held.append((world @ Vector(place), normal))
    minimize(ball, through="Targets", through_normals=True, outcome="REPLACE")
    modifier = ball.modifiers[-1]
    modifier.levels, modifier.use_limit_surface, modifier.quality = 6, True, 10
    mesh = ball.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    surface = BVHTree.FromPolygons([world @ vertex.co for vertex in mesh.vertices], [polygon.vertices[:] for polygon in mesh.polygons])
    for place, normal in held:
        found = surface.find_nearest(place)
        assert found[3] < 2e-4 and abs(found[1].dot(normal)) > 0.999


@pytest.fixture
def names(ball, part):
    """What the places of the collection are of."""

    def names_now(with_normals=False):
        source = part("scene.read_cage").read_source(bpy.context, ball)
        return part("scene.read_targets").read_targets(bpy.context, "Targets", with_normals, False, source).names

    return names_now


def test_what_counts(ball, targets, names, part):
    """Children, collections in it, what the eye hides; not what Blender does not evaluate, the cage, and its results."""
    off = bpy.data.collections.new("Off")
    inner = bpy.data.collections.new("Inner")
    for collection in (off, inner):
        targets.children.link(collection)
    made = {}
    for name, collection in zip(("seen", "hidden", "disabled", "excluded", "inner", "child"), (targets,) * 3 + (off, inner, targets)):
        made[name] = bpy.data.objects.new(name, None)
        collection.objects.link(made[name])
    inner.objects.link(made["seen"])
    targets.objects.link(ball)
    made["child"].parent = made["seen"]
    made["hidden"].hide_set(True)
    made["disabled"].hide_viewport = True
    bpy.context.view_layer.layer_collection.children["Targets"].children["Off"].exclude = True
    for number, empty in enumerate(made.values()):
        empty.location = (3.0 + number, 1, -2)
    counted = {"empty 'seen'", "empty 'hidden'", "empty 'inner'", "empty 'child'"}
    found = names()
    assert set(found) == counted and len(found) == 4
    result = minimize(ball, energy="WILLMORE", max_iterations=1)
    assert result.name in targets.objects
    assert set(names()) == counted
    source = part("scene.read_cage").read_source(bpy.context, ball)
    places = part("scene.read_targets").read_targets(bpy.context, "Targets", False, False, source)
    hidden = places.points[places.names.index("empty 'hidden'")]
    assert (ball.matrix_world @ Vector(hidden) - Vector((4, 1, -2))).length < 1e-5
    for name in ("seen", "hidden", "inner", "child"):
        bpy.data.objects.remove(made[name])
    with pytest.raises(RuntimeError, match="disabled in viewports does not count"):
        minimize(ball, through="Targets")


def test_odd_curves_and_meshes_leave_nothing_behind(ball, targets, add, names):
    """Curves without splines, with keys and modifiers, of enormous size; meshes that are flat, large, of no numbers."""
    curve = bpy.data.curves.new("Line", "CURVE")
    curve.dimensions = "3D"
    line = bpy.data.objects.new("Line", curve)
    targets.objects.link(line)

    def counts():
        return {kind: len(getattr(bpy.data, kind)) for kind in ("objects", "meshes", "curves", "shape_keys", "actions")}

    before = counts()
    with pytest.raises(RuntimeError, match="has no empty, mesh or curve"):
        minimize(ball, through="Targets")
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (1, 0, 0, 1)
    plain = len(names())
    line.modifiers.new("Array", "ARRAY")
    line.shape_key_add(name="Basis")
    key = line.shape_key_add(name="Far")
    key.value, key.data[1].co = 1, (20, 0, 0)
    assert len(names()) == plain and key.value == 1
    line.scale = (1e9, 1, 1)
    with pytest.raises(RuntimeError, match="'Targets' has more places than 'Ball' has vertices, 98"):
        minimize(ball, through="Targets")
    assert counts() == {**before, "shape_keys": 1}
    bpy.data.objects.remove(line)
    flat = add(AXES, [], name="Flat")
    flat.location, flat.scale = (3, 1, -2), (1, 1, 0)
    targets.objects.link(flat)
    vectors = flat.data.attributes.new("curvopt_normal", "FLOAT_VECTOR", "POINT").data
    vectors.foreach_set("vector", np.tile([0.1, 0.0, 1.0], 4))
    assert len(names(with_normals=True)) == 4
    vectors[2].vector = (np.nan, 0, 1)
    with pytest.raises(RuntimeError, match="'curvopt_normal' of vertex 2 of 'Flat'"):
        minimize(ball, through="Targets", through_normals=True)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Go Through: chains of edges that follow curves, by Blender's own limit surface and its own evaluation of curves."""

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Matrix, Vector
from mathutils.geometry import interpolate_bezier
from runs import minimize, positions

RIGID = Matrix.Translation((3, 1, -2)) @ Matrix.Rotation(0.7, 4, (1.0, 2.0, 0.5))
SCALE = (1.5, 0.8, 1.2)
TURNED = RIGID @ Matrix.Diagonal((*SCALE, 1))


@pytest.fixture
def ball(add):
    """A cage of 98 vertices, turned, moved and scaled unevenly, with a vertex group Ring of the 16 round its middle."""
    points, faces = shapes.quad_sphere(4)
    obj = add(np.asarray(points) * [1.0, 0.9, 1.1], faces, name="Ball")
    obj.matrix_world = TURNED
    assign(obj, "Ring", [int(v) for v in np.flatnonzero(np.abs(points[:, 2]) < 1e-6)])
    return obj


def assign(obj, name, vertices):
    group = obj.vertex_groups.get(name) or obj.vertex_groups.new(name=name)
    group.add(vertices, 1.0, "REPLACE")


def add_curve(collection, name, splines, world=TURNED, kind="POLY"):
    """A curve object; splines: points [n, 3] and whether each is closed."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    for points, is_closed in splines:
        spline = data.splines.new(kind)
        spline.points.add(len(points) - 1)
        for point, at in zip(spline.points, points):
            point.co = (*at, 1)
        spline.use_cyclic_u = is_closed
        spline.use_endpoint_u = not is_closed
    obj = bpy.data.objects.new(name, data)
    collection.objects.link(obj)
    obj.matrix_world = world
    return obj


def add_circle(collection, name="Ring", radius=1.2):
    """A Bezier circle in the ball's plane z = 0, in parts of the ball's own axes."""
    bpy.ops.curve.primitive_bezier_circle_add(radius=radius)
    circle = bpy.context.view_layer.objects.active
    circle.name, circle.matrix_world, circle.data.bevel_depth = name, TURNED, 0.1
    collection.objects.link(circle)
    return circle


def along(circle, n=400):
    """Points [k, 3] of a closed Bezier curve in the world, by Blender's own formula."""
    points = circle.data.splines[0].bezier_points
    pairs = zip(points, [*points[1:], points[0]])
    found = [p for a, b in pairs for p in interpolate_bezier(a.co, a.handle_right, b.handle_left, b.co, n)[:-1]]
    return np.array([circle.matrix_world @ p for p in found])


def surface_points(obj, vertices):
    """The points [k, 3] of Blender's limit surface that belong to vertices of a result, where the original is: the scale is in
    its vertices, and it stands beside it."""
    modifier = next(m for m in obj.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 1, True, 10
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return np.array([RIGID @ mesh.vertices[v].co for v in vertices])


def group_of(obj, name="Ring"):
    index = obj.vertex_groups[name].index
    return [v.index for v in obj.data.vertices if any(g.group == index for g in v.groups)]


def distances(points, line):
    """Of points [k, 3] from the polygon through `line` [m, 3], closed."""
    a, b = line, np.roll(line, -1, axis=0)
    t = np.clip(((points[:, None] - a) * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(axis=1), 0, 1)
    return np.linalg.norm(points[:, None] - a - t[:, :, None] * (b - a), axis=2).min(axis=1)


def test_a_closed_chain_follows_a_bezier_circle(ball, targets, part):
    """Its limit points are on the curve; the curve, the cage, and what else is in the file stay."""
    circle = add_circle(targets)
    line, ring, before = along(circle), group_of(ball), positions(ball).copy()
    was = {kind: len(getattr(bpy.data, kind)) for kind in ("objects", "curves", "meshes")}
    result = minimize(ball, through="Targets")
    assert distances(surface_points(result, ring), line).max() < 2e-5
    assert "along 1 curve" in part("ui.properties").state.message
    now = {kind: len(getattr(bpy.data, kind)) for kind in was}
    assert now == {**was, "objects": was["objects"] + 1, "meshes": was["meshes"] + 1}
    assert (positions(ball) == before).all() and circle.data.bevel_depth == pytest.approx(0.1)
    assert circle.data.splines[0].resolution_u == 12
    free = minimize(ball)
    assert distances(surface_points(free, ring), line).min() > 0.05


def test_middles_of_edges_follow_the_curve_on_the_second_level(ball, targets):
    circle = add_circle(targets)
    result = minimize(ball, through="Targets", resolution="REFINE", levels=2)
    edges = {tuple(sorted(edge.vertices)): number for number, edge in enumerate(ball.data.edges)}
    ring = group_of(ball)
    inside = [n for ends, n in edges.items() if set(ends) <= set(ring)]
    assert len(inside) == 16
    near = distances(surface_points(result, range(len(result.data.vertices))), along(circle))
    assert (near[ring] < 2e-5).all() and (near < 2e-5).sum() == 32


@pytest.mark.parametrize("kind", ["POLY", "NURBS"])
def test_an_open_chain_follows_part_of_a_line(ball, targets, kind):
    """Of any order in the group, with a curve in a space of its own, longer than the chain; a second guide beside it."""
    points = np.array([v.co[:] for v in ball.data.vertices])
    above = [int(v) for v in np.flatnonzero((np.abs(points[:, 0]) < 1e-6) & (points[:, 2] > 0.3) & (np.abs(points[:, 1]) < 0.75))]
    assert len(above) == 5
    assign(ball, "Over", above[::-1])
    angle = np.linspace(0.2, np.pi - 0.2, 40)
    line = np.column_stack([0 * angle, np.cos(angle), 1.3 * np.sin(angle)])
    own = Matrix.Translation((9, 9, 9)) @ Matrix.Diagonal((2, 0.5, -3, 1))
    turned = np.array([own.inverted() @ (TURNED @ Vector(p)) for p in line])
    curve = add_curve(targets, "Over", [(turned, False)], own, kind)
    circle = add_circle(targets, radius=1.1)
    result = minimize(ball, through="Targets")
    shape = curve.copy()
    mesh = shape.to_mesh()
    dense = np.array([own @ v.co for v in mesh.vertices])
    shape.to_mesh_clear()
    bpy.data.objects.remove(shape)
    found = distances(surface_points(result, above), dense[:-1])
    assert found.max() < 2e-3  # between the points the spline is outside the polygon
    assert distances(surface_points(result, group_of(ball)), along(circle)).max() < 2e-5


def test_a_weight_below_1_ends_between(ball, targets, part):
    """The lower, the farther, and the less bent; curves that cross without meeting are no obstacle."""
    circle = add_circle(targets)
    line, ring = along(circle), group_of(ball)
    far = []
    for weight in (0.999, 0.9, 0.3):
        result = minimize(ball, through="Targets", through_weight=weight)
        assert "near 1 curve" in part("ui.properties").state.message
        far.append(distances(surface_points(result, ring), line).max())
    assert 2e-5 < far[0] < far[1] < far[2]
    points = np.array([v.co[:] for v in ball.data.vertices])
    across = [int(v) for v in np.flatnonzero(np.abs(points[:, 0]) < 1e-6)]
    assign(ball, "Across", across)
    angle = 2 * np.pi * np.arange(40) / 40
    add_curve(targets, "Across", [(np.column_stack([0 * angle, 1.3 * np.cos(angle), 1.4 * np.sin(angle)]), True)])
    with pytest.raises(RuntimeError, match="The chain of '(Ring|Across)' wants vertex .* away from where the chain of '(Ring|Across)' wants it: let the curves meet there, or set a Weight"):
        minimize(ball, through="Targets")
    minimize(ball, through="Targets", through_weight=0.9)


def test_refusals_say_what_to_do(ball, targets):
    """Nothing is written, and no curve that was evaluated is left behind."""

    def refused(match, **arguments):
        cage, counts = positions(ball).copy(), (len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.objects))
        with pytest.raises(RuntimeError, match=match):
            minimize(ball, through="Targets", **arguments)
        assert (positions(ball) == cage).all()
        assert counts == (len(bpy.data.meshes), len(bpy.data.curves), len(bpy.data.objects))

    circle, ring = add_circle(targets), group_of(ball)
    group = ball.vertex_groups["Ring"]
    circle.data.splines[0].use_cyclic_u = False
    refused(r"Curve 'Ring' is open, and the chain of edges is closed: close it \(Toggle Cyclic\)")
    circle.data.splines[0].use_cyclic_u = True
    group.remove(ring[3:5] if len(ring) > 4 else ring)
    chain_of_two = r"Vertex group 'Ring' of object 'Ball', whose chain of edges is to follow the curve of that name, is in pieces"
    group.remove([v for v in ring if v not in ring[:1]])
    refused(rf"has vertex {ring[0]} alone; a chain has two vertices and more: assign the vertices of one chain")
    group.remove(ring)
    refused("has no vertex with a weight above 0: assign those of a chain of edges, or rename the curve")
    points = np.array([v.co[:] for v in ball.data.vertices])
    poles = [int(np.argmax(points[:, 2])), int(np.argmin(points[:, 2]))]
    group.add(poles, 1.0, "REPLACE")
    refused(chain_of_two + f": no edges join vertex {min(poles)} to vertex {max(poles)}")
    group.remove(poles)
    group.add(range(98), 1.0, "REPLACE")
    refused("branches at vertex 0, which edges join to [34] others of it")
    group.remove(range(98))
    group.add(ring, 1.0, "REPLACE")
    refused("The chain of 'Ring' goes through vertex [0-9]+, which is pinned: take it off the pins", pin="GROUP", vertex_group="Ring")
    refused("Go Through needs a Strength of 1", strength=0.5)
    refused("The chain of 'Ring' has 16 edges, which become 1024 on level 7; there can be 1000: .* a Weight below 1", resolution="REFINE", levels=7)
    circle.scale = (0.05, 0.05, 0.05)
    circle.location = (60, 0, 0)
    refused("The chain of 'Ring': on its curve vertex [0-9]+ comes out of order, or where another one is: let the curve run beside")
    bpy.data.objects.remove(circle)
    empty = add_curve(targets, "Ring", [])
    refused("Curve 'Ring', which a chain of edges is to follow, has no spline: draw one")
    bpy.data.objects.remove(empty)
    two = add_curve(targets, "Ring", [([(0, 0, 0), (1, 0, 0)], False)] * 2)
    refused("has 2 splines: give each a curve of its own")
    bpy.data.objects.remove(two)
    dot = add_curve(targets, "Ring", [([(0, 0, 0)], False)])
    refused("Curve 'Ring' has a spline of one point")
    bpy.data.objects.remove(dot)
    far = add_curve(targets, "Ring", [([(0, 0, 0), (1, 0, 0), (0, 1, 0)], True)])
    far.data.splines[0].points[1].co = (float("nan"), 0, 0, 1)
    refused("Curve 'Ring' is at no place")


def test_loose_vertices_and_empties_beside_a_chain(ball, targets):
    """Numbers are the mesh's; a vertex without a face in the group is named, and so is an empty on the chain."""
    add_circle(targets)
    mesh = ball.data
    ring = group_of(ball)
    mesh.vertices.add(1)
    mesh.vertices[98].co = (5, 5, 5)
    result = minimize(ball, through="Targets", max_iterations=3)
    assert np.allclose(positions(result)[98], 5 * np.array(SCALE))
    assign(ball, "Ring", [98])
    with pytest.raises(RuntimeError, match="has vertex 98, which has no face: take it out of the group"):
        minimize(ball, through="Targets")
    ball.vertex_groups["Ring"].remove([98])
    empty = bpy.data.objects.new("Place", None)
    targets.objects.link(empty)
    empty.matrix_world = TURNED @ Matrix.Translation(mesh.vertices[ring[0]].co)
    with pytest.raises(RuntimeError, match="The chain of 'Ring' holds the point of empty 'Place': move it away from the chain, or take it out"):
        minimize(ball, through="Targets")


def test_a_mirror_modifier_is_refused(add, targets):
    half = add(*shapes.grid(), name="Half")
    half.modifiers.new("Mirror", "MIRROR")
    assign(half, "Ring", [0, 1])
    add_circle(targets)
    with pytest.raises(RuntimeError, match="'Half' has a Mirror modifier, which cannot be had with the chain on curve 'Ring': apply the modifier first"):
        minimize(half, through="Targets")


@pytest.fixture
def selected(ball):
    """Selects vertices of the ball in Edit Mode, with one more edge that has no face."""

    def select(vertices):
        if bpy.context.mode == "EDIT_MESH":
            bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.objects.active = ball
        for part_of in (ball.data.vertices, ball.data.edges, ball.data.polygons):
            part_of.foreach_set("select", [False] * len(part_of))
        for vertex in vertices:
            ball.data.vertices[vertex].select = True
        bpy.ops.object.mode_set(mode="EDIT")

    yield select
    if bpy.context.mode == "EDIT_MESH":
        bpy.ops.object.mode_set(mode="OBJECT")


def test_a_new_guide_is_on_the_surface_and_is_followed(ball, selected):
    """Twice: a closed and an open one. A run that is drawn to them keeps the surface; once the curve is moved, the chain goes along."""
    ring = group_of(ball)
    ball.vertex_groups.clear()
    selected(ring)
    assert bpy.ops.curvopt.new_guide() == {"FINISHED"}
    guide = bpy.data.objects["Guide"]
    spline = guide.data.splines[0]
    assert bpy.context.scene.curvopt.through == "Guides" == guide.users_collection[0].name and spline.use_cyclic_u
    points = np.array([v.co[:] for v in ball.data.vertices])
    above = [int(v) for v in np.flatnonzero((np.abs(points[:, 0]) < 1e-6) & (points[:, 2] > 0.3) & (np.abs(points[:, 1]) < 0.75))]
    selected(above)
    assert bpy.ops.curvopt.new_guide() == {"FINISHED"}
    other = bpy.data.objects["Guide.001"]
    assert not other.data.splines[0].use_cyclic_u and len(other.data.splines[0].bezier_points) == 5
    bpy.ops.object.mode_set(mode="OBJECT")
    assert group_of(ball, "Guide") == ring and sorted(group_of(ball, "Guide.001")) == above
    for curve, vertices in ((guide, ring), (other, above)):
        knots = np.array([curve.matrix_world @ knot.co for knot in curve.data.splines[0].bezier_points])
        modifier = ball.modifiers.new("Surface", "SUBSURF")
        at = surface_points(ball, vertices)  # in the ball's own space
        ball.modifiers.remove(modifier)
        at = np.array([TURNED @ RIGID.inverted() @ Vector(p) for p in at])
        assert np.linalg.norm(knots[:, None] - at, axis=2).min(axis=0).max() < 1e-6
    bpy.data.objects.remove(other)
    for knot in spline.bezier_points:
        knot.co.z += 0.1
    result = minimize(ball, through="Guides")
    assert distances(surface_points(result, ring), along(guide)).max() < 2e-5


def test_no_new_guide_without_a_chain(ball, selected):
    """A sentence, and nothing is made."""

    def refused(vertices, match):
        selected(vertices)
        with pytest.raises(RuntimeError, match=match):
            bpy.ops.curvopt.new_guide()
        assert not bpy.data.curves and len(bpy.data.meshes) == 1 and len(ball.vertex_groups) == 1
        assert bpy.context.scene.curvopt.through == "" and "Guides" not in bpy.data.collections

    refused([], "No vertex is selected: select the vertices of a chain of edges")
    refused(range(98), "The selection branches at vertex 0, .* select the vertices of one chain")
    refused([5], "The selection has vertex 5 alone")
    selected([0])
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not bpy.ops.curvopt.new_guide.poll()
    ball.data.vertices.add(1)
    refused([98], "Vertex 98, which has no face, is selected")
    bpy.ops.object.mode_set(mode="OBJECT")
    ball.data.transform(Matrix.Translation((5, 0, 0)))
    ball.modifiers.new("Mirror", "MIRROR")
    refused([0, 1], "has a Mirror modifier, with which no curve can be followed")


def test_no_new_guide_in_a_collection_that_the_scene_has_not(ball, selected):
    """It would not be seen, and not be followed."""
    elsewhere = bpy.data.collections.new("Elsewhere")
    bpy.context.scene.curvopt.through = "Elsewhere"
    selected(group_of(ball))
    with pytest.raises(RuntimeError, match="'Elsewhere' is not in this scene: link it to the scene, or choose another one"):
        bpy.ops.curvopt.new_guide()
    assert not elsewhere.objects and not bpy.data.curves and len(ball.vertex_groups) == 1
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.scene.curvopt.through = ""


def test_a_curve_without_its_vertex_group_is_named(ball, targets, part):
    """As after one of the two was renamed."""
    circle, state = add_circle(targets), part("ui.properties").state
    minimize(ball, through=targets.name)
    assert "along 1 curve" in state.message and "of its name" not in state.message
    circle.name = "Circle"
    ball.vertex_groups.new(name="Bone").add([0, 5, 20], 1.0, "REPLACE")
    minimize(ball, through=targets.name, through_weight=0.5)
    words = (
        "Curve 'Circle' has no vertex group of its name on object 'Ball', so the surface goes through points along it, and vertex "
        "group 'Ring', a chain of edges, has no curve: give both one name if the chain is to follow the curve"
    )
    assert words in state.message
    ball.vertex_groups.remove(ball.vertex_groups["Ring"])
    minimize(ball, through=targets.name, through_weight=0.5)
    assert "of its name" not in state.message

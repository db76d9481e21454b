# SPDX-License-Identifier: GPL-3.0-or-later
"""Creases and boundary rules: what Blender's modifier shows, before and after, is the surface that the library has.

Blender approximates round a cage vertex where creases meet: what is left of its error there falls by 2.2 to 4 with each
step of `quality`, of which there are 10. Everywhere else it is float32's.
"""

import bpy
import numpy as np
import pytest
import shapes
from mathutils.kdtree import KDTree

MODIFIER_LEVELS = 3
ELSEWHERE, AT_VERTICES = 1e-6, 1e-4  # in sizes of the surface

CAGES = {"cube": shapes.cube, "torus": shapes.torus, "grid": shapes.grid, "prism": shapes.prism}


def add_modifier(obj, boundary="ALL", use_creases=True, quality=10):
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.quality, modifier.use_limit_surface = MODIFIER_LEVELS, quality, True
    modifier.boundary_smooth, modifier.use_creases = boundary, use_creases
    return modifier


def minimize(energy="WILLMORE", levels=2, **arguments):
    assert bpy.ops.curvopt.minimize(energy=energy, levels=levels, **arguments) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def limit_points(part, cage):
    """The library's points at corners, (k, 3), and elsewhere, (l, 3), at places where the modifier has vertices."""
    library, sizes = part("binding.library"), np.asarray(cage.face_sizes)
    kinds = [], []
    for face, size in enumerate(sizes):
        corners = range(1 if size == 4 else size)
        ends = [(0, 0), (1, 0), (1, 1), (0, 1)] if size == 4 else [(0, 0)]
        inside = [(0.5, 0), (0, 0.5), (0.5, 0.5), (0.25, 0.75)] if size == 4 else [(1, 0), (1, 1), (0.5, 0.25)]
        for spots, places in zip(kinds, (ends, inside)):
            spots += [(face, corner, uv) for corner in corners for uv in places]
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        return [mesh.jets(cage.positions, *map(list, zip(*spots)))[:, 0] for spots in kinds]


def distance_to_shown(obj, points):
    """Largest distance of points (k, 3), local ones, from the evaluated mesh's vertices, in sizes of that mesh."""
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    assert len(shown.vertices) > len(obj.data.vertices) and np.isfinite(points).all()
    tree = KDTree(len(shown.vertices))
    for vertex in shown.vertices:
        tree.insert(vertex.co, vertex.index)
    tree.balance()
    return max(tree.find(point)[2] for point in points) / np.ptp([vertex.co for vertex in shown.vertices], 0).max()


def assert_shown(obj, part, cage):
    at_vertices, elsewhere = limit_points(part, cage)
    assert distance_to_shown(obj, elsewhere) < ELSEWHERE
    assert distance_to_shown(obj, at_vertices) < AT_VERTICES


def read(part, obj):
    return part("scene.read_cage").read_source(bpy.context, obj).cage


def crease_at_random(crease, obj, seed):
    random = np.random.default_rng(seed)
    edges = {tuple(edge.vertices): random.choice([0, 0, 0.2, 0.35, 0.7, 1]) for edge in obj.data.edges}
    crease(obj, edges, {vertex.index: random.choice([0, 0, 0.2, 0.35, 0.7, 1]) for vertex in obj.data.vertices})


# ------------------------------------------------------------------------------------------------- what is read --


@pytest.mark.parametrize("boundary", ["ALL", "PRESERVE_CORNERS"])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", CAGES)
def test_the_surface_that_is_read_is_the_one_shown(add, part, crease, name, seed, boundary):
    """Creases at random, also of boundary edges and of both edges of a corner, which sharpen it."""
    obj = add(*CAGES[name]())
    crease_at_random(crease, obj, seed)
    add_modifier(obj, boundary)
    cage = read(part, obj)
    assert len(cage.creases.edges) > 0 < len(cage.creases.vertices)
    assert_shown(obj, part, cage)


def test_blenders_error_at_creased_vertices_falls_with_its_quality(add, part, crease):
    obj = add(*shapes.prism())
    crease_at_random(crease, obj, 2)
    modifier = add_modifier(obj)
    at_vertices, errors = limit_points(part, read(part, obj))[0], []
    for modifier.quality in (6, 8, 10):
        errors.append(distance_to_shown(obj, at_vertices))
    assert 4 < errors[0] / errors[1] < 20 and 4 < errors[1] / errors[2] < 20


def test_sharpness_is_ten_times_the_crease_squared(torus, part, crease):
    crease(torus, {(0, 1): 0.5, (1, 2): 1.0, (2, 3): 1e-4}, {5: 0.6})
    creases = read(part, torus).creases
    assert sorted(zip(map(sorted, creases.edges.tolist()), creases.edge_sharpness)) == [([0, 1], 2.5), ([1, 2], 10.0)]
    assert creases.vertices.tolist() == [5] and creases.vertex_sharpness == pytest.approx([3.6], rel=1e-6)


def test_a_corner_is_as_sharp_as_itself_and_the_less_sharp_of_its_edges(add, part, crease):
    obj = add(*shapes.grid())
    crease(obj, {(0, 1): 0.5, (0, 5): 0.6, (3, 4): 0.9, (4, 9): 1.0}, {0: 0.3, 4: 0.5})
    creases = read(part, obj).creases
    assert dict(zip(creases.vertices.tolist(), creases.vertex_sharpness)) == pytest.approx({0: 0.9 + 2.5, 4: 10.0})


@pytest.mark.parametrize("show", [(True, True), (True, False), (False, True)])
def test_modifier_without_creases_means_no_creases(torus, part, crease, show):
    crease(torus, {(0, 1): 0.5})
    modifier = add_modifier(torus, use_creases=False)
    modifier.show_viewport, modifier.show_render = show
    assert len(read(part, torus).creases.edges) == 0


@pytest.mark.parametrize("switched_off", [False, True])
def test_without_a_modifier_creases_count_as_with_a_new_one(torus, part, crease, switched_off):
    crease(torus, {(0, 1): 0.5})
    if switched_off:
        modifier = add_modifier(torus, "PRESERVE_CORNERS", use_creases=False)
        modifier.show_viewport = modifier.show_render = False
    creases = read(part, torus).creases
    assert len(creases.edges) == 1 and creases.rule == "smooth"


def test_creases_of_a_mirrored_object_stay_on_their_edges(torus, part, crease):
    crease(torus, {(0, 1): 0.5}, {7: 0.4})
    torus.scale = (-1, 1, 1)
    creases = read(part, torus).creases
    assert [sorted(edge) for edge in creases.edges.tolist()] == [[0, 1]] and creases.vertices.tolist() == [7]


# ------------------------------------------------------------------------------------------------ what is shown --


def solve_and_add(part, obj, levels, **request):
    """(solution, result object) of the active object; the solution has the positions in double precision."""
    source = part("scene.read_cage").read_source(bpy.context, obj)
    wanted = part("core.job").Request("willmore", levels, {"max_iterations": 12}, **request)
    solution = part("core.job").solve(source.cage, wanted)
    return solution, part("scene.write_result").add_result(bpy.context, source, wanted, solution)


RINGS = {(4 * i + k, 4 * ((i + 1) % 8) + k): c for i in range(8) for k, c in ((0, 1.0), (2, 0.55))}  # of the torus


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_result_of_a_creased_cage_is_the_surface_shown(torus, part, crease, levels):
    """A ring that stays sharp, one of sharpness 3.025 that softens, and a vertex of 4.9."""
    crease(torus, RINGS, {5: 0.7})
    solution, result = solve_and_add(part, torus, levels)
    assert result.modifiers[0].use_creases
    assert_shown(result, part, solution.cage)
    softer = 3.025 - (levels - 1)
    assert set(np.round(solution.cage.creases.edge_sharpness, 5)) == {round(softer, 5), 10.0}
    assert len(solution.cage.creases.edges) == 16 * 2 ** (levels - 1)
    assert solution.cage.creases.vertex_sharpness == pytest.approx([4.9 - (levels - 1)], rel=1e-6)
    assert solution.end.objective < solution.start.objective


@pytest.mark.parametrize("boundary, rule", [("ALL", "smooth"), ("PRESERVE_CORNERS", "corners")])
@pytest.mark.parametrize("levels", [1, 2, 3])
def test_result_of_an_open_creased_cage_is_the_surface_shown(add, part, crease, levels, boundary, rule):
    """Corners by vertex creases, by two sharp edges, or by the rule; a crease across."""
    obj = add(*shapes.grid())
    edges = {(10 + x, 11 + x): 0.5 for x in range(4)}
    if rule == "smooth":
        crease(obj, {**edges, (0, 1): 1.0, (0, 5): 1.0, (3, 4): 0.9, (4, 9): 0.8}, {4: 0.7, 20: 1.0, 24: 1.0})
    else:
        crease(obj, edges)
    add_modifier(obj, boundary)
    solution, result = solve_and_add(part, obj, levels)
    assert result.modifiers[0].boundary_smooth == boundary and solution.cage.creases.rule == rule
    assert_shown(result, part, solution.cage)


@pytest.mark.parametrize("name, levels", [("torus", 1), ("torus", 2), ("grid", 1), ("grid", 2), ("grid", 3)])
@pytest.mark.parametrize("seed", range(3))
def test_creases_written_are_the_creases_read(add, part, crease, name, levels, seed):
    """Whatever they are: of a cage subdivided by the library, written to a mesh, read back."""
    library, obj = part("binding.library"), add(*CAGES[name]())
    crease_at_random(crease, obj, seed)
    cage = read(part, obj)
    mesh = library.Mesh.of_cage(library.load(), cage)
    xyz = cage.positions
    for _ in range(levels - 1):
        mesh, xyz = mesh.refine(xyz)
    written = part("binding.values").Cage(xyz, *mesh.faces(), mesh.creases())
    new = bpy.data.objects.new("New", part("scene.write_result").make_mesh("New", written))
    bpy.context.scene.collection.objects.link(new)
    assert _sharpness(read(part, new).creases) == pytest.approx(_sharpness(written.creases), rel=1e-5, abs=1e-5)
    assert not new.data.validate() and all(polygon.use_smooth for polygon in new.data.polygons)
    assert part("scene.read_cage").read_faces(new.data)[1].tolist() == written.face_vertices.tolist()


def _sharpness(creases):
    edges = zip(map(tuple, np.sort(creases.edges, 1).tolist()), creases.edge_sharpness)
    return {**dict(edges), **dict(zip(creases.vertices.tolist(), creases.vertex_sharpness))}


def test_corners_kept_by_the_rule_get_no_crease(add, part):
    add_modifier(add(*shapes.grid()), "PRESERVE_CORNERS")
    result = minimize(levels=1)
    assert result.modifiers[0].boundary_smooth == "PRESERVE_CORNERS"
    assert len(read(part, result).creases.vertices) == 0


def test_quality_is_as_high_as_memory_allows(part):
    """192 edges of sharpness 9 took Blender 1.4 GB at quality 10; infinitely sharp ones take nothing."""
    quality = part("scene.write_result").shown_quality
    creases = lambda *s: part("binding.values").Creases(edge_sharpness=np.array(s, float))  # noqa: E731
    assert quality(creases(), 4) == quality(creases(*[10.0] * 100_000), 4) == quality(creases(*[4.0] * 1000), 4) == 10
    assert quality(creases(*[9.0] * 192), 4) == 6 and quality(creases(*[9.0] * 100_000), 4) == 4


def test_creases_that_the_modifier_ignores_are_not_carried_over(torus, part, crease):
    plain = minimize(levels=1)["curvopt_after_willmore"]
    bpy.context.view_layer.objects.active = torus
    crease(torus, RINGS)
    torus.modifiers.new("Subdivision", "SUBSURF").use_creases = False
    result = minimize(levels=1)
    assert result["curvopt_after_willmore"] == pytest.approx(plain, rel=1e-9)
    assert len(read(part, result).creases.edges) == 0


def test_cage_without_creases_gives_a_mesh_without(torus, part):
    mesh = minimize(levels=1).data
    creases = mesh.vertex_creases if bpy.app.version < (4, 0, 0) else [n for n in mesh.attributes.keys() if "cr" in n]
    assert len(creases) == 0


# --------------------------------------------------------------------------------------- boundaries, and the verdict --


@pytest.mark.parametrize("boundary, rows", [("POSITION", 1), ("TANGENT", 2), ("CURVATURE", 3), ("FREE", 0)])
def test_boundary_says_how_many_rows_of_an_open_surface_stay(add, boundary, rows):
    n = 8
    points, faces = shapes.grid(n)
    add_modifier(add(points, faces), "PRESERVE_CORNERS")
    result = minimize(levels=1, boundary=boundary)
    moved = np.array([np.linalg.norm(v.co - w.co) for v, w in zip(result.data.vertices, _vertices("Cage"))])
    row = np.array([min(i % (n + 1), i // (n + 1), n - i % (n + 1), n - i // (n + 1)) for i in range(len(points))])
    assert moved[row < rows].max(initial=0) < 1e-6 and moved[row == rows].max() > 1e-4


def _vertices(name):
    return bpy.data.objects[name].data.vertices


def test_boundary_of_the_scene_is_used_when_the_call_gives_none(add):
    points, faces = shapes.torus()
    add(points, faces[1:])
    bpy.context.scene.curvopt.boundary = "FREE"
    result = minimize(levels=1)
    moved = [np.linalg.norm(np.array(v.co) - p) for v, p in zip(result.data.vertices, points)]
    assert max(moved[v] for v in faces[0]) > 1e-3


def test_result_remembers_its_verdict(torus, part):
    stored = part("scene.write_result").stored_verdict
    assert stored(None) == stored(torus) == ""
    assert stored(minimize(levels=1)).startswith("Checked: ")


def test_choices_of_the_panel_are_the_librarys(part):
    assert tuple(item[0].lower() for item in part("ui.properties").BOUNDARIES) == part("binding.abi").BOUNDARIES

# SPDX-License-Identifier: GPL-3.0-or-later
"""Half cages and whole ones, loose parts and their places, without Blender."""

import sys
from pathlib import Path

import numpy as np
import pytest
import shapes
from addon.binding import library, values
from addon.core import job, layout, mirror

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "blend_files"))
from halves import HALVES  # noqa: E402

AXES = [(0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)]


def mesh_of(points, faces, loose_edges=(), creases=None, vertex_crease=None):
    """MeshArrays of points (n, 3), faces and loose edges; creases by pairs of vertices."""
    sides = {tuple(sorted(pair)) for face in faces for pair in zip(face, face[1:] + face[:1])}
    edges = sorted(sides) + [tuple(edge) for edge in loose_edges]
    edge_crease = np.array([(creases or {}).get(edge, 0.0) for edge in edges], np.float32)
    vertex = np.zeros(len(points), np.float32)
    for index, value in (vertex_crease or {}).items():
        vertex[index] = value
    loose = np.arange(len(edges)) >= len(sides)
    sizes, vertices = (np.array(part, np.int32) for part in shapes.packed(faces))
    arrays = np.array(points, float), np.array(edges, np.int32), loose, edge_crease, vertex
    return layout.MeshArrays(*arrays, sizes, vertices)


def test_collapsed_faces():
    """Two corners of the first face are nearly one place; the others' are not, however long their sides are."""
    points = [(0, 0, 0), (1e-6, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 0), (900, 0, 0)]
    assert list(mesh_of(points[:4], [[0, 1, 2, 3]]).collapsed_faces()) == [0]
    assert list(mesh_of(points, [[3, 2, 4], [0, 4, 2, 3]]).collapsed_faces()) == []
    assert list(mesh_of(points[:5], [[2, 3, 4], [1, 4, 2, 3], [3, 0, 1]]).collapsed_faces()) == [2]


def patch(seed=0):
    """The sides x = 2, y = 2, z = 2 of a block, of four faces each, waved; some of their vertices are near planes."""
    points = np.array([(x, y, z) for x in range(3) for y in range(3) for z in range(3)], float)
    number = {tuple(point): i for i, point in enumerate(points)}
    faces = []
    for axis in range(3):
        for a in range(2):
            for b in range(2):
                corners = [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)]
                places = [tuple(np.insert(np.array(corner, float), axis, 2.0)) for corner in corners]
                faces.append([number[place] for place in places[:: -1 if axis == 1 else 1]])
    used = sorted({vertex for face in faces for vertex in face})
    renamed = {vertex: i for i, vertex in enumerate(used)}
    wave = 1 + 0.1 * np.random.default_rng(seed).uniform(size=(len(used), 3))
    return points[used] * wave, [[renamed[vertex] for vertex in face] for face in faces]


def by_hand(points, faces, axes, on_plane):
    """Axis by axis, vertex by vertex: what the modifier does, in another way than mirror.py."""
    points, faces, merged = [tuple(p) for p in points], [list(f) for f in faces], [tuple(m) for m in on_plane]
    for axis in axes:
        image = {}
        for index in range(len(points)):
            point = list(points[index])
            if merged[index][axis]:
                point[axis] = 0.0
                points[index], image[index] = tuple(point), index
            else:
                point[axis] = -point[axis]
                image[index] = len(points)
                points.append(tuple(point))
                merged.append(merged[index])
        faces += [[image[face[0]], *(image[v] for v in face[:0:-1])] for face in list(faces)]
    return np.array(points), faces


def faces_of(sizes, vertices):
    return [part.tolist() for part in np.split(vertices, np.cumsum(sizes)[:-1])]


@pytest.mark.parametrize("axes", AXES)
def test_whole_is_what_mirroring_axis_by_axis_gives(axes):
    points, faces = patch()
    on_plane = (points < 0.5) & np.isin(np.arange(3), axes)
    on_plane[::7] = False  # unmerged ones among them
    halves = mirror.Halves.of_planes(axes, on_plane)
    sizes, vertices = (np.array(part, np.int32) for part in shapes.packed(faces))
    whole, whole_faces = by_hand(points, faces, axes, on_plane)
    assert np.array_equal(halves.positions(points), whole)
    assert faces_of(*halves.faces(sizes, vertices)) == whole_faces
    assert np.array_equal(halves.index[0], np.arange(len(points)))  # the half comes first


def test_without_a_mirror_the_whole_is_the_half():
    points, faces = patch()
    sizes, vertices = (np.array(part, np.int32) for part in shapes.packed(faces))
    halves = mirror.Halves.of_planes((), np.zeros((len(points), 3), bool))
    assert np.array_equal(halves.positions(points), points)
    assert np.array_equal(halves.faces(sizes, vertices)[1], vertices) and halves.axes == ()


def whole_cage(axes=(0, 1, 2)):
    points, faces = patch()
    mesh = mesh_of(points, faces)
    on_plane = (points < 0.5) & np.isin(np.arange(3), axes)
    plan = layout.Layout.of_mesh(mesh, axes, on_plane)
    return mesh, plan, plan.cage(mesh, points, mesh.face_vertices, "smooth", True)


@pytest.mark.parametrize("axes", AXES)
def test_pins_have_images(axes):
    mesh, plan, cage = whole_cage(axes)
    held = plan.held(values.Held(np.array([4, 9]), np.array([1.0, 0.25])))
    places = {tuple(np.abs(p).round(9)) for p in cage.positions[held.vertices]}
    flat = np.where((mesh.positions < 0.5) & np.isin(np.arange(3), axes), 0.0, mesh.positions)
    assert places == {tuple(flat[v].round(9)) for v in (4, 9)}
    images = [2 ** sum(flat[v][axis] > 0 for axis in axes) for v in (4, 9)]
    assert [(held.weights == w).sum() for w in (1.0, 0.25)] == images


@pytest.mark.parametrize("levels", [0, 1, 2])
@pytest.mark.parametrize("axes", AXES)
def test_half_of_a_refined_whole_makes_that_whole_again(axes, levels):
    mesh, plan, cage = whole_cage(axes)
    with library.Mesh.of_cage(library.load(), cage) as net:
        positions = cage.positions
        for _ in range(levels):
            net, positions = net.refine(positions)
        fine = values.Cage(positions, *net.faces(), net.creases())
    written = plan.written(fine)
    half = written.positions(positions, np.empty((0, 3)))
    flat = written.half.on_plane
    assert (flat == ((np.abs(half) < 1e-12) & np.isin(np.arange(3), axes))).all() and (half[flat] == 0).all()
    assert len(written.face_sizes) * 2 ** len(axes) == len(fine.face_sizes)
    again = mirror.Halves.of_planes(axes, flat)
    whole = again.positions(half)
    assert len(whole) == len(positions)
    assert np.abs(sorted_rows(whole) - sorted_rows(positions)).max() < 1e-12
    _, corners = again.faces(written.face_sizes, written.face_vertices)
    middles = (points_of(whole, corners), points_of(positions, fine.face_vertices))
    assert np.abs(sorted_rows(middles[0]) - sorted_rows(middles[1])).max() < 1e-12


def points_of(positions, corners):
    """Middles of quads."""
    return positions[corners.reshape(-1, 4)].mean(axis=1)


def sorted_rows(rows):
    return rows[np.lexsort(rows.round(7).T)]


@pytest.mark.parametrize("name", list(HALVES))
def test_optimum_is_symmetric_and_its_seam_is_in_the_plane(name):
    """The library keeps the plane to rounding: what is clipped is no more."""
    points, faces = HALVES[name].make()
    axis, mesh = HALVES[name].axis, mesh_of(points, [list(face) for face in faces])
    on_plane = (points == 0) & (np.arange(3) == axis)
    plan = layout.Layout.of_mesh(mesh, (axis,), on_plane)
    cage = plan.cage(mesh, points, mesh.face_vertices, "smooth", True)
    assert np.abs(cage.positions.mean(axis=0)[axis]) < 1e-15
    found = job.solve(cage, job.Request("willmore", 2, symmetry=mirror.planes_text("auto", (axis,))))
    written = plan.written(found.cage)
    seam = found.cage.positions[written.half.vertices][written.half.on_plane[:, axis], axis]
    assert len(seam) > on_plane.sum() and np.abs(seam).max() < 1e-12 and found.symmetry_order == 2


def test_symmetry_of_a_run():
    assert mirror.planes_text("auto", ()) == "auto" and mirror.planes_text("x,z", ()) == "x,z"
    assert mirror.planes_text("none", (1,)) == "y" and mirror.planes_text("z", (0, 1)) == "x,y,z"


# ----------------------------------------------------------------------------------------------------- loose parts --


def with_loose():
    """A cube whose vertices 3 and 7 were not there first: loose vertices 3, 7 and 10, loose edges 3-7 and 0-10."""
    points, faces = shapes.cube()
    where = [0, 1, 2, 4, 5, 6, 8, 9]  # of the cube's vertices
    places = np.full((11, 3), 9.0)
    places[where] = points
    places[[3, 7, 10]] += [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    return mesh_of(places, [[where[v] for v in face] for face in faces], [(3, 7), (0, 10)])


def test_loose_parts_are_no_part_of_the_cage():
    mesh = with_loose()
    plan = layout.Layout.of_mesh(mesh)
    cage = plan.cage(mesh, mesh.positions, mesh.face_vertices, "smooth", True)
    assert np.array_equal(cage.positions, shapes.cube()[0]) and not plan.is_plain
    assert faces_of(cage.face_sizes, cage.face_vertices) == shapes.cube()[1]
    assert cage.creases.vertices.tolist() == [0] and cage.creases.vertex_sharpness.tolist() == [10]


def test_loose_parts_are_back_in_their_places():
    mesh = with_loose()
    plan = layout.Layout.of_mesh(mesh)
    cage = plan.cage(mesh, mesh.positions, mesh.face_vertices, "smooth", True)
    written = plan.written(cage)
    moved = written.positions(cage.positions + 1, mesh.positions[plan.loose])
    assert np.array_equal(moved[[3, 7, 10]], mesh.positions[[3, 7, 10]])
    assert np.array_equal(np.delete(moved, [3, 7, 10], 0), np.delete(mesh.positions + 1, [3, 7, 10], 0))
    assert np.array_equal(written.face_vertices, mesh.face_vertices)
    assert written.loose_edges.tolist() == [[3, 7], [0, 10]] and written.vertex_crease[0] == 1


def test_loose_parts_follow_a_refined_cage():
    mesh = with_loose()
    plan = layout.Layout.of_mesh(mesh)
    cage = plan.cage(mesh, mesh.positions, mesh.face_vertices, "smooth", True)
    with library.Mesh.of_cage(library.load(), cage) as net:
        fine, positions = net.refine(cage.positions)
        written = plan.written(values.Cage(positions, *fine.faces(), fine.creases()))
    moved = written.positions(positions, mesh.positions[plan.loose])
    assert len(moved) == 26 + 3 and np.array_equal(moved[26:], mesh.positions[[3, 7, 10]])
    assert written.loose_edges.tolist() == [[26, 27], [0, 28]] and np.array_equal(moved[0], positions[0])


def test_pins_on_loose_vertices_are_none():
    plan = layout.Layout.of_mesh(with_loose())
    held = plan.held(values.Held.exactly([3, 4, 10]))
    assert held.vertices.tolist() == [3] and held.weights.tolist() == [1]


def test_sentences_have_the_numbers_of_the_mesh():
    plan = layout.Layout.of_mesh(with_loose())
    text = plan.in_mesh_numbers("Vertex 3 has valence 2; vertices 4 and 7, face 2, and 6 more of 9 vertices")
    assert text == "Vertex 4 has valence 2; vertices 5 and 9, face 2, and 6 more of 9 vertices"
    _, mirrored, cage = whole_cage((0,))
    last = len(cage.positions) - 1
    assert mirrored.in_mesh_numbers(f"vertex {last}, face 23") == f"vertex {mirrored.halves.origin[last]}, face 11"


# -------------------------------------------------------------------------------------------------------- creases --


def test_creases_are_those_of_the_whole():
    """A corner of the half with two edges has more in the whole: its own crease is all it has."""
    points, faces = patch()
    corner = next(v for v in range(len(points)) if sum(v in face for face in faces) == 1)
    face = next(face for face in faces if corner in face)
    ends = [face[face.index(corner) - 1], face[(face.index(corner) + 1) % 4]]
    pairs = {tuple(sorted((corner, end))): 1.0 for end in ends}
    mesh = mesh_of(points, faces, creases=pairs, vertex_crease={corner: 0.5})
    alone = layout.Layout.of_mesh(mesh).cage(mesh, points, mesh.face_vertices, "smooth", True)
    assert alone.creases.vertex_sharpness.tolist() == [10]
    plan = layout.Layout.of_mesh(mesh, (0, 1, 2), points < 0.5)
    whole = plan.cage(mesh, points, mesh.face_vertices, "smooth", True)
    assert set(whole.creases.vertex_sharpness.tolist()) == {2.5}
    written = plan.written(whole)
    assert {tuple(sorted(edge)) for edge in written.crease_edges.tolist()} == set(pairs)
    assert written.edge_crease.tolist() == [1.0] * 2 and written.vertex_crease[corner] == pytest.approx(0.5)
    assert layout.Layout.of_mesh(mesh).cage(mesh, points, mesh.face_vertices, "smooth", False).creases.edges.size == 0


def test_vertices_of_a_torn_mesh():
    """Two quads side by side whose common edge is there twice; then joined, then apart. Loose vertices do not count."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1 + 1e-8, 0)]
    assert mesh_of(points, [[0, 1, 2, 3], [4, 5, 6, 7]]).n_torn() == 4
    assert mesh_of([*points, (0, 0, 0)], [[0, 1, 2, 3], [1, 5, 6, 2]]).n_torn() == 0
    assert mesh_of([(*point[:2], point[2] + 1e-3 * (k > 3)) for k, point in enumerate(points)], [[0, 1, 2, 3], [4, 5, 6, 7]]).n_torn() == 0


def test_a_closed_mesh_is_not_torn():
    assert mesh_of(*shapes.torus()).n_torn() == 0

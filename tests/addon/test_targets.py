# SPDX-License-Identifier: GPL-3.0-or-later
"""From handles to what the solver holds, without Blender: images by mirrors and planes, points of the surface."""

import numpy as np
import pytest
import shapes
from addon.binding.values import Cage, Held
from addon.core import targets
from addon.core.go_through import Places
from test_layout import mesh_of

AROUND, ACROSS = 8, 4  # of the torus


def torus():
    """(mesh, its layout, the cage) of a torus, every vertex of which has four faces."""
    points, faces = shapes.torus(AROUND, ACROSS)
    mesh = mesh_of(points, faces)
    plain = targets.Layout.of_mesh(mesh)
    return plain, plain.cage(mesh, mesh.positions, mesh.face_vertices, "smooth", True)


def by_mask(cage: Cage) -> np.ndarray:
    """Limit points of a cage of quads whose vertices have four faces each, by the mask 16, 4, 1 of bicubic B-splines."""
    out = np.zeros_like(cage.positions)
    for quad in cage.face_vertices.reshape(-1, 4):
        for corner in range(4):
            vertex, one, across, other = np.roll(quad, -corner)
            beside = 2 * (cage.positions[one] + cage.positions[other])  # each edge belongs to two faces
            out[vertex] += 4 * cage.positions[vertex] + beside + cage.positions[across]
    return out / 36


def test_limit_points():
    _, cage = torus()
    assert np.abs(targets.limit_points(cage) - by_mask(cage)).max() < 1e-13


@pytest.mark.parametrize("on_surface", [False, True])
def test_handles_are_held_where_they_were_moved_to(on_surface):
    plain, cage = torus()
    base = targets.Base.of_cage(cage, plain, on_surface)
    pins = Held(np.array([3, 7]), np.array([0.25, 0.5]))
    shifts = np.array([[0.1, 0.2, 0.3], [0.0, 0.0, 0.0]])
    held, places = base.held(pins, np.array([7, 20]), shifts)
    start = by_mask(cage) if on_surface else cage.positions
    assert held.vertices.tolist() == [3, 7, 20] and held.weights.tolist() == [0.25, 1, 1]
    assert held.limit_points is on_surface
    assert np.isnan(places[0]).all() and np.abs(places[1:] - start[[7, 20]] - shifts).max() < 1e-13


@pytest.mark.parametrize("axes", [(0,), (0, 1)])
def test_images_by_a_mirror_modifier_move_along(axes):
    """Half a torus, or a quarter. Every copy of a handle is where its reflection is; one in the plane stays in it."""
    points, faces = shapes.torus(AROUND, ACROSS)
    faces = [face for face in faces if (points[face][:, list(axes)] > -1e-9).all()]
    used = np.unique(np.concatenate(faces))
    number = {vertex: i for i, vertex in enumerate(used)}
    points = np.where(np.abs(points[used]) < 1e-9, 0, points[used])
    mesh = mesh_of([*points, (9, 9, 9)], [[number[v] for v in face] for face in faces])
    on_plane = (np.abs(mesh.positions) < 1e-9) & np.isin(np.arange(3), axes)
    half = targets.Layout.of_mesh(mesh, axes, on_plane)
    cage = half.cage(mesh, mesh.positions, mesh.face_vertices, "smooth", True)
    base = targets.Base.of_cage(cage, half, False)
    flat, loose = int(np.flatnonzero(on_plane[:, 0])[0]), len(points)
    inner = int(np.flatnonzero(~on_plane[:-1].any(axis=1))[0])
    shift = np.array([0.3, 0.2, 0.1])
    held, places = base.held(Held(), np.array([inner, flat, loose]), np.tile(shift, (3, 1)))
    wanted = set()
    for vertex in (inner, flat):
        place = mesh.positions[vertex] + shift
        place[on_plane[vertex]] = 0
        for signs in np.ndindex(*([2] * len(axes))):
            image = place.copy()
            for axis, sign in zip(axes, signs):
                image[axis] *= 1 - 2 * sign
            wanted.add(tuple(np.round(image + 0.0, 12)))
    assert {tuple(place) for place in np.round(places + 0.0, 12)} == wanted and len(places) == len(wanted)
    starts = {tuple(np.round(np.abs(cage.positions[vertex]), 9)) for vertex in held.vertices}
    assert starts == {tuple(np.round(np.abs(mesh.positions[vertex]), 9)) for vertex in (inner, flat)}


def test_images_across_chosen_planes_move_along():
    """Also where the cage is beside its origin. Of two images the one that was moved farther decides."""
    plain, cage = torus()
    centre = np.array([5.0, -3.0, 2.0])
    cage = Cage(cage.positions + centre, cage.face_sizes, cage.face_vertices)
    base = targets.Base.of_cage(cage, plain, False)
    one = int(np.argmax(cage.positions @ (1, 0.5, 0.1)))
    mirrored = (cage.positions[one] - centre) * (-1, 1, 1) + centre
    other = int(np.argmin(np.linalg.norm(cage.positions - mirrored, axis=1)))
    flat = int(np.flatnonzero(np.abs(cage.positions[:, 0] - centre[0]) < 1e-9)[0])
    assert len({one, other, flat}) == 3
    shift = np.array([0.1, 0.2, 0.3])
    vertices, shifts = np.array([one, other, flat]), np.array([shift, 0.5 * shift, shift])
    for chosen in ([0, 2], [0, 1, 2]):
        held, places = base.held(Held(), vertices[chosen], shifts[chosen], [0])
        place = dict(zip(held.vertices.tolist(), places))
        assert sorted(place) == sorted([one, other, flat])
        assert np.abs(place[one] - cage.positions[one] - shift).max() < 1e-12
        assert np.abs(place[other] - cage.positions[other] - shift * (-1, 1, 1)).max() < 1e-12
        assert np.abs(place[flat] - cage.positions[flat] - shift * (0, 1, 1)).max() < 1e-12


def test_places_have_images_each_once():
    """In one plane, in both, at the image of another; one that is no place lies in the second."""
    points = np.array([[0.3, 0.2, 1], [1e-9, 0.5, 0], [0, -1e-9, 2], [-0.3, 0.2, 1], [np.nan, 0, 0]])
    normals = np.array([[1, 2, 3], [0, 1, 0], [0, 0, 1], [-1, 2, 3], [np.nan] * 3])
    places = Places(points, normals, tuple("abcde"), 0.5)
    once, twice = places.mirrored((0,), 1e-6), places.mirrored((0, 1), 1e-6)
    assert "".join(once.names) == "abcdee" and once.weight == twice.weight == 0.5
    assert np.isnan(once.points[5]).any() and once.points[1].tolist() == [0, 0.5, 0]
    assert "".join(twice.names) == "abcdeeabd"
    finite = [k for k in range(len(twice.names)) if np.isfinite(twice.points[k]).all()]
    for sign in ([-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        for k in finite:
            image = np.flatnonzero(np.abs(twice.points[finite] - twice.points[k] * sign).max(axis=1) < 1e-12)
            assert len(image) == 1 and (twice.normals[finite][image[0]] == twice.normals[k] * sign).all()


def test_handles_in_one_place_are_seen():
    places = np.random.default_rng(1).normal(size=(50, 3))
    places[7] = np.nan  # held where it is
    places[8] = np.nan
    assert not targets.any_in_one_place(places, 2.0)
    places[30] = places[2].astype(np.float32)
    assert targets.any_in_one_place(np.round(places, 3), 2.0)
    places[30, 1] += 1e-3
    assert not targets.any_in_one_place(places, 2.0) and not targets.any_in_one_place(np.empty((0, 3)), 2.0)

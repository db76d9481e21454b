# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points of limit surfaces against all points of a fine grid; points along lines against arithmetic."""

import numpy as np
import pytest
import shapes
from addon.binding import library
from addon.binding.library import CurvoptError
from addon.binding.values import Cage
from addon.core import balls, go_through, surface_points


def triangles():
    points, quads = shapes.quad_sphere(2)
    return points, [triangle for a, b, c, d in quads for triangle in ([a, b, c], [a, c, d])]


def prism():
    """Two hexagons and six quads."""
    angle = np.arange(6) * np.pi / 3
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], -1)
    sides = [[i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    return np.concatenate([ring - [0, 0, 0.5], ring + [0, 0, 0.5]]), [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *sides]


def cage_of(points, faces):
    sizes, corners = [len(face) for face in faces], [vertex for face in faces for vertex in face]
    return Cage(np.asarray(points, float), np.array(sizes, np.int32), np.array(corners, np.int32))


SHAPES = {"sphere": lambda: shapes.quad_sphere(3), "torus": shapes.torus, "cube": shapes.cube, "triangles": triangles,
          "prism": prism, "open": lambda: shapes.grid(5)}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
def test_no_point_of_a_fine_grid_is_nearer(name):
    """Places on the surface, near it and two sizes away; those on it have the point itself."""
    cage, random = cage_of(*SHAPES[name]()), np.random.default_rng(3)
    size = np.ptp(cage.positions, axis=0).max()
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        fine = surface_points.grids(mesh.faces()[0], 20).jets(mesh, cage.positions)[:, 0]
        for off in (0.0, 0.05, 0.5, 2.0):
            places = fine[random.integers(len(fine), size=60)] + off * size * random.normal(size=(60, 3))
            face, corner, uv = go_through.nearest(mesh, cage.positions, places)
            options = mesh.lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
            with library.Sampler.create(mesh, cage.positions, options) as sampler:
                found = np.linalg.norm(sampler.jets(face, corner, uv)[:, 0] - places, axis=1)
            least = np.array([np.linalg.norm(fine - place, axis=1).min() for place in places])
            assert (found <= least + 1e-5 * size).all(), (off, (found - least).max() / size)


def test_a_ball_is_touched_where_an_ellipsoid_has_that_curvature():
    """Against second differences of the ellipsoid itself, sheared and turned, and the ball's 1 / radius."""
    round_ball = balls.touch(np.array([1.0, 2, 3]), 0.25 * np.eye(3)[:, [1, 2, 0]])
    assert round_ball.tip == pytest.approx([1.25, 2, 3]) and round_ball.normal == pytest.approx([1, 0, 0])
    assert round_ball.curvatures == pytest.approx([4, 4])
    random = np.random.default_rng(5)
    for _ in range(20):
        middle, axes = random.normal(size=3), random.normal(size=(3, 3))
        if abs(np.linalg.det(axes)) < 0.2:
            continue
        found, step = balls.touch(middle, axes), 1e-4
        inverse = np.linalg.inv(axes)

        def height(along, across):
            """How far above the tangent plane the ellipsoid is, beside its tip."""
            at = found.tip + along * found.direction + across * np.cross(found.normal, found.direction)
            p, q = inverse @ (at - middle), inverse @ found.normal
            roots = np.roots([q @ q, 2 * p @ q, p @ p - 1])
            return roots[np.abs(roots).argmin()].real

        bends = [-(height(step, 0) + height(-step, 0)) / step**2, -(height(0, step) + height(0, -step)) / step**2]
        twist = (height(step, step) - height(step, -step) - height(-step, step) + height(-step, -step)) / (4 * step**2)
        assert found.curvatures == pytest.approx(bends, rel=1e-4) and abs(twist) < 1e-4 * max(bends)
        assert np.linalg.norm(inverse @ (found.tip - middle)) == pytest.approx(1) and found.normal @ (found.tip - middle) > 0
    for bad in (np.zeros((3, 3)), np.diag([1.0, 0, 1]), np.diag([1.0, 1, 0]), np.full((3, 3), np.nan)):
        with pytest.raises(ValueError, match="is flat"):
            balls.touch(np.zeros(3), bad)


def test_a_ball_outside_is_in_a_hollow():
    """The sign is that of the original's normal; a vertex of three faces has no curvatures, so the face beside it has."""
    points, faces = shapes.quad_sphere(2)
    cage = cage_of(points, faces)
    valence = np.bincount(cage.face_vertices)
    pole, regular = int(np.flatnonzero(valence == 3)[0]), int(np.flatnonzero(valence == 4)[0])
    for vertex, snaps in ((pole, False), (regular, True)):
        for out in (1.0, -1.0):
            tip = 0.8 * np.asarray(points[vertex])
            axis = out * tip / np.linalg.norm(tip)
            ball = balls.Touch(tip, axis, np.array([2.0, 2.0]), np.cross(axis, [0.3, 0.5, 0.7]))
            (entry,) = go_through.Places(tip[None], axis[None], ("a ball",), balls={0: ball}).entries(cage)
            assert (entry.vertex == vertex) == snaps and (entry.vertex is None) != snaps
            assert entry.curvatures == pytest.approx([2 * out, 2 * out]) and entry.curvature_direction is ball.direction


def test_entries_of_a_face_that_is_no_quad():
    """A place over a corner is of the vertex, one over the middle of an edge of the edge, one over the middle beside it."""
    points, faces = prism()
    cage = cage_of(points, faces)
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        samples = surface_points.grids(mesh.faces()[0], 1)
        at = samples.jets(mesh, cage.positions)[:, 0].reshape(-1, 4, 3)[6]  # the first quarter of the upper hexagon
    entries = go_through.Places(at, np.full((4, 3), np.nan), ("a", "b", "c", "d")).entries(cage)
    assert entries[0].vertex == 6
    ways = {(entry.corner, *np.round(entry.uv)) for entry in entries[1:3]}  # an edge's middle is in the patches of two corners
    assert len(ways) == 2 and ways <= {(0, 0.0, 1.0), (5, 1.0, 0.0), (0, 1.0, 0.0), (1, 0.0, 1.0)}
    assert all(np.abs(np.array(entry.uv) - np.round(entry.uv)).max() < 1e-4 for entry in entries[1:3])
    assert entries[3].face == 1 and entries[3].uv == pytest.approx((0.9, 0.9))


def test_refusals_have_the_names_of_places():
    cage = cage_of(*prism())
    places = go_through.Places(cage.positions[[2, 7]] * 1.1, np.zeros((2, 3)), ("empty 'A'", "empty 'B'"))
    told = str(places.named(CurvoptError(1, 0, "entry 1: its point cannot be beside entry 0"), cage))
    assert told == "empty 'B': its point cannot be beside empty 'A'"
    text = "the limit points of 9 vertices that touch each other, vertex 7 among them, do not move"
    assert str(places.named(CurvoptError(1, 7, text), cage)) == "9 places near each other, empty 'B' among them, do not move"
    assert str(places.named(CurvoptError(1, 2, text), cage)) == "9 places near each other, empty 'A' among them, do not move"
    assert str(places.named(CurvoptError(1, -1, text), cage)) == text
    assert str(go_through.Places().named(CurvoptError(1, 7, text), cage)) == text  # of pins


def test_points_along_lines():
    """Open and closed ones, far from the origin, in one place, of no numbers, and of a great length."""
    line = np.array([[0, 0, 0], [1.0, 0, 0], [1, 3, 0]])
    assert go_through.evenly(line, 1.0, 100) == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 2, 0], [1, 3, 0]]))
    square = np.array([[0, 0, 0], [1.0, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]])
    assert go_through.evenly(square, 1.0, 100) == pytest.approx(square[:4])
    assert len(go_through.evenly(square, 10.0, 100)) == 3
    short = np.array([[1000, 1000, 0], [1000.005, 1000, 0]])
    assert go_through.evenly(short, 0.005, 100) == pytest.approx(short, abs=1e-12)
    assert go_through.evenly(line[[1, 1, 1]], 1.0, 100) == pytest.approx(line[[1]])
    assert np.isnan(go_through.evenly(np.where(line == 3, np.nan, line), 1.0, 100)).all()
    assert len(go_through.evenly(line * 1e30, 1.0, 100)) == 101
    two = go_through.polylines(np.arange(15.0).reshape(5, 3), np.array([[0, 1], [1, 0], [2, 3], [3, 4]]))
    assert [found[:, 0].tolist() for found in two] == [[0, 3, 0], [6, 9, 12]]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading a surface on the object itself: energy densities, combs, probe, continuity, the worker; against closed forms,
differences and the library's own integrals."""

import time

import numpy as np
import pytest
import shapes
from addon.binding import library
from addon.binding.values import Cage, Creases
from addon.core import combs, density, inspected, inspector, probe, sections, surface_points
from addon.core.edges import EdgeTable
from test_surface import jets_of, torus_point


def cage_of(points, faces, creases=None):
    sizes, vertices = shapes.packed(faces)
    return Cage(np.asarray(points, float), np.array(sizes, np.int32), np.array(vertices, np.int32), creases or Creases())


def round_torus(around=64, across=48, major=2.0, minor=0.7):
    """A cage whose limit surface goes through the torus at all limit points of vertices: in each direction the limit point
    of a circle's vertices is (2 + cos step) / 3 times as far out."""
    u, v = (2 * np.pi * np.arange(n) / n for n in (around, across))
    su, sv = (3 / (2 + np.cos(2 * np.pi / n)) for n in (around, across))
    ring = (major + minor * sv * np.cos(v)) * su
    points = np.stack([np.outer(np.cos(u), ring), np.outer(np.sin(u), ring), np.tile(minor * sv * np.sin(v), (around, 1))], -1)
    return cage_of(points.reshape(-1, 3), shapes.torus(around, across)[1])


def sphere_point(radius):
    return lambda u, v: radius * np.array([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])


def taken(cage, wanted=3000, **more):
    with inspected.Sampling(library.load()) as sampling:
        return sampling.take(inspected.Subject(cage, **more), wanted)


def probe_of(cage, **more):
    return probe.Probe(library.load(), taken(cage, **more))


def test_densities_of_a_torus():
    """Of a torus of revolution only k2 changes, along the meridian: C has that change three times, as C_122."""
    v = np.array([0.4, 2.0])
    found = density.densities(jets_of(torus_point, at=[(0.3, v[0]), (1.1, v[1])]), area=5.0, radius=2.0)
    ring = 2.0 + 0.7 * np.cos(v)
    change = (-np.sin(v) / ring + np.cos(v) * 0.7 * np.sin(v) / ring**2) / 0.7
    k1, k2 = 1 / 0.7, np.cos(v) / ring
    for name, value in (
        ("willmore", k1**2 + k2**2), ("mean_curvature", (k1 + k2) ** 2 / 4), ("mvs", 0 * v), ("mvs_cross", 5 * change**2),
        ("variation", 15 * change**2), ("mehlum_tarrou", 5 * 9 / 8 * change**2), ("area", np.full(2, 0.25)),
    ):  # fmt: skip
        assert found[name] == pytest.approx(value, abs=1e-3), name


def test_densities_integrate_to_the_librarys_energies():
    """By Gauss' rule on each patch of a cage without poles, whose limit surface carries all energies."""
    points, faces = shapes.torus()
    points = points + 0.1 * np.random.default_rng(5).normal(size=points.shape)
    cage, lib = cage_of(points, faces), library.load()
    nodes, weights = np.polynomial.legendre.leggauss(10)
    u, v = (a.ravel() for a in np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2, indexing="ij"))
    face = np.repeat(np.arange(len(faces)), 100)
    with library.Mesh.of_cage(lib, cage) as mesh:
        jets = mesh.jets(points, face, 0 * face, np.tile(np.stack([u, v], -1), (len(faces), 1)))
        options = lib.options({"mvs": 1.0}, surface=library.SURFACES.index("limit"), tolerance=1e-7)
        with library.Problem.create(mesh, options, points) as problem:
            truth = problem.evaluate(points)[0]
    element = np.tile(np.outer(weights, weights).ravel() / 4, len(faces)) * np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1)
    radius = np.sqrt(((points - points.mean(0)) ** 2).sum(1).mean())
    found = density.densities(jets, truth.area, radius)
    for name, value in truth.terms.items():
        assert (found[name] * element).sum() == pytest.approx(value, rel=1e-5), name


@pytest.mark.parametrize("name", ["torus", "prism", "cube"])
def test_both_sides_of_an_edge_are_the_same_curve(name):
    points, faces = {"torus": shapes.torus(), "prism": shapes.prism(), "cube": shapes.cube()}[name]
    cage = cage_of(points, faces)
    table = EdgeTable.of_faces(cage.face_sizes, cage.face_vertices)
    assert len(table.edges) == len({frozenset(pair) for face in faces for pair in zip(face, face[1:] + face[:1])})
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        for edge in range(len(table.edges)):
            one, two = table.of_edge(edge)
            assert table.ends[one].tolist() == table.ends[two].tolist()[::-1]
            t = np.array([0.0, 0.2, 0.5, 0.7, 1.0])
            here, there = table.places([one] * 5, t), table.places([two] * 5, 1 - t)
            curve, other = (mesh.jets(cage.positions, p.face, p.corner, p.uv)[:, 0] for p in (here, there))
            assert curve == pytest.approx(other, abs=1e-12)
            corners = mesh.jets(cage.positions, here.face, here.corner, here.uv + 1e-3 * here.inwards)[:, 0]
            assert (np.linalg.norm(corners - curve, axis=1) > 1e-6).all()  # still on the face: parameters stay in 0 .. 1


def test_the_derivative_along_a_side_is_that_of_its_curve():
    cage = cage_of(*shapes.prism())
    table = EdgeTable.of_faces(cage.face_sizes, cage.face_vertices)
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        for side in range(len(table.ends)):
            for t in (0.3, 0.8):
                p = table.places([side] * 3, [t - 1e-5, t, t + 1e-5])
                jets = mesh.jets(cage.positions, p.face, p.corner, p.uv)
                slope = p.along[1, 0] * jets[1, 1] + p.along[1, 1] * jets[1, 2]
                assert slope == pytest.approx((jets[2, 0] - jets[0, 0]) / 2e-5, abs=1e-7)


def test_loops_go_straight_on_and_along_boundaries():
    cage = cage_of(*shapes.torus(8, 4))
    table = EdgeTable.of_faces(cage.face_sizes, cage.face_vertices)
    ring = table.loops(table.chosen([[0, 1]]))  # vertices of the first cross section
    assert sorted(map(tuple, table.edges[ring].tolist())) == [(0, 1), (0, 3), (1, 2), (2, 3)]
    assert len(table.loops(table.chosen([[0, 4]]))) == 8 and len(table.loops(table.chosen([[0, 1], [0, 4]]))) == 12
    sheet = cage_of(*shapes.grid(3))
    table = EdgeTable.of_faces(sheet.face_sizes, sheet.face_vertices)
    assert len(table.loops(table.chosen([[0, 1]]))) == 12  # all of the boundary
    assert sorted(map(tuple, table.edges[table.loops(table.chosen([[5, 9]]))].tolist())) == [(1, 5), (5, 9), (9, 13)]
    assert len(table.chosen([[0, 99], [3, 1], [-1, 0]])) == 0


def test_curvature_vectors_are_those_of_circles():
    """Of meridians and circles of latitude: a sphere's great and small circles."""
    at = [(0.3, 0.5), (1.0, -0.6)]
    jets = jets_of(sphere_point(2.0), at=at)
    great, small = (combs.curvature_vectors(jets, np.tile(way, (2, 1))) for way in ([0.0, 3.0], [-0.5, 0.0]))
    assert great == pytest.approx(-jets[:, 0] / 4, abs=1e-6)  # towards the centre, 1 / 2 long
    axis = jets[:, 0] * (1, 1, 0)
    assert small == pytest.approx(-axis / (axis**2).sum(1)[:, None], abs=1e-6)
    twisted = jets_of(lambda u, v: np.array([np.cos(u + v * v), np.sin(u + v * v), u * v]), at=[(0.2, 0.0)])
    found = combs.curvature_vectors(twisted, np.array([[1.0, 1.0]]))  # of the curve s -> (s, s) - (0, 0.2)
    s = np.linspace(-2e-3, 2e-3, 5)
    curve = np.stack([np.cos(0.2 + s + s * s), np.sin(0.2 + s + s * s), (0.2 + s) * s], -1)
    first, second = (curve[3] - curve[1]) / 2e-3, (curve[3] - 2 * curve[2] + curve[1]) / 1e-6
    across = second - first * (first @ second) / (first @ first)
    assert found[0] == pytest.approx(across / (first @ first), abs=1e-4)


def test_combs_stand_on_the_edges_and_show_the_curvature_of_their_curves():
    """Against differences of the curve alone, at poles, too."""
    cage = cage_of(*shapes.prism())
    choice = combs.OnEdges(np.array([[0, 1], [1, 4], [2, 9]]), loops=False, teeth=6, length=0.5)
    found = taken(cage, choice=choice).combs
    all_feet, all_tips = found.feet.reshape(2, 7, 3), found.tips.reshape(2, 7, 3)
    table, h = EdgeTable.of_faces(cage.face_sizes, cage.face_vertices), 1e-4
    t = np.linspace(0, 1, 7)[1:-1]
    radius = np.sqrt(((cage.positions - cage.positions.mean(0)) ** 2).sum(1).mean())
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        for edge, feet, tips in zip(table.chosen(choice.pairs), all_feet, all_tips):
            places = [table.places(np.full(5, table.first[edge]), t + shift) for shift in (-h, 0, h)]
            before, now, after = (mesh.jets(cage.positions, p.face, p.corner, p.uv)[:, 0] for p in places)
            assert feet[1:-1] == pytest.approx(now, abs=1e-12)
            first, second = (after - before) / (2 * h), (after - 2 * now + before) / h**2
            bend = np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3
            teeth = tips[1:-1] - feet[1:-1]
            curved = np.abs(t - 0.5) > 1e-9  # at the middle of a polygon's edge the parametrization turns its quarters
            assert np.linalg.norm(teeth, axis=1)[curved] == pytest.approx(0.5 * radius**2 * bend[curved], rel=1e-4)
            assert (np.einsum("ij,ij->i", teeth, second)[curved] < 0).all()  # away from where it bends to
            assert np.einsum("ij,ij->i", teeth, first)[curved] == pytest.approx(0 * t[curved], abs=1e-6)
    assert np.isfinite(found.tips).all()
    torus = cage_of(*shapes.torus())
    loop = combs.OnEdges(np.array([[0, 1]]), loops=True, teeth=2, length=0.5)
    assert taken(torus, choice=loop).combs.feet.shape == (4 * 3, 3)
    assert taken(torus, choice=combs.OnEdges(None, False, 1, 0.5)).combs.feet.shape == (64 * 2, 3)
    nothing = combs.OnEdges(np.empty((0, 2), np.int32), loops=True, teeth=3, length=0.5)
    assert taken(torus, choice=nothing).combs.feet.shape == (0, 3)
    points, pairs = found.lines()
    assert points.shape == (28, 3) and {name: len(part) for name, part in pairs.items()} == {"curves": 12, "teeth": 14, "crests": 12}
    ends = {name: points[part] for name, part in pairs.items()}
    assert ends["teeth"].reshape(2, 7, 2, 3) == pytest.approx(np.stack([all_feet, all_tips], 2), abs=1e-6)
    for name, part in (("curves", all_feet), ("crests", all_tips)):
        assert ends[name].reshape(2, 6, 2, 3) == pytest.approx(np.stack([part[:, :-1], part[:, 1:]], 2), abs=1e-6)


def test_sections_of_a_torus_are_circles_with_their_curvature():
    """Across the axis two circles at each height, and along it, through the axis, two meridians: exactly in the planes."""
    torus = round_torus()
    found = taken(torus, wanted=13_000, choice=combs.OnSections((0.0, 0.0, 1.0), count=4, teeth=1, length=0.5)).combs
    heights = 0.7 * np.array([-0.75, -0.25, 0.25, 0.75])
    off = np.abs(found.feet[:, 2, None] - heights)
    assert off.min(axis=1) == pytest.approx(0, abs=1e-5)  # of the torus' extent, by points of the net
    assert all(np.ptp(found.feet[off.argmin(axis=1) == k, 2]) < 1e-12 for k in range(4))
    ring, pipe = np.hypot(*found.feet[:, :2].T), np.sqrt(0.49 - found.feet[:, 2] ** 2)
    assert np.abs(ring - 2.0) == pytest.approx(pipe, abs=2e-4)
    radius = np.sqrt(((torus.positions - torus.positions.mean(0)) ** 2).sum(1).mean())
    teeth = found.tips - found.feet
    outwards = np.concatenate([found.feet[:, :2] / ring[:, None], 0 * ring[:, None]], axis=1)
    assert teeth == pytest.approx(0.5 * radius**2 / ring[:, None] * outwards, abs=4e-3 * radius)
    assert set(np.bincount(found.links.ravel(), minlength=len(found.feet))) == {2}  # closed
    table = EdgeTable.of_faces(torus.face_sizes, torus.face_vertices)
    mean_edge = np.linalg.norm(np.diff(torus.positions[table.edges], axis=1), axis=2).mean()
    for circle in (2.0 + 0.7 * np.sqrt(1 - 0.75**2), 2.0 - 0.7 * np.sqrt(1 - 0.25**2)):  # two of each
        assert (np.abs(ring[found.teeth] - circle) < 1e-3).sum() == pytest.approx(2 * 2 * np.pi * circle / mean_edge, abs=2)
    across = taken(torus, wanted=13_000, choice=combs.OnSections((0.0, 1.0, 0.0), count=1, teeth=2, length=0.5)).combs
    pipe = np.hypot(np.abs(across.feet[:, 0]) - 2.0, across.feet[:, 2])
    assert pipe == pytest.approx(0.7, abs=2e-4) and np.abs(across.feet[:, 1]).max() < 1e-5
    assert np.linalg.norm(across.tips - across.feet, axis=1) == pytest.approx(0.5 * radius**2 / 0.7, rel=5e-3)


def test_sections_show_the_curvature_of_their_curves():
    """Of a surface with poles, against circles through three points of the section alone."""
    cage = cage_of(*shapes.prism())
    normal = np.array([0.48, 0.6, 0.64])
    found = taken(cage, wanted=40_000, choice=combs.OnSections(tuple(normal), count=3, teeth=5, length=1.0)).combs
    heights, radius = found.feet @ normal, np.sqrt(((cage.positions - cage.positions.mean(0)) ** 2).sum(1).mean())
    assert len(np.unique(np.round(heights, 11))) == 3
    around = [[] for _ in found.feet]
    for one, other in found.links.tolist():
        around[one].append(other)
        around[other].append(one)
    ends = np.array(around)
    a, b = found.feet[ends[:, 0]] - found.feet, found.feet[ends[:, 1]] - found.feet
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, a - b))
    good = np.minimum(la, lb) > 0.3 * np.maximum(la, lb)
    bend = 2 * np.linalg.norm(np.cross(a, b), axis=1) / (la * lb * lc)
    shown = np.linalg.norm(found.tips - found.feet, axis=1) / radius**2
    off = np.abs(shown - bend)[good] * radius
    assert good.mean() > 0.5 and np.median(off) < 0.03 and np.quantile(off, 0.95) < 0.2  # curvature is 2 to 6; chords are long
    assert (np.einsum("ij,ij->i", found.tips - found.feet, normal[None] + 0 * a) ** 2).max() < 1e-16  # in the plane
    inwards = np.einsum("ij,ij->i", found.tips - found.feet, a / la[:, None] ** 2 + b / lb[:, None] ** 2)[good & (bend * radius > 0.1)]
    assert (inwards < 0).all()


def test_sections_meet_saddles_poles_and_planes():
    saddle = np.array([[True, False, True, False]])
    assert {frozenset(pair) for pair in sections.pieces(saddle, np.array([True])).tolist()} == {frozenset((0, 1)), frozenset((2, 3))}
    assert {frozenset(pair) for pair in sections.pieces(saddle, np.array([False])).tolist()} == {frozenset((0, 3)), frozenset((1, 2))}
    assert sections.pieces(np.array([[True, True, False, False]]), np.array([True])).tolist() == [[1, 3]]
    points, faces = shapes.grid(3)
    flat = cage_of(np.asarray(points) * (1, 1, 0), faces)
    choice = combs.OnSections((0.0, 0.0, 1.0), count=2, teeth=3, length=0.5)
    points, pairs = taken(flat, choice=choice).combs.lines()
    assert points.shape == (0, 3) and all(len(part) == 0 for part in pairs.values())  # the plane itself is no curve
    found = taken(flat, choice=combs.OnSections((1.0, 0.0, 0.0), count=2, teeth=3, length=0.5)).combs
    assert found.tips == pytest.approx(found.feet, abs=1e-9) and len(found.teeth)
    cube = taken(cage_of(*shapes.cube()), choice=combs.OnSections((1.0, 0.0, 0.0), count=1, teeth=3, length=0.5)).combs
    assert np.isfinite(cube.tips).all() and cube.feet[:, 0] == pytest.approx(0, abs=1e-12)


def test_sections_of_a_collapsed_tube_are_drawn():
    """Where the surface has no tangent plane there is no tooth, and the rest is there."""
    rings, faces = (1, 1, 1, 0, 0, 0, 0, 1, 1), []
    points = [(k, r * np.cos(a), r * np.sin(a)) for k, r in enumerate(rings) for a in np.arange(6) * np.pi / 3]
    for k in range(len(rings) - 1):
        faces += [[6 * k + i, 6 * k + (i + 1) % 6, 6 * k + 6 + (i + 1) % 6, 6 * k + 6 + i] for i in range(6)]
    found = taken(cage_of(points, faces), choice=combs.OnSections((1.0, 0.0, 0.0), count=9, teeth=3, length=0.5)).combs
    lines, pairs = found.lines()
    assert np.isfinite(lines).all() and len(pairs["teeth"]) and len(found.feet)


PERSPECTIVE = np.array([[1.5, 0, 0, 0], [0, 1.5, 0, 0], [0, 0, -1.02, -0.202], [0, 0, -1, 0]])  # the eye at 0, along -z


def test_pick_finds_the_nearest_quad_and_where_in_it():
    far = np.array([[-1, -1, -6], [1, -1, -6], [1, 1, -4], [-1, 1, -4]], float)  # tilted
    points = np.concatenate([far, far + (0, 0, -3), far + (0, 0, 8)])  # behind it; behind the eye
    quads = np.array([[0, 1, 2, 3], [7, 4, 5, 6], [8, 9, 10, 11]])
    at = np.array([0.1, 0.05])
    quad, weights = probe.pick(points, quads, PERSPECTIVE, at)
    assert quad == 0 and weights.sum() == pytest.approx(1)
    # The ray (x, y, -1) s with x, y = at / 1.5 meets the plane z = -5 + y.
    s = 5 / (1 + at[1] / 1.5)
    assert weights @ far == pytest.approx([s * at[0] / 1.5, s * at[1] / 1.5, -s], abs=1e-9)
    assert probe.pick(points, quads, PERSPECTIVE, np.array([0.9, 0.9])) is None
    assert probe.pick(points, quads[::-1], PERSPECTIVE, at)[0] == 2
    assert probe.pick(-far, quads[:1], PERSPECTIVE, at) is None  # behind the eye, where it would be seen there


@pytest.mark.parametrize("at", [(0.03, 0.06), (-0.11, -0.12)])
def test_the_probe_reads_radii_normal_and_energy_of_a_torus(at):
    """Seen from the side, through a perspective; the ray meets the torus itself, and not the coarse picture of it."""
    look = np.eye(4)
    look[:3, :3] = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]  # the eye on the x axis, z upwards
    look[2, 3] = -8.0
    matrix = PERSPECTIVE @ look
    with probe_of(round_torus(), wanted=3000) as found:
        reading = found.read(matrix, np.array(at), "willmore")
        assert found.read(matrix, np.array([0.9, 0.9]), "willmore") is None
    x, y, z = reading.point
    seen = matrix @ (x, y, z, 1.0)
    assert seen[:2] / seen[3] == pytest.approx(at, abs=1e-10)
    ring = np.hypot(x, y)
    assert x > 0 and np.hypot(ring - 2, z) == pytest.approx(0.7, abs=1e-4)
    v = np.arctan2(z, ring - 2)
    assert reading.normal == pytest.approx([np.cos(v) * x / ring, np.cos(v) * y / ring, np.sin(v)], abs=1e-3)
    assert 1 / reading.k1 == pytest.approx(0.7, rel=4e-3) and 1 / reading.k2 == pytest.approx(ring / np.cos(v), rel=4e-3)
    assert reading.density == pytest.approx(reading.k1**2 + reading.k2**2, rel=1e-9)
    assert reading.edge.n_faces == 2 and max(reading.edge.gap, reading.edge.angle) < 1e-6 and reading.edge.jump < 1e-3
    assert np.linalg.norm(reading.edge.point - reading.point) < 2 * np.pi * 2.7 / 64
    lines = probe.words(reading, reading.normal, 2.0)
    assert lines[0].startswith("Radii of curvature: 0.69") or lines[0].startswith("Radii of curvature: 0.70")
    assert lines[2].startswith("Willmore per area: ") and lines[3] == "Edge: G0 0, G1 0°, G2 0 %"


def test_continuity_of_spheres_that_touch_and_of_planes_at_an_angle():
    small, large = jets_of(lambda u, v: sphere_point(1.0)(u, v) - (1, 0, 0), [(0, 0)])[0], jets_of(lambda u, v: sphere_point(2.0)(u, v) - (2, 0, 0), [(0, 0)])[0]
    ways = np.array([[0.0, 1.0], [0.0, -1.0]])
    assert probe.continuity(small, large, ways, False, 1.0) == pytest.approx((0, 0, 50), abs=1e-3)
    shifted = large + np.eye(10)[0][:, None] * (0.3, 0, 0.4)
    assert probe.continuity(small, shifted, ways, False, 1.0) == pytest.approx((0.5, 0, 50), abs=1e-3)

    def plane(slope):
        return jets_of(lambda u, v: np.array([u, v, slope * u]), [(0, 0)])[0]

    gap, angle, jump = probe.continuity(plane(0.0), plane(np.tan(np.radians(7.0))), ways, False, 1.0)
    assert (gap, angle, jump) == pytest.approx((0, 7, 0), abs=1e-6)

    def saddle(bend):
        return jets_of(lambda u, v: np.array([u, v, -bend / 2 * u * u]), [(0, 0)])[0]

    assert probe.continuity(saddle(0.0), saddle(3.0), ways, False, 1.0)[2] == pytest.approx(100, abs=1e-4)
    assert probe.continuity(saddle(2.0), saddle(-2.0), ways, False, 1.0)[2] == pytest.approx(200, abs=1e-4)
    # The other face with its corners the other way round: the same shape, the normal turned.
    turned = jets_of(lambda u, v: np.array([-u, v, -1.0 * u * u]), [(0, 0)])[0]
    assert probe.continuity(saddle(2.0), turned, np.array([[0.0, 1.0], [0.0, 1.0]]), True, 1.0) == pytest.approx((0, 0, 0), abs=1e-4)


def test_continuity_of_a_box_with_one_sharp_edge_and_of_its_boundary():
    """Between two faces of a box, all of whose edges are sharp, are 90 degrees; an open one has boundaries."""
    points, faces = shapes.cube()
    edges = np.array(sorted({tuple(sorted(pair)) for face in faces for pair in zip(face, face[1:] + face[:1])}))
    sharp = Creases(edges, np.full(len(edges), 10.0), np.arange(8, dtype=np.int32), np.full(8, 10.0))
    with probe_of(cage_of(points, faces, sharp)) as found:
        edge = found.at(0, 0, np.array([0.1, 0.6]), "willmore").edge
    assert edge.n_faces == 2 and edge.angle == pytest.approx(90) and edge.gap == pytest.approx(0, abs=1e-12) and edge.jump == 0
    with probe_of(cage_of(points, faces)) as found:
        edge = found.at(0, 0, np.array([0.1, 0.6]), "willmore").edge
        pole = found.at(0, 0, np.array([0.0, 0.0]), "willmore")
    assert edge.angle == pytest.approx(0, abs=1e-5) and edge.jump == pytest.approx(0, abs=1e-3)
    assert np.isfinite(pole.normal).all() and np.isfinite(pole.edge.jump)
    with probe_of(cage_of(points, faces[:-1])) as found:
        boundary = set(faces[-1])
        face = next(i for i, face in enumerate(faces[:-1]) if len(boundary & set(face)) == 2)
        ends = [k for k in range(4) if {faces[face][k], faces[face][(k + 1) % 4]} <= boundary]
        uv = {0: (0.5, 0.05), 1: (0.95, 0.5), 2: (0.5, 0.95), 3: (0.05, 0.5)}[ends[0]]
        reading = found.at(face, 0, np.array(uv), "willmore")
    assert reading.edge.n_faces == 1 and probe.words(reading, reading.normal, 1.0)[-1] == "Edge: a boundary"


def test_words_say_flat_and_which_edge_has_many_faces():
    edge = probe.Continuity(np.zeros(3), 3)
    reading = probe.Reading(np.zeros(3), np.array([0.0, 0, 1]), 0.5, 0.0, "mvs", 1.25, edge)
    lines = probe.words(reading, np.array([-0.0001, 0.6, 0.8]), 1.0)
    assert lines == ["Radii of curvature: 2 and flat", "Normal: 0.000, 0.600, 0.800", "MVS per area: 1.25", "Edge: 3 faces"]


@pytest.mark.parametrize("name", ["torus", "prism"])
def test_a_picture_has_points_and_normals_of_the_limit_surface(name):
    points, faces = {"torus": shapes.torus(), "prism": shapes.prism()}[name]
    found = taken(cage_of(points, faces), wanted=500)
    net = found.net
    assert len(net.face) <= 500 < 4 * len(net.face) and found.tints is None
    rows, middle = np.arange(len(net.face)), net.uv.mean(axis=1)
    with mesh_of(points, faces) as mesh:
        for corner in range(4):
            jets = mesh.jets(points, net.face, net.corner, net.uv[:, corner] + 1e-9 * (middle - net.uv[:, corner]))
            index = net.points.quads[rows, corner]
            assert found.points[index] == pytest.approx(jets[:, 0], abs=1e-6)
            cross = np.cross(jets[:, 1], jets[:, 2])
            apart = np.linalg.norm(found.normals[index] - cross / np.linalg.norm(cross, axis=1)[:, None], axis=1)
            assert np.median(apart) < 1e-6 and apart.max() < 0.05  # poles: a thousandth of a quad beside
    assert shapes.enclosed_volume(found.points.astype(float), net.points.quads.tolist()) > 0


def mesh_of(points, faces):
    return library.Mesh.create(library.load(), len(points), *shapes.packed(faces))


def test_the_area_is_that_of_the_torus():
    assert taken(round_torus(), wanted=30_000).area == pytest.approx(4 * np.pi**2 * 2.0 * 0.7, rel=2e-3)


def test_colours_of_curvature_and_of_the_distance_to_another_place():
    cage = cage_of(*shapes.torus())
    seen = taken(cage, quantity="H")
    assert seen.span[1] == -seen.span[0] > 0 and seen.tints.shape == (len(seen.points), 4)
    points, faces = shapes.grid(4)
    points[:, 2] = 0.0
    raised = cage_of(points + (0, 0, 0.25), faces)
    seen = taken(raised, quantity="distance", original=points, wanted=300)
    assert seen.span == pytest.approx((0, 0.25)) and np.ptp(seen.tints, axis=0).max() < 1e-3
    assert len(seen.net.face) == 256 and seen.points[:, 2] == pytest.approx(np.full(len(seen.points), 0.25))


def test_sides_fit_the_budget():
    assert [inspected.side_for(n, 12_000) for n in (1, 48, 5_000, 20_000)] == [32, 15, 1, 1]


def wait_for(condition):
    for _ in range(12_000):
        if condition():
            return
        time.sleep(0.005)
    raise AssertionError("it never came true")


def test_the_worker_gives_a_coarse_picture_first_and_a_fine_one_when_nothing_else_comes():
    """Of the newest subject; a subject without a surface leaves a refusal, and the next one is drawn again."""
    cage, seen = cage_of(*shapes.torus()), []
    worker = inspector.Inspector()
    try:
        first, second = (inspected.Subject(cage, number=n) for n in (1, 2))
        worker.look(first)
        wait_for(lambda: worker.is_settled)
        assert worker.latest.subject is first and worker.latest.is_fine
        worker.look(second)
        wait_for(lambda: seen.append(worker.latest) or worker.is_settled)
        passing = [picture for picture in seen if picture.subject is second and not picture.is_fine]
        assert passing and len(passing[0].points) < len(worker.latest.points)
        worker.look(inspected.Subject(cage_of(cage.positions * np.nan, shapes.torus()[1])))
        wait_for(lambda: worker.error is not None)
        assert worker.latest is None and "finite" in str(worker.error)
        worker.look(first)
        assert worker.error is None
        wait_for(lambda: worker.latest is not None and worker.latest.subject is first)
    finally:
        assert worker.close(60)


def test_what_is_refused_is_not_tried_again():
    class Failing(inspected.Sampling):
        tries = 0

        def take(self, *_):
            self.tries += 1
            raise ValueError("No surface")

    failing = Failing(library.load())
    worker = inspector.Inspector(lambda: failing)
    worker.look(inspected.Subject(cage_of(*shapes.torus())))
    wait_for(lambda: worker.error is not None)
    time.sleep(0.2)
    assert worker.close(60) and failing.tries == 1


def test_cages_that_are_too_large_are_refused(monkeypatch):
    monkeypatch.setattr(inspected, "MOST_FACES", 31)
    with pytest.raises(inspected.UserError, match="32 faces. Inspect draws 31 at most"):
        taken(cage_of(*shapes.torus()))


def test_a_sampling_follows_to_other_faces_and_creases():
    with inspected.Sampling(library.load()) as sampling:
        torus, cube = cage_of(*shapes.torus()), cage_of(*shapes.cube())
        assert len({len(sampling.take(inspected.Subject(cage), 100).net.face) for cage in (torus, cube)}) == 2
        round_one = sampling.take(inspected.Subject(cube), 100).area
        sharp = cage_of(*shapes.cube(), Creases(vertices=np.array([0], np.int32), vertex_sharpness=np.array([10.0])))
        assert sampling.take(inspected.Subject(sharp), 100).area > round_one
        assert not inspected.is_alike(cube, sharp) and inspected.is_alike(cube, cage_of(*shapes.cube()))
    assert surface_points.unit(np.zeros((1, 3))).tolist() == [[0, 0, 0]]

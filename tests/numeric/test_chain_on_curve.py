# SPDX-License-Identifier: GPL-3.0-or-later
"""Chains of edges whose limit curves follow curves (libcurvopt/notes/122-a-chain-of-edges-on-a-curve.md): how fast they come to
them, by OpenSubdiv; where vertices are held, by SciPy's splines; what is refused."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import lib
import nets
import test_through as points
from ccref import Mesh, mesh_from_faces
from nets import torus_cage
from osd import osd_jets

NONE = 1  # CURVOPT_SYMMETRY_NONE
LEVELS = 4 if lib.LONG else 3
Curve = Callable[[np.ndarray], np.ndarray]
TURN = 2 * np.pi * np.arange(200) / 200


def place_on(mesh: Mesh, a: int, b: int, t: float) -> tuple[int, tuple[float, float]]:
    """Face, and u and v, at the part t of the edge from a to b, in a mesh of quads."""
    faces = np.array(mesh.face_list())
    f, k = np.nonzero((faces == a) & (np.roll(faces, -1, axis=1) == b))
    if not len(f):
        return place_on(mesh, b, a, 1 - t)
    return f[0], ((t, 0), (1, t), (1 - t, 1), (0, 1 - t))[k[0]]


def edges_of(chain: list[int], is_closed: bool) -> list[tuple[int, int]]:
    return list(zip(chain, chain[1:] + chain[:is_closed]))


def divided(mesh: Mesh, fine: Mesh, chain: list[int], is_closed: bool) -> list[int]:
    """The same chain on the subdivided mesh of quads: vertices that are joined to both ends of an edge, and to four or three."""
    faces = fine.face_list()
    near: dict[int, set[int]] = {}
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1]):
            near.setdefault(a, set()).add(b)
            near.setdefault(b, set()).add(a)
    out = []
    for a, b in edges_of(chain, is_closed):
        (middle,) = near[a] & near[b]
        out += [a, middle]
    return out if is_closed else out + chain[-1:]


def run(mesh: Mesh, levels: int, chains: list[lib.Chain], **more) -> lib.Result:
    return lib.minimize(mesh, levels=levels, symmetry=NONE, through=lib.through(chains=chains), **more)


def on_level(mesh: Mesh, chain: list[int], is_closed: bool, level: int) -> list[int]:
    for _ in range(level - 1):
        fine = lib.refine(mesh)
        mesh, chain = fine, divided(mesh, fine, chain, is_closed)
    return chain


def deviations(mesh: Mesh, chain: list[int], is_closed: bool, given: lib.Chain, distance: Curve,
               verdict: str | None = "minimum") -> np.ndarray:
    """Largest distance [LEVELS] of the chain's limit curve from the curve."""
    out = []
    for level in range(1, LEVELS + 1):
        result = run(mesh, level, [given])
        assert verdict in (None, result.verdict)
        edges = edges_of(on_level(mesh, chain, is_closed, level), is_closed)
        where = [place_on(result.mesh, a, b, t) for a, b in edges for t in (0.1, 0.25, 0.5, 0.75, 0.9)]
        found = osd_jets(result.mesh, [f for f, _ in where], [0] * len(where), [p for _, p in where], level=6).jets[:, 0]
        out.append(distance(found).max())
    return np.array(out)


def orders(found: np.ndarray) -> np.ndarray:
    return np.log2(found[:-1] / found[1:])


def ring() -> tuple[Mesh, list[int], Curve, Curve]:
    """A meridian of a torus, and a circle in its plane, wider by 15 %."""
    mesh = torus_cage(9, 8, 0.4)
    limits = points.limits(mesh)[:8]
    middle, size = limits.mean(axis=0), 1.15 * np.linalg.norm(limits - limits.mean(axis=0), axis=1).mean()
    out, up = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    sign = np.sign((limits[2] - middle) @ up)

    def curve(t: np.ndarray) -> np.ndarray:
        return middle + size * (np.outer(np.cos(t), out) + sign * np.outer(np.sin(t), up))

    def distance(x: np.ndarray) -> np.ndarray:
        return np.hypot((x - middle)[:, 1], np.hypot((x - middle)[:, 0], (x - middle)[:, 2]) - size)

    return mesh, list(range(8)), curve, distance


UNEVEN = (200 * np.arange(8) / 8 + 200 / (2 * np.pi) * 0.25 * np.random.default_rng(1).uniform(-1, 1, 8)) % 200


def helix() -> tuple[Mesh, list[int], np.ndarray, Curve]:
    """Six vertices in a row of a torus, points of a helix, and the distance from it."""
    mesh, rise = torus_cage(12, 7, 0.4), 0.08
    size = 1.05 * np.hypot(*points.limits(mesh)[0, :2])

    def curve(t: np.ndarray) -> np.ndarray:
        return np.column_stack([size * np.cos(t), size * np.sin(t), rise * t])

    def distance(x: np.ndarray) -> np.ndarray:
        t = np.arctan2(x[:, 1], x[:, 0])
        for _ in range(20):  # Newton's method for the foot
            tangent = np.column_stack([-size * np.sin(t), size * np.cos(t), np.full(len(t), rise)])
            bend = np.column_stack([-size * np.cos(t), -size * np.sin(t), 0 * t])
            off = curve(t) - x
            t = t - (off * tangent).sum(axis=1) / ((tangent ** 2).sum(axis=1) + (off * bend).sum(axis=1))
        return np.linalg.norm(curve(t) - x, axis=1)

    return mesh, [7 * i for i in range(6)], curve(np.linspace(-0.1, 2.8, 200)), distance


@pytest.mark.parametrize("parameters", [None, UNEVEN])
def test_a_closed_chain_comes_to_a_circle_with_order_4(parameters, capsys):
    """At the nearest places, and at uneven ones."""
    mesh, chain, curve, distance = ring()
    given = lib.chain(chain, curve(TURN), True, True, parameters)
    found = deviations(mesh, chain, True, given, distance, "minimum" if parameters is not None else None)
    with capsys.disabled():
        print("\n  circle:", found, orders(found))
    assert (orders(found) > 3.5).all() and (orders(found) < 4.6).all()


@pytest.mark.parametrize("is_reversed", [False, True])
def test_an_open_chain_comes_to_a_helix_with_order_4(is_reversed, capsys):
    """In either direction; without the middles of its end edges the order would be 1."""
    mesh, chain, curve, distance = helix()
    chain = chain[::-1] if is_reversed else chain
    found = deviations(mesh, chain, False, lib.chain(chain, curve), distance)
    with capsys.disabled():
        print("\n  helix:", found, orders(found))
    assert (orders(found) > 3.5).all() and (orders(found) < 4.6).all()


def by_length(curve: np.ndarray, is_closed: bool) -> CubicSpline:
    """The spline through points [n, 3] by the length of their polygon."""
    curve = np.vstack([curve, curve[:1]]) if is_closed else curve
    length = np.r_[0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))]
    return CubicSpline(length, curve, bc_type="periodic" if is_closed else "not-a-knot")


def test_vertices_are_where_the_splines_of_scipy_are():
    """On three levels, of points that are far from each other on the curve, and the parameters between the first level's
    vertices: limit points by OpenSubdiv."""
    mesh, chain, curve, _ = ring()
    few = curve(2 * np.pi * np.array([0, 0.1, 0.3, 0.42, 0.6, 0.8, 0.91])) + 0.02 * np.random.default_rng(4).normal(size=(7, 3))
    parameters = np.array([0.2, 1.5, 2.1, 3.5, 4.1, 4.7, 5.3, 6.4])
    spline = by_length(few, True)
    t = np.interp(parameters, np.arange(8), spline.x)
    s = CubicSpline(np.arange(9), np.r_[t, t[0] + spline.x[-1]] - spline.x[-1] / 8 * np.arange(9), bc_type="periodic")
    for level in (1, 2, 3):
        result = run(mesh, level, [lib.chain(chain, few, True, True, parameters)])
        on = on_level(mesh, chain, True, level)
        u = np.arange(len(on)) / 2 ** (level - 1)
        wanted = spline((s(u) + spline.x[-1] / 8 * u) % spline.x[-1])
        assert np.abs(points.limits(result.mesh)[on] - wanted).max() < 1e-9


@pytest.mark.parametrize("is_closed", [True, False])
def test_points_that_repeat_others_to_rounding_do_not_count(is_closed):
    """A last point beside the first one of a closed curve, or at the end of an open one, and one in the middle."""
    mesh, chain, curve, _ = ring()
    points_of = curve(TURN[::10])
    step = 1e-7 * np.array([0.3, -0.5, 0.8])
    more = np.vstack([points_of[:9], points_of[8] + step, points_of[9:], points_of[0 if is_closed else -1] + step])
    on = chain if is_closed else chain[2:6]
    found = [points.limits(run(mesh, 1, [lib.chain(on, c, is_closed, is_closed)]).mesh)[on] for c in (points_of, more)]
    assert np.abs(found[1] - found[0]).max() < 1e-6


def test_middles_of_end_edges_of_an_open_chain_are_on_its_curve():
    mesh, chain, curve, _ = helix()
    parameters = np.array([5, 40, 70, 105, 142, 180.0])
    spline = by_length(curve, False)
    s = CubicSpline(np.arange(6), np.interp(parameters, np.arange(200), spline.x))
    for level in (1, 2, 3):
        result = run(mesh, level, [lib.chain(chain, curve, parameters=parameters)])
        on = on_level(mesh, chain, False, level)
        step = 1 / 2 ** (level - 1)
        u = np.r_[np.arange(len(on)) * step, step / 2, 5 - step / 2]
        where = [place_on(result.mesh, on[k], on[k + 1], 0.5) for k in (0, len(on) - 2)]
        middles = osd_jets(result.mesh, [f for f, _ in where], [0, 0], [p for _, p in where], level=6).jets[:, 0]
        found = np.vstack([points.limits(result.mesh)[on], middles])
        assert np.abs(found - spline(s(u))).max() < 1e-9


@pytest.mark.parametrize("chain", [[16, 8, 0, 1, 2], [3, 11, 19, 20, 21], [0, 8, 9]])
def test_chains_turn_in_regular_vertices(chain, capsys):
    """By a right angle, on a curve through the chain's own limit points, which is smooth there and bends by more than a radian
    along the end edges: what their middles wanted folded the surface beyond them. Points in the same places do no harm either."""
    mesh = torus_cage(8, 8, 0.5)
    places = points.limits(mesh)[chain]
    for levels in (1, 2):
        result = run(mesh, levels, [lib.chain(chain, places, parameters=np.arange(len(chain)))])
        alone = lib.minimize(mesh, levels=levels, symmetry=NONE, through=lib.through(chain, places=places))
        more = result.summary.end.objective / alone.summary.end.objective - 1
        with capsys.disabled():
            print(f"\n  {chain}, {levels} levels: {more:+.4f}")
        assert result.verdict == alone.verdict == "minimum" and more < 0.01
        assert np.abs(points.limits(result.mesh)[chain] - places).max() < 1e-9


POLES = [(True, 0.6, 1.5), (False, 1.5, 3)]


@pytest.mark.parametrize("inside, least, most", POLES if lib.LONG else POLES[:1])
def test_poles_of_three_faces_take_orders_from_chains(inside, least, most, capsys):
    """A limit curve has a corner of 120 degrees in such a pole, which the curve has not; one that ends there has none."""
    mesh = nets.sphere_like(4)
    loop = [9, 62, 63, 64, 34, 33, 39, 44, 49, 79, 78, 77, 24, 19, 14, 8]
    chain = loop[2:7] if inside else loop[:5]
    limits = points.limits(mesh)[loop]
    height, size = limits[:, 2].mean(), np.hypot(*limits[:, :2].T).mean()
    curve = np.column_stack([size * np.cos(TURN), size * np.sin(TURN), np.full(200, height)])
    found = deviations(mesh, chain, False, lib.chain(chain, curve, curve_closed=True),
                       lambda x: np.hypot(np.hypot(x[:, 0], x[:, 1]) - size, x[:, 2] - height))
    with capsys.disabled():
        print(f"\n  pole {'inside' if inside else 'at the end'}:", found, orders(found))
    assert (orders(found) > least).all() and (orders(found) < most).all()


def patch(n: int = 7) -> Mesh:
    """A flat square of (n - 1)^2 faces."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    faces = [[i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j] for i in range(n - 1) for j in range(n - 1)]
    return mesh_from_faces(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), faces)


def test_a_boundary_keeps_the_ends_of_a_chain():
    """From side to side of a flat patch, under a curve that is higher in the middle; corners of the grid are sharp."""
    mesh = patch()
    chain = list(range(21, 28))
    x = np.linspace(-1, 1, 60)
    curve = np.column_stack([x, 0 * x, 0.3 * (1 - x ** 2)])
    before = points.limits(mesh)
    for level in (1, 2):
        result = run(mesh, level, [lib.chain(chain, curve)])
        at = points.limits(result.mesh)[on_level(mesh, chain, False, level)]
        assert np.abs(at[[0, -1]] - before[[21, 27]]).max() < 1e-12
        assert np.abs(at[1:-1, 2] - 0.3 * (1 - at[1:-1, 0] ** 2)).max() < 1e-6 and at[:, 2].max() > 0.2


def test_chains_cross_in_a_vertex():
    """Where both curves have the same point; entries beside them hold other points."""
    mesh = patch()
    x = np.linspace(-1, 1, 61)
    along = np.column_stack([x, 0 * x, 0.3 * (1 - x ** 2)])
    across = np.column_stack([0 * x, x, 0.3 * (1 - x ** 4)])
    one, two = list(range(21, 28)), list(range(3, 49, 7))
    even = np.linspace(0, 60, 7)
    entries = {"vertices": [16], "places": [[-0.35, -0.3, 0.3]]}
    chains = [lib.chain(one, along, parameters=even), lib.chain(two, across, parameters=even)]
    result = lib.minimize(mesh, levels=2, symmetry=NONE, through=lib.through(**entries, chains=chains))
    at = points.limits(result.mesh)
    assert np.abs(at[24] - [0, 0, 0.3]).max() < 1e-9 and np.abs(at[16] - [-0.35, -0.3, 0.3]).max() < 1e-9
    assert np.abs(at[two[1:-1]] - across[10:60:10]).max() < 1e-9
    chains[1] = lib.chain(two, across, parameters=even + np.r_[0, 0, 0, 1, 0, 0, 0])
    with pytest.raises(lib.CurvoptError, match="chain 1 wants vertex 24 0.03.* away from where chain 0 wants it"):
        run(mesh, 1, chains)


CURVE = ring()[2](TURN)
REFUSED = [
    ("chain 0 goes from vertex 0 to vertex 2, but no edge does", dict(vertices=[0, 2, 3])),
    ("chain 0 has vertex 1 twice", dict(vertices=[0, 1, 2, 1])),
    ("chain 0 has vertex 0 twice: a closed chain says so", dict(vertices=[0, 1, 2, 3, 4, 5, 6, 7, 0])),
    ("chain 0 has 1 vertices, which are given; an open chain needs 2", dict(vertices=[0])),
    ("chain 0 has 2 vertices, which are given; a closed chain needs 3", dict(vertices=[0, 1], closed=True)),
    ("chain 0 has vertex 72; there are 72 vertices", dict(vertices=[0, 72])),
    ("chain 0 has vertex -1; there are 72 vertices", dict(vertices=[-1, 0])),
    ("chain 0 is closed and its curve is open", dict(vertices=list(range(8)), closed=True)),
    ("chain 0: its curve has 1 point that differs from the one before; a curve needs 2", dict(vertices=[0, 1], curve=[[1, 2, 3]] * 4)),
    ("chain 0: its curve has 2 points that differ from the one before; a closed curve needs 3",
     dict(vertices=[0, 1], curve=[[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 0]], curve_closed=True)),
    ("chain 0: point 1 of its curve is 1 nan 3", dict(vertices=[0, 1], curve=[[1, 2, 3], [1, np.nan, 3]])),
    ("chain 0: its curve is too long", dict(vertices=[0, 1], curve=[[0, 0, 0], [1e200, 0, 0]])),
    ("chain 0: its curve has 0 points", dict(vertices=[0, 1], curve=np.zeros((0, 3)))),
    ("chain 0: the parameter of vertex 1 is 199.5; it must be 0 to 199", dict(vertices=[0, 1], parameters=[0, 199.5])),
    ("chain 0: the parameter of vertex 0 is nan", dict(vertices=[0, 1], parameters=[np.nan, 1])),
    ("chain 0: on its curve vertex 3 comes out of order", dict(vertices=[0, 1, 2, 3, 4], parameters=[10, 20, 30, 25, 40])),
    ("chain 0: on its curve vertex 2 comes out of order", dict(vertices=[4, 3, 2, 1, 0], parameters=[40, 30, 35, 20, 10])),
    ("chain 0: on its curve vertex 3 comes out of order",
     dict(vertices=list(range(8)), closed=True, curve_closed=True, parameters=[0, 20, 40, 30, 80, 100, 120, 140])),
    ("chain 0: on its curve vertex 1 comes out of order, or where another one is", dict(vertices=[0, 1], curve=[[9, 9, 9], [8, 9, 9]])),
    ("chain 0: between vertex 1 and vertex 2 the places on its curve turn back", dict(vertices=[0, 1, 2, 3], parameters=[0, 80, 81, 160])),
]


@pytest.mark.parametrize("sentence, given", REFUSED)
def test_chains_that_cannot_be_are_refused_by_name(sentence, given):
    given = {"curve": CURVE} | given
    with pytest.raises(lib.CurvoptError) as error:
        run(ring()[0], 1, [lib.chain(**given)])
    assert sentence in str(error.value)


def test_what_chains_stand_against_is_refused():
    mesh, chain, curve, _ = ring()
    good = lib.chain(chain, curve(TURN), True, True)
    for sentence, more in (
        ("chain 0 goes through vertex 3, which has a constraint of its own", {"constraints": lib.constraints([3])}),
        ("what the surface goes through cannot be had with a strength below 1", {"strength": 0.5}),
        ("chain 0 has 8 edges, which become 1024 on level 8; there can be 1000", {"levels": 8}),
    ):
        with pytest.raises(lib.CurvoptError) as error:
            lib.minimize(mesh, **({"levels": 1, "symmetry": NONE, "through": lib.through(chains=[good])} | more))
        assert sentence in str(error.value)
    for sentence, through in (
        ("chain 0 holds the point of entry 1: leave the entry out; where on its curve", lib.through([20, 2], chains=[good])),
        ("chain 0 holds the point of entry 0", lib.through(None, [0], uv=[[0, 0.3]], chains=[good])),
        ("chain 1 has the edge from vertex 0 to vertex 1, as chain 0 has", lib.through(chains=[good, lib.chain([0, 1], curve(TURN))])),
    ):
        with pytest.raises(lib.CurvoptError) as error:
            lib.minimize(mesh, levels=1, symmetry=NONE, through=through)
        assert sentence in str(error.value)
    flat = patch()
    with pytest.raises(lib.CurvoptError, match="chain 0: the boundary, a crease or left-out faces hold all of its vertices"):
        run(flat, 1, [lib.chain([1, 2, 3], [[-1, -1, 0.1], [1, -1, 0]])])

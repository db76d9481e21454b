# SPDX-License-Identifier: GPL-3.0-or-later
"""Blends of several faces a sector at poles on boundaries and creases: against a second implementation, along the curve,
their energies and orders, and when they are taken (notes/16-blends-at-boundaries.md).
"""
from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import lib
from ccref import SHARP, Mesh, mesh_from_faces, refine, topology
from cut_ref import fans, star
from test_gradient import difference, mean_edge
from test_poles_on_curves import curve, exact_energies, half_disc, height, size, strip, with_height
from wide_cut_ref import WideCutBlend, grid
from wide_ref import PLACE, sector_taylor

FREE = 3  # boundaries are held by pins alone


def sharpness(mesh: Mesh, corners: bool = False) -> tuple[dict, dict]:
    """Of creases and of vertices, as mesh_from_faces takes it; `corners`: infinite for vertices of one face."""
    alone = np.flatnonzero((np.bincount(mesh.flat) == 1) * corners + mesh.vertex_sharpness)
    return dict(zip(map(tuple, mesh.creases.tolist()), mesh.crease_sharpness)), {int(v): SHARP for v in alone}


def shaken(flat: Mesh, amount: float, seed: int = 0) -> Mesh:
    """Every coordinate moved by up to `amount`; each face begins at a corner of its own. Corners of one face are kept."""
    rng = np.random.default_rng(seed)
    faces = [np.roll(face, rng.integers(4)).tolist() for face in flat.face_list()]
    return mesh_from_faces(flat.xyz + amount * rng.uniform(-1, 1, flat.xyz.shape), faces, *sharpness(flat, True))


def crease_star(sides: tuple[int, int], m: int) -> Mesh:
    """m x m faces of each of some sectors on either side of a crease through vertex 0, natural on both sides."""
    n = sum(sides)
    flat = star(n, m, False, {0: m, sides[0]: m})
    x, y, _ = flat.xyz.T
    sector = np.arctan2(y, x) % (2 * np.pi) / (2 * np.pi) * n
    sector[sector > n - 1e-9] = 0
    angle = np.pi * np.where(sector <= sides[0], sector / sides[0], 1 + (sector - sides[0]) / sides[1])
    radius = np.hypot(x, y)
    return flat.with_xyz(np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * x], axis=1))


def natural(n: int, m: int) -> tuple[Mesh, np.ndarray]:
    """The natural net over a half disc of radius 2, its corners kept, and which faces are in the inner half of each
    sector."""
    mesh = star(n, m, True)
    sharp = np.where(np.bincount(mesh.flat) == 1, SHARP, 0)
    i = np.arange(mesh.n_faces)
    return (Mesh(mesh.sizes, mesh.flat, mesh.xyz / (m / 2), mesh.creases, mesh.crease_sharpness, sharp),
            (i % m < m // 2) & (i // m % m < m // 2))


@lru_cache(maxsize=None)
def net(name: str) -> Mesh:
    """kind_sectors_m_refinements"""
    kind, *numbers = name.split("_")
    sectors, m, times = (int(k) for k in numbers)
    mesh = shaken(star(sectors, m, True) if kind == "boundary" else crease_star((sectors, 4), m), 0.01, sectors)
    for _ in range(times):
        mesh = refine(mesh)
    return mesh


NETS = {"boundary_3_8_0": 2, "boundary_5_8_0": 2, "boundary_4_17_0": 4, "boundary_6_4_1": 2, "boundary_3_4_2": 4,
        "crease_3_8_0": 2}


# ---------------------------------------------------------------------------------------------- the surface --


@pytest.mark.parametrize("name", NETS)
def test_jets_are_those_of_the_second_implementation(name, capsys):
    """On all faces of the half disc, close to the vertex, too; beyond it they are the limit surface's. With another map
    they are not."""
    mesh, m, steps = net(name), NETS[name], int(name[-1])
    st, worst, differs = np.random.default_rng(1).uniform(0.02, 0.98, (3, 2)), np.zeros(4), np.inf
    for fan in range(len(fans(mesh, 0))):
        blend, other = WideCutBlend(mesh, 0, m, steps, fan), WideCutBlend(mesh, 0, m, steps + 1, fan)
        gap = 0.0
        for cell in blend.cells():
            at = st if any(cell[1:]) else np.concatenate([st, 0.02 * st])
            got, wanted = sector_taylor(mesh, *blend.face(cell), at, "polynomial"), blend.taylor(cell, at)
            error = abs(got - wanted).max(axis=(0, 2)) / np.maximum(abs(wanted).max(axis=(0, 2)), size(mesh))
            for (p, q), k in PLACE.items():
                worst[p + q] = max(worst[p + q], error[k])
            gap = max(gap, abs(other.taylor(cell, at) - wanted)[:, 0].max() / size(mesh))
        differs = min(differs, gap)
        for beyond in ((0, m, 0), (blend.n - 1, 0, m), (0, m, m)):
            got, wanted = (sector_taylor(mesh, *blend.face(beyond), st, surface) for surface in ("polynomial", "deep"))
            assert abs(got - wanted).max() <= 1e-12
    with capsys.disabled():
        print(f"\n  {name}: errors by order", ", ".join(f"{e:.1e}" for e in worst), f"; other map {differs:.1e}")
    assert (worst <= [1e-14, 1e-14, 1e-12, 1e-12]).all(), worst
    assert differs >= 1e-5


@pytest.mark.parametrize("name", NETS)
def test_the_curve_stays_as_it_is(name):
    """The surface ends at the B-spline of its boundary or crease on all faces along it; so both sides of a crease meet."""
    mesh, m, t = net(name), NETS[name], np.linspace(0.05, 0.95, 5)
    for fan in range(len(fans(mesh, 0))):
        blend = WideCutBlend(mesh, 0, m, 0, fan)
        for k in range(m):
            for cell, to_other in (((0, k, 0), 0), ((blend.n - 1, 0, k), 3)):
                face, corner = blend.face(cell)
                along = np.stack([0 * t, t] if to_other else [t, 0 * t], axis=1)
                got = sector_taylor(mesh, face, corner, along, "polynomial")[:, 0]
                wanted = curve(mesh, face, (corner + to_other) % 4, 1 - t if to_other else t)
                assert abs(got - wanted).max() <= 1e-14 * size(mesh)


@pytest.mark.parametrize("name", ["boundary_3_8_0", "boundary_4_17_0", "boundary_6_4_1"])
def test_second_derivatives_are_continuous(name):
    """Across all edges, derivatives towards the other side."""
    mesh = net(name)
    topo = topology(mesh)
    corner = np.arange(len(mesh.flat)) - topo.start[topo.face]
    along = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    direction = along[(corner + 1) % 4] - along[corner]
    inward = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    inner = topo.twin >= 0
    jets = lib.jets(mesh, topo.face, 0 * topo.face, along[corner] + 0.3 * direction, "polynomial")
    back = lib.jets(mesh, topo.face, 0 * topo.face, along[corner] + 0.7 * direction, "polynomial")
    for order, factors in ((0, {0: (0, 0)}), (1, {1: (1, 0), 2: (0, 1)}), (2, {3: (2, 0), 4: (1, 1), 5: (0, 2)})):
        sides = []
        for at in (jets, back):
            sides.append(sum((2 if k == 4 else 1) * (inward[:, 0] ** p * inward[:, 1] ** q)[:, None] * at[:, k]
                             for k, (p, q) in factors.items()))
        gap = sides[0] - (-1) ** order * sides[1][topo.twin]
        assert abs(gap[inner]).max() <= 1e-12 * size(mesh), order


# ------------------------------------------------------------------------------------------------- energies --


@pytest.mark.parametrize("name", ["boundary_3_8_0", "boundary_5_8_0", "boundary_6_4_1", "crease_3_8_0"])
def test_flat_cages_have_no_energy(name):
    """In any plane; a positive Jacobian says that the blend does not fold over."""
    mesh = net(name)
    flat = mesh.with_xyz(mesh.xyz * [1, 1, 0])
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for one in (flat, flat.with_xyz(flat.xyz @ turn.T)):
        for term in ("willmore", "mvs", "mvs_cross", "variation"):
            found = lib.evaluate(one, term, "polynomial", joshi_sequin=1)
            assert 0 <= found.objective < 1e-18 and found.min_jacobian > 0, (term, found.objective)


def bent(name: str) -> Mesh:
    """A net over the height of test_poles_on_curves.py."""
    mesh = net(name)
    x, y = 2 * mesh.xyz[:, :2].T / abs(mesh.xyz).max()
    scale = abs(mesh.xyz).max() / 2
    return mesh.with_xyz(mesh.xyz + scale * np.stack([0 * x, 0 * x, height(x, y)[:, 0]], axis=1))


@pytest.mark.parametrize("name, term", [("boundary_3_8_0", "mvs"), ("boundary_5_8_0", "willmore"),
                                        ("boundary_6_4_1", "mvs_cross"), ("crease_3_8_0", "mvs"),
                                        ("boundary_4_17_0", "mvs")])
def test_gradients(name, term, capsys):
    """Against differences, to 1e-6, at the pole and the vertices next to it; the surface is one with half discs."""
    mesh = bent(name)
    problem = lib.Problem(mesh, lib.options(term, "polynomial", joshi_sequin=1))
    energies, gradient = problem.evaluate(mesh.xyz, gradient=True)
    narrow = lib.evaluate(mesh, term, "polynomial", joshi_sequin=1, blend_width=1).objective
    assert abs(energies.objective - narrow) >= 1e-5 * narrow
    worst, axis = 0.0, np.random.default_rng(0).integers(0, 3, 30)
    for k, v in enumerate(np.argsort(np.linalg.norm(mesh.xyz - mesh.xyz[0], axis=1))[:30:2]):
        at = int(v), int(axis[k])
        if abs(gradient[at]) > 1e-3 * abs(gradient).max():
            worst = max(worst, abs(difference(problem, mesh.xyz, at, mean_edge(mesh)) / gradient[at] - 1))
    with capsys.disabled():
        print(f"\n  {name} {term}: worst relative error {worst:.1e}")
    assert 0 < worst <= 1e-6


@pytest.mark.parametrize("name", ["boundary_3_8_0", "boundary_6_4_1", "crease_3_8_0"])
def test_energies_converge_to_those_of_finer_rules(name, capsys):
    """And Gauss and Bonnet are met."""
    mesh, words = bent(name), []
    for term in ("willmore", "mvs"):
        exact = lib.evaluate(mesh, term, "polynomial", tolerance=1e-7).objective
        for tolerance in (1e-3, 1e-5):
            found = lib.evaluate(mesh, term, "polynomial", tolerance=tolerance)
            error = abs(found.objective - exact)
            words.append(f"{error / exact:.1e} ({found.objective_error / exact:.1e})")
            assert error <= 3 * found.objective_error and error <= tolerance * exact
            assert found.gauss_bonnet_defect < 10 * tolerance
    with capsys.disabled():
        print(f"\n  {name}: errors (claimed) at 1e-3, 1e-5:", ", ".join(words))


def mvs_error(flat: Mesh, inner: np.ndarray, **fields) -> float:
    """Of the known height over the inner faces of a plane net."""
    exact = exact_energies(flat, np.flatnonzero(inner))["mvs"]
    holes = lib.holes(np.flatnonzero(~inner))
    return lib.evaluate(with_height(flat), "mvs", "polynomial", tolerance=1e-4, **holes, **fields).value("mvs") - exact


@pytest.mark.parametrize("n, errors", [(3, [1.36, 0.340, 0.127]), (5, [17.8, 6.51, 2.09]), (6, [None, 18.8, 5.78])])
def test_mvs_converges_on_natural_nets(n, errors, capsys):
    """With order 1.3 to 2.1 from 8 to 32 faces a sector, where m is 2, 4, 8; with width 1 with less than .3."""
    at = [m for m, error in zip((8, 16, 32), errors) if error]
    found = [mvs_error(*natural(n, m)) for m in at]
    narrow = [mvs_error(*natural(n, m), blend_width=1) for m in at[-2:]]
    orders = np.log2(np.divide(found[:-1], found[1:]))
    with capsys.disabled():
        print(f"\n  {n} faces: MVS errors", ", ".join(f"{e:.3g}" for e in found), "orders",
              ", ".join(f"{o:.2f}" for o in orders), "; width 1", ", ".join(f"{e:.3g}" for e in narrow))
    assert found == pytest.approx([error for error in errors if error], rel=0.05)
    assert (1.3 < orders).all() and (orders < 2.1).all()
    assert -0.1 < np.log2(narrow[0] / narrow[1]) < 0.3 and narrow[1] > 9 * found[-1]


def test_mvs_of_a_refined_cage_stays(capsys):
    """The same limit surface: three refinements change MVS by less than a tenth; with blends of width 1 it triples."""
    mesh, found = strip(), []
    for k in range(4):
        mesh = lib.refine(mesh) if k else mesh
        found.append([lib.evaluate(mesh, "mvs", "polynomial", tolerance=1e-3, blend_width=m).value("mvs")
                      for m in (8, 1)])
    wide, narrow = np.array(found).T
    with capsys.disabled():
        print("\n  MVS after 0..3 refinements:", ", ".join(f"{e:.5g}" for e in wide), "; width 1:",
              ", ".join(f"{e:.5g}" for e in narrow))
    assert wide.max() <= 1.11 * wide.min() and wide[3] == pytest.approx(wide[2], rel=0.01)
    assert narrow[3] > 2.9 * narrow[0]


# ------------------------------------------------------------------------------------- when they are taken --


def half_width(mesh: Mesh, widest: int = 8) -> int:
    """How far from vertex 0 along the boundary the surface is not that of width 1; 1: nowhere."""
    row = grid(mesh, fans(mesh, 0)[0][1][0], widest)[0]
    st = np.array([[0.3, 0.4]])
    differs = [abs(sector_taylor(mesh, *at, st, "polynomial") - sector_taylor(mesh, *at, st, "limit")).max() > 1e-9
               for at in row]
    return max(1, sum(differs))


@pytest.mark.parametrize("m, width", [(7, 1), (8, 2), (15, 2), (16, 4), (32, 8), (40, 8)])
def test_width_is_a_power_of_2_up_to_a_quarter_of_the_distance(m, width):
    mesh = shaken(star(3, m, True), 0.01)
    assert half_width(mesh, min(m - 1, 10)) == width
    if width > 2:
        faces = np.arange(mesh.n_faces)
        uv = np.full((mesh.n_faces, 2), 0.4)
        jets = [lib.jets(mesh, faces, 0 * faces, uv, "polynomial", blend_width=most) for most in (2, 3, 4)]
        assert (jets[0] == jets[1]).all() and abs(jets[2] - jets[0]).max() > 1e-4


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_crowded_nets_stay_at_width_1(n):
    """Points at places like z^(2/n): no polynomial over the natural net is near that surface."""
    flat, inner = half_disc(n, 16)
    holes = lib.holes(np.flatnonzero(~inner))
    values = [lib.evaluate(with_height(flat), "mvs", "polynomial", **holes, blend_width=m).value("mvs") for m in (1, 8)]
    assert values[0] == values[1]


@pytest.mark.parametrize("n", [3, 5, 6])
@pytest.mark.parametrize("noise", [0.05, 0.1, 0.2])
def test_noise_makes_half_discs_hardly_worse_than_width_1(n, noise):
    for m in (8, 16):
        flat, inner = natural(n, m)
        xyz = flat.xyz + np.stack([0 * flat.xyz[:, 0]] * 2 + [height(*flat.xyz[:, :2].T)[:, 0]], axis=1)
        xyz += noise * 2 / m * np.random.default_rng(1).uniform(-1, 1, xyz.shape)
        holes = lib.holes(np.flatnonzero(~inner))
        one, wide = (lib.evaluate(flat.with_xyz(xyz), "mvs", "polynomial", tolerance=1e-2, **holes,
                                  blend_width=width).value("mvs") for width in (1, 8))
        assert wide <= 1.06 * one


def test_energies_do_not_depend_on_orientation_size_or_order():
    """Mirror image; a turned, larger one elsewhere; faces in another order and each beginning at another vertex."""
    for name in ("boundary_5_8_0", "boundary_6_4_1", "crease_3_8_0"):
        mesh, rng = bent(name), np.random.default_rng(3)
        faces, sharp = mesh.face_list(), sharpness(mesh)
        turned = [np.roll(faces[f], rng.integers(4)).tolist() for f in rng.permutation(mesh.n_faces)]
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        images = [mesh_from_faces(mesh.xyz * [-1, 1, 1], [face[::-1] for face in faces], *sharp),
                  mesh_from_faces(mesh.xyz, turned, *sharp),
                  mesh_from_faces(7 * mesh.xyz @ turn.T + 3, faces, *sharp)]
        for term in ("willmore", "mvs"):
            values = [lib.evaluate(one, term, "polynomial", joshi_sequin=1).objective for one in (mesh, *images)]
            assert values[1:] == pytest.approx([values[0]] * 3, rel=1e-11)


def test_mirror_symmetric_cages_have_mirror_symmetric_half_discs():
    """Noise that both halves of a cage have alike: widths and maps are the same on both, and so are places."""
    taken = 0
    for seed in range(6):
        half = shaken(star(5, 8, True), 0.12, seed)
        faces, n = half.face_list(), half.n_vertices
        image = half.xyz * [-1, 1, 1] + [50, 0, 0]
        mesh = mesh_from_faces(np.concatenate([half.xyz, image]),
                               faces + [[face[0] + n, *(v + n for v in face[:0:-1])] for face in faces])
        f = np.arange(half.n_faces)
        uv = np.random.default_rng(seed).uniform(0.1, 0.9, (half.n_faces, 2))
        here = lib.jets(mesh, f, 0 * f, uv, "polynomial")[:, 0]
        there = lib.jets(mesh, f + half.n_faces, 0 * f, uv[:, ::-1], "polynomial")[:, 0] * [-1, 1, 1] + [50, 0, 0]
        assert abs(here - there).max() <= 1e-12 * 50
        taken += abs(here - lib.jets(mesh, f, 0 * f, uv, "polynomial", blend_width=1)[:, 0]).max() > 1e-6
    assert taken >= 3


@pytest.mark.parametrize("levels", [1, 2])
def test_evaluate_and_minimize_agree(levels, capsys):
    """Of the cage that comes in, and of the one that goes out."""
    flat, _ = natural(3, 8)
    mesh = with_height(flat)
    result = lib.minimize(mesh, "mvs", "polynomial", levels=levels, boundary=0, spacing=0)
    start = lib.evaluate(mesh, "mvs", "polynomial").value("mvs")
    end = lib.evaluate(result.mesh, "mvs", "polynomial")
    with capsys.disabled():
        print(f"\n  {start:.6g} -> {end.value('mvs'):.6g}, {result.stop}, {result.verdict}")
    assert result.summary.start.value("mvs") == pytest.approx(start, rel=1e-3)
    assert result.summary.end.value("mvs") == pytest.approx(end.value("mvs"), rel=1e-3)
    assert end.value("mvs") < start


def test_figures_of_the_result_are_those_of_its_own_half_discs(capsys):
    """Of a cage whose boundary is too uneven for half discs, until its points have been moved."""
    flat, _ = natural(3, 8)
    mesh = with_height(flat)
    curve_points = topology(flat).ends[topology(flat).n_edge_faces == 1]
    near = np.unique(curve_points[(curve_points == 0).any(axis=1)])
    mesh = mesh.with_xyz(mesh.xyz - 0.6 * np.isin(np.arange(mesh.n_vertices), near)[:, None] * (mesh.xyz - mesh.xyz[0]))
    narrow, wide = (lib.evaluate(mesh, "mvs", "polynomial", blend_width=m).value("mvs") for m in (1, 8))
    assert narrow == wide
    free = np.linalg.norm(flat.xyz, axis=1) < 1.2
    result = lib.minimize(mesh, "mvs", "polynomial", levels=1, boundary=FREE,
                          constraints=lib.constraints(np.flatnonzero(~free)))
    narrow, wide = (lib.evaluate(result.mesh, "mvs", "polynomial", blend_width=m).value("mvs") for m in (1, 8))
    with capsys.disabled():
        print(f"\n  result at width 1: {narrow:.6g}, with half discs {wide:.6g}, reported"
              f" {result.summary.end.value('mvs'):.6g}")
    assert abs(narrow / wide - 1) > 5e-3
    assert result.summary.end.value("mvs") == pytest.approx(wide, rel=1e-3)

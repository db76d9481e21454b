# SPDX-License-Identifier: GPL-3.0-or-later
"""`polynomial` where its blend is over several faces of each sector: against a second implementation, and its orders."""
from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import lib
from ccref import Mesh, refine, topology
from energy_ref import densities, gauss_rule
from nets import perturbed, quad_cage, sphere_like, subdivided_cube, trapezohedron, valences
from wide_ref import PLACE, WideBlend, sector_taylor


@lru_cache(maxsize=None)
def net(name: str) -> tuple[Mesh, Mesh, int]:
    """A mesh with a vertex of some valence far from others, the same with regular positions there, and the vertex."""
    kind, valence, halvings = name.split("_")
    if kind == "cube":
        flat = subdivided_cube(2 ** int(halvings))
    else:
        flat = quad_cage(trapezohedron(int(valence)))
        for _ in range(int(halvings) - 1):
            flat = refine(flat)
    vertex = int(np.flatnonzero(valences(flat) == int(valence))[0])
    return flat, perturbed(flat, 0.1, 7), vertex


@pytest.mark.parametrize("name, m", [("cube_3_2", 1), ("cube_3_3", 2), ("cube_3_4", 4), ("kites_5_3", 2), ("kites_6_3", 2),
                                     ("kites_7_3", 2)])
def test_jets_are_those_of_the_second_implementation(name, m, capsys):
    """On all faces of the disc; and beyond it they are the limit surface's. At m - 1 or m + 1 they are not."""
    flat, mesh, vertex = net(name)
    blend, around = WideBlend(flat, mesh, vertex, m), WideBlend(flat, mesh, vertex, m + 1)
    st = np.random.default_rng(m).uniform(0.02, 0.98, (4, 2))
    size, worst, differs = np.ptp(mesh.xyz, axis=0).max(), np.zeros(4), 0.0
    for cell in around.cells:
        got = sector_taylor(mesh, *cell[:2], st, "polynomial")
        inside = max(cell[2:]) < m
        wanted = blend.taylor(cell, st) if inside else sector_taylor(mesh, *cell[:2], st)
        error = abs(got - wanted).max(axis=(0, 2)) / np.maximum(abs(wanted).max(axis=(0, 2)), size)
        for (p, q), k in PLACE.items():
            worst[p + q] = max(worst[p + q], error[k])
        differs = max(differs, abs(around.taylor(cell, st) - wanted)[:, 0].max() / size)
    with capsys.disabled():
        print(f"\n  {name}, m = {m}: errors by order", ", ".join(f"{e:.1e}" for e in worst), f"; other m {differs:.1e}")
    assert (worst <= 1e-13).all(), worst
    assert differs >= 1e-5


@pytest.mark.parametrize("name", ["sphere", "ellipsoid_1_1_2"])
def test_the_width_grows_with_the_net(name):
    """At the vertex itself the surface is the polynomial: how its place moves when points far off do says how wide it is."""
    for n, m in ((4, 1), (8, 2), (16, 4), (32, 8)):
        mesh = sphere_like(n, name, subdivided_cube)
        quads = mesh.flat.reshape(-1, 4)
        vertex = int(np.flatnonzero(valences(mesh) == 3)[0])
        face, corner = (int(k[0]) for k in np.nonzero(quads == vertex))
        at = [[0, 0], [1, 0], [1, 1], [0, 1]][corner]
        distance = np.full(mesh.n_vertices, mesh.n_vertices)
        distance[vertex] = 0
        for _ in range(n):
            np.minimum.at(distance, quads.ravel(), np.repeat(distance[quads].min(axis=1) + 1, 4))
        place = lib.jets(mesh, [face], [0], [at], "polynomial")[0, 0]
        moved = []
        for ring in range(1, m + 3):
            xyz = mesh.xyz.copy()
            xyz[np.flatnonzero(distance == ring)[0]] += 1
            moved.append(abs(lib.jets(mesh.with_xyz(xyz), [face], [0], [at], "polynomial")[0, 0] - place).max())
        assert min(moved[:m + 1]) > 0 and moved[m + 1] == 0, (n, moved)


def test_blends_no_wider_than_asked():
    """|grad h|^2 of a sphere's net (0 exactly) at n = 16, which has room for m = 4: what tests/bench/wide_blend.py found for
    m = 1, 2, 4 before the library had wide blends."""
    mesh = sphere_like(16, "sphere", subdivided_cube)
    left = [lib.evaluate(mesh, "variation", "polynomial", tolerance=1e-4, blend_width=width).value("variation")
            for width in (1, 2, 4, 8)]
    assert left[:3] == pytest.approx([27.2, 12.8, 9.1], rel=0.03) and left[3] == left[2]
    with pytest.raises(lib.CurvoptError, match="blend_width is 9; it must be 1 to 8"):
        lib.evaluate(mesh, blend_width=9)


def test_samplers_show_the_surface_that_is_evaluated():
    """|grad h|^2 of a sphere's net, which the width changes by a factor, integrated from a sampler's jets and evaluated by
    the library, with the same blend_width in both."""
    mesh = sphere_like(8, "sphere", subdivided_cube)
    nodes, weights = gauss_rule(16)
    uv = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)
    face = np.repeat(np.arange(mesh.n_faces), len(uv))
    found = []
    for width in (1, 8):
        jets = lib.jets(mesh, face, 0 * face, np.tile(uv, (mesh.n_faces, 1)), "polynomial", blend_width=width)
        density = densities(jets)
        size = np.tile(np.outer(weights, weights).ravel(), mesh.n_faces) * density["area"]
        area, variation = float(size.sum()), float((size * density["variation"]).sum())
        evaluated = lib.evaluate(mesh, "variation", "polynomial", blend_width=width, tolerance=1e-5)
        assert area == pytest.approx(evaluated.area, rel=1e-5)
        assert area * variation == pytest.approx(evaluated.value("variation"), rel=5e-3)
        found.append(area * variation)
    assert found[0] > 1.3 * found[1]


def test_affine_images_of_the_net_are_affine_images_of_the_surface():
    _, mesh, _ = net("cube_3_4")
    matrix, shift = np.array([[1.2, 0.3, -0.1], [0.0, 0.7, 0.4], [0.2, -0.5, 1.1]]), np.array([3.0, -20.0, 7.0])
    faces = np.flatnonzero((np.arange(mesh.n_faces) % 5) == 0)
    uv = np.random.default_rng(0).uniform(0, 1, (len(faces), 2))
    one = lib.jets(mesh, faces, 0 * faces, uv, "polynomial")
    other = lib.jets(mesh.with_xyz(mesh.xyz @ matrix.T + shift), faces, 0 * faces, uv, "polynomial")
    wanted = one @ matrix.T
    wanted[:, 0] += shift
    assert abs(other - wanted).max() <= 1e-11 * abs(wanted).max()


def test_surface_is_continuous_across_the_faces_of_a_disc():
    """Places and derivatives across edges, from both sides of each."""
    _, mesh, _ = net("cube_3_4")
    topo = topology(mesh)
    corner = np.arange(len(mesh.flat)) - topo.start[topo.face]
    along = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    direction = along[(corner + 1) % 4] - along[corner]
    inward = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    jets = lib.jets(mesh, topo.face, 0 * topo.face, along[corner] + 0.3 * direction, "polynomial")
    back = lib.jets(mesh, topo.face, 0 * topo.face, along[corner] + 0.7 * direction, "polynomial")[topo.twin]
    size = np.ptp(mesh.xyz, axis=0).max()
    normal = np.einsum("nk,nkc->nc", inward, jets[:, 1:3])
    normal_back = np.einsum("nk,nkc->nc", inward[topo.twin], back[:, 1:3])
    assert abs(jets[:, 0] - back[:, 0]).max() <= 1e-12 * size
    assert abs(normal + normal_back).max() <= 1e-10 * size

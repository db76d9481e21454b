# SPDX-License-Identifier: GPL-3.0-or-later
"""curvopt_sampler_jets and curvopt_mesh_refine against deep refinement and OpenSubdiv."""
from __future__ import annotations

import numpy as np
import pytest

import lib
from ccref import JET_ORDERS, deep_jets, mesh_from_faces, refine, topology, vertex_limit
from energy_ref import Blend
from nets import hull_cage, named_cages, periodic_net, torus, valences
from osd import osd_jets

CAGES = named_cages()
CAGES["net_torus"] = periodic_net(torus(0.5), 8, 8)
CAGES["triangles"] = hull_cage(14, 3)
CAGES["two_parts"] = mesh_from_faces(
    np.concatenate([CAGES["cube"].xyz, CAGES["cube"].xyz * 0.5 + 4]),
    CAGES["cube"].face_list() + [[8 + i for i in face] for face in CAGES["cube"].face_list()])
PER_FACE = 6


def locations(mesh, seed: int = 0):
    """Random points in every face, some of them close to corners and edges: (face, corner, uv)."""
    rng = np.random.default_rng(seed)
    face = np.repeat(np.arange(mesh.n_faces), PER_FACE)
    corner = np.where(mesh.sizes[face] == 4, 0, rng.integers(0, 5040, len(face)) % mesh.sizes[face])
    uv = rng.uniform(0.02, 0.98, (len(face), 2))
    near = np.arange(len(face)) % PER_FACE == 0
    uv[near] = np.round(uv[near]) + np.where(uv[near] < 0.5, 1, -1) * rng.uniform(0.004, 0.03, (near.sum(), 2))
    return face, corner, uv


def worst(mesh, name: str, face, error: np.ndarray) -> str:
    """Sentence on the worst point."""
    at = int(error.argmax())
    f = int(face[at])
    corners = valences(mesh)[np.split(mesh.flat, np.cumsum(mesh.sizes)[:-1])[f]]
    return f"{name}: worst {error[at]:.2e} at face {f}, valences {corners.tolist()}"


def scale_of(jets: np.ndarray, size: float) -> np.ndarray:
    """What an error of each jet is relative to: the cage's size, or the derivative itself where that is larger."""
    return np.maximum(np.abs(jets).max(axis=2), size)


@pytest.mark.parametrize("name", CAGES)
def test_jets_are_those_of_deep_refinement(name, capsys):
    mesh = CAGES[name]
    face, corner, uv = locations(mesh)
    got = lib.jets(mesh, face, corner, uv)
    wanted = deep_jets(mesh, face, corner, uv)
    size = np.ptp(mesh.xyz, axis=0).max()
    error = (np.abs(got - wanted).max(axis=2) / scale_of(wanted, size)).astype(float)
    with capsys.disabled():
        print("\n  " + worst(mesh, name, face, error.max(axis=1)))
    limits = {0: 1e-12, 1: 1e-11, 2: 1e-10, 3: 1e-9}
    for at, (p, q) in enumerate(JET_ORDERS):
        assert error[:, at].max() <= limits[p + q], f"S_{'u' * p}{'v' * q}: " + worst(mesh, name, face, error[:, at])


@pytest.mark.parametrize("name", CAGES)
def test_jets_are_those_of_opensubdiv(name, capsys):
    mesh = CAGES[name]
    face, corner, uv = locations(mesh, 1)
    got = lib.jets(mesh, face, corner, uv)[:, :6]
    theirs = osd_jets(mesh, face, corner, uv).jets
    size = np.ptp(mesh.xyz, axis=0).max()
    error = np.abs(got - theirs).max(axis=2) / scale_of(theirs, size)
    with capsys.disabled():
        print("\n  " + worst(mesh, name, face, error.max(axis=1)))
    assert error[:, 0].max() <= 1e-10, worst(mesh, name, face, error[:, 0])
    assert error[:, 1:].max() <= 1e-8, worst(mesh, name, face, error[:, 1:].max(axis=1))


@pytest.mark.parametrize("name", ["mixed_quads", "frame_3", "voxels_2"])
def test_surface_is_continuous_from_face_to_face(name):
    """Positions on both sides of every edge agree, at the vertices too, and are the limit positions there."""
    mesh = CAGES[name]
    topo = topology(mesh)
    along = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    corner = np.arange(len(mesh.flat)) - topo.start[topo.face]
    size = np.ptp(mesh.xyz, axis=0).max()
    for t in (0.0, 0.3, 1.0):
        uv = along[corner] * (1 - t) + along[(corner + 1) % 4] * t
        points = lib.jets(mesh, topo.face, np.zeros_like(corner), uv)[:, 0]
        back = along[corner] * t + along[(corner + 1) % 4] * (1 - t)
        across = lib.jets(mesh, topo.face, np.zeros_like(corner), back)[:, 0][topo.twin]
        assert np.abs(points - across).max() <= 1e-12 * size
        if t == 0.0:
            for vertex in range(0, mesh.n_vertices, 11):
                limit, _ = vertex_limit(mesh, topo, vertex)
                at = np.flatnonzero(mesh.flat == vertex)
                assert np.abs(points[at] - limit).max() <= 1e-12 * size


def test_derivatives_at_an_extraordinary_vertex_are_nan_and_elsewhere_are_not():
    mesh = CAGES["star_xyz_4"]
    odd = valences(mesh) != 4
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    face = np.repeat(np.arange(mesh.n_faces), 4)
    got = lib.jets(mesh, face, np.zeros_like(face), np.tile(corner, (mesh.n_faces, 1)))
    assert np.isfinite(got[:, 0]).all()
    assert (np.isnan(got[:, 1:]).all(axis=(1, 2)) == odd[mesh.flat]).all()
    assert np.isfinite(got[~odd[mesh.flat]]).all()


@pytest.mark.parametrize("name", ["star_xyz_4", "kites_5_quads", "kites_6_quads", "kites_7_quads"])
def test_plane_jets_are_the_blend_of_deep_refinement(name, capsys):
    mesh = CAGES[name]
    face, corner, uv = locations(mesh, 2)
    got = lib.jets(mesh, face, corner, uv, "plane")
    deep = deep_jets(mesh, face, corner, uv)
    wanted = Blend(mesh.with_xyz(mesh.xyz.astype(np.longdouble))).apply(
        deep, face, uv[:, 0].astype(np.longdouble), uv[:, 1].astype(np.longdouble))
    size = np.ptp(mesh.xyz, axis=0).max()
    scale = np.maximum(scale_of(deep, size), scale_of(wanted, size))
    error = (np.abs(got - wanted).max(axis=2) / scale).astype(float)
    with capsys.disabled():
        print("\n  " + worst(mesh, name, face, error.max(axis=1)))
    limits = {0: 1e-12, 1: 1e-11, 2: 1e-10, 3: 1e-9}
    for at, (p, q) in enumerate(JET_ORDERS):
        assert error[:, at].max() <= limits[p + q], worst(mesh, name, face, error[:, at])


def test_plane_is_the_limit_surface_where_no_vertex_is_extraordinary():
    mesh = CAGES["torus_8x6"]
    face, corner, uv = locations(mesh, 3)
    assert np.array_equal(lib.jets(mesh, face, corner, uv, "plane"), lib.jets(mesh, face, corner, uv, "limit"))


def test_third_derivatives_are_the_differences_of_second_ones():
    """The four-point difference is exact for bicubics; all five points lie between the same knots."""
    mesh = CAGES["mixed_quads"]
    face = np.arange(mesh.n_faces)
    zero = np.zeros_like(face)
    at = np.tile([[0.61, 0.57]], (mesh.n_faces, 1))
    jets = lib.jets(mesh, face, zero, at)
    h = 0.02
    for step, columns in (((h, 0), [6, 7, 8]), ((0, h), [7, 8, 9])):
        second = {k: lib.jets(mesh, face, zero, at + k * np.array(step))[:, 3:6] for k in (-2, -1, 1, 2)}
        slope = (8 * (second[1] - second[-1]) - (second[2] - second[-2])) / (12 * h)
        assert np.abs(slope - jets[:, columns]).max() <= 1e-10 * np.abs(jets[:, 6:]).max()


@pytest.mark.parametrize("name", CAGES)
def test_refinement_is_the_textbook_one(name):
    mesh = CAGES[name]
    got, wanted = lib.refine(mesh), refine(mesh)
    assert got.n_faces == wanted.n_faces and got.n_vertices == wanted.n_vertices
    n = mesh.n_vertices
    n_edges = len(topology(mesh).ends)
    assert np.abs(got.xyz[:n] - wanted.xyz[:n]).max() <= 1e-14 * np.abs(mesh.xyz).max()
    assert np.abs(got.xyz[n + n_edges:] - wanted.xyz[n + n_edges:]).max() <= 1e-14 * np.abs(mesh.xyz).max()
    # child k of a face is [corner k, edge, face, edge before]; ours are turned for quads
    k = np.arange(len(mesh.flat)) - topology(mesh).start[topology(mesh).face]
    turn = np.where(np.repeat(mesh.sizes, mesh.sizes) == 4, k, 0)
    ours = np.take_along_axis(wanted.flat.reshape(-1, 4), (np.arange(4)[None] + turn[:, None]) % 4, axis=1)
    theirs = got.flat.reshape(-1, 4)
    assert np.array_equal(theirs[:, 0], mesh.flat)
    assert np.abs(got.xyz[theirs] - wanted.xyz[ours]).max() <= 1e-14 * np.abs(mesh.xyz).max()
    assert np.array_equal(theirs[:, 2], n + n_edges + np.repeat(np.arange(mesh.n_faces), mesh.sizes))

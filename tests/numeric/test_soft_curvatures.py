# SPDX-License-Identifier: GPL-3.0-or-later
"""Principal curvatures that springs draw (curvopt_through.weights below 1): the springs' energy is its definition, by OpenSubdiv, on
every level; forces balance, by B-splines; curvatures tend to the wanted ones as the weight goes to 1; size and pose do not matter;
what is refused, by number. With CURVOPT_LONG=1 more cages and energies."""
from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

import lib
import test_through as points
import test_through_curvatures as curved
import test_through_frames as frames
import test_through_springs as springs
from ccref import Mesh
from nets import read_obj, torus_cage, write_obj
from osd import osd_jets

NONE, FREE_SPACING = 1, 2
HELD, LINE, PLANE, FREE = range(4)
NAN = float("nan")
unit = frames.unit


def turned(tensors: np.ndarray, normals: np.ndarray, to: np.ndarray) -> np.ndarray:
    """Tensors [n, 3, 3] in planes across `normals`, turned to planes across `to` by the least turn: of the axis across both, by
    Rodrigues' formula."""
    goal = to * np.sign((normals * to).sum(1))[:, None]
    out = []
    for tensor, a, b in zip(tensors, normals, goal):
        x, y, z = np.cross(a, b)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + cross + cross @ cross / (1 + a @ b)
        out.append(turn @ tensor @ turn.T)
    return np.array(out)


def off(jets: np.ndarray, wanted: curved.Wishes) -> np.ndarray:
    """Frobenius norms [n] of second forms less those that are wanted."""
    normals, found = curved.forms(jets)
    wish = curved.tensors(wanted.normals, wanted.directions, wanted.k)
    return np.sqrt(((found - turned(wish, wanted.normals, normals)) ** 2).sum((1, 2)))


def soft(wanted: curved.Wishes, weights: np.ndarray) -> lib.Through:
    through = dict(**wanted.where.fields(), freedom=wanted.freedom, directions=wanted.normals, places=wanted.places,
                   normals=wanted.normals, curvatures=wanted.k, curvature_directions=wanted.directions)
    return lib.through(**through, weights=weights)


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("seed, refined, energies", curved.CAGES + curved.MORE if lib.LONG else curved.CAGES[::2])
def test_the_springs_energy_is_its_definition(seed, refined, energies, levels, capsys):
    wanted = curved.Wishes(seed, refined)
    n, size, energy = wanted.where.n, springs.radius(wanted.mesh), {"w": "willmore", "m": "mvs"}[energies[levels - 1]]
    weights = np.random.default_rng(seed).uniform(0.2, 0.8, n)
    result = lib.minimize(wanted.mesh, energy, levels=levels, decrement_tolerance=1e-12, through=soft(wanted, weights))
    jets, first = curved.look(wanted.where, result.mesh, levels), wanted.mesh
    for _ in range(levels - 1):
        first = lib.refine(first)
    before = curved.look(wanted.where, first, levels)
    k = springs.STIFFNESS[energy] * weights / (1 - weights)
    far = np.array([springs.projector(f, d) @ np.where(f == FREE, 0, x) for f, d, x in
                    zip(wanted.freedom, wanted.normals, np.where(wanted.freedom[:, None] == FREE, 0, jets[:, 0] - wanted.places))]) / size
    tangents = np.array([springs.orthonormal(a) @ b for a, b in zip(before[:, 1:3], jets[:, 1:3])])
    slope = np.einsum("nkc,nc->nk", tangents, wanted.normals)
    bent = off(jets, wanted)
    total = springs.sum_of(k, far, slope) + (k * (size * bent) ** 2).sum() / 2
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels, {energy}, {wanted.where.n_v} vertices and {len(wanted.where.faces)} places: "
              f"{result.verdict}, {result.summary.seconds:.2f} s, springs {total:.4g}, by curvatures {(k * (size * bent) ** 2).sum() / 2:.4g}, "
              f"beside {result.summary.end.objective:.4g}; {abs(result.summary.spring_energy / total - 1):.1e}")
    assert result.verdict == "minimum"
    assert abs(result.summary.spring_energy - total) <= 1e-6 * total


# ------------------------------------------------------------------------------------------------------- forces --

class Torus:
    """Three places of a shaken torus by B-splines: rows [n, 6, n_vertices], and what springs are to add by them."""

    def __init__(self, energy: str = "mvs"):
        m, n = 12, 8
        mesh = torus_cage(m, n, 0.4)
        self.mesh = points.mesh_from_faces(mesh.xyz + 0.02 * np.random.default_rng(3).uniform(-1, 1, mesh.xyz.shape), mesh.face_list())
        self.vertex, faces, uv = 40, [10, 60], [[0.3, 0.6], [0.7, 0.2], [0, 0]]
        face = next(f for f, corners in enumerate(self.mesh.face_list()) if corners[0] == self.vertex)
        self.rows = np.array([curved.rows_on_torus(self.mesh, m, n, f, *at) for f, at in zip([*faces, face], uv)])
        self.size = springs.radius(self.mesh)
        jets = self.rows @ self.mesh.xyz
        self.places = jets[:, 0]
        self.tangents = np.array([springs.orthonormal(t) @ r for t, r in zip(jets[:, 1:3], self.rows[:, 1:3])])
        self.normals = unit(curved.forms(jets)[0] + 0.05)
        self.k, self.directions = np.array([[2.5, 0.5], [1.5, -1], [3, 1]]), unit(np.cross(self.normals, [0.3, 0.2, 0.9]))
        self.weights = np.array([0.3, 0.5, 0.7])
        self.firmness = springs.STIFFNESS[energy] * self.weights / (1 - self.weights)
        self.fields = dict(vertices=[-1, -1, self.vertex], faces=[*faces, 0], uv=uv)

    def springs(self, xyz: np.ndarray, bent: bool = True) -> float:
        """What springs add at a cage; without those of curvatures."""
        slope = np.einsum("nkv,vc,nc->nk", self.tangents, xyz, self.normals)
        far = (self.rows[:, 0] @ xyz - self.places) / self.size
        return springs.sum_of(self.firmness, far, slope) + bent * (self.firmness * (self.size * off(self.rows @ xyz, self)) ** 2).sum() / 2

    def slope(self, xyz: np.ndarray, **which) -> np.ndarray:
        """Its gradient, by central differences with an error of order 4."""
        out, h = np.zeros_like(xyz), 1e-4
        for i in np.ndindex(*xyz.shape):
            step = np.zeros_like(xyz)
            step[i] = h
            a, b, c, d = (self.springs(xyz + k * step, **which) for k in (-2, -1, 1, 2))
            out[i] = (a - 8 * b + 8 * c - d) / (12 * h)
        return out


def run(torus: Torus, **fields) -> lib.Result:
    """MVS, for which curvatures cost energy on any grid."""
    return lib.minimize(torus.mesh, "mvs", levels=1, symmetry=NONE, spacing=FREE_SPACING, tolerance=1e-7, decrement_tolerance=1e-13,
                        through=lib.through(**torus.fields, normals=torus.normals, curvatures=torus.k,
                                            curvature_directions=torus.directions, **fields))


def test_forces_balance(capsys):
    """At the end the energy's gradient, by the public evaluation, is what springs draw with, at every vertex of the cage."""
    torus = Torus()
    result = run(torus, weights=torus.weights)
    found = result.mesh.xyz
    _, gradient = lib.Problem(torus.mesh, lib.options("mvs", tolerance=1e-7)).evaluate(found, gradient=True)
    pull = torus.slope(found)
    without = torus.slope(found, bent=False)
    share, alone = (np.linalg.norm(gradient + p) / np.linalg.norm(pull) for p in (pull, without))
    with capsys.disabled():
        print(f"\n  {result.verdict}, springs {result.summary.spring_energy:.4g} beside {result.summary.end.objective:.4g}; of "
              f"their forces {share:.1e} is left, without those of curvatures {alone:.1e}")
    assert result.verdict == "minimum" and share <= 1e-5 and alone > 1e-2
    assert abs(result.summary.spring_energy - torus.springs(found)) <= 1e-9 * result.summary.spring_energy


# ------------------------------------------------------------------------------------------------------- limits --

def test_a_large_weight_is_near_what_is_wanted():
    torus = Torus("willmore")
    result = lib.minimize(torus.mesh, levels=1, symmetry=NONE, through=lib.through(
        **torus.fields, normals=torus.normals, curvatures=torus.k, curvature_directions=torus.directions, weights=np.full(3, 0.999)))
    jets = torus.rows @ result.mesh.xyz
    assert result.verdict == "minimum" and off(jets, torus).max() < 1e-3
    assert np.linalg.norm(np.cross(curved.forms(jets)[0], torus.normals), axis=1).max() < 1e-3


@pytest.mark.skipif(not lib.LONG, reason="a minute: CURVOPT_LONG=1")
def test_a_large_weight_tends_to_what_is_wanted(capsys):
    """Curvatures and normals are off by a part that falls like 1 - w."""
    torus, found = Torus(), []
    for softness in (1e-2, 1e-3, 1e-4):
        result = run(torus, weights=np.full(3, 1 - softness))
        jets = torus.rows @ result.mesh.xyz
        normals, tensors = curved.forms(jets)
        wrong = np.linalg.norm(tensors - curved.tensors(torus.normals, torus.directions, torus.k), axis=(1, 2)).max()
        found.append((wrong, np.linalg.norm(np.cross(normals, torus.normals), axis=1).max(), result.summary.end.objective))
        assert result.verdict == "minimum"
    exact = run(torus)
    with capsys.disabled():
        print(f"\n  curvatures and normals are off by, and energy (exact {exact.summary.end.objective:.8g}):\n{np.array(found)}")
    ratios = np.array(found[:-1])[:, :2] / np.array(found[1:])[:, :2]
    assert (ratios > 8.5).all() and (ratios < 11).all() and found[-1][0] < 1e-2
    assert found[-1][2] < exact.summary.end.objective, "tangents that are held as vectors cost energy"


def test_weights_next_to_1_hold_exactly_and_0_does_not_hold():
    mesh, torus = torus_cage(12, 8, 0.4), Torus()
    fields = dict(normals=torus.normals, curvatures=torus.k, curvature_directions=torus.directions)
    exact, next_to_1, none = (lib.minimize(mesh, levels=1, symmetry=NONE, through=lib.through(**torus.fields, **fields, weights=np.full(3, w)))
                              for w in (1, 1 - 1e-12, 0))
    free = lib.minimize(mesh, levels=1, symmetry=NONE)
    assert np.array_equal(exact.mesh.xyz, next_to_1.mesh.xyz) and np.array_equal(free.mesh.xyz, none.mesh.xyz)


def test_size_and_pose_do_not_matter():
    """Springs add the same to a surface that is larger, elsewhere and turned, and so are the curvatures."""
    torus, found = Torus(), []
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    for size, pose, shift in ((1, np.eye(3), 0), (1000, turn, 70)):
        cage = points.mesh_from_faces(size * torus.mesh.xyz @ pose.T + shift, torus.mesh.face_list())
        result = lib.minimize(cage, "mvs", levels=1, symmetry=NONE, decrement_tolerance=1e-11, through=lib.through(
            **torus.fields, normals=torus.normals @ pose.T, curvatures=torus.k / size, curvature_directions=torus.directions @ pose.T,
            weights=torus.weights))
        found.append((result.summary.spring_energy, result.summary.end.objective))
        assert result.verdict == "minimum"
    assert np.allclose(*np.sum(found, axis=1), rtol=1e-4)  # what is minimized
    assert np.allclose(*found, rtol=5e-3)  # paths differ by rounding, and valleys are flat


def test_what_contradicts_ends_between(capsys):
    """One place of a ball to which four curvatures are said: none is refused, and at large weights it is their mean."""
    mesh = points.shaken_cube()
    mesh = lib.refine(lib.refine(mesh))
    jets = osd_jets(mesh, [20], [0], [[0.4, 0.3]]).jets
    normals, now = curved.forms(jets)
    k, firmness = np.array([0.5, 1, 1.5, 2]) * np.abs(now).max(), np.array([1, 2, 3, 4]) * 1e5
    result = lib.minimize(mesh, levels=1, symmetry=NONE, through=lib.through(
        faces=[20] * 4, uv=[[0.4, 0.3]] * 4, normals=np.repeat(normals, 4, axis=0), curvatures=np.stack([k, k], 1),
        weights=firmness / (1 + firmness)))
    normals, found = curved.forms(osd_jets(result.mesh, [20], [0], [[0.4, 0.3]]).jets)
    mean = (k * firmness).sum() / firmness.sum()
    with capsys.disabled():
        print(f"\n  {result.verdict}: {np.linalg.eigvalsh(found[0])[[0, 2]] / mean} of the mean")
    assert result.verdict == "minimum"
    assert np.abs(found[0] - mean * (np.eye(3) - np.outer(normals[0], normals[0]))).max() <= 1e-3 * mean


def test_there_may_be_more_than_freedom():
    """Curvatures in every face of a torus, next to each other: exactly they are refused."""
    torus = torus_cage(8, 5, 0.4)
    faces = np.arange(len(torus.face_list()))
    jets = osd_jets(torus, faces, 0 * faces, [[0.5, 0.5]] * len(faces)).jets
    normals, now = curved.forms(jets)
    fields = dict(faces=faces, uv=[[0.5, 0.5]] * len(faces), normals=normals, curvatures=[[1.5, 1.5]] * len(faces))
    result = lib.minimize(torus, levels=1, through=lib.through(**fields, weights=np.full(len(faces), 0.5)))
    found = curved.forms(osd_jets(result.mesh, faces, 0 * faces, [[0.5, 0.5]] * len(faces)).jets)[1]
    assert result.verdict == "minimum" and result.summary.spring_energy > 1
    wish = 1.5 * (np.eye(3) - normals[:, :, None] * normals[:, None])
    assert ((found - wish) ** 2).sum() < ((now - wish) ** 2).sum()
    with pytest.raises(lib.CurvoptError, match="entry [0-9]+"):
        lib.minimize(torus, levels=1, through=lib.through(**fields))


def test_one_of_two_pieces_is_drawn():
    one, two = torus_cage(8, 5, 0.4), torus_cage(10, 6, 0.4)
    faces = one.face_list() + [[v + one.n_vertices for v in face] for face in two.face_list()]
    both = points.mesh_from_faces(np.vstack([one.xyz, two.xyz + [4, 0, 0]]), faces)
    jets = osd_jets(two, [7], [0], [[0.3, 0.6]]).jets
    fields = dict(uv=[[0.3, 0.6]], normals=curved.forms(jets)[0], curvatures=[[0.25, 2]], curvature_directions=unit(jets[:, 1]), weights=[0.5])
    alone = lib.minimize(two, levels=1, through=lib.through(faces=[7], **fields))
    result = lib.minimize(both, levels=1, through=lib.through(faces=[len(one.face_list()) + 7], **fields))
    assert result.verdict == alone.verdict == "minimum" and alone.summary.spring_energy > 1e-4
    assert abs(result.summary.spring_energy - alone.summary.spring_energy) <= 1e-3 * alone.summary.spring_energy


# --------------------------------------------------------------------------------------------- what is refused --

@pytest.mark.parametrize("weight", [1, 0.5])
@pytest.mark.parametrize("k", [1e20, -1e200, 1.7e308])
def test_curvatures_that_no_surface_has_are_refused_by_number(k, weight):
    with pytest.raises(lib.CurvoptError, match="entry 1 has curvatures that are too large: a radius is less than 1e-06 of the surface's size"):
        lib.minimize(torus_cage(8, 5, 0.4), levels=1, through=lib.through(
            [3, 5], normals=[[0, 0, 1]] * 2, curvatures=[[NAN, NAN], [k, k]], weights=[1, weight]))


@pytest.mark.parametrize("weight", [1, 0.5])
@pytest.mark.parametrize("far", [1e10, -1e300])
def test_places_beyond_all_digits_are_refused_by_number(far, weight):
    with pytest.raises(lib.CurvoptError, match="entry 1 has the place 0 0 .*, which is more than 1e\\+09 times the surface's size away"):
        lib.minimize(torus_cage(8, 5, 0.4), levels=1, through=lib.through([3, 5], places=[[NAN] * 3, [0, 0, far]], weights=[1, weight]))


def test_chosen_mirror_planes_are_refused():
    with pytest.raises(lib.CurvoptError, match="curvatures that the surface goes through cannot be had with mirror planes"):
        lib.minimize(torus_cage(8, 4, 0.4), levels=1, symmetry=4, symmetry_planes=1,
                     through=lib.through([3], normals=[[0, 0, 1]], curvatures=[[1, 1]], weights=[0.5]))


# ------------------------------------------------------------------------------------------ the command line --

def test_the_command_line_draws_them(tmp_path):
    """The same cage, bit by bit, as by the library; the springs' energy is in the report."""
    mesh: Mesh = torus_cage(8, 5, 0.4)
    cage, out, report = tmp_path / "cage.obj", tmp_path / "out.obj", tmp_path / "report.json"
    write_obj(cage, mesh)
    entries = [{"vertex": 11, "normal": [0, 0.25, 1], "curvatures": [0.5, 2], "curvature_direction": [1, 0, 0], "weight": 0.75}]
    subprocess.run([lib.BUILD / "curvopt", "minimize", cage, "-o", out, "--levels", "2", "--through", "-", "--json", report, "--quiet"],
                   input=json.dumps(entries), text=True, check=True)
    result = lib.minimize(mesh, levels=2, through=lib.through(
        [11], freedom=[FREE], normals=[[0, 0.25, 1]], curvatures=[[0.5, 2]], curvature_directions=[[1, 0, 0]], weights=[0.75]))
    assert np.array_equal(read_obj(out).xyz, result.mesh.xyz)
    assert json.loads(report.read_text())["spring_energy"] == result.summary.spring_energy > 0

# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages of several pieces: each ends as if it were alone, where it was and as large as it was. Alone is another run of the same
library, of a mesh that never met the others; figures of all together are those of an evaluation of all together."""
from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import cube_grid, perturbed, torus_cage

AUTO, NONE, ROTATIONS, KEEP, PLANES = range(5)
UNKNOWN, MINIMUM, SADDLE, NOT_STATIONARY = range(4)
CONVERGED, STALLED, LIMIT, CANCELLED, UNRESOLVED, SETTLED = range(6)


class Joined(NamedTuple):
    """Pieces as one mesh: their vertices and faces are mixed, but keep their order."""

    mesh: Mesh
    vertices: list[np.ndarray]  # of each piece
    faces: list[np.ndarray]


def mixed(random: np.random.Generator, sizes: list[int]) -> list[np.ndarray]:
    """Numbers 0 to sum(sizes) dealt out at random, ascending in each hand; the first ones go round."""
    first = np.arange(len(sizes))
    owner = np.concatenate([first, random.permutation(np.repeat(first, np.array(sizes) - 1))])
    return [np.flatnonzero(owner == k) for k in range(len(sizes))]


def join(pieces: list[Mesh], seed: int = 0) -> Joined:
    random = np.random.default_rng(seed)
    vertices = mixed(random, [piece.n_vertices for piece in pieces])
    faces = mixed(random, [piece.n_faces for piece in pieces])
    xyz, face_list = np.empty((sum(map(len, vertices)), 3)), [[]] * sum(map(len, faces))
    for piece, to, at in zip(pieces, vertices, faces):
        xyz[to] = piece.xyz
        for face, number in zip(piece.face_list(), at):
            face_list[number] = [int(to[v]) for v in face]
    return Joined(mesh_from_faces(xyz, face_list), vertices, faces)


def corners_of(joined: Joined, number: int, result: Mesh) -> np.ndarray:
    """Places of the corners of a piece's faces in a result, in the order of its own faces [.., 3]."""
    sizes = np.array([len(face) for face in joined.mesh.face_list()])
    if result.n_faces == len(sizes):
        starts, counts = np.concatenate([[0], np.cumsum(sizes)[:-1]]), sizes
    else:  # children of a face follow each other
        per_corner = 4 * result.n_faces // sizes.sum()
        starts, counts = per_corner * np.concatenate([[0], np.cumsum(sizes)[:-1]]), per_corner * sizes
    at = np.concatenate([np.arange(starts[f], starts[f] + counts[f]) for f in joined.faces[number]])
    return result.xyz[result.flat[at]]


def moved(mesh: Mesh, scale: float, by: tuple[float, float, float]) -> Mesh:
    return replace(mesh, xyz=scale * mesh.xyz + by)


def cage_of(p: lib.Progress) -> np.ndarray:
    """[n_vertices, 3] what a callback sees."""
    return np.ctypeslib.as_array(p.xyz, (3 * p.n_vertices,)).reshape(-1, 3).copy()


def sheet() -> Mesh:
    """A wavy sheet of 4 by 4 faces, whose boundary is held."""
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0), indexing="ij")
    xyz = np.stack([x, y, 0.4 * np.sin(2 * x + y)], axis=2).reshape(-1, 3)
    return mesh_from_faces(xyz, [[5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1] for i in range(4) for j in range(4)])


def uneven() -> list[Mesh]:
    return [moved(perturbed(cube_grid(2), 0.2, 3), 1, (4, 0, 0)), sheet(),
            moved(perturbed(torus_cage(6, 4, 0.4), 0.1, 5), 0.2, (0, 0, 3))]


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("energy", ["willmore", "mvs"])
def test_each_piece_ends_as_if_it_were_alone(energy: str, levels: int):
    """To the last bit where objectives just add up; third-order ones of pieces are weighed by the whole's area."""
    pieces = uneven()
    joined = join(pieces)
    exact = {} if energy == "willmore" else {"tolerance": 1e-7}  # rounding may choose between coarser rules
    whole = lib.minimize(joined.mesh, energy, levels=levels, **exact)
    alone = [lib.minimize(piece, energy, levels=levels, **exact) for piece in pieces]
    for k, one in enumerate(alone):
        ours, theirs = corners_of(joined, k, whole.mesh), one.mesh.xyz[one.mesh.flat]
        assert np.abs(ours - theirs).max() <= (0 if energy == "willmore" else 1e-6)
    assert whole.summary.verdict == MINIMUM == max(one.summary.verdict for one in alone)
    assert whole.summary.n_levels == levels
    for i in range(levels):
        assert whole.levels[i].iterations == sum(one.levels[i].iterations for one in alone)
        assert whole.levels[i].n_vertices == sum(one.levels[i].n_vertices for one in alone)


@pytest.mark.parametrize("weights", ["willmore", "mvs", {"willmore": 1.0, "mvs_cross": 0.01, "area": 0.3}])
def test_figures_are_those_of_all_together(weights):
    joined = join(uneven())
    got = lib.minimize(joined.mesh, weights, levels=2)
    for cage, ours in ((joined.mesh, got.summary.start), (got.mesh, got.summary.end)):
        theirs = lib.evaluate(cage, weights, tolerance=1e-5)
        assert abs(ours.objective - theirs.objective) <= ours.objective_error + theirs.objective_error
        for i in np.flatnonzero(np.isfinite(theirs.term)):
            assert abs(ours.term[i] - theirs.term[i]) <= ours.term_error[i] + theirs.term_error[i]
        assert ours.area == pytest.approx(theirs.area, rel=1e-4)
        assert ours.total_mean_curvature == pytest.approx(theirs.total_mean_curvature, rel=1e-4)
        assert np.isnan(ours.volume)
    assert got.levels[1].energy == got.summary.end.objective


def test_closed_pieces_keep_places_and_sizes():
    """Results are spheres: their centres are those of their pieces, and their areas, too."""
    pieces = [moved(perturbed(cube_grid(2), 0.15, seed), scale, (5 * seed, 0, 0)) for seed, scale in ((0, 1), (1, 0.3))]
    joined = join(pieces)
    got = lib.minimize(joined.mesh, levels=2)
    for k, piece in enumerate(pieces):
        points = corners_of(joined, k, got.mesh)
        assert np.linalg.norm(points.mean(0) - piece.xyz.mean(0)) < 0.05 * np.ptp(piece.xyz)
        area = 4 * np.pi * np.linalg.norm(points - points.mean(0), axis=1).mean() ** 2
        assert area == pytest.approx(lib.evaluate(piece).area, rel=0.12)
    assert got.summary.end.volume == pytest.approx(lib.evaluate(got.mesh).volume, rel=1e-4)


def test_wishes_go_to_their_pieces():
    """Pins with places, points that the surface goes through, a chain, and a hole: of each piece as if it were alone."""
    pieces = [torus_cage(8, 5, 0.4), moved(torus_cage(8, 5, 0.4), 1.5, (4, 0, 0)), moved(cube_grid(3), 1, (0, 5, 0)), sheet()]
    joined = join(pieces, 1)
    torus, other, cube, cloth = joined.vertices
    place = pieces[0].xyz[7] + [0, 0, 0.1]
    curve = moved(pieces[1], 1.05, (-0.2, 0, 0)).xyz[[0, 1, 2, 3]]
    entry = pieces[1].xyz[20] * 1.02

    def run(mesh: Mesh, pin=None, goes=None, hole=None) -> lib.Result:
        return lib.minimize(mesh, symmetry=NONE, levels=2, **({"constraints": pin} if pin else {}),
                            **({"through": goes} if goes else {}), **(lib.holes([hole]) if hole is not None else {}))

    places = np.array([place, [np.nan] * 3])
    whole = run(joined.mesh, lib.constraints([torus[7], torus[30]], places=places),
                lib.through([other[20], cube[5]], freedom=[0, 0], places=[entry, [np.nan] * 3],
                            chains=[lib.chain(other[[0, 1, 2, 3]], curve)]), joined.faces[3][5])
    alone = [run(pieces[0], lib.constraints([7, 30], places=places)),
             run(pieces[1], None, lib.through([20], freedom=[0], places=[entry], chains=[lib.chain([0, 1, 2, 3], curve)])),
             run(pieces[2], None, lib.through([5], freedom=[0])), run(pieces[3], hole=5)]
    for k, one in enumerate(alone):
        assert np.array_equal(corners_of(joined, k, whole.mesh), one.mesh.xyz[one.mesh.flat])
    assert whole.summary.n_left_out == 1


def test_a_piece_that_is_held_stays_and_counts():
    pieces = [perturbed(cube_grid(2), 0.2, 3), moved(cube_grid(2), 1, (5, 0, 0))]
    joined = join(pieces)
    got = lib.minimize(joined.mesh, levels=1, constraints=lib.constraints(joined.vertices[1]))
    assert np.array_equal(got.mesh.xyz[joined.vertices[1]], pieces[1].xyz)
    free = lib.minimize(pieces[0], levels=1)
    assert got.summary.end.objective == pytest.approx(free.summary.end.objective + lib.evaluate(pieces[1]).objective, rel=1e-4)
    assert got.summary.verdict == MINIMUM


def test_progress_is_of_all_pieces():
    pieces = uneven()
    joined = join(pieces)
    seen = []

    def progress(p) -> bool:
        seen.append((p.level, p.iteration, p.energy, p.start_energy, cage_of(p)))
        return False

    got = lib.minimize(joined.mesh, levels=2, progress=progress)
    levels, iterations, energies, starts, _ = zip(*seen)
    assert set(starts) == {got.summary.start.objective}
    assert energies[0] == pytest.approx(starts[0], rel=1e-4)
    assert list(levels) == sorted(levels) and max(levels) == 2
    for level in (1, 2):
        counts = [i for at, i in zip(levels, iterations) if at == level]
        assert counts == sorted(counts) and counts[-1] == got.levels[level - 1].iterations
        assert all(len(xyz) == got.levels[level - 1].n_vertices for at, *_, xyz in seen if at == level)
    assert np.array_equal(seen[0][4][joined.vertices[1]], pieces[1].xyz)  # it waits for the first one
    assert energies[-1] == pytest.approx(got.summary.end.objective, rel=1e-4)


def test_a_run_that_is_cancelled_keeps_what_it_has():
    pieces = uneven()
    joined = join(pieces)
    seen = []
    alone = lib.minimize(pieces[0], levels=2, progress=lambda p: seen.append(cage_of(p)) if p.level == 1 else False)
    got = lib.minimize(joined.mesh, levels=2, progress=lambda p: p.iteration > alone.levels[0].iterations)
    assert got.summary.stop == CANCELLED and got.summary.n_levels == 1 and got.summary.verdict == UNKNOWN
    assert np.abs(got.mesh.xyz[joined.vertices[0]] - seen[-1]).max() < 1e-12
    assert np.array_equal(got.mesh.xyz[joined.vertices[2]], pieces[2].xyz)
    assert got.summary.end.objective == pytest.approx(lib.evaluate(got.mesh).objective, rel=1e-3)


def test_images_of_a_mirror_stay_images():
    """A pair on both sides of a plane, and a piece that the plane halves."""
    left = moved(perturbed(cube_grid(2), 0.2, 8), 1, (-4, 0.5, 0))
    right = mesh_from_faces(left.xyz * [-1, 1, 1], [face[::-1] for face in left.face_list()])
    middle = perturbed(cube_grid(2), 0.15, 2)
    half = middle.xyz.copy()
    base = cube_grid(2).xyz
    partner = [int(np.argmin(np.abs(base - v * [-1, 1, 1]).sum(1))) for v in base]
    middle = replace(middle, xyz=(half + half[partner] * [-1, 1, 1]) / 2)
    joined = join([left, middle, right])
    for symmetry, planes in ((PLANES, 1), (KEEP, 0), (AUTO, 0)):
        got = lib.minimize(joined.mesh, levels=2, symmetry=symmetry, symmetry_planes=planes)
        a, b = corners_of(joined, 0, got.mesh), corners_of(joined, 2, got.mesh)
        a = a[np.lexsort(a.round(9).T)]
        b = b * [-1, 1, 1]
        b = b[np.lexsort(b.round(9).T)]
        assert np.abs(a - b).max() < 1e-9, symmetry
        alone = lib.minimize(left, levels=2)
        assert np.abs(corners_of(joined, 0, got.mesh).mean(0) - alone.mesh.xyz[alone.mesh.flat].mean(0)).max() < 1e-3


def test_each_piece_keeps_its_volume():
    pieces = [moved(perturbed(cube_grid(2), 0.15, 4), 1, (3, 0, 0)), perturbed(torus_cage(8, 5, 0.3), 0.05, 1)]
    joined = join(pieces)
    got = lib.minimize(joined.mesh, levels=1, hold={"volume": "keep", "area": "keep"})
    for number, piece in enumerate(pieces):
        before = lib.evaluate(piece, tolerance=1e-6)
        after = lib.evaluate(replace(piece, xyz=got.mesh.xyz[joined.vertices[number]]), tolerance=1e-6)
        assert after.volume == pytest.approx(before.volume, rel=1e-4)
        assert after.area == pytest.approx(before.area, rel=1e-4)
    assert np.isnan(got.summary.multiplier[0])  # there are two


def test_what_ties_pieces_together_is_minimized_together():
    joined = join([perturbed(cube_grid(2), 0.1, 4), moved(perturbed(cube_grid(2), 0.1, 1), 1, (5, 0, 0))])
    reduced = lib.evaluate(joined.mesh)
    share = reduced.volume / (reduced.area ** 1.5 / (6 * np.sqrt(np.pi)))
    got = lib.minimize(joined.mesh, levels=1, hold={"volume": ("reduced", 0.98 * share)})
    after = lib.evaluate(got.mesh)
    assert after.volume / (after.area ** 1.5 / (6 * np.sqrt(np.pi))) == pytest.approx(0.98 * share, rel=1e-3)


def mirrored(mesh: Mesh, axis: int = 0) -> Mesh:
    sign = np.where(np.arange(3) == axis, -1.0, 1.0)
    return mesh_from_faces(mesh.xyz * sign, [face[::-1] for face in mesh.face_list()])


def test_far_pieces_that_differ_are_no_copies():
    """By their distance they are images of each other to 1e-5; by their own size they differ by 3e-4."""
    one = moved(perturbed(cube_grid(2), 0.2, 3), 1, (300, 0, 0))
    other = mirrored(one)
    other = replace(other, xyz=other.xyz + 3e-4 * np.random.default_rng(1).normal(size=other.xyz.shape))
    joined = join([one, other])
    got = lib.minimize(joined.mesh, levels=1, symmetry=KEEP, max_iterations=0)
    assert np.array_equal(got.mesh.xyz[joined.vertices[1]], lib.minimize(other, levels=1, max_iterations=0).mesh.xyz)


def test_images_are_where_they_were_when_a_held_piece_is_put_elsewhere():
    """That alone makes the cage symmetric; the input's centroid is not on the plane."""
    one = moved(perturbed(cube_grid(2), 0.2, 3), 1, (4, 0.3, 0))
    between = moved(cube_grid(2), 1, (0, 0, 4))
    joined = join([one, moved(between, 1, (1.5, 0, 0)), mirrored(one)])
    got = lib.minimize(joined.mesh, levels=1, symmetry=KEEP, constraints=lib.constraints(joined.vertices[1], places=between.xyz))
    alone = lib.minimize(one, levels=1, symmetry=KEEP)
    assert np.abs(got.mesh.xyz[joined.vertices[2]] - alone.mesh.xyz * [-1, 1, 1]).max() < 1e-9
    assert np.array_equal(got.mesh.xyz[joined.vertices[1]], between.xyz)


def test_levels_have_the_energy_of_a_held_piece_at_its_places():
    free, held = perturbed(cube_grid(2), 0.2, 3), moved(cube_grid(2), 1, (5, 0, 0))
    places = held.xyz * [1, 1, 2]
    joined = join([free, held])
    seen = []
    got = lib.minimize(joined.mesh, levels=2, constraints=lib.constraints(joined.vertices[1], places=places),
                       progress=lambda p: seen.append(p.energy))
    alone, beside = lib.minimize(free, levels=2), lib.evaluate(replace(held, xyz=places)).objective
    for ours, theirs in zip(got.levels, alone.levels):
        assert ours.energy == pytest.approx(theirs.energy + beside, rel=1e-4)
    assert seen[-1] == pytest.approx(got.summary.end.objective, rel=1e-4)


def test_what_levels_brought_is_of_one_kind_of_sum():
    """The last level's energy is of an evaluation of all, which differs from the sum of the pieces'; steps between levels do
    not have that in them. Either is as exact as its quadrature claims."""
    pieces = [moved(perturbed(cube_grid(2), 0.1, 1), 1, (5, 0, 0)), sheet(),
              moved(torus_cage(6, 4, 0.4), 0.7, (0, 0, 4))]
    got = lib.minimize(join(pieces).mesh, "mvs_cross", levels=3)
    alone = [lib.minimize(piece, "mvs_cross", levels=3).summary.end for piece in pieces]
    area = sum(end.area for end in alone)
    energies = [report.energy for report in got.levels[:2]] + [sum(end.objective * area / end.area for end in alone)]
    steps = np.abs(np.diff(energies))
    assert steps[1] < 0.6 * steps[0]
    claimed = got.summary.end.objective_error + sum(end.objective_error * area / end.area for end in alone)
    assert got.summary.discretization_error == pytest.approx(1.5 * steps[1], rel=0, abs=1.5 * claimed)


def test_an_older_struct_of_what_the_surface_goes_through():
    """Without the members from `toward` on, where there is something else."""
    pieces = [perturbed(cube_grid(2), 0.2, 3), moved(cube_grid(2), 1, (5, 0, 0))]
    joined = join(pieces)
    goes = lib.through([joined.vertices[1][3]])
    goes.struct_size = lib.Through.toward.offset
    goes.toward = goes.weights = goes.chains = goes.chain_weights = 1
    goes.n_chains = 1 << 30
    got = lib.minimize(joined.mesh, levels=1, through=goes)
    alone = lib.minimize(pieces[1], levels=1, through=lib.through([3]))
    assert np.array_equal(got.mesh.xyz[joined.vertices[1]], alone.mesh.xyz)


def test_a_multiplier_that_only_one_piece_has_is_that():
    joined = join([perturbed(cube_grid(2), 0.15, 4), moved(cube_grid(2), 1, (5, 0, 0))])
    got = lib.minimize(joined.mesh, levels=1, hold={"volume": "keep", "area": "keep"}, constraints=lib.constraints(joined.vertices[1]))
    alone = lib.minimize(perturbed(cube_grid(2), 0.15, 4), levels=1, hold={"volume": "keep", "area": "keep"})
    assert got.summary.multiplier[0] == alone.summary.multiplier[0] != 0


def test_spontaneous_curvature_counts_by_the_normals_of_all():
    """A shell: normals of the inner piece point into the cavity, for which c0 has the other sign."""
    outer, inside = perturbed(cube_grid(2), 0.1, 3), moved(perturbed(cube_grid(2), 0.1, 5), 0.4, (0, 0, 0))
    cavity = mesh_from_faces(inside.xyz, [face[::-1] for face in inside.face_list()])
    joined = join([outer, cavity])
    got = lib.minimize(joined.mesh, levels=2, spontaneous_curvature=0.5, max_iterations=2)
    for number, (piece, c0) in enumerate([(outer, 0.5), (cavity, -0.5)]):
        alone = lib.minimize(piece, levels=2, spontaneous_curvature=c0, max_iterations=2)
        assert np.array_equal(corners_of(joined, number, got.mesh), alone.mesh.xyz[alone.mesh.flat])
    seen = []
    lib.minimize(joined.mesh, levels=1, spontaneous_curvature=0.5, progress=lambda p: seen.append((p.energy, p.start_energy)))
    assert seen[0][0] == pytest.approx(seen[0][1], rel=1e-3)


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
def test_a_surface_that_becomes_flat_is_a_minimum(energy: str):
    """Its energy is rounding, and no decrement is small beside that."""
    cloth = sheet()
    inside = [6, 7, 8, 11, 12, 13, 16, 17, 18]
    flat = cloth.xyz.copy()
    flat[:, 2] = 0
    flat[inside] = cloth.xyz[inside]
    got = lib.minimize(replace(cloth, xyz=flat), energy, levels=2)
    assert got.verdict == "minimum" and got.summary.end.objective < 1e-20
    assert np.abs(got.mesh.xyz[:, 2]).max() < 1e-9

# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface that stays near the input cage: which waves go, and what holds the others."""
from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from energy_ref import densities, samples
from nets import perturbed, read_obj, torus_cage

NONE = 1
FREE = 2  # curvopt_spacing
STIFFNESS = {"willmore": 24 * pi, "mvs": 2979.1973808604575}  # penalty.h
REACH, FIRMEST, LIMITING = 0.2, 0.3, 0.03  # strength.c
DENSITY = {"willmore": lambda k, area: k ** 4, "mvs": lambda k, area: area * k ** 6}


def spread(xyz: np.ndarray) -> float:
    """Root mean square distance of points from their mean; of a cage's vertices its radius."""
    return float(np.sqrt(((xyz - xyz.mean(0)) ** 2).sum() / len(xyz)))


def vertex_areas(mesh: Mesh) -> np.ndarray:
    """Of faces cut into triangles from their middles, half of each to the two vertices."""
    area = np.zeros(mesh.n_vertices)
    for face in mesh.face_list():
        p = mesh.xyz[face]
        for i, v in enumerate(face):
            w = (i + 1) % len(face)
            triangle = np.linalg.norm(np.cross(p[w] - p[i], p.mean(0) - p[i])) / 2
            area[[v, face[w]]] += triangle / 2
    return area


def vertex_energies(mesh: Mesh, energy: str) -> np.ndarray:
    """Of faces, equal parts to their vertices; quads without extraordinary vertices."""
    share, whole = np.zeros(mesh.n_faces), 0.0
    for face, _, _, weight, jets in samples(mesh, 8, 1, 1):
        density = densities(jets)
        np.add.at(share, face, density[energy] * density["area"] * weight)
        whole += float((density["area"] * weight).sum())
    part = np.repeat(share / 4 * (1 if energy == "willmore" else whole), 4)
    return np.bincount(mesh.flat, part, minlength=mesh.n_vertices)


def strip(n: int, rows: int, height: float, waves: float) -> Mesh:
    """A plane of n x rows unit squares with a wave along it; its corners are corners."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(rows + 1.0), indexing="ij")
    z = height * np.cos(2 * pi * waves * x / n)
    at = lambda i, j: i * (rows + 1) + j
    faces = [[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(n) for j in range(rows)]
    corners = np.zeros(x.size)
    corners[[at(i, j) for i in (0, n) for j in (0, rows)]] = 10
    return replace(mesh_from_faces(np.stack([x, y, z], -1).reshape(-1, 3), faces), vertex_sharpness=corners)


@pytest.mark.parametrize("energy", ["willmore", "mvs", "mvs_cross", "variation", "mehlum_tarrou"])
def test_energy_of_a_wave(energy):
    """What functional.h says of a wave on a plane, against the energy of one: the strip between two others of its
    width, of whole waves in the middle and plane nowhere."""
    n, height = 96, 0.15
    long, short = (strip(m, 2, height, m / 16) for m in (2 * n, n))
    values = [lib.evaluate(mesh, energy, tolerance=1e-6) for mesh in (long, short)]
    k, part = 2 * pi / 16, {"mehlum_tarrou": 0.625}.get(energy, 1)
    limit = height * (2 + np.cos(k)) / 3  # of cubic splines at their vertices
    if energy == "willmore":
        found = values[0].objective - values[1].objective  # the ends cancel
        wanted = k ** 4 * 2 * n * limit ** 2 / 2
    else:
        found = values[0].objective / values[0].area - values[1].objective / values[1].area
        wanted = part * k ** 6 * 2 * n * limit ** 2 / 2
    assert found == pytest.approx(wanted, rel=0.06)


def test_half_of_the_wave_of_the_stated_length_stays():
    """And of one half or twice as long what Tikhonov's formula says, in the middle of a strip whose ends are far."""
    n = 96
    for factor in (0.5, 1, 2):
        wave = 12.0
        mesh = strip(n, 3, 0.05, n / (wave * factor))
        s = (wave / spread(mesh.xyz)) / (1 + wave / spread(mesh.xyz))
        result = lib.minimize(mesh, "willmore", levels=1, symmetry=NONE, strength=s, boundary=3)
        middle = slice(4 * (n // 4), 4 * (3 * n // 4))
        before, after = (np.ptp(m.xyz[middle, 2]) for m in (mesh, result.mesh))
        assert after / before == pytest.approx(1 / (1 + factor ** -4), abs=0.04), factor


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
@pytest.mark.parametrize("strength", [0.5, 0.8])
def test_forces_balance(energy, strength):
    """At the end the surface's gradient is what the springs pull with: their formula, written again here."""
    mesh = perturbed(torus_cage(9, 6, 0.5), 0.1, 3)
    result = lib.minimize(mesh, energy, levels=1, symmetry=NONE, strength=strength, decrement_tolerance=1e-12,
                          gradient_tolerance=1e-15, tolerance=1e-7)
    problem = lib.Problem(result.mesh, lib.options(energy, tolerance=1e-7))
    _, gradient = problem.evaluate(result.mesh.xyz, True)
    area, size, wave = vertex_areas(mesh), spread(mesh.xyz), strength / (1 - strength)
    density = DENSITY[energy](2 * pi / wave, area.sum() / size ** 2)
    reach, moved = REACH * wave * size, result.mesh.xyz - mesh.xyz
    stiffness = 2 * density / size ** 4 * area + 2 * FIRMEST * vertex_energies(mesh, energy) / reach ** 2
    pull = (stiffness / (1 - (moved ** 2).sum(1) / reach ** 2))[:, None] * moved
    assert np.abs(gradient + pull).max() < 1e-3 * np.abs(pull).max()
    assert np.linalg.norm(moved, axis=1).max() > 1e-2 * size
    assert result.verdict == "minimum"


def creased_box(sharpness: float) -> Mesh:
    """A box of 4 x 2 x 2 squares, its twelve edges creased: energies of third order push them far."""
    index: dict[tuple, int] = {}
    points, faces, creases = [], [], {}
    size = np.array([4, 2, 2])
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, int(size[axis])):
            for i in range(size[a]):
                for j in range(size[b]):
                    face = []
                    for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[a], at[b] = side, i + u, j + v
                        if tuple(at) not in index:
                            index[tuple(at)] = len(points)
                            points.append(at)
                        face.append(index[tuple(at)])
                    faces.append(face if side else face[::-1])
    on_sides = ((np.array(points) == 0) | (np.array(points) == size)).sum(1)
    for face in faces:
        for v, w in zip(face, face[1:] + face[:1]):
            both = (np.array(points)[[v, w]] == 0).all(0) | (np.array(points)[[v, w]] == size).all(0)
            if min(on_sides[[v, w]]) > 1 and both.sum() == 2:
                creases[(min(v, w), max(v, w))] = sharpness
    return mesh_from_faces(np.array(points, float), faces, creases)


@pytest.mark.parametrize("strength, levels", [(0.3, 2), *([(0.3, 1), (0.5, 1), (0.8, 1)] if lib.LONG else [])])
def test_no_point_moves_beyond_the_reach(strength, levels, capsys):
    """Of the cage, and so of its surface, whatever the energy is: without the end of springs .36 radii at strength .5,
    where .2 are stated, and .88 at .8, where .8 are."""
    mesh = creased_box(3)
    result = lib.minimize(mesh, "mvs", levels=levels, symmetry=NONE, strength=strength)
    was = mesh
    for _ in range(levels - 1):
        was = lib.refine(was)
    reach = REACH * strength / (1 - strength) * spread(mesh.xyz)
    moved = np.linalg.norm(result.mesh.xyz - was.xyz, axis=1).max()
    with capsys.disabled():
        print(f"\n  strength {strength}, {levels} levels: {moved / reach:.3f} of the reach")
    assert 0.3 * reach < moved < reach
    assert result.verdict == "minimum"


def test_from_the_input_to_the_minimum():
    """The stronger, the further from the input, and the less energy; 1 is the run without the option."""
    mesh = read_obj(lib.ROOT / "blend_files" / "obj" / "mug_g1.obj")
    distance, energy = [], []
    for strength in (0.01, 0.2, 0.4, 0.6):
        result = lib.minimize(mesh, levels=1, strength=strength)
        distance.append(spread(result.mesh.xyz - mesh.xyz))
        energy.append(result.summary.end.objective)
    assert distance[0] < 1e-4 * spread(mesh.xyz) and (np.diff(distance) > 0).all() and (np.diff(energy) < 0).all()
    assert energy[0] == pytest.approx(result.summary.start.objective, rel=1e-3)
    plain, one = (lib.minimize(torus_cage(6, 4, 0.4), levels=1, **fields) for fields in ({}, {"strength": 1.0}))
    assert np.array_equal(plain.mesh.xyz, one.mesh.xyz)


def test_levels_change_the_net_and_not_the_nearness():
    """On a net that has room for the waves that go (with one level here it has not: two thirds of the distance)."""
    mesh = perturbed(torus_cage(10, 8, 0.5), 0.1, 5)
    distance = []
    for levels in (2, 3):
        result = lib.minimize(mesh, levels=levels, symmetry=NONE, strength=0.4)
        was = mesh
        for _ in range(levels - 1):
            was = lib.refine(was)
        distance.append(spread(result.mesh.xyz - was.xyz))
        assert result.verdict == "minimum"
    assert max(distance) < 1.1 * min(distance), distance


def test_the_command_line_takes_it(tmp_path):
    mesh = perturbed(torus_cage(8, 5, 0.5), 0.1, 3)
    _, by_command = lib.cli_minimize(mesh, "--strength", "0.3", "--levels", "1")
    result = lib.minimize(mesh, levels=1, strength=0.3)
    assert np.abs(by_command.xyz - result.mesh.xyz).max() < 1e-6


# ------------------------------------------------------------------------------------------------------- within --


def moved_by(mesh: Mesh, result) -> np.ndarray:
    """How far each vertex of a result is from where subdividing the cage puts it."""
    was = mesh
    while was.n_vertices < result.mesh.n_vertices:
        was = lib.refine(was)
    return np.linalg.norm(result.mesh.xyz - was.xyz, axis=1)


@pytest.mark.parametrize("energy, levels", [("willmore", 1), ("willmore", 2), ("mvs", 2), ("mvs_cross", 1)])
def test_no_point_gets_farther_than_within(energy, levels):
    """And the distance is used: the more of it, the less energy."""
    mesh = perturbed(torus_cage(9, 6, 0.5), 0.1, 3)
    energies, size = [], spread(mesh.xyz)
    for part in (0.01, 0.05, 0.2):
        result = lib.minimize(mesh, energy, levels=levels, symmetry=NONE, within=part * size)
        assert result.verdict == "minimum"
        assert moved_by(mesh, result).max() < part * size
        assert moved_by(mesh, result).max() > 0.6 * part * size
        found, _ = lib.deviation(mesh, result.mesh)
        assert found.max <= found.bound <= part * size and found.bound < 1.2 * found.max
        energies.append(result.summary.end.objective)
    assert (np.diff(energies) < 0).all()


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
def test_what_the_barrier_costs(energy):
    """At the end the energy's gradient is the barrier's, which is worth a hundredth of what the energy is; with a tenth
    of its weight, by the formula of its own, no more than a few hundredths would be gained. Over all coordinates: an even
    spacing is not the energy's."""
    mesh = perturbed(torus_cage(9, 6, 0.5), 0.1, 3)
    within = 0.1 * spread(mesh.xyz)
    result = lib.minimize(mesh, energy, levels=1, symmetry=NONE, within=within, spacing=FREE, decrement_tolerance=1e-12,
                          gradient_tolerance=1e-15, tolerance=1e-7)
    problem = lib.Problem(result.mesh, lib.options(energy, tolerance=1e-7))
    value, gradient = problem.evaluate(result.mesh.xyz, True)
    moved, area = result.mesh.xyz - mesh.xyz, vertex_areas(mesh)
    pull = (area / (1 - (moved ** 2).sum(1) / within ** 2))[:, None] * moved
    pull *= 2 * LIMITING * value.objective / (area.sum() * within ** 2)
    weight = -(gradient * pull).sum() / (pull ** 2).sum()
    assert np.abs(gradient + weight * pull).max() < 1e-3 * np.abs(pull).max()
    assert 0.99 < weight < 2  # weighed anew whenever the energy has halved


def test_within_is_whole_where_numbers_and_pins_are_held():
    mesh = perturbed(torus_cage(9, 6, 0.5), 0.1, 3)
    within = 0.05 * spread(mesh.xyz)
    pins = lib.constraints([0, 7, 20], [0, 1, 2], [[0, 0, 0], [1, 2, 3], [0, 1, -1]])
    result = lib.minimize(mesh, levels=2, symmetry=NONE, within=within, constraints=pins, hold={"volume": "keep"})
    others = np.delete(moved_by(mesh, result), [0, 7, 20])
    assert others.max() < within and result.verdict == "minimum"
    assert result.summary.end.volume == pytest.approx(result.summary.start.volume, rel=1e-6)
    both = lib.minimize(mesh, levels=1, symmetry=NONE, within=within, strength=0.6)
    assert moved_by(mesh, both).max() < within
    one = lib.minimize(mesh, levels=1, symmetry=NONE, within=within, constraints=pins)
    assert moved_by(mesh, one).max() < within and moved_by(mesh, one)[0] == 0
    alone = lib.minimize(mesh, levels=1, symmetry=NONE, strength=0.6)
    assert moved_by(mesh, alone).max() > within


@pytest.mark.parametrize("within", [1e-6, 1e-5, 1e-4])
def test_within_stands_where_a_held_number_is_elsewhere_by_the_rules_of_the_end(within):
    """A bent cube: held by coarser rules, its area is not the same by finer ones, and less than that is allowed."""
    corners = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    i = np.arange(24).reshape(8, 3)
    mesh = mesh_from_faces(corners + 0.2 * np.sin(3.1 * i ** 2), faces)
    result = lib.minimize(mesh, levels=1, within=within, hold={"area": "keep"})
    assert moved_by(mesh, result).max() <= within
    assert np.isfinite(result.summary.spring_energy) and np.isfinite(result.summary.end.objective)


@pytest.mark.parametrize("fields, what", [
    ({"weights": [1.0, 0.5], "freedom": [0, 1], "directions": [[0, 0, 0], [1, 0, 0]]}, "constraint 1, of vertex 4"),
    ({"places": [[np.nan] * 3, [1.0, 2.0, 3.0]]}, "constraint 1, of vertex 4"),
])
def test_what_stands_against_within_is_refused(fields, what):
    mesh = perturbed(torus_cage(9, 6, 0.5), 0.1, 3)
    with pytest.raises(lib.CurvoptError, match=what):
        lib.minimize(mesh, levels=1, within=0.1, constraints=lib.constraints([2, 4], **fields))
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(lib.CurvoptError, match="within"):
            lib.minimize(mesh, levels=1, within=wrong)


def test_a_flat_cage_stays_within():
    """Energy 0 to begin with: nothing to gain, nothing lost."""
    result = lib.minimize(strip(6, 4, 0.0, 1), levels=2, within=0.1)
    assert moved_by(strip(6, 4, 0.0, 1), result).max() < 0.1 and result.summary.end.objective < 1e-12


def test_the_command_line_takes_within(tmp_path):
    mesh = perturbed(torus_cage(8, 5, 0.5), 0.1, 3)
    _, by_command = lib.cli_minimize(mesh, "--within", "0.03", "--levels", "1")
    result = lib.minimize(mesh, levels=1, within=0.03)
    assert np.abs(by_command.xyz - result.mesh.xyz).max() < 1e-6

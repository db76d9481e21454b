# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges of length 0: what they leave without a tangent plane is left out, and everything else is optimized."""
from __future__ import annotations

import json

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import cube_grid, perturbed, write_obj

POSITION, FREE = 0, 3  # curvopt_boundary


def together(mesh: Mesh, *groups: list[int]) -> Mesh:
    """The mesh with each of these groups of vertices in one place."""
    points = mesh.xyz.copy()
    for group in groups:
        points[group] = points[group].mean(0)
    return mesh_from_faces(points, mesh.face_list())


def grid(n: int = 8) -> Mesh:
    """n x n vertices, waved."""
    at = np.linspace(-1, 1, n)
    points = [[x, y, 0.3 * np.cos(2 * x + 1) * np.sin(y + 2)] for y in at for x in at]
    starts = [n * y + x for y in range(n - 1) for x in range(n - 1)]
    return mesh_from_faces(points, [[v, v + 1, v + n + 1, v + n] for v in starts])


def rings(radius: list[float], height: list[float], n: int = 8) -> Mesh:
    """n vertices a ring, all in one place where the radius is 0."""
    turn = 2 * np.pi * np.arange(n) / n
    points = [[r * np.cos(t), r * np.sin(t), z] for r, z in zip(radius, height) for t in turn]
    faces = [[n * i + k, n * i + (k + 1) % n, n * i + n + (k + 1) % n, n * i + n + k]
             for i in range(len(radius) - 1) for k in range(n)]
    return mesh_from_faces(points, faces)


def spun(rows: int = 8, n: int = 12) -> Mesh:
    """An ellipsoid whose poles are boundaries of n vertices in one place."""
    angle = np.pi * np.arange(rows + 1) / rows
    return rings([float(r) for r in np.sin(angle[:-1])] + [0.0], [float(z) for z in -1.3 * np.cos(angle)], n)


def two_cubes() -> Mesh:
    """One of them in one place."""
    cube, point = perturbed(cube_grid(3), 0.03, 3), cube_grid(1)
    faces = [[v + cube.n_vertices for v in face] for face in point.face_list()]
    return mesh_from_faces(np.vstack([cube.xyz, 0 * point.xyz + [0, 0, 3]]), [*cube.face_list(), *faces])


# Faces that have no tangent plane at a corner, by hand.
CAGES = {
    "quad that is a triangle": (lambda: together(grid(), [27, 28]), 0),
    "face in one place": (lambda: together(grid(), [27, 28, 35, 36]), 0),
    "faces round a vertex in one place": (lambda: together(grid(), [27, 28, 29, 35, 36, 37, 43, 44, 45]), 4),
    "boundary edge": (lambda: together(grid(), [2, 3]), 0),
    "two boundary edges": (lambda: together(grid(), [2, 3, 4]), 2),
    "side of a grid": (lambda: together(grid(), list(range(8))), 7),
    "edge of a cube": (lambda: together(perturbed(cube_grid(4), 0.03, 3), cube_grid(4).face_list()[0][:2]), 0),
    "poles": (spun, 24),
    "waist of one ring": (lambda: rings([1, 1, 1, 0.5, 0, 0.5, 1, 1, 1], list(range(9))), 0),
    "waist of two rings": (lambda: rings([1, 1, 1, 0.5, 0, 0, 0.5, 1, 1, 1], [0, 1, 2, 3, 4, 4, 5, 6, 7, 8]), 0),
    "waist of three rings": (lambda: rings([1, 1, 0.5, 0, 0, 0, 0.5, 1, 1], [0, 1, 2, 3, 3, 3, 4, 5, 6]), 16),
    "piece in one place": (two_cubes, 6),
}


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
@pytest.mark.parametrize("name", CAGES)
def test_every_cage_ends_as_a_minimum(name, energy):
    make, left_out = CAGES[name]
    cage = make()
    reasons = lib.exceptions(cage, energy)
    assert sum(map(bool, reasons[1])) == reasons[1].count("degenerate") == left_out
    result = lib.minimize(cage, energy, levels=1, strength=0.3)
    held = np.flatnonzero([bool(reason) for reason in reasons[0]])
    assert result.verdict == "minimum" and result.summary.n_left_out == left_out and result.summary.n_held == len(held)
    assert np.array_equal(result.mesh.xyz[held], cage.xyz[held])
    assert result.summary.end.objective < result.summary.start.objective


@pytest.mark.parametrize("seed", range(12))
def test_vertices_in_one_place_at_random(seed):
    """Up to six neighbours in one place, on open and closed cages: all end as minima."""
    random = np.random.default_rng(seed)
    cage = grid(6) if seed % 2 else perturbed(cube_grid(3), 0.03, seed)
    edges = {tuple(sorted(pair)) for face in cage.face_list() for pair in zip(face, face[1:] + face[:1])}
    group = {int(random.integers(cage.n_vertices))}
    for _ in range(random.integers(1, 6)):
        way = sorted(edge for edge in edges if len(group & set(edge)) == 1)
        group |= set(way[random.integers(len(way))])
    assert lib.minimize(together(cage, sorted(group)), levels=1, strength=0.3).verdict == "minimum"


def test_what_is_left_out_is_decided_once():
    """On finer levels it is the children of what the input has, though these have no edge of length 0; and an
    evaluation somewhere else leaves out the same faces."""
    cage = together(grid(6), [1, 2, 3])
    left_out = [bool(reason) for reason in lib.exceptions(cage)[1]]
    result = lib.minimize(cage, levels=2, strength=0.5)
    assert result.summary.n_left_out == sum(left_out) == 2
    children = np.flatnonzero(np.repeat(left_out, cage.sizes))
    again = lib.evaluate(result.mesh, **lib.holes(children))
    assert again.objective == pytest.approx(result.summary.end.objective, rel=1e-4)
    elsewhere = grid(6)
    there = lib.Problem(cage, lib.options()).evaluate(elsewhere.xyz)
    assert there.objective == lib.evaluate(elsewhere, **lib.holes(np.flatnonzero(left_out))).objective


def test_without_what_is_left_out_it_is_the_cage_with_holes():
    cage = spun()
    left_out = np.flatnonzero([bool(reason) for reason in lib.exceptions(cage)[1]])
    assert lib.evaluate(cage).objective == lib.evaluate(cage, **lib.holes(left_out)).objective


def test_command_line_says_what_and_where(tmp_path):
    path = write_obj(tmp_path / "cage.obj", spun())
    for command in (["evaluate", path], ["minimize", path, "-o", tmp_path / "out.obj", "--levels", 1]):
        done = lib.run_cli(*map(str, command))
        assert done.returncode == 0, done.stderr
        assert "24 of 96 faces are left out of the energy" in done.stdout
        assert "24 vertices: 0 1 2 3 4 .. (edges of length 0, or far too short for the cage, leave no tangent plane)" in done.stdout
        done = lib.run_cli(*map(str, command), "--strict")
        assert done.returncode == 1 and not done.stdout
        assert "edges of length 0 leave the surface no tangent plane at vertex 0" in done.stderr
    figures = json.loads(lib.run_cli("evaluate", str(path), "--json", "-").stdout)
    assert figures["n_left_out"] == 24 and figures["left_out"][0]["reason"] == "degenerate"
    assert [(entry["reason"], entry["count"]) for entry in figures["held"]] == [("degenerate", 24), ("beside", 24)]


def test_command_line_says_how_many_levels_it_takes(tmp_path):
    quad = mesh_from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0.3], [0, 1, 0]], [[0, 1, 2, 3]])
    path, out = write_obj(tmp_path / "cage.obj", quad), tmp_path / "out.obj"
    for boundary, level in (("position", 2), ("tangent", 3), ("curvature", 4)):
        arguments = ["minimize", str(path), "-o", str(out), "--boundary", boundary, "--levels"]
        done = lib.run_cli(*arguments, "1")
        assert done.returncode == 1 and not out.exists()
        assert done.stderr.strip().endswith(f"use more levels: from --levels {level} on some may")
        assert lib.run_cli(*arguments, str(level)).returncode == 0
        out.unlink()
    (tmp_path / "through.json").write_text('[{"vertex": 0, "at": [0, 0, 1]}]')  # another reason, which more levels do not mend
    done = lib.run_cli(*arguments, "1", "--strength", "0.3", "--through", str(tmp_path / "through.json"))
    assert done.returncode == 1 and done.stderr.strip().endswith("cannot be had with a strength below 1")


def test_gradient_that_no_double_can_hold_is_refused():
    """A prism whose vertices lie at distances of 1 to 1e-100: MVS is 1e103, and its gradient was NAN, with status 0. What is
    refused writes nothing."""
    turn = 2 * np.pi * np.arange(8) / 8
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    xyz = np.concatenate([ring, ring + [0, 0, 1]]) * 10.0 ** np.random.default_rng(9).integers(-100, 1, size=(16, 1))
    sides = [[k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k] for k in range(8)]
    mesh = mesh_from_faces(xyz, [list(range(7, -1, -1)), list(range(8, 16)), *sides])
    problem = lib.Problem(mesh, lib.options({"mvs": 1e100}, tolerance=0.5, threads=1))
    assert np.isfinite(problem.evaluate(xyz).objective)
    with pytest.raises(lib.CurvoptError, match="gradient is not finite at vertex"):
        problem.evaluate(xyz, gradient=True)

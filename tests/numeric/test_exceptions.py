# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages that are no manifold, or have no finite energy everywhere: what is held stays, what is left is as it was."""
from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from energy_ref import gauss_rule, second_order
from nets import cube_grid, perturbed, torus_cage, write_obj
from osd import osd_refined

POSITION, FREE = 0, 3  # curvopt_boundary
PROGRAM = lib.ROOT / "build" / "release" / "curvopt"


def jittered(mesh: Mesh, size: float, seed: int) -> Mesh:
    """The mesh with vertices moved by about `size`; it need not be a manifold."""
    noise = size * np.random.default_rng(seed).standard_normal(mesh.xyz.shape)
    return mesh_from_faces(mesh.xyz + noise, mesh.face_list())


def joined(mesh: Mesh, points, faces) -> Mesh:
    """The mesh with more vertices and faces."""
    return mesh_from_faces(np.vstack([mesh.xyz, np.reshape(points, (-1, 3))]), [*mesh.face_list(), *faces])


def fin(mesh: Mesh, face: int = 0, height: float = 0.5) -> Mesh:
    """The mesh with a quad that stands on the first edge of a face."""
    a, b = mesh.face_list()[face][:2]
    n = mesh.n_vertices
    up = height * mesh.xyz[[a, b]] / np.linalg.norm(mesh.xyz[[a, b]], axis=1)[:, None] + [0, 0, height]
    return joined(mesh, mesh.xyz[[a, b]] + up, [[a, b, n + 1, n]])


def with_valence_two(mesh: Mesh, face: int) -> Mesh:
    """The mesh with a quad cut in two along a broken line: its middle is an inner vertex of two edges."""
    faces = mesh.face_list()
    a, b, c, d = faces[face]
    x = mesh.n_vertices
    points = np.vstack([mesh.xyz, mesh.xyz[[a, b, c, d]].mean(0)])
    return mesh_from_faces(points, [*faces[:face], [a, b, c, x], *faces[face + 1:], [a, x, c, d]])


def with_cone(mesh: Mesh, vertex: int) -> Mesh:
    """The mesh with an infinitely sharp vertex: of its faces no energy is finite."""
    return mesh_from_faces(mesh.xyz, mesh.face_list(), None, {vertex: 10.0})


def sheets(n: int) -> Mesh:
    """n pairs of quads that share two edges, 0 1 and 1 2."""
    turn = [(np.cos(2 * np.pi * k / n), np.sin(2 * np.pi * k / n)) for k in range(n)]
    points = [[0, 0, z] for z in range(3)] + [[x, y, z] for x, y in turn for z in range(3)]
    return mesh_from_faces(points, [f for i in range(3, 3 * n + 3, 3) for f in ([0, i, i + 1, 1], [1, i + 1, i + 2, 2])])


def flawed() -> dict[str, Mesh]:
    """Small cages with every flaw, at positions in general."""
    torus = torus_cage(5, 4, 0.5)
    faces = torus.face_list()
    grid = mesh_from_faces([[x, y, 0.1 * x * y] for y in range(4) for x in range(4)],
                           [[4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4] for y in range(3) for x in range(3)])
    cube = cube_grid(1)
    twin = [[v + 7 if v else 0 for v in f] for f in cube.face_list()]
    cages = {
        "fin": fin(torus),
        "flipped": mesh_from_faces(torus.xyz, [faces[0][::-1], *faces[1:]]),
        "repeated": mesh_from_faces(torus.xyz, [*faces, faces[3]]),
        "tips": mesh_from_faces(np.vstack([cube.xyz, 2 * cube.xyz[0] - cube.xyz[1:]]), [*cube.face_list(), *twin]),
        "valence_2": with_valence_two(cube_grid(2), 3),
        "two_corners": mesh_from_faces(grid.xyz, [grid.face_list()[i] for i in (0, 4)]),
        "fin_of_two": joined(grid, [[1, 1, 1], [2, 1, 1], [1, 1, 2], [2, 1, 2]], [[5, 6, 17, 16], [16, 17, 19, 18]]),
        "sheets": sheets(3),
        "sheets_and_a_boundary": joined(sheets(3), [[2, 2, 2], [2, 1, 2], [1, 2, 2]], [[1, 12, 13, 14]]),
        "four_and_three": joined(sheets(3), [[0, -1, 2], [0, -1, 3]], [[0, 12, 13, 1]]),
        "threefold": mesh_from_faces(cube.xyz, [*cube.face_list(), cube.face_list()[2], cube.face_list()[2][::-1]]),
        "triangles_on_an_edge": mesh_from_faces([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]],
                                                [[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
    }
    return {name: jittered(mesh, 0.05, 5) for name, mesh in cages.items()}


@pytest.mark.parametrize("name", flawed())
def test_subdivision_is_that_of_opensubdiv(name):
    """Every vertex after one, two and three steps; OpenSubdiv numbers them differently."""
    ours = mesh = flawed()[name]
    for levels in (1, 2, 3):
        ours, theirs = lib.refine(ours), osd_refined(mesh, levels)
        assert len(theirs) == ours.n_vertices
        distance = np.linalg.norm(ours.xyz[:, None] - theirs[None], axis=2)
        assert distance.min(1).max() < 1e-12 and distance.min(0).max() < 1e-12


def test_isolated_vertices_stay_and_keep_their_numbers():
    torus = torus_cage(5, 4, 0.5)
    loose = mesh_from_faces(np.insert(torus.xyz, 7, [9, 9, 9], axis=0),
                            [[v + (v >= 7) for v in f] for f in torus.face_list()])
    fine, expected = lib.refine(loose), lib.refine(torus)
    assert np.array_equal(fine.xyz[7], [9, 9, 9])
    assert np.array_equal(np.delete(fine.xyz, 7, axis=0), expected.xyz)


# ------------------------------------------------------------------------------------------------ energies --


def face_energies(mesh: Mesh, n_gauss: int = 16) -> np.ndarray:
    """int k1^2 + k2^2 dA of every face of a cage whose faces are all regular, by one Gauss rule."""
    t, w = gauss_rule(n_gauss)
    u, v = (a.ravel() for a in np.meshgrid(t, t))
    face = np.repeat(np.arange(mesh.n_faces), len(u))
    jets = lib.jets(mesh, face, np.zeros(len(face)), np.tile(np.stack([u, v], 1), (mesh.n_faces, 1)))
    density = second_order(jets)
    values = density["willmore"] * density["area"] * np.tile(np.outer(w, w).ravel(), mesh.n_faces)
    return values.reshape(mesh.n_faces, -1).sum(1)


def kept_faces(mesh: Mesh, **fields) -> np.ndarray:
    """Which faces count."""
    return np.array([not reason for reason in lib.exceptions(mesh, **fields)[1]])


def test_energy_is_that_of_the_kept_faces():
    """A fin on a torus: the faces at the fin's edge and the fin are left out, the others have the torus' energies."""
    torus = perturbed(torus_cage(10, 8, 0.5), 0.05, 1)
    cage = fin(torus)
    kept = kept_faces(cage)
    assert not kept[-1] and (~kept).sum() == 7  # six faces of the torus are at the two vertices
    each = face_energies(torus)
    assert lib.evaluate(torus, tolerance=1e-9).objective == pytest.approx(each.sum(), rel=1e-8)
    energies = lib.evaluate(cage, tolerance=1e-9)
    assert energies.objective == pytest.approx(each[kept[:-1]].sum(), rel=1e-8)
    assert np.isnan(energies.gauss_bonnet_defect)
    assert lib.evaluate(torus, tolerance=1e-9, **lib.holes(np.flatnonzero(~kept[:-1]))).objective == pytest.approx(
        energies.objective, rel=1e-12)


@pytest.mark.parametrize("energy", ["willmore", "mvs", "area"])
def test_an_isolated_vertex_changes_no_energy(energy):
    torus = perturbed(torus_cage(8, 6, 0.5), 0.05, 2)
    loose = joined(torus, [[40, -7, 3]], [])
    there, slope = lib.Problem(loose, lib.options(energy)).evaluate(loose.xyz, gradient=True)
    here, other = lib.Problem(torus, lib.options(energy)).evaluate(torus.xyz, gradient=True)
    assert there.objective == here.objective and there.gauss_bonnet_defect == here.gauss_bonnet_defect
    assert np.array_equal(slope[:-1], other) and not slope[-1].any()


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
@pytest.mark.parametrize("name", ["fin", "valence_2", "repeated"])
def test_gradient_against_differences(energy, name):
    cage = {"fin": fin(torus_cage(10, 8, 0.5)), "valence_2": with_valence_two(cube_grid(3), 4),
            "repeated": joined(torus_cage(8, 6, 0.5), [[3, 3, 3]], [torus_cage(8, 6, 0.5).face_list()[3]])}[name]
    cage = jittered(cage, 0.01, 3)
    problem = lib.Problem(cage, lib.options(energy, tolerance=1e-6))
    _, slope = problem.evaluate(cage.xyz, gradient=True)
    random = np.random.default_rng(4)
    for _ in range(3):
        way = random.standard_normal(cage.xyz.shape)
        step = 1e-5
        for _ in range(2):  # where the first pair changes the rules, the second one has the same
            ahead, back = (problem.evaluate(cage.xyz + s * step * way) for s in (1, -1))
        assert ahead.n_samples == back.n_samples
        assert (slope * way).sum() == pytest.approx((ahead.objective - back.objective) / (2 * step), rel=2e-6)


# ---------------------------------------------------------------------------------------------- minimizing --


def inner_vertex(mesh: Mesh) -> int:
    """The first vertex of four faces."""
    return int(np.flatnonzero(np.bincount(mesh.flat) == 4)[0])


def held_vertices(mesh: Mesh, **fields) -> np.ndarray:
    return np.flatnonzero([bool(reason) for reason in lib.exceptions(mesh, **fields)[0]])


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
def test_a_cage_with_a_cone_ends_as_a_minimum(energy):
    """Four faces and nine vertices of it are held, and a loose vertex; nothing else is."""
    plain = joined(perturbed(cube_grid(4), 0.05, 6), [[3, 3, 3]], [])
    cage = with_cone(plain, inner_vertex(plain))
    result = lib.minimize(cage, energy, levels=1)
    held = held_vertices(cage, weights=energy)
    assert result.verdict == "minimum" and len(held) == 10
    assert result.summary.n_held == 10 and result.summary.n_left_out == 4
    assert np.array_equal(result.mesh.xyz[held], cage.xyz[held])
    assert (np.delete(result.mesh.xyz, held, 0) != np.delete(cage.xyz, held, 0)).any(axis=1).all()
    assert result.summary.end.objective < 0.9 * result.summary.start.objective


def test_on_finer_levels_only_children_of_left_out_faces_stay_out():
    """The last level is a run of its own on the subdivided cage, whose holes are those children."""
    cage = with_cone(perturbed(cube_grid(3), 0.05, 7), inner_vertex(cube_grid(3)))
    result = lib.minimize(cage, levels=2)
    left_out = ~kept_faces(cage)
    children = np.flatnonzero(np.repeat(left_out, cage.sizes))
    again = lib.evaluate(result.mesh, **lib.holes(children))
    assert again.objective == pytest.approx(result.summary.end.objective, rel=1e-4)
    assert result.summary.n_left_out == 4
    held = np.unique(np.concatenate([result.mesh.face_list()[f] for f in children]))
    assert (result.mesh.xyz[held] != 0).any()
    # where subdivision of the first level's result put them: of those faces' own vertices alone, and what is round them
    first = lib.minimize(cage, levels=1)
    middle = np.arange(result.mesh.n_vertices)[-cage.n_faces:][left_out]
    expected = [first.mesh.xyz[f].mean(0) for f, out in zip(cage.face_list(), left_out) if out]
    assert np.allclose(result.mesh.xyz[middle], expected, rtol=0, atol=1e-14)


def test_symmetry_is_kept_beside_what_is_held():
    """A loose vertex far from any mirror plane, and a square with four cones."""
    n = 8
    points = [[x, y, 0.3 * np.cos(x) * np.cos(y)] for y in np.linspace(-1, 1, n) for x in np.linspace(-1, 1, n)]
    faces = [[n * y + x, n * y + x + 1, n * y + x + n + 1, n * y + x + n] for y in range(n - 1) for x in range(n - 1)]
    cones = {n * y + x: 10.0 for x in (1, n - 2) for y in (1, n - 2)}
    cage = mesh_from_faces([*points, [5, 1, 2]], faces, None, cones)
    result = lib.minimize(cage, levels=1)
    assert result.summary.symmetry_order == 8
    assert result.summary.n_left_out == 16 and result.summary.n_held == 4 * 9 + 1
    assert np.array_equal(result.mesh.xyz[-1], [5, 1, 2])
    assert np.allclose(result.mesh.xyz[:-1, 2], result.mesh.xyz[:-1, 2].reshape(n, n).T.ravel(), rtol=0, atol=1e-12)


def test_nothing_left_is_said_in_one_sentence():
    cone = mesh_from_faces(cube_grid(1).xyz, cube_grid(1).face_list(), None, dict.fromkeys(range(8), 10.0))
    for run in (lib.evaluate, lib.minimize):
        with pytest.raises(lib.CurvoptError, match="no face is left in the energy: all 6 .* vertex 0, where an inf"):
            run(cone)
    cage = fin(cube_grid(1))
    with pytest.raises(lib.CurvoptError, match="no face is left|nothing may move"):
        lib.minimize(cage, levels=1)


def test_strict_refuses():
    for name, cage in flawed().items():
        if name == "valence_2":  # unusual, but sound
            continue
        with pytest.raises(lib.CurvoptError, match="manifold|flipped|separate fans|isolated"):
            lib.minimize(cage, levels=1, strict=1)
        with pytest.raises(lib.CurvoptError, match="manifold|flipped|separate fans|isolated"):
            lib.evaluate(cage, strict=1)


def test_pins_and_springs_beside_what_is_held():
    cage = with_cone(perturbed(cube_grid(3), 0.05, 8), inner_vertex(cube_grid(3)))
    held = set(held_vertices(cage))
    others = [v for v in range(cage.n_vertices) if v not in held]
    pins = lib.constraints([*sorted(held)[:2], *others[:2], others[5]], weights=[0.3, 1, 1, 0.5, 0.2])
    result = lib.minimize(cage, levels=1, constraints=pins)
    exact = sorted(held | {others[0]})
    assert result.verdict == "minimum"
    assert np.array_equal(result.mesh.xyz[exact], cage.xyz[exact])


# ------------------------------------------------------------------------------------------- command line --


def run(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([str(PROGRAM), *map(str, arguments)], capture_output=True, text=True, check=False)


def test_loose_vertices_and_lines_are_carried_through(tmp_path):
    cage = joined(perturbed(cube_grid(3), 0.05, 9), [[4, 0, 0], [5, 1, 0]], [])
    n = cage.n_vertices
    path = write_obj(tmp_path / "cage.obj", cage)
    path.write_text(path.read_text() + f"l {n - 1} {n} 1\n")
    for levels in (1, 2):
        out, report = tmp_path / f"{levels}.obj", tmp_path / "report.json"
        done = run("minimize", path, "-o", out, "--levels", levels, "--json", report)
        assert done.returncode == 0 and "isolated" in done.stdout
        lines = out.read_text().splitlines()
        assert lines[n - 2:n] == path.read_text().splitlines()[n - 2:n]
        assert lines[-1] == f"l {n - 1} {n} 1"
        assert json.loads(report.read_text())["held"] == [
            {"reason": "isolated", "count": 2, "vertices": [n - 2, n - 1]}]


def test_report_says_what_is_held(tmp_path):
    cage = cube_grid(3)
    v = inner_vertex(cage)
    path = write_obj(tmp_path / "cage.obj", cage)
    path.write_text(path.read_text() + f"t corner 1/1/0 {v} 10\n")
    around = [f for f, face in enumerate(cage.face_list()) if v in face]
    for command in (["evaluate", path], ["minimize", path, "-o", tmp_path / "out.obj", "--levels", 1]):
        done = run(*command)
        assert done.returncode == 0
        assert "9 of 56 vertices; 4 of 54 faces are left out of the energy" in done.stdout
        assert f"1 vertex: {v} (an infinitely sharp vertex makes a cone)" in done.stdout
        done = run(*command, "--strict")
        assert done.returncode == 1 and f"vertex {v} is infinitely sharp" in done.stderr and not done.stdout
    report = run("evaluate", path, "--json", "-")
    figures = json.loads(report.stdout)
    assert figures["n_held"] == 9 and figures["n_left_out"] == 4
    assert [(entry["reason"], entry["count"]) for entry in figures["held"]] == [("cone", 1), ("beside", 8)]
    assert figures["left_out"][0]["faces"] == around
    assert figures["gauss_bonnet_defect"] is None


def test_tags_that_mean_the_surface_are_honoured(tmp_path):
    n = 5
    points = [[x, y, 0.2 * x * y] for y in np.linspace(-1, 1, n) for x in np.linspace(-1, 1, n)]
    faces = [[n * y + x, n * y + x + 1, n * y + x + n + 1, n * y + x + n] for y in range(n - 1) for x in range(n - 1)]
    path = write_obj(tmp_path / "grid.obj", mesh_from_faces(points, faces))
    plain = path.read_text()

    def figures(tags: str, *options: str) -> dict:
        path.write_text(plain + tags)
        done = run("evaluate", path, "--json", "-", *options)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    round_corners, sharp_corners = figures("")["area"], figures("t interpolateboundary 1/0/0 1\n")["area"]
    assert figures("t interpolateboundary 1/0/0 2\n")["area"] == round_corners < sharp_corners
    assert figures("t interpolateboundary 1/0/0 1\n", "--boundary-rule", "smooth")["area"] == round_corners
    assert figures("t interpolateboundary 1/0/0 0\n")["left_out"] == [
        {"reason": "hole", "count": 12, "faces": [0, 1, 2, 3, 4, 7, 8, 11, 12, 13, 14, 15]}]
    assert figures("t hole 2/0/0 5 6\nt interpolateboundary 1/0/0 1\n")["left_out"][0]["faces"] == [5, 6]
    path.write_text(plain + "t creasemethod 0/0/1 chaikin\nt vertexedit 1/1/1 0 1 x\n")
    assert "tags passed over       creasemethod, vertexedit" in run("evaluate", path).stdout


def test_holes_of_a_result_are_children_of_those_of_the_cage(tmp_path):
    path = write_obj(tmp_path / "cage.obj", perturbed(cube_grid(2), 0.05, 10))
    path.write_text(path.read_text() + "t hole 2/0/0 0 3\n")
    for levels, holes in ((1, [0, 3]), (2, [0, 1, 2, 3, 12, 13, 14, 15]), (3, [*range(16), *range(48, 64)])):
        done = run("minimize", path, "-o", tmp_path / "out.obj", "--levels", levels, "--max-iterations", 2)
        assert done.returncode == 0, done.stderr
        last = (tmp_path / "out.obj").read_text().splitlines()[-1].split()
        assert last == ["t", "hole", f"{len(holes)}/0/0", *map(str, holes)]

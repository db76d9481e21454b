# SPDX-License-Identifier: GPL-3.0-or-later
"""Points, curvatures and colours of limit surfaces, and pictures of a run, against formulas and against the library."""

import numpy as np
import pytest
import shapes
from addon.binding import library
from addon.core import catalogue, colours, curvature, energy, job, memory, messages, snapshot, surface_points


def jets_of(point, at, step=1e-2):
    """Jets (k, 10, 3) of a parametric surface from values on a grid, good to 1e-6."""
    orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
    grid = np.arange(-4, 5)
    powers = np.vander(grid * step, 9, increasing=True)  # values at the grid from a Taylor polynomial of degree 8
    fit = np.linalg.inv(powers)
    factorial = np.array([1, 1, 2, 6])
    result = []
    for u, v in at:
        values = np.array([[point(u + i * step, v + j * step) for j in grid] for i in grid])
        taylor = np.einsum("ai,bj,ijx->abx", fit, fit, values)
        result.append([taylor[a, b] * factorial[a] * factorial[b] for a, b in orders])
    return np.array(result)


def torus_point(u, v, major=2.0, minor=0.7):
    ring = major + minor * np.cos(v)
    return np.array([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)])


def test_curvatures_of_a_sphere_are_those_of_its_radius_and_do_not_vary():
    def sphere(u, v):
        return 2.5 * np.array([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])

    found = curvature.of_jets(jets_of(sphere, at=[(0.3, 0.4), (1.0, -0.6)]))
    for name, value in (("k1", 0.4), ("k2", 0.4), ("H", 0.4), ("K", 0.16)):
        assert getattr(found, name) == pytest.approx(np.full(2, value), abs=1e-6)
    assert found.variation == pytest.approx(np.zeros(2), abs=1e-4)
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(np.ones(2))


def test_curvatures_and_variation_of_a_torus():
    """k1 = 1 / r; k2 = cos v / (R + r cos v), whose derivative by arc length is its only variation: the tensor has it
    three times, in the places of C_112."""
    places = [(0.2, 0.0), (0.9, 0.8), (2.0, 2.5)]
    found = curvature.of_jets(jets_of(torus_point, at=places))
    v = np.array([place[1] for place in places])
    ring = 2.0 + 0.7 * np.cos(v)
    assert found.k1 == pytest.approx(np.full(3, 1 / 0.7), rel=1e-6)
    assert found.k2 == pytest.approx(np.cos(v) / ring, abs=1e-6)
    assert found.K == pytest.approx(np.cos(v) / ring / 0.7, abs=1e-6)
    slope = np.abs(-np.sin(v) / ring + np.cos(v) * 0.7 * np.sin(v) / ring**2) / 0.7
    assert found.variation == pytest.approx(np.sqrt(3) * slope, abs=1e-4)


def mesh_of(points, faces):
    return library.Mesh.create(library.load(), len(points), *shapes.packed(faces))


CAGES = {"torus": shapes.torus(), "cube": shapes.cube(), "prism": shapes.prism()}


@pytest.mark.parametrize("name", CAGES)
@pytest.mark.parametrize("levels", [0, 1, 3])
def test_lattice_has_one_point_per_vertex_whatever_face_it_is_taken_from(name, levels):
    """Its points are those that refining and taking the limit at corners gives."""
    points, faces = CAGES[name]
    with mesh_of(points, faces) as mesh:
        net = surface_points.lattice(mesh, levels)
        seen = net.jets(mesh, points)
        fine, xyz = mesh, np.asarray(points, float)
        while fine.info().n_vertices < len(seen):
            fine, xyz = fine.refine(xyz)
        assert fine.info().n_vertices == len(seen) and np.array_equal(fine.faces()[1], net.quads.reshape(-1))
        corners = np.arange(len(net.quads))
        at_corner = fine.jets(xyz, corners, np.zeros_like(corners), np.zeros((len(corners), 2)))[:, 0]
    assert seen[net.quads[:, 0], 0] == pytest.approx(at_corner, abs=1e-12)
    assert np.isfinite(seen[:, :6]).all()
    assert shapes.enclosed_volume(seen[:, 0], net.quads.tolist()) > 0


def test_integral_of_gauss_curvature_over_the_lattice_is_topological():
    points, faces = shapes.torus()
    with mesh_of(points, faces) as mesh:
        net = surface_points.lattice(mesh, 4)
        jets = net.jets(mesh, points)
    found = curvature.of_jets(jets)
    area = np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1)
    assert abs((found.K * area).mean()) < 1e-3 * (np.abs(found.K) * area).mean()


def test_levels_fit_the_number_of_quads():
    assert [surface_points.levels_for(n, 24_000) for n in (1, 32, 6_000, 6_001, 30_000)] == [4, 4, 1, 0, 0]


def test_face_edges_are_each_there_once():
    _, faces = shapes.prism()
    edges = surface_points.face_edges(*map(np.array, shapes.packed(faces)))
    assert edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]]


def test_colours_put_nothing_in_the_middle_and_clip_outliers():
    values = np.array([-1.0, 0.0, 1.0, 2.0, np.nan, np.inf])
    low, high = colours.value_range("H", np.concatenate([np.linspace(-1, 1, 100), [1e9]]))
    assert -low == high and 0.9 < high < 1.1
    shown = colours.colours("H", values, -1.0, 1.0)
    assert shown[1, :3] == pytest.approx([0.93] * 3) and np.array_equal(shown[2], shown[3])
    assert np.array_equal(shown[5], shown[2]) and np.array_equal(shown[4], shown[0])
    assert colours.value_range("variation", np.array([0.0, 1.0]))[0] == 0.0
    assert colours.value_range("H", np.zeros(4)) == (-1.0, 1.0)
    assert colours.value_range("distance", np.array([*np.zeros(99), 7.0])) == (0.0, 7.0)


# ------------------------------------------------------------------------------------------------- pictures of a run --


def torus_cage():
    points, faces = shapes.torus()
    sizes, vertices = shapes.packed(faces)
    return library.Cage(points, np.array(sizes), np.array(vertices))


def test_a_run_is_seen_from_its_start_and_only_as_often_as_asked():
    watcher, seen = snapshot.Watcher(), []
    watcher._not_before = 0.0

    def on_progress(progress):
        seen.append(watcher.latest)
        if progress.level == 1:
            watcher._not_before = 0.0
            watcher.ask()

    job.solve(torus_cage(), job.Request("willmore", 3, {"threads": 1}), on_progress, watcher=watcher)
    assert seen[0].progress is None or seen[0].progress.level == 1
    levels = [picture.progress.level for picture in seen if picture.progress is not None]
    assert 1 in levels and 3 not in levels  # asked for once more at most after level 1
    first, last = seen[0], seen[-1]
    assert len(first.points) == 32 * 4**4 and first.cage.shape == (32, 3) and len(first.edges) == 64
    assert first.points.dtype == np.float32 and first.triangles.max() == len(first.points) - 1
    assert np.abs(np.linalg.norm(first.normals, axis=1) - 1).max() < 1e-5
    assert np.abs(last.points.mean(0)).max() < 1e-3


def test_pictures_show_the_iterate_of_their_time():
    """The last cage shown before the end of level 1 is where the run then stood: its energy is the progress's."""
    watcher, cage = snapshot.Watcher(), torus_cage()

    def on_progress(_progress):
        watcher._not_before = 0.0
        watcher.ask()

    job.solve(cage, job.Request("willmore", 1, {"threads": 1}), on_progress, watcher=watcher)
    picture, lib = watcher.latest, library.load()
    with library.Mesh.of_cage(lib, cage) as mesh:
        with library.Problem.create(mesh, lib.options({"willmore": 1.0})) as problem:
            energies, _ = problem.evaluate(picture.cage)
    assert energies.objective == pytest.approx(picture.progress.energy, rel=3e-4)


def test_result_carries_the_start_subdivided_as_often():
    solution = job.solve(torus_cage(), job.Request("willmore", 3))
    with mesh_of(*shapes.torus()) as mesh:
        points = shapes.torus()[0]
        for _ in range(2):
            mesh, points = mesh.refine(points)
    assert np.array_equal(solution.start_positions, points)
    assert len(solution.start_positions) == len(solution.cage.positions)


def test_the_history_is_of_every_step():
    work = job.Job.minimize(torus_cage(), job.Request("willmore", 2))
    work.start()
    assert work.join(60) and work.error is None
    assert [level for _, level, _ in work.history] == sorted(level for _, level, _ in work.history)
    assert work.history[-1][2] == work.latest.energy and len(work.history) > 4


# ------------------------------------------------------------------------------------------- energies and catalogue --


def test_a_mix_is_minimized_as_the_sum_of_its_parts():
    solution = job.solve(torus_cage(), job.Request("willmore:2,mvs:0.5", 1))
    for energies in (solution.start, solution.end):
        parts = 2 * energies.terms["willmore"] + 0.5 * energies.terms["mvs"]
        assert energies.objective == pytest.approx(parts, rel=1e-9)
    assert solution.end.objective < solution.start.objective
    assert messages.solution_text(job.Request("willmore:2,mvs:0.5"), solution).startswith("2 Willmore + 0.5 MVS ")


@pytest.mark.parametrize(
    "text, weights", [("mvs", {"mvs": 1.0}), ("mvs:1, willmore:0.1", {"mvs": 1.0, "willmore": 0.1})]
)
def test_mixes_are_read_and_written(text, weights):
    assert energy.weights_of(text) == weights
    assert energy.weights_of(energy.text_of(weights)) == weights


@pytest.mark.parametrize(
    "text, why",
    [("", "empty"), ("bend", "no energy 'bend'"), ("mvs:x", "'x' is no weight"), ("mvs:-1", "0 or more"),
     ("mvs:nan", "0 or more"), ("mvs:0", "empty"), ("area:1", "empty"), ("mvs,mvs", "twice")],
)  # fmt: skip
def test_what_is_no_mix_says_why(text, why):
    with pytest.raises(ValueError, match=why):
        energy.weights_of(text)


def test_every_cage_of_the_catalogue_is_a_surface():
    assert {"lawson_g2", "torus_050", "mug_g1"} <= set(catalogue.names())
    assert catalogue.label("lawson_g2") == "Lawson genus 2" and catalogue.label("torus_015") == "Torus 0.15"
    lib = library.load()
    for name in catalogue.names():
        cage = catalogue.load(name)
        with library.Mesh.of_cage(lib, cage) as mesh:
            info = mesh.info()
            assert (info.n_vertices, info.n_faces) == (len(cage.positions), len(cage.face_sizes)), name


def test_a_cage_that_is_not_there_or_broken_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(catalogue, "folder", lambda: tmp_path)
    with pytest.raises(OSError):
        catalogue.load("none")
    for text in ("", "v 0 0 0\nf 1 2 3\n"):
        (tmp_path / "bad.obj").write_text(text)
        with pytest.raises(ValueError, match="holds no cage"):
            catalogue.load("bad")


# ------------------------------------------------------------------------------------------------------------ memory --


def test_memory_of_this_machine_is_known():
    assert 1e7 < memory.used() < 1e11 and 1e8 < memory.available() < 1e14


def test_a_cage_beyond_memory_is_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(memory, "available", lambda: 1e5)
    with pytest.raises(memory.MemoryRefusal, match="The cage has 32 vertices.* use a coarser cage"):
        job.solve(torus_cage(), job.Request("willmore", 1))


def test_a_level_beyond_memory_is_not_begun_and_the_levels_before_are_kept(monkeypatch):
    """As if the process grew by 1 MB per vertex, on a machine that has room for 128 vertices but not for 512."""
    vertices = [32]
    monkeypatch.setattr(memory, "used", lambda: 1e6 * vertices[0])
    monkeypatch.setattr(memory, "available", lambda: 400e6)

    def on_progress(progress):
        vertices[0] = max(vertices[0], progress.n_vertices)

    monkeypatch.setattr(memory.Guard, "__init__", guard_from_nothing)
    solution = job.solve(torus_cage(), job.Request("willmore", 5), on_progress)
    assert solution.stop == "memory"
    assert [level.level for level in solution.levels if level.iterations] == [1, 2]
    assert "needs more memory" in messages.solution_text(job.Request("willmore", 5), solution)
    assert solution.end.objective < solution.start.objective


def guard_from_nothing(self):
    self.stopped, self._start, self._level, self._most = False, 0.0, 1, 0.0

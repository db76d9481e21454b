# SPDX-License-Identifier: GPL-3.0-or-later
"""Worker and modal state machine: with invented work where order matters, with the library where energies do."""

import dataclasses
import math
import threading
import time

import numpy as np
import pytest
import shapes
from addon.binding import abi, library, locate, measure
from addon.binding.values import Cage, Exceptions, Held
from addon.core import energy, job, least, messages


def progress(iteration: int) -> library.Progress:
    return library.Progress(90.0 - iteration, 100.0, 0.5, 1.0, 2, 4, iteration, 2 * iteration, 32)


class Gated:
    """Work that reports one step per `allow()` and ends when allowed `steps` times or told to cancel."""

    def __init__(self, steps: int, outcome: object = "solution") -> None:
        self.steps, self.outcome = steps, outcome
        self.gate, self.reported = threading.Semaphore(0), threading.Semaphore(0)
        self.saw_cancel = False

    def __call__(self, on_progress):
        for step in range(self.steps):
            assert self.gate.acquire(timeout=300)
            self.saw_cancel = bool(on_progress(progress(step)))
            self.reported.release()
            if self.saw_cancel:
                break
        if isinstance(self.outcome, BaseException):
            raise self.outcome
        return self.outcome

    def allow(self) -> None:
        self.gate.release()
        assert self.reported.acquire(timeout=300)


@pytest.mark.parametrize("residual, end, text", [
    (1e-9, 4.0, ""), (-1e-9, 4.0, ""), (2e-8, 4.0, "The volume could not be kept, it is 2e-06 % off"),
    (-0.0123, 4.0, "The volume could not be kept, it is 1.2 % off"), (0.5, math.nan, "The volume could not be kept"),
    (math.nan, 4.0, "The volume could not be kept"),
])  # fmt: skip
def test_a_volume_that_was_not_kept_is_said(residual, end, text):
    solution = job.solve(torus_cage(), job.Request("willmore", 1, {"max_iterations": 1}))
    solution = dataclasses.replace(
        solution, scalar_residuals={"volume": residual}, end=dataclasses.replace(solution.end, volume=end)
    )
    assert messages.volume_text(job.Request(keeps_volume=True), solution) == text
    assert messages.volume_text(job.Request(), solution) == ""
    left_out = dataclasses.replace(solution, exceptions=Exceptions((), 9, 4))
    said = messages.volume_text(job.Request(keeps_volume=True), left_out)
    assert said == (text or "Keep Volume does not see the faces that are left out: the volume under them may change")
    assert messages.volume_text(job.Request(), left_out) == ""


def test_ticks_follow_the_worker_to_its_end():
    work = Gated(2)
    run = job.ModalRun(job.Job(work), "MVS")
    assert run.tick() is job.Phase.RUNNING and "preparing" in messages.status_text(run)
    work.allow()
    assert run.tick() is job.Phase.RUNNING
    assert "MVS: level 2 of 4, iteration 0, energy 90 (from 100)" in messages.status_text(run)
    work.allow()
    assert run.job.join(20)
    assert run.tick() is job.Phase.FINISHED
    assert run.job.solution == "solution" and run.job.error is None


def test_escape_ends_the_run_at_once_and_the_worker_at_its_next_step():
    work, asked = Gated(5), []
    run = job.ModalRun(job.Job(work, lambda: asked.append(1)), "MVS")
    work.allow()
    run.escape()
    run.escape()
    assert asked == [1]
    assert run.tick() is job.Phase.CANCELLED and run.job.running
    work.allow()
    assert work.saw_cancel and run.job.join(20)
    assert run.tick() is job.Phase.CANCELLED


def test_finishing_early_ends_as_finished_with_what_the_worker_has():
    work = Gated(5)
    run = job.ModalRun(job.Job(work), "MVS")
    work.allow()
    run.finish()
    assert run.tick() is job.Phase.FINISHING and "best surface so far" in messages.status_text(run)
    work.allow()
    assert work.saw_cancel and run.job.join(20)
    assert run.tick() is job.Phase.FINISHED and run.job.solution == "solution"


def test_escape_after_finish_still_changes_nothing():
    work = Gated(5)
    run = job.ModalRun(job.Job(work), "MVS")
    run.finish()
    run.escape()
    work.allow()
    assert run.job.join(20) and run.tick() is job.Phase.CANCELLED


def test_escape_wins_over_a_worker_that_has_just_finished():
    work = Gated(1)
    run = job.ModalRun(job.Job(work), "MVS")
    work.allow()
    assert run.job.join(20)
    run.escape()
    assert run.tick() is job.Phase.CANCELLED


def test_escape_after_the_end_changes_nothing():
    work = Gated(0)
    run = job.ModalRun(job.Job(work), "MVS")
    assert run.job.join(20) and run.tick() is job.Phase.FINISHED
    run.escape()
    assert run.tick() is job.Phase.FINISHED


def test_failure_is_kept_for_the_main_thread():
    error = library.CurvoptError(4, 3, "Face 3 is flipped.")
    run = job.ModalRun(job.Job(Gated(0, error)), "MVS")
    assert run.job.join(20)
    assert run.tick() is job.Phase.FAILED
    assert run.job.error is error and run.job.solution is None


def test_failure_while_cancelling_is_a_cancellation():
    work = Gated(1, RuntimeError("late"))
    run = job.ModalRun(job.Job(work), "MVS")
    run.escape()
    work.allow()
    assert run.job.join(20)
    assert run.tick() is job.Phase.CANCELLED


def test_abandoning_waits_for_the_worker_but_not_for_ever():
    work = Gated(1)
    run = job.ModalRun(job.Job(work), "MVS")
    start = time.monotonic()
    assert run.abandon(0.05) is False and time.monotonic() - start < 5
    assert run.phase is job.Phase.CANCELLED and run.job.running
    work.allow()
    assert run.abandon(20) is True


def torus_cage() -> library.Cage:
    points, faces = shapes.torus()
    sizes, vertices = shapes.packed(faces)
    return library.Cage(points, np.array(sizes), np.array(vertices))


def test_solve_carries_everything_that_the_result_object_needs():
    solution = job.solve(torus_cage(), job.Request("willmore", 2, {"max_iterations": 30}))
    assert solution.cage.positions.shape == (128, 3)
    assert solution.end.terms["willmore"] < solution.start.terms["willmore"]
    assert [level.level for level in solution.levels] == [1, 2] and solution.euler == 0
    text = messages.solution_text(job.Request("willmore", 2), solution)
    assert text.startswith("Willmore ") and "128 vertices" in text


def test_an_energy_that_could_not_fall_is_said_once():
    """Of a flat cage it is 0; of a cube, with its symmetries, it is that of the input."""
    flat = library.Cage(np.array([(x, y, 0) for y in range(3) for x in range(3)], float), np.full(4, 4),
                        np.array([0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7]))  # fmt: skip
    request = job.Request("willmore", 1, strength=0.3)
    text = messages.solution_text(request, job.solve(flat, request), "Remark")
    assert text.startswith("Willmore is 0 already, the least that there is (9 vertices, ") and text.endswith(" s). Remark")
    points, faces = shapes.cube()
    cube = library.Cage(points, *(np.array(part) for part in shapes.packed(faces)))
    text = messages.solution_text(request, job.solve(cube, request))
    assert text.startswith("Willmore is 25.5 as before, stayed near the original (strength 0.3), converged ")


def test_a_run_that_left_next_to_all_as_it_was_says_what_to_do():
    points, faces = shapes.cube()
    cube = library.Cage(points, *(np.array(part) for part in shapes.packed(faces)))
    points, faces = shapes.bottle()
    bumpy = library.Cage(np.asarray(points, float), *(np.array(part) for part in shapes.packed(faces)))
    said = []
    for strength, cage in ((0.3, cube), (1.0, cube), (0.3, bumpy)):
        request = job.Request("willmore", 1, strength=strength)
        solution = job.solve(cage, request)
        said.append(messages.unchanged_text(request, solution))
        assert messages.unchanged_text(request, dataclasses.replace(solution, stop="cancelled")) == ""
    assert said[0].startswith("Strength 0.3 takes short bumps only") and said[1:] == ["", ""]


def test_strength_below_1_stays_near_the_cage_and_says_so():
    points = torus_cage().positions + 0.05 * np.random.default_rng(1).normal(size=(32, 3))
    cage = dataclasses.replace(torus_cage(), positions=points)
    near, far = (job.solve(cage, job.Request("willmore", 1, strength=strength)) for strength in (0.3, 1.0))
    distances = [np.linalg.norm(solution.cage.positions - points, axis=1).max() for solution in (near, far)]
    assert distances[0] < 0.2 * distances[1]
    text = messages.solution_text(job.Request("willmore", 1, strength=0.3), near)
    assert ", stayed near the original (strength 0.3), " in text
    assert "near" not in messages.solution_text(job.Request(), far)
    verdict = messages.verdict_of(job.Request("willmore", 1, strength=0.3), near)
    assert verdict == "Checked: a local minimum of energy and nearness to the original together."


def test_measuring_is_cancelled_too(monkeypatch):
    """A flag that is raised when the run is over: the result is there, without what was not measured."""
    true = job.measure.deviation

    def late(mesh, xyz, other, other_xyz, threads=0, cancel=None):
        cancel.request()
        return true(mesh, xyz, other, other_xyz, threads, cancel)

    with job.library.Cancel.create(job.library.load()) as cancel:
        monkeypatch.setattr(job.measure, "deviation", late)
        solution = job.solve(torus_cage(), job.Request("willmore", 1), cancel=cancel)
    assert solution.stop != "cancelled" and solution.deviation is None and solution.crossings is None
    assert messages.solution_text(job.Request("willmore", 1), solution)


def test_job_runs_the_library_beside_this_thread_and_cancels_fast():
    work = job.Job.minimize(torus_cage(), job.Request("mvs", 6))
    work.start()
    deadline = time.monotonic() + 300  # a busy machine
    while work.latest is None and work.running and time.monotonic() < deadline:
        time.sleep(0.01)
    assert work.latest is not None and work.latest.levels == 6
    start = time.process_time()
    work.cancel()
    assert work.join(300)
    assert time.process_time() - start < 2.0
    assert work.solution.stop == "cancelled" and work.error is None


def test_job_without_a_library_fails_before_it_starts(monkeypatch, tmp_path):
    monkeypatch.setenv(locate.LIBRARY_VARIABLE, str(tmp_path / "none.so"))
    with pytest.raises(library.LibraryError, match="missing"):
        job.Job.minimize(torus_cage(), job.Request())


@pytest.mark.parametrize(
    "value, text",
    [(78.95683, "78.957"), (1317412.6, "1,317,413"), (0.00012345678, "0.00012346"), (2e9, "2e+09")],
)
def test_energies_are_written_for_people(value, text):
    assert energy.number_text(value) == text


def test_boundary_of_the_request_reaches_the_library():
    cage, moved = torus_cage(), {}
    opened = library.Cage(cage.positions, cage.face_sizes[1:], cage.face_vertices[4:])
    for boundary in abi.BOUNDARIES:
        end = job.solve(opened, job.Request("willmore", 1, {"max_iterations": 5}, boundary)).cage.positions
        moved[boundary] = (np.abs(end - cage.positions).max(axis=1) > 0).sum()
    assert moved["free"] == 32 > moved["position"] == 28 > moved["tangent"] > moved["curvature"]


def test_creases_of_the_cage_reach_the_library():
    cage = torus_cage()
    ring = np.array([[4 * i, 4 * ((i + 1) % 8)] for i in range(8)])
    request = job.Request("willmore", 1, {"max_iterations": 5})
    creased = dataclasses.replace(cage, creases=library.Creases(ring, np.full(8, 10.0)))
    plain, sharp = job.solve(cage, request), job.solve(creased, request)
    assert sharp.start.terms["willmore"] != pytest.approx(plain.start.terms["willmore"], rel=1e-2)
    assert np.array_equal(sharp.cage.positions[ring], cage.positions[ring])


BLOCK = np.arange(20)  # of the torus: five of its eight rings
INNER_FACES = np.arange(4, 12)  # all of whose neighbours have only vertices of these


def solve_holding(held, levels, symmetry="keep", iterations=5):
    options = {"max_iterations": iterations, "threads": 1}
    return job.solve(torus_cage(), job.Request("mvs", levels, options, symmetry=symmetry, held=Held.exactly(held)))


@pytest.mark.parametrize("symmetry", [name for name in abi.SYMMETRIES if name != "planes"])
@pytest.mark.parametrize("held", [np.array([0]), np.array([1, 6, 30]), BLOCK])
def test_held_vertices_of_the_request_stay(held, symmetry):
    moved = np.abs(solve_holding(held, 1, symmetry).cage.positions - torus_cage().positions)
    assert moved[held].max() == 0 and np.delete(moved, held, 0).max() > 1e-3


def test_the_surface_stays_where_faces_and_their_neighbours_are_held():
    """Its points at two opposite corners of such faces; elsewhere it moves."""
    cage, moved = torus_cage(), []
    start = corner_points(cage, np.arange(32))
    for levels in (1, 2, 3):
        children = np.arange(32) * 4 ** (levels - 1)  # the first child is the one at the face's first corner
        distance = np.linalg.norm(corner_points(solve_holding(BLOCK, levels).cage, children) - start, axis=1)
        assert distance[INNER_FACES].max() < 1e-14
        moved.append(distance.max())
    assert min(moved) > 1e-2


def test_symmetry_is_a_name_or_planes():
    assert [job.symmetry_of(name) for name in ("auto", "keep")] == [(0, 0), (3, 0)]
    assert [job.symmetry_of(text)[1] for text in ("x", "z", "y,x", "x,y,z", "z,z")] == [1, 4, 3, 7, 4]
    assert job.symmetry_of("y")[0] == abi.SYMMETRIES.index("planes")
    for text in ("planes", "", "x,", "xy", "w", "x, y", "all"):
        with pytest.raises(ValueError, match=f"no symmetry '{text}'; there are auto, none, rotations, keep, and"):
            job.symmetry_of(text)


@pytest.mark.parametrize("planes, order", [("x", 2), ("y,z", 4), ("x,y,z", 8)])
def test_chosen_planes_are_kept(planes, order):
    solution = job.solve(torus_cage(), job.Request("willmore", 2, {"threads": 1}, symmetry=planes))
    assert solution.symmetry_order == order
    for axis in ("xyz".index(plane) for plane in planes.split(",")):
        points = solution.cage.positions
        image = points * np.where(np.arange(3) == axis, -1, 1)
        assert np.linalg.norm(image[:, None] - points[None], axis=2).min(axis=1).max() < 1e-12


def corner_points(cage, faces):
    """Points (k, 3) of the surface at the first corner of faces (k,)."""
    with library.Mesh.create(library.load(), len(cage.positions), cage.face_sizes, cage.face_vertices) as mesh:
        return mesh.jets(cage.positions, faces, np.zeros_like(faces), np.zeros((len(faces), 2)))[:, 0]


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("held, order", [([], 32), ([0, 4, 8, 12, 16, 20, 24, 28], 32), ([0, 16], 8), ([0], 4)])
def test_result_has_the_symmetries_of_cage_and_held_vertices(held, order, levels):
    """To rounding: mirror images in the planes x = 0 (but for one vertex held), y = 0 and z = 0."""
    solution = solve_holding(np.array(held, np.int32), levels)
    assert solution.symmetry_order == order
    points = solution.cage.positions
    for axis in range(3) if order > 4 else (1, 2):
        mirrored = points * np.where(np.arange(3) == axis, -1, 1)
        distances = np.linalg.norm(mirrored[:, None] - points[None], axis=2)
        assert distances.min(axis=1).max() < 1e-12


def test_symmetries_are_kept_only_if_wanted_and_there():
    assert solve_holding([], 1, "none").symmetry_order == 1
    cage = torus_cage()
    shaken = cage.positions + 1e-3 * np.random.default_rng(4).normal(size=(32, 3))
    request = job.Request("willmore", 1, {"max_iterations": 2})
    assert job.solve(dataclasses.replace(cage, positions=shaken), request).symmetry_order == 1


def test_the_report_says_how_many_symmetries_were_kept():
    solution = solve_holding(np.empty(0, np.int32), 1)
    assert "(32 vertices, 32 symmetries kept, " in messages.solution_text(job.Request("mvs"), solution)
    assert "symmetr" not in messages.solution_text(job.Request("mvs"), dataclasses.replace(solution, symmetry_order=1))


def test_a_minimum_of_symmetric_shapes_is_called_no_more_than_that():
    text = messages.verdict_text(library.Verification("minimum", 1e-9, 0), 100.0, 12)
    assert text == "Checked: a true local minimum among shapes of the same symmetry."


@pytest.mark.parametrize(
    "verdict, decrement, directions, text",
    [
        ("minimum", 1e-9, 0, "Checked: a true local minimum."),
        ("saddle", 1e-9, 1, "Checked: a saddle, 1 direction would still lead down."),
        ("saddle", 1e-9, -1, "Checked: a saddle, some directions would still lead down."),
        ("not stationary", 2.345e-3, 0, "Checked: not yet a minimum, about 0.0023 % less seems possible."),
        ("not stationary", 2.345e-3, 3, "Checked: not yet a minimum, about 0.0023 % less seems possible, more along 3 "
                                        "directions."),
        ("not stationary", 2.345e5, 0, "Checked: not yet a minimum, much less seems possible."),
        ("not stationary", math.nan, 0, "Checked: not yet a minimum, less seems possible."),
        ("unknown", math.nan, -1, "Not checked: whether this is a minimum is not known."),
    ],
)  # fmt: skip
def test_verdicts_are_written_for_people(verdict, decrement, directions, text):
    assert messages.verdict_text(library.Verification(verdict, decrement, directions), 100.0) == text


@pytest.mark.parametrize("rise, energy, raised", [(25, 100.0, "by 25 %"), (250, 100.0, "to 3.5 times as much"), (1, 0.0, "far")])
def test_what_a_touch_does_is_said_where_a_minimum_does_not_bear_it(rise, energy, raised):
    delicate = library.Verification("minimum", 1e-9, 0, rise, True)
    assert messages.delicacy_text(delicate, energy) == (
        f" It is delicate: with its vertices moved by a thousandth of an edge it rises {raised}, and minimized again from "
        "there it may end elsewhere."
    )
    assert messages.delicacy_text(dataclasses.replace(delicate, is_delicate=False), energy) == ""


# ------------------------------------------------------------------------------------- where nothing may move --


def cage(points, faces):
    sizes, vertices = shapes.packed(faces)
    return Cage(np.array(points, float), np.array(sizes, np.int32), np.array(vertices, np.int32))


def quad():
    return cage([(0, 0, 0), (1, 0, 0), (1, 1, 0.3), (0, 1, 0)], [[0, 1, 2, 3]])


@pytest.mark.parametrize("boundary, levels", [("free", 1), ("position", 2), ("tangent", 3), ("curvature", 1)])
def test_a_cage_that_cannot_move_is_refined_up_to_twice(boundary, levels):
    """Three rows of vertices stay with `curvature`: that takes three subdivisions."""
    wanted = job.Request("willmore", 1, boundary=boundary, strength=0.3)
    request = job.freed(quad(), wanted)
    assert (request.levels, request.refined) == (levels, levels - 1)
    assert all(getattr(request, name) is value for name, value in vars(wanted).items() if name not in ("levels", "refined"))
    assert bool(messages.refined_text(request)) == (levels > 1)


def test_other_cages_and_requests_stay_as_they_are():
    around, pins = cage(*shapes.torus()), Held.exactly(np.arange(32))
    for shape, request in (
        (around, job.Request("willmore", 1)),
        (around, job.Request("willmore", 1, held=pins)),  # refining frees nothing where all of a face is pinned
        (quad(), job.Request("willmore", 2, boundary="tangent")),  # asked for so many levels
        (cage(*shapes.grid(3)), job.Request("mvs", 1)),
    ):
        assert job.freed(shape, request) is request
    with pytest.raises(library.CurvoptError, match="nothing may move: all 32 vertices"):
        job.solve(around, job.Request("willmore", 1, held=pins))


def test_pins_that_hold_half_of_the_faces_do_not_hold_what_refining_adds():
    shape, pins = cage(*shapes.grid(1)), Held.exactly([0, 1])
    request = job.freed(shape, job.Request("willmore", 1, held=pins))
    solution = job.solve(shape, request)
    assert request.levels == 2 and len(solution.cage.positions) == 9
    assert solution.verification.verdict == "minimum"


def test_the_report_says_why_a_cage_was_refined():
    text = "The cage was refined {}, because all of its own vertices are held by boundary, creases or pins"
    assert messages.refined_text(job.Request("willmore", 2, refined=1)) == text.format("once")
    assert messages.refined_text(job.Request("willmore", 3, refined=2)) == text.format("twice")
    assert messages.refined_text(job.Request("willmore", 3)) == ""


def test_an_open_surface_that_grows_is_said_to():
    """Five vertices hold it in the frame, and its boundary is free; not where the boundary is held, nor a closed one."""
    points, faces = shapes.grid(4)
    x, y = points[:, 0], points[:, 1]
    bump = np.stack([x, y, 1.2 - 0.15 * ((x - 2) ** 2 + (y - 2) ** 2) + 0.02 * ((7 * x + 3 * y) % 5)], axis=1)
    shape, pins = cage(bump, faces), Held.exactly([6, 8, 12, 16, 18])
    request = job.Request("willmore", 1, held=pins, boundary="free")
    solution = job.solve(shape, request)
    times = solution.end.area / solution.start.area
    assert solution.stop == "grown" and times > 10
    assert messages.growth_text(request, solution) == (
        f"The surface has {times:.3g} times the area that it had: with a free boundary bending falls as it grows. "
        "Hold the boundary, or more vertices"
    )
    assert "stopped early: the surface grows without end" in messages.solution_text(request, solution)
    assert messages.growth_text(dataclasses.replace(request, boundary="position"), solution) == ""
    closed = dataclasses.replace(solution, cage=cage(*shapes.torus()))
    assert messages.growth_text(request, closed) == ""
    kept = job.Request("willmore", 1, held=pins)
    assert messages.growth_text(kept, job.solve(shape, kept)) == ""


def test_refusals_use_blenders_words():
    cone = library.load().c.curvopt_exception_text(abi.EXCEPTIONS.index("cone")).decode()
    assert messages.failure_text(library.CurvoptError(6, 3, f"vertex 3, where {cone}")) == (
        "Vertex 3, where a vertex crease of 1, or the end of a loose edge, makes a cone."
    )


def test_failures_become_one_sentence():
    assert messages.failure_text(library.CurvoptError(4, 1, "face 1 is bad")) == "Face 1 is bad."
    assert messages.failure_text(library.LibraryError("Gone.")) == "Gone."
    assert messages.failure_text(KeyError("x")) == "Unexpected KeyError: 'x'."


def test_solutions_say_how_far_and_whether_they_cross():
    points, faces = shapes.cube()
    cube = library.Cage(points, *(np.array(part) for part in shapes.packed(faces)))
    solution = job.solve(cube, job.Request(energy="willmore", levels=2))
    assert 0 < solution.deviation.max <= solution.deviation.bound <= 1.2 * solution.deviation.max
    text = messages.deviation_text(solution)
    assert text.startswith("Farthest from the original: ") and "root mean square" in text
    assert messages.crossings_text(solution) == "" and solution.crossings.is_complete
    crossed = dataclasses.replace(solution, crossings=dataclasses.replace(solution.crossings, n_pairs=2))
    assert messages.crossings_text(crossed) == "The surface crosses itself at 2 pairs of faces"
    before = dataclasses.replace(crossed, n_crossing_before=3)
    assert messages.crossings_text(before) == "The surface crosses itself at 2 pairs of faces, the original at 3"
    stopped = job.solve(cube, job.Request(energy="mvs", levels=3), lambda progress: True)
    assert stopped.deviation is None and messages.deviation_text(stopped) == messages.crossings_text(stopped) == ""


def test_what_crosses_in_the_original_is_counted_where_the_result_crosses():
    points, faces = shapes.cube()
    both, n = np.concatenate([points, np.asarray(points) + [0.9, 0.2, 0.1]]), len(points)
    faces = [*faces, *([v + n for v in face] for face in faces)]
    cage = library.Cage(both, *(np.array(part) for part in shapes.packed(faces)))
    solution = job.solve(cage, job.Request(energy="willmore", levels=1))
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        found = measure.crossings(mesh, cage.positions).n_pairs
    assert solution.crossings.n_pairs > 0 and solution.n_crossing_before == found > 0


def test_a_folded_mesh_is_unfolded_and_named():
    """Before a run, all of it or a part; not where what is folded is held."""
    points, faces = shapes.torus(8, 6, 1.0, 0.4)
    corners = faces[3]
    points = points.copy()
    points[corners[0]] += 3.5 * (points[corners[1]] - points[corners[0]]) + 0.3 * (points[corners[3]] - points[corners[0]])
    cage = library.Cage(points, *(np.array(part) for part in shapes.packed(faces)))
    solution = job.solve(cage, job.Request(energy="willmore", levels=1))
    assert solution.verification.verdict == "minimum" and len(solution.folded) == solution.n_unfolded == 2
    one, two = solution.folded
    named = f"The original is folded (face {one}, face {two})"
    assert messages.folds_text(solution) == f"{named}: 2 vertices were put between their neighbours first"
    held = Held.exactly(np.unique(np.concatenate([faces[one], faces[two]])))
    stuck = job.solve(cage, job.Request(energy="willmore", levels=1, held=held, options={"max_iterations": 3}))
    assert messages.folds_text(stuck) == f"{named}, so that the energy is infinite: move vertices back that lie beyond others"
    flat = library.Cage(shapes.torus(8, 6)[0], *(np.array(part) for part in shapes.packed(faces)))
    assert messages.folds_text(job.solve(flat, job.Request(energy="willmore", levels=1))) == ""


def test_the_verdict_says_what_theorems_say_of_bending():
    """Of a Clifford torus and a sphere with levels enough to know the error; not after one level, of MVS, nor of a
    multiple of the energy."""

    def verdict(cage, energy="willmore", levels=3):
        request = job.Request(energy, levels)
        return messages.verdict_of(request, job.solve(cage, request))

    points, faces = shapes.cube()
    cube = library.Cage(points, *(np.array(part) for part in shapes.packed(faces)))
    torus = torus_cage()
    assert verdict(torus).endswith(" No surface of genus 1 has less, within the error (Marques and Neves 2014).")
    assert "genus 1" in verdict(torus, "mean_curvature") and "Willmore 1965" in verdict(cube)
    assert "genus" not in verdict(torus, levels=1) and "genus" not in verdict(torus, "mvs")
    assert "genus" not in verdict(torus, "willmore:2")


def test_least_energies():
    assert least.least("willmore", 2) == pytest.approx(8 * math.pi) and least.least("willmore", 0) == pytest.approx(8 * math.pi**2)
    assert least.least("mean_curvature", 0) == pytest.approx(2 * math.pi**2) and least.least("mvs", 0) is None
    assert least.least("willmore", -2) is None and least.least("willmore", 1) is None
    assert least.is_least(10.05, 10.0, 0.06, 0.001) and not least.is_least(10.07, 10.0, 0.06, 0.001)
    assert not least.is_least(9.99, 10.0, 0.06, 0.001), "below a theorem's bound"
    assert not least.is_least(10.0, 10.0, math.nan, 0.0) and not least.is_least(11.0, 10.0, 2.0, 0.0), "too much is open"


def test_a_run_that_was_ended_before_its_first_step_has_found_nothing():
    shape, request = cage(*shapes.quad_sphere()), job.Request("willmore", 2)
    flag = library.Cancel.create(library.load())
    flag.request()
    assert job.solve(shape, request, cancel=flag).is_empty
    assert job.solve(shape, request, lambda progress: True).is_empty
    assert not job.solve(shape, request, lambda progress: progress.iteration >= 2).is_empty
    assert not job.solve(shape, request).is_empty
    assert messages.nothing_found_text("Willmore").startswith("Minimizing Willmore was ended before its first step: nothing was found yet")

# SPDX-License-Identifier: GPL-3.0-or-later
"""The session of a surface that follows the hand, without Blender: what it shows, where it ends, and how it ends."""

import dataclasses
import threading
import time

import numpy as np
import pytest
import shapes
from addon.binding import library, locate
from addon.binding.values import Cage, Held
from addon.core import job, live, messages

PINS = np.array([0, 9, 18, 27])
FOLDED = 20  # a face that has none of these


def shaken_torus(noise: float = 0.05) -> Cage:
    points, faces = shapes.torus()
    sizes, vertices = shapes.packed(faces)
    points = points + noise * np.random.default_rng(3).normal(size=points.shape)
    return Cage(points, np.array(sizes), np.array(vertices))


def request_of(cage: Cage, strength: float = 1.0, **fields) -> job.Request:
    return job.Request("willmore", 1, {"threads": 2}, held=Held.exactly(PINS), strength=strength, **fields)


def wait(condition, seconds: float = 300.0) -> None:
    """Until it holds; a busy machine takes its time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "the awaited condition never came true"
        time.sleep(0.002)


@pytest.fixture
def session():
    """Starts sessions, and has every one of them end with its thread."""
    begun = []

    def start(cage, request, places, recorder=None):
        begun.append(live.Live(cage, request, places, recorder))
        begun[-1].start()
        return begun[-1]

    yield start
    for one in begun:
        assert one.close(300)
    assert not [thread for thread in threading.enumerate() if thread.name == "curvopt"]


def drag(one, request, places, way, steps: int) -> np.ndarray:
    """The first pin along `way` (3,), as fast as the session shows first answers; the places at its end."""
    for step in range(1, steps + 1):
        moved = places.copy()
        moved[0] += way * step / steps
        one.aim(request, moved)
        wait(lambda: one.latest is not None and one.latest.number == one.number or one.error)
        one.seen(one.latest)
    return moved


def energy_of(cage: Cage, request: job.Request, positions: np.ndarray) -> float:
    """Of a cage, by finer rules than any run uses."""
    lib = library.load()
    with library.Mesh.of_cage(lib, cage) as mesh:
        options = lib.options({"willmore": 1.0}, tolerance=1e-9)
        with library.Problem.create(mesh, options) as problem:
            return problem.evaluate(positions)[0].objective


@pytest.mark.parametrize("strength", [1.0, 0.3])
def test_a_drag_ends_where_a_session_from_the_cage_ends(session, strength):
    """Evenly spaced vertices of this torus may come to rest in two places in the surface, 5.6e-5 of the energy apart, and which it
    is depends on where a drag was when it was overtaken; with a strength spacing is free."""
    cage = shaken_torus()
    request = request_of(cage, strength)
    fine = dataclasses.replace(request, options={"threads": 2, "tolerance": 1e-7, "decrement_tolerance": 1e-9})
    places = cage.positions[PINS]
    warm = session(cage, fine, places)
    end = drag(warm, fine, places, np.array([0.0, 0.1, 0.3]), 12)
    wait(lambda: warm.is_settled)
    cold = session(cage, fine, end)
    wait(lambda: cold.is_settled)
    found = [one.latest.snapshot.cage.astype(float) for one in (warm, cold)]
    assert np.abs(found[0][PINS] - end).max() < 1e-6
    if strength == 1.0:
        energies = [energy_of(cage, fine, positions) for positions in found]
    else:
        energies = [one.latest.energy for one in (warm, cold)]
    assert abs(energies[0] / energies[1] - 1) <= (1e-4 if strength == 1.0 else 5e-6)
    assert warm.latest.summary.verification.verdict == "minimum"


def test_a_hand_that_was_too_far_for_a_moment_does_no_harm(session):
    """On the way back the surface is beyond repair by small steps; it is found again from the last minimum."""
    request, places, one = settled(session)
    energy = one.latest.energy
    drag_all(one, request, places, np.linspace(0, 0.8, 9))
    wait(lambda: one.is_settled)
    drag_all(one, request, places, np.linspace(0.8, 0, 9))
    wait(lambda: one.is_settled)
    assert one.latest.summary.verification.verdict == "minimum"
    assert one.latest.energy == pytest.approx(energy, rel=3e-3)


def test_a_hand_that_was_a_thousand_sizes_away_does_no_harm(session):
    """On the way back all steps are used up while the energy still falls."""
    request, places, one = settled(session)
    energy, far = one.latest.energy, places.copy()
    far[0, 2] += 1e3
    for goal in (far, places):
        one.aim(request, goal)
        wait(lambda: one.is_settled)
    assert one.latest.summary.verification.verdict == "minimum"
    assert one.latest.energy == pytest.approx(energy, rel=3e-3)


def test_a_large_cage_that_comes_late_is_said(session):
    """How late is by this test's clock, which also counts that the answer is published."""
    request, places, one = settled(session)
    begin = time.monotonic()
    one.aim(request, places + [0, 0, 0.05])
    wait(lambda: one.latest.number == one.number)
    assert 0 < one.latest.lag <= time.monotonic() - begin
    late = dataclasses.replace(one.latest, summary=None, lag=1.26)
    assert messages.live_text(request, late).endswith(", following")  # a small cage is not the reason
    grid = shapes.torus(60, 40)[0]
    large = dataclasses.replace(late, snapshot=dataclasses.replace(late.snapshot, cage=grid))
    assert messages.live_text(request, large).endswith(", following 1.3 s behind the hand, because the cage is large (2,400 vertices)")
    assert messages.live_text(request, dataclasses.replace(large, lag=0.1)).endswith(", following")
    assert messages.live_text(request, dataclasses.replace(large, number=0)) == "Live: preparing: 2,400 vertices take their time"


def test_a_picture_waits_for_the_surface_that_belongs_to_it(session):
    """As long as it was told to; never where the last answer has taken longer than that; and not once the session has ended."""
    request, places, one = settled(session)
    one.aim(request, places + [0, 0, 0.01])
    assert one.await_first(300.0) and one.latest.number == one.number
    assert one.await_first(300.0), "it is there already"
    assert not one.await_first(0.0), "the last one has taken longer"
    wait(lambda: one.is_settled)
    with one._changed:  # the worker publishes nothing meanwhile
        one.aim(request, places)
        begin = time.monotonic()
        one._took, one._publish = 0.0, lambda *_, **__: None
    assert not one.await_first(0.02) and time.monotonic() - begin >= 0.02
    one.error = ValueError("an error has ended it")
    assert not one.await_first(300.0)


def settled(session):
    """Of a shaken torus the request, the places (k, 3) of its pins, and Live on it, at rest."""
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS]
    one = session(cage, request, places)
    wait(lambda: one.is_settled)
    return request, places, one


def drag_all(one, request, places, distances) -> None:
    for distance in distances:
        one.aim(request, places + [0, distance, distance])
        wait(lambda: one.latest.number == one.number or one.error)
        one.seen(one.latest)


def test_first_answers_come_before_states_that_pass_and_the_optimum(session):
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS]
    seen = []
    publish = live.Live._publish

    class Noted(live.Live):
        def _publish(self, *arguments, **named):
            publish(self, *arguments, **named)
            seen.append(self.latest)

    one = Noted(cage, request, places)
    one.start()
    wait(lambda: one.is_settled)
    wait(lambda: seen[-1].summary is seen[-2].summary is not None)  # the exact picture is the last one
    seen.clear()
    one.aim(request, places + [0, 0, 0.1])
    wait(lambda: one.is_settled and len(seen) > 2)
    assert one.close(300)
    assert [view.number for view in seen] == [2] * len(seen)
    assert seen[0].is_first and not any(view.is_first for view in seen[1:])
    assert [view.summary is None for view in seen] == sorted([view.summary is None for view in seen], reverse=True)
    for view in seen:
        assert np.abs(view.snapshot.cage[PINS] - (places + [0, 0, 0.1])).max() < 1e-6
    assert all(view.snapshot.triangles is seen[0].snapshot.triangles for view in seen if view.summary is None)
    assert seen[-1].energy <= seen[0].energy * (1 + 1e-6)


def test_the_newest_targets_win(session):
    """Of many that come at once only the last ones are settled for, and no answer is to older ones than the one before."""
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS]
    one, numbers = session(cage, request, places), []
    wait(lambda: one.is_settled)
    for step in range(200):
        one.aim(request, places + [0, 0, 0.001 * (step + 1)])
        numbers.append(one.latest.number)
        one.seen(one.latest)
    wait(lambda: one.is_settled)
    assert numbers == sorted(numbers) and len(set(numbers)) < 100
    assert np.abs(one.latest.snapshot.cage[PINS] - (places + [0, 0, 0.2])).max() < 1e-6


def test_a_solution_that_is_on_gives_way(session, monkeypatch):
    """New targets end the way to an optimum that nobody waits for any more, within its step."""
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS]
    stops, solve = [], library.Solver.solve
    reached = threading.Event()

    def noted(self, settle, on_progress, flag, watch):
        def on_step(progress):
            if settle and progress.iteration >= 1:
                reached.set()
                wait(lambda: on_progress(progress), 20)
            return on_progress(progress)

        solve(self, settle, on_step, flag, watch)
        stops.append((settle, self.summary().stop))

    monkeypatch.setattr(library.Solver, "solve", noted)
    one = session(cage, request, places)
    wait(reached.is_set)
    monkeypatch.setattr(library.Solver, "solve", solve)
    one.aim(request, places + [0, 0, 0.1])
    wait(lambda: one.is_settled)
    assert (True, "cancelled") in stops and one.latest.number == 2 and one.error is None


@pytest.mark.parametrize("moment", ["at once", "first view", "settled"])
def test_it_ends_in_the_middle(session, moment):
    cage = shaken_torus()
    one = session(cage, request_of(cage), cage.positions[PINS])
    if moment != "at once":
        wait(lambda: one.latest is not None if moment == "first view" else one.is_settled)
    begin = time.process_time()
    assert one.close(300) and not one.running
    assert time.process_time() - begin < 2.0 and one.error is None and one.solution is None
    assert one.close(300)
    assert not library.load().open


def test_a_session_that_was_never_started_ends():
    cage = shaken_torus()
    assert live.Live(cage, request_of(cage), cage.positions[PINS]).close()


def test_bad_targets_are_said_and_others_are_followed(session):
    """Handles in one place leave no surface there, and none is at infinity."""
    cage = shaken_torus()
    request = dataclasses.replace(request_of(cage), held=Held.exactly(np.array([0, 1, 4, 5])))
    places = cage.positions[request.held.vertices]
    one = session(cage, request, places)
    wait(lambda: one.is_settled)
    one.aim(request, np.repeat(places[:1], 4, axis=0))
    wait(lambda: one.trouble is not None or one.is_settled)
    assert isinstance(one.trouble, library.CurvoptError) and one.error is None
    one.aim(request, places)
    wait(lambda: one.is_settled)
    assert one.trouble is None
    one.aim(request, places + [0, 0, np.inf])
    wait(lambda: one.trouble is not None)
    assert isinstance(one.trouble, library.CurvoptError) and messages.failure_text(one.trouble).endswith(".")
    assert one.running and one.error is None
    one.aim(request, places)
    wait(lambda: one.is_settled and one.trouble is None)
    assert one.latest.summary.verification.verdict == "minimum"


def test_finishing_in_trouble_is_an_error(session):
    cage = shaken_torus()
    request = dataclasses.replace(request_of(cage), held=Held.exactly(np.array([0, 1, 4, 5])))
    one = session(cage, request, np.repeat(cage.positions[:1], 4, axis=0))
    one.finish()
    wait(lambda: not one.running)
    assert isinstance(one.error, library.CurvoptError) and one.solution is None


def test_options_that_the_library_refuses_leave_the_session_as_it_is(session):
    cage = shaken_torus()
    good, places = request_of(cage), cage.positions[PINS]
    one = session(cage, good, places)
    wait(lambda: one.is_settled)
    one.aim(dataclasses.replace(good, options={"threads": 2, "slide": 1}), places)
    wait(lambda: one.trouble is not None)
    one.aim(good, places)
    wait(lambda: one.is_settled and one.trouble is None)
    assert one.latest.number == 3


def test_what_cannot_begin_is_an_error(session):
    cage = shaken_torus()
    one = session(cage, dataclasses.replace(request_of(cage), options={"slide": 1}), cage.positions[PINS])
    wait(lambda: not one.running)
    assert "slide" in str(one.error)


def test_without_a_library_it_ends_with_a_sentence(session, monkeypatch, tmp_path):
    monkeypatch.setenv(locate.LIBRARY_VARIABLE, str(tmp_path / "none.so"))
    cage = shaken_torus()
    one = session(cage, request_of(cage), cage.positions[PINS])
    wait(lambda: not one.running)
    assert isinstance(one.error, library.LibraryError)


def test_where_everything_is_held_it_says_so(session):
    cage = shaken_torus()
    request = dataclasses.replace(request_of(cage), held=Held.exactly(np.arange(32)))
    one = session(cage, request, cage.positions)
    wait(lambda: one.trouble is not None or not one.running or one.is_settled)
    assert isinstance(one.error, library.CurvoptError)
    assert messages.failure_text(one.error).startswith("Nothing may move: all 32 vertices are held")


def test_other_settings_and_other_handles_while_it_is_on(session):
    cage = shaken_torus()
    one = session(cage, request_of(cage), cage.positions[PINS])
    wait(lambda: one.is_settled)
    free = one.latest.energy
    near = request_of(cage, 0.1)
    one.aim(near, cage.positions[PINS])
    wait(lambda: one.is_settled)
    assert one.latest.energy > 1.01 * free
    more = dataclasses.replace(near, held=Held.exactly(np.append(PINS, 30)))
    places = np.append(cage.positions[PINS], cage.positions[30:31] + 0.1, axis=0)
    one.aim(more, places)
    wait(lambda: one.is_settled)
    assert np.abs(one.latest.snapshot.cage[[0, 30]] - places[[0, 4]]).max() < 1e-6
    volume = dataclasses.replace(request_of(cage), keeps_volume=True)
    one.aim(volume, cage.positions[PINS] + [0, 0, 0.1])
    wait(lambda: one.is_settled)
    start, end = one.latest.summary.start.volume, one.latest.summary.end.volume
    assert end == pytest.approx(start, rel=1e-7)


def test_finishing_settles_and_measures(session):
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS] + [0, 0, 0.05]
    one = session(cage, request, places)
    one.finish()
    wait(lambda: not one.running)
    found = one.solution
    assert one.error is None and found.stop != "cancelled" and found.verification.verdict == "minimum"
    assert np.array_equal(found.cage.positions[PINS], places) and np.array_equal(found.start_positions, cage.positions)
    assert found.deviation.bound >= found.deviation.max > 0.01 and found.crossings is not None
    assert messages.solution_text(request, found).startswith("Willmore ")


def test_a_folded_cage_is_unfolded(session):
    """A vertex that was dragged over its neighbours; what is held is elsewhere."""
    cage = shaken_torus()
    points, (a, b, _, d) = cage.positions.copy(), cage.face_vertices[4 * FOLDED : 4 * FOLDED + 4]
    points[a] += 3.5 * (points[b] - points[a]) + 0.3 * (points[d] - points[a])
    folded = dataclasses.replace(cage, positions=points)
    one = session(folded, request_of(folded), points[PINS])
    wait(lambda: one.is_settled)
    one.finish()
    wait(lambda: not one.running)
    found = one.solution
    assert one.error is None and found.verification.verdict == "minimum" and found.n_unfolded > 0
    assert messages.folds_text(found).startswith(f"The original is folded (face {found.folded[0]}")


def test_the_way_that_was_shown_is_the_path(session):
    """From the cage through the place that the hand was drawn back from to the result; a second worker goes on with it."""
    cage = shaken_torus()
    request, places = request_of(cage), cage.positions[PINS].copy()
    one = session(cage, request, places)
    wait(lambda: one.is_settled)
    drag(one, request, places, np.array([0, 0, 0.6]), 12)
    one.close()
    two = session(cage, request, places, one.recorder)
    wait(lambda: two.is_settled)
    two.finish()
    wait(lambda: not two.running)
    path = two.solution.path
    assert 5 < len(path) <= 25 and all(state.shape == cage.positions.shape for state in path)
    assert np.array_equal(path[0], cage.positions) and np.array_equal(path[-1], two.solution.cage.positions)
    heights = np.array([state[PINS[0], 2] - places[0, 2] for state in path])
    assert heights.max() > 0.4 and abs(heights[-1]) < 1e-9
    gaps = [np.linalg.norm(a - b) for a, b in zip(path, path[1:])]
    assert max(gaps) < 0.5 * sum(gaps), gaps


def test_quick_pictures_are_those_of_the_surface(session):
    """Points of the subdivided cage are near the surface, and so are their normals."""
    cage = shaken_torus(0.0)
    watcher = live.Watcher()
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        quick, again = watcher.take(mesh, cage.positions), watcher.take(mesh, cage.positions)
        exact = watcher.take_exact(mesh, cage.positions, lambda: False)
        assert watcher.take_exact(mesh, cage.positions, lambda: True) is None
    assert quick.triangles is again.triangles and 4 * len(quick.triangles) == len(exact.triangles)
    distances = np.linalg.norm(quick.points[:, None] - exact.points, axis=2)
    nearest = distances.argmin(axis=1)
    assert distances.min(axis=1).max() < 1e-2
    assert (quick.normals * exact.normals[nearest]).sum(axis=1).min() > 0.999


def test_an_exact_picture_that_nobody_wants_any_more_is_left():
    """Between two parts of it."""
    cage, asked = shaken_torus(), []
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        watcher = live.Watcher()
        assert watcher.take_exact(mesh, cage.positions, lambda: bool(asked.append(0)) or len(asked) == 3) is None
    assert len(asked) == 3

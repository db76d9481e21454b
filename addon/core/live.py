# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface that follows the hand: one worker thread with the library's solver that stays. No bpy.

The main thread says where handles are to be (`aim`) and looks at `latest`. The newest targets win. For each the worker
publishes a first answer, then states that pass, and once the hand rests the optimum with its verdict.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..binding import library
from ..binding.values import Cage, LevelReport, Summary
from .job import Request, Solution, folded_faces, measured, options_of
from .memory import check_cage
from .record import Recorder
from .snapshot import Snapshot, Watcher

REST = 0.04  # seconds without new targets after which the hand rests: a mouse that moves reports every 8 to 17 ms
_SLOWEST = 0.15  # seconds: where Blender takes that long to draw, and so to tell of the mouse, it rests later by as much
_SHARE = 2.0  # between the first answer and the optimum the worker solves that many times longer than it draws


@dataclass(frozen=True)
class Aim:
    """Targets: what is minimized, and where its held vertices are to be, (k, 3) in the order of request.held, NAN where
    they are; `number` counts them, `time` is that of time.monotonic()."""

    request: Request
    places: np.ndarray
    number: int = 0
    time: float = 0.0


@dataclass(frozen=True)
class View:
    """What is to be seen: a surface, `number` of the targets that it belongs to, its energy, and whether it is the first
    answer to them; `summary`, with the verdict, if it is the optimum. `time` is that of time.monotonic(), `lag` how many
    seconds before that the targets of the last first answer were given."""

    snapshot: Snapshot
    number: int
    energy: float
    is_first: bool
    time: float
    summary: Summary | None = None
    lag: float = 0.0


class Live:
    """Every method is for the main thread and returns at once, `join` and `close` excepted.

    `latest` is the newest View or None. `trouble` is why the newest targets cannot be followed, such as two handles in
    one place, or None: other targets may be. `error` has ended the session. `solution` is there some time after
    `finish`, with the way of all surfaces that were shown as its path. `recorder` has that of a worker before this one."""

    def __init__(self, cage: Cage, request: Request, places: np.ndarray, recorder: Recorder | None = None) -> None:
        self.cage = cage
        self.recorder = recorder or Recorder(cage.positions)
        self.latest: View | None = None
        self.trouble: BaseException | None = None
        self.error: BaseException | None = None
        self.solution: Solution | None = None
        self._aim = Aim(request, places, 1, time.monotonic())
        self._pause = 0.0  # seconds between the last two targets, _SLOWEST at most
        self._done, self._settled = 0, False  # number of the targets that were gone to, and whether to the end
        self._applied = request  # whose options the solver has
        self._solved = self._aim  # the targets that are solved for
        self._good: np.ndarray | None = None  # positions (n, 3) of the last minimum; the cage's before there is one
        self._found: tuple[np.ndarray, Summary, LevelReport] | None = None  # the optimum of the newest targets
        self._finishing = self._closing = False
        self._flag: library.Cancel | None = None  # of the solution that is on
        self._answered = False  # whether that one may be cancelled: its first answer is published
        self._seen: View | None = None
        self._not_before = 0.0
        self._lag = 0.0
        self._took = 0.0  # the worker's processor time for the last first answer
        self._watcher = Watcher()
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="curvopt", daemon=True)

    # --------------------------------------------------------------------------------------------- main thread --

    def start(self) -> None:
        """Start the worker; once only."""
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the worker is there."""
        return self._thread.is_alive()

    @property
    def number(self) -> int:
        """Of the newest targets."""
        return self._aim.number

    @property
    def is_settled(self) -> bool:
        """Whether what is shown is the optimum of the newest targets."""
        view = self.latest
        return view is not None and view.summary is not None and view.number == self._aim.number

    def aim(self, request: Request, places: np.ndarray) -> None:
        """New targets. Another object as `request` than before: other options or other held vertices."""
        with self._changed:
            now = time.monotonic()
            self._pause = min(now - self._aim.time, _SLOWEST)
            self._aim = Aim(request, places, self._aim.number + 1, now)
            self._interrupt()

    def await_first(self, seconds: float) -> bool:
        """Wait for the first answer to the newest targets, that long at most, and not where the last one has taken longer:
        whether it is there."""
        deadline = time.monotonic() + seconds
        with self._changed:
            if self._took > seconds or self.latest is None:
                return False
            while self.latest.number < self._aim.number and self.error is None:
                if not self._changed.wait(max(0.0, deadline - time.monotonic())):
                    break
            return self.latest.number >= self._aim.number

    def seen(self, view: View) -> None:
        """The view has been shown: another one on the way is welcome."""
        self._seen = view

    def finish(self) -> None:
        """Settle, measure, leave `solution`, and end."""
        with self._changed:
            self._finishing = True
            self._changed.notify()

    def join(self) -> None:
        """Wait for the worker, after `finish`."""
        self._thread.join()

    def close(self, timeout: float | None = None) -> bool:
        """End at once, and wait for that, `timeout` seconds at most: whether the worker has ended."""
        with self._changed:
            self._closing = self._answered = True
            self._interrupt()
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self.running

    def _interrupt(self) -> None:
        """Have the worker look at what is wanted; with the lock."""
        if self._flag is not None and self._answered:
            self._flag.request()
        self._changed.notify()

    # -------------------------------------------------------------------------------------------------- worker --

    def _run(self) -> None:
        try:
            lib = library.load()
            check_cage(len(self.cage.positions))
            with library.Mesh.of_cage(lib, self.cage) as mesh:
                self._publish(mesh, self.cage.positions, 0, np.nan)
                options = _options(lib, self._aim)
                with library.Solver.create(mesh, self.cage.positions, options) as solver:
                    while self._step(lib, mesh, solver):
                        pass
        except BaseException as error:  # a thread has nobody to raise to; the main thread reads it
            self.error = error

    def _step(self, lib: library.Library, mesh: library.Mesh, solver: library.Solver) -> bool:
        """One solution, or one wait; False at the end."""
        with self._changed:
            aim = self._aim
            if self._closing:
                return False
            is_new = aim.number != self._done
            rest = aim.time + REST + self._pause - time.monotonic()
            if not is_new and self._settled and not self._finishing:
                self._changed.wait()
                return True
            if not is_new and not self._settled and rest > 0 and not self._finishing:
                self._changed.wait(rest)
                return True
            self._flag, self._answered = library.Cancel.create(lib), not is_new
        try:
            if not is_new and self._settled:
                if self.trouble is None:
                    self.solution = self._solution(lib, mesh, aim)
                else:
                    self.error = self.trouble
                return False
            self._solve(lib, mesh, solver, aim, settle=not is_new)
        except (library.CurvoptError, ValueError) as error:  # the solver stands where it stood, and goes on with other targets
            self._done, self._settled, self.trouble = aim.number, True, error
        finally:
            with self._changed:
                flag, self._flag = self._flag, None
            flag.close()
        return True

    def _solve(self, lib: library.Library, mesh: library.Mesh, solver: library.Solver, aim: Aim, settle: bool) -> None:
        """To a passing state of these targets, or to their optimum."""
        self._solved, begin = aim, time.thread_time()
        if not settle:
            if aim.request is not self._applied:
                solver.set_options(_options(lib, aim))
                self._applied = aim.request
            elif len(aim.places):
                solver.set_places(aim.places)

        def watch(iterate: library.Iterate) -> None:
            first = not (settle or self._answered)
            if first or self._wants_another():
                self._publish(mesh, iterate.positions(), aim.number, iterate.progress.energy, first)
            if first:
                self._took = time.thread_time() - begin
            with self._changed:
                self._answered = True

        def is_over(_: object = None) -> bool:
            return self._aim is not aim or self._closing

        solver.solve(settle, is_over, self._flag, watch)
        if solver.summary().stop == "cancelled" and is_over():
            return  # other targets are waiting
        self._found = solver.positions(), solver.summary(), solver.report()
        if settle and _is_lost(self._found[1]) and not self._start_again(solver, is_over):
            return
        xyz, summary, _ = self._found
        if settle and summary.verification.verdict == "minimum":
            self._good = xyz
        self.trouble = None
        self._done, self._settled = aim.number, settle
        self._publish(mesh, xyz, aim.number, summary.end.objective, summary=summary if settle else None)
        if settle:
            self._publish(mesh, xyz, aim.number, summary.end.objective, summary=summary, exact_unless=is_over)

    def _start_again(self, solver: library.Solver, is_over: Callable[[object], bool]) -> bool:
        """The way of the hand went through shapes from which none leads back, as where it was too far for a moment. So
        once more from the last minimum, and where that ends no better, from the first cage; the best of these counts. False
        if other targets came meanwhile."""
        for begin in (self._good, None) if self._good is not None else (None,):
            try:
                solver.set_positions(begin)
                for settle in (False, True):
                    solver.solve(settle, is_over, self._flag)
                    if solver.summary().stop == "cancelled" and is_over():
                        return False
            except library.CurvoptError:
                continue
            found = solver.positions(), solver.summary(), solver.report()
            if found[1].end.objective < self._found[1].end.objective:
                self._found = found
            if not _is_lost(found[1]):
                break
        solver.set_positions(self._found[0])
        return True

    def _wants_another(self) -> bool:
        """Whether a state on the way is worth a picture: the last one was shown, and did not cost too much."""
        return self._seen is self.latest and time.monotonic() >= self._not_before

    def _publish(
        self, mesh: library.Mesh, xyz: np.ndarray, number: int, energy: float, first: bool = False,
        summary: Summary | None = None, exact_unless: Callable[[], bool] | None = None,
    ) -> None:  # fmt: skip
        begin = time.monotonic()
        self.recorder.see(xyz)
        if exact_unless is None:
            snapshot = self._watcher.take(mesh, xyz)
        else:
            snapshot = self._watcher.take_exact(mesh, xyz, exact_unless)
        if snapshot is None:
            return
        end = time.monotonic()
        if first:
            self._lag = end - self._solved.time
        with self._changed:
            self.latest = View(snapshot, number, energy, first, end, summary, self._lag)
            self._changed.notify_all()
        self._not_before = end + _SHARE * (end - begin)

    def _solution(self, lib: library.Library, mesh: library.Mesh, aim: Aim) -> Solution:
        """As of a run from the cage."""
        xyz, summary, report = self._found
        final = replace(self.cage, positions=xyz)
        deviation, crossings = measured(mesh, self.cage, mesh, final, self._flag)
        options = _options(lib, aim)
        exceptions = mesh.exceptions(self.cage.positions, options)
        return Solution(
            final, self.cage.positions, summary.start, summary.end, mesh.info().euler, summary.stop, summary.verification,
            summary.seconds, (report,), summary.symmetry_order, exceptions, 0, deviation, crossings,
            summary.multipliers, summary.scalar_residuals, folded=folded_faces(mesh, self.cage, summary, options),
            n_unfolded=summary.n_unfolded, path=self.recorder.path(mesh, xyz),
        )  # fmt: skip


def _options(lib: library.Library, aim: Aim) -> library.COptions:
    """The library's options of targets."""
    held = replace(aim.request.held, places=aim.places) if len(aim.places) else aim.request.held
    return options_of(lib, replace(aim.request, held=held))


def _is_lost(summary: Summary) -> bool:
    """Whether a solution ended where the surface has features too fine to resolve, or still falling after all its steps."""
    return summary.stop in ("unresolved", "limit") and summary.verification.verdict != "minimum"

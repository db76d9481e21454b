# SPDX-License-Identifier: GPL-3.0-or-later
"""One optimization: synchronously (`solve`), on a worker thread (`Job`), and as a modal operator sees it (`ModalRun`).

No bpy. The worker touches arrays and the library only; whatever it has to say is read by polling from the main thread.
"""

from __future__ import annotations

import enum
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from . import native
from .energy import label_of, number_text, weights_of
from .header import BOUNDARIES, SYMMETRIES
from .memory import Guard, check_cage
from .snapshot import Watcher
from .values import Cage, Energies, Held, LevelReport, Progress, Verification


@dataclass(frozen=True)
class Request:
    """What to minimize. `energy` is a key of energy.ENERGY_LABELS or a mix such as "mvs:1,willmore:0.1"; `limits` are
    further fields of curvopt_options; `boundary`, of header.BOUNDARIES, is what an open surface keeps; `symmetry`, of
    header.SYMMETRIES, whether the cage's symmetries are kept, or mirror planes that are, such as "x,z"; `held` are
    vertices of the cage that may not move freely."""

    energy: str = "mvs"
    levels: int = 4
    limits: dict[str, float] = field(default_factory=dict)
    boundary: str = "position"
    symmetry: str = "keep"
    held: Held = field(default_factory=Held)

    @property
    def label(self) -> str:
        return label_of(self.energy)


@dataclass(frozen=True)
class Solution:
    """The optimized cage, the energies of the first and of this one, and how the run went; `symmetry_order` 1 means
    that no symmetries were kept. start_positions (n, 3) are vertices of the optimized cage that show the first one's
    surface: the first cage, subdivided as often."""

    cage: Cage
    start_positions: np.ndarray
    start: Energies
    end: Energies
    euler: int
    stop: str
    verification: Verification
    seconds: float
    levels: tuple[LevelReport, ...]
    symmetry_order: int


OnProgress = Callable[[Progress], object]


def symmetry_of(text: str) -> tuple[int, int]:
    """(curvopt_symmetry, sum of curvopt_plane) of a name of header.SYMMETRIES or of mirror planes such as "x,z".
    ValueError for anything else."""
    if text in SYMMETRIES and text != "planes":
        return SYMMETRIES.index(text), 0
    planes = text.split(",")
    if not all(plane in ("x", "y", "z") for plane in planes):
        names = ", ".join(name for name in SYMMETRIES if name != "planes")
        raise ValueError(f"There is no symmetry '{text}'; there are {names}, and mirror planes such as x or y,z.")
    return SYMMETRIES.index("planes"), sum(1 << "xyz".index(plane) for plane in set(planes))


def solve(
    cage: Cage,
    request: Request,
    on_progress: OnProgress | None = None,
    cancel: native.Cancel | None = None,
    watcher: Watcher | None = None,
) -> Solution:
    """Run here and now. `on_progress` may return a true value to cancel; a cancelled run has `stop == "cancelled"`.
    A `watcher` takes pictures of the start and on the way.

    LibraryError, CurvoptError, ValueError, and whatever `on_progress` raises."""
    library = native.library()
    check_cage(len(cage.positions))
    guard = Guard()

    def step(progress: Progress) -> bool:
        wants_out = bool(on_progress is not None and on_progress(progress))
        return guard(progress) or wants_out

    symmetry, planes = symmetry_of(request.symmetry)
    options = library.options(
        weights_of(request.energy), request.held, levels=request.levels, boundary=BOUNDARIES.index(request.boundary),
        symmetry=symmetry, symmetry_planes=planes, **request.limits,
    )  # fmt: skip
    with native.Mesh.create(library, len(cage.positions), cage.face_sizes, cage.face_vertices, cage.creases) as mesh:
        if watcher is not None:
            watcher.start(mesh, cage)
        with native.minimize(mesh, cage.positions, options, step, cancel, watcher) as result:
            summary = result.summary()
            levels = tuple(result.level(index) for index in range(summary.n_levels))
            euler = result.mesh().info().euler
            final = result.cage()
            start = _subdivided(mesh, cage.positions, len(final.positions))
            stop = "memory" if guard.stopped and summary.stop == "cancelled" else summary.stop
            return Solution(
                final, start, summary.start, summary.end, euler, stop, summary.verification, summary.seconds,
                levels, summary.symmetry_order,
            )  # fmt: skip


def _subdivided(mesh: native.Mesh, positions: np.ndarray, n_vertices: int) -> np.ndarray:
    """The cage, subdivided until it has `n_vertices`."""
    while len(positions) < n_vertices:
        mesh, positions = mesh.refine(positions)
    return positions


class Job:
    """A worker thread running `work(on_progress) -> Solution`. Every method is for the main thread and returns at once,
    `join` excepted. `latest` is the newest Progress or None, `history` (seconds, level, energy) of all of them; after
    the end, `solution` or `error` is set. `watcher`, if there is one, has pictures."""

    def __init__(
        self,
        work: Callable[[OnProgress], Solution],
        on_cancel: Callable[[], None] = lambda: None,
        watcher: Watcher | None = None,
    ) -> None:
        self.watcher = watcher
        self.latest: Progress | None = None
        self.history: list[tuple[float, int, float]] = []  # only ever appended to
        self.solution: Solution | None = None
        self.error: BaseException | None = None
        self._work = work
        self._on_cancel = on_cancel
        self._cancelled = threading.Event()
        self._thread = threading.Thread(target=self._run, name="curvopt", daemon=True)

    @classmethod
    def minimize(cls, cage: Cage, request: Request) -> Job:
        """A job that runs `solve`, with pictures. LibraryError if there is no usable library."""
        flag, watcher = native.Cancel.create(native.library()), Watcher()
        return cls(lambda on_progress: solve(cage, request, on_progress, flag, watcher), flag.request, watcher)

    def start(self) -> None:
        self._thread.start()

    def cancel(self) -> None:
        """Ask the worker to stop; may be called at any time and more than once."""
        self._cancelled.set()
        self._on_cancel()

    @property
    def running(self) -> bool:
        return self._thread.is_alive()

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the worker, `timeout` seconds at most; whether it has ended."""
        self._thread.join(timeout)
        return not self.running

    def _run(self) -> None:
        try:
            self.solution = self._work(self._on_progress)
        except BaseException as error:  # a thread has nobody to raise to; the main thread reads it
            self.error = error

    def _on_progress(self, progress: Progress) -> bool:
        self.history.append((progress.seconds, progress.level, progress.energy))
        self.latest = progress  # one reference, replaced whole: a reader sees the old or the new one, never a mixture
        return self._cancelled.is_set()


class Phase(enum.Enum):
    """Where a modal run is; the last three are ends."""

    RUNNING = "running"
    KEEPING = "keeping"
    FINISHED = "finished"
    CANCELLED = "cancelled"
    FAILED = "failed"

    @property
    def ended(self) -> bool:
        return self in (Phase.FINISHED, Phase.CANCELLED, Phase.FAILED)


class ModalRun:
    """What a modal operator does, without Blender: `tick` on every timer event, `escape` on ESC, `keep` on Enter, until
    `phase.ended`.

    ESC ends the run at once, even if the worker was about to finish: a worker in the middle of a long step goes on to
    its end with nobody to listen to it; see `Job.running`."""

    def __init__(self, job: Job, label: str) -> None:
        self.job = job
        self.label = label
        self.phase = Phase.RUNNING
        job.start()

    def escape(self) -> None:
        """The user wants out: nothing of this run is to be kept."""
        if not self.phase.ended:
            self.phase = Phase.CANCELLED
            self.job.cancel()

    def keep(self) -> None:
        """The user has seen enough: end with the best cage so far."""
        if self.phase is Phase.RUNNING:
            self.phase = Phase.KEEPING
            self.job.cancel()

    def tick(self) -> Phase:
        """Look at the worker; the phase now."""
        if not self.phase.ended and not self.job.running:
            self.phase = Phase.FINISHED if self.job.error is None else Phase.FAILED
        return self.phase

    def abandon(self, timeout: float) -> bool:
        """Cancel and wait up to `timeout` seconds (Blender quits, loads a file): whether the worker has ended."""
        self.escape()
        return self.job.join(timeout)

    @property
    def status(self) -> str:
        """What it is doing, in a few words."""
        progress = self.job.latest
        if self.phase is Phase.KEEPING:
            return f"Minimizing {self.label}: finishing with the best so far"
        return f"Minimizing {self.label}: {progress_text(progress) if progress else 'preparing'}"


def progress_text(progress: Progress) -> str:
    """Level, iteration and energy in words."""
    return (
        f"level {progress.level} of {progress.levels}, iteration {progress.iteration}, "
        f"energy {number_text(progress.energy)} (from {number_text(progress.start_energy)})"
    )


_STOP_WORDS = {
    "converged": "converged",
    "stalled": "stopped early: no further decrease was found",
    "limit": "stopped early: iteration limit reached, still falling",
    "cancelled": "stopped early as you asked, still falling",
    "memory": "stopped early: the next level needs more memory than there is",
    "unresolved": "stopped early: the surface develops features too fine to resolve",
    "settled": "settled: it would still fall, but hardly",
}


def solution_text(request: Request, solution: Solution) -> str:
    """The outcome in one sentence."""
    before, after = solution.start.objective, solution.end.objective
    order = solution.symmetry_order
    kept = f", {order} symmetries kept" if order > 1 else ""
    return (
        f"{request.label} {number_text(before)} to {number_text(after)}, {_STOP_WORDS[solution.stop]} "
        f"({len(solution.cage.positions)} vertices{kept}, {solution.seconds:.1f} s)"
    )


def verdict_text(verification: Verification, energy: float, symmetry_order: int = 1, stop: str = "converged") -> str:
    """What the Hessian says of a result of this energy, in a sentence; without a Hessian, why the run stopped. Only
    directions that keep the symmetries were looked at."""
    directions = verification.negative_directions
    more = "some directions" if directions < 1 else f"{directions} direction{'s' if directions > 1 else ''}"
    gain = verification.newton_decrement / energy if energy > 0 else math.nan
    less = f"about {100 * gain:.2g} % less" if math.isfinite(gain) else "less"
    among = " among shapes of the same symmetry" if symmetry_order > 1 else ""
    if verification.verdict == "minimum":
        return f"Checked: a true local minimum{among}."
    if verification.verdict == "saddle":
        return f"Checked: a saddle, {more} would still lead down."
    if verification.verdict == "not stationary":
        also = f", more along {more}" if directions else ""
        return f"Checked: not yet a minimum, {less} seems possible{also}."
    if stop in ("cancelled", "limit", "memory"):
        return "Not checked: the run was stopped early, the energy was still falling."
    return "Not checked: whether this is a minimum is not known."


# The library's words for what has another name in Blender.
_IN_BLENDER = (
    ("is infinitely sharp:", "has a crease of 1:"),
    ("an infinitely sharp crease", "a crease of 1"),
    ("make it an infinitely sharp vertex", "give it a vertex crease of 1"),
    ("the rule `corners` does", "Keep Corners in the Subdivision Surface modifier does"),
)


def failure_text(error: BaseException) -> str:
    """An error of `solve` as one sentence; anything unforeseen with its type, so that it can be reported."""
    if isinstance(error, (native.LibraryError, native.CurvoptError, ValueError)):
        return sentence(in_blender(str(error)))
    return f"Unexpected {type(error).__name__}: {error}."


def in_blender(text: str) -> str:
    """The library's text with Blender's names for things."""
    for theirs, ours in _IN_BLENDER:
        text = text.replace(theirs, ours)
    return text


def sentence(text: str) -> str:
    """The text on one line with a capital and a full stop."""
    text = " ".join(text.split())
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")

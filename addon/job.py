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
from .header import BOUNDARIES, SYMMETRIES
from .values import Cage, Energies, LevelReport, Progress, Verification

# What can be minimized by itself: every term but the area, whose least is no surface.
ENERGY_LABELS = {
    "willmore": "Willmore",
    "mvs": "MVS",
    "mvs_cross": "MVS_cross",
    "variation": "Variation",
    "mehlum_tarrou": "Mehlum-Tarrou",
}


@dataclass(frozen=True)
class Request:
    """What to minimize. `energy` is a key of ENERGY_LABELS; `limits` are further fields of curvopt_options; `boundary`,
    of header.BOUNDARIES, is what an open surface keeps; `symmetry`, of header.SYMMETRIES, whether the cage's symmetries
    are kept; held (k,) are vertices of the cage that may not move."""

    energy: str = "mvs"
    levels: int = 4
    limits: dict[str, float] = field(default_factory=dict)
    boundary: str = "position"
    symmetry: str = "auto"
    held: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))

    @property
    def label(self) -> str:
        return ENERGY_LABELS[self.energy]


@dataclass(frozen=True)
class Solution:
    """The optimized cage, the energies of the first and of this one, and how the run went; `symmetry_order` 1 means
    that no symmetries were kept."""

    cage: Cage
    start: Energies
    end: Energies
    euler: int
    stop: str
    verification: Verification
    seconds: float
    levels: tuple[LevelReport, ...]
    symmetry_order: int


OnProgress = Callable[[Progress], object]


def solve(
    cage: Cage, request: Request, on_progress: OnProgress | None = None, cancel: native.Cancel | None = None
) -> Solution:
    """Run here and now. `on_progress` may return a true value to cancel; a cancelled run has `stop == "cancelled"`.

    LibraryError, CurvoptError, ValueError, and whatever `on_progress` raises."""
    library = native.library()
    boundary, symmetry = BOUNDARIES.index(request.boundary), SYMMETRIES.index(request.symmetry)
    options = library.options(
        {request.energy: 1.0}, request.held, levels=request.levels, boundary=boundary, symmetry=symmetry,
        **request.limits,
    )  # fmt: skip
    with native.Mesh.create(library, len(cage.positions), cage.face_sizes, cage.face_vertices, cage.creases) as mesh:
        with native.minimize(mesh, cage.positions, options, on_progress, cancel) as result:
            summary = result.summary()
            levels = tuple(result.level(index) for index in range(summary.n_levels))
            euler = result.mesh().info().euler
            return Solution(
                result.cage(), summary.start, summary.end, euler, summary.stop, summary.verification, summary.seconds,
                levels, summary.symmetry_order,
            )  # fmt: skip


class Job:
    """A worker thread running `work(on_progress) -> Solution`. Every method is for the main thread and returns at once,
    `join` excepted. `latest` is the newest Progress or None; after the end, `solution` or `error` is set."""

    def __init__(self, work: Callable[[OnProgress], Solution], on_cancel: Callable[[], None] = lambda: None) -> None:
        self.latest: Progress | None = None
        self.solution: Solution | None = None
        self.error: BaseException | None = None
        self._work = work
        self._on_cancel = on_cancel
        self._cancelled = threading.Event()
        self._thread = threading.Thread(target=self._run, name="curvopt", daemon=True)

    @classmethod
    def minimize(cls, cage: Cage, request: Request) -> Job:
        """A job that runs `solve`. LibraryError if there is no usable library."""
        flag = native.Cancel.create(native.library())
        return cls(lambda on_progress: solve(cage, request, on_progress, flag), flag.request)

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
        self.latest = progress  # one reference, replaced whole: a reader sees the old or the new one, never a mixture
        return self._cancelled.is_set()


class Phase(enum.Enum):
    """Where a modal run is; the last three are ends."""

    RUNNING = "running"
    CANCELLING = "cancelling"
    FINISHED = "finished"
    CANCELLED = "cancelled"
    FAILED = "failed"

    @property
    def ended(self) -> bool:
        return self in (Phase.FINISHED, Phase.CANCELLED, Phase.FAILED)


class ModalRun:
    """What a modal operator does, without Blender: `tick` on every timer event, `escape` on ESC, until `phase.ended`.

    After ESC the run ends as CANCELLED even if the worker was about to finish, but only once the worker has stopped."""

    def __init__(self, job: Job, label: str) -> None:
        self.job = job
        self.label = label
        self.phase = Phase.RUNNING
        job.start()

    def escape(self) -> None:
        """The user wants out: nothing of this run is to be kept."""
        if self.phase is Phase.RUNNING:
            self.phase = Phase.CANCELLING
            self.job.cancel()

    def tick(self) -> Phase:
        """Look at the worker; the phase now."""
        if self.phase.ended or self.job.running:
            return self.phase
        if self.phase is Phase.CANCELLING:
            self.phase = Phase.CANCELLED
        elif self.job.error is not None:
            self.phase = Phase.FAILED
        else:
            self.phase = Phase.FINISHED
        return self.phase

    def abandon(self, timeout: float) -> bool:
        """Cancel and wait up to `timeout` seconds (Blender quits, loads a file): whether the worker has ended."""
        self.escape()
        ended = self.job.join(timeout)
        self.tick()
        return ended

    @property
    def status(self) -> str:
        """One line for the status bar."""
        if self.phase is Phase.CANCELLING:
            return f"Minimizing {self.label}: cancelling"
        progress = self.job.latest
        if progress is None:
            return f"Minimizing {self.label}: preparing   |   ESC: cancel"
        return f"Minimizing {self.label}: {progress_text(progress)}   |   ESC: cancel"


def progress_text(progress: Progress) -> str:
    """Level, iteration and energy in words."""
    return (
        f"level {progress.level} of {progress.levels}, iteration {progress.iteration}, "
        f"energy {energy_text(progress.energy)} (from {energy_text(progress.start_energy)})"
    )


def energy_text(value: float) -> str:
    """An energy for people: 5 digits, and no exponent where plain digits are readable."""
    return f"{value:,.0f}" if 1e4 <= abs(value) < 1e8 else f"{value:.5g}"


_STOP_WORDS = {
    "converged": "converged",
    "stalled": "stopped early: no further decrease was found",
    "limit": "stopped early: iteration limit reached, still falling",
    "cancelled": "cancelled",
    "unresolved": "stopped early: the surface develops features too fine to resolve",
    "settled": "settled: it would still fall, but hardly",
}


def solution_text(request: Request, solution: Solution) -> str:
    """The outcome in one sentence."""
    before, after = solution.start.terms[request.energy], solution.end.terms[request.energy]
    order = solution.symmetry_order
    kept = f", {order} symmetries kept" if order > 1 else ""
    return (
        f"{request.label} {energy_text(before)} to {energy_text(after)}, {_STOP_WORDS[solution.stop]} "
        f"({len(solution.cage.positions)} vertices{kept}, {solution.seconds:.1f} s)"
    )


def verdict_text(verification: Verification, energy: float, symmetry_order: int = 1) -> str:
    """What the Hessian says of a result of this energy, in a sentence. Only directions that keep the symmetries were
    looked at."""
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

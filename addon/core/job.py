# SPDX-License-Identifier: GPL-3.0-or-later
"""One optimization: synchronously (`solve`), on a worker thread (`Job`), and as a modal operator sees it (`ModalRun`).

No bpy. The worker touches arrays and the library only; whatever it has to say is read by polling from the main thread.
"""

from __future__ import annotations

import enum
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..binding import library, measure
from ..binding.abi import BOUNDARIES, DEFAULTS, SURFACES, SYMMETRIES, COptions
from ..binding.through import Chain, Through
from ..binding.values import Cage, Energies, Exceptions, Held, LevelReport, Progress, Summary, Verification
from .crop import Crop
from .energy import label_of, weights_of
from .memory import Guard, check_cage
from .record import Recorder
from .rims import marked_boundary
from .snapshot import Watcher


_MOST_REFINED = 2  # subdivisions that nobody asked for: 16 times the faces


@dataclass(frozen=True)
class Request:
    """What to minimize; the defaults are the library's.

    `energy` is a key of energy.ENERGY_LABELS or a mix such as "mvs:1,willmore:0.1". `options` are further fields of
    curvopt_options by name. `boundary`, of abi.BOUNDARIES, says what an open surface keeps. `symmetry` is a name of
    abi.SYMMETRIES, or mirror planes such as "x,z". `held` are vertices of the cage that may not move freely. Below a
    `strength` of 1 the surface stays near the cage's, and with a positive `within` no farther from it than that. `holes` (k,) are faces of the cage that are left out of the
    energy; their vertices are held. `keeps_volume` holds the volume inside the whole surface, or between it and a boundary
    that stays. `refined` of the levels were not asked for: `freed` added them. Of `marked` edges of
    the boundary the marks count, and are in `boundary` and `held`; unless `refinable`, on one level only. `records` the way of the run.
    `through` are points of the cage's surface and where they go, `chains` its chains of edges on curves."""

    energy: str = DEFAULTS.energy
    levels: int = DEFAULTS.levels
    options: dict[str, float] = field(default_factory=dict)
    boundary: str = DEFAULTS.boundary
    symmetry: str = DEFAULTS.symmetry
    held: Held = field(default_factory=Held)
    strength: float = DEFAULTS.strength
    holes: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))
    refined: int = 0
    marked: int = 0
    refinable: bool = True
    keeps_volume: bool = False
    within: float = DEFAULTS.within
    records: bool = False
    through: tuple[Through, ...] = ()
    chains: tuple[Chain, ...] = ()

    @property
    def label(self) -> str:
        """The energy for people."""
        return label_of(self.energy)

    @property
    def goes_through(self) -> bool:
        """Whether the surface goes through places, or along curves, of the scene."""
        return bool(self.through or self.chains)

    def free(self, n: int) -> np.ndarray:
        """Which of the n vertices of the cage (n,) are not held exactly."""
        free = np.ones(n, bool)
        free[self.held.vertices[np.asarray(self.held.weights) == 1]] = False
        return free


@dataclass(frozen=True)
class Solution:
    """The optimized cage, the energies of the first and of this one, and how the run went; `symmetry_order` 1 means
    that no symmetries were kept, and `n_sliding` vertices of the first cage may slide. start_positions (n, 3) are vertices
    of the optimized cage that show the first one's surface: the first cage, subdivided as often. `deviation` from the
    first cage's surface, and `crossings` of the optimized one with itself; None of a cancelled run. `multipliers` and
    `scalar_residuals` by name, `discretization_error`, and of No Crossings `clearance` and `touching`, as of values.Summary. The first cage's surface crosses
    itself at `n_crossing_before` pairs of faces: of No Crossings, and where the optimized one does. `folded` faces of the first cage make its energies infinite; `n_unfolded` of its vertices were put
    between their neighbours for that. `path`, of a run that was recorded: states (n, 3) of the optimized cage's vertices, from the first
    cage to the optimized one."""

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
    exceptions: Exceptions = Exceptions()
    n_sliding: int = 0
    deviation: measure.Deviation | None = None
    crossings: measure.Crossings | None = None
    multipliers: Mapping[str, float] = field(default_factory=dict)
    scalar_residuals: Mapping[str, float] = field(default_factory=dict)
    discretization_error: float = math.nan
    clearance: float = math.nan
    touching: tuple[tuple[int, int], ...] = ()
    n_crossing_before: int = 0
    folded: tuple[int, ...] = ()
    n_unfolded: int = 0
    path: tuple[np.ndarray, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether the run was cancelled before anything had moved."""
        return self.stop == "cancelled" and np.array_equal(self.cage.positions, self.start_positions)


OnProgress = Callable[[Progress], object]


def symmetry_of(text: str) -> tuple[int, int]:
    """(curvopt_symmetry, sum of curvopt_plane) of a name of abi.SYMMETRIES or of mirror planes such as "x,z".
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
    cancel: library.Cancel | None = None,
    watcher: Watcher | None = None,
) -> Solution:
    """Run here and now. `on_progress` may return a true value to cancel; a cancelled run has `stop == "cancelled"`.
    A `watcher` takes pictures of the start and on the way; of a run with holes, of the faces that count.

    LibraryError, CurvoptError, ValueError, and whatever `on_progress` raises."""
    if not _can_be_cropped(cage, request):
        return _solve(cage, request, on_progress, cancel, watcher)
    crop = Crop.of_faces(cage, _counted(cage, request))
    held, holes, strength = crop.held(request.held), crop.holes(request.holes), crop.strength(request.strength)
    part = replace(request, held=held, holes=holes, strength=strength)
    try:
        found = _solve(crop.cage, part, on_progress, cancel, watcher)
    except library.CurvoptError as error:
        raise crop.error(error) from None
    return replace(
        found, cage=crop.expanded(found.cage.positions), start_positions=cage.positions, euler=crop.euler(),
        exceptions=crop.exceptions(found.exceptions), folded=tuple(crop.faces[list(found.folded)].tolist()),
    )  # fmt: skip


def with_marks(cage: Cage, request: Request, edges: np.ndarray, marks: np.ndarray) -> Request:
    """The request; at marked edges (k, 2) of the boundary, what their marks (k,) say is held in place of `boundary`.
    ValueError where that is not possible on so many levels."""
    found, n = marked_boundary(cage, edges, marks, request.boundary), len(cage.positions)
    if not found.count:
        return request
    if request.levels > 1 and not found.refinable:
        raise ValueError(
            "Some edges of the boundary are free and others keep their position, by marks or by Boundary: a refined cage "
            "cannot do both. Use the cage's own vertices (Same Vertices, one level), or mark Tangent in place of Position."
        )
    weights = np.zeros(n)
    weights[request.held.vertices] = request.held.weights
    on_surface = np.zeros(n, bool)
    on_surface[request.held.vertices] = request.held.limit_points
    weights[found.held], on_surface[found.held] = 1, False
    vertices = np.flatnonzero(weights).astype(np.int32)
    held = Held(vertices, weights[vertices], on_surface[vertices])
    return replace(request, boundary=found.boundary, held=held, marked=found.count, refinable=found.refinable)


def freed(cage: Cage, request: Request) -> Request:
    """The request; where it is for the cage's own vertices, one level, and all of these are held, with the least number of
    levels at which one may move, up to two more. If there is none it stays as it is, and the run says so.

    LibraryError, CurvoptError, ValueError."""
    if request.levels > 1 or not request.refinable:
        return request
    lib = library.load()
    check_cage(len(cage.positions))
    with library.Mesh.of_cage(lib, cage) as mesh:
        level = mesh.moving_level(cage.positions, options_of(lib, replace(request, levels=1 + _MOST_REFINED)))
    return replace(request, levels=level, refined=level - 1) if level > 1 else request


def _counted(cage: Cage, request: Request) -> np.ndarray:
    """Faces (m,) that are no holes."""
    counted = np.ones(len(cage.face_sizes), bool)
    counted[request.holes] = False
    return counted


def _can_be_cropped(cage: Cage, request: Request) -> bool:
    """Whether only a part of the cage decides on the result: with holes, on one level, on surfaces where a face depends
    on its neighbours only (at a pole POLYNOMIAL depends on more), at energies that do not see the size of the cage. A part
    whose boundary is not held by the library's rule keeps no volume."""
    if not len(request.holes) or request.levels > 1 or not _counted(cage, request).any():
        return False
    local_surface = SURFACES[int(request.options.get("surface", 0))] != "polynomial"  # AUTO is LIMIT at second order
    second_order = set(weights_of(request.energy)) <= {"willmore", "mean_curvature"}
    exact = bool((np.asarray(request.held.weights) == 1).all()) and bool(np.isfinite(cage.positions).all())
    has_volume = not request.keeps_volume or request.boundary != "free"
    sees_all = not request.options.get("no_crossings")  # also faces that do not change are in the way
    scale_free = not request.options.get("spontaneous_curvature")  # with it the area of the whole counts
    return local_surface and second_order and exact and has_volume and sees_all and scale_free


def _solve(
    cage: Cage,
    request: Request,
    on_progress: OnProgress | None,
    cancel: library.Cancel | None,
    watcher: Watcher | None,
) -> Solution:
    """The same on the cage as it is."""
    lib = library.load()
    check_cage(len(cage.positions))
    guard = Guard()

    def step(progress: Progress) -> bool:
        wants_out = bool(on_progress is not None and on_progress(progress))
        return guard(progress) or wants_out

    options, recorder = options_of(lib, request), Recorder(cage.positions) if request.records else None

    def watch(iterate: library.Iterate) -> None:
        for each in (watcher, recorder):
            if each is not None:
                each(iterate)

    with library.Mesh.of_cage(lib, cage) as mesh:
        if watcher is not None:
            watcher.start(mesh, cage, np.flatnonzero(_counted(cage, request)) if len(request.holes) else None)
        with library.minimize(mesh, cage.positions, options, step, cancel, watch) as result:
            summary = result.summary()
            levels = tuple(result.level(index) for index in range(summary.n_levels))
            euler = result.mesh().info().euler
            final = result.cage()
            start = _subdivided(mesh, cage.positions, len(final.positions))
            of_interest = request.free(len(cage.positions)) if len(request.holes) else None
            stop = "memory" if guard.stopped and summary.stop == "cancelled" else summary.stop
            deviation = crossings = None
            n_before = summary.n_crossing_before
            if summary.stop != "cancelled":
                deviation, crossings = measured(mesh, cage, result.mesh(), final, cancel)
            if crossings is not None and crossings.n_pairs and not request.options.get("no_crossings"):
                original = measure.crossings(mesh, cage.positions, cancel=cancel)
                n_before = original.n_pairs if original.is_complete else 0
            path = recorder.path(mesh, final.positions) if recorder is not None else ()
            return Solution(
                final, start, summary.start, summary.end, euler, stop, summary.verification, summary.seconds,
                levels, summary.symmetry_order, mesh.exceptions(cage.positions, options, of_interest),
                summary.n_sliding, deviation, crossings, summary.multipliers, summary.scalar_residuals,
                summary.discretization_error, summary.clearance, summary.touching, n_before,
                folded_faces(mesh, cage, summary, options), summary.n_unfolded, path,
            )  # fmt: skip


def measured(
    mesh: library.Mesh, cage: Cage, final_mesh: library.Mesh, final: Cage, cancel: library.Cancel | None
) -> tuple[measure.Deviation, measure.Crossings] | tuple[None, None]:
    """How far the result is from the cage, and where it crosses itself; neither if it is cancelled meanwhile."""
    deviation = measure.deviation(mesh, cage.positions, final_mesh, final.positions, cancel=cancel)
    crossings = measure.crossings(final_mesh, final.positions, cancel=cancel)
    if np.isnan(deviation.rms) or not crossings.is_complete:
        return None, None
    return deviation, crossings


def folded_faces(mesh: library.Mesh, cage: Cage, summary: Summary, options: COptions) -> tuple[int, ...]:
    """The faces for which a run's first cage was found to be folded; none if that was not looked for."""
    return tuple(measure.folds(mesh, cage.positions, options).tolist()) if summary.n_folded else ()


def options_of(lib: library.Library, request: Request) -> COptions:
    """The library's options of a request."""
    symmetry, planes = symmetry_of(request.symmetry)
    scalars = {"volume": ("keep", 0.0)} if request.keeps_volume else {}
    return lib.options(
        weights_of(request.energy), request.held, levels=request.levels, boundary=BOUNDARIES.index(request.boundary),
        holes=request.holes, symmetry=symmetry, symmetry_planes=planes, strength=request.strength, scalars=scalars,
        within=request.within, through=request.through, chains=request.chains, **request.options,
    )  # fmt: skip


def _subdivided(mesh: library.Mesh, positions: np.ndarray, n_vertices: int) -> np.ndarray:
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
        flag, watcher = library.Cancel.create(library.load()), Watcher()
        return cls(lambda on_progress: solve(cage, request, on_progress, flag, watcher), flag.request, watcher)

    def start(self) -> None:
        """Start the worker; once only."""
        self._thread.start()

    def cancel(self) -> None:
        """Ask the worker to stop; may be called at any time and more than once."""
        self._cancelled.set()
        self._on_cancel()

    @property
    def running(self) -> bool:
        """Whether the worker is at work."""
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
    FINISHING = "finishing"
    FINISHED = "finished"
    CANCELLED = "cancelled"
    FAILED = "failed"

    @property
    def ended(self) -> bool:
        """Whether the run is over."""
        return self in (Phase.FINISHED, Phase.CANCELLED, Phase.FAILED)


class ModalRun:
    """What a modal operator does, without Blender: `tick` on every timer event, `escape` on ESC, `finish` on Enter,
    until
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

    def finish(self) -> None:
        """The user has seen enough: end with the best cage so far."""
        if self.phase is Phase.RUNNING:
            self.phase = Phase.FINISHING
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

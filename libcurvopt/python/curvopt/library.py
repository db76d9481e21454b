# SPDX-License-Identifier: GPL-3.0-or-later
"""ctypes binding of libcurvopt: handles and calls. `curvopt.h` is the manual, `abi.py` its mirror, `loading.py` finds and
checks the library, `api.py` is the public side.

Every handle has `close()` and is a context manager. An exception in a progress callback never crosses C: it is kept, the
run is cancelled, and it is raised again once C has returned.
"""

from __future__ import annotations

import ctypes as C
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from .abi import (
    EXCEPTIONS,
    PROGRESS_FN,
    SCALARS,
    STOPS,
    SURFACES,
    VERDICTS,
    CEnergies,
    CLevelReport,
    CMeshInfo,
    COptions,
    CProgress,
    CSummary,
)
from .loading import (
    INT32_MAX,
    Cancelled,
    CurvoptError,
    Library,
    LibraryError,
    creases_to_c,
    forget,
    indices,
    int_pointer,
    load,
    option_value,
    real_pointer,
    reals,
)
from .values import Cage, Creases, Energies, Exceptions, LevelReport, Progress, Summary, Verification

__all__ = (  # of loading.py, for whoever binds the library by this module
    "Cancelled", "CurvoptError", "Library", "LibraryError", "forget", "indices", "load", "option_value", "reals",
)  # fmt: skip

_Self = TypeVar("_Self")


class _Handle:
    """An opaque pointer that is destroyed once. With an `owner` it is borrowed, and keeps the owner alive."""

    _destroy = ""

    def __init__(self, lib: Library, pointer: C.c_void_p, owner: object = None) -> None:
        self.lib = lib
        self._pointer: C.c_void_p | None = pointer
        self._owner = owner
        if owner is None:
            lib.open.add(pointer.value)

    @property
    def pointer(self) -> C.c_void_p:
        """The C pointer. ValueError after close()."""
        if self._pointer is None:
            raise ValueError(f"This {type(self).__name__} is closed.")
        return self._pointer

    def close(self) -> None:
        """Free it; a second time does nothing."""
        pointer, self._pointer = self._pointer, None
        if pointer is not None and self._owner is None:
            self.lib.open.discard(pointer.value)  # before: another thread may get the same address
            getattr(self.lib.c, self._destroy)(pointer)

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_pointer", None) is not None:
            self.close()


class Mesh(_Handle):
    """curvopt_mesh: checked connectivity and creases."""

    _destroy = "curvopt_mesh_destroy"

    def __init__(self, lib: Library, pointer: C.c_void_p, owner: object = None, rule: str = "smooth") -> None:
        super().__init__(lib, pointer, owner)
        self.rule = rule  # of its creases; the library does not tell

    @classmethod
    def create(
        cls, lib: Library, n_vertices: int, face_sizes: object, face_vertices: object, creases: Creases | None = None
    ) -> Mesh:
        """face_sizes (m,), face_vertices (sum of sizes,). CurvoptError if that is no consistent surface."""
        sizes, vertices = indices(face_sizes, "face_sizes"), indices(face_vertices, "face_vertices")
        corners = int(np.maximum(sizes, 0).sum(dtype=np.int64))
        if vertices.size != corners:
            raise ValueError(f"face_vertices holds {vertices.size} indices, but face_sizes add up to {corners}.")
        if not 0 <= n_vertices <= INT32_MAX:
            raise ValueError(f"{n_vertices} vertices are beyond 32 bits.")
        creases = creases or Creases()
        raw, _arrays = creases_to_c(creases)
        pointer = lib.create(
            "curvopt_mesh_create_creased", n_vertices, sizes.size, int_pointer(sizes), int_pointer(vertices),
            C.byref(raw),
        )  # fmt: skip
        return cls(lib, pointer, rule=creases.rule)

    @classmethod
    def of_cage(cls, lib: Library, cage: Cage) -> Mesh:
        """Connectivity and creases of a cage. CurvoptError if that is no consistent surface."""
        return cls.create(lib, len(cage.positions), cage.face_sizes, cage.face_vertices, cage.creases)

    def info(self) -> CMeshInfo:
        """Counts, Euler characteristic, boundary."""
        info = CMeshInfo()
        self.lib.c.curvopt_mesh_get_info(self.pointer, C.byref(info), C.sizeof(info))
        return info

    def faces(self) -> tuple[np.ndarray, np.ndarray]:
        """(face_sizes (m,), face_vertices (n_corners,)), int32."""
        info = self.info()
        sizes, vertices = np.empty(info.n_faces, np.int32), np.empty(info.n_corners, np.int32)
        self.lib.c.curvopt_mesh_get_faces(self.pointer, int_pointer(sizes), int_pointer(vertices))
        return sizes, vertices

    def creases(self) -> Creases:
        """Its sharp edges and vertices; vertices that the rule "corners" keeps are among them, infinitely sharp."""
        n_edges, n_vertices = C.c_int32(), C.c_int32()
        self.lib.c.curvopt_mesh_count_creases(self.pointer, C.byref(n_edges), C.byref(n_vertices))
        edges, vertices = np.empty((n_edges.value, 2), np.int32), np.empty(n_vertices.value, np.int32)
        edge_sharpness, vertex_sharpness = np.empty(n_edges.value), np.empty(n_vertices.value)
        self.lib.c.curvopt_mesh_get_creases(
            self.pointer, int_pointer(edges), real_pointer(edge_sharpness), int_pointer(vertices),
            real_pointer(vertex_sharpness),
        )  # fmt: skip
        return Creases(edges, edge_sharpness, vertices, vertex_sharpness, self.rule)

    def exceptions(self, xyz: object, options: COptions, free: np.ndarray | None = None) -> Exceptions:
        """What a run from xyz (n_vertices, 3) with these options holds and leaves out of the energy, holes excepted; of
        that, where `free` (n_vertices,) is given, what holds vertices that would move without it."""
        info = self.info()
        points = reals(xyz, 3 * info.n_vertices, "xyz")
        vertices, faces = np.empty(info.n_vertices, np.int32), np.empty(info.n_faces, np.int32)
        self.lib.call(
            "curvopt_mesh_find_exceptions", self.pointer, real_pointer(points), C.byref(options),
            int_pointer(vertices), int_pointer(faces),
        )  # fmt: skip
        beside, hole = EXCEPTIONS.index("beside"), EXCEPTIONS.index("hole")
        sizes, corners = self.faces()
        left_out = (faces >= 0) & (faces != hole)
        if free is not None and len(sizes):
            left_out &= np.logical_or.reduceat(free[corners], np.cumsum(sizes) - sizes)
        there = np.bincount(corners[np.repeat(left_out, sizes)], minlength=info.n_vertices) > 0
        named = (vertices >= 0) & (vertices != beside) & (vertices != hole) & (there | (free is None))
        reasons = tuple(
            (self.lib.c.curvopt_exception_text(int(reason)).decode(), np.flatnonzero(named & (vertices == reason)))
            for reason in np.unique(vertices[named])
        )
        held = (named | there) & (True if free is None else free)
        return Exceptions(reasons, int(held.sum()), int(left_out.sum()))

    def moving_level(self, xyz: object, options: COptions) -> int:
        """The first level of a run from xyz (n_vertices, 3) at which a vertex may move, 0 if there is none."""
        points, level = reals(xyz, 3 * self.info().n_vertices, "xyz"), C.c_int32()
        self.lib.call(
            "curvopt_find_moving_level", self.pointer, real_pointer(points), C.byref(options), C.byref(level)
        )
        return level.value

    def refine(self, xyz: object) -> tuple[Mesh, np.ndarray]:
        """One Catmull-Clark step: the finer mesh and its positions (n_vertices + n_edges + n_faces, 3)."""
        info = self.info()
        coarse = reals(xyz, 3 * info.n_vertices, "xyz")
        fine = np.empty((info.n_vertices + info.n_edges + info.n_faces, 3))
        out = C.c_void_p()
        self.lib.call("curvopt_mesh_refine", self.pointer, real_pointer(coarse), C.byref(out), real_pointer(fine))
        return Mesh(self.lib, out, rule=self.rule), fine

    def jets(self, xyz: object, face: object, corner: object, uv: object, surface: str = "limit") -> np.ndarray:
        """Points and derivatives (n, 10, 3): S, S_u, S_v, S_uu, ... S_vvv at uv (n, 2) of face (n,), corner (n,)."""
        options = self.lib.options({"willmore": 1.0}, surface=SURFACES.index(surface))
        with Sampler.create(self, xyz, options) as sampler:
            return sampler.jets(face, corner, uv)


class Sampler(_Handle):
    """curvopt_sampler: a cage's surface, ready to be sampled."""

    _destroy = "curvopt_sampler_destroy"

    @classmethod
    def create(cls, mesh: Mesh, xyz: object, options: COptions) -> Sampler:
        """The surface of the cage xyz (n, 3) that these options stand for. CurvoptError if it has none."""
        points = reals(xyz, 3 * mesh.info().n_vertices, "xyz")
        pointer = mesh.lib.create("curvopt_sampler_create", mesh.pointer, real_pointer(points), C.byref(options))
        return cls(mesh.lib, pointer)

    def jets(self, face: object, corner: object, uv: object) -> np.ndarray:
        """Points and derivatives (n, 10, 3): S, S_u, S_v, S_uu, ... S_vvv at uv (n, 2) of face (n,), corner (n,)."""
        faces, corners = indices(face, "face"), indices(corner, "corner")
        if faces.size != corners.size:
            raise ValueError(f"face holds {faces.size} indices, but corner {corners.size}.")
        parameters = reals(uv, 2 * faces.size, "uv")
        jets = np.empty((faces.size, 10, 3))
        self.lib.call(
            "curvopt_sampler_jets", self.pointer, faces.size, int_pointer(faces), int_pointer(corners),
            real_pointer(parameters), real_pointer(jets),
        )  # fmt: skip
        return jets


class Problem(_Handle):
    """curvopt_problem: a mesh made ready for evaluation."""

    _destroy = "curvopt_problem_destroy"

    @classmethod
    def create(cls, mesh: Mesh, options: COptions, xyz: object = None, cancel: Cancel | None = None) -> Problem:
        """Faces that are degenerate at xyz (n, 3), if it is given, are left out. CurvoptError for a surface that cannot
        carry the energy; Cancelled."""
        points = None if xyz is None else reals(xyz, 3 * mesh.info().n_vertices, "xyz")
        pointer = mesh.lib.create(
            "curvopt_problem_create_interruptible", mesh.pointer, real_pointer(points), C.byref(options),
            PROGRESS_FN(), None, cancel.pointer if cancel else None,
        )  # fmt: skip
        problem = cls(mesh.lib, pointer)
        problem.n_vertices = mesh.info().n_vertices
        return problem

    def evaluate(
        self, xyz: object, with_gradient: bool = False, cancel: Cancel | None = None
    ) -> tuple[Energies, np.ndarray | None]:
        """Energies at xyz (n, 3) and, if asked for, the objective's gradient (n, 3). A problem whose evaluation was
        Cancelled can be evaluated again."""
        points = reals(xyz, 3 * self.n_vertices, "xyz")
        gradient = np.empty((self.n_vertices, 3)) if with_gradient else None
        raw = CEnergies()
        self.lib.call(
            "curvopt_problem_evaluate_interruptible", self.pointer, real_pointer(points), PROGRESS_FN(), None,
            cancel.pointer if cancel else None, C.byref(raw), C.sizeof(raw), real_pointer(gradient),
        )  # fmt: skip
        return Energies.from_c(raw), gradient


class Cancel(_Handle):
    """curvopt_cancel: a flag that any thread may raise."""

    _destroy = "curvopt_cancel_destroy"

    @classmethod
    def create(cls, lib: Library) -> Cancel:
        """A flag that is not raised."""
        return cls(lib, lib.create("curvopt_cancel_create"))

    def request(self) -> None:
        """Stop the call that was given this flag, at its next opportunity."""
        self.lib.c.curvopt_cancel_request(self.pointer)


def _summary(
    raw: CSummary, start: CEnergies, end: CEnergies, touching: tuple[tuple[int, int], ...] = ()
) -> Summary:
    return Summary(
        Energies.from_c(start), Energies.from_c(end), raw.seconds, STOPS[raw.stop],
        Verification(VERDICTS[raw.verdict], raw.newton_decrement, raw.negative_directions, raw.touch_rise,
                     bool(raw.is_delicate)),
        raw.n_levels, raw.n_vertices, raw.n_faces, raw.symmetry_order,
        raw.free_negative_directions, raw.all_negative_directions, raw.n_sliding,
        dict(zip(SCALARS, raw.multiplier)), dict(zip(SCALARS, raw.scalar_residual)), raw.discretization_error,
        raw.clearance, touching, raw.n_crossing_before, raw.n_refused, raw.spring_energy, raw.n_folded, raw.n_unfolded,
    )  # fmt: skip


def _level_report(raw: CLevelReport) -> LevelReport:
    values = {name: getattr(raw, name) for name in LevelReport.__dataclass_fields__}
    return LevelReport(**{**values, "stop": STOPS[raw.stop]})


class Result(_Handle):
    """curvopt_result: the optimized cage and what happened."""

    _destroy = "curvopt_result_destroy"

    def __init__(self, lib: Library, pointer: C.c_void_p, rule: str) -> None:
        super().__init__(lib, pointer)
        self.rule = rule  # of its mesh

    def mesh(self) -> Mesh:
        """The optimized cage's connectivity and creases, borrowed."""
        return Mesh(self.lib, C.c_void_p(self.lib.c.curvopt_result_mesh(self.pointer)), self, self.rule)

    def cage(self) -> Cage:
        """A copy of the optimized cage."""
        positions = np.empty((self.summary().n_vertices, 3))
        self.lib.c.curvopt_result_get_positions(self.pointer, real_pointer(positions))
        mesh = self.mesh()
        return Cage(positions, *mesh.faces(), mesh.creases())

    def summary(self) -> Summary:
        """Energies at start and end, stop reason, verdict, size, symmetries."""
        raw = CSummary()
        self.lib.c.curvopt_result_get_summary(self.pointer, C.byref(raw), C.sizeof(raw))
        start, end = CEnergies(), CEnergies()
        self.lib.c.curvopt_result_get_energies(self.pointer, C.byref(start), C.byref(end), C.sizeof(CEnergies))
        pairs = np.empty((raw.n_touching, 2), np.int32)
        self.lib.c.curvopt_result_get_touching(self.pointer, int_pointer(pairs))
        return _summary(raw, start, end, tuple((int(f), int(g)) for f, g in pairs))

    def level(self, index: int) -> LevelReport:
        """Report of level index 0 .. n_levels - 1. CurvoptError outside."""
        raw = CLevelReport()
        self.lib.call("curvopt_result_get_level", self.pointer, index, C.byref(raw), C.sizeof(raw))
        return _level_report(raw)


class Iterate:
    """The cage of a run that is on, within its callback: what it lends is void once the callback returns."""

    def __init__(self, lib: Library, raw: CProgress, progress: Progress) -> None:
        self.progress = progress
        self._lib, self._raw = lib, raw

    def mesh(self) -> Mesh:
        """The connectivity of the current level, borrowed."""
        return Mesh(self._lib, C.c_void_p(self._raw.mesh), self)

    def positions(self) -> np.ndarray:
        """A copy of the vertices (n, 3)."""
        return np.ctypeslib.as_array(self._raw.xyz, (self._raw.n_vertices, 3)).copy()


def _callback(
    lib: Library,
    on_progress: Callable[[Progress], object] | None,
    watch: Callable[[Iterate], object] | None,
) -> tuple[object, list[BaseException]]:
    """What C calls after every step, to be kept alive as long as it may; and what the functions have raised."""
    raised: list[BaseException] = []

    def trampoline(progress: object, _user: object) -> int:
        try:
            step = Progress.from_c(progress.contents)
            if watch is not None:
                watch(Iterate(lib, progress.contents, step))
            return 1 if on_progress is not None and on_progress(step) else 0
        except BaseException as error:  # nothing may cross the C frame; raised again by the caller
            raised.append(error)
            return 1

    return PROGRESS_FN(trampoline) if on_progress or watch else PROGRESS_FN(), raised


def minimize(
    mesh: Mesh,
    xyz: object,
    options: COptions,
    on_progress: Callable[[Progress], object] | None = None,
    cancel: Cancel | None = None,
    watch: Callable[[Iterate], object] | None = None,
) -> Result:
    """Minimize over xyz (n, 3). `on_progress` is called on this thread after every step; a true value cancels. `watch`
    is called before it, with the cage as it is then.

    Runs without Python's global lock. CurvoptError as in curvopt.h; whatever `on_progress` raises is raised here."""
    points = reals(xyz, 3 * mesh.info().n_vertices, "xyz")
    callback, raised = _callback(mesh.lib, on_progress, watch)
    flag = cancel.pointer if cancel else None
    try:
        pointer = mesh.lib.create(
            "curvopt_minimize", mesh.pointer, real_pointer(points), C.byref(options), callback, None, flag
        )
    except CurvoptError:
        if raised:
            raise raised[0] from None
        raise
    result = Result(mesh.lib, pointer, mesh.rule)
    if raised:
        result.close()
        raise raised[0]
    return result


class Solver(_Handle):
    """curvopt_solver: one level of a cage, solved again and again."""

    _destroy = "curvopt_solver_destroy"

    @classmethod
    def create(cls, mesh: Mesh, xyz: object, options: COptions) -> Solver:
        """Of the cage xyz (n, 3). CurvoptError as in curvopt.h."""
        n = mesh.info().n_vertices
        pointer = mesh.lib.create(
            "curvopt_solver_create", mesh.pointer, real_pointer(reals(xyz, 3 * n, "xyz")), C.byref(options)
        )
        solver = cls(mesh.lib, pointer)
        solver.n_vertices = n
        solver.n_constraints = options.constraints.contents.n if options.constraints else 0
        return solver

    def set_places(self, places: object) -> None:
        """Where the constraints go through: (k, 3), in their order; NAN: where the vertex was."""
        points = reals(places, 3 * self.n_constraints, "places")
        self.lib.call("curvopt_solver_set_places", self.pointer, real_pointer(points))

    def set_options(self, options: COptions) -> None:
        """Other options, with their constraints."""
        self.lib.call("curvopt_solver_set_options", self.pointer, C.byref(options))
        self.n_constraints = options.constraints.contents.n if options.constraints else 0

    def set_positions(self, xyz: object = None) -> None:
        """Stand at xyz (n, 3), or where it was created."""
        points = None if xyz is None else reals(xyz, 3 * self.n_vertices, "xyz")
        self.lib.call("curvopt_solver_set_positions", self.pointer, real_pointer(points))

    def solve(
        self,
        settle: bool = True,
        on_progress: Callable[[Progress], object] | None = None,
        cancel: Cancel | None = None,
        watch: Callable[[Iterate], object] | None = None,
    ) -> None:
        """From where it stands to its targets, as minimize(). Runs without Python's global lock."""
        callback, raised = _callback(self.lib, on_progress, watch)
        flag = cancel.pointer if cancel else None
        try:
            self.lib.call("curvopt_solver_solve", self.pointer, int(settle), callback, None, flag)
        except CurvoptError:
            if raised:
                raise raised[0] from None
            raise
        if raised:
            raise raised[0]

    def positions(self) -> np.ndarray:
        """A copy of where it stands (n, 3)."""
        points = np.empty((self.n_vertices, 3))
        self.lib.c.curvopt_solver_get_positions(self.pointer, real_pointer(points))
        return points

    def summary(self) -> Summary:
        """Of the last solution."""
        raw, start, end = CSummary(), CEnergies(), CEnergies()
        self.lib.c.curvopt_solver_get_summary(self.pointer, C.byref(raw), C.sizeof(raw))
        self.lib.c.curvopt_solver_get_energies(self.pointer, C.byref(start), C.byref(end), C.sizeof(CEnergies))
        return _summary(raw, start, end)

    def report(self) -> LevelReport:
        """Of the last solution."""
        raw = CLevelReport()
        self.lib.c.curvopt_solver_get_report(self.pointer, C.byref(raw), C.sizeof(raw))
        return _level_report(raw)

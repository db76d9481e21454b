# SPDX-License-Identifier: GPL-3.0-or-later
"""The library and the command line as the numeric tests call them: a ctypes binding of their own, from the header.

Both are taken from build/release, or from the folder that CURVOPT_BUILD names.
"""
from __future__ import annotations

import ctypes as C
import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Callable

import numpy as np

from ccref import Mesh
from nets import read_obj, write_obj

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("CURVOPT_BUILD", ROOT / "build" / "release"))
LONG = os.environ.get("CURVOPT_LONG") == "1"

I32, F64, PTR, SIZE = C.c_int32, C.c_double, C.c_void_p, C.c_size_t
_LIBRARY = C.CDLL(str(BUILD / "libcurvopt.so"))


def names(of: str) -> tuple[str, ...]:
    """Names or texts of an enumeration of the library from 0 on, by a function such as "curvopt_term_name"."""
    function, known = getattr(_LIBRARY, of), getattr(_LIBRARY, of.replace("_text", "_name"))
    function.restype = known.restype = C.c_char_p
    found = []
    while known(len(found)) is not None:
        found.append(function(len(found)).decode())
    return tuple(found)


WEIGHTS = names("curvopt_term_name")
TERMS = tuple(name for name in WEIGHTS if name not in ("area", "mean_curvature"))
SURFACES = {name: i for i, name in enumerate(names("curvopt_surface_name"))}
METHODS = {name: i for i, name in enumerate(names("curvopt_method_name"))}
VERDICTS = names("curvopt_verdict_text")
STOPS = names("curvopt_stop_text")
MAX_TERMS = 8  # CURVOPT_MAX_TERMS
SCALARS = names("curvopt_scalar_name")
SCALAR_RULES = {name: i for i, name in enumerate(names("curvopt_scalar_rule_name"))}
MAX_SCALARS = 6  # CURVOPT_MAX_SCALARS


class Error(C.Structure):
    """curvopt_error"""

    _fields_ = [("code", I32), ("element", I32), ("message", C.c_char * 248)]


class MeshInfo(C.Structure):
    """curvopt_mesh_info"""

    _fields_ = [(name, I32) for name in ("n_vertices", "n_edges", "n_faces", "n_corners", "n_components",
                                         "n_boundary_edges", "n_extraordinary", "max_valence", "euler", "all_quads",
                                         "n_isolated", "n_flawed_edges")]


class Creases(C.Structure):
    """curvopt_creases"""

    _fields_ = [(name, C.c_void_p) for name in ("crease_vertices", "crease_sharpness", "corner_vertices",
                                                "corner_sharpness")] + [
        (name, I32) for name in ("n_creases", "n_corners", "boundary_rule", "reserved")]


class Options(C.Structure):
    """curvopt_options"""

    _fields_ = [(name, I32) for name in ("struct_size", "surface", "method", "levels", "max_iterations", "threads",
                                         "joshi_sequin", "boundary")] + [
        ("weights", F64 * MAX_TERMS), ("tolerance", F64), ("gradient_tolerance", F64),
        ("decrement_tolerance", F64), ("max_step", F64),
        ("constraints", C.c_void_p), ("symmetry", I32), ("verify", I32),
        ("escape", I32), ("symmetry_planes", I32), ("blend_width", I32),
        ("spacing", I32), ("strength", F64), ("holes", C.c_void_p), ("n_holes", I32), ("strict", I32),
        ("slide", I32), ("scalar_rule", I32 * MAX_SCALARS), ("scalar_value", F64 * MAX_SCALARS),
        ("within", F64), ("spontaneous_curvature", F64), ("through", C.c_void_p), ("no_crossings", I32), ("reserved", I32)]


class Energies(C.Structure):
    """curvopt_energies"""

    _fields_ = [("objective", F64), ("area", F64), ("term", F64 * MAX_TERMS), ("h2", F64), ("gauss", F64),
                ("gauss_bonnet_defect", F64), ("objective_error", F64), ("area_error", F64), ("term_error", F64 * MAX_TERMS),
                ("min_jacobian", F64), ("surface", I32), ("n_samples", I32), ("volume", F64), ("total_mean_curvature", F64),
                ("helfrich", F64)]

    def value(self, name: str) -> float:
        """A term or field by name."""
        return self.term[WEIGHTS.index(name)] if name in WEIGHTS and name != "area" else getattr(self, name)


class Progress(C.Structure):
    """curvopt_progress"""

    _fields_ = [(name, I32) for name in ("struct_size", "level", "levels", "iteration", "evaluations", "n_vertices",
                                         "samples", "method", "rejected", "reserved")] + [
        ("xyz", C.POINTER(F64)), ("mesh", PTR)] + [(name, F64) for name in (
            "energy", "start_energy", "gradient_norm", "seconds", "predicted", "shift", "gain_ratio", "step")]


class Constraints(C.Structure):
    """curvopt_constraints; made by constraints()"""

    _fields_ = [("vertices", C.c_void_p), ("freedom", C.c_void_p), ("directions", C.c_void_p), ("n", I32),
                ("has_places", I32), ("weights", C.c_void_p), ("places", C.c_void_p)]


class Through(C.Structure):
    """curvopt_through; made by through()"""

    _fields_ = [("struct_size", I32), ("n", I32)] + [(name, C.c_void_p) for name in (
        "vertices", "faces", "corners", "uv", "freedom", "directions", "places", "normals", "tangents", "toward",
        "weights", "chains")] + [("n_chains", I32), ("reserved", I32)] + [(name, C.c_void_p) for name in (
            "chain_weights", "curvatures", "curvature_directions")]


class Chain(C.Structure):
    """curvopt_chain; made by chain()"""

    _fields_ = [(name, C.c_void_p) for name in ("vertices", "curve", "parameters")] + [(name, I32) for name in (
        "n_vertices", "n_points", "is_closed", "is_curve_closed")]


class LevelReport(C.Structure):
    """curvopt_level_report"""

    _fields_ = [("energy", F64), ("gradient_norm", F64), ("seconds", F64)] + [(name, I32) for name in (
        "level", "n_vertices", "iterations", "evaluations", "stop", "reserved")]


class Summary(C.Structure):
    """curvopt_summary; Result adds `start` and `end`, Energies"""

    _fields_ = [("seconds", F64), ("newton_decrement", F64), ("shape_decrement", F64)] + [
        (name, I32) for name in ("n_levels", "stop", "n_vertices", "n_faces", "method", "verdict",
                                 "negative_directions", "symmetry_order")] + [
        ("difference_decrement", F64), ("all_negative_directions", I32), ("free_negative_directions", I32),
        ("n_held", I32), ("n_left_out", I32), ("curve_deviation", F64), ("n_sliding", I32), ("n_folded", I32),
        ("multiplier", F64 * MAX_SCALARS), ("scalar_residual", F64 * MAX_SCALARS),
        ("discretization_error", F64), ("clearance", F64), ("n_touching", I32), ("n_crossing_before", I32),
        ("n_refused", I32), ("n_unfolded", I32), ("spring_energy", F64),
        ("touch_rise", F64), ("is_delicate", I32), ("reserved", I32)]


class Deviation(C.Structure):
    """curvopt_deviation"""

    _fields_ = [("max", F64), ("rms", F64), ("bound", F64), ("size", F64), ("point", F64 * 3), ("other_point", F64 * 3)]


class Crossings(C.Structure):
    """curvopt_crossings; crossings() adds `pairs`"""

    _fields_ = [(name, I32) for name in ("n_pairs", "n_contacts", "n_unresolved", "n_listed",
                                         "is_complete", "reserved")]


PROGRESS_FN = C.CFUNCTYPE(I32, C.POINTER(Progress), PTR)

SIGNATURES = {
    "curvopt_mesh_create": (I32, [I32, I32, PTR, PTR, PTR, PTR]),
    "curvopt_mesh_create_creased": (I32, [I32, I32, PTR, PTR, PTR, PTR, PTR]),
    "curvopt_mesh_destroy": (None, [PTR]),
    "curvopt_mesh_count_creases": (None, [PTR, PTR, PTR]),
    "curvopt_mesh_get_creases": (None, [PTR, PTR, PTR, PTR, PTR]),
    "curvopt_mesh_get_info": (None, [PTR, PTR, SIZE]),
    "curvopt_mesh_get_faces": (None, [PTR, PTR, PTR]),
    "curvopt_mesh_refine": (I32, [PTR, PTR, PTR, PTR, PTR]),
    "curvopt_mesh_find_exceptions": (I32, [PTR, PTR, PTR, PTR, PTR, PTR]),
    "curvopt_exception_name": (C.c_char_p, [I32]),
    "curvopt_options_init": (None, [PTR, SIZE]),
    "curvopt_problem_create": (I32, [PTR, PTR, PTR, PTR, PTR]),
    "curvopt_problem_destroy": (None, [PTR]),
    "curvopt_problem_evaluate": (I32, [PTR, PTR, PTR, SIZE, PTR, PTR]),
    "curvopt_sampler_create": (I32, [PTR, PTR, PTR, PTR, PTR]),
    "curvopt_sampler_destroy": (None, [PTR]),
    "curvopt_sampler_jets": (I32, [PTR, I32, PTR, PTR, PTR, PTR, PTR]),
    "curvopt_measure_deviation": (I32, [PTR, PTR, PTR, PTR, I32, PTR, PTR, SIZE, PTR, PTR]),
    "curvopt_find_crossings": (I32, [PTR, PTR, I32, PTR, I32, PTR, PTR, SIZE, PTR]),
    "curvopt_find_folds": (I32, [PTR, PTR, PTR, PTR, PTR, PTR, PTR]),
    "curvopt_minimize": (I32, [PTR, PTR, PTR, PROGRESS_FN, PTR, PTR, PTR, PTR]),
    "curvopt_cancel_create": (I32, [PTR, PTR]),
    "curvopt_cancel_request": (None, [PTR]),
    "curvopt_cancel_destroy": (None, [PTR]),
    "curvopt_result_destroy": (None, [PTR]),
    "curvopt_result_mesh": (PTR, [PTR]),
    "curvopt_result_get_positions": (None, [PTR, PTR]),
    "curvopt_result_get_touching": (None, [PTR, PTR]),
    "curvopt_result_get_summary": (None, [PTR, PTR, SIZE]),
    "curvopt_result_get_energies": (None, [PTR, PTR, PTR, SIZE]),
    "curvopt_result_get_level": (I32, [PTR, I32, PTR, SIZE, PTR]),
}
for _name, (_result, _arguments) in SIGNATURES.items():
    getattr(_LIBRARY, _name).restype, getattr(_LIBRARY, _name).argtypes = _result, _arguments


class CurvoptError(Exception):
    """A nonzero status with the library's message."""


def library() -> C.CDLL:
    """The loaded library with typed functions."""
    return _LIBRARY


def call(name: str, *arguments) -> None:
    """Call a fallible function; CurvoptError unless it returns 0."""
    error = Error()
    code = getattr(library(), name)(*arguments, C.byref(error))
    if code:
        raise CurvoptError(f"{name}: {code}: {error.message.decode('utf-8', 'replace')}")


def _pointer(array: np.ndarray) -> int:
    return array.ctypes.data


class Handle:
    """An opaque pointer that is destroyed with its owner."""

    def __init__(self, destroy: str):
        self.pointer, self._destroy = PTR(), destroy

    def __del__(self):
        getattr(library(), self._destroy)(self.pointer)


def make_mesh(mesh: Mesh, boundary_rule: int = 0) -> Handle:
    """curvopt_mesh of the connectivity and its creases."""
    handle = Handle("curvopt_mesh_destroy")
    sizes, flat = mesh.sizes.astype(np.int32), np.ascontiguousarray(mesh.flat, np.int32)
    vertex = np.zeros(0) if mesh.vertex_sharpness is None else np.asarray(mesh.vertex_sharpness, np.float64)
    corners = np.flatnonzero(vertex).astype(np.int32)
    if boundary_rule == 0 and len(mesh.creases) == 0 and len(corners) == 0:
        call("curvopt_mesh_create", mesh.n_vertices, mesh.n_faces, _pointer(sizes), _pointer(flat),
             C.byref(handle.pointer))
        return handle
    pairs, sharpness = np.ascontiguousarray(mesh.creases, np.int32), np.asarray(mesh.crease_sharpness, np.float64)
    vertex = np.ascontiguousarray(vertex[corners])
    creases = Creases(_pointer(pairs), _pointer(sharpness), _pointer(corners), _pointer(vertex), len(pairs),
                      len(corners), boundary_rule, 0)
    call("curvopt_mesh_create_creased", mesh.n_vertices, mesh.n_faces, _pointer(sizes), _pointer(flat),
         C.byref(creases), C.byref(handle.pointer))
    return handle


def positions(mesh: Mesh) -> np.ndarray:
    """Contiguous doubles."""
    return np.ascontiguousarray(mesh.xyz, np.float64)


def read_mesh(pointer, xyz: np.ndarray | None = None) -> Mesh:
    """Connectivity of a curvopt_mesh, with positions if given."""
    info = MeshInfo()
    library().curvopt_mesh_get_info(pointer, C.byref(info), C.sizeof(info))
    sizes, flat = np.empty(info.n_faces, np.int32), np.empty(info.n_corners, np.int32)
    library().curvopt_mesh_get_faces(pointer, _pointer(sizes), _pointer(flat))
    xyz = np.zeros((info.n_vertices, 3)) if xyz is None else xyz
    n_creases, n_corners = I32(), I32()
    library().curvopt_mesh_count_creases(pointer, C.byref(n_creases), C.byref(n_corners))
    pairs, sharpness = np.empty((n_creases.value, 2), np.int32), np.empty(n_creases.value)
    corners, corner_sharpness = np.empty(n_corners.value, np.int32), np.empty(n_corners.value)
    library().curvopt_mesh_get_creases(pointer, _pointer(pairs), _pointer(sharpness), _pointer(corners),
                                       _pointer(corner_sharpness))
    vertex = np.zeros(info.n_vertices)
    vertex[corners] = corner_sharpness
    return Mesh(sizes.astype(np.int64), flat.astype(np.int64), xyz, pairs.astype(np.int64), sharpness, vertex)


def refine(mesh: Mesh) -> Mesh:
    """curvopt_mesh_refine."""
    handle, fine = make_mesh(mesh), Handle("curvopt_mesh_destroy")
    info = MeshInfo()
    library().curvopt_mesh_get_info(handle.pointer, C.byref(info), C.sizeof(info))
    xyz = np.empty((info.n_vertices + info.n_edges + info.n_faces, 3))
    call("curvopt_mesh_refine", handle.pointer, _pointer(positions(mesh)), C.byref(fine.pointer), _pointer(xyz))
    return read_mesh(fine.pointer, xyz)


def exceptions(mesh: Mesh, weights="willmore", boundary_rule: int = 0, **fields) -> tuple[list[str], list[str]]:
    """curvopt_mesh_find_exceptions: the reason of every vertex and of every face by name, "" where there is none."""
    handle, opts = make_mesh(mesh, boundary_rule), options(weights, **fields)
    vertex, face = np.empty(mesh.n_vertices, np.int32), np.empty(mesh.n_faces, np.int32)
    call("curvopt_mesh_find_exceptions", handle.pointer, _pointer(positions(mesh)), C.byref(opts), _pointer(vertex),
         _pointer(face))
    names = [library().curvopt_exception_name(i) for i in range(12)]
    return tuple([names[i].decode() if i >= 0 else "" for i in found] for found in (vertex, face))


def holes(faces) -> dict[str, object]:
    """Fields of the options that name these faces as holes; keeps the array alive for as long as it is referred to."""
    array = np.ascontiguousarray(list(faces), np.int32)
    holes.kept = getattr(holes, "kept", []) + [array]
    return {"holes": array.ctypes.data, "n_holes": len(array)}


def constraints(vertices, freedom=None, directions=None, weights=None, places=None) -> Constraints:
    """Vertices, how many dimensions each has left (None: 0), directions [n, 3], and how firmly each is held, 0 to 1 or
    all alike (None: 1), and places [n, 3]; keeps the arrays alive."""
    kept = [np.ascontiguousarray(list(vertices), np.int32)]
    kept += [None if freedom is None else np.ascontiguousarray(freedom, np.int32),
             None if directions is None else np.ascontiguousarray(directions, np.float64),
             None if weights is None else np.ascontiguousarray(np.broadcast_to(weights, len(kept[0])), np.float64),
             None if places is None else np.ascontiguousarray(places, np.float64)]
    vertex, free, direction, weight, place = (None if a is None else a.ctypes.data for a in kept)
    out = Constraints(vertex, free, direction, len(kept[0]), places is not None, weight, place)
    out.kept = kept
    return out


def through(vertices=None, faces=None, corners=None, uv=None, freedom=None, directions=None, places=None, normals=None,
            tangents=None, toward=None, weights=None, chains=(), chain_weights=None, curvatures=None,
            curvature_directions=None) -> Through:
    """Points of the surface, as in curvopt.h: vertices [n] or faces [n] with uv [n, 2]; chains; keeps the arrays alive."""
    kept = [None if a is None else np.ascontiguousarray(a, kind) for a, kind in (
        (vertices, np.int32), (faces, np.int32), (corners, np.int32), (uv, float), (freedom, np.int32), (directions, float),
        (places, float), (normals, float), (tangents, float), (toward, np.int32),
        (weights, float), (chain_weights, float), (curvatures, float), (curvature_directions, float))]
    array = (Chain * len(chains))(*chains)
    pointers = [None if a is None else a.ctypes.data for a in kept]
    out = Through(C.sizeof(Through), next((len(a) for a in kept[:2] if a is not None), 0), *pointers[:-3],
                  C.addressof(array), len(chains), 0, *pointers[-3:])
    out.kept = kept, array, chains
    return out


def chain(vertices, curve, closed=False, curve_closed=False, parameters=None) -> Chain:
    """A chain of edges [n] that follows the curve [m, 3]; keeps the arrays alive."""
    kept = [None if a is None else np.ascontiguousarray(a, kind) for a, kind in (
        (vertices, np.int32), (curve, float), (parameters, float))]
    out = Chain(*(None if a is None else a.ctypes.data for a in kept), len(kept[0]), len(kept[1]), closed, curve_closed)
    out.kept = kept
    return out


def options(weights: dict[str, float] | str = "willmore", surface: str = "auto", **fields) -> Options:
    """Defaults, changed: weights by term name or the name of one term; any other field by its name. hold: rules by the
    name of a scalar, "keep", a value, or ("reduced", value)."""
    out = Options()
    library().curvopt_options_init(C.byref(out), C.sizeof(out))
    weights = {weights: 1.0} if isinstance(weights, str) else weights
    for i, name in enumerate(WEIGHTS):
        out.weights[i] = weights.get(name, 0.0)
    out.surface = SURFACES[surface]
    for name, value in fields.pop("hold", {}).items():
        rule, number = value if isinstance(value, tuple) else ("keep", 0.0) if value == "keep" else ("value", value)
        out.scalar_rule[SCALARS.index(name)], out.scalar_value[SCALARS.index(name)] = SCALAR_RULES[rule], number
    for name, value in fields.items():
        if isinstance(value, (Constraints, Through)):
            out.kept = getattr(out, "kept", []) + [value]
            value = C.addressof(value)
        setattr(out, name, METHODS[value] if name == "method" else value)
    return out


class Problem:
    """A cage made ready for evaluation."""

    def __init__(self, mesh: Mesh, opts: Options):
        self._mesh = make_mesh(mesh)
        self._handle = Handle("curvopt_problem_destroy")
        call("curvopt_problem_create", self._mesh.pointer, _pointer(positions(mesh)), C.byref(opts),
             C.byref(self._handle.pointer))

    def evaluate(self, xyz: np.ndarray, gradient: bool = False):
        """Energies, or (Energies, gradient [n, 3])."""
        xyz = np.ascontiguousarray(xyz, np.float64)
        out = Energies()
        slope = np.empty_like(xyz)
        call("curvopt_problem_evaluate", self._handle.pointer, _pointer(xyz), C.byref(out), C.sizeof(out),
             _pointer(slope) if gradient else None)
        return (out, slope) if gradient else out


def evaluate(mesh: Mesh, weights="willmore", surface: str = "auto", **fields) -> Energies:
    """Energies of a cage."""
    return Problem(mesh, options(weights, surface, **fields)).evaluate(mesh.xyz)


def jets(mesh: Mesh, face, corner, uv, surface: str = "limit", boundary_rule: int = 0, **fields) -> np.ndarray:
    """Jets [n, 10, 3] by a curvopt_sampler of this surface; other fields of its options by their names."""
    handle, sampler = make_mesh(mesh, boundary_rule), Handle("curvopt_sampler_destroy")
    opts = options("willmore", surface, **fields)
    face, corner = (np.ascontiguousarray(a, np.int32) for a in (face, corner))
    uv = np.ascontiguousarray(uv, np.float64).reshape(-1, 2)
    out = np.empty((len(face), 10, 3))
    call("curvopt_sampler_create", handle.pointer, _pointer(positions(mesh)), C.byref(opts), C.byref(sampler.pointer))
    call("curvopt_sampler_jets", sampler.pointer, len(face), _pointer(face), _pointer(corner), _pointer(uv),
         _pointer(out))
    return out


def deviation(mesh: Mesh, other: Mesh, threads: int = 0, boundary_rule: int = 0) -> tuple[Deviation, np.ndarray]:
    """curvopt_measure_deviation, and the distances [n] of the other cage's limit points."""
    one, two, out = make_mesh(mesh, boundary_rule), make_mesh(other, boundary_rule), Deviation()
    distances = np.full(other.n_vertices, -1.0)
    call("curvopt_measure_deviation", one.pointer, _pointer(positions(mesh)), two.pointer, _pointer(positions(other)),
         threads, None, C.byref(out), C.sizeof(out), _pointer(distances))
    return out, distances


def folds(mesh: Mesh, **fields) -> np.ndarray:
    """curvopt_find_folds: the folded faces, ascending."""
    handle, opts, folded = make_mesh(mesh), options("willmore", "auto", **fields), np.empty(mesh.n_faces, np.int32)
    n = C.c_int32(-1)
    call("curvopt_find_folds", handle.pointer, _pointer(positions(mesh)), C.byref(opts), None, _pointer(folded), C.byref(n))
    assert n.value == folded.sum() and set(folded) <= {0, 1}
    return np.flatnonzero(folded)


def crossings(mesh: Mesh, threads: int = 0, room: int = 10000, boundary_rule: int = 0) -> Crossings:
    """curvopt_find_crossings, with pairs [n_listed, 2]."""
    handle, out, pairs = make_mesh(mesh, boundary_rule), Crossings(), np.empty((room, 2), np.int32)
    call("curvopt_find_crossings", handle.pointer, _pointer(positions(mesh)), threads, None, room, _pointer(pairs),
         C.byref(out), C.sizeof(out))
    out.pairs = pairs[:out.n_listed]
    return out


class Result:
    """What a run returned: cage, summary and level reports."""

    def __init__(self, handle: Handle):
        self.summary = Summary()
        library().curvopt_result_get_summary(handle.pointer, C.byref(self.summary), C.sizeof(self.summary))
        self.summary.start, self.summary.end = Energies(), Energies()
        library().curvopt_result_get_energies(handle.pointer, C.byref(self.summary.start), C.byref(self.summary.end),
                                              C.sizeof(Energies))
        xyz = np.empty((self.summary.n_vertices, 3))
        library().curvopt_result_get_positions(handle.pointer, _pointer(xyz))
        self.mesh = read_mesh(library().curvopt_result_mesh(handle.pointer), xyz)
        self.touching = np.empty((self.summary.n_touching, 2), np.int32)
        library().curvopt_result_get_touching(handle.pointer, _pointer(self.touching))
        self.stop = STOPS[self.summary.stop]
        self.verdict = VERDICTS[self.summary.verdict]
        self.levels = []
        for i in range(self.summary.n_levels):
            report = LevelReport()
            call("curvopt_result_get_level", handle.pointer, i, C.byref(report), C.sizeof(report))
            self.levels.append(report)


def minimize(mesh: Mesh, weights="willmore", surface: str = "auto", progress: Callable[[Progress], bool] | None = None,
             cancel: Handle | None = None, **fields) -> Result:
    """curvopt_minimize; `progress` returns true to cancel. What it raises is raised again here."""
    raised: list[BaseException] = []

    def trampoline(report, _user) -> int:
        try:
            return int(bool(progress(report.contents)))
        except BaseException as error:  # must not cross the C frame
            raised.append(error)
            return 1

    handle, out = make_mesh(mesh), Handle("curvopt_result_destroy")
    opts = options(weights, surface, **fields)
    call("curvopt_minimize", handle.pointer, _pointer(positions(mesh)), C.byref(opts),
         PROGRESS_FN(trampoline) if progress else PROGRESS_FN(0), None, cancel.pointer if cancel else None,
         C.byref(out.pointer))
    if raised:
        raise raised[0]
    return Result(out)


def make_cancel() -> Handle:
    """curvopt_cancel; raise it with library().curvopt_cancel_request(handle.pointer)."""
    handle = Handle("curvopt_cancel_destroy")
    call("curvopt_cancel_create", C.byref(handle.pointer))
    return handle


def run_cli(*arguments: str, timeout: float = 600) -> subprocess.CompletedProcess:
    """Run the command line."""
    return subprocess.run([str(BUILD / "curvopt"), *arguments], capture_output=True, text=True, timeout=timeout)


def cli_evaluate(mesh: Mesh, *arguments: str) -> dict:
    """JSON of `curvopt evaluate`."""
    with tempfile.TemporaryDirectory() as folder:
        cage = write_obj(Path(folder) / "cage.obj", mesh)
        run = run_cli("evaluate", str(cage), "--json", "-", *arguments)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def cli_minimize(mesh: Mesh, *arguments: str) -> tuple[dict, Mesh]:
    """JSON and output cage of `curvopt minimize`."""
    with tempfile.TemporaryDirectory() as folder:
        cage = write_obj(Path(folder) / "cage.obj", mesh)
        out = Path(folder) / "out.obj"
        report = Path(folder) / "report.json"
        run = run_cli("minimize", str(cage), "-o", str(out), "--json", str(report), "--quiet", *arguments)
        assert run.returncode == 0, run.stderr
        return json.loads(report.read_text(encoding="utf-8")), read_obj(out)

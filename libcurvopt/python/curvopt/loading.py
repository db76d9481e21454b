# SPDX-License-Identifier: GPL-3.0-or-later
"""libcurvopt, found, loaded and checked: its signatures, its options, its errors, and arrays as it takes them.

Arrays are converted to contiguous float64 or int32 and their lengths checked before C sees them. A status other than 0
raises CurvoptError with the library's own sentence.
"""

from __future__ import annotations

import _ctypes
import ctypes as C
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .abi import (
    BOUNDARY_RULES,
    FREEDOM_OF_LIMIT_POINT,
    HEADER_VERSION,
    INTS,
    MAX_TERMS,
    NAMES,
    OPTION_KINDS,
    REALS,
    SCALAR_RULES,
    SCALARS,
    SIGNATURES,
    STATUSES,
    STRUCT_SIZES,
    TERMS,
    CConstraints,
    CCreases,
    CError,
    COptions,
)
from .locate import LIBRARY_VARIABLE, library_candidates, missing_text, platform_name, platforms_here
from .through import Chain, Through, struct_of
from .values import Creases, Held

INT32_MAX = 2**31 - 1


class LibraryError(RuntimeError):
    """The library is missing, cannot be loaded, or is not of the header's version."""


class CurvoptError(RuntimeError):
    """A call failed. `code` is the curvopt_status, `element` the offending vertex, face or field index or -1."""

    def __init__(self, code: int, element: int, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.element = element
        self.message = message


class Cancelled(CurvoptError):
    """What was called has been cancelled by its flag, and has no result."""


# ---------------------------------------------------------------------------------------------------------- arrays --


def reals(values: object, count: int, name: str) -> np.ndarray:
    """`values` as `count` contiguous float64, flat. ValueError for another number of them, and for what are no numbers."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be numbers, not {values!r}.") from None
    if array.size != count:
        raise ValueError(f"{name} holds {array.size} numbers, expected {count}.")
    return array


def indices(values: object, name: str) -> np.ndarray:
    """`values` as contiguous int32, flat. ValueError for fractions and for values beyond 32 bits."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} must be integers, not {values!r}.") from None
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise ValueError(f"{name} must be integers, not {array.dtype}.")
    if array.size and (array.max() > INT32_MAX or array.min() < -INT32_MAX - 1):
        raise ValueError(f"{name} holds a value beyond 32 bits.")
    return np.ascontiguousarray(array, dtype=np.int32).reshape(-1)


def option_value(name: str, value: object) -> float | int:
    """A value of a field of curvopt_options, or of a weight of an energy (any other name). ValueError naming it."""
    whole = OPTION_KINDS.get(name) is C.c_int32
    is_number = isinstance(value, (int, float, np.integer, np.floating, np.bool_))
    if not is_number or (whole and value != value // 1):
        raise ValueError(f"{name} is {value!r}; it must be a {'whole ' * whole}number.")
    if whole and not -INT32_MAX <= value <= INT32_MAX:
        raise ValueError(f"Option {name} = {value} is beyond 32 bits.")
    try:
        return int(value) if whole else float(value)
    except OverflowError:
        raise ValueError(f"{name} = {value} is beyond what a double holds.") from None


def real_pointer(array: np.ndarray | None) -> object:
    return None if array is None else array.ctypes.data_as(REALS)


def int_pointer(array: np.ndarray) -> object:
    return array.ctypes.data_as(INTS)


def creases_to_c(creases: Creases) -> tuple[CCreases, tuple[np.ndarray, ...]]:
    """The struct, and the arrays that it points into. ValueError for lengths that do not fit and an unknown rule."""
    if creases.rule not in BOUNDARY_RULES:
        raise ValueError(f"There is no boundary rule '{creases.rule}'; there are {', '.join(BOUNDARY_RULES)}.")
    edges, vertices = indices(creases.edges, "edges"), indices(creases.vertices, "vertices")
    edge_sharpness = reals(creases.edge_sharpness, len(creases.edges), "edge_sharpness")
    vertex_sharpness = reals(creases.vertex_sharpness, vertices.size, "vertex_sharpness")
    if edges.size != 2 * edge_sharpness.size:
        raise ValueError(f"edges holds {edges.size} indices, expected {2 * edge_sharpness.size}.")
    raw = CCreases(
        int_pointer(edges), real_pointer(edge_sharpness), int_pointer(vertices), real_pointer(vertex_sharpness),
        edge_sharpness.size, vertices.size, BOUNDARY_RULES.index(creases.rule), 0,
    )  # fmt: skip
    return raw, (edges, edge_sharpness, vertices, vertex_sharpness)


# --------------------------------------------------------------------------------------------------------- library --


class Library:
    """A loaded libcurvopt with its signatures set. LibraryError if it is unusable. `open` has the pointers of its handles."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.open: set[int] = set()
        try:
            self.c = C.CDLL(str(path))
        except OSError as error:
            raise LibraryError(
                f"The curvopt library {path} cannot be loaded on {platform_name()}: {error}. Install the file for this system."
            ) from error
        self._set_signatures(["curvopt_version"])
        self.version = self.c.curvopt_version().decode()
        if tuple(self.version.split(".")[:2]) != tuple(map(str, HEADER_VERSION)):
            wanted = ".".join(map(str, HEADER_VERSION))
            raise LibraryError(
                f"The curvopt library {path} is version {self.version}, but this add-on or package needs {wanted}: "
                "after an update, restart Blender or Python. If that does not help, remove both and install one file that has both."
            )
        self._set_signatures(SIGNATURES)
        self._check_sizes()
        self._check_names()

    def unload(self) -> None:
        """Take it out of memory, unless handles are open. Calls raise AttributeError afterwards."""
        if not self.open:
            loaded, self.c = self.c, None
            (_ctypes.FreeLibrary if sys.platform == "win32" else _ctypes.dlclose)(loaded._handle)

    def _set_signatures(self, names: object) -> None:
        for name in names:
            try:
                function = getattr(self.c, name)
            except AttributeError as error:
                raise LibraryError(
                    f"The curvopt library {self.path} has no function {name}: install library and add-on together."
                ) from error
            function.restype, function.argtypes = SIGNATURES[name][0], SIGNATURES[name][1]

    def _check_sizes(self) -> None:
        for struct, size in STRUCT_SIZES.items():
            if C.sizeof(struct) != size:
                raise LibraryError(f"{struct.__doc__} takes {C.sizeof(struct)} bytes here instead of {size}.")
        options = COptions()
        self.c.curvopt_options_init(C.byref(options), C.sizeof(options))
        if options.struct_size != C.sizeof(COptions):
            raise LibraryError(
                f"The curvopt library {self.path} has options of {options.struct_size} bytes "
                f"instead of {C.sizeof(COptions)}."
            )

    def _check_names(self) -> None:
        for function, names in NAMES.items():
            known = getattr(self.c, function.replace("_text", "_name"))
            here = [name.encode() for name in names]
            if [getattr(self.c, function)(i) for i in range(len(here))] != here or known(len(here)) is not None:
                raise LibraryError(f"The curvopt library {self.path} has other names by {function} than this add-on.")

    def call(self, name: str, *arguments: object) -> None:
        """Call a fallible function with everything but its error; CurvoptError unless it returns 0, and of these
        Cancelled if it was cancelled."""
        error = CError(element=-1)
        code = getattr(self.c, name)(*arguments, C.byref(error))
        if code != 0:
            text = error.message.decode("utf-8", "replace") or self.c.curvopt_status_text(code).decode()
            raise (Cancelled if code == STATUSES.index("cancelled") else CurvoptError)(code, error.element, text)

    def create(self, name: str, *arguments: object) -> C.c_void_p:
        """Call a fallible function whose last argument before the error is `out`; its new handle."""
        out = C.c_void_p()
        self.call(name, *arguments, C.byref(out))
        return out

    def options(
        self, weights: Mapping[str, float], held: Held | None = None, holes: object = (),
        scalars: Mapping[str, tuple[str, float]] | None = None, through: Sequence[Through] = (),
        chains: Sequence[Chain] = (), **fields: float,
    ) -> COptions:  # fmt: skip
        """The library's defaults with `weights` by term name and other fields of curvopt_options changed, with
        vertices held, points that the surface goes `through`, `chains` on curves, and faces (k,) that are `holes`. `scalars`, by names of abi.SCALARS: the rule, of
        abi.SCALAR_RULES, and the value, 0 where the rule takes none.

        ValueError for an unknown name and for lengths that do not fit, CurvoptError for a value that the library
        refuses."""
        options = COptions()
        self.c.curvopt_options_init(C.byref(options), C.sizeof(options))
        options.weights = (C.c_double * MAX_TERMS)()
        for term, weight in weights.items():
            if term not in TERMS:
                raise ValueError(f"There is no energy '{term}'; there are {', '.join(TERMS)}.")
            options.weights[TERMS.index(term)] = option_value(f"the weight of {term}", weight)
        for scalar, (rule, value) in (scalars or {}).items():
            options.scalar_rule[SCALARS.index(scalar)] = SCALAR_RULES.index(rule)
            options.scalar_value[SCALARS.index(scalar)] = value
        for name, value in fields.items():
            if name not in OPTION_KINDS:
                raise ValueError(f"There is no option '{name}'.")
            setattr(options, name, option_value(name, value))
        if held is not None and len(held.vertices):
            vertices = indices(held.vertices, "held")
            firmness = reals(held.weights, vertices.size, "weights of held vertices")
            freedom = indices(np.where(firmness == 1, FREEDOM_OF_LIMIT_POINT * held.limit_points, 0), "freedom")
            places = None if held.places is None else reals(held.places, 3 * vertices.size, "places")
            options.held = vertices, freedom, firmness, places  # of Python's: pointers do not keep arrays alive
            pointers = int_pointer(vertices), int_pointer(freedom), None
            where = (False, real_pointer(firmness), None)
            if places is not None:
                where = (True, real_pointer(firmness), real_pointer(places))
            options.constraints = C.pointer(CConstraints(*pointers, vertices.size, *where))
        if len(through) or len(chains):
            options.points = struct_of(through, chains)
            options.through = C.pointer(options.points)
        if len(holes):
            faces = indices(holes, "holes")
            options.left_out = faces
            options.holes, options.n_holes = int_pointer(faces), faces.size
        self.call("curvopt_options_validate", C.byref(options))
        return options


_loaded: dict[Path, Library] = {}


def load() -> Library:
    """The library, loaded once per path. LibraryError, with every place that was looked at, if there is none."""
    candidates = library_candidates()
    for path in candidates:
        if path.is_file():
            if path not in _loaded:
                _loaded[path] = Library(path)
            return _loaded[path]
    if not platforms_here() and not os.environ.get(LIBRARY_VARIABLE) and sys.platform == "linux":
        system = Path(f"libcurvopt.so.{'.'.join(map(str, HEADER_VERSION))}")  # Debian's package: the loader knows where
        if system not in _loaded and _has_system_library(system):
            _loaded[system] = Library(system)
        if system in _loaded:
            return _loaded[system]
    raise LibraryError(missing_text(candidates))


def _has_system_library(name: Path) -> bool:
    try:
        C.CDLL(str(name))
    except OSError:
        return False
    return True


def forget() -> None:
    """Unload the libraries: for an add-on that is switched off, so that an updated one finds its own. No run may be on.

    Each run joins its threads, so nothing is left in a library whose handles are closed. One that has open handles stays
    in memory until the process ends."""
    for lib in _loaded.values():
        lib.unload()
    _loaded.clear()

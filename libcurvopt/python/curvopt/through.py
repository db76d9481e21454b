# SPDX-License-Identifier: GPL-3.0-or-later
"""What the limit surface goes through: entries and chains of edges, and the library's struct of them."""

from __future__ import annotations

import ctypes as C
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .abi import CChain, CThrough

_INT32_MAX = 2**31 - 1


@dataclass(frozen=True)
class Through:
    """A point of the limit surface and what is held there, on every level.

    vertex          whose limit point it is; or face, uv and, of a face that is no quad, corner, as in Sampler.jets()
    at (3,)         where the point is held; "here": where it is; None: it is free, unless there is a line or plane
    line (3,)       it moves on the line with this direction through `at`, or through where it is
    plane (3,)      it moves in the plane with this normal, likewise
    normal (3,)     the surface's normal there; its sign does not count
    tangent (3,)    direction of the tangent toward vertex `toward`; inside a face "u" or "v"; its sign does not count
    curvatures (2,) principal curvatures there, in 1 / units, with a normal; inside faces and at vertices where four faces meet.
                    Both are positive on a sphere whose faces are counterclockwise as seen from outside
    curvature_direction (3,) direction of the first curvature; None: that of the tangent, or none where both are the same
    weight          0 to 1: how firmly. 1: exactly; less: springs draw the point, normal, tangent and curvatures; 0: not at all
    """

    vertex: int | None = None
    face: int | None = None
    uv: tuple[float, float] | None = None
    corner: int = 0
    at: object = None
    line: object = None
    plane: object = None
    normal: object = None
    tangent: object = None
    toward: int | str | None = None
    weight: float = 1.0
    curvatures: object = None
    curvature_direction: object = None


@dataclass(frozen=True)
class Chain:
    """A chain of edges whose limit curve follows a curve, the nearer the finer the level.

    vertices (k,)    each joined to the next by an edge
    curve (m, 3)     points, through which the curve is a cubic spline
    closed           whether the chain goes on from its last vertex to the first; the curve must be closed, too
    curve_closed     whether the curve goes on from its last point to the first; None: if the chain is closed
    parameters (k,)  where on the curve each vertex is, in numbers of points, 1.25 a quarter of the way from point 1 to
                     point 2; None: at the nearest place
    weight           0 to 1: how firmly. 1: exactly; less: springs draw the limit curve to the curve; 0: not at all
    """

    vertices: Sequence[int]
    curve: object
    closed: bool = False
    curve_closed: bool | None = None
    parameters: object = None
    weight: float = 1.0


def _numbers(value: object, entry: int, name: str, n: int = 3) -> np.ndarray:
    """So many numbers, two or three; NAN for None."""
    if value is None:
        return np.full(n, np.nan)
    try:
        out = np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        out = np.empty(0)
    if out.shape != (n,):
        raise ValueError(f"entry {entry}: {name} is {value!r}; it must be {'two' if n == 2 else 'three'} numbers.")
    return out


def _weight(value: object, entry: int, of: str = "entry") -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)) or not 0 <= value <= 1:
        raise ValueError(f"{of} {entry}: weight is {value!r}; it must be 0 to 1.")
    return float(value)


def _count(value: object, entry: int, name: str, of: str = "entry") -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value <= _INT32_MAX:
        raise ValueError(f"{of} {entry}: {name} is {value!r}; it must be a whole number, 0 or more.")
    return int(value)


def _switch(value: object, chain: int, name: str) -> bool:
    if not isinstance(value, (bool, np.bool_, int)) or value not in (0, 1):
        raise ValueError(f"chain {chain}: {name} is {value!r}; it must be True or False.")
    return bool(value)


def _check_type(value: object, i: int, of: str, wanted: type) -> None:
    if not isinstance(value, wanted):
        raise ValueError(f"{of} {i} is a {type(value).__name__}; it must be a curvopt.{wanted.__name__} object.")


def _check(entry: Through, i: int) -> None:
    if (entry.vertex is None) == (entry.face is None):
        raise ValueError(f"entry {i}: either vertex or face says where it is.")
    if entry.face is not None and entry.uv is None:
        raise ValueError(f"entry {i}: a face needs uv.")
    if entry.vertex is not None and (entry.uv is not None or entry.corner):
        raise ValueError(f"entry {i}: uv and corner are of faces.")
    if entry.line is not None and entry.plane is not None:
        raise ValueError(f"entry {i}: line and plane together: give the point where they meet, or its line.")
    if (entry.tangent is None) != (entry.toward is None):
        raise ValueError(f"entry {i}: tangent and toward belong together.")
    if entry.face is not None and entry.toward not in (None, "u", "v"):
        raise ValueError(f"entry {i}: toward is {entry.toward!r}; inside a face it must be 'u' or 'v'.")
    if entry.curvatures is not None and entry.normal is None:
        raise ValueError(f"entry {i}: curvatures need a normal.")
    if entry.curvatures is None and entry.curvature_direction is not None:
        raise ValueError(f"entry {i}: curvature_direction needs curvatures.")
    if isinstance(entry.at, str) and entry.at != "here":
        raise ValueError(f"entry {i}: at is {entry.at!r}; it must be three numbers or 'here'.")


def _freedom(entry: Through) -> int:
    if entry.line is not None:
        return 1
    return 2 if entry.plane is not None else 3 if entry.at is None else 0


def _chain(chain: Chain, i: int) -> tuple[CChain, list[np.ndarray]]:
    """The struct, and its arrays."""
    try:
        vertices = np.array([_count(v, i, "a vertex", "chain") for v in chain.vertices], np.int32)
    except TypeError:
        raise ValueError(f"chain {i}: vertices is {chain.vertices!r}; it must be a list of vertex numbers.") from None
    try:
        curve = np.ascontiguousarray(chain.curve, float)
        parameters = None if chain.parameters is None else np.ascontiguousarray(chain.parameters, float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"chain {i}: curve and parameters must be numbers: {error}.") from None
    if curve.ndim != 2 or curve.shape[1] != 3:
        raise ValueError(f"chain {i}: curve has the shape {curve.shape}; it must be (m, 3).")
    if parameters is not None and parameters.shape != vertices.shape:
        raise ValueError(f"chain {i}: parameters have the shape {parameters.shape}; there are {len(vertices)} vertices.")
    reals = C.POINTER(C.c_double)
    out = CChain(
        vertices.ctypes.data_as(C.POINTER(C.c_int32)), curve.ctypes.data_as(reals),
        None if parameters is None else parameters.ctypes.data_as(reals), len(vertices), len(curve), _switch(chain.closed, i, "closed"),
        _switch(chain.closed if chain.curve_closed is None else chain.curve_closed, i, "curve_closed"),
    )  # fmt: skip
    return out, [vertices, curve] + ([] if parameters is None else [parameters])


def struct_of(entries: Sequence[Through], chains: Sequence[Chain] = ()) -> CThrough:
    """The struct, which keeps its arrays. ValueError naming the entry or chain where one cannot be read."""
    for i, entry in enumerate(entries):
        _check_type(entry, i, "entry", Through)
        _check(entry, i)
    for i, chain in enumerate(chains):
        _check_type(chain, i, "chain", Chain)
    on = list(enumerate(entries))
    toward = [
        0 if e.toward in (None, "u") else 1 if e.toward == "v" else _count(e.toward, i, "toward") for i, e in on
    ]
    integers = {
        "vertices": [-1 if e.vertex is None else _count(e.vertex, i, "vertex") for i, e in on],
        "faces": [0 if e.face is None else _count(e.face, i, "face") for i, e in on],
        "corners": [_count(e.corner, i, "corner") for i, e in on],
        "freedom": [_freedom(e) for e in entries],
        "toward": toward,
    }
    vectors = {
        "directions": [_numbers(e.line if e.line is not None else e.plane, i, "line or plane") for i, e in on],
        "places": [_numbers(None if isinstance(e.at, str) else e.at, i, "at") for i, e in on],
        "normals": [_numbers(e.normal, i, "normal") for i, e in on],
        "tangents": [_numbers(e.tangent, i, "tangent") for i, e in on],
        "curvatures": [_numbers(e.curvatures, i, "curvatures", 2) for i, e in on],
        "curvature_directions": [_numbers(e.curvature_direction, i, "curvature_direction") for i, e in on],
    }
    uv = np.array([_numbers(e.uv, i, "uv", 2) for i, e in on], float)
    weights = np.array([_weight(e.weight, i) for i, e in on], float)
    arrays: dict[str, np.ndarray] = {name: np.array(numbers, np.int32) for name, numbers in integers.items()}
    arrays.update({name: np.ascontiguousarray(rows, float) for name, rows in (vectors | {"uv": uv, "weights": weights}).items()})
    out = CThrough(C.sizeof(CThrough), len(entries))
    for name, array in arrays.items():
        kind = C.c_int32 if array.dtype == np.int32 else C.c_double
        setattr(out, name, array.ctypes.data_as(C.POINTER(kind)))
    made = [_chain(chain, i) for i, chain in enumerate(chains)]
    array = (CChain * len(made))(*(chain for chain, _ in made))
    out.chains, out.n_chains = array, len(made)
    chain_weights = np.array([_weight(chain.weight, i, "chain") for i, chain in enumerate(chains)], float)
    out.chain_weights = chain_weights.ctypes.data_as(C.POINTER(C.c_double))
    out.arrays = arrays, array, made, chain_weights  # of Python's: pointers do not keep arrays alive
    return out

# SPDX-License-Identifier: GPL-3.0-or-later
"""How far two limit surfaces are apart, where one crosses itself and where it is folded: curvopt_measure_deviation,
curvopt_find_crossings, curvopt_find_folds."""

from __future__ import annotations

import ctypes as C
from dataclasses import dataclass

import numpy as np

from .abi import INTS, REALS, CCrossings, CDeviation, COptions
from .library import Cancel, Mesh, reals


@dataclass(frozen=True)
class Deviation:
    """Largest and root mean square distance of two limit surfaces, in units of the cages.

    No point of either is farther from the other one than `bound`, which is at most 1.2 `max` (curvopt.h says when it is
    not). `size`: RMS radius of the first cage. `point` (3,) of the first surface and `other_point` (3,) are `max` apart.
    `distances` (n,) of the limit points of the other cage's vertices from the first surface, at poles up to
    2.5 % of max too large; NAN of isolated ones."""

    max: float
    rms: float
    bound: float
    size: float
    point: np.ndarray
    other_point: np.ndarray
    distances: np.ndarray


@dataclass(frozen=True)
class Crossings:
    """Where a limit surface crosses itself: `pairs` (n_listed, 2) of faces, ascending, the first of `n_pairs` in all.

    `n_contacts` pairs touch without a crossing that could be proven, `n_unresolved` come too close to tell.
    `is_complete`: not cancelled."""

    pairs: np.ndarray
    n_pairs: int
    n_contacts: int
    n_unresolved: int
    is_complete: bool


def deviation(
    mesh: Mesh, xyz: object, other: Mesh, other_xyz: object, threads: int = 0, cancel: Cancel | None = None
) -> Deviation:
    """From the limit surface of a cage to that of another one, and back. CurvoptError for coordinates that make none."""
    n = other.info().n_vertices
    points, others = reals(xyz, 3 * mesh.info().n_vertices, "xyz"), reals(other_xyz, 3 * n, "other_xyz")
    raw, distances = CDeviation(), np.empty(n)
    mesh.lib.call(
        "curvopt_measure_deviation", mesh.pointer, points.ctypes.data_as(REALS), other.pointer,
        others.ctypes.data_as(REALS), threads, cancel.pointer if cancel else None, C.byref(raw), C.sizeof(raw),
        distances.ctypes.data_as(REALS),
    )  # fmt: skip
    return Deviation(raw.max, raw.rms, raw.bound, raw.size, np.array(raw.point), np.array(raw.other_point), distances)


def crossings(mesh: Mesh, xyz: object, threads: int = 0, cancel: Cancel | None = None, most: int = 100000) -> Crossings:
    """Where the limit surface of a cage crosses itself; `most` pairs are listed."""
    points, pairs, raw = reals(xyz, 3 * mesh.info().n_vertices, "xyz"), np.empty((most, 2), np.int32), CCrossings()
    mesh.lib.call(
        "curvopt_find_crossings", mesh.pointer, points.ctypes.data_as(REALS), threads,
        cancel.pointer if cancel else None, most, pairs.ctypes.data_as(INTS), C.byref(raw), C.sizeof(raw),
    )  # fmt: skip
    return Crossings(pairs[: raw.n_listed].copy(), raw.n_pairs, raw.n_contacts, raw.n_unresolved, bool(raw.is_complete))


def folds(mesh: Mesh, xyz: object, options: COptions, cancel: Cancel | None = None) -> np.ndarray:
    """The faces, ascending, at which the limit surface of a cage is folded: at a point it has no tangent plane, and energies
    of curvature are infinite. Of the options holes and strict count: faces that are left out are not looked at."""
    points, folded = reals(xyz, 3 * mesh.info().n_vertices, "xyz"), np.zeros(mesh.info().n_faces, np.int32)
    mesh.lib.call(
        "curvopt_find_folds", mesh.pointer, points.ctypes.data_as(REALS), C.byref(options),
        cancel.pointer if cancel else None, folded.ctypes.data_as(INTS), None,
    )  # fmt: skip
    return np.flatnonzero(folded)

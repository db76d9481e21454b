# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvature combs: teeth on a curve, away from where it bends to, as long as it is curved. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..binding import library
from ..binding.values import Cage, rms_radius
from .edges import EdgeTable, Places

_NUDGE = 1e-3  # of an edge, away from its end where derivatives do not exist there
_UU, _UV, _VV = 3, 4, 5  # in a jet


@dataclass(frozen=True)
class Choice:
    """Which edges have combs: `pairs` (p, 2) of vertices, or None for all; with `loops`, those that go on from them, too.
    `teeth` on each edge, one of them at its end; at curvature 1 / r, r the RMS radius of the cage, `length` r long."""

    pairs: np.ndarray | None
    loops: bool
    teeth: int
    length: float


@dataclass(frozen=True)
class Combs:
    """On each of e edges k points of its curve, both ends among them, `feet`, and the `tips` of the teeth, (e, k, 3)."""

    feet: np.ndarray
    tips: np.ndarray

    def lines(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """points (2 e k, 3) float32, feet first; pairs of them by name: the "curves", the "teeth", and the "crests" through
        the tips."""
        e, k = self.feet.shape[:2]
        number = np.arange(e * k, dtype=np.int32).reshape(e, k)
        along = np.stack([number[:, :-1], number[:, 1:]], -1).reshape(-1, 2)
        teeth = np.stack([number.ravel(), number.ravel() + e * k], -1)
        points = np.concatenate([self.feet.reshape(-1, 3), self.tips.reshape(-1, 3)])
        return points.astype(np.float32), {"curves": along, "teeth": teeth.astype(np.int32), "crests": along + np.int32(e * k)}


def curvature_vectors(jets: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Of curves on a surface that run straight in its parameters, by `along` (n, 2): the vectors (n, 3) towards the centres
    of their circles of curvature, 1 / radius long. NAN where there are none."""
    u, v = along[:, :1], along[:, 1:]
    first = u * jets[:, 1] + v * jets[:, 2]
    second = u * u * jets[:, _UU] + 2 * u * v * jets[:, _UV] + v * v * jets[:, _VV]
    square = (first**2).sum(axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return (second - first * (first * second).sum(axis=1, keepdims=True) / square) / square


def combs(sampler: library.Sampler, cage: Cage, table: EdgeTable, choice: Choice) -> Combs:
    """The combs of a cage's surface."""
    edges = np.arange(len(table.edges)) if choice.pairs is None else table.chosen(choice.pairs)
    if choice.loops:
        edges = table.loops(edges)
    t = np.tile(np.linspace(0.0, 1.0, choice.teeth + 1), len(edges))
    side = np.repeat(table.first[edges], choice.teeth + 1)
    places = table.places(side, t)
    jets = jets_at(sampler, places)
    vectors = curvature_vectors(jets, places.along)
    bad = np.flatnonzero(~np.isfinite(vectors).all(axis=1))
    if bad.size:  # at poles
        near = table.places(side[bad], np.clip(t[bad], _NUDGE, 1 - _NUDGE))
        vectors[bad] = np.nan_to_num(curvature_vectors(jets_at(sampler, near), near.along), nan=0.0, posinf=0.0, neginf=0.0)
    scale = choice.length * rms_radius(cage.positions) ** 2
    shape = len(edges), choice.teeth + 1, 3
    return Combs(jets[:, 0].reshape(shape), (jets[:, 0] - scale * vectors).reshape(shape))


def jets_at(sampler: library.Sampler, places: Places) -> np.ndarray:
    """Jets (n, 10, 3) there."""
    return sampler.jets(places.face, places.corner, places.uv)

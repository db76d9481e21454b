# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvature combs: teeth on a curve, away from where it bends to, as long as it is curved. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..binding import library
from ..binding.values import Cage, rms_radius
from . import sections
from .edges import EdgeTable, Places
from .surface_points import Net

_NUDGE = 1e-3  # of an edge, away from its end where derivatives do not exist there
_UU, _UV, _VV = 3, 4, 5  # in a jet


@dataclass(frozen=True)
class OnEdges:
    """Which edges have combs: `pairs` (p, 2) of vertices, or None for all; with `loops`, those that go on from them, too.
    `teeth` on each edge, one of them at its end; at curvature 1 / r, r the RMS radius of the cage, `length` r long."""

    pairs: np.ndarray | None
    loops: bool
    teeth: int
    length: float


@dataclass(frozen=True)
class OnSections:
    """Combs on the sections by `count` planes at right angles to the unit vector `normal`, at equal distances over the whole
    surface. `teeth` on the mean length of an edge; `length` as of OnEdges."""

    normal: tuple[float, float, float]
    count: int
    teeth: int
    length: float


Choice = OnEdges | OnSections


@dataclass(frozen=True)
class Combs:
    """Points of curves, `feet` (n, 3), with the `tips` (n, 3) of teeth, NAN where there is none. `links` (l, 2): points that follow
    one another on a curve; `teeth` (t,): the points whose tooth is drawn."""

    feet: np.ndarray
    tips: np.ndarray
    links: np.ndarray
    teeth: np.ndarray

    def lines(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """points (2 n, 3) float32, feet first; pairs of them by name: the "curves", the "teeth", and the "crests" through the
        tips."""
        with np.errstate(over="ignore"):
            n, is_there = len(self.feet), np.isfinite(self.tips.astype(np.float32)).all(axis=1)
        teeth, crests = self.teeth[is_there[self.teeth]], self.links[is_there[self.links].all(axis=1)]
        pairs = {"curves": self.links, "teeth": np.stack([teeth, teeth + n], -1), "crests": crests + n}
        points = np.concatenate([self.feet, np.where(is_there[:, None], self.tips, self.feet)])
        return points.astype(np.float32), {name: part.astype(np.int32) for name, part in pairs.items()}


def is_same(one: Choice | None, other: Choice | None) -> bool:
    """Whether they choose the same combs."""
    if type(one) is not type(other) or not isinstance(one, OnEdges):
        return one == other
    pairs = (one.pairs is None) == (other.pairs is None) and (one.pairs is None or np.array_equal(one.pairs, other.pairs))
    return pairs and (one.loops, one.teeth, one.length) == (other.loops, other.teeth, other.length)


def curvature_vectors(jets: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Of curves on a surface that run straight in its parameters, by `along` (n, 2): the vectors (n, 3) towards the centres
    of their circles of curvature, 1 / radius long. NAN where there are none."""
    u, v = along[:, :1], along[:, 1:]
    first = u * jets[:, 1] + v * jets[:, 2]
    second = u * u * jets[:, _UU] + 2 * u * v * jets[:, _UV] + v * v * jets[:, _VV]
    square = (first**2).sum(axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return (second - first * (first * second).sum(axis=1, keepdims=True) / square) / square


def on_edges(sampler: library.Sampler, cage: Cage, table: EdgeTable, choice: OnEdges) -> Combs:
    """Combs on edges of a cage as curves of its surface: of each edge `teeth` + 1 points, one after the other."""
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
    number = np.arange(len(t)).reshape(-1, choice.teeth + 1)
    links = np.stack([number[:, :-1], number[:, 1:]], -1).reshape(-1, 2)
    return Combs(jets[:, 0], _tips(jets[:, 0], vectors, cage, choice.length), links, number.ravel())


def on_sections(sampler: library.Sampler, cage: Cage, table: EdgeTable, net: Net, choice: OnSections) -> Combs:
    """Combs on plane sections. `net`: of the surface, with vertices that its quads share."""
    normal = np.array(choice.normal)
    found = sections.curves(sampler, net, net.points.jets_of(sampler)[:, 0], normal, choice.count)
    feet, vectors = found.jets[:, 0], sections.curvature_vectors(found.jets, normal)
    ends = cage.positions[table.edges]
    mean_edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    return Combs(feet, _tips(feet, vectors, cage, choice.length), found.links, sections.spaced(found, mean_edge / choice.teeth))


def _tips(feet: np.ndarray, vectors: np.ndarray, cage: Cage, length: float) -> np.ndarray:
    return feet - length * rms_radius(cage.positions) ** 2 * vectors


def jets_at(sampler: library.Sampler, places: Places) -> np.ndarray:
    """Jets (n, 10, 3) there."""
    return sampler.jets(places.face, places.corner, places.uv)

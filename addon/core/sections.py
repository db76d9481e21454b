# SPDX-License-Identifier: GPL-3.0-or-later
"""Plane sections of a surface: the curves in which parallel planes meet it. No bpy.

Marching squares on quads between points of the surface say which way a curve runs. Its points lie on edges of the quads, and
there exactly in the surface and in the plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..binding import library
from .crease import edge_keys
from .curvature import forms_of_jets, inverse_of
from .layout import sides
from .surface_points import Net

_STEPS = 4  # of Newton's method
_NUDGE = 1e-3  # of a quad, towards its middle, where derivatives do not exist
_FLAT = 1e-9  # of the surface's size: what rounding makes of a plane
_LEAST_SINE = 0.05  # of the angle between plane and surface: where they touch, a section's curvature has no bound


@dataclass(frozen=True)
class Curves:
    """Points of curves with the surface's derivatives there, `jets` (n, 10, 3); `links` (l, 2): points that follow one
    another."""

    jets: np.ndarray
    links: np.ndarray


def levels_of(points: np.ndarray, normal: np.ndarray, count: int) -> np.ndarray:
    """Heights (count,) along `normal` (3,) of planes in the middles of equal slices of points (n, 3); none (0,) of a plane."""
    heights = points @ normal
    extent = np.ptp(heights)
    flat = extent <= _FLAT * np.ptp(points, axis=0).max()
    return heights.min() + (np.arange(0 if flat else count) + 0.5) / count * extent


def pieces(above: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """The pieces of curve (l, 2) in quads with corners above or below a plane, (q, 4) bool, and middles, (q,): from side to
    side, which have the numbers 4 quad + corner."""
    cut = above != np.roll(above, -1, axis=1)
    n_cut = cut.sum(axis=1)
    once, twice = np.flatnonzero(n_cut == 2), np.flatnonzero(n_cut == 4)
    found = [4 * once[:, None] + np.nonzero(cut[once])[1].reshape(-1, 2)]
    # Opposite corners on one side of the plane: the middle says which two hang together, and a curve goes round each other.
    round_odd = (above[twice, 0] == middle[twice])[:, None]
    for odd, even in (((0, 1), (3, 0)), ((2, 3), (1, 2))):
        found.append(4 * twice[:, None] + np.where(round_odd, odd, even))
    return np.concatenate(found)


def curves(sampler: library.Sampler, net: Net, points: np.ndarray, normal: np.ndarray, count: int) -> Curves:
    """Where the surface is cut by `count` planes at right angles to `normal` (3,), at equal distances over all of it. `net`:
    its quads share their vertices, which are at `points` (n, 3)."""
    quads, heights = net.points.quads, points @ normal
    of_side = sides(np.full(len(quads), 4), quads.ravel())
    _, first, edge = np.unique(edge_keys(of_side, len(points)), return_index=True, return_inverse=True)
    edge, levels = edge.reshape(-1), levels_of(points, normal, count)
    links = [np.empty((0, 2), np.intp)] + [
        edge[pieces(heights[quads] >= level, heights[quads].mean(axis=1) >= level)] + number * len(first)
        for number, level in enumerate(levels)
    ]
    cuts, numbers = np.unique(np.concatenate(links), return_inverse=True)
    side, level = first[cuts % len(first)], levels[cuts // len(first)]
    ends = heights[of_side[side]] - level[:, None]
    return Curves(_on_plane(sampler, net, side, normal, level, ends), numbers.reshape(-1, 2))


def _on_plane(
    sampler: library.Sampler, net: Net, side: np.ndarray, normal: np.ndarray, level: np.ndarray, ends: np.ndarray
) -> np.ndarray:
    """Jets (n, 10, 3) where sides of quads (n,), as curves of the surface, meet planes at these levels (n,). `ends` (n, 2): how
    far above its plane a side begins and ends, one of them below."""
    quad, corner = side // 4, side % 4
    begin, way = net.uv[quad, corner], net.uv[quad, (corner + 1) % 4] - net.uv[quad, corner]

    def jets_at(uv: np.ndarray) -> np.ndarray:
        return sampler.jets(net.face[quad], net.corner[quad], uv)

    low, high, t = np.zeros(len(side)), np.ones(len(side)), ends[:, 0] / (ends[:, 0] - ends[:, 1])
    for _ in range(_STEPS):
        jets = jets_at(begin + t[:, None] * way)
        off, slope = jets[:, 0] @ normal - level, np.einsum("ni,nix,x->n", way, jets[:, 1:3], normal)
        is_before = (off < 0) == (ends[:, 0] < 0)
        low, high = np.where(is_before, t, low), np.where(is_before, high, t)
        with np.errstate(invalid="ignore", divide="ignore"):
            step = t - off / slope
        t = np.where(np.isfinite(step), np.clip(step, low, high), (low + high) / 2)
    uv = begin + t[:, None] * way
    jets = jets_at(uv)
    bad = np.flatnonzero(~np.isfinite(jets).all(axis=(1, 2)))
    if bad.size:  # at poles
        near = uv + _NUDGE * (net.uv[quad].mean(axis=1) - uv)
        jets[bad, 1:] = jets_at(near)[bad, 1:]
    return jets


def curvature_vectors(jets: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Of the sections at right angles to `normal` through n points of a surface: the vectors (n, 3) towards the centres of their
    circles of curvature, 1 / radius long. By Meusnier's theorem: the part along the surface's normal is its normal curvature.
    NAN where plane and surface nearly touch."""
    with np.errstate(invalid="ignore", divide="ignore"):
        forms = forms_of_jets(jets)
        along = np.cross(forms.normals, normal)
        sine = np.linalg.norm(along, axis=1, keepdims=True)
        along /= sine
        weights = np.einsum("nij,nj->ni", inverse_of(forms.metric), np.einsum("nix,nx->ni", jets[:, 1:3], along))
        bend = np.einsum("ni,nij,nj->n", weights, forms.second, weights)  # positive to the inside
        across = np.cross(normal, along)
        vectors = -(bend / np.einsum("nx,nx->n", across, forms.normals))[:, None] * across
    return np.where(sine > _LEAST_SINE, vectors, np.nan)


def spaced(curves_: Curves, spacing: float) -> np.ndarray:
    """Points of the curves (t,), one for each `spacing` along them."""
    places = curves_.jets[:, 0]
    chosen = []
    for way in _walks(len(places), curves_.links):
        steps = np.linalg.norm(np.diff(places[way], axis=0), axis=1)
        number = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) / spacing)
        chosen.append(np.array(way)[np.diff(number, prepend=-1.0) > 0])
    return np.concatenate(chosen) if chosen else np.empty(0, np.intp)


def _walks(n: int, links: np.ndarray) -> Iterator[list[int]]:
    """Each curve's points one after the other; open ones begin at an end."""
    around: list[list[int]] = [[] for _ in range(n)]
    for one, other in links.tolist():
        around[one].append(other)
        around[other].append(one)
    seen = [False] * n
    for start in sorted(range(n), key=lambda point: len(around[point]) != 1):
        way, at = [], None if seen[start] else start
        while at is not None:
            seen[at] = True
            way.append(at)
            at = next((other for other in around[at] if not seen[other]), None)
        if way:
            yield way

# SPDX-License-Identifier: GPL-3.0-or-later
"""Minimizers that have to do something: enclose a volume, or pass through rings. No bpy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from addon.binding import api
from addon.binding.through import Chain
from addon.binding.values import Cage
from . import solve
from .store import Item, Store

USES = (solve,)  # (`store`)
_FREE = 2  # curvopt_spacing: necks want faces, which an even spacing takes from them
_TOLERANCE = 1e-6  # of integrals, by which it can be free: vertices slide where coarse rules are wrong


@dataclass(frozen=True)
class Vesicle:
    """A closed surface of a reduced volume, as picture and text name it; `exact` is its least int H^2, `source` who says
    so."""

    kind: str
    volume: float
    exact: float
    source: str


_SOLVER = "axisymmetric solver of the tests (tests/oracle/vesicle_branches.csv)"
_TORUS = 2 * math.pi**2
_THEOREM = "Moebius images of Clifford's torus (Marques, Neves 2014)"
VESICLES: Mapping[str, Vesicle] = {
    "prolate_90": Vesicle("prolate", 0.90, 14.949507815940, _SOLVER),
    "prolate_70": Vesicle("prolate", 0.70, 20.649945184557, _SOLVER),
    "oblate_60": Vesicle("oblate", 0.60, 24.575803038922, _SOLVER),
    "stomatocyte_54": Vesicle("stomatocyte", 0.54, 24.942412644930, _SOLVER),
    "torus_75": Vesicle("torus", 0.75, _TORUS, _THEOREM),
    "torus_85": Vesicle("torus", 0.85, _TORUS, _THEOREM),
    "torus_95": Vesicle("torus", 0.95, _TORUS, _THEOREM),
}  # fmt: skip
_RINGS = (  # height, radius, and the normal's lean towards x and y: what a vase is to pass through
    (0.0, 0.55, 0.0, 0.0), (0.75, 0.95, 0.25, 0.0), (1.55, 0.50, 0.0, -0.30), (2.20, 0.42, -0.20, 0.15), (2.75, 0.72, 0.0, 0.0),
)  # fmt: skip
RING_ENERGIES = ("willmore", "mvs")
_ROUND, _BETWEEN = 12, 2  # vertices of a ring, and faces from one ring to the next
RING_POINTS = 96  # of a ring as a polygon


# --------------------------------------------------------------------------------------------------------- vesicles --


def vesicle_cage(kind: str, make: Callable[..., Cage]) -> Cage:
    """A cage of the kind's shape, roughly, by functions of cages.py: where a run begins."""
    if kind == "torus":
        return _lopsided(make("torus", 1 / math.sqrt(2), 8, 8, interpolate=True))
    sphere = make("sphere_cube")
    points = np.array(sphere.positions)
    if kind == "stomatocyte":
        points = _dented(points)
    else:
        points[:, 2] *= {"prolate": 1.6, "oblate": 0.5}[kind]
    return Cage(points, sphere.face_sizes, sphere.face_vertices)


def _lopsided(torus: Cage) -> Cage:
    """Clifford's torus inverted in a sphere whose centre is beside it: a cyclide, by which the run has not to leave the
    torus' symmetry."""
    away = np.asarray(torus.positions) - np.array([-3.2, 0.0, 0.0])
    points = away / (away**2).sum(1)[:, None]
    return Cage(points - points.mean(0), torus.face_sizes, np.asarray(torus.face_vertices).reshape(-1, 4)[:, ::-1].ravel())


def _dented(points: np.ndarray) -> np.ndarray:
    """Points of the unit sphere put on a cup: the upper part hangs inside."""
    latitude = np.arccos(np.clip(-points[:, 2], -1, 1)) / math.pi  # 0 at the south pole, 1 at what becomes the dent
    rim, inner = 0.62, 0.72  # where the rim is, and the dent's radius
    outside = latitude <= rim
    angle = np.where(outside, 0.80 * math.pi * latitude / rim, 0.80 * math.pi * (1 - latitude) / (1 - rim))
    radius = np.where(outside, 1.0, inner)
    out, up = radius * np.sin(angle), -radius * np.cos(angle)
    around = np.arctan2(points[:, 1], points[:, 0])
    return np.stack([out * np.cos(around), out * np.sin(around), up], 1)


def enclose(store: Store, item: Item) -> dict[str, object]:
    """Minimizes int H^2 of the item's cage with the reduced volume `volume`; keeps the result's cage."""
    ((_, cage),) = item.cages.items()
    found = api.minimize(
        cage, "mean_curvature", levels=item.inputs["levels"], symmetry="keep", spacing=_FREE, tolerance=_TOLERANCE,
        reduced_volume=item.inputs["volume"], threads=1,
    )  # fmt: skip
    store.save_cage(item.name, found.cage)
    residual = found.summary.scalar_residuals["volume"]
    return {**_figures(found), "exact": item.inputs["exact"], "source": item.inputs["source"],
            "volume": item.inputs["volume"], "missed": solve.plain(residual)}  # fmt: skip


def _figures(found: api.Minimum) -> dict[str, object]:
    """What a run says of its result."""
    end, summary = found.energies, found.summary
    return {
        "value": solve.plain(end.objective), "h2": solve.plain(end.h2), "start": solve.plain(summary.start.objective),
        "net_share": solve.plain(summary.discretization_error), "quadrature_error": solve.plain(end.objective_error),
        "verdict": summary.verification.verdict, "vertices": summary.n_vertices, "stop": summary.stop,
        "seconds": round(summary.seconds, 2),
    }  # fmt: skip


# ------------------------------------------------------------------------------------------------------------ rings --


def rings(points: int = RING_POINTS) -> np.ndarray:
    """The rings (r, points, 3), counter-clockwise from above."""
    angle = 2 * math.pi * np.arange(points) / points
    found = []
    for height, radius, lean_x, lean_y in _RINGS:
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        found.append(np.stack([x, y, height - lean_x * x - lean_y * y], 1))
    return np.array(found)


def vase() -> Cage:
    """A tube, rough between the rings, whose rows of vertices belong to them; its ends, which stay, lie on the first and
    the last one."""
    ring = rings(_ROUND)
    rows = []
    for below, above in zip(ring, ring[1:]):
        rows += [below + (above - below) * k / _BETWEEN for k in range(_BETWEEN)]
    rows.append(ring[-1])
    shrink = (2 + math.cos(2 * math.pi / _ROUND)) / 3  # of a cubic spline whose control points lie on a circle
    for end in (0, -1):
        rows[end] = rows[end].mean(0) + (rows[end] - rows[end].mean(0)) / shrink
    points = np.concatenate(rows)
    faces = [
        (_ROUND * k + i, _ROUND * k + (i + 1) % _ROUND, _ROUND * (k + 1) + (i + 1) % _ROUND, _ROUND * (k + 1) + i)
        for k in range(len(rows) - 1)
        for i in range(_ROUND)
    ]
    return api.cage(points, faces)


def pass_through(store: Store, item: Item) -> dict[str, object]:
    """Minimizes `energy` of the vase with its inner rows on the rings; keeps the result's cage."""
    ((_, cage),) = item.cages.items()
    chains = [
        Chain(range(_ROUND * _BETWEEN * k, _ROUND * (_BETWEEN * k + 1)), ring, closed=True)
        for k, ring in enumerate(rings())
        if 0 < k < len(_RINGS) - 1
    ]
    found = api.minimize(cage, item.inputs["energy"], levels=item.inputs["levels"], chains=chains, threads=1)
    store.save_cage(item.name, found.cage)
    return _figures(found)


# ---------------------------------------------------------------------------------------------------------- diagram --

DIAGRAM = Path(__file__).resolve().parents[1] / "pictures" / "vesicles.svg"  # by phase_diagram.py


def diagram(store: Store, item: Item) -> None:
    """The committed phase diagram, for the page."""
    store.write(item.files[0], DIAGRAM.read_bytes())

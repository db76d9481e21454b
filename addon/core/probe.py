# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface is like under the mouse: where a ray meets it, its radii of curvature there, how much energy, and how well
both sides of the edge next to it fit together. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..binding import library
from ..binding.values import rms_radius
from . import curvature
from .combs import jets_at
from .density import densities, mixed
from .edges import EdgeTable
from .energy import label_of, number_text, weights_of
from .inspected import Inspected

_STEPS = 6  # of Newton's method
_SAMPLES = 33  # of an edge, to begin with
_NUDGE = 1e-3  # of a face, where derivatives do not exist
_FLAT = 1e-6  # curvature times RMS radius of the cage: less is none


@dataclass(frozen=True)
class Continuity:
    """How two faces meet at `point` (3,) of their edge. `gap`: how far their points there are from each other (G0). `angle`
    between their tangent planes in degrees (G1). `jump` in per cent (G2): how far their curvatures across the edge differ, of
    the larger one, signs included; 0 where both are flat. `n_faces` 1: a boundary; 3 and more: they are not compared."""

    point: np.ndarray
    n_faces: int
    gap: float = 0.0
    angle: float = 0.0
    jump: float = 0.0


@dataclass(frozen=True)
class Reading:
    """At a `point` with its unit `normal` (3,): principal curvatures k1 >= k2, positive where the surface bends to its inside;
    how much of `energy` there is per unit of area; the edge next to it."""

    point: np.ndarray
    normal: np.ndarray
    k1: float
    k2: float
    energy: str
    density: float
    edge: Continuity


def pick(points: np.ndarray, quads: np.ndarray, matrix: np.ndarray, at: np.ndarray) -> tuple[int, np.ndarray] | None:
    """The quad (of q, 4) over points (n, 3) that is seen at `at` (2,), -1 .. 1, through `matrix` (4, 4), nearest to the eye;
    and the weights (4,) of its corners there. None if there is nothing."""
    clip = np.asarray(points, float) @ matrix[:, :3].T + matrix[:, 3]
    w = np.where(clip[:, 3] > 0, clip[:, 3], np.nan)
    flat = clip[:, :2] / w[:, None] - at
    x, y = flat[:, 0][quads], flat[:, 1][quads]
    near = np.flatnonzero((x.min(1) <= 0) & (x.max(1) >= 0) & (y.min(1) <= 0) & (y.max(1) >= 0))
    best, found = np.inf, None
    for corners in ((0, 1, 2), (0, 2, 3)):
        px, py, pw = x[near][:, corners], y[near][:, corners], w[quads[near]][:, corners]
        part = np.roll(px, -1, 1) * np.roll(py, -2, 1) - np.roll(px, -2, 1) * np.roll(py, -1, 1)
        whole = part.sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            part = part / whole
            inside = (part >= -1e-9).all(axis=1)
            depth = (part * (clip[:, 2] / w)[quads[near]][:, corners]).sum(axis=1)
        depth = np.where(inside & np.isfinite(depth), depth, np.inf)
        if depth.size and depth.min() < best:
            hit = int(np.argmin(depth))
            best, weights = depth[hit], np.zeros(4)
            weights[list(corners)] = part[hit] / pw[hit]  # perspective
            found = int(near[hit]), weights / weights.sum()
    return found


def continuity(one: np.ndarray, two: np.ndarray, ways: np.ndarray, same: bool, radius: float) -> tuple[float, float, float]:
    """(gap, angle, jump) of two jets (10, 3) at one point of an edge, whose parameters run along it by ways (2, 2). `same`:
    both faces run the same way round over it, so that one of their normals is turned. `radius`: RMS radius of the cage."""
    normals, bends = [], []
    for jet, way in zip((one, two), ways):
        forms = curvature.forms_of_jets(jet[None])
        normal, metric, second = forms.normals[0], forms.metric[0], forms.second[0]
        tangent = way[0] * jet[1] + way[1] * jet[2]
        across = np.cross(normal, tangent / np.linalg.norm(tangent))
        weights = np.linalg.solve(metric, np.array([jet[1] @ across, jet[2] @ across]))
        turned = -1.0 if same and bends else 1.0
        normals.append(turned * normal)
        bends.append(turned * float(weights @ second @ weights))
    angle = np.arctan2(np.linalg.norm(np.cross(*normals)), normals[0] @ normals[1])
    larger = max(map(abs, bends))
    jump = 0.0 if larger * radius <= _FLAT else 100 * abs(bends[0] - bends[1]) / larger
    return float(np.linalg.norm(one[0] - two[0])), float(np.degrees(angle)), float(jump)


class Probe:
    """Reads an inspected surface; for the thread that makes it. A context manager."""

    def __init__(self, lib: library.Library, inspected: Inspected) -> None:
        self.inspected = inspected
        cage = inspected.subject.cage
        with library.Mesh.of_cage(lib, cage) as mesh:
            options = lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
            self._sampler = library.Sampler.create(mesh, cage.positions, options)
        self._table = EdgeTable.of_faces(cage.face_sizes, cage.face_vertices)
        self._radius = rms_radius(cage.positions)

    def read(self, matrix: np.ndarray, at: np.ndarray, energy: str) -> Reading | None:
        """Where the surface is seen at `at` (2,), -1 .. 1, through `matrix` (4, 4); None where it is not. `energy` as of
        energy.py."""
        seen, net = self.inspected, self.inspected.net
        hit = pick(seen.points, net.points.quads, matrix, at)
        if hit is None:
            return None
        quad, weights = hit
        face, corner = int(net.face[quad]), int(net.corner[quad])
        uv = self._on_ray(face, corner, weights @ net.uv[quad], matrix, at)
        return self.at(face, corner, uv, energy)

    def at(self, face: int, corner: int, uv: np.ndarray, energy: str) -> Reading:
        """At parameters (2,) of a face."""
        jet = self._jets([face], [corner], uv[None])
        if not np.isfinite(jet).all():  # a pole
            jet = self._jets([face], [corner], (uv + _NUDGE * (0.5 - uv))[None])
        with np.errstate(invalid="ignore", divide="ignore"):
            bends = curvature.of_jets(jet)
        try:
            density = float(mixed(weights_of(energy), densities(jet, self.inspected.area, self._radius))[0])
        except (np.linalg.LinAlgError, ValueError):  # no tangent plane; an empty mix
            density = float("nan")
        edge = self._edge_near(face, corner, jet[0, 0])
        return Reading(jet[0, 0], bends.normals[0], float(bends.k1[0]), float(bends.k2[0]), energy, density, edge)

    def _jets(self, face: object, corner: object, uv: np.ndarray) -> np.ndarray:
        return self._sampler.jets(face, corner, uv)

    def _on_ray(self, face: int, corner: int, uv: np.ndarray, matrix: np.ndarray, at: np.ndarray) -> np.ndarray:
        """The parameters, within the patch, at which the surface itself is seen there, from those of a point nearby."""
        rows = matrix[:2] - at[:, None] * matrix[3]  # times a point: 0 where it is seen at `at`
        for _ in range(_STEPS):
            jet = self._jets([face], [corner], uv[None])[0]
            slope = rows[:, :3] @ jet[1:3].T
            if not np.isfinite(slope).all() or abs(np.linalg.det(slope)) <= 1e-12 * np.linalg.norm(slope) ** 2:
                break
            uv = np.clip(uv - np.linalg.solve(slope, rows[:, :3] @ jet[0] + rows[:, 3]), 0.0, 1.0)
        return uv

    def _edge_near(self, face: int, corner: int, point: np.ndarray) -> Continuity:
        """Over the nearest edge of the face; of a polygon's quarter over one of its corner's two edges."""
        of_face = self._table.of_face(face)
        sides = of_face if len(of_face) == 4 else of_face[[corner, corner - 1]]
        t = np.tile(np.linspace(0.0, 1.0, _SAMPLES), len(sides))
        side = np.repeat(sides, _SAMPLES)
        curve = jets_at(self._sampler, self._table.places(side, t))[:, 0]
        nearest = int(np.nanargmin(np.linalg.norm(curve - point, axis=1)))
        return self._over(int(side[nearest]), self._foot(int(side[nearest]), float(t[nearest]), point))

    def _foot(self, side: int, t: float, point: np.ndarray) -> float:
        """Where the edge is nearest, from a sample; away from ends where derivatives do not exist."""
        for _ in range(3):
            places = self._table.places([side], [np.clip(t, _NUDGE, 1 - _NUDGE)])
            jet, way = jets_at(self._sampler, places)[0], places.along[0]
            tangent = way[0] * jet[1] + way[1] * jet[2]
            square = tangent @ tangent
            if not square > 0:
                break
            t = float(np.clip(t + (point - jet[0]) @ tangent / square, _NUDGE, 1 - _NUDGE))
        return float(np.clip(t, _NUDGE, 1 - _NUDGE))

    def _over(self, side: int, t: float) -> Continuity:
        table = self._table
        around = table.of_edge(int(table.edge[side]))
        here = table.places([side], [t])
        one = jets_at(self._sampler, here)[0]
        if len(around) != 2:
            return Continuity(one[0], len(around))
        other = int(around[around != side][0])
        same = bool(table.ends[other][0] == table.ends[side][0])
        there = table.places([other], [t if same else 1 - t])
        two = jets_at(self._sampler, there)[0]
        ways = np.stack([here.along[0], there.along[0]])
        return Continuity(one[0], 2, *continuity(one, two, ways, same, self._radius))

    def close(self) -> None:
        """Free it; a second time does nothing."""
        self._sampler.close()

    def __enter__(self) -> Probe:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def words(reading: Reading, direction: np.ndarray, radius: float) -> list[str]:
    """A reading as lines; its normal's `direction` (3,) in the world."""
    radii = " and ".join("flat" if abs(k) * radius <= _FLAT or not np.isfinite(k) else number_text(1 / k) for k in (reading.k1, reading.k2))
    x, y, z = (f"{round(float(part), 3) + 0.0:.3f}" for part in direction)
    lines = [f"Radii of curvature: {radii}", f"Normal: {x}, {y}, {z}", f"{label_of(reading.energy)} per area: {number_text(reading.density)}"]
    edge = reading.edge
    if edge.n_faces == 1:
        return [*lines, "Edge: a boundary"]
    if edge.n_faces > 2:
        return [*lines, f"Edge: {edge.n_faces} faces"]
    gap = number_text(0.0 if edge.gap <= 1e-9 * radius else edge.gap)
    angle, jump = (f"{round(value, 2) + 0.0:.3g}" for value in (edge.angle, edge.jump))
    return [*lines, f"Edge: G0 {gap}, G1 {angle}°, G2 {jump} %"]

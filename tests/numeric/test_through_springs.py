# SPDX-License-Identifier: GPL-3.0-or-later
"""Points, normals and tangents of the surface that springs draw (curvopt_through.weights): forces balance, with rows by
OpenSubdiv; the springs' energy is its definition, on every level; between weight 0, the free result, and 1, the exact one; any
number of places. With CURVOPT_LONG=1 more cages."""
from __future__ import annotations

import json
import math
import subprocess

import numpy as np
import pytest

import lib
import test_through as points
import test_through_frames as frames
from ccref import Mesh, mesh_from_faces
from nets import read_obj, sphere_like, torus_cage, write_obj
from osd import osd_jets

NONE = 1  # CURVOPT_SYMMETRY_NONE
FREE_SPACING = 2
HELD, LINE, PLANE, FREE = range(4)
NAN = float("nan")
STIFFNESS = {"willmore": 24 * np.pi, "mvs": 2979.1973808604575}  # of a sphere: libcurvopt/notes/80-soft-constraints.md


def firmness(weights) -> np.ndarray:
    weights = np.asarray(weights, float)
    return weights / (1 - weights)


def radius(mesh: Mesh) -> float:
    """Root mean square distance of the vertices from their mean."""
    return float(np.sqrt(((mesh.xyz - mesh.xyz.mean(axis=0)) ** 2).sum(axis=1).mean()))


def projector(freedom: int, direction: np.ndarray) -> np.ndarray:
    """Onto what a point of that freedom is held in."""
    along = np.outer(direction, direction) / (direction @ direction) if freedom in (LINE, PLANE) else np.zeros((3, 3))
    return {HELD: np.eye(3), LINE: np.eye(3) - along, PLANE: along, FREE: np.zeros((3, 3))}[freedom]


def looks(mesh: Mesh, where: frames.Places, levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Points [n, 3] of the surface there, and two tangents [n, 2, 3] each, by OpenSubdiv: S_u and S_v inside faces; at vertices
    two at right angles to the normal."""
    found = osd_jets(mesh, *where.on(levels))
    return np.r_[found.limit[where.vertices], found.jets[:, 0]], found.jets[:, 1:3]


def spring_rows(mesh: Mesh, where: frames.Places) -> tuple[np.ndarray, np.ndarray]:
    """Rows over the cage's vertices: of the points [n, n_vertices], and of S_u and S_v inside faces [n_f, 2, n_vertices]; from
    OpenSubdiv's points on cages of zeros and ones, three vertices at a time."""
    n = mesh.n_vertices
    at, tangents = np.zeros((where.n, n)), np.zeros((len(where.faces), 2, n))
    for first in range(0, n, 3):
        columns = list(range(first, min(first + 3, n)))
        ones = np.zeros((n, 3))
        ones[columns, range(len(columns))] = 1
        cage = mesh_from_faces(ones, mesh.face_list())
        found = osd_jets(cage, where.faces, where.corners, where.uv, level=8)
        at[:, columns] = np.r_[found.limit[where.vertices], found.jets[:, 0]][:, :len(columns)]
        tangents[:, :, columns] = found.jets[:, 1:3, :len(columns)]
    return at, tangents


def orthonormal(tangents: np.ndarray) -> np.ndarray:
    """Coefficients [2, 2] by which two tangents [2, 3] are combined to two at right angles, of length 1."""
    return np.linalg.inv(np.linalg.qr(tangents.T)[1]).T


class Setting:
    """A cage, places at poles, regular vertices and in faces, what they are drawn to, and the sum of springs by definition."""

    def __init__(self, seed: int):
        random = np.random.default_rng(seed)
        self.mesh = lib.refine(points.corpus_cage(seed)) if seed else lib.refine(points.shaken_cube())
        self.where = frames.Places(self.mesh, random, 12)
        n, size = self.where.n, radius(self.mesh)
        self.rows, self.tangent_rows = spring_rows(self.mesh, self.where)
        faces, n_v = self.mesh.face_list(), self.where.n_v
        toward = [next(f[(f.index(v) + 1) % 4] for f in faces if v in f) for v in self.where.vertices]
        self.tangent_rows = np.r_[np.array([frames.tangent_masks(self.mesh, v, w)
                                            for v, w in zip(self.where.vertices, toward)]), self.tangent_rows]
        first = self.tangent_rows @ self.mesh.xyz
        self.tangent_rows = np.array([orthonormal(t) @ rows for t, rows in zip(first, self.tangent_rows)])
        self.freedom = random.integers(0, 4, n)
        self.directions = random.normal(size=(n, 3))
        self.places = self.rows @ self.mesh.xyz + 0.05 * size * random.normal(size=(n, 3))
        normals = np.cross(first[:, 0], first[:, 1])
        self.normals = frames.unit(frames.unit(normals) + 0.2 * random.normal(size=(n, 3)))
        self.weights = random.uniform(0.3, 0.95, n)
        self.n_v = n_v

    def through(self, **changed) -> lib.Through:
        places = np.where((self.freedom == FREE)[:, None], NAN, self.places)
        return lib.through(**self.where.fields(), **(dict(
            freedom=self.freedom, directions=self.directions, places=places, normals=self.normals, weights=self.weights) | changed))

    def forces(self, xyz: np.ndarray, energy: str) -> tuple[float, np.ndarray]:
        """The springs' sum, and its gradient [n_vertices, 3], on the cage that was not subdivided."""
        total, pull = 0.0, np.zeros_like(xyz)
        for i, k in enumerate(STIFFNESS[energy] * firmness(self.weights)):
            off = projector(self.freedom[i], self.directions[i]) @ (self.rows[i] @ xyz - self.places[i]) / radius(self.mesh)
            slope = self.tangent_rows[i] @ xyz @ self.normals[i]
            total += k / 2 * (off @ off + slope @ slope)
            pull += k * (np.outer(self.rows[i], off) / radius(self.mesh) +
                         np.outer(slope @ self.tangent_rows[i], self.normals[i]))
        return total, pull


@pytest.mark.parametrize("energy, seed, most", [("willmore", 0, 1e-4), ("mvs", 13, 1e-2)])
def test_forces_balance(energy, seed, most, capsys):
    """At the end the surface's gradient, by the public evaluation, is what the springs draw with, at every vertex of the cage."""
    s = Setting(seed)
    result = lib.minimize(s.mesh, energy, levels=1, spacing=FREE_SPACING, tolerance=1e-7, decrement_tolerance=1e-13,
                          through=s.through())
    _, gradient = lib.Problem(s.mesh, lib.options(energy, tolerance=1e-7)).evaluate(result.mesh.xyz, gradient=True)
    total, pull = s.forces(result.mesh.xyz, energy)
    rest = np.linalg.norm(gradient + pull) / np.linalg.norm(pull)
    with capsys.disabled():
        print(f"\n  {energy}, {s.where.n} entries: {result.verdict}, springs {total:.4g} beside {result.summary.end.objective:.4g}; of their "
              f"forces {rest:.1e} is left")
    assert result.verdict == "minimum" and rest <= most and total > 0.01
    assert abs(result.summary.spring_energy - total) <= 1e-9 * total

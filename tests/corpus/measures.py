# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of a cage that say whether vertices lie well in its surface, by Python alone. None depends on the cage's size.

`jacobian`: the cage is subdivided twice more. In each of the new quads, |S_u x S_v| at a corner is the area between the two
edges there. The least of these, over the mean of those in the same face of the cage (the same quarter, if it is no quad).
Near 0 the surface folds or pinches there. At a vertex of valence other than 4 it tells of the valence, too, so a result is to
be compared with its input, which has the same valences.

`edges`: how unlike in length the cage's edges are: the quantile of 95 % over that of 5 %.

Both of an input are taken after as many subdivisions as its result had.
"""
from __future__ import annotations

import sys
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle")]

from ccref import Mesh, mesh_from_faces, refine, topology  # noqa: E402
from nets import read_obj  # noqa: E402


class Measures(NamedTuple):
    """Of one cage."""

    jacobian: float
    edges: float


def read_cage(path: Path) -> Mesh:
    """A cage with its creases and corners, which are tags: t crease 2/1/0 A B SHARPNESS, t corner 1/1/0 V SHARPNESS."""
    mesh, creases, corners = read_obj(path), {}, {}
    for line in path.read_text(encoding="utf-8").splitlines():
        word = line.split()
        if word[:2] == ["t", "crease"]:
            creases[int(word[3]), int(word[4])] = float(word[5])
        elif word[:2] == ["t", "corner"]:
            corners[int(word[3])] = float(word[4])
    return mesh_from_faces(mesh.xyz, mesh.face_list(), creases, corners)


def subdivided(mesh: Mesh, times: int) -> Mesh:
    """By Catmull-Clark's rules."""
    for _ in range(times):
        mesh = refine(mesh)
    return mesh


def least_jacobian(mesh: Mesh) -> float:
    """As above."""
    quads = int((mesh.sizes == 4).all())
    parts = 4 ** (1 + quads)  # new quads in a face, or in a quarter of it; they are numbered face by face
    fine = subdivided(mesh, 2)
    corner = fine.xyz[fine.flat.reshape(-1, 4)]
    to_next, to_last = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    area = np.linalg.norm(np.cross(to_next, to_last), axis=2).reshape(-1, 4 * parts)
    return float((area.min(axis=1) / np.maximum(area.mean(axis=1), 1e-300)).min())


def edge_spread(mesh: Mesh) -> float:
    """As above."""
    a, b = topology(mesh).ends.T
    low, high = np.quantile(np.linalg.norm(mesh.xyz[a] - mesh.xyz[b], axis=1), [0.05, 0.95])
    return float(high / max(low, 1e-300))


def measures(mesh: Mesh) -> Measures:
    """Of a cage."""
    return Measures(least_jacobian(mesh), edge_spread(mesh))


@lru_cache(maxsize=8)
def measures_of_file(path: Path, content: str, subdivisions: int) -> Measures:
    """Of the cage in a file, subdivided; `content` names what is in the file."""
    return measures(subdivided(read_cage(path), subdivisions))

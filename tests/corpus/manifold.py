# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh, closed or open, is a manifold, and whether the library takes its boundary."""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle")]

from ccref import Mesh, topology  # noqa: E402
from nets import check_manifold, connected  # noqa: E402


def is_accepted_open(mesh: Mesh, most: int) -> bool:
    """Whether the mesh is a connected manifold with 2 to `most` faces at each boundary vertex.

    With one face, or four, a smooth boundary has no tangent plane there, and the energies are infinite.
    """
    try:
        check(mesh)
    except ValueError:
        return False
    topo = topology(mesh)
    at_boundary = topo.ends[topo.n_edge_faces == 1].ravel()
    n_faces = np.bincount(mesh.flat, minlength=mesh.n_vertices)
    return connected(mesh) and bool((n_faces[at_boundary] <= most).all())


def check(mesh: Mesh) -> None:
    """ValueError unless every edge has one or two faces, oppositely, and every vertex one fan of two faces or more."""
    topo = topology(mesh)
    if (topo.n_edge_faces == 2).all():
        check_manifold(mesh)
        return
    sides = [(f[k], f[(k + 1) % len(f)]) for f in mesh.face_list() for k in range(len(f))]
    if len(set(sides)) != len(sides):
        raise ValueError("an edge has two faces on one side")
    beside = set(sides)
    starts = [a for a, b in sides if (b, a) not in beside]
    if len(set(starts)) != len(starts):
        raise ValueError("a vertex joins two fans")
    n_faces = np.bincount(mesh.flat, minlength=mesh.n_vertices)
    fans: dict[tuple[int, int], tuple[int, int]] = {}
    for face in mesh.face_list():
        for k, v in enumerate(face):
            fans[(v, face[(k + 1) % len(face)])] = (v, face[k - 1])
    for a, b in [(a, b) for a, b in sides if (b, a) not in beside]:
        at, n = (a, b), 0
        while at in fans:
            at, n = fans[at], n + 1
        if n != n_faces[a] or n < 2:
            raise ValueError("a boundary vertex joins two fans, or has one face")
    for v in set(range(mesh.n_vertices)) - set(starts):
        first = next(key for key in ((v, b) for a, b in sides if a == v))
        at, n = fans[first], 1
        while at != first:
            at, n = fans[at], n + 1
        if n != n_faces[v]:
            raise ValueError("a vertex joins two fans")

# SPDX-License-Identifier: GPL-3.0-or-later
"""A catalogue of cages for the comparison with OpenSubdiv: every valence, boundary, corner, crease and polygon.

Each case names its boundary rule as OpenSubdiv does: `all` rounds the corners of an open cage (Blender's ALL),
`corners` keeps those that belong to one face (Blender's PRESERVE_CORNERS). Deterministic.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ccref import SHARP, Mesh, mesh_from_faces, topology
from nets import CUBE, TETRAHEDRON, genus_cage, hull_cage, mixed_cage, prism, torus_cage, trapezohedron


class Case(NamedTuple):
    """A cage with its boundary rule."""

    mesh: Mesh
    boundary: str = "all"

    def reference(self) -> Mesh:
        """The mesh as the deep refinement wants it: kept corners are infinitely sharp vertices."""
        mesh = self.mesh
        if self.boundary == "all":
            return mesh
        topo = topology(mesh)
        open_ends = topo.ends[topo.n_edge_faces == 1].ravel()
        faces = np.bincount(mesh.flat, minlength=mesh.n_vertices)
        corner = np.zeros(mesh.n_vertices, bool)
        corner[open_ends] = True
        corner &= faces == 1
        sharp = mesh.vertex_sharpness if mesh.vertex_sharpness is not None else np.zeros(mesh.n_vertices)
        return Mesh(mesh.sizes, mesh.flat, mesh.xyz, mesh.creases, mesh.crease_sharpness,
                    np.where(corner, SHARP, sharp))


def _shaken(mesh: Mesh, seed: int, share: float = 0.08) -> Mesh:
    rng = np.random.default_rng(seed)
    return mesh.with_xyz(mesh.xyz + share * rng.uniform(-1, 1, mesh.xyz.shape))


def _creased(mesh: Mesh, edges: list[tuple[int, int]], sharpness: float | list[float],
             vertices: dict[int, float] | None = None) -> Mesh:
    values = sharpness if isinstance(sharpness, list) else [sharpness] * len(edges)
    return mesh_from_faces(mesh.xyz, mesh.face_list(), dict(zip(edges, values)), vertices)


def bipyramid(n: int) -> Mesh:
    """Triangles; two vertices of valence n."""
    a = 2 * np.pi * np.arange(n) / n
    points = [*np.stack([np.cos(a), np.sin(a), 0 * a], axis=1), [0, 0, 1], [0, 0, -1]]
    faces = [[i, (i + 1) % n, n] for i in range(n)] + [[(i + 1) % n, i, n + 1] for i in range(n)]
    return mesh_from_faces(points, faces)


def quad_fan(n: int) -> Mesh:
    """n quads round one interior vertex, open all round."""
    a = np.pi * np.arange(2 * n) / n
    r = np.where(np.arange(2 * n) % 2 == 0, 1.0, 1.3)
    ring = np.stack([r * np.cos(a), r * np.sin(a), 0.3 * np.cos(2 * a)], axis=1)
    faces = [[2 * n, 2 * i, 2 * i + 1, (2 * i + 2) % (2 * n)] for i in range(n)]
    return mesh_from_faces([*ring, [0, 0, 0.4]], faces)


def grid(m: int, n: int) -> Mesh:
    """Open m x n grid of quads, curved."""
    x, y = np.meshgrid(np.arange(m + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.stack([x, y, 0.2 * x * x - 0.3 * y * y + 0.1 * x * y], axis=-1).reshape(-1, 3)
    faces = [[i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1]
             for i in range(m) for j in range(n)]
    return mesh_from_faces(points, faces)


def polygon(n: int) -> Mesh:
    """A single n-gon, bent."""
    a = 2 * np.pi * np.arange(n) / n
    return mesh_from_faces(np.stack([np.cos(a), np.sin(a), 0.2 * np.cos(2 * a)], axis=1), [list(range(n))])


def without_faces(mesh: Mesh, drop: list[int]) -> Mesh:
    """The mesh with faces taken out; vertices that become unused go too."""
    faces = [f for i, f in enumerate(mesh.face_list()) if i not in drop]
    used = sorted({i for f in faces for i in f})
    new = {old: at for at, old in enumerate(used)}
    return mesh_from_faces(mesh.xyz[used], [[new[i] for i in f] for f in faces])


def closed_cases() -> dict[str, Case]:
    """Closed smooth cages."""
    out = {}
    for n in range(3, 13):
        out[f"bipyramid_{n}"] = Case(_shaken(bipyramid(n), n))
        out[f"trapezohedron_{n}"] = Case(_shaken(trapezohedron(n), n))
    for n in (3, 5, 6, 8, 12):
        out[f"prism_{n}"] = Case(_shaken(mesh_from_faces(*prism(n)), n))
    for genus in (1, 2, 3, 5):
        out[f"frame_{genus}"] = Case(genus_cage(genus))
    out["torus"] = Case(_shaken(torus_cage(6, 5, 0.4), 1, 0.05))
    out["tetrahedron"] = Case(mesh_from_faces(*TETRAHEDRON))
    out["hull"] = Case(hull_cage(20, 4))
    out["mixed"] = Case(mixed_cage(0))
    return out


def open_cases() -> dict[str, Case]:
    """Open smooth cages, with both boundary rules."""
    meshes = {f"fan_{n}": quad_fan(n) for n in (3, 4, 5, 7, 12)}
    meshes.update({f"grid_{m}x{n}": grid(m, n) for m, n in ((1, 1), (1, 3), (3, 3), (4, 5))})
    meshes.update({f"polygon_{n}": polygon(n) for n in (3, 5, 6)})
    meshes["box"] = without_faces(_shaken(mesh_from_faces(*CUBE), 3), [5])
    meshes["holed_torus"] = without_faces(torus_cage(6, 5, 0.4), [3, 4, 17])
    meshes["holed_mixed"] = without_faces(mixed_cage(0), [1, 7])
    meshes["notched_grid"] = without_faces(grid(4, 4), [0, 6])
    return {f"{name}_{rule}": Case(mesh, rule) for name, mesh in meshes.items() for rule in ("all", "corners")}


def creased_cases() -> dict[str, Case]:
    """Semi-sharp and sharp edges and vertices, on closed and open cages.

    Sharpnesses are sixteenths: OpenSubdiv keeps them in single precision, and 0.3 would differ by 1e-8 there.
    """
    cube = _shaken(mesh_from_faces(*CUBE), 9)
    loop = [(4, 5), (5, 7), (6, 7), (4, 6)]  # round one face
    torus = _shaken(torus_cage(8, 6, 0.4), 2, 0.05)
    ring = [(i * 6, (i + 1) % 8 * 6) for i in range(8)]
    out = {f"cube_loop_{s}": Case(_creased(cube, loop, s)) for s in (0.3125, 1.0, 1.625, 2.0, 3.6875, 10.0)}
    out.update({f"cube_dart_{s}": Case(_creased(cube, [(4, 5)], s)) for s in (0.5, 2.1875, 10.0)})
    out.update({f"cube_corner_{s}": Case(_creased(cube, [(4, 5), (4, 6), (0, 4)], s)) for s in (0.6875, 2.5, 10.0)})
    out.update({f"cube_vertex_{s}": Case(_creased(cube, [], [], {4: s})) for s in (0.4375, 1.5, 10.0)})
    out["cube_mixed_loop"] = Case(_creased(cube, loop, [0.4375, 1.1875, 2.625, 10.0]))
    out["cube_loop_and_vertex"] = Case(_creased(cube, loop, [1.5, 1.5, 0.5, 2.5], {4: 0.8125, 0: 2.3125}))
    out.update({f"torus_ring_{s}": Case(_creased(torus, ring, s)) for s in (0.8125, 2.4375, 10.0)})
    out["torus_crossing"] = Case(_creased(torus, ring[:5] + [(0, 1), (1, 2), (2, 3)], [1.3125] * 5 + [2.6875] * 3))
    mesh = mixed_cage(0)
    rng = np.random.default_rng(12)
    ends = topology(mesh).ends
    for at in range(4):
        pick = rng.choice(len(ends), 6, replace=False)
        edges = [(int(a), int(b)) for a, b in ends[pick]]
        values = rng.choice([0.25, 0.9375, 1.375, 2.0, 3.25, 10.0], 6).tolist()
        out[f"mixed_random_{at}"] = Case(_creased(mesh, edges, values, {int(rng.integers(16)): 1.6875}))
    middle = [(1 * 5 + j, 1 * 5 + j + 1) for j in range(4)]
    for s in (0.625, 2.3125, 10.0):
        for rule in ("all", "corners"):
            out[f"grid_crease_{s}_{rule}"] = Case(_creased(grid(3, 4), middle, s), rule)
    return out


def catalogue() -> dict[str, Case]:
    """All cases by name."""
    return {**closed_cases(), **open_cases(), **creased_cases()}

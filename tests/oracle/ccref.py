# SPDX-License-Identifier: GPL-3.0-or-later
"""Catmull-Clark surfaces by deep refinement: the tests' own evaluator.

Nothing here knows eigenvectors or exact evaluation. A cage is refined by the textbook rules (Catmull and Clark 1978;
boundaries, creases and corners as in DeRose, Kass and Truong 1998 with the uniform creasing of OpenSubdiv) until the
wanted point lies on a face whose neighbourhood is regular; there the limit surface is one bicubic B-spline patch, and
its derivatives are the polynomial's. In `longdouble` eight levels still leave third derivatives with 1e-11.

Only the faces around the wanted points are kept from level to level: the limit surface over a face depends on the
faces that touch it, and those are known exactly after every refinement of such a neighbourhood.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

SHARP = 10.0  # sharpness from which a crease never softens, as in OpenSubdiv


@dataclass
class Mesh:
    """Polygons `faces` (flat vertex indices, `sizes` of them per face) with positions `xyz` [n, 3].

    `creases` [m, 2] with `crease_sharpness` [m]; `vertex_sharpness` [n]. Boundary edges are always sharp.
    """

    sizes: np.ndarray
    flat: np.ndarray
    xyz: np.ndarray
    creases: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    crease_sharpness: np.ndarray = field(default_factory=lambda: np.zeros(0))
    vertex_sharpness: np.ndarray | None = None

    @property
    def n_vertices(self) -> int:
        return len(self.xyz)

    @property
    def n_faces(self) -> int:
        return len(self.sizes)

    def face_list(self) -> list[list[int]]:
        """The faces as lists of vertex indices."""
        return [part.tolist() for part in np.split(self.flat, np.cumsum(self.sizes)[:-1])]

    def with_xyz(self, xyz: np.ndarray) -> "Mesh":
        """The same connectivity with other positions."""
        return Mesh(self.sizes, self.flat, np.asarray(xyz), self.creases, self.crease_sharpness, self.vertex_sharpness)


def mesh_from_faces(xyz, faces, creases=None, vertex_sharpness=None, dtype=np.float64) -> Mesh:
    """A mesh from lists; `creases` maps vertex pairs to sharpness, `vertex_sharpness` vertices to sharpness."""
    xyz = np.asarray(xyz, dtype=dtype).reshape(-1, 3)
    creases = creases or {}
    sharp = np.zeros(len(xyz))
    for vertex, value in (vertex_sharpness or {}).items():
        sharp[vertex] = value
    sizes, flat = [len(f) for f in faces], [i for f in faces for i in f]
    return Mesh(np.array(sizes, np.int64), np.array(flat, np.int64), xyz,
                np.array(list(creases.keys()), np.int64).reshape(-1, 2), np.array(list(creases.values()), float), sharp)


def scatter_add(index: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """out[index[i]] += values[i] in any floating type."""
    out = np.zeros((n,) + values.shape[1:], values.dtype)
    if len(index) == 0:
        return out
    order = np.argsort(index, kind="stable")
    sorted_index = index[order]
    starts = np.flatnonzero(np.r_[True, sorted_index[1:] != sorted_index[:-1]])
    out[sorted_index[starts]] = np.add.reduceat(values[order], starts, axis=0)
    return out


class Topology(NamedTuple):
    """Corner and edge tables of a mesh; a corner is also the half-edge that leaves it."""

    face: np.ndarray      # [corners] face of each corner
    start: np.ndarray     # [faces] first corner of each face
    nxt: np.ndarray       # [corners] next corner in the face
    prv: np.ndarray
    edge: np.ndarray      # [corners] edge of the half-edge that leaves the corner
    ends: np.ndarray      # [edges, 2]
    n_edge_faces: np.ndarray
    twin: np.ndarray      # [corners] opposite half-edge or -1
    sharpness: np.ndarray  # [edges] explicit sharpness; boundary edges SHARP


def topology(mesh: Mesh) -> Topology:
    """Build the tables. Edges with more than two faces must not occur."""
    sizes, flat = mesh.sizes, mesh.flat
    start = np.r_[0, np.cumsum(sizes)[:-1]]
    face = np.repeat(np.arange(len(sizes)), sizes)
    corner = np.arange(len(flat))
    last = corner == start[face] + sizes[face] - 1
    nxt = np.where(last, start[face], corner + 1)
    prv = np.empty_like(nxt)
    prv[nxt] = corner
    a, b = flat, flat[nxt]
    key = np.minimum(a, b) * mesh.n_vertices + np.maximum(a, b)
    unique, edge = np.unique(key, return_inverse=True)
    ends = np.stack([unique // mesh.n_vertices, unique % mesh.n_vertices], axis=1)
    count = np.bincount(edge, minlength=len(unique))
    if count.max() > 2:
        raise ValueError("non-manifold edge")
    order = np.argsort(edge, kind="stable")
    pair = np.flatnonzero(np.r_[edge[order][1:] == edge[order][:-1], False])
    twin = np.full(len(flat), -1)
    twin[order[pair]], twin[order[pair + 1]] = order[pair + 1], order[pair]
    sharpness = np.zeros(len(unique))
    if len(mesh.creases):
        lo, hi = mesh.creases.min(axis=1), mesh.creases.max(axis=1)
        wanted = lo * mesh.n_vertices + hi
        at = np.minimum(np.searchsorted(unique, wanted), len(unique) - 1)
        known = unique[at] == wanted  # a restricted mesh may have lost the edge
        sharpness[at[known]] = mesh.crease_sharpness[known]
    sharpness[count == 1] = SHARP
    return Topology(face, start, nxt, prv, edge, ends, count, twin, sharpness)


def _soften(sharpness: np.ndarray) -> np.ndarray:
    """Sharpness one level later."""
    return np.where(sharpness >= SHARP, sharpness, np.maximum(sharpness - 1.0, 0.0))


def _vertex_points(mesh: Mesh, topo: Topology, face_points: np.ndarray, vsharp: np.ndarray) -> np.ndarray:
    """New positions of the old vertices: smooth, crease, corner, and the blend while a crease fades."""
    n, xyz = mesh.n_vertices, mesh.xyz
    real = xyz.dtype.type
    ends, sharp = topo.ends, topo.sharpness
    both, other = ends.ravel(), ends[:, ::-1].ravel()
    n_edges = np.bincount(both, minlength=n)[:, None].astype(xyz.dtype)
    edge_mean = scatter_add(both, (xyz[both] + xyz[other]) / 2, n) / n_edges
    n_faces = np.maximum(np.bincount(mesh.flat, minlength=n), 1)[:, None].astype(xyz.dtype)
    face_mean = scatter_add(mesh.flat, face_points[topo.face], n) / n_faces
    smooth = (face_mean + 2 * edge_mean + (n_edges - 3) * xyz) / n_edges

    def masked(edge_sharp: np.ndarray, vertex_sharp: np.ndarray) -> np.ndarray:
        mask = np.repeat(edge_sharp > 0, 2)
        count = np.bincount(both[mask], minlength=n)
        crease = (6 * xyz + scatter_add(both[mask], xyz[other[mask]], n)) / 8
        corner = (vertex_sharp > 0) | (count > 2)
        return np.where(corner[:, None], xyz, np.where((count == 2)[:, None], crease, smooth))

    child_sharp, child_vsharp = _soften(sharp), _soften(vsharp)
    fading = (sharp > 0) & (child_sharp == 0)
    fading_vertex = (vsharp > 0) & (child_vsharp == 0)
    mask = np.repeat(fading, 2)
    total = np.bincount(both[mask], weights=np.repeat(sharp, 2)[mask], minlength=n) + np.where(fading_vertex, vsharp, 0)
    count = np.bincount(both[mask], minlength=n) + fading_vertex
    weight = np.minimum(total / np.maximum(count, 1), 1.0).astype(xyz.dtype)[:, None]
    now, later = masked(sharp, vsharp), masked(child_sharp, child_vsharp)
    return np.where((count > 0)[:, None], weight * now + (real(1) - weight) * later, now)


def refine(mesh: Mesh) -> Mesh:
    """One Catmull-Clark step. Vertices: old ones, edges, faces. Children stand in corner order.

    A quad's children keep its orientation: corner j of each child lies towards corner j of the parent, so that child k
    covers the quadrant at corner k with parallel (u, v). Children of other faces start at their corner of the parent.
    """
    topo = topology(mesh)
    n, n_edges = mesh.n_vertices, len(topo.ends)
    xyz = mesh.xyz
    vsharp = mesh.vertex_sharpness if mesh.vertex_sharpness is not None else np.zeros(n)
    face_points = scatter_add(topo.face, xyz[mesh.flat], mesh.n_faces) / mesh.sizes[:, None].astype(xyz.dtype)
    middle = (xyz[topo.ends[:, 0]] + xyz[topo.ends[:, 1]]) / 2
    beside = scatter_add(topo.edge, face_points[topo.face], n_edges)
    weight = np.minimum(topo.sharpness, 1.0).astype(xyz.dtype)[:, None]
    edge_points = (1 - weight) * (2 * middle + beside) / 4 + weight * middle
    points = np.concatenate([_vertex_points(mesh, topo, face_points, vsharp), edge_points, face_points])

    child = np.stack([mesh.flat, n + topo.edge, n + n_edges + topo.face, n + topo.edge[topo.prv]], axis=1)
    k = np.arange(len(mesh.flat)) - topo.start[topo.face]
    turn = np.where(mesh.sizes[topo.face] == 4, k, 0)
    child = np.take_along_axis(child, (np.arange(4)[None, :] - turn[:, None]) % 4, axis=1)

    inner = topo.n_edge_faces == 2
    sharp = _soften(topo.sharpness)
    keep = np.flatnonzero(inner & (sharp > 0))
    creases = np.concatenate([np.stack([topo.ends[keep, side], n + keep], axis=1) for side in (0, 1)])
    return Mesh(np.full(len(child), 4), child.ravel(), points, creases, np.tile(sharp[keep], 2),
                np.r_[_soften(vsharp), np.zeros(n_edges + mesh.n_faces)])


def restrict(mesh: Mesh, wanted: np.ndarray) -> tuple[Mesh, np.ndarray]:
    """The faces that touch a `wanted` face, and the new index of every old face (-1: dropped)."""
    face = np.repeat(np.arange(mesh.n_faces), mesh.sizes)
    mark = np.zeros(mesh.n_vertices, bool)
    chosen = np.zeros(mesh.n_faces, bool)
    chosen[wanted] = True
    mark[mesh.flat[chosen[face]]] = True
    keep = np.zeros(mesh.n_faces, bool)
    keep[face[mark[mesh.flat]]] = True
    new_face = np.where(keep, np.cumsum(keep) - 1, -1)
    flat = mesh.flat[keep[face]]
    used, flat = np.unique(flat, return_inverse=True)
    new_vertex = np.full(mesh.n_vertices, -1)
    new_vertex[used] = np.arange(len(used))
    crease = new_vertex[mesh.creases]
    good = (crease >= 0).all(axis=1)
    vsharp = mesh.vertex_sharpness[used] if mesh.vertex_sharpness is not None else None
    return Mesh(mesh.sizes[keep], flat, mesh.xyz[used], crease[good], mesh.crease_sharpness[good], vsharp), new_face


def regular_faces(mesh: Mesh, topo: Topology) -> np.ndarray:
    """Faces whose limit surface is one bicubic patch: quads among quads, four plain interior vertices of valence 4."""
    n = mesh.n_vertices
    bad = np.bincount(mesh.flat, minlength=n) != 4
    both = topo.ends.ravel()
    bad |= np.bincount(both, minlength=n) != 4
    bad[topo.ends[topo.sharpness > 0].ravel()] = True  # creases and boundaries
    if mesh.vertex_sharpness is not None:
        bad |= mesh.vertex_sharpness > 0
    odd = mesh.sizes != 4
    bad[mesh.flat[odd[topo.face]]] = True
    return np.bincount(topo.face, weights=bad[mesh.flat], minlength=mesh.n_faces) == 0


def patch_points(mesh: Mesh, topo: Topology, faces: np.ndarray) -> np.ndarray:
    """The 4 x 4 B-spline control points [len(faces), 4 (u), 4 (v), 3] of regular faces; corner 0 is point (1, 1)."""
    grid = np.empty((len(faces), 4, 4), np.int64)
    corner_at = [(1, 1), (2, 1), (2, 2), (1, 2)]
    beside_at = [((1, 0), (2, 0)), ((3, 1), (3, 2)), ((2, 3), (1, 3)), ((0, 2), (0, 1))]
    diagonal_at = [(0, 0), (3, 0), (3, 3), (0, 3)]
    for k in range(4):
        here = topo.start[faces] + k
        grid[:, corner_at[k][0], corner_at[k][1]] = mesh.flat[here]
        across = topo.nxt[topo.twin[here]]  # leaves this corner in the neighbour face
        first = topo.nxt[across]
        (i, j), (p, q) = beside_at[k]
        grid[:, i, j] = mesh.flat[first]
        grid[:, p, q] = mesh.flat[topo.nxt[first]]
        grid[:, diagonal_at[k][0], diagonal_at[k][1]] = mesh.flat[topo.prv[topo.twin[across]]]
    return mesh.xyz[grid]


def bspline_rows(t: np.ndarray) -> np.ndarray:
    """Uniform cubic B-spline values and derivatives [len(t), 4 (order), 4 (point)]."""
    t = np.asarray(t)
    one, zero = np.ones_like(t), np.zeros_like(t)
    s = one - t
    value = [s ** 3 / 6, (3 * t ** 3 - 6 * t ** 2 + 4) / 6, (-3 * t ** 3 + 3 * t ** 2 + 3 * t + 1) / 6, t ** 3 / 6]
    first = [-s ** 2 / 2, (3 * t ** 2 - 4 * t) / 2, (-3 * t ** 2 + 2 * t + 1) / 2, t ** 2 / 2]
    second = [s, 3 * t - 2, -3 * t + 1, t]
    third = [-one, 3 * one, -3 * one, one]
    return np.stack([np.stack(row, axis=-1) for row in (value, first, second, third)], axis=1) + zero[:, None, None]


# (u order, v order) of the ten jets, in the order of curvopt_sampler_jets
JET_ORDERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]


def patch_jets(points: np.ndarray, u: np.ndarray, v: np.ndarray, scale=1.0) -> np.ndarray:
    """Jets [n, 10, 3] of n patches [n, 4, 4, 3], each at its own (u, v); derivatives times scale ** order."""
    bu, bv = bspline_rows(u), bspline_rows(v)
    scale = np.broadcast_to(np.asarray(scale, points.dtype), u.shape)
    along = (bu @ points.reshape(len(u), 4, 12)).reshape(len(u), 4, 4, 3)
    tensor = bv[:, None] @ along  # [n, 4 (orders in u), 4 (in v), 3]
    p, q = np.array(JET_ORDERS).T
    return tensor[:, p, q] * (scale[:, None] ** (p + q))[..., None]


def quad_location(mesh: Mesh, face: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Faces of the once refined mesh that hold the quarters (face, corner): children stand in corner order."""
    start = np.r_[0, np.cumsum(mesh.sizes)[:-1]]
    return start[face] + corner


def deep_jets(mesh: Mesh, face, corner, uv, dtype=np.longdouble, max_level: int = 40) -> np.ndarray:
    """Jets [n, 10, 3] of the limit surface at (face, corner, u, v), conventions of curvopt_sampler_jets.

    Quads: corner is 0 and (u, v) range over the face. Other faces: (u, v) range over the quarter at `corner`.
    Points on an extraordinary vertex or on a crease or boundary never become regular: ValueError.
    """
    face, corner = np.asarray(face, np.int64), np.asarray(corner, np.int64)
    uv = np.asarray(uv, dtype).reshape(-1, 2).copy()
    mesh = mesh.with_xyz(mesh.xyz.astype(dtype))
    out = np.full((len(face), 10, 3), np.nan, dtype)
    scale = np.ones(len(face), dtype)
    quads = mesh.sizes[face] == 4
    if not (mesh.sizes == 4).all():  # one global step turns every face into quads
        half = np.clip((uv[quads] * 2).astype(np.int64), 0, 1)
        child = np.where(half[:, 1] == 0, half[:, 0], 3 - half[:, 0])
        corner = corner.copy()
        corner[quads] = child
        uv[quads] = uv[quads] * 2 - half
        scale[quads] = 2
        face = quad_location(mesh, face, corner)
        mesh = refine(mesh)
    todo = np.arange(len(face))
    for _ in range(max_level):
        mesh, new_face = restrict(mesh, np.unique(face[todo]))
        face = np.where(face >= 0, new_face[face], -1)
        topo = topology(mesh)
        good = regular_faces(mesh, topo)[face[todo]]
        at = todo[good]
        if len(at):
            out[at] = patch_jets(patch_points(mesh, topo, face[at]), uv[at, 0], uv[at, 1], scale[at])
        todo = todo[~good]
        if len(todo) == 0:
            return out
        half = np.clip((uv[todo] * 2).astype(np.int64), 0, 1)
        child = np.where(half[:, 1] == 0, half[:, 0], 3 - half[:, 0])
        uv[todo] = uv[todo] * 2 - half
        scale[todo] = scale[todo] * 2
        moved = np.full(len(face), -1)
        moved[todo] = 4 * face[todo] + child
        face = moved
        mesh = refine(mesh)
    raise ValueError(f"{len(todo)} points lie on an extraordinary vertex, a crease or the boundary")


def ordered_ring(mesh: Mesh, topo: Topology, vertex: int) -> tuple[np.ndarray, np.ndarray]:
    """Edge neighbours e_i and opposite quad corners f_i (between e_i and e_i+1) around an interior vertex, in order."""
    here = int(np.flatnonzero(mesh.flat == vertex)[0])
    first, edges, faces = here, [], []
    while True:
        edges.append(int(mesh.flat[topo.nxt[here]]))
        faces.append(int(mesh.flat[topo.nxt[topo.nxt[here]]]))
        here = int(topo.twin[topo.prv[here]])
        if here == first:
            return np.array(edges), np.array(faces)


def vertex_limit(mesh: Mesh, topo: Topology, vertex: int, steps: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Limit position and unit normal of an interior vertex of an all-quad mesh, by refining its ring `steps` times."""
    e_at, f_at = ordered_ring(mesh, topo, vertex)
    n = mesh.xyz.dtype.type(len(e_at))
    v, e, f = mesh.xyz[vertex], mesh.xyz[e_at], mesh.xyz[f_at]

    def step(v, e, f):
        fp = (v + e + f + np.roll(e, -1, axis=0)) / 4
        ep = (v + e + fp + np.roll(fp, 1, axis=0)) / 4
        return (fp.mean(axis=0) + (v + e).mean(axis=0) + (n - 3) * v) / n, ep, fp

    a = (v, e, f)
    for _ in range(steps):
        a = step(*a)
    limit = a[0]
    v, e, f = v - limit, e - limit, f - limit
    for _ in range(steps):  # the power method: only the subdominant plane survives
        v, e, f = step(v, e, f)
        mean = (n * n * v + 4 * e.sum(axis=0) + f.sum(axis=0)) / (n * (n + 5))  # drift of rounding
        size = np.abs(e - mean).max()
        v, e, f = (v - mean) / size, (e - mean) / size, (f - mean) / size
    normal = np.cross(e, np.roll(e, -1, axis=0)).sum(axis=0)
    return limit, normal / np.sqrt((normal ** 2).sum())

# SPDX-License-Identifier: GPL-3.0-or-later
"""The corpus's families: each makes a cage of about the wanted number of vertices from a stream of draws, or ValueError.

What they make is checked and counted by cages.py. Nothing is symmetric unless its name says so.
"""
from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Callable

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle"), str(HERE.parent / "cages")]

from catalogue import without_faces  # noqa: E402
from ccref import Mesh, mesh_from_faces, topology  # noqa: E402
from draw import Draw  # noqa: E402
from manifold import is_accepted_open  # noqa: E402
from nets import (CUBE, TETRAHEDRON, connected, frame_cage, grow, hull, prism, spread, torus_cage,  # noqa: E402
                  torus_faces, voxel_surface)

LARGEST = 200      # vertices
NARROWEST = 0.35   # half the width of an arm, in units of a box about two wide
Named = tuple[Mesh, str]


# ------------------------------------------------------------------------------------------------ deformations --

def mean_edge(mesh: Mesh) -> float:
    """Mean length of the edges."""
    ends = topology(mesh).ends
    return float(np.linalg.norm(mesh.xyz[ends[:, 0]] - mesh.xyz[ends[:, 1]], axis=1).mean())


def short_edge(mesh: Mesh) -> float:
    """Mean length of the vertices' shortest edges."""
    ends = topology(mesh).ends
    length = np.linalg.norm(mesh.xyz[ends[:, 0]] - mesh.xyz[ends[:, 1]], axis=1)
    shortest = np.full(mesh.n_vertices, np.inf)
    np.minimum.at(shortest, ends[:, 0], length)
    np.minimum.at(shortest, ends[:, 1], length)
    return float(shortest.mean())


def shaken(draw: Draw, mesh: Mesh, share: float, edge: float | None = None) -> Mesh:
    """Every coordinate moved by up to `share` of an edge: the mean one, if no length is given."""
    edge = mean_edge(mesh) if edge is None else edge
    return mesh.with_xyz(mesh.xyz + share * edge * draw.reals(mesh.n_vertices, -1, 1))


def warped(draw: Draw, mesh: Mesh, amount: float = 0.12) -> Mesh:
    """Bent by three waves about as long as the cage, each of `amount` of its size."""
    low, size = mesh.xyz.min(axis=0), float(np.ptp(mesh.xyz, axis=0).max())
    xyz = mesh.xyz
    for _ in range(3):
        along, across = draw.directions(2)
        phase = (mesh.xyz - low) @ along * (2 * math.pi * draw.real(0.4, 1) / size) + draw.real(0, 2 * math.pi)
        xyz = xyz + amount * draw.real(0.3, 1) * size / 3 * np.sin(phase)[:, None] * across
    return mesh.with_xyz(xyz)


def without_symmetry(draw: Draw, mesh: Mesh) -> Mesh:
    """Stretched, bent and shaken by 2 to 12 % of an edge."""
    stretched = mesh.with_xyz(mesh.xyz * draw.reals(1, 0.75, 1.4))
    return shaken(draw, warped(draw, stretched), draw.real(0.02, 0.12))


# ---------------------------------------------------------------------------------------------- tubes and lathes --

def shaken_torus(draw: Draw, size: int) -> Named:
    """A net of n x m on a torus whose tube fills 15 to 75 % of the way to the axis, shaken by 2 to 25 % of a short edge."""
    across = draw.integer(3, 8)
    along = max(3, min(round(size / across), 24))
    mesh = torus_cage(along, across, draw.real(0.15, 0.75) * math.cos(math.pi / along))
    return shaken(draw, mesh, draw.real(0.02, 0.25), short_edge(mesh)), f"torus_{along}x{across}"


def tube_points(draw: Draw, curve: np.ndarray, sides: int, closed: bool) -> np.ndarray:
    """Points [n, sides, 3] round a curve [n, 3], as thick as its other strands and bends allow, by parallel transport."""
    n = len(curve)
    if closed:
        tangent = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    else:
        padded = np.concatenate([2 * curve[:1] - curve[1:2], curve, 2 * curve[-1:] - curve[-2:-1]])
        tangent = padded[2:] - padded[:-2]
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = [_across(tangent[0], draw.directions(1)[0])]
    for t in tangent[1:]:
        normal.append(_across(t, normal[-1]))
    turn = np.zeros(n)
    if closed:  # the angle by which the frame comes back turned, undone evenly
        back = _across(tangent[0], normal[-1])
        angle = math.atan2(float(np.cross(normal[0], back) @ tangent[0]), float(normal[0] @ back))
        turn = -angle * np.arange(n) / n
    radius = _clearance(curve, closed) * draw.real(0.25, 0.42)
    radii = radius * (1 + 0.2 * np.sin(2 * math.pi * np.arange(n) / n + draw.real(0, 2 * math.pi)))
    out = np.empty((n, sides, 3))
    for i, (t, a) in enumerate(zip(tangent, normal)):
        b = np.cross(t, a)
        for k in range(sides):
            at = turn[i] + 2 * math.pi * k / sides
            out[i, k] = curve[i] + radii[i] * (math.cos(at) * a + math.sin(at) * b)
    return out


def _across(tangent: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The unit vector across the tangent that is nearest."""
    part = near - (near @ tangent) * tangent
    length = float(np.linalg.norm(part))
    if length < 1e-3:
        raise ValueError("no direction across the curve")
    return part / length


def _clearance(curve: np.ndarray, closed: bool) -> float:
    """Distance of a curve's strands: between points whose way along the curve is twice as long, or longer."""
    n = len(curve)
    step = np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=1)
    place = np.concatenate([[0.0], np.cumsum(step)])
    along = abs(place[:n, None] - place[None, :n])
    if closed:
        along = np.minimum(along, place[-1] - along)
    apart = np.linalg.norm(curve[:, None] - curve[None], axis=2)
    far = along > 1.5 * apart
    return float(min(apart[far].min() if far.any() else np.inf, 2.2 * step[:n if closed else n - 1].max()))


def knot(draw: Draw, size: int) -> Named:
    """A tube of 3 to 5 sides round a random closed curve: a bent ring, or a torus knot."""
    p, q = draw.choice([(1, 0), (1, 0), (1, 2), (2, 3), (2, 5), (3, 2)])
    sides = draw.integer(3, 5)
    fewest = 6 if q == 0 else 6 * max(p, q)
    n = max(fewest, min(round(size / sides), max(size, LARGEST) // sides))
    t = 2 * math.pi * np.arange(n) / n
    width = draw.real(0.3, 0.55)
    round_by = 1 + width * np.cos(q * t) * (q > 0)
    curve = np.stack([round_by * np.cos(p * t), round_by * np.sin(p * t), width * np.sin(q * t)], axis=1)
    for wave in (1, 2, 3):
        angle = draw.real(0, 2 * math.pi)
        curve = curve + draw.real(0, 0.35 if q == 0 else 0.12) / wave * np.sin(wave * t + angle)[:, None] * draw.directions(1)
    points = tube_points(draw, curve * draw.reals(1, 0.8, 1.3), sides, True)
    mesh = mesh_from_faces(points.reshape(-1, 3), torus_faces(n, sides))
    return shaken(draw, mesh, draw.real(0.02, 0.1)), f"knot_{p}_{q}_{n}x{sides}"


def lathe(draw: Draw, sides: int, rings: int, top: str, bottom: str) -> Mesh:
    """A turned shape: rings of quads; each end is a `pole` of triangles, a `face` with `sides` corners, or `open`."""
    points, z = [], 0.0
    for i in range(rings):
        radius = draw.real(0.55, 1.2) * (0.65 if i in (0, rings - 1) and rings > 2 else 1)
        points += [[radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides), z]
                   for k in range(sides)]
        z += draw.real(0.35, 0.8)
    faces = [[i * sides + k, i * sides + (k + 1) % sides, (i + 1) * sides + (k + 1) % sides, (i + 1) * sides + k]
             for i in range(rings - 1) for k in range(sides)]
    for end, first, pole_z in ((bottom, 0, -draw.real(0.2, 0.6)), (top, (rings - 1) * sides, z)):
        ring = [first + k for k in range(sides)]
        upwards = ring if first else ring[::-1]
        if end == "pole":
            faces += [[upwards[k], upwards[(k + 1) % sides], len(points)] for k in range(sides)]
            points.append([0.0, 0.0, pole_z])
        elif end == "face":
            faces.append(upwards)
    return mesh_from_faces(points, faces)


def poles(draw: Draw, size: int) -> Named:
    """A turned shape with one or two poles of valence 5 to 12. One in three keeps its symmetry."""
    sides = draw.integer(5, 12)
    rings = max(2, min(round((size - 2) / sides), 10))
    ends = draw.choice([("pole", "pole"), ("pole", "face")])
    mesh = lathe(draw, sides, rings, *ends)
    if draw.chance(1 / 3):
        return mesh, f"poles_symmetric_{sides}x{rings}"
    return without_symmetry(draw, mesh), f"poles_{sides}x{rings}"


# -------------------------------------------------------------------------------------------------- cubes and arms --

def grid_lines(draw: Draw, n: int, symmetric: bool) -> np.ndarray:
    """n + 1 coordinates, 0.6 to 1.5 apart; symmetric ones about 0."""
    gaps = np.array([draw.real(0.6, 1.5) for _ in range(n)])
    if symmetric:
        gaps = (gaps + gaps[::-1]) / 2
    lines = np.concatenate([[0.0], np.cumsum(gaps)])
    return (lines - lines[::-1]) / 2 if symmetric else lines


def stretched(draw: Draw, solid: np.ndarray, mesh: Mesh, symmetric: tuple[int, ...] = ()) -> Mesh:
    """The voxels' surface with grid lines at random distances."""
    lines = [grid_lines(draw, n, axis in symmetric) for axis, n in enumerate(solid.shape)]
    at = np.rint(mesh.xyz).astype(int)
    return mesh.with_xyz(np.stack([lines[axis][at[:, axis]] for axis in range(3)], axis=1))


def heap_of(draw: Draw, size: int, mirrors: tuple[int, ...] = ()) -> tuple[np.ndarray, Mesh]:
    """Cubes one after the other, each beside one that is there, until the surface has `size` vertices."""
    solid = np.zeros((7, 7, 7), bool)
    solid[3, 3, 3] = True
    mesh = voxel_surface(solid)
    for _ in range(400):
        if mesh.n_vertices >= size:
            break
        at = np.array(draw.choice(np.argwhere(solid).tolist()))
        at[draw.integer(0, 2)] += draw.choice((-1, 1))
        if at.min() < 0 or at.max() > 6 or solid[tuple(at)]:
            continue
        trial = solid.copy()
        trial[tuple(at)] = True
        for axis in mirrors:
            trial |= np.flip(trial, axis)
        try:
            made = voxel_surface(trial)
        except ValueError:  # edges or corners that touch
            continue
        if made.n_vertices <= max(size, 8) + 16 and connected(made):
            solid, mesh = trial, made
    return solid, mesh


def heap(draw: Draw, size: int) -> Named:
    """A heap of cubes, stretched, bent and shaken. One in three has one to three mirror planes instead."""
    if draw.chance(1 / 3):
        mirrors = tuple(range(draw.integer(1, 3)))
        solid, mesh = heap_of(draw, size, mirrors)
        return stretched(draw, solid, mesh, mirrors), f"heap_mirrored_{len(mirrors)}"
    solid, mesh = heap_of(draw, size)
    return without_symmetry(draw, stretched(draw, solid, mesh)), "heap"


def extrude(draw: Draw, points: list, faces: list[list[int]], at: int) -> bool:
    """Draws a face out about along its normal, smaller and turned; False, and nothing done, if it would meet another part."""
    face = faces[at]
    corner = np.array([points[i] for i in face])
    centre = corner.mean(axis=0)
    normal = sum(np.cross(corner[k] - centre, corner[(k + 1) % len(face)] - centre) for k in range(len(face)))
    normal = normal / np.linalg.norm(normal)
    width = float(np.linalg.norm(corner - centre, axis=1).mean())
    along = normal + 0.45 * draw.directions(1)[0]
    move = along * max(width * draw.real(0.6, 1.8), NARROWEST)
    scale = draw.real(0.6, 1.05)
    others = np.array([p for i, p in enumerate(points) if i not in face])
    for share in (0.5, 1.0, 1.5):
        if np.linalg.norm(others - centre - share * move, axis=1).min() < 1.1 * width:
            return False
    if scale * width < NARROWEST:
        return False
    tilt = draw.real(0, 0.35) * draw.directions(1)[0]
    ring = list(range(len(points), len(points) + len(face)))
    points += [centre + move + scale * (p - centre + np.cross(tilt, p - centre)) for p in corner]
    for k, a in enumerate(face):
        j = (k + 1) % len(face)
        faces.append([a, face[j], ring[j], ring[k]])
    faces[at] = ring
    return True


def arms(draw: Draw, size: int) -> Named:
    """A box or a prism with arms drawn out of its faces, some of them jointed or branched."""
    xyz, faces = CUBE if draw.chance(0.6) else prism(draw.integer(3, 6))
    points, faces = [np.array(p, float) for p in xyz * draw.reals(1, 0.7, 1.5)], [list(f) for f in faces]
    last, n = 0, 0
    for _ in range(500):
        at = last if n and draw.chance(0.55) else draw.integer(0, len(faces) - 1)
        if extrude(draw, points, faces, at):
            last, n = at, n + 1
        if n and len(points) >= size:
            break
    mesh = mesh_from_faces(points, faces)
    return shaken(draw, mesh, draw.real(0.02, 0.08)), f"arms_{n}"


# --------------------------------------------------------------------------------------------------------- polyhedra --

def cut(points: np.ndarray, faces: list[list[int]], normal: np.ndarray, offset: float) -> tuple[np.ndarray, list[list[int]]]:
    """A convex polyhedron's part with normal . x <= offset; ValueError if the plane passes near a corner."""
    height = points @ normal - offset
    if abs(height).min() < 0.04:
        raise ValueError("the plane passes near a corner")
    xyz, made, follows, out = list(points), {}, {}, []

    def crossing(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in made:
            made[key] = len(xyz)
            xyz.append((height[b] * points[a] - height[a] * points[b]) / (height[b] - height[a]))
        return made[key]

    for face in faces:
        kept, leaves, enters = [], -1, -1
        for k, a in enumerate(face):
            b = face[(k + 1) % len(face)]
            if height[a] < 0:
                kept.append(a)
            if height[a] < 0 < height[b]:
                leaves = crossing(a, b)
                kept.append(leaves)
            elif height[b] < 0 < height[a]:
                enters = crossing(a, b)
                kept.append(enters)
        if kept:
            out.append(kept)
        if leaves >= 0:
            follows[enters] = leaves
    if not follows:
        raise ValueError("the plane misses")
    ring = [next(iter(follows))]
    while follows[ring[-1]] != ring[0]:
        ring.append(follows[ring[-1]])
    mesh = compacted(xyz, [*out, ring])
    return mesh.xyz, mesh.face_list()


def compacted(points, faces: list[list[int]]) -> Mesh:
    """Without the vertices that no face has."""
    return without_faces(mesh_from_faces(points, faces), [])


def convex(draw: Draw, size: int) -> tuple[np.ndarray, list[list[int]]]:
    """A box, tetrahedron or prism with its corners and edges cut off by planes; every vertex has three edges."""
    xyz, faces = draw.choice([CUBE, TETRAHEDRON, prism(3), prism(5)])
    points = np.array(xyz, float) * draw.reals(1, 0.8, 1.4)
    for _ in range(60):
        if len(points) >= size:
            break
        normal = draw.directions(1)[0]
        try:
            points, faces = cut(points, faces, normal, float((points @ normal).max()) * draw.real(0.62, 0.92))
        except ValueError:
            continue
    return points, faces


def raised(draw: Draw, mesh: Mesh, n: int) -> Mesh:
    """n of the faces with more than three corners turned into pyramids."""
    points, faces = list(mesh.xyz), mesh.face_list()
    for face in draw.sample([f for f in faces if len(f) > 3], n):
        corner = mesh.xyz[face]
        out = corner.mean(axis=0) - mesh.xyz.mean(axis=0)
        faces = [f for f in faces if f is not face]
        faces += [[a, face[(k + 1) % len(face)], len(points)] for k, a in enumerate(face)]
        points.append(corner.mean(axis=0) + draw.real(0.05, 0.4) * out)
    return mesh_from_faces(points, faces)


def polyhedron(draw: Draw, size: int) -> Named:
    """Faces with 3 to 10 corners: a cut polyhedron, some of its faces raised, or a hull some of whose triangles are
    joined."""
    if draw.chance(0.5):
        mesh = mesh_from_faces(*convex(draw, min(size, 70)))
        able = sum(len(f) > 3 for f in mesh.face_list())
        mesh = raised(draw, mesh, min(draw.integer(0, 3), able))
        return shaken(draw, mesh, draw.real(0.02, 0.1)), "polyhedron_cut"
    mesh = triangle_hull(draw, min(max(size, 9), 36))
    faces = mesh.face_list()
    for _ in range(draw.integer(2, max(4, mesh.n_vertices // 2))):
        got = grow(faces, draw.choice(faces), mesh.n_vertices)
        faces = got[1] if got else faces
    return mesh_from_faces(mesh.xyz, faces), "polyhedron_joined"


def triangle_hull(draw: Draw, n: int) -> Mesh:
    """The hull's triangles of n points on an ellipsoid, each moved in or out."""
    mesh = hull(spread(draw.directions(n)))
    rough = draw.real(0.03, 0.3)
    away = np.array([[draw.real(1 - rough, 1 + rough)] for _ in range(n)])
    return mesh.with_xyz(mesh.xyz * away * draw.reals(1, 0.6, 1.5))


def triangles(draw: Draw, size: int) -> Named:
    """8 to 30 vertices."""
    n = 8 + size % 23
    return triangle_hull(draw, n), f"triangles_{n}"


# ------------------------------------------------------------------------------------------------- frames and open --

def frame(draw: Draw, size: int) -> Named:
    """Genus 1 to 3: tubes along the edges of a polyhedron or of a graph in a lattice."""
    if draw.chance(0.5):
        points, faces = convex(draw, draw.integer(4, max(5, min(size // 4, 14))))
        holed = draw.sample(range(len(faces)), min(draw.integer(2, 4), len(faces)))
        mesh = frame_cage(points - points.mean(axis=0), faces, holed, draw.real(0.3, 0.5), draw.real(0.45, 0.7))
        return without_symmetry(draw, mesh), f"frame_polyhedron_{len(holed) - 1}"
    genus = 1 if size < 48 else draw.integer(1, 3)
    solid = lattice_graph(draw, genus)
    mesh = voxel_surface(solid)
    return without_symmetry(draw, stretched(draw, solid, mesh)), f"frame_lattice_{genus}"


def lattice_graph(draw: Draw, genus: int) -> np.ndarray:
    """Voxels along a connected graph in a lattice of 3 x 3 x 2 nodes with `genus` independent circles."""
    nodes = [(x, y, z) for x in range(3) for y in range(3) for z in range(2)]
    edges = {(a, b) for a in nodes for b in nodes if a < b and sum(abs(i - j) for i, j in zip(a, b)) == 1}
    seen, used, circles = {draw.choice(nodes)}, set(), 0
    while circles < genus:
        beside = sorted(e for e in edges - used if e[0] in seen or e[1] in seen)
        closing = [e for e in beside if e[0] in seen and e[1] in seen]
        edge = draw.choice(closing if closing and draw.chance(0.8) else beside)
        circles += edge[0] in seen and edge[1] in seen
        used.add(edge)
        seen |= set(edge)
    solid = np.zeros((5, 5, 3), bool)
    for a, b in used:
        for at in (2 * np.array(a), 2 * np.array(b), np.array(a) + np.array(b)):
            solid[tuple(at)] = True
    return solid


def opened(draw: Draw, size: int) -> Named:
    """A boundary: a heap or a polyhedron with faces taken out, a cup, or a tube with two ends."""
    kind = draw.choice(("heap", "polyhedron", "cup", "tube"))
    if kind == "cup":
        sides = draw.integer(4, 9)
        mesh = lathe(draw, sides, max(2, min(round(size / sides), 12)), "open", draw.choice(("pole", "face")))
        return without_symmetry(draw, mesh), f"open_cup_{sides}"
    if kind == "tube":
        sides = draw.integer(3, 7)
        n = max(3, min(round(size / sides), 25))
        t = np.arange(n) / (n - 1)
        bend = np.cumsum(draw.directions(3), axis=0)
        curve = 2.5 * (t[:, None] * bend[0] + (t * t)[:, None] * bend[1] + (t ** 3)[:, None] * bend[2])
        faces = [f for f in torus_faces(n, sides) if abs(f[0] // sides - f[1] // sides) == 1]
        mesh = mesh_from_faces(tube_points(draw, curve, sides, False).reshape(-1, 3), faces)
        return shaken(draw, mesh, draw.real(0.02, 0.12)), f"open_tube_{n}x{sides}"
    if kind == "heap":
        solid, mesh = heap_of(draw, size)
        mesh = stretched(draw, solid, mesh)
    else:
        mesh = mesh_from_faces(*convex(draw, max(12, min(size, 60))))
    most = draw.integer(2, 3)  # with 3 the third-order energies refuse the cage
    for _ in range(draw.integer(1, max(1, mesh.n_faces // 8))):
        trial = without_faces(mesh, [draw.integer(0, mesh.n_faces - 1)])
        if is_accepted_open(trial, most):
            mesh = trial
    if not is_accepted_open(mesh, most) or (topology(mesh).n_edge_faces == 2).all():
        raise ValueError("no face could be taken out")
    return without_symmetry(draw, mesh), f"open_{kind}_{most}"


FAMILIES: tuple[Callable[[Draw, int], Named], ...] = (
    shaken_torus, heap, frame, knot, polyhedron, triangles, arms, opened, poles)  # an odd number: each in both halves

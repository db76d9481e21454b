# SPDX-License-Identifier: GPL-3.0-or-later
"""The corpus's second range, seeds from 1000 on: 30 to 1000 vertices, among them what modelling programs start from.

As in families.py, a family makes a cage of about the wanted number of vertices from a stream of draws, or ValueError.
"""
from __future__ import annotations

import itertools
import math
from functools import lru_cache
from pathlib import Path
from typing import Callable

import numpy as np

import families
from ccref import Mesh, mesh_from_faces, refine, topology
from draw import Draw
from families import Named, extrude, mean_edge, shaken, short_edge, stretched, warped, without_symmetry
from nets import cube_grid, grow, read_obj, torus_cage, voxel_surface

FIRST = 1000             # seed
SMALLEST, LARGEST = 30, 1000
STRATA = 13              # of the sizes, evenly in the logarithm
STRIDE = 5               # between the strata of a family's successive cages; no divisor of STRATA
LEAST, MOST = 0.7, 1.4   # of the wanted number of vertices
SIDES = ((0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0))
CATALOGUE = Path(__file__).resolve().parents[2] / "blend_files" / "obj"


# -------------------------------------------------------------------------------------------------- range of seeds --

def family_and_stratum(seed: int) -> tuple[int, int]:
    """Of a seed. An even seed and the next one share both, so that the halves have the same families and sizes."""
    turn, at = divmod((seed - FIRST) // 2, len(FAMILIES))
    return at, STRIDE * (turn + at) % STRATA


def make(draw: Draw, seed: int) -> Named:
    """The seed's cage by these draws; ValueError if there is none, or if it is far from the wanted size."""
    at, stratum = family_and_stratum(seed)
    size = round(SMALLEST * (LARGEST / SMALLEST) ** ((stratum + draw.real(0, 1)) / STRATA))
    mesh, name = FAMILIES[at](draw, size)
    n = mesh.n_vertices
    if not (SMALLEST <= n <= LARGEST and LEAST * size <= n <= MOST * size):
        raise ValueError(f"{n} vertices instead of {size}")
    return mesh, name


def edited(draw: Draw, mesh: Mesh, name: str) -> Named:
    """One in three is stretched along the axes alone, the others are without symmetry."""
    if draw.chance(1 / 3):
        return mesh.with_xyz(mesh.xyz * draw.reals(1, 0.75, 1.4)), f"{name}_plain"
    return without_symmetry(draw, mesh), name


# ---------------------------------------------------------------------------------------------------------- voxels --

@lru_cache
def simple_blocks() -> np.ndarray:
    """[256]: whether the surface of 2 x 2 x 2 voxels, their bits the number, passes through the middle once or not at all.

    It does if the set voxels hang together by their sides, and the others too.
    """
    cells = list(itertools.product((0, 1), repeat=3))

    def whole(some: set[tuple[int, ...]]) -> bool:
        reached = {next(iter(some))} if some else set()
        while beside := {b for a in reached for b in some - reached if sum(abs(i - j) for i, j in zip(a, b)) == 1}:
            reached |= beside
        return reached == some

    sets = [{cell for bit, cell in enumerate(cells) if code >> bit & 1} for code in range(256)]
    return np.array([whole(some) and whole(set(cells) - some) for some in sets])


def block_codes(solid: np.ndarray) -> np.ndarray:
    """The numbers, for simple_blocks(), of the blocks round the inner grid points: [a - 1, b - 1, c - 1] of [a, b, c]."""
    a, b, c = (n - 1 for n in solid.shape)
    return sum((solid[i:i + a, j:j + b, k:k + c].astype(int) << bit)
               for bit, (i, j, k) in enumerate(itertools.product((0, 1), repeat=3)))


def surface_size(solid: np.ndarray) -> int:
    """Vertices of the voxels' surface, none of which is at the array's border."""
    codes = block_codes(solid)
    return int(((codes > 0) & (codes < 255)).sum())


def blocks(draw: Draw, size: int) -> Named:
    """A heap of cubes with as many vertices as wanted. One in three keeps its right angles."""
    across = 7 + 2 * math.isqrt(size)
    solid = np.zeros((across,) * 3, bool)
    cubes, branch = [(across // 2,) * 3], draw.real(0, 0.7)
    solid[cubes[0]] = True
    n = 8
    for _ in range(40 * size):
        if n >= size:
            break
        near = cubes[-1] if draw.chance(branch) else draw.choice(cubes)
        at = tuple(a + b for a, b in zip(near, draw.choice(SIDES)))
        if min(at) < 2 or max(at) > across - 3 or solid[at]:
            continue
        round_it = tuple(slice(a - 1, a + 2) for a in at)
        before = surface_size(solid[round_it])
        solid[at] = True
        if simple_blocks()[block_codes(solid[round_it])].all():
            n += surface_size(solid[round_it]) - before
            cubes.append(at)
        else:  # edges or corners would touch
            solid[at] = False
    mesh = stretched(draw, solid, voxel_surface(solid))
    return (mesh, "blocks_plain") if draw.chance(1 / 3) else (without_symmetry(draw, mesh), "blocks")


def tubes(draw: Draw, size: int) -> Named:
    """Branching tubes of four sides along a graph in a lattice, some of its circles closed."""
    spacing, across = draw.integer(2, 4), 9
    closing, onward = draw.real(0, 1), draw.real(0, 0.8)
    solid = np.zeros((spacing * across + 4,) * 3, bool)
    nodes, used, circles = [(across // 2,) * 3], set(), 0
    for _ in range(20 * size):
        if surface_size(solid) >= size - 2 * spacing:
            break
        start = nodes[-1] if draw.chance(onward) else draw.choice(nodes)
        end = tuple(a + b for a, b in zip(start, draw.choice(SIDES)))
        edge = frozenset((start, end))
        is_closing = end in nodes
        if min(end) < 0 or max(end) > across or edge in used or (is_closing and not draw.chance(closing)):
            continue
        low, high = (2 + spacing * np.array(some) for some in sorted(edge))
        solid[tuple(slice(a, b + 1) for a, b in zip(low, high))] = True
        used.add(edge)
        circles += is_closing
        if not is_closing:
            nodes.append(end)
    return without_symmetry(draw, stretched(draw, solid, voxel_surface(solid))), f"tubes_{circles}"


# ------------------------------------------------------------------------------------------------------- catalogue --

@lru_cache
def catalogue() -> tuple[tuple[str, Mesh], ...]:
    """The committed cages, as they are, subdivided once and twice, with their names."""
    out = []
    for path in sorted(CATALOGUE.glob("*.obj")):
        mesh = read_obj(path)
        for times in range(3):
            out.append((f"{path.stem}_{times}", mesh))
            mesh = refine(mesh)
    return tuple(out)


def shaken_catalogue(draw: Draw, size: int) -> Named:
    """A committed cage, each vertex moved along its own random direction by the same 2 to 15 % of a short edge."""
    name, mesh = draw.choice([one for one in catalogue() if LEAST * size <= one[1].n_vertices <= MOST * size])
    share = draw.real(0.02, 0.15)
    return mesh.with_xyz(mesh.xyz + share * short_edge(mesh) * draw.directions(mesh.n_vertices)), f"shaken_{name}"


# ------------------------------------------------------------------------------------------------------ primitives --

def sheet(draw: Draw, size: int) -> Named:
    """Open: a grid, bent, its corners cut off, or a tube without caps.

    A boundary vertex of one face, such as a grid's corner, has no finite energy while its boundary runs smoothly.
    """
    if draw.chance(0.4):
        sides = draw.integer(5, min(32, max(5, size // 3)))
        mesh = turned(sides, [1.0] * max(3, round(size / sides)), draw.real(1, 3), "open", "open")
        return edited(draw, mesh, f"sheet_tube_{sides}")
    m = max(4, round(math.sqrt(size * draw.real(0.5, 1))))
    n = max(4, round(size / m))
    x, y = np.meshgrid(np.linspace(-1, 1, m), np.linspace(-n / m, n / m, n), indexing="ij")
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corners = {0, n - 1, (m - 1) * n, m * n - 1}
    faces = [[i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1] for i in range(m - 1) for j in range(n - 1)]
    cut = families.compacted(points, [[v for v in face if v not in corners] for face in faces])
    return shaken(draw, warped(draw, cut, draw.real(0.2, 0.6)), draw.real(0.02, 0.12)), f"sheet_grid_{m}x{n}"


def turned(sides: int, radii: list[float], height: float, top: str, bottom: str) -> Mesh:
    """Rings of `sides` vertices and these radii, evenly in the height.

    Each end is `open`, a `face` with `sides` corners or a `fan` of triangles round a vertex as high as the ring.
    """
    angle = 2 * math.pi * np.arange(sides) / sides
    heights = np.linspace(0, height, len(radii))
    points = [[r * math.cos(a), r * math.sin(a), z] for r, z in zip(radii, heights) for a in angle]
    faces = [[i * sides + k, i * sides + (k + 1) % sides, (i + 1) * sides + (k + 1) % sides, (i + 1) * sides + k]
             for i in range(len(radii) - 1) for k in range(sides)]
    for end, ring, z in ((bottom, list(range(sides))[::-1], 0.0),
                         (top, list(range((len(radii) - 1) * sides, len(radii) * sides)), height)):
        if end == "face":
            faces.append(ring)
        elif end == "fan":
            faces += [[ring[k], ring[(k + 1) % sides], len(points)] for k in range(sides)]
            points.append([0.0, 0.0, z])
    return mesh_from_faces(points, faces)


def can(draw: Draw, size: int) -> Named:
    """A cylinder or a cone with loop cuts; caps are n-gons or fans of triangles. The cone's tip is a fan."""
    sides = draw.integer(max(5, round(0.6 * math.sqrt(size))), min(48, size // 2))
    rings = max(2, round(size / sides))
    height, cap = draw.real(1, 3), draw.choice(("face", "fan"))
    if draw.chance(0.5):
        return edited(draw, turned(sides, [1.0] * rings, height, cap, cap), f"can_cylinder_{cap}_{sides}x{rings}")
    mesh = turned(sides, [1 - i / rings for i in range(rings)], height * (rings - 1) / rings, "fan", cap)
    tip = mesh.n_vertices - 1
    xyz = mesh.xyz.copy()
    xyz[tip, 2] = height
    return edited(draw, mesh.with_xyz(xyz), f"can_cone_{cap}_{sides}x{rings}")


def globe(draw: Draw, size: int) -> Named:
    """A sphere by meridians and parallels, its poles fans of triangles."""
    segments = max(5, round(math.sqrt(size * draw.real(1.3, 2.6))))
    rings = max(2, round((size - 2) / segments))
    z = [-math.cos(math.pi * (i + 1) / (rings + 1)) for i in range(rings)]
    mesh = turned(segments, [math.sqrt(1 - h * h) for h in z], 1.0, "fan", "fan")
    xyz = mesh.xyz.copy()
    xyz[:, 2] = np.concatenate([np.repeat(z, segments), [-1, 1]])
    return edited(draw, mesh.with_xyz(xyz), f"globe_{segments}x{rings}")


def geodesic(n: int) -> Mesh:
    """The unit sphere as an icosahedron with each edge in n parts: 10 n^2 + 2 vertices."""
    g = (1 + math.sqrt(5)) / 2
    corners = np.array([p for a in (-1, 1) for b in (-g, g) for p in ((0, a, b), (a, b, 0), (b, 0, a))])
    index: dict[tuple, int] = {}
    points, faces = [], []

    def vertex(p: np.ndarray) -> int:
        p = p / np.linalg.norm(p)
        key = tuple(np.round(p, 9) + 0.0)
        if key not in index:
            index[key] = len(points)
            points.append(p)
        return index[key]

    for a, b, c in families.hull(corners).face_list():
        def at(i: int, j: int) -> int:
            return vertex(corners[a] * (n - i - j) + corners[b] * i + corners[c] * j)
        for i in range(n):
            for j in range(n - i):
                faces.append([at(i, j), at(i + 1, j), at(i, j + 1)])
                if i + j < n - 1:
                    faces.append([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
    return mesh_from_faces(points, faces)


def box_grid(n: int) -> Mesh:
    """A cube of edge n with n x n quads a side."""
    mesh = cube_grid(n)  # whose points are at equal angles
    onto = mesh.xyz / abs(mesh.xyz).max(axis=1)[:, None]
    return mesh.with_xyz(np.rint(2 * n / math.pi * np.arctan(onto) + n / 2) - n / 2)


def ball(draw: Draw, size: int) -> Named:
    """An icosphere, or a subdivided cube, round or with flat sides."""
    kind = draw.choice(("icosphere", "cube", "box"))
    if kind == "icosphere":
        n = max(1, round(math.sqrt((size - 2) / 10)))
        return edited(draw, geodesic(n), f"ball_icosphere_{n}")
    n = max(2, round(math.sqrt((size - 2) / 6)))
    return edited(draw, cube_grid(n) if kind == "cube" else box_grid(n), f"ball_{kind}_{n}")


def ring(draw: Draw, size: int) -> Named:
    """A torus, its tube 20 to 80 % as thick as the hole allows."""
    across = draw.integer(4, max(4, min(16, math.isqrt(size))))
    along = max(5, round(size / across))
    mesh = torus_cage(along, across, draw.real(0.2, 0.8))
    return edited(draw, mesh, f"ring_{along}x{across}")


# ------------------------------------------------------------------------------------------- triangles and polygons --

def scattered(draw: Draw, n: int) -> np.ndarray:
    """Directions [n, 3], each the one of ten draws that is farthest from those before."""
    out = draw.directions(1)
    for _ in range(n - 1):
        some = draw.directions(10)
        out = np.concatenate([out, some[[int(np.argmin((some @ out.T).max(axis=1)))]]])
    return out


def hull(points: np.ndarray) -> Mesh:
    """Convex hull (triangles, outwards) of unit vectors [n, 3], no four in a plane, added one by one."""
    triangles = np.array([[0, 1, 2], [0, 2, 1]])  # two sides of one triangle
    for new in range(3, len(points)):
        a, b, c = (points[triangles[:, k]] for k in range(3))
        height = ((points[new] - a) * np.cross(b - a, c - a)).sum(axis=1)
        seen = triangles[height > 0]
        sides = {(int(f[k]), int(f[(k + 1) % 3])) for f in seen for k in range(3)}
        rim = sorted((p, q) for p, q in sides if (q, p) not in sides)
        triangles = np.concatenate([triangles[height <= 0], [[p, q, new] for p, q in rim]])
    return mesh_from_faces(points, triangles.tolist())


def bumpy(draw: Draw, mesh: Mesh) -> Mesh:
    """Vertices of a sphere moved in or out by waves and, each by itself, by up to 3 to 25 % of an edge; stretched."""
    rough, away = draw.real(0.03, 0.25) * mean_edge(mesh), np.ones(mesh.n_vertices)
    for along in draw.directions(4):
        away += 0.12 * np.sin(mesh.xyz @ along * draw.real(1, 5) + draw.real(0, 2 * math.pi))
    away *= 1 + rough * draw.reals(mesh.n_vertices, -1, 1)[:, 0]
    return mesh.with_xyz(mesh.xyz * away[:, None] * draw.reals(1, 0.6, 1.5))


def facets(draw: Draw, size: int) -> Named:
    """Triangles: a bumpy sphere, or quads of another family with diagonals."""
    kind = draw.choice(("sphere", "ring", "tubes", "blocks"))
    if kind == "sphere":
        return bumpy(draw, hull(scattered(draw, size))), f"facets_sphere_{size}"
    mesh, _ = {"ring": ring, "tubes": tubes, "blocks": blocks}[kind](draw, size)
    faces = []
    for a, b, c, d in mesh.face_list():
        faces += [[a, b, c], [a, c, d]] if draw.chance(0.5) else [[b, c, d], [b, d, a]]
    return mesh_from_faces(mesh.xyz, faces), f"facets_{kind}"


def dual(mesh: Mesh) -> Mesh:
    """A vertex for each face of a closed mesh, at its middle, and a face round each vertex."""
    topo = topology(mesh)
    centre = np.add.reduceat(mesh.xyz[mesh.flat], topo.start, axis=0) / mesh.sizes[:, None]
    first = np.full(mesh.n_vertices, -1)
    first[mesh.flat] = np.arange(len(mesh.flat))
    faces = []
    for start in first:
        here, polygon = start, []
        while here != start or not polygon:
            polygon.append(int(topo.face[here]))
            here = topo.twin[topo.prv[here]]
        faces.append(polygon)
    return mesh_from_faces(centre, faces)


def ngons(draw: Draw, size: int) -> Named:
    """Faces with up to ten corners on a bumpy sphere: the dual of triangles, or triangles some of which are joined."""
    if draw.chance(0.5):
        return dual(bumpy(draw, hull(scattered(draw, max(size // 2 + 2, 12))))), "ngons_dual"
    mesh = bumpy(draw, hull(scattered(draw, size)))
    faces = mesh.face_list()
    for _ in range(round(size * draw.real(0.1, 0.4))):
        face = draw.choice(faces)
        got = grow(faces, face, mesh.n_vertices) if len(face) < 10 else None
        faces = got[1] if got else faces
    return mesh_from_faces(mesh.xyz, faces), "ngons_joined"


# --------------------------------------------------------------------------------------------------- limbs and loops --

def limbs(draw: Draw, size: int) -> Named:
    """A box of quads with arms drawn out of its faces, some of them jointed or branched."""
    base = box_grid(max(1, round(math.sqrt(size * draw.real(0.1, 0.5) / 6))))
    points, faces = list(base.xyz * draw.reals(1, 0.8, 1.3)), base.face_list()
    jointed, last, n = draw.real(0.3, 0.8), 0, 0
    for _ in range(10 * size):
        at = last if n and draw.chance(jointed) else draw.integer(0, len(faces) - 1)
        if extrude(draw, points, faces, at):
            last, n = at, n + 1
        if n and len(points) >= size:
            break
    mesh = mesh_from_faces(points, faces)
    moves = draw.real(0.02, 0.08) * mean_edge(mesh) * draw.directions(mesh.n_vertices)
    return mesh.with_xyz(mesh.xyz + moves), f"limbs_{n}"


def loop(draw: Draw, size: int) -> Named:
    """A tube of 3 to 5 sides round a bent ring or a torus knot."""
    mesh, name = families.knot(draw, size)
    return mesh, name.replace("knot", "loop")


FAMILIES: tuple[Callable[[Draw, int], Named], ...] = (
    blocks, tubes, shaken_catalogue, sheet, can, globe, ball, ring, facets, ngons, limbs, loop)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Control cages for the tests: nets fitted to known surfaces, and cages with every kind of vertex and genus.

Fitting means that the Catmull-Clark limit surface passes through the known surface at the cage's vertices. All
random choices come from a seed. `python3 nets.py FOLDER` writes every named cage as an OBJ file.
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Callable

import numpy as np

from ccref import Mesh, mesh_from_faces, refine, topology

Surface = Callable[[np.ndarray, np.ndarray], np.ndarray]


# ------------------------------------------------------------------------------------------------- files --

def write_obj(path: Path | str, mesh: Mesh) -> Path:
    """Write v and f lines; positions to 17 digits, so that they return bit for bit."""
    path = Path(path)
    lines = ["v %.17g %.17g %.17g" % tuple(float(x) for x in p) for p in mesh.xyz]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in mesh.face_list()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def read_obj(path: Path | str) -> Mesh:
    """Read v and f lines; of a corner a/b/c only the vertex counts."""
    xyz, faces = [], []
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        word = line.split()
        if word and word[0] == "v":
            xyz.append([float(x) for x in word[1:4]])
        elif word and word[0] == "f":
            faces.append([int(x.split("/")[0]) - 1 for x in word[1:]])
    return mesh_from_faces(xyz, faces)


# ------------------------------------------------------------------------------------------ doubly periodic --

def torus_faces(m: int, n: int) -> list[list[int]]:
    """Quads of an m (u) x n (v) periodic grid, vertex i * n + j."""
    return [[i * n + j, (i + 1) % m * n + j, (i + 1) % m * n + (j + 1) % n, i * n + (j + 1) % n]
            for i in range(m) for j in range(n)]


def interpolating_net(values: np.ndarray) -> np.ndarray:
    """Control points [m, n, 3] of the periodic bicubic B-spline surface through `values` at its knots (by FFT)."""
    out = np.fft.fft2(values, axes=(0, 1))
    for axis, size in enumerate(values.shape[:2]):
        weight = (2 + np.cos(2 * np.pi * np.arange(size) / size)) / 3
        out = out / np.expand_dims(weight, axis=[a for a in range(3) if a != axis])
    return np.fft.ifft2(out, axes=(0, 1)).real


def periodic_net(surface: Surface, m: int, n: int) -> Mesh:
    """Interpolating net of a surface that is 2 pi periodic in both parameters, normals outwards if S_u x S_v is."""
    u, v = np.meshgrid(2 * np.pi * np.arange(m) / m, 2 * np.pi * np.arange(n) / n, indexing="ij")
    return mesh_from_faces(interpolating_net(surface(u, v)).reshape(-1, 3), torus_faces(m, n))


def torus(rho: float) -> Surface:
    """Round torus, R = 1, r = rho."""
    return lambda u, v: np.stack([(1 + rho * np.cos(v)) * np.cos(u), (1 + rho * np.cos(v)) * np.sin(u),
                                  rho * np.sin(v)], axis=-1)


def bumpy_torus(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """torus_bumpy3 of refvals.json."""
    a = 0.4 * (1 + 0.2 * np.cos(3 * u))
    return np.stack([(1 + a * np.cos(v)) * np.cos(u), (1 + a * np.cos(v)) * np.sin(u), a * np.sin(v)], axis=-1)


def cyclide(t: np.ndarray, p: np.ndarray, a: float = 5.0, c: float = 3.0, mu: float = 4.0) -> np.ndarray:
    """cyclide_a5_c3_mu4 of refvals.json."""
    b2 = a * a - c * c
    b = np.sqrt(b2)
    d = a - c * np.cos(t) * np.cos(p)
    return np.stack([(mu * (c - a * np.cos(t) * np.cos(p)) + b2 * np.cos(t)) / d,
                     b * np.sin(t) * (a - mu * np.cos(p)) / d, b * np.sin(p) * (c * np.cos(t) - mu) / d], axis=-1)


def torus_cage(m: int, n: int, rho: float) -> Mesh:
    """The plain cage: grid points on the torus itself, not interpolated."""
    u, v = np.meshgrid(2 * np.pi * np.arange(m) / m, 2 * np.pi * np.arange(n) / n, indexing="ij")
    return mesh_from_faces(torus(rho)(u, v).reshape(-1, 3), torus_faces(m, n))


# ----------------------------------------------------------------------------------------------- sphere-like --

def cube_grid(n: int) -> Mesh:
    """Unit sphere as a cube of 6 n^2 quads (equal angles), all normals outwards."""
    index: dict[tuple, int] = {}
    points, faces = [], []
    angle = np.tan(np.pi / 4 * (2 * np.arange(n + 1) / n - 1))

    def vertex(p: np.ndarray) -> int:
        key = tuple(np.round(p, 9) + 0.0)
        if key not in index:
            index[key] = len(points)
            points.append(p / np.linalg.norm(p))
        return index[key]

    for axis in range(3):
        for sign in (-1.0, 1.0):
            def at(i: int, j: int) -> int:
                p = np.empty(3)
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign, angle[i], angle[j]
                return vertex(p)
            for i in range(n):
                for j in range(n):
                    quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                    faces.append(quad if sign > 0 else quad[::-1])
    return mesh_from_faces(points, faces)


def subdivided_cube(n: int) -> Mesh:
    """Unit sphere as the 6 n^2 quads of a cube subdivided, put back on the sphere at every step; n a power of two.

    Its lines have no kink at the cube's edges, as those of `cube_grid` have, and it looks like the characteristic map
    near the eight extraordinary vertices.
    """
    if n < 1 or n & (n - 1):
        raise ValueError("n is no power of two")
    mesh = mesh_from_faces(CUBE[0] / np.sqrt(3), CUBE[1])
    while mesh.n_faces < 6 * n * n:
        mesh = refine(mesh)
        mesh = mesh.with_xyz(mesh.xyz / np.linalg.norm(mesh.xyz, axis=1)[:, None])
    return mesh


def limit_mask(mesh: Mesh) -> tuple[Callable[[np.ndarray], np.ndarray], np.ndarray]:
    """Limit positions of the vertices of a closed all-quad mesh as (A, d): A(points [n, 3]) / d[:, None], A symmetric."""
    a, b = topology(mesh).ends.T
    quads = mesh.flat.reshape(-1, 4)
    valence = np.bincount(np.concatenate([a, b]), minlength=mesh.n_vertices).astype(float)
    to = np.concatenate([a, b, quads.ravel()])
    start = np.concatenate([b, a, np.roll(quads, 2, axis=1).ravel()])
    weight = np.repeat([4.0, 1.0], [2 * len(a), quads.size])

    def apply(points: np.ndarray) -> np.ndarray:
        sums = [np.bincount(to, weight * x[start], mesh.n_vertices) for x in points.T]
        return valence[:, None] ** 2 * points + np.stack(sums, axis=1)

    return apply, valence * (valence + 5)


def fitted(mesh: Mesh, targets: np.ndarray) -> Mesh:
    """The cage whose limit surface passes through targets at its vertices (conjugate gradients)."""
    apply, scale = limit_mask(mesh)
    goal = scale[:, None] * targets
    xyz = np.array(targets, float)
    for _ in range(2):  # the second time from the residual as it is, not as it was updated
        left = goal - apply(xyz)
        step, size = left, (left ** 2).sum(axis=0)
        for _ in range(500):
            if np.sqrt(size.max()) <= 1e-15 * np.linalg.norm(goal):
                break
            image = apply(step)
            along = size / np.maximum((step * image).sum(axis=0), 1e-300)
            xyz, left = xyz + along * step, left - along * image
            before, size = size, (left ** 2).sum(axis=0)
            step = left + size / np.maximum(before, 1e-300) * step
    if abs(goal - apply(xyz)).max() > 1e-12 * abs(goal).max():
        raise ValueError("the targets do not determine a cage")
    return mesh.with_xyz(xyz)


def on_profile(mesh: Mesh, turning: np.ndarray, r: np.ndarray, z: np.ndarray) -> Mesh:
    """A mesh round the origin put on a surface of revolution, vertices by latitude: the south pole at its first point. Its
    profile is r, z [n], and in equal angles of latitude `turning` [n] changes by the same."""
    x, y, height = mesh.xyz.T
    latitude = np.arccos(-height / np.linalg.norm(mesh.xyz, axis=1)) / np.pi
    at = np.interp(latitude, (turning - turning[0]) / (turning[-1] - turning[0]), np.arange(len(r)))
    out, up = (np.interp(at, np.arange(len(r)), w) for w in (r, z))
    angle = np.arctan2(y, x)
    return mesh.with_xyz(np.stack([out * np.cos(angle), out * np.sin(angle), up], axis=-1))


def ellipsoid_points(directions: np.ndarray, axes: tuple[float, float, float]) -> np.ndarray:
    """Unit sphere stretched along the axes."""
    return directions * np.asarray(axes)


def star_points(directions: np.ndarray, name: str) -> np.ndarray:
    """star_P2 and star_xyz of refvals.json along unit directions."""
    x, y, z = directions.T
    r = 1 + 0.2 * (3 * z * z - 1) / 2 if name == "star_P2" else 1 + 0.2 * np.sqrt(27) * x * y * z
    return directions * r[:, None]


def sphere_like(n: int, name: str = "sphere", grid: Callable[[int], Mesh] = cube_grid) -> Mesh:
    """Fitted cube-like net of `sphere`, `ellipsoid_a_b_c`, `star_P2` or `star_xyz` with 6 n^2 faces."""
    mesh = grid(n)
    if name.startswith("ellipsoid"):
        return fitted(mesh, ellipsoid_points(mesh.xyz, tuple(float(x) for x in name.split("_")[1:])))
    return fitted(mesh, mesh.xyz if name == "sphere" else star_points(mesh.xyz, name))


# ----------------------------------------------------------------------------------------- mixed and random --

def hull_cage(n: int, seed: int) -> Mesh:
    """Convex hull (triangles, outwards) of n random directions, pushed apart a little."""
    return hull(spread(np.random.default_rng(seed).normal(size=(n, 3))))


def spread(p: np.ndarray) -> np.ndarray:
    """Directions [n, 3] pushed apart a little, as unit vectors."""
    for _ in range(10):
        p = p / np.linalg.norm(p, axis=1)[:, None]
        gap = p[:, None] - p[None]
        p = p + 0.02 * (gap / ((gap ** 2).sum(-1) + 0.05)[..., None]).sum(axis=1)
    return p / np.linalg.norm(p, axis=1)[:, None]


def hull(p: np.ndarray) -> Mesh:
    """Convex hull (triangles, outwards) of points [n, 3], all of them on it and no four in a plane."""
    n = len(p)
    faces = []
    for a in range(n):
        for b in range(a + 1, n):
            for c in range(b + 1, n):
                normal = np.cross(p[b] - p[a], p[c] - p[a])
                side = np.delete((p - p[a]) @ normal, [a, b, c])
                if (side < 0).all():
                    faces.append([a, b, c])
                elif (side > 0).all():
                    faces.append([a, c, b])
    return mesh_from_faces(p, faces)


def dissolve(faces: list[list[int]], a: int, b: int) -> list[list[int]]:
    """Join the two faces at edge a-b."""
    one = next(f for f in faces if a in f and f[(f.index(a) + 1) % len(f)] == b)
    two = next(f for f in faces if b in f and f[(f.index(b) + 1) % len(f)] == a)
    i, j = one.index(b), two.index(a)
    joined = one[i:] + one[:i] + (two[j:] + two[:j])[1:-1]
    return [f for f in faces if f is not one and f is not two] + [joined]


def valences(mesh: Mesh) -> np.ndarray:
    """Number of edges at each vertex."""
    return np.bincount(topology(mesh).ends.ravel(), minlength=mesh.n_vertices)


def mixed_cage(seed: int = 0, perturb: float = 0.05) -> Mesh:
    """Triangles, quads, a pentagon and a hexagon; vertices of valence 3, 4, 5, 6 and 7 (and perhaps more)."""
    for trial in range(10_000):
        rng = np.random.default_rng([seed, trial])
        mesh = hull_cage(16, 1000 * seed + trial)
        faces = mesh.face_list()
        if not {5, 6, 7} <= set(valences(mesh).tolist()):
            continue
        for size in (6, 5, 4, 4, 4):
            face = [f for f in faces if len(f) == 3][0]
            while len(face) < size:
                face = grow(faces, face, mesh.n_vertices)
                if face is None:
                    break
                faces = face[1]
                face = face[0]
            if face is None:
                break
        else:
            got = mesh_from_faces(mesh.xyz * (1 + perturb * rng.normal(size=(16, 1))), faces)
            if {3, 4, 5, 6, 7} <= set(valences(got).tolist()):
                return got
    raise ValueError("no cage found")


def grow(faces: list[list[int]], face: list[int], n: int):
    """Join a triangle to `face`, if an edge allows it: both ends keep valence 3 and the two share one edge alone."""
    count = np.bincount(np.concatenate(faces), minlength=n)
    for k, a in enumerate(face):
        b = face[(k + 1) % len(face)]
        other = next(f for f in faces if b in f and f[(f.index(b) + 1) % len(f)] == a)
        if len(other) == 3 and count[a] > 3 and count[b] > 3 and len(set(other) & set(face)) == 2:
            joined = dissolve(faces, a, b)
            return joined[-1], joined
    return None


def quad_cage(mesh: Mesh, seed: int = 0, perturb: float = 0.0) -> Mesh:
    """All-quad cage, no face with two extraordinary corners (refined once, or twice if the cage has n-gons).

    Positions are moved by a share of the mean edge.
    """
    fine = refine(mesh)
    if (mesh.sizes != 4).any():
        fine = refine(fine)
    rng = np.random.default_rng(seed)
    ends = topology(fine).ends
    edge = np.linalg.norm(fine.xyz[ends[:, 0]] - fine.xyz[ends[:, 1]], axis=1).mean()
    return mesh_from_faces(fine.xyz + perturb * edge * rng.uniform(-1, 1, fine.xyz.shape), fine.face_list())


def perturbed(mesh: Mesh, share: float, seed: int) -> Mesh:
    """Every coordinate moved by up to `share` of the mean edge."""
    rng = np.random.default_rng(seed)
    ends = topology(mesh).ends
    edge = np.linalg.norm(mesh.xyz[ends[:, 0]] - mesh.xyz[ends[:, 1]], axis=1).mean()
    return mesh.with_xyz(mesh.xyz + share * edge * rng.uniform(-1, 1, mesh.xyz.shape))


# ------------------------------------------------------------------------------------------------- any genus --

def voxel_surface(solid: np.ndarray) -> Mesh:
    """Boundary quads of the set voxels; ValueError if it is not a manifold."""
    solid = np.pad(np.asarray(solid, bool), 1)
    index: dict[tuple, int] = {}
    faces = []
    for cell in np.argwhere(solid):
        for axis in range(3):
            for sign in (0, 1):
                beside = cell.copy()
                beside[axis] += 2 * sign - 1
                if solid[tuple(beside)]:
                    continue
                quad = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    p = cell.copy()
                    p[axis] += sign
                    p[(axis + 1) % 3] += du
                    p[(axis + 2) % 3] += dv
                    quad.append(index.setdefault(tuple(p), len(index)))
                faces.append(quad if sign else quad[::-1])
    mesh = mesh_from_faces(np.array(list(index)) - 1.0, faces)
    check_manifold(mesh)
    return mesh


def check_manifold(mesh: Mesh) -> None:
    """ValueError unless every edge has two opposite faces and every vertex one fan."""
    topo = topology(mesh)
    if (topo.n_edge_faces != 2).any() or (mesh.flat == mesh.flat[topo.twin]).any():
        raise ValueError("not a closed oriented manifold")
    fan = np.full(mesh.n_vertices, 0)
    first = np.full(mesh.n_vertices, -1)
    first[mesh.flat] = np.arange(len(mesh.flat))
    for vertex, here in enumerate(first):
        start = here
        while True:
            fan[vertex] += 1
            here = topo.twin[topo.prv[here]]
            if here == start:
                break
    if (fan != np.bincount(mesh.flat, minlength=mesh.n_vertices)).any():
        raise ValueError("a vertex joins two fans")


def euler(mesh: Mesh) -> int:
    """V - E + F."""
    return mesh.n_vertices - len(topology(mesh).ends) + mesh.n_faces


def holed_block(genus: int) -> Mesh:
    """A slab of voxels with `genus` square holes in a row."""
    solid = np.ones((2 * genus + 1, 3, 1), bool)
    solid[1:2 * genus:2, 1] = False
    return voxel_surface(solid)


def random_voxels(genus: int, seed: int, flips: int = 40) -> Mesh:
    """A connected voxel surface of the wanted genus: a holed block after random flips of voxels that keep all of it."""
    rng = np.random.default_rng([seed, genus])
    solid = np.zeros((2 * genus + 3, 5, 3), bool)
    solid[1:-1, 1:4, 1] = True
    solid[2:2 * genus + 1:2, 2, 1] = False
    mesh = voxel_surface(solid)
    for _ in range(flips):
        at = tuple(int(rng.integers(0, s)) for s in solid.shape)
        solid[at] ^= True
        try:
            trial = voxel_surface(solid)
            if euler(trial) == 2 - 2 * genus and connected(trial):
                mesh = trial
                continue
        except ValueError:  # not a manifold any more
            pass
        solid[at] ^= True
    return mesh


def connected(mesh: Mesh) -> bool:
    """Whether edges lead from every vertex to every other."""
    label = np.arange(mesh.n_vertices)
    ends = topology(mesh).ends
    while True:
        low = np.minimum(label[ends[:, 0]], label[ends[:, 1]])
        new = label.copy()
        np.minimum.at(new, ends[:, 0], low)
        np.minimum.at(new, ends[:, 1], low)
        if (new == label).all():
            return bool((label == 0).all())
        label = new


def frame_cage(points: np.ndarray, faces: list[list[int]], holed: list[int], inset: float = 0.4,
               inner: float = 0.6) -> Mesh:
    """Two concentric copies of a polyhedron joined through its holed faces: genus len(holed) - 1, arms between hubs.

    Faces left whole become n-gons twice. All quads if every face is holed.
    """
    points = np.asarray(points, float)
    n = len(points)
    xyz = [*points, *(inner * points)]
    out = []
    for at, face in enumerate(faces):
        if at not in holed:
            out += [list(face), [n + i for i in reversed(face)]]
            continue
        centre = points[face].mean(axis=0)
        ring = []
        for scale in (1.0, inner):
            ring.append(range(len(xyz), len(xyz) + len(face)))
            xyz += [scale * (centre + (1 - inset) * (points[i] - centre)) for i in face]
        for k, a in enumerate(face):
            j = (k + 1) % len(face)
            b = face[j]
            out.append([a, b, ring[0][j], ring[0][k]])
            out.append([n + b, n + a, ring[1][k], ring[1][j]])
            out.append([ring[0][k], ring[0][j], ring[1][j], ring[1][k]])
    mesh = mesh_from_faces(xyz, out)
    check_manifold(mesh)
    return mesh


CUBE = (np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)]),
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TETRAHEDRON = (np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
               [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def prism(n: int) -> tuple[np.ndarray, list[list[int]]]:
    """Points and faces of an n-sided prism: two n-gons, then n quads."""
    a = 2 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(a), np.sin(a)], axis=1)
    points = np.concatenate([np.c_[ring, -np.ones(n)], np.c_[ring, np.ones(n)]])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return points, [list(range(n))[::-1], list(range(n, 2 * n))] + sides


def trapezohedron(n: int) -> Mesh:
    """2 n kites: two vertices of valence n, the others of valence 3 (n = 3 is a cube)."""
    a = np.pi * np.arange(2 * n) / n
    ring = np.stack([np.cos(a), np.sin(a), 0.25 * (-1.0) ** np.arange(2 * n)], axis=1)
    faces = []
    for i in range(0, 2 * n, 2):
        faces.append([2 * n, i, i + 1, (i + 2) % (2 * n)])
        faces.append([2 * n + 1, (i + 1) % (2 * n), i, (i - 1) % (2 * n)])
    return mesh_from_faces([*ring, [0, 0, 1.0], [0, 0, -1.0]], faces)


def genus_cage(genus: int) -> Mesh:
    """A frame of the given genus 1..5: prisms with holed sides, tetrahedron (3) and cube (5)."""
    if genus == 3:
        return frame_cage(*TETRAHEDRON, holed=list(range(4)))
    if genus == 5:
        return frame_cage(*CUBE, holed=list(range(6)))
    points, faces = prism(max(genus + 1, 3))
    return frame_cage(points, faces, holed=list(range(2, 3 + genus)))


def named_cages() -> dict[str, Mesh]:
    """The small cages that the numeric tests go through, by name."""
    mixed = mixed_cage(0)
    cages = {
        "cube": mesh_from_faces(*CUBE),
        "torus_8x6": perturbed(torus_cage(8, 6, 0.45), 0.1, 1),
        "mixed": mixed,
        "mixed_quads": quad_cage(mixed, 1, 0.05),
        "star_xyz_4": sphere_like(4, "star_xyz"),
    }
    for n in (5, 6, 7):
        cages[f"kites_{n}_quads"] = quad_cage(trapezohedron(n), n, 0.08)
    for genus in range(1, 6):
        cages[f"frame_{genus}"] = genus_cage(genus)
        cages[f"frame_{genus}_quads"] = quad_cage(genus_cage(genus), genus, 0.05)
    for genus in range(0, 6):
        cages[f"voxels_{genus}"] = random_voxels(genus, genus)
    return cages


def main(folder: str) -> None:
    """Write the named cages and the fitted nets."""
    cages = named_cages()
    for n in (8, 16, 32):
        cages[f"net_torus_{n}"] = periodic_net(torus(0.5), n, n)
        cages[f"net_bumpy_{n}"] = periodic_net(bumpy_torus, n, n)
        cages[f"net_cyclide_{n}"] = periodic_net(cyclide, n, n)
    for name in ("sphere", "ellipsoid_1_1_2", "ellipsoid_1_2_3", "star_P2", "star_xyz"):
        for n in (2, 4, 8):
            cages[f"net_{name}_{n}"] = sphere_like(n, name)
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    for name, mesh in cages.items():
        check_manifold(mesh)
        write_obj(target / f"{name}.obj", mesh)


if __name__ == "__main__":
    main(sys.argv[1])

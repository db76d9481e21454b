# SPDX-License-Identifier: GPL-3.0-or-later
"""Principal curvatures at points of the surface (curvopt_through.curvatures): what OpenSubdiv says that they are, on every
level; minima that nothing else holds; spheres and tori from points with their curvatures, against points with normals
alone; runs that are stopped; what is refused, by name. With CURVOPT_LONG=1 more cages, surfaces and levels."""
from __future__ import annotations

import json
import subprocess
import time

import numpy as np
import pytest

import lib
import test_frames_orders as orders
import test_through as points
import test_through_frames as frames
from ccref import Mesh
from nets import read_obj, sphere_like, torus_cage, write_obj
from osd import osd_jets
from test_no_crossings import sheets

NONE = 1  # CURVOPT_SYMMETRY_NONE
HELD, LINE, PLANE, FREE = range(4)
CAGES = ((0, 0, "wmw"), (4, 0, "www"), (22, 1, "www"))  # seed, whether refined first, energies of levels
MORE = ((4, 0, "wmw"), (22, 1, "mww"), *((seed, refined, "www") for seed, refined in (
    (1, 0), (2, 0), (3, 0), (7, 0), (8, 0), (11, 0), (19, 0), (10, 1), (13, 1))))
SURFACES = [("torus", 0.3), *[("sphere", 0), ("torus", 0.5)] * lib.LONG]
LEVELS = 3 if lib.LONG else 2
NAN = float("nan")
unit = frames.unit


def forms(jets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals [n, 3] and curvature tensors [n, 3, 3] of jets [n, 6, 3]: n n' to 0, and the second form on tangent vectors,
    positive on a sphere whose faces are counterclockwise seen from outside."""
    first, second = jets[:, 1:3], jets[:, [3, 4, 4, 5]].reshape(-1, 2, 2, 3)
    normals = unit(np.cross(first[:, 0], first[:, 1]))
    form = -np.einsum("nijx,nx->nij", second, normals)
    dual = np.linalg.pinv(np.swapaxes(first, 1, 2))  # [n, 2, 3]
    return normals, np.einsum("nia,nij,njb->nab", dual, form, dual)


def tensors(normals: np.ndarray, directions: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Those [n, 3, 3] of principal curvatures k [n, 2], the first in these directions."""
    d = unit(directions)
    e = np.cross(unit(normals), d)
    return k[:, 0, None, None] * d[:, :, None] * d[:, None] + k[:, 1, None, None] * e[:, :, None] * e[:, None]


def at_vertices(mesh: Mesh, vertices) -> tuple[list[int], list[int], list[list[float]]]:
    """A place of a face for each vertex, as osd_jets takes it."""
    out = []
    for v in vertices:
        f, face = next((f, face) for f, face in enumerate(mesh.face_list()) if v in face)
        k = face.index(v)
        out.append((f, 0, [[0, 0], [1, 0], [1, 1], [0, 1]][k]) if len(face) == 4 else (f, k, [0, 0]))
    return tuple(map(list, zip(*out))) if out else ([], [], [])


def look(where: frames.Places, mesh: Mesh, levels: int) -> np.ndarray:
    """Jets [n, 6, 3] at the places of a cage, vertices first, by OpenSubdiv."""
    faces, corners, uv = where.on(levels)
    f, c, at = at_vertices(mesh, where.vertices)
    return osd_jets(mesh, [*f, *faces], [*c, *corners], np.array([*at, *uv]), level=10).jets


class Wishes:
    """Places, normals and curvatures near those that a surface has: inside faces and at vertices of four faces."""

    def __init__(self, seed: int, refined: int):
        self.random = random = np.random.default_rng(seed)
        mesh = points.corpus_cage(seed)
        self.mesh = mesh = lib.refine(mesh) if refined else mesh
        valence = np.bincount([v for face in mesh.face_list() for v in face], minlength=mesh.n_vertices)
        self.where = where = frames.Places(mesh, random, 20)
        where.vertices = where.vertices[valence[where.vertices] == 4]
        where.n_v, where.n = len(where.vertices), len(where.vertices) + len(where.faces)
        jets, size, n = look(where, mesh, 1), points.size(mesh), where.n
        normals, now = forms(jets)
        self.normals = unit(normals + 0.1 * random.normal(size=(n, 3)))
        self.places = jets[:, 0] + 0.005 * size * random.uniform(-1, 1, (n, 3))
        largest = np.array([np.linalg.eigh(tensor)[1][:, np.abs(np.linalg.eigvalsh(tensor)).argmax()] for tensor in now])
        directions = largest - (largest * self.normals).sum(1)[:, None] * self.normals
        self.directions = unit(directions + 0.2 * np.cross(self.normals, directions))
        across = np.cross(self.normals, self.directions)
        k = np.stack([np.einsum("na,nab,nb->n", d, now, d) for d in (self.directions, across)], 1)
        self.k = k + 0.3 * random.uniform(-1, 1, (n, 2)) * np.abs(k).max(1)[:, None]
        self.freedom = random.choice([HELD, FREE, PLANE], n)
        self.places[self.freedom == FREE] = NAN

    def through(self) -> lib.Through:
        signs = self.random.choice([-1, 1], (self.where.n, 1))  # which do not count
        return lib.through(**self.where.fields(), freedom=self.freedom, directions=self.normals, places=self.places,
                           normals=signs * self.normals, curvatures=self.k, curvature_directions=3 * self.directions)


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("seed, refined, energies", CAGES + MORE if lib.LONG else CAGES)
def test_curvatures_are_what_they_are_to_be(seed, refined, energies, levels, capsys):
    wanted = Wishes(seed, refined)
    energy = {"w": "willmore", "m": "mvs"}[energies[levels - 1]]
    result = lib.minimize(wanted.mesh, energy, levels=levels, symmetry=NONE, through=wanted.through())
    jets = look(wanted.where, result.mesh, levels)
    normals, found = forms(jets)
    held = wanted.freedom != FREE
    far = points.off((jets[:, 0] - wanted.places)[held], wanted.freedom[held], wanted.normals[held]).max(initial=0)
    askew = np.linalg.norm(np.cross(normals, wanted.normals), axis=1).max()
    wish = tensors(wanted.normals, wanted.directions, wanted.k)
    wrong = np.abs(found - wish).max() * points.size(wanted.mesh)
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels, {energy}, {wanted.where.n_v} vertices and {len(wanted.where.faces)} places of "
              f"{wanted.mesh.n_vertices}: {result.summary.start.objective:.5g} -> {result.summary.end.objective:.5g}, "
              f"{result.verdict}, {result.summary.seconds:.2f} s; off by {far / points.size(wanted.mesh):.1e}, normals by "
              f"{askew:.1e}, curvatures by {wrong:.1e} of {np.abs(wish).max() * points.size(wanted.mesh):.1f}")
    assert far <= 1e-9 * points.size(wanted.mesh) and askew <= 1e-9 and wrong <= 1e-9 and result.verdict == "minimum"


# ------------------------------------------------------------------------------------------- what holds a minimum --

def spline(t: float) -> np.ndarray:
    """Weights [3, 4] of a uniform cubic B-spline, and their first and second derivatives."""
    return np.array([[(1 - t) ** 3, 3 * t ** 3 - 6 * t * t + 4, -3 * t ** 3 + 3 * t * t + 3 * t + 1, t ** 3],
                     [-3 * (1 - t) ** 2, 9 * t * t - 12 * t, -9 * t * t + 6 * t + 3, 3 * t * t],
                     [6 - 6 * t, 18 * t - 12, 6 - 18 * t, 6 * t]]) / 6


def rows_on_torus(mesh: Mesh, m: int, n: int, face: int, u: float, v: float) -> np.ndarray:
    """Rows [6, m n] of S, S_u, S_v, S_uu, S_uv, S_vv on a face of a grid of m x n vertices, by bicubic B-splines."""
    corners = [divmod(x, n) for x in mesh.face_list()[face]]
    (i, j), along, across = corners[0], np.subtract(corners[1], corners[0]), np.subtract(corners[3], corners[0])
    wrap = lambda d: (d + np.array([m, n]) // 2) % np.array([m, n]) - np.array([m, n]) // 2  # noqa: E731
    along, across = wrap(along), wrap(across)
    a, b = spline(u), spline(v)
    out = np.zeros((6, m * n))
    for row, (p, q) in zip(out, ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))):
        for k in range(4):
            for l in range(4):
                x, y = (i, j) + (k - 1) * along + (l - 1) * across
                row[x % m * n + y % n] += a[p, k] * b[q, l]
    return out


@pytest.mark.parametrize("energy, most", [("willmore", 1e-4), *[("mvs", 1e-2)] * lib.LONG])
def test_only_what_is_held_bears_the_gradient(energy, most, capsys):
    """The gradient of a minimum is a combination of rows, by B-splines: of the point, of both tangents, and of second derivatives
    along the normal. At places of faces, one of them at a vertex."""
    m, n, at = 12, 8, np.array([[0.3, 0.6], [0.7, 0.2], [0, 0]])
    mesh = torus_cage(m, n, 0.4)
    mesh = points.mesh_from_faces(mesh.xyz + 0.02 * np.random.default_rng(3).uniform(-1, 1, mesh.xyz.shape), mesh.face_list())
    faces = [10, 60]
    vertex = 40
    face = next(f for f, corners in enumerate(mesh.face_list()) if corners[0] == vertex)
    rows = [rows_on_torus(mesh, m, n, f, *uv) for f, uv in zip([*faces, face], at)]
    jets = np.array([r @ mesh.xyz for r in rows])
    assert np.abs(jets - osd_jets(mesh, [*faces, face], [0] * 3, at).jets).max() < 1e-12
    normals = unit(forms(jets)[0] + 0.05)
    k = np.array([[2.5, 0.5], [1.5, -1], [3, 1]])
    directions = np.cross(normals, [0.3, 0.2, 0.9])
    through = lib.through([-1, -1, vertex], [*faces, 0], uv=at, normals=normals, curvatures=k, curvature_directions=directions)
    result = lib.minimize(mesh, energy, levels=1, symmetry=NONE, spacing=2, tolerance=1e-7, decrement_tolerance=1e-13,
                          through=through)
    found = forms(np.array([r @ result.mesh.xyz for r in rows]))[1]
    assert np.abs(found - tensors(normals, directions, k)).max() <= 1e-9
    problem = lib.Problem(result.mesh, lib.options(energy, tolerance=1e-7))
    _, gradient = problem.evaluate(result.mesh.xyz, gradient=True)
    forces = [np.outer(row, axis) for r in rows for row in r[:3] for axis in np.eye(3)]
    forces += [np.outer(row, normal) for r, normal in zip(rows, normals) for row in r[3:]]
    matrix = np.array([force.ravel() for force in forces]).T
    size, *_ = np.linalg.lstsq(matrix, gradient.ravel(), rcond=None)
    rest = np.linalg.norm(gradient.ravel() - matrix @ size) / np.linalg.norm(gradient)
    with capsys.disabled():
        print(f"\n  {energy}, {result.verdict}: of a gradient of {np.linalg.norm(gradient):.2g} {rest:.1e} is left")
    assert result.verdict == "minimum" and rest <= most


# ------------------------------------------------------------------------------------- spheres and tori from points --

def exact_curvatures(name: str, at: np.ndarray, normals: np.ndarray, ring: float) -> tuple[np.ndarray, np.ndarray]:
    """Principal curvatures [n, 2] and directions [n, 3] of the unit sphere or a torus of the radii 1 and `ring`."""
    if name == "sphere":
        return np.ones((len(at), 2)), np.full((len(at), 3), NAN)
    round_axis = np.cross([0, 0, 1], at)
    far = np.linalg.norm(at[:, :2], axis=1)
    return np.stack([(far - 1) / ring / far, np.full(len(at), 1 / ring)], 1), round_axis


def far_apart(mesh: Mesh) -> np.ndarray:
    """Six vertices of four faces, at least four edges from each other: along a row of a regular net three are needed."""
    faces, chosen = mesh.face_list(), []
    valence = np.bincount([v for face in faces for v in face])
    for v in np.random.default_rng(2).permutation(np.flatnonzero(valence == 4)):
        near = {int(v)}
        for _ in range(3):
            near |= {w for face in faces for a, b in zip(face, face[1:] + face[:1]) if a in near or b in near for w in (a, b)}
        if len(chosen) < 6 and not near & set(chosen):
            chosen.append(int(v))
    assert len(chosen) == 6
    return np.array(chosen)


@pytest.mark.parametrize("name, ring", SURFACES)
def test_points_with_curvatures_tend_to_the_surface(name, ring, capsys):
    """MVS from six points, with normals alone, and with curvatures: distance to the exact surface, curvature's error. What normals
    hold loosely, as a thin torus, curvatures bring nearer; elsewhere what is held takes little."""
    exact = orders.sphere() if name == "sphere" else orders.cyclide(1, 0, ring)
    vertices = far_apart(exact.cage)
    limit = osd_jets(exact.cage, [0], [0], [[0.5, 0.5]]).limit
    places, normals, _ = exact.nearest(limit[vertices])
    k, directions = exact_curvatures(name, places, normals, ring)
    held = {"normals": {}, "curvatures": dict(curvatures=k, curvature_directions=directions)}
    rows: dict[str, list[tuple[float, ...]]] = {}
    for what, more in held.items():
        for levels in range(1, LEVELS + 1):
            began = time.process_time()
            result = lib.minimize(exact.cage, "mvs", levels=levels, symmetry=NONE, tolerance=1e-5,
                                  through=lib.through(vertices, places=places, normals=normals, **more))
            assert result.verdict == "minimum"
            rows.setdefault(what, []).append((*orders.errors(result.mesh, exact), result.summary.end.objective,
                                              time.process_time() - began))
    with capsys.disabled():
        print(f"\n  {name} {ring}, six points")
        for what, found in rows.items():
            print(f"    {what:10s} distance {' '.join(f'{x[0]:.1e}' for x in found)}; curvature "
                  f"{' '.join(f'{x[1]:.1e}' for x in found)}; energy {' '.join(f'{x[2]:.3g}' for x in found)}; CPU time "
                  f"{' '.join(f'{x[3]:.1f}' for x in found)}")
    alone, curved = (np.array(found)[:, :2] for found in rows.values())
    assert (curved[-1] < curved[-2] / 2).all() and curved[-1, 1] < 1.3 * alone[-1, 1]
    if ring == 0.3:
        assert (curved[-1] < alone[-1] / 2).all()


@pytest.mark.parametrize("k", [[1.5, 1.5], *[[0.25, 1.0], [-0.5, 0.5]] * lib.LONG])
def test_a_ball_bends_as_it_is_told(k):
    """Curvatures at one point of a sphere that has others: the size comes from them, and nothing else is held."""
    mesh = sphere_like(4)
    jets = osd_jets(mesh, [20], [0], [[0.4, 0.3]]).jets
    normals, _ = forms(jets)
    levels = 2 if lib.LONG else 1
    direction = np.cross(normals, [0.2, 0.9, 0.1])
    result = lib.minimize(mesh, "mvs", levels=levels, symmetry=NONE, through=lib.through(
        faces=[20], uv=[[0.4, 0.3]], normals=normals, curvatures=[k], curvature_directions=direction))
    place = ([80], [0], [[0.8, 0.6]]) if lib.LONG else ([20], [0], [[0.4, 0.3]])
    found = forms(osd_jets(result.mesh, *place).jets)[1]
    assert np.abs(found - tensors(normals, direction, np.array([k]))).max() <= 1e-9 and result.verdict == "minimum"


def test_a_tangent_is_the_direction_of_the_first_curvature():
    mesh = torus_cage(10, 6, 0.4)
    jet = osd_jets(mesh, [7], [0], [[0.3, 0.6]]).jets[0]
    normal = unit(np.cross(jet[1], jet[2]))
    goal = unit(unit(jet[1]) + 0.2 * np.cross(normal, unit(jet[1])))
    result = lib.minimize(mesh, levels=1, symmetry=NONE, through=lib.through(
        faces=[7], uv=[[0.3, 0.6]], normals=[normal], tangents=[goal], toward=[0], curvatures=[[0.5, 2]]))
    after = osd_jets(result.mesh, [7], [0], [[0.3, 0.6]]).jets
    assert np.linalg.norm(np.cross(unit(after[0, 1]), goal)) <= 1e-9
    assert np.abs(forms(after)[1] - tensors(normal[None], goal[None], np.array([[0.5, 2]]))).max() <= 1e-9


def test_one_of_two_pieces_has_curvatures():
    """Entries of the second piece alone, which is minimized as if the first were not there."""
    one, two = torus_cage(8, 5, 0.4), torus_cage(10, 6, 0.4)
    faces = one.face_list() + [[v + one.n_vertices for v in face] for face in two.face_list()]
    both = points.mesh_from_faces(np.vstack([one.xyz, two.xyz + [4, 0, 0]]), faces)
    at = dict(faces=[len(one.face_list()) + 7], uv=[[0.3, 0.6]])
    jets = osd_jets(both, at["faces"], [0], at["uv"]).jets
    normals, direction = forms(jets)[0], unit(jets[:, 1])
    result = lib.minimize(both, levels=1, symmetry=NONE, through=lib.through(
        **at, normals=normals, curvatures=[[0.25, 2]], curvature_directions=direction))
    found = forms(osd_jets(result.mesh, at["faces"], [0], at["uv"]).jets)[1]
    assert np.abs(found - tensors(normals, direction, np.array([[0.25, 2]]))).max() <= 1e-9 and result.verdict == "minimum"


@pytest.mark.parametrize("steps", [1, 3, 12])
def test_a_run_can_be_stopped_while_tangents_are_chosen(steps):
    mesh, seen = torus_cage(10, 6, 0.4), []
    jets = osd_jets(mesh, [7], [0], [[0.3, 0.6]]).jets
    through = lib.through(faces=[7], uv=[[0.3, 0.6]], normals=forms(jets)[0], curvatures=[[0.5, 2]],
                          curvature_directions=jets[:, 1])

    def stop(progress) -> bool:
        seen.append((progress.level, progress.iteration))
        return len(seen) == steps

    result = lib.minimize(mesh, "mvs", levels=2, symmetry=NONE, through=through, progress=stop)
    assert len(seen) == steps and result.stop == "cancelled" and np.isfinite(result.mesh.xyz).all()
    assert [number for _, number in seen] == sorted(number for _, number in seen)
    assert result.levels[0].iterations == steps - 1
    energy = lib.evaluate(result.mesh, "mvs").objective  # by other rules; the input's is half of that
    assert abs(result.summary.end.objective - energy) <= 1e-2 * energy


def test_the_choice_takes_half_of_any_number_of_steps():
    mesh = torus_cage(8, 5, 0.4)
    jets = osd_jets(mesh, [7], [0], [[0.3, 0.6]]).jets
    through = lib.through(faces=[7], uv=[[0.3, 0.6]], normals=forms(jets)[0], curvatures=[[0.5, 2]],
                          curvature_directions=jets[:, 1])
    default, most, four = (lib.minimize(mesh, levels=1, symmetry=NONE, through=through, **limit)
                           for limit in ({}, {"max_iterations": 2 ** 31 - 1}, {"max_iterations": 4}))
    assert np.array_equal(default.mesh.xyz, most.mesh.xyz) and default.levels[0].iterations == most.levels[0].iterations
    assert four.levels[0].iterations == 4 and four.stop == "limit"


def test_curvatures_that_make_it_cross_itself_are_refused():
    """A plane just above a plateau, as it is bent down to it; bent up it is not."""
    mesh, above = sheets(0.27), 81 + 40
    fields = dict(levels=1, boundary=1, no_crossings=1)
    held = lib.minimize(mesh, **fields, through=lib.through([above], normals=[[0, 0, 1]], curvatures=[[-16, -16]]))
    assert lib.crossings(held.mesh).n_pairs == 0 and held.verdict == "minimum"
    with pytest.raises(lib.CurvoptError, match="with the constraints at their places the surface crosses itself"):
        lib.minimize(mesh, **fields, through=lib.through([above], normals=[[0, 0, 1]], curvatures=[[16, 16]]))


# --------------------------------------------------------------------------------------------- what is refused --

IN_FACE = dict(faces=[3], uv=[[0.5, 0.5]], normals=[[0, 0, 1]])
REFUSED = {
    "no normal": (dict(faces=[3], uv=[[0.5, 0.5]], curvatures=[[1, 1]]), "entry 0 has curvatures, but no normal"),
    "not finite": (dict(IN_FACE, curvatures=[[1, np.inf]]), "entry 0 has the curvatures 1 and inf"),
    "one alone": (dict(IN_FACE, curvatures=[[1, NAN]]), "entry 0 has the curvatures 1 and nan"),
    "no direction": (dict(IN_FACE, curvatures=[[1, 2]]), "entry 0 has two curvatures, but no direction of the first one"),
    "of no length": (dict(IN_FACE, curvatures=[[1, 2]], curvature_directions=[[0, 0, 0]]),
                     "entry 0 has the direction of curvature 0 0 0"),
    "along the normal": (dict(IN_FACE, curvatures=[[1, 2]], curvature_directions=[[0, 0, 2]]),
                         "entry 0 has a direction of curvature that is not at right angles to its normal: the cosine is 1"),
    "twice": (dict(faces=[3, 3], uv=[[0.5, 0.5]] * 2, normals=[[0, 0, 1]] * 2, freedom=[FREE, FREE], curvatures=[[1, 1]] * 2),
              "entry [01]: its .* cannot be chosen freely beside entry [01]"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_bad_entries_are_refused_by_name(what):
    fields, sentence = REFUSED[what]
    with pytest.raises(lib.CurvoptError, match=sentence):
        lib.minimize(torus_cage(8, 8, 0.4), levels=1, through=lib.through(**fields))


def test_extraordinary_vertices_and_boundaries_have_no_curvatures():
    cube = points.shaken_cube()
    with pytest.raises(lib.CurvoptError, match="entry 0 holds curvatures at vertex 2: vertices have them only where four faces meet; "
                                               "take a point inside a face"):
        lib.minimize(cube, levels=1, through=lib.through([2], normals=[[1, 1, 1]], curvatures=[[1, 1]]))
    mesh = frames.open_net()
    rim = sorted(set(range(mesh.n_vertices)) - set(points.interior(mesh).tolist()))
    with pytest.raises(lib.CurvoptError, match=f"entry 0 holds a normal or tangent at vertex {rim[0]}, which is on a bound"):
        lib.minimize(mesh, levels=1, boundary=3, through=lib.through([rim[0]], normals=[[0, 0, 1]], curvatures=[[1, 1]]))


def test_entries_that_can_hardly_be_told_apart_are_refused_by_number():
    """Pivots are found for all 744 values, but their matrix is too near to a singular one."""
    mesh = sphere_like(12)
    faces = list(range(0, len(mesh.face_list()), 7))
    uv = [[0.4, 0.3]] * len(faces)
    normals = forms(osd_jets(mesh, faces, [0] * len(faces), uv).jets)[0]
    with pytest.raises(lib.CurvoptError, match="entry [0-9]+ and those that touch it hold [0-9]+ points, .* that cannot"):
        lib.minimize(mesh, levels=1, through=lib.through(faces=faces, uv=uv, normals=normals, curvatures=[[1, 1]] * len(faces)))


def test_callers_with_an_older_header_go_on():
    """Bytes beyond their struct are not read."""
    mesh = torus_cage(8, 5, 0.4)
    plain = lib.through([5])
    older = lib.through([5], curvatures=[[NAN, 7]])
    older.struct_size = 120
    found = [lib.minimize(mesh, levels=1, through=through).mesh.xyz for through in (plain, older)]
    assert np.array_equal(*found)


# ------------------------------------------------------------------------------------------ the command line --

def test_the_command_line_reads_them_from_json(tmp_path):
    """The same cage, bit by bit, as by the library."""
    mesh = torus_cage(8, 5, 0.4)
    cage, out, wanted = tmp_path / "cage.obj", tmp_path / "out.obj", tmp_path / "through.json"
    write_obj(cage, mesh)
    normal = np.round(unit(np.cross(*osd_jets(mesh, [30], [0], [[0.25, 0.5]]).jets[0, 1:3])), 6).tolist()
    entries = [{"face": 30, "uv": [0.25, 0.5], "at": "here", "normal": normal, "curvatures": [2, 2]},
               {"vertex": 11, "normal": [0, 0.25, 1], "curvatures": [0.5, 2], "curvature_direction": [1, 0, 0]}]
    wanted.write_text(json.dumps(entries))
    command = [lib.BUILD / "curvopt", "minimize", cage, "-o", out, "--levels", "2", "--through", wanted, "--quiet"]
    subprocess.run(command, check=True)
    result = lib.minimize(mesh, levels=2, through=lib.through(
        [-1, 11], [30, 0], uv=[[0.25, 0.5], [0, 0]], freedom=[HELD, FREE], normals=[normal, [0, 0.25, 1]],
        curvatures=[[2, 2], [0.5, 2]], curvature_directions=[[NAN] * 3, [1, 0, 0]]))
    assert np.array_equal(read_obj(out).xyz, result.mesh.xyz)


@pytest.mark.parametrize("entry, sentence", [
    ({"vertex": 1, "at": "here", "curvatures": [1, 1]}, 'entry 0, line 1: "curvatures" need a "normal"'),
    ({"vertex": 1, "normal": [0, 0, 1], "curvature_direction": [1, 0, 0]}, '"curvature_direction" needs "curvatures"'),
    ({"vertex": 1, "normal": [0, 0, 1], "curvatures": [1]}, '"curvatures" must be a list of two numbers')])
def test_the_command_line_refuses_by_name(tmp_path, entry, sentence):
    cage, wanted = write_obj(tmp_path / "cage.obj", torus_cage(8, 5, 0.4)), tmp_path / "through.json"
    wanted.write_text(json.dumps([entry]))
    run = subprocess.run([lib.BUILD / "curvopt", "minimize", cage, "-o", tmp_path / "out.obj", "--through", wanted],
                         capture_output=True, text=True)
    assert run.returncode and sentence in run.stderr

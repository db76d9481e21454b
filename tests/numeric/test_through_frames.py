# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of the surface at vertices and inside faces, with places, normals and tangents (curvopt_through): where OpenSubdiv
says that they are, on every level; minima that nothing else holds; what is refused, by name. With CURVOPT_LONG=1 ten
cages."""
from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

import lib
import test_through as points
from ccref import Mesh, mesh_from_faces
from nets import read_obj, sphere_like, torus_cage, write_obj
from osd import osd_jets

NONE = 1  # CURVOPT_SYMMETRY_NONE
HELD, LINE, PLANE, FREE = range(4)
SEEDS = (3, 4, 6, 7, 13, 15, 16, 17, 20, 22) if lib.LONG else (3, 4, 7, 17)
NAN = float("nan")


def unit(x: np.ndarray) -> np.ndarray:
    """Rows of length 1."""
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


class Places:
    """Some vertices and places inside faces of a cage, [n_v] and [n_f], and the same on subdivided ones."""

    def __init__(self, mesh: Mesh, random, part: int):
        inside = points.interior(mesh)
        faces = mesh.face_list()
        whole = [f for f, face in enumerate(faces) if set(face) <= set(inside.tolist())]
        self.mesh, self.vertices = mesh, random.choice(inside, max(2, len(inside) // part), replace=False)
        self.faces = random.choice(whole, max(1, len(whole) // part), replace=False)
        self.corners = np.array([0 if len(faces[f]) == 4 else random.integers(len(faces[f])) for f in self.faces])
        self.uv = random.uniform(0.1, 0.9, (len(self.faces), 2))
        self.n_v, self.n = len(self.vertices), len(self.vertices) + len(self.faces)

    def fields(self) -> dict:
        """Those of lib.through()."""
        pad = np.zeros(self.n_v, int)
        return dict(vertices=np.r_[self.vertices, -np.ones(len(self.faces), int)], faces=np.r_[pad, self.faces],
                    corners=np.r_[pad, self.corners], uv=np.r_[np.full((self.n_v, 2), NAN), self.uv])

    def on(self, levels: int):
        """Faces, corners and parameters on the cage subdivided levels - 1 times, by the definition of its children."""
        mesh, where = self.mesh, [(f, c, *uv) for f, c, uv in zip(self.faces, self.corners, self.uv)]
        for _ in range(levels - 1):
            sizes = [len(face) for face in mesh.face_list()]
            first = np.concatenate([[0], np.cumsum(sizes)])
            for i, (f, c, u, v) in enumerate(where):
                if sizes[f] == 4:
                    c, u, v = ((0, 2 * u, 2 * v) if u < 0.5 and v < 0.5 else (1, 2 * v, 2 - 2 * u) if v < 0.5 else
                               (2, 2 - 2 * u, 2 - 2 * v) if u >= 0.5 else (3, 2 - 2 * v, 2 * u))
                where[i] = (first[f] + c, 0, u, v)
            mesh = lib.refine(mesh)
        faces, corners, u, v = zip(*where)
        return faces, corners, np.column_stack([u, v])

    def look(self, mesh: Mesh, levels: int) -> tuple[np.ndarray, np.ndarray]:
        """Points and unit normals [n, 3] there, by OpenSubdiv."""
        found = osd_jets(mesh, *self.on(levels), level=10)
        normals = np.cross(found.jets[:, 1], found.jets[:, 2])
        return (np.r_[found.limit[self.vertices], found.jets[:, 0]],
                unit(np.r_[found.normal[self.vertices], normals]))


def wishes(where: Places, random) -> dict:
    """Mixed constraints near where the surface is: fields of lib.through()."""
    at, normals = where.look(where.mesh, 1)
    n, size = where.n, points.size(where.mesh)
    freedom = random.integers(0, 4, n)
    places = at + 0.01 * size * random.uniform(-1, 1, (n, 3))
    places[freedom == FREE] = NAN
    normals = unit(normals + 0.2 * random.normal(size=(n, 3)))
    normals[(random.uniform(size=n) < 0.3) & (freedom != FREE)] = NAN
    return dict(freedom=freedom, directions=unit(random.normal(size=(n, 3))), places=places, normals=normals)


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("seed", SEEDS)
def test_points_and_normals_are_where_they_are_to_be(seed, levels, capsys):
    random = np.random.default_rng(seed)
    mesh = points.corpus_cage(seed)
    where = Places(mesh, random, 12)
    wanted = wishes(where, random)
    energy = "mvs" if levels < 3 and seed % 2 else "willmore"
    result = lib.minimize(mesh, energy, levels=levels, symmetry=NONE, through=lib.through(**where.fields(), **wanted))
    at, normals = where.look(result.mesh, levels)
    held = wanted["freedom"] != FREE
    far = points.off((at - wanted["places"])[held], wanted["freedom"][held], wanted["directions"][held]).max()
    has = ~np.isnan(wanted["normals"][:, 0])
    askew = np.linalg.norm(np.cross(normals, wanted["normals"])[has], axis=1).max()
    with capsys.disabled():
        print(f"\n  seed {seed}, {levels} levels, {energy}, {where.n} entries: {result.summary.start.objective:.5g} -> "
              f"{result.summary.end.objective:.5g}, {result.verdict}, {result.summary.seconds:.2f} s; off by "
              f"{far / points.size(mesh):.1e}, normals by {askew:.1e}")
    assert far <= 1e-9 * points.size(mesh) and askew <= 1e-9 and result.verdict == "minimum"


# ---------------------------------------------------------------------------------------- tangents, by their masks --

def rings(mesh: Mesh, v: int, first: int) -> tuple[list[int], list[int]]:
    """Neighbours of a vertex inside a mesh of quads from `first` on, counterclockwise, and the vertices across faces."""
    step = {}
    for face in mesh.face_list():
        if v in face:
            at = face.index(v)
            step[face[(at + 1) % 4]] = (face[(at + 2) % 4], face[(at + 3) % 4])
    edges, across = [first], []
    for _ in step:
        across.append(step[edges[-1]][0])
        edges.append(step[edges[-1]][1])
    return edges[:-1], across


def tangent_masks(mesh: Mesh, v: int, first: int) -> np.ndarray:
    """Rows [2, n_vertices] of the limit's tangents along the edge to `first` and across (Halstead, Kass, DeRose 1993)."""
    edges, across = rings(mesh, v, first)
    turn = 2 * np.pi / len(edges)
    weight = 1 + np.cos(turn) + np.cos(turn / 2) * np.sqrt(2 * (9 + np.cos(turn)))
    out = np.zeros((2, mesh.n_vertices))
    for i, (e, f) in enumerate(zip(edges, across)):
        for row, wave in zip(out, (np.cos, np.sin)):
            row[e] += weight * wave(i * turn)
            row[f] += wave(i * turn) + wave((i + 1) * turn)
    return out


def neighbour_on(mesh: Mesh, v: int, w: int, levels: int) -> int:
    """The vertex next to v on the edge toward w after levels - 1 subdivisions."""
    for _ in range(levels - 1):
        edges: dict[tuple[int, int], int] = {}
        for face in mesh.face_list():
            for a, b in zip(face, face[1:] + face[:1]):
                edges.setdefault((min(a, b), max(a, b)), len(edges))
        fine = lib.refine(mesh)
        middles = [x for x in range(mesh.n_vertices, mesh.n_vertices + len(edges))
                   if any(v in face and x in face for face in fine.face_list())]
        near = [x for x in middles if any(w in face and x in face for face in fine.face_list())]
        assert len(near) == 1
        mesh, w = fine, near[0]
    return w


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("valence", [3, 4, 5])
def test_tangents_lie_along_their_directions(valence, levels):
    mesh = lib.refine(points.corpus_cage(13))
    faces = mesh.face_list()
    inside = set(points.interior(mesh).tolist())
    v = next(v for v in sorted(inside) if sum(v in face for face in faces) == valence)
    toward = next(face[(face.index(v) + 1) % 4] for face in faces if v in face)
    first = tangent_masks(mesh, v, toward) @ mesh.xyz
    normal = unit(np.cross(*first) + 0.3 * np.linalg.norm(np.cross(*first)) * np.random.default_rng(valence).normal(size=3))
    goal = unit(np.cross(normal, np.cross(first[0], normal)) + 0.3 * np.cross(normal, first[0]))
    result = lib.minimize(mesh, levels=levels, symmetry=NONE, through=lib.through(
        [v, v], freedom=[FREE, HELD], normals=[normal, [NAN] * 3], tangents=[goal, [NAN] * 3], toward=[toward, -1]))
    found = tangent_masks(result.mesh, v, neighbour_on(mesh, v, toward, levels)) @ result.mesh.xyz
    assert np.linalg.norm(np.cross(unit(found[0]), goal)) <= 1e-9
    assert abs(unit(found[1]) @ normal) <= 1e-9 and result.verdict == "minimum"
    assert np.abs(points.limits(result.mesh)[v] - points.limits(mesh)[v]).max() <= 1e-9


@pytest.mark.parametrize("along", [0, 1])
def test_tangents_inside_a_face_lie_along_their_directions(along):
    mesh = torus_cage(8, 5, 0.4)
    jet = osd_jets(mesh, [7], [0], [[0.3, 0.6]]).jets[0]
    goal = unit(jet[1 + along] + 0.4 * np.linalg.norm(jet[1 + along]) * np.array([1, 2, -1]) / 3)
    result = lib.minimize(mesh, "mvs", levels=1, through=lib.through(
        faces=[7], uv=[[0.3, 0.6]], freedom=[FREE], tangents=[goal], toward=[along]))
    found = osd_jets(result.mesh, [7], [0], [[0.3, 0.6]]).jets[0]
    assert np.linalg.norm(np.cross(unit(found[1 + along]), goal)) <= 1e-9


# ------------------------------------------------------------------------------------------- what holds a minimum --

@pytest.mark.parametrize("energy, most", [("willmore", 1e-4), ("mvs", 1e-2)])
def test_only_what_is_held_bears_the_gradient(energy, most, capsys):
    """The gradient of a minimum is a combination of the rows of what is held, in the directions in which it is held."""
    mesh = lib.refine(lib.refine(points.shaken_cube()))
    vertices, random = np.array([3, 20, 41]), np.random.default_rng(1)
    toward = [next(f[(f.index(v) + 1) % 4] for f in mesh.face_list() if v in f) for v in vertices]
    frames = [tangent_masks(mesh, v, w) for v, w in zip(vertices, toward)]
    normals = unit(unit(np.array([np.cross(*(rows @ mesh.xyz)) for rows in frames])) + 0.1)
    across = unit(random.normal(size=(3, 3)))
    places = points.limits(mesh)[vertices] * [[1.05], [1], [1]]
    result = lib.minimize(mesh, energy, levels=1, symmetry=NONE, spacing=2, tolerance=1e-7, decrement_tolerance=1e-13,
                          through=lib.through(vertices, freedom=[HELD, HELD, PLANE], normals=normals, places=places,
                                              directions=across))
    problem = lib.Problem(result.mesh, lib.options(energy, tolerance=1e-7))
    _, gradient = problem.evaluate(result.mesh.xyz, gradient=True)
    forces = [np.outer(row, normal) for rows, normal in zip(frames, normals) for row in rows]
    for mask, axes in zip(points.masks(mesh, vertices), (np.eye(3), np.eye(3), across[2:])):
        forces += [np.outer(mask, axis) for axis in axes]
    matrix = np.array([force.ravel() for force in forces]).T
    size, *_ = np.linalg.lstsq(matrix, gradient.ravel(), rcond=None)
    rest = np.linalg.norm(gradient.ravel() - matrix @ size) / np.linalg.norm(gradient)
    with capsys.disabled():
        print(f"\n  {energy}, {result.verdict}: of a gradient of {np.linalg.norm(gradient):.2g} {rest:.1e} is left")
    assert result.verdict == "minimum" and rest <= most and np.abs(size).min() > 1e-3 * np.abs(size).max()


def test_a_normal_far_from_the_surface_s_is_turned_to():
    """By 70 degrees, with its sign."""
    mesh = torus_cage(8, 5, 0.4)
    normal = points.limits(mesh)
    found = osd_jets(mesh, [0], [0], [[0.5, 0.5]]).normal[12]
    axis = unit(np.cross(found, [0.3, 0.5, 0.8]))
    goal = -(np.cos(1.22) * found + np.sin(1.22) * np.cross(axis, found))
    result = lib.minimize(mesh, levels=2, through=lib.through([12], normals=[goal]))
    after = osd_jets(result.mesh, [0], [0], [[0.5, 0.5]])
    assert np.linalg.norm(np.cross(after.normal[12], goal)) <= 1e-9
    assert np.abs(after.limit[12] - normal[12]).max() <= 1e-9 and result.verdict == "minimum"


def test_a_sphere_that_grows_is_no_hard_start():
    """Fourteen frames of the unit sphere, of a cage whose vertices are on it, and its surface a tenth inside: tangents have to
    grow with it. Were their lengths kept, this one began folded."""
    mesh = sphere_like(4)
    mesh = mesh_from_faces(unit(mesh.xyz), mesh.face_list())
    held = np.random.default_rng(47).choice(len(mesh.xyz), 14, replace=False)
    frames = lib.through(held, places=mesh.xyz[held], normals=mesh.xyz[held])
    result = lib.minimize(mesh, levels=1, symmetry=NONE, through=frames)
    assert result.verdict == "minimum" and 8 * np.pi <= result.summary.end.objective <= 8.02 * np.pi


def test_pins_and_points_can_be_held_together():
    """Vertices, limit points and frames that touch, by both structs."""
    mesh = torus_cage(10, 6, 0.4)
    at = points.limits(mesh)
    normals = osd_jets(mesh, [0], [0], [[0.5, 0.5]]).normal
    pins = lib.constraints([0, 1, 13], [points.LIMIT_POINT, 0, points.LIMIT_POINT + PLANE], [[0, 0, 1]] * 3)
    goal = unit(normals[[7, 30]] + 0.2)
    result = lib.minimize(mesh, levels=2, symmetry=NONE, constraints=pins,
                          through=lib.through([7, 30], places=at[[7, 30]] * 1.02, normals=goal))
    after, turned = points.limits(result.mesh), osd_jets(result.mesh, [0], [0], [[0.5, 0.5]]).normal
    assert np.abs(after[0] - at[0]).max() <= 1e-12 and np.array_equal(result.mesh.xyz[1], mesh.xyz[1])
    assert abs(after[13, 2] - at[13, 2]) <= 1e-12 and np.abs(after[[7, 30]] - at[[7, 30]] * 1.02).max() <= 1e-12
    assert np.linalg.norm(np.cross(turned[[7, 30]], goal), axis=1).max() <= 1e-12


# --------------------------------------------------------------------------------------------- what is refused --

def open_net() -> Mesh:
    """A torus without its last 8 faces."""
    mesh = torus_cage(8, 8, 0.4)
    return points.mesh_from_faces(mesh.xyz, [list(face) for face in mesh.face_list()[:-8]])


REFUSED = {
    "three frames in a row": (dict(vertices=[9, 17, 25], normals=[[1, 0, 0]] * 3), "entry .: its .* cannot be chosen freely"),
    "twice the same": (dict(vertices=[9, 9]), "entry 1: its point cannot be chosen freely beside entry 0"),
    "no vertex": (dict(vertices=[0, 64]), "entry 1 is at vertex 64; there are 64 vertices"),
    "no face": (dict(faces=[64], uv=[[0.5, 0.5]]), "entry 0 is on face 64; there are"),
    "outside a face": (dict(faces=[3], uv=[[0.5, 1.5]]), "entry 0 has u = 0.5, v = 1.5; they must be 0 to 1"),
    "no parameters": (dict(faces=[3]), "entry 0 has u = nan"),
    "at a corner": (dict(faces=[3], uv=[[1, 0]]), "entry 0, u = 1, v = 0 of face 3, is at a vertex"),
    "no such corner": (dict(faces=[3], corners=[1], uv=[[0.5, 0.5]]), "entry 0 is at corner 1 of face 3; it must be 0 to 0"),
    "not finite": (dict(vertices=[1], places=[[0, np.inf, 0]]), "entry 0 has the place 0 inf 0"),
    "no length": (dict(vertices=[1], normals=[[0, 0, 0]]), "entry 0 has the normal 0 0 0"),
    "no direction": (dict(vertices=[1], freedom=[LINE]), "entry 0 has no direction"),
    "freedom": (dict(vertices=[1], freedom=[4]), "entry 0 leaves its point 4 dimensions"),
    "place of a free point": (dict(vertices=[1], freedom=[FREE], places=[[0, 0, 0]]), "entry 0 has a place, but"),
    "nothing": (dict(vertices=[1], freedom=[FREE]), "entry 0 holds nothing"),
    "not at right angles": (dict(vertices=[1], normals=[[0, 0, 1]], tangents=[[1, 0, 1]], toward=[2]),
                            "entry 0 has a tangent that is not at right angles to its normal"),
    "no edge": (dict(vertices=[1], tangents=[[1, 0, 0]], toward=[30]), "tangent at vertex 1 toward 30, but no edge"),
    "no direction in a face": (dict(faces=[3], uv=[[0.5, 0.5]], tangents=[[1, 0, 0]], toward=[2]), "the tangent along 2"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_bad_entries_are_refused_by_name(what):
    fields, sentence = REFUSED[what]
    with pytest.raises(lib.CurvoptError, match=sentence):
        lib.minimize(torus_cage(8, 8, 0.4), levels=1, through=lib.through(**fields))


def test_normals_at_right_angles_are_refused():
    mesh = torus_cage(8, 8, 0.4)
    found = osd_jets(mesh, [0], [0], [[0.5, 0.5]]).normal[12]
    with pytest.raises(lib.CurvoptError, match="entry 0: the surface begins at right angles to the normal"):
        lib.minimize(mesh, levels=1, through=lib.through([12], normals=[np.cross(found, [1, 2, 3])]))


def test_boundaries_have_points_but_no_normals():
    mesh = open_net()
    rim = sorted(set(range(mesh.n_vertices)) - set(points.interior(mesh).tolist()))
    with pytest.raises(lib.CurvoptError, match=f"entry 0 holds a normal or tangent at vertex {rim[0]}, which is on a bound"):
        lib.minimize(mesh, levels=1, boundary=3, through=lib.through([rim[0]], normals=[[0, 0, 1]]))
    at = points.limits(mesh)[rim[0]] + [0.02, 0, 0.01]
    with pytest.raises(lib.CurvoptError, match="entry 0: nothing that its point depends on may move"):
        lib.minimize(mesh, levels=1, through=lib.through([rim[0]], places=[at]))  # the boundary is held
    result = lib.minimize(mesh, levels=2, boundary=3, through=lib.through([rim[0]], places=[at]))
    assert np.abs(points.limits(result.mesh)[rim[0]] - at).max() <= 1e-9


@pytest.mark.parametrize("levels", [1, 2])
def test_what_stands_on_a_held_boundary_is_no_reason_to_refuse(levels):
    """Points of a held boundary, where they are or in planes that they are in, beside one that is held."""
    mesh = open_net()
    inside = points.interior(mesh).tolist()
    rim = sorted(set(range(mesh.n_vertices)) - set(inside))
    at = points.limits(mesh)
    fields = dict(levels=levels, symmetry=1)  # points on one side of the mirror planes break them
    alone = lib.minimize(mesh, **fields, through=lib.through(inside[:1], places=[at[inside[0]]]))
    both = lib.minimize(
        mesh, **fields,
        through=lib.through([*rim[:3], inside[0]], places=at[[*rim[:3], inside[0]]], freedom=[0, 2, 1, 0],
                            directions=[[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 0, 1]]),
    )  # fmt: skip
    assert both.verdict == alone.verdict == "minimum"
    assert np.array_equal(both.mesh.xyz, alone.mesh.xyz)
    only = lib.minimize(mesh, **fields, through=lib.through(rim[:2]))
    assert only.verdict == "minimum" and np.array_equal(only.mesh.xyz, lib.minimize(mesh, **fields).mesh.xyz)


@pytest.mark.parametrize("fields, what", [(dict(strength=0.5), "a strength below 1"), (dict(within=0.1), "a distance")])
def test_options_that_stand_against_it_are_refused(fields, what):
    with pytest.raises(lib.CurvoptError, match=f"goes through cannot be had with {what}"):
        lib.minimize(torus_cage(8, 8, 0.4), levels=1, through=lib.through([1]), **fields)


# ------------------------------------------------------------------------------------------ the command line --

def test_the_command_line_reads_them_from_json(tmp_path):
    """The same cage, bit by bit, as by the library."""
    mesh = torus_cage(8, 5, 0.4)
    cage, out, wanted = tmp_path / "cage.obj", tmp_path / "out.obj", tmp_path / "through.json"
    write_obj(cage, mesh)
    entries = [{"vertex": 5, "at": [1, 0.5, 0.25], "normal": [0.5, 0.25, 1]},
               {"face": 30, "uv": [0.25, 0.5], "at": "here", "plane": [0, 0, 1]},
               {"vertex": 22, "line": [1, 0, 0.5], "tangent": {"to": 23, "along": [-0.25, -1, 0.5]}}]
    at = points.limits(mesh)
    entries[0]["at"] = np.round(at[5] * 1.01, 6).tolist()
    wanted.write_text(json.dumps(entries))
    subprocess.run([lib.BUILD / "curvopt", "minimize", cage, "-o", out, "--levels", "2", "--through", wanted, "--quiet"], check=True)
    nan = [NAN] * 3
    result = lib.minimize(mesh, levels=2, through=lib.through(
        [5, -1, 22], [0, 30, 0], uv=[[0, 0], [0.25, 0.5], [0, 0]], freedom=[HELD, PLANE, LINE],
        directions=[nan, [0, 0, 1], [1, 0, 0.5]], places=[entries[0]["at"], nan, nan], normals=[[0.5, 0.25, 1], nan, nan],
        tangents=[nan, nan, [-0.25, -1, 0.5]], toward=[0, 0, 23]))
    assert np.array_equal(read_obj(out).xyz, result.mesh.xyz)

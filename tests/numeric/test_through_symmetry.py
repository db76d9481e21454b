# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetries of cages that are kept with entries (curvopt_through): which they are, against motions that are tried one by one
here; that results are those without symmetries; that every entry is met, by OpenSubdiv. With CURVOPT_LONG=1 more random
orbits of entries."""
from __future__ import annotations

import itertools

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import torus_cage
from osd import osd_jets

NONE, HELD, PLANE, FREE = 1, 0, 2, 3
FREE_SPACING = 2
EXACT = dict(spacing=FREE_SPACING, decrement_tolerance=1e-13, tolerance=1e-9, max_iterations=2000)
NAN = float("nan")


def sphere() -> Mesh:
    """A cube, subdivided once."""
    grid = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return lib.refine(mesh_from_faces(grid, quads))


def motions(mesh: Mesh) -> list[tuple[np.ndarray, np.ndarray]]:
    """Orthogonal matrices about the origin that take the cage's vertices to vertices, and which to which: of those of a cube
    and of prisms of 8 and 9 corners."""
    tried = [np.eye(3)[list(order)] * np.array(signs)[:, None] for order in itertools.permutations(range(3))
             for signs in itertools.product((-1, 1), repeat=3)]
    for n in (8, 9):
        for k, mirror, up in itertools.product(range(n), (1, -1), (1, -1)):
            c, s = np.cos(2 * np.pi * k / n), np.sin(2 * np.pi * k / n)
            tried.append(np.array([[c, -s * mirror, 0], [s, c * mirror, 0], [0, 0, up]]))
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for matrix in tried:
        distance = np.linalg.norm((mesh.xyz @ matrix.T)[:, None] - mesh.xyz, axis=2)
        if distance.min(axis=1).max() < 1e-9 and not any(np.abs(matrix - other).max() < 1e-6 for other, _ in found):
            found.append((matrix, distance.argmin(axis=1)))
    return found


def oracle_order(mesh: Mesh, at: np.ndarray, fields: dict) -> int:
    """How many motions take entries at the limit points `at` [n, 3] of vertices to entries. Missing fields are alike."""
    n = len(at)
    place = fields.get("places", np.zeros((n, 3)))
    normal = fields.get("normals", np.zeros((n, 3)))
    count = 0
    for matrix, _ in motions(mesh):
        to = np.linalg.norm((at @ matrix.T)[:, None] - at, axis=2)
        k = to.argmin(axis=1)
        count += bool(to.min(axis=1).max() < 1e-6 and np.abs(place @ matrix.T - place[k]).max() < 1e-5
                      and np.linalg.norm(np.cross(normal @ matrix.T, normal[k]), axis=1).max() < 1e-5
                      and all(np.array_equal(np.asarray(fields[name])[k], fields[name])
                              for name in ("freedom", "weights") if name in fields))
    return count


def off(mesh: Mesh, vertices, fields: dict) -> float:
    """How far points and normals at vertices are from what is held exactly."""
    found = osd_jets(mesh, [0], [0], [[0.5, 0.5]], level=6)
    exact = np.asarray(fields.get("weights", np.ones(len(vertices)))) == 1
    moved = (found.limit[vertices] - fields["places"])[exact]
    most = 0.0
    if not exact.any():
        return most
    if "freedom" in fields:  # planes
        most = np.abs((moved * np.asarray(fields["directions"])[exact]).sum(axis=1)).max()
    else:
        most = np.abs(moved).max()
    if "normals" in fields:
        most = max(most, np.linalg.norm(np.cross(found.normal[vertices], fields["normals"])[exact], axis=1).max())
    return float(most)


def ball_entries() -> dict[str, tuple[list[int], dict]]:
    """On sphere(): vertices, and what is held there."""
    mesh = sphere()
    found = osd_jets(mesh, [0], [0], [[0.5, 0.5]])
    at, n = found.limit, found.limit / np.linalg.norm(found.limit, axis=1, keepdims=True)
    corners, four = list(range(8)), [0, 3, 5, 6]
    middles = [v for v in range(mesh.n_vertices) if (np.abs(at[v]) < 1e-9).sum() == 2]
    mixed = [2, 9, 17]
    return {
        "corners": (corners, dict(places=1.1 * at[corners])),
        "four corners, frames": (four, dict(places=1.1 * at[four], normals=n[four])),
        "two corners, frames": ([0, 7], dict(places=1.1 * at[[0, 7]], normals=n[[0, 7]])),
        "one corner, frame": ([0], dict(places=1.1 * at[[0]], normals=n[[0]])),
        "corners, soft frames": (corners, dict(places=1.1 * at[corners], normals=n[corners], weights=np.full(8, 0.9))),
        "corners, four of them soft": (corners, dict(places=1.05 * at[corners], weights=np.where(np.arange(8) % 3 == 0, 1, 0.9))),
        "six middles in planes": (middles, dict(places=1.03 * at[middles], directions=n[middles], freedom=np.full(6, PLANE))),
        "nothing symmetric": (mixed, dict(places=1.05 * at[mixed])),
    }


BALL = ball_entries()


@pytest.mark.parametrize("name", BALL)
def test_on_a_sphere_results_are_those_without_symmetries(name):
    mesh, (vertices, fields) = sphere(), BALL[name]
    at = osd_jets(mesh, [0], [0], [[0.5, 0.5]]).limit[vertices]
    kept, none = (lib.minimize(mesh, levels=1, symmetry=s, through=lib.through(vertices, **fields), **EXACT) for s in (0, NONE))
    assert none.summary.symmetry_order == 1
    assert kept.summary.symmetry_order == oracle_order(mesh, at, fields)
    energies = [r.summary.end.objective + r.summary.spring_energy for r in (kept, none)]
    assert abs(energies[0] / energies[1] - 1) <= 1e-9 and kept.verdict == none.verdict == "minimum"
    assert off(kept.mesh, vertices, fields) <= 1e-9 and off(none.mesh, vertices, fields) <= 1e-9


def spoiled() -> dict[str, tuple[list[int], dict]]:
    """Four corners, one of which is not as the others."""
    corners, fields = BALL["four corners, frames"]
    place, normal = fields["places"].copy(), fields["normals"].copy()
    place[3] *= 1.002
    normal[1] += [0.01, 0, 0]
    normal[1] /= np.linalg.norm(normal[1])
    soft = dict(weights=np.full(4, 0.9))
    return {"place": (corners, dict(fields, places=place)), "normal": (corners, dict(fields, normals=normal)),
            "soft place": (corners, dict(fields, **soft, places=place)), "soft normal": (corners, dict(fields, **soft, normals=normal)),
            "soft weight": (corners, dict(fields, weights=np.array([0.9, 0.8, 0.9, 0.9]))),
            "weight": (corners, dict(fields, weights=np.where(np.arange(4) == 2, 0.9, 1))),
            "three": (corners[:-1], {key: value[:-1] for key, value in fields.items()})}


@pytest.mark.parametrize("what", spoiled())
def test_an_entry_that_breaks_a_symmetry_takes_it_away(what):
    """By the order, by the entries, and by the energy, which symmetric cages do not have."""
    mesh, (vertices, fields) = sphere(), spoiled()[what]
    at = osd_jets(mesh, [0], [0], [[0.5, 0.5]]).limit[vertices]
    kept, none = (lib.minimize(mesh, levels=1, symmetry=s, through=lib.through(vertices, **fields), **EXACT) for s in (0, NONE))
    assert kept.summary.symmetry_order == oracle_order(mesh, at, fields) < 24
    assert off(kept.mesh, vertices, fields) <= 1e-9
    energies = [r.summary.end.objective + r.summary.spring_energy for r in (kept, none)]
    assert abs(energies[0] / energies[1] - 1) <= 1e-9


@pytest.mark.parametrize("symmetry, planes, order", [(2, 0, 12), (3, 0, 24), (4, 1, 2), (4, 7, 8), (4, 2, 2)],
                         ids=["rotations", "keep", "plane x", "three planes", "plane y"])
def test_symmetries_that_are_chosen_stay_with_entries(symmetry, planes, order):
    """Corners have all 48 motions, four of them 24, of which 12 turn; planes through the axes are those of all corners."""
    mesh = sphere()
    vertices, fields = BALL["corners" if planes else "four corners, frames"]
    result, none = (lib.minimize(mesh, levels=2, through=lib.through(vertices, **fields), tolerance=1e-8, **more)
                    for more in (dict(symmetry=symmetry, symmetry_planes=planes), dict(symmetry=NONE)))
    assert result.summary.symmetry_order == order and result.verdict == "minimum"
    assert off(result.mesh, vertices, fields) <= 1e-9
    assert result.summary.end.objective == pytest.approx(none.summary.end.objective, rel=1e-6)


def test_chosen_planes_that_entries_do_not_have_are_refused():
    mesh = sphere()
    vertices, fields = BALL["four corners, frames"]  # of a tetrahedron: symmetric about diagonal planes alone
    for places, why in ((fields["places"], "vertex 0 has no partner"), (None, "but not the directions .* or what the surface goes")):
        with pytest.raises(lib.CurvoptError, match=f"not symmetric about the plane x = 0: .*{why}"):
            lib.minimize(mesh, levels=1, symmetry=4, symmetry_planes=1, through=lib.through(vertices, places=places))
    edge = list(mesh.face_list()[0][:2])
    chains = [lib.chain(edge, osd_jets(mesh, [0], [0], [[0.5, 0.5]]).limit[edge])]
    with pytest.raises(lib.CurvoptError, match="chains that the surface goes through cannot be had with mirror planes"):
        lib.minimize(mesh, levels=1, symmetry=4, symmetry_planes=1, through=lib.through(chains=chains, chain_weights=[0.5]))


def outer_ring(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Its vertices in order; limit points and normals of all vertices."""
    found = osd_jets(mesh, [0], [0], [[0.5, 0.5]])
    radius = np.hypot(*found.limit[:, :2].T)
    return np.where(radius > radius.max() - 1e-9)[0], found.limit, found.normal


@pytest.mark.parametrize("step, frames, order", [(1, False, 32), (2, False, 16), (4, True, 8), (8, True, 4)])
def test_on_a_torus_symmetric_results_are_stationary_among_all(step, frames, order):
    """A torus has minima nearby that are less symmetric: what the run without symmetries is compared with begins where the
    other one ended."""
    mesh = torus_cage(8, 4, 0.4)
    ring, at, normal = outer_ring(mesh)
    held = ring[::step]
    fields = dict(places=at[held] * [1.03, 1.03, 1], **(dict(normals=normal[held]) if frames else {}))
    through = lib.through(held, **fields)
    kept = lib.minimize(mesh, levels=1, through=through, **EXACT)
    again = lib.minimize(kept.mesh, levels=1, symmetry=NONE, through=through, **EXACT)
    assert kept.summary.symmetry_order == order == oracle_order(mesh, at[held], fields)
    assert abs(again.summary.end.objective / kept.summary.end.objective - 1) <= 1e-9
    assert off(kept.mesh, held, fields) <= 1e-9
    two = lib.minimize(mesh, levels=2, through=through)
    assert two.summary.symmetry_order == order and off(two.mesh, held, fields) <= 1e-9 and two.verdict == "minimum"


def test_on_a_torus_with_its_spacing_results_are_stationary_among_all():
    """As above, with an even spacing, which has settled to a few 1e-6 of the energy."""
    mesh = torus_cage(8, 4, 0.4)
    ring, at, _ = outer_ring(mesh)
    through = lib.through(ring[::2], places=at[ring[::2]] * 1.03)
    kept = lib.minimize(mesh, levels=1, through=through)
    again = lib.minimize(kept.mesh, levels=1, symmetry=NONE, through=through)
    assert kept.summary.symmetry_order == 16
    assert abs(again.summary.end.objective / kept.summary.end.objective - 1) <= 5e-6
    assert np.abs(kept.mesh.xyz - again.mesh.xyz).max() <= 1e-3


def test_entries_that_are_symmetric_but_for_a_tolerance_are_met_exactly():
    """Places and normals in single precision, of a cage that is turned askew."""
    random = np.random.default_rng(0)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    mesh, (vertices, fields) = sphere(), BALL["four corners, frames"]
    askew = mesh_from_faces((mesh.xyz @ turn.T).astype(np.float32).astype(float), mesh.face_list())
    single = {key: (value @ turn.T).astype(np.float32).astype(float) for key, value in fields.items()}
    single["normals"] /= np.linalg.norm(single["normals"], axis=1, keepdims=True)
    for levels in (1, 2):
        result = lib.minimize(askew, levels=levels, through=lib.through(vertices, **single))
        assert result.summary.symmetry_order == 24 and off(result.mesh, vertices, single) <= 1e-9


# --------------------------------------------------------------------------------------------- random orbits --

CORNER = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
IN_FACES = np.array([[0.5, 0.5], [0.5, 0.2], [0.3, 0.3], [0.2, 0.6], [0, 0.4], [0.5, 0]])  # on mirror planes, edges, neither


def subgroup(mesh: Mesh, random) -> list[tuple[np.ndarray, np.ndarray]]:
    """That generated by up to three motions."""
    found = motions(mesh)
    chosen = [found[k] for k in random.integers(len(found), size=random.integers(1, 4))]
    group = [(np.eye(3), np.arange(mesh.n_vertices))]
    for matrix, image in group:
        for other, then in chosen:
            if not any(np.abs(other @ matrix - known).max() < 1e-6 for known, _ in group):
                group.append((other @ matrix, then[image]))
    return group


def where(mesh: Mesh, entry: dict) -> np.ndarray:
    """Point, tangents and unit normal of the surface at an entry [4, 3]; at vertices tangents are 0."""
    if entry["vertices"] >= 0:
        found = osd_jets(mesh, [0], [0], [[0.5, 0.5]], level=6)
        v = entry["vertices"]
        return np.array([found.limit[v], np.zeros(3), np.zeros(3), found.normal[v]])
    jets = osd_jets(mesh, [entry["faces"]], [0], [entry["uv"]], level=6).jets[0]
    normal = np.cross(jets[1], jets[2])
    return np.array([*jets[:3], normal / np.linalg.norm(normal)])


def image(mesh: Mesh, entry: dict, matrix: np.ndarray, to: np.ndarray) -> dict:
    """An entry moved."""
    out = dict(entry)
    for key in ("places", "directions", "normals", "tangents"):
        out[key] = matrix @ entry[key]
    if entry["vertices"] >= 0:
        out["vertices"], out["toward"] = to[entry["vertices"]], to[entry["toward"]]
        return out
    faces = [list(face) for face in mesh.face_list()]
    moved = [to[v] for v in faces[entry["faces"]]]
    out["faces"] = next(f for f, face in enumerate(faces) if set(face) == set(moved))
    origin, u, v = (CORNER[faces[out["faces"]].index(moved[k])] for k in (0, 1, 3))
    out["uv"] = origin + entry["uv"][0] * (u - origin) + entry["uv"][1] * (v - origin)
    along = (u, v)[entry["toward"]] - origin
    out["toward"] = int(abs(along[1]) > 0.5)
    return out


def orbit(mesh: Mesh, group, random, noise: float) -> list[dict]:
    """A random entry and its images, each place once. What stays where it is moves within its symmetry."""
    entry = dict(vertices=-1, faces=-1, uv=np.full(2, NAN), toward=0)
    faces = [list(face) for face in mesh.face_list()]
    if random.random() < 0.5:
        v = int(random.integers(mesh.n_vertices))
        entry.update(vertices=v, toward=next(face[(face.index(v) + 1) % 4] for face in faces if v in face))
    else:
        entry.update(faces=int(random.integers(mesh.n_faces)), uv=IN_FACES[random.integers(6)], toward=int(random.integers(2)))
    jet = where(mesh, entry)
    stays = [matrix for matrix, _ in group if np.linalg.norm(matrix @ jet[0] - jet[0]) < 1e-9]
    keep = sum(stays) / len(stays)
    normal = jet[3] + 0.15 * keep @ random.normal(size=3)
    normal /= np.linalg.norm(normal)
    tangent = jet[1 + entry["toward"]] if entry["vertices"] < 0 else mesh.xyz[entry["toward"]] - mesh.xyz[entry["vertices"]]
    tangent = tangent - (tangent @ normal) * normal
    direction = keep @ random.normal(size=3)
    direction = direction / np.linalg.norm(direction) if np.linalg.norm(direction) > 1e-6 else jet[3]
    kind = random.choice(["point", "frame", "normal", "line", "plane", "tangent"])
    entry.update(freedom=dict(normal=FREE, line=1, plane=2).get(kind, HELD), directions=direction,
                 places=jet[0] + 0.03 * keep @ random.normal(size=3) if kind != "normal" else np.full(3, NAN),
                 normals=normal if kind in ("frame", "normal", "tangent") else np.full(3, NAN),
                 tangents=tangent / np.linalg.norm(tangent) if kind == "tangent" else np.full(3, NAN))
    out: list[dict] = []
    for matrix, to in group:
        at = matrix @ jet[0]
        if not any(np.linalg.norm(at - other["at"]) < 1e-7 for other in out):
            out.append(dict(image(mesh, entry, matrix, to), at=at))
            out[-1]["places"] = out[-1]["places"] + noise * random.normal(size=3)
    return out


def violation(mesh: Mesh, entry: dict) -> float:
    point, *tangents, normal = where(mesh, entry)
    moved, direction, most = point - entry["places"], entry["directions"], 0.0
    if entry["freedom"] < FREE:
        most = (np.linalg.norm(moved), np.linalg.norm(np.cross(moved, direction)), abs(moved @ direction))[entry["freedom"]]
    if not np.isnan(entry["normals"][0]):
        most = max(most, np.linalg.norm(np.cross(normal, entry["normals"])))
    if not np.isnan(entry["tangents"][0]) and entry["vertices"] < 0:
        t = tangents[entry["toward"]]
        most = max(most, np.linalg.norm(np.cross(t, entry["tangents"])) / np.linalg.norm(t))
    return float(most)


def independent_orbit(mesh: Mesh, group: list, random: np.random.Generator, noise: float):
    """The first drawn orbit of entries that do not depend on each other, what the surface goes through, and the run. The others
    are refused, with and without symmetries."""
    for _ in range(50):
        entries = orbit(mesh, group, random, noise)
        through = lib.through(**{key: np.array([e[key] for e in entries]) for key in entries[0] if key != "at"})
        try:
            return entries, through, lib.minimize(mesh, levels=1, through=through, **EXACT)
        except lib.CurvoptError as error:
            assert "cannot be chosen freely" in str(error)
            with pytest.raises(lib.CurvoptError, match="cannot be chosen freely"):
                lib.minimize(mesh, levels=1, symmetry=NONE, through=through, **EXACT)
    raise AssertionError("of 50 orbits each depends on itself")


@pytest.mark.parametrize("seed", range(120) if lib.LONG else (0, 1, 2, 3, 5, 8, 11, 16))
@pytest.mark.parametrize("noise", (0, 1e-7))
def test_random_orbits_of_entries_keep_their_group(seed, noise):
    random = np.random.default_rng(seed)
    mesh = (torus_cage(8, 8, 0.4), sphere(), torus_cage(9, 6, 0.4))[seed % 3]
    group = subgroup(mesh, random)
    entries, through, kept = independent_orbit(mesh, group, random, noise)
    order = lib.minimize(mesh, levels=1, through=through, max_iterations=0).summary.symmetry_order
    assert 2 * order >= len(group)  # half, where each vertex near is on a mirror plane that the entry is not on
    assert max(violation(kept.mesh, entry) for entry in entries) <= 1e-9
    if noise == 0:  # a saddle that symmetry hides is left where noise shows the way
        again = lib.minimize(kept.mesh, levels=1, symmetry=NONE, through=through, **EXACT)
        assert again.summary.end.objective >= kept.summary.end.objective * (1 - 1e-7)

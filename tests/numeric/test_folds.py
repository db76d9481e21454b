# SPDX-License-Identifier: GPL-3.0-or-later
"""Folded cages: faces with a point without tangent plane, as OpenSubdiv finds them; and that runs from such cages end as
minima, from a cage whose moved vertices lie as a thin plate would."""
from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import lib
from ccref import Mesh, mesh_from_faces
from nets import cube_grid, torus_cage, write_obj
from osd import osd_jets

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import cages  # noqa: E402

GRID = 20  # points a side of a face from which points without tangent plane are looked for
STEPS = 30
SIZES = ((6, 4), (8, 4), (8, 6), (12, 6), (9, 5))


def exchanged(mesh: Mesh, face: int, other: int = 2) -> Mesh:
    """Two corners of a face have changed places: opposite ones, or (1) neighbours."""
    points, corners = mesh.xyz.copy(), mesh.face_list()[face]
    points[[corners[0], corners[other]]] = points[[corners[other], corners[0]]]
    return mesh_from_faces(points, mesh.face_list())


def dragged(mesh: Mesh, face: int, edges: float) -> Mesh:
    """A vertex dragged over its neighbour, and a little aside."""
    points, corners = mesh.xyz.copy(), mesh.face_list()[face]
    points[corners[0]] += edges * (points[corners[1]] - points[corners[0]]) + 0.3 * (points[corners[3]] - points[corners[0]])
    return mesh_from_faces(points, mesh.face_list())


def shaken(mesh: Mesh, edges: float, seed: int) -> Mesh:
    faces = mesh.face_list()
    edge = np.mean([np.linalg.norm(mesh.xyz[f[0]] - mesh.xyz[f[1]]) for f in faces])
    return mesh_from_faces(mesh.xyz + edges * edge * np.random.default_rng(seed).normal(size=mesh.xyz.shape) / 3**0.5, faces)


def without_tangent_plane(mesh: Mesh) -> tuple[set[int], set[int]]:
    """Faces, all of them quads, inside which S_u x S_v = 0 at a point, and on the edge of which it does: by Gauss and
    Newton's steps on OpenSubdiv's derivatives, from points of a grid at which it is less than at their neighbours."""
    at = (np.arange(GRID) + 0.5) / GRID
    u, v = (x.ravel() for x in np.meshgrid(at, at, indexing="ij"))
    n = mesh.n_faces
    faces = np.repeat(np.arange(n), GRID * GRID)
    jets = osd_jets(mesh, faces, 0 * faces, np.tile(np.stack([u, v], 1), (n, 1))).jets
    size = np.linalg.norm(np.cross(jets[:, 1], jets[:, 2]), axis=1).reshape(n, GRID, GRID)
    padded = np.pad(size, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    around = [padded[:, 1 + a : 1 + a + GRID, 1 + b : 1 + b + GRID] for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    low = (size <= np.min(around, axis=0)) & (size < 0.5 * size.mean((1, 2), keepdims=True))
    face, i, j = np.nonzero(low)
    uv = np.stack([at[i], at[j]], 1)
    if not len(face):
        return set(), set()
    for _ in range(STEPS):
        s = osd_jets(mesh, face, 0 * face, np.clip(uv, 1e-6, 1 - 1e-6)).jets
        value = np.cross(s[:, 1], s[:, 2])
        by = np.stack([np.cross(s[:, 3], s[:, 2]) + np.cross(s[:, 1], s[:, 4]),
                       np.cross(s[:, 4], s[:, 2]) + np.cross(s[:, 1], s[:, 5])], 2)
        step = np.stack([np.linalg.lstsq(b, -x, rcond=None)[0] for b, x in zip(by, value)])
        uv = np.clip(uv, 1e-6, 1 - 1e-6) + step * np.minimum(1, 0.1 / (np.linalg.norm(step, axis=1, keepdims=True) + 1e-30))
    inside = (uv > 1e-5).all(1) & (uv < 1 - 1e-5).all(1)
    relative = np.linalg.norm(value, axis=1) / (np.linalg.norm(s[:, 1], axis=1) * np.linalg.norm(s[:, 2], axis=1))
    on_edge = ~inside & (relative < 1e-4)  # the last points are at most 1e-6 inside
    return set(face[inside & (relative < 1e-9)].tolist()), set(face[on_edge].tolist())


def neighbours(mesh: Mesh, chosen: set[int]) -> set[int]:
    """Faces that have an edge in common with a chosen one."""
    edges = [{frozenset(e) for e in zip(f, f[1:] + f[:1])} for f in mesh.face_list()]
    return {g for g, own in enumerate(edges) if any(own & edges[f] for f in chosen)}


CASES = [(f"torus {n} x {m}, {what}", make) for n, m in SIZES for what, make in (
    ("as it is", lambda n=n, m=m: torus_cage(n, m, 0.4)), ("opposite", lambda n=n, m=m: exchanged(torus_cage(n, m, 0.4), 3)),
    ("neighbours", lambda n=n, m=m: exchanged(torus_cage(n, m, 0.4), 3, 1)), ("dragged", lambda n=n, m=m: dragged(torus_cage(n, m, 0.4), 3, 3.5)),
    ("shaken", lambda n=n, m=m: shaken(torus_cage(n, m, 0.4), 0.6, n)))] + [
    ("cube", lambda: exchanged(cube_grid(4), 20)), ("cube, pole", lambda: exchanged(cube_grid(3), 0)),
    ("cube, shaken", lambda: shaken(cube_grid(4), 0.7, 5))]


@pytest.mark.parametrize("name, make", CASES, ids=[name for name, _ in CASES])
def test_faces_are_those_of_opensubdiv(name, make):
    """And perhaps neighbours, where the point is less than an eighth of a face away from the edge."""
    mesh = make()
    found, (inside, on_edge) = set(lib.folds(mesh).tolist()), without_tangent_plane(mesh)
    assert inside <= found <= inside | on_edge | neighbours(mesh, inside | on_edge)
    assert len(found) <= 3 * len(inside | on_edge)  # three meet at a pole


def test_some_are_folded_and_some_are_not():
    found = [len(lib.folds(make())) for _, make in CASES]
    assert sum(n > 0 for n in found) >= 12 and sum(n == 0 for n in found) >= 8


@pytest.mark.parametrize("seed", range(0, 24))
def test_cages_of_the_corpus_are_not_folded(seed):
    xyz, faces, _ = cages.cage(seed)
    assert not len(lib.folds(mesh_from_faces(np.array(xyz), faces)))


def bending_left(mesh: Mesh, xyz: np.ndarray, free: np.ndarray) -> float:
    """The largest force on a free vertex of a thin plate: L^T L x, L x = x - mean of the neighbours."""
    faces, n = mesh.face_list(), mesh.n_vertices
    laplacian = np.zeros((n, n))
    for a, b in {(a, b) for f in faces for p, q in zip(f, f[1:] + f[:1]) for a, b in ((p, q), (q, p))}:
        laplacian[a, b] = 1
    laplacian = np.eye(n) - laplacian / laplacian.sum(1, keepdims=True)
    return float(np.abs((laplacian.T @ laplacian @ xyz)[free]).max())


def as_placed(xyz: np.ndarray, mesh: Mesh, folds: np.ndarray) -> np.ndarray:
    """Without what moves and scales the whole, which has the input's centroid and size: vertices of no folded face stayed."""
    stayed = np.setdiff1d(np.arange(mesh.n_vertices), [v for f in folds for v in mesh.face_list()[f]])
    a, b = xyz[stayed], mesh.xyz[stayed]
    scale = np.linalg.norm(b - b.mean(0)) / np.linalg.norm(a - a.mean(0))
    return (xyz - a.mean(0)) * scale + b.mean(0)


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
@pytest.mark.parametrize("name", [name for name, _ in CASES if name.endswith(("opposite", "dragged"))])
def test_runs_from_folded_cages_end_as_minima(name, energy):
    mesh, first = dict(CASES)[name](), []

    def watch(progress) -> bool:
        if not first:
            first.append(np.array([progress.xyz[i] for i in range(3 * mesh.n_vertices)]).reshape(-1, 3))
            assert progress.start_energy == pytest.approx(progress.energy, rel=0.05)
        return False

    folds = lib.folds(mesh)
    result = lib.minimize(mesh, energy, levels=2, progress=watch)
    assert result.verdict == "minimum" and result.summary.n_folded == (len(folds) if len(folds) else 0)
    moved = np.linalg.norm(as_placed(first[0], mesh, folds) - mesh.xyz, axis=1) > 1e-9
    assert moved.sum() == result.summary.n_unfolded and bool(moved.any()) == bool(len(folds))
    if len(folds):
        assert bending_left(mesh, first[0], moved) < 1e-8 and not len(lib.folds(mesh_from_faces(first[0], mesh.face_list())))
    if energy == "willmore":
        assert result.summary.end.objective < 1.003 * 8 * np.pi**2


@pytest.mark.parametrize("fields", [{"strength": 0.5}, {"within": 0.05}, {"joshi_sequin": 1}])
def test_what_stays_near_its_input_is_not_unfolded(fields):
    mesh = dragged(torus_cage(8, 6, 0.4), 3, 3.5)
    assert len(lib.folds(mesh))
    assert lib.minimize(mesh, "willmore", levels=1, max_iterations=3, **fields).summary.n_unfolded == 0


def test_command_line(tmp_path):
    """What people and programs are told, before and after; and of a fold that is held."""
    mesh = dragged(torus_cage(8, 6, 0.4), 3, 3.5)
    folds = lib.folds(mesh).tolist()
    found = lib.cli_evaluate(mesh)
    assert found["folded"] == folds and found["n_folded"] == len(folds) and "n_unfolded" not in found
    cage, out, report = write_obj(tmp_path / "cage.obj", mesh), tmp_path / "out.obj", tmp_path / "report.json"
    listed = " ".join(map(str, folds))
    assert f"{len(folds)} faces: {listed}; the surface has a point without a tangent plane" in lib.run_cli("evaluate", str(cage)).stdout
    run = lib.run_cli("minimize", str(cage), "-o", str(out), "--json", str(report), "--levels", "1")
    assert f"{len(folds)} faces: {listed}; first 2 vertices were put between their neighbours" in run.stdout
    found = json.loads(report.read_text())
    assert found["folded"] == folds and found["n_unfolded"] == 2 and found["verification"]["verdict"] == "minimum"
    pins = tmp_path / "pins.txt"
    pins.write_text("\n".join(map(str, sorted({v for f in folds for v in mesh.face_list()[f]}))) + "\n")
    run = lib.run_cli("minimize", str(cage), "-o", str(out), "--json", str(report), "--levels", "1", "--pin", str(pins))
    assert "move vertices back" in run.stdout
    found = json.loads(report.read_text())
    assert found["folded"] == folds and found["n_unfolded"] == 0

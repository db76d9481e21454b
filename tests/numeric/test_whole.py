# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of the whole surface that are held: closed minimizers of bending energy with a given volume and area against an
axisymmetric solver and closed forms that share no code with the library; volumes by OpenSubdiv; multipliers as slopes of
the least energy."""
from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import cyclides
import lib
import vesicle_branches
import vesicles
from ccref import Mesh, mesh_from_faces
from nets import on_profile, perturbed, read_obj, torus_cage
from osd import osd_jets

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))
import cages  # noqa: E402

NONE, KEEP = 1, 3  # curvopt_symmetry
FREE = 2  # curvopt_spacing
OBJ = lib.ROOT / "blend_files" / "obj"


def branches() -> dict[tuple[str, float], dict[str, float]]:
    """Rows of the axisymmetric solver's table (tests/oracle/vesicle_branches.py), by branch and reduced volume."""
    with open(Path(cyclides.__file__).with_name("vesicle_branches.csv"), newline="") as file:
        return {(row["branch"], float(row["v"])): {key: float(row[key]) for key in ("W", "intH_over_sqrtA", "pressure_p")}
                for row in csv.DictReader(file)}


def stretched(mesh: Mesh, factor: float) -> Mesh:
    return mesh_from_faces(mesh.xyz * [1, 1, factor], mesh.face_list())


def reduced_volume(energies: lib.Energies) -> float:
    return 6 * math.sqrt(math.pi) * energies.volume / energies.area ** 1.5


def vesicle(branch: str, v: float, levels: int, **fields) -> lib.Result:
    """From a sphere's cage of 98 vertices, drawn long or pressed flat."""
    mesh = stretched(read_obj(OBJ / "sphere_cube.obj"), {"prolate": 2.2, "oblate": 0.45}[branch])
    return lib.minimize(mesh, "mean_curvature", levels=levels, hold={"volume": ("reduced", v)}, **fields)


# ------------------------------------------------------------------------------------------ known minimizers --


@pytest.mark.parametrize("branch, v", [("prolate", 0.95), ("prolate", 0.8), ("prolate", 0.65), ("oblate", 0.9),
                                       ("oblate", 0.75), ("oblate", 0.65)])
def test_spheres_with_less_volume(branch, v):
    """Bending energy of prolate and oblate shapes. Symmetries are kept: without them oblate shapes of much volume are
    saddles. Nothing may lie below; the order is that of the discretization."""
    known, errors = branches()[branch, v], []
    for levels in (1, 2, 3):
        result = vesicle(branch, v, levels, symmetry=KEEP)
        assert result.verdict == "minimum"
        assert abs(reduced_volume(result.summary.end) / v - 1) < 1e-11
        errors.append(result.summary.end.h2 / known["W"] - 1)
        mean = result.summary.end.total_mean_curvature / math.sqrt(result.summary.end.area)
        assert abs(mean / known["intH_over_sqrtA"] - 1) < 1e-4 / 8 ** (levels - 2)  # which nothing holds
    assert errors[0] < 1e-3 and errors[1] < 8e-5 and errors[2] < 1e-5
    assert all(error > -1e-9 for error in errors)
    assert 4 < errors[0] / errors[1] < 40 and 4 < errors[1] / errors[2] < 40
    slope = -known["pressure_p"] * 4 / 3 * math.pi  # of W by v, at the area 4 pi
    assert abs(result.summary.multiplier[0] / slope - 1) < 1e-4


AT_TWELVE_VOLUMES = [row for row in branches() if row[0] in ("prolate", "oblate") and row[1] >= 0.4]


@pytest.mark.parametrize("branch, v", AT_TWELVE_VOLUMES if lib.LONG else [("prolate", 0.4), ("prolate", 0.98), ("oblate", 0.5)])
def test_spheres_at_twelve_volumes(branch, v):
    """Long thin ones need a level more."""
    result = vesicle(branch, v, 5 if branch == "prolate" and v <= 0.5 else 4, symmetry=KEEP, tolerance=1e-7)
    assert result.verdict == "minimum"
    assert -1e-9 < result.summary.end.h2 / branches()[branch, v]["W"] - 1 < 1e-5


@pytest.fixture(scope="module")
def cup() -> vesicles.Shape:
    """A stomatocyte by the axisymmetric solver, at v = 0.54."""
    oblate = vesicle_branches.simple_branch(-1.0, np.array([0.51]), 48)[0]
    return vesicle_branches.at_volume(vesicle_branches.stomatocyte_start(oblate, 48)[1], 0.54, 64)


@pytest.mark.parametrize("v", sorted(v for branch, v in branches() if branch == "stomatocyte" and v <= 0.65)
                         if lib.LONG else [0.6, 0.5])
def test_stomatocytes(cup, v):
    """From 98 vertices on the stomatocyte of v = 0.54, most where it turns, to others. Their necks want faces, which an even
    spacing takes from them: so the spacing is free."""
    t, r, z = cup.profile()
    turning = np.cumsum(np.sqrt(cup.ends[:, vesicles.U] ** 2 + 1) * np.gradient(t))
    mesh = on_profile(read_obj(OBJ / "sphere_cube.obj"), turning, r, z)
    known, errors = branches()["stomatocyte", v], []
    for levels in (2, 3, 4):
        result = lib.minimize(mesh, "mean_curvature", levels=levels, symmetry=KEEP, spacing=FREE,
                              hold={"volume": ("reduced", v)})
        assert abs(reduced_volume(result.summary.end) / v - 1) < 1e-10
        errors.append(result.summary.end.h2 / known["W"] - 1)
    assert all(error > -1e-9 for error in errors)
    assert errors[0] < 3e-4 and errors[0] > 2 * errors[1] > 4 * errors[2] and errors[2] < 1e-5, errors
    mean = result.summary.end.total_mean_curvature / math.sqrt(result.summary.end.area)
    assert abs(mean / known["intH_over_sqrtA"] - 1) < 5e-3  # soft: what changes it costs little


def test_the_picture_of_the_branches(cup, monkeypatch):
    """blend_files/phase_diagram.py, with one shape a branch and one level."""
    monkeypatch.setenv("CURVOPT_LIBRARY", str(lib.BUILD / "libcurvopt.so"))
    monkeypatch.syspath_prepend(str(lib.ROOT / "blend_files"))
    import phase_diagram

    monkeypatch.setattr(phase_diagram, "LEVELS", 1)
    shapes = {"stomatocyte": [cup, cup]}
    found = phase_diagram.dots(shapes, {"stomatocyte": [0.5]})
    (volume, energy), = found["stomatocyte"]
    assert volume == 0.5 and 0 < energy * 4 * math.pi / branches()["stomatocyte", 0.5]["W"] - 1 < 5e-3
    picture = phase_diagram.diagram(shapes, found)
    assert picture.startswith("<svg") and picture.count("<circle") == 2 and "stomatocyte, curvopt" in picture


@pytest.mark.parametrize("v", [0.74, 0.82, 0.9, 0.96] if lib.LONG else [0.74, 0.9])
def test_tori_with_more_volume_are_cyclides(v):
    """Moebius images of Clifford's torus: 2 pi^2 for every volume between that torus' and a sphere's. The run starts at a
    torus and has to leave its symmetry."""
    known = cyclides.willmore_cyclide(v)
    errors = []
    for levels in (1, 2, 3):
        result = lib.minimize(torus_cage(10, 6, 0.5), "mean_curvature", levels=levels, symmetry=NONE, tolerance=1e-6,
                              hold={"volume": ("reduced", v)})
        assert abs(reduced_volume(result.summary.end) / v - 1) < 1e-11
        errors.append(result.summary.end.h2 / (2 * math.pi ** 2) - 1)
    mean = result.summary.end.total_mean_curvature / math.sqrt(result.summary.end.area)
    assert abs(mean / (known.total_mean_curvature() / math.sqrt(known.area())) - 1) < 1e-3
    assert all(error > -1e-9 for error in errors) and errors[2] < 2e-4
    assert errors[0] > errors[1] > errors[2]


@pytest.mark.parametrize("v", cyclides.VOLUMES if lib.LONG else [0.72, 0.98])
def test_tori_of_ten_volumes(v):
    """From 64 vertices on the cyclide of v = 0.85, on four levels."""
    angle = np.arange(8) * math.pi / 4
    points = cyclides.willmore_cyclide(0.85).position(*np.meshgrid(angle, angle, indexing="ij")).reshape(-1, 3)
    result = lib.minimize(torus_cage(8, 8, 0.5).with_xyz(points), "mean_curvature", levels=4, symmetry=KEEP, tolerance=1e-7,
                          hold={"volume": ("reduced", v), "area": 4 * math.pi})
    assert result.verdict == "minimum"
    assert -1e-9 < result.summary.end.h2 / (2 * math.pi ** 2) - 1 < 1e-5
    check_is_cyclide(result, v)


@pytest.mark.parametrize("v", cyclides.VOLUMES if lib.LONG else [0.75])
def test_cyclides_point_by_point(v):
    """From a shaken torus, on four levels, without symmetries."""
    result = lib.minimize(perturbed(torus_cage(8, 8, 0.6), 0.1, 1), "mean_curvature", levels=4, symmetry=NONE,
                          hold={"volume": ("reduced", v), "area": 4 * math.pi})
    assert result.verdict == "minimum"
    assert -1e-9 < result.summary.end.h2 / (2 * math.pi ** 2) - 1 < 1e-4
    check_is_cyclide(result, v)


def check_is_cyclide(result, v):
    """Limit points are near the cyclide of that volume, in the pose that fits best, and no point of the cyclide is far from
    all of them."""
    faces = range(result.mesh.n_faces)
    points = lib.jets(result.mesh, faces, np.zeros(len(faces)), np.full((len(faces), 2), 0.5))[:, 0]
    size = np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())
    known = cyclides.fitted(points, v)
    assert known.distance(points).max() < 1e-3 * size
    angle = np.linspace(0, 2 * math.pi, 60, endpoint=False)
    grid = known.position(*np.meshgrid(angle, angle)).reshape(-1, 3)
    assert cKDTree(points).query(grid)[0].max() < 0.1 * size


# ------------------------------------------------------------------------------------------- any cage, anything held --


def corpus_cage(seed: int) -> Mesh:
    points, faces, _ = cages.cage(seed)
    return mesh_from_faces(points, [list(face) for face in faces])


def volume_by_osd(mesh: Mesh) -> float:
    """Of polyhedra with corners on the limit surface, by OpenSubdiv, from two of them extrapolated."""
    found = []
    for _ in range(4):
        mesh = lib.refine(mesh)
        corners = osd_jets(mesh, [0], [0], [[0.5, 0.5]], level=2).limit
        quads = np.array(mesh.face_list())
        a, b, c, d = (corners[quads[:, k]] for k in range(4))
        found.append(sum(np.einsum("ij,ij->", p, np.cross(q, r)) for p, q, r in ((a, b, c), (a, c, d))) / 6)
    return (4 * found[-1] - found[-2]) / 3


def is_closed(seed: int) -> bool:
    return math.isfinite(lib.evaluate(corpus_cage(seed)).volume)


@pytest.mark.parametrize("seed", filter(is_closed, range(60)) if lib.LONG else (3, 4, 9))
@pytest.mark.parametrize("kind", ["pins", "strength"])
def test_volume_stays_by_opensubdiv(seed, kind):
    mesh = corpus_cage(seed)
    fields = {"strength": 0.5} if kind == "strength" else {
        "constraints": lib.constraints(np.random.default_rng(seed).choice(mesh.n_vertices, 4, replace=False))}
    before = volume_by_osd(mesh)
    kept = lib.minimize(mesh, levels=2, hold={"volume": "keep"}, **fields)
    assert abs(kept.summary.scalar_residual[0]) < 1e-11
    assert abs(kept.summary.end.volume / kept.summary.start.volume - 1) < 1e-11
    assert abs(volume_by_osd(kept.mesh) / before - 1) < 3e-5


def test_multiplier_is_the_slope_of_the_least_energy():
    """Of Willmore's energy with seven pins, by volume and by area, against differences of minima."""
    mesh = torus_cage(8, 6, 0.45)
    pins = lib.constraints([0, 5, 11, 16, 22, 29, 40])  # with four, nearly nothing holds the size: no slope to speak of
    start = lib.minimize(mesh, levels=1, constraints=pins, max_iterations=0).summary.start
    for name, number in (("volume", 1.2 * start.volume), ("area", 1.2 * start.area),
                         ("total_mean_curvature", 1.1 * start.total_mean_curvature)):
        step, cage, energy = 2e-3 * number, mesh, {}
        for at in (0, -1, 1):
            result = lib.minimize(cage, levels=1, constraints=pins, tolerance=1e-8, decrement_tolerance=1e-12,
                                  spacing=FREE, hold={name: number + at * step})
            assert result.verdict == "minimum"
            energy[at] = result.summary.end.objective
            if at == 0:
                slope = result.summary.multiplier[lib.SCALARS.index(name)]
                cage = result.mesh  # the branch that was found: a free net has others, at other energies
        assert abs(slope / ((energy[1] - energy[-1]) / (2 * step)) - 1) < 2e-3, name


def test_size_alone_costs_nothing():
    """Where nothing else is held a volume sets the size of the same shape."""
    mesh = torus_cage(8, 6, 0.45)
    plain = lib.minimize(mesh, levels=1)
    for hold in ({"volume": 7.0}, {"total_mean_curvature": 9.0}, {"area": 3.0}):
        held = lib.minimize(mesh, levels=1, hold=hold)
        (name, value), = hold.items()
        assert abs(getattr(held.summary.end, name) / value - 1) < 1e-11
        assert abs(held.summary.end.objective / plain.summary.end.objective - 1) < 1e-9
        assert not any(held.summary.multiplier) and not any(held.summary.scalar_residual)


def test_normals_that_point_inwards():
    """Volume and mean curvature then count negative, and the shape is the same."""
    mesh = stretched(read_obj(OBJ / "sphere_cube.obj"), 2.2)
    inward = mesh_from_faces(mesh.xyz, [face[::-1] for face in mesh.face_list()])
    out, other = (lib.minimize(m, "mean_curvature", levels=1, symmetry=NONE, spacing=FREE, decrement_tolerance=1e-12,
                               hold={"volume": ("reduced", 0.8)}) for m in (mesh, inward))
    assert abs(out.summary.end.objective / other.summary.end.objective - 1) < 1e-9
    assert out.summary.end.volume > 0 > other.summary.end.volume


def test_threads_do_not_matter():
    mesh = corpus_cage(4)
    one, two = (lib.minimize(mesh, "mvs", levels=1, threads=n, hold={"volume": "keep", "area": "keep"}) for n in (1, 2))
    assert np.array_equal(one.mesh.xyz, two.mesh.xyz)


# --------------------------------------------------------------------------------------------------- refusals --

CUBE = stretched(read_obj(OBJ / "sphere_cube.obj"), 1.0)
OPEN = read_obj(OBJ / "branch_open.obj")


@pytest.mark.parametrize("mesh, fields, words", [
    (CUBE, {"hold": {"volume": 100.0, "area": 1.0}}, "does not fit into an area of 1"),
    (CUBE, {"hold": {"volume": ("reduced", 1.2)}}, "more than the sphere's"),
    (CUBE, {"hold": {"volume": -1.0}}, "must be positive"),
    (CUBE, {"hold": {"volume": math.nan}}, "must be positive"),
    (CUBE, {"hold": {"area": ("reduced", 0.5)}}, "must be 0 to 2"),
    (CUBE, {"hold": {"volume": "keep"}, "joshi_sequin": 1}, "holds no scalar"),
    (OPEN, {"hold": {"volume": 1.0}}, "not closed"),
    (OPEN, {"hold": {"volume": ("reduced", 0.5)}}, "not closed"),
    (OPEN, {"hold": {"volume": "keep"}, "boundary": 3}, "boundary may move"),
])
def test_refused(mesh, fields, words):
    with pytest.raises(lib.CurvoptError, match=words):
        lib.minimize(mesh, levels=1, **fields)


def test_what_cannot_be_reached_is_said():
    """All but one vertex of a torus are held: the volume comes as near as that one lets it, and that is no minimum."""
    mesh = torus_cage(8, 6, 0.45)
    result = lib.minimize(mesh, levels=1, constraints=lib.constraints(range(1, mesh.n_vertices)), hold={"volume": 30.0})
    assert result.verdict == "not stationary"
    assert result.summary.scalar_residual[0] < -0.01
    assert math.isfinite(result.summary.end.objective)


def test_the_command_line_says_what_was_not_kept(tmp_path):
    """Within a hundredth the cube's volume cannot be 20; one that can be held is not spoken of."""
    cage, options = str(OBJ / "sphere_cube.obj"), ("-o", str(tmp_path / "out.obj"), "--levels", "1")
    missed = lib.run_cli("minimize", cage, *options, "--within", "0.01", "--volume", "20")
    assert missed.returncode == 0
    (line,) = (line for line in missed.stdout.splitlines() if line.startswith("not kept"))
    assert "volume" in line and "% less than it was to be" in line
    assert "not kept" not in lib.run_cli("minimize", cage, *options, "--volume", "20").stdout

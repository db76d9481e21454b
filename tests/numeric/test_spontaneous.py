# SPDX-License-Identifier: GPL-3.0-or-later
"""Spontaneous curvature: Helfrich's energy of tori and spheres by closed forms, its gradient by differences, vesicles
against an axisymmetric solver that shares no code with the library, certificates by dense linear algebra."""
from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

import cyclides
import lib
from ccref import Mesh, mesh_from_faces
from nets import periodic_net, read_obj, sphere_like, torus, torus_cage

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))
import cages  # noqa: E402

NONE, KEEP = 1, 3  # curvopt_symmetry
FREE = 2  # curvopt_spacing
SPHERE = read_obj(lib.ROOT / "blend_files" / "obj" / "sphere_cube.obj")
AREA = 4 * math.pi
VOLUME_INDEX, AREA_INDEX = lib.SCALARS.index("volume"), lib.SCALARS.index("area")
FORM = {"prolate": 2.2, "oblate": 0.45}


def stretched(mesh: Mesh, factor: float) -> Mesh:
    return mesh_from_faces(mesh.xyz * [1, 1, factor], mesh.face_list())


def inside_out(mesh: Mesh) -> Mesh:
    return mesh_from_faces(mesh.xyz, [face[::-1] for face in mesh.face_list()])


def size(mesh: Mesh) -> float:
    return float(np.sqrt(((mesh.xyz - mesh.xyz.mean(axis=0)) ** 2).sum(axis=1).mean()))


# -------------------------------------------------------------------------------------------------- closed forms --


def torus_helfrich(rho: float, c0: float) -> float:
    """int (k1 + k2 - c0)^2 dA of a torus of radii 1 and rho, by the trapezoidal rule."""
    angle = 2 * np.pi * np.arange(400) / 400
    out = 1 + rho * np.cos(angle)
    return float(np.sum((1 / rho + np.cos(angle) / out - c0) ** 2 * rho * out) * (2 * np.pi) ** 2 / 400)


@pytest.mark.parametrize("c0", [1.3, -0.8])
def test_tori_have_the_closed_form(c0):
    """Through nets that interpolate them: the error falls as h^4. Turned inside out they have the same energy."""
    known, errors = torus_helfrich(0.5, c0), []
    for n in (16, 32, 64):
        mesh = periodic_net(torus(0.5), n, n)
        got = lib.evaluate(mesh, surface="limit", tolerance=1e-9, spontaneous_curvature=c0)
        errors.append(got.helfrich / known - 1)
        assert got.objective == pytest.approx(got.helfrich - 2 * got.gauss, rel=1e-12)
        other = lib.evaluate(inside_out(mesh), surface="limit", tolerance=1e-9, spontaneous_curvature=c0)
        assert other.helfrich == pytest.approx(got.helfrich, rel=1e-9)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert 3.8 < orders[1] < 4.5 and abs(errors[2]) < 1e-5, errors


@pytest.mark.parametrize("weights", [{"willmore": 1.0}, {"mean_curvature": 1.0},
                                     {"willmore": 0.3, "mean_curvature": 0.5, "mvs": 0.01}])
@pytest.mark.parametrize("c0", [0.7, -1.3])
def test_gradient_against_differences(weights, c0):
    """In random directions, along scaling, which the energy sees, and along a translation, which it does not."""
    random = np.random.default_rng(1)
    mesh = mesh_from_faces(3 * SPHERE.xyz + 0.1 * random.standard_normal(SPHERE.xyz.shape) + [1, 2, 3],
                           SPHERE.face_list())
    for cage in (mesh, inside_out(mesh), stretched(torus_cage(7, 5, 0.4), 1.7)):
        problem = lib.Problem(cage, lib.options(weights, spontaneous_curvature=c0))
        found, gradient = problem.evaluate(cage.xyz, gradient=True)
        plain = sum(weight * found.value(name) for name, weight in weights.items())
        outwards = math.copysign(1, found.volume)
        bending = 4 * weights.get("willmore", 0) + weights.get("mean_curvature", 0)
        assert found.objective == pytest.approx(
            plain + bending * (c0 ** 2 / 4 * found.area - c0 * outwards * found.total_mean_curvature), rel=1e-12)
        for way in (random.standard_normal(cage.xyz.shape), cage.xyz - cage.xyz.mean(axis=0), np.ones_like(cage.xyz)):
            step = 1e-4
            at = [problem.evaluate(cage.xyz + k * step * way).objective for k in (-2, -1, 1, 2)]
            slope = (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step)
            assert abs((gradient * way).sum() - slope) < 1e-6 * np.linalg.norm(gradient) * np.linalg.norm(way)


@pytest.mark.parametrize("seed", range(40) if lib.LONG else (1, 6, 11))
@pytest.mark.parametrize("c0", [-8.0, 3.0, 30.0])
def test_claimed_errors_hold(seed, c0):
    """Of corpus cages; the tolerance is relative to the objective plus 2 c0^2 times the area."""
    points, faces, _ = cages.cage(seed)
    mesh = mesh_from_faces(points, [list(face) for face in faces])
    rough, fine = (lib.evaluate(mesh, surface="limit", spontaneous_curvature=c0 / size(mesh), tolerance=tolerance)
                   for tolerance in (1e-4, 1e-8))
    off = abs(rough.objective - fine.objective)
    assert off <= rough.objective_error and off <= 1e-4 * (fine.objective + 2 * (c0 / size(mesh)) ** 2 * fine.area)


@pytest.mark.parametrize("c0", [0.5, 2.0, 4.0, -1.0])
@pytest.mark.parametrize("radius", [1.0, 3.0])
def test_spheres(c0, radius):
    """4 pi (2 - c0 R)^2, a fourth of it for int (H - c0 / 2)^2 dA. What it costs to make the area larger is known, too."""
    c0, errors = c0 / radius, []
    for levels in (1, 2, 3):
        result = lib.minimize(SPHERE, "mean_curvature", levels=levels, spontaneous_curvature=c0,
                              hold={"area": AREA * radius ** 2})
        end = result.summary.end
        assert result.verdict == "minimum" and result.stop in ("converged", "stalled", "settled")
        assert end.helfrich == pytest.approx(4 * end.objective, abs=1e-10)
        errors.append(end.objective - math.pi * (2 - c0 * radius) ** 2)
    assert all(error > -1e-9 for error in errors)
    assert errors[0] < 0.02 and 4 < errors[0] / errors[1] < 40 and 4 < errors[1] / errors[2] < 40
    assert result.summary.multiplier[AREA_INDEX] == pytest.approx(-c0 * (2 - c0 * radius) / (4 * radius), abs=1e-5)


def test_an_open_surface_becomes_a_cylinder():
    """Between two held circles of radius 1 int (H - 1/2)^2 dA goes to 0 where the faces run outwards round the cylinder."""
    left = []
    for n in (8, 16, 32):
        angle, height = 2 * np.pi * np.arange(n) / n, np.linspace(-0.7, 0.7, n // 2 + 1)
        to_circle = np.linalg.inv((np.roll(np.eye(n), 1, 0) + 4 * np.eye(n) + np.roll(np.eye(n), -1, 0)) / 6)
        circle = to_circle @ np.stack([np.cos(angle), np.sin(angle)], -1)
        wide = 1 + 0.3 * np.cos(np.pi * height / 1.4)
        points = [[x * w, y * w, z] for z, w in zip(height, wide) for x, y in circle]
        faces = [[j * n + i, j * n + (i + 1) % n, (j + 1) * n + (i + 1) % n, (j + 1) * n + i]
                 for j in range(n // 2) for i in range(n)]
        result = lib.minimize(mesh_from_faces(np.array(points), faces), "mean_curvature", levels=1, boundary=0,
                              spontaneous_curvature=1.0)
        assert result.verdict == "minimum"
        left.append(result.summary.end.objective)
        at = lib.jets(result.mesh, range(len(faces)), np.zeros(len(faces)), np.full((len(faces), 2), 0.5))[:, 0]
    assert np.abs(np.hypot(at[:, 0], at[:, 1]) - 1).max() < 1e-3
    orders = np.log2(np.array(left[:-1]) / left[1:])
    assert left[-1] < 1e-4 and (orders > 2).all() and (orders < 5).all(), left


# ------------------------------------------------------------------------------------------------------- vesicles --


def table() -> dict[tuple[str, float, float], dict[str, float]]:
    """Rows of the axisymmetric solver (tests/oracle/vesicle_branches.py), by branch, reduced volume, c0 at area 4 pi."""
    with open(Path(cyclides.__file__).with_name("vesicle_spontaneous.csv"), newline="") as file:
        return {(row["branch"], float(row["v"]), float(row["c0"])): {
            key: float(row[key]) for key in ("F", "W", "M", "pressure_p", "tension_sigma")} for row in csv.DictReader(file)}


TABLE = table()
SOME = [("prolate", 0.95, 2.0), ("prolate", 0.8, -1.0), ("prolate", 0.65, 1.0), ("oblate", 0.95, -3.0),
        ("oblate", 0.8, -2.0), ("oblate", 0.65, -1.0)]


def vesicle(branch: str, v: float, c0: float, levels: int, **fields) -> lib.Result:
    """From a sphere's cage of 98 vertices, drawn long or pressed flat, to the area 4 pi."""
    return lib.minimize(stretched(SPHERE, FORM[branch]), "mean_curvature", levels=levels, spontaneous_curvature=c0,
                        hold={"area": AREA, "volume": ("reduced", v)}, **fields)


@pytest.mark.parametrize("branch, v, c0", list(TABLE) if lib.LONG else SOME)
def test_vesicles(branch, v, c0):
    """Energy from above, M, which nothing holds, and both multipliers, on four levels."""
    known, errors = TABLE[branch, v, c0], []
    for levels in (1, 2, 3, 4):
        result = vesicle(branch, v, c0, levels, symmetry=KEEP, decrement_tolerance=1e-9)
        end = result.summary.end
        assert result.verdict == "minimum" and end.area == pytest.approx(AREA, rel=1e-12)
        assert 6 * math.sqrt(math.pi) * end.volume / end.area ** 1.5 == pytest.approx(v, rel=1e-11)
        errors.append((end.objective - known["F"]) / known["W"])
    assert all(error > -1e-9 for error in errors) and errors[3] < 1e-5, errors
    assert errors[0] > 3 * errors[1] > 9 * errors[2] > 27 * errors[3], errors
    assert end.total_mean_curvature == pytest.approx(known["M"], rel=1e-5)
    by_volume = -known["pressure_p"] * AREA / 3
    by_area = -known["tension_sigma"] - known["pressure_p"] * v / 2  # with the reduced volume held
    assert result.summary.multiplier[VOLUME_INDEX] == pytest.approx(by_volume, rel=1e-5, abs=1e-4)
    assert result.summary.multiplier[AREA_INDEX] == pytest.approx(by_area, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("branch, v, c0", list(TABLE) if lib.LONG else SOME[1:2])
def test_these_branches_are_stable(branch, v, c0):
    result = vesicle(branch, v, c0, 2, symmetry=KEEP, verify=1)
    assert result.summary.free_negative_directions == 0
    assert result.summary.difference_decrement == pytest.approx(result.summary.shape_decrement, rel=1e-3)


# ------------------------------------------------------------------------------------------ certificate, multipliers --


def second_differences(function, n: int, step: float) -> np.ndarray:
    """Second derivatives [n, n] of a cubic function of n numbers at 0, exact but for rounding."""
    unit = step * np.eye(n)
    at = {sign: [function(sign * u) for u in unit] for sign in (1, -1)}
    here, out = function(np.zeros(n)), np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            out[i, j] = out[j, i] = sum(function(sign * (unit[i] + unit[j])) - at[sign][i] - at[sign][j] + here
                                        for sign in (1, -1)) / (2 * step ** 2)
    return out


@pytest.mark.parametrize("factor, v, c0", [(2.2, 0.8, -2.5), (0.45, 0.85, 1.0), (2.2, 0.8, 1.0)] if lib.LONG else [
    (0.45, 0.85, 1.0)])
def test_certificate_against_a_dense_projected_hessian(factor, v, c0):
    """26 vertices that keep symmetries. Negative directions over all coordinates without these, at what volume and area
    allow, against eigenvalues of the dense Hessian of the Lagrangian between the constraints' tangents. The numbers' own
    derivatives are by differences: of the gradients of Helfrich's energy by c0, and of the volume, which is cubic."""
    cage = stretched(sphere_like(2), factor)
    result = lib.minimize(cage, "mean_curvature", levels=1, symmetry=KEEP, spacing=FREE, tolerance=1e-6, verify=1,
                          decrement_tolerance=1e-12, spontaneous_curvature=c0,
                          hold={"area": AREA, "volume": ("reduced", v)})
    assert result.verdict in ("minimum", "saddle")
    at, mesh, n = result.mesh.xyz, result.mesh, result.mesh.xyz.size
    problem = {c: lib.Problem(mesh, lib.options("mean_curvature", tolerance=1e-6, threads=1, spontaneous_curvature=c))
               for c in (c0, 1.0, -1.0, 0.0)}

    def gradients(x: np.ndarray) -> np.ndarray:
        """Of Helfrich's energy and the area, [2, n]."""
        of = {c: p.evaluate(x, gradient=True)[1].ravel() for c, p in problem.items()}
        return np.stack([of[c0], 2 * (of[1.0] + of[-1.0] - 2 * of[0.0])])

    roughly = lib.Problem(mesh, lib.options("mean_curvature", tolerance=1e-4, threads=1))  # it is asked 12 000 times

    def volume(move: np.ndarray) -> float:
        return roughly.evaluate(at + move.reshape(-1, 3)).volume

    step = 1e-5 * size(mesh)
    moves = np.eye(n).reshape(n, -1, 3)
    of_energy, of_area = np.moveaxis(np.stack([(gradients(at + step * u) - gradients(at - step * u)) / (2 * step)
                                               for u in moves]), 1, 0)
    energy, area = gradients(at)
    h = 0.02 * size(mesh)
    by_volume = np.array([(8 * volume(h * u) - 8 * volume(-h * u) - volume(2 * h * u) + volume(-2 * h * u)) / (12 * h)
                          for u in moves])
    constraints = np.stack([area, by_volume], -1)
    multipliers = np.linalg.lstsq(constraints, -energy, rcond=None)[0]
    assert np.linalg.norm(energy + constraints @ multipliers) < 1e-4 * np.linalg.norm(energy)
    reduced = result.summary.multiplier[VOLUME_INDEX] / (AREA / 3)  # of what is held: a part of the sphere's volume
    assert -multipliers[1] == pytest.approx(reduced, rel=1e-4)
    hessian = of_energy + multipliers[0] * of_area + multipliers[1] * second_differences(volume, n, h)
    motions = [np.tile(axis, n // 3) for axis in np.eye(3)] + [np.cross(axis, at).ravel() for axis in np.eye(3)]
    between = null_space(np.concatenate([constraints.T, motions]))
    values = eigh(between.T @ (hessian + hessian.T) @ between / 2, eigvals_only=True) * size(mesh) ** 2
    reference = result.summary.end.objective + c0 ** 2 * AREA / 2
    shift = 0.1 * reference / mesh.n_vertices  # curvature below it counts as none
    assert (values < -0.5 * shift).sum() == (values < -2 * shift).sum(), values[:6]
    assert result.summary.all_negative_directions == (values < -shift).sum()


@pytest.mark.parametrize("c0", [0.0, 0.9])
@pytest.mark.parametrize("pinned", [False, True])
def test_multipliers_are_slopes_of_the_least_energy(c0, pinned):
    """Of Willmore's energy, with volume and area held, by either, against differences of minima."""
    mesh = torus_cage(8, 6, 0.45)
    fields = {"constraints": lib.constraints([0, 11, 22, 40])} if pinned else {}
    first = lib.evaluate(mesh)
    held = {"volume": 1.1 * first.volume, "area": 1.1 * first.area}

    def solve(cage, change: dict[str, float]) -> lib.Result:
        result = lib.minimize(cage, levels=1, symmetry=NONE, tolerance=1e-7, decrement_tolerance=1e-13, spacing=FREE,
                              spontaneous_curvature=c0, hold={**held, **change}, **fields)
        assert result.verdict == "minimum"
        return result

    middle = solve(mesh, {})
    found = middle.summary.multiplier
    start = middle.mesh if pinned else mesh  # of the minima of the net, both ways the same
    for name, value in held.items():
        step = 5e-4 * value
        high, low = (solve(start, {name: value + of * step}) for of in (1, -1))
        slope = high.summary.end.objective - low.summary.end.objective
        assert found[lib.SCALARS.index(name)] == pytest.approx(slope / (2 * step), rel=2e-3), name


# ----------------------------------------------------------------------------------------------- scale, invariances --


def test_it_is_the_same_in_other_units():
    mesh, fields = stretched(SPHERE, 2.2), {"levels": 2, "hold": {"volume": "keep", "area": "keep"}}
    one = lib.minimize(mesh, spontaneous_curvature=1.2, **fields)
    for scale in (1e-4, 1e4):
        other = lib.minimize(mesh.with_xyz(mesh.xyz * scale), spontaneous_curvature=1.2 / scale, **fields)
        assert other.summary.end.objective == pytest.approx(one.summary.end.objective, rel=1e-9)
        assert np.abs(other.mesh.xyz / scale - one.mesh.xyz).max() < 1e-6


def test_normals_that_point_inwards():
    mesh = stretched(SPHERE, 2.2)
    out, other = (vesicle_of.summary.end for vesicle_of in (
        lib.minimize(m, levels=1, symmetry=NONE, spontaneous_curvature=1.2, hold={"volume": ("reduced", 0.8)})
        for m in (mesh, inside_out(mesh))))
    assert other.objective == pytest.approx(out.objective, rel=1e-6)
    assert out.volume > 0 > other.volume and out.total_mean_curvature > 0 > other.total_mean_curvature


@pytest.mark.parametrize("hold", [{}, {"volume": 7.0}, {"total_mean_curvature": 9.0}, {"area": 3.0}])
def test_the_size_is_the_one_that_is_asked_for(hold):
    """A run's figures are those of its result, evaluated as a cage by itself; the size, by whatever number, is reached."""
    mesh = torus_cage(8, 6, 0.45)
    result = lib.minimize(mesh, levels=1, spontaneous_curvature=0.8, tolerance=1e-6, hold=hold)
    end = result.summary.end
    again = lib.evaluate(result.mesh, spontaneous_curvature=0.8, tolerance=1e-7)
    assert result.verdict == "minimum"
    for name, value in (hold or {"area": lib.evaluate(mesh, tolerance=1e-7).area}).items():
        assert getattr(end, name) == pytest.approx(value, rel=1e-5)
    assert end.objective == pytest.approx(again.objective, rel=1e-4)
    assert end.helfrich == pytest.approx(again.helfrich, rel=1e-4)


def test_threads_do_not_matter():
    mesh = torus_cage(9, 6, 0.45)
    one, two = (lib.minimize(mesh, {"willmore": 1.0, "mvs": 0.01}, levels=1, threads=n, spontaneous_curvature=0.5,
                             hold={"volume": "keep", "area": "keep"}) for n in (1, 2))
    assert np.array_equal(one.mesh.xyz, two.mesh.xyz)


def test_what_is_told_on_the_way_is_the_objective():
    """It comes near 0 here, and what it is beside that is told of neither."""
    seen: list[float] = []
    result = lib.minimize(stretched(SPHERE, 1.5), "mean_curvature", levels=2, spontaneous_curvature=2.0,
                          hold={"area": AREA}, progress=lambda p: seen.append(p.energy))
    assert seen[0] > 0.1 and result.verdict == "minimum"
    assert seen[-1] == pytest.approx(result.summary.end.objective, abs=1e-6) == pytest.approx(0, abs=1e-3)


# ------------------------------------------------------------------------------------------------------- refusals --


@pytest.mark.parametrize("weights, c0, words", [
    ("mvs", 1.0, "spontaneous_curvature is 1, but neither willmore nor mean_curvature"),
    ({"variation": 1.0, "area": 1.0}, -2.0, "spontaneous_curvature is -2, but neither"),
    ("willmore", math.nan, "spontaneous_curvature is nan"), ("willmore", math.inf, "spontaneous_curvature is inf"),
])
def test_refused(weights, c0, words):
    for call in (lib.minimize, lib.evaluate):
        with pytest.raises(lib.CurvoptError, match=words):
            call(SPHERE, weights, spontaneous_curvature=c0)


def test_the_command_line_takes_it():
    mesh = stretched(SPHERE, 2.2)
    seen, wanted = lib.cli_evaluate(mesh, "--spontaneous-curvature", "-1.5"), lib.evaluate(mesh, spontaneous_curvature=-1.5)
    assert seen["spontaneous_curvature"] == -1.5
    assert seen["helfrich"] == wanted.helfrich and seen["objective"] == wanted.objective
    report, _ = lib.cli_minimize(mesh, "--spontaneous-curvature", "1.2", "--levels", "1", "--reduced-volume", "0.8",
                                 "--area", "12.5")
    result = lib.minimize(mesh, levels=1, spontaneous_curvature=1.2, hold={"area": 12.5, "volume": ("reduced", 0.8)})
    assert report["spontaneous_curvature"] == 1.2 and report["helfrich"] == result.summary.end.helfrich
    assert list(report["multipliers"].values())[:2] == list(result.summary.multiplier)[:2]

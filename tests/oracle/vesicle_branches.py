# SPDX-License-Identifier: GPL-3.0-or-later
"""Branches of axisymmetric vesicles: prolate, oblate and stomatocytes, followed from shapes that are solved (vesicles.py);
where they cross, branch and turn back. As a program it writes vesicle_branches.csv, vesicle_events.csv and vesicle_spontaneous.csv."""
from __future__ import annotations

import csv
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from vesicles import (AREA, Array, Condition, NODES, R, SPHERE_VOLUME, Shape,
                      asymmetry_condition, equations, factorize, solve,
                      volume_condition)


def near_sphere(v: float, sign: float, count: int) -> Shape:
    """Return a first-order guess: a sphere with an l = 2 deformation.

    sign = +1 is prolate and sign = -1 is oblate; r(theta) = 1 + e P2 and
    1 - v = 3 e^2 / 5 to leading order.
    """
    e = sign * np.sqrt(5.0 * (1.0 - v) / 3.0)
    theta = np.linspace(0.0, np.pi, 2001)
    arc = theta + e * (theta / 4.0 + 3.0 * np.sin(2.0 * theta) / 8.0)
    psi = theta + 1.5 * e * np.sin(2.0 * theta)
    mesh = np.linspace(0.0, 1.0, count + 1)
    gauss = mesh[:-1, None] + np.diff(mesh)[:, None] * NODES

    def values(t: Array) -> Array:
        angle = np.interp(t * arc[-1], arc, psi)
        polar = np.interp(t * arc[-1], arc, theta)
        slope = (1.0 + 3.0 * e * np.cos(2.0 * polar)) / (
            1.0 + e * (0.25 + 0.75 * np.cos(2.0 * polar)))
        radius = (1.0 + e * (1.5 * np.cos(polar) ** 2 - 0.5)) * np.sin(polar)
        gamma = -6.0 * np.sin(polar) * np.cos(polar)
        return np.stack([angle, slope, radius, gamma], axis=-1)

    params = np.array([arc[-1], 6.0, -3.0, v])
    return Shape(mesh, values(mesh), values(gauss), params)


def follow(shape: Shape, volumes: Array, count: int) -> list[Shape]:
    """Continue a branch through the given reduced volumes, in that order.

    The predictor is linear in v; the mesh is graded again after each step.
    Steps that fail are halved.  A volume counts as reached within 1e-13.
    """
    found: list[Shape] = []
    previous, current = None, shape
    for target in volumes:
        while abs(current.volume - target) > 1e-13:
            step = float(target - current.volume)
            step = float(np.sign(step) * min(abs(step), 0.02))
            for _ in range(8):
                v = current.volume + step
                if abs(v - target) < 1e-9:
                    v = float(target)
                guess = current
                if previous is not None:
                    old = previous.on_mesh(current.mesh)
                    scale = (v - current.volume) / (
                        current.volume - previous.volume)
                    guess = current.with_vector(
                        current.vector()
                        + scale * (current.vector() - old.vector()))
                try:
                    new = solve(guess, volume_condition(guess, v))
                except RuntimeError:
                    step *= 0.5
                    continue
                break
            else:
                raise RuntimeError(f"branch lost near v = {current.volume}")
            graded = new.remeshed(count)
            new = solve(graded, volume_condition(graded, v))
            previous, current = current, new
        found.append(current)
    return found


def at_volume(shape: Shape, v: float, count: int) -> Shape:
    """Continue a shape to the reduced volume v with `count` elements."""
    found = follow(shape, np.array([v]), count)[0]
    if len(found.mesh) == count + 1:
        return found
    graded = found.remeshed(count)
    return solve(graded, volume_condition(graded, v))


def at_spontaneous(shape: Shape, c0: float, count: int) -> Shape:
    """Continue a shape at its volume to the spontaneous curvature c0.

    Steps of c0 are 0.1 at most, the predictor is linear in it, and steps that
    fail are halved.
    """
    previous, current = None, shape
    while current.spontaneous != c0:
        step = float(np.clip(c0 - current.spontaneous, -0.1, 0.1))
        for _ in range(8):
            target = current.spontaneous + step
            if abs(target - c0) < 1e-9:
                target = c0
            guess = replace(current, spontaneous=target)
            if previous is not None:
                old = previous.on_mesh(current.mesh)
                scale = step / (current.spontaneous - previous.spontaneous)
                guess = guess.with_vector(
                    guess.vector() + scale * (guess.vector() - old.vector()))
            try:
                new = solve(guess, volume_condition(guess, shape.volume))
            except RuntimeError:
                step *= 0.5
                continue
            break
        else:
            raise RuntimeError(f"branch lost near c0 = {current.spontaneous}")
        graded = new.remeshed(count)
        previous, current = current, solve(
            graded, volume_condition(graded, shape.volume))
    return current


def simple_branch(sign: float, volumes: Array, count: int) -> list[Shape]:
    """Return the prolate (+1) or oblate (-1) shapes for descending volumes."""
    guess = near_sphere(0.98, sign, count)
    start = solve(guess, volume_condition(guess, 0.98))
    return follow(start, volumes, count)


def asymmetric_mode(shape: Shape) -> Array:
    """Return the singular vector of the smallest singular value at fixed v.

    It is shaped like Shape.vector() and scaled to change psi(1/2) by one.
    Near the symmetry breaking bifurcation it is the antisymmetric mode.
    """
    _, matrix = equations(shape, volume_condition(shape, shape.volume))
    factors = factorize(matrix)
    mode = np.random.default_rng(1).standard_normal(matrix.shape[0])
    for _ in range(20):
        mode = factors.solve(factors.solve(mode, trans="T"))
        mode /= np.linalg.norm(mode)
    return mode / (asymmetry_condition(shape, 0.0).row @ mode)


def small_asymmetry(oblate: Shape, angle: float) -> Shape:
    """Branch off an oblate shape near the symmetry breaking bifurcation.

    The closing condition prescribes psi(1/2) - pi/2 = angle; v is free.  The
    mesh is uniform with the same number of elements, which must be even.
    """
    count = len(oblate.mesh) - 1
    base = oblate.on_mesh(np.linspace(0.0, 1.0, count + 1))
    base = solve(base, volume_condition(base, oblate.volume))
    guess = base.with_vector(base.vector() + angle * asymmetric_mode(base))
    return solve(guess, asymmetry_condition(guess, angle))


def follow_arc(before: Shape, last: Shape, count: int, steps: int,
               stop: Callable[[Shape], bool]) -> list[Shape]:
    """Continue a branch by secant pseudo arc length, so folds are harmless.

    Every step is 1.3 times the one before, at most 0.15 in the root mean
    square of all unknowns, and is halved on failure.  Ends when stop(shape)
    holds or after `steps` steps.
    """
    found = [before, last]
    growth = 1.3
    for _ in range(steps):
        base = found[-1].remeshed(count)
        base = solve(base, volume_condition(base, base.volume))
        old = found[-2].on_mesh(base.mesh)
        secant = base.vector() - old.vector()
        size = float(np.sqrt(np.mean(secant ** 2)))
        scale = min(growth, 0.15 / size)
        for _ in range(8):
            guess = base.with_vector(base.vector() + scale * secant)
            row = secant / np.linalg.norm(secant)
            condition = Condition(row, float(row @ guess.vector()))
            try:
                new = solve(guess, condition)
            except RuntimeError:
                scale *= 0.5
                continue
            break
        else:
            raise RuntimeError(f"branch lost near v = {base.volume}")
        found[-1] = base
        found.append(new)
        if stop(new):
            break
    return found


def crossing(first: Shape, second: Shape, bracket: tuple[float, float],
             count: int) -> tuple[float, float]:
    """Return the volume and energy where two branches have equal energy."""
    def difference(v: float) -> float:
        return (at_volume(first, v, count).willmore()
                - at_volume(second, v, count).willmore())
    v = float(brentq(difference, *bracket, xtol=1e-10))
    return v, at_volume(first, v, count).willmore()


def root(function: Callable[[Shape], float], shape: Shape,
         bracket: tuple[float, float], count: int) -> float:
    """Return the volume at which function(shape) vanishes along a branch."""
    return float(brentq(lambda v: function(at_volume(shape, v, count)),
                        *bracket, xtol=1e-10))


def stomatocyte_start(oblate: Shape, count: int) -> tuple[Shape, Shape]:
    """Follow the stomatocytes from the oblate bifurcation around the fold.

    oblate: an oblate shape near the bifurcation (v = 0.51).  Returns the
    shape with the largest volume met and the first one below v = 0.65 on the
    branch of lower energy.
    """
    past_fold = [False]

    def stop(shape: Shape) -> bool:
        past_fold[0] = past_fold[0] or shape.volume > 0.655
        return past_fold[0] and shape.volume < 0.65

    path = follow_arc(small_asymmetry(oblate, 0.05),
                      small_asymmetry(oblate, 0.1), count, 60, stop)
    return max(path, key=lambda shape: shape.volume), path[-1]


def bifurcation(oblate: Shape) -> float:
    """Return the volume at which the stomatocytes leave the oblate branch.

    v is even in the asymmetry angle, so three small angles and a polynomial
    in the squared angle give its value at zero.
    """
    angles = np.array([0.02, 0.04, 0.06])
    volumes = [small_asymmetry(oblate, float(a)).volume for a in angles]
    return float(np.polyfit(angles ** 2, volumes, 2)[-1])


def fold(top: Shape, count: int) -> Shape:
    """Return the stomatocyte of largest volume, starting from a nearby one.

    At the fold the derivative of v by the asymmetry angle vanishes.
    """
    base = top.on_mesh(np.linspace(0.0, 1.0, count + 1))

    def at_angle(angle: float) -> Shape:
        return solve(base, asymmetry_condition(base, angle))

    def derivative(angle: float) -> float:
        shape = at_angle(angle)
        _, matrix = equations(shape, asymmetry_condition(shape, angle))
        unit = np.zeros(matrix.shape[0])
        unit[-1] = 1.0
        return float(factorize(matrix).solve(unit)[-1])

    angle = top.asymmetry()
    return at_angle(float(brentq(derivative, angle - 0.02, angle + 0.02,
                                 xtol=1e-12)))


BRANCH_VOLUMES = {
    "prolate": [0.98, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.5, 0.4,
                0.3],
    "oblate": [0.98, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.57, 0.54,
               0.5],
    "stomatocyte": [0.66, 0.65, 0.64, 0.62, 0.6, 0.57, 0.54, 0.5, 0.45, 0.4,
                    0.35, 0.3],
}

COLUMNS = ["branch", "v", "W", "W_over_4pi", "intH_over_sqrtA", "pressure_p",
           "tension_sigma", "residual", "first_integral_max",
           "scaling_defect", "area_error", "volume_error", "W_fine",
           "W_fine_minus_W", "r_change_on_fine", "pole_gap", "embedded"]


def table_row(branch: str, shape: Shape) -> dict[str, object]:
    """Return one row of vesicle_branches.csv."""
    fine = shape.refined()
    fine = solve(fine, volume_condition(fine, shape.volume))
    _, p, sigma, v = shape.params
    energy, energy_fine = shape.willmore(), fine.willmore()
    return {
        "branch": branch,
        "v": f"{v:.10g}",
        "W": f"{energy:.12f}",
        "W_over_4pi": f"{energy / AREA:.12f}",
        "intH_over_sqrtA":
            f"{shape.total_mean_curvature() / np.sqrt(AREA):.12f}",
        "pressure_p": f"{p:.10f}",
        "tension_sigma": f"{sigma:.10f}",
        "residual": f"{shape.residual:.1e}",
        "first_integral_max": f"{shape.first_integral():.1e}",
        "scaling_defect": f"{shape.scaling_defect():.1e}",
        "area_error": f"{shape.area() - AREA:.1e}",
        "volume_error": f"{shape.enclosed_volume() - v * SPHERE_VOLUME:.1e}",
        "W_fine": f"{energy_fine:.12f}",
        "W_fine_minus_W": f"{energy_fine - energy:.1e}",
        "r_change_on_fine":
            f"{np.abs(fine.ends[::2, R] - shape.ends[:, R]).max():.1e}",
        "pole_gap": f"{shape.pole_gap():.10f}",
        "embedded": shape.embedded(),
    }


# Reduced volumes and spontaneous curvatures at which a branch is stable, also
# without its symmetry (tests/numeric/test_spontaneous.py looks).
SPONTANEOUS = {
    "prolate": [(v, c0) for v in (0.95, 0.8, 0.65) for c0 in (-1.0, 1.0, 2.0)],
    "oblate": [(v, c0) for v in (0.95, 0.8) for c0 in (-3.0, -2.0, -1.0)]
    + [(0.65, -1.0)],
}


def write_spontaneous(folder: Path, shapes: dict[str, list[Shape]],
                      count: int) -> None:
    """Write vesicle_spontaneous.csv, from shapes without c0, to a folder."""
    columns = ["branch", "v", "c0", "F", "W", "M", "pressure_p",
               "tension_sigma", "residual", "first_integral_max",
               "scaling_defect", "F_fine_minus_F", "embedded"]
    with open(folder / "vesicle_spontaneous.csv", "w", newline="") as handle:
        table = csv.DictWriter(handle, columns)
        table.writeheader()
        for branch, points in SPONTANEOUS.items():
            for v, c0 in points:
                near = min(shapes[branch], key=lambda s: abs(s.volume - v))
                shape = at_spontaneous(at_volume(near, v, count), c0, count)
                fine = shape.refined()
                fine = solve(fine, volume_condition(fine, v))
                _, p, sigma, _ = shape.params
                table.writerow({
                    "branch": branch, "v": v, "c0": c0,
                    "F": f"{shape.energy():.12f}",
                    "W": f"{shape.willmore():.12f}",
                    "M": f"{shape.total_mean_curvature():.12f}",
                    "pressure_p": f"{p:.10f}", "tension_sigma": f"{sigma:.10f}",
                    "residual": f"{shape.residual:.1e}",
                    "first_integral_max": f"{shape.first_integral():.1e}",
                    "scaling_defect": f"{shape.scaling_defect():.1e}",
                    "F_fine_minus_F": f"{fine.energy() - shape.energy():.1e}",
                    "embedded": shape.embedded()})


def main(folder: Path, count: int = 96) -> None:
    """Write vesicle_branches.csv, vesicle_events.csv and
    vesicle_spontaneous.csv to a folder; a minute."""
    began = time.time()
    shapes: dict[str, list[Shape]] = {}
    for branch, sign in (("prolate", 1.0), ("oblate", -1.0)):
        shapes[branch] = simple_branch(
            sign, np.array(BRANCH_VOLUMES[branch]), count)
        print(branch, f"{time.time() - began:.0f} s", flush=True)
    near_bifurcation = at_volume(shapes["oblate"][-2], 0.51, count)
    top, lower = stomatocyte_start(near_bifurcation, count)
    # The first volume lies just below the fold and is reached upwards.
    volumes = np.array(BRANCH_VOLUMES["stomatocyte"])
    shapes["stomatocyte"] = (follow(lower, volumes[:1], count)
                             + follow(lower, volumes[1:], count))
    print("stomatocyte", f"{time.time() - began:.0f} s", flush=True)
    write_spontaneous(folder, shapes, count)

    def near(branch: str, v: float) -> Shape:
        return min(shapes[branch], key=lambda shape: abs(shape.volume - v))

    special: list[tuple[str, float, float]] = []
    for first, second, bracket in (
            ("prolate", "oblate", (0.645, 0.66)),
            ("oblate", "stomatocyte", (0.585, 0.6))):
        for elements in (count, 2 * count):
            v, energy = crossing(near(first, bracket[0]),
                                 near(second, bracket[0]), bracket, elements)
            special.append((f"crossing {first}/{second}, {elements} elements",
                            v, energy))
        for branch in (first, second):
            shapes[branch].append(at_volume(near(branch, v), v, count))
    for elements in (count, 2 * count):
        special.append((f"bifurcation oblate/stomatocyte, {elements} elements",
                        bifurcation(at_volume(near_bifurcation, 0.51,
                                              elements)), np.nan))
        edge = fold(top, elements)
        special.append((f"fold of the stomatocytes, {elements} elements",
                        edge.volume, edge.willmore()))
    touch = root(Shape.pole_gap, near("oblate", 0.5), (0.495, 0.51), count)
    special.append(("poles of the oblate shape touch", touch,
                    at_volume(near("oblate", 0.5), touch, count).willmore()))
    with open(folder / "vesicle_events.csv", "w", newline="") as handle:
        writer = csv.writer(handle)
        writer.writerow(["event", "v", "W", "W_over_4pi"])
        for name, v, energy in special:
            writer.writerow([name, f"{v:.9f}", f"{energy:.9f}",
                             f"{energy / AREA:.9f}"])
            print(name, v, energy / AREA, flush=True)

    with open(folder / "vesicle_branches.csv", "w", newline="") as handle:
        table = csv.DictWriter(handle, COLUMNS)
        table.writeheader()
        for branch, members in shapes.items():
            for shape in sorted(members, key=lambda s: -s.volume):
                table.writerow(table_row(branch, shape))
    print(f"finished after {time.time() - began:.0f} s")


if __name__ == "__main__":
    main(Path(__file__).resolve().parent)

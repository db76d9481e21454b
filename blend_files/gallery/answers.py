# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's other questions: the two blend functions, how far `plane` moves minimizers, and saddles. No bpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from . import solve
from .dense import Dense, centre_and_size, dense
from .plot import Axis, Series, plot
from .store import Item, Store

_COMPARED = 6000  # quads of a shape whose distance to another is measured
_BLOCK = 500


def smooth_blend(t: np.ndarray) -> np.ndarray:
    """The report's function (1), its denominator mended: h(t) / (h(t) + h(1 - t)) with h(t) = exp(2 e^(-1/t) / (t - 1))
    (Ying and Zorin 2004), smooth to all orders, 1 at 0 and 0 at 1."""

    def h(s: np.ndarray) -> np.ndarray:
        inside = np.clip(s, 1e-12, 1 - 1e-12)
        return np.exp(2 * np.exp(-1 / inside) / (inside - 1))

    return h(t) / (h(t) + h(1 - t))


def spline_blend(t: np.ndarray) -> np.ndarray:
    """The C^4 spline that falls from 1 to 0 over five equal spans with four vanishing derivatives at both ends: one
    minus the integral of the quartic B-spline, by truncated powers."""
    x = 5 * np.asarray(t)
    terms = ((-1) ** k * math.comb(5, k) * np.maximum(x - k, 0.0) ** 5 for k in range(6))
    return 1 - sum(terms) / math.factorial(5)


def blend_functions(store: Store, item: Item) -> list[dict[str, float]]:
    """The report's figure 3: both functions, and how far their platforms reach."""
    t = np.linspace(0, 1, 401)
    found, series = [], []
    for label, blend, style in (
        ("smooth to all orders, (1)", smooth_blend, "line"), ("C⁴ spline", spline_blend, "dashes"),
    ):  # fmt: skip
        values = blend(t)
        series.append(Series(label, list(zip(t.tolist(), values.tolist())), style))
        fine = np.linspace(0, 1, 100_001)
        reach = {f"above_{level}": float(fine[blend(fine) >= level].max()) for level in (0.999, 0.99, 0.9, 0.5)}
        found.append({"function": label, **reach, "integral": float(np.trapz(blend(fine), fine))})
    x, y = Axis("t, from the extraordinary vertex", 0, 1), Axis("w(t)", 0, 1.05)
    text = plot("The two blend functions", x, y, series)
    store.write(item.files[0], text.encode())
    return found


# ------------------------------------------------------------------------------------------- plane and polynomial --


def compare_plane(store: Store, item: Item) -> list[dict[str, object]]:
    """Answer (d): of each pair (cage, energy, item with `polynomial`, item with `plane`), the energy of either cage on
    either surface, and the distance of the shapes."""
    found = []
    for name, energy, polynomial, plane in item.inputs["pairs"]:
        cages = store.cage(polynomial), store.cage(plane)
        own = store.result(polynomial), store.result(plane)
        mean, most = distance(dense(cages[0], "polynomial", _COMPARED), dense(cages[1], "plane", _COMPARED))
        found.append({
            "cage": name, "energy": energy, "polynomial": own[0]["value"], "plane": own[1]["value"],
            "plane_minimizer_on_polynomial": solve.evaluate(cages[1], energy, "polynomial").objective,
            "polynomial_minimizer_on_plane": solve.evaluate(cages[0], energy, "plane").objective,
            "distance": mean, "farthest": most, "h2": [own[0]["h2"], own[1]["h2"]],
            "verdicts": [own[0]["verdict"], own[1]["verdict"]],
            "net_shares": [record["net_share"] for record in own],
            "quadrature_errors": [record["quadrature_error"] for record in own],
        })  # fmt: skip
    series = []
    for energy, title in (("mvs", "MVS"), ("mvs_cross", "MVS_cross")):
        apart = [100 * row["distance"] for row in found if row["energy"] == energy]
        series.append(Series(title, [(k + 1.0, percent) for k, percent in enumerate(apart)], "dots"))
    names = list(dict.fromkeys(row["cage"] for row in found))
    label = ", ".join(f"{k + 1} {name}" for k, name in enumerate(names))
    text = plot("How far `plane` moves minimizers", Axis(label, 0, len(names) + 1, ticks=range(1, len(names) + 1)),
                Axis("mean distance, % of the size", 0), series)  # fmt: skip
    store.write(item.files[0], text.encode())
    return found


def distance(one: Dense, other: Dense) -> tuple[float, float]:
    """Root mean square (by area) and largest distance of a shape's points from another, best placed and scaled, in
    sizes of the first. Points are held against tangent planes at the nearest points."""
    centre, size = centre_and_size(one)
    points = (one.points - centre) / size
    theirs, their_size = centre_and_size(other)
    moved = (other.points - theirs) / their_size
    normals = other.normals
    for _ in range(15):
        nearest = _nearest(points, moved)
        rotation, scale, shift = _similarity(moved[nearest], points, one.areas)
        moved = scale * moved @ rotation.T + shift
        normals = normals @ rotation.T
    nearest = _nearest(points, moved)
    apart = np.abs(((points - moved[nearest]) * normals[nearest]).sum(1))
    weight = one.areas / one.areas.sum()
    return float(np.sqrt(weight @ apart**2)), float(apart.max())


def _nearest(points: np.ndarray, among: np.ndarray) -> np.ndarray:
    """For each point (n, 3) the index of the nearest `among` (m, 3)."""
    squares = (among**2).sum(1)
    blocks = [points[k : k + _BLOCK] for k in range(0, len(points), _BLOCK)]
    return np.concatenate([np.argmin(squares - 2 * block @ among.T, axis=1) for block in blocks])


def _similarity(source: np.ndarray, target: np.ndarray, areas: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Rotation, scale, shift that bring `source` (n, 3) nearest to `target` (n, 3) (Umeyama 1991)."""
    weight = areas / areas.sum()
    a, b = weight @ source, weight @ target
    u, s, vt = np.linalg.svd((target - b).T @ ((source - a) * weight[:, None]))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = (u * signs) @ vt
    scale = float((s * signs).sum() / (weight @ ((source - a) ** 2).sum(1)))
    return rotation, scale, b - scale * rotation @ a


# --------------------------------------------------------------------------------------------------------- saddles --


def plot_saddles(store: Store, item: Item) -> dict[str, object]:
    """Answer (e): certificates without symmetry, and the fall of Willmore's energy from shaken minimizers."""
    verified, shaken, modes, series = [], [], [], []
    for name in item.needs:
        result = store.result(name)
        kind, cage, energy, last = f"{name}.".split(".")[:4]
        if kind == "mode":
            modes.append({"cage": cage, "h2": store.result(result["of"])["h2"], **result, "sides": []})
            continue
        if kind == "fall":
            modes[-1]["sides"].append(result)
            continue
        if kind == "verify":
            verified.append({"cage": cage, "energy": energy, "levels": int(last), **result})
            continue
        before = store.result(result["from"])
        share, rounds = int(last.split("x")[0]) / 1000, int(last.split("x")[1])
        shaken.append({
            "cage": cage, "energy": energy, "share": share, "rounds": rounds, "before": before["value"],
            "h2_before": before["h2"], "start": result["path"][0], "value": result["value"], "h2": result["h2"],
            "steps": len(result["path"]) - 1, "stop": result["stop"], "verdict": result["verdict"],
        })  # fmt: skip
        if energy == "willmore":
            series.append(Series(f"{cage}, {share:g}, {rounds}", _as_h2(result["path"], result["euler"])))
    lawson = [(f"Lawson, genus {genus}", solve.lawson_h2(genus)) for genus in (3, 5)]
    text = plot("Symmetric Willmore minimizers, shaken", Axis("step"), Axis("∫H²", 22.6, 25.4), series, lawson)
    store.write(item.files[0], text.encode())
    return {"verified": verified, "shaken": shaken, "modes": modes}


def _as_h2(path: Sequence[float], euler: int) -> list[tuple[float, float]]:
    """int H^2 by step, from W = 4 int H^2 - 4 pi chi."""
    return [(float(step), (value + 4 * math.pi * euler) / 4) for step, value in enumerate(path)]

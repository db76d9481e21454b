# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's optimizations: a cage, an energy and a setting to a minimizer, its figures and its certificate. No bpy.

Settings: "default", but with all symmetries of the cage kept; "report", the report's surface, optimizer and fixed
quadrature rule; "plane", the report's surface with our optimizer and quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from addon.binding import library
from addon.binding.abi import SURFACES, SYMMETRIES
from addon.binding.values import Cage, Energies, Verification
from addon.core import job
from .dense import dense, torus_ratio
from .store import Item, Store

SETTINGS = ("default", "report", "plane")
# A level. The fixed rule has no minimum that more would reach, on many cages: MVS of Lawson's genus 2 ends at 4 018, 3 192
# and 2 274 with 250, 500 and 1000, of genus 3 at 16 931 and 21 090 with 250 and 1000.
REPORT_STEPS = 500
SYMMETRY = "keep"  # as the report's shapes keep theirs; what lies beyond is a question of its own (`verify`, `shaken`)
ENERGIES = ("willmore", "mvs", "mvs_cross")
FINE = 1e-5  # relative accuracy of the figures that fixed rules are held against


def limits(setting: str, energy: str, threads: int) -> dict[str, int]:
    """Fields of curvopt_options that a setting changes. ValueError for an unknown one."""
    if setting not in SETTINGS:
        raise ValueError(f"There is no setting '{setting}'; there are {', '.join(SETTINGS)}.")
    fields = {"threads": threads}
    if setting == "report":
        fields["joshi_sequin"] = 1
        fields["max_iterations"] = REPORT_STEPS
    if setting == "plane" and energy != "willmore":
        fields["surface"] = SURFACES.index("plane")
    return fields


def minimize(store: Store, item: Item) -> dict[str, object]:
    """An item of inputs `energy`, `setting`, `levels`, of one cage; keeps the minimizer's cage."""
    ((_, cage),) = item.cages.items()
    inputs = item.inputs
    fields = limits(inputs["setting"], inputs["energy"], threads=1)
    symmetry = "none" if inputs["setting"] == "report" else SYMMETRY  # the report knows nothing of it
    solution = job.solve(cage, job.Request(inputs["energy"], inputs["levels"], fields, symmetry=symmetry))
    store.save_cage(item.name, solution.cage)
    return figures(solution, inputs["energy"], inputs["setting"])


def figures(solution: job.Solution, energy: str, setting: str) -> dict[str, object]:
    """All that a run says of its result, and what a fine adaptive rule makes of the same surface. `net_share` is what
    finer nets would still take away, as the library estimates it; None where nothing is known of it."""
    end, cage = solution.end, solution.cage
    found, certified_by = solution.verification, "run"
    if setting == "report":
        found, certified_by = certificate(cage, energy, end.surface), "afterwards, by the default settings"
    return {
        "energy": energy, "setting": setting, "surface": end.surface,
        "start": plain(solution.start.objective), "value": plain(end.objective), "h2": plain(end.h2),
        "terms": {name: plain(value) for name, value in end.terms.items()},
        "quadrature_error": plain(end.objective_error), "net_share": plain(solution.discretization_error),
        "gauss_bonnet_defect": plain(end.gauss_bonnet_defect),
        "resolved": resolved(cage, energy, end.surface), "euler": solution.euler,
        "verdict": found.verdict, "newton_decrement": plain(found.newton_decrement),
        "negative_directions": found.negative_directions, "certified": certified_by,
        "stop": solution.stop, "seconds": solution.seconds, "vertices": len(cage.positions),
        "iterations": [level.iterations for level in solution.levels],
        "symmetry_order": solution.symmetry_order,
        "ratio": torus_ratio(dense(cage, "limit", 8000).points) if solution.euler == 0 else None,
    }  # fmt: skip


def plain(value: float) -> float | None:
    """A number for JSON; None for what is none."""
    return float(value) if math.isfinite(value) else None


def evaluate(cage: Cage, energy: str, surface: str, tolerance: float = 1e-4) -> Energies:
    """Energies of a cage's surface, the one of `energy` (a term) as the objective. CurvoptError."""
    lib = library.load()
    options = lib.options({energy: 1.0}, surface=SURFACES.index(surface), tolerance=tolerance, threads=1)
    with library.Mesh.of_cage(lib, cage) as mesh:
        with library.Problem.create(mesh, options) as problem:
            return problem.evaluate(cage.positions)[0]


def resolved(cage: Cage, energy: str, surface: str) -> dict[str, object]:
    """What a fine adaptive rule makes of a surface: `value`, its estimated `error`, `h2`; or `refused`, why not."""
    try:
        found = evaluate(cage, energy, surface, FINE)
    except library.CurvoptError as error:
        return {"value": None, "error": None, "h2": None, "refused": error.message}
    return {
        "value": plain(found.objective), "error": plain(found.objective_error), "h2": plain(found.h2), "refused": None,
    }  # fmt: skip


def certificate(cage: Cage, energy: str, surface: str) -> Verification:
    """What the Hessian says of a cage as it is: a run of no steps."""
    fields = {"threads": 1, "max_iterations": 0, "surface": SURFACES.index(surface)}
    return job.solve(cage, job.Request(energy, 1, fields, symmetry="none")).verification


def inputs_figures(store: Store, item: Item) -> dict[str, object]:
    """Energies of a cage as it comes: Willmore and int H^2 of the limit surface, third order of `polynomial`."""
    ((_, cage),) = item.cages.items()
    bending, third = evaluate(cage, "willmore", "limit"), evaluate(cage, "mvs", "polynomial")
    return {
        "willmore": plain(bending.terms["willmore"]), "h2": plain(bending.h2),
        "mvs": plain(third.terms["mvs"]), "mvs_cross": plain(third.terms["mvs_cross"]),
        "quadrature_errors": {
            "willmore": plain(bending.term_errors["willmore"]),
            **{name: plain(third.term_errors[name]) for name in ("mvs", "mvs_cross")},
        },
        "gauss_bonnet_defect": plain(bending.gauss_bonnet_defect), "vertices": len(cage.positions),
        "ratio": torus_ratio(dense(cage, "limit", 8000).points),
    }  # fmt: skip


def verify(store: Store, item: Item) -> dict[str, object]:
    """Minimizes `energy` of a cage in `levels` levels and looks at the result without its symmetries as well
    (`--verify`). -1: not counted."""
    lib = library.load()
    ((_, cage),) = item.cages.items()
    options = lib.options(
        {item.inputs["energy"]: 1.0}, levels=item.inputs["levels"], verify=1, threads=1,
        symmetry=SYMMETRIES.index(SYMMETRY),
    )  # fmt: skip
    with library.Mesh.of_cage(lib, cage) as mesh:
        with library.minimize(mesh, cage.positions, options) as result:
            summary = result.summary()
    return {
        "verdict": summary.verification.verdict, "symmetry_order": summary.symmetry_order,
        "negative_directions": summary.verification.negative_directions,
        "free_negative_directions": summary.free_negative_directions,
        "all_negative_directions": summary.all_negative_directions,
        "vertices": summary.n_vertices, "value": plain(summary.end.objective), "h2": plain(summary.end.h2),
        "quadrature_error": plain(summary.end.objective_error), "net_share": plain(summary.discretization_error),
    }  # fmt: skip


def shaken(store: Store, item: Item) -> dict[str, object]:
    """Minimizes again from the minimizer of item `of`, every vertex moved at random by `share` of the size in the
    mean, neighbours alike over as many edges as the root of `rounds` or so, no symmetry kept: where a saddle falls
    to."""
    inputs = item.inputs
    cage = store.cage(inputs["of"])
    size = np.sqrt(((cage.positions - cage.positions.mean(0)) ** 2).sum(1).mean())
    noise = np.random.default_rng(0).standard_normal((len(cage.positions), 3))
    shift = inputs["share"] * size * _smooth(cage, noise, inputs["rounds"])
    moved = Cage(cage.positions + shift, cage.face_sizes, cage.face_vertices)
    fields = {"threads": 1, "max_iterations": inputs["iterations"]}
    path: list[float] = []
    request = job.Request(inputs["energy"], 1, fields, symmetry="none")
    solution = job.solve(moved, request, lambda progress: path.append(progress.energy))
    store.save_cage(item.name, solution.cage)
    return {**figures(solution, inputs["energy"], "default"), "path": path, "from": inputs["of"]}


def _smooth(cage: Cage, field: np.ndarray, rounds: int) -> np.ndarray:
    """A field (n, 3) on the vertices, averaged over faces `rounds` times, so that it bends the shape rather than its
    skin, and made of unit mean square."""
    owner = np.repeat(np.arange(len(cage.face_sizes)), cage.face_sizes)
    corners = cage.face_vertices
    count = np.bincount(corners, minlength=len(field))[:, None]
    for _ in range(rounds):
        means = np.zeros((len(cage.face_sizes), 3))
        np.add.at(means, owner, field[corners])
        means /= cage.face_sizes[:, None]
        field = np.zeros_like(field)
        np.add.at(field, corners, means[owner])
        field /= count
    return field / np.sqrt((field**2).sum(1).mean())


def extrapolate(store: Store, item: Item) -> dict[str, object]:
    """int H^2 of Willmore's minimizer of the cage `of`, which nobody has published: from two levels, `levels` and one
    more, by the ratio at which their errors fall. That ratio is measured on the item's other cages, whose exact values
    are known; `tried` has each of these, predicted by the others' ratio, less its exact value."""
    pairs = {}
    for name, cage in item.cages.items():
        solved = [job.solve(cage, _willmore(item.inputs["levels"] + k)) for k in (0, 1)]
        pairs[name] = tuple(solution.end.h2 for solution in solved)
    known = {name: exact_h2(name)[0] for name in pairs if name != item.inputs["of"]}
    ratios = {name: (pairs[name][0] - exact) / (pairs[name][1] - exact) for name, exact in known.items()}

    def predicted(name: str) -> float:
        others = [ratio for other, ratio in ratios.items() if other != name]
        coarse, fine = pairs[name]
        return fine - (coarse - fine) / (float(np.mean(others)) - 1)

    tried = {name: predicted(name) - exact for name, exact in known.items()}
    return {"h2": predicted(item.inputs["of"]), "ratios": ratios, "tried": tried, "pairs": pairs}


def _willmore(levels: int) -> job.Request:
    return job.Request("willmore", levels, {"threads": 1}, symmetry=SYMMETRY)


KNOWN_H2: Mapping[str, float] = {
    "lawson_g2": 21.9085143681, "lawson_g3": 22.8202770937, "lawson_g5": 23.6413458093,
    "tetrahedral_g3": 23.3786593912, "cubical_g5": 24.5040762011, "sphere_cube": 4 * math.pi,
}  # fmt: skip


def exact_h2(cage_name: str) -> tuple[float, str] | None:
    """int H^2 of a cage's Willmore minimizer and where it is known from; None if it is not."""
    if cage_name.startswith("torus"):
        return 2 * math.pi**2, "Clifford torus, closed form"
    if cage_name in KNOWN_H2:
        return KNOWN_H2[cage_name], "closed form" if cage_name == "sphere_cube" else "literature, 12 digits"
    if cage_name.startswith("lawson_g"):
        return lawson_h2(int(cage_name[8:])), "interpolated in 1/(2g + 2) between genus 1, 2, 3, 5 and infinity"
    return None


_ZETA3 = 1.2020569031595943


def lawson_h2(genus: int, without: int = 0) -> float:
    """int H^2 of Lawson's surface xi_{genus,1}, its area in the unit 3-sphere.

    Heller, Heller, Traizet 2023 and Charlton, Heller, Heller, Traizet 2024 expand it in x = 1 / (2 genus + 2):
    8 pi (1 - ln 2 x - 9/4 zeta(3) x^3 - ...), odd powers only. What the other powers add, over x^3, is interpolated
    as a polynomial in x^2 through the known genera and 9/4 zeta(3) at x = 0. `without` leaves one known genus out, to
    see how well the rest predict it."""
    known = {1: 2 * math.pi**2, **{g: KNOWN_H2[f"lawson_g{g}"] for g in (2, 3, 5)}}
    known.pop(without, None)
    nodes = [(0.0, 2.25 * _ZETA3)]
    for other, value in known.items():
        x = 1 / (2 * other + 2)
        nodes.append((x * x, (1 - math.log(2) * x - value / (8 * math.pi)) / x**3))
    x = 1 / (2 * genus + 2)
    rest = sum(
        value * math.prod((x * x - other) / (node - other) for other, _ in nodes if other != node)
        for node, value in nodes
    )
    return 8 * math.pi * (1 - math.log(2) * x - rest * x**3)

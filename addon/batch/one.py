# SPDX-License-Identifier: GPL-3.0-or-later
"""One run of the batch command: a cage of the open file is minimized, and everything that was asked for is written.

Every output is first made beside its place under a temporary name, and all are moved there at the end. What a run that
was killed has left under such names is removed by the next one. Progress goes to stderr, and only to a terminal.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ..binding.library import CurvoptError
from ..binding.values import Cage, Energies, LevelReport, Progress, Verification
from ..core import job, messages
from ..core.energy import number_text
from ..core.go_through import Places
from ..render import before_after
from ..scene import placement, read_cage, read_marks, read_targets, write_result
from . import leftovers


class BatchError(messages.UserError):
    """The request cannot be carried out; the message is a sentence."""


def run(options: argparse.Namespace, also: dict[str, object] | None = None) -> str:
    """Minimize and write everything that was asked for, the report with what is `also` to be in it; what happened, in a
    sentence. Raises if anything fails."""
    fields = {"threads": options.threads, "max_iterations": options.max_iterations, "escape": int(options.escape)}
    fields["slide"], fields["no_crossings"] = int(options.slide), int(options.no_crossings)
    fields["spontaneous_curvature"] = options.spontaneous_curvature
    fields = {name: value for name, value in fields.items() if value is not None}
    wanted = {name: getattr(options, name) for name in ("output", "render", "json") if getattr(options, name)}
    with all_or_nothing(wanted) as place:
        obj = chosen_object(options.object)
        source = read_cage.read_source(bpy.context, obj)
        pin = "NOTHING" if options.pin_group is None else "GROUP"
        held = read_cage.read_held(obj, pin, options.pin_group, options.pin_surface)
        request = job.Request(
            options.energy, options.levels, fields, options.boundary, options.symmetry, held, options.strength,
            keeps_volume=options.keep_volume, within=options.within, records=options.animation,
        )  # fmt: skip
        request = source.fitted(request)
        request = job.with_marks(source.cage, request, *read_marks.read_marks(obj.data, source))
        weight = options.through_weight
        wanted = options.through, options.through_normals, options.through_balls
        places = read_targets.read_targets(bpy.context, *wanted, source, weight)
        request = replace(request, through=places.entries(source.cage), chains=places.chains)
        with _progress_on_terminal() as show:
            solution = _solve(source, request, places, show)
        new = write_result.add_result(bpy.context, source, request, solution)
        shown = placement.animate_run(bpy.context, new, source, solution)
        if "render" in place:
            _render(source, request, solution, options, place["render"])
        if "json" in place:
            found = {**(also or {}), **report(source, new.name, request, solution)}
            write_json(place["json"], found)
        if "output" in place:
            bpy.ops.wm.save_as_mainfile(filepath=str(place["output"]), copy=True, check_existing=False)
    verdict = messages.verdict_of(request, solution)
    in_mesh_numbers = source.layout.in_mesh_numbers
    held, folded = in_mesh_numbers(messages.exceptions_text(solution.exceptions)), in_mesh_numbers(messages.folds_text(solution))
    counted = messages.marks_text(request), messages.sliding_text(request, solution)
    counted = *counted, messages.contact_text(request, solution), messages.volume_text(request, solution), shown
    measured = messages.deviation_text(solution), messages.growth_text(request, solution), messages.crossings_text(solution)
    parts = messages.solution_text(request, solution), *counted, *measured, held, folded, verdict
    return "\n".join(part for part in parts if part)


def _solve(
    source: read_cage.Source, request: job.Request, places: Places, show: Callable[[Progress], None] | None
) -> job.Solution:
    """Run; a refusal of the library's names vertices as the mesh does, and what places are of. BatchError where the levels that were asked for
    move nothing, and more would."""
    try:
        levels = job.freed(source.cage, request).levels
        if levels > request.levels:
            raise BatchError(
                f"Nothing may move with --levels {request.levels}: boundary, creases or pins hold all vertices; use "
                f"--levels {levels}."
            )
        return job.solve(source.cage, request, show)
    except CurvoptError as error:
        raise places.named(source.named(error), source.cage) from error


def chosen_object(name: str | None) -> bpy.types.Object:
    """The object called `name`, else the active mesh object, else the only one. BatchError if there is none."""
    if name is not None:
        obj = bpy.context.scene.objects.get(name)
        if obj is None:
            raise BatchError(f"There is no object '{name}' in scene '{bpy.context.scene.name}'.")
        return obj
    active = bpy.context.view_layer.objects.active
    if active is not None and active.type == "MESH":
        return active
    meshes = [obj for obj in bpy.context.scene.objects if obj.type == "MESH"]
    if len(meshes) != 1:
        raise BatchError(f"Scene '{bpy.context.scene.name}' has {len(meshes)} mesh objects, none active: use --object.")
    return meshes[0]


def write_json(path: Path, report: dict[str, object]) -> None:
    """A new file: never through a link that somebody put there."""
    with path.open("x", encoding="utf-8") as file:
        file.write(json.dumps(report, indent=2) + "\n")


@contextmanager
def all_or_nothing(wanted: dict[str, Path]) -> Iterator[dict[str, Path]]:
    """Temporary paths beside the wanted ones; moved there if all goes well and removed if not.

    BatchError, before any work is done, if a file cannot be made there."""
    place = {}
    for name, path in wanted.items():
        path = path.parent.resolve() / path.name  # a link itself is replaced, not what it leads to
        place[name] = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
        leftovers.remove(path)
        try:
            if path.is_dir():
                raise IsADirectoryError(0, "it is a folder")
            place[name].touch(exist_ok=False)
            place[name].unlink()
        except OSError as error:
            raise BatchError(f"{path} cannot be written: {error.strerror}.") from error
    try:
        yield place
        for name, temporary in place.items():
            if not temporary.is_file() or temporary.stat().st_size == 0:
                raise BatchError(f"{wanted[name]} could not be written.")
        for name, temporary in place.items():
            os.replace(temporary, wanted[name])
    finally:
        for temporary in place.values():
            temporary.unlink(missing_ok=True)


def _render(
    source: read_cage.Source, request: job.Request, solution: job.Solution, options: argparse.Namespace, path: Path
) -> None:
    """The picture of --render, before and after, in the world's orientation."""
    rotation = np.array(source.frame.to_3x3(), np.float64)
    shapes = []
    for when, cage, energies in (("Before", source.cage, solution.start), ("After", solution.cage, solution.end)):
        world = replace(cage, positions=cage.positions @ rotation.T)
        shapes.append((world, f"{when}: {request.label} {number_text(energies.objective)}"))
    picture = before_after.Picture(*options.size, options.samples, options.engine, options.look)
    before_after.render_side_by_side(shapes, path, picture)


def report(
    source: read_cage.Source, result_name: str, request: job.Request, solution: job.Solution
) -> dict[str, object]:
    """What --json writes: the command line's keys for the result, `before` the same for the original."""
    return {
        "object": source.name,
        "result": result_name,
        "energy": request.energy,
        "strength": request.strength,
        "within": request.within,
        "keep_volume": request.keeps_volume,
        "boundary": request.boundary,
        "symmetry_order": solution.symmetry_order,
        **_energies(solution.end, solution.cage, solution.euler),
        "before": _energies(solution.start, source.cage, solution.euler),
        "levels": [_level(level) for level in solution.levels],
        "stop": solution.stop,
        "seconds": solution.seconds,
        "multipliers": _finite(solution.multipliers),
        "scalar_residuals": _finite(solution.scalar_residuals),
        **_finite({"discretization_error": solution.discretization_error}),
        **_contact(request, solution),
        "n_held": solution.exceptions.n_held,
        "n_left_out": solution.exceptions.n_left_out,
        "n_folded": len(solution.folded),
        "n_unfolded": solution.n_unfolded,
        "verification": _verification(solution.verification),
        "verdict": messages.verdict_of(request, solution),
        **_measures(solution),
    }


def _contact(request: job.Request, solution: job.Solution) -> dict[str, object]:
    """Of No Crossings, as the command line writes it, but for pairs of the original that cross; empty without it."""
    if not request.options.get("no_crossings"):
        return {}
    found = {**_finite({"clearance": solution.clearance}), "touching": [list(pair) for pair in solution.touching]}
    return {"no_crossings": {**found, "n_crossings_before": solution.n_crossing_before}}


def _measures(solution: job.Solution) -> dict[str, object]:
    """As the command line writes it; pairs are faces of the result. Empty for a cancelled run."""
    far, crossed = solution.deviation, solution.crossings
    if far is None or crossed is None:
        return {}
    return {
        "deviation": {"max": far.max, "rms": far.rms, "bound": far.bound, "size": far.size},
        "n_crossings": crossed.n_pairs,
        "n_contacts": crossed.n_contacts,
        "n_unresolved": crossed.n_unresolved,
        "crossings": crossed.pairs[:1000].tolist(),
    }


def _verification(found: Verification) -> dict[str, object]:
    """As the command line writes it."""
    return {
        "verdict": found.verdict,
        "newton_decrement": found.newton_decrement if math.isfinite(found.newton_decrement) else None,
        "negative_directions": found.negative_directions if found.negative_directions >= 0 else None,
        **_finite({"touch_rise": found.touch_rise}),
        "delicate": found.is_delicate,
    }


def _level(level: LevelReport) -> dict[str, object]:
    values = dict(vars(level))
    return {"level": values.pop("level"), "vertices": values.pop("n_vertices"), **values}


def _finite(values: Mapping[str, float]) -> dict[str, float | None]:
    """The numbers as JSON has them."""
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def _energies(energies: Energies, cage: Cage, euler: int) -> dict[str, object]:
    values = {
        **energies.terms,
        "area": energies.area,  # in squared units, not the term of that name
        "volume": energies.volume,
        "reduced_volume": energies.reduced_volume,
        "total_mean_curvature": energies.total_mean_curvature,
        "helfrich": energies.helfrich,
        "h2": energies.h2,
        "gauss": energies.gauss,
        "gauss_bonnet_defect": energies.gauss_bonnet_defect,
        "quadrature_error": energies.objective_error,
    }
    return {
        "vertices": len(cage.positions),
        "faces": len(cage.face_sizes),
        "euler": euler,
        **_finite(values),
        "surface": energies.surface,
    }


@contextmanager
def _progress_on_terminal() -> Iterator[Callable[[Progress], None] | None]:
    """A callback that keeps one line of stderr up to date, or None if stderr is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return

    def show(progress: Progress) -> None:
        print(f"\r\033[K{messages.progress_text(progress)}", end="", file=sys.stderr, flush=True)

    try:
        yield show
    finally:
        print(file=sys.stderr)


def failure_text(error: Exception) -> str | None:
    """What to tell people of a failure; None for one that is a fault of the program."""
    if messages.is_foreseen(error) or isinstance(error, OSError):
        return messages.failure_text(error)
    if isinstance(error, RuntimeError):  # Blender's own refusals
        return messages.sentence(f"Could not finish: {error}")
    return None

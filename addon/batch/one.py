# SPDX-License-Identifier: GPL-3.0-or-later
r"""Minimize without a window:

    blender -b FILE.blend --python-exit-code 1 -P batch.py -- \
        --energy mvs --levels 4 --output OUT.blend --render OUT.png

or, many at once, `blender -b -P addon/batch.py -- FILE.blend ... --into DIR --energy mvs --energy willmore ...`

Exit code 0: done, 1: could not (one sentence on stderr, nothing written), 2: wrong usage. Every output is first made
beside its place under a temporary name, and all are moved there at the end. Progress goes to stderr, and only to a
terminal. Run with -P this file is no part of a package: see parts.py.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

if __package__:
    from .parts import part as _part
else:
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    from parts import part as _part

if TYPE_CHECKING:
    from .cage import Source
    from .job import Request, Solution
    from .values import Cage, Energies, LevelReport, Progress, Verification


class BatchError(RuntimeError):
    """The request cannot be carried out; the message is a sentence."""


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line behind `--`. Exits with 2 if it is wrong."""
    parser = argparse.ArgumentParser(prog="batch.py", description="Minimize the energy of a cage in a .blend file.")
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.blend", help="with --into: what to work on")
    parser.add_argument(
        "--into", type=Path, metavar="DIR",
        help="every file, object, energy and number of levels: one .blend and .json each in this folder. What is there "
        "and of the same input and settings is skipped, what fails is reported and the rest goes on",
    )  # fmt: skip
    parser.add_argument("--all-objects", action="store_true", help="with --into: every mesh object of the scene")
    parser.add_argument(
        "--energy", type=_energy, action="append",
        help=f"{', '.join(_part('energy').ENERGY_LABELS)}, or a mix such as mvs:1,willmore:0.1 (default mvs); again "
        "for more with --into",
    )  # fmt: skip
    parser.add_argument(
        "--levels", type=int, action="append",
        help="optimizations, subdividing between them (default 4); again for more with --into",
    )  # fmt: skip
    parser.add_argument(
        "--boundary", choices=_part("header").BOUNDARIES, default="position", help="what stays (default %(default)s)"
    )
    parser.add_argument(
        "--symmetry", type=_symmetry, default="keep", metavar="{auto,none,rotations,keep,PLANES}",
        help="of the cage: all kept (the default), kept where that pays, turns alone kept, not looked for, or mirror "
        "planes of the object's axes and no others, such as x or y,z",
    )
    parser.add_argument("--escape", action="store_true", help="leave saddles of the shape, downwards")
    parser.add_argument(
        "--pin-group", metavar="NAME", help="weights in this vertex group say how firmly vertices are held, 1: exactly"
    )
    parser.add_argument(
        "--object", metavar="NAME", action="append",
        help="the object (default: the active or the only mesh object); again for more with --into",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, metavar="OUT.blend", help="where to save the file with the result")
    parser.add_argument("--render", type=Path, metavar="OUT.png", help="picture, before and after side by side")
    parser.add_argument("--json", type=Path, metavar="OUT.json", help="report of energies, levels and times")
    parser.add_argument("--threads", type=int, help="threads of the optimization (default: all cores)")
    parser.add_argument("--max-iterations", type=int, help="iterations per level")
    picture = parser.add_argument_group("picture")
    picture.add_argument("--look", choices=("clay", "zebra"), default="clay", help="surface (default %(default)s)")
    picture.add_argument("--engine", choices=("cycles", "workbench"), default="cycles", help="(default %(default)s)")
    picture.add_argument("--samples", type=_count, default=64, help="Cycles samples per pixel (default %(default)s)")
    picture.add_argument("--size", type=_size, default=(1400, 700), metavar="WxH", help="pixels (default 1400x700)")
    options = parser.parse_args(arguments)
    options.energy, options.levels = options.energy or ["mvs"], options.levels or [4]
    options.object = options.object or [None]
    if options.into:
        if not options.files or options.output or options.render or options.json:
            parser.error("--into wants files, and neither --output, --render nor --json")
        return options
    if options.files or options.all_objects or max(map(len, (options.energy, options.levels, options.object))) > 1:
        parser.error("several files, objects, energies or levels need --into")
    if not (options.output or options.render or options.json):
        parser.error("nothing to do: give --output, --render or --json, or --into")
    options.energy, options.levels, options.object = options.energy[0], options.levels[0], options.object[0]
    return options


def _energy(text: str) -> str:
    try:
        _part("energy").weights_of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _symmetry(text: str) -> str:
    try:
        _part("job").symmetry_of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _count(text: str) -> int:
    if not (text.isdigit() and 1 <= int(text) <= 1_000_000):
        raise argparse.ArgumentTypeError(f"{text!r} is no count")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and 1 <= int(width) <= 20000 and 1 <= int(height) <= 20000):
        raise argparse.ArgumentTypeError(f"{text!r} is no size such as 1400x700")
    return int(width), int(height)


def run(options: argparse.Namespace, also: dict[str, object] | None = None) -> str:
    """Minimize and write everything that was asked for, the report with what is `also` to be in it; what happened, in a
    sentence. Raises if anything fails."""
    job, cage, result = _part("job"), _part("cage"), _part("result")
    limits = {"threads": options.threads, "max_iterations": options.max_iterations, "escape": int(options.escape)}
    limits = {name: value for name, value in limits.items() if value is not None}
    wanted = {name: getattr(options, name) for name in ("output", "render", "json") if getattr(options, name)}
    with _all_or_nothing(wanted) as place:
        obj = chosen_object(options.object)
        source = cage.read_source(bpy.context, obj)
        keep = "NOTHING" if options.pin_group is None else "GROUP"
        held = cage.read_held(obj, keep, options.pin_group)
        request = job.Request(options.energy, options.levels, limits, options.boundary, options.symmetry, held)
        with _progress_on_terminal() as show:
            solution = job.solve(source.cage, request, show)
        new = result.add_result(bpy.context, source, request, solution)
        if "render" in place:
            _render(source, request, solution, options, place["render"])
        if "json" in place:
            found = {**(also or {}), **report(source, new.name, request, solution)}
            place["json"].write_text(json.dumps(found, indent=2) + "\n")
        if "output" in place:
            bpy.ops.wm.save_as_mainfile(filepath=str(place["output"]), copy=True, check_existing=False)
    verdict = job.verdict_text(solution.verification, solution.end.objective, solution.symmetry_order)
    return f"{job.solution_text(request, solution)}\n{verdict}"


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


@contextmanager
def _all_or_nothing(wanted: dict[str, Path]) -> Iterator[dict[str, Path]]:
    """Temporary paths beside the wanted ones; moved there if all goes well and removed if not.

    BatchError, before any work is done, if a file cannot be made there."""
    place = {}
    for name, path in wanted.items():
        path = path.resolve()
        place[name] = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
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


def _render(source: Source, request: Request, solution: Solution, options: argparse.Namespace, path: Path) -> None:
    render, number_text = _part("render"), _part("energy").number_text
    rotation = np.array(source.frame.to_3x3(), np.float64)
    shapes = []
    for when, cage, energies in (("Before", source.cage, solution.start), ("After", solution.cage, solution.end)):
        world = replace(cage, positions=cage.positions @ rotation.T)
        shapes.append((world, f"{when}: {request.label} {number_text(energies.objective)}"))
    picture = render.Picture(*options.size, options.samples, options.engine, options.look)
    render.render_side_by_side(shapes, path, picture)


def report(source: Source, result_name: str, request: Request, solution: Solution) -> dict[str, object]:
    """What --json writes: the command line's keys for the result, `before` the same for the original."""
    return {
        "object": source.name,
        "result": result_name,
        "energy": request.energy,
        "boundary": request.boundary,
        "symmetry_order": solution.symmetry_order,
        **_energies(solution.end, solution.cage, solution.euler),
        "before": _energies(solution.start, source.cage, solution.euler),
        "levels": [_level(level) for level in solution.levels],
        "stop": solution.stop,
        "seconds": solution.seconds,
        "verification": _verification(solution.verification),
    }


def _verification(found: Verification) -> dict[str, object]:
    """As the command line writes it."""
    return {
        "verdict": found.verdict,
        "newton_decrement": found.newton_decrement if math.isfinite(found.newton_decrement) else None,
        "negative_directions": found.negative_directions if found.negative_directions >= 0 else None,
    }


def _level(level: LevelReport) -> dict[str, object]:
    values = dict(vars(level))
    return {"level": values.pop("level"), "vertices": values.pop("n_vertices"), **values}


def _energies(energies: Energies, cage: Cage, euler: int) -> dict[str, object]:
    values = {
        **energies.terms,
        "area": energies.area,  # in squared units, not the term of that name
        "h2": energies.h2,
        "gauss": energies.gauss,
        "gauss_bonnet_defect": energies.gauss_bonnet_defect,
        "quadrature_error": energies.objective_error,
    }
    return {
        "vertices": len(cage.positions),
        "faces": len(cage.face_sizes),
        "euler": euler,
        **{name: value if math.isfinite(value) else None for name, value in values.items()},
        "surface": energies.surface,
    }


@contextmanager
def _progress_on_terminal() -> Iterator[Callable[[Progress], None] | None]:
    """A callback that keeps one line of stderr up to date, or None if stderr is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    text = _part("job").progress_text

    def show(progress: Progress) -> None:
        print(f"\r\033[K{text(progress)}", end="", file=sys.stderr, flush=True)

    try:
        yield show
    finally:
        print(file=sys.stderr)


def sentence_of(error: Exception) -> str | None:
    """What to tell people of a failure; None for one that is a fault of the program."""
    native, job, cage, render = _part("native"), _part("job"), _part("cage"), _part("render")
    foreseen = (BatchError, cage.CageError, render.RenderError, native.LibraryError, native.CurvoptError, ValueError)
    if isinstance(error, foreseen):
        return job.sentence(job.in_blender(str(error)))
    if isinstance(error, (OSError, RuntimeError)):  # the system's and Blender's own refusals
        return job.sentence(f"Could not finish: {error}")
    return None


def main(arguments: list[str]) -> int:
    """The exit code."""
    options = parse(arguments)
    try:
        if options.into:
            return _part("many").run_all(options, run, sentence_of)
        print(run(options))
    except Exception as error:
        text = sentence_of(error)
        if text is None:
            traceback.print_exc()
        else:
            print(text, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))

# SPDX-License-Identifier: GPL-3.0-or-later
r"""The command line of the batch command, which minimizes without a window:

    blender -b FILE.blend --python-exit-code 1 -P addon/batch.py -- \
        --energy mvs --levels 4 --output OUT.blend --render OUT.png

or, many at once, `blender -b -P addon/batch.py -- FILE.blend ... --into DIR --energy mvs --energy willmore ...`

Exit code 0: done, 1: could not (one sentence on stderr, nothing written), 2: wrong usage.
"""

from __future__ import annotations

import argparse
import sys
import traceback
from pathlib import Path

from ..binding.abi import BOUNDARIES, DEFAULTS
from ..core.energy import ENERGY_LABELS, weights_of
from ..core.job import symmetry_of
from ..render.studio import ENGINES, LOOKS
from . import many, one


def _parser() -> argparse.ArgumentParser:
    """Every option with its help."""
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
        help=f"{', '.join(ENERGY_LABELS)}, or a mix such as mvs:1,willmore:0.1 (default {DEFAULTS.energy}); again for "
        "more with --into",
    )  # fmt: skip
    parser.add_argument(
        "--levels", type=int, action="append",
        help=f"optimizations, subdividing between them (default {DEFAULTS.levels}); again for more with --into",
    )  # fmt: skip
    parser.add_argument(
        "--strength", type=float, default=DEFAULTS.strength, metavar="S",
        help="how much of the shape may go, 0.001 to 1. Below 1 the surface stays near the original: waves shorter "
        "than S / (1 - S) times the cage's RMS radius go, longer ones stay; the panel in Blender begins with 0.3. 1 is the "
        "minimum of the energy (default %(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--within", type=float, default=DEFAULTS.within, metavar="D",
        help="no vertex and no point of the surface gets farther than this from where it was, in units of the scene",
    )
    parser.add_argument(
        "--animation", action="store_true",
        help="the result has the way from the original as shape keys with keyframes, from the frame after the current one on",
    )
    parser.add_argument(
        "--keep-volume", action="store_true",
        help="the result has the volume of the original; an open surface keeps that between it and its boundary, which must "
        "stay. At strength 1 without pins this only sets the size of the result",
    )  # fmt: skip
    parser.add_argument(
        "--boundary", choices=BOUNDARIES, default=DEFAULTS.boundary,
        help="what an open surface keeps (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--slide", action="store_true",
        help="vertices on boundaries and infinitely sharp creases that --boundary keeps move along these; curves stay",
    )  # fmt: skip
    parser.add_argument(
        "--no-crossings", action="store_true",
        help="the surface comes to cross itself nowhere: faces that are no neighbours repel each other when they come close",
    )  # fmt: skip
    parser.add_argument(
        "--symmetry", type=_symmetry, default=DEFAULTS.symmetry, metavar="{auto,keep,rotations,none,PLANES}",
        help="of the cage: keep them all; auto: likewise, but give some up where that lowers a third-order energy by 6 "
        "%% or more for each halving; rotations alone; none; or reflections across axes of the object and no others, "
        "such as x or y,z (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--escape", action="store_true", help="leave a result that is a saddle among shapes of less symmetry"
    )
    parser.add_argument(
        "--pin-group", metavar="NAME", help="pin vertices by their weights in this vertex group: 1 is exact, 0 is free"
    )
    parser.add_argument(
        "--pin-surface", action="store_true", help="pin the points of the surface that belong to these vertices instead"
    )
    parser.add_argument(
        "--spontaneous-curvature", type=float, metavar="C", default=DEFAULTS.spontaneous_curvature,
        help="of bending energy, in 1 / units: a sphere of radius R has 2 / R (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--through", metavar="COLLECTION", default="",
        help="go through the empties of this collection, the vertices of its meshes, and points along its curves; a curve that has "
        "the name of a vertex group is followed by the chain of edges of that group",
    )  # fmt: skip
    parser.add_argument(
        "--through-weight", type=_weight, default=1.0, metavar="W",
        help="how firmly, 0.01 to 1. 1: exactly; less: springs draw the surface there (default %(default)g)",
    )
    parser.add_argument(
        "--through-normals", action="store_true",
        help="with the Z axes of the empties and the meshes' attribute curvopt_normal as normals of the surface",
    )  # fmt: skip
    parser.add_argument(
        "--through-balls", action="store_true",
        help="empties that are shown as spheres are balls, or ellipsoids: the surface touches each at the tip of its Z axis, and "
        "is curved like it there",
    )  # fmt: skip
    parser.add_argument(
        "--object", metavar="NAME", action="append",
        help="the object (default: the active or the only mesh object); again for more with --into",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, metavar="OUT.blend", help="where to save the file with the result")
    parser.add_argument("--render", type=Path, metavar="OUT.png", help="picture, before and after side by side")
    parser.add_argument("--json", type=Path, metavar="OUT.json", help="report of energies, levels and times")
    parser.add_argument("--threads", type=int, help="threads of the optimization (default: all cores)")
    parser.add_argument(
        "--max-iterations", type=int, help=f"largest number of steps of a level (default {DEFAULTS.max_iterations})"
    )
    picture = parser.add_argument_group("picture")
    picture.add_argument("--look", choices=LOOKS, default="clay", help="surface (default %(default)s)")
    picture.add_argument("--engine", choices=tuple(ENGINES), default="cycles", help="(default %(default)s)")
    picture.add_argument("--samples", type=_count, default=64, help="Cycles samples per pixel (default %(default)s)")
    picture.add_argument("--size", type=_size, default=(1400, 700), metavar="WxH", help="pixels (default 1400x700)")
    return parser


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line behind `--`. Exits with 2 if it is wrong."""
    parser = _parser()
    options = parser.parse_args(arguments)
    options.energy, options.levels = options.energy or [DEFAULTS.energy], options.levels or [DEFAULTS.levels]
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
    """An energy or a mix, checked. ArgumentTypeError, as below."""
    try:
        weights_of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _weight(text: str) -> float:
    """0.01 .. 1"""
    try:
        weight = float(text)
    except ValueError:
        weight = 0.0
    if not 0.01 <= weight <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no weight: it must be 0.01 to 1")
    return weight


def _symmetry(text: str) -> str:
    """A symmetry or mirror planes, checked."""
    try:
        symmetry_of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _count(text: str) -> int:
    """1 .. 1 000 000"""
    if not (text.isdigit() and 1 <= int(text) <= 1_000_000):
        raise argparse.ArgumentTypeError(f"{text!r} is no count")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    """Width and height, 1 .. 20 000 each."""
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and 1 <= int(width) <= 20000 and 1 <= int(height) <= 20000):
        raise argparse.ArgumentTypeError(f"{text!r} is no size such as 1400x700")
    return int(width), int(height)


def main(arguments: list[str]) -> int:
    """Do what the command line behind `--` asks for; the exit code."""
    options = parse(arguments)
    try:
        if options.into:
            return many.run_all(options)
        print(one.run(options))
    except Exception as error:
        text = one.failure_text(error)
        if text is None:
            traceback.print_exc()
        else:
            print(text, file=sys.stderr)
        return 1
    return 0

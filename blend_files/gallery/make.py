# SPDX-License-Identifier: GPL-3.0-or-later
r"""The report's tables, figures and open questions, from the committed cages, as one HTML page:

    blender -b --factory-startup --python-exit-code 1 -P blend_files/gallery/make.py -- --output DIR \
        [--only NAME ...] [--jobs N] [--publish DIR]

What is finished in DIR, and whose inputs, code and library have not changed, is not made again; a run that is killed
loses the items in work and nothing else. Exit code 0: done, 1: something could not be made (said on stderr), 2: wrong
usage.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

if not __package__:  # Blender runs this file with -P, outside of any package
    sys.path[:0] = [str(Path(__file__).resolve().parents[level]) for level in (2, 1)]

from addon.binding import library  # noqa: E402
from addon.binding.values import Cage  # noqa: E402
from addon.core.messages import UserError, failure_text  # noqa: E402
from addon.scene.read_cage import read_faces, read_positions  # noqa: E402
from gallery import constrained_pictures, contents, genus_pictures, page, pair_pictures, pictures, publish, schedule  # noqa: E402
from gallery import store as stored  # noqa: E402


class GalleryError(UserError):
    """The gallery cannot be made; the message is a sentence."""


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line behind `--`. Exits with 2 if it is wrong."""
    names = (*contents.GROUPS, *contents.all_cages())
    parser = argparse.ArgumentParser(prog="make.py", description="Make the gallery, or what of it is missing.")
    parser.add_argument("--output", type=Path, required=True, metavar="DIR", help="where the gallery is, or is to be")
    parser.add_argument(
        "--only", nargs="+", choices=names, metavar="NAME",
        help=f"only the README's pictures ({contents.README}), these tables ({', '.join(contents.TABLES)}), {contents.PAIRS}, "
        f"{contents.CONSTRAINED}, figures, answers ({', '.join(contents.ANSWERS)}; all of them: answers) or rows of tables, by their "
        f"cages; or the campaign behind the answer holes ({contents.CAMPAIGN}: an hour of two cores, DIR/genus.csv), which is not made "
        "without being asked for",
    )  # fmt: skip
    parser.add_argument("--jobs", type=_count, default=os.cpu_count(), metavar="N",
                        help="calculations at a time (default: one a core)")  # fmt: skip
    measure = contents.Measure()
    parser.add_argument("--levels", type=_level, default=measure.levels, help="of the tables (default %(default)s)")
    parser.add_argument("--width", type=_count, default=measure.width, help="pixels of a cell (default %(default)s)")
    parser.add_argument("--samples", type=_count, default=measure.samples, help="a pixel (default %(default)s)")
    parser.add_argument("--publish", type=Path, metavar="DIR",
                        help="where the README's pictures go, with a stamp of their figures (blend_files/pictures)")  # fmt: skip
    parser.add_argument("--cages", type=Path, metavar="DIR", default=Path(__file__).resolve().parents[1],
                        help="the .blend files and cages.py (default: blend_files)")  # fmt: skip
    return parser.parse_args(arguments)


def _count(text: str) -> int:
    if not (text.isdigit() and 1 <= int(text) <= 10_000):
        raise argparse.ArgumentTypeError(f"{text!r} is no count")
    return int(text)


def _level(text: str) -> int:
    if not (text.isdigit() and 1 <= int(text) <= 5):
        raise argparse.ArgumentTypeError(f"{text!r} is not 1 to 5")
    return int(text)


def read_cage(folder: Path, name: str) -> Cage:
    """The cage of FOLDER/NAME.blend. GalleryError if there is none."""
    path = folder / f"{name}.blend"
    if not path.is_file():
        raise GalleryError(f"The cage {path} is missing.")
    with bpy.data.libraries.load(str(path)) as (there, here):
        here.objects = [found for found in there.objects if found == name]
    if not here.objects:
        raise GalleryError(f"{path} holds no object '{name}'.")
    obj = here.objects[0]
    try:
        return Cage(read_positions(obj.data), *read_faces(obj.data))
    finally:
        mesh = obj.data
        bpy.data.objects.remove(obj)
        bpy.data.meshes.remove(mesh)


def cage_maker(folder: Path) -> Callable[..., Cage]:
    """Calls a function of FOLDER/cages.py by name; what it makes as a Cage. GalleryError if that file is missing."""
    path = folder / "cages.py"
    if not path.is_file():
        raise GalleryError(f"{path} is missing.")
    spec = importlib.util.spec_from_file_location("curvopt_cages", path)
    sys.modules["curvopt_cages"] = cages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(cages)

    def call(kind: str, *arguments: object, **changes: object) -> Cage:
        vertices, faces = getattr(cages, kind)(*arguments, **changes)
        sizes = np.array([len(face) for face in faces], np.int32)
        return Cage(vertices, sizes, np.concatenate([np.array(face, np.int32) for face in faces]))

    return call


def make(options: argparse.Namespace) -> bool:
    """Make what was asked for and the page; whether nothing failed."""
    lib = library.load()
    start = time.monotonic()
    store = stored.Store(options.output.resolve(), stored.library_version(lib.path, lib.version))
    cages = {name: read_cage(options.cages, name) for name in contents.all_cages()}
    measure = contents.Measure(options.levels, options.width, options.samples)
    draw = {**pictures.DRAW, **constrained_pictures.DRAW, **genus_pictures.DRAW, "pair": pair_pictures.draw}
    items = contents.items(cages, cage_maker(options.cages), measure, draw)
    asked = set(options.only or set(contents.GROUPS) - {contents.CAMPAIGN})
    wanted = [item.name for item in items if item.tags & asked]
    with _quiet_blender() as say:
        outcome = schedule.run(schedule.with_needs(items, wanted), store, options.jobs, say)
    keys = stored.keys(items, store.version)
    by_name = {item.name: item for item in items if contents.CAMPAIGN not in item.tags}
    fresh = {name for name, item in by_name.items() if store.fresh(item, keys[name])}
    index = page.write(store, fresh, by_name)
    if options.publish:
        publish.publish(store, by_name, fresh, options.publish)
    for name, why in outcome.failed.items():
        print(f"gallery: {name} could not be made: {why}", file=sys.stderr)
    counts = f"{len(outcome.made)} made, {len(outcome.fresh)} finished before, {len(outcome.failed)} failed"
    _say(sys.stdout.fileno(), f"{counts}, {time.monotonic() - start:.0f} s: {index}")
    return not outcome.failed


@contextmanager
def _quiet_blender() -> Iterator[Callable[[str], None]]:
    """Keeps what Blender says of every step of every render off standard output; the gallery's own lines are for the
    function that this gives."""
    out = sys.stdout.fileno()
    sys.stdout.flush()
    kept, nowhere = os.dup(out), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, out)
    try:
        yield lambda text: _say(kept, text)
    finally:
        sys.stdout.flush()
        os.dup2(kept, out)
        os.close(kept)
        os.close(nowhere)


def _say(out: int, text: str) -> None:
    """A line of progress, at once."""
    os.write(out, f"gallery: {text}\n".encode())


def main(arguments: list[str]) -> int:
    """The exit code."""
    options = parse(arguments)
    try:
        return 0 if make(options) else 1
    except (GalleryError, library.LibraryError, library.CurvoptError, OSError) as error:
        print(failure_text(error), file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Many files, objects, energies and levels, one after the other: `--into` of the batch command.

Each combination gives NAME.blend with the result and NAME.json with its report, whose `input` says what it was made
from. A second call skips those whose `input` is the same, so that an interrupted batch goes on where it was. A failure
gives NAME.json with `error`, and is tried again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy

from ..core import messages
from . import one


def run_all(options: argparse.Namespace) -> int:
    """Do everything; 1 if anything failed, else 0. One line on stdout for each, failures on stderr as well."""
    options.into.mkdir(parents=True, exist_ok=True)
    done, skipped, failures, names = 0, 0, [], {}
    for wanted, about in _combinations(options, failures):
        if names.setdefault(wanted.json.stem.casefold(), about) != about:
            failures.append(f"{about['file']}, {about['object']}: its files would have the names of another one's, {wanted.json.stem}")
            print(f"failed {failures[-1]}", flush=True)
            continue
        if _finished(wanted, about):
            print(f"skipped {wanted.json.stem}: it is there already")
            skipped += 1
            continue
        try:
            _open(about["file"])
            print(f"done {wanted.json.stem}: {one.run(wanted, {'input': about})}".replace("\n", " "), flush=True)
            done += 1
        except Exception as error:
            text = one.failure_text(error)
            if text is None:
                traceback.print_exc()
                text = messages.failure_text(error)
            failures.append(f"{wanted.json.stem}: {text}")
            wanted.output.unlink(missing_ok=True)
            _note(wanted.json, {"input": about, "error": text}, failures)
            print(f"failed {wanted.json.stem}: {text}", flush=True)
    print(f"{done} done, {skipped} skipped, {len(failures)} failed")
    for failure in failures:
        print(failure, file=sys.stderr)
    return 1 if failures else 0


def _note(path: Path, report: dict[str, object], failures: list[str]) -> None:
    """Write a failure's report, whole or not at all; that it could not be written is one more failure."""
    try:
        with one.all_or_nothing({"json": path}) as place:
            one.write_json(place["json"], report)
    except (one.BatchError, OSError) as error:
        failures.append(f"{path.name}: {error}")


def _open(path: str) -> None:
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)


def _combinations(
    options: argparse.Namespace, failures: list[str]
) -> Iterator[tuple[argparse.Namespace, dict[str, object]]]:
    """(options of one run, what its report says of its input); files that cannot be read go to `failures`."""
    for path in options.files:
        try:
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            _open(str(path.resolve()))
        except (OSError, RuntimeError) as error:
            failures.append(f"{path}: it cannot be read: {' '.join(str(error).split())}")
            print(f"failed {failures[-1]}", flush=True)
            continue
        names = [obj.name for obj in bpy.context.scene.objects if obj.type == "MESH"]
        for name in names if options.all_objects else options.object:
            for energy in options.energy:
                for levels in options.levels:
                    yield _combination(options, path.resolve(), digest, name, energy, levels)


def _combination(
    options: argparse.Namespace, path: Path, digest: str, name: str | None, energy: str, levels: int
) -> tuple[argparse.Namespace, dict[str, object]]:
    parts = [path.stem, *([name] if name else []), energy, str(levels)]
    stem = "-".join(re.sub(r"[^\w.]+", "_", part) for part in parts)
    settings = "strength boundary symmetry pin_group pin_surface through through_normals through_balls through_weight threads max_iterations escape slide keep_volume within no_crossings spontaneous_curvature animation".split()
    about = {
        "file": str(path), "sha256": digest, "object": name, "energy": energy, "levels": levels,
        **{setting: getattr(options, setting) for setting in settings},
    }  # fmt: skip
    wanted = argparse.Namespace(**vars(options))
    wanted.object, wanted.energy, wanted.levels, wanted.render = name, energy, levels, None
    wanted.output, wanted.json = options.into / f"{stem}.blend", options.into / f"{stem}.json"
    return wanted, about


def _finished(wanted: argparse.Namespace, about: dict[str, object]) -> bool:
    """Whether both files are there, and of the same input and settings."""
    try:
        found = json.loads(wanted.json.read_text())
    except (OSError, ValueError):
        return False
    return found.get("input") == about and "error" not in found and wanted.output.is_file()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Presses Minimize in Blender, with default settings, on what people start from, and makes a table of what came out.

    python3 tests/corpus/press.py run --output OUT.jsonl [--corpus DIR] [--pictures DIR]
    python3 tests/corpus/press.py table OUT.jsonl

Shapes are Blender's primitives, Suzanne, and the OBJ files of a folder: OpenSubdiv's regression shapes, with their tags
as far as Blender has them (tagged.py). Each is pressed at each energy. A run that takes longer than the limit ends as by
Enter; one that does not end then is killed, and the others go on in another Blender, as after a crash. `run` does what
the output does not have yet. Pictures have both limit surfaces side by side.
"""
from __future__ import annotations

import argparse
import json
import math
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Iterable, Sequence

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent / "addon")]

from run_in_blender import NAME, blender_environment, install_folder  # noqa: E402
from tables import quantile, table  # noqa: E402

Record = dict[str, Any]
Run = tuple[str, str]  # shape, energy
ENERGIES = ("willmore", "mvs")
GRACE = 30  # seconds from the limit to the kill: the last step, and the pictures
NO_RESULT = ("refused", "failed", "crashed", "hangs")

# Operators of the Add menu, their arguments, and settings of a curve before it is converted to a mesh.
PRIMITIVES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "plane": ("mesh.primitive_plane_add", {}, {}),
    "grid": ("mesh.primitive_grid_add", {}, {}),
    "circle, n-gon": ("mesh.primitive_circle_add", {"fill_type": "NGON"}, {}),
    "circle, triangle fan": ("mesh.primitive_circle_add", {"fill_type": "TRIFAN"}, {}),
    "circle, not filled": ("mesh.primitive_circle_add", {}, {}),
    "cube": ("mesh.primitive_cube_add", {}, {}),
    "cylinder": ("mesh.primitive_cylinder_add", {}, {}),
    "cylinder, triangle fans": ("mesh.primitive_cylinder_add", {"end_fill_type": "TRIFAN"}, {}),
    "cylinder, open": ("mesh.primitive_cylinder_add", {"end_fill_type": "NOTHING"}, {}),
    "cone": ("mesh.primitive_cone_add", {}, {}),
    "UV sphere": ("mesh.primitive_uv_sphere_add", {}, {}),
    "ico sphere": ("mesh.primitive_ico_sphere_add", {}, {}),
    "torus": ("mesh.primitive_torus_add", {}, {}),
    "Suzanne": ("mesh.primitive_monkey_add", {}, {}),
    "text": ("object.text_add", {}, {}),
    "text, extruded": ("object.text_add", {}, {"extrude": 0.1}),
    "Bezier curve": ("curve.primitive_bezier_curve_add", {}, {}),
    "Bezier curve, round bevel": ("curve.primitive_bezier_curve_add", {}, {"bevel_depth": 0.1}),
    "Bezier circle, filled": ("curve.primitive_bezier_circle_add", {}, {"dimensions": "2D", "fill_mode": "BOTH"}),
    "NURBS circle, extruded": ("curve.primitive_nurbs_circle_add", {}, {"extrude": 0.3}),
    "NURBS surface": ("surface.primitive_nurbs_surface_surface_add", {}, {}),
    "NURBS cylinder": ("surface.primitive_nurbs_surface_cylinder_add", {}, {}),
    "NURBS sphere": ("surface.primitive_nurbs_surface_sphere_add", {}, {}),
    "NURBS torus": ("surface.primitive_nurbs_surface_torus_add", {}, {}),
    "metaball": ("object.metaball_add", {}, {}),
}


def is_file(shape: str) -> bool:
    """Whether a shape is one of the corpus."""
    return shape.endswith(".obj")


def picture_of(shape: str, energy: str) -> str:
    """The name of a run's picture."""
    return f"{name_of(shape)}.{energy}.png".replace(" ", "_").replace(",", "")


def name_of(shape: str) -> str:
    """A shape in tables and names of pictures; a primitive may have the name of a file without its ending."""
    return Path(shape).name


# ---------------------------------------------------------------------------------------------------------- campaign --

def campaign(runs: Sequence[Run], output: Path, limit: float, pictures: Path | None, command: Sequence[str],
             environment: dict[str, str]) -> None:
    """Does the runs that the output does not have yet. `command` is called with a file of jobs and one for events."""
    left = [run for run in runs if key_of(*run) not in {key_of(r["shape"], r["energy"]) for r in records(output)}]
    while left:
        jobs = {"runs": left, "limit": limit, "pictures": str(pictures) if pictures else None}
        with tempfile.TemporaryDirectory(prefix="curvopt-press-") as folder:
            events = Path(folder) / "events.jsonl"
            (Path(folder) / "jobs.json").write_text(json.dumps(jobs))
            done = watched([*command, str(Path(folder) / "jobs.json"), str(events)], environment, events, limit, output)
        if done == 0:
            raise SystemExit("Blender ended before the first run.")
        left = left[done:]


def watched(command: Sequence[str], environment: dict[str, str], events: Path, limit: float, output: Path) -> int:
    """Runs the command until it ends, or hangs and is killed; the number of runs that it has ended or died of."""
    events.touch()
    child = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    done, begun, since = 0, None, time.monotonic()
    with events.open(encoding="utf-8") as stream, output.open("a", encoding="utf-8", buffering=1) as out:
        try:
            while True:
                ended = child.poll() is not None  # before the last look at the events
                for line in stream:
                    event, since = json.loads(line), time.monotonic()
                    begun = event.get("begins")
                    if begun is None:
                        keep(out, event["ended"], event["record"])
                        done += 1
                if ended:
                    break
                if time.monotonic() - since > limit + GRACE:
                    child.kill()
                    child.wait()
                    if begun:
                        keep(out, begun, {"outcome": "hangs", "said": f"not ended after {limit + GRACE:.0f} s: killed"})
                    return done + bool(begun)
                time.sleep(0.05)
        finally:
            child.kill()
            child.wait()
        if begun:
            code = child.returncode
            how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            keep(out, begun, {"outcome": "crashed", "said": f"Blender ended: {how}"})
            done += 1
    return done


def keep(out: Any, run: Sequence[str], record: Record) -> None:
    """Appends a record."""
    shape, energy = run
    out.write(json.dumps({"shape": shape, "energy": energy, **record}) + "\n")
    print(f"{name_of(shape)}, {energy}: {record['outcome']}", flush=True)


def key_of(shape: str, energy: str) -> str:
    """The name of a run: the folder of the corpus does not count."""
    return f"{name_of(shape)}|{energy}"


def records(path: Path) -> list[Record]:
    """Those of a file, if it is there."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def shapes_of(corpus: Path | None, only: Iterable[str]) -> list[str]:
    """Primitives, then the folder's files; those whose name has one of the texts `only`, or all."""
    files = sorted(str(path.resolve()) for path in corpus.glob("*.obj")) if corpus else []
    wanted = list(only)
    return [shape for shape in [*PRIMITIVES, *files] if not wanted or any(text in name_of(shape) for text in wanted)]


# ------------------------------------------------------------------------------------------------------------ tables --

def summary(found: Sequence[Record]) -> str:
    """Outcomes and seconds, a row for each energy."""
    words = ("minimum", "saddle", "not stationary", "unknown", "out of time", *NO_RESULT)
    rows = []
    for energy in dict.fromkeys(record["energy"] for record in found):
        mine = [record for record in found if record["energy"] == energy]
        counts = [sum(record["outcome"] == word for record in mine) for word in words]
        seconds = [record["seconds"] for record in mine if record["outcome"] not in NO_RESULT]
        times = [f"{quantile(seconds, share):.2f}" for share in (0.5, 0.95, 1.0)] if seconds else ["", "", ""]
        held = sum(record.get("held", 0) > 0 for record in mine)
        rows.append([energy, len(mine), *counts, held, *times])
    return table(["", "runs", *words, "with held vertices", "s: median", "95 %", "most"], rows)


def rows_of(found: Sequence[Record]) -> str:
    """A row for each run."""
    head = ["shape", "energy", "vertices", "outcome", "held", "left out", "before", "after", "moved", "s", "reasons"]
    return table(head, (row_of(record) for record in found))


def row_of(record: Record) -> list[str]:
    """Of one run. Lengths are parts of the largest distance from the mean of the vertices."""
    if record["outcome"] in NO_RESULT:
        said = f"{record['outcome']}: {record['said']}"
        return [name_of(record["shape"]), record["energy"], str(record.get("vertices", "")), said, *[""] * 5,
                f"{record['seconds']:.1f}" if "seconds" in record else "", ""]
    reasons = "; ".join(f"{text} ({count})" for text, count, _ in record["reasons"])
    return [name_of(record["shape"]), record["energy"], str(record["vertices"]), record["outcome"], str(record["held"]),
            str(record["left_out"]), number(record["before"]), number(record["after"]), number(record["moved"]),
            f"{record['seconds']:.1f}", reasons]


def number(value: float) -> str:
    """Four digits."""
    return "" if value is None or not math.isfinite(value) else f"{value:.4g}"


# ------------------------------------------------------------------------------------------------------ command line --

def main() -> None:
    parser = argparse.ArgumentParser(description="Presses Minimize in Blender on many shapes.")
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="make the runs")
    run.add_argument("--output", type=Path, required=True, metavar="OUT.jsonl")
    run.add_argument("--corpus", type=Path, metavar="DIR", help="OBJ files with tags; without it primitives alone")
    run.add_argument("--energies", nargs="+", default=ENERGIES)
    run.add_argument("--limit", type=float, default=60, help="seconds of a run (default %(default)s)")
    run.add_argument("--pictures", type=Path, metavar="DIR", help="a picture of each run")
    run.add_argument("--only", nargs="+", default=(), metavar="TEXT", help="shapes whose name has one of these")
    run.add_argument("--blender", default="blender")
    shown = commands.add_parser("table", help="Markdown of a file")
    shown.add_argument("file", type=Path)
    arguments = parser.parse_args()
    if arguments.command == "table":
        found = records(arguments.file)
        print(summary(found), rows_of(found), sep="\n")
        return
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="curvopt-press-") as folder:
        (Path(folder) / "addons").mkdir()
        install_folder(ROOT / "addon", Path(folder))
        command = [arguments.blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                   str(HERE / "press_inside.py"), "--"]
        environment = blender_environment(Path(folder), {})
        shapes = shapes_of(arguments.corpus, arguments.only)
        runs = [(shape, energy) for shape in shapes for energy in arguments.energies]
        campaign(runs, arguments.output, arguments.limit, arguments.pictures, command, environment)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a change moves any result of the command line: two programs on all committed cages.

    python3 tests/checks/results.py --before PROGRAM --after PROGRAM [option]...
    python3 tests/checks/results.py --after PROGRAM --record FILE      keeps the results of a program
    python3 tests/checks/results.py --after PROGRAM --against FILE     compares with kept ones

Each cage of blend_files/obj and tests/cages/numeric is evaluated and minimized, with each energy, on one thread. Compared are
energies, to a relative tolerance; steps of each level, reasons to stop and verdicts exactly. With --tolerance 0 everything but
times must be equal to the last bit: all figures, and the cages that come out. Runs that use up their CPU time, or that fail, are
compared as such: a run that ends so before and after is listed, and is no difference. Figures that only one program gives are
listed once and not compared.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Iterator, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
CAGES = [*sorted((ROOT / "blend_files/obj").glob("*.obj")), *sorted((ROOT / "tests/cages/numeric").glob("*.obj"))]
ENERGIES = ("willmore", "mvs", "mvs_cross")
# Differences of nearly equal numbers: they say nothing beside a tolerance that is relative to themselves.
SMALL = {"gauss", "gauss_bonnet_defect", "quadrature_error", "quadrature_errors", "gradient_norm", "newton_decrement",
         "shape_decrement", "difference_decrement", "cage"}
OUT_OF_TIME = {"ended": "out of CPU time"}

Result = dict[str, Any]


class Job(NamedTuple):
    """A run: command is evaluate or minimize."""

    command: str
    cage: Path
    energy: str

    @property
    def name(self) -> str:
        """Such as "minimize torus_050 mvs"."""
        return f"{self.command} {self.cage.stem} {self.energy}"


def run(program: Path, job: Job, levels: int, cpu: int) -> Result:
    """The program's JSON and a digest of the cage that it wrote; or how it ended otherwise."""
    with tempfile.TemporaryDirectory(prefix="curvopt-results-") as folder:
        out = Path(folder) / "out.obj"
        more = ["-o", out, "--levels", levels] if job.command == "minimize" else []
        command = [program, job.command, job.cage, "--energy", job.energy, "--threads", 1, "--quiet", "--json", "-", *more]
        done = subprocess.run(["bash", "-c", 'ulimit -t "$0"; exec "$@"', str(cpu), *map(str, command)], capture_output=True,
                              text=True)
        if done.returncode in (-9, -24, 137, 152):  # SIGKILL, SIGXCPU
            return OUT_OF_TIME
        if done.returncode:
            return {"ended": f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"}
        result = json.loads(done.stdout)
        if out.exists():
            result["cage"] = hashlib.sha256(out.read_bytes()).hexdigest()
        return result


def results(program: Path, jobs: list[Job], options: argparse.Namespace) -> dict[str, Result]:
    """Of every job, by its name."""
    with ThreadPoolExecutor(options.jobs) as pool:
        ran = pool.map(lambda job: run(program, job, options.levels, options.cpu), jobs)
        return {job.name: result for job, result in zip(jobs, ran)}


def differences(before: Any, after: Any, tolerance: float, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Place, value before, value after. Figures that only one side has come as (place, None, None)."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in [*before, *(key for key in after if key not in before)]:
            place = f"{where}.{key}".lstrip(".")
            if key == "seconds" or (tolerance > 0 and key in SMALL):
                continue
            if key in before and key in after:
                yield from differences(before[key], after[key], tolerance, place)
            elif "ended" in before or "ended" in after:
                yield where or "run", before.get("ended", "a result"), after.get("ended", "a result")
                return
            else:
                yield place, None, None
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for k, pair in enumerate(zip(before, after)):
            yield from differences(*pair, tolerance, f"{where}[{k + 1}]")
    elif isinstance(before, float) and isinstance(after, (int, float)):
        if before != after and not abs(before - after) <= tolerance * max(abs(before), abs(after)):
            yield where, before, after
    elif before != after:
        yield where, before, after


def compare(before: dict[str, Result], after: dict[str, Result], tolerance: float) -> int:
    """Prints what differs; number of runs that do."""
    differ, same_end, only_one = 0, [], set()
    for name in before.keys() & after.keys():
        if "ended" in before[name] and before[name] == after[name]:
            same_end.append(f"{name}: {before[name]['ended']}")
        found = list(differences(before[name], after[name], tolerance))
        only_one |= {place for place, old, new in found if old is None and new is None}
        found = [entry for entry in found if entry[1:] != (None, None)]
        differ += bool(found)
        for place, old, new in found[:6]:
            print(f"{name}: {place}: {old} -> {new}")
        if len(found) > 6:
            print(f"{name}: and {len(found) - 6} figures more")
    for sentence in sorted(same_end):
        print(f"before and after, {sentence}")
    if only_one:
        print(f"in one program only: {', '.join(sorted(only_one))}")
    return differ


def main() -> int:
    """As the module says; 1 if anything differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, metavar="PROGRAM")
    parser.add_argument("--after", type=Path, metavar="PROGRAM", required=True)
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the results of --after")
    parser.add_argument("--against", type=Path, metavar="FILE", help="compare with results that --record wrote")
    parser.add_argument("--tolerance", type=float, default=1e-12, help="relative, of energies; 0: the last bit of everything")
    parser.add_argument("--levels", type=int, default=2)
    parser.add_argument("--energy", action="append", help="default: " + ", ".join(ENERGIES))
    parser.add_argument("--cage", action="append", help="name, such as torus_050; default: all")
    parser.add_argument("--cpu", type=int, default=60, help="seconds of CPU time of a run (default 60)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    if bool(options.before) + bool(options.against) + bool(options.record) != 1:
        parser.error("give one of --before, --against, --record")
    for program in filter(None, (options.before, options.after)):
        if not os.access(program, os.X_OK):
            parser.error(f"{program} is no program")
    cages = [cage for cage in CAGES if not options.cage or cage.stem in options.cage]
    jobs = [Job(command, cage, energy) for command in ("evaluate", "minimize") for cage in cages
            for energy in options.energy or ENERGIES]
    if not jobs:
        parser.error("there is no such cage")
    settings = {"levels": options.levels, "cpu": options.cpu}
    after = results(options.after.resolve(), jobs, options)
    if options.record:
        options.record.write_text(json.dumps({"settings": settings, "results": after}, indent=1) + "\n")
        print(f"{len(after)} runs recorded in {options.record}")
        return 0
    if options.against:
        kept = json.loads(options.against.read_text())
        if kept["settings"] != settings:
            parser.error(f"{options.against} was recorded with {kept['settings']}")
        before = kept["results"]
    else:
        before = results(options.before.resolve(), jobs, options)
    n_compared = len(before.keys() & after.keys())
    differ = compare(before, after, options.tolerance)
    print(f"{n_compared - differ} passed, {differ} failed" if n_compared else "0 passed, 1 failed")
    return int(differ > 0 or n_compared == 0)


if __name__ == "__main__":
    sys.exit(main())

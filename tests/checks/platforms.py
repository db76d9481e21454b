# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the results of the command line differ between platforms: programs, given as commands, against the first of them.

    python3 tests/checks/platforms.py --program linux=build/release/curvopt \\
        --program windows=build/windows-x64/tests/curvopt.sh --program arm64=build/linux-arm64/tests/curvopt.sh

Each cage of blend_files/obj is evaluated, and minimized on one level, with each energy, on one thread. Per program, command and
energy: the largest relative difference of the objective, and where; in how many runs the steps of a level and the verdict are
others. Runs that fail, or take longer than the limit of CPU time, are listed and left out.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import results

CAGES = [cage for cage in results.CAGES if cage.parent.name == "obj"]


def run(program: list[str], job: results.Job, options: argparse.Namespace) -> results.Result:
    """The program's JSON, or how it ended otherwise."""
    with tempfile.TemporaryDirectory(prefix="curvopt-platforms-") as folder:
        more = ["-o", f"{folder}/out.obj", "--levels", "1"] if job.command == "minimize" else []
        command = [*program, job.command, str(job.cage), "--energy", job.energy, "--threads", "1", "--quiet", "--json", "-",
                   *more, *options.option]
        try:
            done = subprocess.run(["bash", "-c", 'ulimit -t "$0"; exec "$@"', str(options.cpu), *command], capture_output=True,
                                  text=True, timeout=8 * options.cpu, env={**os.environ, "WINEDEBUG": "-all"})
        except subprocess.TimeoutExpired:
            return results.OUT_OF_TIME
        if done.returncode in (-9, -24, 137, 152):  # SIGKILL, SIGXCPU
            return results.OUT_OF_TIME
        if done.returncode:
            return {"ended": f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"}
        return json.loads(done.stdout)


def figures(result: results.Result) -> tuple[float, Any, Any]:
    """Objective, steps of each level, verdict."""
    levels = [level["iterations"] for level in result.get("levels", [])]
    return result["objective"], levels, result.get("verification", {}).get("verdict")


def row(name: str, jobs: list[results.Job], first: dict[str, results.Result], other: dict[str, results.Result]) -> str:
    """A line of the table: one program, command and energy."""
    worst, where, steps, verdicts, compared = 0.0, "", 0, 0, 0
    for job in jobs:
        pair = first[job.name], other[job.name]
        if any("ended" in result for result in pair):
            continue
        (a, steps_a, verdict_a), (b, steps_b, verdict_b) = map(figures, pair)
        compared += 1
        steps += steps_a != steps_b
        verdicts += verdict_a != verdict_b
        if a is None or b is None:
            verdicts += (a is None) != (b is None)
        elif abs(a - b) > worst * max(abs(a), abs(b)):
            worst, where = abs(a - b) / max(abs(a), abs(b)), job.cage.stem
    return f"{name:12} {jobs[0].command:9} {jobs[0].energy:10} {compared:5} {worst:10.1e} {steps:6} {verdicts:8}  {where}"


def main() -> int:
    """As the module says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", action="append", required=True, metavar="NAME=COMMAND")
    parser.add_argument("--energy", action="append", help="default: " + ", ".join(results.ENERGIES))
    parser.add_argument("--cage", action="append", help="name, such as torus_050; default: all")
    parser.add_argument("--command", action="append", choices=("evaluate", "minimize"))
    parser.add_argument("--option", action="append", default=[], help="one more argument of every run")
    parser.add_argument("--cpu", type=int, default=60, help="seconds of CPU time of a run (default 60)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--runs", action="store_true", help="print the figures of every run, too")
    options = parser.parse_args()
    programs = {name: shlex.split(command) for name, command in (entry.split("=", 1) for entry in options.program)}
    cages = [cage for cage in CAGES if not options.cage or cage.stem in options.cage]
    groups = [[results.Job(command, cage, energy) for cage in cages] for command in options.command or ("evaluate", "minimize")
              for energy in options.energy or results.ENERGIES]
    if not cages or len(programs) < 2:
        parser.error("give two programs or more, and cages that exist")
    jobs = [job for group in groups for job in group]
    with ThreadPoolExecutor(options.jobs) as pool:
        found = {name: dict(zip((job.name for job in jobs), pool.map(lambda job, p=program: run(p, job, options), jobs)))
                 for name, program in programs.items()}
    names = list(programs)
    for job in jobs:
        for name in names:
            result = found[name][job.name]
            if "ended" in result:
                print(f"left out: {name}: {job.name}: {result['ended']}")
            elif options.runs:
                print(f"{job.name} {name}: {figures(result)}")
    print(f"against {names[0]}:")
    print(f"{'program':12} {'command':9} {'energy':10} {'runs':>5} {'objective':>10} {'steps':>6} {'verdicts':>8}  where")
    for name in names[1:]:
        for group in groups:
            print(row(name, group, found[names[0]], found[name]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: GPL-3.0-or-later
"""An evaluation on two ranks against one, by the clock and by CPU time: runs in pairs, in turn, and the least of all.

The cage is a torus of 131072 vertices. For each energy and number of ranks: the least time by the clock from call to
return of a value and gradient, of all evaluations of all runs; the least of the runs' mean CPU time of a rank in the
library, values alone included; the memory of the largest rank; and by how much the machine was in demand meanwhile.
Figures by the clock mean something only where the load is not above the number of cores.

    python3 tests/tao/scaling.py BUILD_FOLDER [--pairs 5] [--iterations 25] [--levels 6] [--energy E ...]
"""
from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(build: Path, ranks: int, *arguments: str) -> None:
    """curvopt-tao minimize on so many ranks; CalledProcessError where it fails."""
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    command = ["mpirun", "-q", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), str(build / "curvopt-tao")]
    subprocess.run([*command, "minimize", *arguments, "--joshi-sequin", "--quiet"], check=True, env=environment)


def main() -> None:
    """The table, to standard output."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=Path)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--iterations", default="25")
    parser.add_argument("--levels", default="6", help="of subdivision of a torus of 128 vertices, from 1 on")
    parser.add_argument("--energy", nargs="+", default=["willmore", "mvs"])
    options = parser.parse_args()
    found: dict[tuple[str, int], list[dict]] = {}
    loads = []
    with tempfile.TemporaryDirectory() as name:
        cage, out, report = (str(Path(name, file)) for file in ("cage.obj", "out.obj", "report.json"))
        start = ROOT / "blend_files" / "obj" / "torus_050_16x8.obj"
        run(options.build, 1, str(start), "-o", cage, "--levels", options.levels, "--max-iterations", "0")
        for _ in range(options.pairs):
            for energy in options.energy:
                for ranks in (1, 2):
                    run(options.build, ranks, cage, "-o", out, "--energy", energy, "--levels", "1",
                        "--max-iterations", options.iterations, "--json", report)
                    found.setdefault((energy, ranks), []).append(json.loads(Path(report).read_text())["tao"])
                    loads.append(os.getloadavg()[0])
    print("| energy | ranks | ms by the clock | ms of CPU, a rank | memory of a rank, MB |")
    print("| --- " * 5 + "|")
    for (energy, ranks), runs in found.items():
        clock, cpu = (1e3 * min(max(one[key]) for one in runs)
                      for key in ("least_seconds_a_gradient", "cpu_seconds_an_evaluation"))
        memory = min(max(one["memory_bytes"]) for one in runs) / 1e6
        print(f"| {energy} | {ranks} | {clock:.1f} | {cpu:.1f} | {memory:.0f} |")
    print(f"\nload {min(loads):.1f} to {max(loads):.1f} on {os.cpu_count()} cores, {options.pairs} pairs")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's verification, Newton's method with a finite-difference Hessian, by TAO and by the library: a table.

Twice for each torus of the report's first table and each energy: at the cage that TAO's LMVM ends at, and at the one that
the library ends at. Both programs look at the same cage and say what Newton's method has left to gain, relative to the
energy: over everything that may move, and over motion along normals. TAO's figures are what it gained; the library's are
Newton decrements. `verdict` is a minimum's where both are at most 1e-6.

    python3 tests/tao/verification.py BUILD_FOLDER [--levels 2] [--tolerance 1e-6] [--energy E ...] [--ratio PERCENT ...]
"""
from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(program: Path, cage: Path, out: Path, energy: str, *options: str) -> dict:
    """What the program's JSON says; CalledProcessError where it fails."""
    report = out.with_suffix(".json")
    command = [str(program), "minimize", str(cage), "-o", str(out), "--energy", energy, "--symmetry", "none", "--blend-width", "1",
               "--quiet"]
    subprocess.run([*command, "--json", str(report), *options], check=True)
    return json.loads(report.read_text())


def figures(report: dict) -> tuple[str, float, float]:
    """Verdict, and what is left over everything and along normals, of the energy; NAN for what was not found."""
    found, energy = report["verification"], abs(report["objective"])
    values = [found[key] for key in ("newton_decrement", "difference_decrement")]
    return (found["verdict"], *(float("nan") if v is None else v / energy for v in values))


def main() -> None:
    """The table, to standard output."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=Path)
    parser.add_argument("--levels", default="2")
    parser.add_argument("--tolerance", default="1e-6")
    parser.add_argument("--energy", nargs="+", default=["willmore", "mvs", "mvs_cross"])
    parser.add_argument("--ratio", nargs="+", type=int, default=list(range(10, 100, 10)))
    options = parser.parse_args()
    build, common = options.build, ("--tolerance", options.tolerance)
    print("| torus | energy | minimizer | value | TAO: verdict | left | normals | library: verdict | left | normals |")
    print("| --- " * 10 + "|")
    for energy in options.energy:
        for ratio in options.ratio:
            for program in ("curvopt-tao", "curvopt"):
                with tempfile.TemporaryDirectory() as name:
                    at = Path(name, "minimizer.obj")
                    start = ROOT / "blend_files" / "obj" / f"torus_{ratio:03d}.obj"
                    run(build / program, start, at, energy, "--levels", options.levels, "--max-iterations", "5000",
                        *common)
                    here = ("--levels", "1", "--max-iterations", "0", "--verify", *common)
                    tao = run(build / "curvopt-tao", at, Path(name, "tao.obj"), energy, *here)
                    ours = run(build / "curvopt", at, Path(name, "ours.obj"), energy, *here)
                    who = "TAO" if program == "curvopt-tao" else "ours"
                    cells = [f"{ratio / 100:.1f}", energy, who, f"{ours['objective']:.7g}"]
                    for report in (tao, ours):
                        verdict, anything, normals = figures(report)
                        cells += [verdict, f"{anything:.0e}", f"{normals:.0e}"]
                    print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's verification, by TAO and by the library: a table.

Twice for each torus of the report's first table and each energy: at the cage that TAO's LMVM ends at, and at the one that
the library ends at. Both programs look at the same cage, by quadrature so fine that it does not matter that their rules
differ, and say, relative to the energy, what is left: half of gradient . Hessian^-1 gradient over everything that may
move (`left`) and over motion along normals, TAO's with a Hessian by differences, the library's with its exact one; and
whether the Hessian over everything has negative directions (-) or not (+). Of these are the verdicts, by each program's
own threshold of 1e-6. `Newton` is what the report did: what Newton's method with that Hessian takes off the energy in the
end. Where there are negative directions it leaves along them, so that this is more than is left by any quadratic model.

    python3 tests/tao/verification.py BUILD_FOLDER [--levels 2] [--tolerance 1e-10] [--energy E ...] [--ratio PERCENT ...]
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


def figures(report: dict) -> tuple[str, float, float, str]:
    """Verdict; what is left over everything and along normals, of the energy, NAN for what was not found; the sign of
    the Hessian over everything."""
    found, energy = report["verification"], abs(report["objective"])
    values = [found[key] for key in ("newton_decrement", "shape_decrement")]
    left, normals = (float("nan") if v is None else v / energy for v in values)
    return found["verdict"], left, normals, "+" if found["all_negative_directions"] == 0 else "-"


def look(build: Path, energy: str, at: Path, folder: Path, *options: str) -> tuple[dict, dict]:
    """What TAO and the library say of a cage."""
    here = ("--levels", "1", "--max-iterations", "0", "--verify", *options)
    return (run(build / "curvopt-tao", at, folder / "tao.obj", energy, *here),
            run(build / "curvopt", at, folder / "ours.obj", energy, *here))


def main() -> None:
    """The table, to standard output."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=Path)
    parser.add_argument("--levels", default="2")
    parser.add_argument("--tolerance", default="1e-10")
    parser.add_argument("--energy", nargs="+", default=["willmore", "mvs", "mvs_cross"])
    parser.add_argument("--ratio", nargs="+", type=int, default=list(range(10, 100, 10)))
    options = parser.parse_args()
    build, common = options.build, ("--tolerance", options.tolerance)
    print("| torus | energy | minimizer | value | TAO: verdict | left | normals | H | Newton | library: verdict | left "
          "| normals | H |")
    print("| --- " * 13 + "|")
    same, seen, apart = 0, 0, 0.0
    for energy in options.energy:
        for ratio in options.ratio:
            for program in ("curvopt-tao", "curvopt"):
                with tempfile.TemporaryDirectory() as name:
                    at = Path(name, "minimizer.obj")
                    start = ROOT / "blend_files" / "obj" / f"torus_{ratio:03d}.obj"
                    run(build / program, start, at, energy, "--levels", options.levels, "--max-iterations", "5000",
                        *common)
                    tao, ours = look(build, energy, at, Path(name), *common)
                value = ours["objective"]
                newton = tao["tao"]["newton_gain"] / abs(value)
                (verdict, left, normals, sign), mine = figures(tao), figures(ours)
                who = "TAO" if program == "curvopt-tao" else "ours"
                cells = [f"{ratio / 100:.1f}", energy, who, f"{value:.7g}", verdict, f"{left:.1e}", f"{normals:.1e}",
                         sign, f"{newton:.1e}", mine[0], f"{mine[1]:.1e}", f"{mine[2]:.1e}", mine[3]]
                print("| " + " | ".join(cells) + " |", flush=True)
                same, seen = same + (verdict == mine[0]), seen + 1
                apart = max(apart, abs(tao["objective"] / value - 1))
    print(f"\n{same} of {seen} verdicts are the same. Energies of the same cage differ by {apart:.0e} at most.")


if __name__ == "__main__":
    main()

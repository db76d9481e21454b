# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark: python3 tests/bench/run.py [--part NAME]... [--write-baseline] [--output FILE] [--build DIR].

Builds the preset release first, unless --build names a folder with other programs. Parts: kernels, faces, matrix (all from
`curvopt_bench`), start (the command line's own time), shapes (time to a certified minimum, beside plain LMVM), evolver
(Surface Evolver on the same task; about five minutes), and, only if it is named, corpus (distributions over random cages;
hours). Prints Markdown tables and what got slower than `baseline.json`, as ratios; figures that depend on the machine's speed
are divided by the peak measured in the same run, so a baseline of another machine says something too. The exit status is 1 if
anything is 1.5 times slower, 2 if something is missing. What is written as JSON names machine, compiler, commit and load.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Iterable

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), *(str(HERE.parent / name) for name in ("oracle", "numeric", "corpus"))]

try:
    import campaign  # noqa: E402
    import evolver  # noqa: E402
    import lib  # noqa: E402
    from ccref import Mesh  # noqa: E402
    from acceptance import acceptance  # noqa: E402
    from nets import read_obj, torus_cage, write_obj  # noqa: E402
    from tables import summary  # noqa: E402
except ModuleNotFoundError as missing:
    if missing.name != "numpy":
        raise
    print(f"bench: {sys.executable} has no numpy; run: apt-get install python3-numpy, and use /usr/bin/python3",
          file=sys.stderr)
    sys.exit(2)

CAGES = ROOT / "blend_files" / "obj"
SURFACES = {1: "limit", 2: "plane", 3: "polynomial"}
SLOWER = 1.5
EXACT = {"torus_030": 19.739208802178716, "lawson_g2": 21.9085143681}  # int H^2; MATH: 2 pi^2; Lawson's of genus 2
SHAPES = [("torus_030", "willmore"), ("lawson_g2", "willmore"), ("lawson_g5", "willmore"), ("tetrahedral_g3", "willmore"),
          ("torus_030", "mvs"), ("sphere_cube", "mvs"), ("lawson_g2", "mvs"), ("cubical_g5", "mvs"),
          ("torus_030", "mvs_cross"), ("lawson_g2", "mvs_cross")]

Row = dict[str, Any]


def table(head: list[str], rows: Iterable[Iterable[object]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def compiled(build: Path, parts: list[str]) -> list[Row]:
    """What curvopt_bench measured."""
    if not {"kernels", "faces", "matrix"} & set(parts):
        return []
    arguments = [] if "faces" in parts else ["--largest", "2000"]
    done = subprocess.run([build / "curvopt_bench", *arguments], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def kernel_tables(rows: list[Row]) -> tuple[str, dict[str, float]]:
    """ns a sample and the share of the peak; for the baseline, time in units of the peak. The pointwise part of `plane`
    is not counted, so that it has no share."""
    text, figures = [], {}
    for row in rows:
        what = f"{row['kernel']} {'MVS' if row['third'] else 'Willmore'} {SURFACES[row['surface']]} {row['valence']}"
        share = row["gflops"] / row["peak_gflops"]
        key = what + (" gradient" if row["gradient"] else " energy")
        figures[key] = row["ns_per_sample"] * row["peak_gflops"]
        text.append([row["kernel"], "MVS" if row["third"] else "Willmore", SURFACES[row["surface"]], row["valence"],
                     "energy + gradient" if row["gradient"] else "energy", row["points"],
                     f"{row['ns_per_sample']:.1f}", f"{row['flops']:.0f}", f"{row['peak_gflops']:.0f}",
                     "" if row["surface"] == 2 else f"{100 * share:.0f} %"])
    head = ["kernel", "energy", "surface", "valence", "what", "points", "ns a sample", "flops", "peak GFlop/s", "of peak"]
    return table(head, text), figures


def faces_table(rows: list[Row], peak: float) -> tuple[str, dict[str, float]]:
    """Cost a face of energy and gradient against the number of faces; what two threads bring, measured by turns; peak
    memory with one problem."""
    text, figures = [], {}
    for row in rows:
        text.append(["MVS" if row["third"] else "Willmore", row["faces"], f"{row['ns_per_face']:.0f}",
                     f"{row['ns_per_face_2']:.0f}", f"{row['speed_up']:.2f} ({row['pairs']})", f"{row['set_up_s']:.2f}",
                     f"{row['set_up_2_s']:.2f}", row["peak_mb"]])
        for threads, key in ((1, "ns_per_face"), (2, "ns_per_face_2")):
            figures[f"faces {row['faces']} {row['third']} {threads}"] = row[key] * peak
    head = ["energy", "faces", "ns a face", "two threads", "times faster (pairs)", "set-up, s", "two threads",
            "memory, MB"]
    return table(head, text), figures


def matrix_table(rows: list[Row], peak: float) -> tuple[str, dict[str, float]]:
    """Assembly and factorization."""
    keys = ["create_s", "gauss_newton_s", "hessian_s", "factor_s", "solve_s"]
    figures = {f"matrix {row['vertices']} {row['third']} {row['threads']} {key}": row[key] * peak
               for row in rows for key in keys if row[key] > 1e-3}
    text = [["MVS" if row["third"] else "Willmore", row["vertices"], row["threads"],
             *(f"{1e3 * row[key]:.1f}" for key in keys)] for row in rows]
    head = ["energy", "vertices", "threads", "analysis, ms", "Gauss-Newton, ms", "Hessian, ms", "factor, ms", "solve, ms"]
    return table(head, text), figures


def timed(command: list[object]) -> tuple[float, float, float]:
    """Seconds by the clock, CPU seconds and MB at most of a command that must succeed."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.monotonic() - start, cpu, after.ru_maxrss / 1024


def start_table(build: Path) -> tuple[str, dict[str, float]]:
    """The command line from start to end: a small cage, a big one."""
    text, figures = [], {}
    with tempfile.TemporaryDirectory() as folder:
        big = Path(folder) / "big.obj"
        write_obj(big, torus_cage(1414, 708, 0.5))
        for name, path, runs in (("98 vertices (sphere as a cube)", CAGES / "sphere_cube.obj", 20),
                                 ("1 001 112 faces (torus)", big, 1)):
            seconds, _, megabytes = min(timed([build / "curvopt", "evaluate", path, "--energy", "willmore"])
                                        for _ in range(runs))
            text.append([name, f"{seconds:.3f}", f"{megabytes:.0f}" if path == big else ""])
            figures["start " + name] = seconds
    return table(["curvopt evaluate", "s", "memory so far, MB"], text), figures


def minimized(build: Path, name: str, *options: object) -> tuple[Row, float]:
    """JSON of a run, and its CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "out.json"
        _, cpu, _ = timed([build / "curvopt", "minimize", CAGES / f"{name}.obj", "-o", Path(folder) / "out.obj", "--json",
                           report, "--quiet", *options])
        return json.loads(report.read_text()), cpu


def seconds_to(name: str, energy: str, target: float) -> float | None:
    """CPU seconds of a default run on one thread until the last level has an energy of at most `target`; None: never."""
    seen: list[tuple[float, int, float]] = []

    def watch(p: Any) -> bool:
        seen.append((time.process_time(), p.level, p.energy))
        return p.level == 4 and p.energy <= target

    cage = read_obj(CAGES / f"{name}.obj")
    start = time.process_time()
    end = lib.minimize(cage, energy, levels=4, threads=1, progress=watch).summary.end.objective
    reached = [at for at, level, value in seen if level == 4 and value <= target]
    return reached[0] - start if reached else time.process_time() - start if end <= target else None


def shapes_table(build: Path) -> tuple[str, dict[str, float]]:
    """Time to a certified minimum of four levels; plain LMVM's energy after 2 000 iterations a level, the CPU time that it
    took, and the share of it after which the default run has that energy."""
    text, figures = [], {}
    for name, energy in SHAPES:
        strong, cpu = minimized(build, name, "--energy", energy)
        plain, slow = minimized(build, name, "--energy", energy, "--method", "lmvm", "--max-iterations", 2000)
        quick = seconds_to(name, energy, plain["objective"])
        check = strong["verification"]
        text.append([name, energy, f"{strong['objective']:.7g}", strong["symmetry_order"], check["verdict"],
                     f"{check['newton_decrement'] / strong['objective']:.0e}", f"{strong['seconds']:.2f}", f"{cpu:.2f}",
                     " ".join(str(level["iterations"]) for level in strong["levels"]),
                     f"{plain['objective']:.8g}", f"{slow:.2f}", plain["verification"]["verdict"],
                     f"{slow / quick:.0f}" if quick else "never"])
        figures[f"shape {name} {energy}"] = strong["seconds"]
    head = ["cage", "energy", "result", "symmetries", "verdict", "decrement", "s", "CPU s", "iterations a level",
            "plain LMVM", "CPU s", "verdict", "times faster to there"]
    return table(head, text), figures


# ------------------------------------------------------------------------------------------------ Evolver --

def ours(build: Path, name: str) -> list[tuple[float, float]]:
    """CPU seconds and relative error of ∫H² of runs of 1 to 5 levels, the whole process counted."""
    points = []
    for levels in range(1, 6):
        result, cpu = minimized(build, name, "--energy", "willmore", "--levels", levels)
        points.append((cpu, abs(result["h2"] - EXACT[name]) / EXACT[name]))
    return points


def time_to(points: list[tuple[float, float]], error: float) -> float | None:
    """Least time after which the error is that small and stays so."""
    reached = None
    for cpu, at in points:
        if at > error:
            reached = None
        elif reached is None:
            reached = cpu
    return reached


def evolver_table(build: Path, picture: Path | None, seconds: int = 150) -> tuple[str, dict[str, float]]:
    """Error against CPU time, both programs from the same cages, in one run."""
    text, curves = [], []
    for name in EXACT:
        cage: Mesh = read_obj(CAGES / f"{name}.obj")
        own = ours(build, name)
        curves.append((f"curvopt, {name}", own))
        for schedule in evolver.SCHEDULES:
            stages = evolver.run(cage, schedule, seconds)
            theirs = [(cpu, abs(value - EXACT[name]) / EXACT[name]) for _, value, cpu in stages]
            curves.append((f"Evolver ({schedule}), {name}", theirs))
            for error in (1e-2, 1e-3, 1e-4):
                mine, other = time_to(own, error), time_to(theirs, error)
                ratio = "" if mine is None else f"{other / mine:.0f}" if other else f"> {theirs[-1][0] / mine:.0f}"
                text.append([name, schedule, f"{error:.0e}", f"{mine:.3f}" if mine else "not reached",
                             f"{other:.1f}" if other else f"not in {theirs[-1][0]:.0f} s (at {theirs[-1][1]:.1e})", ratio])
    if picture:
        picture.write_text(plot(curves))
    return table(["shape", "Evolver's schedule", "error of ∫H²", "curvopt, CPU s", "Evolver, CPU s", "ratio"], text), {}


def plot(curves: list[tuple[str, list[tuple[float, float]]]]) -> str:
    """Error against CPU time on logarithmic axes, as SVG."""
    width, height, left, bottom = 760, 460, 70, 50
    colours = ["#c0392b", "#2471a3", "#7fb3d5", "#e67e22", "#1e8449", "#82c99a"]

    def at(cpu: float, error: float) -> tuple[float, float]:
        from math import log10
        x = left + (log10(max(cpu, 1e-3)) + 3) / 5.5 * (width - left - 20)
        return x, 20 + -log10(min(max(error, 1e-7), 10) / 10) / 8 * (height - bottom - 20)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
             'font-size="12">', f'<rect width="{width}" height="{height}" fill="white"/>']
    for k in range(-3, 3):
        x, _ = at(10.0**k, 1)
        parts += [f'<path d="M{x:.1f} 20V{height - bottom}" stroke="#ddd"/>',
                  f'<text x="{x:.1f}" y="{height - bottom + 16}" text-anchor="middle">{10.0**k:g}</text>']
    for k in range(-7, 2):
        _, y = at(1, 10.0**k)
        parts += [f'<path d="M{left} {y:.1f}H{width - 20}" stroke="#ddd"/>',
                  f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{10.0**k:g}</text>']
    for k, (label, points) in enumerate(curves):
        places = [at(cpu, error) for cpu, error in points if cpu > 0]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colours[k % 6]}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colours[k % 6]}"/>' for x, y in places]
        parts.append(f'<text x="{width - 250}" y="{250 + 16 * k}" fill="{colours[k % 6]}">{label}</text>')
    parts += [f'<text x="{width / 2}" y="{height - 12}" text-anchor="middle">CPU seconds</text>',
              f'<text x="16" y="{height / 2}" text-anchor="middle" transform="rotate(-90 16 {height / 2})">'
              "relative error of the integral of H²</text>", "</svg>"]
    return "\n".join(parts) + "\n"


# ------------------------------------------------------------------------------------------------ corpus --

SEEDS = range(1000, 1312)  # the corpus's second range
SUBSET = range(1000, 1080)
LEVELS = (1, 2)


def corpus_part(build: Path, seeds: range) -> tuple[str, dict[str, float]]:
    """Distributions over the odd ones of the seeds, of which the first 40 have each family with three sizes or four. What is
    done of it is in build/corpus, so that a stopped benchmark goes on from there."""
    program = campaign.Program((build / "curvopt").resolve())
    done = campaign.cage_folder() / f"bench_{program.settings()['program'][:12]}.json"
    runs = [campaign.Run(cage, energy, levels) for cage in campaign.corpus_files(seeds, "odd")
            for energy in campaign.ENERGIES for levels in LEVELS]
    found = campaign.campaign(runs, program, done, 1)["runs"]
    wanted = {run.key: found[run.key] for levels in LEVELS for energy in campaign.ENERGIES for run in runs
              if (run.energy, run.levels) == (energy, levels)}
    text = f"Odd seeds from {seeds.start} to {seeds.stop - 1}, {program.limit} CPU s a run.\n\n"
    return text + summary(wanted) + "\n" + acceptance(wanted, campaign.best_known()), {}


# ------------------------------------------------------------------------------------------------- main --

RELEASE = ROOT / "build" / "release"
PROGRAMS = {"curvopt_bench": {"kernels", "faces", "matrix"}, "curvopt": {"start", "shapes", "evolver", "corpus"},
            "libcurvopt.so": {"shapes"}}  # and the parts that use them


class Missing(RuntimeError):
    """Something that the benchmark needs is not there; the message is a sentence."""


def build_release() -> None:
    """Brings the preset release up to date; quietly, unless it fails."""
    for tool, package in (("cmake", "cmake"), ("ninja", "ninja-build"), ("cc", "gcc")):
        if not shutil.which(tool):
            raise Missing(f"{tool} is missing; run: apt-get install {package}")
    for command in (["cmake", "--preset", "release"],
                    ["cmake", "--build", "--preset", "release", "--target", "curvopt_bench", "curvopt_tool", "libcurvopt.so"]):
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            raise Missing(f"{' '.join(command)} failed:\n{(done.stdout + done.stderr)[-3000:]}")


def present(build: Path, wanted: list[str], chosen: bool) -> list[str]:
    """The wanted parts that can be run. Missing: what all of them need, or what a chosen one needs, is not there."""
    for program, parts in PROGRAMS.items():
        if parts & set(wanted) and not (build / program).exists():
            raise Missing(f"{build / program} is missing; without --build it is built")
    if "evolver" in wanted and not shutil.which("evolver"):
        sentence = "Surface Evolver is missing; run: apt-get install evolver-nox"
        if chosen:
            raise Missing(sentence)
        print(f"bench: the part evolver is left out: {sentence}", file=sys.stderr)
        return [part for part in wanted if part != "evolver"]
    return wanted


def first_line(*command: str) -> str:
    """What a command says first; empty if it cannot be run."""
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.partition("\n")[0]
    except OSError:
        return ""


def circumstances(build: Path) -> Row:
    """Machine, compiler, commit and load, for whoever compares figures later."""
    cpu = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    model = [line.partition(":")[2].strip() for line in cpu.splitlines() if line.startswith("model name")]
    cache = build / "CMakeCache.txt"
    lines = cache.read_text().splitlines() if cache.exists() else []
    compiler = next((line.partition("=")[2] for line in lines if line.startswith("CMAKE_C_COMPILER:")), "cc")
    changed = first_line("git", "status", "--porcelain", "--untracked-files=no")
    return {"machine": f"{model[0] if model else platform.processor()}, {os.cpu_count()} threads, {platform.platform()}",
            "compiler": first_line(compiler, "--version"),
            "commit": first_line("git", "rev-parse", "--short", "HEAD") + (" and changes" if changed else ""),
            "load_average": [round(load, 2) for load in os.getloadavg()],
            "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())}


def compare(figures: dict[str, float], baseline: dict[str, float]) -> list[tuple[str, float]]:
    """What takes longer than in the baseline, with its ratio, the worst first."""
    ratios = [(key, value / baseline[key]) for key, value in figures.items() if baseline.get(key)]
    return sorted((pair for pair in ratios if pair[1] > 1.15), key=lambda pair: -pair[1])


def main() -> int:
    """As the module says."""
    parts = ["kernels", "faces", "matrix", "start", "shapes", "evolver"]
    parser = argparse.ArgumentParser(description="Measure libcurvopt; see tests/bench/README.md.")
    parser.add_argument("--build", type=Path, help="where the programs are; default: the preset release, built now")
    parser.add_argument("--part", action="append", choices=[*parts, "corpus"], help="only this; may be repeated")
    parser.add_argument("--all-seeds", action="store_true", help="part corpus: all odd seeds, not the first 40")
    parser.add_argument("--write-baseline", action="store_true", help="these figures are to be compared with from now on")
    parser.add_argument("--output", type=Path, help="these figures as JSON")
    parser.add_argument("--picture", type=Path, help="SVG of the errors against time, from the part evolver")
    options = parser.parse_args()
    try:
        if options.build is None:
            options.build = RELEASE
            build_release()
        wanted = present(options.build, options.part or parts, bool(options.part))
    except Missing as missing:
        print(f"bench: {missing}", file=sys.stderr)
        return 2
    about = circumstances(options.build)
    rows = compiled(options.build, wanted)
    peak = max((row["peak_gflops"] for row in rows if row["kind"] == "kernel"), default=0.0)
    makers = {
        "kernels": lambda: kernel_tables([row for row in rows if row["kind"] == "kernel"]),
        "faces": lambda: faces_table([row for row in rows if row["kind"] == "faces"], peak),
        "matrix": lambda: matrix_table([row for row in rows if row["kind"] == "matrix"], peak),
        "start": lambda: start_table(options.build),
        "shapes": lambda: shapes_table(options.build),
        "evolver": lambda: evolver_table(options.build, options.picture),
        "corpus": lambda: corpus_part(options.build, SEEDS if options.all_seeds else SUBSET),
    }
    figures: dict[str, float] = {}
    for part in wanted:
        text, found = makers[part]()
        figures.update(found)
        print(f"## {part}\n\n{text}", flush=True)
    rounded = {key: float(f"{value:.4g}") for key, value in figures.items()}
    if options.output:
        options.output.write_text(json.dumps({"about": about, **rounded}, indent=1, sort_keys=True) + "\n")
    path = HERE / "baseline.json"
    baseline = json.loads(path.read_text()) if path.exists() else {}
    if options.write_baseline:
        kept = {**baseline, **rounded, "about": {**baseline.get("about", {}), **{part: about for part in wanted}}}
        path.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n")
        return 0
    slower = compare(figures, baseline)
    print("## against the baseline\n")
    print(table(["figure", "times as long"], [(key, f"{ratio:.2f}") for key, ratio in slower]) if slower
          else f"none of {len(figures)} figures takes over 1.15 times as long")
    return int(any(ratio > SLOWER for _, ratio in slower))


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs `curvopt minimize` over the corpus, and compares what came out.

    python3 tests/corpus/campaign.py run --output A.json --half odd --energies willmore mvs --levels 2
    python3 tests/corpus/campaign.py summary A.json
    python3 tests/corpus/campaign.py compare A.json B.json

`run` does what the output file does not have yet, so a stopped campaign goes on from there. The file is written whole or
not at all. Every run has one thread and a limit of CPU time. The tables are Markdown.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable, Iterable, NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from tables import compare, summary  # noqa: E402

FORMAT = 1
HALVES = {"even": (0,), "odd": (1,), "both": (0, 1)}
CATALOGUE = ROOT / "blend_files" / "obj"
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OMP_WAIT_POLICY="passive")
Record = dict[str, Any]


class Run(NamedTuple):
    """One minimization."""

    cage: Path
    energy: str
    levels: int

    @property
    def key(self) -> str:
        """Its name in the file."""
        return f"{self.cage.stem}|{self.energy}|{self.levels}"

    def cage_hash(self) -> str:
        """Of the file's contents."""
        return hashlib.sha256(self.cage.read_bytes()).hexdigest()[:16]


class Program(NamedTuple):
    """What runs are made with."""

    path: Path
    limit: int = 20                    # CPU seconds a run
    changes: tuple[str, ...] = ()      # NAME=VALUE, handed on as --set
    options: tuple[str, ...] = ()      # handed on as they are

    def settings(self) -> Record:
        """What must agree for two campaigns to be one."""
        return {"format": FORMAT, "program": hashlib.sha256(self.path.read_bytes()).hexdigest(), "limit": self.limit,
                "set": list(self.changes), "options": list(self.options)}


# --------------------------------------------------------------------------------------------------------- one run --

class Children:
    """The processes that are running, so that an interrupt can end them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: set[int] = set()
        self.stopped = False

    def execute(self, command: list[str], limit: int) -> tuple[int, float, str]:
        """Exit code (below 0: the signal), CPU seconds and standard error of a command."""
        with tempfile.TemporaryFile("w+") as errors:
            with self._lock:
                if self.stopped:
                    raise KeyboardInterrupt
                child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, env=ENVIRONMENT,
                                         start_new_session=True)
                resource.prlimit(child.pid, resource.RLIMIT_CPU, (limit, limit + 1))
                resource.prlimit(child.pid, resource.RLIMIT_CORE, (0, 0))
                self._running.add(child.pid)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            with self._lock:
                self._running.discard(child.pid)
                if self.stopped:
                    raise KeyboardInterrupt
            errors.seek(0)
            return child.returncode, usage.ru_utime + usage.ru_stime, errors.read()

    def stop(self) -> None:
        """Ends all of them; their runs are not recorded."""
        with self._lock:
            self.stopped = True
            for pid in self._running:
                os.kill(pid, signal.SIGKILL)


def perform(run: Run, program: Program, children: Children) -> Record:
    """The run's record. `outcome` is one of done, out of time, refused (by `evaluate`, too), failed."""
    with tempfile.TemporaryDirectory(prefix="corpus_") as folder:
        report = Path(folder) / "report.json"
        command = [str(program.path), "minimize", str(run.cage), "-o", str(Path(folder) / "end.obj"), "--json", str(report),
                   "--energy", run.energy, "--levels", str(run.levels), "--threads", "1", "--quiet", *program.options]
        for change in program.changes:
            command += ["--set", change]
        began = time.monotonic()
        code, cpu, message = children.execute(command, program.limit)
        record: Record = {"cage": run.cage_hash(), "cpu": round(cpu, 4), "wall": round(time.monotonic() - began, 4)}
        if code == 0:
            return {"outcome": "done", **record, **figures(json.loads(report.read_text(encoding="utf-8")))}
        if code == -signal.SIGXCPU:  # the kernel's count, which differs from the usage by up to a tenth
            return {"outcome": "out of time", **record}
        outcome = "failed"
        if code == 1:
            evaluate = [str(program.path), "evaluate", str(run.cage), "--energy", run.energy, "--threads", "1", "--quiet"]
            outcome = "refused" if children.execute(evaluate, program.limit)[0] == 1 else "failed"
        return {"outcome": outcome, **record, "code": code, "message": message.strip().replace(str(run.cage), run.cage.name)}


def figures(report: Record) -> Record:
    """What of a report is kept."""
    return {"verdict": report["verification"]["verdict"], "stop": report["stop"], "objective": report["objective"],
            "quadrature_error": report["quadrature_error"], "start": report["start"]["objective"],
            "iterations": sum(level["iterations"] for level in report["levels"]),
            "evaluations": sum(level["evaluations"] for level in report["levels"]),
            "vertices": report["vertices"], "cage_vertices": report["levels"][0]["vertices"],
            "symmetries": report["symmetry_order"]}


# ------------------------------------------------------------------------------------------------------ a campaign --

def save(path: Path, data: Record) -> None:
    """JSON, whole or not at all."""
    fresh = path.with_name(f"{path.name}.{os.getpid()}")
    fresh.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="ascii")
    fresh.replace(path)


def load(path: Path) -> Record:
    """A campaign's file."""
    data = json.loads(path.read_text(encoding="ascii"))
    if data.get("format") != FORMAT:
        raise SystemExit(f"{path}: no campaign of format {FORMAT}")
    return data


def campaign(runs: Iterable[Run], program: Program, output: Path, jobs: int,
             progress: Callable[[str, Record], None] | None = None) -> Record:
    """Does the runs that the output file does not have, or has of another cage; the whole of the file in the end."""
    settings = program.settings()
    data = load(output) if output.exists() else {**settings, "commit": commit(), "runs": {}}
    for name, value in settings.items():
        if data[name] != value:
            raise SystemExit(f"{output} was made with another {name}: {data[name]}, not {value}; name another output")
    left = {run.key: run for run in runs if data["runs"].get(run.key, {}).get("cage") != run.cage_hash()}
    children, lock = Children(), threading.Lock()

    def one(run: Run) -> None:
        record = perform(run, program, children)
        with lock:
            data["runs"][run.key] = record
            save(output, data)
            if progress:
                progress(run.key, record)

    with ThreadPoolExecutor(jobs) as pool:
        futures = [pool.submit(one, run) for run in left.values()]
        try:
            for future in futures:
                future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            children.stop()
            raise
    if not output.exists():
        save(output, data)
    return data


def commit() -> str:
    """The working copy's commit, `-dirty` if it was changed."""
    done = subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude", "*"],
                          capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def corpus_files(seeds: Iterable[int], half: str) -> list[Path]:
    """The OBJ files of a half's seeds, made where they are not there yet."""
    from cages import write  # needs numpy, which the rest does not

    folder = ROOT / "build" / "corpus"
    folder.mkdir(parents=True, exist_ok=True)
    return [write(seed, folder) for seed in seeds if seed % 2 in HALVES[half]]


def print_progress(key: str, record: Record) -> None:
    """A line a run."""
    print(f"{key:36s} {record['outcome']:12s} {record['cpu']:7.2f} s  {record.get('objective', '')!s:22s} "
          f"{record.get('iterations', '')!s:5s} {record.get('verdict', '')}", flush=True)


# ------------------------------------------------------------------------------------------------------ command line --

def add_program(parser: argparse.ArgumentParser, program: str) -> None:
    """The arguments that a program is made from."""
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / program, help="default %(default)s")
    parser.add_argument("--limit", type=int, default=20, help="CPU seconds a run (default 20)")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time (default 1)")


def arguments() -> argparse.Namespace:
    """The command line."""
    from cages import parse_seeds

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="minimize, and record what came out")
    run.add_argument("--output", type=Path, required=True, metavar="FILE.json")
    run.add_argument("--seeds", type=parse_seeds, default=range(240), metavar="FIRST:END", help="default 0:240")
    run.add_argument("--half", choices=HALVES, default="both", help="even seeds are for choosing, odd ones for publishing")
    run.add_argument("--cages", type=Path, nargs="*", default=[], metavar="CAGE.obj", help="these, too")
    run.add_argument("--energies", nargs="+", default=["willmore", "mvs"], help="default willmore mvs")
    run.add_argument("--levels", type=int, nargs="+", default=[2], help="default 2")
    run.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="handed on to the program")
    run.add_argument("options", nargs="*", help="further options of `curvopt minimize`, behind --")
    add_program(run, "curvopt")
    one = commands.add_parser("summary", help="the distributions of one campaign")
    one.add_argument("file", type=Path)
    two = commands.add_parser("compare", help="two campaigns, and the runs that both have")
    two.add_argument("files", type=Path, nargs=2, metavar="FILE.json")
    for command in (one, two):
        command.add_argument("--half", choices=HALVES, default="both")
    return parser.parse_args()


def chosen(data: Record, half: str) -> dict[str, Record]:
    """The half's runs; the catalogue's are in both."""
    def belongs(key: str) -> bool:
        stem = key.split("|")[0]
        return not stem.startswith("seed_") or int(stem[5:]) % 2 in HALVES[half]

    return {key: record for key, record in data["runs"].items() if belongs(key)}


def main() -> None:
    a = arguments()
    if a.command == "summary":
        print(summary(chosen(load(a.file), a.half)))
    elif a.command == "compare":
        print(compare(*((path.stem, chosen(load(path), a.half)) for path in a.files)))
    else:
        cages = corpus_files(a.seeds, a.half) + a.cages
        runs = [Run(cage, energy, levels) for levels in a.levels for energy in a.energies for cage in cages]
        program = Program(a.program.resolve(), a.limit, tuple(a.set), tuple(a.options))
        campaign(runs, program, a.output, a.jobs, print_progress)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped; the same command goes on")

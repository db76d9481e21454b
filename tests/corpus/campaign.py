# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs `curvopt minimize` over the corpus, and compares what came out.

    python3 tests/corpus/campaign.py run --output A.json --half odd --energies willmore mvs --levels 2
    python3 tests/corpus/campaign.py summary A.json
    python3 tests/corpus/campaign.py compare A.json B.json
    python3 tests/corpus/campaign.py best A.json...
    python3 tests/corpus/campaign.py tori --output TORI.json
    python3 tests/corpus/campaign.py touch --output DIR --seeds 1000:1100 --half odd

`run` does what the output file does not have yet, so a stopped campaign goes on from there. The file is written whole or
not at all. Every run has one thread and a limit of CPU time, at which it is interrupted. The tables are Markdown.

`best` lowers the best known energies of odd seeds, in best.json, to those of the campaigns. `tori` minimizes nets of n x m on
tori, and lists what is no certified minimum, and energies over three times a neighbour's. `touch` shakes certified results
by a thousandth of a mean edge, minimizes each again without refinement and symmetries, and says by how much it falls.
"""
from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import math
import os
import resource
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable, Iterable, NamedTuple, Sequence

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from acceptance import acceptance, lowered  # noqa: E402
from tables import compare, is_certified, summary  # noqa: E402

FORMAT = 2
GRACE = 10  # seconds that an interrupted run may take
BEST = HERE / "best.json"
ENERGIES = ("willmore", "mvs", "mvs_cross")
HALVES = {"even": (0,), "odd": (1,), "both": (0, 1)}
CATALOGUE = ROOT / "blend_files" / "obj"
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
    limit: float = 60                  # CPU seconds a run
    changes: tuple[str, ...] = ()      # NAME=VALUE, handed on as --set
    options: tuple[str, ...] = ()      # handed on as they are

    def settings(self) -> Record:
        """What must agree for two campaigns to be one."""
        return {"format": FORMAT, "program": hashlib.sha256(self.path.read_bytes()).hexdigest(), "limit": self.limit,
                "set": list(self.changes), "options": list(self.options)}


# --------------------------------------------------------------------------------------------------------- one run --

class Execution(NamedTuple):
    """What a command did."""

    code: int                # of its exit; below 0: the signal
    cpu: float               # seconds
    stopping: float | None   # seconds by the clock from the interrupt to the end; None: not interrupted
    message: str             # on standard error


def interrupt_at(pid: int, limit: float) -> float | None:
    """Waits until a child ends, or has taken `limit` CPU seconds; then interrupts it, as Ctrl-C does.

    After an interrupt: the seconds until it ended, or was killed because it did not end in GRACE seconds.
    """
    clock = (~pid << 3) | 2  # Linux's number for the CPU time of a process
    ended = os.pidfd_open(pid)
    try:
        while (left := limit - time.clock_gettime(clock)) > 0:
            if select.select([ended], [], [], left)[0]:
                return None
        began = time.monotonic()
        os.kill(pid, signal.SIGINT)
        if not select.select([ended], [], [], GRACE)[0]:
            os.kill(pid, signal.SIGKILL)
            select.select([ended], [], [])
        return time.monotonic() - began
    finally:
        os.close(ended)


class Children:
    """The processes that are running, so that an interrupt can end them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: set[int] = set()
        self.stopped = False

    def execute(self, command: list[str], limit: float) -> Execution:
        """A command, interrupted once it has taken `limit` CPU seconds."""
        with tempfile.TemporaryFile("w+") as errors:
            with self._lock:
                if self.stopped:
                    raise KeyboardInterrupt
                child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors,
                                         start_new_session=True)
                most = math.ceil(limit) + GRACE  # by the kernel, should this process end first
                resource.prlimit(child.pid, resource.RLIMIT_CPU, (most, most))
                resource.prlimit(child.pid, resource.RLIMIT_CORE, (0, 0))
                self._running.add(child.pid)
            stopping = interrupt_at(child.pid, limit)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            with self._lock:
                self._running.discard(child.pid)
                if self.stopped:
                    raise KeyboardInterrupt
            errors.seek(0)
            return Execution(child.returncode, usage.ru_utime + usage.ru_stime, stopping, errors.read())

    def stop(self) -> None:
        """Ends all of them; their runs are not recorded."""
        with self._lock:
            self.stopped = True
            for pid in self._running:
                os.kill(pid, signal.SIGKILL)


def perform(run: Run, program: Program, children: Children, results: Path | None = None) -> Record:
    """The run's record; the cage that came out goes to the folder `results`, if one is given.

    `outcome` is one of done, out of time, refused (by `evaluate`, too), failed. A run that is out of time has a result, too,
    if the program wrote one when it was interrupted.
    """
    with tempfile.TemporaryDirectory(prefix="corpus_") as folder:
        report, end = Path(folder) / "report.json", Path(folder) / "end.obj"
        command = [str(program.path), "minimize", str(run.cage), "-o", str(end), "--json", str(report),
                   "--energy", run.energy, "--levels", str(run.levels), "--threads", "1", "--quiet", *program.options]
        for change in program.changes:
            command += ["--set", change]
        began = time.monotonic()
        did = children.execute(command, program.limit)
        record: Record = {"cage": run.cage_hash(), "cpu": round(did.cpu, 4), "wall": round(time.monotonic() - began, 4)}
        if did.stopping is not None:
            record["stopping"] = round(did.stopping, 4)
        if did.code == 0:
            got = figures(json.loads(report.read_text(encoding="utf-8")))
            if results:
                shutil.copyfile(end, result_path(results, run))
            return {"outcome": "out of time" if got["stop"] == "cancelled" else "done", **record, **got, **shape(run, end)}
        if did.stopping is not None:
            return {"outcome": "out of time", **record}
        outcome = "failed"
        if did.code == 1:
            evaluate = [str(program.path), "evaluate", str(run.cage), "--energy", run.energy, "--threads", "1", "--quiet"]
            outcome = "refused" if children.execute(evaluate, program.limit).code == 1 else "failed"
        message = did.message.strip().replace(str(run.cage), run.cage.name)
        return {"outcome": outcome, **record, "code": did.code, "message": message}


def result_path(folder: Path, run: Run) -> Path:
    """The run's cage in a folder of results."""
    return folder / f"{run.cage.stem}.{run.energy}.{run.levels}.obj"


def figures(report: Record) -> Record:
    """What of a report is kept."""
    start = report["start"]
    return {"verdict": report["verification"]["verdict"], "stop": report["stop"], "objective": report["objective"],
            "quadrature_error": report["quadrature_error"], "start": start["objective"],
            "iterations": sum(level["iterations"] for level in report["levels"]),
            "evaluations": sum(level["evaluations"] for level in report["levels"]),
            "vertices": report["vertices"], "cage_vertices": report["levels"][0]["vertices"],
            "symmetries": report["symmetry_order"],
            "sampled_jacobian": [start["min_jacobian"], report["min_jacobian"]]}


def shape(run: Run, end: Path) -> Record:
    """What measures.py says of the input, subdivided as often as the result, and of the result."""
    from measures import measures, measures_of_file, read_cage

    before, after = measures_of_file(run.cage, run.cage_hash(), run.levels - 1), measures(read_cage(end))
    return {name: [round(a, 6), round(b, 6)] for name, a, b in zip(before._fields, before, after)}


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
             progress: Callable[[str, Record], None] | None = None, results: Path | None = None) -> Record:
    """Does the runs that the output file does not have, or has of another cage; the whole of the file in the end.

    The cages that come out go to the folder `results`, if one is given.
    """
    settings = program.settings()
    data = load(output) if output.exists() else {**settings, "commit": commit(), "runs": {}}
    for name, value in settings.items():
        if data[name] != value:
            raise SystemExit(f"{output} was made with another {name}: {data[name]}, not {value}; name another output")
    left = {run.key: run for run in runs if data["runs"].get(run.key, {}).get("cage") != run.cage_hash()}
    children, lock = Children(), threading.Lock()

    def one(run: Run) -> None:
        record = perform(run, program, children, results)
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
    """The working copy's commit, `-dirty` if it was changed; `unknown` outside of a checkout and without git."""
    try:
        done = subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude", "*"],
                              capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "unknown"
    return done.stdout.strip() or "unknown"


def cage_folder(name: str = "") -> Path:
    """Where cages are written, made if it is not there yet."""
    folder = ROOT / "build" / "corpus" / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def corpus_files(seeds: Iterable[int], half: str) -> list[Path]:
    """The OBJ files of a half's seeds, made where they are not there yet."""
    from cages import write  # needs numpy, which the rest does not

    folder = cage_folder()
    return [write(seed, folder) for seed in seeds if seed % 2 in HALVES[half]]


def print_progress(key: str, record: Record) -> None:
    """A line a run."""
    print(f"{key:36s} {record['outcome']:12s} {record['cpu']:7.2f} s  {record.get('objective', '')!s:22s} "
          f"{record.get('iterations', '')!s:5s} {record.get('verdict', '')}", flush=True)


# ------------------------------------------------------------------------------------------------------ command line --

def add_program(parser: argparse.ArgumentParser, program: str) -> None:
    """The arguments that a program is made from."""
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / program, help="default %(default)s")
    parser.add_argument("--limit", type=int, default=60, help="CPU seconds a run (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time (default %(default)s)")


def add_half(parser: argparse.ArgumentParser) -> None:
    """Which seeds count."""
    parser.add_argument("--half", choices=HALVES, default="both", help="even seeds are for choosing, odd ones for publishing")


def add_runs(parser: argparse.ArgumentParser, energies: Sequence[str], levels: Sequence[int]) -> None:
    """The arguments that runs are made from, apart from the cages, with these defaults."""
    parser.add_argument("--energies", nargs="+", default=list(energies), help="default %(default)s")
    parser.add_argument("--levels", type=int, nargs="+", default=list(levels), help="default %(default)s; 1: no refinement")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="handed on to the program")
    parser.add_argument("options", nargs="*", help="further options of `curvopt minimize`, behind --")
    add_program(parser, "curvopt")


def add_cages(parser: argparse.ArgumentParser) -> None:
    """Which cages are minimized."""
    from cages import parse_seeds

    parser.add_argument("--seeds", type=parse_seeds, default=range(240), metavar="FIRST:END", help="default 0:240")
    parser.add_argument("--cages", type=Path, nargs="*", default=[], metavar="CAGE.obj", help="these, too")
    add_half(parser)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)

    def add(name: str, act: Callable[[argparse.Namespace], None], about: str) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=about)
        command.set_defaults(act=act)
        return command

    run = add("run", run_campaign, "minimize, and record what came out")
    run.add_argument("--output", type=Path, required=True, metavar="FILE.json")
    add_cages(run)
    add_runs(run, ("willmore", "mvs"), (2,))
    one = add("summary", print_summary, "the distributions of one campaign")
    one.add_argument("file", type=Path)
    two = add("compare", print_comparison, "two campaigns, and the runs that both have")
    two.add_argument("files", type=Path, nargs=2, metavar="FILE.json")
    for command in (one, two):
        add_half(command)
    best = add("best", lower_best, "lower the best known energies of odd seeds")
    best.add_argument("files", type=Path, nargs="+", metavar="FILE.json")
    tori = add("tori", run_tori, "minimize nets on tori, and compare neighbours")
    tori.add_argument("--output", type=Path, required=True, metavar="FILE.json")
    add_runs(tori, ENERGIES, (2,))
    touch = add("touch", run_touch, "shake certified results a little and minimize them again")
    touch.add_argument("--output", type=Path, required=True, metavar="DIR")
    add_cages(touch)
    add_runs(touch, ENERGIES, (1, 2))
    return parser.parse_args()


def chosen(data: Record, half: str) -> dict[str, Record]:
    """The half's runs; the catalogue's are in both."""
    def belongs(key: str) -> bool:
        stem = key.split("|")[0]
        return not stem.startswith("seed_") or int(stem[5:]) % 2 in HALVES[half]

    return {key: record for key, record in data["runs"].items() if belongs(key)}


def best_known() -> dict[str, float]:
    """By cage|energy|levels."""
    return json.loads(BEST.read_text(encoding="ascii"))


def runs_of(a: argparse.Namespace, cages: list[Path]) -> list[Run]:
    """All energies and levels of the command line, of these cages."""
    return [Run(cage, energy, levels) for levels in a.levels for energy in a.energies for cage in cages]


def program_of(a: argparse.Namespace, *options: str) -> Program:
    """The program of the command line, with more options."""
    return Program(a.program.resolve(), a.limit, tuple(a.set), (*a.options, *options))


def run_campaign(a: argparse.Namespace) -> None:
    campaign(runs_of(a, corpus_files(a.seeds, a.half) + a.cages), program_of(a), a.output, a.jobs, print_progress)


def print_summary(a: argparse.Namespace) -> None:
    runs = chosen(load(a.file), a.half)
    print(summary(runs) + "\n" + acceptance(runs, best_known()))


def print_comparison(a: argparse.Namespace) -> None:
    print(compare(*((path.stem, chosen(load(path), a.half)) for path in a.files)))


def lower_best(a: argparse.Namespace) -> None:
    before = best = best_known()
    for path in a.files:
        best = lowered(best, load(path)["runs"])
    save(BEST, {key: float(f"{value:.8g}") for key, value in best.items()})
    print(f"{len(best) - len(before)} new, {sum(best[key] < before[key] for key in before)} lower, of {len(best)}")


def run_tori(a: argparse.Namespace) -> None:
    from tori import report, write_all

    data = campaign(runs_of(a, write_all(cage_folder("tori"))), program_of(a), a.output, a.jobs, print_progress)
    print("\n" + acceptance(data["runs"], {}) + "\n" + report(data["runs"]))


def run_touch(a: argparse.Namespace) -> None:
    from touch import report, touched

    results, shaken = a.output / "results", a.output / "shaken"
    for folder in (results, shaken):
        folder.mkdir(parents=True, exist_ok=True)
    runs = runs_of(a, corpus_files(a.seeds, a.half) + a.cages)
    first = campaign(runs, program_of(a), a.output / "results.json", a.jobs, print_progress, results)["runs"]
    again = {run.key: [Run(cage, run.energy, 1) for cage in touched(result_path(results, run), shaken)]
             for run in runs if is_certified(first[run.key])}
    second = campaign(itertools.chain(*again.values()), program_of(a, "--symmetry", "none"), a.output / "touched.json", a.jobs,
                      print_progress)["runs"]
    print("\n" + report(first, {key: [second[run.key] for run in some] for key, some in again.items()}))


def main() -> None:
    a = arguments()
    a.act(a)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped; the same command goes on")

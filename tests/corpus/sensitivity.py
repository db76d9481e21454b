# SPDX-License-Identifier: GPL-3.0-or-later
"""Halves and doubles each constant of the library's tuning table, and says what that changes.

    python3 tests/corpus/sensitivity.py choose --defaults EVEN.json... [--budget 40]    writes fast.txt
    python3 tests/corpus/sensitivity.py run --output DIR [--only NAME...] [--jobs 2]
    python3 tests/corpus/sensitivity.py report --output DIR

`choose` takes campaigns of the even seeds (and the catalogue) with the defaults. Its rule: of the runs that came to their
end, whatever the verdict, all that take less CPU time than a threshold, the same for all energies; the threshold is the
largest with which the runs together fit in the budget (CPU seconds). The list is committed, so that another machine runs
the same set.

`run` needs `curvopt_tuned`, which takes what `curvopt` takes, and --set NAME=VALUE and --list-tuning (a line per constant:
name, default, least, largest, 1 if integer; tabs between). A changed constant is rounded and at least 1 if it is an integer,
and clamped to its range; where that gives the default there is nothing to run. Every finished run is on disk: the same
command goes on. `report` prints what is there.

A constant changes nothing beyond noise if, halved and doubled, no verdict changes, no energy by more than 1e-6 of itself,
and the sums of CPU time and of iterations by no more than 2 %. The defaults are run twice, first of all, and their mean CPU
times are what others are compared with. Where these two sums of CPU time differ by more than 2 %, CPU times may differ by
that much: other work on the machine is not the constant's.
"""
from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from campaign import CATALOGUE, Program, Run, add_program, campaign, corpus_files, load  # noqa: E402
from tables import Runs, is_certified, is_done, shared, table, verdict  # noqa: E402

FAST = HERE / "fast.txt"
FACTORS = {"half": 0.5, "double": 2.0}
ENERGY_CHANGE = 1e-6
NOISE = 0.02
TURNS = ("defaults.json", "defaults_again.json")
HEAD = ["constant", "default", "changed to", "verdicts", "minima lost", "gained", "energies better", "worse", "CPU", "iterations"]


class Constant(NamedTuple):
    """A line of the tuning table."""

    name: str
    default: float
    least: float
    largest: float
    is_integer: bool

    def changed(self, factor: float) -> float | None:
        """The default times the factor, as the range allows; None if that is the default."""
        value = self.default * factor
        if self.is_integer:
            value = max(1, int(value + 0.5))
        value = min(max(value, self.least), self.largest)
        return None if value == self.default else value

    def text(self, value: float) -> str:
        """The value as the program reads it."""
        return str(int(value)) if self.is_integer else repr(float(value))


class Effect(NamedTuple):
    """What a change did to the runs."""

    verdicts: int
    lost: int          # runs that ended in a minimum and do so no more
    gained: int
    better: int
    worse: int
    cpu: float         # ratio of the sums, over the runs done in both
    iterations: float
    is_same: bool      # energies, iterations and evaluations to the last bit

    def is_noise(self, cpu_noise: float = NOISE) -> bool:
        """By the rule above."""
        return self.keeps_results() and abs(self.cpu - 1) <= max(NOISE, cpu_noise)

    def keeps_results(self) -> bool:
        """By the rule above, CPU time apart."""
        return self.verdicts == self.better == self.worse == 0 and abs(self.iterations - 1) <= NOISE

    def cells(self) -> list[str]:
        """Of a table."""
        return [str(self.verdicts), str(self.lost), str(self.gained), str(self.better), str(self.worse), f"{self.cpu:.3f}",
                f"{self.iterations:.3f}" + (" (same)" if self.is_same else "")]


def tuning(program: Path) -> list[Constant]:
    """The program's table."""
    done = subprocess.run([program, "--list-tuning"], check=True, capture_output=True, text=True)
    out = []
    for line in done.stdout.splitlines():
        name, default, least, largest, is_integer = line.split("\t")
        out.append(Constant(name, float(default), float(least), float(largest), is_integer == "1"))
    if not out:
        raise SystemExit(f"{program} --list-tuning: no constants")
    return out


def effect(before: Runs, after: Runs) -> Effect:
    """Of a change, from the defaults' runs and the changed ones."""
    both = shared(before, after)
    moved = [(after[k]["objective"] - before[k]["objective"]) / max(abs(before[k]["objective"]), 1e-300) for k in both]
    sums = {what: [sum(runs[k][what] for k in both) for runs in (before, after)] for what in ("cpu", "iterations")}
    exact = ("objective", "iterations", "evaluations", "verdict")
    return Effect(sum(verdict(before[k]) != verdict(after[k]) for k in before),
                  sum(is_certified(before[k]) and not is_certified(after[k]) for k in before),
                  sum(is_certified(after[k]) and not is_certified(before[k]) for k in before),
                  sum(x < -ENERGY_CHANGE for x in moved), sum(x > ENERGY_CHANGE for x in moved),
                  *(b / a if a else 1.0 for a, b in sums.values()),
                  len(both) == len(before) and all(before[k][w] == after[k][w] for k in both for w in exact))


# ----------------------------------------------------------------------------------------------------------- the set --

def choose(runs: Runs, budget: float) -> tuple[list[str], float]:
    """Keys of the fast runs, sorted, and the threshold: the CPU time of the longest of them."""
    cheap = sorted((record["cpu"], key) for key, record in runs.items() if is_done(record))
    taken, total = [], 0.0
    for cpu, key in cheap:
        total += cpu
        if total > budget:
            break
        taken.append((cpu, key))
    return sorted(key for _, key in taken), max((cpu for cpu, _ in taken), default=0.0)


def write_choice(a: argparse.Namespace) -> None:
    """fast.txt, or what --set names."""
    runs: Runs = {}
    for path in a.defaults:
        runs.update(load(path)["runs"])
    keys, threshold = choose(runs, a.budget)
    odd = [key for key in keys if key.startswith("seed_") and int(key[5:8]) % 2]
    if odd:
        raise SystemExit(f"{odd[0]} is of the odd half, which is for publishing")
    head = (f"# Runs of the sensitivity campaign, chosen by sensitivity.py: below {threshold:.2f} CPU s each, "
            f"{a.budget:g} CPU s together\n# (commit {load(a.defaults[0])['commit']}). CAGE|ENERGY|LEVELS\n")
    a.set.write_text(head + "".join(key + "\n" for key in keys), encoding="ascii")
    cages = {key.split("|")[0] for key in keys}
    print(f"{len(keys)} runs of {len(cages)} cages below {threshold:.2f} s")


def read_set(path: Path) -> list[Run]:
    """The runs of a list like fast.txt, with their cages made."""
    keys = [line for line in path.read_text(encoding="ascii").splitlines() if line and line[0] != "#"]
    out = []
    for key in keys:
        stem, energy, levels = key.split("|")
        if stem.startswith("seed_"):
            seed = int(stem[5:])
            cage = corpus_files([seed], "both")[0]
        else:
            cage = CATALOGUE / f"{stem}.obj"
        out.append(Run(cage, energy, int(levels)))
    return out


# ---------------------------------------------------------------------------------------------------------- the runs --

def variations(constants: list[Constant]) -> list[tuple[Constant, str, float]]:
    """Constant, `half` or `double`, and the value."""
    every = [(c, word, c.changed(factor)) for c in constants for word, factor in FACTORS.items()]
    return [(c, word, value) for c, word, value in every if value is not None]


def row(constant: Constant, value: float, found: Effect) -> list[str]:
    """A line of the report."""
    return [constant.name, constant.text(constant.default), constant.text(value), *found.cells()]


def perform(a: argparse.Namespace) -> None:
    """All that is not done yet; a line for each variation as it ends."""
    runs = read_set(a.set)
    constants = tuning(a.program)
    unknown = set(a.only) - {c.name for c in constants}
    if unknown:
        raise SystemExit(f"no constant is called {sorted(unknown)[0]}")
    a.output.mkdir(parents=True, exist_ok=True)
    program = Program(a.program.resolve(), a.limit)
    for turn in TURNS:
        campaign(runs, program, a.output / turn, a.jobs)
    before = baseline(a.output)
    print(table(HEAD, [turns_row(a.output)]), end="", flush=True)
    for constant, word, value in variations([c for c in constants if not a.only or c.name in a.only]):
        changed = program._replace(changes=(f"{constant.name}={constant.text(value)}",))
        after = campaign(runs, changed, path_of(a.output, constant, word), a.jobs)["runs"]
        print("| " + " | ".join(row(constant, value, effect(before, after))) + " |", flush=True)
    print("\n" + summary(a.output, constants))


def path_of(folder: Path, constant: Constant, word: str) -> Path:
    """A variation's file."""
    return folder / f"{constant.name.replace('/', '_')}.{word}.json"


def complete(folder: Path, constants: list[Constant]) -> dict[str, list[tuple[Constant, float, Effect]]]:
    """The variations of each constant of which all runs are on disk."""
    before = baseline(folder)
    out: dict[str, list[tuple[Constant, float, Effect]]] = {}
    for constant, word, value in variations(constants):
        path = path_of(folder, constant, word)
        after = load(path)["runs"] if path.exists() else {}
        if before.keys() <= after.keys():
            out.setdefault(constant.name, []).append((constant, value, effect(before, after)))
    return out


def turns(folder: Path) -> list[Runs]:
    """The runs of the defaults' two turns."""
    return [load(folder / turn)["runs"] for turn in TURNS]


def baseline(folder: Path) -> Runs:
    """The defaults' runs, with the mean CPU time of both turns."""
    one, two = turns(folder)
    return {key: {**record, "cpu": (record["cpu"] + two[key]["cpu"]) / 2} for key, record in one.items()}


def turns_row(folder: Path) -> list[str]:
    """The report's first line: the second turn against the first."""
    return ["(defaults again)", "", "", *effect(*turns(folder)).cells()]


def cpu_noise(folder: Path) -> float:
    """By how much the CPU times of the defaults' two turns differ, in sum."""
    return abs(effect(*turns(folder)).cpu - 1)


def summary(folder: Path, constants: list[Constant]) -> str:
    """Which constants change nothing beyond noise; which change no result, but CPU time; which could not be changed."""
    done = complete(folder, constants)
    wanted = {name: sum(c.name == name for c, _, _ in variations(constants)) for name in (c.name for c in constants)}
    whole = {name: [e for _, _, e in some] for name, some in done.items() if len(some) == wanted[name]}
    noise = cpu_noise(folder)
    inert = [name for name, effects in whole.items() if all(e.is_noise(noise) for e in effects)]
    slower = [name for name, effects in whole.items() if name not in inert and all(e.keeps_results() for e in effects)]
    partly = [name for name, effects in whole.items()
              if name not in inert + slower and any(e.is_noise(noise) for e in effects)]
    fixed = [name for name, n in wanted.items() if n == 0]
    lines = [f"{len(whole)} of {len(constants)} constants were changed in all ways that their ranges allow."]
    for names, what in (
            (inert, "change nothing beyond noise, halved or doubled (no verdict, no energy by more than 1e-6, "
                    f"iterations by 2 % and CPU time by {100 * max(NOISE, noise):.1f} % at most)"),
            (slower, "change no result, but CPU time by more: time again before believing that"),
            (partly, "change something in one direction only"),
            (fixed, "cannot be changed within their ranges")):
        lines.append(f"- {len(names)} {what}: {', '.join(names) or 'none'}")
    return "\n".join(lines)


def report(a: argparse.Namespace) -> None:
    """The table and the summary of what is on disk."""
    constants = tuning(a.program)
    rows = [row(*one) for some in complete(a.output, constants).values() for one in some]
    print(table(HEAD, [turns_row(a.output), *rows]))
    print(summary(a.output, constants))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    chooser = commands.add_parser("choose", help="choose the fast set")
    chooser.add_argument("--defaults", type=Path, nargs="+", required=True, metavar="FILE.json",
                         help="campaigns of the even half and the catalogue")
    chooser.add_argument("--budget", type=float, default=40, help="CPU seconds of one variation (default 40)")
    chooser.set_defaults(act=write_choice)
    runner = commands.add_parser("run", help="change the constants, one by one")
    runner.add_argument("--only", nargs="*", default=[], metavar="NAME", help="these constants alone")
    runner.set_defaults(act=perform)
    reporter = commands.add_parser("report", help="print what is there")
    reporter.set_defaults(act=report)
    for command in (chooser, runner):
        command.add_argument("--set", type=Path, default=FAST, metavar="FILE", help="the runs (default fast.txt)")
    for command in (runner, reporter):
        command.add_argument("--output", type=Path, required=True, metavar="DIR")
        add_program(command, "curvopt_tuned")
        command.set_defaults(jobs=2, limit=10)
    a = parser.parse_args()
    a.act(a)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped; the same command goes on")

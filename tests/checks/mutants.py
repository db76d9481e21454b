#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutation testing: changes one operator, constant, condition or statement at a time, and sees whether a test fails.

    mutants.py --output OUT.json [--work DIR] [--mutants N] [--seed S] [--budget SECONDS] [--numeric FILE...]

The commit that is checked out is cloned into DIR and built there; the checkout itself is not touched. Of N random changes in
libcurvopt/src/optimize, solve and energy each is compiled; one that does not compile, or gives the same machine code, does not
count. Then tests run until one fails: the unit test of the file's name, those that include the file's header, those that
include headers of its folder, all others; in each group the shortest first. --numeric: pytest files that run at the end.
A test that takes more than ten times its usual CPU time, and over 20 s, counts as failed.

OUT.json has each mutant with what became of it, and is written after each: a second call goes on. The end of the output has
killed and survived by folder, and each survivor. --budget: CPU seconds of tests for each mutant, after which it counts as a
survivor though some tests have not run; JSON says how many have.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = "libcurvopt/src"
FOLDERS = ("optimize", "solve", "energy")
LEAST_LIMIT, TIMES = 20, 10  # CPU seconds of a test, and times its usual ones
TOKENS = {" + ": " - ", " - ": " + ", " += ": " -= ", " -= ": " += ", " < ": " <= ", " <= ": " < ", " > ": " >= ",
          " >= ": " > ", " && ": " || ", " || ": " && ", " == ": " != ", " != ": " == "}  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:e-?\d+)?|\d+e-?\d+|\d+)(?![\w.])")
CONDITION = re.compile(r"^(\s*(?:\} else )?if )\((.*)\)( \{)?$")
STATEMENT = re.compile(r"^\s*(?:[a-z]\w*(?:->|\.|\[|\()[^;]*|\*?\w+ [-+*/|&]?= [^;]*|[a-z]\w*(?:\+\+|--));$")
# Tests of files that have none of their own: what they do is seen through the exported functions.
THROUGH = {"live": "test_solver", "live_solve": "test_solver", "live_state": "test_solver", "level_response": "test_solver",
           "strength": "test_solver", "run": "test_multilevel", "run_start": "test_multilevel", "verdict": "test_multilevel",
           "symmetry_reduction": "test_multilevel", "moving_level": "test_minimize", "slide": "test_minimize",
           "held_scalars": "test_held_level", "marking": "test_adaptive_quadrature", "quadrature_error": "test_adaptive_quadrature",
           "element_batches": "test_evaluate", "assembly": "test_evaluate"}  # fmt: skip


@dataclass
class Mutant:
    """One change; `outcome` is "", "stillborn", "equivalent", "killed" or "survived"."""

    file: str
    line: int
    kind: str
    before: str
    after: str
    outcome: str = ""
    by: str = ""  # the test that failed
    n_tests: int = 0  # that ran


def code_lines(text: str) -> list[tuple[int, str]]:
    """(number from 0, line) of what is code: no comments, preprocessor, strings or lines that only go on."""
    found, inside = [], False
    for number, line in enumerate(text.split("\n")):
        begins = inside
        rest = line.split("*/", 1)[1] if inside and "*/" in line else line
        inside = (inside and "*/" not in line) or ("/*" in rest and "*/" not in rest.split("/*", 1)[1])
        if not begins and "/*" not in line and '"' not in line and not line.lstrip().startswith("#") and line.strip():
            found.append((number, line))
    return found


def changes(file: str, text: str) -> list[Mutant]:
    """Every change of a file that this script knows."""
    found = []
    for number, line in code_lines(text):

        def add(kind: str, after: str, number: int = number, line: str = line) -> None:
            found.append(Mutant(file, number + 1, kind, line, after))

        if re.match(r"^(static |typedef |enum|struct|\w[\w ]*\**\w+\(.*\{$)", line):
            continue  # declarations
        for token, other in TOKENS.items():
            for match in re.finditer(re.escape(token), line):
                add(token.strip(), line[: match.start()] + other + line[match.end() :])
        for match in NUMBER.finditer(line):
            number_text = match.group(1)
            value = float(number_text)
            others = [text for text in ("0", "1", f"{2 * value:g}") if float(text) != value]
            if "[" not in line[: match.start()][-1:]:  # no sizes of arrays
                for other in others:
                    shown = other if "." not in number_text and "e" not in number_text or "." in other else other + ".0"
                    add("constant", line[: match.start()] + shown + line[match.end() :])
        if match := CONDITION.match(line):
            add("condition", f"{match.group(1)}(!({match.group(2)})){match.group(3) or ''}")
        if STATEMENT.match(line) and not re.match(r"^\s*(return|break|continue|goto)\b", line):
            add("statement", re.sub(r"\S.*$", ";", line))
    return found


def choose(root: Path, rng: random.Random, n: int) -> list[Mutant]:
    """n changes of the sources below root: first a folder, then a line, then a change of it, so that no file counts for its many constants."""
    by_folder: dict[str, dict[tuple[str, int], list[Mutant]]] = {}
    for folder in FOLDERS:
        lines: dict[tuple[str, int], list[Mutant]] = {}
        for path in sorted((root / SOURCES / folder).glob("*.[ch]")):
            for mutant in changes(f"{SOURCES}/{folder}/{path.name}", path.read_text()):
                lines.setdefault((mutant.file, mutant.line), []).append(mutant)
        by_folder[folder] = lines
    chosen, seen = [], set()
    while len(chosen) < n:
        lines = by_folder[FOLDERS[len(chosen) % len(FOLDERS)]]
        mutant = rng.choice(lines[rng.choice(sorted(lines))])
        if (key := (mutant.file, mutant.line, mutant.after)) not in seen:
            seen.add(key)
            chosen.append(mutant)
    return chosen


def take_commit(folder: Path) -> str:
    """Brings the commit that is checked out into the clone, which is made if it is not there; the commit."""
    if not folder.exists():
        subprocess.run(["git", "clone", "-q", "--local", str(ROOT), str(folder)], check=True)
    found = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    commit = found.stdout.strip()
    subprocess.run(["git", "-C", str(folder), "fetch", "-q", "origin"], check=True)
    subprocess.run(["git", "-C", str(folder), "checkout", "-qf", commit], check=True)
    return commit


class Workshop:
    """The clone, its build, and its tests."""

    def __init__(self, folder: Path, numeric: list[str]) -> None:
        self.folder, self.build = folder, folder / "build" / "mutants"
        self.commit = take_commit(folder)
        settings = ["-DCMAKE_BUILD_TYPE=Release", "-DCURVOPT_PORTABLE=ON", "-DCURVOPT_TAO=OFF", "-DCMAKE_C_FLAGS=-w",
                    "-DCMAKE_C_FLAGS_RELEASE=-O1"]  # fmt: skip
        subprocess.run(["cmake", "-S", str(folder), "-B", str(self.build), "-G", "Ninja", *settings], check=True, capture_output=True)
        self.numeric = numeric
        self.units = sorted(path.stem for path in (folder / "tests" / "unit").glob("test_*.c"))
        self.units = [name for name in self.units if name not in ("test_own_blas", "test_cpu_model", "test_tuning")]
        self.make(*self.units, *(["curvopt"] if numeric else []))
        self.seconds = self.usual_seconds()

    def usual_seconds(self) -> dict[str, float]:
        """CPU seconds of each unit test without a change; measured once for a clone. All must pass."""
        path = self.build / "seconds.json"
        if not path.exists():
            found = {name: self.run_unit(name, 600) for name in self.units}
            failed = [name for name, (well, _) in found.items() if not well]
            if failed:
                raise SystemExit(f"without a change these fail: {' '.join(failed)}")
            path.write_text(json.dumps({name: seconds for name, (_, seconds) in found.items()}))
        return json.loads(path.read_text())

    def make(self, *targets: str) -> bool:
        """Whether they could be built."""
        return subprocess.run(["ninja", "-C", str(self.build), "-j1", *targets], capture_output=True).returncode == 0

    def run(self, command: list[str], limit: float, **options: object) -> tuple[bool, float]:
        """(whether it ended well, CPU seconds); it is killed after `limit` of them, or 20 times as long on the clock."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)

        def limited() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_AS, (2**33, 2**33))

        try:
            done = subprocess.run(command, capture_output=True, preexec_fn=limited, timeout=20 * limit, **options)
            well = done.returncode == 0
        except subprocess.TimeoutExpired:
            well = False
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return well, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def run_unit(self, name: str, limit: float) -> tuple[bool, float]:
        """One unit test."""
        return self.run([str(self.build / "tests" / name)], limit)

    def order(self, file: str) -> list[str]:
        """Unit tests, those first that most likely fail if this file is wrong."""
        folder, stem = Path(file).parent.name, Path(file).stem

        def rank(name: str) -> tuple[int, float]:
            text = (self.folder / "tests" / "unit" / f"{name}.c").read_text()
            first = 0 if name in (f"test_{stem}", THROUGH.get(stem)) else 1 if f'"{folder}/{stem}.h"' in text else 2 if f'"{folder}/' in text else 3
            return first, self.seconds[name]

        return sorted(self.units, key=rank)

    def objects(self, file: str) -> dict[Path, bytes]:
        """Object files of a source in the static library; of a header, of all of its folder."""
        folder, name = Path(file).parent.name, Path(file).name
        pattern = f"**/{folder}/*.o" if name.endswith(".h") else f"**/{folder}/{name}.o"
        names = [path for path in self.build.glob(f"libcurvopt/CMakeFiles/{pattern}")]
        names += self.build.glob("libcurvopt/CMakeFiles/**/element_kernel*.o") if name.startswith("kernel_") else []
        return {path: path.read_bytes() for path in names}

    def try_out(self, mutant: Mutant, budget: float) -> None:
        """Sets what becomes of a mutant; the source is as it was afterwards."""
        path = self.folder / mutant.file
        text, before = path.read_text(), self.objects(mutant.file)
        lines = text.split("\n")
        assert lines[mutant.line - 1] == mutant.before, mutant
        lines[mutant.line - 1] = mutant.after
        path.write_text("\n".join(lines))
        try:
            if not self.make("curvopt_static"):
                mutant.outcome = "stillborn"
            elif self.objects(mutant.file) == before:
                mutant.outcome = "equivalent"
            else:
                mutant.outcome = "survived"
                self.test(mutant, budget)
        finally:
            path.write_text(text)
            os.utime(path)
            self.make("curvopt_static")

    def test(self, mutant: Mutant, budget: float) -> None:
        """Runs tests until one fails."""
        spent = 0.0
        for name in self.order(mutant.file):
            if spent >= budget:
                return
            well, seconds = False, 0.0
            if self.make(name):
                well, seconds = self.run_unit(name, max(LEAST_LIMIT, TIMES * self.seconds[name]))
            spent, mutant.n_tests = spent + seconds, mutant.n_tests + 1
            if not well:
                mutant.outcome, mutant.by = "killed", name
                return
        for name in self.numeric if self.make("curvopt", "curvopt_tool") else []:
            environment = {**os.environ, "CURVOPT_BUILD": str(self.build)}
            command = [sys.executable, "-m", "pytest", "-q", "-x", name]
            well, _ = self.run(command, 600, cwd=self.folder, env=environment)
            mutant.n_tests += 1
            if not well:
                mutant.outcome, mutant.by = "killed", name
                return


def report(mutants: list[Mutant]) -> None:
    """Counts by folder, and the survivors."""
    counts = Counter((Path(mutant.file).parent.name, mutant.outcome) for mutant in mutants)
    for folder in FOLDERS:
        killed, survived = counts[folder, "killed"], counts[folder, "survived"]
        rate = f"{100 * killed / (killed + survived):.0f} %" if killed + survived else "-"
        print(f"{folder:10} killed {killed:3}  survived {survived:3}  ({rate})  stillborn {counts[folder, 'stillborn']:3}  "
              f"the same code {counts[folder, 'equivalent']:3}")  # fmt: skip
    for mutant in mutants:
        if mutant.outcome == "survived":
            print(f"{mutant.file}:{mutant.line} {mutant.kind}\n    {mutant.before.strip()}\n    {mutant.after.strip()}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--work", type=Path, metavar="DIR", help="the clone (default: OUT.json.clone)")
    parser.add_argument("--mutants", type=int, default=60, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--budget", type=float, default=float("inf"), metavar="SECONDS")
    parser.add_argument("--numeric", nargs="*", default=[], metavar="FILE")
    options = parser.parse_args()
    folder = (options.work or Path(f"{options.output}.clone")).resolve()
    take_commit(folder)
    mutants = choose(folder, random.Random(options.seed), options.mutants)
    known: dict[tuple[str, int, str, str], dict[str, object]] = {}
    if options.output.exists():
        known = {(m["file"], m["line"], m["before"], m["after"]): m for m in json.loads(options.output.read_text())["mutants"]}
    for mutant in mutants:
        for field, value in known.get((mutant.file, mutant.line, mutant.before, mutant.after), {}).items():
            setattr(mutant, field, value)
    if all(mutant.outcome for mutant in mutants):
        report(mutants)
        return 0
    workshop = Workshop(folder, options.numeric)
    for k, mutant in enumerate(mutants):
        if mutant.outcome:
            continue
        started = time.monotonic()
        workshop.try_out(mutant, options.budget)
        said = f"{mutant.outcome} {mutant.by}".strip()
        print(f"{k + 1}/{len(mutants)} {mutant.file}:{mutant.line} {mutant.kind}: {said}, {time.monotonic() - started:.0f} s", flush=True)
        draft = options.output.with_name(options.output.name + ".new")
        draft.write_text(json.dumps({"seed": options.seed, "commit": workshop.commit, "mutants": list(map(asdict, mutants))}, indent=1))
        os.replace(draft, options.output)
    report(mutants)
    return 0


if __name__ == "__main__":
    sys.exit(main())

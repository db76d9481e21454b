#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutation testing: changes one operator, constant, condition or statement at a time, and sees whether a test fails.

    mutants.py --output OUT.json [--work DIR] [--commit REVISION] [--mutants N] [--seed S] [--budget SECONDS] [--numeric [TEST...]] [--again]

The commit that is checked out, or REVISION, is cloned into DIR and built there; the checkout itself is not touched. Of N random changes in
libcurvopt/src/optimize, solve and energy each is compiled; one that does not compile, or gives the same machine code, does not
count. Then tests run until one fails: the unit test of the file's name, those that include the file's header, those that
include headers of its folder, all others that can call it by the flow of folders; in each group the shortest first. --numeric:
then tests of pytest, by default those of NUMERIC that are about the file, the shortest first.
A test that takes more than ten times its usual CPU time, and over 5 s, counts as failed.

OUT.json has each mutant with what became of it, and is written after each: a second call goes on. The end of the output has
killed and survived by folder and by kind of change, and each survivor. --budget: CPU seconds of tests for each mutant; tests
that would take more, but for the first, do not run, and JSON says how many have.

--again: survivors of OUT.json, which may be of another commit, are tried again with the tests of today where their lines are
still there. Each survivor has `note`, for a reader to fill in. --runs: RUNS are runs of the command line on small cages; for each
survivor `differ` lists those whose bytes are not those without the change. Where none does, the change may be one of speed
alone; this alone does not prove it.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shlex
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
SOURCES = "libcurvopt/src"
FOLDERS = ("optimize", "solve", "energy")
LEAST_LIMIT, TIMES = 5, 10  # CPU seconds of a test, and times its usual ones
TOKENS = {" + ": " - ", " - ": " + ", " += ": " -= ", " -= ": " += ", " < ": " <= ", " <= ": " < ", " > ": " >= ",
          " >= ": " > ", " && ": " || ", " || ": " && ", " == ": " != ", " != ": " == "}  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:e-?\d+)?|\d+e-?\d+|\d+)(?![\w.])")
CONDITION = re.compile(r"^(\s*(?:\} else )?if )\((.*)\)( \{)?$")
STATEMENT = re.compile(r"^\s*(?:[a-z]\w*(?:->|\.|\[|\()[^;]*|\*?\w+ [-+*/|&]?= [^;]*|[a-z]\w*(?:\+\+|--));$")
# Tests of files that have none of their own: what they do is seen through the exported functions.
THROUGH = {"live": "test_solver", "live_solve": "test_solver", "live_state": "test_solver",
           "run": "test_multilevel", "run_start": "test_multilevel", "verdict": "test_multilevel",
           "symmetry_reduction": "test_saddle_escape", "moving_level": "test_minimize", "marking": "test_adaptive_quadrature",
           "quadrature_error": "test_adaptive_quadrature", "spontaneous_curvature": "test_held_numbers",
           "element_batches": "test_evaluate", "assembly": "test_evaluate", "assembly_sums": "test_evaluate"}  # fmt: skip
# Tests that no mutant concerns, and one that takes 20 s.
SKIPPED = ("test_own_blas", "test_cpu_model", "test_tuning", "test_oom")
# The flow of folders from the mutated ones on: a test that includes no header of a folder or a later one cannot call it.
FLOW = ("energy", "constraints", "hessian", "optimize", "solve", "api")
# Tests of tests/numeric about files of solve/, by how their names begin: of each topic those that take seconds.
STRENGTH = "test_strength.py -k 'not beyond and not farther'"
PINS = "test_held.py -k 'not balance and not guide and not depends'"
SLIDE = "test_slide.py -k 'not ends_lower and not boundary_stays and not pinned'"
LIMIT_POINTS = "test_through.py -k 'go_where or stay_where'"
LEVELS = "test_minimize.py -k 'never_rises or cancelled_run'"
NUMERIC = {"strength": [STRENGTH], "slide": [SLIDE], "level": [LEVELS, PINS, LIMIT_POINTS], "run": [LEVELS, STRENGTH, PINS, SLIDE],
           "multilevel": [LEVELS, SLIDE], "step_review": [LEVELS], "verdict": [LEVELS, PINS], "symmetry": [LEVELS]}  # fmt: skip
# Runs of the command line for `differ`: cages of blend_files/obj, options.
RUNS = ("torus_030 --energy mvs --levels 2 --verify", "torus_050_8x8 --levels 3", "sphere_cube --energy mvs --levels 2 --escape",
        "pretzel_g2 --levels 1 --symmetry none --volume keep", "pretzel_g2 --levels 1 --strength 0.3", "mug_g1 --levels 1 --within 0.05",
        "branch_open --levels 2 --slide", "branch_open --energy mvs --levels 1 --boundary tangent --reduced-volume 0.5")  # fmt: skip


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
    cpu: float = 0  # seconds of tests
    differ: list[str] | None = None  # of a survivor: those of RUNS whose results are not the same bytes
    note: str = ""  # of a survivor: what a reader found


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


def take_commit(folder: Path, revision: str) -> str:
    """Brings a commit into the clone, which is made if it is not there; its name."""
    if not folder.exists():
        subprocess.run(["git", "clone", "-q", "--local", str(ROOT), str(folder)], check=True)
    found = subprocess.run(["git", "-C", str(ROOT), "rev-parse", revision], check=True, capture_output=True, text=True)
    commit = found.stdout.strip()
    subprocess.run(["git", "-C", str(folder), "fetch", "-q", "origin"], check=True)
    subprocess.run(["git", "-C", str(folder), "checkout", "-qf", commit], check=True)
    return commit


class Workshop:
    """The clone, its build, and its tests."""

    def __init__(self, folder: Path, commit: str, numeric: list[str] | None, runs: bool) -> None:
        """numeric: None for no tests of pytest, [] for those of NUMERIC."""
        self.folder, self.build = folder, folder / "build" / "mutants"
        self.commit = commit
        settings = ["-DCMAKE_BUILD_TYPE=Release", "-DCURVOPT_PORTABLE=ON", "-DCURVOPT_TAO=OFF", "-DCMAKE_C_FLAGS=-w",
                    "-DCMAKE_C_FLAGS_RELEASE=-O1", "-DCMAKE_EXE_LINKER_FLAGS=-fsanitize=leak"]  # fmt: skip
        subprocess.run(["cmake", "-S", str(folder), "-B", str(self.build), "-G", "Ninja", *settings], check=True, capture_output=True)
        rules = self.build / "build.ninja"  # the kernel asks for -O3, which takes four times as long to compile
        rules.write_text(rules.read_text().replace(" -O3 ", " -O2 "))
        self.numeric = numeric
        self.units = sorted(path.stem for where in ("unit", "robust") for path in (folder / "tests" / where).glob("test_*.c"))
        self.units = [name for name in self.units if name not in SKIPPED]
        if not self.make("curvopt_static", *self.units, "libcurvopt.so", "curvopt_tool"):
            raise SystemExit("the clone cannot be built")
        self.headers = {name: self.headers_of(f"{name}.c") for name in self.units}
        self.seconds = self.usual_seconds()
        self.usual = {run: self.bytes_of(run) for run in RUNS} if runs else {}

    def headers_of(self, name: str) -> set[str]:
        """The library's headers that a test in C includes, itself or by files beside it: "folder/stem"."""
        path = self.folder / "tests" / "unit" / name
        path = path if path.exists() else self.folder / "tests" / "robust" / name
        found = re.findall(r'#include "(.*)\.h"', path.read_text())
        beside = [stem for stem in found if "/" not in stem and path.with_name(f"{stem}.h").exists()]
        below = [self.headers_of(f"{stem}.{end}") for stem in beside for end in ("h", "c")
                 if f"{stem}.{end}" != name and path.with_name(f"{stem}.{end}").exists() and (end == "c" or not name.startswith(stem))]
        return set(found).union(*below)

    def usual_seconds(self) -> dict[str, float]:
        """CPU seconds of each test without a change; measured once for a clone and its commit. All must pass."""
        path = self.build / "seconds.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        found = known.get("tests", {}) if known.get("commit") == self.commit else {}
        for name in (*self.units, *self.all_numeric()):
            if name not in found:
                well, found[name] = self.run_test(name, 600)
                if not well:
                    raise SystemExit(f"without a change this fails: {name}")
                path.write_text(json.dumps({"commit": self.commit, "tests": found}))
        return found

    def all_numeric(self) -> list[str]:
        """Tests of pytest that may be wanted."""
        chosen = self.numeric if self.numeric is None or self.numeric else sorted({test for tests in NUMERIC.values() for test in tests})
        return chosen or []

    def make(self, *targets: str) -> bool:
        """Whether they could be built."""
        return subprocess.run(["ninja", "-C", str(self.build), "-j1", *targets], capture_output=True).returncode == 0

    def run(self, command: list[str], limit: float) -> tuple[bool, float]:
        """(whether it ended well, CPU seconds); it is killed after `limit` of them, or 20 times as long on the clock."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)

        def limited() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        environment = {**os.environ, "CURVOPT_BUILD": str(self.build), "LSAN_OPTIONS": "hard_rss_limit_mb=4096:allocator_may_return_null=1"}
        try:
            done = subprocess.run(command, capture_output=True, preexec_fn=limited, timeout=20 * limit, cwd=self.folder, env=environment)
            well = done.returncode == 0
        except subprocess.TimeoutExpired:
            well = False
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return well, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def run_test(self, name: str, limit: float) -> tuple[bool, float]:
        """A unit test, or one of tests/numeric by file or node."""
        if ".py" not in name:
            return self.run([str(self.build / "tests" / name)], limit)
        command = [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *shlex.split(f"tests/numeric/{name}")]
        return self.run(command, limit)

    def order(self, file: str) -> list[str]:
        """Tests that can call the file, those first that most likely fail if it is wrong."""
        folder, stem = Path(file).parent.name, Path(file).stem
        later = FLOW[FLOW.index(folder) :]

        def rank(name: str) -> tuple[int, float]:
            of_folder = [header for header in self.headers[name] if header.startswith(f"{folder}/")]
            first = 0 if name in (f"test_{stem}", THROUGH.get(stem)) else 1 if f"{folder}/{stem}" in of_folder else 2 if of_folder else 3
            return first, self.seconds[name]

        def can_call(name: str) -> bool:
            return any(header.split("/")[0] in later or header == "curvopt" for header in self.headers[name])

        numeric = self.all_numeric()
        if not self.numeric:
            numeric = [test for begin, tests in NUMERIC.items() if stem.startswith(begin) for test in tests if test in numeric]
        return sorted(filter(can_call, self.units), key=rank) + sorted(set(numeric), key=self.seconds.get)

    def objects(self, file: str) -> dict[Path, bytes]:
        """Object files of a source in the static library; of a header, of all of its folder."""
        folder, name = Path(file).parent.name, Path(file).name
        pattern = f"**/{folder}/*.o" if name.endswith(".h") else f"**/{folder}/{name}.o"
        names = [path for path in self.build.glob(f"libcurvopt/CMakeFiles/{pattern}")]
        names += self.build.glob("libcurvopt/CMakeFiles/**/element_kernel*.o") if name.startswith("kernel_") else []
        return {path: path.read_bytes() for path in names}

    def try_out(self, mutant: Mutant, budget: float) -> None:
        """Sets what becomes of a mutant; the source and what was built of it are as they were afterwards."""
        path = self.folder / mutant.file
        text, times, before = path.read_text(), path.stat(), self.objects(mutant.file)
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
            self.put_back(path, times.st_mtime_ns, before)

    def put_back(self, path: Path, time_ns: int, objects: dict[Path, bytes]) -> None:
        """A kernel takes half a minute to compile: the objects are written back, as old as ninja knows them to be."""
        os.utime(path, ns=(time_ns, time_ns))
        for name, content in objects.items():
            if not name.exists() or name.read_bytes() != content:
                made = name.stat().st_mtime_ns if name.exists() else None
                name.write_bytes(content)
                if made:
                    os.utime(name, ns=(made, made))
        for name in (*self.build.glob("libcurvopt_static.a"), *self.build.glob("libcurvopt.so*"), self.build / "curvopt"):
            name.unlink(missing_ok=True)

    def test(self, mutant: Mutant, budget: float) -> None:
        """Runs tests until one fails; of a survivor, the runs."""
        for name in self.order(mutant.file):
            if mutant.cpu > 0 and mutant.cpu + self.seconds[name] > budget:
                continue
            well, seconds = False, 0.0
            if self.make(*([name] if ".py" not in name else ["libcurvopt.so", "curvopt_tool"])):
                well, seconds = self.run_test(name, max(LEAST_LIMIT, TIMES * self.seconds[name]))
            mutant.cpu, mutant.n_tests = round(mutant.cpu + seconds, 2), mutant.n_tests + 1
            if not well:
                mutant.outcome, mutant.by = "killed", name
                return
        if self.usual:
            self.make("curvopt_tool")
            mutant.differ = [run for run in RUNS if self.bytes_of(run) != self.usual[run]]

    def bytes_of(self, run: str) -> bytes:
        """The cage that comes out of a run of the command line, and its figures but for seconds."""
        cage, *options = run.split()
        out = self.build / "run.obj"
        out.unlink(missing_ok=True)
        command = [str(self.build / "curvopt"), "minimize", str(self.folder / f"blend_files/obj/{cage}.obj"), "-o", str(out), "--quiet",
                   "--threads", "1", "--json", "-", *options]  # fmt: skip
        said = subprocess.run(["bash", "-c", 'ulimit -t 60; exec "$@"', "run", *command], capture_output=True)
        return re.sub(rb'"seconds": *[^,}]*', b"", said.stdout) + (out.read_bytes() if out.exists() else b"")


def report(mutants: list[Mutant]) -> None:
    """Counts by folder and by kind of change, and the survivors."""
    def rates(of: Callable[[Mutant], str]) -> None:
        counts = Counter((of(mutant), mutant.outcome) for mutant in mutants)
        for name in sorted({of(mutant) for mutant in mutants}):
            killed, survived = counts[name, "killed"], counts[name, "survived"]
            rate = f"{100 * killed / (killed + survived):.0f} %" if killed + survived else "-"
            print(f"{name:10} killed {killed:3}  survived {survived:3}  ({rate})  stillborn {counts[name, 'stillborn']:3}  "
                  f"the same code {counts[name, 'equivalent']:3}")  # fmt: skip

    for mutant in mutants:
        if mutant.outcome == "survived":
            print(f"{mutant.file}:{mutant.line} {mutant.kind}\n    {mutant.before.strip()}\n    {mutant.after.strip()}")
            if mutant.differ is not None or mutant.note:
                runs = "" if mutant.differ is None else f"results that differ: {', '.join(mutant.differ) or 'none'}. "
                print(f"    {runs}{mutant.note}")
    rates(lambda mutant: mutant.kind if mutant.kind in ("constant", "condition", "statement") else "operator")
    rates(lambda mutant: Path(mutant.file).parent.name)
    rates(lambda _: "all")


def write(output: Path, seed: int, commit: str, mutants: list[Mutant]) -> None:
    """Whole or not at all."""
    draft = output.with_name(output.name + ".new")
    draft.write_text(json.dumps({"seed": seed, "commit": commit, "mutants": list(map(asdict, mutants))}, indent=1))
    os.replace(draft, output)


def find_again(folder: Path, known: list[dict[str, Any]]) -> list[Mutant]:
    """Mutants of OUT.json where their lines are now: survivors without an outcome. Those whose lines are gone are left out."""
    found = []
    for entry in known:
        mutant = Mutant(**entry)
        lines = (folder / mutant.file).read_text().split("\n")
        places = [k + 1 for k, line in enumerate(lines) if line == mutant.before]
        if mutant.outcome == "survived":
            if not places:
                continue
            mutant.line = min(places, key=lambda place: abs(place - mutant.line))
            mutant.outcome, mutant.cpu, mutant.n_tests = "", 0, 0
        found.append(mutant)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--work", type=Path, metavar="DIR", help="the clone (default: OUT.json.clone)")
    parser.add_argument("--commit", default="HEAD", metavar="REVISION")
    parser.add_argument("--mutants", type=int, default=60, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--budget", type=float, default=float("inf"), metavar="SECONDS")
    parser.add_argument("--numeric", nargs="*", metavar="TEST", help="such as test_held.py; none: those of NUMERIC")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--runs", action="store_true")
    options = parser.parse_args()
    folder = (options.work or Path(f"{options.output}.clone")).resolve()
    commit = take_commit(folder, options.commit)
    known = json.loads(options.output.read_text()) if options.output.exists() else {"commit": commit, "mutants": []}
    if options.again:
        mutants = find_again(folder, known["mutants"]) if known["commit"] != commit else [Mutant(**m) for m in known["mutants"]]
    elif known["commit"] != commit:
        raise SystemExit(f"{options.output} is of commit {known['commit']}: check that out, or try its survivors --again")
    else:
        mutants = choose(folder, random.Random(options.seed), options.mutants)
        before = {(m["file"], m["line"], m["before"], m["after"]): m for m in known["mutants"]}
        mutants = [Mutant(**before.get((m.file, m.line, m.before, m.after), asdict(m))) for m in mutants]
    workshop = Workshop(folder, commit, options.numeric, options.runs) if not all(mutant.outcome for mutant in mutants) else None
    for k, mutant in enumerate(mutants):
        if mutant.outcome or not workshop:
            continue
        workshop.try_out(mutant, options.budget)
        said = f"{mutant.outcome} {mutant.by}".strip()
        print(f"{k + 1}/{len(mutants)} {mutant.file}:{mutant.line} {mutant.kind}: {said}, {mutant.cpu:.0f} s", flush=True)
        write(options.output, options.seed, commit, mutants)
    report(mutants)
    return 0


if __name__ == "__main__":
    sys.exit(main())

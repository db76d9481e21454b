#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults while `curvopt` runs: killed, disk full, folder gone, memory out, others writing there, streams closed.

    faults.py PROGRAM [--faults N] [--seed S] [--only KIND] [--blender PROGRAM --batch FILE.py --blend FILE.blend]

After each fault every output is whole, the new one or the one of before, or it is not there; exit code and sentence are
right; and once the same command has run again to its end, nothing is there but its outputs. The same seed makes the same
faults, but for the moments, which depend on the machine. As root a full and a read-only disk are file systems of their own;
else a limit on the size of files and a folder without permission. With --blender the batch command is killed, too.

Exit status: 0 if all is as it should be, 1 if not (a line for each fault that shows something wrong), 2 wrong usage.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path

OLD = "# what was there before\n"
MOST_CPU = 60  # seconds, after which a run counts as one that hangs
KINDS: dict[str, Callable[["Place"], None]] = {}


class Wrong(Exception):
    """Something is not as it should be."""


def check(condition: object, what: str) -> None:
    """Wrong, with this sentence, unless the condition holds."""
    if not condition:
        raise Wrong(what)


def torus(n: int, m: int) -> str:
    """An OBJ file of n x m quads."""
    lines = []
    for i in range(n):
        for j in range(m):
            a, b = 2 * math.pi * i / n, 2 * math.pi * j / m
            r = 1 + 0.4 * math.cos(b)
            lines.append(f"v {r * math.cos(a):.15g} {r * math.sin(a):.15g} {0.4 * math.sin(b):.15g}")
    for i in range(n):
        for j in range(m):
            k, l = (i + 1) % n, (j + 1) % m  # noqa: E741
            lines.append(f"f {i * m + j + 1} {k * m + j + 1} {k * m + l + 1} {i * m + l + 1}")
    return "\n".join(lines) + "\n"


# A run that writes much after a short time, and one that computes.
COMMANDS = {
    "minimize": ["minimize", "cage.obj", "-o", "out.obj", "--json", "out.json", "--trace", "out.csv", "--levels", "4",
                 "--max-iterations", "1", "--threads", "1", "--quiet"],
    "steps": ["minimize", "cage.obj", "-o", "out.obj", "--json", "out.json", "--trace", "out.csv", "--levels", "3",
              "--energy", "mvs", "--threads", "2", "--quiet"],
    "evaluate": ["evaluate", "cage.obj", "--json", "out.json", "--energy", "mvs", "--tolerance", "1e-8", "--quiet"],
}  # fmt: skip
CAGES = {"minimize": (12, 8), "steps": (8, 6), "evaluate": (12, 8)}
VERTICES = {"minimize": 12 * 8 * 64, "steps": 8 * 6 * 16, "evaluate": 12 * 8}
OUTPUTS = {"minimize": ("out.obj", "out.json", "out.csv"), "steps": ("out.obj", "out.json", "out.csv"), "evaluate": ("out.json",)}


class Place:
    """A folder with a cage, a command to run there, and perhaps outputs of before."""

    def __init__(self, program: str, folder: Path, rng: random.Random, command: str | None = None) -> None:
        self.program, self.folder, self.rng = program, folder, rng
        self.command = command or rng.choice(list(COMMANDS))
        self.old = rng.random() < 0.5
        self.fill(folder)

    def fill(self, folder: Path) -> None:
        """Cage and outputs of before, into an empty folder."""
        (folder / "cage.obj").write_text(torus(*CAGES[self.command]))
        for name in OUTPUTS[self.command] if self.old else ():
            (folder / name).write_text(OLD)

    def start(self, **options: object) -> subprocess.Popen[str]:
        """The command, started in the folder; its errors are piped, unless options say otherwise."""
        fields: dict[str, object] = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        before = options.pop("preexec_fn", None)

        def limited() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (MOST_CPU, MOST_CPU))
            if before:
                before()

        fields.update(cwd=self.folder, text=True, preexec_fn=limited, **options)
        return subprocess.Popen([self.program, *COMMANDS[self.command]], **fields)

    def run(self, **options: object) -> tuple[int, str]:
        """Exit code and standard error of the command."""
        process = self.start(**options)
        errors = process.communicate()[1] or ""
        return process.returncode, errors

    def seconds(self) -> float:
        """How long the command takes here, measured once."""
        key = self.command
        if key not in _seconds:
            started = time.monotonic()
            with tempfile.TemporaryDirectory() as scratch:
                other = Place(self.program, Path(scratch), random.Random(0), self.command)
                check(other.run() == (0, ""), "the command fails without a fault")
            _seconds[key] = time.monotonic() - started
        return _seconds[key]

    def pause(self) -> None:
        """A random moment of the run."""
        time.sleep(self.rng.uniform(0, 1.1) * self.seconds())

    def outputs_are_whole(self, folder: Path | None = None) -> int:
        """Each is new and whole, or the one of before, or, if there was none, perhaps not there. How many are new."""
        folder, new = folder or self.folder, 0
        for name in OUTPUTS[self.command]:
            path = folder / name
            if not path.exists():
                check(not self.old, f"{name} of before is gone")
                continue
            text = path.read_text()
            if text == OLD and self.old:
                continue
            check(self.is_whole(name, text), f"{name} is not whole: {len(text)} characters, ends in {text[-40:]!r}")
            new += 1
        return new

    def is_whole(self, name: str, text: str) -> bool:
        """Whether an output has all that it begins."""
        if not text.endswith("\n"):
            return False
        if name.endswith(".json"):
            try:
                return json.loads(text)["vertices"] in self.sizes()
            except (ValueError, KeyError):
                return False
        lines = text.splitlines()
        if name.endswith(".csv"):
            return len({line.count(",") for line in lines}) == 1
        vertices, faces = (sum(line.startswith(f"{letter} ") for line in lines) for letter in "vf")
        return vertices in self.sizes() and faces == vertices and len(lines[-1].split()) == 5

    def sizes(self) -> set[int]:
        """Vertices that a result may have: an interrupted run ends on any level."""
        n, m = CAGES[self.command]
        return {n * m * 4**level for level in range(4)}

    def next_run_leaves_nothing(self) -> None:
        """The same command, without a fault, ends with all outputs and no other file."""
        check(self.run() == (0, ""), "the next run fails")
        check(self.outputs_are_whole() == len(OUTPUTS[self.command]), "the next run does not write all")
        left = sorted(set(os.listdir(self.folder)) - {"cage.obj", *OUTPUTS[self.command]})
        check(not left, f"left behind: {' '.join(left)}")


_seconds: dict[str, float] = {}


def is_sentence(errors: str, *parts: str) -> bool:
    """One line of the program's, with one of these parts."""
    return errors.startswith("curvopt: ") and errors.count("\n") == 1 and any(part in errors for part in parts)


def fault(function: Callable[[Place], None]) -> Callable[[Place], None]:
    """Registers a kind of fault by the function's name."""
    KINDS[function.__name__] = function
    return function


def finish(process: subprocess.Popen[str], codes: tuple[int, ...], *parts: str) -> None:
    """The process ends with one of these codes, with 1 in a sentence with one of these parts, else silently."""
    errors = process.communicate()[1] or ""
    check(process.returncode in codes, f"exit code {process.returncode}, not of {codes}; errors: {errors!r}")
    if process.returncode == 1:
        check(is_sentence(errors, *parts), f"standard error is {errors!r}")
    else:
        check(not errors, f"standard error is {errors!r} at exit code {process.returncode}")


# ----------------------------------------------------------------------------------------------- signals, kill -9 --


@fault
def killed(place: Place) -> None:
    """kill -9 at a random moment."""
    process = place.start()
    place.pause()
    process.kill()
    finish(process, (0, -signal.SIGKILL))
    place.outputs_are_whole()
    place.next_run_leaves_nothing()


@fault
def killed_while_writing(place: Place) -> None:
    """kill -9 as soon as a partial file is there: mostly one is left."""
    process = place.start()
    while process.poll() is None and not any(name.endswith(".part") for name in os.listdir(place.folder)):
        pass
    time.sleep(place.rng.choice((0, 0, 0.001, 0.003)))
    process.kill()
    finish(process, (0, -signal.SIGKILL))
    place.outputs_are_whole()
    place.next_run_leaves_nothing()


@fault
def signalled(place: Place) -> None:
    """SIGTERM, SIGHUP or SIGPIPE at a random moment; the first two end the program as they end others."""
    number = place.rng.choice((signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE))
    process = place.start()
    place.pause()
    process.send_signal(number)
    finish(process, (0, -number))
    new = place.outputs_are_whole()
    check(process.returncode != 0 or new == len(OUTPUTS[place.command]), "exit code 0, and outputs are missing")
    place.next_run_leaves_nothing()


@fault
def interrupted(place: Place) -> None:
    """SIGINT: a run has a result, an evaluation has none and says so; before it is heard, it ends the program."""
    process = place.start()
    place.pause()
    process.send_signal(signal.SIGINT)
    finish(process, (0, 1, -signal.SIGINT), "cage.obj: it was cancelled")
    check(process.returncode != 1 or place.command == "evaluate", "a run that was interrupted has a result")
    new = place.outputs_are_whole()
    check((new == len(OUTPUTS[place.command])) == (process.returncode == 0), f"{new} outputs are new")
    place.next_run_leaves_nothing()


# ------------------------------------------------------------------------------------------------ disks and folders --


@contextmanager
def mounted(folder: Path, options: str):
    """A file system of its own at the folder; False where that is not allowed."""
    command = ["mount", "-t", "tmpfs", "-o", options, "curvopt_faults", str(folder)]
    ok = os.geteuid() == 0 and subprocess.run(command, capture_output=True).returncode == 0
    try:
        yield ok
    finally:
        if ok:
            subprocess.run(["umount", "-l", str(folder)], check=True)


@fault
def disk_is_full(place: Place) -> None:
    """Some pages are free, or files may have some bytes."""
    pages = place.rng.randrange(1, 60)
    with tempfile.TemporaryDirectory() as scratch, mounted(Path(scratch), f"size={4 * pages + 32}k") as ok:
        if ok:
            kept, place.folder = place.folder, Path(scratch)
            place.fill(place.folder)
            finish(place.start(), (0, 1), "No space left on device")
            new = place.outputs_are_whole()
            left = [name for name in os.listdir(place.folder) if name.endswith(".part")]
            check(not left, f"left behind: {' '.join(left)}")
            check(new == 0 or not place.old or new == len(OUTPUTS[place.command]), f"{new} outputs are new")
            place.folder = kept
    size = 4096 * pages if place.command != "evaluate" else pages
    process = place.start(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
    finish(process, (0, 1), "File too large")
    new = place.outputs_are_whole()
    check((new == len(OUTPUTS[place.command])) == (process.returncode == 0) or place.old, f"{new} outputs are new")
    place.next_run_leaves_nothing()


@fault
def folder_is_read_only(place: Place) -> None:
    """Nothing can be written; what is there stays as it is."""
    with tempfile.TemporaryDirectory() as scratch, mounted(Path(scratch), "size=1m") as ok:
        kept, place.folder = place.folder, Path(scratch)
        place.fill(place.folder)
        before = sorted(os.listdir(place.folder))
        if ok:
            subprocess.run(["mount", "-o", "remount,ro", scratch], check=True)
        os.chmod(scratch, 0o555) if not ok else None
        if ok or os.geteuid() != 0:
            finish(place.start(), (1,), "Read-only file system", "Permission denied")
            check(place.outputs_are_whole() == 0 and sorted(os.listdir(place.folder)) == before, "the folder has changed")
        os.chmod(scratch, 0o755) if not ok else None
        place.folder = kept
    place.next_run_leaves_nothing()


@fault
def folder_goes_away(place: Place) -> None:
    """It is removed, or moved, at a random moment: an error, or whole outputs where the folder is now."""
    other = place.folder.with_name(place.folder.name + "_moved")
    process = place.start()
    place.pause()
    moved = place.rng.random() < 0.5
    if moved:
        place.folder.rename(other)
    else:
        shutil.rmtree(place.folder, ignore_errors=True)
    finish(process, (0, 1), "No such file or directory")
    if moved:
        place.outputs_are_whole(other)
        other.rename(place.folder)
    else:
        shutil.rmtree(place.folder, ignore_errors=True)
        place.folder.mkdir()
        place.fill(place.folder)
    place.next_run_leaves_nothing()


# -------------------------------------------------------------------------------------------------- memory, others --


@fault
def memory_is_out(place: Place) -> None:
    """A random limit on the address space. 127: the loader itself has too little."""
    limit = int(2 ** place.rng.uniform(22, 28.5))
    process = place.start(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    errors = process.communicate()[1]
    if process.returncode != 127 or limit > 2**24:
        check(process.returncode in (0, 1), f"exit code {process.returncode} at {limit} bytes; errors: {errors!r}")
        check(errors == "" if process.returncode == 0 else is_sentence(errors, "memory"), f"standard error is {errors!r}")
    place.outputs_are_whole()
    left = [name for name in os.listdir(place.folder) if name.endswith(".part")]
    check(not left, f"left behind: {' '.join(left)}")
    place.next_run_leaves_nothing()


@fault
def two_runs_write_the_same(place: Place) -> None:
    """Both end well, and each output is of one of them; a third one may be killed meanwhile."""
    first, second, third = place.start(), place.start(), place.start()
    if place.rng.random() < 0.5:
        place.pause()
        third.kill()
    finish(third, (0, -signal.SIGKILL))
    finish(first, (0,))
    finish(second, (0,))
    check(place.outputs_are_whole() == len(OUTPUTS[place.command]), "not all outputs are new")
    place.next_run_leaves_nothing()


@fault
def input_changes(place: Place) -> None:
    """Another program rewrites the cage again and again, whole and in pieces, while the run reads it."""
    done, path = threading.Event(), place.folder / "cage.obj"
    text = path.read_text()
    cuts = [place.rng.randrange(len(text)) for _ in range(50)]

    def rewrite() -> None:
        for k in range(10**9):
            if done.is_set():
                return
            with open(path, "w") as file:
                cut = cuts[k % len(cuts)]
                file.write(text[:cut])
                file.flush()
                file.write(text[cut:])

    thread = threading.Thread(target=rewrite)
    thread.start()
    try:
        process = place.start()
        errors = process.communicate()[1]
    finally:
        done.set()
        thread.join()
    check(process.returncode in (0, 1), f"exit code {process.returncode}; errors: {errors!r}")
    check(errors == "" if process.returncode == 0 else is_sentence(errors, "cage.obj"), f"standard error is {errors!r}")
    for name in OUTPUTS[place.command]:
        output = place.folder / name
        if output.exists() and (output.read_text() != OLD or not place.old):
            check(output.read_text().endswith("\n"), f"{name} is not whole")
            output.unlink()
    place.old = False
    path.write_text(text)
    place.next_run_leaves_nothing()


# --------------------------------------------------------------------------------------------------------- streams --


@fault
def streams_are_closed(place: Place) -> None:
    """Some of the three standard streams are closed: no file gets their numbers."""
    closed = place.rng.sample((0, 1, 2), place.rng.randrange(1, 4))

    def close() -> None:
        for number in closed:
            os.close(number)

    code, errors = place.run(preexec_fn=close)
    check(code == 0 and not errors, f"exit code {code}; errors: {errors!r}")  # --quiet: nothing is printed
    check(place.outputs_are_whole() == len(OUTPUTS[place.command]), "not all outputs are new")
    place.next_run_leaves_nothing()


@fault
def reader_has_gone(place: Place) -> None:
    """Standard output is a pipe that nobody reads, or closed, and figures go there: an error, and nothing is left."""
    name = OUTPUTS[place.command][-1]
    command = ["-" if word == name else word for word in COMMANDS[place.command]]
    reading, writing = os.pipe()
    os.close(reading)
    is_closed = place.rng.random() < 0.5
    process = subprocess.Popen(
        [place.program, *command], cwd=place.folder, text=True, stdin=subprocess.DEVNULL, stdout=writing,
        stderr=subprocess.PIPE, preexec_fn=lambda: os.close(1) if is_closed else None,
    )  # fmt: skip
    os.close(writing)
    finish(process, (1,), "Broken pipe", "Bad file descriptor")
    check(place.outputs_are_whole() == 0, "outputs are new though one could not be written")
    left = [name for name in os.listdir(place.folder) if name.endswith(".part")]
    check(not left, f"left behind: {' '.join(left)}")
    place.next_run_leaves_nothing()


# ----------------------------------------------------------------------------------------------------------- batch --


def batch_killed(place: Place, blender: str, script: str, blend: str) -> None:
    """kill -9 of the batch command at a random moment; the next one finishes and leaves nothing."""
    command = [blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P", script, "--", blend, "--into",
               str(place.folder / "results"), "--energy", "willmore", "--levels", "1", "--levels", "2"]  # fmt: skip
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    process = subprocess.Popen(command, **quiet)
    time.sleep(place.rng.uniform(0.5, 6))
    process.kill()
    process.communicate()
    again = subprocess.run(command, **quiet)
    check(again.returncode == 0, f"the next batch fails: {again.stdout[-400:]}")
    names = sorted(os.listdir(place.folder / "results"))
    stem = Path(blend).stem
    wanted = [name for name in names if name.startswith(stem) and name.endswith((".blend", ".json"))]
    check(len(wanted) == 4 and wanted == names, f"the folder has: {' '.join(names)}")
    for name in names:
        if name.endswith(".json"):
            json.loads((place.folder / "results" / name).read_text())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--faults", type=int, default=36, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--only", choices=sorted(KINDS), metavar="KIND", help=", ".join(sorted(KINDS)))
    parser.add_argument("--blender", metavar="PROGRAM")
    parser.add_argument("--batch", metavar="FILE.py")
    parser.add_argument("--blend", metavar="FILE.blend")
    options = parser.parse_args()
    if bool(options.blender) != bool(options.batch and options.blend):
        parser.error("--blender, --batch and --blend go together")
    program = str(Path(options.program).resolve())
    kinds = dict(KINDS)
    if options.blender:
        batch = [options.blender, *(str(Path(name).resolve()) for name in (options.batch, options.blend))]
        kinds = {"batch_killed": lambda place: batch_killed(place, *batch)}
    names, counts, wrong = sorted(kinds), Counter(), 0
    for k in range(options.faults):
        name = options.only or names[k % len(names)]
        with tempfile.TemporaryDirectory(prefix="curvopt_faults_") as scratch:
            folder = Path(scratch) / "folder"
            folder.mkdir()
            place = Place(program, folder, random.Random(f"{options.seed} {k}"))
            try:
                kinds[name](place)
            except Wrong as error:
                wrong += 1
                print(f"not ok - fault {k}, {name}, {place.command}, with outputs of before {place.old}: {error}", flush=True)
            counts[name] += 1
    print(", ".join(f"{name} {count}" for name, count in sorted(counts.items())))
    print(f"{options.faults - wrong} passed, {wrong} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

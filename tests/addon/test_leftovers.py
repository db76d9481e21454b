# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary files of batch runs that were killed."""

import os
import subprocess
import sys
from pathlib import Path

from addon.batch import leftovers


def gone_process() -> int:
    """The number of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_process_that_has_ended_is_gone_and_others_are_not():
    assert leftovers.is_gone(gone_process())
    assert not leftovers.is_gone(os.getpid()) and not leftovers.is_gone(os.getppid()) and not leftovers.is_gone(1)
    assert leftovers.is_gone(2**62)


def test_what_killed_runs_have_left_is_removed_and_nothing_else(tmp_path: Path):
    gone, parent = gone_process(), os.getppid()
    left = [f".a (1).{gone}.blend", f".a (1).{gone}.blend@", f".a (1).{os.getpid()}.blend"]
    others = [
        "a (1).blend", f".a (1).{parent}.blend", f".b.{gone}.blend", f".a (1).{gone}.json", f".a (1).{gone}.blend1",
        f"a (1).{gone}.blend", ".a (1)..blend", ".a (1).12x.blend", f".a (1).1.{gone}.blend",
    ]  # fmt: skip
    for name in left + others:
        (tmp_path / name).write_text("x")
    leftovers.remove(tmp_path / "a (1).blend")
    assert sorted(os.listdir(tmp_path)) == sorted(others)
    leftovers.remove(tmp_path / "no" / "such.blend")


def test_what_cannot_be_removed_stays(tmp_path: Path):
    gone = gone_process()
    (tmp_path / f".a.{gone}.blend").mkdir()
    (tmp_path / f".a.{gone}.blend@").write_text("x")
    leftovers.remove(tmp_path / "a.blend")
    assert os.listdir(tmp_path) == [f".a.{gone}.blend"]

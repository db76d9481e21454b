# SPDX-License-Identifier: GPL-3.0-or-later
"""Results are the same bits with all instruction sets of x86-64: cages are minimized by curvopt_sets, which is the command
line as on a processor that has no more than it is told (instruction_sets.c)."""
from __future__ import annotations

import json
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import lib
from ccref import mesh_from_faces
from nets import write_obj

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import cages  # noqa: E402

PROGRAM = lib.BUILD / "curvopt_sets"
NOT_HERE = 77
SETS = ("portable", "avx2", "avx512")
# Seeds, energy, levels. By default 61 cages; those that take more than two or three CPU seconds with CURVOPT_LONG=1 alone.
WILLMORE = (*range(43), 47, 49, 50, 51, 52, 56, 68)
MVS = (*range(100, 112), 138, 144, 153, 156, 162)
MVS_CROSS = (*range(112, 130), 165, 174, 183, 192)
SLOW = {7, 12, 13, 14, 16, 30, 31, 33, 40, 100, 101, 102, 103, 104, 107, 109, 110, 112, 113, 114, 116, 118, 119, 121, 122, 123,
        127, 128}  # fmt: skip
RUNS = [(seed, energy, levels) for seeds, energy, levels in ((WILLMORE, "willmore", 2), (MVS, "mvs", 1), (MVS_CROSS, "mvs_cross", 1))
        for seed in seeds if lib.LONG or seed not in SLOW]  # fmt: skip


def without_times(value: object) -> object:
    """Figures of a report that are not of a clock."""
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key != "seconds"}
    return [without_times(inner) for inner in value] if isinstance(value, list) else value


def minimize(path: Path, energy: str, levels: int, instruction_set: str) -> tuple[bytes, object] | None:
    """The minimized cage's bytes and its figures; None if this processor has not got the instruction set."""
    out = path.with_name(f"{instruction_set}.obj")
    done = subprocess.run(
        [PROGRAM, "--instruction-set", instruction_set, "minimize", path, "-o", out, "--energy", energy, "--levels", str(levels),
         "--threads", "1", "--quiet", "--json", "-"], capture_output=True, text=True)  # fmt: skip
    if done.returncode == NOT_HERE:
        return None
    assert done.returncode == 0, done.stderr
    return out.read_bytes(), without_times(json.loads(done.stdout))


@pytest.mark.parametrize("seed, energy, levels", RUNS)
def test_same_bits(seed: int, energy: str, levels: int, tmp_path: Path) -> None:
    """A random cage's minimizer: every vertex, energy, step and verdict."""
    xyz, faces, _ = cages.cage(seed)
    path = tmp_path / "cage.obj"
    write_obj(path, mesh_from_faces(xyz, faces))
    found = [result for name in SETS if (result := minimize(path, energy, levels, name))]
    if len(found) < 2:
        pytest.skip("this processor has one instruction set")
    for other in found[1:]:
        assert other == found[0]


def test_no_operation_is_fused() -> None:
    """Compilers fuse at times, whatever they are told: the program is taken apart."""
    objdump = shutil.which("objdump")
    if objdump is None or platform.machine() != "x86_64":
        pytest.skip("there is no objdump, or the processor has other instructions")
    code = subprocess.run([objdump, "-d", "--no-show-raw-insn", PROGRAM], capture_output=True, text=True, check=True).stdout
    assert "mulsd" in code
    fused = re.findall(r"^.*\svfn?m(?:add|sub)\w*\s.*$", code, re.MULTILINE)
    assert not fused, fused[:3]

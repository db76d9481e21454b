# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes beyond memory: refused before a run where that is certain, stopped between levels where it shows. No bpy.

Linux hands out more memory than there is and then kills who uses it: Blender, with all unsaved work. So what a level
has taken is measured, and the next one, of four times as many vertices, is not begun if it would not fit.
"""

from __future__ import annotations

import os
from pathlib import Path

from ..binding.values import Progress

_LEAST = 8_000  # bytes per vertex of a cage that a run takes at least: measured with 5000 vertices and 32 symmetries
_GROWTH = 4.5  # from level to level: four times the vertices, and factors grow a little faster


class MemoryRefusal(ValueError):
    """The cage is larger than the machine."""


def available() -> float:
    """Bytes that programs can still have; infinite where the system does not say."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return float("inf")


def used() -> float:
    """Bytes that this process has in memory; 0 where the system does not say."""
    try:
        return float(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0.0


def check_cage(n_vertices: int) -> None:
    """MemoryRefusal if not even one level of a cage of so many vertices fits."""
    least = n_vertices * _LEAST
    if least > available():
        raise MemoryRefusal(
            f"The cage has {n_vertices:,} vertices, for which a run takes {least / 1e9:.0f} GB at least, and "
            f"{available() / 1e9:.0f} GB are free: use a coarser cage."
        )


class Guard:
    """Asked at every step whether to stop, because the level that begins will not fit."""

    def __init__(self) -> None:
        self.stopped = False
        self._start = used()
        self._level, self._most = 1, 0.0

    def __call__(self, progress: Progress) -> bool:
        """Whether to stop."""
        if progress.level > self._level:
            self.stopped = self.stopped or _GROWTH * self._most > available() + self._most
            self._level = progress.level
        self._most = max(self._most, used() - self._start)
        return self.stopped

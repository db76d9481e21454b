# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the library's file lies: one folder `native/PLATFORM/` inside the package for each platform that it came with."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

LIBRARY_VARIABLE = "CURVOPT_LIBRARY"
PACKAGE = Path(__file__).resolve().parent
FILE_NAMES = {"linux": "libcurvopt.so", "windows": "curvopt.dll", "macos": "libcurvopt.dylib"}
_SYSTEMS = {"linux": "linux", "win32": "windows", "darwin": "macos"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def platform_name(system: str = sys.platform, machine: str | None = None) -> str:
    """This machine as Blender's extension platform calls it, for example "linux-x64"."""
    machine = (machine or platform.machine()).lower()
    return f"{_SYSTEMS.get(system, system)}-{_MACHINES.get(machine, machine)}"


def file_name(platform_: str) -> str:
    """The library's file on a platform."""
    return FILE_NAMES.get(platform_.partition("-")[0], "libcurvopt.so")


def platforms_here() -> list[str]:
    """Platforms that this copy of the package has libraries for, sorted; none in a checkout and in Debian's package."""
    return sorted(path.parent.name for path in (PACKAGE / "native").glob("*/*curvopt*"))


def library_candidates() -> list[Path]:
    """Where the library may lie: the file that CURVOPT_LIBRARY names; or else the package's own; or else that of a
    checkout's build, or the system's, which its loader finds by name."""
    named = os.environ.get(LIBRARY_VARIABLE)
    if named:
        return [Path(named).absolute()]  # a bare name would be looked for elsewhere by the system's loader
    name = platform_name()
    inside = PACKAGE / "native" / name / file_name(name)
    if PACKAGE.parents[1].name == "libcurvopt":
        return [inside, PACKAGE.parents[2] / "build" / "release" / file_name(name)]
    return [inside]


def missing_text(candidates: list[Path]) -> str:
    """Why no candidate is there, and what to do, as a sentence."""
    here, name = platforms_here(), platform_name()
    if here and name not in here and not os.environ.get(LIBRARY_VARIABLE):
        return (
            f"The curvopt library for {name} is missing: this package is for {', '.join(here)}. Remove it and install "
            f"the file whose name has {name.replace('-', '_')} in it."
        )
    return (
        f"The curvopt library is missing: looked for {' and '.join(map(str, candidates))}. Install the add-on's zip or the "
        "wheel again, or in a checkout build it: cmake --preset release && cmake --build --preset release."
    )

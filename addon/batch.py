# SPDX-License-Identifier: GPL-3.0-or-later
"""Other files of the add-on for those that Blender runs with -P, which are then no part of a package: the folder is
loaded as one. No bpy."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

_ALONE = "curvopt_alone"  # the package's name then


def part(name: str) -> ModuleType:
    """Another file of the add-on, by name."""
    package = __package__
    if not package:
        package, here = _ALONE, Path(__file__).resolve().parent
        if package not in sys.modules:
            spec = importlib.util.spec_from_file_location(
                package, here / "__init__.py", submodule_search_locations=[str(here)]
            )
            sys.modules[package] = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(sys.modules[package])
    return importlib.import_module(f"{package}.{name}")

# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package `curvopt`, under a name of the add-on's own: `binding.library` is the file `library.py` of that package.

The package comes as a folder of the add-on (`vendor/curvopt`: the zip for Blender 3.4 to 4.1), as a wheel that Blender has
installed (extensions), or from the project's checkout. Several versions of it may be on Python's path, of other add-ons or
of the user's own. Therefore the add-on does not `import curvopt`, which gives whichever comes first or has been loaded
already: it takes the first folder whose version is its own.
"""

import os
import re
import sys
from pathlib import Path

VERSION = "0.1.0"  # of the add-on, and so of the package that it needs; a test compares with the root CMakeLists.txt


def _version_of(folder: Path) -> "str | None":
    """The version of the package in a folder; None if there is no such package."""
    try:
        found = re.search(r'^VERSION = "(.+)"', (folder / "version.py").read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        return None
    return found[1] if found else None


def _find() -> Path:
    """The folder of the package. ImportError, with what to do, if there is none of this version."""
    addon, others = Path(__file__).resolve().parents[1], []
    wheels = addon.parents[1] / ".local/lib/python{}.{}/site-packages".format(*sys.version_info)  # of Blender's extensions
    own = [addon / "vendor" / "curvopt", addon.parent / "libcurvopt" / "python" / "curvopt", wheels / "curvopt"]
    for folder in [*own, *(Path(entry) / "curvopt" for entry in sys.path if os.path.isabs(entry))]:
        version = _version_of(folder)
        if version == VERSION:
            return folder
        if version is not None:
            others.append(f"version {version} in {folder}")
    seen = f" There is {' and '.join(others)}." if others else ""
    raise ImportError(
        f"This add-on needs version {VERSION} of the Python package curvopt, which is not here.{seen} Remove every version of "
        f"Curvopt in Edit > Preferences > Add-ons, restart Blender, and install the zip of version {VERSION} for this system and "
        "this version of Blender."
    )


__path__ = [str(_find())]

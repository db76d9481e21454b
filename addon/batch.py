# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the batch command, batch/command.py: blender -b FILE.blend --python-exit-code 1 -P addon/batch.py -- ...

Blender runs this file with -P, outside of any package. So the add-on's folder, wherever it is, is loaded as a package
first; it need not be installed, and nothing is registered.
"""

import importlib
import importlib.util
import sys
from pathlib import Path

_PACKAGE = "curvopt_batch"  # the folder's name as a package here; an installed add-on has another one

if __name__ == "__main__":
    folder = Path(__file__).resolve().parent
    spec = importlib.util.spec_from_file_location(
        _PACKAGE, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    sys.modules[_PACKAGE] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[_PACKAGE])
    command = importlib.import_module(f"{_PACKAGE}.batch.command")  # the folder batch/, which comes before this file
    sys.exit(command.main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))

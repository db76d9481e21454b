# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the repository and the helpers on the path, for tests with and without Blender."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
for folder in (HERE, HERE.parents[1]):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the package and the packing script on the path; the library is this checkout's build, unless a test says otherwise."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
for folder in ("libcurvopt/python", "libcurvopt/packaging"):
    sys.path.insert(0, str(ROOT / folder))

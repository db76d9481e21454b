# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the oracle and the cages importable."""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
for folder in (HERE, HERE.parent / "oracle", HERE.parent / "cages"):
    sys.path.insert(0, str(folder))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the numeric tests' library, the oracle and the cages importable."""
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parent.parent
for folder in (TESTS / "tao", TESTS / "numeric", TESTS / "oracle", TESTS / "cages"):
    sys.path.insert(0, str(folder))

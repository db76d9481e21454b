# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the oracle and the cages importable; gives each process of pytest-xdist a processor of its own, and so one thread."""
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
for folder in (HERE, HERE.parent / "oracle", HERE.parent / "cages"):
    sys.path.insert(0, str(folder))

WORKER = os.environ.get("PYTEST_XDIST_WORKER", "")  # gw0, gw1, ...
if WORKER:
    processors = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {processors[int(WORKER[2:]) % len(processors)]})

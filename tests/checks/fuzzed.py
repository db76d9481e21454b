# SPDX-License-Identifier: GPL-3.0-or-later
"""Each exported function (tests/abi/symbols.txt) is called by a harness of tests/fuzz.

    python3 tests/checks/fuzzed.py

One line for each that is not; the last line is "N passed, N failed".
"""
from __future__ import annotations

import re
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parent.parent


def functions() -> list[str]:
    """Names of the exported functions."""
    return re.findall(r"^(curvopt_\w+)$", (TESTS / "abi" / "symbols.txt").read_text(encoding="utf-8"), re.MULTILINE)


def named() -> set[str]:
    """Every word of the harnesses."""
    return {word for path in (TESTS / "fuzz").glob("*.c")
            for word in re.findall(r"\w+", re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL))}


def main() -> int:
    """As the module says."""
    words = named()
    names = functions()
    missing = [name for name in names if name not in words]
    for name in missing:
        print(f"no fuzzer calls {name}")
    print(f"{len(names) - len(missing)} passed, {len(missing) + (not names)} failed")
    return int(bool(missing) or not names)


if __name__ == "__main__":
    sys.exit(main())

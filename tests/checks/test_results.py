# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether results.py sees what differs, on made-up results: python3 tests/checks/test_results.py."""

from __future__ import annotations

import sys

from results import OUT_OF_TIME, Result, differences

RESULT: Result = {"objective": 8.5, "seconds": 1.0, "cage": "a", "gauss": 1e-9, "verification": {"verdict": "minimum"},
                  "levels": [{"iterations": 7, "energy": 9.0}, {"iterations": 3, "energy": 8.5}]}
# What the result after has otherwise, the tolerance, and what must be reported.
CASES: dict[str, tuple[Result, float, list[tuple[str, object, object]]]] = {
    "nothing": ({}, 0, []),
    "times": ({"seconds": 2.0}, 0, []),
    "an energy": ({"objective": 8.5 * (1 + 2e-12)}, 1e-12, [("objective", 8.5, 8.5 * (1 + 2e-12))]),
    "an energy within the tolerance": ({"objective": 8.5 * (1 + 5e-13)}, 1e-12, []),
    "the last bit": ({"objective": 8.5 * (1 + 3e-16)}, 0, [("objective", 8.5, 8.5 * (1 + 3e-16))]),
    "an energy that is no number any more": ({"objective": None}, 1e-12, [("objective", 8.5, None)]),
    "steps": ({"levels": [{"iterations": 7, "energy": 9.0}, {"iterations": 4, "energy": 8.5}]}, 1e-12,
              [("levels[2].iterations", 3, 4)]),
    "levels": ({"levels": []}, 1e-12, [("levels", RESULT["levels"], [])]),
    "the verdict": ({"verification": {"verdict": "saddle"}}, 1e-12, [("verification.verdict", "minimum", "saddle")]),
    "a small figure": ({"gauss": 2e-9}, 1e-12, []),
    "a small figure, to the last bit": ({"gauss": 2e-9}, 0, [("gauss", 1e-9, 2e-9)]),
    "the cage, to the last bit": ({"cage": "b"}, 0, [("cage", "a", "b")]),
    "a new figure": ({"more": 1}, 1e-12, [("more", None, None)]),
}


def main() -> int:
    """Every case."""
    said = {name: list(differences(RESULT, {**RESULT, **change}, tolerance)) for name, (change, tolerance, _) in CASES.items()}
    wanted = {name: case[2] for name, case in CASES.items()}
    said["out of time after"] = list(differences(RESULT, OUT_OF_TIME, 1e-12))[:1]
    wanted["out of time after"] = [("run", "a result", "out of CPU time")]
    said["out of time in both"] = list(differences(OUT_OF_TIME, OUT_OF_TIME, 0))
    wanted["out of time in both"] = []
    failed = [name for name in wanted if said[name] != wanted[name]]
    for name in failed:
        print(f"test_results: {name}: expected {wanted[name]}, got {said[name]}")
    print(f"{len(wanted) - len(failed)} passed, {len(failed)} failed")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())

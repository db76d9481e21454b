# SPDX-License-Identifier: GPL-3.0-or-later
"""Line coverage of libcurvopt/src: python3 tests/checks/coverage.py BUILD [--least PERCENT] [--lines FILE...].

BUILD is a folder that was built with gcc's --coverage and in which programs have run since. A line counts as run if it has
run in any of the objects that contain it (headers, and the element kernel, are compiled several times). Prints a table of
the folders, the files below PERCENT with the lines that did not run, and "N passed, N failed": the total must reach PERCENT,
and every source file must have been measured.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "libcurvopt" / "src"

Lines = dict[int, int]  # line -> how often it ran, at most


def measured(build: Path) -> dict[str, Lines]:
    """Lines of each file of SOURCES, by its path there, from every object of the library in `build`."""
    notes = sorted(str(path.resolve()) for path in build.glob("libcurvopt/**/*.gcno"))
    if not notes:
        sys.exit(f"coverage: {build} holds no *.gcno; build the preset coverage")
    done = subprocess.run(["gcov", "--json-format", "--stdout", *notes], check=True, capture_output=True, text=True, cwd=build)
    files: dict[str, Lines] = defaultdict(dict)
    for document in map(json.loads, filter(None, done.stdout.splitlines())):
        for file in document["files"]:
            path = (Path(document["current_working_directory"]) / file["file"]).resolve()
            if path.is_relative_to(SOURCES):
                for line in file["lines"]:
                    lines = files[str(path.relative_to(SOURCES))]
                    lines[line["line_number"]] = max(lines.get(line["line_number"], 0), line["count"])
    return files


def missed(lines: Lines) -> str:
    """Lines that did not run, such as "12-14, 20"; lines without code do not interrupt a range."""
    ranges: list[list[int]] = []
    before = True  # whether the line of code before has run
    for line in sorted(lines):
        if not lines[line]:
            if before:
                ranges.append([line, line])
            ranges[-1][1] = line
        before = lines[line] > 0
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in ranges)


def share(parts: list[Lines]) -> tuple[int, int, float]:
    """Lines of code, lines that ran, percent."""
    total = sum(map(len, parts))
    run = sum(count > 0 for lines in parts for count in lines.values())
    return total, run, 100 * run / max(total, 1)


def main() -> int:
    """As the module says."""
    parser = argparse.ArgumentParser(description="Line coverage of libcurvopt/src.")
    parser.add_argument("build", type=Path)
    parser.add_argument("--least", type=float, default=95, metavar="PERCENT")
    parser.add_argument("--lines", nargs="+", default=[], metavar="FILE", help="also of these, whatever their share")
    options = parser.parse_args()
    files = measured(options.build)
    folders: dict[str, list[Lines]] = defaultdict(list)
    for name, lines in files.items():
        folders[name.partition("/")[0]].append(lines)
    print(f"{'folder':<14} {'lines':>6} {'run':>6} {'%':>6}")
    for folder, parts in [*sorted(folders.items()), ("in all", list(files.values()))]:
        print("{:<14} {:6d} {:6d} {:6.1f}".format(folder, *share(parts)))
    print(f"\nfiles below {options.least:g} %, and the lines that did not run:")
    for name, lines in sorted(files.items(), key=lambda item: share([item[1]])[2]):
        percent = share([lines])[2]
        if percent < options.least or name in options.lines:
            print(f"{percent:6.1f} % {name}: {missed(lines)}")
    code = {str(path.relative_to(SOURCES)) for path in SOURCES.rglob("*.c")}
    unmeasured = sorted(code - files.keys())
    for name in unmeasured:
        print(f"coverage: {name} is in no object of {options.build}")
    total = share(list(files.values()))[2]
    if total < options.least:
        print(f"coverage: {total:.1f} % of libcurvopt/src ran, and {options.least:g} % must")
    failed = (total < options.least) + bool(unmeasured)
    print(f"{2 - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())

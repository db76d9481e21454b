# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's command as people run it, on one small item: output, resuming, figures, refusals."""

import csv
import json
import subprocess
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[3]
SMALL = ["--only", "torus_050", "--levels", "1", "--width", "60", "--samples", "1", "--jobs", "1"]


@pytest.fixture
def gallery(tmp_path):
    """Runs the gallery's command: (exit code, standard output, standard error)."""
    program = ROOT / "blend_files" / "gallery" / "make.py"

    def run(*arguments):
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P", str(program), "--",
                   "--output", str(tmp_path / "gallery"), *arguments]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr

    return run


def test_one_row_its_figures_and_resuming(gallery, tmp_path):
    code, said, complaints = gallery(*SMALL)
    assert code == 0, complaints
    assert "9 made, 0 finished before, 0 failed" in said and "Saved" not in said
    folder = tmp_path / "gallery"
    image = bpy.data.images.load(str(folder / "pictures" / "row.torus_050.png"))
    assert image.size[0] == 4 * 60
    pixels = list(image.pixels)
    assert min(pixels[0::4]) < 0.6 and max(pixels[0::4]) > 0.95
    with open(folder / "figures.csv", encoding="utf-8") as file:
        rows = {(row["energy"], row["setting"]): row for row in csv.DictReader(file)}
    assert len(rows) == 6
    # Clifford's torus on a net of 8 x 4; `tests/numeric` has the same of the library
    assert 19.74 < float(rows["willmore", "default"]["h2"]) < 21 and rows["willmore", "default"]["verdict"] == "minimum"
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert 'href="pictures/row.torus_050.png"' in page and 'src="pictures/row.torus_050.3.png"' in page and "http" not in page
    assert rows["willmore", "default"]["quadrature_error"] and not rows["willmore", "default"]["net_share"], "one level"
    cage_as_the_command_line_sees_it(folder)

    picture = folder / "pictures" / "row.torus_050.png"
    stamp = picture.stat().st_mtime_ns
    code, said, _ = gallery(*SMALL)
    assert code == 0 and "0 made, 9 finished before, 0 failed" in said and picture.stat().st_mtime_ns == stamp
    (folder / "data" / "solve.torus_050.mvs.default.json").unlink()
    code, said, _ = gallery(*SMALL)
    assert code == 0 and "] solve.torus_050.mvs.default" in said and "8 finished before" in said
    assert "1 made" in said, "the picture depends on the same inputs still"


def cage_as_the_command_line_sees_it(folder):
    found = json.loads((folder / "data" / "input.torus_050.json").read_text())["result"]
    program = ROOT / "build" / "release" / "curvopt"
    for energy in ("willmore", "mvs", "mvs_cross"):
        command = [program, "evaluate", ROOT / "blend_files" / "obj" / "torus_050.obj", "--energy", energy, "--quiet",
                   "--json", "-"]  # fmt: skip
        line = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        assert found[energy] == pytest.approx(line[energy], rel=2e-4)
    assert found["h2"] == pytest.approx(line["h2"], rel=2e-4)


@pytest.mark.parametrize("arguments, complaint", [
    (["--only", "torus_051"], "'torus_051'"), (["--only"], "--only"), (["--jobs", "0"], "'0' is no count"),
    (["--levels", "9"], "'9' is not 1 to 5"),
])  # fmt: skip
def test_wrong_usage_is_refused_by_name(gallery, tmp_path, arguments, complaint):
    code, _, complaints = gallery(*arguments)
    assert code == 2 and complaint in complaints
    assert not (tmp_path / "gallery").exists()


def test_missing_cages_are_named(gallery, tmp_path):
    code, _, complaints = gallery(*SMALL, "--cages", str(tmp_path))
    assert code == 1 and "torus_010.blend is missing" in complaints and "Traceback" not in complaints

# SPDX-License-Identifier: GPL-3.0-or-later
"""The campaign of presses, tests/corpus/press.py, without Blender: shapes with tags, crashes and hangs, tables."""

import json
import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import press  # noqa: E402
import tagged  # noqa: E402

RESULT = {
    "outcome": "minimum", "vertices": 8, "held": 1, "left_out": 2, "before": 4.0, "after": 3.0, "moved": 0.25,
    "seconds": 1.5, "reasons": [["an inner vertex has two edges", 1, [7]]],
}  # fmt: skip

# Stands for Blender: what it does with a shape is the shape's name.
FAKE = """
import json, os, signal, sys, time
jobs = json.load(open(sys.argv[1]))
with open(sys.argv[2], "a", buffering=1) as events:
    for shape, energy in jobs["runs"]:
        events.write(json.dumps({"begins": [shape, energy]}) + "\\n")
        if shape == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if shape == "left":
            sys.exit(3)
        if shape == "hanging":
            time.sleep(60)
        events.write(json.dumps({"ended": [shape, energy], "record": {"outcome": "minimum", "seconds": 1}}) + "\\n")
        if shape == "killed by its picture":
            os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def outcomes(tmp_path, monkeypatch):
    """Makes runs of shapes and returns the outcomes in the file, by shape."""
    (tmp_path / "fake.py").write_text(FAKE)
    monkeypatch.setattr(press, "GRACE", 0.5)

    def make(*shapes):
        output, command = tmp_path / "out.jsonl", [sys.executable, str(tmp_path / "fake.py")]
        press.campaign([(shape, "mvs") for shape in shapes], output, 0.5, None, command, {})
        return {record["shape"]: (record["outcome"], record.get("said")) for record in press.records(output)}

    return make


def test_crash_and_hang_end_one_run(outcomes):
    found = outcomes("one", "killed", "two", "left", "hanging", "killed by its picture", "three")
    assert found["killed"] == ("crashed", "Blender ended: SIGKILL")
    assert found["left"] == ("crashed", "Blender ended: exit code 3")
    assert found["hanging"] == ("hangs", "not ended after 1 s: killed")
    assert all(found[shape] == ("minimum", None) for shape in ("one", "two", "three", "killed by its picture"))


def test_campaign_goes_on(outcomes, tmp_path):
    outcomes("one")
    before = (tmp_path / "out.jsonl").read_text()
    outcomes("one", "two")
    assert (tmp_path / "out.jsonl").read_text().startswith(before) and len(press.records(tmp_path / "out.jsonl")) == 2


def test_blender_that_does_nothing_ends_the_campaign(tmp_path):
    with pytest.raises(SystemExit, match="before the first run"):
        press.campaign([("one", "mvs")], tmp_path / "out.jsonl", 1, None, [sys.executable, "-c", ""], {})


def test_tags():
    shape = tagged.parse(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2 3 -1\nt crease 2/1/0 1 0 2.5\nt crease 3/2/0 1 2 3 4 10\n"
        "t corner 2/1/0 0 3 7\nt interpolateboundary 1/0/0 1\nt hole 1/0/0 0\n\n# remark\n"
    )
    assert len(shape.points) == 4 and shape.faces == [[0, 1, 2, 3]]
    assert shape.edges == {(0, 1): 2.5, (1, 2): 4, (2, 3): 10} and shape.corners == {0: 7, 3: 7}
    assert shape.boundary_smooth == "PRESERVE_CORNERS" and shape.passed_over == {"hole"}
    with pytest.raises(ValueError, match="3 values for 2"):
        tagged.parse("t crease 3/3/0 0 1 2 1 2 3")


@pytest.mark.parametrize("sharpness,crease", [(0, 0), (2.5, 0.5), (10, 1), (12, 1), (-1, 0)])
def test_creases(sharpness, crease):
    assert math.isclose(tagged.crease_of(sharpness), crease)


def test_tables():
    found = [
        {"shape": "/of/some/torus.obj", "energy": "mvs", **RESULT},
        {"shape": "torus", "energy": "mvs", "outcome": "refused", "said": "No.", "vertices": 4, "seconds": 0.1},
        {"shape": "cube", "energy": "mvs", "outcome": "hangs", "said": "killed"},
    ]
    one, two, three = map(press.row_of, found)
    assert one[:8] == ["torus.obj", "mvs", "8", "minimum", "1", "2", "4", "3"]
    assert one[8:] == ["0.25", "1.5", "an inner vertex has two edges (1)"]
    assert two[:4] == ["torus", "mvs", "4", "refused: No."] and three[3] == "hangs: killed"
    counts = press.summary(found).splitlines()[-1].strip("| ").split(" | ")
    assert counts == ["mvs", "3", "1", "0", "0", "0", "0", "1", "0", "0", "1", "1", "1.50", "1.50", "1.50"]
    assert all(len(row) == len(one) for row in (two, three)) and json.dumps(found)


def test_shapes(tmp_path):
    (tmp_path / "torus.obj").touch()
    assert press.shapes_of(None, ()) == list(press.PRIMITIVES)
    chosen = press.shapes_of(tmp_path, ["torus"])
    assert [press.name_of(shape) for shape in chosen] == ["torus", "NURBS torus", "torus.obj"]
    assert len({press.key_of(shape, "mvs") for shape in chosen}) == 3
    assert len({press.picture_of(shape, "mvs") for shape in chosen}) == 3

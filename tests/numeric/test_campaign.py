# SPDX-License-Identifier: GPL-3.0-or-later
"""Campaigns over the corpus, with programs made up here: outcomes, going on after a stop, comparisons, changed constants."""
from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

from campaign import Program, Run, campaign, chosen  # noqa: E402
from sensitivity import Constant, choose, effect, variations  # noqa: E402
from tables import compare, quantile, summary  # noqa: E402

REPORT = {"verification": {"verdict": "minimum"}, "stop": "converged", "objective": 2.0, "quadrature_error": 1e-5,
          "start": {"objective": 3.0}, "levels": [{"iterations": 4, "evaluations": 5, "vertices": 8},
                                                  {"iterations": 6, "evaluations": 7, "vertices": 26}],
          "vertices": 26, "symmetry_order": 1}


@pytest.fixture
def program(tmp_path):
    """Makes a program from a shell script's lines; each of its runs leaves a line in `log`."""
    def make(script: str, **settings) -> Program:
        path = tmp_path / f"program_{abs(hash(script))}"
        (tmp_path / "report.json").write_text(json.dumps(REPORT))
        path.write_text(f'#!/bin/bash\necho "$*" >> {tmp_path}/log\nreport=$(sed "s/.*--json //; s/ .*//" <<< "$*")\n'
                        f"good={tmp_path}/report.json\n{script}\n")
        path.chmod(0o755)
        return Program(path, **settings)
    return make


@pytest.fixture
def run(tmp_path):
    """Runs of cages that nobody opens."""
    out = [Run(tmp_path / f"seed_{seed:03d}.obj", "willmore", 2) for seed in range(3)]
    for one in out:
        one.cage.write_text(f"v 0 0 {one.cage.stem[5:]}\n")
    return out


def records(program: Program, runs: list[Run], tmp_path: Path) -> list[dict]:
    return list(campaign(runs, program, tmp_path / "out.json", 2)["runs"].values())


def test_done(program, run, tmp_path):
    got = records(program('cp $good "$report"', changes=("a.b=2",)), run, tmp_path)
    assert len(got) == 3 and all(r["outcome"] == "done" and r["iterations"] == 10 and r["evaluations"] == 12 for r in got)
    assert all(r["cage_vertices"] == 8 and r["cpu"] < 1 and r["start"] == 3 for r in got)
    assert (tmp_path / "log").read_text().count("--set a.b=2") == 3


def test_out_of_time(program, run, tmp_path):
    (got,) = records(program("while :; do :; done", limit=1), run[:1], tmp_path)
    assert got["outcome"] == "out of time" and 0.9 <= got["cpu"] < 3


def test_refused_and_failed(program, run, tmp_path):
    (got,) = records(program('echo "no: $2" >&2; exit 1'), run[:1], tmp_path)
    assert got["outcome"] == "refused" and got["message"] == "no: seed_000.obj"
    for script, code in (("[[ $1 == evaluate ]]", 1), ("kill -SEGV $$", -11)):
        (tmp_path / "out.json").unlink()
        (got,) = records(program(script), run[:1], tmp_path)
        assert got["outcome"] == "failed" and got["code"] == code


def test_goes_on(program, run, tmp_path):
    """What is in the file is not done again, unless the cage is another; another program's file is not added to."""
    script = 'cp $good "$report"'
    records(program(script), run[:2], tmp_path)
    assert len(records(program(script), run, tmp_path)) == 3
    assert len((tmp_path / "log").read_text().splitlines()) == 3
    run[1].cage.write_text("v 1 1 1\n")
    assert len(records(program(script), run, tmp_path)) == 3
    assert len((tmp_path / "log").read_text().splitlines()) == 4
    for other in (program(script + " # another"), program(script, limit=3), program(script, changes=("a=1",))):
        with pytest.raises(SystemExit, match="was made with another"):
            records(other, run, tmp_path)


def record(**changes) -> dict:
    return {"outcome": "done", "verdict": "minimum", "objective": 10.0, "cpu": 1.0, "iterations": 10, "evaluations": 20,
            **changes}


def test_compare():
    one = {"seed_001|mvs|2": record(), "seed_003|mvs|2": record(), "seed_005|mvs|2": record(), "only|mvs|2": record()}
    other = {"seed_001|mvs|2": record(cpu=2.0), "seed_003|mvs|2": record(objective=10.05, cpu=4.0, verdict="saddle"),
             "seed_005|mvs|2": {"outcome": "out of time", "cpu": 20.0}}
    text = compare(("a", one), ("b", other))
    assert "3 runs are in both" in text
    assert "| mvs, 2 levels | B | 3 | 0 | 1 | 1 | 0 | 0 | 1 | 0 |" in text
    assert "| mvs, 2 levels | cpu | 2 | 2 | 2.5 | 3 | 3.5 | 4 | 3 | seed_003 mvs 2 (1 -> 4) |" in text
    assert "| mvs, 2 levels | A | 2 | 100.0 % | 100.0 % | 0 |" in text
    assert "| mvs, 2 levels | B | 2 | 50.0 % | 100.0 % | 0.005 |" in text
    assert "| seed_005 mvs 2 | minimum | out of time |" in text


def test_summary_and_halves():
    runs = {f"seed_{seed:03d}|mvs|2": record(cpu=float(seed)) for seed in range(8)}
    runs["torus|mvs|2"] = {"outcome": "refused", "cpu": 0.1}
    odd = chosen({"runs": runs}, "odd")
    assert sorted(odd) == ["seed_001|mvs|2", "seed_003|mvs|2", "seed_005|mvs|2", "seed_007|mvs|2", "torus|mvs|2"]
    text = summary(odd)
    assert "| mvs, 2 levels | 5 | 1 | 4 | 0 | 0 | 0 | 0 | 0 |" in text
    assert "| mvs, 2 levels | 1 of 4 | 3 of 4 | 4 of 4 | 2.50 | 4.00 | 5.50 | 7.00 | 10 | 10 |" in text
    assert quantile([3.0, 1.0, 2.0], 0.25) == 1.5


def test_changed_constants():
    constants = [Constant("whole", 5, 1, 8, True), Constant("one", 1, 0, 9, True), Constant("real", 0.3, 0.2, 9, False),
                 Constant("fixed", 5, 5, 5, True), Constant("negative", -30, -100, -1, False)]
    assert [(c.name, word, value) for c, word, value in variations(constants)] == [
        ("whole", "half", 3), ("whole", "double", 8), ("one", "double", 2), ("real", "half", 0.2), ("real", "double", 0.6),
        ("negative", "half", -15), ("negative", "double", -60)]
    assert constants[0].text(3) == "3" and constants[2].text(0.6) == "0.6"


def test_effect():
    before = {key: record() for key in "abcd"}
    same = effect(before, {key: record(cpu=1.01) for key in "abcd"})
    assert same.is_noise() and same.is_same and same.cpu == pytest.approx(1.01)
    slow = effect(before, {key: record(cpu=1.03) for key in "abcd"})
    assert not slow.is_noise() and slow.is_noise(0.04) and slow.keeps_results()
    got = effect(before, {"a": record(objective=10 + 2e-5), "b": record(objective=10 - 2e-5), "c": record(objective=10 + 1e-6),
                          "d": {"outcome": "out of time", "cpu": 10.0}})
    assert (got.verdicts, got.lost, got.gained, got.better, got.worse) == (1, 1, 0, 1, 1) and not got.keeps_results()
    got = effect(before, {key: record(iterations=13) for key in "abcd"})
    assert got.iterations == 1.3 and not got.keeps_results()


def test_choice():
    """The cheapest runs that fit, whatever the verdict; none that did not come to an end."""
    runs = {"a": record(cpu=3.0), "b": record(cpu=1.0, verdict="saddle"), "c": record(cpu=2.0),
            "d": {"outcome": "out of time", "cpu": 0.5}}
    assert choose(runs, 3.5) == (["b", "c"], 2.0)

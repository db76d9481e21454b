# SPDX-License-Identifier: GPL-3.0-or-later
"""Campaigns over the corpus, with programs made up here: outcomes, going on after a stop, comparisons, changed constants."""
from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import lib  # noqa: F401
from catalogue import grid
from ccref import mesh_from_faces
from nets import CUBE as CUBE_POINTS
from nets import read_obj, torus_cage, write_obj

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))

import tori  # noqa: E402
import touch  # noqa: E402
from acceptance import acceptance, lowered  # noqa: E402
from campaign import Program, Run, campaign, chosen  # noqa: E402
from families import mean_edge  # noqa: E402
from measures import edge_spread, least_jacobian, read_cage, subdivided  # noqa: E402
from sensitivity import Constant, choose, effect, variations  # noqa: E402
from tables import compare, quantile, summary  # noqa: E402

CUBE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 {0}\nv 1 0 {0}\nv 1 1 {0}\nv 0 1 {0}
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"""
REPORT = {"verification": {"verdict": "minimum"}, "stop": "converged", "objective": 2.0, "quadrature_error": 1e-5,
          "start": {"objective": 3.0, "min_jacobian": 0.5}, "min_jacobian": 0.25,
          "levels": [{"iterations": 4, "evaluations": 5, "vertices": 8}, {"iterations": 6, "evaluations": 7, "vertices": 26}],
          "vertices": 26, "symmetry_order": 1}


@pytest.fixture
def program(tmp_path):
    """Makes a program from a shell script's lines; each of its runs leaves a line in `log`."""
    def make(script: str, **settings) -> Program:
        path = tmp_path / f"program_{abs(hash(script))}"
        (tmp_path / "report.json").write_text(json.dumps(REPORT))
        path.write_text(f'#!/bin/bash\necho "$*" >> {tmp_path}/log\nreport=$(sed "s/.*--json //; s/ .*//" <<< "$*")\n'
                        f"good={tmp_path}/report.json\n[[ $1 != minimize ]] || cp $2 $4\n{script}\n")
        path.chmod(0o755)
        return Program(path, **settings)
    return make


@pytest.fixture
def run(tmp_path):
    """Runs of boxes."""
    out = [Run(tmp_path / f"seed_{seed:03d}.obj", "willmore", 2) for seed in range(3)]
    for one in out:
        one.cage.write_text(CUBE.format(1 + int(one.cage.stem[5:])))
    return out


def records(program: Program, runs: list[Run], tmp_path: Path) -> list[dict]:
    return list(campaign(runs, program, tmp_path / "out.json", 2)["runs"].values())


def test_done(program, run, tmp_path):
    got = records(program('cp $good "$report"', changes=("a.b=2",)), run, tmp_path)
    assert len(got) == 3 and all(r["outcome"] == "done" and r["iterations"] == 10 and r["evaluations"] == 12 for r in got)
    assert all(r["cage_vertices"] == 8 and r["cpu"] < 1 and r["start"] == 3 for r in got)
    assert all(r["sampled_jacobian"] == [0.5, 0.25] and "stopping" not in r for r in got)
    edges = sorted(r["edges"][::-1] for r in got)
    assert [after for after, _ in edges] == pytest.approx([1, 2, 3])  # the results are the boxes themselves
    assert edges[2][1] != pytest.approx(3)                            # the input counts as subdivided once
    assert (tmp_path / "log").read_text().count("--set a.b=2") == 3


def test_out_of_time(program, run, tmp_path):
    """The interrupt comes after the limit of CPU time; what the program then writes is a result, but no end."""
    (got,) = records(program("trap 'exit 3' INT\nwhile :; do :; done", limit=1), run[:1], tmp_path)
    assert got["outcome"] == "out of time" and 0.9 <= got["cpu"] < 3 and got["stopping"] < 1 and "edges" not in got
    (tmp_path / "out.json").unlink()
    (tmp_path / "report.json").unlink()
    script = f"trap 'sleep 0.5; cp {tmp_path}/late.json $report; exit 0' INT\nwhile :; do :; done"
    (tmp_path / "late.json").write_text(json.dumps({**REPORT, "stop": "cancelled"}))
    (got,) = records(program(script, limit=1), run[:1], tmp_path)
    assert got["outcome"] == "out of time" and 0.4 <= got["stopping"] < 2 and got["objective"] == 2 and got["edges"][1] == 1


def test_results_are_kept(program, run, tmp_path):
    campaign(run[:1], program('cp $good "$report"'), tmp_path / "out.json", 1, results=tmp_path)
    assert (tmp_path / "seed_000.willmore.2.obj").read_text() == run[0].cage.read_text()


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
    run[1].cage.write_text(CUBE.format(9))
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


def test_acceptance():
    """The figures of a campaign made by hand."""
    fine = {"jacobian": [0.8, 0.4], "sampled_jacobian": [0.5, 0.31], "edges": [3.0, 4.0]}
    runs = {"seed_1001|mvs|2": record(cpu=1.0, iterations=10, quadrature_error=1e-4, **fine),
            "seed_1003|mvs|2": record(cpu=2.0, iterations=30, quadrature_error=1e-1, **{**fine, "jacobian": [0.5, 0.24]}),
            "seed_1005|mvs|2": record(cpu=3.0, iterations=20, quadrature_error=1e-4, verdict="saddle", objective=9.9,
                                      **{**fine, "edges": [3.0, 4.1]}),
            "seed_1007|mvs|2": {"outcome": "out of time", "cpu": 60.0, "stopping": 0.25, "iterations": 5},
            "seed_1009|mvs|2": {"outcome": "refused", "cpu": 0.0}}
    text = acceptance(runs, {"seed_1001|mvs|2": 10.0, "seed_1003|mvs|2": 8.0, "seed_1005|mvs|2": 9.9 / 1.001})
    assert "| mvs, 2 levels | 4 | 50.0 % | 2.50 | 51.45 | 60.00 | 15 | 28 | 30 | 1 | 0.25 |" in text
    assert "| mvs, 2 levels | 3 | 33.3 % | 66.7 % | 0 | 0.001 | 0.25 |" in text
    assert "| mvs, 2 levels | jacobian | 3 | 66.7 % | 0.8 | 0.53 | 0.5 | 0.4 | 0.256 | 0.24 |" in text
    assert "| mvs, 2 levels | sampled jacobian | 3 | 100.0 % |" in text
    assert "| mvs, 2 levels | edges | 3 | 66.7 % | 3 | 3 | 3 | 4 | 4.09 | 4.1 |" in text
    runs["seed_1004|mvs|2"] = runs["seed_1001|mvs|2"]  # even: never
    best = lowered({"seed_1001|mvs|2": 9.0, "seed_1005|mvs|2": 9.95}, runs)
    assert best == {"seed_1001|mvs|2": 9.0, "seed_1005|mvs|2": 9.9}


def test_tori(tmp_path):
    """A value is held against the neighbours', of the same ratio and energy."""
    nets = tori.write_all(tmp_path)
    assert len(nets) == 10 * 5 * 4 and nets[0].stem == "torus_05x4_30" and read_obj(nets[0]).n_vertices == 20
    values = {"05x4_30": 31.0, "06x4_30": 20.0, "05x5_30": 10.0, "06x5_30": 1e3, "05x4_50": 1.0}
    runs = {f"torus_{net}|mvs|2": record(objective=value) for net, value in values.items()}
    assert [row[0] for row in tori.high(runs)] == ["torus_05x4_30 mvs 2", "torus_06x5_30 mvs 2"]
    assert tori.high(runs)[0][2:] == ["torus_05x5_30", "10"]
    runs["torus_14x8_30|mvs|2"] = record(verdict="saddle")
    assert "| torus_14x8_30 mvs 2 | saddle | 1.00 | 10 |" in tori.report(runs)


def test_touch(tmp_path):
    """A boundary stays; the others move by a thousandth of an edge, in ten ways; falls are of the result's energy."""
    sheet = write_obj(tmp_path / "sheet.obj", grid(3, 3))
    copies = [read_obj(path).xyz - grid(3, 3).xyz for path in touch.touched(sheet, tmp_path)]
    moved = np.linalg.norm(copies, axis=2)
    inside = np.zeros(16, bool)
    inside[[5, 6, 9, 10]] = True
    assert moved.shape == (10, 16) and (moved[:, ~inside] == 0).all()
    assert moved[:, inside] == pytest.approx(1e-3 * mean_edge(grid(3, 3)))
    assert abs(copies[0] - copies[1])[inside].min() > 0
    sharp = tmp_path / "sharp.obj"
    sharp.write_text(CUBE.format(1) + "t crease 2/1/0 0 1 10\nt crease 2/1/0 2 3 3\nt corner 1/1/0 7 10\n")
    for path in touch.touched(sharp, tmp_path):
        copy = read_cage(path)
        assert (copy.xyz == read_obj(sharp).xyz).all(axis=1).tolist() == [True, True] + 5 * [False] + [True]
        assert copy.creases.tolist() == [[0, 1], [2, 3]] and copy.vertex_sharpness[7] == 10
    again = [record(objective=9.98, quadrature_error=1e-5), record(objective=10.01, quadrature_error=1e-5),
             {"outcome": "out of time"}]
    runs = {"seed_001|mvs|2": record(quadrature_error=1e-4)}
    assert touch.falls(runs["seed_001|mvs|2"], again) == pytest.approx([2e-3, -1e-3])
    text = touch.report(runs, {"seed_001|mvs|2": again})
    assert "| mvs, 2 levels | 1 | 1 | 1 | 0 | 1 | 0.002 |" in text
    assert "| seed_001 mvs 2 | 10 | 2 | 2 | 0.0005 | 0.002 | 1e-05 | yes |" in text


def test_measures():
    """Of cages whose subdivisions are known: a regular torus' is alike everywhere, and shear makes corners narrow."""
    cube = mesh_from_faces(*CUBE_POINTS)
    assert edge_spread(cube) == 1 and edge_spread(cube.with_xyz(cube.xyz * [1, 3, 5])) == pytest.approx(5)
    for change in (cube.with_xyz(7 * cube.xyz + 3), cube.with_xyz(cube.xyz[:, ::-1])):  # no measure of size or place
        assert least_jacobian(change) == pytest.approx(least_jacobian(cube))
    folded = cube.xyz.copy()
    folded[0] = folded[7]
    assert least_jacobian(cube.with_xyz(folded)) < 0.5 * least_jacobian(cube)
    # A doubly periodic net of squares, rolled up on a large torus, is nearly flat and regular.
    assert least_jacobian(torus_cage(400, 40, 0.1)) == pytest.approx(1, abs=0.02)


def test_tags_are_read(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE.format(1) + "t crease 2/1/0 0 1 2.5\nt corner 1/1/0 4 10\n")
    mesh = read_cage(tmp_path / "cube.obj")
    assert mesh.creases.tolist() == [[0, 1]] and mesh.crease_sharpness.tolist() == [2.5] and mesh.vertex_sharpness[4] == 10
    assert subdivided(mesh, 1).xyz[4].tolist() == [0, 0, 1]


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

# SPDX-License-Identifier: GPL-3.0-or-later
"""The five examples run, and what they print is right: closed forms, and properties that hold exactly."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "libcurvopt" / "python" / "examples"


def run(monkeypatch, name, *arguments):
    """The names that an example defines."""
    monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def test_every_example_has_a_test():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {"energies", "minimize", "constraints", "sampler", "study"}


def test_energies(monkeypatch):
    seen = run(monkeypatch, "energies")
    assert seen["found"].h2 == pytest.approx(2 * np.pi**2, rel=1e-3)
    assert abs(seen["found"].gauss) < 1e-9
    assert seen["found"].terms["willmore"] == pytest.approx(4 * seen["found"].h2, rel=1e-9)
    assert seen["found"].area == pytest.approx(4 * np.pi**2 * np.sqrt(0.5), rel=0.02)
    assert seen["slope"] == pytest.approx(seen["quotient"], rel=1e-4)


def test_minimize(monkeypatch):
    seen = run(monkeypatch, "minimize")
    fair = seen["fair"]
    assert fair.energies.objective == pytest.approx(8 * np.pi, rel=1e-4)
    assert fair.summary.verification.verdict == "minimum"
    assert [step.level for step in seen["steps"]] == sorted(step.level for step in seen["steps"])
    assert seen["short"].summary.stop == seen["stopped"].summary.stop == "cancelled"
    assert seen["short"].energies.objective < fair.summary.start.objective


def test_constraints(monkeypatch):
    seen = run(monkeypatch, "constraints")
    flat, sheet, rim = seen["flat"], seen["sheet"], seen["rim"]
    assert np.array_equal(flat.cage.positions[rim], sheet.positions[rim])
    assert np.abs(flat.cage.positions[:, 2]).max() < 1e-9 and flat.energies.objective < 1e-12
    assert seen["tent"].cage.positions[seen["middle"][0], 2] == 0.5
    assert 0 < seen["soft"].cage.positions[seen["middle"][0], 2] < 0.4
    height = seen["through"].cage.positions[:, 2].reshape(13, 13)[5:8, 5:8]  # masks: 16, 4 and 1 of 36
    assert (np.outer([1, 4, 1], [1, 4, 1]) * height).sum() / 36 == pytest.approx(seen["before"], abs=1e-12)
    height = seen["above"].cage.positions[:, 2].reshape(13, 13)[5:8, 5:8]
    assert (np.outer([1, 4, 1], [1, 4, 1]) * height).sum() / 36 == pytest.approx(0.3, abs=1e-12)
    heights = list(seen["heights"].values())
    assert heights == sorted(heights, reverse=True) and heights[-1] < 0.6 * heights[0]


def test_sampler(monkeypatch, tmp_path):
    seen = run(monkeypatch, "sampler", tmp_path / "points.csv")
    assert seen["total_gauss"] == pytest.approx(4 * np.pi, rel=1e-3)
    assert seen["area"] == pytest.approx(4 * np.pi * seen["radius"].mean() ** 2, rel=1e-3)
    assert np.allclose(seen["mean"] * seen["radius"], -1, atol=0.1)
    table = np.loadtxt(tmp_path / "points.csv", delimiter=",", skiprows=1)
    assert np.allclose(table[:, :3], seen["point"]) and table.shape[1] == 8


def test_study(monkeypatch, tmp_path):
    seen = run(monkeypatch, "study", tmp_path / "study.png")
    assert np.allclose(seen["seen"], [seen["exact"](ratio) for ratio in seen["ratios"]], rtol=0.025)
    assert seen["ratios"][seen["seen"].argmin()] == pytest.approx(np.sqrt(0.5), abs=0.03)
    assert all(1.8 < order < 2.2 for order in seen["orders"])

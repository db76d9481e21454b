# SPDX-License-Identifier: GPL-3.0-or-later
"""Spontaneous Curvature: a sphere that has just that curvature has no bending energy; elsewhere it is refused."""

import numpy as np
import pytest
import shapes
from runs import minimize, positions


@pytest.fixture
def ball(add):
    """A cage of 98 vertices that is no sphere."""
    points, faces = shapes.quad_sphere()
    return add(points * [1.0, 0.9, 1.1], faces, name="Ball")


@pytest.mark.parametrize("energy", ["WILLMORE", "MEAN_CURVATURE"])
def test_a_sphere_of_that_curvature(ball, energy):
    """The result keeps the area 4 pi R^2; with 2 / R it is the sphere without energy, with 1 / R it has a quarter of 16 pi."""
    area = minimize(ball, energy=energy)["curvopt_before_area"]
    for part, expected in ((2.0, 0.0), (1.0, 4 * np.pi)):
        result = minimize(ball, energy=energy, spontaneous_curvature=part / np.sqrt(area / (4 * np.pi)))
        assert result["curvopt_after_area"] == pytest.approx(area, rel=1e-6)
        assert result["curvopt_after_helfrich"] == pytest.approx(expected, abs=2e-3 * 16 * np.pi)
        assert result["curvopt_before_helfrich"] > result["curvopt_after_helfrich"]
        distance = np.linalg.norm(positions(result) - positions(result).mean(axis=0), axis=1)
        assert distance.std() < 0.02 * distance.mean()


def test_without_it_there_is_no_such_row(ball):
    assert "curvopt_after_helfrich" not in minimize(ball)


def test_mvs_has_none(ball):
    with pytest.raises(RuntimeError, match="Spontaneous Curvature is 1, but neither Willmore nor Mean curvature is minimized"):
        minimize(ball, energy="MVS", spontaneous_curvature=1.0)


def test_the_reports_number_is_named(ball, part):
    state = part("ui.properties").state
    result = minimize(ball, spontaneous_curvature=1.0, strength=0.3)
    before, after = (part("core.energy").number_text(result[f"curvopt_{when}_helfrich"]) for when in ("before", "after"))
    assert state.message.startswith(f"Helfrich {before} to {after}, ")
    minimize(ball, energy="MIX", weight_mvs=1.0, weight_willmore=0.1, spontaneous_curvature=1.0, strength=0.3)
    assert state.message.startswith("0.1 Willmore + MVS with Spontaneous Curvature 1: ")
    minimize(ball, strength=0.3)
    assert "Helfrich" not in state.message

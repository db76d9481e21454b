# SPDX-License-Identifier: GPL-3.0-or-later
"""No Crossings: a knot's tube stops where it touches itself, and the message says so."""

import numpy as np
import pytest
from runs import minimize

THICKNESS = 0.6


@pytest.fixture
def knot(add):
    """The active object: a tube of eight sides round a trefoil, as in tests/numeric/test_measure.py."""
    n, m = 48, 8
    t = 2 * np.pi * np.arange(n) / n
    curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    along = np.stack([np.cos(t) + 4 * np.cos(2 * t), -np.sin(t) + 4 * np.sin(2 * t), -3 * np.cos(3 * t)], axis=1)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, [0, 0, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, along)
    a = 2 * np.pi * np.arange(m) / m
    ring = np.cos(a)[None, :, None] * side[:, None] + np.sin(a)[None, :, None] * up[:, None]
    faces = [
        [i * m + j, i * m + (j + 1) % m, (i + 1) % n * m + (j + 1) % m, (i + 1) % n * m + j]
        for i in range(n)
        for j in range(m)
    ]
    return add((curve[:, None] + THICKNESS * ring).reshape(-1, 3), faces, name="Knot")


def test_a_knot_is_held_by_contact(newcomer, knot, part):
    assert "no_crossings" in part("ui.properties").SETTINGS and newcomer.no_crossings is False
    minimize(knot, strength=1.0, resolution="SAME")
    assert "crosses itself" in part("ui.properties").state.message
    minimize(knot, strength=1.0, resolution="SAME", no_crossings=True)
    message = part("ui.properties").state.message
    assert "held by contact with itself" in message and "crosses itself" not in message

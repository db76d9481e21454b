# SPDX-License-Identifier: GPL-3.0-or-later
"""Where objects are: scene/frame.py."""

import numpy as np


def test_the_inverse_is_that_of_numpy(part):
    random = np.random.default_rng(2)
    for scale in (1.0, 1e-6, np.array([1e-3, 1.0, 1e4])):
        linear = random.normal(size=(3, 3)) * scale
        wanted = np.linalg.inv(linear)
        found = part("scene.frame").inverse(linear)
        assert (np.abs(found - wanted).max(axis=1) <= 1e-12 * np.abs(wanted).max(axis=1)).all()
    assert np.array_equal(part("scene.frame").inverse(np.diag([2.0, 4.0, -8.0])), np.diag([0.5, 0.25, -0.125]))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Creases to sharpness and back, without Blender."""

import numpy as np
import pytest
import shapes
from addon.binding import abi, values
from addon.core import crease

GRID_EDGES = np.array([[y * 3 + x, y * 3 + x + 1] for y in range(3) for x in range(2)]
                      + [[y * 3 + x, y * 3 + x + 3] for y in range(2) for x in range(3)], np.int32)  # fmt: skip
CORNER = [0, 6]  # of GRID_EDGES, the two at vertex 0


def grid_cage(creases):
    points, faces = shapes.grid(2)
    return values.Cage(points, *map(np.array, shapes.packed(faces)), creases)


def there_and_back(edge_crease, vertex_crease, rule="smooth"):
    creases = crease.from_blender(GRID_EDGES, edge_crease, vertex_crease, rule)
    return creases, *crease.to_blender(grid_cage(creases), GRID_EDGES)


def test_sharpness_is_blenders_in_single_precision():
    assert crease.sharpness_of([0, 0.5, 1]).tolist() == [0, 2.5, 10]
    c = np.float32(0.7)
    assert crease.sharpness_of([0.7])[0] == float(c * c * np.float32(10)) != 4.9


def test_creases_beyond_their_range_are_what_blender_makes_of_them():
    """Attributes can hold anything: squared, and from 10 on infinite."""
    assert crease.sharpness_of([-0.5, 2.0, -3.0, 1e30]).tolist() == [2.5, 10, 10, 10]


def test_sharpness_below_a_millionth_is_none_on_edges():
    creases, edge, vertex = there_and_back(np.full(12, 3e-4), np.full(9, 0.0))
    assert len(creases.edges) == len(creases.vertices) == 0 and not edge.any() and not vertex.any()


@pytest.mark.parametrize("seed", range(20))
def test_there_and_back_again(seed):
    """To single precision; a corner that its edges make infinitely sharp needs nothing of its own, so may get all."""
    random = np.random.default_rng(seed)
    edge_crease, vertex_crease = random.uniform(size=(2, 12)) * (random.uniform(size=(2, 12)) < 0.7)
    creases, edge, vertex = there_and_back(edge_crease, vertex_crease[:9])
    again = crease.from_blender(GRID_EDGES, edge, vertex, "smooth")
    assert edge == pytest.approx(edge_crease, abs=1e-6)
    assert again.edges.tolist() == creases.edges.tolist() and again.vertices.tolist() == creases.vertices.tolist()
    assert again.edge_sharpness == pytest.approx(creases.edge_sharpness, abs=1e-5)
    assert again.vertex_sharpness == pytest.approx(creases.vertex_sharpness, abs=1e-5)


def test_infinitely_sharp_stays_infinitely_sharp():
    """Also where rounding of what the edges leave to the vertex would make it a little less."""
    for value in np.linspace(0.95, 1, 200):
        edge_crease, vertex_crease = np.zeros(12), np.zeros(9)
        edge_crease[CORNER], vertex_crease[0] = value, np.sqrt(1 - value * value) + 1e-3
        _, edge, vertex = there_and_back(edge_crease, np.minimum(vertex_crease, 1))
        sharpness = crease.from_blender(GRID_EDGES, edge, vertex, "smooth").vertex_sharpness
        assert sharpness.tolist() == [abi.SHARPNESS_INFINITE]


def test_names_of_the_modifier_stand_for_every_rule():
    assert tuple(crease.BOUNDARY_SMOOTH) == abi.BOUNDARY_RULES

# SPDX-License-Identifier: GPL-3.0-or-later
"""Within: no vertex of the result gets farther than that from where it was, in Object and Edit Mode and in the batch command."""

import bmesh
import bpy
import numpy as np
import pytest
import shapes
from runs import minimize, positions

LIMIT = 0.02


@pytest.fixture
def ring(add):
    """The active object: a bumpy torus of 160 vertices, twice as large as its mesh."""
    points, faces = shapes.torus(16, 10)
    obj = add(points + 0.03 * np.random.default_rng(3).normal(size=points.shape), faces, name="Ring")
    obj.scale = 2.0, 2.0, 2.0
    return obj


def turned_and_scaled(obj):
    """Vertices of an object's mesh (n, 3) in the world, but for where it stands: a result stands beside its original."""
    bpy.context.view_layer.update()
    return positions(obj) @ np.array(obj.matrix_world)[:3, :3].T


def moved(result, original):
    """The farthest that a vertex got, in the world."""
    return np.linalg.norm(turned_and_scaled(result) - turned_and_scaled(original), axis=1).max()


def test_nothing_moves_farther_in_the_world(newcomer, ring, part):
    free = minimize(ring, strength=1.0, resolution="SAME", max_iterations=20)
    near = minimize(ring, strength=1.0, resolution="SAME", within=LIMIT)
    assert moved(free, ring) > 3 * LIMIT
    assert 0.6 * LIMIT < moved(near, ring) < LIMIT
    assert f"stayed within {LIMIT:.3g} of the original" in part("ui.properties").state.message
    assert near["curvopt_within"] == pytest.approx(LIMIT, rel=1e-6)
    assert "within" in part("ui.properties").SETTINGS and newcomer.within == 0.0


def test_the_setting_of_the_scene_counts(newcomer, ring):
    newcomer.within = LIMIT
    assert moved(minimize(ring, strength=1.0, resolution="SAME"), ring) < LIMIT


def test_in_edit_mode_a_part_stays_within(newcomer, ring):
    was = turned_and_scaled(ring)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(ring.data)
    for vertex in edit.verts:
        vertex.select_set(vertex.index in range(30, 110))
    edit.select_flush_mode()
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy="WILLMORE", strength=1.0, within=LIMIT) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    step = np.linalg.norm(turned_and_scaled(ring) - was, axis=1)
    assert 0.5 * LIMIT < step.max() < LIMIT and step[:30].max() == 0

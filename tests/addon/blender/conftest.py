# SPDX-License-Identifier: GPL-3.0-or-later
"""Every test starts in an empty file with the add-on on."""

import importlib
import os
import sys
from pathlib import Path

import bmesh
import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import shapes  # noqa: E402

NAME = os.environ["CURVOPT_TEST_NAME"]  # of the add-on, which as an extension has a longer one


def pytest_collection_modifyitems(items):
    """Every n-th test, from the k-th on: run_in_blender.py."""
    k, n = map(int, os.environ["CURVOPT_TEST_DEAL"].split("/"))
    items[:] = items[k - 1::n]


@pytest.fixture(autouse=True)
def empty_file(request):
    """The tests are of minimizers unless they ask for a newcomer's settings."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert hasattr(bpy.types.Scene, "curvopt") and len(bpy.data.objects) == 0
    if "newcomer" not in request.fixturenames:
        bpy.context.scene.curvopt.strength, bpy.context.scene.curvopt.resolution = 1.0, "REFINE"


@pytest.fixture
def newcomer():
    """The settings as a new file has them."""
    return bpy.context.scene.curvopt


@pytest.fixture
def part():
    """A file of the installed add-on, by name."""
    return lambda name: importlib.import_module(f"{NAME}.{name}")


@pytest.fixture
def add():
    """Adds a mesh object of points and faces to the scene and makes it the active and only selected one."""

    def add_object(points, faces, name="Cage", scene=None):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([tuple(map(float, p)) for p in points], [], [list(f) for f in faces])
        obj = bpy.data.objects.new(name, mesh)
        (scene or bpy.context.scene).collection.objects.link(obj)
        for other in bpy.context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        return obj

    return add_object


@pytest.fixture
def crease():
    """Sets creases of an object: edges by their two vertices, vertices by their number."""

    def set_creases(obj, edges=None, vertices=None):
        mesh = obj.data
        index = {tuple(sorted(edge.vertices)): edge.index for edge in mesh.edges}
        of_edges, of_vertices = np.zeros(len(mesh.edges), np.float32), np.zeros(len(mesh.vertices), np.float32)
        for pair, value in (edges or {}).items():
            of_edges[index[tuple(sorted(pair))]] = value
        for vertex, value in (vertices or {}).items():
            of_vertices[vertex] = value
        if bpy.app.version >= (4, 0, 0):
            mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", of_edges)
            mesh.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", of_vertices)
        else:
            edit = bmesh.new()
            edit.from_mesh(mesh)
            edit.verts.layers.crease.verify()
            edit.to_mesh(mesh)
            mesh.vertex_creases[0].data.foreach_set("value", of_vertices)
            mesh.edges.foreach_set("crease", of_edges)

    return set_creases


@pytest.fixture
def torus(add):
    """The active object: an 8 x 4 torus cage."""
    return add(*shapes.torus(), name="Torus")


@pytest.fixture
def contents():
    """All that a run could change, as comparable values."""

    def snapshot():
        bpy.context.view_layer.update()
        return {
            "objects": {
                obj.name: (
                    [repr(tuple(v.co)) for v in obj.data.vertices] if obj.type == "MESH" else None,
                    [tuple(p.vertices) for p in obj.data.polygons] if obj.type == "MESH" else None,
                    [tuple(row) for row in obj.matrix_world],
                    [modifier.name for modifier in obj.modifiers],
                    obj.hide_get(), obj.hide_render, obj.mode, dict(obj.items()),
                )
                for obj in bpy.context.scene.objects
            },
            "data": {kind: sorted(d.name for d in getattr(bpy.data, kind)) for kind in DATA},
            "active": bpy.context.view_layer.objects.active and bpy.context.view_layer.objects.active.name,
            "selected": sorted(obj.name for obj in bpy.context.view_layer.objects.selected),
        }  # fmt: skip

    return snapshot


DATA = ("scenes", "objects", "meshes", "materials", "worlds", "cameras", "lights", "curves", "collections")


@pytest.fixture
def targets():
    """An empty collection of the scene."""
    found = bpy.data.collections.new("Targets")
    bpy.context.scene.collection.children.link(found)
    return found

# SPDX-License-Identifier: GPL-3.0-or-later
"""Marked edges of a mesh: what single edges hold where they are a boundary, or the rim of a selection."""

from __future__ import annotations

import bpy
import numpy as np

from .modifiers import CageError
from .read_cage import Source

MARK = "curvopt_rim"  # attribute of edges, INT; its values are indices of core.rims.MARKS


def read_marks(mesh: bpy.types.Mesh, source: Source) -> tuple[np.ndarray, np.ndarray]:
    """Marked edges (k, 2) of the cage, each once, images included, and their marks (k,). `mesh` is that of the source,
    or a copy of it. CageError for an attribute of that name that is something else."""
    marks, layout = _values(mesh), source.layout
    marked = np.flatnonzero(marks)
    tight = marked[~source.mesh.loose[marked]]
    number = np.zeros(len(source.mesh.positions), np.int32)
    number[layout.kept] = np.arange(len(layout.kept))
    return layout.halves.edges(number[source.mesh.edges[tight]], marks[tight])


def _values(mesh: bpy.types.Mesh) -> np.ndarray:
    """The marks (e,) of edges; 0: none."""
    values, attribute = np.zeros(len(mesh.edges), np.int32), mesh.attributes.get(MARK)
    if attribute is None:
        return values
    if (attribute.domain, attribute.data_type) != ("EDGE", "INT"):
        raise CageError(f"Attribute '{MARK}' is no integer of edges: delete it, and mark edges with Mark Rim again.")
    attribute.data.foreach_get("value", values)
    return values

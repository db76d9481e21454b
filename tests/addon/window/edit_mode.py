# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a background Blender: the manual's picture of a run in Edit Mode, by the add-on's studio, as clay and
with zebra stripes.

    blender -b --factory-startup --python-exit-code 1 -P edit_mode.py -- CLAY.png ZEBRA.png
"""

import sys
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[2])]
import shapes  # noqa: E402
from addon.binding.values import Cage, Held  # noqa: E402
from addon.core import job, rims  # noqa: E402
from addon.render.before_after import Picture, render_side_by_side  # noqa: E402

STRENGTH = 0.5


def suzanne():
    """The cage of Blender's monkey, which looks along -y."""
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    sizes, vertices = shapes.packed([list(face.vertices) for face in mesh.polygons])
    return Cage(np.array([vertex.co for vertex in mesh.vertices], float), np.array(sizes), np.array(vertices))


def faired(cage, selected, rim):
    """The cage after a run in Edit Mode with these vertices (n,) selected."""
    part = rims.Part(selected, np.empty((0, 2), int), np.empty(0, int))
    moving = rims.moving_vertices(cage, part, rim, "position")
    holes = np.flatnonzero(~rims.changing_faces(cage, moving))
    held = Held.exactly(np.flatnonzero(~moving))
    request = job.Request("willmore", 1, boundary="free", held=held, holes=holes, strength=STRENGTH)
    solution = job.solve(cage, request)
    before, after = solution.start.objective, solution.end.objective
    print(f"Rim {rim}: {moving.sum()} of {selected.sum()} vertices, {len(cage.face_sizes) - len(holes)} faces, "
          f"Willmore {before:.4g} to {after:.4g}, {solution.seconds:.1f} s")  # fmt: skip
    return solution.cage


def head(cage):
    """Its vertices (n,) without the eyeballs: what hangs together with the topmost one."""
    found = np.arange(len(cage.positions)) == cage.positions[:, 2].argmax()
    starts = np.cumsum(cage.face_sizes) - cage.face_sizes
    for _ in range(len(found)):
        faces = np.logical_or.reduceat(found[cage.face_vertices], starts)
        found[cage.face_vertices[np.repeat(faces, cage.face_sizes)]] = True
    return found


original = suzanne()
forehead = head(original) & (original.positions[:, 2] > 0.35) & (original.positions[:, 1] < -0.2)
pictures = [(original, "Original"), (faired(original, forehead, "free"), "Forehead selected")]
for look, name in zip(("clay", "zebra"), sys.argv[sys.argv.index("--") + 1 :]):
    render_side_by_side(pictures, Path(name).resolve(), Picture(800, 420, 96, "workbench", look))

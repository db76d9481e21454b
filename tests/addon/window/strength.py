# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a background Blender: the manual's pictures of what the first press does, by the add-on's studio;
Suzanne also with zebra stripes.

    blender -b --factory-startup --python-exit-code 1 -P strength.py -- BOTTLE.png SUZANNE.png ZEBRA.png
"""

import sys
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[2])]
import shapes  # noqa: E402
from addon.binding.values import Cage  # noqa: E402
from addon.core import job  # noqa: E402
from addon.render.before_after import Picture, render_side_by_side  # noqa: E402

NEWCOMER, MORE, MINIMUM = 0.3, 0.5, 1.0


def bottle():
    """Points (n, 3) and faces of the bottle with bumps."""
    return shapes.bottle()


def suzanne():
    """The same of Blender's monkey, which looks along -y."""
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    return np.array([vertex.co for vertex in mesh.vertices]), [list(face.vertices) for face in mesh.polygons]


def draw(cage_of, strengths, **looks):
    """The original and what each strength makes of it, side by side; for each picture its path."""
    points, faces = cage_of()
    sizes, vertices = shapes.packed(faces)
    cage = Cage(points, np.array(sizes), np.array(vertices))
    pictures = [(cage, "Original")]
    for strength in strengths:
        solution = job.solve(cage, job.Request("willmore", 1, strength=strength))
        pictures.append((solution.cage, f"Strength {strength:g}"))
        before, after = solution.start.objective, solution.end.objective
        print(f"{cage_of.__name__}, strength {strength:g}: Willmore {before:.4g} to {after:.4g}, {solution.seconds:.1f} s")
    for look, path in looks.items():
        engine = {"engine": "workbench", "look": look} if look == "zebra" else {}
        render_side_by_side(pictures, path, Picture(1200, 520, 96, **engine))


to = [Path(name).resolve() for name in sys.argv[sys.argv.index("--") + 1 :]]
draw(bottle, (NEWCOMER, MORE, MINIMUM), clay=to[0])
draw(suzanne, (NEWCOMER, MORE), clay=to[1], zebra=to[2])

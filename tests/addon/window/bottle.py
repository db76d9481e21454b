# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a background Blender: the manual's picture of what the first press does, by the add-on's studio.

    blender -b --factory-startup --python-exit-code 1 -P bottle.py -- OUT.png
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[2])]
import shapes  # noqa: E402
from addon.binding.values import Cage  # noqa: E402
from addon.core import job  # noqa: E402
from addon.render.before_after import Picture, render_side_by_side  # noqa: E402

STRENGTHS = 0.3, 0.5, 1.0  # a newcomer's, more, and the minimum


def main(path):
    points, faces = shapes.bottle()
    sizes, vertices = shapes.packed(faces)
    cage = Cage(points, np.array(sizes), np.array(vertices))
    pictures = [(cage, "Original")]
    for strength in STRENGTHS:
        solution = job.solve(cage, job.Request("willmore", 1, strength=strength))
        pictures.append((solution.cage, f"Strength {strength:g}"))
        print(f"strength {strength:g}: Willmore {solution.start.objective:.4g} to {solution.end.objective:.4g}")
    render_side_by_side(pictures, path, Picture(1200, 520, 96))


main(Path(sys.argv[sys.argv.index("--") + 1]).resolve())

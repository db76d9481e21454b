# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a background Blender: the manual's picture of a run as an animation, some of its states by the add-on's studio.

    blender -b --factory-startup --python-exit-code 1 -P animation.py -- STATES.png
"""

import sys
from dataclasses import replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[2])]
from addon.core import catalogue, job  # noqa: E402
from addon.render.before_after import Picture, render_side_by_side  # noqa: E402
from addon.scene.animation import FRAMES  # noqa: E402

cage = catalogue.load("lawson_g2")
solution = job.solve(cage, job.Request("mvs", 3, records=True))
last = len(solution.path) - 1
chosen = [round(part * last) for part in (0, 0.2, 0.5, 1)]
pictures = [(replace(solution.cage, positions=solution.path[k]), f"Frame {2 + FRAMES * k}") for k in chosen]
print(f"{last + 1} states, MVS {solution.start.objective:.4g} to {solution.end.objective:.4g}, {solution.seconds:.1f} s")
render_side_by_side(pictures, Path(sys.argv[sys.argv.index("--") + 1]).resolve(), Picture(1200, 420, 96, "workbench", "clay"))

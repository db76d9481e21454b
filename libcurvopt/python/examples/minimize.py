# SPDX-License-Identifier: GPL-3.0-or-later
"""A minimization with progress and cancel: a cube becomes a sphere."""

# %% The cage.
import threading

import numpy as np

import curvopt

corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
cube = curvopt.cage(corners, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])

# %% Progress is called on this thread after every step.
steps = []
fair = curvopt.minimize(cube, "willmore", levels=4, on_progress=steps.append)
print(f"{len(steps)} steps, {fair.summary.seconds:.2f} s, {fair.summary.symmetry_order} symmetries")
print(f"Willmore {fair.summary.start.objective:.4f} -> {fair.energies.objective:.5f}; a sphere has {8 * np.pi:.5f}")
print(f"a {fair.summary.verification.verdict}, {len(fair.cage.positions)} vertices")

# %% A callback that returns a true value ends the run, with the best cage so far.
short = curvopt.minimize(cube, "willmore", levels=4, on_progress=lambda progress: progress.iteration >= 2)
print(f"ended by the callback: {short.summary.stop}, Willmore {short.energies.objective:.4f}")

# %% Any other thread may end it, too.
with curvopt.Cancel() as cancel:
    timer = threading.Timer(0.05, cancel.request)
    timer.start()
    stopped = curvopt.minimize(cube, "mvs", levels=6, symmetry="none", cancel=cancel)
    timer.join()
print(f"ended by a timer: {stopped.summary.stop} after {stopped.summary.seconds:.2f} s")

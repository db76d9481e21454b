# SPDX-License-Identifier: GPL-3.0-or-later
"""A study: int H^2 dA of tori over their ratio and over refinement, with a plot if matplotlib is there:
python3 study.py [OUT.png]"""

# %% A torus of radii 1 and `ratio`, 2 n x n points. Its int H^2 dA is pi^2 / (ratio sqrt(1 - ratio^2)).
import sys

import numpy as np

import curvopt


def torus(ratio: float, n: int) -> curvopt.Cage:
    u, v = np.meshgrid(np.arange(2 * n) * np.pi / n, np.arange(n) * 2 * np.pi / n, indexing="ij")
    points = np.stack([(1 + ratio * np.cos(v)) * np.cos(u), (1 + ratio * np.cos(v)) * np.sin(u), ratio * np.sin(v)], -1)
    i = np.arange(2 * n * n).reshape(2 * n, n)
    faces = np.stack([i, np.roll(i, -1, 0), np.roll(i, (-1, -1), (0, 1)), np.roll(i, -1, 1)], -1)
    return curvopt.cage(points, faces.reshape(-1, 4))


def exact(ratio: float) -> float:
    return np.pi**2 / (ratio * np.sqrt(1 - ratio**2))


# %% Over the ratio: least near 1 / sqrt(2).
ratios = np.linspace(0.4, 0.9, 11)
seen = np.array([curvopt.energies(torus(ratio, 32)).h2 for ratio in ratios])
for ratio, value in zip(ratios, seen):
    print(f"ratio {ratio:.2f}   int H^2 dA {value:8.4f}   exact {exact(ratio):8.4f}")

# %% Over refinement: the cage's points lie on the torus, so the surface is off by the square of the spacing.
sizes = [16, 32, 64]
errors = [abs(curvopt.energies(torus(0.5, n), tolerance=1e-8).h2 - exact(0.5)) for n in sizes]
orders = [float(np.log2(coarse / fine)) for coarse, fine in zip(errors, errors[1:])]
print("errors", [f"{error:.1e}" for error in errors], "orders", [round(order, 2) for order in orders])

# %% The plot.
if len(sys.argv) > 1:
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        print("no plot: matplotlib is not installed")
    else:
        plt.plot(ratios, seen, "o", ratios, exact(ratios), "-")
        plt.xlabel("ratio of the radii")
        plt.ylabel("∫H² dA")
        plt.savefig(sys.argv[1])

# SPDX-License-Identifier: GPL-3.0-or-later
"""The phase diagram of vesicles without spontaneous curvature (Seifert, Berndl, Lipowsky 1991): bending energy by reduced volume of
prolate shapes, oblate shapes and stomatocytes. Curves are by the axisymmetric solver of the tests, dots by libcurvopt.

    python3 blend_files/phase_diagram.py [OUT.svg]        needs the preset release, numpy, SciPy; half a minute
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "blend_files"), str(ROOT / "libcurvopt" / "python"), str(ROOT / "tests" / "oracle")]
import curvopt  # noqa: E402
import vesicle_branches  # noqa: E402
import vesicles as solver  # noqa: E402
from gallery.plot import Axis, Series, plot  # noqa: E402
from nets import on_profile, read_obj  # noqa: E402

LEVELS = 4
DOTS = {
    "prolate": (0.98, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.45),
    "oblate": (0.98, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.57, 0.54, 0.51),
    "stomatocyte": (0.65, 0.64, 0.63, 0.62, 0.6, 0.57, 0.54, 0.51, 0.48, 0.45, 0.42, 0.4),
}
INKS = {"prolate": "#1f5fa8", "oblate": "#b5482a", "stomatocyte": "#2f7d46"}
Curves = Mapping[str, Sequence[solver.Shape]]


def curves(elements: int = 48) -> dict[str, list[solver.Shape]]:
    """The solver's shapes along each branch, by falling reduced volume, down to 0.4; oblate ones until their poles touch."""
    out = {
        name: vesicle_branches.simple_branch(sign, np.linspace(0.99, end, count), elements)
        for name, sign, end, count in (("prolate", 1.0, 0.4, 60), ("oblate", -1.0, 0.51, 49))
    }
    top, low = vesicle_branches.stomatocyte_start(out["oblate"][-1], elements)
    out["stomatocyte"] = [top, *vesicle_branches.follow(low, np.linspace(low.volume, 0.4, 40)[1:], elements)]
    return out


def cage_of(shape: solver.Shape) -> curvopt.Cage:
    """98 vertices of a sphere's cage on a shape, most of them where it turns."""
    t, r, z = shape.profile()
    turning = np.cumsum(np.sqrt(shape.ends[:, solver.U] ** 2 + 1) * np.gradient(t))
    mesh = on_profile(read_obj(ROOT / "blend_files" / "obj" / "sphere_cube.obj"), turning, r, z)
    return curvopt.cage(mesh.xyz, mesh.face_list())


def energy(shape: solver.Shape, volume: float) -> float:
    """int H^2 dA over 4 pi of the library's minimizer of that reduced volume, from a cage on a shape."""
    found = curvopt.minimize(
        cage_of(shape), "mean_curvature", levels=LEVELS, symmetry="keep", spacing=2, reduced_volume=volume
    )  # spacing 2: free, for necks
    return found.energies.h2 / (4 * math.pi)


def nearest(shapes: Sequence[solver.Shape], volume: float) -> solver.Shape:
    """Of a branch, but its first shape, from which stomatocytes go two ways."""
    return min(shapes[1:], key=lambda shape: abs(shape.volume - volume))


def dots(branches: Curves, volumes: Mapping[str, Sequence[float]]) -> dict[str, list[tuple[float, float]]]:
    """Reduced volume and energy of the library's minimizers, each from the branch's shape nearest to it."""
    out: dict[str, list[tuple[float, float]]] = {name: [] for name in volumes}
    for name, wanted in volumes.items():
        for volume in wanted:
            out[name].append((volume, energy(nearest(branches[name], volume), volume)))
    return out


def diagram(branches: Curves, found: Mapping[str, Sequence[tuple[float, float]]]) -> str:
    """The SVG."""
    lines = [
        Series(f"{name}, solver", [(s.volume, s.willmore() / solver.AREA) for s in shapes], "line", INKS[name])
        for name, shapes in branches.items()
    ]
    points = [Series(f"{name}, curvopt", found[name], "dots", INKS[name]) for name in found]
    title = "Bending energy of closed surfaces with less volume than a sphere"
    return plot(title, Axis("reduced volume", 0.4, 1.0), Axis("∫H² / 4π", 1.0, 3.2), [*lines, *points])


def main() -> None:
    """Write the picture, and say how far the dots are above the curves at most."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "blend_files" / "pictures" / "vesicles.svg"
    branches = curves()
    found = dots(branches, DOTS)
    for name, places in found.items():
        near = [vesicle_branches.at_volume(nearest(branches[name], v), v, 96) for v, _ in places]
        known = [shape.willmore() / solver.AREA for shape in near]
        off = [e / w - 1 for (_, e), w in zip(places, known)]
        print(f"{name}: {len(off)} volumes, {min(off):.1e} to {max(off):.1e} above")
    out.write_text(diagram(branches, found), encoding="utf-8")


if __name__ == "__main__":
    main()

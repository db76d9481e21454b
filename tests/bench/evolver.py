# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface Evolver (Brakke, "The Surface Evolver", Exp. Math. 1, 1992; Debian's evolver-nox) on the same task: ∫H² of a
triangulated closed surface by its `star_perp_sq_mean_curvature`, from points of the cage's limit surface.

Two schedules, since no one is best everywhere: `steady` alternates short gradient descents with vertex averaging and
equiangulation, then conjugate gradients, and refines; `eager` goes to conjugate gradients at once and takes
`hessian_seek` steps with `hessian_normal`. Times are Evolver's own CPU clock.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from ccref import Mesh, refine
from nets import limit_mask

SCHEDULES = {
    "steady": "gentle 20; stage; r; gentle 20; stage; r; gentle 20; stage; U; g 30; V; u; g 30; stage; U;"
    " r; gentle 20; stage; U; g 40; V; u; g 40; stage; g 200; stage",
    "eager": "U; g 100; V 5; u; g 100; stage; r; g 50; V 5; u; g 100; stage; hessian_normal on; hessian_seek;"
    " hessian_seek; stage; r; g 50; V 5; u; g 100; hessian_seek; hessian_seek; stage; r; g 50; V 5; u; g 100;"
    " hessian_seek; hessian_seek; stage; r; g 50; V 5; u; g 100; stage",
}
PREPARE = (
    "set facet tension 0",
    "autochop off",
    "quietgo on",
    'stage := { printf "STAGE %d %.12g %.4f\\n", vertex_count, total_energy, clock; }',
    "gentle := { g 10; V; u; }",
    "stage",
)


def datafile(cage: Mesh) -> str:
    """The cage subdivided once, its vertices put on the limit surface, faces cut in two."""
    fine = refine(cage)
    apply, scale = limit_mask(fine)
    points = apply(fine.xyz) / scale[:, None]
    quads = fine.flat.reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    low = np.sort(ends, axis=2)
    edges, number = np.unique(low.reshape(-1, 2), axis=0, return_inverse=True)
    signed = (number.reshape(-1, 3) + 1) * np.where(ends[:, :, 0] < ends[:, :, 1], 1, -1)
    lines = ["quantity bending energy method star_perp_sq_mean_curvature global", "vertices"]
    lines += [f"{i + 1} {x:.16g} {y:.16g} {z:.16g}" for i, (x, y, z) in enumerate(points)]
    lines += ["edges", *(f"{i + 1} {a + 1} {b + 1}" for i, (a, b) in enumerate(edges))]
    lines += ["faces", *(f"{i + 1} {a} {b} {c}" for i, (a, b, c) in enumerate(signed))]
    return "\n".join(lines) + "\n"


def run(cage: Mesh, schedule: str, seconds: int) -> list[tuple[int, float, float]]:
    """Vertices, ∫H² and CPU seconds after every stage that was reached in that time."""
    program = shutil.which("evolver")
    if not program:
        raise FileNotFoundError("evolver is not installed (Debian: evolver-nox)")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "start.fe").write_text(datafile(cage))
        commands = [*PREPARE, *(step.strip() for step in SCHEDULES[schedule].split(";")), "q", "q"]
        try:
            done = subprocess.run(
                [program, "start.fe"], input="\n".join(commands) + "\n", capture_output=True, text=True, cwd=folder,
                timeout=seconds, check=False,
            )
            output = done.stdout
        except subprocess.TimeoutExpired as late:
            output = (late.stdout or b"").decode()
    found = re.findall(r"^STAGE (\d+) (\S+) (\S+)$", output, re.MULTILINE)
    if not found:
        raise RuntimeError("Evolver said: " + output[-400:])
    return [(int(n), float(value), float(cpu)) for n, value, cpu in found]

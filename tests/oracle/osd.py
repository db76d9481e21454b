# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs osd_eval.cpp: builds it once per checkout state and reads its output."""
from __future__ import annotations

import hashlib
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ccref import Mesh
from nets import write_obj

SOURCE = Path(__file__).resolve().parent / "osd_eval.cpp"


class OsdResult(NamedTuple):
    """jets [n, 6, 3]: S, S_u, S_v, S_uu, S_uv, S_vv; limit and normal [n_vertices, 3]."""

    jets: np.ndarray
    limit: np.ndarray
    normal: np.ndarray


def program() -> Path:
    """The compiled osd_eval, kept in the temporary folder under a name that holds the source's hash."""
    digest = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]
    target = Path(tempfile.gettempdir()) / f"curvopt_osd_eval_{digest}"
    if not target.exists():
        with tempfile.TemporaryDirectory() as folder:
            built = Path(folder) / "osd_eval"
            subprocess.run(["g++", "-O2", "-std=c++14", str(SOURCE), "-o", str(built), "-losdCPU"], check=True)
            partial = target.with_suffix(f".{digest}.{Path(folder).name}")
            partial.write_bytes(built.read_bytes())
            partial.chmod(0o755)
            partial.replace(target)
    return target


def osd_refined(mesh: Mesh, levels: int, boundary: str = "all") -> np.ndarray:
    """Vertices [n, 3] after so many subdivisions by OpenSubdiv, in its order; the cage need not be a manifold."""
    with tempfile.TemporaryDirectory() as folder:
        cage = write_obj(Path(folder) / "cage.obj", mesh)
        run = subprocess.run([str(program()), str(cage), "--boundary", boundary, "--refine", str(levels)], input=b"",
                             capture_output=True, check=True)
    return np.frombuffer(run.stdout).reshape(-1, 3)


def osd_jets(mesh: Mesh, face, corner, uv, boundary: str = "all", level: int = 10) -> OsdResult:
    """OpenSubdiv's positions and derivatives at (face, corner, u, v) and its limit at the cage's vertices."""
    uv = np.asarray(uv, float).reshape(-1, 2)
    with tempfile.TemporaryDirectory() as folder:
        cage = write_obj(Path(folder) / "cage.obj", mesh)
        command = [str(program()), str(cage), "--boundary", boundary, "--level", str(level)]
        lines = [f"e {a} {b} {s}" for (a, b), s in zip(mesh.creases, mesh.crease_sharpness)]
        if mesh.vertex_sharpness is not None:
            lines += [f"v {i} {s}" for i, s in enumerate(mesh.vertex_sharpness) if s > 0]
        if lines:
            creases = Path(folder) / "creases.txt"
            creases.write_text("\n".join(lines) + "\n", encoding="ascii")
            command += ["--creases", str(creases)]
        points = np.column_stack([face, corner, uv]).astype(float)
        run = subprocess.run(command, input=points.tobytes(), capture_output=True, check=True)
    jets, vertices = np.split(np.frombuffer(run.stdout), [18 * len(uv)])
    limit, normal = np.split(vertices.reshape(-1, 6), 2, axis=1)
    return OsdResult(jets.reshape(-1, 6, 3), limit, normal)

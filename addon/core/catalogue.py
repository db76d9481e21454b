# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages to start from: Wavefront files in the add-on's `shapes/`, or else in the project's `blend_files/obj/`. No bpy."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..binding.values import Cage


def folder() -> Path:
    """Where the files are; it may not exist."""
    addon = Path(__file__).resolve().parents[1]
    installed = addon / "shapes"
    return installed if installed.is_dir() else addon.parent / "blend_files" / "obj"


def names() -> list[str]:
    """Names of all cages, sorted."""
    return sorted(path.stem for path in folder().glob("*.obj"))


def label(name: str) -> str:
    """For people: "Lawson genus 2", "Torus 0.15"."""
    words = [re.sub(r"^g(\d+)$", r"genus \1", word) for word in name.split("_")]
    words = [re.sub(r"^0(\d\d)$", r"0.\1", word) for word in words]
    text = " ".join(words)
    return text[:1].upper() + text[1:]


def load(name: str) -> Cage:
    """The cage called so. OSError or ValueError if its file is not there or no cage."""
    points, sizes, vertices = [], [], []
    for line in (folder() / f"{name}.obj").read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points.append([float(word) for word in words[:3]])
        elif kind == "f":
            face = [int(word.split("/")[0]) - 1 for word in words]
            sizes.append(len(face))
            vertices.extend(face)
    positions = np.array(points, float).reshape(-1, 3)
    if not sizes or min(vertices) < 0 or max(vertices) >= len(positions):
        raise ValueError(f"The file of the shape '{name}' holds no cage.")
    return Cage(positions, np.array(sizes, np.int32), np.array(vertices, np.int32))

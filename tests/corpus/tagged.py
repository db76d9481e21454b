# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes in OBJ files with OpenSubdiv's tags, and what Blender can have of them.

    t crease n/k/0 VERTEX... SHARPNESS...       a chain of n vertices with one sharpness, or n - 1 of them
    t corner n/k/0 VERTEX... SHARPNESS...       n vertices with one sharpness, or n of them
    t interpolateboundary 1/0/0 RULE            2: smooth, 1: corners are kept, 0: faces at a boundary are not drawn

Vertices of tags count from 0. Blender draws faces at a boundary, and has neither holes nor edits of finer levels.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Sequence

INFINITE = 10.0  # OpenSubdiv's sharpness from which a crease never fades; Blender's crease of 1
BOUNDARY_SMOOTH = {0: "ALL", 1: "PRESERVE_CORNERS", 2: "ALL"}  # of the modifier, by the tag's rule


@dataclass
class Shape:
    """Points, faces, sharpness of edges (by their two vertices, ascending) and of vertices; the modifier's
    boundary_smooth; names of tags that Blender has nothing for."""

    points: list[tuple[float, ...]] = field(default_factory=list)
    faces: list[list[int]] = field(default_factory=list)
    edges: dict[tuple[int, int], float] = field(default_factory=dict)
    corners: dict[int, float] = field(default_factory=dict)
    boundary_smooth: str = "ALL"
    passed_over: set[str] = field(default_factory=set)


def parse(text: str) -> Shape:
    """The shape in the text of an OBJ file. ValueError, IndexError for tags that are not as above."""
    shape = Shape()
    for line in text.splitlines():
        word, *values = line.split() or [""]
        if word == "v":
            shape.points.append(tuple(map(float, values[:3])))
        elif word == "f":
            shape.faces.append([_index(value, len(shape.points)) for value in values])
        elif word == "t":
            _add_tag(shape, values)
    return shape


def crease_of(sharpness: float) -> float:
    """Blender's crease, 0 .. 1, of a sharpness: the modifier takes 10 times its square."""
    return (min(max(sharpness, 0.0), INFINITE) / INFINITE) ** 0.5


def _index(value: str, n_points: int) -> int:
    number = int(value.split("/")[0])
    return number - 1 if number > 0 else n_points + number


def _add_tag(shape: Shape, words: Sequence[str]) -> None:
    name, counts, *values = words
    n_integers, n_reals = map(int, counts.split("/")[:2])
    integers, reals = list(map(int, values[:n_integers])), list(map(float, values[n_integers:n_integers + n_reals]))
    if name == "crease":
        edges = [(min(pair), max(pair)) for pair in zip(integers, integers[1:])]
        shape.edges.update(zip(edges, _each(reals, len(edges))))
    elif name == "corner":
        shape.corners.update(zip(integers, _each(reals, len(integers))))
    elif name == "interpolateboundary":
        shape.boundary_smooth = BOUNDARY_SMOOTH[integers[0]]
        if integers[0] == 0:
            shape.passed_over.add(name)
    else:
        shape.passed_over.add(name)


def _each(values: list[float], n: int) -> list[float]:
    """n values, of n or of one."""
    if len(values) not in (1, n):
        raise ValueError(f"{len(values)} values for {n}")
    return values * n if len(values) == 1 else values

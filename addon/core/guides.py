# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that chains of edges follow: which chain the vertices of a vertex group are, and what of a curve stands against it. No bpy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..binding.through import Chain


def ordered(members: np.ndarray, edges: np.ndarray) -> tuple[list[int], bool]:
    """The chain of edges (e, 2) between vertices `members` (k,), each vertex once, and whether it is closed. An open one begins
    at its end of the least number. ValueError, about vertices by number, where they are no chain, or more than one."""
    members = [int(vertex) for vertex in members]
    inside = set(members)
    near: dict[int, list[int]] = {vertex: [] for vertex in members}
    for a, b in edges.tolist():
        if a in inside and b in inside:
            near[a].append(b)
            near[b].append(a)
    if len(members) < 2:
        raise ValueError(f"has vertex {members[0]} alone; a chain has two vertices and more")
    forks = [vertex for vertex in members if len(near[vertex]) > 2]
    if forks:
        joined = len(near[forks[0]])
        raise ValueError(f"branches at vertex {forks[0]}, which edges join to {joined} others of it; in a chain it is one or two")
    ends = [vertex for vertex in members if len(near[vertex]) < 2]
    chain = [min(ends, default=members[0])]
    while len(chain) <= len(members):
        following = [vertex for vertex in near[chain[-1]] if vertex not in chain[-2:-1]]
        if not following or following[0] == chain[0]:
            break
        chain.append(following[0])
    rest = inside.difference(chain)
    if rest:
        raise ValueError(f"is in pieces: no edges join vertex {chain[0]} to vertex {min(rest)}; a chain is in one")
    return chain, not ends


def is_chain(members: np.ndarray, edges: np.ndarray) -> bool:
    """Whether the vertices `members` (k,) are one chain of edges (e, 2)."""
    try:
        ordered(members, edges)
    except ValueError:
        return False
    return True


def unpaired_text(curves: Sequence[str], groups: Sequence[str], name: str) -> str:
    """That `curves` have no vertex group of their name on object `name`, and chains of edges in `groups` no curve, in a sentence;
    empty unless there are both."""
    if not curves or not groups:
        return ""
    return (
        f"Curve '{curves[0]}' has no vertex group of its name on object '{name}', so the surface goes through points along it, and "
        f"vertex group '{groups[0]}', a chain of edges, has no curve: give both one name if the chain is to follow the curve"
    )


def followed(chain: list[int], is_closed: bool, line: np.ndarray, is_curve_closed: bool, weight: float) -> Chain:
    """The chain on a curve through the points of `line` (k, 3), whose last one repeats the first if it is closed. ValueError where it
    cannot follow it."""
    if not np.isfinite(line).all():
        raise ValueError("is at no place: give it a scale and points that are numbers")
    if is_closed and not is_curve_closed:
        raise ValueError("is open, and the chain of edges is closed: close it (Toggle Cyclic), or take a vertex out of the vertex group")
    points = line[:-1] if is_curve_closed else line
    return Chain(chain, points, closed=is_closed, curve_closed=is_curve_closed, weight=weight)

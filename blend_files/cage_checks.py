# SPDX-License-Identifier: GPL-3.0-or-later
"""What every cage of the gallery must be: manifold, closed or with whole open ends, outward, of its genus, symmetric,
well shaped."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass

import numpy as np

SYMMETRY_TOLERANCE = 8e-15
ANGLE_LIMITS = (25.0, 155.0)  # degrees, corners of a face
WARP_LIMIT = 0.45  # distance of a quad's diagonals over the mean length of its edges

Faces = list[tuple[int, ...]]


@dataclass
class Figures:
    """What a check measured, printed as one line of the table."""

    vertices: int
    faces: int
    euler: int
    order: int
    valences: dict[int, int]
    warp: float
    edge_ratio: float
    angles: tuple[float, float]
    crowded: int

    def __str__(self) -> str:
        valences = " ".join(f"{valence}:{count}" for valence, count in sorted(self.valences.items()))
        return (
            f"{self.vertices:>4} {self.faces:>4} {self.euler:>4} {self.order:>4}  {valences:<16} {self.warp:5.2f}"
            f" {self.edge_ratio:6.2f}  {self.angles[0]:3.0f}-{self.angles[1]:<3.0f}  {self.crowded}"
        )


def check_cage(
    vertices: np.ndarray, faces: Faces, euler: int, open_ends: int, group: np.ndarray, edge_ratio: float
) -> tuple[Figures, list[str]]:
    """Measures a cage, vertices (n, 3), against its Euler characteristic, its number of open ends
    and its symmetry group (m, 3, 3).

    `edge_ratio` bounds a face's longest edge over its shortest. Returns the figures and one sentence per fault.
    """
    faults = _topology_faults(len(vertices), faces, open_ends)
    edges = {frozenset(edge) for face in faces for edge in _edges(face)}
    valences = Counter(i for edge in edges for i in edge)
    rim = {i for end in _open_ends(faces) for i in end}
    extraordinary = {i for i, valence in valences.items() if valence != (3 if i in rim else 4)}
    shapes = [_face_shape(vertices[list(face)]) for face in faces]
    figures = Figures(
        vertices=len(vertices),
        faces=len(faces),
        euler=len(vertices) - len(edges) + len(faces),
        order=len(group),
        valences=dict(Counter(valences.values())),
        warp=max(shape[0] for shape in shapes),
        edge_ratio=max(shape[1] for shape in shapes),
        angles=(min(shape[2] for shape in shapes), max(shape[3] for shape in shapes)),
        crowded=max(sum(i in extraordinary for i in face) for face in faces),
    )
    if figures.euler != euler:
        faults.append(f"its Euler characteristic is {figures.euler}, not {euler}")
    if not np.isfinite(vertices).all():
        faults.append("a coordinate is not finite")
    elif volume(vertices, faces) <= 0:
        faults.append(f"its volume is {volume(vertices, faces):.3g}: the faces look inwards")
    return figures, faults + _symmetry_faults(vertices, faces, group) + _shape_faults(figures, edge_ratio)


def volume(vertices: np.ndarray, faces: Faces) -> float:
    """The volume inside a closed cage, vertices (n, 3); negative if its faces look inwards."""
    total = 0.0
    for face in faces:
        a = vertices[face[0]]
        for b, c in zip(vertices[list(face[1:-1])], vertices[list(face[2:])]):
            total += float(a @ np.cross(b, c)) / 6
    return total


def _edges(face: tuple[int, ...]) -> list[tuple[int, int]]:
    """The directed edges of a face."""
    return list(zip(face, face[1:] + face[:1]))


def _open_ends(faces: Faces) -> list[list[int]]:
    """Vertices of each closed chain of edges that have one face only, in order; a chain that does not close is given
    as far as it goes."""
    directed = {edge for face in faces for edge in _edges(face)}
    after = {b: a for a, b in directed if (b, a) not in directed}
    ends = []
    while after:
        end = [next(iter(after))]
        while (following := after.pop(end[-1], end[0])) != end[0]:
            end.append(following)
        ends.append(end)
    return ends


def _topology_faults(n_vertices: int, faces: Faces, open_ends: int) -> list[str]:
    """Sentences on edges without exactly two opposite faces, but for those of so many open ends, and on vertices
    without exactly one fan."""
    faults = []
    directed = Counter(edge for face in faces for edge in _edges(face))
    ends = _open_ends(faces)
    if len(ends) != open_ends:
        faults.append(f"it has {len(ends)} open ends, not {open_ends}")
    rim = {(b, a) for end in ends for a, b in zip(end, end[1:] + end[:1])}
    for (a, b), count in directed.items():
        if count != 1 or directed[b, a] != ((a, b) not in rim):
            faults.append(f"edge {a}-{b} has {count} faces on one side and {directed[b, a]} on the other")
    following: dict[int, dict[int, int]] = defaultdict(dict)
    for face in faces:
        if len(face) < 3 or len(set(face)) != len(face):
            faults.append(f"face {face} is too small or repeats a vertex")
        for before, here, after in zip(face[-1:] + face[:-1], face, face[1:] + face[:1]):
            following[here][after] = before
    for vertex in range(n_vertices):
        fan = following.get(vertex, {})
        start = here = next((i for i in fan if i not in fan.values()), next(iter(fan), None))  # at a rim: its first
        steps = 0
        while here in fan and steps < len(fan):
            here, steps = fan[here], steps + 1
            if here == start:
                break
        closes = here == start or (start not in fan.values() and here not in fan)
        if not fan or not closes or steps != len(fan):
            faults.append(f"vertex {vertex} has {steps} of its {len(fan)} faces in one fan")
    return faults


def _symmetry_faults(vertices: np.ndarray, faces: Faces, group: np.ndarray) -> list[str]:
    """Sentences on group elements (m, 3, 3) that do not map the cage onto itself."""
    size = np.abs(vertices).max()
    polygons = {frozenset(face) for face in faces}
    faults = []
    for number, element in enumerate(group):
        image = vertices @ element.T
        distance = np.abs(image[:, None] - vertices[None]).max(axis=2)
        partner = distance.argmin(axis=1)
        worst = float(distance.min(axis=1).max())
        if worst > SYMMETRY_TOLERANCE * size or len(set(partner.tolist())) != len(vertices):
            faults.append(f"symmetry {number} moves a vertex off the cage by {worst:.3g}")
        elif {frozenset(partner[list(face)].tolist()) for face in faces} != polygons:
            faults.append(f"symmetry {number} maps a face to none of the cage's")
    return faults


def _face_shape(corners: np.ndarray) -> tuple[float, float, float, float]:
    """Warp, edge ratio, smallest and largest angle in degrees of a face with corners (k, 3)."""
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = np.roll(corners, 1, axis=0) - corners
    lengths = np.linalg.norm(ahead, axis=1)
    cosines = (ahead * behind).sum(axis=1) / (lengths * np.linalg.norm(behind, axis=1))
    angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    offsets = (corners - corners.mean(axis=0)) @ (normal / np.linalg.norm(normal))
    warp = (offsets.max() - offsets.min()) / lengths.mean()
    return float(warp), float(lengths.max() / lengths.min()), float(angles.min()), float(angles.max())


def _shape_faults(figures: Figures, edge_ratio: float) -> list[str]:
    """Sentences on faces that no artist would leave."""
    faults = []
    if figures.warp > WARP_LIMIT:
        faults.append(f"a face is warped by {figures.warp:.2f} of its edges, more than {WARP_LIMIT}")
    if figures.edge_ratio > edge_ratio:
        faults.append(f"a face's edges differ by {figures.edge_ratio:.2f}, more than {edge_ratio}")
    if figures.angles[0] < ANGLE_LIMITS[0] or figures.angles[1] > ANGLE_LIMITS[1]:
        faults.append(f"a face has angles of {figures.angles[0]:.0f} to {figures.angles[1]:.0f} degrees")
    return faults

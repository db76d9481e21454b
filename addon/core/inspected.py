# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn on an object itself to read its surface: points of the true surface with normals and colours, and combs. No
bpy.

All are of the limit surface that the library samples. How finely Blender shows the object does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..binding import library, measure
from ..binding.values import Cage
from . import colours, combs, curvature
from .combs import Choice, Combs
from .edges import EdgeTable
from .messages import UserError
from .surface_points import Net, grid_net, lattice_net, levels_for, unit

MOST_FACES = 200_000
_MOST_SIDE = 32  # points along an edge


@dataclass(frozen=True)
class Subject:
    """What to look at. With a `quantity`, of colours.QUANTITIES or colours.DISTANCE, in colours; for DISTANCE from the surface
    of the same cage at `original` (n, 3). `number` counts them."""

    cage: Cage
    quantity: str = ""
    original: np.ndarray | None = None
    choice: Choice | None = None
    number: int = 0


@dataclass(frozen=True)
class Inspected:
    """The surface of `subject`: points, normals (n, 3) float32 on a `net`; tints (n, 4), RGBA, with the range of their values
    (low, high), or None; `area`, that of the surface by its points. `is_fine`: nothing finer will follow."""

    subject: Subject
    net: Net
    points: np.ndarray
    normals: np.ndarray
    tints: np.ndarray | None
    span: tuple[float, float] | None
    combs: Combs | None
    area: float
    is_fine: bool


def side_for(n_patches: int, wanted: int) -> int:
    """Quads along an edge of each of `n_patches`, 1 .. 32, for about `wanted` of them, but not more if that is possible."""
    return int(np.clip(np.sqrt(wanted / max(n_patches, 1)), 1, _MOST_SIDE))


class Sampling:
    """Takes pictures of surfaces; what depends on connectivity only is kept. A context manager, for one thread."""

    def __init__(self, lib: library.Library) -> None:
        self._lib = lib
        self._mesh: library.Mesh | None = None
        self._of: Cage | None = None
        self._table: EdgeTable | None = None
        self._nets: dict[tuple[bool, int], Net] = {}

    def take(self, subject: Subject, wanted: int, is_fine: bool = True, cancel: library.Cancel | None = None) -> Inspected:
        """With about `wanted` quads. UserError for cages too large; CurvoptError for those without a surface, ValueError."""
        cage = subject.cage
        self._prepare(cage)
        by_distance = subject.quantity == colours.DISTANCE
        net = self._net(by_distance, wanted)
        options = self._lib.options({"willmore": 1.0}, surface=library.SURFACES.index("limit"))
        with library.Sampler.create(self._mesh, cage.positions, options) as sampler:
            jets = net.points.jets_of(sampler)
            cross = np.cross(jets[:, 1], jets[:, 2])
            normals = unit(np.nan_to_num(cross))
            values = None
            if by_distance and subject.original is not None:
                values = self._distances(subject, net, cancel)
            elif subject.quantity and not by_distance:
                values = getattr(curvature.of_jets(jets), subject.quantity)
            found = self._combs(sampler, subject, wanted)
        span = None if values is None else colours.value_range(subject.quantity, values)
        tints = None if values is None else colours.colours(subject.quantity, values, *span)
        points = np.ascontiguousarray(jets[:, 0], np.float32)
        return Inspected(subject, net, points, normals.astype(np.float32), tints, span, found, _area(jets, net), is_fine)

    def _prepare(self, cage: Cage) -> None:
        """Mesh and tables of its connectivity."""
        if self._of is not None and is_alike(self._of, cage):
            return
        self.close()
        if len(cage.face_sizes) > MOST_FACES:
            raise UserError(f"The cage has {len(cage.face_sizes):,} faces. Inspect draws {MOST_FACES:,} at most.")
        self._mesh = library.Mesh.of_cage(self._lib, cage)
        self._of, self._table = cage, EdgeTable.of_faces(cage.face_sizes, cage.face_vertices)

    def _net(self, is_shared: bool, wanted: int) -> Net:
        sizes = self._of.face_sizes
        if is_shared:
            key = True, levels_for(len(sizes), wanted)
        else:
            key = False, side_for(int(np.where(sizes == 4, 1, sizes).sum()), wanted)
        if key not in self._nets:
            self._nets[key] = lattice_net(self._mesh, key[1]) if is_shared else grid_net(sizes, key[1])
        return self._nets[key]

    def _combs(self, sampler: library.Sampler, subject: Subject, wanted: int) -> Combs | None:
        choice = subject.choice
        if isinstance(choice, combs.OnSections):
            return combs.on_sections(sampler, subject.cage, self._table, self._net(True, wanted), choice)
        return None if choice is None else combs.on_edges(sampler, subject.cage, self._table, choice)

    def _distances(self, subject: Subject, net: Net, cancel: library.Cancel | None) -> np.ndarray:
        """Of the net's points (n,) from the original's surface."""
        fine, xyz = self._mesh, subject.cage.positions
        while len(xyz) < len(net.points.face):
            fine, xyz = fine.refine(xyz)
        return measure.deviation(self._mesh, subject.original, fine, xyz, cancel=cancel).distances

    def close(self) -> None:
        """Free what the library holds; a second time does nothing."""
        if self._mesh is not None:
            self._mesh.close()
        self._mesh = self._of = self._table = None
        self._nets.clear()

    def __enter__(self) -> Sampling:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def is_alike(one: Cage, other: Cage) -> bool:
    """Whether two cages have the same faces and creases, wherever their vertices are."""
    if one.face_sizes is other.face_sizes and one.face_vertices is other.face_vertices and one.creases is other.creases:
        return True
    a, b = one.creases, other.creases
    pairs = (
        (one.face_sizes, other.face_sizes), (one.face_vertices, other.face_vertices), (a.edges, b.edges),
        (a.edge_sharpness, b.edge_sharpness), (a.vertices, b.vertices), (a.vertex_sharpness, b.vertex_sharpness),
    )  # fmt: skip
    same = len(one.positions) == len(other.positions) and a.rule == b.rule
    return same and all(np.array_equal(x, y) for x, y in pairs)


def _area(jets: np.ndarray, net: Net) -> float:
    """By the quads' diagonals: half the length of their cross product."""
    a, b, c, d = (jets[net.points.quads[:, corner], 0] for corner in range(4))
    return float(np.linalg.norm(np.cross(c - a, d - b), axis=1).sum() / 2)

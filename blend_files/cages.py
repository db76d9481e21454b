#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's control cages as plain numbers, without Blender.

Every cage is (vertices (n, 3) float64, faces as tuples of indices): manifold, closed or with smooth open ends,
counter-clockwise seen from outside, symmetric to rounding. CATALOGUE names them; make_blends.py turns them into .blend
files.

    python3 cages.py --check            check every cage, one line each
    python3 cages.py --obj DIR          write DIR/NAME.obj with all digits
    python3 cages.py --only NAME ...    restrict either to some cages
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from cage_checks import check_cage
from frames import TRIANGLES, Cage, lawson, mirror_group, polyhedral, triangle_hosohedron

Face = tuple[int, ...]


def torus(ratio: float, around: int = 8, tube: int = 4, interpolate: bool = False) -> Cage:
    """A torus of radii 1 and `ratio` about the z axis; vertex i tube + j has big angle i, tube angle j.

    The cage's own points lie on the torus, as in Blender's Add Torus; with `interpolate` they are moved out so that
    the limit surface passes through these points (for two closed cubic splines that is a scaling of each circle).
    """
    shrink_around, shrink_tube = ((2 + np.cos(2 * np.pi / n)) / 3 if interpolate else 1.0 for n in (around, tube))
    big, small = _circle(around), _circle(tube) * ratio / shrink_tube
    radius = (1 + small[:, 0]) / shrink_around
    x, y = np.outer(big[:, 0], radius), np.outer(big[:, 1], radius)
    vertices = np.stack([x, y, np.broadcast_to(small[:, 1], x.shape)], axis=-1).reshape(-1, 3)
    return _without_dust(vertices), _grid_faces(around, tube)


def _circle(n: int) -> np.ndarray:
    """Corners (n, 2) of the regular polygon in the unit circle, the first at (1, 0)."""
    angles = [2 * math.pi * i / n for i in range(n)]
    return np.array([[math.cos(angle), math.sin(angle)] for angle in angles])


def _grid_faces(rows: int, columns: int) -> list[Face]:
    """Quads of a rows x columns grid that closes in both directions, vertex (i, j) being i columns + j."""

    def at(i: int, j: int) -> int:
        return i % rows * columns + j % columns

    return [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(rows) for j in range(columns)]


def _without_dust(vertices: np.ndarray) -> np.ndarray:
    """Vertices (n, 3) with what is 0 but for rounding made 0."""
    return np.where(np.abs(vertices) < 1e-15, 0.0, vertices)


def sphere_cube(divisions: int = 4) -> Cage:
    """A cube, each face divided equally in angle into divisions x divisions quads, blown up to the unit sphere."""
    grid = np.tan(np.pi / 4 * (2 * np.arange(divisions + 1) / divisions - 1))
    grid = (grid - grid[::-1]) / 2
    index: dict[tuple[float, ...], int] = {}
    faces: list[Face] = []
    for axis in range(3):
        for side in (-1.0, 1.0):

            def vertex(i: int, j: int, axis: int = axis, side: float = side) -> int:
                point = np.empty(3)
                point[[axis, (axis + 1) % 3, (axis + 2) % 3]] = side, grid[i], grid[j]
                point = np.sign(point) * np.where(np.abs(np.abs(point) - 1) < 1e-12, 1.0, np.abs(point))
                return index.setdefault(tuple(point + 0.0), len(index))

            for i in range(divisions):
                for j in range(divisions):
                    face = (vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1))
                    faces.append(face if side > 0 else face[::-1])
    points = np.array(list(index))
    squares = np.sort(points**2, axis=1)
    return points / np.sqrt(squares.sum(axis=1))[:, None], faces


def polycube(cells: set[tuple[int, int, int]]) -> Cage:
    """The outside of some unit cells, blocked out as an artist would; cell (i, j, k) begins at the point (i, j, k)."""
    index: dict[tuple[int, int, int], int] = {}
    faces: list[Face] = []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                neighbour = tuple(c + (2 * side - 1) * (d == axis) for d, c in enumerate(cell))
                if neighbour in cells:
                    continue
                corners = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[(axis + 1) % 3] += u
                    corner[(axis + 2) % 3] += v
                    corners.append(index.setdefault((corner[0], corner[1], corner[2]), len(index)))
                faces.append(tuple(corners) if side else tuple(corners[::-1]))
    return np.array(list(index), dtype=float), faces


def mug() -> Cage:
    """A mug of genus 1: nine columns with the middle one hollow, a handle of five cells, made round."""
    body = {(i, j, k) for i in range(3) for j in range(3) for k in range(3) if (i, j) != (1, 1) or k == 0}
    handle = {(3, 1, 0), (4, 1, 0), (4, 1, 1), (4, 1, 2), (3, 1, 2)}
    vertices, faces = polycube(body | handle)
    x, y, z = (vertices - [1.5, 1.5, 0]).T
    square = np.maximum(np.abs(x), np.abs(y))
    round_off = square / np.hypot(x, y)
    wall = np.where(square > 1, 1.3, 0.95) / square
    on_body = x < 2
    outward = np.where(on_body, x * round_off * wall, 1.3 + 0.55 * (x - 1.5))
    across = np.where(on_body, y * round_off * wall, 0.5 * y)
    flare = 1 + 0.06 * (z - 1.5) * on_body
    height = np.where(on_body, 1.05 * z - 0.35 * ((z == 1) & (square < 1)), 0.5 + 0.75 * z)
    return np.stack([outward * flare, across * flare, height], axis=1), faces


def pretzel() -> Cage:
    """A hand-made pretzel of genus 2: a flat figure of eight, one loop larger, bent and twisted; no symmetry."""
    cells = {(i, j, 0) for i in range(5) for j in range(3) if (i, j) not in {(1, 1), (3, 1)}}
    vertices, faces = polycube(cells)
    x, y, z = (vertices - [2.5, 1.5, 0.5]).T
    swell = 1 + 0.16 * x
    y = y * swell * (1 - 0.05 * x**2)
    x = x + 0.08 * x**2
    twist = 0.22 * x
    y, z = y * np.cos(twist) - 0.8 * z * np.sin(twist), y * np.sin(twist) + 0.8 * z * np.cos(twist)
    return np.stack([x, y + 0.1 * x * z, z + 0.09 * x**2], axis=1), faces


def branch() -> Cage:
    """A hand-made branching pipe, open at its three ends, each arm of another length and bend; no symmetry."""
    cells = {(i, 0, 0) for i in range(-2, 3)} | {(0, 0, k) for k in range(1, 4)}
    vertices, faces = polycube(cells)
    ends = ((0, -2.0), (0, 3.0), (2, 4.0))  # (axis, coordinate) of the caps that are taken away
    faces = [face for face in faces if not any((vertices[list(face), axis] == at).all() for axis, at in ends)]
    x, y, z = (vertices - [0.5, 0.5, 0.5]).T
    along, up = np.abs(x) > 0.6, z > 0.6
    wide = np.where(up, 1.25 - 0.09 * z, np.where(along, 1.0 - 0.08 * np.abs(x) + 0.05 * x, 1.15))
    bent_x = np.where(up, wide * x + 0.12 * (z - 0.5) ** 2, x + 0.06 * x**2 * np.sign(x))
    bent_y = wide * y + np.where(up, 0.1 * (z - 0.5) ** 2, 0.07 * x**2)
    bent_z = np.where(up, 1.05 * z, wide * z - np.where(along, 0.14 * x**2 - 0.02 * x**3, 0.0))
    return np.stack([bent_x, bent_y, bent_z], axis=1), faces


def trefoil(around: int = 36, tube: int = 4, radius: float = 0.5) -> Cage:
    """A trefoil knot's tube of genus 1, framed by the torus that the knot winds around."""
    t = 2 * np.pi * np.arange(around) / around
    zero = np.zeros_like(t)
    direction = np.stack([np.cos(2 * t), np.sin(2 * t), zero], axis=1)
    normal = direction * np.cos(3 * t)[:, None] + np.stack([zero, zero, np.sin(3 * t)], axis=1)
    middle = 2 * direction + normal
    turned = np.stack([-np.sin(2 * t), np.cos(2 * t), zero], axis=1)
    rate = 2 * (2 + np.cos(3 * t))[:, None] * turned
    rate += 3 * (np.stack([zero, zero, np.cos(3 * t)], axis=1) - direction * np.sin(3 * t)[:, None])
    binormal = np.cross(rate / np.linalg.norm(rate, axis=1)[:, None], normal)
    angle = 2 * np.pi * np.arange(tube) / tube
    ring = np.cos(angle)[:, None] * normal[:, None] - np.sin(angle)[:, None] * binormal[:, None]
    return _without_dust((middle[:, None] + radius * ring).reshape(-1, 3)), _grid_faces(around, tube)


@dataclass(frozen=True)
class Entry:
    """A cage of the catalogue and what must be true of it."""

    title: str
    make: Callable[[], Cage]
    genus: int
    open_ends: int = 0
    triangle: np.ndarray | None = None  # corners (3, 3) whose mirrors generate the symmetry group; None: no mirrors
    edge_ratio: float = 4.0  # of a face's longest edge to its shortest, at most

    @property
    def euler(self) -> int:
        """V - E + F."""
        return 2 - 2 * self.genus - self.open_ends

    def group(self) -> np.ndarray:
        """The symmetry group's elements (n, 3, 3); the identity alone without a triangle."""
        return np.eye(3)[None] if self.triangle is None else mirror_group(self.triangle)


def _catalogue() -> dict[str, Entry]:
    """Every cage by the name of its file."""
    entries: dict[str, Entry] = {}
    for percent in (10, 15, 20, 30, 40, 50, 60, 70, 80, 85, 90):
        ratio = percent / 100
        entries[f"torus_{percent:03d}"] = Entry(
            f"Torus, ratio {ratio}, 8 x 4", lambda ratio=ratio: torus(ratio), 1, 0, triangle_hosohedron(8), 17.0
        )
    for around, tube in ((6, 4), (8, 8), (12, 6), (16, 8)):
        entries[f"torus_050_{around}x{tube}"] = Entry(
            f"Torus, ratio 0.5, {around} x {tube}",
            lambda around=around, tube=tube: torus(0.5, around, tube),
            1,
            0,
            triangle_hosohedron(around),
        )
    for genus in range(1, 7):
        entries[f"lawson_g{genus}"] = Entry(
            f"Lawson, genus {genus}", lambda genus=genus: lawson(genus), genus, 0, triangle_hosohedron(genus + 1)
        )
    for file, solid, genus in (
        ("tetrahedral_g3", "tetrahedron", 3),
        ("cubical_g5", "cube", 5),
        ("octahedral_g7", "octahedron", 7),
    ):
        title = f"Frame of a{'n' if solid[0] == 'o' else ''} {solid}, genus {genus}"
        entries[file] = Entry(title, lambda solid=solid: polyhedral(solid), genus, 0, TRIANGLES[solid])
    entries["sphere_cube"] = Entry("Sphere from a cube", sphere_cube, 0, 0, TRIANGLES["cube"])
    entries["mug_g1"] = Entry("Mug, free form", mug, 1)
    entries["trefoil_g1"] = Entry("Trefoil knot, free form", trefoil, 1)
    entries["pretzel_g2"] = Entry("Pretzel, free form", pretzel, 2)
    entries["branch_open"] = Entry("Branching pipe, open, free form", branch, 0, 3)
    return entries


CATALOGUE = _catalogue()


def write_obj(path: Path, name: str, cage: Cage) -> None:
    """Writes a cage as OBJ, coordinates with all their digits."""
    vertices, faces = cage
    lines = [f"o {name}"]
    lines += ["v " + " ".join(repr(float(x)) for x in vertex) for vertex in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_obj(path: Path) -> Cage:
    """Reads what write_obj wrote."""
    rows = [line.split() for line in path.read_text(encoding="ascii").splitlines()]
    vertices = np.array([[float(x) for x in row[1:]] for row in rows if row[0] == "v"])
    return vertices, [tuple(int(i) - 1 for i in row[1:]) for row in rows if row[0] == "f"]


def check_all(names: list[str]) -> int:
    """Checks some cages, prints one line each, and returns how many are wrong."""
    wrong = 0
    print(f"{'cage':<16} {'V':>4} {'F':>4} {'chi':>4} {'|G|':>4}  valences          warp  edges  angles   EV/face")
    for name in names:
        entry = CATALOGUE[name]
        vertices, faces = entry.make()
        figures, faults = check_cage(vertices, faces, entry.euler, entry.open_ends, entry.group(), entry.edge_ratio)
        print(f"{name:<16} {figures}")
        for fault in faults:
            print(f"cages: {name}: {fault}", file=sys.stderr)
        wrong += bool(faults)
    print(f"{len(names) - wrong} passed, {wrong} failed")
    return wrong


def main() -> int:
    """The command line; 0 done, 1 a cage is wrong, 2 wrong usage."""
    parser = argparse.ArgumentParser(description="The gallery's control cages.")
    parser.add_argument("--check", action="store_true", help="check the cages")
    parser.add_argument("--obj", type=Path, metavar="DIR", help="write the cages to DIR/NAME.obj")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=list(CATALOGUE), help="some cages only")
    options = parser.parse_args()
    names = options.only or list(CATALOGUE)
    if not options.check and options.obj is None:
        parser.error("nothing to do: give --check or --obj DIR")
    if options.obj is not None:
        options.obj.mkdir(parents=True, exist_ok=True)
        for name in names:
            write_obj(options.obj / f"{name}.obj", name, CATALOGUE[name].make())
    return 1 if options.check and check_all(names) else 0


if __name__ == "__main__":
    sys.exit(main())

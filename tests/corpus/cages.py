# SPDX-License-Identifier: GPL-3.0-or-later
"""The held-out corpus: random cages that chose none of the optimizer's constants. README.md says what they are for.

    python3 tests/corpus/cages.py --seeds 0:120 --output DIR      writes DIR/seed_NNN.obj

A cage depends on its seed alone: draws are the corpus's own (draw.py), and coordinates are multiples of 2^-28, which
hides what libraries of functions round differently.
"""
from __future__ import annotations

import argparse
import hashlib
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "oracle"), str(HERE.parent / "cages")]

import large  # noqa: E402
from ccref import Mesh, mesh_from_faces  # noqa: E402
from draw import Draw  # noqa: E402
from families import FAMILIES, LARGEST, Named  # noqa: E402
from manifold import check  # noqa: E402
from nets import connected, read_obj, write_obj  # noqa: E402

GRAIN = 2.0 ** 28  # coordinates are multiples of 1 / GRAIN
TRIALS = 200       # a cage that is no manifold, or too large, is drawn anew


def cage(seed: int) -> tuple[np.ndarray, list[tuple[int, ...]], str]:
    """Positions [n, 3], faces and name of the seed's cage."""
    for trial in range(TRIALS):
        draw = Draw(seed, trial)
        try:
            mesh, name = large.make(draw, seed) if seed >= large.FIRST else small(draw, seed)
            check(mesh)
        except ValueError:
            continue
        if connected(mesh):
            return np.rint(mesh.xyz * GRAIN) / GRAIN, [tuple(face) for face in mesh.face_list()], name
    raise ValueError(f"seed {seed}: no cage in {TRIALS} trials")


def small(draw: Draw, seed: int) -> Named:
    """The first range's cage of the seed by these draws; ValueError if it has too few or too many vertices."""
    mesh, name = FAMILIES[seed % len(FAMILIES)](draw, draw.size())
    if not 6 <= mesh.n_vertices <= LARGEST:
        raise ValueError(f"{mesh.n_vertices} vertices")
    return mesh, name


def checksum(seeds: range) -> str:
    """SHA-256 of the cages' coordinates, as integers, and faces."""
    total = hashlib.sha256()
    for seed in seeds:
        xyz, faces, name = cage(seed)
        total.update(repr((name, [int(x) for x in np.rint(xyz * GRAIN).ravel()], faces)).encode())
    return total.hexdigest()


def parse_seeds(text: str) -> range:
    """FIRST:END, END excluded, or a single seed."""
    first, _, end = text.partition(":")
    return range(int(first), int(end) if end else int(first) + 1)


def write(seed: int, folder: Path) -> Path:
    """The seed's OBJ file, left alone if it is there with the same contents."""
    xyz, faces, _ = cage(seed)
    mesh, path = mesh_from_faces(xyz, faces), folder / f"seed_{seed:03d}.obj"
    if not path.exists() or not _same(read_obj(path), mesh):
        write_obj(path, mesh)
    return path


def _same(one: Mesh, other: Mesh) -> bool:
    return one.face_list() == other.face_list() and np.array_equal(one.xyz, other.xyz)


def main() -> None:
    parser = argparse.ArgumentParser(description="Writes the corpus's cages as OBJ files.")
    parser.add_argument("--seeds", type=parse_seeds, default=range(240), metavar="FIRST:END", help="default 0:240")
    parser.add_argument("--output", type=Path, required=True, metavar="DIR")
    parser.add_argument("--list", action="store_true", help="also print seed, name, vertices and faces")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for seed in arguments.seeds:
        write(seed, arguments.output)
        if arguments.list:
            xyz, faces, name = cage(seed)
            print(f"{seed:4d}  {name:28s} {len(xyz):4d} vertices {len(faces):4d} faces")


if __name__ == "__main__":
    main()

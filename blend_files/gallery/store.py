# SPDX-License-Identifier: GPL-3.0-or-later
"""What the gallery has finished, on disk: one JSON file an item, with the key of everything it depended on. No bpy.

DIR/data/ITEM.json    {"key", "seconds", "result"}; written last, and whole or not at all
DIR/data/ITEM.npz     arrays of the item, if it has any
DIR/pictures/         what items draw
"""

from __future__ import annotations

import hashlib
import inspect
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from addon.binding.values import Cage


@dataclass(frozen=True)
class Item:
    """A piece of work with a name of its own.

    `work(store, item)` returns its result, plain values for JSON; it may call `store.save_arrays` and must make `files`
    (relative to the store). `inputs` are plain values on which the result depends, beside the results of the items that
    it `needs`, the library, and the source of `work`'s module. `drawn`: it uses Blender, so it is for the main thread.
    `cost` is a guess in seconds, `tags` are what --only knows it by."""

    name: str
    work: Callable[[Store, Item], object]
    inputs: Mapping[str, object]
    tags: frozenset[str]
    needs: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    drawn: bool = False
    cost: float = 1.0
    cages: Mapping[str, Cage] = field(default_factory=dict)


class Store:
    """The folder of a gallery. `version` says which library makes its figures."""

    def __init__(self, root: Path, version: str) -> None:
        self.root, self.version = root, version
        for folder in ("data", "pictures"):
            (root / folder).mkdir(parents=True, exist_ok=True)

    def path(self, file: str) -> Path:
        """Where a file of the gallery lies."""
        return self.root / file

    def entry(self, name: str) -> dict | None:
        """What is written of an item, up to date or not; None if that is nothing, or nothing readable."""
        try:
            return json.loads((self.root / "data" / f"{name}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def result(self, name: str) -> object:
        """The result of a finished item. KeyError if it is not finished."""
        entry = self.entry(name)
        if entry is None:
            raise KeyError(f"{name} is not finished")
        return entry["result"]

    def fresh(self, item: Item, key: str) -> bool:
        """Whether an item is finished and nothing that it depends on has changed."""
        entry = self.entry(item.name)
        return entry is not None and entry["key"] == key and all(self.path(file).is_file() for file in item.files)

    def finish(self, item: Item, key: str, seconds: float, result: object) -> None:
        """Write down that an item is finished. RuntimeError if it has not made its files."""
        missing = [file for file in item.files if not self.path(file).is_file()]
        if missing:
            raise RuntimeError(f"{item.name} did not make {', '.join(missing)}")
        text = json.dumps({"key": key, "seconds": round(seconds, 3), "result": result}, indent=1)
        self.write(f"data/{item.name}.json", (text + "\n").encode())

    def write(self, file: str, content: bytes) -> None:
        """Write a file whole or not at all."""
        path = self.path(file)
        draft = path.with_name(f".{path.name}.{os.getpid()}")
        draft.write_bytes(content)
        os.replace(draft, path)

    def save_arrays(self, name: str, **arrays: np.ndarray) -> None:
        """Keep arrays for the items that need this one."""
        path = self.root / "data" / f"{name}.npz"
        draft = path.with_name(f".{name}.{os.getpid()}.npz")
        np.savez_compressed(draft, **arrays)
        os.replace(draft, path)

    def save_cage(self, name: str, cage: Cage) -> None:
        """Keep a cage without creases."""
        self.save_arrays(name, positions=cage.positions, sizes=cage.face_sizes, corners=cage.face_vertices)

    def cage(self, name: str) -> Cage:
        """A cage that save_cage kept."""
        with np.load(self.root / "data" / f"{name}.npz") as kept:
            return Cage(kept["positions"], kept["sizes"], kept["corners"])


def keys(items: Sequence[Item], version: str) -> dict[str, str]:
    """The key of each item by its name: a digest of all that its result depends on. Items stand after
    what they need."""
    found: dict[str, str] = {}
    for item in items:
        parts = {
            "inputs": item.inputs,
            "cages": {name: cage_digest(cage) for name, cage in item.cages.items()},
            "needs": [found[need] for need in item.needs],
            "code": _code(item.work),
            "library": version,
        }
        found[item.name] = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
    return found


def _code(work: Callable[[Store, Item], object]) -> str:
    """A digest of the source of `work`'s module, and of those that it lists as USES."""
    used = getattr(inspect.getmodule(work), "USES", ())
    return " ".join(_source_digest(path) for path in (inspect.getsourcefile(work), *(m.__file__ for m in used)))


@lru_cache(maxsize=None)
def _source_digest(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def library_version(path: Path, version: str) -> str:
    """The library's version and a digest of its file: two builds of one version are two libraries."""
    return f"{version} {hashlib.sha256(path.read_bytes()).hexdigest()}"


def cage_digest(cage: Cage) -> str:
    """A digest of a cage's numbers, creases apart."""
    digest = hashlib.sha256()
    for array in (cage.positions, cage.face_sizes, cage.face_vertices):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()

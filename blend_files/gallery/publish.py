# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's pictures, out of a gallery into the repository, with a stamp: which library made them, from what, and
every figure in them. tests/numeric/test_readme.py makes the figures again and compares. No bpy.

DIR/*.png           as they stand in the gallery
DIR/pictures.json   {"library", "sources", "pictures": {FILE: {"sha256", "figures": [...]}}}"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from . import contents
from .store import Item, Store

STAMP = "pictures.json"
_FIELDS = ("value", "h2", "net_share", "quadrature_error", "verdict", "symmetry_order", "vertices", "seconds")
_ROOT = Path(__file__).resolve().parents[2]


def publish(store: Store, items: Mapping[str, Item], fresh: Iterable[str], folder: Path) -> list[str]:
    """Copy the pictures of the README that are up to date, and write the stamp; names of the files. Those that are not
    up to date stay as they were, and so do their figures."""
    stamp = {"library": "", "sources": "", "pictures": {}}
    if (folder / STAMP).is_file():
        stamp = json.loads((folder / STAMP).read_text(encoding="utf-8"))
    made = []
    for name in sorted(set(fresh) & set(contents.published())):
        item = items[name]
        figures = [_figures(store, items[solved]) for solved in contents.solves(items, item)]
        for file in item.files:
            content = store.path(file).read_bytes()
            _write(folder / Path(file).name, content)
            digest = hashlib.sha256(content).hexdigest()
            stamp["pictures"][Path(file).name] = {"sha256": digest, "figures": figures}
            made.append(Path(file).name)
    if made:
        stamp["library"], stamp["sources"] = store.version.split()[0], sources_digest()
        _write(folder / STAMP, (json.dumps(stamp, indent=1, sort_keys=True) + "\n").encode())
    return made


def sources_digest() -> str:
    """A digest of the sources that decide results: the library's, and its public header."""
    digest = hashlib.sha256()
    for part in ("include", "src"):
        for path in sorted((_ROOT / "libcurvopt" / part).rglob("*.[ch]")):
            digest.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _figures(store: Store, item: Item) -> dict[str, object]:
    """What one run was asked for and what came of it."""
    record = store.result(item.name)
    ((cage, _),) = item.cages.items()
    asked = {"cage": cage, "energy": record["energy"], "levels": item.inputs["levels"],
             "symmetry": "auto" if item.name.startswith("cover.") else "keep"}  # fmt: skip
    return {**asked, **{field: record[field] for field in _FIELDS}}


def _write(path: Path, content: bytes) -> None:
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_bytes(content)
    os.replace(draft, path)

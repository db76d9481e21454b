# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether flow.py finds what it is for, on small made-up trees: python3 tests/checks/test_flow.py."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import flow

GUIDE = """# Made up
```flow
lib: base -> mesh, tables
-> api
py: binding -> core -> ui, render -> .
py/binding -> gallery
```
```map
lib/base/     what all use
    status    codes
lib/mesh/     connectivity
    mesh      half-edges
    fan       faces round a vertex
lib/tables/   numbers
    gauss     nodes
lib/api/      exported
    api       checks
py/           the start
    start     runs it
    ui        has a folder's name
py/binding/   the library
    abi       structs
py/core/      arrays
    job       one run
py/ui/        panels
    panel     one
py/render/    pictures
    studio    light
gallery/      pages
    page      one
```
See `lib/base/`, `mesh.h`, `gallery/page.py`, `build/<preset>/` and `build/made`.
"""
GOOD = {
    "lib/base/status.h": "", "lib/base/status.c": '#include "base/status.h"\n#include <stdio.h>\n',
    "lib/mesh/mesh.h": '#include "base/status.h"\n', "lib/mesh/mesh.c": '#include "mesh/mesh.h"\n#include "fan.h"\n',
    "lib/mesh/fan.h": "", "lib/tables/gauss.h": '#include "base/status.h"\n', "lib/api/api.c": '#  include "tables/gauss.h"\n',
    "py/__init__.py": '"""All."""\n', "py/start.py": "from .ui import panel\nimport py.core.job\n",
    "py/binding/abi.py": "import ctypes\n", "py/core/job.py": "from ..binding import abi\n",
    "py/ui/panel.py": "from . import panel\ndef f():\n    from ..core.job import run\n", "py/render/studio.py": "", "py/ui/__init__.py": "", "py/ui.py": "",
    "gallery/page.py": "from py.binding.abi import X\n", "gallery/__init__.py": "",
}
# What is changed in the good tree, and the sentences that must be said of it, all of them.
CASES = {
    "a good tree": ({}, []),
    "a file that an editor left": ({"lib/mesh/fan.c.orig": ""}, ["lib/mesh/fan.c.orig: is neither a source nor a description of a build"]),
    "against the flow": ({"lib/base/status.c": '#include "mesh/fan.h"\n'},
                         ["lib/base/status.c: includes mesh/fan.h, which comes later"]),
    "between folders of one step": ({"lib/mesh/fan.h": '#include "tables/gauss.h"\n'},
                                    ["lib/mesh/fan.h: includes tables/gauss.h, which is not before it in the flow"]),
    "a cycle of headers": ({"lib/mesh/fan.h": '#include "mesh.h"\n'},
                           ["lib/mesh/mesh.c: closes a cycle: lib/mesh/fan -> lib/mesh/mesh -> lib/mesh/fan"]),
    "a header that is not there": ({"lib/mesh/fan.h": '#include "mesh/none.h"\n'},
                                   ["lib/mesh/fan.h: includes mesh/none.h, which is not there"]),
    "a file without a name in the map": ({"lib/mesh/ring.c": ""},
                                         ["lib/mesh/ring.c: the map in CONTRIBUTING.md does not name it"]),
    "a folder outside the flow": ({"py/new/more.py": ""},
                                  ["py/new/more.py: the map in CONTRIBUTING.md does not name it",
                                   "py/new/more.py: the flow in CONTRIBUTING.md does not name its folder"]),
    "a name without a file": ({"lib/mesh/fan.h": None, "lib/mesh/mesh.c": ""},
                              ["CONTRIBUTING.md: the map names lib/mesh/fan, which is not there"]),
    "a file that only the text names": ({"gallery/page.py": None, "gallery/__init__.py": ""},
                                        ["CONTRIBUTING.md: names gallery/page.py, which is not there",
                                         "CONTRIBUTING.md: the map names gallery/page, which is not there"]),
    "a folder without files": ({"lib/tables/gauss.h": None, "lib/api/api.c": ""},
                               ["CONTRIBUTING.md: the map names lib/tables/gauss, which is not there",
                                "CONTRIBUTING.md: the flow names lib/tables, which holds no source"]),
    "Python against the flow": ({"py/binding/abi.py": "from ..core import job\n", "py/core/job.py": ""},
                                ["py/binding/abi.py: imports ..core.job, which comes later"]),
    "Python between siblings": ({"py/render/studio.py": "if 0:\n    from ..ui.panel import x\n"},
                                ["py/render/studio.py: imports ..ui.panel, which is not before it in the flow"]),
    "Python across packages": ({"gallery/page.py": "import py.core.job\n"},
                               ["gallery/page.py: imports py.core.job, which is not before it in the flow"]),
    "a cycle in Python": ({"py/binding/abi.py": "from . import more\n", "py/binding/more.py": "from .abi import X\n"},
                          ["py/binding/more.py: the map in CONTRIBUTING.md does not name it",
                           "py/binding/more.py: closes a cycle: py/binding/abi -> py/binding/more -> py/binding/abi"]),
}


def said_of(changes: dict[str, str | None]) -> list[str]:
    """Sentences on the good tree with these files changed, or left out."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        (root / "CONTRIBUTING.md").write_text(GUIDE)
        for name, text in {**GOOD, **changes}.items():
            if text is not None:
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
        return flow.check(root)[1]


def main() -> int:
    """Every case."""
    failed = 0
    for name, (changes, wanted) in CASES.items():
        said = said_of(changes)
        if said != wanted:
            failed += 1
            print(f"test_flow: {name}:\n  expected {wanted}\n  got      {said}")
    print(f"{len(CASES) - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())

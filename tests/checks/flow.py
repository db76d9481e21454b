# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the sources keep to the flow and to the map in CONTRIBUTING.md: python3 tests/checks/flow.py [ROOT].

The block ```flow of CONTRIBUTING.md has chains of folders, such as "libcurvopt/src: base -> linalg -> mesh"; a comma
separates folders of one step, "." is the folder in front of the colon, and a line that begins with "->" goes on with the one
above. A file may use its own folder and those that stand before it in a chain. The block ```map names the modules of every folder. A module is NAME.c and NAME.h, or NAME.py.

Failures: a file of another kind in a folder of the flow, an include or import against the flow, a cycle of modules, a source
file that the map does not name, a name without a file, there or in `quotes` elsewhere in CONTRIBUTING.md. Imports count
wherever they stand in a file; modules that Python loads by a computed name are not seen. Prints "file: includes X, which
comes later" and the like, and "N passed, N failed" (files without and sentences).
"""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

KINDS = (".c", ".h", ".py", ".typed", ".txt", ".toml")  # what may lie in a folder of the flow
Edges = dict[str, dict[str, str]]  # module -> module that it uses -> the file that does


def block(text: str, name: str) -> list[str]:
    """Lines of the fenced block of that name, without empty ones."""
    found = re.search(rf"^```{name}\n(.*?)^```", text, re.M | re.S)
    return [line for line in found[1].splitlines() if line.strip()] if found else []


def read_flow(text: str) -> dict[str, set[str]]:
    """Folder -> folders that it may use; its own is among them."""
    allowed: dict[str, set[str]] = {}
    for line in "\n".join(block(text, "flow")).replace("\n->", " ->").splitlines():
        prefix, _, chain = line.strip().rpartition(":")
        before: set[str] = set()
        for step in chain.split("->"):
            names = [name.strip() for name in step.split(",")]
            here = {"/".join(filter(None, (prefix.strip(), "" if name == "." else name))) for name in names}
            for folder in here:
                allowed.setdefault(folder, {folder}).update(before)
            before |= here
    return allowed


def read_map(text: str) -> set[str]:
    """Modules, as "folder/name": a line that ends its first word with "/" is a folder, an indented one a module in it."""
    modules, folder = set(), ""
    for line in block(text, "map"):
        if line[0] != " ":
            folder = line.split()[0].rstrip("/")
        else:
            modules.add(f"{folder}/{line.split()[0]}")
    return modules


def module_of(path: str) -> str:
    """File -> module; a package's __init__.py is the folder's."""
    return path.rpartition(".")[0]


def includes(root: Path, path: Path, folders: list[str]) -> list[tuple[str, str | None]]:
    """What a C file includes in quotes: as it is written there, and the file, or None."""
    found = []
    for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', path.read_text(), re.M):
        places = [path.parent, *(root / folder / up for folder in folders for up in (".", ".."))]
        files = [(place / name).resolve() for place in places if (place / name).is_file()]
        found.append((name, str(files[0].relative_to(root)) if files else None))
    return found


def imports(root: Path, path: Path) -> list[tuple[str, str | None]]:
    """What a Python file imports from the sources: as it is written there, and the file. Packages lie in the root, as addon,
    or beside the file's own, as gallery."""
    found = []
    tops = {root, path.parent.parent}
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            wanted = [(a.name, top / a.name.replace(".", "/")) for a in node.names for top in tops]
        elif isinstance(node, ast.ImportFrom):
            dots, inner = "." * node.level + (node.module or ""), (node.module or "").replace(".", "/")
            wanted = []
            for base in [path.parents[node.level - 1] / inner] if node.level else [top / inner for top in tops]:
                wanted += [(f"{dots}{'.' if node.module else ''}{a.name}", base / a.name) for a in node.names] + [(dots, base)]
        else:
            continue
        for name, place in wanted:
            files = [file for file in (place / "__init__.py", place.with_name(place.name + ".py")) if file.is_file()]
            if files and files[0] != path:
                found.append((name, str(files[0].relative_to(root))))
    return found


def cycles(edges: Edges) -> list[list[str]]:
    """One cycle, as modules in order, for each edge that closes one in a walk in depth."""
    found, done = [], set()

    def walk(module: str, trail: list[str]) -> None:
        for used in sorted(edges.get(module, {})):
            if used in trail:
                found.append([*trail[trail.index(used):], used])
            elif used not in done:
                walk(used, [*trail, used])
        done.add(module)

    for module in sorted(edges):
        if module not in done:
            walk(module, [module])
    return found


def check(root: Path) -> tuple[int, list[str]]:
    """Number of source files, and a sentence for everything that is wrong."""
    text = (root / "CONTRIBUTING.md").read_text()
    allowed, named = read_flow(text), read_map(text)
    tops = sorted({folder.split("/")[0] for folder in allowed})
    paths = sorted(p for top in tops for kind in ("c", "h", "py") for p in (root / top).rglob(f"*.{kind}"))
    paths = [p for p in paths if any(str(p.relative_to(root)).startswith(folder + "/") for folder in allowed)]
    edges, seen, used_folders = {}, set(), set()
    places = [root / folder for folder in sorted(allowed) if (root / folder).is_dir()]
    wrong = [f"{p.relative_to(root)}: is neither a source nor a description of a build"
             for place in places for p in sorted(place.iterdir()) if p.is_file() and p.suffix not in KINDS]
    for path in paths:
        file = str(path.relative_to(root))
        folder, module = file.rpartition("/")[0], module_of(file)
        used_folders.add(folder)
        seen.add(module)
        if module not in named and path.name != "__init__.py":
            wrong.append(f"{file}: the map in CONTRIBUTING.md does not name it")
        if folder not in allowed:
            wrong.append(f"{file}: the flow in CONTRIBUTING.md does not name its folder")
            continue
        python = path.suffix == ".py"
        uses = imports(root, path) if python else includes(root, path, sorted(allowed))
        for name, target in dict.fromkeys(uses):
            does = "imports" if python else "includes"
            if target is None:
                wrong.append(f"{file}: {does} {name}, which is not there")
                continue
            there = target.rpartition("/")[0]
            if module_of(target) != module and not target.endswith("__init__.py"):
                edges.setdefault(module, {}).setdefault(module_of(target), file)
            if there not in allowed[folder]:
                later = folder in allowed.get(there, ())
                wrong.append(f"{file}: {does} {name}, which {'comes later' if later else 'is not before it in the flow'}")
    for ring in cycles(edges):
        wrong.append(f"{edges[ring[-2]][ring[-1]]}: closes a cycle: {' -> '.join(ring)}")
    quoted = re.findall(r"`((?:[a-z_]+|\.ci)/[a-z_/.0-9-]*[a-z_/])`", text)
    kept = [name for name in dict.fromkeys(quoted) if not name.startswith("build/")]  # what a build makes is there or not
    wrong += [f"CONTRIBUTING.md: names {name}, which is not there" for name in kept if not (root / name).exists()]
    wrong += [f"CONTRIBUTING.md: the map names {name}, which is not there" for name in sorted(named - seen)]
    wrong += [f"CONTRIBUTING.md: the flow names {name}, which holds no source" for name in sorted(allowed.keys() - used_folders)]
    return len(paths), wrong


def main() -> int:
    """As the module says."""
    n_files, wrong = check(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve())
    print("".join(sentence + "\n" for sentence in wrong), end="")
    if n_files == 0:
        wrong.append("")
        print("flow: found no source file")
    clean = n_files - len({sentence.partition(":")[0] for sentence in wrong} - {"CONTRIBUTING.md"})
    print(f"{max(clean, 0)} passed, {len(wrong)} failed")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())

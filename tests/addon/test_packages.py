# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's layout: the list in addon/__init__.py is complete, imports follow it, and both zips hold all of it."""

import ast
import io
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "addon"


def listed():
    """Modules such as "core.job" in the order of the list in addon/__init__.py."""
    package, found = "", []
    for line in ast.get_docstring(ast.parse((ADDON / "__init__.py").read_text())).split("\n"):
        if match := re.match(r"(\w+)/ ", line):
            package = match.group(1)
        elif match := re.match(r"    (\w+) ", line):
            found.append(f"{package}.{match.group(1)}")
    return found


ORDER = listed()


def path_of(module):
    return ADDON / (module.replace(".", "/") + ".py")


def imported(module):
    """Modules of the add-on that `module` imports anywhere, also within functions."""
    package, found = module.partition(".")[0], set()
    for node in ast.walk(ast.parse(path_of(module).read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = {1: package, 2: ""}[node.level]
            names = [".".join(filter(None, (base, node.module, alias.name))) for alias in node.names]
            found |= {name if name in ORDER else name.rpartition(".")[0] for name in names}
    return {name for name in found if name.partition(".")[0] != "binding"}  # comes before everything


def test_every_file_is_listed():
    files = {path.relative_to(ADDON).with_suffix("").as_posix().replace("/", ".") for path in ADDON.glob("*/*.py")}
    assert {name for name in files if not name.startswith("presets.") and not name.endswith("__init__")} == set(ORDER)
    assert len(ORDER) == len(set(ORDER)) > 25


@pytest.mark.parametrize("module", ORDER)
def test_imports_follow_the_order(module):
    assert imported(module) <= set(ORDER[: ORDER.index(module)])


def test_binding_and_core_need_no_blender():
    python = shutil.which("python3", path="/usr/bin") or "python3"
    without = [name for name in ORDER if name.startswith("core.")]
    code = f"import sys; import {', '.join('addon.' + name for name in without)}; assert 'bpy' not in sys.modules"
    subprocess.run([python, "-c", code], cwd=ROOT, check=True)


PACKAGE = ROOT / "libcurvopt" / "python" / "curvopt"


def own_files(top):
    """The add-on's files in a zip, without manifest and package."""
    wanted = {path.relative_to(ADDON).as_posix() for path in ADDON.rglob("*.py")}
    shapes = {f"shapes/{path.name}" for path in (ROOT / "blend_files" / "obj").glob("*.obj")}
    return {top + file for file in wanted | shapes | {"LICENSE"}}


def package_in(top):
    """Files of the Python package below `top`."""
    files = {path.name for path in PACKAGE.iterdir() if path.suffix in (".py", ".typed")}
    return {top + name for name in files | {"native/linux-x64/libcurvopt.so"}}


def test_the_zip_for_old_blenders_holds_add_on_and_package_and_nothing_else():
    with zipfile.ZipFile(ROOT / "build" / "release" / "curvopt_addon.zip") as found:
        assert set(found.namelist()) == own_files("curvopt_addon/") | package_in("curvopt_addon/vendor/curvopt/")
        for module in ORDER:
            assert found.read(f"curvopt_addon/{module.replace('.', '/')}.py") == path_of(module).read_bytes(), module


def test_the_extension_holds_add_on_and_wheel_and_no_loose_library():
    with zipfile.ZipFile(ROOT / "build" / "release" / "curvopt_extension.zip") as found:
        (wheel,) = [name for name in found.namelist() if name.startswith("curvopt_addon/wheels/")]
        assert set(found.namelist()) == own_files("curvopt_addon/") | {"curvopt_addon/blender_manifest.toml", wheel}
        listed = wheel.removeprefix("curvopt_addon/")
        assert f'wheels = ["./{listed}"]' in found.read("curvopt_addon/blender_manifest.toml").decode()
        with zipfile.ZipFile(io.BytesIO(found.read(wheel))) as inside:
            info = {f"{name.split('/')[1]}" for name in inside.namelist() if ".dist-info/" in name}
            assert info == {"METADATA", "WHEEL", "RECORD", "LICENSE"}
            assert {n for n in inside.namelist() if ".dist-info/" not in n} == package_in("curvopt/")

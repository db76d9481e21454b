# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the add-on as a user does, in a fresh Blender in background, and presses Minimize.

    blender -b --factory-startup --online-mode --python-exit-code 1 -P install_in_blender.py -- legacy ZIP
    blender -b --factory-startup --python-exit-code 1 -P install_in_blender.py -- mistaken EXTENSION ZIP
    blender -b --factory-startup --online-mode --python-exit-code 1 -P install_in_blender.py -- from_disk EXTENSION [FOREIGN]
    blender -b --factory-startup --online-mode --python-exit-code 1 -P install_in_blender.py -- repository URL FOLDER NEWER

`legacy`: installs the zip, presses, tries to switch on another copy of it, removes it. `mistaken`: installs an extension in a
Blender that knows no extensions, then the right zip. `from_disk`: installs the extension FOREIGN of another system, which Blender
refuses, then that of this one, presses, removes. `repository`: subscribes to URL, which serves FOLDER; installs, presses,
replaces the contents of FOLDER by those of NEWER, updates while a run is on, presses, removes while a run is on. Last line:
"N passed, N failed".
"""

import importlib
import shutil
import sys
from pathlib import Path

import addon_utils
import bpy

passed = failed = 0


def check(name: str, right: bool) -> None:
    """Count one statement."""
    global passed, failed
    passed, failed = passed + bool(right), failed + (not right)
    if not right:
        print(f"FAIL: {name}")


def part(addon: str, name: str) -> object:
    """A module of the installed add-on."""
    return importlib.import_module(f"{addon}.{name}")


def press(addon: str, version: str) -> None:
    """The first press of Minimize on a cube, with the library that was installed and no other."""
    bpy.ops.mesh.primitive_cube_add()
    before = len(bpy.data.objects)
    bpy.context.scene.curvopt.strength = 1.0
    check(f"{addon} {version}: the press ends", bpy.ops.curvopt.minimize() == {"FINISHED"})
    check(f"{addon} {version}: there is a new object", len(bpy.data.objects) == before + 1)
    points = [v.co.length for v in bpy.context.active_object.data.vertices]
    check(f"{addon} {version}: which is round", max(points) / min(points) < 1.25)
    package = part(addon, "binding")
    check(f"{addon}: its package has its version", package.VERSION == version)
    where = str(part(addon, "binding.library").load().path)
    inside = ("vendor", "site-packages", ".local")
    check(f"{addon}: the library is the installed one, not {where}", "native" in where and any(x in where for x in inside))
    print(f"pressed with {where}")


def start_run(addon: str) -> object:
    """A long run, as the modal operator starts it; its job."""
    job, cage = part(addon, "core.job"), part(addon, "core.catalogue").load("lawson_g2")
    operators = part(addon, "ui.operators")
    work = job.Job.minimize(cage, job.Request(energy="mvs", levels=5))
    operators._run = job.ModalRun(work, "MVS")
    check("a run is on", work.running)
    return work


def refused_twice(folder: Path) -> None:
    """A second Curvopt beside the one that is on, under another name, is not switched on, and changes nothing."""
    second = folder.with_name("curvopt_second")
    shutil.copytree(folder, second)
    addon_utils.modules(refresh=True)
    try:
        bpy.ops.preferences.addon_enable(module=second.name)
        said = ""
    except RuntimeError as error:
        said = str(error)
    check(f"a second Curvopt is refused, not: {said}", "Another Curvopt is switched on already: curvopt_addon. Remove" in said)
    check("and is not among those that are on", second.name not in bpy.context.preferences.addons)
    press("curvopt_addon", part("curvopt_addon", "binding").VERSION)
    shutil.rmtree(second)


def legacy(zip_file: str) -> None:
    """The zip for Blender 3.4 to 4.1."""
    bpy.ops.preferences.addon_install(filepath=zip_file)
    check("the add-on is enabled", addon_utils.enable("curvopt_addon", default_set=True) is not None)
    press("curvopt_addon", part("curvopt_addon", "binding").VERSION)
    folder = Path(sys.modules["curvopt_addon"].__file__).parent
    refused_twice(folder)
    work = start_run("curvopt_addon")
    addon_utils.disable("curvopt_addon", default_set=True)
    check("switched off while it runs, the run has ended", not work.running)
    shutil.rmtree(folder)
    check("and its files are gone", not folder.exists())


def mistaken(extension: str, zip_file: str) -> None:
    """Blender 4.1 and older take an extension for an add-on."""
    bpy.ops.preferences.addon_install(filepath=extension)
    folder = Path(bpy.utils.user_resource("SCRIPTS", path="addons"))
    check("it lies in one folder", [path.name for path in folder.iterdir()] == ["curvopt_addon"])
    try:
        bpy.ops.preferences.addon_enable(module="curvopt_addon")
        said = ""
    except RuntimeError as error:
        said = str(error)
    check(f"it says what to do, not: {said}", "install the zip of version" in said and "this version of Blender" in said)
    bpy.ops.preferences.addon_install(filepath=zip_file)
    check("the right zip takes its place", addon_utils.enable("curvopt_addon", default_set=True) is not None)
    press("curvopt_addon", part("curvopt_addon", "binding").VERSION)


def from_disk(extension: str, *foreign: str) -> None:
    """Install from Disk, in Blender 4.2 and later."""
    number = next(i for i, repo in enumerate(bpy.context.preferences.extensions.repos) if repo.module == "user_default")
    place = Path(bpy.context.preferences.extensions.repos[number].directory) / "curvopt"
    for other in foreign:
        bpy.ops.extensions.package_install_files(filepath=other, repo="user_default", enable_on_install=True)
        check("another system's extension is not installed", not place.exists() and not hasattr(bpy.types.Scene, "curvopt"))
    bpy.ops.extensions.package_install_files(filepath=extension, repo="user_default", enable_on_install=True)
    check("this system's is installed", (place / "blender_manifest.toml").is_file())
    press("bl_ext.user_default.curvopt", part("bl_ext.user_default.curvopt", "binding").VERSION)
    bpy.ops.extensions.package_uninstall(repo_index=number, pkg_id="curvopt")
    check("and its files are gone", not place.exists() and not hasattr(bpy.types.Scene, "curvopt"))


def repository(url: str, folder: str, newer: str) -> None:
    """The static repository, from a local address."""
    bpy.ops.preferences.extension_repo_add(name="Curvopt", remote_url=url, type="REMOTE")
    repos = bpy.context.preferences.extensions.repos
    number = next(i for i, repo in enumerate(repos) if repo.remote_url == url)
    name = f"bl_ext.{repos[number].module}.curvopt"
    place = Path(repos[number].directory) / "curvopt"
    bpy.ops.extensions.repo_sync(repo_index=number)
    bpy.ops.extensions.package_install(repo_index=number, pkg_id="curvopt", enable_on_install=True)
    check("it is installed", (place / "blender_manifest.toml").is_file())
    check("and enabled", hasattr(bpy.types.Scene, "curvopt"))
    press(name, part(name, "binding").VERSION)

    old, work = part(name, "binding").VERSION, start_run(name)
    shutil.rmtree(folder)
    shutil.copytree(newer, folder)
    bpy.ops.extensions.repo_sync(repo_index=number)
    bpy.ops.extensions.package_upgrade_all()
    check("updated while it runs, the run has ended", not work.running)
    new = part(name, "binding").VERSION
    check(f"the version has changed from {old} to {new}", new != old)
    press(name, new)

    work = start_run(name)
    bpy.ops.extensions.package_uninstall(repo_index=number, pkg_id="curvopt")
    check("removed while it runs, the run has ended", not work.running)
    check("and its files are gone", not place.exists() and not hasattr(bpy.types.Scene, "curvopt"))


arguments = sys.argv[sys.argv.index("--") + 1 :]
{"legacy": legacy, "mistaken": mistaken, "from_disk": from_disk, "repository": repository}[arguments[0]](*arguments[1:])
print(f"{bpy.app.version_string}: {passed} passed, {failed} failed")
sys.exit(failed > 0)

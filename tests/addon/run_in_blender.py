# SPDX-License-Identifier: GPL-3.0-or-later
"""Run tests/addon/blender inside a real Blender in background, with the add-on installed for the occasion.

    python3 run_in_blender.py [--blender PROGRAM] [--addon FOLDER|ZIP | --extension ZIP] [--deal K/N] [pytest arguments ...]

The add-on goes into a temporary user folder (a zip by Blender's own installer), so nothing of the user's Blender is
touched. As an extension it has another name, which the tests are told. --deal: every N-th test, from the K-th on. The
exit code is pytest's. The same file, run by Blender, is the inner half.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NAME = "curvopt"  # of the installed add-on
ZIP_VARIABLE = "CURVOPT_TEST_ZIP"
EXTENSION_VARIABLE = "CURVOPT_TEST_EXTENSION"
DEAL_VARIABLE = "CURVOPT_TEST_DEAL"
NAME_VARIABLE = "CURVOPT_TEST_NAME"  # for the tests: what the add-on is called
EXTENSION_NAME = f"bl_ext.user_default.{NAME}"


def install_folder(source: Path, scripts: Path) -> Path:
    """Copy the add-on to where Blender looks for it, with the newest built library inside; its place."""
    place = scripts / "addons" / NAME
    shutil.copytree(source, place, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "blend_files" / "obj", place / "shapes", dirs_exist_ok=True)
    package = place / "vendor" / "curvopt"
    shutil.copytree(ROOT / "libcurvopt" / "python" / "curvopt", package, ignore=shutil.ignore_patterns("__pycache__"))
    library = package / "native" / "linux-x64" / "libcurvopt.so"
    built = Path(os.environ.get("CURVOPT_LIBRARY") or ROOT / "build" / "release" / "libcurvopt.so")
    library.parent.mkdir(parents=True)
    shutil.copy(built, library)
    return place


def blender_environment(scripts: Path, extra: dict[str, str]) -> dict[str, str]:
    """The environment of a Blender that knows only the add-ons in `scripts`. The system's programs come first: Debian's
    Blender takes its Python's library from beside the first python3 on PATH, which may be another version's."""
    env = {k: v for k, v in os.environ.items() if k not in ("CURVOPT_LIBRARY", "PYTHONPATH")}
    env["PATH"] = f"/usr/bin{os.pathsep}{env['PATH']}"
    return {**env, "BLENDER_USER_SCRIPTS": str(scripts), "PYTHONDONTWRITEBYTECODE": "1", **extra}


def outer() -> int:
    parser = argparse.ArgumentParser(description="Run the add-on's tests inside Blender.")
    parser.add_argument("--blender", default=os.environ.get("BLENDER", "blender"))
    parser.add_argument("--addon", type=Path, default=ROOT / "addon")
    parser.add_argument("--extension", type=Path)
    parser.add_argument("--deal", default="1/1")
    options, pytest_arguments = parser.parse_known_args()
    with tempfile.TemporaryDirectory(prefix="curvopt-test-") as folder:
        scripts, extra = Path(folder) / "scripts", {DEAL_VARIABLE: options.deal}
        (scripts / "addons").mkdir(parents=True)
        if options.extension is not None:
            extra[EXTENSION_VARIABLE] = str(options.extension.resolve())
            extra["BLENDER_USER_EXTENSIONS"] = str(Path(folder) / "extensions")
        elif options.addon.is_dir():
            install_folder(options.addon, scripts)
        else:
            extra[ZIP_VARIABLE] = str(options.addon.resolve())
        command = [options.blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P", __file__, "--"]
        return subprocess.run([*command, *pytest_arguments], env=blender_environment(scripts, extra)).returncode


def inner(arguments: list[str]) -> int:
    import addon_utils
    import bpy
    import pytest

    name = NAME
    if ZIP_VARIABLE in os.environ:
        name = "curvopt_addon"
        bpy.ops.preferences.addon_install(filepath=os.environ[ZIP_VARIABLE])
    if EXTENSION_VARIABLE in os.environ:
        name = EXTENSION_NAME
        bpy.ops.extensions.package_install_files(filepath=os.environ[EXTENSION_VARIABLE], repo="user_default")
    if addon_utils.enable(name, default_set=True) is None or not hasattr(bpy.types.Scene, "curvopt"):
        print("The add-on could not be enabled.", file=sys.stderr)
        return 1
    os.environ[NAME_VARIABLE] = name
    return int(pytest.main(["-p", "no:cacheprovider", "--rootdir", str(HERE), str(HERE / "blender"), *arguments]))


if __name__ == "__main__":
    inside = "bpy" in sys.modules
    sys.exit(inner(sys.argv[sys.argv.index("--") + 1 :]) if inside else outer())

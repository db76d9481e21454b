#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs what users get out of finished builds; the same sources and builds give the same bytes.

    python3 libcurvopt/packaging/make_dist.py addon BUILD     BUILD/curvopt_addon.zip, BUILD/curvopt_extension.zip: this
                                                              build's platform only
    python3 libcurvopt/packaging/make_dist.py dist BUILD      everything, in BUILD/dist/
    python3 libcurvopt/packaging/make_dist.py versions        whether every file names the version of CMakeLists.txt

In dist/: a wheel per platform; `extensions/`, a static repository for Blender 4.2 and later (index.json and an extension zip
per platform, each with the wheel inside); one zip for Blender 3.4 to 4.1 with the libraries of all platforms; the source
archive of the commit; CHANGELOG.md; SHA256SUMS. A platform is packed where its build exists (PLATFORMS); the others are named.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
import shutil
import subprocess
import sys
import zipfile
from io import BytesIO
from pathlib import Path
from platform import machine
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "libcurvopt" / "python" / "curvopt"
DATE = (1980, 1, 1, 0, 0, 0)  # of every file in a zip: the earliest that the format knows


class Platform(NamedTuple):
    """A platform by Blender's name: the wheel's tag (PEP 425, PEP 600), the library's file, the preset that builds it,
    and whether our tests run there."""

    name: str
    tag: str
    library: str
    preset: str
    is_run: bool = True


PLATFORMS = (
    Platform("linux-x64", "manylinux_2_17_x86_64", "libcurvopt.so", "release"),
    Platform("linux-arm64", "manylinux_2_17_aarch64", "libcurvopt.so", "linux-arm64"),
    Platform("windows-x64", "win_amd64", "curvopt.dll", "windows-x64"),
    Platform("macos-arm64", "macosx_11_0_arm64", "libcurvopt.dylib", "macos-arm64", is_run=False),
    Platform("macos-x64", "macosx_11_0_x86_64", "libcurvopt.dylib", "macos-x64", is_run=False),
)
NOT_RUN = (  # goes beside the library
    "Built, not run: the library for this system is compiled and checked from outside, but no machine of ours can run it.\n"
    "Please tell us whether it works.\n"
)
Files = dict[str, bytes]  # path in an archive -> contents


# -------------------------------------------------------------------------------------------------------- versions --


def version() -> str:
    """The version, from the root CMakeLists.txt: the one place that decides."""
    return re.search(r"project\(curvopt VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


_COPIES = {
    "addon/__init__.py": r'"version": \((\d+, \d+, \d+)\)',
    "addon/binding/__init__.py": r'^VERSION = "(.*?)"',
    "addon/blender_manifest.toml": r'^version = "(.*?)"',
    "libcurvopt/python/curvopt/version.py": r'^VERSION = "(.*?)"',
    "CHANGELOG.md": r"^## (\S+)",
    "libcurvopt/packaging/debian/changelog": r"^curvopt \(([^)-]*)",
}


def wrong_versions() -> list[str]:
    """A sentence for each file that names another version."""
    wanted, wrong = version(), []
    for file, pattern in _COPIES.items():
        found = re.search(pattern, (ROOT / file).read_text(), re.MULTILINE)
        here = found[1].replace(", ", ".") if found else "none"
        if here != wanted:
            wrong.append(f"{file} names version {here}, but CMakeLists.txt {wanted}: change it there.")
    header = (ROOT / "libcurvopt/include/curvopt.h").read_text()
    numbers = ".".join(re.search(rf"VERSION_{part} (\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH"))
    if numbers != wanted:
        wrong.append(f"curvopt.h names version {numbers}, but CMakeLists.txt {wanted}: change it there.")
    return wrong


# -------------------------------------------------------------------------------------------------------- archives --


def zipped(files: Files) -> bytes:
    """A zip: files in order of their paths, with one date and one mode each."""
    out = BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for path in sorted(files):
            info = zipfile.ZipInfo(path, DATE)
            info.create_system, info.compress_type = 3, zipfile.ZIP_DEFLATED  # 3: Unix, wherever this runs
            native = path.endswith((".so", ".dll", ".dylib"))
            info.external_attr = (0o100755 if native else 0o100644) << 16
            archive.writestr(info, files[path], compresslevel=9)
    return out.getvalue()


def package_files(top: str) -> Files:
    """The Python package without a library."""
    return {f"{top}{path.name}": path.read_bytes() for path in PACKAGE.iterdir() if path.suffix in (".py", ".typed")}


def addon_files(top: str = "") -> Files:
    """Every .py file of the add-on, the cages of its catalogue, the licence."""
    addon, shapes = ROOT / "addon", ROOT / "blend_files" / "obj"
    files = {f"{top}{path.relative_to(addon).as_posix()}": path.read_bytes() for path in addon.rglob("*.py")}
    files.update({f"{top}shapes/{path.name}": path.read_bytes() for path in shapes.glob("*.obj")})
    files[f"{top}LICENSE"] = (ROOT / "LICENSE").read_bytes()
    return files


def library_files(top: str, platform: Platform, library: bytes) -> Files:
    """A platform's folder of the package: the library, and what is to be known of it."""
    folder = f"{top}native/{platform.name}/"
    files = {folder + platform.library: library}
    if not platform.is_run:
        files[folder + "BUILT_NOT_RUN.txt"] = NOT_RUN.encode()
    return files


def wheel(platform: Platform, library: bytes) -> tuple[str, bytes]:
    """File name and contents of a platform's wheel."""
    tag, info = f"py3-none-{platform.tag}", f"curvopt-{version()}.dist-info/"
    files = {**package_files("curvopt/"), **library_files("curvopt/", platform, library)}
    files[info + "METADATA"] = (
        f"Metadata-Version: 2.1\nName: curvopt\nVersion: {version()}\n"
        "Summary: Minimize curvature energies (Willmore, MVS, MVS_cross) of Catmull-Clark surfaces\n"
        "Author: The curvopt authors\nLicense: GPL-3.0-or-later\n"
        "Classifier: License :: OSI Approved :: GNU General Public License v3 or later (GPLv3+)\n"
        "Classifier: Programming Language :: Python :: 3\nClassifier: Topic :: Scientific/Engineering :: Mathematics\n"
        "Requires-Python: >=3.9\nRequires-Dist: numpy\nDescription-Content-Type: text/markdown\n\n"
        + ("" if platform.is_run else NOT_RUN + "\n")
        + (PACKAGE.parent / "README.md").read_text()
    ).encode()
    files[info + "WHEEL"] = f"Wheel-Version: 1.0\nGenerator: curvopt\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[info + "LICENSE"] = (ROOT / "LICENSE").read_bytes()
    rows = []
    for path in sorted(files):
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[path]).digest()).rstrip(b"=").decode()
        rows.append(f"{path},sha256={digest},{len(files[path])}\n")
    files[info + "RECORD"] = "".join([*rows, f"{info}RECORD,,\n"]).encode()
    return f"curvopt-{version()}-{tag}.whl", zipped(files)


def manifest(platform: Platform, wheel_name: str) -> str:
    """blender_manifest.toml of a platform's extension."""
    text = (ROOT / "addon" / "blender_manifest.toml").read_text()
    return f'{text}platforms = ["{platform.name}"]\nwheels = ["./wheels/{wheel_name}"]\n'


def extension(platform: Platform, library: bytes) -> bytes:
    """A platform's extension zip: a folder with the add-on and the wheel, no loose library. Without the folder Blender 4.1 and
    older would scatter the files among other add-ons, and say nothing; with it they list the add-on, which says what to do."""
    name, contents = wheel(platform, library)
    top = "curvopt_addon/"  # as in the zip for those Blenders, which replaces it
    files = addon_files(top)
    files[f"{top}blender_manifest.toml"] = manifest(platform, name).encode()
    files[f"{top}wheels/{name}"] = contents
    return zipped(files)


def legacy(libraries: dict[Platform, bytes]) -> bytes:
    """The zip for Blender 3.4 to 4.1: a folder with the package and the libraries of these platforms. It does not have the
    package's name: a package `curvopt` on Python's path would be loaded in its place."""
    files = {**addon_files("curvopt_addon/"), **package_files("curvopt_addon/vendor/curvopt/")}
    for platform, library in libraries.items():
        files.update(library_files("curvopt_addon/vendor/curvopt/", platform, library))
    return zipped(files)


def index(zips: dict[str, tuple[Platform, bytes]]) -> bytes:
    """index.json of a static repository, as `blender --command extension server-generate` writes it."""
    data = []
    for name, (platform, contents) in sorted(zips.items()):
        item = _read_manifest(manifest(platform, ""))
        del item["wheels"]
        item.update(
            archive_url=f"./{name}",
            archive_size=len(contents),
            archive_hash=f"sha256:{hashlib.sha256(contents).hexdigest()}",
            python_versions=["3"],  # from the wheel's tag py3
        )
        data.append(item)
    return (json.dumps({"version": "v1", "blocklist": [], "data": data}, indent=2) + "\n").encode()


def _read_manifest(text: str) -> dict[str, object]:
    """Keys of a manifest whose values are strings and lists of strings, which JSON and TOML write alike."""
    return {key: json.loads(value) for key, value in re.findall(r"^(\w+) = (.*)$", text, re.MULTILINE)}


def source() -> bytes | None:
    """The source archive of the commit that is checked out; None without git."""
    prefix = f"curvopt-{version()}/"
    command = ["git", "-C", str(ROOT), "archive", "--format=tar", f"--prefix={prefix}", "HEAD"]
    try:
        tar = subprocess.run(command, check=True, capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    return gzip.compress(tar, 9, mtime=0)


# -------------------------------------------------------------------------------------------------------- commands --


def platform_of(build: Path) -> Platform:
    """What a build is for: a cross build's folder has its preset's name; any other build is for this machine."""
    crossed = [platform for platform in PLATFORMS if platform.preset == build.name]
    arm = machine() in ("aarch64", "arm64")
    return crossed[0] if crossed and crossed[0].preset != "release" else PLATFORMS[1 if arm else 0]


def how_to_build(preset: str) -> str:
    """A sentence."""
    presets = json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]
    if any(each["name"] == preset for each in presets):
        return f"It is built by: cmake --preset {preset} && cmake --build build/{preset} (CONTRIBUTING.md: what that needs)"
    return "No preset builds it yet."


def found_libraries(build: Path) -> dict[Platform, bytes]:
    """The library of each platform that has been built: this build's, and those of the presets."""
    found, own = {}, platform_of(build)
    for platform in PLATFORMS:
        folder = build if platform is own else ROOT / "build" / platform.preset
        if (folder / platform.library).is_file():
            found[platform] = (folder / platform.library).read_bytes()
    return found


def make_addon(build: Path) -> None:
    """The two zips of this build's platform beside the library."""
    platform = platform_of(build)
    library = (build / platform.library).read_bytes()
    (build / "curvopt_addon.zip").write_bytes(legacy({platform: library}))
    (build / "curvopt_extension.zip").write_bytes(extension(platform, library))


def make_dist(build: Path) -> None:
    """Everything, into an empty dist/."""
    libraries, dist, made = found_libraries(build), build / "dist", {}
    zips = {}
    for platform, library in libraries.items():
        name, contents = wheel(platform, library)
        made[name] = contents
        zips[f"curvopt-{version()}-{platform.name.replace('-', '_')}.zip"] = (platform, extension(platform, library))
    made.update({f"extensions/{name}": contents for name, (_, contents) in zips.items()})
    made["extensions/index.json"] = index(zips)
    made[f"curvopt-{version()}-blender-3.4-to-4.1.zip"] = legacy(libraries)
    made["CHANGELOG.md"] = (ROOT / "CHANGELOG.md").read_bytes()
    archive = source()
    if archive is None:
        print("dist: left out the source archive: this is no git checkout.")
    else:
        made[f"curvopt-{version()}.tar.gz"] = archive
    sums = "".join(f"{hashlib.sha256(contents).hexdigest()}  {name}\n" for name, contents in sorted(made.items()))
    shutil.rmtree(dist, ignore_errors=True)
    for name, contents in {**made, "SHA256SUMS": sums.encode()}.items():
        (dist / name).parent.mkdir(parents=True, exist_ok=True)
        (dist / name).write_bytes(contents)
        print(f"dist: {len(contents):>10}  {name}")
    for platform in PLATFORMS:
        if platform in libraries and not platform.is_run:
            print(f"dist: {platform.name} is built, not run: nothing here can run it.")
        if platform not in libraries:
            print(
                f"dist: left out {platform.name}: there is no build/{platform.preset}/{platform.library}. "
                + how_to_build(platform.preset)
            )


def main() -> int:
    """As the module says."""
    command, build = (sys.argv[1:2] or [""])[0], Path(sys.argv[2] if len(sys.argv) > 2 else "build/release").resolve()
    if command not in ("addon", "dist", "versions"):
        print(__doc__, file=sys.stderr)
        return 2
    wrong = wrong_versions()
    for sentence in wrong:
        print(f"{command}: {sentence}", file=sys.stderr)
    if not wrong and command != "versions":
        (make_addon if command == "addon" else make_dist)(build)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())

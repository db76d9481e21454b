# SPDX-License-Identifier: GPL-3.0-or-later
"""What `--target dist` makes: the same bytes twice, wheels that pip takes, one version; and what bad installs are told."""

import base64
import hashlib
import io
import json
import os
import shutil
import stat
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import make_dist

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
DIST = BUILD / "dist"
VERSION = make_dist.version()


@pytest.fixture(scope="module", autouse=True)
def dist():
    """Built once for this file."""
    subprocess.run(["cmake", "--build", str(BUILD), "--target", "dist"], check=True, capture_output=True)


@pytest.fixture
def wheel():
    return DIST / f"curvopt-{VERSION}-py3-none-manylinux_2_17_x86_64.whl"


def everything():
    return {path.relative_to(DIST).as_posix(): path.read_bytes() for path in DIST.rglob("*") if path.is_file()}


def test_every_file_names_the_same_version():
    assert make_dist.wrong_versions() == []


def test_a_wrong_version_is_named_with_its_file(monkeypatch):
    monkeypatch.setattr(make_dist, "version", lambda: "9.9.9")
    assert len(make_dist.wrong_versions()) == len(make_dist._COPIES) + 1


def test_the_same_bytes_twice():
    first = everything()
    subprocess.run([sys.executable, "-B", ROOT / "libcurvopt/packaging/make_dist.py", "dist", str(BUILD)], check=True)
    assert everything() == first


def test_checksums_are_of_all_files():
    lines = dict(reversed(line.split("  ")) for line in (DIST / "SHA256SUMS").read_text().splitlines())
    files = everything()
    del files["SHA256SUMS"]
    assert lines == {name: hashlib.sha256(contents).hexdigest() for name, contents in files.items()}


def test_platforms_without_a_build_are_named(tmp_path):
    shutil.copy(BUILD / "libcurvopt.so", tmp_path)
    said = subprocess.run(
        [sys.executable, "-B", ROOT / "libcurvopt/packaging/make_dist.py", "dist", str(tmp_path)], check=True,
        capture_output=True, text=True,
    ).stdout  # fmt: skip
    made = {platform.name for platform in make_dist.found_libraries(tmp_path)}
    for platform in make_dist.PLATFORMS:
        assert (f"left out {platform.name}: there is no build/" in said) == (platform.name not in made)


def test_the_record_of_the_wheel_is_right(wheel):
    with zipfile.ZipFile(wheel) as found:
        rows = [line.split(",") for line in found.read(f"curvopt-{VERSION}.dist-info/RECORD").decode().splitlines()]
        assert [row[0] for row in rows] == [*sorted(set(found.namelist()) - {rows[-1][0]}), rows[-1][0]]
        for name, digest, size in rows[:-1]:
            contents = found.read(name)
            wanted = base64.urlsafe_b64encode(hashlib.sha256(contents).digest()).rstrip(b"=").decode()
            assert (digest, int(size)) == (f"sha256={wanted}", len(contents))
        assert b"Tag: py3-none-manylinux_2_17_x86_64\n" in found.read(f"curvopt-{VERSION}.dist-info/WHEEL")


def clean_environment():
    return {key: value for key, value in os.environ.items() if key not in ("CURVOPT_LIBRARY", "PYTHONPATH")}


CODE = """
import curvopt
p = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
print(curvopt.__version__, round(curvopt.minimize(curvopt.cage(p, f), levels=3).energies.objective, 2), curvopt.__file__)
"""


def test_pip_installs_it_and_it_works_and_pip_removes_it(wheel, tmp_path):
    def python(*arguments, **more):
        return subprocess.run(
            [tmp_path / "venv/bin/python", *arguments], check=True, capture_output=True, text=True, cwd=tmp_path,
            env=clean_environment(), **more,
        ).stdout  # fmt: skip

    subprocess.run(["/usr/bin/python3", "-m", "venv", "--system-site-packages", tmp_path / "venv"], check=True)
    python("-m", "pip", "install", "--no-index", "--no-deps", str(wheel))
    said = python("-c", CODE)
    assert said.startswith(f"{VERSION} 25.1") and str(tmp_path / "venv") in said
    python("-m", "pip", "uninstall", "-y", "curvopt")
    assert not list((tmp_path / "venv").rglob("curvopt*"))


def unpacked(wheel, folder):
    """The wheel's package in a folder of its own."""
    with zipfile.ZipFile(wheel) as found:
        found.extractall(folder)
    return folder / "curvopt"


def import_from(folder, code=CODE):
    return subprocess.run(
        ["/usr/bin/python3", "-B", "-c", code], capture_output=True, text=True, cwd=folder,
        env={**clean_environment(), "PYTHONPATH": str(folder)},
    )  # fmt: skip


def test_the_wheel_of_another_platform_says_so(wheel, tmp_path):
    package = unpacked(wheel, tmp_path)
    (package / "native/linux-x64").rename(package / "native/windows-x64")
    assert "for linux-x64 is missing: this package is for windows-x64" in import_from(tmp_path).stderr


def test_a_library_that_is_of_another_system_or_empty_says_so(wheel, tmp_path):
    library = unpacked(wheel, tmp_path) / "native/linux-x64/libcurvopt.so"
    for contents in (b"MZ" + bytes(5000), b""):
        library.write_bytes(contents)
        said = import_from(tmp_path).stderr
        assert "cannot be loaded on linux-x64: " in said and "Install the file for this system." in said, said


def test_pip_refuses_the_wheel_of_another_platform(tmp_path):
    (platform,) = (each for each in make_dist.PLATFORMS if each.name == "windows-x64")
    name, contents = make_dist.wheel(platform, b"a library")
    (tmp_path / name).write_bytes(contents)
    subprocess.run(["/usr/bin/python3", "-m", "venv", tmp_path / "venv"], check=True)
    done = subprocess.run(
        [tmp_path / "venv/bin/python", "-m", "pip", "install", "--no-index", "--no-deps", tmp_path / name],
        capture_output=True, text=True, env=clean_environment(),
    )  # fmt: skip
    assert done.returncode and "is not a supported wheel on this platform" in done.stderr, done.stderr
    assert not list((tmp_path / "venv").rglob("curvopt*"))


@pytest.mark.parametrize("platform", make_dist.PLATFORMS, ids=lambda platform: platform.name)
def test_what_was_never_run_says_so(platform):
    never = platform.name.startswith("macos")
    archives = {"curvopt/": make_dist.wheel(platform, b"")[1], "curvopt_addon/vendor/curvopt/": make_dist.legacy({platform: b""})}
    for top, contents in archives.items():
        with zipfile.ZipFile(io.BytesIO(contents)) as found:
            note = f"{top}native/{platform.name}/BUILT_NOT_RUN.txt"
            assert (note in found.namelist()) == never
            assert not never or found.read(note).startswith(b"Built, not run: ")
            for name in found.namelist():
                assert not name.endswith("METADATA") or (b"Built, not run: " in found.read(name)) == never


def test_an_older_library_beside_a_newer_package_says_so(wheel, tmp_path):
    package, header = unpacked(wheel, tmp_path), ROOT / "libcurvopt/include"
    (tmp_path / "old.c").write_text('#include <curvopt.h>\nconst char *curvopt_version(void) { return "0.0.9"; }')
    library = package / "native/linux-x64/libcurvopt.so"
    subprocess.run(["cc", f"-I{header}", "-shared", "-fPIC", tmp_path / "old.c", "-o", library], check=True)
    said = import_from(tmp_path).stderr
    assert "is version 0.0.9, but this add-on or package needs 0.1: after an update, restart" in said


def test_a_read_only_install_works(wheel, tmp_path):
    package = unpacked(wheel, tmp_path / "ro")
    for path in [package, *package.rglob("*")]:
        path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))
    before = sorted((tmp_path / "ro").rglob("*"))
    done = import_from(tmp_path / "ro")
    assert done.stdout.startswith(VERSION), done.stderr
    assert sorted((tmp_path / "ro").rglob("*")) == before  # nothing is written, also by root


def install_addon(folder, vendor):
    """The add-on of this checkout in folder/addon, with its own package or without."""
    shutil.copytree(ROOT / "addon", folder / "addon", ignore=shutil.ignore_patterns("__pycache__", "manual"))
    if vendor:
        shutil.copytree(ROOT / "libcurvopt/python/curvopt", folder / "addon/vendor/curvopt")


BINDING = "import addon.binding.library as l; print(l.__file__)"


def older(folder):
    """A package of another version, which breaks whoever imports it."""
    (folder / "curvopt").mkdir(parents=True)
    (folder / "curvopt" / "version.py").write_text('VERSION = "0.0.9"\n')
    (folder / "curvopt" / "__init__.py").write_text("raise SystemExit('the old one was imported')")
    return folder


def test_the_add_on_takes_its_own_package_whatever_else_is_installed(tmp_path):
    install_addon(tmp_path, vendor=True)
    done = import_from(older(tmp_path / "old"), f"import sys; sys.path.append({str(tmp_path)!r}); {BINDING}")
    assert done.stdout.strip() == str(tmp_path / "addon/vendor/curvopt/library.py"), done.stderr


def test_of_two_wheels_the_add_on_takes_the_one_of_its_version(wheel, tmp_path):
    install_addon(tmp_path, vendor=False)
    unpacked(wheel, tmp_path / "new")
    code = f"import sys; sys.path += [{str(tmp_path / 'new')!r}, {str(tmp_path)!r}]; {BINDING}"
    done = import_from(older(tmp_path / "old"), code)
    assert done.stdout.strip() == str(tmp_path / "new/curvopt/library.py"), done.stderr


def test_an_extension_finds_its_wheel_though_no_path_names_it(wheel, tmp_path):
    place = tmp_path / "extensions/user_default"
    install_addon(place, vendor=False)
    version = subprocess.run(
        ["/usr/bin/python3", "-c", "import sys; print('{}.{}'.format(*sys.version_info))"], capture_output=True, text=True, check=True
    ).stdout.strip()  # fmt: skip
    package = unpacked(wheel, tmp_path / f"extensions/.local/lib/python{version}/site-packages")
    done = import_from(place, BINDING)
    assert done.stdout.strip() == str(package / "library.py"), done.stderr


def test_with_an_older_package_alone_the_add_on_says_what_to_do(tmp_path):
    install_addon(tmp_path, vendor=False)
    done = import_from(older(tmp_path / "old"), f"import sys; sys.path.append({str(tmp_path)!r}); {BINDING}")
    assert f"needs version {VERSION} of the Python package curvopt" in done.stderr
    assert "There is version 0.0.9 in" in done.stderr and "install the zip of version" in done.stderr


def test_the_repository_lists_what_is_there():
    listed = json.loads((DIST / "extensions/index.json").read_text())["data"]
    zips = {path.name: path.read_bytes() for path in (DIST / "extensions").glob("*.zip")}
    assert {item["archive_url"][2:] for item in listed} == set(zips)
    for item in listed:
        contents = zips[item["archive_url"][2:]]
        assert item["archive_hash"] == f"sha256:{hashlib.sha256(contents).hexdigest()}"
        assert item["archive_size"] == len(contents) and item["version"] == VERSION

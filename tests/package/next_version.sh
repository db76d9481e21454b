#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A copy of the add-on's sources under the next patch version, packed with the built library: next_version.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/../.."
version=$(sed -nE 's/^project\(curvopt VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
next=${version%.*}.$((${version##*.} + 1))
mkdir -p "$1/build/release"
cp -r --parents addon LICENSE CMakeLists.txt CMakePresets.json CHANGELOG.md libcurvopt/include libcurvopt/python \
    libcurvopt/packaging blend_files/obj "$1"
cp -L build/release/libcurvopt.so "$1/build/release"
cd "$1"
commas=${version//./, }
sed -i "s/\"$version\"/\"$next\"/; s/($commas)/(${next//./, })/; s/VERSION $version/VERSION $next/; s/^## $version/## $next/; s/($version-/($next-/
    s/VERSION_PATCH ${version##*.}/VERSION_PATCH ${next##*.}/" CMakeLists.txt CHANGELOG.md addon/__init__.py addon/binding/__init__.py \
    addon/blender_manifest.toml libcurvopt/python/curvopt/version.py libcurvopt/packaging/debian/changelog libcurvopt/include/curvopt.h
python3 -B libcurvopt/packaging/make_dist.py dist build/release

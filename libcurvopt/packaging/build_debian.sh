#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Debian packages of the commit that is checked out, checked by lintian: bash libcurvopt/packaging/build_debian.sh [DIR]
# Needs debhelper, dh-python, lintian and the packages that debian/control names. The packages are in DIR; default:
# build/debian. The exit code is not 0 if lintian finds anything.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m -- "${1:-build/debian}")
version=$(sed -nE 's/^project\(curvopt VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
rm -rf "$out"
mkdir -p "$out/curvopt-$version"
git archive HEAD | tar -x -C "$out/curvopt-$version"
cd "$out/curvopt-$version"
cp -r libcurvopt/packaging/debian debian
dpkg-buildpackage -us -uc -b >../build.log 2>&1 || { tail -n 40 ../build.log >&2 && exit 1; }
cd ..
ls -l ./*.deb
lintian --info --display-info --fail-on error,warning,info ./*.changes

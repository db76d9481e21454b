#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The Debian packages of the commit: built, checked by lintian, unpacked in a folder and used from there: debian.sh
# Last line: "N passed, N failed".
set -u
cd "$(dirname "$0")/../.." || exit 1
out=$PWD/build/debian
root=$out/root
# shellcheck source=tests/check.sh
source tests/check.sh

unpack() {
    local package
    for package in "$out"/*.deb; do
        dpkg-deb -x "$package" "$root" || return
    done
}

libraries=$(dpkg-architecture -qDEB_HOST_MULTIARCH)
code="import curvopt; curvopt.library_version(); print(curvopt.__file__)"

# The Python package finds the system's library by name.
python_uses_it() {
    env -u CURVOPT_LIBRARY LD_LIBRARY_PATH="$root/usr/lib/$libraries" PYTHONPATH="$root/usr/lib/python3/dist-packages" \
        /usr/bin/python3 -B -c "$code"
}

pkg_config_finds_it() {
    [[ $(PKG_CONFIG_PATH=$root/usr/lib/$libraries/pkgconfig pkg-config --modversion curvopt) == \
        $(sed -nE 's/^project\(curvopt VERSION ([0-9.]+).*/\1/p' CMakeLists.txt) ]]
}

# Blender finds the add-on where the package puts it, and the Python package beside it.
blender_uses_it() {
    env -u CURVOPT_LIBRARY LD_LIBRARY_PATH="$root/usr/lib/$libraries" BLENDER_USER_SCRIPTS="$root/usr/share/blender/scripts" \
        PYTHONPATH="$root/usr/lib/python3/dist-packages" PYTHONDONTWRITEBYTECODE=1 \
        blender -b --factory-startup --python-exit-code 1 --addons curvopt_addon --python-expr \
        'import bpy; bpy.ops.mesh.primitive_cube_add(); assert bpy.ops.curvopt.minimize() == {"FINISHED"}'
}

check "builds, and lintian is content" bash libcurvopt/packaging/build_debian.sh "$out"
check "unpacks" unpack
check "the command runs" env LD_LIBRARY_PATH="$root/usr/lib/$libraries" "$root/usr/bin/curvopt" --version
check "pkg-config finds it" pkg_config_finds_it
check "Python uses it" python_uses_it
check "Blender uses it" blender_uses_it
end_of_checks

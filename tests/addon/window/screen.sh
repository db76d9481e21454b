# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# To be sourced by scripts of this folder: a virtual screen and a folder `$work` with the add-on for a Blender of its own,
# both gone when the script ends. blender_window SECONDS SCRIPT runs SCRIPT in a window of `size`. BLENDER names another
# Blender.
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../../.." && pwd)
export PATH="/usr/bin:$PATH"

work=$(mktemp -d -t curvopt-window-XXXXXX)
mkdir -p "$work/out" "$work/scripts/addons"
cp -r "$root/addon" "$work/scripts/addons/curvopt"
cp -r "$root/blend_files/obj" "$work/scripts/addons/curvopt/shapes"
mkdir -p "$work/scripts/addons/curvopt/vendor"
package="$work/scripts/addons/curvopt/vendor/curvopt"
cp -r "$root/libcurvopt/python/curvopt" "$package"
mkdir -p "$package/native/linux-x64"
cp "${CURVOPT_LIBRARY:-$root/build/release/libcurvopt.so}" "$package/native/linux-x64/libcurvopt.so"
unset CURVOPT_LIBRARY PYTHONPATH

mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1000x700x24 -nolisten tcp 3>"$work/display" 2>"$work/xvfb.log" &
xvfb=$!
trap 'kill "$xvfb" 2>/dev/null; wait "$xvfb" 2>/dev/null; rm -rf "$work"' EXIT
read -r number <"$work/display" || { echo "Xvfb did not start"; cat "$work/xvfb.log"; exit 1; }
export BLENDER_USER_SCRIPTS="$work/scripts" BLENDER_USER_CONFIG="$work/config" DISPLAY=":$number"

# blender_window SECONDS SCRIPT
blender_window() {
    timeout "$1" "${BLENDER:-blender}" --factory-startup --enable-event-simulate -p 0 0 ${size:-1000 700} \
        --python-exit-code 1 -P "$2"
}

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Makes the manual's pictures, addon/manual/pictures/: see pictures.py, strength.py, edit_mode.py, animation.py, comparison.py. Usage: pictures.sh [FOLDER]
set -eu
# shellcheck source=tests/addon/window/screen.sh
source "$(dirname "$0")/screen.sh"

out=${1:-$root/addon/manual/pictures}
mkdir -p "$out"
"${BLENDER:-blender}" -b --factory-startup --python-exit-code 1 -P "$here/strength.py" -- "$work/12_strength.png" "$work/13_clay.png" "$work/13_zebra.png"
convert "$work/13_clay.png" "$work/13_zebra.png" -append "$work/13_suzanne.png"
"${BLENDER:-blender}" -b --factory-startup --python-exit-code 1 -P "$here/edit_mode.py" -- "$work/clay.png" "$work/zebra.png"
convert "$work/clay.png" "$work/zebra.png" -append "$work/14_edit_mode.png"
for picture in 12_strength 13_suzanne 14_edit_mode; do
    convert "$work/$picture.png" -strip -colors 256 -define png:exclude-chunks=all "png8:$out/$picture.png"
done
"${BLENDER:-blender}" -b --factory-startup --python-exit-code 1 -P "$here/animation.py" -- "$work/23_states.png"
convert "$work/23_states.png" -strip -colors 256 -define png:exclude-chunks=all "png8:$out/23_states.png"
mkdir "$work/comparison"
export CURVOPT_WINDOW_RESULTS="$work/comparison/results.txt"
blender_window 600 "$here/comparison.py" # also prints its table
grep -q '^PASS' "$CURVOPT_WINDOW_RESULTS"
convert "$work/comparison/24_comparison.png" -strip -colors 256 -define png:exclude-chunks=all "png8:$out/24_comparison.png"
export CURVOPT_WINDOW_RESULTS="$work/out/results.txt"
blender_window 600 "$here/pictures.py"
if grep -q '^FAIL' "$CURVOPT_WINDOW_RESULTS"; then
    exit 1
fi
for picture in "$work"/out/*.png; do
    height=650
    [ "$(basename "$picture")" = 0_install.png ] && height=320 # the rest is empty
    convert "$picture" -crop "828x$height+0+30" +repage -strip +dither -colors 96 -define png:exclude-chunks=all "png8:$out/$(basename "$picture")"
done

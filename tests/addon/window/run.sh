#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Drives the add-on in a real Blender window on a virtual screen. Usage: run.sh [FOLDER for screenshots]
# Last line: "N passed, N failed"; exit code 0 only if nothing failed. BLENDER names another Blender.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../.." && pwd)
export PATH="/usr/bin:$PATH"

work=$(mktemp -d -t curvopt-window-XXXXXX)
out=${1:-$work/out}
mkdir -p "$out" "$work/scripts/addons"
cp -r "$root/addon" "$work/scripts/addons/curvopt"
mkdir -p "$work/scripts/addons/curvopt/lib"
cp -r "$root/blend_files/obj" "$work/scripts/addons/curvopt/shapes"
cp "${CURVOPT_LIBRARY:-$root/build/release/libcurvopt.so}" "$work/scripts/addons/curvopt/lib/libcurvopt.so"
unset CURVOPT_LIBRARY PYTHONPATH

mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1000x700x24 -nolisten tcp 3>"$work/display" 2>"$work/xvfb.log" &
xvfb=$!
trap 'kill "$xvfb" 2>/dev/null; wait "$xvfb" 2>/dev/null; rm -rf "$work"' EXIT
read -r number <"$work/display" || { echo "Xvfb did not start"; cat "$work/xvfb.log"; exit 1; }

export CURVOPT_WINDOW_RESULTS="$out/results.txt" BLENDER_USER_SCRIPTS="$work/scripts" DISPLAY=":$number"
rm -f "$CURVOPT_WINDOW_RESULTS"
timeout 240 "${BLENDER:-blender}" --factory-startup --enable-event-simulate -p 0 0 1000 700 \
    --python-exit-code 1 -P "$here/drive.py"
code=$?

# Every check of drive.py must have passed, and the quit in the middle of a run must have ended Blender with 0.
touch "$CURVOPT_WINDOW_RESULTS"
expected=$(($(grep -c '^@check' "$here/drive.py") + 1))
passed=$(grep -c '^PASS ' "$CURVOPT_WINDOW_RESULTS")
if grep -q '^QUITTING' "$CURVOPT_WINDOW_RESULTS" && [ "$code" -eq 0 ]; then
    echo "PASS quitting_during_a_run"
    passed=$((passed + 1))
else
    echo "FAIL quitting_during_a_run: Blender's exit code was $code"
fi
echo "$passed passed, $((expected - passed)) failed"
[ "$passed" -eq "$expected" ]

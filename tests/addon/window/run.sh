#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Drives the add-on in a real Blender window on a virtual screen. Usage: run.sh [FOLDER for screenshots]
# Last line: "N passed, N failed"; exit code 0 only if nothing failed. BLENDER names another Blender.
set -u
# shellcheck source=tests/addon/window/screen.sh
source "$(dirname "$0")/screen.sh"

out=${1:-$work/out}
mkdir -p "$out"
export CURVOPT_WINDOW_RESULTS="$out/results.txt"
rm -f "$CURVOPT_WINDOW_RESULTS"
blender_window 1700 "$here/drive.py"
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

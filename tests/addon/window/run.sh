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
blender_window 900 "$here/live.py"
live_code=$?
blender_window 600 "$here/reading.py"
reading_code=$?

# Every check of the scripts must have passed, and the quits in the middle must have ended Blender with 0.
touch "$CURVOPT_WINDOW_RESULTS"
expected=$(($(cat "$here/drive.py" "$here/live.py" "$here/reading.py" | grep -c '^@check') + 3))
passed=$(grep -c '^PASS ' "$CURVOPT_WINDOW_RESULTS")

# quit WORD CODE: whether Blender quit with 0 where the results say WORD.
quit() {
    if grep -qx "$1" "$CURVOPT_WINDOW_RESULTS" && [ "$2" -eq 0 ]; then
        echo "PASS $1"
        passed=$((passed + 1))
    else
        echo "FAIL $1: Blender's exit code was $2"
    fi
}
quit QUITTING "$code"
quit "QUITTING LIVE" "$live_code"
quit "QUITTING INSPECT" "$reading_code"
echo "$passed passed, $((expected - passed)) failed"
[ "$passed" -eq "$expected" ]

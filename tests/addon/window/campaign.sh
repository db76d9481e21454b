#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Sequences of random actions in a real Blender window: see campaign.py. Usage:
# campaign.sh [NUMBER] [FIRST] [live] (default 10, from 1; with "live" each begins with Live). Last line: "N passed, N
# failed", counting sequences and quits.
set -u
# shellcheck source=tests/addon/window/screen.sh
source "$(dirname "$0")/screen.sh"

first=${2:-1}
last=$((first + ${1:-10} - 1))
export CURVOPT_WINDOW_RESULTS="$work/out/results.txt"
touch "$CURVOPT_WINDOW_RESULTS"
passed=0
failed=0
while [ "$first" -le "$last" ]; do
    CURVOPT_CAMPAIGN="$first $last ${3:-}" blender_window 900 "$here/campaign.py" >"$work/out/log" 2>&1
    code=$?
    ended=$(grep -E '^(BEGIN|QUITTING) ' "$CURVOPT_WINDOW_RESULTS" | tail -n 1)
    if [ "$code" -eq 0 ] && [[ $ended == QUITTING* ]]; then
        passed=$((passed + 1))
    else
        echo "FAIL: Blender ended with $code in \"$ended\"; its last words:"
        tail -n 40 "$work/out/log"
        failed=$((failed + 1))
    fi
    next=$(($(cut -d ' ' -f 2 <<<"${ended:-x $last}") + 1))
    first=$next
done
grep '^FAIL' -B 1 "$CURVOPT_WINDOW_RESULTS"
passed=$((passed + $(grep -c '^PASS ' "$CURVOPT_WINDOW_RESULTS")))
failed=$((failed + $(grep -c '^FAIL ' "$CURVOPT_WINDOW_RESULTS")))
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

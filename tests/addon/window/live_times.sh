#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Measures Live in a real Blender window: see live_times.py, also for the environment.
set -eu
# shellcheck source=tests/addon/window/screen.sh
source "$(dirname "$0")/screen.sh"

export CURVOPT_WINDOW_RESULTS="$work/out/results.txt"
touch "$CURVOPT_WINDOW_RESULTS"
[ -z "${CURVOPT_BARE:-}" ] || size="480 360"
for case in 0 1 2; do
    CURVOPT_CASE=$case blender_window 1800 "$here/live_times.py" >"$work/out/log" 2>&1 || cat "$work/out/log"
done
cat "$CURVOPT_WINDOW_RESULTS"
! grep -q '^FAIL' "$CURVOPT_WINDOW_RESULTS"

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What users install, installed: in fresh Blenders (blenders.sh; CURVOPT_ROOTS names folders with other Debians), and as
# Debian packages (debian.sh). Last line: "N passed, N failed".
set -u
here=$(dirname "$0")
log=$(mktemp -t curvopt-package-XXXXXX)
trap 'rm -f "$log"' EXIT
passed=0
failed=0
cmake --build --preset release --target dist || exit 1
# shellcheck disable=SC2086 # several folders
for command in "blenders.sh ${CURVOPT_ROOTS:-}" debian.sh; do
    bash "$here"/$command 2>&1 | tee "$log"
    read -r ok bad < <(sed -nE 's/^([0-9]+) passed, ([0-9]+) failed$/\1 \2/p' "$log" | tail -n 1)
    passed=$((passed + ${ok:-0}))
    failed=$((failed + ${bad:-1}))
done
echo "$passed passed, $failed failed"
((failed == 0))

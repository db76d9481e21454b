#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Short runs of the command line for the coverage figure (tests/checks/coverage.py): what whole runs do and unit tests do
# not, such as leaving saddles. Each must succeed; what it finds is the business of other tests.
#
#   bash tests/checks/coverage_runs.sh PROGRAM
set -u
program=$(realpath -- "${1:?which program?}")
cd "$(dirname "$0")/../.." || exit 1
work=$(mktemp -d -t curvopt-coverage-XXXXXX)
trap 'rm -rf "$work"' EXIT
failed=0

# run CAGE OPTION...: a minimization.
run() {
    local cage=$1
    shift
    "$program" minimize "$cage" -o "$work/out.obj" --json "$work/out.json" --quiet "$@" ||
        { failed=$((failed + 1)) && printf 'coverage_runs: failed: minimize %s %s\n' "$cage" "$*" >&2; }
}

cages=blend_files/obj
printf '%s\n' "0" "1 line 0 0 1 0.5" "2 plane 1 0 0" "3 0.2" >"$work/pins.txt"
run $cages/torus_050_6x4.obj --energy mvs --levels 2 --escape --verify
run $cages/torus_050_6x4.obj --energy mvs_cross --levels 2 --symmetry auto
run $cages/torus_050_6x4.obj --energy willmore --levels 2 --symmetry none --escape --verify
run $cages/torus_050_6x4.obj --energy mvs --levels 1 --symmetry x,y
run $cages/torus_050_6x4.obj --energy mvs --levels 2 --joshi-sequin --max-iterations 40
run $cages/sphere_cube.obj --energy mvs:1,area:0.1 --levels 2 --symmetry none --escape --verify
run tests/cages/numeric/cube.obj --energy mvs --levels 2 --pin "$work/pins.txt"
run tests/cages/numeric/cube.obj --energy mehlum_tarrou --levels 1 --boundary-rule corners
for boundary in position tangent curvature free; do
    run $cages/branch_open.obj --energy mvs --levels 1 --boundary $boundary --max-iterations 30
done
for surface in limit plane polynomial; do
    "$program" evaluate $cages/torus_050_6x4.obj --energy willmore --surface $surface --json - >/dev/null ||
        failed=$((failed + 1))
done
((failed == 0))

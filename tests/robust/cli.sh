# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the tests of the command line share; to be sourced. Each test is a function test_BEHAVIOUR that runs in an empty
# folder of its own; run_tests runs them all and fails if one did.
#
#   test_cli_NAME.sh PROGRAM [SYSTEM]     native (if it is not given), windows (in Wine), emulated (Linux, in qemu) or
#                                         sanitized (a build with sanitizers)
set -uo pipefail

CURVOPT=$(realpath -- "$1")
SYSTEM=${2:-native}
HEADER=$(realpath -- "$(dirname "${BASH_SOURCE[0]}")/../../libcurvopt/include/curvopt.h")
OUT='' ERR='' CODE=0

fail() {
    printf '    %s\n' "$*" >&2
    FAILED=1
}

# cannot_be_on SYSTEM REASON: whether that is this system; the test then ends, and is counted as skipped, for that reason.
cannot_be_on() {
    [[ $SYSTEM == "$1" ]] || return 1
    SKIPPED=$2
}

# run ARGUMENT...: output, errors and exit code into OUT, ERR, CODE.
run() {
    "$CURVOPT" "$@" >"$SCRATCH/out" 2>"$SCRATCH/err" </dev/null
    CODE=$?
    OUT=$(<"$SCRATCH/out")
    ERR=$(<"$SCRATCH/err")
}

# expect CODE PART: the exit code, and a text that standard error must contain ('' for no errors at all).
expect() {
    [[ $CODE == "$1" ]] || fail "expected exit code $1, got $CODE; standard error: $ERR"
    if [[ -z $2 ]]; then
        [[ -z $ERR ]] || fail "expected nothing on standard error, got: $ERR"
    else
        [[ $ERR == *"$2"* ]] || fail "expected '$2' on standard error, got: $ERR"
    fi
}

# One sentence that begins with the program's name, and nothing on standard output.
expect_one_sentence() {
    [[ $ERR == curvopt:\ * && $ERR != *$'\n'* ]] || fail "expected one line 'curvopt: ...', got: $ERR"
    [[ -z $OUT ]] || fail "expected nothing on standard output, got: $OUT"
}

# refused CODE PART COMMAND...: as expect, and nothing is there that was not there before.
refused() {
    local code=$1 part=$2 before after
    shift 2
    before=$(ls -lA --time-style=full-iso)
    run "$@"
    after=$(ls -lA --time-style=full-iso)
    expect "$code" "$part"
    expect_one_sentence
    [[ $before == "$after" ]] || fail "the folder has changed: $after"
}

# json FILE EXPRESSION: a Python expression over the object j that must be true.
json() {
    python3 -c '
import json, sys
def number(text):
    raise ValueError("not JSON: " + text)
j = json.load(open(sys.argv[1]), parse_constant=number)
sys.exit(0 if eval(sys.argv[2]) else "not so: " + sys.argv[2] + " in " + json.dumps(j)[:2000])' "$1" "$2" ||
        fail "$1 is not as it should be"
}

# cube_obj [NAME VALUE]: a cube on standard output; the first line may be replaced by another one.
cube_obj() {
    cat <<'END'
v -1 -1 -1
v -1 -1 1
v -1 1 -1
v -1 1 1
v 1 -1 -1
v 1 -1 1
v 1 1 -1
v 1 1 1
f 1 2 4 3
f 5 7 8 6
f 1 5 6 2
f 3 4 8 7
f 1 3 7 5
f 2 6 8 4
END
}

# torus_obj N_U N_V
torus_obj() {
    awk -v n="$1" -v m="$2" 'BEGIN {
        pi = atan2(0, -1)
        for (i = 0; i < n; i++)
            for (j = 0; j < m; j++) {
                a = 2 * pi * i / n; b = 2 * pi * j / m; r = 1 + 0.4 * cos(b)
                printf "v %.15g %.15g %.15g\n", r * cos(a), r * sin(a), 0.4 * sin(b)
            }
        for (i = 0; i < n; i++)
            for (j = 0; j < m; j++) {
                k = (i + 1) % n; l = (j + 1) % m
                printf "f %d %d %d %d\n", i * m + j + 1, k * m + j + 1, k * m + l + 1, i * m + l + 1
            }
    }'
}

run_tests() {
    local name failed=0 count=0 skipped=0
    SCRATCH=$(mktemp -d) || exit 1
    trap 'rm -rf "$SCRATCH"' EXIT
    for name in $(declare -F | sed -n 's/^declare -f \(test_.*\)/\1/p'); do
        FAILED=0 SKIPPED=
        mkdir "$SCRATCH/$name" && cd "$SCRATCH/$name" || exit 1
        "$name"
        if [[ -n $SKIPPED ]]; then
            skipped=$((skipped + 1))
            echo "skipped - $name: $SKIPPED"
            continue
        fi
        count=$((count + 1))
        if ((FAILED)); then
            failed=$((failed + 1))
            echo "not ok - $name"
        else
            echo "ok - $name"
        fi
    done
    echo "$((count - failed)) passed, $failed failed, $skipped skipped"
    ((count > 0 && failed == 0))
}

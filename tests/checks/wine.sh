#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The Windows build in Wine, in short: a few unit tests; the library loaded 100 times; which DLLs it needs; names of files;
# two cages evaluated and minimized on two levels with the same bits as by the Linux program
# (libcurvopt/notes/98-other-platforms.md). All of it: tests/run.sh windows. Last line: "N passed, N failed", or why it cannot
# run: "skipped: ...".
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
# shellcheck source=tests/setup.sh
source tests/setup.sh
# shellcheck source=tests/check.sh
source tests/check.sh
BUILD=build/windows-x64
UNIT=(memory clock thread_pool own_blas sparse_cholesky element_kernel options)
PROGRAM=$PWD/$BUILD/tests/curvopt.sh
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

skip() {
    echo "skipped: $*"
    exit 0
}

unit_test() {
    ctest --test-dir "$BUILD" --tests-regex "^unit\\.$1\$" --no-tests=error --output-on-failure
}

# run_program NAME PROGRAM CAGE ENERGY: its figures into NAME.evaluate.json and NAME.minimize.json
run_program() {
    "$2" evaluate "$3" --energy "$4" --threads 1 --quiet --json "$work/$1.evaluate.json" &&
        "$2" minimize "$3" --energy "$4" --threads 1 --levels 2 --quiet -o "$work/$1.obj" --json "$work/$1.minimize.json"
}

# same_as_linux CAGE ENERGY
same_as_linux() {
    rm -f "$work"/*.json
    run_program linux build/release/curvopt "$@" && run_program windows "$PROGRAM" "$@" || return
    cmp "$work/linux.obj" "$work/windows.obj" || return
    python3 - "$work" <<'END'
import json, sys
for command in ("evaluate", "minimize"):
    a, b = (json.load(open(f"{sys.argv[1]}/{system}.{command}.json")) for system in ("linux", "windows"))
    assert a["objective"] == b["objective"] > 0, (command, a["objective"], b["objective"])
    for name in ("vertices", "faces", "samples", "stop", "verification"):
        same = a.get(name) == b.get(name) if name != "verification" else a.get(name, {}).get("verdict") == b.get(name, {}).get("verdict")
        assert same, (command, name, a.get(name), b.get(name))
    steps = [[level["iterations"] for level in each.get("levels", [])] for each in (a, b)]
    assert steps[0] == steps[1], (command, steps)
END
}

for compiler in gcc g++; do
    command -v "x86_64-w64-mingw32-$compiler-posix" >/dev/null ||
        skip "there is no compiler for Windows ($compiler-mingw-w64-x86-64-posix)"
done
[[ -x /usr/lib/wine/wine64 ]] || command -v wine64 >/dev/null || command -v wine >/dev/null || skip "there is no Wine (wine64)"
mkdir -p build/tests
log=build/tests/archives-windows-x64.log
if ! bash libcurvopt/toolchains/archives.sh x86_64-w64-mingw32 >"$log" 2>&1; then
    [[ -e build/cross/sources/suitesparse && -e build/cross/sources/cmocka ]] || skip "sources of CHOLMOD cannot be had ($log)"
    echo "wine: CHOLMOD for Windows cannot be made: $log" >&2
    exit 1
fi
build windows-x64 curvopt curvopt_tool unload "${UNIT[@]/#/test_}" || exit 1
wine_starts || { echo "Wine does not start" >&2 && exit 1; }
for name in "${UNIT[@]}"; do
    check "unit.$name" unit_test "$name"
done
check "the library is loaded 100 times" ctest --test-dir "$BUILD" --tests-regex '^abi\.unload$' --no-tests=error --output-on-failure
check "DLLs, exports, no console" bash tests/checks/windows_dlls.sh "$BUILD"
check "names of files" bash tests/robust/test_cli_paths.sh "$PROGRAM" windows
check "torus_050_8x8, MVS, as on Linux" same_as_linux blend_files/obj/torus_050_8x8.obj mvs
check "lawson_g2, Willmore, as on Linux" same_as_linux blend_files/obj/lawson_g2.obj willmore
wine_ends
end_of_checks

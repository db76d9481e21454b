#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs build/release into a folder of its own and uses it from there, as a stranger's CMake project, by C compiler
# and by command. The last line is "N passed, N failed".
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
work=$PWD/build/tests/install
prefix=$work/prefix
passed=0
failed=0

# check NAME COMMAND...: counts whether the command succeeds; shows its output if it does not.
check() {
    local name=$1 output
    shift
    if output=$("$@" 2>&1); then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        printf 'install: failed: %s\n%s\n' "$name" "$output" >&2
    fi
}

# Finds the package, but not in the version that is wanted.
refuses_version() {
    local output
    ! output=$(consumer newer "$1" 2>&1) && grep -q "curvoptConfig.cmake, version: " <<<"$output"
}

consumer() {
    cmake -S tests/install/consumer -B "$work/$1" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -DWANTED="$2"
}

by_compiler() {
    cc -std=c11 tests/install/consumer/main.c -o "$work/by_compiler" -I"$prefix/include" -L"$prefix/lib" -lcurvopt -lm \
        -Wl,-rpath,"$prefix/lib" && "$work/by_compiler"
}

only_two_headers() {
    [[ $(find "$prefix/include" -type f | sort) == "$prefix/include/curvopt.h"$'\n'"$prefix/include/curvopt_experimental.h" ]]
}

no_trace_of_the_build() {
    [[ -e $prefix/include/curvopt.h ]] && ! grep -rlaF -- "$PWD" "$prefix"
}

cmake -E rm -rf "$work"
check "installs" cmake --install build/release --prefix "$prefix"
check "installs two headers" only_two_headers
check "names no folder of the build" no_trace_of_the_build
check "a CMake project finds it" consumer found 0.1
check "a CMake project builds with it" cmake --build "$work/found"
check "the project's program runs" "$work/found/consumer"
check "a CMake project that wants version 99 does not" refuses_version 99
check "a C compiler finds it" by_compiler
check "the command runs" "$prefix/bin/curvopt" --version
check "the command works" "$prefix/bin/curvopt" evaluate blend_files/obj/sphere_cube.obj --json -
echo "$passed passed, $failed failed"
((failed == 0))

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs build/release into a folder of its own and uses it from there, as a stranger's CMake project, by C compiler
# and by command. The last line is "N passed, N failed".
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
work=$PWD/build/tests/install
prefix=$work/prefix
# shellcheck source=tests/check.sh
source tests/check.sh

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

# by_pkg_config VERSION: compiled, linked and run with what pkg-config says of that version or later.
by_pkg_config() {
    local flags
    export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
    flags=$(pkg-config --cflags --libs "curvopt >= $1") || return
    # shellcheck disable=SC2086 # flags are words
    cc -std=c11 tests/install/consumer/main.c -o "$work/by_pkg_config" $flags -lm -Wl,-rpath,"$prefix/lib" &&
        "$work/by_pkg_config"
}

pkg_config_refuses_version() {
    local output
    ! output=$(by_pkg_config "$1" 2>&1) && grep -q "curvopt >= $1" <<<"$output"
}

# The name that programs are linked with has the version that they fit.
names_its_version() {
    readelf -d "$prefix/lib/libcurvopt.so" | grep -q 'SONAME.*\[libcurvopt\.so\.0\.1\]' &&
        [[ -L $prefix/lib/libcurvopt.so && -f $prefix/lib/libcurvopt.so.0.1.0 ]]
}

# With a distribution's shared CHOLMOD and BLAS.
unbundled_builds() {
    cmake -S . -B "$work/unbundled" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCURVOPT_BUNDLE_CHOLMOD=OFF -DCURVOPT_TESTS=OFF &&
        cmake --build "$work/unbundled"
}

unbundled_needs_cholmod() {
    readelf -d "$work/unbundled/libcurvopt.so" | grep -q 'NEEDED.*libcholmod' &&
        ! readelf -d build/release/libcurvopt.so | grep -q 'NEEDED.*libcholmod'
}

# The same minimum as with the bundled one.
unbundled_minimizes() {
    local build energy=() out=$work/out
    for build in build/release "$work/unbundled"; do
        "$build/curvopt" minimize blend_files/obj/torus_050.obj -o "$out.obj" --levels 2 --quiet --json "$out.json" || return
        energy+=("$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["objective"])' "$out.json")")
    done
    python3 -c 'import sys; a, b = map(float, sys.argv[1:]); sys.exit(not abs(a / b - 1) < 1e-5)' "${energy[@]}"
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
check "pkg-config finds it" by_pkg_config 0.1
check "pkg-config does not find version 99" pkg_config_refuses_version 99
check "the library's name has its version" names_its_version
check "the command runs" "$prefix/bin/curvopt" --version
check "the command works" "$prefix/bin/curvopt" evaluate blend_files/obj/sphere_cube.obj --json -
check "builds with a shared CHOLMOD" unbundled_builds
check "which it then needs" unbundled_needs_cholmod
check "and minimizes as well with it" unbundled_minimizes
end_of_checks

# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Functions that the project's scripts share; to be sourced. They run on a fresh Debian with nothing but apt, and on
# any Linux that has the tools already.

# Packages, by what they are for: PACKAGE, or PACKAGE:COMMAND where having the command, from wherever, will do.
# shellcheck disable=SC2034
{
    BUILD_PACKAGES=(gcc:gcc libc6-dev cmake:cmake ninja-build:ninja libsuitesparse-dev python3:python3)
    CTEST_PACKAGES=("${BUILD_PACKAGES[@]}" g++:g++ libcmocka-dev)
    BLENDER_PACKAGES=(blender:blender python3-numpy libegl1 libegl-mesa0)
    PYTEST_PACKAGES=(python3-pytest python3-numpy)
    DEBIAN_PACKAGES=(dpkg-dev debhelper dh-python lintian fakeroot libblas-dev pkg-config:pkg-config)
    CROSS_PACKAGES=(cmake:cmake ninja-build:ninja binutils:objdump dpkg-dev:dpkg-source make:make perl:perl python3:python3)
    WINDOWS_PACKAGES=(gcc-mingw-w64-x86-64-posix g++-mingw-w64-x86-64-posix wine64)
    ARM64_PACKAGES=(gcc-aarch64-linux-gnu g++-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user:qemu-aarch64)
    MACOS_PACKAGES=(clang-14:clang-14 lld-14 llvm-14 npm:npm)
    TAO_PACKAGES=(pkg-config:pkg-config petsc-dev libopenmpi-dev openmpi-bin:mpirun)
}

# The script that sources this file, in front of every message.
ME=$(basename "$0" .sh)

say() {
    printf '%s: %s\n' "$ME" "$*"
}

die() {
    printf '%s: %s\n' "$ME" "$*" >&2
    exit 1
}

# installed PACKAGE[:COMMAND]
installed() {
    local package=${1%%:*} command=
    [[ $1 != *:* ]] || command=${1#*:}
    if [[ -n $command ]] && command -v "$command" >/dev/null; then
        return 0
    fi
    command -v dpkg-query >/dev/null || return 1
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed* ]]
}

# need PACKAGE[:COMMAND]...: installs from Debian whatever is missing; needs root only then.
need() {
    local entry missing=()
    for entry in "$@"; do
        installed "$entry" || missing+=("${entry%%:*}")
    done
    if ((${#missing[@]} == 0)); then
        return 0
    fi
    command -v apt-get >/dev/null ||
        die "there is no apt-get to install these packages of Debian: ${missing[*]}"
    [[ $(id -u) == 0 ]] ||
        die "packages are missing; as root, run: apt-get install --no-install-recommends ${missing[*]}"
    say "installing from Debian: ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    local log
    log=$(mktemp -t "$ME-apt-XXXXXX.log")
    apt-get update >"$log" 2>&1 || say "the package lists could not all be refreshed; going on with those at hand"
    apt-get install -y --no-install-recommends "${missing[@]}" >>"$log" 2>&1 ||
        { tail -n 20 "$log" >&2 && die "apt-get could not install ${missing[*]}; all of its output is in $log"; }
    rm -f "$log"
}

# has_petsc: whether curvopt-tao can be built and run.
has_petsc() {
    command -v mpirun >/dev/null && command -v pkg-config >/dev/null && pkg-config --exists 'PETSc >= 3.18'
}

# build PRESET [TARGET...]: configures and builds in build/PRESET, quietly unless it fails; to be called in the
# project's folder.
build() {
    local preset=$1 log=build/$1.log targets=()
    shift
    (($# == 0)) || targets=(--target "$@")
    mkdir -p build
    say "building build/$preset"
    if ! { cmake --preset "$preset" && cmake --build --preset "$preset" "${targets[@]}"; } >"$log" 2>&1; then
        tail -n 40 "$log" >&2
        printf '%s: the build of preset %s failed; all of its output is in %s\n' "$ME" "$preset" "$log" >&2
        return 1
    fi
}

# wine_starts, wine_ends: one server of Wine for all programs of the Windows build between them, without which each of them
# starts its own, which takes 2 s. Its drives and registry are the build's own (libcurvopt/toolchains/windows-x64.cmake).
wine_starts() {
    mkdir -p build/windows-x64/wine
    wine_server --kill
    wine_server --persistent=60 # seconds after its last program
    bash build/windows-x64/tests/curvopt.sh --version >build/windows-x64/wine.log 2>&1
}

wine_ends() {
    wine_server --kill
}

wine_server() {
    local server
    server=$(command -v wineserver) || server=/usr/lib/wine/wineserver
    [[ ! -x $server ]] || WINEPREFIX=$PWD/build/windows-x64/wine "$server" "$1" >/dev/null 2>&1 </dev/null
}

# run_blender ARGUMENT...: Blender without a window, without this user's settings and Python paths; a script that
# fails makes it fail.
run_blender() {
    # Debian's Blender looks for its Python beside the first python3 of the path.
    PATH=$(dirname "$(command -v blender)"):$PATH env -u PYTHONPATH -u PYTHONHOME \
        blender -b --factory-startup --python-exit-code 1 "$@"
}

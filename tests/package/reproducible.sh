#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Whether the same commit gives the same bytes: two copies in folders with names of different lengths, built one after the
# other, at different times, in different languages and time zones; then every library, program and file of dist/ is compared.
# The sources of CHOLMOD are taken from build/cross where they are there; its archives are made anew in each copy.
#
#   bash tests/package/reproducible.sh [PRESET...]     default: release, and each cross preset whose compiler is installed
#
# Needs git, and what these presets need. Last line: "N passed, N failed", a file each.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
root=$PWD
# shellcheck source=tests/check.sh
source tests/check.sh
work=$(mktemp -d -t curvopt-reproducible-XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
COPIES=("$work/a" "$work/another-folder-with-a-longer-name")
declare -A TRIPLES=([windows-x64]=x86_64-w64-mingw32 [linux-arm64]=aarch64-linux-gnu [macos-arm64]=arm64-apple-macos11
    [macos-x64]=x86_64-apple-macos11)
declare -A COMPILERS=([windows-x64]=x86_64-w64-mingw32-g++-posix [linux-arm64]=aarch64-linux-gnu-g++ [macos-arm64]=clang-14 [macos-x64]=clang-14)

if (($#)); then
    presets=("$@")
else
    presets=(release)
    for preset in windows-x64 linux-arm64 macos-arm64 macos-x64; do
        command -v "${COMPILERS[$preset]}" >/dev/null && presets+=("$preset")
    done
fi

# build_copy FOLDER: what is committed, built there; the cross builds first, since dist packs what it finds.
build_copy() {
    local preset folder
    git clone -q "$root" "$1" && mkdir -p "$1/build/cross" && cd "$1" || return
    for folder in sources zig; do
        [[ ! -e $root/build/cross/$folder ]] || cp -r "$root/build/cross/$folder" build/cross
    done
    for preset in "${presets[@]}"; do
        [[ $preset == release ]] || bash libcurvopt/toolchains/archives.sh "${TRIPLES[$preset]}" || return
        cmake --preset "$preset" -DCURVOPT_TESTS=OFF && cmake --build --preset "$preset" || return
    done
    python3 -B libcurvopt/packaging/make_dist.py dist "build/${presets[-1]}"
}

# Files to compare, relative to a copy: libraries, programs and dist.
files_of() {
    local preset
    cd "$1/build" || return
    for preset in "${presets[@]}"; do
        find "$preset" -maxdepth 1 -type f \( -name '*curvopt*.so*' -o -name '*.dll' -o -name '*.dylib' -o -name curvopt \
            -o -name 'curvopt.exe' -o -name '*.zip' \)
    done
    find ./*/dist -type f
}

same_bytes() {
    cmp "${COPIES[0]}/build/$1" "${COPIES[1]}/build/$1"
}

settings=("TZ=UTC LC_ALL=C SOURCE_DATE_EPOCH=" "TZ=Asia/Tokyo LC_ALL=C.UTF-8 SOURCE_DATE_EPOCH=1")
for i in 0 1; do
    # shellcheck disable=SC2086 # several settings
    if ! (export ${settings[i]} && [[ -n $SOURCE_DATE_EPOCH ]] || unset SOURCE_DATE_EPOCH && build_copy "${COPIES[i]}") >"$work/log" 2>&1; then
        tail -n 40 "$work/log" >&2
        echo "0 passed, 1 failed"
        exit 1
    fi
done
mapfile -t files < <(for copy in "${COPIES[@]}"; do (files_of "$copy"); done | sort -u)
for file in "${files[@]}"; do
    check "$file is the same" same_bytes "$file"
done
((${#files[@]} >= 8)) || check "there are files to compare" false
printf 'compared: %s\n' "${files[@]}"
end_of_checks

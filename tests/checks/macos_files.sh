#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The macOS builds from outside; nothing here can run them. For each: kind of file and processor, the name that programs will
# look for, libSystem as the one library that is needed, macOS 11 as the oldest, the exported functions, the signature without
# which Apple's processors run nothing; and that all that is needed of libSystem is on its list.
#   macos_files.sh FOLDER ARCHITECTURE     such as build/macos-arm64 arm64
set -uo pipefail
# shellcheck source=tests/check.sh
source "$(dirname "$0")/../check.sh"
build=$1 architecture=$2
symbols=$(dirname "$0")/../abi/symbols.txt
list=$(dirname "$1")/cross/$architecture-apple-macos11/sysroot/usr/lib/libSystem.tbd

headers_of() {
    llvm-objdump-14 --macho --private-headers "$1"
}

# is_of_kind KIND FILE
is_of_kind() {
    headers_of "$2" | grep -iE "^MH_MAGIC_64 +(ARM64|X86_64) .* $1 " | tee /dev/stderr | grep -qiE " $architecture "
}

needs_libsystem_alone() {
    local needed
    needed=$(headers_of "$1" | grep -A 2 -E 'cmd LC_(LOAD|LOAD_WEAK|REEXPORT|LAZY_LOAD)_DYLIB' | sed -n 's/^ *name \(.*\) (offset.*$/\1/p')
    echo "$1 needs: $needed"
    [[ $needed == /usr/lib/libSystem.B.dylib ]]
}

has_no_path_of_this_machine() {
    [[ -f $1 ]] && ! headers_of "$1" | grep -E 'LC_RPATH|/(tmp|work|home|root|build)/' && ! grep -aoF -m 1 "$(realpath "$build")" "$1"
}

is_for_macos_11() {
    headers_of "$1" | grep -A 5 LC_BUILD_VERSION | tee /dev/stderr | grep -qE 'minos 11\.0'
}

has_install_name() {
    headers_of "$1" | grep -A 2 LC_ID_DYLIB | tee /dev/stderr | grep -qE "name @rpath/libcurvopt\.[0-9]+\.[0-9]+\.dylib "
}

exports_the_list() {
    diff "$symbols" <(llvm-nm-14 --extern-only --defined-only "$1" | sed -n 's/^.* [A-Z] _//p' | LC_ALL=C sort)
}

# On Apple's processors every file must be signed, if only by a sum of its own pages ("ad hoc"), as the linker does.
is_signed() {
    [[ -f $1 ]] && { [[ $architecture != arm64 ]] || headers_of "$1" | grep -q LC_CODE_SIGNATURE; }
}

asks_libsystem_for_what_it_has() {
    local asked
    asked=$(llvm-nm-14 --undefined-only --format=posix "$1" | cut -d ' ' -f 1 | sort -u)
    [[ $asked == *_malloc* ]] || return
    ! comm -23 <(echo "$asked") <(grep -oE "[_a-zA-Z][_a-zA-Z0-9\$]*" "$list" | sort -u) | grep .
}

check "libcurvopt.dylib is a library for $architecture" is_of_kind DYLIB "$build/libcurvopt.dylib"
check "curvopt is a program for $architecture" is_of_kind EXECUTE "$build/curvopt"
check "libcurvopt.dylib has its install name" has_install_name "$build/libcurvopt.dylib"
check "libcurvopt.dylib exports what the headers declare" exports_the_list "$build/libcurvopt.dylib"
for file in libcurvopt.dylib curvopt; do
    check "$file needs libSystem alone" needs_libsystem_alone "$build/$file"
    check "$file has no path of this machine" has_no_path_of_this_machine "$build/$file"
    check "$file is for macOS 11 and later" is_for_macos_11 "$build/$file"
    check "$file is signed where that must be" is_signed "$build/$file"
    check "$file asks libSystem for what it has" asks_libsystem_for_what_it_has "$build/$file"
done
end_of_checks

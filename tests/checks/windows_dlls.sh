#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The Windows build from outside: which DLLs it needs (the system's alone); what the library and its import library export;
# that the library opens no console window: no subsystem of consoles, nothing that starts programs or asks for a console.
#   windows_dlls.sh FOLDER     such as build/windows-x64
set -uo pipefail
# shellcheck source=tests/check.sh
source "$(dirname "$0")/../check.sh"
build=$1
symbols=$(dirname "$0")/../abi/symbols.txt

needs_system_dlls_alone() {
    local needed
    needed=$(objdump -p "$1" | sed -n 's/^.*DLL Name: //p')
    echo "$1 needs: $needed"
    [[ -n $needed ]] && ! grep -vxiE 'kernel32\.dll|msvcrt\.dll|shell32\.dll' <<<"$needed"
}

exports_the_list() {
    diff "$symbols" <(objdump -p "$build/curvopt.dll" |
        sed -nE 's/^\s+\[ *[0-9]+\] (\+base\[ *[0-9]+\] +[0-9a-f]+ )?(\S+)$/\2/p' | LC_ALL=C sort -u)
}

import_library_has_the_list() {
    x86_64-w64-mingw32-nm "$build/libcurvopt.dll.a" 2>/dev/null | sed -n 's/^.* T //p' | LC_ALL=C sort -u | diff "$symbols" -
}

# Imported functions, one a line: address, hint, name.
imports_of() {
    objdump -p "$1" | sed -n '/Import Tables/,/Export Tables/p' | awk 'NF == 3 && $1 ~ /^[0-9a-f]+$/ { print $3 }'
}

STARTS_OR_SHOWS='(CreateProcess|WinExec|ShellExecute|_w?system$|system$|_w?popen|_w?spawn|_w?exec|AllocConsole|AttachConsole|MessageBox)'
opens_no_console() {
    local imports
    imports=$(imports_of "$build/curvopt.dll")
    grep -qx CloseHandle <<<"$imports" || { echo "no imports were read" && return 1; }
    ! grep -E "^$STARTS_OR_SHOWS" <<<"$imports" || return
    objdump -p "$build/curvopt.dll" | grep '^Subsystem' | tee /dev/stderr | grep -q 'Windows GUI'
}

for file in curvopt.dll curvopt.exe; do
    check "$file needs DLLs of the system alone" needs_system_dlls_alone "$build/$file"
done
check "curvopt.dll exports what the headers declare" exports_the_list
check "libcurvopt.dll.a has what the headers declare" import_library_has_the_list
check "curvopt.dll opens no console window" opens_no_console
end_of_checks

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Which DLLs the Windows build needs: the system's alone; the library, and its import library, have the exported functions.
#   windows_dlls.sh FOLDER     such as build/windows-x64
set -uo pipefail
failed=0 passed=0
for file in "$1/curvopt.dll" "$1/curvopt.exe"; do
    needed=$(objdump -p "$file" | sed -n 's/^.*DLL Name: //p')
    if [[ -n $needed ]] && ! grep -vxiE 'kernel32\.dll|msvcrt\.dll|shell32\.dll' <<<"$needed"; then
        passed=$((passed + 1))
    else
        echo "$file needs: $needed" >&2
        failed=$((failed + 1))
    fi
done
names=$(objdump -p "$1/curvopt.dll" | sed -nE 's/^\s+\[ *[0-9]+\] (\+base\[ *[0-9]+\] +[0-9a-f]+ )?(\S+)$/\2/p' | LC_ALL=C sort -u)
if diff "$(dirname "$0")/../abi/symbols.txt" <(echo "$names"); then passed=$((passed + 1)); else failed=$((failed + 1)); fi
if x86_64-w64-mingw32-nm "$1/libcurvopt.dll.a" 2>/dev/null | sed -n 's/^.* T //p' | LC_ALL=C sort -u |
    diff "$(dirname "$0")/../abi/symbols.txt" -; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
echo "$passed passed, $failed failed"
((failed == 0))

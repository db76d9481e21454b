#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The shared library from outside: what it exports, what it needs.
#   check_library.sh symbols|versions|needed LIBRARY
set -euo pipefail
library=$2
folder=$(dirname "$0")

case $1 in
symbols) # exactly the committed list, and nothing that the header does not declare
    nm -D --defined-only "$library" | awk '{ print $NF }' | LC_ALL=C sort | diff "$folder/symbols.txt" - || {
        echo "left: tests/abi/symbols.txt; right: what the library exports" >&2
        exit 1
    }
    ;;
versions) # glibc's, at most those of Debian 7 and CentOS 7
    newest=2.17
    objdump -T "$library" | sed -nE 's/.*\(?GLIBC_([0-9.]+)\)? +(.*)$/\1 \2/p' | while read -r version symbol; do
        if [[ $(printf '%s\n' "$version" $newest | sort -V | tail -n 1) != "$newest" ]]; then
            echo "$symbol needs glibc $version; $newest is the newest allowed" >&2
            echo bad
        fi
    done | grep -q bad && exit 1
    objdump -T "$library" | grep -q GLIBC_ # or this has looked at nothing
    ;;
needed)
    readelf -d "$library" | sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p' | LC_ALL=C sort >/dev/stderr
    ! readelf -d "$library" | sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p' |
        grep -vE '^(libc\.so\.6|libm\.so\.6|libgomp\.so\.1|ld-linux-[a-z0-9-]+\.so\.2)$'
    readelf -d "$library" | grep -q NEEDED
    ! readelf -d "$library" | grep -E 'RPATH|RUNPATH|TEXTREL'
    ;;
*)
    echo "usage: check_library.sh symbols|versions|needed LIBRARY" >&2
    exit 2
    ;;
esac

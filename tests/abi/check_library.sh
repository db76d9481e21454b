#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The shared library from outside: what it exports, what it needs.
#   check_library.sh symbols|versions|needed|calls LIBRARY
set -euo pipefail
library=$2
folder=$(dirname "$0")
debian=$folder/../../libcurvopt/packaging/debian/libcurvopt0.1.symbols

case $1 in
symbols) # exactly the committed list, which Debian's package has, too, and nothing that the header does not declare
    nm -D --defined-only "$library" | awk '{ print $NF }' | LC_ALL=C sort | diff "$folder/symbols.txt" - || {
        echo "left: tests/abi/symbols.txt; right: what the library exports" >&2
        exit 1
    }
    sed -nE 's/^ ([a-z0-9_]+)@.*/\1/p' "$debian" | LC_ALL=C sort | diff "$folder/symbols.txt" - || {
        echo "left: tests/abi/symbols.txt; right: $debian" >&2
        exit 1
    }
    ;;
versions) # glibc's, at most those of Debian 7 and CentOS 7
    newest=2.17
    needs=$(objdump -T "$library" | sed -nE 's/.*GLIBC_([0-9.]+)\)? +(.*)$/\1 \2/p')
    [[ -n $needs ]] # or this has looked at nothing
    failed=0
    while read -r version symbol; do
        if [[ $(printf '%s\n' "$version" $newest | sort -V | tail -n 1) != "$newest" ]]; then
            echo "$symbol needs glibc $version; $newest is the newest allowed" >&2
            failed=1
        fi
    done <<<"$needs"
    exit $failed
    ;;
needed) # what every Linux has, and no place of this machine
    dynamic=$(readelf -d "$library")
    [[ $dynamic == *NEEDED* ]]
    libraries=$(sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p' <<<"$dynamic")
    if grep -vxE 'libc\.so\.6|libm\.so\.6|ld-linux-[a-z0-9-]+\.so\.2' <<<"$libraries"; then
        echo "the library needs what stands above" >&2
        exit 1
    fi
    if grep -E 'RPATH|RUNPATH|TEXTREL' <<<"$dynamic"; then
        exit 1
    fi
    ;;
calls) # memory, threads, mathematics and the clock alone; no files, processes, environment, network: addon/manual/TRUST.md
    calls=$(nm -D --undefined-only "$library" | sed -nE 's/.* [UwW] ([A-Za-z0-9_]+).*/\1/p')
    grep -qx malloc <<<"$calls" # or this has looked at nothing
    # madvise: huge pages for large blocks
    memory='malloc|calloc|realloc|free|aligned_alloc|madvise|mem(cmp|cpy|move|set)|str(cmp|len|ncmp|chr)|qsort'
    threads='pthread_(create|join|sigmask)|pthread_(cond|mutex)_[a-z]+|sigfillset|sched_(getaffinity|yield)|sysconf'
    mathematics='sqrt|fm(ax|in|od|a)|asin|frexp|ldexp|floor|ceil|round|trunc|l?rint|copysign'
    text='vsnprintf|snprintf|printf|fprintf|puts|fputs|putchar|fputc|fwrite|fflush|std(out|err)' # printf: CHOLMOD's, off
    # __getauxval: GCC's, on arm64, for the processor's atomic instructions
    others='clock_gettime|abort|_ITM_[A-Za-z]+|__(cxa_finalize|getauxval|gmon_start__|stack_chk_fail|sched_cpucount|[a-z]+_chk)'
    if grep -vxE "$memory|$threads|$mathematics|$text|$others" <<<"$calls"; then
        echo "the library calls what stands above, which this list does not allow" >&2
        exit 1
    fi
    ;;
*)
    echo "usage: check_library.sh symbols|versions|needed|calls LIBRARY" >&2
    exit 2
    ;;
esac

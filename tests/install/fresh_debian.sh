#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Tries the README's commands as a newcomer would: in a fresh Debian 12, made in a folder by debootstrap, that has
# nothing but apt. Copies the committed files there, not the working tree. Needs root, the network, debootstrap and
# 4 GB; changes nothing outside the folder.
#
#   bash tests/install/fresh_debian.sh DIR                  the demo, then the tests
#   bash tests/install/fresh_debian.sh DIR COMMAND...       some other command, run in the checkout's copy
#
# DIR is made if it does not exist. If it does, it is used again as it is, but for a new copy of the committed files. The
# machine's own /dev is never bound into it (whoever deletes the folder would delete the devices too).
set -euo pipefail

SUITE=bookworm
CHECKOUT=/root/curvopt # in the fresh system

die() {
    printf 'fresh_debian: %s\n' "$*" >&2
    exit 1
}

# make DIR
make() {
    command -v debootstrap >/dev/null || die "debootstrap is missing; run: apt-get install debootstrap"
    printf 'fresh_debian: making Debian %s in %s\n' "$SUITE" "$1"
    debootstrap --variant=minbase "$SUITE" "$1" >"$1.log" 2>&1 ||
        die "debootstrap failed; its output is in $1.log"
    cp /etc/resolv.conf "$1/etc/resolv.conf"
}

# inside DIR COMMAND...: as root in the fresh system, in its checkout, with an environment of its own.
inside() {
    local root=$1
    shift
    # shellcheck disable=SC2016 # expanded by the shell in the new mount namespace
    ROOT=$root CHECKOUT=$CHECKOUT unshare --mount --propagation private bash -c '
        mount -t proc proc "$ROOT/proc"
        mount -t sysfs -o ro sys "$ROOT/sys" # MPI looks there for processors
        exec env -i HOME=/root LANG=C.UTF-8 TERM=dumb PATH=/usr/sbin:/usr/bin:/sbin:/bin \
            chroot "$ROOT" sh -c "cd $CHECKOUT && exec \"\$@\"" sh "$@"' bash "$@"
}

# timed DIR COMMAND...
timed() {
    local before=$SECONDS code=0
    inside "$@" || code=$?
    shift
    printf 'fresh_debian: %s: exit code %d, %d s\n' "$*" "$code" $((SECONDS - before))
    return "$code"
}

main() {
    local root failed=0
    (($# > 0)) || die "which folder? usage: fresh_debian.sh DIR [COMMAND...]"
    [[ $(id -u) == 0 ]] || die "debootstrap and chroot need root"
    root=$(realpath -m -- "$1")
    shift
    cd "$(dirname "$0")/../.."
    [[ -e $root ]] || make "$root"
    [[ -x $root/usr/bin/apt-get ]] || die "$root is there, but holds no Debian"
    rm -rf --one-file-system "${root:?}$CHECKOUT"
    mkdir -p "$root$CHECKOUT"
    git archive HEAD | tar -x -C "$root$CHECKOUT"
    if (($# > 0)); then
        timed "$root" "$@"
        return
    fi
    timed "$root" bash blend_files/demo.sh || failed=1
    timed "$root" bash tests/run.sh || failed=1
    return "$failed"
}

main "$@"

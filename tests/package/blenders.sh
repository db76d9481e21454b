#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What build/release/dist holds, installed in fresh Blenders without a compiler: the zip for 3.4 to 4.1 in each; an extension, by
# mistake, in those that know none; in those of 4.2 and later, with Blender's own check of every extension zip, the extension
# from disk, another system's, too, and the static repository from a local address.
#
#   bash tests/package/blenders.sh [ROOT...]     here, and in the Debians in these folders (head of tests/addon/blenders.sh)
#
# Last line: "N passed, N failed". Needs root where there are ROOTs.
set -u
cd "$(dirname "$0")/../.." || exit 1
dist=$PWD/build/release/dist
work=$(mktemp -d -t curvopt-blenders-XXXXXX)
inside=/root/curvopt-package
passed=0
failed=0
server=

finish() {
    [ -z "$server" ] || kill "$server"
    rm -rf "$work"
}
trap finish EXIT

# count NAME LOG CODE: adds the last line's figures.
count() {
    local ok bad
    read -r ok bad < <(sed -nE 's/^(.*: )?([0-9]+) passed, ([0-9]+) failed$/\2 \3/p' "$2" | tail -n 1)
    if [ -z "${ok:-}" ] || { [ "$3" -ne 0 ] && [ "$bad" -eq 0 ]; }; then
        cat "$2"
        echo "FAIL $1: exit code $3"
        bad=$((${bad:-0} + 1))
    else
        grep -aE '^FAIL|^Error|passed,|pressed with|Traceback' "$2" | sed "s|^|$1: |"
    fi
    passed=$((passed + ${ok:-0}))
    failed=$((failed + bad))
}

# in_root ROOT COMMAND...: with a home and an environment of its own; "/" is this system.
in_root() {
    local root=$1
    shift
    if [ "$root" = / ]; then
        env -i HOME="$work/home" LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin "$@"
    else
        # shellcheck disable=SC2016 # expanded by the shell in the new mount namespace
        ROOT=$root unshare --mount --propagation private bash -c '
            mount -t proc proc "$ROOT/proc"
            exec env -i HOME='"$inside"'/home LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$ROOT" "$@"' sh "$@"
    fi
}

# try_blender ROOT FOLDER: the tests in FOLDER, which is the root's name of the copies.
try_blender() {
    local root=$1 folder=$2 version online=() zip extensions=("$dist"/extensions/*.zip)
    version=$(in_root "$root" blender --version 2>/dev/null | sed -nE 's/^Blender ([0-9]+\.[0-9]+).*/\1/p' | head -n 1)
    [ -n "$version" ] || { echo "FAIL: no Blender in $root" && failed=$((failed + 1)) && return; }
    [[ $version == 3.* || $version == 4.[01] ]] || online=(--online-mode)
    zip=$(basename "$dist"/*-blender-3.4-to-4.1.zip)
    in_root "$root" blender -b --factory-startup "${online[@]}" --python-exit-code 1 -P "$folder/install_in_blender.py" -- \
        legacy "$folder/dist/$zip" >"$work/log" 2>&1
    count "$version legacy zip" "$work/log" $?
    if [ ${#online[@]} -eq 0 ]; then
        in_root "$root" blender -b --factory-startup --python-exit-code 1 -P "$folder/install_in_blender.py" -- \
            mistaken "$folder/dist/extensions/$(basename "${extensions[0]}")" "$folder/dist/$zip" >"$work/log" 2>&1
        count "$version an extension by mistake" "$work/log" $?
        return
    fi
    for zip in "${extensions[@]}"; do
        if in_root "$root" blender --command extension validate "$folder/dist/extensions/$(basename "$zip")" >"$work/log" 2>&1; then
            echo "1 passed, 0 failed" >>"$work/log"
        else
            echo "0 passed, 1 failed" >>"$work/log"
        fi
        count "$version validates $(basename "$zip")" "$work/log" 0
    done
    try_from_disk "$root" "$folder" "$version"
    in_root "$root" blender --command extension server-generate --repo-dir "$folder/generated" >"$work/log" 2>&1
    python3 -B tests/package/same_index.py "$dist/extensions/index.json" "${root%/}$folder/generated/index.json" >"$work/log" 2>&1
    count "$version index.json" "$work/log" $?
    rm -f "$work/port"
    cp -r "$dist/extensions" "${root%/}$folder/served"
    python3 -B tests/package/serve.py "${root%/}$folder/served" >"$work/port" 2>/dev/null &
    server=$!
    until [ -s "$work/port" ]; do sleep 0.1; done
    in_root "$root" blender -b --factory-startup --online-mode --python-exit-code 1 -P "$folder/install_in_blender.py" -- \
        repository "http://127.0.0.1:$(cat "$work/port")/index.json" "$folder/served" "$folder/newer" >"$work/log" 2>&1
    count "$version repository" "$work/log" $?
    kill "$server"
    server=
}

# try_from_disk ROOT FOLDER VERSION: this system's extension, and another's, if there is one, which Blender refuses in a sentence.
try_from_disk() {
    local root=$1 folder=$2/dist/extensions version=$3 own others
    own=linux_$(uname -m | sed 's/x86_64/x64/; s/aarch64/arm64/')
    mapfile -t others < <(cd "$dist/extensions" && find . -name '*.zip' ! -name "*-$own.zip" -printf "$folder/%f\n" | sort | tail -n 1)
    in_root "$root" blender -b --factory-startup --online-mode --python-exit-code 1 -P "$2/install_in_blender.py" -- \
        from_disk "$folder/$(basename "$dist"/extensions/*-"$own".zip)" "${others[@]}" >"$work/log" 2>&1
    count "$version from disk" "$work/log" $?
    if [ ${#others[@]} -gt 0 ]; then
        if grep -qE "This platform \(.*\) isn't one of \(.*\)" "$work/log"; then
            echo "1 passed, 0 failed" >"$work/log"
        else
            echo "0 passed, 1 failed" >>"$work/log"
        fi
        count "$version another system's extension" "$work/log" 0
    fi
}

# copies FOLDER: what a root needs.
copies() {
    mkdir -p "$1"
    cp tests/package/install_in_blender.py "$1"
    cp -r "$dist" "$1"
    cp -r "$work/newer/build/release/dist/extensions" "$1/newer"
    mkdir "$1/generated"
    cp "$dist"/extensions/*.zip "$1/generated"
}

# A repository of the next version, for the update: the same sources under another number.
bash tests/package/next_version.sh "$work/newer" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
copies "$work/here"
try_blender / "$work/here"
for root in "$@"; do
    rm -rf --one-file-system "${root:?}$inside"
    copies "$root$inside"
    try_blender "$root" "$inside"
    rm -rf --one-file-system "${root:?}$inside"
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# From a fresh Debian 12 to a minimum variation surface of genus 2: installs what is needed (root, only if something is
# missing), builds, minimizes lawson_g2.blend, and says where the .blend and the picture are.
#
#   bash blend_files/demo.sh [DIR]      results in DIR; default: build/demo
set -euo pipefail
started=$SECONDS
output=$(realpath -m -- "${1:-$(dirname "$0")/../build/demo}")
cd "$(dirname "$0")/.."
# shellcheck source=tests/setup.sh
source tests/setup.sh

need "${BUILD_PACKAGES[@]}" "${BLENDER_PACKAGES[@]}"
build release addon || exit 1
mkdir -p "$output" || die "the folder $output cannot be made"

blend=$output/lawson_g2_mvs.blend
picture=$output/lawson_g2_mvs.png
say "minimizing MVS on blend_files/lawson_g2.blend; this takes a minute or two"
run_blender blend_files/lawson_g2.blend -P addon/batch.py -- \
    --energy mvs --levels 4 --strength 1 --output "$blend" --render "$picture" >"$output/blender.log" ||
    die "Blender's batch failed; its output is in $output/blender.log"
[[ -s $blend && -s $picture ]] || die "Blender's batch ended without writing $blend and $picture"

say "done in $((SECONDS - started)) s"
say "open in Blender: $blend"
say "before and after: $picture"

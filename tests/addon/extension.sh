#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Whether Blender's own check accepts the extension: bash extension.sh ZIP. Last line: "N passed, N failed".
set -u
if "${BLENDER:-blender}" --command extension validate "$1"; then
    echo "1 passed, 0 failed"
else
    echo "0 passed, 1 failed"
    exit 1
fi

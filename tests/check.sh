# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# To be sourced by scripts that count: check NAME COMMAND... counts whether the command succeeds, and shows its output if it
# does not; end_of_checks prints "N passed, N failed", and fails unless all passed.
passed=0
failed=0

check() {
    local name=$1 output
    shift
    if output=$("$@" 2>&1); then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        printf '%s: failed: %s\n%s\n' "$0" "$name" "$output" >&2
    fi
}

end_of_checks() {
    echo "$passed passed, $failed failed"
    ((failed == 0))
}

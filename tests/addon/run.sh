#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# All tests of the add-on and of the gallery: what needs no Blender; operator, batch and gallery in a background Blender;
# the add-on installed from both zips (the extension in Blenders that know them); the modal operator in a window. Needs the
# built library (or CURVOPT_LIBRARY), blender, pytest, Xvfb and imagemagick; a missing one is a failure. Last line:
# "N passed, N failed". BLENDER names another Blender.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
export PATH="/usr/bin:$PATH" PYTHONDONTWRITEBYTECODE=1
export CURVOPT_LIBRARY=${CURVOPT_LIBRARY:-$root/build/release/libcurvopt.so}
work=$(mktemp -d -t curvopt-addon-XXXXXX)
trap 'rm -rf "$work"' EXIT
passed=0
failed=0

# part NAME COMMAND...: runs it, its output in a file.
part() {
    local name=$1
    shift
    "$@" >"$work/$name.log" 2>&1
    echo $? >"$work/$name.code"
}

# report NAME...: shows the output of these parts, and adds the counts of its last pytest or "N passed, N failed" line. A
# part that dies, or that ran no test, counts as one more failure.
report() {
    local name line code ok bad
    for name in "$@"; do
        echo "== $name"
        cat "$work/$name.log"
        code=$(<"$work/$name.code")
        line=$(grep -E '(^|[^0-9])[0-9]+ (passed|failed|errors?)' "$work/$name.log" | tail -n 1)
        ok=$(grep -oE '[0-9]+ passed' <<<"$line" | grep -oE '[0-9]+')
        bad=$(grep -oE '[0-9]+ (failed|errors?)' <<<"$line" | grep -oE '[0-9]+' | paste -sd+ | sed 's/$/+0/;s/^+//')
        ok=${ok:-0}
        bad=$((${bad:-0}))
        if [ "$ok" -eq 0 ] || { [ "$code" -ne 0 ] && [ "$bad" -eq 0 ]; }; then
            echo "FAIL $name: exit code $code after $ok passed"
            bad=$((bad + 1))
        fi
        passed=$((passed + ok))
        failed=$((failed + bad))
    done
}

start=$SECONDS
zips=$root/build/release # as the build's target `addon` made them
some="new_object or off_and_on or shape_of_the_catalogue or presets or picture_and_report"
# The window, which waits for its screen at times, beside all others; of these two at a time. Its limits are of processor
# time; half a second of what a call waits for beside a processor; and timeouts for what waits for ever.
windows() {
    part window bash "$here/window/run.sh"
    part campaign bash "$here/window/campaign.sh" "$([ -n "${CURVOPT_LONG:-}" ] && echo 200 || echo 5)"
}
windows &
windows=$!
part background_1 /usr/bin/python3 "$here/run_in_blender.py" --deal 1/2 -q &
other=$!
part background_2 /usr/bin/python3 "$here/run_in_blender.py" --deal 2/2 -q
wait "$other"
part library /usr/bin/python3 -m pytest -q -p no:cacheprovider --rootdir "$here" "$here"/test_*.py &
other=$!
part zip /usr/bin/python3 "$here/run_in_blender.py" --addon "$zips/curvopt_addon.zip" -q -k "$some"
wait "$other"
report library background_1 background_2 zip
if [[ $(blender --version 2>/dev/null) == "Blender "[5-9]* || $(blender --version 2>/dev/null) == "Blender 4."[2-9]* ]]; then
    part manifest bash "$here/extension.sh" "$zips/curvopt_extension.zip"
    part extension /usr/bin/python3 "$here/run_in_blender.py" --extension "$zips/curvopt_extension.zip" -q -k "$some"
    report manifest extension
fi
wait "$windows"
report window campaign
echo "add-on tests took $((SECONDS - start)) s"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]

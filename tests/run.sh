#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Every test of the project, on a fresh Debian 12 as on a developer's machine: installs what is missing (root, only
# then), builds, runs each part to its end whatever the others did. Logs: build/tests/PART.log.
#
#   bash tests/run.sh               everything
#   bash tests/run.sh PART...       some parts, such as cages or numeric; a wrong one lists them
#
# The last line is "N passed, N failed". A part that cannot run, or runs nothing, is a failure.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
# shellcheck source=tests/setup.sh
source tests/setup.sh

PYTHON=/usr/bin/python3
PARTS=(format cppcheck cages blends release asan numeric tao addon)
LOGS=build/tests
# By name only. tidy warns of paths that no status code allows; install waits for the build's install rules.
EXTRA=(tidy install)
LIMIT=900 # seconds a part may take
total_passed=0
total_failed=0
results=()

# Each part is a function run_PART. Its tests are counted from what it prints (counts_of): the summary of ctest or of
# pytest, or a line "N passed, N failed"; a check without a summary counts as one test.

sources() {
    find libcurvopt tests -name '*.[ch]' "$@"
}

run_format() {
    sources -print0 | xargs -0 clang-format --dry-run -Werror
}

run_cppcheck() {
    cppcheck --std=c11 --enable=warning,performance,portability --inline-suppr --suppress=missingIncludeSystem \
        --suppressions-list=tests/cppcheck-suppressions.txt --error-exitcode=1 --quiet -j "$(nproc)" \
        -I libcurvopt/include -I libcurvopt/src -I libcurvopt/tools libcurvopt
}

run_tidy() { # which checks, and why not others: .clang-tidy
    cmake -DCMAKE_EXPORT_COMPILE_COMMANDS=ON build/release >/dev/null &&
        find libcurvopt tests/unit tests/robust tests/fuzz tests/abi -name '*.c' -print0 |
        xargs -0 -P "$(nproc)" -n 4 clang-tidy --quiet -p build/release
}

run_cages() {
    "$PYTHON" blend_files/cages.py --check
}

run_blends() {
    run_blender -P blend_files/make_blends.py -- --check
}

run_release() {
    ctest_of release
}

run_asan() {
    ctest_of asan
}

ctest_of() {
    ctest --test-dir "build/$1" --label-regex '^(unit|robust|abi)$' --no-tests=error --output-on-failure \
        --parallel "$(nproc)"
}

run_install() {
    bash tests/install/run.sh
}

run_numeric() {
    env -u PYTHONPATH "$PYTHON" -B -m pytest -q -p no:cacheprovider tests/numeric
}

# curvopt-tao is off in every preset: this part alone turns it on.
run_tao() {
    if ! has_petsc; then
        echo "skipped: no PETSc (${TAO_PACKAGES[*]%%:*}; with CURVOPT_TAO=1 they are installed)"
        return 0
    fi
    cmake --preset release -DCURVOPT_TAO=ON >/dev/null && cmake --build --preset release --target curvopt_tao &&
        env -u PYTHONPATH "$PYTHON" -B -m pytest -q -p no:cacheprovider tests/tao
}

run_addon() {
    bash tests/addon/run.sh
}

# count WORDS FILE: the number before any of the words in the file's last summary line; nothing if there is none.
count() {
    local line
    line=$(grep -aE '(^| )[0-9]+ (passed|failed|errors?)(,| in |$)' "$2" | tail -n 1)
    [[ -n $line ]] && grep -oE "[0-9]+ ($1)" <<<"$line" | awk '{ n += $1 } END { print n + 0 }'
}

# counts_of PART LOG CODE: prints "passed failed", and why if the part failed otherwise than by a test.
counts_of() {
    local passed='' failed='' total
    case $1 in
    format | cppcheck | tidy)
        echo $(($3 == 0)) $(($3 != 0))
        return
        ;;
    release | asan)
        read -r failed total < <(sed -nE 's/^.*tests passed, ([0-9]+) tests? failed out of ([0-9]+).*$/\1 \2/p' "$2")
        passed=${failed:+$((total - failed))}
        ;;
    tao)
        if [[ $3 == 0 ]] && grep -q '^skipped: no PETSc' "$2"; then
            echo "0 0 $(grep -m 1 '^skipped:' "$2")"
            return
        fi
        passed=$(count passed "$2")
        failed=$(count 'failed|errors?' "$2")
        ;;
    *)
        passed=$(count passed "$2")
        failed=$(count 'failed|errors?' "$2")
        ;;
    esac
    if [[ $3 == 124 ]]; then
        echo "${passed:-0} $((${failed:-0} + 1)) stopped after $LIMIT s"
    elif [[ -z $passed ]]; then
        echo "0 1 exit code $3 and no summary"
    elif (($3 != 0 && failed == 0)); then
        echo "$passed 1 exit code $3"
    elif ((passed + failed == 0)); then
        echo "0 1 it ran nothing"
    else
        echo "$passed $failed"
    fi
}

# execute PART: runs it for at most LIMIT seconds in a process of its own and adds what it counted to the totals.
execute() {
    local log=$LOGS/$1.log before=$SECONDS code passed failed why
    say "$1 ..."
    timeout --kill-after=10 "$LIMIT" bash tests/run.sh --part "$1" </dev/null 2>&1 | tee "$log"
    code=${PIPESTATUS[0]}
    read -r passed failed why < <(counts_of "$1" "$log" "$code")
    record "$1" "$passed" "$failed" $((SECONDS - before)) "$why"
}

# record PART PASSED FAILED SECONDS WHY
record() {
    total_passed=$((total_passed + $2))
    total_failed=$((total_failed + $3))
    results+=("$(printf '%-9s %5d passed %4d failed %5d s  %s' "$@")")
    say "${results[-1]}"
}

# presets PART...: the builds that these parts use.
presets() {
    local part
    for part in "$@"; do
        case $part in
        tidy | release | install | numeric | tao | addon) echo release ;;
        asan) echo asan ;;
        esac
    done | sort -ru
}

main() {
    local part preset before wanted=(release debug asan)
    (($# == 0)) || mapfile -t wanted < <(presets "$@")
    (($# > 0)) || set -- "${PARTS[@]}"
    for part in "$@"; do
        [[ " ${PARTS[*]} ${EXTRA[*]} " == *" $part "* ]] ||
            die "there is no part '$part'; the parts are: ${PARTS[*]}, and by name only: ${EXTRA[*]}"
    done
    need "${BUILD_PACKAGES[@]}" "${BLENDER_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
    [[ " $* " != *" tao "* || ${CURVOPT_TAO:-} != 1 ]] || need "${TAO_PACKAGES[@]}"
    [[ " $* " != *" tidy "* ]] || need clang-tidy:clang-tidy
    mkdir -p "$LOGS"
    for preset in "${wanted[@]}"; do
        before=$SECONDS
        build "$preset" || record "$preset" 0 1 $((SECONDS - before)) "it does not build"
    done
    for part in "$@"; do
        execute "$part"
    done
    say "in all, $SECONDS s:"
    printf '  %s\n' "${results[@]}"
    echo "$total_passed passed, $total_failed failed"
    ((total_failed == 0))
}

if [[ ${1:-} == --part ]]; then
    "run_$2"
else
    main "$@"
fi

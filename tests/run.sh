#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Every test of the project, on a fresh Debian 12 as on a developer's machine: installs what the wanted parts need and
# have not got (as root), builds, runs each part to its end whatever the others did. Logs: build/tests/PART.log.
#
#   bash tests/run.sh               every part
#   bash tests/run.sh PART...       only these, such as format or release; a wrong name lists them
#
# The parts tao and wine are skipped, and say so, where what they need is not there: PETSc; Wine, the compiler for Windows and
# CHOLMOD made by it.
#
# At the end: passed, failed and seconds of each part, which may have run beside others; what was skipped, and why; the ten
# slowest tests. The last line is "N passed, N failed". A part that cannot run, or runs nothing, is a failure.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
# shellcheck source=tests/setup.sh
source tests/setup.sh
export PYTEST_ADDOPTS="--durations=0 --durations-min=1 -rs ${PYTEST_ADDOPTS:-}" # for report_times, report_skipped

PYTHON=/usr/bin/python3
PARTS=(format cppcheck tidy cages blends release install asan tsan numeric tao python wine addon)
# Most of their time these keep one processor busy: they run one after another, in their order, beside the parts of
# BESIDE_THEM, and end before any other part begins (tao builds in the folder that they read).
ONE_PROCESSOR=(format cages blends install python wine)
BESIDE_THEM=(cppcheck tidy release asan tsan numeric)
EXTRA=(coverage package windows arm64 macos reproducible) # by name only: coverage's time in a whole run is not measured yet;
# package needs root; windows and arm64 run in Wine and qemu, which takes minutes; macos needs npm; reproducible builds all of
# them twice
LOGS=build/tests
LIMIT=3600   # CPU seconds a part may take, all its processes; on the clock a busy machine takes ten times as long
[[ " $* " != *" arm64 "* && " $* " != *" reproducible "* ]] || LIMIT=14400 # qemu is 50 to 100 times as slow
TEST_LIMIT=900 # CPU seconds of one process of a test in C; 85 are the most, under the sanitizers
SLOW=5       # seconds; tests above it are counted at the end
COVERAGE=95  # percent of the lines of libcurvopt/src that must run in the part coverage
total_passed=0
total_failed=0
results=()

# packages_of PART: what apt must have installed for it, besides bash and coreutils.
packages_of() {
    case $1 in
    format) echo python3:python3 clang-format:clang-format ;;
    cppcheck) echo cppcheck:cppcheck ;;
    tidy) echo "${CTEST_PACKAGES[@]}" clang-tidy:clang-tidy libclang-rt-dev ;; # the last for msan_interface.h
    cages) echo python3-numpy ;;
    blends) echo "${BLENDER_PACKAGES[@]}" ;;
    release | asan | tsan | coverage | wine) echo "${CTEST_PACKAGES[@]}" ;;
    install) echo "${CTEST_PACKAGES[@]}" pkg-config:pkg-config ;;
    numeric) echo "${CTEST_PACKAGES[@]}" "${PYTEST_PACKAGES[@]}" python3-pytest-xdist python3-scipy libosd-dev ;;
    tao)
        echo "${CTEST_PACKAGES[@]}" "${PYTEST_PACKAGES[@]}" python3-pytest-xdist
        [[ ${CURVOPT_TAO:-} != 1 ]] || echo "${TAO_PACKAGES[@]}"
        ;;
    python) echo "${CTEST_PACKAGES[@]}" "${PYTEST_PACKAGES[@]}" python3-venv python3-matplotlib ;;
    package) echo "${CTEST_PACKAGES[@]}" "${BLENDER_PACKAGES[@]}" "${DEBIAN_PACKAGES[@]}" ;;
    windows) echo "${CROSS_PACKAGES[@]}" "${WINDOWS_PACKAGES[@]}" ;;
    arm64) echo "${CROSS_PACKAGES[@]}" "${ARM64_PACKAGES[@]}" ;;
    macos) echo "${CROSS_PACKAGES[@]}" "${MACOS_PACKAGES[@]}" ;;
    reproducible) echo git:git "${CTEST_PACKAGES[@]}" "${CROSS_PACKAGES[@]}" ;;
    addon) echo "${CTEST_PACKAGES[@]}" "${PYTEST_PACKAGES[@]}" "${BLENDER_PACKAGES[@]}" xvfb:Xvfb imagemagick:import ;;
    esac
}

# preset_of PART: the build that it uses. The preset debug is for debuggers; no part uses it.
preset_of() {
    case $1 in
    release | install | numeric | tao | python | wine | addon | package) echo release ;;
    asan | tsan | coverage) echo "$1" ;;
    windows) echo windows-x64 ;;
    arm64) echo linux-arm64 ;;
    macos) echo macos-arm64 && echo macos-x64 ;;
    esac
}

# The tests that use several threads, which run under the thread sanitizer; nothing else is built with it.
THREADED=(thread_pool work_sharing cancel minimize supernodal_cholesky)

# targets_of PRESET: what is built of it, if not everything.
targets_of() {
    [[ $1 != tsan ]] || printf '%s\n' "${THREADED[@]/#/test_}"
}

# Each part is a function run_PART. Its tests are counted from what it prints (counts_of): the summary of ctest or of
# pytest, or a line "N passed, N failed"; a check without a summary counts as one test.

sources() {
    find libcurvopt tests -name '*.[ch]' "$@"
}

# clang-format; the flow of the sources (tests/checks/flow.py); a fuzzer for each function; tests of the scripts in tests/checks.
run_format() {
    local passed=0 failed=0 script ok bad
    if sources -print0 | xargs -0 clang-format --dry-run -Werror; then passed=1; else failed=1; fi
    for script in test_flow flow fuzzed test_results; do
        "$PYTHON" -B "tests/checks/$script.py" | tee "$LOGS/$script.txt"
        ok=0 bad=1
        read -r ok _ bad _ < <(tail -n 1 "$LOGS/$script.txt")
        passed=$((passed + ok)) failed=$((failed + bad))
    done
    echo "$passed passed, $failed failed"
    ((failed == 0))
}

run_cppcheck() { # its own -j works on one file at a time
    find libcurvopt -name '*.c' -print0 |
        xargs -0 -P "$(nproc)" -n 8 cppcheck --std=c11 --enable=warning,performance,portability --inline-suppr \
            --suppress=missingIncludeSystem --suppressions-list=tests/cppcheck-suppressions.txt --error-exitcode=1 --quiet \
            -I libcurvopt/include -I libcurvopt/src -I libcurvopt/tools
}

run_tidy() { # which checks, and why not others: .clang-tidy. Most of the time is the analyzer's
    local nodes=() of_tests=(--checks=-clang-analyzer-*)
    [[ -z ${CURVOPT_LONG:-} ]] || nodes=(--extra-arg={-Xclang,-analyzer-config,-Xclang,max-nodes=225000}) of_tests=("${nodes[@]}")
    c_files libcurvopt/src libcurvopt/tools | tidy "${nodes[@]}" &&
        c_files tests/unit tests/robust tests/fuzz tests/abi | tidy "${of_tests[@]}"
}

c_files() { # FOLDER...: those that this system compiles
    find "$@" -name '*.c' ! -name '*_windows.c' -print0
}

tidy() { # OPTION...
    xargs -0 -P "$(nproc)" -n 4 clang-tidy --quiet -p build/release "$@"
}

run_cages() {
    "$PYTHON" blend_files/cages.py --check
}

run_blends() {
    run_blender -P blend_files/make_blends.py -- --check
}

run_release() { # asan has the same cases of what takes longest
    local less=(--exclude-regex '^robust[.](oom|oom_open|fuzz_mesh)$')
    [[ -z ${CURVOPT_LONG:-} ]] || less=()
    ctest_of release '^(unit|robust|abi)$' "${less[@]}"
}

run_asan() {
    ctest_of asan '^(unit|robust|abi)$'
}

run_tsan() {
    ctest --test-dir build/tsan --tests-regex "^unit\\.($(IFS='|' && echo "${THREADED[*]}"))\$" --no-tests=error \
        --output-on-failure --parallel "$(nproc)"
}

# ctest_of PRESET LABELS [OPTION...]
ctest_of() {
    [[ $1 == linux-arm64 || $1 == windows-x64 ]] || ulimit -t "$TEST_LIMIT"
    ctest --test-dir "build/$1" --label-regex "$2" --no-tests=error --output-on-failure --parallel "$(nproc)" "${@:3}"
}

# The tests of `release`, and runs of the command line, in a build that counts which lines have run. There the default is
# one thread (CMakePresets.json): two would fight for the counters, and take five times as long.
run_coverage() {
    find build/coverage -name '*.gcda' -delete
    ctest_of coverage '^(unit|robust|abi)$' || return
    bash tests/checks/coverage_runs.sh build/coverage/curvopt || return
    "$PYTHON" -B tests/checks/coverage.py build/coverage --least "$COVERAGE"
}

run_install() {
    bash tests/install/run.sh
}

# One process for each core, each with one thread: tests/numeric/conftest.py.
run_numeric() {
    env -u PYTHONPATH "$PYTHON" -B -m pytest -q -p no:cacheprovider -n "$(nproc)" tests/numeric
}

# curvopt-tao is off in every preset: this part alone turns it on.
run_tao() {
    if ! has_petsc; then
        echo "skipped: no PETSc (${TAO_PACKAGES[*]%%:*}; with CURVOPT_TAO=1 they are installed)"
        return 0
    fi
    cmake --preset release -DCURVOPT_TAO=ON >/dev/null && cmake --build --preset release --target curvopt_tao &&
        env -u PYTHONPATH "$PYTHON" -B -m pytest -q -p no:cacheprovider -n "$(nproc)" tests/tao
}

# The Python package, its examples, what the target dist makes, and what bad installs are told.
run_python() {
    env -u PYTHONPATH "$PYTHON" -B -m pytest -q -p no:cacheprovider tests/package
}

run_package() {
    bash tests/package/run.sh
}

# The tests in C, and those of the command line, for other platforms. CTest calls Wine or qemu
# (CMAKE_CROSSCOMPILING_EMULATOR of the toolchain file).
run_windows() {
    local code
    wine_starts || { echo "Wine does not start" >&2 && return 1; }
    ctest_of windows-x64 '^(unit|robust|abi)$'
    code=$?
    wine_ends
    say_skipped windows-x64
    return $code
}

run_arm64() {
    ctest_of linux-arm64 '^(unit|robust|abi)$'
    local code=$?
    say_skipped linux-arm64
    return $code
}

# say_skipped PRESET: the tests of the command line that cannot be on that platform, and why.
say_skipped() {
    sed -n 's/^skipped - /not on this platform: /p' "build/$1/Testing/Temporary/LastTest.log"
}

# A part of windows, wherever it can run without installing anything.
run_wine() {
    bash tests/checks/wine.sh
}

# Built, not run: nothing here can run it.
run_macos() {
    local ok bad passed=0 failed=0 architecture
    for architecture in arm64 x86_64; do
        bash tests/checks/macos_files.sh "build/macos-${architecture/x86_64/x64}" "$architecture" | tee "$LOGS/macos_files.txt"
        ok=0 bad=1
        read -r ok _ bad _ < <(tail -n 1 "$LOGS/macos_files.txt")
        passed=$((passed + ok)) failed=$((failed + bad))
    done
    echo "$passed passed, $failed failed"
    ((failed == 0))
}

run_reproducible() {
    bash tests/package/reproducible.sh
}

# archives_of PRESET: CHOLMOD and cmocka for a cross build, if it is one.
archives_of() {
    case $1 in
    windows-x64) bash libcurvopt/toolchains/archives.sh x86_64-w64-mingw32 ;;
    linux-arm64) bash libcurvopt/toolchains/archives.sh aarch64-linux-gnu ;;
    macos-arm64) bash libcurvopt/toolchains/archives.sh arm64-apple-macos11 ;;
    macos-x64) bash libcurvopt/toolchains/archives.sh x86_64-apple-macos11 ;;
    esac >"$LOGS/archives-$1.log" 2>&1 || { tail -n 20 "$LOGS/archives-$1.log" >&2 && return 1; }
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
    cppcheck | tidy)
        echo $(($3 == 0)) $(($3 != 0))
        return
        ;;
    release | asan | tsan | windows | arm64)
        read -r failed total < <(sed -nE 's/^.*tests passed, ([0-9]+) tests? failed out of ([0-9]+).*$/\1 \2/p' "$2")
        passed=${failed:+$((total - failed))}
        ;;
    tao | wine)
        if [[ $3 == 0 ]] && grep -q '^skipped: ' "$2"; then
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
        echo "${passed:-0} $((${failed:-0} + 1)) stopped, $(sed -n 's/^cpu_limit: //p' "$2" | tail -n 1)"
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

# execute PART: runs it for at most LIMIT CPU seconds in a session of its own. What it counted: LOGS/PART.result.
execute() {
    local log=$LOGS/$1.log before=$SECONDS code passed failed why
    say "$1 ..."
    bash tests/cpu_limit.sh "$LIMIT" bash tests/run.sh --part "$1" </dev/null 2>&1 | tee "$log"
    code=${PIPESTATUS[0]}
    read -r passed failed why < <(counts_of "$1" "$log" "$code")
    echo "$passed $failed $((SECONDS - before)) $why" >"$LOGS/$1.result"
    say "$(line "$1" "$passed" "$failed" $((SECONDS - before)) "$why")"
}

# execute_quietly PART...: one after another; the output of each at its end.
execute_quietly() {
    local part output
    for part in "$@"; do
        output=$(execute "$part" 2>&1)
        echo "$output"
    done
}

# execute_all PART...
execute_all() {
    local part others=() beside
    for part in "$@"; do
        [[ " ${ONE_PROCESSOR[*]} " != *" $part "* ]] || others+=("$part")
        rm -f "$LOGS/$part.result"
    done
    env --default-signal=INT,QUIT bash tests/run.sh --quietly "${others[@]}" & # see cpu_limit.sh
    beside=$!
    for part in "$@"; do
        [[ " ${others[*]} " != *" $part "* ]] || continue
        [[ " ${BESIDE_THEM[*]} " == *" $part "* ]] || wait "$beside"
        execute "$part"
    done
    wait "$beside"
}

# line PART PASSED FAILED SECONDS WHY
line() {
    printf '%-9s %5d passed %4d failed %5d s  %s' "$@"
}

# record PART PASSED FAILED SECONDS WHY: adds to the totals.
record() {
    total_passed=$((total_passed + $2))
    total_failed=$((total_failed + $3))
    results+=("$(line "$@")")
}

# times PART...: "seconds part test" of the tests in these parts' logs, the slowest first; from ctest's lines and pytest's
# --durations, of the latter set-up included.
times() {
    local part
    for part in "$@"; do
        sed -nE "s/^ *[0-9]+\/[0-9]+ Test +#[0-9]+: ([^ ]+) .* ([0-9.]+) sec.*$/\2 $part \1/p
                 s/^([0-9.]+)s (call|setup) +(.*)$/\1 $part \3/p" "$LOGS/$part.log"
    done | sort -rn
}

# report_times PART...: the slowest ten tests, and how many take longer than SLOW.
report_times() {
    local measured
    measured=$(times "$@")
    [[ -n $measured ]] || return 0
    say "the slowest tests:"
    head -n 10 <<<"$measured" | awk '{ printf "  %7.1f s  %s: %s\n", $1, $2, substr($0, index($0, $3)) }'
    awk -v slow="$SLOW" '$1 > slow { n++; sum += $1 }
        END { printf "  %d tests take over %d s, %.0f s in all\n", n, slow, sum }' <<<"$measured"
}

# report_skipped PART...: single tests that were left out, and why, as ctest's and pytest's logs and scripts say it.
report_skipped() {
    local part
    for part in "$@"; do
        grep -aE '^(SKIPPED \[|skipped - |skipped: )' "$LOGS/$part.log" | sed -E "s/^SKIPPED /skipped /; s/^/  $part: /"
    done | sort -u
}

main() {
    local part preset before packages wanted targets passed failed seconds why
    (($# > 0)) || set -- "${PARTS[@]}"
    for part in "$@"; do
        [[ " ${PARTS[*]} ${EXTRA[*]} " == *" $part "* ]] ||
            die "there is no part '$part'; the parts are: ${PARTS[*]}, and by name only: ${EXTRA[*]}"
    done
    mapfile -t packages < <(for part in "$@"; do packages_of "$part"; done | tr ' ' '\n' | sort -u)
    mapfile -t wanted < <(for part in "$@"; do preset_of "$part"; done | sort -ru)
    need "${packages[@]}"
    mkdir -p "$LOGS"
    # Once and not in run_tidy: parts beside it may be reading what configuring writes.
    [[ " $* " != *" tidy "* || " ${wanted[*]} " == *" release "* ]] || cmake --preset release >/dev/null
    for preset in "${wanted[@]}"; do
        before=$SECONDS
        mapfile -t targets < <(targets_of "$preset")
        { archives_of "$preset" && build "$preset" "${targets[@]}"; } ||
            { record "build of $preset" 0 1 $((SECONDS - before)) "it does not build"; say "${results[-1]}"; }
    done
    execute_all "$@"
    for part in "$@"; do
        passed=0 failed=1 seconds=0 why="it did not end"
        [[ ! -e $LOGS/$part.result ]] || read -r passed failed seconds why <"$LOGS/$part.result"
        record "$part" "$passed" "$failed" "$seconds" "$why"
    done
    say "in all, $SECONDS s:"
    printf '  %s\n' "${results[@]}"
    report_skipped "$@"
    report_times "$@"
    echo "$total_passed passed, $total_failed failed"
    ((total_failed == 0))
}

trap 'exit 130' INT # once the part that is on has ended by it
if [[ ${1:-} == --part ]]; then
    "run_$2"
elif [[ ${1:-} == --quietly ]]; then
    execute_quietly "${@:2}"
else
    main "$@"
fi

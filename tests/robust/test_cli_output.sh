#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the command line writes, when it writes nothing, and interrupting it.
# shellcheck source=tests/robust/cli.sh
source "$(dirname "$0")/cli.sh"

FAST=(--levels 2 --max-iterations 3 --tolerance 1e-2)
EVALUATE_KEYS='{"vertices","faces","euler","area","willmore","h2","mvs","mvs_cross","gauss","gauss_bonnet_defect",
"quadrature_error","surface"}'

test_json_of_evaluate_has_its_keys() {
    torus_obj 6 4 >cage.obj
    run evaluate cage.obj --json result.json
    expect 0 ''
    json result.json "$EVALUATE_KEYS <= set(j)"
    json result.json 'j["vertices"] == 24 and j["faces"] == 24 and j["euler"] == 0 and j["surface"] == "limit"'
    json result.json '70 < j["willmore"] < 200 and j["mvs"] > 0 and abs(j["gauss"]) < 0.1'
    json result.json 'j["area"] > 1 and 0 <= j["quadrature_error"] < 1e-3 * j["willmore"]'
}

test_energy_that_does_not_exist_is_null() {
    cube_obj >cage.obj
    run evaluate cage.obj --json result.json
    expect 0 ''
    json result.json 'j["mvs"] is None and j["mvs_cross"] is None and j["willmore"] > 25 and j["euler"] == 2'
}

test_json_of_minimize_has_its_keys() {
    torus_obj 6 4 >cage.obj
    run minimize cage.obj -o result.obj "${FAST[@]}" --energy mvs --json result.json
    expect 0 ''
    json result.json "$EVALUATE_KEYS | {'energy', 'method', 'levels', 'seconds'} <= set(j)"
    json result.json 'len(j["levels"]) == 2 and j["energy"] == "mvs" and j["method"] == "gauss_newton" and j["verification"]["verdict"]'
    json result.json 'all({"level", "vertices", "iterations", "evaluations", "energy", "gradient_norm", "seconds", "stop"}
        <= set(l) for l in j["levels"])'
    json result.json '[l["vertices"] for l in j["levels"]] == [24, 96] and j["vertices"] == 96'
    json result.json 'j["levels"][1]["stop"] in ("limit", "converged", "stalled")'
}

test_what_no_rule_reaches_is_said() {
    cube_obj >cage.obj
    run minimize cage.obj -o result.obj --energy mvs --levels 1 --tolerance 1e-12
    expect 0 ''
    [[ $OUT == *"quadrature error "*" (more than the 1.1e-10 that was wanted"* ]] || fail "output: $OUT"
    run minimize cage.obj -o result.obj --energy willmore --levels 1
    expect 0 ''
    [[ $OUT != *"quadrature error"* ]] || fail "output: $OUT"
}

test_dash_as_json_is_standard_output_alone() {
    cube_obj >cage.obj
    run evaluate cage.obj --json -
    expect 0 ''
    printf '%s' "$OUT" >result.json
    json result.json 'j["vertices"] == 8'
    run minimize cage.obj -o result.obj "${FAST[@]}" --json -
    expect 0 ''
    printf '%s' "$OUT" >result.json
    json result.json 'j["vertices"] == 26 and len(j["levels"]) == 2'
}

test_dash_as_cage_is_standard_input() {
    cube_obj >cage.obj
    run evaluate cage.obj
    local from_file=$OUT from_input
    from_input=$("$CURVOPT" evaluate - <cage.obj) || fail "exit code $?"
    [[ $from_input == "$from_file" ]] || fail "standard input gives $from_input"
    "$CURVOPT" evaluate - </dev/null 2>err && fail "an empty standard input was accepted"
    grep -q "the file is empty" err || fail "message: $(<err)"
}

# One row for every iteration, as the report counts them; columns are what the header line says.
test_trace_has_a_row_for_every_iteration() {
    torus_obj 6 4 >cage.obj
    run minimize cage.obj -o result.obj --levels 2 --max-iterations 8 --energy mvs --trace trace.csv --json result.json
    expect 0 ''
    python3 - trace.csv result.json <<'END' || fail "the trace is not as it should be: $(head -n 4 trace.csv)"
import csv, json, sys
rows = list(csv.DictReader(open(sys.argv[1], newline="")))
report = json.load(open(sys.argv[2]))
columns = "level iteration energy gradient_norm predicted shift gain_ratio step samples method rejected seconds"
assert list(rows[0]) == columns.split() and all(None not in row and None not in row.values() for row in rows)
for level in report["levels"]:
    mine = [row for row in rows if int(row["level"]) == level["level"]]
    steps = [int(row["iteration"]) for row in mine]
    assert steps[0] == 0 and max(steps) == level["iterations"] > 0, (steps, level)
    assert len(set(steps)) == level["iterations"] + 1, steps
    assert abs(float(mine[-1]["energy"]) / level["energy"] - 1) < 1e-2, (mine[-1], level)
seconds = [float(row["seconds"]) for row in rows]
assert seconds == sorted(seconds) and 0 <= seconds[0] and seconds[-1] <= report["seconds"]
END
}

test_trace_is_written_whole_or_not_at_all() {
    cube_obj >cage.obj
    refused 1 "no/such.csv: No such file" minimize cage.obj -o result.obj --levels 1 --max-iterations 1 --quiet \
        --trace no/such.csv
    refused 1 "No such file" minimize cage.obj -o no/such.obj --levels 1 --max-iterations 1 --quiet --trace trace.csv
    run minimize cage.obj -o result.obj --levels 1 --max-iterations 1 --trace -
    expect 0 ''
    [[ $OUT == level,iteration,energy,* && $OUT != *willmore:* ]] || fail "printed: $OUT"
    [[ -s result.obj && -z $(ls ./*.part 2>/dev/null) ]] || fail "left: $(ls)"
}

test_quiet_prints_nothing() {
    cube_obj >cage.obj
    run evaluate cage.obj --quiet --json result.json
    expect 0 ''
    [[ -z $OUT ]] || fail "printed: $OUT"
    run minimize cage.obj -o result.obj "${FAST[@]}" --quiet
    expect 0 ''
    [[ -z $OUT && -s result.obj && -s result.json ]] || fail "printed: $OUT"
}

test_progress_is_not_written_to_a_file() {
    cube_obj >cage.obj
    run minimize cage.obj -o result.obj "${FAST[@]}"
    expect 0 ''
    [[ $OUT == willmore:* ]] || fail "printed: $OUT"
}

test_result_can_be_read_again_and_is_as_good_as_said() {
    torus_obj 6 4 >cage.obj
    run minimize cage.obj -o result.obj "${FAST[@]}" --tolerance 1e-4 --json first.json
    expect 0 ''
    run evaluate result.obj --json second.json
    expect 0 ''
    printf '[%s,%s]' "$(<first.json)" "$(<second.json)" >both.json
    json both.json 'abs(j[0]["willmore"] / j[1]["willmore"] - 1) < 1e-3 and j[0]["faces"] == j[1]["faces"]'
    [[ -z $(ls ./*.part 2>/dev/null) ]] || fail "left: $(ls)"
}

test_output_may_replace_the_input() {
    { echo '# the input' && cube_obj; } >cage.obj
    run minimize cage.obj -o cage.obj --levels 1 --max-iterations 2
    expect 0 ''
    [[ $(grep -c '^v ' cage.obj) == 8 ]] || fail "it has not eight vertices"
    ! grep -q 'the input' cage.obj || fail "it was not replaced"
}

test_unwritable_outputs_are_refused_and_nothing_is_left() {
    cube_obj >cage.obj
    mkdir folder
    refused 1 "no/such/result.obj: No such file" minimize cage.obj -o no/such/result.obj --levels 1 --max-iterations 1
    refused 1 "folder" minimize cage.obj -o folder --levels 1 --max-iterations 1
    refused 1 "no/such.json: No such file" evaluate cage.obj --quiet --json no/such.json
    refused 1 "no/such.json: No such file" minimize cage.obj -o result.obj --levels 1 --max-iterations 1 --quiet \
        --json no/such.json
}

test_full_disk_is_reported() {
    cannot_be_on windows "there is no /dev/full" && return
    cube_obj >cage.obj
    [[ -c /dev/full ]] || fail "this system has no /dev/full"
    run evaluate cage.obj --quiet --json /dev/full
    expect 1 "No space left"
    [[ -c /dev/full ]] || fail "the device is gone"
    "$CURVOPT" evaluate cage.obj >/dev/full 2>err
    [[ $? == 1 ]] || fail "a report that could not be printed passes for done"
    run minimize cage.obj -o result.obj --levels 1 --max-iterations 1 --quiet --trace /dev/full
    expect 1 "No space left"
}

# A limit of the shell is a signal by default, which would leave OUT.PID.part behind.
test_limit_of_file_size_is_reported_and_leaves_nothing() {
    cannot_be_on windows "it has no such limit" && return
    torus_obj 24 16 >cage.obj
    (ulimit -f 4 && exec "$CURVOPT" minimize cage.obj -o result.obj --levels 2 --max-iterations 1 --quiet) 2>err
    CODE=$? ERR=$(<err)
    expect 1 "result.obj: File too large"
    [[ $(ls) == $'cage.obj\nerr' ]] || fail "left: $(ls)"
}

test_devices_are_written_not_replaced() {
    cannot_be_on windows "its pipes are no files of a folder; test_cli_paths.sh writes to its device NUL" && return
    cube_obj >cage.obj
    mkfifo pipe
    cat pipe >copy.obj &
    local reader=$!
    run minimize cage.obj -o pipe --levels 1 --max-iterations 1 --quiet
    expect 0 ''
    [[ -p pipe ]] || fail "the pipe was replaced"
    wait "$reader"
    [[ $(grep -c '^f ' copy.obj) == 6 ]] || fail "the cage did not come through the pipe"
}

# Whether process $1 catches SIGINT, and has 3 s of CPU time behind it in an emulator: Wine and qemu catch it from the
# start, before the program does.
is_ready() {
    local caught ticks
    caught=$(sed -n 's/^SigCgt:[[:space:]]*//p' "/proc/$1/status" 2>/dev/null) && ((0x$caught & 2)) || return
    [[ $SYSTEM != native ]] || return 0
    read -r -a ticks < <(sed 's/^.*) //' "/proc/$1/stat") && ((ticks[11] + ticks[12] > 3 * $(getconf CLK_TCK)))
}

# Waits until process $1 is ready for SIGINT, at most 120 s, then sends it.
interrupt() {
    local tries
    for ((tries = 0; tries < 2400; tries++)); do
        if is_ready "$1"; then
            sleep 0.3
            kill -INT "$1"
            return
        fi
        [[ -e /proc/$1 ]] || return 1
        sleep 0.05
    done
    return 1
}

test_interrupt_keeps_the_best_cage() {
    torus_obj 24 16 >cage.obj
    "$CURVOPT" minimize cage.obj -o result.obj --energy mvs --levels 9 --max-iterations 1000000 --json result.json \
        >out 2>err &
    local process=$!
    interrupt "$process" || fail "it could not be interrupted"
    wait "$process"
    CODE=$? ERR=$(<err)
    expect 0 ''
    json result.json 'j["stop"] == "cancelled" and j["levels"][-1]["stop"] == "cancelled"'
    grep -q cancelled out || fail "printed: $(<out)"
    [[ $(grep -c '^f ' result.obj) -ge 384 ]] || fail "the cage is not there"
    run evaluate result.obj --quiet
    expect 0 ''
}

# An evaluation has no result before its end: a sentence, and nothing else.
test_interrupt_ends_an_evaluation() {
    poles_obj 200 >cage.obj
    "$CURVOPT" evaluate cage.obj --energy mvs --json result.json >out 2>err &
    local process=$!
    interrupt "$process" || fail "it could not be interrupted"
    wait "$process"
    CODE=$? ERR=$(<err) OUT=$(<out)
    expect 1 'cage.obj: it was cancelled'
    expect_one_sentence
    [[ $(ls) == $'cage.obj\nerr\nout' ]] || fail "left: $(ls)"
}

# CPU seconds of process $1 so far; nothing once it has ended.
cpu_seconds() {
    local ticks
    read -r -a ticks < <(sed 's/^.*) //' "/proc/$1/stat" 2>/dev/null) || return
    awk -v t="$((ticks[11] + ticks[12]))" -v hz="$(getconf CLK_TCK)" 'BEGIN { print t / hz }'
}

# Two poles of $1 triangles each, rings of quads between.
poles_obj() {
    awk -v n="$1" 'BEGIN {
        pi = atan2(0, -1); rings = 3
        for (r = 0; r < rings; r++)
            for (k = 0; k < n; k++) {
                h = 1 - (r + 1) * 2 / (rings + 1); q = 1 - (h < 0 ? -h : h)
                printf "v %.15g %.15g %.15g\n", q * cos(2 * pi * k / n), q * sin(2 * pi * k / n), h
            }
        print "v 0 0 1\nv 0 0 -1"
        for (k = 0; k < n; k++) {
            l = (k + 1) % n
            printf "f %d %d %d\nf %d %d %d\n", rings * n + 1, k + 1, l + 1, rings * n - n + k + 1, rings * n + 2, rings * n - n + l + 1
            for (r = 0; r < rings - 1; r++)
                printf "f %d %d %d %d\n", r * n + k + 1, r * n + n + k + 1, r * n + n + l + 1, r * n + l + 1
        }
    }'
}

# What is measured of the result, too: at these poles the deviation alone takes seconds.
test_interrupt_ends_poles_soon() {
    cannot_be_on emulated "its CPU time is the emulator's" && return
    cannot_be_on sanitized "its CPU time is the sanitizers'" && return
    cannot_be_on windows "its CPU time is Wine's" && return
    poles_obj 100 >cage.obj
    "$CURVOPT" minimize cage.obj -o result.obj --threads 1 --json result.json --quiet &
    local process=$! before last='' now
    interrupt "$process" || fail "it could not be interrupted"
    before=$(cpu_seconds "$process")
    while now=$(cpu_seconds "$process") && [[ -n $now && -e /proc/$process/exe ]]; do
        last=$now
        sleep 0.05
    done
    wait "$process" || fail "exit code $?"
    awk -v a="$before" -v b="${last:-$before}" 'BEGIN { exit !(b - a < 1.5) }' || fail "from $before to $last s of CPU time"
    json result.json 'j["stop"] == "cancelled" and "deviation" not in j and "n_crossings" not in j'
}

run_tests

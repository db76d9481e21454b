#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Wrong use of the command line: exit code 2, one sentence, nothing written.
# shellcheck source=tests/robust/cli.sh
source "$(dirname "$0")/cli.sh"

usage() {
    local part=$1
    shift
    [[ -e cage.obj ]] || cube_obj >cage.obj
    refused 2 "$part" "$@"
}

minimize() {
    local part=$1
    shift
    usage "$part" minimize cage.obj -o result.obj --json result.json "$@"
}

test_no_or_unknown_command() {
    usage "no command"
    usage "unknown command optimize" optimize cage.obj
    usage "unknown command" ""
    usage "unknown command cage.obj" cage.obj
}

test_unknown_options_are_named() {
    usage "unknown option --frobnicate" evaluate cage.obj --frobnicate
    usage "unknown option -x" evaluate -x cage.obj
    minimize "unknown option --Energy" --Energy mvs
    usage "unknown option --energy=mvs" evaluate cage.obj --energy=mvs
    minimize "unknown option --strenght; the nearest is --strength (" --strenght .5
    minimize "unknown option --no-crosings; the nearest is --no-crossings (" --no-crosings
    usage "unknown option --level (" evaluate cage.obj --level 1
    usage "unknown option --frobnicate (" evaluate cage.obj --frobnicate
    usage "unknown option -x (" evaluate cage.obj -x
}

test_options_of_minimize_are_refused_by_evaluate() {
    local option
    for option in -o --output --levels --max-iterations --method --trace --joshi-sequin --slide --no-crossings; do
        usage "$option" evaluate cage.obj "$option" 1
    done
}

test_deviation_is_for_evaluate() {
    minimize "unknown option --deviation-from" --deviation-from cage.obj
    refused 1 "nowhere.obj" evaluate cage.obj --deviation-from nowhere.obj
}

test_missing_values_are_named() {
    local option
    for option in --json --energy --surface --tolerance --threads --deviation-from; do
        usage "a value is missing after $option" evaluate cage.obj "$option"
    done
    for option in -o --output --levels --max-iterations --method --trace; do
        usage "a value is missing after $option" minimize cage.obj "$option"
    done
}

test_missing_or_double_cage_and_missing_output() {
    usage "no cage was named" evaluate
    usage "no cage was named" minimize -o result.obj
    usage "more than one cage: other.obj" evaluate cage.obj other.obj
    usage "no output was named" minimize cage.obj
}

test_values_that_make_no_sense_are_named() {
    minimize "--energy cannot be beauty" --energy beauty
    minimize "--energy cannot be mvs:" --energy mvs:
    minimize "--energy cannot be mvs:x" --energy mvs:x
    minimize "--energy cannot be mvs,," --energy mvs,,
    minimize "--surface cannot be automatic" --surface automatic
    minimize "--surface cannot be Limit" --surface Limit
    minimize "--method cannot be newton" --method newton
    minimize "--energy cannot be foo; there are willmore, mvs, mvs_cross, variation, mehlum_tarrou, area, mean_curvature, mixes such as mvs:1,willmore:0.1 (" --energy foo
    minimize "--boundary cannot be foo; there are position, tangent, curvature, free (" --boundary foo
    minimize "--boundary-rule cannot be foo; there are smooth, corners (" --boundary-rule foo
    minimize "--surface cannot be foo; there are auto, limit, plane, polynomial (" --surface foo
    minimize "--symmetry cannot be planes; there are auto, none, rotations, keep, mirror planes such as x or y,z (" --symmetry planes
    minimize "--spacing cannot be foo; there are auto, even, free (" --spacing foo
    minimize "--method cannot be foo; there are auto, lmvm, gauss_newton (" --method foo
    local long
    long=$(printf 'x%.0s' {1..5000})
    minimize "--energy cannot be xxx" --energy "$long"
    minimize "unknown option --xxx" "--$long"
    minimize "--levels cannot be two" --levels two
    minimize "--levels cannot be 2.5" --levels 2.5
    minimize "--levels cannot be " --levels ""
    minimize "--threads cannot be 99999999999" --threads 99999999999
    minimize "--tolerance cannot be tight" --tolerance tight
    minimize "--decrement-tolerance cannot be 1e-8x" --decrement-tolerance 1e-8x
    minimize "--max-iterations cannot be 10x" --max-iterations 10x
}

test_values_out_of_range_are_named() {
    minimize "levels is 0; it must be 1 to 12" --levels 0
    minimize "levels is 13; it must be 1 to 12" --levels 13
    minimize "levels is -1" --levels -1
    minimize "threads is -1; it must be 0 to 1024" --threads -1
    minimize "max_iterations is -5" --max-iterations -5
    minimize "tolerance is 0; it must be" --tolerance 0
    minimize "tolerance is 1; it must be" --tolerance 1
    minimize "tolerance is nan" --tolerance nan
    minimize "decrement_tolerance is 0; it must be" --decrement-tolerance 0
    minimize "decrement_tolerance is nan" --decrement-tolerance nan
    minimize "weights[1] is -1" --energy mvs:-1
    minimize "weights[0] is nan" --energy willmore:nan
    minimize "weights add up to 0" --energy mvs:0
    minimize "strength is 0.0005; it must be 0.001 to 1" --strength .0005
    minimize "within is -1; it must be finite, 0 or more (" --within -1
    minimize "volume is -1; it must be positive and finite" --volume -1
    minimize "reduced volume is -1; it must be positive and finite" --reduced-volume -1
}

test_volume_and_reduced_volume_exclude_each_other() {
    minimize "--volume and --reduced-volume exclude each other: give the volume, or" --reduced-volume .8 --volume keep
    minimize "--volume and --reduced-volume exclude each other: give the volume, or" --volume 1 --reduced-volume .8
}

# pins CONTENT SENTENCE: a file of pins with that content is refused with that sentence.
pins() {
    cube_obj >cage.obj
    printf -- "$1" >pins.txt
    refused 1 "$2" minimize cage.obj -o result.obj --levels 1 --pin pins.txt
}

test_bad_pins_are_refused_by_name() {
    pins '' 'pins.txt: names no vertex'
    pins '# nothing but a comment\n\n' 'pins.txt: names no vertex'
    pins '1 surfaces\n' 'pins.txt: line 1 is no pin'
    pins '1 at 0 0\n' 'pins.txt: line 1 is no pin'
    pins '1 surface at 0 0 inf\n' 'pins.txt: line 1: constraint 0 on vertex 1 has the place 0 0 inf'
    pins '1 surface line 0 0\n' 'pins.txt: line 1 is no pin'
    pins '1 surface 0.5\n' 'limit point of vertex 1 has the weight 0.5; it must be 1'
    pins '1\n2 lime 0 0 1\n' 'pins.txt: line 2 is no pin'
    pins '1 line 0 0\n' 'pins.txt: line 1 is no pin'
    pins '-1\n' 'pins.txt: line 1 is no pin'
    pins '1.5\n' 'pins.txt: line 1 is no pin'
    pins '1,0.5\n' 'pins.txt: line 1 is no pin'
    pins '1 0.5 2\n' 'pins.txt: line 1 is no pin'
    pins '1 line 0 0 1 soft\n' 'pins.txt: line 1 is no pin'
    pins '# firm\n\n1 1.5\n' 'pins.txt: line 3: constraint 0 on vertex 1 has the weight 1.5; it must be 0 to 1'
    pins '1\n1 0.5\n' 'pins.txt: line 2: vertex 1 has two constraints that contradict'
    pins '1\n\n8\n' 'pins.txt: line 3: constraint 1 is on vertex 8; there are 8 vertices'
    pins '1\n3 line 0 0 0\n' 'pins.txt: line 2: constraint 1 on vertex 3 has the direction 0 0 0'
    pins '1 line 0 0 nan\n' 'vertex 1 has the direction'
    pins '1\n1 plane 0 0 1\n' 'vertex 1 has two constraints that contradict'
    pins '0\n1\n2\n3\n4\n5\n6\n7\n' 'cage.obj: nothing may move: all 8 vertices'
    refused 1 "no/pins.txt: No such file" minimize cage.obj -o result.obj --levels 1 --pin no/pins.txt
}

test_pins_hold_vertices() {
    cube_obj >cage.obj
    printf '0 # stays\n3 line 0 0 2\n5 plane 1 0 0\n0\n' >pins.txt
    run minimize cage.obj -o result.obj --levels 1 --pin pins.txt --quiet
    expect 0 ''
    [[ $(sed -n 1p result.obj) == "$(sed -n 1p cage.obj)" ]] || fail "vertex 0 has moved"
    [[ $(sed -n 4p result.obj | cut -d' ' -f2,3) == "$(sed -n 4p cage.obj | cut -d' ' -f2,3)" ]] ||
        fail "vertex 3 has left its line"
    [[ $(sed -n 6p result.obj | cut -d' ' -f2) == "$(sed -n 6p cage.obj | cut -d' ' -f2)" ]] ||
        fail "vertex 5 has left its plane"
}

test_weights_of_pins_hold_softly() {
    cube_obj | sed '1s/-1/-2/' >cage.obj
    printf '0 0.5 # a little\n3 line 0 0 2 .9\n5 plane 1 0 0 1\n' >pins.txt
    run minimize cage.obj -o result.obj --levels 1 --pin pins.txt --quiet
    expect 0 ''
    [[ $(sed -n 1p result.obj) != "$(sed -n 1p cage.obj)" ]] || fail "vertex 0 has not moved at all"
    [[ $(sed -n 6p result.obj | cut -d' ' -f2) == "$(sed -n 6p cage.obj | cut -d' ' -f2)" ]] ||
        fail "vertex 5 has left its plane"
}

# through CONTENT SENTENCE: a file of what the surface goes through with that content is refused with that sentence.
through() {
    cube_obj >cage.obj
    printf '%s' "$1" >through.json
    refused 1 "$2" minimize cage.obj -o result.obj --levels 1 --through through.json
}

test_bad_files_of_points_are_refused_by_name() {
    through '' 'through.json: line 1: a value was expected'
    through '[]' 'through.json: a list with at least one entry was expected'
    through '{"vertex": 1}' 'through.json: only "points" and "chains" are known there'
    through '{"vertex": 1, "at": "here"}' 'are known there; put [ ] round an entry: they are in a list'
    through '{"point": []}' 'through.json: only "points" and "chains" are known there'
    through '{"points": [], "chains": []}' 'through.json: a list with at least one entry was expected, or an object'
    through '{"chains": 1}' 'through.json: a list with at least one entry was expected, or an object'
    local curve='"curve": [[0, 0, 0], [1, 0, 0]]'
    through '{"chains": [1]}' 'chain 0, line 1: an object was expected'
    through '{"chains": [{"curve": [[0, 0, 0]]}]}' 'chain 0, line 1: "vertices" must be a list of at least two vertices'
    through '{"chains": [{"vertices": [1, -1], '"$curve"'}]}' '"vertices" must be a whole number, 0 or more'
    through '{"chains": [{"vertices": [0, 1]}]}' '"curve" must be a list of at least one point'
    through $'{"chains": [{"vertices": [0, 1],\n "curve": [[0, 0, 0], [1, 0]]}]}' 'chain 0, line 2: "curve" must be a list of three numbers'
    through '{"chains": [{"vertices": [0, 1], "closed": 1, '"$curve"'}]}' '"closed" must be true or false'
    through '{"chains": [{"vertices": [0, 1], "parameters": [1], '"$curve"'}]}' '"parameters" must be a list of as many numbers as there are vertices'
    through '{"chains": [{"vertices": [0, 1], "parameters": [1, "a"], '"$curve"'}]}' '"parameters" has something else than numbers'
    through '{"chains": [{"vertices": [0, 1], "at": 1, '"$curve"'}]}' '"at" is not known here'
    through '{"chains": [{"vertices": [0, 1], "weight": 2, '"$curve"'}]}' '"weight" must be a number, 0 to 1'
    through '{"chains": [{"vertices": [0, 1], "weight": "firm", '"$curve"'}]}' '"weight" must be a number, 0 to 1'
    through '{"chains": [{"vertices": [0, 1], "parameters": [0, 1], '"$curve"'}, {"vertices": [0, 9], '"$curve"'}]}' 'through.json: chain 1 has vertex 9; there are 8 vertices'
    through '[{"vertex": 1, "at": [0, 0, 1]},]' 'line 1: a value was expected'
    through '[{"vertex": 1 "at": [0, 0, 1]}]' 'line 1: a comma or } was expected'
    through '[{"vertex": 1, "vertex": 2}]' 'line 1: a key is there twice'
    through $'[\n{"vertex": 01}]' 'line 2: no number that JSON has'
    through '[{"vertex": 1, "at": [0, 0, 1e999]}]' 'or one that is too large'
    through '[{"vertex": NaN}]' 'line 1: a value was expected'
    through "[{'vertex': 1}]" 'line 1: a key in quotation marks was expected'
    through '[{"vertex": 1, "at": [0, 0, 1]}] x' 'line 1: something follows behind the end'
    through '[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]' 'too deep in each other'
    through '[{"vertex": "a\q"}]' 'has \ before something'
    through '[1]' 'entry 0, line 1: an object was expected'
    through $'[{"vertex": 1, "at": "here"},\n {"at": [0, 0, 1]}]' 'entry 1, line 2: either "vertex" or "face" says'
    through '[{"vertex": 1, "face": 2}]' 'entry 0, line 1: either "vertex" or "face" says'
    through '[{"vertex": 1.5, "at": "here"}]' '"vertex" must be a whole number'
    through '[{"vertex": -1, "at": "here"}]' '"vertex" must be a whole number'
    through '[{"face": 1, "at": "here"}]' 'a face needs "uv": [U, V]'
    through '[{"face": 1, "uv": [0.5], "at": "here"}]' '"uv" must be a list of two numbers'
    through '[{"vertex": 1, "at": [0, 0]}]' '"at" must be a list of three numbers'
    through '[{"vertex": 1, "at": "there"}]' '"at" must be a list of three numbers, or "here"'
    through '[{"vertex": 1, "line": [1, 0, 0], "plane": [1, 0, 0]}]' '"line" and "plane" together'
    through '[{"vertex": 1, "tangent": [1, 0, 0]}]' '"tangent" must be {"to": W, "along": [X, Y, Z]}'
    through '[{"face": 1, "uv": [0.5, 0.5], "tangent": {"to": 3, "along": [1, 0, 0]}}]' '"to" must be "u" or "v"'
    through '[{"vertex": 1}]' 'entry 0, line 1: holds nothing'
    through '[{"vertex": 1, "at": "here", "weight": 1.5}]' '"weight" must be a number, 0 to 1'
    through '[{"vertex": 1, "at": "here", "weight": "firm"}]' '"weight" must be a number, 0 to 1'
    through '[{"vertex": 1, "at": "here", "normals": 1}]' 'entry 0, line 1: "normals" is not known here'
    through '[{"vertex": 8, "at": "here"}]' 'through.json: entry 0 is at vertex 8; there are 8 vertices'
    through '[{"vertex": 1, "normal": [0, 0, 0]}]' 'entry 0 has the normal 0 0 0'
    through '[{"vertex": 1, "at": "here"}, {"vertex": 1, "at": [2, 2, 2]}]' 'entry 1: its point cannot be chosen freely beside entry 0'
    refused 1 "no/through.json: No such file" minimize cage.obj -o result.obj --levels 1 --through no/through.json
    printf '[{"vertex": 1, "at": "here"}]' >through.json
    refused 2 "standard input can be the cage or the file of --through, not both" minimize - -o result.obj --through -
    refused 1 "its vertices and faces are, but not the directions in which vertices may move, or what the surface goes through" minimize cage.obj -o result.obj --levels 1 --through through.json --symmetry x
}

test_symmetry_is_a_name_or_planes() {
    local wrong
    for wrong in perhaps x,w xy x, ,x x,,y ''; do
        minimize "--symmetry cannot be $wrong" --symmetry "$wrong"
    done
    cube_obj >cage.obj
    run minimize cage.obj -o result.obj --levels 1 --symmetry z,x --json - --quiet
    expect 0 ''
    [[ $OUT == *'"symmetry_order": 4'* ]] || fail "symmetries kept: $OUT"
    cube_obj | sed '2s/$/1/' >cage.obj
    refused 1 "the cage is not symmetric about the plane x = 0: vertex 1 has no partner" \
        minimize cage.obj -o result.obj --levels 1 --symmetry x
}

test_energy_that_the_surface_cannot_carry_is_refused() {
    cube_obj >cage.obj
    refused 1 "no finite third-order energy" evaluate cage.obj --energy mvs --surface limit
    refused 1 "no finite third-order energy" minimize cage.obj -o result.obj --energy mvs --surface limit
}

test_a_weight_begins_with_its_number() {
    cube_obj >cage.obj
    refused 2 "--energy cannot be" evaluate cage.obj --energy $'willmore:\t1' --json result.json
}

test_help_and_version() {
    run --help
    expect 0 ''
    [[ $OUT == *"usage: curvopt evaluate"* && $OUT == *"exit status"* ]] || fail "help: $OUT"
    local help=$OUT
    run minimize --help
    expect 0 ''
    [[ $OUT == "$help" ]] || fail "help of a command: $OUT"
    run evaluate -h
    expect 0 ''
    [[ $OUT == "$help" ]] || fail "help of a command: $OUT"
    local option
    for option in --energy --surface --tolerance --threads --json --quiet --output --levels --method --max-iterations \
        --joshi-sequin --trace --deviation-from; do
        [[ $OUT == *"$option"* ]] || fail "help does not mention $option"
    done
    run --version
    expect 0 ''
    [[ $OUT =~ ^curvopt\ [0-9]+\.[0-9]+\.[0-9]+$ ]] || fail "version: $OUT"
}

# "(default X)" of every option in the help text against "default X" of the field's comment in curvopt.h, where
# another test holds curvopt_options_init() against it.
test_help_says_the_defaults_of_the_header() {
    run --help
    printf '%s' "$OUT" >help
    python3 - help "$HEADER" <<'END' || fail "help and header differ"
import re, sys
text = open(sys.argv[1]).read()
here = {name.replace("-", "_"): value for name, value in
        re.findall(r"^  (?:-o, )?--([a-z-]+) (?:(?!^  -).)*?\(default ([^)]+)\)", text, re.M | re.S)}
body = re.search(r"typedef struct curvopt_options \{(.*?)\} curvopt_options;", open(sys.argv[2]).read(), re.S).group(1)
there = {}
for comment, name in re.findall(r"/\*((?:(?!\*/).)*)\*/\s*[^;/]*?(\w+)(?:\[\w+\])?;", body, re.S):
    found = re.search(r"default\s+([\w.-]+)", comment)
    if found:
        there[name] = found.group(1).rstrip(".,").lower()
both = set(here) & set(there)
assert {"surface", "method", "levels", "max_iterations", "threads", "boundary", "tolerance", "decrement_tolerance",
        "symmetry", "blend_width"} <= both, (here, there)
for name in both:
    same = here[name] == there[name]
    if not same and re.match(r"[\d.]", here[name]):
        same = float(here[name]) == float(there[name])
    assert same, (name, here[name], there[name])
END
}

run_tests

#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Cages that the command line must refuse, in one sentence that names the file, the element and the value.
# shellcheck source=tests/robust/cli.sh
source "$(dirname "$0")/cli.sh"

# refuse_file FILE PART [OPTION]: both commands refuse a file alike and write nothing.
refuse_file() {
    refused 1 "$2" evaluate "$1" --json result.json "${@:3}"
    [[ $ERR == *"$1"* ]] || fail "the message does not name $1: $ERR"
    refused 1 "$2" minimize "$1" -o result.obj --levels 1 --max-iterations 2 --json result.json "${@:3}"
    [[ $ERR == *"$1"* ]] || fail "the message does not name $1: $ERR"
}

# refuse_cube SED PART [OPTION]: the cube, edited.
refuse_cube() {
    cube_obj | sed "$1" >cage.obj
    refuse_file cage.obj "${@:2}"
}

test_empty_file_is_refused() {
    : >cage.obj
    refuse_file cage.obj "the file is empty"
}

test_file_without_cage_is_refused() {
    printf '# nothing here\no thing\n' >cage.obj
    refuse_file cage.obj "0 vertices and 0 faces"
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >cage.obj
    refuse_file cage.obj "3 vertices and 0 faces"
}

test_file_that_is_no_obj_is_refused() {
    printf 'solid thing\nfacet normal 0 0 1\n' >cage.stl
    refuse_file cage.stl "line 1: this is no OBJ file: unknown statement solid"
    printf '{"vertices": []}\n' >cage.json
    refuse_file cage.json "this is no OBJ file"
}

test_binary_garbage_is_refused() {
    printf '\377\376\000\001v\000 1 2\n\000\000\000' >cage.obj
    refuse_file cage.obj "this is no OBJ file"
    head -c 100000 "$CURVOPT" >program.obj
    refuse_file program.obj "this is no OBJ file"
    [[ $ERR != *[$'\001'-$'\010']* ]] || fail "control characters reach the terminal"
}

test_missing_file_is_refused() {
    refuse_file no/such/cage.obj "No such file"
}

test_directory_is_refused() {
    mkdir folder
    refuse_file folder "Is a directory"
}

test_words_that_are_no_numbers_are_refused() {
    refuse_cube '3s/.*/v 1 two 3/' "line 3: not a coordinate: two"
    refuse_cube '3s/.*/v 1 2/' "line 3: a vertex with fewer than three coordinates"
    refuse_cube '10s/.*/f 1 b 3/' "line 10: not a vertex index: b"
    refuse_cube '10s/.*/f 1 2.5 3/' "line 10: not a vertex index: 2.5"
}

test_overlong_words_are_refused_not_cut() {
    local zeros
    zeros=$(printf '0%.0s' {1..80})
    refuse_cube "3s/.*/v 0.${zeros}1e70x 0 0/" "line 3"
    refuse_cube "10s/.*/f 1 2 ${zeros}4x 3/" "line 10"
}

test_coordinates_that_are_not_finite_are_refused() {
    refuse_cube '3s/.*/v 1 nan 0/' "vertex 2 has coordinate y = nan"
    refuse_cube '5s/.*/v inf 0 0/' "vertex 4 has coordinate x = inf"
    refuse_cube '8s/.*/v 0 0 1e400/' "vertex 7 has coordinate z = inf"
}

test_indices_out_of_range_are_refused() {
    refuse_cube '9s/.*/f 1 2 4 9/' "face 0 names vertex 8; the cage has vertices 0 to 7"
    refuse_cube '9s/.*/f 1 2 4 2147483647/' "face 0 names vertex 2147483646"
    refuse_cube '9s/.*/f 1 2 4 99999999999999999999/' "line 9"
    refuse_cube '9s/.*/f 1 2 4 0/' "line 9: there is no vertex 0"
    refuse_cube '9s/.*/f 1 2 4 -9/' "line 9: there is no vertex -9"
}

test_faces_too_small_or_repeating_are_refused() {
    refuse_cube '9s/.*/f 1 2/' "face 0 has 2 corners; at least 3 are needed"
    refuse_cube '9s/.*/f/' "face 0 has 0 corners"
    refuse_cube '12s/.*/f 3 4 8 4/' "vertex 3"
}

test_edges_that_are_not_manifold_are_refused_with_strict() {
    refuse_cube "\$a f 1 2 5" "is not manifold: 3 faces meet there" --strict
}

test_flipped_face_is_refused_with_strict() {
    refuse_cube '9s/.*/f 3 4 2 1/' "one of them is flipped" --strict
}

test_isolated_vertex_is_refused_with_strict() {
    refuse_cube '1i v 5 5 5' "vertex 8 is isolated: no face uses it" --strict
}

test_vertex_joining_two_fans_is_refused_with_strict() {
    {
        printf 'v %s\n' '0 0 0' '1 0 0' '0 1 0' '0 0 1' '-1 0 0' '0 -1 0' '0 0 -1'
        printf 'f %s\n' '1 3 2' '1 2 4' '2 3 4' '3 1 4' '1 6 5' '1 5 7' '5 6 7' '6 1 7'
    } >cage.obj
    refuse_file cage.obj "vertex 0 joins separate fans of faces" --strict
}

test_cages_of_which_nothing_is_left_are_refused() {
    refuse_cube '$a t corner 8/8/0 0 1 2 3 4 5 6 7 10 10 10 10 10 10 10 10' \
        "no face is left in the energy: all 6 are held as they are, the first at vertex 0, where"
    refuse_cube '$a t hole 1/0/0 6' "hole 0 is face 6; the cage has faces 0 to 5"
    refuse_cube '$a t hole 6/0/0 0 1 2 3 4 5' "no face is left in the energy: all 6 are holes"
    refuse_cube '$a t interpolateboundary 1/0/0 3' "interpolateboundary is neither 0, 1 nor 2"
    refuse_cube '$a t hole 2/0/0 1' "not a vertex of a tag"
}

test_zero_area_cages_are_refused() {
    cube_obj | sed 's/^v .*/v 3 4 5/' >cage.obj
    refuse_file cage.obj "zero area"
    cube_obj | awk '$1 == "v" { $3 = $4 = 2 * $2 } 1' >cage.obj
    refuse_file cage.obj "cage.obj"
}

test_unusual_but_good_files_are_read() {
    local plain=
    cube_obj >cage.obj
    run evaluate cage.obj
    plain=$OUT
    cube_obj | sed '1i # comment\nmtllib a.mtl\no cube\ng side\ns off\nvn 0 0 1\nvt 0 0' | sed 's/^f \(.*\)$/f \1 # face/' |
        sed 's/$/\r/' >cage.obj
    run evaluate cage.obj
    expect 0 ''
    [[ $OUT == "$plain" ]] || fail "comments, materials and CR LF change the result: $OUT"
    cube_obj | sed -E '/^f/s#([0-9]+)#\1/2/3#g' >cage.obj
    run evaluate cage.obj
    [[ $OUT == "$plain" ]] || fail "texture and normal indices change the result: $OUT"
    cube_obj | awk '/^f/ { for (i = 2; i <= NF; i++) $i -= 9 } 1' >cage.obj
    run evaluate cage.obj
    [[ $OUT == "$plain" ]] || fail "negative indices change the result: $OUT"
    cube_obj | head -c -1 >cage.obj
    run evaluate cage.obj
    [[ $OUT == "$plain" ]] || fail "a last line without its end changes the result: $OUT"
}

test_lines_end_as_other_systems_end_them() {
    cube_obj >cage.obj
    run evaluate cage.obj
    local plain=$OUT
    { printf '\357\273\277' && sed 's/$/\r/; s/^f \([0-9]*\) /f \1 \\\r\n/' cage.obj; } >other.obj
    grep -q '\\' other.obj || fail "no line goes on"
    run evaluate other.obj
    expect 0 ''
    [[ $OUT == "$plain" ]] || fail "a mark, CR and lines that go on change the result: $OUT"
}

test_a_byte_0_is_no_coordinate() {
    cube_obj | sed '3s/.*/v 1@2 0 0/' | tr '@' '\000' >cage.obj
    refuse_file cage.obj "line 3: not a coordinate: 1?2"
    cube_obj | sed '3s/.*/v @ 0 0/' | tr '@' '\000' >cage.obj
    refuse_file cage.obj "line 3: not a coordinate: ?"
}

run_tests

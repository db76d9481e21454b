#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Names of files that are long or have spaces and letters of many scripts, ends of lines; on Windows drives, devices and
# files that are in use.
# shellcheck source=tests/robust/cli.sh
source "$(dirname "$0")/cli.sh"

SHORT=(--levels 1 --max-iterations 2)
STRANGE='a b  é ü 曲 😀 [x] %TEMP% ;&'

# native_path PATH: as the system writes an absolute path.
native_path() {
    if [[ $SYSTEM == windows ]]; then
        printf 'Z:%s' "${1//\//\\}"
    else
        printf '%s' "$1"
    fi
}

# works_with CAGE FOLDER: every option that names a file, with this cage and names in this folder.
works_with() {
    run evaluate "$1" --json "$2/e.json"
    expect 0 ''
    run minimize "$1" -o "$2/é.obj" --json "$2/m.json" --trace "$2/t.csv" --pin "$2/p.txt" "${SHORT[@]}"
    expect 0 ''
}

# are_there FOLDER: the files of works_with, and no others.
are_there() {
    json "$1/e.json" 'j["vertices"] == 8'
    json "$1/m.json" 'j["vertices"] == 8 and len(j["levels"]) == 1'
    [[ $(grep -c '^f ' "$1/é.obj") == 6 && $(head -n 1 "$1/t.csv") == level,iteration,* ]] || fail "results: $(ls "$1")"
    [[ $(ls -A "$1") == $'c ü.obj\ne.json\nm.json\np.txt\nt.csv\né.obj' ]] || fail "the folder has: $(ls -A "$1")"
}

# with_cage FOLDER: a cage and pins in it.
with_cage() {
    mkdir -p "$1"
    cube_obj >"$1/c ü.obj"
    echo '0 0.5' >"$1/p.txt"
}

# A folder below this one that makes a path of more than 300 characters.
long_folder() {
    local part
    part=$(printf 'long %.0s' {1..12})long
    printf '%s/%s/%s/%s/%s' "$part" "$part" "$part" "$part" "$part"
}

test_names_with_spaces_and_letters_of_other_scripts() {
    export LC_ALL=C.UTF-8
    with_cage "$STRANGE"
    works_with "$STRANGE/c ü.obj" "$STRANGE"
    are_there "$STRANGE"
    local absolute
    absolute=$(native_path "$PWD/$STRANGE")
    works_with "$absolute/c ü.obj" "$absolute"
    are_there "$STRANGE"
}

test_messages_name_the_file_as_it_was_given() {
    local name
    for name in 'no é 曲 😀.obj' "no such/$STRANGE.obj"; do
        refused 1 "curvopt: $name: No such file" evaluate "$name"
    done
    cube_obj | sed '3s/.*/v 1 zwölf 3/' >'c ü.obj'
    refused 1 "c ü.obj: line 3: not a coordinate: zw" evaluate 'c ü.obj'
    refused 2 "unknown option --größe" evaluate 'c ü.obj' --größe
}

test_paths_of_more_than_260_characters() {
    export LC_ALL=C.UTF-8
    local folder
    folder=$(long_folder)
    ((${#folder} > 300)) || fail "the path is too short for this test"
    with_cage "$folder"
    works_with "$folder/c ü.obj" "$folder"
    are_there "$folder"
    works_with "./$folder/../${folder##*/}/c ü.obj" "$(native_path "$PWD/$folder")"
    are_there "$folder"
    refused 1 "No such file" evaluate "$folder/none.obj"
    refused 1 "Is a directory" evaluate "$folder"
    refused 1 "No such file" evaluate "$folder/c ü.obj" --quiet --json "$folder/none/e.json"
}

# Windows has paths of 200 to 260 characters to which ".PROCESS.part" comes on top.
test_paths_just_below_the_limit() {
    local length name
    for length in 180 199 200 201 226 246 254; do
        ((length <= ${#PWD} + 2)) && continue
        name=$(printf 'n%.0s' $(seq $((length - ${#PWD} - 1))))
        cube_obj >"$name"
        run minimize "$name" -o "$name" --quiet "${SHORT[@]}"
        expect 0 ''
        [[ $(ls -A) == "$name" ]] || fail "length $length: the folder has: $(ls -A)"
        rm "$name"
    done
}

test_ends_of_lines_of_windows_are_read_and_not_written() {
    cube_obj >unix.obj
    sed 's/$/\r/' unix.obj >windows.obj
    printf '0 # stays\n3 line 0 0 2\n\n5 plane 1 0 0 0.5\n' >unix.txt
    sed 's/$/\r/' unix.txt >windows.txt
    run minimize unix.obj -o unix.out --pin unix.txt --json unix.json --trace unix.csv "${SHORT[@]}" --threads 1
    expect 0 ''
    run minimize windows.obj -o windows.out --pin windows.txt --json windows.json --trace windows.csv "${SHORT[@]}" --threads 1
    expect 0 ''
    cmp unix.out windows.out || fail "another result"
    ! grep -l $'\r' ./*.out ./*.json ./*.csv || fail "ends of lines of Windows"
    sed '2s/\r$/ x\r/' windows.txt >wrong.txt
    refused 1 "wrong.txt: line 2 is no pin" minimize windows.obj -o no.obj --pin wrong.txt "${SHORT[@]}"
    sed '4s/.*/v 1 zwei 3\r/' windows.obj >wrong.obj
    refused 1 "wrong.obj: line 4: not a coordinate: zwei" evaluate wrong.obj
    [[ $ERR != *$'\r'* ]] || fail "the end of the line is in the message"
    grep -q $'\r' windows.obj || fail "the test's file has no such ends"
}

test_standard_output_has_plain_ends_of_lines() {
    cube_obj >cage.obj
    run evaluate cage.obj --json -
    [[ $OUT != *$'\r'* && $OUT == *$'\n'* ]] || fail "printed: $OUT"
    run --help
    [[ $OUT != *$'\r'* && $OUT == *$'\n'* ]] || fail "help has ends of lines of Windows"
}

test_an_output_that_may_not_be_replaced_is_refused() {
    cube_obj >cage.obj
    echo mine >kept.obj
    chmod a-w kept.obj
    if [[ $SYSTEM == windows ]]; then # POSIX lets a folder's owner replace its files
        refused 1 "kept.obj: Permission denied" minimize cage.obj -o kept.obj --quiet "${SHORT[@]}"
        [[ $(<kept.obj) == mine ]] || fail "it was changed"
    else
        run minimize cage.obj -o kept.obj --quiet "${SHORT[@]}"
        expect 0 ''
    fi
    [[ -z $(ls ./*.part 2>/dev/null) ]] || fail "left: $(ls)"
}

test_the_null_device_is_written_not_replaced() {
    local device=/dev/null
    [[ $SYSTEM != windows ]] || device=NUL
    cube_obj >cage.obj
    run minimize cage.obj -o "$device" --json "$device" --quiet "${SHORT[@]}"
    expect 0 ''
    [[ $(ls -A) == cage.obj && -c /dev/null ]] || fail "the folder has: $(ls -A)"
}

test_drives_and_both_slashes() {
    [[ $SYSTEM == windows ]] || { SKIPPED="only Windows has drives" && return; }
    with_cage folder
    works_with 'folder\c ü.obj' 'folder'
    are_there folder
    works_with "Z:${PWD//\//\\}\\folder/c ü.obj" "z:$PWD/folder"
    are_there folder
    works_with "Z:folder\\c ü.obj" '.\folder'
    are_there folder
}

run_tests

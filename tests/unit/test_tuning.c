/* The table of heuristic numbers: every row is of one number, in its range, and has its note.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/tuning.h"

#include <dirent.h>

static double value_at(const co_tuning *t, const co_tuning_entry *e) {
    const char *at = (const char *)t + e->offset;
    int integer;
    double real;
    if (e->is_integer) {
        memcpy(&integer, at, sizeof integer);
        return integer;
    }
    memcpy(&real, at, sizeof real);
    return real;
}

static size_t size_of(const co_tuning_entry *e) {
    return e->is_integer ? sizeof(int) : sizeof(double);
}

/* A check that names the row. */
static void check_row(const co_tuning_entry *e, int holds, const char *what) {
    if (!holds)
        print_error("%s: default %g, range %g to %g, note %s: ", e->name, e->value, e->least, e->largest, e->note);
    check_true(holds, what, __FILE__, __LINE__);
}

static void test_defaults_lie_in_their_ranges(void **state) {
    (void)state;
    size_t n;
    const co_tuning_entry *e = co_tuning_table(&n);
    CHECK_BETWEEN(n, 20, 1000);
    for (size_t i = 0; i < n; i++) {
        check_row(e + i, e[i].least < e[i].largest, "the range is one");
        check_row(e + i, e[i].least <= e[i].value && e[i].value <= e[i].largest, "the default lies in the range");
        check_row(e + i, !e[i].is_integer || e[i].value == floor(e[i].value), "an int is whole");
    }
}

/* The offsets tile the struct: no row points into another's number, and none is left out. */
static void test_offsets_are_those_of_the_defaults(void **state) {
    (void)state;
    size_t n, end = 0;
    const co_tuning_entry *e = co_tuning_table(&n);
    for (size_t i = 0; i < n; i++) {
        size_t size = size_of(e + i), begin = (end + size - 1) / size * size;
        CHECK_INT(e[i].offset, begin);
        end = begin + size;
        CHECK_NEAR(value_at(&co_tuning_defaults, e + i), e[i].value, 0);
        CHECK_NEAR(value_at(co_tuning_of_runs(), e + i), e[i].value, 0);
    }
    CHECK_INT((end + sizeof(double) - 1) / sizeof(double) * sizeof(double), sizeof(co_tuning));
}

static void test_names_are_unique(void **state) {
    (void)state;
    size_t n;
    const co_tuning_entry *e = co_tuning_table(&n);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            check_row(e + i, strcmp(e[i].name, e[j].name) != 0, "no other row has this name");
}

/* Files of libcurvopt/notes whose names begin with a number. */
static int n_notes(const char *number) {
    const size_t length = strlen(number);
    int n = 0;
    DIR *folder = opendir(CURVOPT_NOTES);
    assert_non_null(folder);
    for (const struct dirent *file = readdir(folder); file; file = readdir(folder)) {
        const char *end = strrchr(file->d_name, '.');
        n +=
            strncmp(file->d_name, number, length) == 0 && file->d_name[length] == '-' && end && strcmp(end, ".md") == 0;
    }
    closedir(folder);
    return n;
}

/* `note` is the number of one file of libcurvopt/notes. */
static void test_every_note_exists(void **state) {
    (void)state;
    size_t n;
    const co_tuning_entry *e = co_tuning_table(&n);
    for (size_t i = 0; i < n; i++) {
        check_row(e + i, e[i].unit[0] && e[i].why[0] && strlen(e[i].note) >= 2, "unit, reason and note are there");
        check_row(e + i, n_notes(e[i].note) == 1, "the note is one file");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults_lie_in_their_ranges),
        cmocka_unit_test(test_offsets_are_those_of_the_defaults),
        cmocka_unit_test(test_names_are_unique),
        cmocka_unit_test(test_every_note_exists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

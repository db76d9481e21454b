/* curvopt with other heuristic numbers: what `curvopt` takes, and
 *
 *   --set NAME=VALUE   a number of the tuning table (base/tuning.h); repeatable
 *   --list-tuning      a line per number: name, default, least, largest, 1 if integer; tabs between
 *
 * For tests/corpus/sensitivity.py. The linker puts this file's co_tuning_of_runs() in the place of the library's, and
 * the command line's main() is compiled as curvopt_main(). SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "base/tuning.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int curvopt_main(int argc, char **argv);
const co_tuning *__wrap_co_tuning_of_runs(void);

static co_tuning tuning;

const co_tuning *__wrap_co_tuning_of_runs(void) {
    return &tuning;
}

static void stop(const char *what, const char *about) {
    fprintf(stderr, "curvopt_tuned: %s: %s\n", what, about);
    exit(2);
}

static void list(void) {
    size_t n;
    const co_tuning_entry *rows = co_tuning_table(&n);
    for (size_t i = 0; i < n; i++)
        printf("%s\t%.17g\t%.17g\t%.17g\t%d\n", rows[i].name, rows[i].value, rows[i].least, rows[i].largest,
               rows[i].is_integer);
}

static void store(const co_tuning_entry *row, double value, const char *text) {
    if (!(value >= row->least && value <= row->largest))
        stop("outside of its range", text);
    if (!row->is_integer) {
        memcpy((char *)&tuning + row->offset, &value, sizeof value);
        return;
    }
    int whole = (int)value;
    if (whole != value)
        stop("not an integer", text);
    memcpy((char *)&tuning + row->offset, &whole, sizeof whole);
}

static void set(const char *text) {
    size_t n;
    const co_tuning_entry *rows = co_tuning_table(&n);
    const char *equals = strchr(text, '=');
    char *end;
    if (!equals)
        stop("not NAME=VALUE", text);
    double value = strtod(equals + 1, &end);
    if (end == equals + 1 || *end)
        stop("not a number", text);
    for (size_t i = 0; i < n; i++)
        if (strlen(rows[i].name) == (size_t)(equals - text) && !strncmp(rows[i].name, text, (size_t)(equals - text))) {
            store(&rows[i], value, text);
            return;
        }
    stop("no such number", text);
}

int main(int argc, char **argv) {
    int n = 0;
    tuning = co_tuning_defaults;
    for (int i = 0; i < argc; i++)
        if (!strcmp(argv[i], "--list-tuning")) {
            list();
            return 0;
        } else if (!strcmp(argv[i], "--set") && i + 1 < argc) {
            set(argv[++i]);
        } else {
            argv[n++] = argv[i];
        }
    argv[n] = NULL;
    return curvopt_main(n, argv);
}

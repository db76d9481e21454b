/* Files of pins. SPDX-License-Identifier: GPL-3.0-or-later */
#include "pins.h"

#include "platform.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_LINE = 512 };
static const char BLANK[] = " \t\r\n";

void pins_free(pin_list *pins) {
    free(pins->vertices);
    free(pins->freedom);
    free(pins->directions);
    free(pins->weights);
    free(pins->places);
    free(pins->lines);
    *pins = (pin_list){0};
}

typedef struct pin {
    int32_t vertex, freedom, line;
    double direction[3], place[3], weight;
} pin;

/* Room for one more; 1 if memory is out. */
static int make_room(pin **list, int32_t n, int32_t *room) {
    if (n < *room)
        return 0;
    size_t bigger = *room ? 2 * (size_t)*room : 64;
    pin *grown = bigger < INT32_MAX / 2 ? realloc(*list, bigger * sizeof **list) : NULL;
    if (!grown)
        return 1;
    *list = grown;
    *room = (int32_t)bigger;
    return 0;
}

/* A number that the line goes on with; 0 if there is none. */
static int take_real(char **at, double *out) {
    char *end;
    *out = strtod(*at, &end);
    if (end == *at)
        return 0;
    *at = end;
    return 1;
}

/* Whether the line goes on with this word; goes past it. */
static int take_word(char **at, const char *word) {
    const size_t n = strlen(word);
    if (strncmp(*at, word, n) != 0 || ((*at)[n] && !strchr(BLANK, (*at)[n])))
        return 0;
    *at += n + strspn(*at + n, BLANK);
    return 1;
}

/* 1 a pin, 0 an empty line, -1 neither. */
static int parse_line(char *line, pin *out) {
    char *end, *at = line + strspn(line, BLANK);
    line[strcspn(line, "#")] = 0;
    if (!*at)
        return 0;
    errno = 0;
    long value = strtol(at, &end, 10);
    if (end == at || errno || value < 0 || value > INT32_MAX || (*end && !strchr(BLANK, *end)))
        return -1;
    *out = (pin){.vertex = (int32_t)value, .weight = 1, .place = {(double)NAN, (double)NAN, (double)NAN}};
    at = end + strspn(end, BLANK);
    const int of_limit = take_word(&at, "surface"), is_placed = take_word(&at, "at");
    for (int c = 0; c < 3 && is_placed; c++)
        if (!take_real(&at, &out->place[c]))
            return -1;
    at += strspn(at, BLANK);
    out->freedom = take_word(&at, "line") ? 1 : take_word(&at, "plane") ? 2 : 0;
    for (int c = 0; c < 3 && out->freedom; c++)
        if (!take_real(&at, &out->direction[c]))
            return -1;
    at += strspn(at, BLANK);
    if (*at && !take_real(&at, &out->weight))
        return -1;
    at += strspn(at, BLANK);
    out->freedom += of_limit ? CURVOPT_FREEDOM_OF_LIMIT_POINT : 0;
    return *at ? -1 : 1;
}

static int read_lines(FILE *file, pin **list, int32_t *n, char *message, size_t size) {
    char line[LONGEST_LINE];
    int32_t room = 0;
    for (int32_t number = 1; fgets(line, sizeof line, file); number++) {
        pin one;
        int found = strlen(line) + 1 == sizeof line ? -1 : parse_line(line, &one);
        if (found < 0) {
            snprintf(message, size,
                     "line %d is no pin: VERTEX, perhaps surface, perhaps at X Y Z, perhaps line X Y Z or plane X Y Z, "
                     "and perhaps a weight",
                     (int)number);
            return 1;
        }
        if (found == 0)
            continue;
        if (make_room(list, *n, &room)) {
            snprintf(message, size, "out of memory");
            return 1;
        }
        one.line = number;
        (*list)[(*n)++] = one;
    }
    if (ferror(file) || *n == 0) {
        snprintf(message, size, "%s", ferror(file) ? strerror(errno) : "names no vertex");
        return 1;
    }
    return 0;
}

/* The list as arrays; 1 if memory is out. */
static int deal_out(const pin *list, int32_t n, pin_list *out) {
    *out = (pin_list){.vertices = malloc(sizeof(int32_t) * (size_t)n),
                      .freedom = malloc(sizeof(int32_t) * (size_t)n),
                      .directions = malloc(3 * sizeof(double) * (size_t)n),
                      .weights = malloc(sizeof(double) * (size_t)n),
                      .places = malloc(3 * sizeof(double) * (size_t)n),
                      .lines = malloc(sizeof(int32_t) * (size_t)n),
                      .n = n};
    if (!out->vertices || !out->freedom || !out->directions || !out->weights || !out->places || !out->lines) {
        pins_free(out);
        return 1;
    }
    for (int32_t i = 0; i < n; i++) {
        out->vertices[i] = list[i].vertex;
        out->freedom[i] = list[i].freedom;
        out->weights[i] = list[i].weight;
        out->lines[i] = list[i].line;
        memcpy(out->places + 3 * (size_t)i, list[i].place, sizeof list[i].place);
        memcpy(out->directions + 3 * (size_t)i, list[i].direction, sizeof list[i].direction);
    }
    return 0;
}

int pins_parse(FILE *file, pin_list *out, char *message, size_t size) {
    pin *list = NULL;
    int32_t n = 0;
    *out = (pin_list){0};
    int failed = read_lines(file, &list, &n, message, size);
    if (!failed) {
        failed = deal_out(list, n, out);
        if (failed)
            snprintf(message, size, "out of memory");
    }
    free(list);
    return failed;
}

int pins_read(const char *path, pin_list *out, char *message, size_t size) {
    *out = (pin_list){0};
    FILE *file = platform_open(path, "r");
    if (!file) {
        snprintf(message, size, "%s", strerror(errno));
        return 1;
    }
    int failed = pins_parse(file, out, message, size);
    fclose(file);
    return failed;
}

curvopt_constraints pins_as_constraints(const pin_list *pins) {
    return (curvopt_constraints){.vertices = pins->vertices,
                                 .freedom = pins->freedom,
                                 .directions = pins->directions,
                                 .n = pins->n,
                                 .has_places = 1,
                                 .weights = pins->weights,
                                 .places = pins->places};
}

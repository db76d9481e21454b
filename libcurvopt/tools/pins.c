/* Files of pins. SPDX-License-Identifier: GPL-3.0-or-later */
#include "pins.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_LINE = 512 };

void pins_free(pin_list *pins) {
    free(pins->vertices);
    free(pins->freedom);
    free(pins->directions);
    *pins = (pin_list){0};
}

static int grow(pin_list *pins, int32_t *room) {
    size_t n = *room ? 2 * (size_t)*room : 64;
    if (n > INT32_MAX / 4)
        return 1;
    int32_t *vertices = realloc(pins->vertices, n * sizeof *vertices);
    pins->vertices = vertices ? vertices : pins->vertices;
    int32_t *freedom = realloc(pins->freedom, n * sizeof *freedom);
    pins->freedom = freedom ? freedom : pins->freedom;
    double *directions = realloc(pins->directions, 3 * n * sizeof *directions);
    pins->directions = directions ? directions : pins->directions;
    *room = (int32_t)n;
    return !vertices || !freedom || !directions;
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

/* 1 a pin, 0 an empty line, -1 neither. */
static int parse_line(char *line, int32_t *vertex, int32_t *freedom, double direction[3]) {
    static const char blank[] = " \t\r\n";
    char *end, *at = line + strspn(line, blank);
    line[strcspn(line, "#")] = 0;
    if (!*at)
        return 0;
    errno = 0;
    long value = strtol(at, &end, 10);
    if (end == at || errno || value < 0 || value > INT32_MAX)
        return -1;
    *vertex = (int32_t)value;
    *freedom = 0;
    memset(direction, 0, 3 * sizeof *direction);
    at = end + strspn(end, blank);
    if (!strncmp(at, "line", 4) || !strncmp(at, "plane", 5)) {
        *freedom = *at == 'l' ? 1 : 2;
        at += *at == 'l' ? 4 : 5;
        for (int c = 0; c < 3; c++)
            if (!take_real(&at, &direction[c]))
                return -1;
        at += strspn(at, blank);
    }
    return *at ? -1 : 1;
}

static int read_lines(FILE *file, pin_list *out, char *message, size_t size) {
    char line[LONGEST_LINE];
    int32_t room = 0;
    for (int number = 1; fgets(line, sizeof line, file); number++) {
        int32_t vertex, freedom;
        double direction[3];
        int found = strlen(line) + 1 == sizeof line ? -1 : parse_line(line, &vertex, &freedom, direction);
        if (found < 0) {
            snprintf(message, size, "line %d is no pin: VERTEX, VERTEX line X Y Z or VERTEX plane X Y Z", number);
            return 1;
        }
        if (found == 0)
            continue;
        if (out->n == room && grow(out, &room)) {
            snprintf(message, size, "out of memory");
            return 1;
        }
        out->vertices[out->n] = vertex;
        out->freedom[out->n] = freedom;
        memcpy(out->directions + 3 * (size_t)out->n, direction, sizeof direction);
        out->n++;
    }
    if (ferror(file) || out->n == 0) {
        snprintf(message, size, "%s", ferror(file) ? strerror(errno) : "names no vertex");
        return 1;
    }
    return 0;
}

int pins_read(const char *path, pin_list *out, char *message, size_t size) {
    *out = (pin_list){0};
    FILE *file = fopen(path, "r");
    if (!file) {
        snprintf(message, size, "%s", strerror(errno));
        return 1;
    }
    int failed = read_lines(file, out, message, size);
    fclose(file);
    if (failed)
        pins_free(out);
    return failed;
}

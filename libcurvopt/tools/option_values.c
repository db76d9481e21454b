/* Values of options, from text. SPDX-License-Identifier: GPL-3.0-or-later */
#include "option_values.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_NAME = 63 };

int parse_integer(const char *text, int32_t *out) {
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    if (end == text || *end || errno || value < INT32_MIN || value > INT32_MAX)
        return 1;
    *out = (int32_t)value;
    return 0;
}

int parse_real(const char *text, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end == text || *end || isspace((unsigned char)*text);
}

int edit_distance(const char *from, const char *to) {
    int row[LONGEST_NAME + 1]; /* from the part of `from` so far to every part of `to` */
    const int n = (int)strlen(to);
    if (n > LONGEST_NAME)
        return INT_MAX;
    for (int k = 0; k <= n; k++)
        row[k] = k;
    for (int i = 1; from[i - 1]; i++) {
        int diagonal = row[0];
        row[0] = i;
        for (int k = 1; k <= n; k++) {
            int least = diagonal + (from[i - 1] != to[k - 1]);
            diagonal = row[k];
            least = row[k - 1] + 1 < least ? row[k - 1] + 1 : least;
            row[k] = row[k] + 1 < least ? row[k] + 1 : least;
        }
    }
    return row[n];
}

/* Up to the next of `ends`, into room [size]; 0 if it is empty or does not fit. */
static size_t take_word(const char *at, const char *ends, char *room, size_t size) {
    size_t length = strcspn(at, ends);
    if (length >= size)
        return 0;
    memcpy(room, at, length);
    room[length] = 0;
    return length;
}

/* "mvs" or "mvs:1,willmore:0.1". */
int parse_energy(const char *text, double *weights) {
    for (int t = 0; t < CURVOPT_MAX_TERMS; t++)
        weights[t] = 0;
    for (const char *at = text;; at++) {
        char word[64];
        double weight = 1;
        size_t length = take_word(at, ":,", word, sizeof word);
        int32_t term = length ? curvopt_term_from_name(word) : -1;
        if (term < 0)
            return 1;
        at += length;
        if (*at == ':') {
            length = take_word(++at, ",", word, sizeof word);
            if (!length || parse_real(word, &weight))
                return 1;
            at += length;
        }
        weights[term] += weight;
        if (!*at)
            return 0;
    }
}

int parse_symmetry(const char *text, curvopt_options *o) {
    o->symmetry_planes = 0;
    o->symmetry = curvopt_symmetry_from_name(text);
    if (o->symmetry >= 0)
        return o->symmetry == CURVOPT_SYMMETRY_PLANES;
    o->symmetry = CURVOPT_SYMMETRY_PLANES;
    for (;; text++) {
        char word[8];
        size_t length = take_word(text, ",", word, sizeof word);
        int32_t plane = length ? curvopt_plane_from_name(word) : -1;
        if (plane < 0)
            return 1;
        o->symmetry_planes |= plane;
        text += length;
        if (!*text)
            return 0;
    }
}

int parse_scalar(const char *text, int scalar, curvopt_options *o) {
    o->scalar_value[scalar] = 0;
    o->scalar_rule[scalar] = CURVOPT_SCALAR_RULE_KEEP;
    if (!strcmp(text, curvopt_scalar_rule_name(CURVOPT_SCALAR_RULE_KEEP)))
        return 0;
    o->scalar_rule[scalar] = CURVOPT_SCALAR_RULE_VALUE;
    return parse_real(text, &o->scalar_value[scalar]);
}

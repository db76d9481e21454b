/* Values of options, from text. SPDX-License-Identifier: GPL-3.0-or-later */
#include "option_values.h"

#include "report_json.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
    return end == text || *end;
}

int parse_name(const char *const *names, int n, const char *text, size_t length) {
    for (int i = 0; i < n; i++)
        if (strlen(names[i]) == length && strncmp(names[i], text, length) == 0)
            return i;
    return -1;
}

/* "mvs" or "mvs:1,willmore:0.1". */
int parse_energy(const char *text, double *weights) {
    for (int t = 0; t < 8; t++)
        weights[t] = 0;
    for (const char *at = text;;) {
        size_t name_length = strcspn(at, ":,"), length = strcspn(at, ",");
        int term = parse_name(json_term_name, CURVOPT_N_TERMS, at, name_length);
        double weight = 1;
        if (term < 0)
            return 1;
        if (name_length < length) {
            char number[64], *end;
            size_t digits = length - name_length - 1;
            if (digits == 0 || digits >= sizeof number)
                return 1;
            memcpy(number, at + name_length + 1, digits);
            number[digits] = 0;
            weight = strtod(number, &end);
            if (*end)
                return 1;
        }
        weights[term] += weight;
        if (!at[length])
            return 0;
        at += length + 1;
    }
}

int parse_symmetry(const char *text, curvopt_options *o) {
    static const char *const name[4] = {"auto", "none", "rotations", "keep"};
    static const char axes[] = "xyz";
    o->symmetry_planes = 0;
    o->symmetry = parse_name(name, 4, text, strlen(text));
    if (o->symmetry >= 0)
        return 0;
    o->symmetry = CURVOPT_SYMMETRY_PLANES;
    for (;; text += 2) {
        const char *axis = *text ? strchr(axes, *text) : NULL;
        if (!axis || (text[1] && text[1] != ','))
            return 1;
        o->symmetry_planes |= 1 << (axis - axes);
        if (!text[1])
            return 0;
    }
}

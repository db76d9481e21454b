/* Files of pins. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PINS_H
#define PINS_H

#include "curvopt.h"

#include <stddef.h>
#include <stdio.h>

typedef struct pin_list {
    int32_t *vertices;
    int32_t *freedom;
    double *directions;
    double *weights;
    double *places;
    int32_t *lines; /* of the file, from 1 */
    int32_t n;
} pin_list;

/* Reads lines "VERTEX", "VERTEX line X Y Z" or "VERTEX plane X Y Z", each perhaps with a weight behind it (1 without),
 * vertices counted from 0, `#` starting a comment. "surface" behind VERTEX means its limit point,
 * "at X Y Z" behind that its place; places are NAN where there is none.
 * Nonzero with a sentence in message if that cannot be done, or if no vertex is named. */
int pins_parse(FILE *file, pin_list *out, char *message, size_t size);
/* The same from a file by name. */
int pins_read(const char *path, pin_list *out, char *message, size_t size);
/* The list as the library takes it, whose arrays stay the list's. */
curvopt_constraints pins_as_constraints(const pin_list *pins);
void pins_free(pin_list *pins);

#endif

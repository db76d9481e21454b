/* The directions in which a constraint lets a vertex move. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/freedom.h"

#include "base/vec3.h"

#include <math.h>
#include <string.h>

/* Sine of the angle up to which directions count as equal: rounding of unit vectors leaves some 1e-16. */
static const double SAME_DIRECTION = 1e-9;

double co_freedom_sine(const double a[3], const double b[3]) {
    double c[3];
    co_cross3(a, b, c);
    return co_length3(c);
}

int co_freedom_same_direction(const double a[3], const double b[3]) {
    return co_freedom_sine(a, b) <= SAME_DIRECTION;
}

void co_freedom_projector(int freedom, const double *d, double projector[9]) {
    memset(projector, 0, 9 * sizeof *projector);
    for (int k = 0; k < 3; k++)
        projector[4 * k] = freedom == CO_FREEDOM_ALL || freedom == CO_FREEDOM_PLANE;
    if (freedom != CO_FREEDOM_LINE && freedom != CO_FREEDOM_PLANE)
        return;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            projector[3 * i + j] += (freedom == CO_FREEDOM_LINE ? 1 : -1) * d[i] * d[j];
}

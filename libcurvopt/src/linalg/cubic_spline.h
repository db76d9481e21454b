/* Interpolating cubic splines, C2, through values of any dimension. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_CUBIC_SPLINE_H
#define CO_LINALG_CUBIC_SPLINE_H

#include "base/status.h"

/* Open ends have no knot next to them (de Boor, "A practical guide to splines", 1978, chapter IV): the first two pieces
 * are one polynomial, and the last two. Through three knots goes a parabola, through two a line. */
typedef struct co_cubic_spline {
    int32_t n;           /* knots; of a periodic spline the last one is the first one, a period on */
    int32_t dimension;   /* numbers of a value */
    int32_t is_periodic; /* then there are four knots at least */
    double *knot;        /* [n] ascending */
    double *value;       /* [n][dimension] */
    double *slope;       /* [n][dimension] derivatives at the knots */
} co_cubic_spline;

/* ERROR_MEMORY. */
int32_t co_cubic_spline_create(int32_t n, int32_t dimension, int is_periodic, const double *knot, const double *value,
                               co_cubic_spline *out, curvopt_error *error);
void co_cubic_spline_free(co_cubic_spline *spline);
/* The value, the first and the second derivative at t: jet [3][dimension]. Beyond the ends of an open spline its end
 * pieces go on; of a periodic one t may be any number. */
void co_cubic_spline_at(const co_cubic_spline *spline, double t, double *jet);

#endif

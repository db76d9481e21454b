/* Interpolating cubic splines. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/cubic_spline.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A tridiagonal system for the slopes; of a periodic spline of n - 1 unknowns, with two entries in the corners. */
typedef struct tridiagonal {
    int32_t n;
    double *below, *diagonal, *above; /* [n] below[0] and above[n - 1] are the corners */
} tridiagonal;

/* Solves for x [n][stride], in place, in `width` columns, without the corners: rows are dominated by their diagonals,
 * or, at the ends of open splines, stay so when they are eliminated. work [n] */
static void solve(const tridiagonal *s, int32_t stride, int32_t width, double *x, double *work) {
    double pivot = s->diagonal[0];
    for (int32_t i = 0; i < s->n; i++) {
        if (i > 0) {
            work[i] = s->above[i - 1] / pivot;
            pivot = s->diagonal[i] - s->below[i] * work[i];
        }
        for (int32_t k = 0; k < width; k++) {
            double *at = x + (size_t)i * (size_t)stride + k;
            at[0] = (at[0] - (i > 0 ? s->below[i] * at[-stride] : 0)) / pivot;
        }
    }
    for (int32_t i = s->n - 2; i >= 0; i--)
        for (int32_t k = 0; k < width; k++)
            x[(size_t)i * (size_t)stride + (size_t)k] -= work[i + 1] * x[(size_t)(i + 1) * (size_t)stride + (size_t)k];
}

/* The same with the corners, by the formula of Sherman and Morrison; work [2 n]. */
static void solve_periodic(const tridiagonal *s, int32_t width, double *x, double *work) {
    const int32_t n = s->n;
    const double first = s->diagonal[0], last = s->diagonal[n - 1], corner = s->below[0], other = s->above[n - 1];
    double *z = work + n;
    s->diagonal[0] = 2 * first; /* less the rank-one matrix (-first, 0, .., other)^T (1, 0, .., -corner / first) */
    s->diagonal[n - 1] = last + corner * other / first;
    memset(z, 0, (size_t)n * sizeof *z);
    z[0] = -first;
    z[n - 1] = other;
    solve(s, 1, 1, z, work);
    solve(s, width, width, x, work);
    const double ratio = corner / first, scale = 1 + z[0] - ratio * z[n - 1];
    for (int32_t k = 0; k < width; k++) {
        const double part = (x[k] - ratio * x[(size_t)(n - 1) * (size_t)width + (size_t)k]) / scale;
        for (int32_t i = 0; i < n; i++)
            x[(size_t)i * (size_t)width + (size_t)k] -= part * z[i];
    }
}

/* Row i: knot `at`, between pieces of lengths a and b with the mean slopes p and q [dimension]. */
static void set_row(const tridiagonal *s, int32_t i, double a, double b) {
    s->below[i] = b;
    s->diagonal[i] = 2 * (a + b);
    s->above[i] = a;
}

static double length(const co_cubic_spline *s, int32_t i) {
    return s->knot[i + 1] - s->knot[i];
}

/* Mean slope of piece i. */
static double mean(const co_cubic_spline *s, int32_t i, int32_t k) {
    const double *at = s->value + (size_t)i * (size_t)s->dimension + k;
    return (at[s->dimension] - at[0]) / length(s, i);
}

/* Knot i, between pieces `before` and `after`: the second derivative does not jump. */
static void fill_inside(const co_cubic_spline *s, const tridiagonal *t, int32_t i, int32_t before, int32_t after) {
    const double a = length(s, before), b = length(s, after);
    set_row(t, i, a, b);
    for (int32_t k = 0; k < s->dimension; k++)
        s->slope[(size_t)i * (size_t)s->dimension + (size_t)k] = 3 * (b * mean(s, before, k) + a * mean(s, after, k));
}

/* An end, knot i, at the piece `end`, next to which is the piece `next`: nor does the third derivative jump there. */
static void fill_end(const co_cubic_spline *s, const tridiagonal *t, int32_t i, int32_t end, int32_t next) {
    const double a = length(s, end), b = length(s, next), sum = a + b;
    t->diagonal[i] = b;
    *(i == 0 ? &t->above[i] : &t->below[i]) = sum;
    for (int32_t k = 0; k < s->dimension; k++)
        s->slope[(size_t)i * (size_t)s->dimension + (size_t)k] =
            ((a + 2 * sum) * b * mean(s, end, k) + a * a * mean(s, next, k)) / sum;
}

/* A line or a parabola. */
static void fill_few(const co_cubic_spline *s) {
    const int32_t d = s->dimension;
    for (int32_t k = 0; k < d; k++) {
        const double p = mean(s, 0, k), q = s->n > 2 ? mean(s, 1, k) : p;
        const double bend = s->n > 2 ? (q - p) / (s->knot[2] - s->knot[0]) : 0;
        s->slope[k] = p - bend * length(s, 0);
        s->slope[d + k] = p + bend * length(s, 0);
        if (s->n > 2)
            s->slope[2 * d + k] = q + bend * length(s, 1);
    }
}

static int32_t find_slopes(co_cubic_spline *s, curvopt_error *error) {
    const int32_t n = s->n - (s->is_periodic ? 1 : 0), last = s->n - 2; /* unknowns; the last piece */
    const size_t size = (size_t)n;
    if (!s->is_periodic && n < 4) {
        fill_few(s);
        return CURVOPT_OK;
    }
    double *work = CO_NEW(double, 5 * size);
    if (!work)
        return co_status_no_memory(error);
    const tridiagonal t = {.n = n, .below = work, .diagonal = work + size, .above = work + 2 * size};
    for (int32_t i = 0; i < n; i++)
        if (s->is_periodic || (i > 0 && i < n - 1))
            fill_inside(s, &t, i, i > 0 ? i - 1 : last, i);
    if (s->is_periodic) {
        solve_periodic(&t, s->dimension, s->slope, work + 3 * size);
        memcpy(s->slope + size * (size_t)s->dimension, s->slope, (size_t)s->dimension * sizeof *s->slope);
    } else {
        fill_end(s, &t, 0, 0, 1);
        fill_end(s, &t, n - 1, last, last - 1);
        solve(&t, s->dimension, s->dimension, s->slope, work + 3 * size);
    }
    free(work);
    return CURVOPT_OK;
}

int32_t co_cubic_spline_create(int32_t n, int32_t dimension, int is_periodic, const double *knot, const double *value,
                               co_cubic_spline *out, curvopt_error *error) {
    const size_t size = (size_t)n * (size_t)dimension;
    *out = (co_cubic_spline){.n = n,
                             .dimension = dimension,
                             .is_periodic = is_periodic,
                             .knot = CO_NEW(double, n),
                             .value = CO_NEW(double, size),
                             .slope = CO_NEW(double, size)};
    int32_t status = out->knot && out->value && out->slope ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        memcpy(out->knot, knot, (size_t)n * sizeof *knot);
        memcpy(out->value, value, size * sizeof *value);
        status = find_slopes(out, error);
    }
    if (status != CURVOPT_OK)
        co_cubic_spline_free(out);
    return status;
}

void co_cubic_spline_free(co_cubic_spline *s) {
    free(s->knot);
    free(s->value);
    free(s->slope);
    *s = (co_cubic_spline){0};
}

/* The piece that t is in. */
static int32_t find_piece(const co_cubic_spline *s, double t) {
    int32_t low = 0, high = s->n - 1;
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (s->knot[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void co_cubic_spline_at(const co_cubic_spline *s, double t, double *jet) {
    const int32_t d = s->dimension;
    const double period = s->knot[s->n - 1] - s->knot[0];
    if (s->is_periodic)
        t -= period * floor((t - s->knot[0]) / period);
    const int32_t i = find_piece(s, t);
    const double h = length(s, i), x = (t - s->knot[i]) / h;
    const double *value = s->value + (size_t)i * (size_t)d, *slope = s->slope + (size_t)i * (size_t)d;
    for (int32_t k = 0; k < d; k++) {
        const double rise = value[d + k] - value[k], a = h * slope[k], b = h * slope[d + k];
        const double square = 3 * rise - 2 * a - b, cube = a + b - 2 * rise;
        jet[k] = value[k] + x * (a + x * (square + x * cube));
        jet[d + k] = (a + x * (2 * square + 3 * x * cube)) / h;
        jet[2 * d + k] = (2 * square + 6 * x * cube) / (h * h);
    }
}

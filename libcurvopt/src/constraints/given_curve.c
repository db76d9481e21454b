/* The curve that the user gives for a chain of edges. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/given_curve.h"

#include "base/memory.h"
#include "base/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 8 }; /* of a piece of the curve, among which the nearest one is looked for */
enum { THIRDS = 40, NEWTON_STEPS = 3 };
/* Step, in parts of the polygon's length, up to which a point repeats the one before, as the last point of a closed
 * curve repeats the first one but for rounding: the direction of such a step would be the spline's there. */
static const double SAME_POINT = 1e-6;

static int32_t measure(const curvopt_chain *chain, const co_given_curve *curve, curvopt_error *error) {
    const int32_t n = curve->n_points;
    for (int32_t i = 0; i < n; i++) {
        const double *p = chain->curve + 3 * (size_t)i;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, curve->number,
                                  "chain %d: point %d of its curve is %g %g %g", curve->number, i, p[0], p[1], p[2]);
    }
    for (int32_t i = 1; i < n + curve->is_closed; i++)
        curve->length[i] =
            curve->length[i - 1] + co_distance3(chain->curve + 3 * (size_t)(i - 1), chain->curve + 3 * (size_t)(i % n));
    if (!isfinite(curve->length[n - 1 + curve->is_closed]))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, curve->number, "chain %d: its curve is too long",
                              curve->number);
    return CURVOPT_OK;
}

/* knot [n_points + 1] and value [3 (n_points + 1)] are room. */
static int32_t make_spline(const curvopt_chain *chain, co_given_curve *curve, double *knot, double *value,
                           curvopt_error *error) {
    const int32_t last = curve->n_points - 1 + curve->is_closed;
    int32_t n = 0;
    for (int32_t i = 0; i <= last; i++) {
        const int repeats = n > 0 && curve->length[i] - knot[n - 1] <= SAME_POINT * curve->length[last];
        if (repeats && (i < last || n == 1))
            continue;
        n -= repeats; /* the last one counts, not the one that it repeats */
        knot[n] = curve->length[i];
        memcpy(value + 3 * (size_t)n++, chain->curve + 3 * (size_t)(i % curve->n_points), 3 * sizeof *value);
    }
    const int32_t distinct = n - curve->is_closed, least = curve->is_closed ? 3 : 2;
    if (distinct < least)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, curve->number,
                              "chain %d: its curve has %d point%s that differ%s from the one before; %s curve needs %d",
                              curve->number, distinct < 1 ? 1 : distinct, distinct > 1 ? "s" : "",
                              distinct > 1 ? "" : "s", curve->is_closed ? "a closed" : "a", least);
    return co_cubic_spline_create(n, 3, curve->is_closed, knot, value, &curve->spline, error);
}

static int32_t make_samples(co_given_curve *curve, curvopt_error *error) {
    const co_cubic_spline *s = &curve->spline;
    const int32_t n_pieces = s->n - 1;
    curve->n_samples = SAMPLES * n_pieces + 1;
    curve->sample = CO_NEW(double, 4 * (size_t)curve->n_samples);
    if (!curve->sample)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < curve->n_samples; i++) {
        const int32_t piece = i / SAMPLES < n_pieces ? i / SAMPLES : n_pieces - 1;
        const double part = (double)(i - SAMPLES * piece) / SAMPLES;
        double jet[9], *to = curve->sample + 4 * (size_t)i;
        to[0] = s->knot[piece] + part * (s->knot[piece + 1] - s->knot[piece]);
        co_cubic_spline_at(s, to[0], jet);
        memcpy(to + 1, jet, 3 * sizeof *to);
    }
    return CURVOPT_OK;
}

int32_t co_given_curve_create(const curvopt_chain *chain, int32_t number, co_given_curve *out, curvopt_error *error) {
    *out = (co_given_curve){.number = number, .n_points = chain->n_points, .is_closed = chain->is_curve_closed != 0};
    if (chain->n_points < 1 || !chain->curve)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, number, "chain %d: its curve has %d points, which are %s",
                              number, chain->n_points, chain->curve ? "given" : "NULL");
    const size_t room = (size_t)chain->n_points + 1;
    double *work = CO_NEW(double, 4 * room);
    out->length = CO_NEW(double, room);
    int32_t status = work && out->length ? measure(chain, out, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = make_spline(chain, out, work, work + room, error);
    if (status == CURVOPT_OK)
        status = make_samples(out, error);
    free(work);
    if (status != CURVOPT_OK)
        co_given_curve_free(out);
    return status;
}

void co_given_curve_free(co_given_curve *curve) {
    free(curve->length);
    free(curve->sample);
    co_cubic_spline_free(&curve->spline);
    *curve = (co_given_curve){0};
}

static double distance_at(const co_given_curve *curve, double t, const double x[3]) {
    double jet[9];
    co_cubic_spline_at(&curve->spline, t, jet);
    return co_distance3(jet, x);
}

/* From t, where Newton's method leads to a place whose tangent is at right angles to the way to x. Distances alone tell
 * t to half of a double's digits. */
static double find_foot(const co_given_curve *curve, double t, double low, double high, const double x[3]) {
    for (int k = 0; k < NEWTON_STEPS; k++) {
        double jet[9], slope = 0, bend = 0;
        co_cubic_spline_at(&curve->spline, t, jet);
        for (int c = 0; c < 3; c++) {
            slope += (jet[c] - x[c]) * jet[3 + c];
            bend += jet[3 + c] * jet[3 + c] + (jet[c] - x[c]) * jet[6 + c];
        }
        const double next = t - slope / bend;
        if (!(bend > 0 && next >= low && next <= high))
            return t;
        t = next;
    }
    return t;
}

/* By thirds, between the neighbours of the nearest sample. */
double co_given_curve_nearest(const co_given_curve *curve, const double x[3]) {
    const int32_t last = curve->n_samples - 1;
    int32_t best = 0;
    for (int32_t i = 1; i <= last; i++)
        if (co_distance3(curve->sample + 4 * (size_t)i + 1, x) < co_distance3(curve->sample + 4 * (size_t)best + 1, x))
            best = i;
    const double at = curve->sample[4 * (size_t)best], end = curve->sample[4 * (size_t)last];
    double low = best > 0 ? curve->sample[4 * (size_t)(best - 1)] : at,
           high = best < last ? curve->sample[4 * (size_t)(best + 1)] : at;
    if (curve->is_closed && best == 0)
        low = at - (end - curve->sample[4 * (size_t)(last - 1)]);
    else if (curve->is_closed && best == last)
        high = at + curve->sample[4];
    const double least = low, most = high;
    for (int k = 0; k < THIRDS; k++) {
        const double third = (high - low) / 3;
        if (distance_at(curve, low + third, x) <= distance_at(curve, high - third, x))
            high -= third;
        else
            low += third;
    }
    const double foot = find_foot(curve, (low + high) / 2, least, most, x);
    const int is_end = !curve->is_closed && (best == 0 || best == last);
    return is_end && distance_at(curve, at, x) <= distance_at(curve, foot, x) ? at : foot;
}

double co_given_curve_parameter(const co_given_curve *curve, double at) {
    const int32_t last = curve->n_points - 1 + curve->is_closed;
    int32_t i = (int32_t)at;
    i = i < last ? i : last - 1;
    return curve->length[i] + (at - i) * (curve->length[i + 1] - curve->length[i]);
}

/* --------------------------------------------------------------------------------------- their order -- */

/* From t[i] to the next one, in direction `sign`, on a closed curve forward to it. */
static double advance(const co_given_curve *curve, const double *t, int32_t i, int32_t n, double sign) {
    const double by = sign * (t[(i + 1) % n] - t[i]), period = curve->length[curve->n_points];
    return curve->is_closed ? by - period * floor(by / period) : by;
}

/* What a step of an open chain takes of a closed curve at most: the shorter way is meant. */
static double longest(const co_given_curve *curve) {
    return curve->is_closed ? curve->length[curve->n_points] / 2 : (double)INFINITY;
}

/* Whether all steps in direction `sign` are forward, and together not more than once round; *sum is how far. */
static int is_in_order(const co_given_curve *curve, const double *t, int32_t n, int32_t n_steps, double sign,
                       double *sum) {
    static const double ROUNDING = 1e-9;
    const double period = curve->length[curve->n_points];
    *sum = 0;
    for (int32_t i = 0; i < n_steps; i++) {
        const double by = advance(curve, t, i, n, sign);
        if (!(by > 0) || (n_steps < n && !(by < longest(curve))))
            return 0;
        *sum += by;
    }
    if (n_steps == n)
        return fabs(*sum - period) < ROUNDING * period;
    return !curve->is_closed || *sum < period;
}

/* Direction that most steps take, and the first vertex that does not follow it. */
static int32_t refuse_order(const co_given_curve *curve, const int32_t *vertices, const double *t, int32_t n,
                            int32_t n_steps, curvopt_error *error) {
    int32_t n_forward = 0, n_backward = 0, i = 0;
    for (int32_t k = 0; k < n_steps; k++) {
        const double forward = advance(curve, t, k, n, 1), backward = advance(curve, t, k, n, -1);
        n_forward += forward > 0 && forward < longest(curve);
        n_backward += backward > 0 && backward < longest(curve);
    }
    const double sign = n_forward >= n_backward ? 1 : -1;
    for (; i < n_steps - 1; i++) {
        const double by = advance(curve, t, i, n, sign);
        if (!(by > 0 && by < longest(curve)))
            break;
    }
    const int32_t at = vertices[(i + 1) % n];
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, curve->number,
                          "chain %d: on its curve vertex %d comes out of order, or where another one is: give its "
                          "vertices parameters, a curve that is as long as the chain, or a chain nearer to it",
                          curve->number, at);
}

int32_t co_given_curve_order(const co_given_curve *curve, const int32_t *vertices, int32_t n, int is_closed, double *t,
                             double *turn, curvopt_error *error) {
    const int32_t n_steps = is_closed ? n : n - 1;
    double forward, backward, sign;
    *turn = 0;
    if (is_closed && !curve->is_closed)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, curve->number,
                              "chain %d is closed and its curve is open: close the curve, or open the chain",
                              curve->number);
    const int goes_forward = is_in_order(curve, t, n, n_steps, 1, &forward);
    const int goes_backward = is_in_order(curve, t, n, n_steps, -1, &backward);
    if (goes_forward && goes_backward)
        sign = forward <= backward ? 1 : -1;
    else if (goes_forward || goes_backward)
        sign = goes_forward ? 1 : -1;
    else
        return refuse_order(curve, vertices, t, n, n_steps, error);
    double at = t[0];
    for (int32_t i = 0; i < n - 1; i++) {
        const double by = advance(curve, t, i, n, sign);
        t[i] = at;
        at += sign * by;
    }
    t[n - 1] = at;
    if (is_closed)
        *turn = sign * curve->length[curve->n_points];
    return CURVOPT_OK;
}

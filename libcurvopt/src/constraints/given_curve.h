/* The curve that the user gives for a chain of edges, and where on it vertices go.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_GIVEN_CURVE_H
#define CO_CONSTRAINTS_GIVEN_CURVE_H

#include "linalg/cubic_spline.h"

/* Point i of the curve is at length [i] of the polygon through them; of a closed curve [n_points] is the whole. */
typedef struct co_given_curve {
    int32_t number; /* of the chain */
    int32_t n_points, is_closed;
    double *length;         /* [n_points + 1] */
    co_cubic_spline spline; /* by these, without points that repeat others */
    double *sample;         /* [4][n_samples] parameter, point; for the nearest place */
    int32_t n_samples;
} co_given_curve;

/* ERROR_ARGUMENT, the element the chain's number; ERROR_MEMORY. */
int32_t co_given_curve_create(const curvopt_chain *chain, int32_t number, co_given_curve *out, curvopt_error *error);
void co_given_curve_free(co_given_curve *curve);
/* The parameter of the nearest place to x. */
double co_given_curve_nearest(const co_given_curve *curve, const double x[3]);
/* The parameter of place `at`, in numbers of points. */
double co_given_curve_parameter(const co_given_curve *curve, double at);
/* Makes parameters t [n] of vertices [n] grow or fall all along, which on closed curves they may do round it; *turn
 * becomes what they change by once round a closed chain. ERROR_ARGUMENT naming a vertex that comes out of turn. */
int32_t co_given_curve_order(const co_given_curve *curve, const int32_t *vertices, int32_t n, int is_closed, double *t,
                             double *turn, curvopt_error *error);

#endif

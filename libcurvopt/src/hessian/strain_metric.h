/* The metric in which steps are damped: what they strain the cage's edges by.
 *
 * The derivatives that a curvature energy is made of are taken over distances of an edge, so its quadratic model is
 * good as long as a step changes each edge by little beside its length. Hence, with a mean edge h,
 *
 *     |d|^2 = h^2 / 4 sum over edges |d_v - d_w|^2 / |x_v - x_w|^2.
 *
 * On a net of squares of one size its diagonal is 1, as the unit matrix' is; but where edges are short it is as stiff
 * as the energy is there, and what moves together, however far, it leaves free
 * (libcurvopt/notes/45-metric-of-the-shift.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_STRAIN_METRIC_H
#define CO_HESSIAN_STRAIN_METRIC_H

#include "hessian/cage_edges.h"

/* out [hessian->pattern.n_entries] becomes the metric's matrix at cage x; hessian's values stay. ERROR_MEMORY. */
int32_t co_strain_metric(const co_cage_edges *edges, const double *x, double edge, co_sparse_hessian *hessian,
                         double *out, curvopt_error *error);

#endif

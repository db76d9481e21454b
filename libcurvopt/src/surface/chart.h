/* Change of parameters: derivatives with respect to one pair of coordinates from those with respect to another.
 *
 * Near an extraordinary vertex the parameters (u, v) of a face are poor coordinates: second and third derivatives of
 * even a smooth surface grow without bound, and its curvature is a small difference of them. The characteristic map is
 * a good pair of coordinates there (notes/40-derivatives-by-the-characteristic-map.md). Energies do not depend on
 * coordinates.
 *
 * The chain rule is written as one triangular system: with f = sum over k of F_k m_k, m_k = dx^a dy^b / (a! b!), the
 * derivatives D_j f in the old coordinates are sum over k of F_k D_j m_k, and D_j m_k is 0 where the order of j is less
 * than that of k. Example in one variable, x = 2 u + u^2 at u = 0: D_1 f = 2 F_1 and D_2 f = 2 F_1 + 4 F_2, solved from
 * the first derivative on.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_CHART_H
#define CO_SURFACE_CHART_H

#include "surface/bspline.h"

typedef struct co_chart {
    int order;                       /* of the highest derivatives with respect to the new coordinates, 2 or 3 */
    double monomial[CO_JET][CO_JET]; /* [k] jet of m_k = dx^a dy^b / (a! b!), k as in jets */
    double inverse[4][4][4];         /* [order] inverse of the block of the D_j m_k with j and k of that order */
    double jacobian;                 /* Jacobian of (x, y) with respect to the old coordinates */
} co_chart;

/* Makes a chart for derivatives up to order `highest`, 2 or 3, from the jets x, y of the new coordinates with respect
 * to the old ones; their Jacobian must not be 0. */
void co_chart_create(const double x[CO_JET], const double y[CO_JET], int highest, co_chart *chart);
/* Replaces a function's derivatives with respect to the old coordinates by those with respect to the new ones; those of
 * higher order than the chart's become NAN. */
void co_chart_apply(const co_chart *chart, double jet[CO_JET]);

#endif

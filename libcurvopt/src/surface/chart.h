/* Derivatives with respect to one pair of coordinates from those with respect to another.
 *
 * Near an extraordinary vertex the parameters (u, v) of a face are poor coordinates: of a surface as smooth as one
 * likes second and third derivatives grow without bound beside what curvature is made of, which is then the small
 * difference of large numbers, and its own derivatives are worse. The characteristic map is the good pair there.
 * Energies do not depend on coordinates. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_CHART_H
#define CO_SURFACE_CHART_H

#include "surface/bspline.h"

typedef struct co_chart {
    double monomial[CO_JET][CO_JET]; /* jets of dx^a dy^b / (a! b!), numbered as derivatives are */
    double inverse[4][4][4];         /* of their blocks of order 1, 2, 3: derivatives of that order from each other */
    double jacobian;                 /* of (x, y) with respect to the old coordinates */
} co_chart;

/* x, y: jets of the new coordinates with respect to the old ones. */
void co_chart_create(const double x[CO_JET], const double y[CO_JET], co_chart *chart);
/* Replaces a function's derivatives with respect to the old coordinates by those with respect to the new ones. */
void co_chart_apply(const co_chart *chart, double jet[CO_JET]);

#endif

/* What Gauss and Bonnet add where a surface ends: the geodesic curvature of boundaries and creases, and the angles
 * there.
 *
 * A surface cut along its boundaries and infinitely sharp creases has
 *     int K dA + int kappa_g ds + sum (pi - angle) = 2 pi chi,
 * kappa_g with the surface on the left, the angles those of corners (pi along smooth stretches), chi of the cut
 * surface. At a dart, where a cut ends inside, the angle is 2 pi.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_RIM_H
#define CO_RIM_H

#include "patches.h"

typedef struct co_rim {
    double target;   /* 2 pi chi - what darts turn */
    int32_t n_sides; /* patch sides on cuts */
    int32_t *patch;  /* [n_sides] */
    uint8_t *side;   /* [n_sides] number of the corner before it */
    int32_t n_tables;
    struct co_rim_table *table; /* samples along a kind of side */
    int32_t *table_of;          /* [n_sides] */
} co_rim;

int32_t co_rim_create(const curvopt_mesh *mesh, const co_patches *patches, co_rim *out, curvopt_error *error);
void co_rim_free(co_rim *rim);
/* int kappa_g ds + sum (pi - angle) at positions points [3 n_points] of all points of the patches; weight [n_patches]
 * or NULL: how often each counts. */
double co_rim_turning(const co_rim *rim, const co_patches *patches, const double *weight, const double *points);

#endif

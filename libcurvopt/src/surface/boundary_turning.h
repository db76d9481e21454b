/* The boundary terms of the Gauss-Bonnet theorem: the geodesic curvature of boundaries and creases, and the angles
 * there.
 *
 * A surface cut along its boundaries and infinitely sharp creases has
 *     int K dA + int kappa_g ds + sum (pi - angle) = 2 pi chi,
 * kappa_g with the surface on the left, the angles those of corners (pi along smooth stretches), chi of the cut
 * surface. At a dart, where a cut ends inside, the angle is 2 pi.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BOUNDARY_TURNING_H
#define CO_SURFACE_BOUNDARY_TURNING_H

#include "surface/patches.h"

typedef struct co_boundary_turning {
    double target;   /* 2 pi chi of the cut surface, less the turning at darts, (pi - 2 pi) each */
    int32_t n_sides; /* patch sides on cuts */
    int32_t *patch;  /* [n_sides] patch of each side */
    uint8_t *side;   /* [n_sides] number of the corner before each side */
    int32_t n_tables;
    struct co_boundary_turning_table *table; /* [n_tables] samples along a kind of side */
    int32_t *table_of;                       /* [n_sides] table of each side */
} co_boundary_turning;

/* surface: curvopt_surface, not AUTO. ERROR_MEMORY. */
int32_t co_boundary_turning_create(const curvopt_mesh *mesh, const co_patches *patches, int32_t surface,
                                   co_boundary_turning *out, curvopt_error *error);
void co_boundary_turning_free(co_boundary_turning *turning);
/* int kappa_g ds + sum (pi - angle) at positions points [3 n_points] of all points of the patches. weight [n_patches]:
 * how often each patch counts; NULL: once. Linear in the sides. */
double co_boundary_turning_total(const co_boundary_turning *turning, const co_patches *patches, const double *weight,
                                 const double *points);

#endif

/* Where a cage's symmetries take the values of the surface that entries hold.
 *
 * A symmetry takes a point of the surface to a point, and tangents there to tangents. So it takes a value's row, a
 * combination of vertices, to the combination of their images, and what is looked for is an entry of which that is a
 * value: rows tell, whatever the faces and parameters are by which a place is given. Two tangents that a normal holds
 * may come out as combinations of two others; `adapt` chooses those of each entry so that they are values one by one.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_VALUE_IMAGES_H
#define CO_CONSTRAINTS_VALUE_IMAGES_H

#include "constraints/surface_values.h"
#include "constraints/symmetry_group.h"

/* Values by the vertices that they depend on. */
typedef struct co_value_index {
    const curvopt_mesh *mesh;
    co_surface_values values; /* a copy, with rows */
    int32_t *first;           /* [values.n] first value of the same entry */
    int32_t *start;           /* [n_vertices + 1] */
    int32_t *user;            /* [start[n_vertices]] values that depend on a vertex */
    int32_t *heaviest;        /* [values.n] vertex of the largest weight */
    double *largest;          /* [values.n] that weight's size */
    double *work;             /* [n_vertices] 0 */
} co_value_index;

/* As co_surface_values_make_rows. */
int32_t co_value_index_create(const curvopt_mesh *mesh, const co_surface_values *values, co_value_index *out,
                              curvopt_error *error);
void co_value_index_free(co_value_index *index);

/* A rigid motion about a centre, and where it takes the cage's corners. Lengths are in units of radius. */
typedef struct co_value_motion {
    const int32_t *corner; /* [n_corners] */
    const double *matrix;  /* [9] */
    const double *centre;  /* [3] */
    double radius, tolerance;
} co_value_motion;

/* Whether a motion takes every entry to one of the same kind, within its tolerance: place, what is held there, in
 * which directions, and how stiffly. 0 where there are entries with curvatures. */
int co_value_index_keeps(const co_value_index *index, const co_value_motion *motion);

/* Chooses the two tangents of each normal that is held so that symmetries take them to each other, as far as that can
 * be; the surface's normal is what it was. Of a symmetry that keeps `values`, whose rows are dropped. ERROR_MEMORY. */
int32_t co_value_images_adapt(const curvopt_mesh *mesh, const co_symmetry *symmetry, co_surface_values *values,
                              curvopt_error *error);

typedef struct co_value_images {
    int32_t n;   /* values */
    int32_t *to; /* [order][n] value that element g takes value i to; -1: a combination of two tangents that are 0 along
                    the normal on all symmetric surfaces, as at an axis */
    int8_t *sign; /* [order][n] value to[g][i] of the image is this times the image of value i */
} co_value_images;

/* Of values with rows. *fits: whether all have images; if not, there are none. ERROR_MEMORY. */
int32_t co_value_images_create(const curvopt_mesh *mesh, const co_symmetry *symmetry, const co_surface_values *values,
                               co_value_images *out, int *fits, curvopt_error *error);
void co_value_images_free(co_value_images *images);

#endif

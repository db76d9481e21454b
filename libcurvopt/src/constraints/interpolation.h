/* Vertices in whose place points and tangents of the limit surface are unknowns.
 *
 * A constraint may hold a linear value of the cage in place of a vertex: a point of the limit surface or a tangent
 * (surface_values.h). There the value itself is the unknown: a level's positions are the cage's, but at the
 * vertices C that interpolate they are such values. With M the values' rows, cage x and positions y,
 *
 *     y_C = M x,      x_C = M_CC^-1 (y_C - M_CF x_F),      y_F = x_F  elsewhere.
 *
 * So holding a point of the surface, or letting it slide on a line or in a plane, is what dof_map.h does with a vertex.
 * A limit point of curvopt_constraints, and a vertex of a finer cage (look_ahead.h), is in the place of its own vertex;
 * after one subdivision no two vertices of the coarser cage are in one mask, and M_CC is a diagonal there on all levels
 * but the first. Other values are in the place of vertices that pivots.h chooses
 * (libcurvopt/notes/87-through-limit-points.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_INTERPOLATION_H
#define CO_CONSTRAINTS_INTERPOLATION_H

#include "constraints/constraints.h"
#include "linalg/sparse_rows.h"

enum { CO_INTERPOLATION_MOST_TOUCHING = 1000 }; /* vertices whose masks hang together */

typedef struct co_interpolation {
    int32_t *vertex;      /* [limit.n_rows] C, ascending */
    co_sparse_rows limit; /* their limit points from the cage */
    co_sparse_rows cage;  /* the vertices from the positions */
    double *work;         /* [3 limit.n_rows] */
} co_interpolation;

/* C: the vertices that constraints->of_limit marks. Those whose limit points cannot move, because nothing in their
 * masks can, are taken off that list: they are held themselves. ERROR_ARGUMENT where more vertices than
 * CO_INTERPOLATION_MOST_TOUCHING hang together or M_CC is all but singular, ERROR_MEMORY. */
int32_t co_interpolation_create(const curvopt_mesh *mesh, co_constraints *constraints, co_interpolation *out,
                                curvopt_error *error);
/* The same of all that of_limit marks, whether they can move or not. */
int32_t co_interpolation_of_all(const curvopt_mesh *mesh, const co_constraints *constraints, co_interpolation *out,
                                curvopt_error *error);
void co_interpolation_free(co_interpolation *interpolation);
/* Of a cage in xyz [3 n_vertices], its positions; and back. */
void co_interpolation_from_cage(const co_interpolation *interpolation, double *xyz);
void co_interpolation_to_cage(const co_interpolation *interpolation, double *xyz);
/* From positions to the cage, with a step of iterative refinement: what the values are off by is then the rounding of
 * the cage's coordinates. off [3 n_vertices]: room. */
void co_interpolation_to_cage_exactly(const co_interpolation *interpolation, double *off, double *xyz);
/* A gradient [3 n_vertices] with respect to the cage becomes that with respect to positions. */
void co_interpolation_gradient(const co_interpolation *interpolation, double *gradient);
/* Index of vertex v in C; -1. */
int32_t co_interpolation_find(const co_interpolation *interpolation, int32_t v);

#endif

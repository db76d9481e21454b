/* Vertices that are given by their limit points.
 *
 * A constraint may hold the point of the limit surface that belongs to a cage vertex, in place of the vertex. There the
 * limit point itself is the unknown: a level's positions are the cage's, but at the vertices C that interpolate they
 * are limit points. With M the limit masks of C, cage x and positions y,
 *
 *     y_C = M x,      x_C = M_CC^-1 (y_C - M_CF x_F),      y_F = x_F  elsewhere.
 *
 * So holding a limit point, or letting it slide on a line or in a plane, is what dof_map.h does with a vertex. After
 * one subdivision no two vertices of the coarser cage are in one mask, so M_CC is a diagonal on all levels but the
 * first (libcurvopt/notes/87-through-limit-points.md).
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

#endif

/* Walls against corners of faces that become thin or turn over, while their face has area.
 *
 * With e and f the edges that leave corner c of a face of n corners, and the area vectors
 *
 *     a_c = e x f,    A = sum of a_c over the face,    r_c = n a_c.A / A.A
 *
 * is the corner's share of the face: 1 in a parallelogram, 0 where the edges are on one line, negative where the corner
 * has turned over. (The corner's Jacobian over the face's mean one, with the face's own normal: P. Knupp, "Algebraic
 * mesh quality metrics", SIAM J. Sci. Comput. 23, 2001.) Where that is below what the corner may have, it costs
 * weight (least_c / r_c - 1)^3. Neither size nor place of the face counts.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_CORNER_WALLS_H
#define CO_HESSIAN_CORNER_WALLS_H

#include "hessian/cage_edges.h"

typedef struct co_corner_walls {
    co_cage_edges cage; /* whose faces */
    double *least;      /* [n_corners] share from which a corner is too thin; 0: it has no wall. NULL: none has */
    double *area;       /* [3 corners of the largest face] work: a_c */
    double weight;
} co_corner_walls;

/* Of positions x [3 n_vertices]: a corner may lose some of its share there, or of a parallelogram's if that is less;
 * one that is thin already has no wall. `mesh`: the caller's; the rest of `cage` is to be set. ERROR_MEMORY. */
int32_t co_corner_walls_create(const curvopt_mesh *mesh, const double *x, co_corner_walls *out, curvopt_error *error);
void co_corner_walls_free(co_corner_walls *walls);
/* The weight by which a corner of half its least share costs a part of `worth` by the number of corners. Corners that
 * are so thin at x that their walls would drown all else lose them. */
void co_corner_walls_weigh(co_corner_walls *walls, const double *x, double worth);
/* The value at x [3 n_vertices], INFINITY where a corner has turned over; gradient [3 n_vertices] += that with respect
 * to x, unless NULL. */
double co_corner_walls_value(const co_corner_walls *walls, const double *x, double *gradient);
/* hessian += a matrix near the second derivatives at x, with respect to positions, that is positive semidefinite: by
 * a_c alone, the face's A being as it is, and vertices that interpolate, too. ERROR_MEMORY. */
int32_t co_corner_walls_add_hessian(const co_corner_walls *walls, const double *x, co_sparse_hessian *hessian,
                                    curvopt_error *error);

#endif

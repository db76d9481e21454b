/* Walls against corners of faces that become thin or turn over.
 *
 * With e and f the edges that leave corner c of a face of n corners, and the area vectors
 *
 *     a_c = e x f,    A = sum of a_c over the face,    r_c = n a_c.A / A.A
 *
 * is the corner's share of the face: 1 in a parallelogram, 0 where the edges are on one line, negative where the corner
 * has turned over. (The corner's Jacobian over the face's mean one, with the face's own normal: P. Knupp, "Algebraic
 * mesh quality metrics", SIAM J. Sci. Comput. 23, 2001.) Where that is below what the corner may have, it costs
 *
 *     weight t^3,    t = least_c / r_c - 1, continued by its tangent below least_c / 10.
 *
 * Neither size nor place of the face counts.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_CORNER_WALLS_H
#define CO_HESSIAN_CORNER_WALLS_H

#include "hessian/cage_edges.h"
#include "linalg/sparse_rows.h"

typedef struct co_corner_walls {
    co_cage_edges cage; /* whose faces */
    double *least;      /* [n_corners] share from which a corner is too thin; 0: it has no wall. NULL: none has */
    double *area;       /* [3 corners of the largest face] work: a_c */
    double weight;
} co_corner_walls;

/* Of the cage x [3 n_vertices]: a corner may lose some of its share there, or of a parallelogram's if that is less; one
 * that is thin already has no wall, nor has one of a face that is left out: left_out [n_faces], or NULL. `mesh`: the
 * caller's; the rest of `cage` and the weight are to be set. Free after failure as well. ERROR_MEMORY. */
int32_t co_corner_walls_create(const curvopt_mesh *mesh, const uint8_t *left_out, const double *x, co_corner_walls *out,
                               curvopt_error *error);
void co_corner_walls_free(co_corner_walls *walls);
/* The weight by which a corner of half its least share costs a part of `worth` by the number of corners, and all
 * corners of cage x [3 n_vertices] together a hundred times `worth` at most. */
void co_corner_walls_weigh(co_corner_walls *walls, const double *x, double worth);
/* The value of cage x [3 n_vertices]; gradient [3 n_vertices] += that with respect to x, unless NULL. */
double co_corner_walls_value(const co_corner_walls *walls, const double *x, double *gradient);
/* hessian += the second derivatives by corners' shares alone at cage x, with respect to positions; they are positive
 * semidefinite. ERROR_MEMORY. */
int32_t co_corner_walls_add_hessian(const co_corner_walls *walls, const double *x, co_sparse_hessian *hessian,
                                    curvopt_error *error);

#endif

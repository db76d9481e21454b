/* Nearest points of a limit surface.
 *
 * Pieces are cut into parts that are nearly flat, and patches put into a tree of boxes. Near a part the distance is
 * minimized by Newton's method on the part, from its point in the middle; boxes that are farther than the best point so
 * far are left out, and patches and parts whose oriented boxes are: these are flat. The point that is found is always
 * one of the surface, so its distance is an upper bound.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_NEAREST_H
#define CO_MEASURE_NEAREST_H

#include "measure/box_tree.h"
#include "measure/pieces.h"

typedef struct co_part {
    int32_t piece; /* of co_surface_pieces; of a tip - 1 - its number */
    float side;    /* of the part in the piece: a power of 1/2 */
    float u, v;    /* its corner of least parameters: exact, too */
    co_oriented_box box;
} co_part;

typedef struct co_nearest {
    const co_surface_pieces *pieces;
    int32_t n_parts;
    co_part *part;        /* [n_parts] patch by patch */
    int32_t *first;       /* [n_patches + 1] first part of each patch */
    co_oriented_box *box; /* [n_patches] round each patch */
    co_box_tree tree;     /* of the patches */
} co_nearest;

/* A point of the surface. */
typedef struct co_surface_point {
    double at[3];
    double distance;
    double uv[2];    /* parameters on its piece */
    int32_t piece;   /* as in co_part */
    int32_t part;    /* the part it was found on */
    int32_t n_steps; /* of Newton's method that it took to find it */
} co_surface_point;

/* The pieces must stay where they are. cancel may be NULL. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_nearest_create(const co_surface_pieces *pieces, const curvopt_cancel *cancel, co_nearest *out,
                          curvopt_error *error);
void co_nearest_free(co_nearest *nearest);
/* The surface's point nearest to x; `hint` is a part where to look first, or -1. */
void co_nearest_find(const co_nearest *nearest, const double x[3], int32_t hint, co_surface_point *out);
/* The same on one piece, u in [u[0], u[1]] and v in [v[0], v[1]], by Newton's method from uv; returns the distance, and
 * adds to *n_steps, unless that is NULL. */
double co_nearest_on_piece(const double piece[CO_BEZIER], const double x[3], const double u[2], const double v[2],
                           double uv[2], double at[3], int32_t *n_steps);

#endif

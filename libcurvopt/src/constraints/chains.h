/* Chains of edges whose limit curves follow given curves.
 *
 * Inside regular parts the limit curve of a chain is a cubic B-spline whose knots are the limit points of its vertices.
 * These are held, on every level anew, those of the vertices in the middles of the coarser level's edges as well: as
 * many as the spline has freedoms, but two that an open chain has at its ends. So the limit points of the middles of
 * its first and last edges are held, too, on levels that are fine enough for the curve's bends there
 * (libcurvopt/notes/122-a-chain-of-edges-on-a-curve.md).
 *
 * Or springs draw the same points: by quadrature of the squared distance along the chain, so that a chain is as stiff
 * on every level (libcurvopt/notes/123-soft-chains.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_CHAINS_H
#define CO_CONSTRAINTS_CHAINS_H

#include "constraints/surface_values.h"
#include "linalg/cubic_spline.h"

typedef struct co_chain {
    int32_t number; /* of the user's chain */
    int32_t n;      /* vertices on this level */
    int32_t is_closed;
    int32_t *vertex; /* [n] */
    double step;     /* from one to the next, in those of the first level */
    double turn;     /* what the curve's parameter grows by from there to there on average, if it is closed */
    co_cubic_spline
        parameter; /* of the curve, over the first level's vertices; of a closed chain less turn times that */
    co_cubic_spline curve;
    double
        stiffness; /* of springs for each of the first level's edges, as in co_surface_value; 0: it is held exactly */
} co_chain;

typedef struct co_chains {
    int32_t n;
    co_chain *item; /* [n] */
} co_chains;

void co_chains_free(co_chains *chains);
void co_chain_free(co_chain *chain);
/* Whether one of them is held exactly. */
int co_chains_hold_any(const co_chains *chains);
/* Number of edges on this level. */
int32_t co_chain_edges(const co_chain *chain);
/* From a mesh to its subdivision. ERROR_MEMORY. */
int32_t co_chains_subdivide(const curvopt_mesh *mesh, co_chains *chains, curvopt_error *error);
/* The place for number `at` of the chain's vertices on this level, or between two of them. */
void co_chain_place(const co_chain *chain, double at, double place[3]);
/* Adds to `values`, which has room for two per chain, the middles of the end edges of open chains that are held, as
 * optional ones of the chains' numbers; takes those off that are there. */
void co_chains_hold_middles(const curvopt_mesh *mesh, const co_chains *chains, co_surface_values *values);
/* Adds to `values` the points that springs of chains draw, as optional ones of the chains' numbers; takes those off
 * that are there. ERROR_MEMORY. */
int32_t co_chains_draw(const curvopt_mesh *mesh, const co_chains *chains, co_surface_values *values,
                       curvopt_error *error);
/* A half-edge between two vertices, that may run either way; -1. */
int32_t co_chains_find_edge(const curvopt_mesh *mesh, int32_t from, int32_t to);

#endif

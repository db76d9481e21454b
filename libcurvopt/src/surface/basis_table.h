/* Quadrature points, weights and basis rows of a kind of face (fan.h): built once, shared by all faces of that kind.
 * What finite elements call tabulated shape functions. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BASIS_TABLE_H
#define CO_SURFACE_BASIS_TABLE_H

#include "base/cancel.h"
#include "base/thread_pool.h"
#include "surface/blend_fit.h"
#include "surface/stam.h"

/* Derivatives are with respect to the face's parameters; round a smooth extraordinary vertex and where there is a blend
 * to its map (chart.h); at other fans to the cell's own parameters, which range over 0..1. Energies do not care. */
typedef struct co_basis_table {
    int32_t surface;        /* curvopt_surface of this kind (co_blend_fit_surface) */
    int32_t kind;           /* kind of face (fan.h) */
    int32_t n_points;       /* points of a patch on which the surface depends */
    int32_t n_own;          /* of which no coefficients of a disc; they stand first */
    int32_t n_samples;      /* quadrature points */
    int32_t *support;       /* [n_points] numbers of these points among the patch's (ring.h) */
    double *area_weight;    /* [n_samples] for integrals of smooth functions */
    double *weight;         /* [n_samples] for integrals of squared curvature, which behave differently in the limit */
    double *jacobian_scale; /* [n_samples] undoes the shrinking of the rings in |S_u x S_v| */
    double *rows;           /* [n_samples][n_points][CO_JET], of a mixed table
                               [parts][n_samples][n_points][CO_JET][lanes] (basis_table_mixed.h); round
                               extraordinary vertices of the limit surface third derivatives are NAN, for no energy of
                               third order is finite there */
    int32_t n_side;         /* samples a side of a regular face, those of one v after the other; else 0 */
    double *side;           /* [n_side][4][4] co_bspline_cubic() at these: one-dimensional shape functions, whose tensor
                               products are a regular face's rows; else NULL */
    int is_mixed;           /* whether each vector lane has a kind of its own (basis_table_mixed.h) */
    double *blend;          /* [n_samples][CO_JET] the weight w(u) w(v) of `plane`; NULL on other surfaces */
    double *masks;          /* [3][n_points] limit position and tangents at the vertex, for `plane`; else NULL */
} co_basis_table;

/* What a table is made with. */
typedef struct co_table_making {
    const co_blend_fit *polynomial; /* that of the kind's vertex (blend_fit.h), on surfaces that have one */
    co_thread_pool *threads;        /* NULL: the calling thread alone */
    co_cancel *cancel;              /* NULL: none */
} co_table_making;

/* Builds the table of a kind of face on a surface, which is co_blend_fit_surface's of the kind, with a rule
 * (face_rule.h). Time and memory grow like samples times points. ERROR_MEMORY, CO_CANCELLED. */
int32_t co_basis_table_make(int32_t surface, int32_t kind, int32_t rule, const co_table_making *making,
                            co_basis_table **out, curvopt_error *error);
void co_basis_table_destroy(co_basis_table *table);

#endif

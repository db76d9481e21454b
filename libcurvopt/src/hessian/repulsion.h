/* What keeps a surface from crossing itself: a barrier between parts that are no neighbours, and a look at each point.
 *
 * From the points x of a grid on all pieces (facing.h), `weight` times the sum, by area, of the barrier of Li et al.,
 * "Incremental potential contact", ACM TOG 39(4), 2020, eq. 6, of the distances d to what they face,
 *
 *     b(d) = -(d / reach - 1)^2 ln(d / reach)   for d < reach, else 0,
 *
 * which has two continuous derivatives and is infinite at 0. Distances are to the limit surface itself, so that the sum
 * is a quadrature of an integral over it. A step may still lead through a surface, past a boundary, or fold neighbours:
 * where crossings.h proves a crossing that the first cage did not have, the value is infinite
 * (libcurvopt/notes/113-no-crossings.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_REPULSION_H
#define CO_HESSIAN_REPULSION_H

#include "hessian/sparse_hessian.h"
#include "measure/facing.h"

/* Of a patch with an extraordinary corner: how small the tip is at which its rings end; as where crossings are reported
 * (api/measure.c). */
#define CO_REPULSION_TIP (1.0 / 256)

/* What a run's first cage does already. */
typedef struct co_repulsion_exceptions {
    co_face_pairs pairs; /* that touch, cross or are near a crossing: they do not repel each other */
    int32_t *n_refused;  /* counts points at which crossings were worse */
    int32_t failed;      /* status: memory is out, in a look of any level */
} co_repulsion_exceptions;

/* How crossings are looked for. */
typedef enum co_look { CO_LOOK_NONE, CO_LOOK_CURSORY, CO_LOOK_THOROUGH } co_look;

typedef struct co_repulsion {
    const curvopt_mesh *mesh;            /* the caller's; NULL: there is no repulsion */
    co_repulsion_exceptions *exceptions; /* the caller's */
    co_thread_pool *threads;             /* the caller's */
    co_patch_neighbours neighbours;
    co_surface_pieces pieces; /* at the positions that were looked at last */
    co_facings facings;       /* there */
    double reach;             /* in units of the positions */
    double weight;            /* 0 at first */
    double *area;             /* [n_pieces] in parts of the whole, at first */
    double *clear;            /* [3 n_points] the patches' points where crossings were looked for last */
    co_look clear_look;       /* how they were looked for there */
    double clearance;         /* least distance of what faces each other there, at most reach; 0: none
                                 were looked at */
    double *row;              /* work: weights of a patch's points */
    double *point_gradient;   /* [3 n_points] work */
    int is_thorough;          /* crossings are looked for as in reports; else sooner given up, and not
                                 near where they were looked for last */
} co_repulsion;

/* Of positions x [3 n_vertices]. Borrows mesh, exceptions and threads. substitution: as co_assembly_create.
 * ERROR_MEMORY, ERROR_TOPOLOGY. */
int32_t co_repulsion_create(const curvopt_mesh *mesh, const co_substitution *substitution, const double *x,
                            double reach, co_repulsion_exceptions *exceptions, co_thread_pool *threads,
                            co_repulsion *out, curvopt_error *error);
void co_repulsion_free(co_repulsion *repulsion);
static inline int32_t co_repulsion_failed(const co_repulsion *r) {
    return r->exceptions ? r->exceptions->failed : CURVOPT_OK;
}
/* Reach, weight and areas of another one on the same mesh. */
void co_repulsion_copy(co_repulsion *repulsion, const co_repulsion *other);

/* Where the first cage crosses itself: crossings at x, where a level begins, are no worse than that either. Which pairs
 * of faces cross is a matter of rounding where one is crossed at its rim. */
void co_repulsion_accept(co_repulsion *repulsion, const double *x);
/* The value at positions x [3 n_vertices], INFINITY where the surface crosses itself anew, and where memory is out;
 * gradient [3 n_vertices] becomes that with respect to x, unless NULL. */
double co_repulsion_value(co_repulsion *repulsion, const double *x, double *gradient);
/* Looks at positions without crossings: what faces what, for the two functions below. */
void co_repulsion_look(co_repulsion *repulsion, const double *x);
/* hessian += sum of b'' grad d grad d^T, where was looked last; of d itself the second derivatives are left out. */
void co_repulsion_add_hessian(co_repulsion *repulsion, co_sparse_hessian *hessian);
/* Vertices that depend on each other there, beside those of the energy. ERROR_MEMORY. */
int32_t co_repulsion_couplings(const co_repulsion *repulsion, co_couplings *out, curvopt_error *error);
/* Whether the pattern has entries for all of them. */
int co_repulsion_is_covered(const co_repulsion *repulsion, const co_sparsity *pattern, const co_dof_map *dofs);

#endif

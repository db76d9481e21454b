/* Energies and gradients of a block of faces of one kind, one face per vector lane.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ELEMENT_KERNEL_H
#define CO_ENERGY_ELEMENT_KERNEL_H

#include "energy/functional.h"
#include "surface/basis_table.h"

enum { CO_MAX_LANES = 8 };

/* Results per face beside the integrals: least and mean |S_u x S_v| over the samples, without the rings' scaling. */
enum { CO_SUM_MIN_JACOBIAN = CO_N_INTEGRALS, CO_SUM_MEAN_JACOBIAN, CO_N_SUMS };

/* An evaluation of one block: n_used faces in L lanes; unused lanes repeat a used one and are ignored by the caller. */
typedef struct co_element_block {
    const co_basis_table *table;
    const int32_t *points;  /* [table->n_points][L] */
    const double *xyz;      /* [3 n_points of the whole surface] */
    double eps4;            /* co_functional_eps4() */
    co_integrand integrand; /* integrand of the gradient */
    int third;              /* third-order integrals are wanted */
    int gradient;           /* the gradient of the integral of `integrand` is wanted */
    int area_gradient;      /* the area's gradient is wanted, too */
    co_cancel *cancel;      /* leaves samples out; NULL: never */
    double *sums;           /* [CO_N_SUMS][L] out */
    double *gradients;      /* [n_points][1 + area_gradient][3][L] out: of int integrand dA, then of the area */
    double *work;           /* [9 n_points][L], 64-byte aligned */
} co_element_block;

/* Second derivatives of a block's faces with respect to their points, of two kinds: the Gauss-Newton matrix, 2 sum over
 * samples and residuals r (kernel_gauss_newton.h) of grad r grad r^T, never indefinite; and the Hessian itself. */
typedef struct co_element_hessian {
    const co_basis_table *table;
    const int32_t *points; /* [table->n_points][L] */
    const double *xyz;     /* [3 n_points of the whole surface] */
    const double
        *before; /* as xyz: where the last step began, for the lifted Newton method; NULL: the Hessian itself */
    double eps4; /* co_functional_eps4() */
    co_integrand integrand;
    co_cancel *cancel; /* leaves samples out; NULL: never */
    int third;         /* the integrand has third-order parts */
    int exact;      /* 1: the Hessian; on irregular faces of `plane`, which is not linear, Gauss-Newton all the same */
    double *matrix; /* out: lower triangle by rows, [3 n (3 n + 1) / 2][L], n = table->n_points */
    double *work;   /* [co_element_hessian_work(n_points)][L], 64-byte aligned */
} co_element_hessian;

/* Gradients of residuals that are gathered before they are multiplied. */
enum { CO_SECOND_COLUMNS = 28 };

static inline size_t co_element_hessian_work(int32_t n_points) {
    return 3 * (size_t)n_points * (CO_SECOND_COLUMNS + 1);
}

typedef struct co_element_kernel {
    int lanes;
    const char *name;
    void (*run)(const co_element_block *block);
    void (*run_second)(const co_element_hessian *block);
} co_element_kernel;

/* The widest kernel that this processor can run; `wanted` (may be NULL) names one instead. NULL if there is none such.
 */
const co_element_kernel *co_element_kernel_select(const char *wanted);

#endif

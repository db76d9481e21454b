/* Energies and gradients of a block of faces of one kind, one face per vector lane.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SWEEP_H
#define CO_SWEEP_H

#include "functional.h"
#include "patch_table.h"

enum { CO_MAX_LANES = 8 };

/* Per-face results beside the integrals: least and mean |S_u x S_v| over the samples, rings' shrinking undone. */
enum { CO_SUM_MIN_JACOBIAN = CO_N_INTEGRALS, CO_SUM_MEAN_JACOBIAN, CO_N_SUMS };

/* One block: n_used faces in L lanes; unused lanes repeat a used one and are ignored by the caller. */
typedef struct co_sweep {
    const co_table *table;
    const int32_t *points;  /* [table->n_points][L] */
    const double *xyz;      /* [3 n_points of the whole surface] */
    double eps4;            /* functional.h's regularization: eps to the fourth */
    co_integrand integrand; /* whose gradient is wanted */
    int third;              /* whether third-order integrals are wanted */
    int gradient;           /* whether the gradient is wanted, */
    int area_gradient;      /* and the area's */
    double *sums;           /* [CO_N_SUMS][L] out */
    double *gradients;      /* [n_points][1 + area_gradient][3][L] out: of int integrand dA, then of the area */
    double *work;           /* [9 n_points][L], 64-byte aligned */
} co_sweep;

/* The Gauss-Newton matrix of a block's faces, sum over samples and residuals r of grad r grad r^T with respect to the
 * face's points: sum of (integrand's own) halves of second derivatives, times 2. */
typedef struct co_normal_sweep {
    const co_table *table;
    const int32_t *points; /* as in co_sweep */
    const double *xyz;
    double eps4;
    co_integrand integrand;
    int second, third; /* which residuals there are */
    double *matrix;    /* out: lower triangle by rows, [3 n (3 n + 1) / 2][L], n = table->n_points */
    double *work;      /* [co_sweep_normal_work(n_points)][L], 64-byte aligned */
} co_normal_sweep;

enum { CO_NORMAL_COLUMNS = 28 }; /* gradients of residuals that are gathered before they are multiplied */

static inline size_t co_sweep_normal_work(int32_t n_points) {
    return 3 * (size_t)n_points * (CO_NORMAL_COLUMNS + 3);
}

typedef struct co_sweep_kernel {
    int lanes;
    const char *name;
    void (*run)(const co_sweep *sweep);
    void (*run_normal)(const co_normal_sweep *sweep);
} co_sweep_kernel;

/* The widest kernel that this processor can run; `wanted` (may be NULL) names one instead. NULL if there is none such.
 */
const co_sweep_kernel *co_sweep_select(const char *wanted);

#endif

/* Energies and gradients of a block of faces of one kind, one face per vector lane.
 *
 * A block has as many faces on every processor, for sums are added block by block, and their last digits would differ
 * else (libcurvopt/notes/98-other-platforms.md). A kernel takes them a part at a time, as many as its
 * vectors have lanes, L; arrays of n numbers a face are [parts][n][L].
 *
 *     block of 8, L = 4, n = 2, faces a .. h:    a0 b0 c0 d0  a1 b1 c1 d1    e0 f0 g0 h0  e1 f1 g1 h1
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ELEMENT_KERNEL_H
#define CO_ENERGY_ELEMENT_KERNEL_H

#include "energy/functional.h"
#include "surface/basis_table.h"

enum { CO_BLOCK_FACES = 8 }; /* every kernel's lanes divide it */

/* Place of the first of `n` numbers of a face in a block's array; the others follow at a distance of `lanes`. */
static inline size_t co_lane_place(size_t face, size_t n, size_t lanes) {
    return face / lanes * n * lanes + face % lanes;
}

/* Results per face beside the integrals: least and mean |S_u x S_v| over the samples, without the rings' scaling; and
 * the integral of |F1 F3| over the samples at whose distance from an umbilic X jumps (kernel_umbilic.h), which is
 * summed with third-order integrals if it is wanted, else 0. */
enum { CO_SUM_MIN_JACOBIAN = CO_N_INTEGRALS, CO_SUM_MEAN_JACOBIAN, CO_SUM_JUMP, CO_N_SUMS };

/* An evaluation of one block. Unused lanes repeat a used face, and the caller ignores them; parts without a face are
 * left out. */
typedef struct co_element_block {
    const co_basis_table *table;
    int32_t n_used;         /* faces */
    const int32_t *points;  /* [parts][table->n_points][L] */
    const double *xyz;      /* [3 n_points of the whole surface] */
    double eps4;            /* co_assembly.eps4 */
    co_integrand integrand; /* integrand of the gradient */
    int third;              /* third-order integrals are wanted */
    int gradient;           /* the gradient of the integral of `integrand` is wanted */
    int area_gradient;      /* the area's gradient is wanted, too */
    int volume;             /* the volume is wanted */
    int jump;               /* CO_SUM_JUMP is wanted */
    int first_order;        /* area and volume alone are wanted, which need first derivatives only */
    co_cancel *cancel;      /* leaves samples out; NULL: never */
    double *sums;           /* [parts][CO_N_SUMS][L] out */
    double *gradients;      /* [parts][n_points][1 + area_gradient][3][L] out: of int integrand dA, then of the area */
    double *work;           /* [9 n_points][L], 64-byte aligned */
} co_element_block;

/* Second derivatives of a block's faces with respect to their points, of two kinds: the Gauss-Newton matrix, 2 sum over
 * samples and residuals r (kernel_gauss_newton.h) of grad r grad r^T, never indefinite; and the Hessian itself. */
typedef struct co_element_hessian {
    const co_basis_table *table;
    int32_t n_used;        /* as of co_element_block */
    const int32_t *points; /* [parts][table->n_points][L] */
    const double *xyz;     /* [3 n_points of the whole surface] */
    const double
        *before; /* as xyz: where the last step began, for the lifted Newton method; NULL: the Hessian itself */
    double eps4; /* co_assembly.eps4 */
    co_integrand integrand;
    co_cancel *cancel; /* leaves samples out; NULL: never */
    int third;         /* the integrand has third-order parts */
    int exact;      /* 1: the Hessian; on irregular faces of `plane`, which is not linear, Gauss-Newton all the same */
    double *matrix; /* out: lower triangles by rows, [parts][co_element_hessian_size(n)][L], n = table->n_points */
    double *work;   /* [co_element_hessian_work(n_points)][L], 64-byte aligned */
} co_element_hessian;

/* Gradients of residuals that are gathered before they are multiplied. */
enum { CO_SECOND_COLUMNS = 28 };

/* Numbers of a face's matrix. */
static inline size_t co_element_hessian_size(int32_t n_points) {
    return 3 * (size_t)n_points * (3 * (size_t)n_points + 1) / 2;
}

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

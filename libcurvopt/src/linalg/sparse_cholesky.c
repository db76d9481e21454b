/* Sparse Cholesky factorization: CHOLMOD, behind what we need of it.
 *
 * Chen, Davis, Hager, Rajamanickam, "Algorithm 887: CHOLMOD", ACM TOMS 35(3), 2008. It orders, finds supernodes, and
 * makes small and indefinite factors; the numbers of large ones are made by supernodal_cholesky.c, for CHOLMOD can
 * neither be cancelled nor share them between threads (notes/43-threads-of-the-factor.md). Inertia is counted from an
 * L D L^T without pivots, and the count is checked afterwards: see check_count().
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/sparse_cholesky.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/memory.h"
#include "linalg/supernodal_cholesky.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

/* Operations a number that there is room for, from which dense blocks are worth while; CHOLMOD's own rule, which counts
 * the factor's entries alone. */
static const double DENSE_ENOUGH = 40;

struct co_sparse_cholesky {
    cholmod_common common;
    co_thread_pool *threads; /* the caller's, or NULL */
    co_cancel *cancel;       /* likewise */
    cholmod_sparse matrix;
    co_supernodes structure;
    int is_supernodal;                  /* whether L L^T is made by supernodes; else it is made as L D L^T */
    co_supernodal_cholesky *supernodal; /* made when first needed, and with it: */
    double *l;                          /* [structure.value_start[n_supernodes]] */
    cholmod_factor *ldl;                /* a simplicial L D L^T; made when first needed */
    int solves_by_ldl;                  /* it was factored last */
    cholmod_dense *right, *x;           /* of a solution by it, kept between solutions */
    cholmod_dense *y;                   /* CHOLMOD's work space, kept as well */
};

int32_t co_sparse_cholesky_create(int32_t n, int32_t *column_start, int32_t *row, double *value,
                                  co_thread_pool *threads, co_cancel *cancel, co_sparse_cholesky **out,
                                  curvopt_error *error) {
    co_sparse_cholesky *f = *out = CO_NEW(co_sparse_cholesky, 1);
    if (!f)
        return co_status_no_memory(error);
    f->threads = threads;
    f->cancel = cancel;
    cholmod_start(&f->common);
    f->common.print = 0;
    f->common.error_handler = NULL;
    f->common.grow2 = 0; /* room for what the analysis says */
    f->matrix = (cholmod_sparse){.nrow = (size_t)n,
                                 .ncol = (size_t)n,
                                 .nzmax = (size_t)column_start[n],
                                 .p = column_start,
                                 .i = row,
                                 .x = value,
                                 .stype = -1,
                                 .itype = CHOLMOD_INT,
                                 .xtype = CHOLMOD_REAL,
                                 .dtype = CHOLMOD_DOUBLE,
                                 .sorted = 1,
                                 .packed = 1};
    int32_t status = co_supernodes_create(n, column_start, row, &f->common, &f->structure, error);
    if (status != CURVOPT_OK) {
        co_sparse_cholesky_destroy(f);
        *out = NULL;
        return status;
    }
    f->is_supernodal =
        f->structure.operations >= DENSE_ENOUGH * (double)f->structure.value_start[f->structure.n_supernodes];
    return CURVOPT_OK;
}

void co_sparse_cholesky_destroy(co_sparse_cholesky *f) {
    if (!f)
        return;
    co_supernodal_cholesky_destroy(f->supernodal);
    co_supernodes_free(&f->structure);
    free(f->l);
    cholmod_free_factor(&f->ldl, &f->common);
    cholmod_free_dense(&f->right, &f->common);
    cholmod_free_dense(&f->x, &f->common);
    cholmod_free_dense(&f->y, &f->common);
    cholmod_finish(&f->common);
    free(f);
}

/* Later versions of SuiteSparse ask for the number of threads when they start; they are linked with this instead of
 * their run time of threads (cholmod.cmake), of which nothing else is needed here. */
int co_sparse_cholesky_most_threads(void);

int co_sparse_cholesky_most_threads(void) {
    return 1;
}

/* ------------------------------------------------------------------------------------------------- factors -- */

static int32_t factorize_supernodal(co_sparse_cholesky *f, double shift, int *positive, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    if (!f->l)
        f->l = CO_NEW_ALIGNED(double, f->structure.value_start[f->structure.n_supernodes]);
    if (!f->l)
        return co_status_no_memory(error);
    if (!f->supernodal)
        status = co_supernodal_cholesky_create(&f->structure, f->matrix.p, f->matrix.i, f->threads, f->cancel,
                                               &f->supernodal, error);
    return status == CURVOPT_OK ? co_supernodal_cholesky_factorize(f->supernodal, f->matrix.x, shift, f->l, positive)
                                : status;
}

/* An empty L D L^T. */
static cholmod_factor *allocate_ldl(co_sparse_cholesky *f) {
    const co_supernodes *s = &f->structure;
    cholmod_factor *ldl = cholmod_allocate_factor((size_t)s->n, &f->common);
    if (!ldl)
        return NULL;
    memcpy(ldl->Perm, s->permutation, sizeof(int) * (size_t)s->n);
    for (int k = 0; k < s->n_supernodes; k++)
        for (int j = 0; j < co_supernodes_width(s, k); j++)
            ((int *)ldl->ColCount)[s->column[k] + j] = co_supernodes_n_rows(s, k) - j;
    ldl->ordering = CHOLMOD_GIVEN;
    return ldl;
}

/* Rows of an L D L^T after which the flag is looked at. */
enum { ROWS_AT_ONCE = 16 };

/* L D L^T, row by row, until a pivot is zero: ldl->minor is its number then, and else n. */
static int32_t factorize_ldl(co_sparse_cholesky *f, double shift, curvopt_error *error) {
    double beta[2] = {shift, 0};
    const size_t n = f->matrix.nrow;
    if (!f->ldl)
        f->ldl = allocate_ldl(f);
    if (!f->ldl)
        return co_status_no_memory(error);
    cholmod_sparse *permuted = cholmod_ptranspose(&f->matrix, 2, f->ldl->Perm, NULL, 0, &f->common);
    int32_t status = permuted ? CURVOPT_OK : co_status_no_memory(error);
    f->ldl->minor = n;
    for (size_t k = 0; f->ldl->nz && k < n; k++) /* the columns of an earlier one are empty again */
        ((int *)f->ldl->nz)[k] = 1;
    for (size_t k = 0; k < n && f->ldl->minor == n && status == CURVOPT_OK; k += ROWS_AT_ONCE) {
        cholmod_rowfac(permuted, NULL, beta, k, k + ROWS_AT_ONCE < n ? k + ROWS_AT_ONCE : n, f->ldl, &f->common);
        status = f->common.status == CHOLMOD_OUT_OF_MEMORY ? co_status_no_memory(error)
                 : co_cancel_is_due(f->cancel)             ? CO_CANCELLED
                                                           : CURVOPT_OK;
    }
    cholmod_free_sparse(&permuted, &f->common);
    return status;
}

/* Negative entries of D; -1 if one is zero. */
static int32_t count_negative_pivots(const cholmod_factor *ldl) {
    const int *column_start = ldl->p;
    const double *value = ldl->x;
    int32_t n_negative = 0;
    if (ldl->minor < ldl->n)
        return -1;
    for (size_t j = 0; j < ldl->n; j++) /* D stands first in each column */
        n_negative += !(value[column_start[j]] > 0);
    return n_negative;
}

int32_t co_sparse_cholesky_factorize(co_sparse_cholesky *f, double shift, int *positive, curvopt_error *error) {
    *positive = 0;
    f->solves_by_ldl = !f->is_supernodal;
    if (f->is_supernodal)
        return factorize_supernodal(f, shift, positive, error);
    int32_t status = factorize_ldl(f, shift, error);
    *positive = status == CURVOPT_OK && count_negative_pivots(f->ldl) == 0;
    return status;
}

static int32_t solve_by_ldl(co_sparse_cholesky *f, const double *b, double *x, curvopt_error *error) {
    size_t n = f->matrix.nrow;
    cholmod_dense *e = NULL; /* that supernodal factors would need */
    if (!cholmod_ensure_dense(&f->right, n, 1, n, CHOLMOD_REAL, &f->common))
        return co_status_no_memory(error);
    memcpy(f->right->x, b, sizeof(double) * n);
    if (!cholmod_ensure_dense(&f->y, n, 1, n, CHOLMOD_REAL, &f->common)) /* CHOLMOD 3 does not look whether it is */
        return co_status_no_memory(error);
    if (!cholmod_solve2(CHOLMOD_A, f->ldl, f->right, NULL, &f->x, NULL, &f->y, &e, &f->common))
        return co_status_no_memory(error);
    memcpy(x, f->x->x, sizeof(double) * n);
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------------- inertia -- */

/* Probes: the count below is wrong and believed with a probability of at most 10^-PROBES. */
enum { PROBES = 6 };

/* Normally distributed numbers: Box and Muller 1958, from Marsaglia's xorshift, the same in every run. */
static void draw_normal(size_t n, uint64_t *state, double *out) {
    for (size_t i = 0; i < n; i++) {
        double uniform[2];
        for (int k = 0; k < 2; k++) {
            *state ^= *state << 13;
            *state ^= *state >> 7;
            *state ^= *state << 17;
            uniform[k] = ((double)(*state >> 11) + 0.5) * 0x1p-53; /* inside 0..1 */
        }
        out[i] = sqrt(-2 * co_log(uniform[0])) * co_cos_pi(2 * uniform[1]);
    }
}

/* out [n] = (matrix + shift) v */
static void multiply_matrix(const co_sparse_cholesky *f, double shift, const double *v, double *out) {
    const int *start = f->matrix.p, *row = f->matrix.i;
    const double *value = f->matrix.x;
    for (size_t j = 0; j < f->matrix.ncol; j++)
        out[j] = shift * v[j];
    for (size_t j = 0; j < f->matrix.ncol; j++)
        for (int e = start[j]; e < start[j + 1]; e++) {
            out[row[e]] += value[e] * v[j];
            if ((size_t)row[e] != j)
                out[j] += value[e] * v[row[e]];
        }
}

/* out [n] = P^T L D L^T P v for a simplicial factor, whose columns begin with D; work [n]. */
static void multiply_factors(const cholmod_factor *ldl, const double *v, double *work, double *out) {
    const int *start = ldl->p, *row = ldl->i, *length = ldl->nz, *order = ldl->Perm;
    const double *value = ldl->x;
    for (size_t j = 0; j < ldl->n; j++)
        work[j] = v[order[j]];
    for (size_t j = 0; j < ldl->n; j++) { /* D L^T: column j needs the entries below it, still untouched */
        for (int e = start[j] + 1; e < start[j] + length[j]; e++)
            work[j] += value[e] * work[row[e]];
        work[j] *= value[start[j]];
    }
    for (size_t j = ldl->n; j-- > 0;) /* L: column j gives to entries below it, which need nothing of it any more */
        for (int e = start[j] + 1; e < start[j] + length[j]; e++)
            work[row[e]] += value[e] * work[j];
    for (size_t j = 0; j < ldl->n; j++)
        out[order[j]] = work[j];
}

/* Whether the signs of D count the negative eigenvalues of A = matrix + shift.
 *
 * The computed factors are exact for some B = A + E, and B has as many negative eigenvalues as D (Sylvester's law of
 * inertia). So has A if |B^-1 E| < 1 in the 2-norm: then B - t E = B (I - t B^-1 E) is singular for no t from 0 to 1,
 * and no eigenvalue passes 0 between B and A. Without pivots nothing bounds E beforehand: it is as large as rounding
 * times |L| |D| |L^T|, which may be anything for an indefinite matrix (Bunch, Kaufman, Math. Comp. 31, 1977; Higham,
 * "Accuracy and Stability of Numerical Algorithms", 2nd ed. 2002, chapter 11). So the norm is estimated afterwards, by
 * random probes: for normally distributed w_1 .. w_k, |X| <= 10 sqrt(2 / pi) max |X w_i| but with probability 10^-k
 * (Halko, Martinsson, Tropp, SIAM Review 53, 2011, lemma 4.1).
 *
 * Example: A = (d 1 3; 1 1 .2; 3 .2 1) has one negative eigenvalue. With d first, D = (d, 1 - 1/d, ...). For d = 1e-3
 * that costs three digits: |B^-1 E| = 1e-13, believed. For d = 1e-20 the 1 is lost in 1 - 1e20, and the third pivot
 * is what rounding leaves of -9e20 + 9e20: |B^-1 E| is 1 or more, not believed, whatever the third sign. */
static int32_t check_count(co_sparse_cholesky *f, double shift, int *holds, curvopt_error *error) {
    size_t n = f->matrix.nrow;
    uint64_t state = 88172645463325252u;
    double *work = CO_NEW(double, 4 * n), *probe = work + n, *by_matrix = work + 2 * n, *off = work + 3 * n;
    int32_t status = work ? CURVOPT_OK : co_status_no_memory(error);
    *holds = 1;
    for (int k = 0; status == CURVOPT_OK && k < PROBES; k++) {
        draw_normal(n, &state, probe);
        multiply_matrix(f, shift, probe, by_matrix);
        multiply_factors(f->ldl, probe, work, off);
        co_vector_add(n, -1, by_matrix, off);
        status = solve_by_ldl(f, off, off, error);
        *holds &= 10 * sqrt(2 / CO_PI) * co_vector_norm(n, off) < 1; /* false for NAN */
    }
    free(work);
    return status;
}

int32_t co_sparse_cholesky_factorize_indefinite(co_sparse_cholesky *f, double shift, int32_t *n_negative,
                                                curvopt_error *error) {
    f->solves_by_ldl = 1;
    int32_t status = factorize_ldl(f, shift, error);
    *n_negative = status == CURVOPT_OK ? count_negative_pivots(f->ldl) : -1;
    return status;
}

int32_t co_sparse_cholesky_count_negative(co_sparse_cholesky *f, double shift, int n_right, const double *right,
                                          double *solved, int32_t *n_negative, curvopt_error *error) {
    const size_t n = f->matrix.nrow;
    int holds = 0;
    int32_t status = co_sparse_cholesky_factorize_indefinite(f, shift, n_negative, error);
    if (status == CURVOPT_OK && *n_negative >= 0)
        status = check_count(f, shift, &holds, error);
    if (!holds)
        *n_negative = -1;
    for (size_t k = 0; holds && k < (size_t)n_right && status == CURVOPT_OK; k++)
        status = solve_by_ldl(f, right + k * n, solved + k * n, error);
    if (f->is_supernodal) /* it takes much room, and is seldom needed */
        cholmod_free_factor(&f->ldl, &f->common);
    return status;
}

int32_t co_sparse_cholesky_solve(co_sparse_cholesky *f, const double *b, double *x, curvopt_error *error) {
    return f->solves_by_ldl ? solve_by_ldl(f, b, x, error) : co_supernodal_cholesky_solve(f->supernodal, f->l, b, x);
}

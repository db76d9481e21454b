/* Sparse Cholesky factorization: CHOLMOD, behind what we need of it.
 *
 * Chen, Davis, Hager, Rajamanickam, "Algorithm 887: CHOLMOD", ACM TOMS 35(3), 2008. Ordered by AMD; supernodal where
 * that pays, which CHOLMOD decides.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/sparse_cholesky.h"

#include "base/memory.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

struct co_sparse_cholesky {
    cholmod_common common;
    cholmod_sparse matrix;
    cholmod_factor *factor;
    cholmod_dense *right, *x, *y, *e; /* for solving, kept: b, the solution, CHOLMOD's work space */
};

int32_t co_sparse_cholesky_create(int32_t n, int32_t *column_start, int32_t *row, double *value,
                                  co_sparse_cholesky **out, curvopt_error *error) {
    co_sparse_cholesky *f = *out = CO_NEW(co_sparse_cholesky, 1);
    if (!f)
        return co_status_no_memory(error);
    cholmod_start(&f->common);
    f->common.print = 0;
    f->common.error_handler = NULL;
    f->common.nmethods = 1;
    f->common.method[0].ordering = CHOLMOD_AMD;
    f->common.postorder = 1;
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
    f->factor = cholmod_analyze(&f->matrix, &f->common);
    if (f->factor)
        return CURVOPT_OK;
    co_sparse_cholesky_destroy(f);
    *out = NULL;
    return co_status_no_memory(error);
}

void co_sparse_cholesky_destroy(co_sparse_cholesky *f) {
    if (!f)
        return;
    cholmod_free_factor(&f->factor, &f->common);
    cholmod_free_dense(&f->right, &f->common);
    cholmod_free_dense(&f->x, &f->common);
    cholmod_free_dense(&f->y, &f->common);
    cholmod_free_dense(&f->e, &f->common);
    cholmod_finish(&f->common);
    free(f);
}

/* CHOLMOD 3 takes four threads for loops over a few hundred numbers, however many there are: waking them costs a tenth
 * of a factor of such a size and brings nothing to larger ones. */
static void factorize_alone(co_sparse_cholesky *f, cholmod_factor *factor, double shift) {
    double beta[2] = {shift, 0};
    int levels = omp_get_max_active_levels();
    omp_set_max_active_levels(0);
    cholmod_factorize_p(&f->matrix, beta, NULL, 0, factor, &f->common);
    omp_set_max_active_levels(levels);
}

int32_t co_sparse_cholesky_factorize(co_sparse_cholesky *f, double shift, int *positive, curvopt_error *error) {
    *positive = 0;
    factorize_alone(f, f->factor, shift);
    if (f->common.status == CHOLMOD_OUT_OF_MEMORY)
        return co_status_no_memory(error);
    *positive = f->common.status == CHOLMOD_OK && f->factor->minor == f->factor->n;
    return CURVOPT_OK;
}

/* With any factor. */
static int32_t solve_with(co_sparse_cholesky *f, cholmod_factor *factor, const double *b, double *x,
                          curvopt_error *error) {
    size_t n = f->matrix.nrow;
    if (!cholmod_ensure_dense(&f->right, n, 1, n, CHOLMOD_REAL, &f->common))
        return co_status_no_memory(error);
    memcpy(f->right->x, b, sizeof(double) * n);
    /* CHOLMOD 3 looks at the second of these allocations only: see to both before */
    if (!cholmod_ensure_dense(&f->y, n, 1, n, CHOLMOD_REAL, &f->common) ||
        (factor->is_super && !cholmod_ensure_dense(&f->e, 1, factor->maxesize, 1, CHOLMOD_REAL, &f->common)))
        return co_status_no_memory(error);
    if (!cholmod_solve2(CHOLMOD_A, factor, f->right, NULL, &f->x, NULL, &f->y, &f->e, &f->common))
        return co_status_no_memory(error);
    memcpy(x, f->x->x, sizeof(double) * n);
    return CURVOPT_OK;
}

int32_t co_sparse_cholesky_count_negative(co_sparse_cholesky *f, double shift, int n_right, const double *right,
                                          double *solved, int32_t *n_negative, curvopt_error *error) {
    size_t n = f->matrix.nrow;
    int supernodal = f->common.supernodal, final_ll = f->common.final_ll, status = CURVOPT_OK;
    *n_negative = -1;
    f->common.supernodal = CHOLMOD_SIMPLICIAL;
    f->common.final_ll = 0;
    cholmod_factor *ldl = cholmod_analyze(&f->matrix, &f->common);
    if (ldl)
        factorize_alone(f, ldl, shift);
    f->common.supernodal = supernodal;
    f->common.final_ll = final_ll;
    if (!ldl || f->common.status == CHOLMOD_OUT_OF_MEMORY) {
        status = co_status_no_memory(error);
    } else if (ldl->minor == ldl->n) {
        const int *column_start = ldl->p;
        const double *value = ldl->x;
        *n_negative = 0;
        for (size_t j = 0; j < ldl->n; j++) /* D stands first in each column */
            *n_negative += value[column_start[j]] < 0;
        for (size_t k = 0; k < (size_t)n_right && status == CURVOPT_OK; k++)
            status = solve_with(f, ldl, right + k * n, solved + k * n, error);
    }
    cholmod_free_factor(&ldl, &f->common);
    return status;
}

int32_t co_sparse_cholesky_solve(co_sparse_cholesky *f, const double *b, double *x, curvopt_error *error) {
    return solve_with(f, f->factor, b, x, error);
}

/* Structure of a sparse Cholesky factor: the order of its columns, and the supernodes, columns with the same rows below
 * them that lie together in one dense block. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SUPERNODES_H
#define CO_LINALG_SUPERNODES_H

#include "base/cancel.h"
#include "base/status.h"

#include <stddef.h>
#include <suitesparse/cholmod.h>

/* Block s has the rows row[row_start[s]] .. row[row_start[s + 1] - 1], ascending, first those of its own columns
 * column[s] .. column[s + 1] - 1; its values lie by columns from value_start[s] on, above the diagonal too. */
typedef struct co_supernodes {
    int n, n_supernodes;
    int *column;         /* [n_supernodes + 1] */
    int *row_start;      /* [n_supernodes + 1] */
    int *row;            /* [row_start[n_supernodes]] */
    size_t *value_start; /* [n_supernodes + 1] */
    int *permutation;    /* [n] column k of the factor is column permutation[k] of the matrix */
    double operations;   /* of the factor: the sum of the squares of its columns' entries */
} co_supernodes;

/* Of the factor of the symmetric matrix whose lower triangle is column_start [n + 1] and row, by columns with ascending
 * rows, all diagonal entries among them. By CHOLMOD, AMD and `common`. Neighbouring columns with the same rows (the
 * coordinates of a vertex) are found first, and only the graph of these groups is ordered and analyzed: Ashcraft,
 * "Compressed graphs and the minimum degree algorithm", SIAM J. Sci. Comput. 16(6), 1995. ERROR_MEMORY. */
int32_t co_supernodes_create(int n, const int *column_start, const int *row, cholmod_common *common, co_supernodes *out,
                             curvopt_error *error);
void co_supernodes_free(co_supernodes *s);

static inline int co_supernodes_width(const co_supernodes *s, int k) {
    return s->column[k + 1] - s->column[k];
}

static inline int co_supernodes_n_rows(const co_supernodes *s, int k) {
    return s->row_start[k + 1] - s->row_start[k];
}

static inline const int *co_supernodes_rows(const co_supernodes *s, int k) {
    return s->row + s->row_start[k];
}

#endif

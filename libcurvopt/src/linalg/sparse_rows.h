/* Sparse matrices by compressed rows: linear maps from cage points to derived points, applied to x, y and z alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SPARSE_ROWS_H
#define CO_LINALG_SPARSE_ROWS_H

#include "base/status.h"

#include <stddef.h>

/* Row r has the entries start[r] .. start[r + 1] - 1. */
typedef struct co_sparse_rows {
    int32_t n_rows;
    int32_t n_columns;
    size_t *start;   /* [n_rows + 1] first entry of each row */
    int32_t *column; /* [start[n_rows]] column of each entry; no column twice in a row */
    double *value;   /* [start[n_rows]] value of each entry */
} co_sparse_rows;

/* Room for n_rows rows and n_entries entries, zeroed, to be filled by the caller. ERROR_MEMORY, and *rows is empty. */
int32_t co_sparse_rows_allocate(co_sparse_rows *rows, int32_t n_rows, int32_t n_columns, size_t n_entries,
                                curvopt_error *error);
/* Rows end at end [n_rows], before the next one begins: moves them together. */
void co_sparse_rows_close_gaps(co_sparse_rows *rows, const size_t *end);
void co_sparse_rows_free(co_sparse_rows *rows);
/* out [3 n_rows] = rows * in [3 n_columns] */
void co_sparse_rows_apply(const co_sparse_rows *rows, const double *in, double *out);
/* out [3 n_columns] += transpose(rows) * in [3 n_rows] */
void co_sparse_rows_add_transposed(const co_sparse_rows *rows, const double *in, double *out);
/* out = transpose(a), the entries of a row in ascending order of columns. ERROR_MEMORY. */
int32_t co_sparse_rows_transpose(const co_sparse_rows *a, co_sparse_rows *out, curvopt_error *error);
/* out = a b, the entries of a row in ascending order of columns. For each row of a, the rows of b that it meets are
 * merged in an array over all columns (Gustavson, ACM TOMS 4(3), 1978): O(products + n log n of each row's length).
 * ERROR_MEMORY. */
int32_t co_sparse_rows_multiply(const co_sparse_rows *a, const co_sparse_rows *b, co_sparse_rows *out,
                                curvopt_error *error);

#endif

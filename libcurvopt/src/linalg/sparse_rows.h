/* Sparse rows: linear maps from cage points to derived points. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SPARSE_ROWS_H
#define CO_LINALG_SPARSE_ROWS_H

#include "base/status.h"

#include <stddef.h>

/* Compressed rows; row r has entries start[r] .. start[r + 1] - 1. */
typedef struct co_sparse_rows {
    int32_t n_rows;
    int32_t n_columns;
    size_t *start;
    int32_t *column;
    double *value;
} co_sparse_rows;

/* Room for n_rows rows and n_entries entries, to be filled by the caller; all NULL on failure. */
int32_t co_sparse_rows_allocate(co_sparse_rows *rows, int32_t n_rows, int32_t n_columns, size_t n_entries,
                                curvopt_error *error);
void co_sparse_rows_free(co_sparse_rows *rows);
/* out [3 n_rows] = rows * in [3 n_columns] */
void co_sparse_rows_apply(const co_sparse_rows *rows, const double *in, double *out);
/* out [3 n_columns] += transpose(rows) * in [3 n_rows] */
void co_sparse_rows_add_transposed(const co_sparse_rows *rows, const double *in, double *out);
/* out = a * b; entries of a row in ascending column. */
int32_t co_sparse_rows_multiply(const co_sparse_rows *a, const co_sparse_rows *b, co_sparse_rows *out,
                                curvopt_error *error);

#endif

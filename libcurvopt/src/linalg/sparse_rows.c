/* Sparse rows: linear maps from cage points to derived points. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/sparse_rows.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

int32_t co_sparse_rows_allocate(co_sparse_rows *rows, int32_t n_rows, int32_t n_columns, size_t n_entries,
                                curvopt_error *error) {
    *rows = (co_sparse_rows){.n_rows = n_rows, .n_columns = n_columns};
    rows->start = CO_NEW(size_t, (size_t)n_rows + 1);
    rows->column = CO_NEW(int32_t, n_entries);
    rows->value = CO_NEW(double, n_entries);
    if (rows->start && rows->column && rows->value)
        return CURVOPT_OK;
    co_sparse_rows_free(rows);
    return co_status_no_memory(error);
}

void co_sparse_rows_close_gaps(co_sparse_rows *rows, const size_t *end) {
    size_t write = 0;
    for (int32_t i = 0; i < rows->n_rows; i++) {
        const size_t first = rows->start[i], size = end[i] - first;
        memmove(rows->column + write, rows->column + first, size * sizeof *rows->column);
        memmove(rows->value + write, rows->value + first, size * sizeof *rows->value);
        rows->start[i] = write;
        write += size;
    }
    rows->start[rows->n_rows] = write;
}

void co_sparse_rows_free(co_sparse_rows *rows) {
    free(rows->start);
    free(rows->column);
    free(rows->value);
    *rows = (co_sparse_rows){0};
}

void co_sparse_rows_apply(const co_sparse_rows *rows, const double *in, double *out) {
    for (int32_t r = 0; r < rows->n_rows; r++) {
        double sum[3] = {0, 0, 0};
        for (size_t e = rows->start[r]; e < rows->start[r + 1]; e++)
            for (int c = 0; c < 3; c++)
                sum[c] += rows->value[e] * in[3 * (size_t)rows->column[e] + (size_t)c];
        for (int c = 0; c < 3; c++)
            out[3 * (size_t)r + (size_t)c] = sum[c];
    }
}

void co_sparse_rows_add_transposed(const co_sparse_rows *rows, const double *in, double *out) {
    for (int32_t r = 0; r < rows->n_rows; r++)
        for (size_t e = rows->start[r]; e < rows->start[r + 1]; e++)
            for (int c = 0; c < 3; c++)
                out[3 * (size_t)rows->column[e] + (size_t)c] += rows->value[e] * in[3 * (size_t)r + (size_t)c];
}

int32_t co_sparse_rows_transpose(const co_sparse_rows *a, co_sparse_rows *out, curvopt_error *error) {
    const size_t n = a->start[a->n_rows];
    const int32_t status = co_sparse_rows_allocate(out, a->n_columns, a->n_rows, n, error);
    if (status != CURVOPT_OK)
        return status;
    for (size_t e = 0; e < n; e++)
        out->start[a->column[e]]++;
    for (int32_t c = 0; c < a->n_columns; c++) /* so far the row's end */
        out->start[c + 1] += out->start[c];
    for (int32_t r = a->n_rows - 1; r >= 0; r--)
        for (size_t e = a->start[r]; e < a->start[r + 1]; e++) {
            const size_t place = --out->start[a->column[e]];
            out->column[place] = r;
            out->value[place] = a->value[e];
        }
    return CURVOPT_OK;
}

static int compare_columns(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Columns of row r of a * b into `list`, ascending; `mark` remembers the row that met each column last. */
static int32_t product_columns(const co_sparse_rows *a, const co_sparse_rows *b, int32_t r, int32_t *mark,
                               int32_t *list) {
    int32_t n = 0;
    for (size_t e = a->start[r]; e < a->start[r + 1]; e++) {
        int32_t m = a->column[e];
        for (size_t k = b->start[m]; k < b->start[m + 1]; k++)
            if (mark[b->column[k]] != r + 1) {
                mark[b->column[k]] = r + 1;
                list[n++] = b->column[k];
            }
    }
    qsort(list, (size_t)n, sizeof *list, compare_columns);
    return n;
}

int32_t co_sparse_rows_multiply(const co_sparse_rows *a, const co_sparse_rows *b, co_sparse_rows *out,
                                curvopt_error *error) {
    int32_t status = CURVOPT_ERROR_MEMORY;
    int32_t *mark = CO_NEW(int32_t, b->n_columns), *list = CO_NEW(int32_t, b->n_columns);
    double *sum = CO_NEW(double, b->n_columns);
    size_t n_entries = 0;
    *out = (co_sparse_rows){0};
    if (!mark || !list || !sum) {
        co_status_no_memory(error);
        goto done;
    }
    for (int32_t r = 0; r < a->n_rows; r++)
        n_entries += (size_t)product_columns(a, b, r, mark, list);
    status = co_sparse_rows_allocate(out, a->n_rows, b->n_columns, n_entries, error);
    if (status != CURVOPT_OK)
        goto done;
    for (int32_t c = 0; c < b->n_columns; c++)
        mark[c] = 0;
    for (int32_t r = 0; r < a->n_rows; r++) {
        int32_t n = product_columns(a, b, r, mark, list);
        for (size_t e = a->start[r]; e < a->start[r + 1]; e++)
            for (size_t k = b->start[a->column[e]]; k < b->start[a->column[e] + 1]; k++)
                sum[b->column[k]] += a->value[e] * b->value[k];
        out->start[r + 1] = out->start[r] + (size_t)n;
        for (int32_t i = 0; i < n; i++) {
            out->column[out->start[r] + (size_t)i] = list[i];
            out->value[out->start[r] + (size_t)i] = sum[list[i]];
            sum[list[i]] = 0;
        }
    }
done:
    free(mark);
    free(list);
    free(sum);
    return status;
}

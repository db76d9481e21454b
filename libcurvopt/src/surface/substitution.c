/* Patches of a cage some of whose vertices stand for something else. SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/substitution.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { ITSELF = -1 };

/* All cage vertices from what stands in their places. number [n_cage]: row of `rows`, or ITSELF. */
static int32_t all_vertices(int32_t n_cage, const int32_t *number, const co_sparse_rows *rows, co_sparse_rows *out,
                            curvopt_error *error) {
    const size_t n_entries = rows->start[rows->n_rows] + (size_t)(n_cage - rows->n_rows);
    int32_t status = co_sparse_rows_allocate(out, n_cage, n_cage, n_entries, error);
    size_t n = 0;
    for (int32_t v = 0; status == CURVOPT_OK && v < n_cage; v++) {
        if (number[v] == ITSELF) {
            out->column[n] = v;
            out->value[n++] = 1;
        } else {
            const size_t first = rows->start[number[v]], size = rows->start[number[v] + 1] - first;
            memcpy(out->column + n, rows->column + first, size * sizeof *out->column);
            memcpy(out->value + n, rows->value + first, size * sizeof *out->value);
            n += size;
        }
        out->start[v + 1] = n;
    }
    return status;
}

/* Rows of `a`, then those of `b`. */
static int32_t stack(const co_sparse_rows *a, const co_sparse_rows *b, co_sparse_rows *out, curvopt_error *error) {
    const size_t n_a = a->n_rows ? a->start[a->n_rows] : 0, n_b = b->start[b->n_rows];
    int32_t status = co_sparse_rows_allocate(out, a->n_rows + b->n_rows, b->n_columns, n_a + n_b, error);
    if (status != CURVOPT_OK)
        return status;
    if (n_a) {
        memcpy(out->column, a->column, n_a * sizeof *a->column);
        memcpy(out->value, a->value, n_a * sizeof *a->value);
    }
    memcpy(out->column + n_a, b->column, n_b * sizeof *b->column);
    memcpy(out->value + n_a, b->value, n_b * sizeof *b->value);
    for (int32_t r = 0; r < a->n_rows; r++)
        out->start[r + 1] = a->start[r + 1];
    for (int32_t r = 0; r < b->n_rows; r++)
        out->start[a->n_rows + r + 1] = n_a + b->start[r + 1];
    return CURVOPT_OK;
}

static int32_t extend_derived(co_patches *p, const int32_t *number, const co_sparse_rows *rows, curvopt_error *error) {
    co_sparse_rows vertices = {0}, derived = {0}, all = {0};
    int32_t status = CURVOPT_OK;
    if (p->derived.n_rows) {
        status = all_vertices(p->n_cage, number, rows, &vertices, error);
        if (status == CURVOPT_OK)
            status = co_sparse_rows_multiply(&p->derived, &vertices, &derived, error);
    }
    if (status == CURVOPT_OK)
        status = stack(&derived, rows, &all, error);
    co_sparse_rows_free(&vertices);
    co_sparse_rows_free(&derived);
    if (status != CURVOPT_OK)
        return status;
    co_sparse_rows_free(&p->derived);
    p->derived = all;
    return CURVOPT_OK;
}

/* The new number of a point. n_before: derived points that there were. */
static int32_t renumbered(const co_patches *p, const int32_t *number, int32_t n_before, int32_t n_more, int32_t point) {
    if (point >= p->n_cage + n_before) /* a disc's coefficient */
        return point + n_more;
    return point < p->n_cage && number[point] != ITSELF ? p->n_cage + n_before + number[point] : point;
}

int32_t co_patches_substitute(co_patches *p, const co_substitution *s, curvopt_error *error) {
    const co_sparse_rows *rows = s->rows;
    const int32_t n_before = p->derived.n_rows, n_more = rows->n_rows;
    if (!n_more)
        return CURVOPT_OK;
    int32_t *number = CO_NEW(int32_t, p->n_cage);
    if (!number)
        return co_status_no_memory(error);
    for (int32_t v = 0; v < p->n_cage; v++)
        number[v] = ITSELF;
    for (int32_t i = 0; i < n_more; i++)
        number[s->vertex[i]] = i;
    int32_t status = extend_derived(p, number, rows, error);
    if (status == CURVOPT_OK) {
        for (size_t i = 0; i < p->start[p->n_patches]; i++)
            p->points[i] = renumbered(p, number, n_before, n_more, p->points[i]);
        for (size_t i = 0; i < p->wide.n_columns; i++)
            p->wide.column[i] = renumbered(p, number, n_before, n_more, p->wide.column[i]);
        for (int32_t d = 0; d < p->wide.n_discs; d++)
            p->wide.disc[d].first_point += n_more;
        p->n_points += n_more;
    }
    free(number);
    return status;
}

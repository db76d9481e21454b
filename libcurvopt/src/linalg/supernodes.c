/* Structure of a sparse Cholesky factor. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/supernodes.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Groups of columns, and the graph among them as a lower triangle. */
typedef struct groups {
    int n;
    int *of_column;    /* [columns] */
    int *first;        /* [n + 1] first column */
    int *column_start; /* [n + 1] */
    int *row;
} groups;

static void groups_free(groups *g) {
    free(g->of_column);
    free(g->first);
    free(g->column_start);
    free(g->row);
}

/* Bits of a number, mixed: Vigna's splitmix64. */
static uint64_t mixed(int i) {
    uint64_t x = ((uint64_t)i + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* A sum over the rows of each column of the whole matrix, by which columns with the same rows are known. */
static void sum_rows(int n, const int *column_start, const int *row, uint64_t *sum) {
    for (int j = 0; j < n; j++)
        for (int e = column_start[j]; e < column_start[j + 1]; e++) {
            sum[j] += mixed(row[e]);
            if (row[e] != j)
                sum[row[e]] += mixed(j);
        }
}

/* Whether columns j and j + 1 have the same rows. (Below them for certain; if their sums are the same by chance, the
 * factor gets room that it does not need.) */
static int are_alike(const int *column_start, const int *row, const uint64_t *sum, int j) {
    const int *a = row + column_start[j] + 1, *b = row + column_start[j + 1];
    const int n = column_start[j + 1] - column_start[j] - 1;
    return sum[j] == sum[j + 1] && n == column_start[j + 2] - column_start[j + 1] &&
           memcmp(a, b, sizeof *a * (size_t)n) == 0;
}

static int32_t groups_create(int n, const int *column_start, const int *row, groups *g, curvopt_error *error) {
    *g = (groups){.of_column = CO_NEW(int, n),
                  .first = CO_NEW(int, n + 1),
                  .column_start = CO_NEW(int, n + 1),
                  .row = CO_NEW(int, column_start[n])};
    uint64_t *sum = CO_NEW(uint64_t, n);
    if (!g->of_column || !g->first || !g->column_start || !g->row || !sum) {
        free(sum);
        return co_status_no_memory(error);
    }
    sum_rows(n, column_start, row, sum);
    for (int j = 0; j < n; j++) {
        if (j == 0 || !are_alike(column_start, row, sum, j - 1))
            g->first[g->n++] = j;
        g->of_column[j] = g->n - 1;
    }
    free(sum);
    g->first[g->n] = n;
    for (int k = 0, end = 0; k < g->n; k++) {
        const int j = g->first[k];
        for (int e = column_start[j], last = -1; e < column_start[j + 1]; e++) {
            const int to = g->of_column[row[e]];
            if (to != last)
                g->row[end++] = last = to;
        }
        g->column_start[k + 1] = end;
    }
    return CURVOPT_OK;
}

/* The structure of the factor of the groups' graph. */
static cholmod_factor *analyze(groups *g, cholmod_common *common) {
    cholmod_sparse graph = {.nrow = (size_t)g->n,
                            .ncol = (size_t)g->n,
                            .nzmax = (size_t)g->column_start[g->n],
                            .p = g->column_start,
                            .i = g->row,
                            .stype = -1,
                            .itype = CHOLMOD_INT,
                            .xtype = CHOLMOD_PATTERN,
                            .dtype = CHOLMOD_DOUBLE,
                            .sorted = 1,
                            .packed = 1};
    common->nmethods = 1;
    common->method[0].ordering = CHOLMOD_AMD;
    common->postorder = 1;
    common->supernodal = CHOLMOD_SUPERNODAL;
    /* widths of supernodes for which some zeros are no loss: CHOLMOD's own, of groups of three */
    common->nrelax[0] = 2;
    common->nrelax[1] = 5;
    common->nrelax[2] = 16;
    return cholmod_analyze(&graph, common);
}

/* The columns of the groups instead of the groups. */
static int32_t expand(const groups *g, const cholmod_factor *l, co_supernodes *s, curvopt_error *error) {
    const int *order = l->Perm, *group = l->super, *group_row_start = l->pi, *group_row = l->s;
    int *start = CO_NEW(int, g->n + 1); /* first column of each group, in the factor's order */
    size_t n_rows = 0;
    s->n_supernodes = (int)l->nsuper;
    s->column = CO_NEW(int, l->nsuper + 1);
    s->row_start = CO_NEW(int, l->nsuper + 1);
    s->value_start = CO_NEW(size_t, l->nsuper + 1);
    s->permutation = CO_NEW(int, s->n);
    if (!start || !s->column || !s->row_start || !s->value_start || !s->permutation)
        goto no_memory;
    for (int k = 0; k < g->n; k++) {
        start[k + 1] = start[k];
        for (int j = g->first[order[k]]; j < g->first[order[k] + 1]; j++)
            s->permutation[start[k + 1]++] = j;
    }
    for (int e = 0; e < group_row_start[l->nsuper]; e++)
        n_rows += (size_t)(start[group_row[e] + 1] - start[group_row[e]]);
    s->row = n_rows < INT32_MAX ? CO_NEW(int, n_rows) : NULL;
    if (!s->row)
        goto no_memory;
    for (int k = 0, end = 0; k < s->n_supernodes; k++) {
        for (int e = group_row_start[k]; e < group_row_start[k + 1]; e++)
            for (int j = start[group_row[e]]; j < start[group_row[e] + 1]; j++)
                s->row[end++] = j;
        s->row_start[k + 1] = end;
        s->column[k + 1] = start[group[k + 1]];
        const int rows = co_supernodes_n_rows(s, k), width = co_supernodes_width(s, k);
        s->value_start[k + 1] = s->value_start[k] + (size_t)rows * (size_t)width;
        for (int j = 0; j < width; j++)
            s->operations += (double)(rows - j) * (rows - j);
    }
    free(start);
    return CURVOPT_OK;
no_memory:
    free(start);
    return co_status_no_memory(error);
}

int32_t co_supernodes_create(int n, const int *column_start, const int *row, cholmod_common *common, co_supernodes *out,
                             curvopt_error *error) {
    groups g;
    cholmod_factor *l = NULL;
    *out = (co_supernodes){.n = n};
    int32_t status = groups_create(n, column_start, row, &g, error);
    if (status == CURVOPT_OK) {
        l = analyze(&g, common);
        status = l ? expand(&g, l, out, error) : co_status_no_memory(error);
    }
    cholmod_free_factor(&l, common);
    groups_free(&g);
    if (status != CURVOPT_OK)
        co_supernodes_free(out);
    return status;
}

void co_supernodes_free(co_supernodes *s) {
    free(s->column);
    free(s->row_start);
    free(s->row);
    free(s->value_start);
    free(s->permutation);
    *s = (co_supernodes){0};
}

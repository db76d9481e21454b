/* The vertices of the cage that each patch depends on. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/stencils.h"

#include "base/memory.h"

#include <stdlib.h>

void co_stencils_free(co_stencils *s) {
    free(s->start);
    free(s->vertex);
    free(s->column);
    free(s->point);
    free(s->weight);
    free(s->pair);
    free(s->place);
    *s = (co_stencils){0};
}

int co_numbered_vertex_compare(const void *a, const void *b) {
    const co_numbered_vertex *x = a, *y = b;
    if (x->node != y->node)
        return (x->node > y->node) - (x->node < y->node);
    return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

/* What the patches are gone through with. */
typedef struct survey {
    const co_patches *patches;
    const co_dof_map *dofs;
    int32_t *number;           /* [n_cage] number of a vertex among the present patch's; -1: it is none of them */
    co_numbered_vertex *found; /* [n_cage] the present patch's vertices */
} survey;

/* The row of own point k of a patch; empty if nothing depends on it. */
static co_point_row row_of(const survey *v, int32_t patch, int32_t k) {
    const co_patches *p = v->patches;
    if (!co_patches_own_is_used(p->surface, p->kind[patch], k))
        return (co_point_row){0};
    return co_patches_row(p, &p->points[p->start[patch] + (size_t)k]);
}

/* Finds the vertices of a patch, in their order; returns their number, and that of the entries of T. */
static size_t find_vertices(const survey *v, int32_t patch, size_t *n_entries) {
    const co_patches *p = v->patches;
    size_t n = 0;
    for (int32_t k = 0; k < co_patches_own_size(p->kind[patch]); k++) {
        co_point_row row = row_of(v, patch, k);
        for (size_t e = 0; e < row.n; e++) {
            int32_t vertex = row.vertex[e];
            if (v->dofs->node[vertex] < 0)
                continue;
            ++*n_entries;
            if (v->number[vertex] >= 0)
                continue;
            v->number[vertex] = 0;
            v->found[n++] = (co_numbered_vertex){v->dofs->node[vertex], vertex};
        }
    }
    qsort(v->found, n, sizeof *v->found, co_numbered_vertex_compare);
    for (size_t i = 0; i < n; i++)
        v->number[v->found[i].vertex] = (int32_t)i;
    return n;
}

static void forget_vertices(const survey *v, size_t n) {
    for (size_t i = 0; i < n; i++)
        v->number[v->found[i].vertex] = -1;
}

/* Fills `start` and `pair`; returns the number of all entries of T. */
static size_t count(const survey *v, co_stencils *s) {
    size_t n_entries = 0;
    for (int32_t p = 0; p < v->patches->n_patches; p++) {
        size_t n = find_vertices(v, p, &n_entries);
        int32_t own = co_patches_own_size(v->patches->kind[p]), n_used = 0;
        for (int32_t k = 0; k < own; k++)
            n_used += row_of(v, p, k).n > 0;
        forget_vertices(v, n);
        s->start[p + 1] = s->start[p] + n;
        s->pair[p + 1] = s->pair[p] + (n ? n * (n - 1) / 2 : 0);
        s->most_points = own > s->most_points ? own : s->most_points;
        s->most_used = n_used > s->most_used ? n_used : s->most_used;
    }
    return n_entries;
}

/* Fills the columns of T of a patch. Column c's entries end where column[c] says, which ends up at their beginning. */
static void fill_columns(const survey *v, int32_t patch, co_stencils *s) {
    const co_patches *p = v->patches;
    for (int32_t k = co_patches_own_size(p->kind[patch]); k-- > 0;) {
        co_point_row row = row_of(v, patch, k);
        for (size_t e = 0; e < row.n; e++) {
            int32_t number = v->number[row.vertex[e]];
            if (number < 0)
                continue;
            size_t to = --s->column[s->start[patch] + (size_t)number];
            s->point[to] = k;
            s->weight[to] = row.weight[e];
        }
    }
}

/* Sets `column` of a patch to the ends of its columns; returns the last one's. */
static size_t measure_columns(const survey *v, int32_t patch, size_t begin, co_stencils *s) {
    const co_patches *p = v->patches;
    for (int32_t k = 0; k < co_patches_own_size(p->kind[patch]); k++) {
        co_point_row row = row_of(v, patch, k);
        for (size_t e = 0; e < row.n; e++)
            if (v->number[row.vertex[e]] >= 0)
                s->column[s->start[patch] + (size_t)v->number[row.vertex[e]]]++;
    }
    for (size_t c = s->start[patch]; c < s->start[patch + 1]; c++)
        begin = s->column[c] += begin;
    return begin;
}

/* Nodes and the neighbours of each ascend: every pattern's column is gone through once. */
static void fill_places(const survey *v, int32_t patch, const co_sparsity *pattern, co_stencils *s) {
    size_t n = s->start[patch + 1] - s->start[patch];
    for (size_t j = 0; j < n; j++) {
        const int32_t low = v->found[j].node;
        size_t at = pattern->neighbour_start[low];
        for (size_t i = j + 1; i < n; i++) {
            const int32_t high = v->found[i].node;
            while (high != low && pattern->neighbour[at] < high)
                at++;
            s->place[s->pair[patch] + i * (i - 1) / 2 + j] = high == low ? 0 : pattern->neighbour_row[at];
        }
    }
}

static int32_t fill(const survey *v, const co_sparsity *pattern, co_cancel *cancel, co_stencils *s) {
    size_t end = 0, ignored = 0;
    for (int32_t p = 0; p < v->patches->n_patches; p++) {
        if (co_cancel_is_due(cancel))
            return CO_CANCELLED;
        size_t n = find_vertices(v, p, &ignored);
        for (size_t i = 0; i < n; i++)
            s->vertex[s->start[p] + i] = v->found[i].vertex;
        end = measure_columns(v, p, end, s);
        fill_columns(v, p, s);
        fill_places(v, p, pattern, s);
        forget_vertices(v, n);
    }
    s->column[s->start[v->patches->n_patches]] = end;
    return CURVOPT_OK;
}

int32_t co_stencils_create(const co_patches *patches, const co_dof_map *dofs, const co_sparsity *pattern,
                           co_cancel *cancel, co_stencils *s, curvopt_error *error) {
    size_t n_patches = (size_t)patches->n_patches, n_entries = 0;
    survey v = {patches, dofs, CO_NEW(int32_t, patches->n_cage), CO_NEW(co_numbered_vertex, patches->n_cage)};
    *s = (co_stencils){.start = CO_NEW(size_t, n_patches + 1), .pair = CO_NEW(size_t, n_patches + 1)};
    int done = v.number && v.found && s->start && s->pair;
    for (int32_t i = 0; done && i < patches->n_cage; i++)
        v.number[i] = -1;
    if (done) {
        n_entries = count(&v, s);
        s->vertex = CO_NEW(int32_t, s->start[n_patches]);
        s->column = CO_NEW(size_t, s->start[n_patches] + 1);
        s->point = CO_NEW(int32_t, n_entries);
        s->weight = CO_NEW(double, n_entries);
        s->place = CO_NEW(int32_t, s->pair[n_patches]);
        done = s->vertex && s->column && s->point && s->weight && s->place;
    }
    int32_t status = done ? fill(&v, pattern, cancel, s) : co_status_no_memory(error);
    if (status != CURVOPT_OK)
        co_stencils_free(s);
    free(v.number);
    free(v.found);
    return status;
}

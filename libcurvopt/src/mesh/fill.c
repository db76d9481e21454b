/* Vertices put between others, as a thin plate would lie. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/fill.h"

#include "base/memory.h"
#include "linalg/sparse_cholesky.h"
#include "linalg/sparse_rows.h"

#include <stdlib.h>

/* Added to the diagonal, which is 1 and more: a piece in which all is free has no other, and stays. */
static const double LEAST = 1e-10;

/* L x is x less the mean of its neighbours, here of the free vertices. */
typedef struct plate {
    const curvopt_mesh *mesh;
    int32_t n_free;
    int32_t *number;       /* [n_vertices] of a free vertex among these; -1: it stays */
    int32_t *n_neighbours; /* [n_vertices] */
    double *bend;          /* [3 n_vertices] L x of all vertices */
    double *right;         /* [3 n_free] - L^T L x */
    double *column;        /* [n_free] one coordinate of it, then of the solution */
    co_sparse_rows along;  /* [n_vertices][n_free] L */
    co_sparse_rows back;   /* [n_free][n_vertices] L^T */
    co_sparse_rows square; /* [n_free][n_free] L^T L */
} plate;

static void plate_free(plate *p) {
    free(p->number);
    free(p->n_neighbours);
    free(p->bend);
    free(p->right);
    free(p->column);
    co_sparse_rows_free(&p->along);
    co_sparse_rows_free(&p->back);
    co_sparse_rows_free(&p->square);
}

static int32_t plate_allocate(const curvopt_mesh *m, const uint8_t *is_free, plate *p, curvopt_error *error) {
    const size_t n = (size_t)m->info.n_vertices;
    p->mesh = m;
    p->number = CO_NEW(int32_t, n);
    p->n_neighbours = CO_NEW(int32_t, n);
    p->bend = CO_NEW(double, 3 * n);
    for (size_t v = 0; p->number && v < n; v++)
        p->number[v] = is_free[v] ? p->n_free++ : -1;
    p->right = CO_NEW(double, 3 * (size_t)p->n_free);
    p->column = CO_NEW(double, p->n_free);
    for (int32_t e = 0; p->n_neighbours && e < m->info.n_edges; e++) {
        p->n_neighbours[m->corner_vertex[m->edge_corner[e]]]++;
        p->n_neighbours[co_mesh_destination(m, m->edge_corner[e])]++;
    }
    return p->number && p->n_neighbours && p->bend && p->right && p->column ? CURVOPT_OK : co_status_no_memory(error);
}

static void add_entry(const plate *p, int32_t v, int32_t w, double value, co_sparse_rows *rows, size_t *end) {
    if (p->number[w] < 0)
        return;
    rows->column[end[v]] = p->number[w];
    rows->value[end[v]++] = value;
}

/* The columns of L that are free. Room for as many entries as vertices have neighbours, and one. */
static int32_t make_rows(const plate *p, co_sparse_rows *rows, curvopt_error *error) {
    const curvopt_mesh *m = p->mesh;
    const int32_t n = m->info.n_vertices;
    int32_t status = co_sparse_rows_allocate(rows, n, p->n_free, (size_t)n + 2 * (size_t)m->info.n_edges, error);
    size_t *end = status == CURVOPT_OK ? CO_NEW(size_t, n) : NULL;
    if (status == CURVOPT_OK && !end)
        status = co_status_no_memory(error);
    if (status != CURVOPT_OK)
        return status;
    for (int32_t v = 0; v < n; v++) {
        end[v] = rows->start[v];
        rows->start[v + 1] = end[v] + 1 + (size_t)p->n_neighbours[v];
        add_entry(p, v, v, 1, rows, end);
    }
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const int32_t v = m->corner_vertex[m->edge_corner[e]], w = co_mesh_destination(m, m->edge_corner[e]);
        add_entry(p, v, w, -1.0 / p->n_neighbours[v], rows, end);
        add_entry(p, w, v, -1.0 / p->n_neighbours[w], rows, end);
    }
    co_sparse_rows_close_gaps(rows, end);
    free(end);
    return CURVOPT_OK;
}

static void add3(double s, const double *x, double *y) {
    for (int c = 0; c < 3; c++)
        y[c] += s * x[c];
}

static void find_right(const double *xyz, plate *p) {
    const curvopt_mesh *m = p->mesh;
    for (size_t i = 0; i < 3 * (size_t)m->info.n_vertices; i++)
        p->bend[i] = -xyz[i];
    for (int32_t e = 0; e < m->info.n_edges; e++) {
        const size_t v = (size_t)m->corner_vertex[m->edge_corner[e]];
        const size_t w = (size_t)co_mesh_destination(m, m->edge_corner[e]);
        add3(1.0 / p->n_neighbours[v], xyz + 3 * w, p->bend + 3 * v);
        add3(1.0 / p->n_neighbours[w], xyz + 3 * v, p->bend + 3 * w);
    }
    co_sparse_rows_add_transposed(&p->along, p->bend, p->right);
}

/* Keeps the part of each row from its diagonal on, as columns of the lower triangle. start [n_free + 1] */
static void keep_triangle(co_sparse_rows *square, int32_t *start) {
    int32_t n = 0;
    for (int32_t r = 0; r < square->n_rows; r++) {
        for (size_t e = square->start[r]; e < square->start[r + 1]; e++)
            if (square->column[e] >= r) {
                square->column[n] = square->column[e];
                square->value[n++] = square->value[e];
            }
        start[r + 1] = n;
    }
}

static int32_t solve(plate *p, co_thread_pool *threads, co_cancel *cancel, curvopt_error *error) {
    co_sparse_cholesky *factor = NULL;
    int positive = 0;
    int32_t *start = CO_NEW(int32_t, (size_t)p->n_free + 1);
    int32_t status = start ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        keep_triangle(&p->square, start);
        status = co_sparse_cholesky_create(p->n_free, start, p->square.column, p->square.value, threads, cancel,
                                           &factor, error);
    }
    if (status == CURVOPT_OK)
        status = co_sparse_cholesky_factorize(factor, LEAST, &positive, error);
    for (size_t c = 0; status == CURVOPT_OK && c < 3; c++) {
        for (size_t i = 0; i < (size_t)p->n_free; i++)
            p->column[i] = positive ? p->right[3 * i + c] : 0;
        if (positive)
            status = co_sparse_cholesky_solve(factor, p->column, p->column, error);
        for (size_t i = 0; i < (size_t)p->n_free; i++)
            p->right[3 * i + c] = p->column[i];
    }
    co_sparse_cholesky_destroy(factor);
    free(start);
    return status;
}

int32_t co_mesh_fill(const curvopt_mesh *mesh, const uint8_t *is_free, co_thread_pool *threads, co_cancel *cancel,
                     double *xyz, curvopt_error *error) {
    plate p = {.n_free = 0};
    int32_t status = plate_allocate(mesh, is_free, &p, error);
    if (status == CURVOPT_OK)
        status = make_rows(&p, &p.along, error);
    if (status == CURVOPT_OK)
        status = co_sparse_rows_transpose(&p.along, &p.back, error);
    if (status == CURVOPT_OK)
        status = co_sparse_rows_multiply(&p.back, &p.along, &p.square, error);
    if (status == CURVOPT_OK && p.n_free > 0) {
        find_right(xyz, &p);
        status = solve(&p, threads, cancel, error);
    }
    for (int32_t v = 0; status == CURVOPT_OK && p.n_free > 0 && v < mesh->info.n_vertices; v++)
        if (p.number[v] >= 0)
            add3(1, p.right + 3 * (size_t)p.number[v], xyz + 3 * (size_t)v);
    plate_free(&p);
    return status;
}

/* Second derivatives of an objective over the cage's coordinates, sparse. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian.h"

#include "memory.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_BLOCKS = 32, NO_RULES = -1, COARSEST = -2 };

void co_hessian_free(co_hessian *h) {
    free(h->neighbour_start);
    free(h->neighbour);
    free(h->column_start);
    free(h->row);
    free(h->value);
    free(h->chunk);
    free(h->work);
    co_layout_free(&h->layout);
    *h = (co_hessian){0};
}

/* ---------------------------------------------------------------------------------------------- pattern -- */

/* The cage vertices that a point is made of: itself, or a derived point's row. */
typedef struct point_row {
    const int32_t *vertex;
    const double *weight;
    size_t n;
} point_row;

static point_row row_of_point(const co_patches *patches, const int32_t *point) {
    static const double one = 1;
    if (*point < patches->n_cage)
        return (point_row){point, &one, 1};
    size_t begin = patches->derived.start[*point - patches->n_cage];
    return (point_row){patches->derived.column + begin, patches->derived.value + begin,
                       patches->derived.start[*point - patches->n_cage + 1] - begin};
}

/* Calls for every (patch, cage vertex) once: count only, or fill `list` (patches of each vertex). mark [n_vertices]. */
static void visit_vertices_of_patches(const co_patches *patches, int32_t *mark, size_t *count, int32_t *list) {
    for (int32_t v = 0; v < patches->n_cage; v++)
        mark[v] = -1;
    for (int32_t p = 0; p < patches->n_patches; p++)
        for (size_t i = patches->start[p]; i < patches->start[p + 1]; i++) {
            point_row r = row_of_point(patches, &patches->points[i]);
            for (size_t k = 0; k < r.n; k++) {
                int32_t v = r.vertex[k];
                if (mark[v] == p)
                    continue;
                mark[v] = p;
                if (list)
                    list[count[v]] = p;
                count[v]++;
            }
        }
}

static int compare_indices(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Larger vertices that share a patch with v, into out (may be NULL: only counted). */
static size_t neighbours_of(const co_patches *patches, const size_t *start, const int32_t *list, int32_t v,
                            int32_t *mark, int32_t *out) {
    size_t n = 0;
    for (size_t e = start[v]; e < start[v + 1]; e++)
        for (size_t i = patches->start[list[e]]; i < patches->start[list[e] + 1]; i++) {
            point_row r = row_of_point(patches, &patches->points[i]);
            for (size_t k = 0; k < r.n; k++) {
                int32_t w = r.vertex[k];
                if (w <= v || mark[w] == v)
                    continue;
                mark[w] = v;
                if (out)
                    out[n] = w;
                n++;
            }
        }
    if (out)
        qsort(out, n, sizeof *out, compare_indices);
    return n;
}

static int32_t find_neighbours(const co_patches *patches, co_hessian *h, curvopt_error *error) {
    size_t n = (size_t)patches->n_cage;
    int32_t status = CURVOPT_ERROR_MEMORY, *list = NULL, *mark = CO_NEW(int32_t, n);
    size_t *start = CO_NEW(size_t, n + 1);
    h->neighbour_start = CO_NEW(size_t, n + 1);
    if (!mark || !start || !h->neighbour_start)
        goto done;
    visit_vertices_of_patches(patches, mark, start + 1, NULL);
    for (size_t v = 0; v < n; v++)
        start[v + 1] += start[v];
    list = CO_NEW(int32_t, start[n]);
    if (!list)
        goto done;
    visit_vertices_of_patches(patches, mark, start, list);
    for (size_t v = n; v > 0; v--)
        start[v] = start[v - 1];
    start[0] = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t v = 0; v < n; v++)
            mark[v] = -1;
        for (int32_t v = 0; v < patches->n_cage; v++) {
            int32_t *out = pass ? h->neighbour + h->neighbour_start[v] : NULL;
            size_t found = neighbours_of(patches, start, list, v, mark, out);
            h->neighbour_start[v + 1] = h->neighbour_start[v] + found;
        }
        if (pass == 0 && !(h->neighbour = CO_NEW(int32_t, h->neighbour_start[n])))
            goto done;
    }
    status = CURVOPT_OK;
done:
    free(mark);
    free(start);
    free(list);
    return status == CURVOPT_OK ? status : co_status_no_memory(error);
}

static int32_t build_columns(co_hessian *h, curvopt_error *error) {
    size_t n = (size_t)h->n_vertices;
    h->n_entries = 6 * n + 9 * h->neighbour_start[n];
    if (h->n_entries > INT32_MAX)
        return co_status_fail(error, CURVOPT_ERROR_SIZE, -1, "a cage of %d vertices is too large for this method",
                              h->n_vertices);
    h->column_start = CO_NEW(int32_t, 3 * n + 1);
    h->row = CO_NEW(int32_t, h->n_entries);
    h->value = CO_NEW(double, h->n_entries);
    if (!h->column_start || !h->row || !h->value)
        return co_status_no_memory(error);
    int32_t at = 0;
    for (int32_t v = 0; v < h->n_vertices; v++)
        for (int c = 0; c < 3; c++) {
            h->column_start[3 * v + c] = at;
            for (int d = c; d < 3; d++)
                h->row[at++] = 3 * v + d;
            for (size_t e = h->neighbour_start[v]; e < h->neighbour_start[v + 1]; e++)
                for (int d = 0; d < 3; d++)
                    h->row[at++] = 3 * h->neighbour[e] + d;
        }
    h->column_start[3 * n] = at;
    return CURVOPT_OK;
}

/* The Hessian is to be that of the function that is minimized, by the rules that the assembly has now. The Gauss-Newton
 * matrix guides steps only, and is positive with any rules: the coarsest will do. */
static int32_t wanted_rules(const co_assembly *a, int exact) {
    return exact ? a->rules_version : COARSEST;
}

/* Layout of these rules, and room. */
static int32_t renew_layout(co_assembly *a, co_hessian *h, int exact, curvopt_error *error) {
    size_t lanes = (size_t)a->kernel->lanes;
    uint8_t *coarsest = CO_NEW(uint8_t, a->patches.n_patches);
    co_layout_free(&h->layout);
    free(h->chunk);
    free(h->work);
    h->chunk = h->work = NULL;
    h->rules_version = NO_RULES;
    if (!coarsest)
        return co_status_no_memory(error);
    int32_t status = co_layout_create(&a->patches, &a->cache, a->kernel->lanes, exact ? a->rule : coarsest, 0, 0, 0,
                                      &h->layout, error);
    free(coarsest);
    if (status != CURVOPT_OK)
        return status;
    size_t size = 3 * (size_t)h->layout.max_points;
    h->matrix_stride = size * (size + 1) / 2 * lanes;
    h->work_stride = co_sweep_second_work(h->layout.max_points) * lanes;
    h->chunk = CO_NEW_ALIGNED(double, CHUNK_BLOCKS * h->matrix_stride);
    h->work = CO_NEW_ALIGNED(double, (size_t)a->n_threads * h->work_stride);
    if (!h->chunk || !h->work)
        return co_status_no_memory(error);
    h->rules_version = wanted_rules(a, exact);
    return CURVOPT_OK;
}

int32_t co_hessian_create(co_assembly *a, co_hessian *h, curvopt_error *error) {
    *h = (co_hessian){.n_vertices = a->patches.n_cage, .rules_version = NO_RULES};
    int32_t status = find_neighbours(&a->patches, h, error);
    if (status == CURVOPT_OK)
        status = build_columns(h, error);
    if (status != CURVOPT_OK)
        co_hessian_free(h);
    return status;
}

/* ----------------------------------------------------------------------------------------------- values -- */

/* Where the 3 x 3 block of vertices column <= row begins in the first of its three columns. */
static size_t block_of(const co_hessian *h, int32_t row, int32_t column) {
    size_t low = h->neighbour_start[column], high = h->neighbour_start[column + 1], first = low;
    if (row == column)
        return (size_t)h->column_start[3 * column];
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (h->neighbour[middle] <= row)
            low = middle;
        else
            high = middle;
    }
    return (size_t)h->column_start[3 * column] + 3 + 3 * (low - first);
}

/* value += weight * block, a full 3 x 3 matrix with rows of vertex `row`, columns of vertex `column`. */
static void add_block(co_hessian *h, int32_t row, int32_t column, double weight, const double block[3][3]) {
    int transposed = row < column;
    int32_t high = transposed ? column : row, low = transposed ? row : column;
    size_t at = block_of(h, high, low);
    size_t length = 3 + 3 * (h->neighbour_start[low + 1] - h->neighbour_start[low]);
    for (int c = 0; c < 3; c++) {
        /* column c of the three is c shorter at its head */
        double *to = h->value + at + (size_t)c * length - (size_t)(c * (c - 1) / 2) - (high == low ? 0 : (size_t)c);
        for (int r = high == low ? c : 0; r < 3; r++)
            to[high == low ? r - c : r] += weight * (transposed ? block[c][r] : block[r][c]);
    }
}

/* The 3 x 3 block of points p >= q of one face's matrix, of one lane. */
static void face_block(const double *matrix, size_t lanes, size_t lane, int32_t p, int32_t q, double block[3][3]) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            size_t i = 3 * (size_t)p + (size_t)r, j = 3 * (size_t)q + (size_t)c;
            size_t at = i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
            block[r][c] = matrix[at * lanes + lane];
        }
}

/* Adds the entries of one face that belong to columns first <= vertex < end. */
static void scatter_face(const co_patches *patches, co_hessian *h, const co_block *b, const double *matrix, size_t lane,
                         int32_t first, int32_t end) {
    size_t lanes = (size_t)h->layout.lanes;
    const int32_t *points = h->layout.points + b->points;
    for (int32_t p = 0; p < b->table->n_points; p++)
        for (int32_t q = 0; q <= p; q++) {
            double block[3][3], transposed[3][3];
            point_row x = row_of_point(patches, &points[(size_t)p * lanes + lane]);
            point_row y = row_of_point(patches, &points[(size_t)q * lanes + lane]);
            int read = 0;
            for (size_t i = 0; i < x.n; i++)
                for (size_t j = 0; j < y.n; j++) {
                    int32_t v = x.vertex[i], w = y.vertex[j], column = v < w ? v : w;
                    if (column < first || column >= end)
                        continue;
                    if (!read) {
                        face_block(matrix, lanes, lane, p, q, block);
                        for (int r = 0; r < 9; r++)
                            transposed[r % 3][r / 3] = block[r / 3][r % 3];
                        read = 1;
                    }
                    /* (p, q) and (q, p) both stand for entries of the whole; on a vertex's own block both are added */
                    add_block(h, v, w, x.weight[i] * y.weight[j], (const double(*)[3])block);
                    if (p != q && v == w)
                        add_block(h, v, v, x.weight[i] * y.weight[j], (const double(*)[3])transposed);
                }
        }
}

static void sweep_chunk(co_assembly *a, co_hessian *h, int32_t first, int32_t n, const co_integrand *integrand,
                        int exact) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(a->n_threads)
    for (int32_t k = 0; k < n; k++) {
        const co_block *b = &h->layout.block[first + k];
        co_second_sweep sweep = {.table = b->table,
                                 .points = h->layout.points + b->points,
                                 .xyz = a->points,
                                 .eps4 = CO_UMBILIC * CO_UMBILIC * CO_UMBILIC * CO_UMBILIC,
                                 .integrand = *integrand,
                                 .third = a->functional.has_third,
                                 .exact = exact,
                                 .matrix = h->chunk + (size_t)k * h->matrix_stride,
                                 .work = h->work + (size_t)omp_get_thread_num() * h->work_stride};
        a->kernel->run_second(&sweep);
    }
}

/* Each thread owns some columns, so that sums come in the same order for any number of threads. */
static void scatter_chunk(co_assembly *a, co_hessian *h, int32_t first, int32_t n) {
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t t = 0; t < a->n_threads; t++) {
        int32_t begin = (int32_t)((int64_t)h->n_vertices * t / a->n_threads);
        int32_t end = (int32_t)((int64_t)h->n_vertices * (t + 1) / a->n_threads);
        for (int32_t k = 0; k < n; k++)
            for (int32_t lane = 0; lane < h->layout.block[first + k].n_used; lane++)
                scatter_face(&a->patches, h, &h->layout.block[first + k], h->chunk + (size_t)k * h->matrix_stride,
                             (size_t)lane, begin, end);
    }
}

/* Held vertices: their rows and columns become a multiple of the identity's, of the order of the others. */
static void hold(co_hessian *h) {
    double sum = 0;
    int32_t n_free = 0, n = 3 * h->n_vertices;
    for (int32_t j = 0; j < n; j++)
        if (!h->held[j / 3]) {
            sum += h->value[h->column_start[j]];
            n_free++;
        }
    for (int32_t j = 0; j < n; j++) {
        for (int32_t e = h->column_start[j]; e < h->column_start[j + 1]; e++)
            if (h->held[j / 3] || h->held[h->row[e] / 3])
                h->value[e] = 0;
        if (h->held[j / 3])
            h->value[h->column_start[j]] = sum > 0 ? sum / n_free : 1;
    }
}

int32_t co_hessian_assemble(co_assembly *a, const double *x, int exact, co_hessian *h, curvopt_error *error) {
    int32_t status = h->rules_version == wanted_rules(a, exact) ? CURVOPT_OK : renew_layout(a, h, exact, error);
    if (status != CURVOPT_OK)
        return status;
    co_values values;
    const co_functional *f = &a->functional;
    memset(h->value, 0, h->n_entries * sizeof(double));
    co_assembly_evaluate(a, x, &(co_request){0}, &values); /* sets the points, gives the integrals */
    double area = values.integral[CO_INT_AREA];
    double third = f->third.f1 * values.integral[CO_INT_F1] + f->third.f3 * values.integral[CO_INT_F3] +
                   f->third.x * values.integral[CO_INT_X];
    co_integrand integrand = {.area = f->second.area + (f->has_third ? third : 0),
                              .h2 = f->second.h2,
                              .f1 = area * f->third.f1,
                              .f3 = area * f->third.f3,
                              .x = area * f->third.x};
    for (int32_t first = 0; first < h->layout.n_blocks; first += CHUNK_BLOCKS) {
        int32_t n = h->layout.n_blocks - first;
        n = n > CHUNK_BLOCKS ? CHUNK_BLOCKS : n;
        sweep_chunk(a, h, first, n, &integrand, exact);
        scatter_chunk(a, h, first, n);
    }
    if (h->held)
        hold(h);
    return CURVOPT_OK;
}

double co_hessian_mean_diagonal(const co_hessian *h) {
    double sum = 0;
    for (int32_t i = 0; i < 3 * h->n_vertices; i++)
        sum += h->value[h->column_start[i]];
    return sum / (3.0 * h->n_vertices);
}

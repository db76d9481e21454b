/* Vertices in whose place points and tangents are unknowns. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/interpolation.h"

#include "base/memory.h"
#include "linalg/small_dense.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double LARGEST_SHIFT = 1e3; /* on a regular grid all of which is held: 9 */
/* Part of the largest entry of a group's inverse below which entries are left out: they fall by .27 a vertex, and rows
 * of a long chain would be as long as the chain. */
static const double NEGLIGIBLE = 1e-17;

/* A row that is being made: its entries follow each other from `first` on. */
typedef struct row_end {
    co_sparse_rows *rows;
    size_t first, end;
} row_end;

static void add_entry(int32_t vertex, double weight, void *context) {
    row_end *row = context;
    size_t at = row->first;
    while (at < row->end && row->rows->column[at] != vertex)
        at++;
    if (at == row->end) {
        row->rows->column[row->end++] = vertex;
        row->rows->value[at] = 0;
    }
    row->rows->value[at] += weight;
}

/* of [n_vertices]: the value whose pivot each vertex is; -1: none. */
static int32_t *values_by_pivot(const curvopt_mesh *m, const co_surface_values *fs) {
    int32_t *of = CO_NEW(int32_t, m->info.n_vertices);
    for (int32_t v = 0; of && v < m->info.n_vertices; v++)
        of[v] = -1;
    for (int32_t k = 0; of && k < fs->n; k++)
        if (fs->item[k].pivot >= 0)
            of[fs->item[k].pivot] = k;
    return of;
}

/* Fills in->limit, of in->vertex [n]. */
static int32_t make_limit(const curvopt_mesh *m, int32_t n, const co_constraints *constraints, co_interpolation *in,
                          curvopt_error *error) {
    const co_surface_values *fs = &constraints->values;
    size_t most = fs->rows.n_rows ? fs->rows.start[fs->rows.n_rows] : 0;
    int32_t *of = values_by_pivot(m, fs);
    if (!of)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < n; i++)
        most += of[in->vertex[i]] < 0 ? co_vertex_mask_most(m, in->vertex[i]) : 0;
    int32_t status = co_sparse_rows_allocate(&in->limit, n, m->info.n_vertices, most, error);
    row_end row = {.rows = &in->limit};
    for (int32_t i = 0; status == CURVOPT_OK && i < n; i++) {
        const int32_t k = of[in->vertex[i]];
        row.first = row.end;
        if (k < 0)
            co_constraints_visit_own_point(m, constraints, in->vertex[i], add_entry, &row);
        for (size_t e = k < 0 ? 0 : fs->rows.start[k]; k >= 0 && e < fs->rows.start[k + 1]; e++)
            add_entry(fs->rows.column[e], fs->rows.value[e], &row);
        in->limit.start[i + 1] = row.end;
    }
    free(of);
    return status;
}

/* Vertices of C by the groups whose masks hang together. */
typedef struct groups {
    int32_t *number;  /* [n_vertices] index in C; -1 */
    int32_t *group;   /* [n] the least index of its group */
    int32_t *at;      /* [n] index within its group */
    int32_t *members; /* [n] the group's, while it is gone through */
    const co_surface_values *values;
} groups;

static void groups_free(groups *g) {
    free(g->number);
    free(g->group);
    free(g->at);
    free(g->members);
}

static int32_t root_of(int32_t *group, int32_t i) {
    while (group[i] != i)
        i = group[i] = group[group[i]];
    return i;
}

static int32_t find_groups(const co_interpolation *in, const co_surface_values *values, groups *g,
                           curvopt_error *error) {
    const int32_t n = in->limit.n_rows, n_vertices = in->limit.n_columns;
    *g = (groups){.number = CO_NEW(int32_t, n_vertices),
                  .group = CO_NEW(int32_t, n),
                  .at = CO_NEW(int32_t, n),
                  .members = CO_NEW(int32_t, n),
                  .values = values};
    if (!g->number || !g->group || !g->at || !g->members)
        return co_status_no_memory(error);
    for (int32_t v = 0; v < n_vertices; v++)
        g->number[v] = -1;
    for (int32_t i = 0; i < n; i++) {
        g->number[in->vertex[i]] = i;
        g->group[i] = i;
    }
    for (int32_t i = 0; i < n; i++)
        for (size_t e = in->limit.start[i]; e < in->limit.start[i + 1]; e++) {
            const int32_t other = g->number[in->limit.column[e]];
            if (other < 0)
                continue;
            const int32_t a = root_of(g->group, i), b = root_of(g->group, other);
            g->group[a > b ? a : b] = a < b ? a : b;
        }
    for (int32_t i = 0; i < n; i++)
        g->group[i] = root_of(g->group, i);
    return CURVOPT_OK;
}

/* Takes off C the groups in whose masks nothing can move. */
static void leave_what_stands(const co_interpolation *in, const groups *g, co_constraints *constraints) {
    const int32_t n = in->limit.n_rows;
    for (int32_t i = 0; i < n; i++)
        g->at[i] = 0; /* whether anything of the group can move */
    for (int32_t i = 0; i < n; i++)
        for (size_t e = in->limit.start[i]; e < in->limit.start[i + 1]; e++)
            g->at[g->group[i]] |= constraints->freedom[in->limit.column[e]] != CO_FREEDOM_NONE;
    for (int32_t i = 0; i < n; i++)
        if (!g->at[g->group[i]])
            constraints->of_limit[in->vertex[i]] = 0;
}

/* Rows (M_CC)^-1 of one group of `size` members, into inverse by in->limit's order of rows; dense [size][size]. */
static void invert_group(const co_interpolation *in, const groups *g, int32_t size, double *dense, double *inverse) {
    memset(dense, 0, (size_t)size * (size_t)size * sizeof *dense);
    for (int32_t k = 0; k < size; k++) {
        const int32_t i = g->members[k];
        for (size_t e = in->limit.start[i]; e < in->limit.start[i + 1]; e++) {
            const int32_t other = g->number[in->limit.column[e]];
            if (other >= 0)
                dense[k * size + g->at[other]] = in->limit.value[e];
        }
    }
    co_small_dense_invert(size, size, dense, inverse);
}

/* Number of the user's entry whose value is in a vertex' place; -1: its own limit point is. */
static int32_t entry_of(const co_surface_values *fs, int32_t vertex) {
    for (int32_t i = 0; i < fs->n; i++)
        if (fs->item[i].pivot == vertex && !fs->item[i].is_optional)
            return fs->item[i].number;
    return -1;
}

static int32_t refuse_dependent(const groups *g, int32_t size, int32_t vertex, curvopt_error *error) {
    const int32_t entry = entry_of(g->values, vertex);
    if (entry >= 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, entry,
                              "entry %d and those that touch it hold %d points, tangents and curvatures that cannot be "
                              "chosen freely: leave some of them out, or subdivide the cage once",
                              entry, size);
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, vertex,
                          "the limit points of %d vertices that touch each other, vertex %d among them, do not "
                          "move independently: hold fewer of them, or refine the cage once",
                          size, vertex);
}

/* ERROR_ARGUMENT where limit points hardly depend on each other's vertices independently: a shift of one by 1 would
 * move a vertex by more than LARGEST_SHIFT. As of three-valent vertices that touch: of a cube M_CC is singular. */
static int32_t check_inverse(const co_interpolation *in, const groups *g, int32_t size, const double *inverse,
                             curvopt_error *error) {
    for (int32_t k = 0; k < size; k++) {
        double sum = 0;
        for (int32_t l = 0; l < size; l++)
            sum += fabs(inverse[k * size + l]);
        if (!(sum <= LARGEST_SHIFT))
            return refuse_dependent(g, size, in->vertex[g->members[k]], error);
    }
    return CURVOPT_OK;
}

/* Sizes of the groups, by their least members in size [n], and g->at. Returns the largest one. */
static int32_t measure_groups(int32_t n, const groups *g, int32_t *size) {
    int32_t most = 0;
    for (int32_t i = 0; i < n; i++)
        size[i] = 0;
    for (int32_t i = 0; i < n; i++) {
        g->at[i] = size[g->group[i]]++;
        most = size[g->group[i]] > most ? size[g->group[i]] : most;
    }
    return most;
}

static double largest_of(size_t n, const double *value) {
    double largest = 0;
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, fabs(value[i]));
    return largest;
}

/* Row k of a group's inverse of `size` members, without what is below `least`; its end. */
static size_t put_row(const groups *g, int32_t size, const double *row, double least, co_sparse_rows *inverse,
                      size_t at) {
    for (int32_t l = 0; l < size; l++)
        if (fabs(row[l]) >= least) {
            inverse->column[at] = g->members[l];
            inverse->value[at++] = row[l];
        }
    return at;
}

/* One group after the other, of size [n] by their least members. dense, of_group: room for the largest one. Rows end
 * at end [n], before the next one begins. */
static int32_t fill_inverse(const co_interpolation *in, const groups *g, const int32_t *size, double *dense,
                            double *of_group, size_t *end, co_sparse_rows *inverse, curvopt_error *error) {
    const int32_t n = in->limit.n_rows;
    for (int32_t i = 0; i < n; i++)
        inverse->start[i + 1] = inverse->start[i] + (size_t)size[g->group[i]];
    for (int32_t i = 0; i < n; i++) {
        if (g->group[i] != i)
            continue;
        int32_t found = 0;
        for (int32_t k = i; k < n && found < size[i]; k++)
            if (g->group[k] == i)
                g->members[found++] = k;
        invert_group(in, g, size[i], dense, of_group);
        int32_t status = check_inverse(in, g, size[i], of_group, error);
        if (status != CURVOPT_OK)
            return status;
        const double least = NEGLIGIBLE * largest_of((size_t)size[i] * (size_t)size[i], of_group);
        for (int32_t k = 0; k < size[i]; k++) {
            const int32_t row = g->members[k];
            end[row] = put_row(g, size[i], of_group + (size_t)k * (size_t)size[i], least, inverse, inverse->start[row]);
        }
    }
    return CURVOPT_OK;
}

/* inverse: (M_CC)^-1, n x n. */
static int32_t make_inverse(const co_interpolation *in, const groups *g, co_sparse_rows *inverse,
                            curvopt_error *error) {
    const int32_t n = in->limit.n_rows;
    int32_t *size = CO_NEW(int32_t, n);
    if (!size)
        return co_status_no_memory(error);
    const int32_t most = measure_groups(n, g, size);
    const size_t square = (size_t)most * (size_t)most;
    size_t n_entries = 0;
    for (int32_t i = 0; i < n; i++)
        n_entries += (size_t)size[g->group[i]];
    if (most > CO_INTERPOLATION_MOST_TOUCHING) {
        free(size);
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, most,
                              "the limit points of %d vertices that touch each other are held; on one level %d can be: "
                              "hold some of the vertices themselves, or refine the cage once",
                              most, CO_INTERPOLATION_MOST_TOUCHING);
    }
    double *dense = CO_NEW(double, 2 * square);
    size_t *end = CO_NEW(size_t, n);
    int32_t status =
        dense && end ? co_sparse_rows_allocate(inverse, n, n, n_entries, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = fill_inverse(in, g, size, dense, dense + square, end, inverse, error);
    if (status == CURVOPT_OK)
        co_sparse_rows_close_gaps(inverse, end);
    free(end);
    free(size);
    free(dense);
    return status;
}

/* in->cage = (M_CC)^-1 [1, -M_CF] */
static int32_t make_cage(co_interpolation *in, const groups *g, curvopt_error *error) {
    co_sparse_rows inverse = {0}, rest = {0};
    const int32_t n = in->limit.n_rows;
    size_t end = 0;
    int32_t status = make_inverse(in, g, &inverse, error);
    if (status == CURVOPT_OK)
        status = co_sparse_rows_allocate(&rest, n, in->limit.n_columns, in->limit.start[n] + (size_t)n, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < n; i++) {
        rest.column[end] = in->vertex[i];
        rest.value[end++] = 1;
        for (size_t e = in->limit.start[i]; e < in->limit.start[i + 1]; e++)
            if (g->number[in->limit.column[e]] < 0) {
                rest.column[end] = in->limit.column[e];
                rest.value[end++] = -in->limit.value[e];
            }
        rest.start[i + 1] = end;
    }
    if (status == CURVOPT_OK)
        status = co_sparse_rows_multiply(&inverse, &rest, &in->cage, error);
    co_sparse_rows_free(&inverse);
    co_sparse_rows_free(&rest);
    return status;
}

/* ------------------------------------------------------------------------------------------------------ -- */

/* The vertices that `of_limit` marks, and their masks. */
static int32_t list(const curvopt_mesh *m, const co_constraints *constraints, co_interpolation *out,
                    curvopt_error *error) {
    int32_t n = 0;
    *out = (co_interpolation){0};
    for (int32_t v = 0; constraints->of_limit && v < m->info.n_vertices; v++)
        n += constraints->of_limit[v] != CO_OF_VERTEX;
    if (!n)
        return CURVOPT_OK;
    out->vertex = CO_NEW(int32_t, n);
    out->work = CO_NEW(double, 3 * (size_t)n);
    if (!out->vertex || !out->work)
        return co_status_no_memory(error);
    n = 0;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (constraints->of_limit[v])
            out->vertex[n++] = v;
    return make_limit(m, n, constraints, out, error);
}

/* The vertices, their masks and their groups. */
static int32_t survey(const curvopt_mesh *m, const co_constraints *constraints, co_interpolation *out, groups *g,
                      curvopt_error *error) {
    *g = (groups){0};
    int32_t status = list(m, constraints, out, error);
    return status == CURVOPT_OK && out->limit.n_rows ? find_groups(out, &constraints->values, g, error) : status;
}

int32_t co_interpolation_of_all(const curvopt_mesh *m, const co_constraints *constraints, co_interpolation *out,
                                curvopt_error *error) {
    groups g;
    int32_t status = survey(m, constraints, out, &g, error);
    if (status == CURVOPT_OK && out->limit.n_rows)
        status = make_cage(out, &g, error);
    groups_free(&g);
    if (status != CURVOPT_OK)
        co_interpolation_free(out);
    return status;
}

int32_t co_interpolation_create(const curvopt_mesh *m, co_constraints *constraints, co_interpolation *out,
                                curvopt_error *error) {
    groups g;
    int32_t status = survey(m, constraints, out, &g, error);
    if (status == CURVOPT_OK)
        leave_what_stands(out, &g, constraints);
    groups_free(&g);
    co_interpolation_free(out);
    return status == CURVOPT_OK ? co_interpolation_of_all(m, constraints, out, error) : status;
}

void co_interpolation_free(co_interpolation *in) {
    free(in->vertex);
    free(in->work);
    co_sparse_rows_free(&in->limit);
    co_sparse_rows_free(&in->cage);
    *in = (co_interpolation){0};
}

/* Vertices C of xyz become rows * xyz. */
static void exchange(const co_interpolation *in, const co_sparse_rows *rows, double *xyz) {
    if (!in->limit.n_rows)
        return;
    co_sparse_rows_apply(rows, xyz, in->work);
    for (int32_t i = 0; i < in->limit.n_rows; i++)
        memcpy(xyz + 3 * (size_t)in->vertex[i], in->work + 3 * (size_t)i, 3 * sizeof(double));
}

void co_interpolation_from_cage(const co_interpolation *in, double *xyz) {
    exchange(in, &in->limit, xyz);
}

void co_interpolation_to_cage(const co_interpolation *in, double *xyz) {
    exchange(in, &in->cage, xyz);
}

void co_interpolation_to_cage_exactly(const co_interpolation *in, double *off, double *xyz) {
    const int32_t n = in->limit.n_rows;
    memset(off, 0, 3 * sizeof *off * (size_t)in->limit.n_columns);
    for (int32_t i = 0; i < n; i++)
        memcpy(off + 3 * (size_t)in->vertex[i], xyz + 3 * (size_t)in->vertex[i], 3 * sizeof *off);
    co_interpolation_to_cage(in, xyz);
    if (n)
        co_sparse_rows_apply(&in->limit, xyz, in->work);
    for (size_t i = 0; i < 3 * (size_t)n; i++)
        off[3 * (size_t)in->vertex[i / 3] + i % 3] -= in->work[i];
    if (n)
        co_sparse_rows_apply(&in->cage, off, in->work);
    for (size_t i = 0; i < 3 * (size_t)n; i++)
        xyz[3 * (size_t)in->vertex[i / 3] + i % 3] += in->work[i];
}

void co_interpolation_gradient(const co_interpolation *in, double *gradient) {
    const int32_t n = in->limit.n_rows;
    for (int32_t i = 0; i < n; i++) {
        double *from = gradient + 3 * (size_t)in->vertex[i];
        memcpy(in->work + 3 * (size_t)i, from, 3 * sizeof(double));
        memset(from, 0, 3 * sizeof(double));
    }
    if (n)
        co_sparse_rows_add_transposed(&in->cage, in->work, gradient);
}

int32_t co_interpolation_find(const co_interpolation *in, int32_t v) {
    int32_t low = 0, high = in->limit.n_rows;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (in->vertex[middle] < v)
            low = middle + 1;
        else
            high = middle;
    }
    return low < in->limit.n_rows && in->vertex[low] == v ? low : -1;
}

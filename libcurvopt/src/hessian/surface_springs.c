/* Springs of points, tangents and curvatures of the surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/surface_springs.h"

#include "base/memory.h"
#include "constraints/freedom.h"
#include "linalg/small_dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void co_surface_springs_free(co_surface_springs *s) {
    free(s->spring);
    free(s->vertex);
    free(s->by);
    free(s->rest);
    free(s->work);
    *s = (co_surface_springs){0};
}

enum { N_TANGENTS = 2, N_FORM = 5 }; /* values that a second form is of: tangents, then second derivatives */

/* A node that a spring depends on. */
typedef struct part {
    int32_t node, vertex;
    double by[N_FORM][9]; /* derivatives of each row's value by its variables: rows x, y, z */
} part;

/* Rows of one spring that are being made over the variables. */
typedef struct making {
    const co_interpolation *map;
    const co_dof_map *dofs;
    int32_t *at; /* [n_nodes] place of a node in `part`; -1 */
    part *part;  /* [..] */
    int32_t n;
    int32_t n_rows, row;    /* of the spring; the one that is added to */
    double rest[N_FORM][3]; /* what no variable moves */
} making;

/* Adds `weight` times position v. */
static void add_position(making *m, int32_t v, double weight) {
    const co_dof_map *r = m->dofs;
    const int32_t node = r->node[v];
    for (size_t c = 0; c < 3 && r->offset; c++)
        m->rest[m->row][c] += weight * r->offset[3 * (size_t)v + c];
    if (node < 0)
        return;
    if (m->at[node] < 0) {
        m->at[node] = m->n;
        m->part[m->n++] = (part){.node = node, .vertex = v};
    }
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < co_dof_map_dimension(r, node); j++)
            m->part[m->at[node]].by[m->row][3 * c + j] += weight * r->basis[9 * (size_t)v + (size_t)(3 * c + j)];
}

/* Adds `weight` times vertex v of the cage. */
static void add_vertex(making *m, int32_t v, double weight) {
    const co_sparse_rows *cage = &m->map->cage;
    const int32_t i = co_interpolation_find(m->map, v);
    if (i < 0) {
        add_position(m, v, weight);
        return;
    }
    for (size_t e = cage->start[i]; e < cage->start[i + 1]; e++)
        add_position(m, cage->column[e], weight * cage->value[e]);
}

static int by_node(const void *a, const void *b) {
    const int32_t p = ((const part *)a)->node, q = ((const part *)b)->node;
    return (p > q) - (p < q);
}

/* How many positions a row can depend on at most. */
static size_t most_parts(const co_sparse_rows *rows, const co_interpolation *map, int32_t row) {
    size_t most = 0;
    for (size_t e = rows->start[row]; e < rows->start[row + 1]; e++) {
        const int32_t i = co_interpolation_find(map, rows->column[e]);
        most += i < 0 ? 1 : map->cage.start[i + 1] - map->cage.start[i];
    }
    return most;
}

/* Rows `first` and so on of `rows`, whose parts ascend. */
static void make_rows(const co_sparse_rows *rows, int32_t first, int32_t n_rows, making *m) {
    m->n = 0;
    m->n_rows = n_rows;
    memset(m->rest, 0, sizeof m->rest);
    for (m->row = 0; m->row < n_rows; m->row++)
        for (size_t e = rows->start[first + m->row]; e < rows->start[first + m->row + 1]; e++)
            add_vertex(m, rows->column[e], rows->value[e]);
    for (int32_t i = 0; i < m->n; i++)
        m->at[m->part[i].node] = -1;
    if (m->n)
        qsort(m->part, (size_t)m->n, sizeof *m->part, by_node);
}

/* x = factor Q x */
static void take(const double free_part[9], double factor, double x[3]) {
    const double was[3] = {x[0], x[1], x[2]};
    for (int c = 0; c < 3; c++) {
        x[c] = factor * was[c];
        for (int d = 0; d < 3; d++)
            x[c] -= factor * free_part[3 * c + d] * was[d];
    }
}

/* Where springs' values are. */
typedef struct frame {
    const double *centroid;
    double radius, scale;
} frame;

/* A spring of the rows that have been made, at the end of `out`: room for its numbers and their derivatives, as rows
 * have them. */
static co_surface_spring *begin_spring(const making *m, co_surface_springs *out) {
    const co_surface_spring *last = out->n ? &out->spring[out->n - 1] : NULL;
    co_surface_spring *s = &out->spring[out->n++];
    *s = (co_surface_spring){.n_nodes = m->n, .n_numbers = 3 * m->n_rows};
    if (last) {
        s->first_node = last->first_node + (size_t)last->n_nodes;
        s->first_number = last->first_number + (size_t)last->n_numbers;
        s->by = last->by + (size_t)last->n_nodes * (size_t)last->n_numbers;
    }
    memcpy(out->rest + s->first_number, m->rest, (size_t)s->n_numbers * sizeof *out->rest);
    for (int32_t i = 0; i < m->n; i++) {
        const part *p = &m->part[i];
        out->vertex[s->first_node + (size_t)i] = p->vertex;
        for (int32_t k = 0; k < s->n_numbers; k++) {
            co_node_derivative *d = &out->by[s->by + (size_t)k * (size_t)m->n + (size_t)i];
            d->node = p->node;
            memcpy(d->by, &p->by[k / 3][3 * (k % 3)], sizeof d->by);
        }
    }
    return s;
}

/* A spring of the point or tangent f, whose row has been made. */
static void add_linear(const co_surface_value *f, const making *m, const frame *frame, co_surface_springs *out) {
    const co_surface_spring *s = begin_spring(m, out);
    const double factor = sqrt(frame->scale * f->stiffness) * (f->order ? frame->radius : 1);
    double free_part[9], *rest = out->rest + s->first_number;
    co_node_derivative *by = out->by + s->by;
    co_freedom_projector(f->freedom, f->direction, free_part);
    for (int c = 0; c < 3 && !f->order; c++)
        rest[c] -= (f->anchor[c] - frame->centroid[c]) / frame->radius;
    take(free_part, factor, rest);
    for (int32_t i = 0; i < m->n; i++)
        for (int j = 0; j < 3; j++) {
            double column[3] = {by[i].by[j], by[m->n + i].by[j], by[2 * m->n + i].by[j]};
            take(free_part, factor, column);
            for (int c = 0; c < 3; c++)
                by[c * m->n + i].by[j] = column[c];
        }
}

/* A spring of the second form whose first second derivative is f. */
static void add_form(const co_surface_value *f, const making *m, const frame *frame, co_surface_springs *out) {
    co_surface_spring *s = begin_spring(m, out);
    s->stiffness = frame->scale * f->stiffness;
    memcpy(s->wanted.normal, f->direction, sizeof s->wanted.normal);
    for (int i = 0; i < 9; i++)
        s->wanted.tensor[i] = frame->radius * f->curvature[i];
}

/* How many values the spring that begins with value i is of: of second derivatives all of an entry. */
static int32_t values_from(const co_surface_values *values, int32_t i) {
    return values->item[i].order == 2 ? N_FORM - N_TANGENTS : 1;
}

/* Makes the springs that the values ask for, for which there is room. */
static void add_springs(const co_surface_values *values, const frame *frame, making *m, co_surface_springs *out) {
    for (int32_t i = 0; i < values->n; i += values_from(values, i)) {
        const co_surface_value *f = &values->item[i];
        const int is_form = f->order == 2;
        make_rows(&values->rows, is_form ? i - N_TANGENTS : i, is_form ? N_FORM : 1, m);
        if (is_form)
            add_form(f, m, frame, out);
        else
            add_linear(f, m, frame, out);
    }
}

/* Room that springs need at most: springs, nodes of all and of one, numbers, derivatives. */
typedef struct room {
    size_t springs, nodes, most, numbers, by;
} room;

static room room_of(const co_surface_values *values, const co_interpolation *map) {
    room r = {0};
    for (int32_t i = 0; i < values->n; i += values_from(values, i)) {
        const int is_form = values->item[i].order == 2;
        const int32_t first = is_form ? i - N_TANGENTS : i, n_rows = is_form ? N_FORM : 1;
        size_t n = 0;
        for (int32_t k = first; k < first + n_rows; k++)
            n += most_parts(&values->rows, map, k);
        r.springs++;
        r.nodes += n;
        r.most = n > r.most ? n : r.most;
        r.numbers += 3 * (size_t)n_rows;
        r.by += 3 * (size_t)n_rows * n;
    }
    return r;
}

int32_t co_surface_springs_create(const co_surface_values *values, const co_interpolation *interpolation,
                                  const co_dof_map *dofs, const double centroid[3], double radius, double scale,
                                  co_surface_springs *out, curvopt_error *error) {
    making m = {.map = interpolation, .dofs = dofs};
    const frame frame = {centroid, radius, scale};
    const room r = room_of(values, interpolation);
    *out = (co_surface_springs){.dofs = dofs,
                                .spring = CO_NEW(co_surface_spring, r.springs),
                                .vertex = CO_NEW(int32_t, r.nodes),
                                .by = CO_NEW(co_node_derivative, r.by),
                                .rest = CO_NEW(double, r.numbers),
                                .work = CO_NEW(co_node_derivative, r.most)};
    m.at = CO_NEW(int32_t, dofs->n_nodes);
    m.part = CO_NEW(part, r.most);
    const int has_room = out->spring && out->vertex && out->by && out->rest && out->work && m.at && m.part;
    for (int32_t i = 0; has_room && i < dofs->n_nodes; i++)
        m.at[i] = -1;
    if (has_room)
        add_springs(values, &frame, &m, out);
    free(m.at);
    free(m.part);
    if (has_room)
        return CURVOPT_OK;
    co_surface_springs_free(out);
    return co_status_no_memory(error);
}

/* Number c of a spring by its nodes. */
static const co_node_derivative *derivatives(const co_surface_springs *s, const co_surface_spring *one, int c) {
    return s->by + one->by + (size_t)c * (size_t)one->n_nodes;
}

/* A spring's numbers at z. */
static void find_numbers(const co_surface_springs *s, const co_surface_spring *one, const double *z, double *number) {
    const co_dof_map *dofs = s->dofs;
    for (int c = 0; c < one->n_numbers; c++) {
        const co_node_derivative *d = derivatives(s, one, c);
        number[c] = s->rest[one->first_number + (size_t)c];
        for (int32_t i = 0; i < one->n_nodes; i++)
            for (int j = 0; j < co_dof_map_dimension(dofs, d[i].node); j++)
                number[c] += d[i].by[j] * z[dofs->first[d[i].node] + j];
    }
}

/* What a spring adds by its numbers; their slopes, unless NULL. */
static double value_of(const co_surface_spring *one, const double *number, double *slope) {
    double value = 0;
    if (one->n_numbers == CO_SECOND_FORM_VALUES) {
        value = one->stiffness * co_second_form_off(&one->wanted, number, slope, NULL, 0);
        for (int c = 0; slope && c < one->n_numbers; c++)
            slope[c] *= one->stiffness;
        return isfinite(value) ? value : (double)INFINITY;
    }
    for (int c = 0; c < one->n_numbers; c++)
        value += number[c] * number[c] / 2;
    if (slope)
        memcpy(slope, number, (size_t)one->n_numbers * sizeof *slope);
    return value;
}

double co_surface_springs_value(const co_surface_springs *s, const double *z, double weight, double *gradient) {
    const co_dof_map *dofs = s->dofs;
    double value = 0, number[CO_SECOND_FORM_VALUES], slope[CO_SECOND_FORM_VALUES] = {0};
    for (int32_t k = 0; k < s->n; k++) {
        const co_surface_spring *one = &s->spring[k];
        find_numbers(s, one, z, number);
        value += value_of(one, number, gradient ? slope : NULL);
        for (int c = 0; gradient && c < one->n_numbers; c++) {
            const co_node_derivative *d = derivatives(s, one, c);
            for (int32_t i = 0; i < one->n_nodes; i++)
                for (int j = 0; j < co_dof_map_dimension(dofs, d[i].node); j++)
                    gradient[dofs->first[d[i].node] + j] += weight * slope[c] * d[i].by[j];
        }
    }
    return value;
}

/* Part of the largest eigenvalue of a second form's matrix below which others are rounding. */
static const double ROUNDING = 1e-15;

/* Adds a second form's matrix at z: the sum over its eigenvectors, each a combination of the numbers. */
static void add_form_matrix(const co_surface_springs *s, const co_surface_spring *one, const double *z, int exact,
                            double weight, co_sparse_hessian *hessian) {
    enum { N = CO_SECOND_FORM_VALUES };
    double number[N], slope[N], matrix[N * N], size[N], vector[N * N], largest = 0;
    find_numbers(s, one, z, number);
    co_second_form_off(&one->wanted, number, slope, matrix, exact);
    co_small_dense_eigen(N, N, matrix, size, vector);
    for (int e = 0; e < N; e++)
        largest = fmax(largest, fabs(size[e]));
    for (int e = 0; e < N; e++) {
        if (!(fabs(size[e]) > ROUNDING * largest))
            continue;
        for (int32_t i = 0; i < one->n_nodes; i++) {
            co_node_derivative *sum = &s->work[i];
            *sum = (co_node_derivative){.node = derivatives(s, one, 0)[i].node};
            for (int c = 0; c < N; c++)
                for (int j = 0; j < 3; j++)
                    sum->by[j] += vector[N * c + e] * derivatives(s, one, c)[i].by[j];
        }
        co_sparse_hessian_add_square(hessian, one->n_nodes, s->work, weight * one->stiffness * size[e]);
    }
}

void co_surface_springs_add_hessian(const co_surface_springs *s, const double *z, int exact, double weight,
                                    co_sparse_hessian *hessian) {
    for (int32_t k = 0; k < s->n; k++) {
        const co_surface_spring *one = &s->spring[k];
        if (one->n_numbers == CO_SECOND_FORM_VALUES)
            add_form_matrix(s, one, z, exact, weight, hessian);
        for (int c = 0; one->n_numbers == 3 && c < 3; c++)
            co_sparse_hessian_add_square(hessian, one->n_nodes, derivatives(s, one, c), weight);
    }
}

int32_t co_surface_springs_couple(const co_surface_springs *s, co_couplings *couplings, curvopt_error *error) {
    const int32_t before = couplings->n;
    const size_t end = couplings->start ? couplings->start[before] : 0;
    if (!s->spring || s->n == 0)
        return CURVOPT_OK;
    const co_surface_spring *last = &s->spring[s->n - 1];
    const size_t n = last->first_node + (size_t)last->n_nodes;
    co_couplings more = {.n = before + s->n,
                         .start = CO_NEW(size_t, (size_t)before + (size_t)s->n + 1),
                         .vertex = CO_NEW(int32_t, end + n)};
    if (!more.start || !more.vertex) {
        co_couplings_free(&more);
        co_couplings_free(couplings);
        return co_status_no_memory(error);
    }
    if (couplings->start)
        memcpy(more.start, couplings->start, ((size_t)before + 1) * sizeof *more.start);
    if (end)
        memcpy(more.vertex, couplings->vertex, end * sizeof *more.vertex);
    more.start[before] = end;
    for (int32_t k = 0; k < s->n; k++)
        more.start[before + k + 1] = end + s->spring[k].first_node + (size_t)s->spring[k].n_nodes;
    if (n)
        memcpy(more.vertex + end, s->vertex, n * sizeof *more.vertex);
    co_couplings_free(couplings);
    *couplings = more;
    return CURVOPT_OK;
}

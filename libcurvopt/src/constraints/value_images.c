/* Where symmetries take values of the surface. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/value_images.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "linalg/small_dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of each other up to which stiffnesses are the same. */
static const double SAME_STIFFNESS = 1e-9;
/* Least |det(1 - rho)| of a map of two numbers along the normal that leaves none but 0. A third of a turn has 3, a
 * seventh .75. */
static const double LEAVES_NONE = 1e-3;

void co_value_index_free(co_value_index *x) {
    co_surface_values_free(&x->values);
    free(x->first);
    free(x->start);
    free(x->user);
    free(x->heaviest);
    free(x->largest);
    free(x->work);
    *x = (co_value_index){0};
}

static void list_users(co_value_index *x) {
    const co_sparse_rows *rows = &x->values.rows;
    const int32_t n = x->mesh->info.n_vertices;
    for (size_t e = 0; e < rows->start[rows->n_rows]; e++)
        x->start[rows->column[e] + 1]++;
    for (int32_t v = 0; v < n; v++)
        x->start[v + 1] += x->start[v];
    for (int32_t i = rows->n_rows - 1; i >= 0; i--)
        for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
            x->user[--x->start[rows->column[e] + 1]] = i;
    for (int32_t v = 0; v < n; v++) /* each start was moved to the one before */
        x->start[v] = x->start[v + 1];
    x->start[n] = (int32_t)rows->start[rows->n_rows];
}

static void find_heaviest(co_value_index *x, int32_t i) {
    const co_sparse_rows *rows = &x->values.rows;
    size_t most = rows->start[i];
    for (size_t e = most; e < rows->start[i + 1]; e++)
        if (fabs(rows->value[e]) > fabs(rows->value[most]))
            most = e;
    x->heaviest[i] = rows->column[most];
    x->largest[i] = fabs(rows->value[most]);
}

int32_t co_value_index_create(const curvopt_mesh *m, const co_surface_values *values, co_value_index *out,
                              curvopt_error *error) {
    *out = (co_value_index){.mesh = m};
    if (!values->n)
        return CURVOPT_OK;
    int32_t status = co_surface_values_copy(values, &out->values, error);
    if (status == CURVOPT_OK)
        status = co_surface_values_make_rows(m, &out->values, error);
    if (status == CURVOPT_OK) {
        out->first = CO_NEW(int32_t, values->n);
        out->start = CO_NEW(int32_t, (size_t)m->info.n_vertices + 1);
        out->user = CO_NEW(int32_t, out->values.rows.start[values->n]);
        out->heaviest = CO_NEW(int32_t, values->n);
        out->largest = CO_NEW(double, values->n);
        out->work = CO_NEW(double, m->info.n_vertices);
        if (!out->first || !out->start || !out->user || !out->heaviest || !out->largest || !out->work)
            status = co_status_no_memory(error);
    }
    if (status != CURVOPT_OK) {
        co_value_index_free(out);
        return status;
    }
    for (int32_t i = 0; i < values->n; i++)
        find_heaviest(out, i);
    for (int32_t i = 0; i < values->n; i++)
        out->first[i] = i > 0 && values->item[i].number == values->item[i - 1].number ? out->first[i - 1] : i;
    list_users(out);
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------------- rows -- */

static int32_t vertex_image(const curvopt_mesh *m, const int32_t *corner, int32_t v) {
    return m->vertex_corner[v] < 0 ? v : m->corner_vertex[corner[m->vertex_corner[v]]];
}

/* work += factor * row i */
static void add_row(const co_value_index *x, int32_t i, double factor) {
    const co_sparse_rows *rows = &x->values.rows;
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
        x->work[rows->column[e]] += factor * rows->value[e];
}

static void add_image(const co_value_index *x, const int32_t *corner, int32_t i, double factor) {
    const co_sparse_rows *rows = &x->values.rows;
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
        x->work[vertex_image(x->mesh, corner, rows->column[e])] += factor * rows->value[e];
}

static double dot_with_work(const co_value_index *x, int32_t i) {
    const co_sparse_rows *rows = &x->values.rows;
    double sum = 0;
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
        sum += x->work[rows->column[e]] * rows->value[e];
    return sum;
}

/* Largest of |work| where row i, or its image, is not 0, which becomes 0; to be gone through for each row that was
 * added. */
static double clear_row(const co_value_index *x, const int32_t *corner, int32_t i) {
    const co_sparse_rows *rows = &x->values.rows;
    double largest = 0;
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++) {
        const int32_t v = corner ? vertex_image(x->mesh, corner, rows->column[e]) : rows->column[e];
        largest = fmax(largest, fabs(x->work[v]));
        x->work[v] = 0;
    }
    return largest;
}

/* The image of row i as a combination part [n] of rows to [n], n = 1 or 2: by least squares. Returns what is left of
 * it, in parts of its largest weight. */
static double combine(const co_value_index *x, const int32_t *corner, int32_t i, int n, const int32_t *to,
                      double part[2]) {
    double a[2] = {0}, b[2][2] = {{0}};
    for (int k = 0; k < n; k++) {
        add_row(x, to[k], 1);
        for (int l = 0; l < n; l++)
            b[k][l] = dot_with_work(x, to[l]);
        clear_row(x, NULL, to[k]);
    }
    add_image(x, corner, i, 1);
    for (int k = 0; k < n; k++)
        a[k] = dot_with_work(x, to[k]);
    const double bottom = n == 1 ? b[0][0] : b[0][0] * b[1][1] - b[0][1] * b[1][0];
    part[0] = n == 1 ? a[0] / bottom : (a[0] * b[1][1] - a[1] * b[0][1]) / bottom;
    part[1] = n == 1 ? 0 : (a[1] * b[0][0] - a[0] * b[1][0]) / bottom;
    for (int k = 0; k < n; k++)
        add_row(x, to[k], -part[k]);
    double left = clear_row(x, corner, i);
    for (int k = 0; k < n; k++)
        left = fmax(left, clear_row(x, NULL, to[k]));
    return bottom > 0 ? left / x->largest[i] : (double)INFINITY;
}

/* Whether the image of row i is that of value `to` but for the sign. */
static int is_image(const co_value_index *x, const int32_t *corner, int32_t i, int32_t to, double tolerance,
                    int8_t *sign) {
    double part[2];
    if (!(fabs(x->largest[i] - x->largest[to]) <= tolerance * x->largest[i]))
        return 0;
    const double left = combine(x, corner, i, 1, &to, part);
    *sign = part[0] < 0 ? -1 : 1;
    return left <= tolerance && fabs(fabs(part[0]) - 1) <= tolerance;
}

/* ---------------------------------------------------------------------------------------------- entries -- */

static int32_t entry_size(const co_value_index *x, int32_t first) {
    int32_t n = 1;
    while (first + n < x->values.n && x->first[first + n] == first)
        n++;
    return n;
}

/* The first of two tangents, both in planes, that the entry of `first` holds; -1. */
static int32_t find_pair(const co_value_index *x, int32_t first) {
    const co_surface_value *f = x->values.item;
    for (int32_t i = first; i + 1 < first + entry_size(x, first); i++)
        if (f[i].order == 1 && f[i + 1].order == 1 && f[i].freedom == CO_FREEDOM_PLANE &&
            f[i + 1].freedom == CO_FREEDOM_PLANE)
            return i;
    return -1;
}

/* Whether what is held of value i comes to what is held of value k. */
static int keeps_what_is_held(const co_value_index *x, const co_value_motion *g, int32_t i, int32_t k,
                              double tolerance) {
    const co_surface_value *a = &x->values.item[i], *b = &x->values.item[k];
    double direction[3], at[3], image[3], held[9];
    if (a->order != b->order || a->freedom != b->freedom ||
        !(fabs(a->stiffness - b->stiffness) <= SAME_STIFFNESS * a->stiffness))
        return 0;
    if (a->freedom == CO_FREEDOM_LINE || a->freedom == CO_FREEDOM_PLANE) {
        co_small_dense_apply_3(g->matrix, a->direction, direction);
        if (!(co_freedom_sine(direction, b->direction) <= tolerance))
            return 0;
    }
    if (a->order > 0)
        return 1;
    for (int c = 0; c < 3; c++)
        at[c] = (a->anchor[c] - g->centre[c]) / g->radius;
    co_small_dense_apply_3(g->matrix, at, image);
    for (int c = 0; c < 3; c++)
        image[c] -= (b->anchor[c] - g->centre[c]) / g->radius;
    co_freedom_projector(b->freedom, b->direction, held);
    co_small_dense_apply_3(held, image, at);
    for (int c = 0; c < 3; c++)
        image[c] -= at[c];
    return co_length3(image) <= tolerance;
}

/* The map of two tangents `from` and after: image k is sum_l part[2 k + l] tangent (to + l). */
static double combine_pair(const co_value_index *x, const int32_t *corner, int32_t from, int32_t to, double part[4]) {
    const int32_t both[2] = {to, to + 1};
    const double left = combine(x, corner, from, 2, both, part);
    return fmax(left, combine(x, corner, from + 1, 2, both, part + 2));
}

/* Springs see lengths: whether the rows of `part` are orthonormal. */
static int is_orthogonal(const double part[4], double tolerance) {
    return fabs(part[0] * part[0] + part[1] * part[1] - 1) <= tolerance &&
           fabs(part[2] * part[2] + part[3] * part[3] - 1) <= tolerance &&
           fabs(part[0] * part[2] + part[1] * part[3]) <= tolerance;
}

static int keeps_pair(const co_value_index *x, const co_value_motion *g, int32_t a, int32_t b, double tolerance) {
    double part[4];
    return keeps_what_is_held(x, g, a, b, tolerance) && keeps_what_is_held(x, g, a + 1, b + 1, tolerance) &&
           combine_pair(x, g->corner, a, b, part) <= tolerance &&
           (x->values.item[a].stiffness == 0 || is_orthogonal(part, tolerance));
}

/* Whether the motion takes the entry of value a to that of value b, both its first. */
static int takes_entry(const co_value_index *x, const co_value_motion *g, int32_t a, int32_t b) {
    const int32_t n = entry_size(x, a), pair = find_pair(x, a), other = find_pair(x, b);
    const double tolerance = g->tolerance;
    if (entry_size(x, b) != n || (pair >= 0 ? pair - a : -1) != (other >= 0 ? other - b : -1))
        return 0;
    if (pair >= 0 && !keeps_pair(x, g, pair, other, tolerance))
        return 0;
    for (int32_t i = a; i < a + n; i++) {
        int32_t k = b;
        int8_t sign;
        if (pair >= 0 && (i == pair || i == pair + 1))
            continue;
        while (k < b + n &&
               !(keeps_what_is_held(x, g, i, k, tolerance) && is_image(x, g->corner, i, k, tolerance, &sign)))
            k++;
        if (k == b + n)
            return 0;
    }
    return 1;
}

/* The entry that the motion takes the one of value a to, by its first value; -1. */
static int32_t find_entry(const co_value_index *x, const co_value_motion *g, int32_t a) {
    const int32_t v = vertex_image(x->mesh, g->corner, x->heaviest[a]);
    for (int32_t e = x->start[v], last = -1; e < x->start[v + 1]; e++) {
        const int32_t b = x->first[x->user[e]];
        if (b != last && takes_entry(x, g, a, b))
            return b;
        last = b;
    }
    return -1;
}

int co_value_index_keeps(const co_value_index *x, const co_value_motion *g) {
    for (int32_t i = 0; i < x->values.n; i++) {
        if (x->values.item[i].order == 2)
            return 0;
        if (x->first[i] == i && find_entry(x, g, i) < 0)
            return 0;
    }
    return 1;
}

/* --------------------------------------------------------------------------------------------- tangents -- */

/* The pair whose tangents are those of pair i moved; -1. part as combine_pair. */
static int32_t find_moved_pair(const co_value_index *x, const int32_t *corner, int32_t i, double part[4]) {
    const int32_t v = vertex_image(x->mesh, corner, x->heaviest[i]);
    for (int32_t e = x->start[v]; e < x->start[v + 1]; e++) {
        const int32_t k = find_pair(x, x->first[x->user[e]]);
        if (k >= 0 && combine_pair(x, corner, i, k, part) <= CO_SYMMETRY_TOLERANCE)
            return k;
    }
    return -1;
}

/* Whether pair i is moved to itself. */
static int is_own_image(const co_value_index *x, const int32_t *corner, int32_t i, double part[4]) {
    const int32_t v = vertex_image(x->mesh, corner, x->heaviest[i]);
    int depends = 0;
    for (int32_t e = x->start[v]; e < x->start[v + 1]; e++)
        depends |= x->user[e] == i || x->user[e] == i + 1;
    return depends && combine_pair(x, corner, i, i, part) <= CO_SYMMETRY_TOLERANCE;
}

static const int32_t *map_of(const co_symmetry *s, int32_t g) {
    return s->corner + (size_t)g * (size_t)s->n_corners;
}

/* Coefficients of tangents i and i + 1 become the combinations `part` of them. */
static void change_pair(co_surface_values *values, int32_t i, const double part[4]) {
    co_surface_value *f = &values->item[i];
    const double a[2] = {f[0].along[0], f[0].along[1]}, b[2] = {f[1].along[0], f[1].along[1]};
    for (int k = 0; k < 2; k++)
        for (int l = 0; l < 2; l++)
            f[k].along[l] = part[2 * k] * a[l] + part[2 * k + 1] * b[l];
}

/* The longer one of two rows, as a unit vector. */
static void take_longer(const double row[2][2], double out[2]) {
    const double square[2] = {row[0][0] * row[0][0] + row[0][1] * row[0][1],
                              row[1][0] * row[1][0] + row[1][1] * row[1][1]};
    const int k = square[1] > square[0];
    for (int l = 0; l < 2; l++)
        out[l] = row[k][l] / sqrt(square[k]);
}

/* Of a reflection rho: one tangent that it keeps, and one that it turns round. */
static void split(const double rho[4], double part[4]) {
    const double kept[2][2] = {{1 + rho[0], rho[1]}, {rho[2], 1 + rho[3]}};
    const double turned[2][2] = {{1 - rho[0], -rho[1]}, {-rho[2], 1 - rho[3]}};
    take_longer(kept, part);
    take_longer(turned, part + 2);
}

/* The part of pair i of an orbit whose other pairs follow it. */
static void adapt_pair(const co_value_index *x, const co_symmetry *s, int32_t i, uint8_t *is_done,
                       co_surface_values *values) {
    double rho[4], own[4] = {1, 0, 0, 1};
    for (int32_t g = 1; g < s->order; g++)
        if (is_own_image(x, map_of(s, g), i, rho) && rho[0] * rho[3] - rho[1] * rho[2] < 0) {
            split(rho, own);
            break;
        }
    for (int32_t g = 0; g < s->order; g++) {
        const int32_t k = find_moved_pair(x, map_of(s, g), i, rho);
        double part[4];
        if (k < 0 || is_done[k])
            continue;
        for (int r = 0; r < 2; r++)
            for (int c = 0; c < 2; c++)
                part[2 * r + c] = own[2 * r] * rho[c] + own[2 * r + 1] * rho[2 + c];
        change_pair(values, k, part);
        is_done[k] = 1;
    }
}

int32_t co_value_images_adapt(const curvopt_mesh *m, const co_symmetry *s, co_surface_values *values,
                              curvopt_error *error) {
    co_value_index x;
    if (s->order == 1 || !values->n)
        return CURVOPT_OK;
    int32_t status = co_value_index_create(m, values, &x, error);
    uint8_t *is_done = status == CURVOPT_OK ? CO_NEW(uint8_t, values->n) : NULL;
    if (status == CURVOPT_OK && !is_done)
        status = co_status_no_memory(error);
    for (int32_t i = 0; status == CURVOPT_OK && i < values->n; i++)
        if (find_pair(&x, x.first[i]) == i && !is_done[i])
            adapt_pair(&x, s, i, is_done, values);
    free(is_done);
    co_value_index_free(&x);
    co_sparse_rows_free(&values->rows);
    return status;
}

/* ----------------------------------------------------------------------------------------------- images -- */

void co_value_images_free(co_value_images *images) {
    free(images->to);
    free(images->sign);
    *images = (co_value_images){0};
}

/* Whether two tangents are 0 along their normal on every surface that an element keeps which takes them to `rho` of
 * themselves. */
static int are_given(const co_value_index *x, const double matrix[9], int32_t pair, const double rho[4]) {
    const double *normal = x->values.item[pair].direction;
    double moved[3];
    co_small_dense_apply_3(matrix, normal, moved);
    const double turn = co_dot3(moved, normal) < 0 ? -1 : 1;
    return fabs((1 - turn * rho[0]) * (1 - turn * rho[3]) - rho[1] * rho[2]) > LEAVES_NONE;
}

/* Marks the pairs that are so for some element; is_given [n]. */
static void mark_given(const co_value_index *x, const co_symmetry *s, uint8_t *is_given) {
    double rho[4];
    for (int32_t i = 0; i < x->values.n; i++)
        for (int32_t g = 1; find_pair(x, x->first[i]) == i && !is_given[i] && g < s->order; g++)
            is_given[i] = is_given[i + 1] =
                is_own_image(x, map_of(s, g), i, rho) && are_given(x, s->matrix + 9 * (size_t)g, i, rho);
}

/* The value that an element takes value i to; -1: there is none. */
static int32_t find_image(const co_value_index *x, const int32_t *corner, int32_t i, int8_t *sign) {
    const int32_t v = vertex_image(x->mesh, corner, x->heaviest[i]);
    for (int32_t e = x->start[v]; e < x->start[v + 1]; e++) {
        const co_surface_value *a = &x->values.item[i], *b = &x->values.item[x->user[e]];
        if (a->order == b->order && a->freedom == b->freedom &&
            is_image(x, corner, i, x->user[e], CO_SYMMETRY_TOLERANCE, sign))
            return x->user[e];
    }
    return -1;
}

int32_t co_value_images_create(const curvopt_mesh *m, const co_symmetry *s, const co_surface_values *values,
                               co_value_images *out, int *fits, curvopt_error *error) {
    const size_t n = (size_t)values->n;
    co_value_index x;
    uint8_t *is_given = CO_NEW(uint8_t, n);
    *out = (co_value_images){.n = values->n};
    *fits = 1;
    int32_t status = is_given ? co_value_index_create(m, values, &x, error) : co_status_no_memory(error);
    if (!is_given)
        return status;
    if (status == CURVOPT_OK) {
        out->to = CO_NEW(int32_t, (size_t)s->order * n);
        out->sign = CO_NEW(int8_t, (size_t)s->order * n);
        if (!out->to || !out->sign)
            status = co_status_no_memory(error);
        mark_given(&x, s, is_given);
    }
    for (int32_t g = 0; status == CURVOPT_OK && *fits && g < s->order; g++)
        for (int32_t i = 0; *fits && i < values->n; i++) {
            const size_t at = (size_t)g * n + (size_t)i;
            out->to[at] = is_given[i] ? -1 : find_image(&x, map_of(s, g), i, &out->sign[at]);
            *fits = is_given[i] || out->to[at] >= 0;
        }
    free(is_given);
    co_value_index_free(&x);
    if (status != CURVOPT_OK || !*fits)
        co_value_images_free(out);
    return status;
}

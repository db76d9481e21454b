/* Pivots that symmetries take to each other. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/pivot_orbits.h"

#include "base/memory.h"
#include "linalg/small_dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Eigenvalue from which on a direction is held: they are 0 or 1. */
static const double IS_HELD = 0.5;

static int32_t image_of(const co_pivot_orbits *o, int32_t g, int32_t value) {
    return o->images.to[(size_t)g * (size_t)o->images.n + (size_t)value];
}

static int8_t sign_of(const co_pivot_orbits *o, int32_t g, int32_t value) {
    return o->images.sign[(size_t)g * (size_t)o->images.n + (size_t)value];
}

/* What is held of a value on symmetric surfaces, beside what they have anyway: as freedom and direction of its place,
 * where those of the value itself are not. */
static int32_t freedom_left(const co_pivot_orbits *o, const co_surface_value *f, int32_t value, double direction[3]) {
    double mean[9] = {0}, free_part[9], held[9], both[9], eigenvalue[3], axis[9];
    int32_t n = 0, n_held = 0, odd = 0;
    for (int32_t g = 0; g < o->symmetry->order; g++)
        if (image_of(o, g, value) == value) {
            for (int k = 0; k < 9; k++)
                mean[k] += sign_of(o, g, value) * o->symmetry->matrix[9 * (size_t)g + (size_t)k];
            n++;
        }
    memcpy(direction, f->direction, sizeof f->direction);
    if (n == 1)
        return f->freedom;
    co_freedom_projector(f->freedom, f->direction, free_part);
    for (int k = 0; k < 9; k++)
        held[k] = (k % 4 == 0) - free_part[k];
    co_small_dense_multiply_3(held, mean, both);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            held[3 * i + j] = (both[3 * i + j] + both[3 * j + i]) / (2 * n);
    co_small_dense_eigen(3, 3, held, eigenvalue, axis);
    for (int k = 0; k < 3; k++)
        n_held += eigenvalue[k] > IS_HELD;
    for (int k = 0; k < 3; k++) /* the one that is held alone, or is free alone */
        if ((eigenvalue[k] > IS_HELD) == (n_held == 1))
            odd = k;
    for (int c = 0; c < 3; c++)
        direction[c] = axis[3 * c + odd];
    return 3 - n_held;
}

void co_pivot_orbits_free(co_pivot_orbits *o) {
    co_value_images_free(&o->images);
    free(o->chief);
    free(o->is_given);
    free(o->is_taken);
    free(o->set);
    *o = (co_pivot_orbits){0};
}

/* The chief is in the least group that there is, so that one group has all of its chiefs' orbits' first values. */
static void find_chief(const co_pivot_orbits *o, const int32_t *root, int32_t value) {
    int32_t chief = value;
    o->is_given[value] = 0;
    for (int32_t g = 0; g < o->symmetry->order; g++) {
        const int32_t image = image_of(o, g, value);
        const int is_before = image < chief;
        o->is_given[value] |= image < 0;
        if (image >= 0 && (root[image] == root[chief] ? is_before : root[image] < root[chief]))
            chief = image;
    }
    o->chief[value] = chief;
}

int32_t co_pivot_orbits_create(const curvopt_mesh *m, const co_symmetry *s, const co_surface_values *values,
                               const int32_t *root, co_pivot_orbits *o, int *fits, curvopt_error *error) {
    double direction[3];
    *o = (co_pivot_orbits){.mesh = m, .symmetry = s};
    int32_t status = co_value_images_create(m, s, values, &o->images, fits, error);
    if (status != CURVOPT_OK || !*fits)
        return status;
    o->chief = CO_NEW(int32_t, values->n);
    o->is_given = CO_NEW(uint8_t, values->n);
    o->is_taken = CO_NEW(uint8_t, m->info.n_vertices);
    o->set = CO_NEW(int32_t, s->order);
    if (!o->chief || !o->is_given || !o->is_taken || !o->set) {
        co_pivot_orbits_free(o);
        return co_status_no_memory(error);
    }
    for (int32_t i = 0; i < values->n; i++) {
        find_chief(o, root, i);
        if (!o->is_given[i])
            o->is_given[i] = freedom_left(o, &values->item[i], i, direction) == CO_FREEDOM_ALL;
    }
    return CURVOPT_OK;
}

int32_t co_pivot_orbits_count(const co_pivot_orbits *o, int32_t value, int32_t w) {
    int32_t n_value = 1, n_vertex = 1; /* by the identity */
    for (int32_t g = 1; g < o->symmetry->order; g++) {
        const int keeps_value = image_of(o, g, value) == value;
        const int keeps_vertex = co_symmetry_vertex(o->symmetry, o->mesh, g, w) == w;
        if ((keeps_vertex && !keeps_value) || (keeps_value && sign_of(o, g, value) < 0))
            return 0;
        n_value += keeps_value;
        n_vertex += keeps_vertex;
    }
    return n_value / n_vertex;
}

int32_t co_pivot_orbits_set(const co_pivot_orbits *o, int32_t value, int32_t w, int32_t g) {
    int32_t n = 0;
    for (int32_t h = 0; h < o->symmetry->order; h++) { /* the identity is the first */
        if (image_of(o, h, value) != value)
            continue;
        const int32_t v = co_symmetry_vertex(o->symmetry, o->mesh, g, co_symmetry_vertex(o->symmetry, o->mesh, h, w));
        int32_t k = 0;
        while (k < n && o->set[k] != v)
            k++;
        if (k == n)
            o->set[n++] = v;
    }
    return n;
}

void co_pivot_orbits_take(co_pivot_orbits *o, int32_t w) {
    for (int32_t g = 0; g < o->symmetry->order; g++)
        o->is_taken[co_symmetry_vertex(o->symmetry, o->mesh, g, w)] = 1;
}

/* --------------------------------------------------------------------------------------------- entering -- */

/* What is made. */
typedef struct slots {
    co_surface_values values;
    size_t end;    /* entries of rows that are there */
    double *work;  /* [n_vertices] 0 */
    uint8_t *done; /* [n_vertices] whether the vertex has its slot */
} slots;

/* Room for the slots of all chiefs. */
static int32_t allocate(const co_pivot_orbits *o, const int32_t *pivot, const co_surface_values *from, slots *to,
                        curvopt_error *error) {
    const size_t n_vertices = (size_t)o->mesh->info.n_vertices, order = (size_t)o->symmetry->order;
    size_t n = 0, n_entries = 0;
    for (int32_t i = 0; i < from->n; i++)
        if (pivot[i] >= 0) {
            n += order;
            n_entries += order * (from->rows.start[i + 1] - from->rows.start[i] + order);
        }
    *to = (slots){.work = CO_NEW(double, n_vertices), .done = CO_NEW(uint8_t, n_vertices)};
    to->values.item = CO_NEW(co_surface_value, n + 1);
    if (!to->work || !to->done || !to->values.item)
        return co_status_no_memory(error);
    return co_sparse_rows_allocate(&to->values.rows, (int32_t)n, (int32_t)n_vertices, n_entries, error);
}

/* sign * row i + e_w - mean over set [n], w the first of it. */
static void put_row(const co_sparse_rows *from, int32_t i, int8_t sign, int32_t n, const int32_t *set, slots *to) {
    co_sparse_rows *rows = &to->values.rows;
    const size_t first = to->end;
    for (size_t e = from->start[i]; e < from->start[i + 1]; e++) {
        rows->column[to->end++] = from->column[e];
        to->work[from->column[e]] = sign * from->value[e];
    }
    for (int32_t k = 0; n > 1 && k < n; k++) {
        if (to->work[set[k]] == 0)
            rows->column[to->end++] = set[k];
        to->work[set[k]] += (k == 0) - 1.0 / n;
    }
    for (size_t e = first; e < to->end; e++) {
        rows->value[e] = to->work[rows->column[e]];
        to->work[rows->column[e]] = 0;
    }
    rows->start[to->values.n + 1] = to->end;
}

/* Value i stands at the first vertex of set [n]. */
static void put_slot(const co_pivot_orbits *o, int32_t i, int8_t sign, int32_t n, co_constraints *c, slots *to) {
    const int32_t w = o->set[0];
    co_surface_value *f = &to->values.item[to->values.n];
    *f = c->values.item[i];
    f->pivot = w;
    put_row(&c->values.rows, i, sign, n, o->set, to);
    to->values.n++;
    c->freedom[w] = (uint8_t)freedom_left(o, f, i, c->direction + 3 * (size_t)w);
    c->of_limit[w] = f->order ? CO_OF_TANGENT : CO_OF_POINT;
    for (size_t k = 0; k < 3; k++)
        c->anchor[3 * (size_t)w + k] = sign * f->anchor[k];
}

int32_t co_pivot_orbits_enter(const co_pivot_orbits *o, const int32_t *pivot, co_constraints *c, curvopt_error *error) {
    slots to;
    int32_t status = allocate(o, pivot, &c->values, &to, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < c->values.n; i++)
        for (int32_t g = 0; pivot[i] >= 0 && g < o->symmetry->order; g++) {
            const int32_t w = co_symmetry_vertex(o->symmetry, o->mesh, g, pivot[i]);
            if (to.done[w])
                continue;
            to.done[w] = 1;
            put_slot(o, image_of(o, g, i), sign_of(o, g, i), co_pivot_orbits_set(o, i, pivot[i], g), c, &to);
        }
    free(to.work);
    free(to.done);
    if (status != CURVOPT_OK) {
        co_surface_values_free(&to.values);
        return status;
    }
    to.values.rows.n_rows = to.values.n;
    co_surface_values_free(&c->values);
    c->values = to.values;
    return CURVOPT_OK;
}

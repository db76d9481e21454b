/* The cage vertices in whose place values are unknowns. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/pivots.h"

#include "base/memory.h"
#include "constraints/interpolation.h"
#include "constraints/pivot_orbits.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of a value's largest weight that must be left of it when what it has in common with others is taken off. */
static const double INDEPENDENT = 1e-3;
/* Part of another value from which on one depends on it. */
static const double LEAST_PART = 1e-6;

/* One group's matrix: rows of limit points first, then of values. */
typedef struct group {
    int32_t n_rows, n_fixed, n_columns;
    int32_t *value;  /* [n_rows] of a row; of a limit point -1 */
    int32_t *vertex; /* [n_columns] of a column */
    int32_t *pivot;  /* [n_rows] column; -1: not yet */
    double *scale;   /* [n_rows] largest weight */
    double *largest; /* [n_rows] largest entry that can be a pivot, in parts of that */
    int32_t *column; /* [n_rows] where it is */
    int32_t *count;  /* [n_rows][n_columns] with symmetries: co_pivot_orbits_count() of chiefs, else 0 */
    size_t stride;   /* n_columns + n_rows */
    double *matrix;  /* [n_rows][stride]: weights, then which combination of the rows at first each row is */
    double *before;  /* with symmetries: room for a copy */
} group;

typedef struct search {
    const curvopt_mesh *mesh;
    co_constraints *constraints;
    const co_surface_values *values;
    int32_t *root;           /* [n] the least value of the group */
    int32_t *first;          /* [n_vertices] a value that can have the vertex as its pivot; -1 */
    int32_t *column;         /* [n_vertices] column of the present group; -1 */
    int32_t *row;            /* [n] row of the present group; -1 */
    int32_t *pivot;          /* [n] of chiefs; -1 */
    co_pivot_orbits *orbits; /* NULL: no symmetry is kept */
} search;

static void group_free(group *g) {
    free(g->value);
    free(g->vertex);
    free(g->pivot);
    free(g->scale);
    free(g->largest);
    free(g->column);
    free(g->count);
    free(g->matrix);
    free(g->before);
}

/* Whether nothing else is at vertex v. */
static int is_free(const co_constraints *c, int32_t v) {
    return c->freedom[v] == CO_FREEDOM_ALL && !c->of_limit[v] && !(c->springs.stiffness && c->springs.stiffness[v] > 0);
}

static int32_t root_of(int32_t *root, int32_t i) {
    while (root[i] != i)
        i = root[i] = root[root[i]];
    return i;
}

static void find_groups(search *s) {
    const co_sparse_rows *rows = &s->values->rows;
    for (int32_t v = 0; v < rows->n_columns; v++)
        s->first[v] = s->column[v] = -1;
    for (int32_t i = 0; i < rows->n_rows; i++) {
        s->root[i] = i;
        for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++) {
            const int32_t v = rows->column[e];
            if (!is_free(s->constraints, v))
                continue;
            if (s->first[v] < 0)
                s->first[v] = i;
            const int32_t a = root_of(s->root, i), b = root_of(s->root, s->first[v]);
            s->root[a > b ? a : b] = a < b ? a : b;
        }
    }
    for (int32_t i = 0; i < rows->n_rows; i++)
        s->root[i] = root_of(s->root, i);
}

/* Whether a column of a group can be of vertex v: a pivot's, or that of a limit point. */
static int has_column(const search *s, int32_t v) {
    return is_free(s->constraints, v) || s->constraints->of_limit[v] == CO_OF_OWN_POINT;
}

typedef struct mask {
    const search *search;
    double *row;
} mask;

static void visit_mask(int32_t v, double weight, void *context) {
    const mask *to = context;
    if (to->search->column[v] >= 0)
        to->row[to->search->column[v]] += weight;
}

/* Whether value i needs a pivot in the group of value `root`. */
static int is_row_of(const search *s, int32_t i, int32_t root) {
    return s->root[i] == root && !(s->orbits && s->orbits->is_given[i]);
}

/* Columns and names of rows of the group of value `root`. */
static int32_t list_group(search *s, int32_t root, group *g, curvopt_error *error) {
    const co_sparse_rows *rows = &s->values->rows;
    size_t n_rows = 0, n_entries = 0;
    *g = (group){0};
    for (int32_t i = root; i < rows->n_rows; i++)
        if (is_row_of(s, i, root)) {
            n_rows++;
            n_entries += rows->start[i + 1] - rows->start[i];
        }
    g->value = CO_NEW(int32_t, n_rows + n_entries);
    g->vertex = CO_NEW(int32_t, n_entries);
    if (!g->value || !g->vertex)
        return co_status_no_memory(error);
    for (int32_t i = root; i < rows->n_rows; i++)
        for (size_t e = rows->start[i]; is_row_of(s, i, root) && e < rows->start[i + 1]; e++) {
            const int32_t v = rows->column[e];
            if (s->column[v] >= 0 || !has_column(s, v))
                continue;
            s->column[v] = g->n_columns;
            g->vertex[g->n_columns++] = v;
            if (s->constraints->of_limit[v] == CO_OF_OWN_POINT)
                g->value[g->n_rows++] = -1 - v;
        }
    g->n_fixed = g->n_rows;
    for (int32_t i = root; i < rows->n_rows; i++)
        if (is_row_of(s, i, root)) {
            s->row[i] = g->n_rows;
            g->value[g->n_rows++] = i;
        }
    return CURVOPT_OK;
}

/* How many vertices give way together if column j is the pivot of row r; 0: it cannot be. */
static int32_t count_of(const search *s, const group *g, int32_t r, int32_t j) {
    if (!s->orbits)
        return 1;
    return s->orbits->is_taken[g->vertex[j]] ? 0 : g->count[(size_t)r * (size_t)g->n_columns + (size_t)j];
}

/* Finds the largest entry of row r; with symmetries the largest coefficient of a mean. */
static void look_at_row(const search *s, group *g, int32_t r) {
    const double *row = g->matrix + (size_t)r * g->stride;
    g->largest[r] = -1;
    for (int32_t j = 0; r >= g->n_fixed && j < g->n_columns; j++) {
        const int32_t count = count_of(s, g, r, j);
        const double size = count * fabs(row[j]) / g->scale[r];
        if (count && size > g->largest[r] && s->constraints->of_limit[g->vertex[j]] != CO_OF_OWN_POINT) {
            g->largest[r] = size;
            g->column[r] = j;
        }
    }
}

/* g->count, and room for a copy of the matrix; 0: no memory. */
static int count_means(const search *s, group *g) {
    g->count = CO_NEW(int32_t, (size_t)g->n_rows * (size_t)g->n_columns);
    g->before = CO_NEW(double, (size_t)g->n_rows * g->stride);
    if (!g->count || !g->before)
        return 0;
    for (int32_t r = g->n_fixed; r < g->n_rows; r++)
        for (int32_t j = 0; s->orbits->chief[g->value[r]] == g->value[r] && j < g->n_columns; j++)
            g->count[(size_t)r * (size_t)g->n_columns + (size_t)j] =
                co_pivot_orbits_count(s->orbits, g->value[r], g->vertex[j]);
    return 1;
}

static int32_t fill_group(search *s, group *g, curvopt_error *error) {
    const co_sparse_rows *rows = &s->values->rows;
    g->stride = (size_t)g->n_columns + (size_t)g->n_rows;
    g->pivot = CO_NEW(int32_t, g->n_rows);
    g->column = CO_NEW(int32_t, g->n_rows);
    g->scale = CO_NEW(double, g->n_rows);
    g->largest = CO_NEW(double, g->n_rows);
    g->matrix = CO_NEW(double, (size_t)g->n_rows * g->stride);
    if (!g->pivot || !g->column || !g->scale || !g->largest || !g->matrix)
        return co_status_no_memory(error);
    if (s->orbits && !count_means(s, g))
        return co_status_no_memory(error);
    for (int32_t r = 0; r < g->n_rows; r++) {
        double *row = g->matrix + (size_t)r * g->stride;
        const int32_t i = g->value[r];
        row[g->n_columns + r] = 1;
        g->pivot[r] = -1;
        if (i < 0)
            co_constraints_visit_own_point(s->mesh, s->constraints, -1 - i, visit_mask, &(mask){s, row});
        for (size_t e = i < 0 ? 0 : rows->start[i]; i >= 0 && e < rows->start[i + 1]; e++) {
            g->scale[r] = fmax(g->scale[r], fabs(rows->value[e]));
            if (s->column[rows->column[e]] >= 0)
                row[s->column[rows->column[e]]] = rows->value[e];
        }
        look_at_row(s, g, r);
    }
    return CURVOPT_OK;
}

/* Sum of a row over n vertices. */
static double sum_over(const search *s, const double *row, int32_t n, const int32_t *vertex) {
    double sum = 0;
    for (int32_t k = 0; k < n; k++)
        sum += row[s->column[vertex[k]]];
    return sum;
}

/* Row r has the mean of n vertices as its unknown, the first of which is its pivot: takes it off all rows that have
 * none yet. */
static void eliminate(const search *s, group *g, int32_t r, int32_t n, const int32_t *vertex) {
    const size_t stride = g->stride;
    const double *from = g->matrix + (size_t)r * stride, pivot = sum_over(s, from, n, vertex);
    g->pivot[r] = s->column[vertex[0]];
    for (int32_t k = 0; k < g->n_rows; k++) {
        double *row = g->matrix + (size_t)k * stride;
        const double sum = sum_over(s, row, n, vertex);
        if (g->pivot[k] >= 0 || sum == 0 || pivot == 0)
            continue;
        const double factor = sum / pivot;
        for (size_t j = 0; j < stride; j++)
            row[j] -= factor * from[j];
        if (n == 1)
            row[g->pivot[r]] = 0;
        look_at_row(s, g, k);
    }
}

/* The rows of the orbit of row r that are in the group get the images of vertex w. Where they depend on each other
 * then, nothing is changed but that it cannot be w. */
static void eliminate_orbit(search *s, group *g, int32_t r, int32_t w) {
    co_pivot_orbits *o = s->orbits;
    const int32_t value = g->value[r];
    int fits = 1;
    memcpy(g->before, g->matrix, (size_t)g->n_rows * g->stride * sizeof *g->matrix);
    for (int32_t e = 0; fits && e < o->symmetry->order; e++) {
        const int32_t row = s->row[o->images.to[(size_t)e * (size_t)o->images.n + (size_t)value]];
        const int32_t n = co_pivot_orbits_set(o, value, w, e);
        if (row < 0 || g->pivot[row] >= 0)
            continue;
        for (int32_t k = 0; k < n; k++)
            fits &= s->column[o->set[k]] >= 0;
        if (fits)
            fits = fabs(sum_over(s, g->matrix + (size_t)row * g->stride, n, o->set)) > INDEPENDENT * g->scale[row];
        if (fits)
            eliminate(s, g, row, n, o->set);
    }
    if (fits) {
        co_pivot_orbits_take(o, w);
        s->pivot[value] = w;
    } else {
        memcpy(g->matrix, g->before, (size_t)g->n_rows * g->stride * sizeof *g->matrix);
        g->count[(size_t)r * (size_t)g->n_columns + (size_t)s->column[w]] = 0;
    }
    for (int32_t k = g->n_fixed; k < g->n_rows; k++) {
        if (!fits && o->chief[g->value[k]] == value)
            g->pivot[k] = -1;
        look_at_row(s, g, k);
    }
}

/* Whether a value is not refused where nothing may move for it. */
static int may_be_left(const co_surface_value *f) {
    return f->is_optional || f->stands;
}

/* The row without pivot that has the largest entry, of those that may be left or not; -1: all have pivots. */
static int32_t find_largest(const search *s, const group *g, int may) {
    int32_t r = -1;
    for (int32_t k = g->n_fixed; k < g->n_rows; k++)
        if (g->pivot[k] < 0 && may_be_left(&s->values->item[g->value[k]]) == may &&
            (r < 0 || g->largest[k] > g->largest[r]))
            r = k;
    return r;
}

/* Of the entries that row r is a combination of, beside its own: how many they are, and the one with the largest part;
 * -1: there is none. Those of an entry follow each other. */
static int32_t find_others(const search *s, const group *g, int32_t r, int32_t *n) {
    const double *part = g->matrix + (size_t)r * g->stride + g->n_columns;
    const int32_t own = s->values->item[g->value[r]].number;
    int32_t other = -1, last = own;
    double most = LEAST_PART;
    *n = 0;
    for (int32_t k = g->n_fixed; k < g->n_rows; k++) {
        const co_surface_value *f = &s->values->item[g->value[k]];
        const int32_t number = f->number;
        if (may_be_left(f) || number == own || fabs(part[k]) < LEAST_PART)
            continue;
        *n += number != last;
        last = number;
        if (fabs(part[k]) >= most) {
            most = fabs(part[k]);
            other = number;
        }
    }
    return other;
}

static int32_t refuse(const search *s, const group *g, int32_t r, curvopt_error *error) {
    int32_t n;
    const co_surface_value *f = &s->values->item[g->value[r]];
    const int32_t other = find_others(s, g, r, &n);
    static const char *const names[] = {"point", "tangents", "curvatures"};
    const char *what = names[f->order];
    if (g->n_columns == 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                              "entry %d: nothing that its %s depend%s on may move", f->number, what,
                              f->order ? "" : "s");
    if (other < 0)
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, f->number,
            "entry %d: its %s cannot be chosen freely beside what chains, constraints and the boundary hold "
            "near it: hold less, or subdivide the cage once",
            f->number, what);
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                          "entry %d: its %s cannot be chosen freely beside entry %d%s: too few vertices may move "
                          "there, or both are the same; leave one of them out, or subdivide the cage once",
                          f->number, what, other, n > 1 ? " and others" : "");
}

/* Chooses pivots for rows of values, those that may be left or not. */
static int32_t choose_rows(search *s, group *g, int may, curvopt_error *error) {
    for (int32_t r = find_largest(s, g, may); r >= 0; r = find_largest(s, g, may)) {
        if (!(g->largest[r] > INDEPENDENT))
            return may ? CURVOPT_OK : refuse(s, g, r, error);
        if (s->orbits)
            eliminate_orbit(s, g, r, g->vertex[g->column[r]]);
        else
            eliminate(s, g, r, 1, &g->vertex[g->column[r]]);
    }
    return CURVOPT_OK;
}

/* What is left of a value to move: see is_fixed. */
static int32_t freedom_of(const co_surface_value *f) {
    if (f->order == 1 && f->is_fixed)
        return CO_FREEDOM_NONE;
    return f->order == 2 && !f->is_fixed ? CO_FREEDOM_ALL : f->freedom;
}

/* The pivot of row r becomes that of its value, and the constraint is entered there. */
static void enter(search *s, const group *g, int32_t r) {
    co_constraints *c = s->constraints;
    co_surface_value *f = &c->values.item[g->value[r]];
    const int32_t v = g->vertex[g->pivot[r]];
    f->pivot = v;
    c->freedom[v] = (uint8_t)freedom_of(f);
    c->of_limit[v] = f->order ? CO_OF_TANGENT : CO_OF_POINT;
    memcpy(c->direction + 3 * (size_t)v, f->direction, sizeof f->direction);
    memcpy(c->anchor + 3 * (size_t)v, f->anchor, sizeof f->anchor);
}

static int32_t choose_in_group(search *s, int32_t root, curvopt_error *error) {
    group g;
    int32_t status = list_group(s, root, &g, error);
    if (status == CURVOPT_OK && g.n_rows > CO_INTERPOLATION_MOST_TOUCHING)
        status = co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, s->values->item[root].number,
            "entry %d and those that touch it hold %d points, tangents and curvatures; on one level %d can be: "
            "leave some of them out, or subdivide the cage once",
            s->values->item[root].number, g.n_rows, CO_INTERPOLATION_MOST_TOUCHING);
    if (status == CURVOPT_OK)
        status = fill_group(s, &g, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < g.n_fixed; k++) { /* what is singular interpolation.c refuses */
        const int32_t own = -1 - g.value[k];
        eliminate(s, &g, k, 1, &own);
    }
    for (int may = 0; status == CURVOPT_OK && may < 2; may++)
        status = choose_rows(s, &g, may, error);
    for (int32_t k = 0; k < g.n_columns; k++)
        s->column[g.vertex[k]] = -1;
    for (int32_t k = g.n_fixed; k < g.n_rows; k++)
        s->row[g.value[k]] = -1;
    for (int32_t k = g.n_fixed; status == CURVOPT_OK && !s->orbits && k < g.n_rows; k++)
        if (g.pivot[k] >= 0)
            enter(s, &g, k);
    group_free(&g);
    return status;
}

/* Whether pivots of the group of value `root` are chosen, and not those of an image of it. */
static int has_chief(const search *s, int32_t root) {
    for (int32_t i = root; i < s->values->n; i++)
        if (is_row_of(s, i, root) && (!s->orbits || s->orbits->chief[i] == i))
            return 1;
    return 0;
}

static int32_t choose(search *s, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int32_t i = 0; i < s->values->n; i++)
        s->row[i] = s->pivot[i] = -1;
    for (int32_t i = 0; status == CURVOPT_OK && i < s->values->n; i++)
        if (s->root[i] == i && has_chief(s, i))
            status = choose_in_group(s, i, error);
    return status;
}

/* With pivots that come in orbits. */
static int32_t choose_by_orbits(const search *without, const co_symmetry *symmetry, curvopt_error *error) {
    co_pivot_orbits orbits;
    search s = *without;
    int fits;
    int32_t status = co_pivot_orbits_create(s.mesh, symmetry, s.values, s.root, &orbits, &fits, error);
    if (status == CURVOPT_OK && !fits)
        status = co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "what is held does not have the symmetry");
    s.orbits = &orbits;
    if (status == CURVOPT_OK)
        status = choose(&s, error);
    if (status == CURVOPT_OK)
        status = co_pivot_orbits_enter(&orbits, s.pivot, s.constraints, error);
    co_pivot_orbits_free(&orbits);
    return status;
}

int32_t co_pivots_choose(const curvopt_mesh *m, const co_symmetry *symmetry, co_constraints *constraints,
                         curvopt_error *error) {
    const int32_t n = constraints->values.n;
    if (n == 0)
        return CURVOPT_OK;
    int32_t status = co_surface_values_make_rows(m, &constraints->values, error);
    search s = {.mesh = m,
                .constraints = constraints,
                .values = &constraints->values,
                .root = CO_NEW(int32_t, n),
                .first = CO_NEW(int32_t, m->info.n_vertices),
                .column = CO_NEW(int32_t, m->info.n_vertices),
                .row = CO_NEW(int32_t, n),
                .pivot = CO_NEW(int32_t, n)};
    if (status == CURVOPT_OK && (!s.root || !s.first || !s.column || !s.row || !s.pivot))
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        find_groups(&s);
    if (status == CURVOPT_OK)
        status = symmetry && symmetry->order > 1 ? choose_by_orbits(&s, symmetry, error) : choose(&s, error);
    free(s.root);
    free(s.first);
    free(s.column);
    free(s.row);
    free(s.pivot);
    return status;
}

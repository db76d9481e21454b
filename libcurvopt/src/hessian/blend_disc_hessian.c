/* Second derivatives with respect to the points of wide blends. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/blend_disc_hessian.h"

#include "base/memory.h"
#include "linalg/blas.h"

#include <stdlib.h>
#include <string.h>

enum { TERMS = CO_BLEND_DISC_TERMS, ROWS = 3 * TERMS };

void co_blend_disc_hessian_free(co_blend_disc_hessian *m) {
    free(m->sorted);
    free(m->start);
    free(m->value);
    free(m->node_start);
    free(m->node);
    free(m->entry_start);
    free(m->entry);
    free(m->fit);
    free(m->sums);
    *m = (co_blend_disc_hessian){0};
}

static size_t row_length(const co_blend_disc_fit *f) {
    return 3 * (size_t)f->n_points + ROWS;
}

static int compare_nodes(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* The points of a disc that is used, as rows over the cage; none of another. */
typedef struct disc_points {
    const int32_t *point; /* [n] */
    size_t column, n;     /* place of the first among all discs' */
} disc_points;

static disc_points points_of(const co_blend_discs *w, int32_t k) {
    const co_blend_disc *d = &w->disc[k];
    return (disc_points){w->column + d->column, d->column,
                         d->is_used ? (size_t)co_blend_disc_fit_of(w, d)->n_points : 0};
}

/* Lists the nodes of disc k from `node` on, ascending; mark [n_nodes] is below k for discs from k on. NULL: they are
 * only counted. */
static size_t find_nodes(const co_blend_disc_hessian *m, int32_t k, int32_t *mark, int32_t *node) {
    const disc_points d = points_of(&m->patches->wide, k);
    size_t n = 0;
    for (size_t i = 0; i < d.n; i++) {
        co_point_row row = co_patches_row(m->patches, &d.point[i]);
        for (size_t e = 0; e < row.n; e++) {
            int32_t at = m->dofs->node[row.vertex[e]];
            if (at < 0 || mark[at] == k)
                continue;
            mark[at] = k;
            if (node)
                node[n] = at;
            n++;
        }
    }
    if (node)
        qsort(node, n, sizeof *node, compare_nodes);
    return n;
}

/* Fills the entries of the points of disc k, whose nodes are listed, from `entry` on; returns their number. NULL: they
 * are only counted. first [n_nodes] is work space. */
static size_t fill_entries(const co_blend_disc_hessian *m, int32_t k, int32_t *first, co_blend_disc_entry *entry) {
    const disc_points d = points_of(&m->patches->wide, k);
    int32_t variables = 0;
    size_t n = 0;
    for (size_t e = m->node_start[k]; e < m->node_start[k + 1]; e++) {
        first[m->node[e]] = variables;
        variables += co_dof_map_dimension(m->dofs, m->node[e]);
    }
    if (entry)
        m->entry_start[d.column] = (size_t)(entry - m->entry);
    for (size_t i = 0; i < d.n; i++) {
        co_point_row row = co_patches_row(m->patches, &d.point[i]);
        for (size_t e = 0; e < row.n; e++) {
            int32_t node = m->dofs->node[row.vertex[e]];
            if (node < 0)
                continue;
            if (entry)
                entry[n] = (co_blend_disc_entry){row.vertex[e], first[node], row.weight[e]};
            n++;
        }
        if (entry)
            m->entry_start[d.column + i + 1] = (size_t)(entry - m->entry) + n;
    }
    return n;
}

/* Both passes of a list: once to count, once to fill. */
static int32_t create_nodes(co_blend_disc_hessian *m, int32_t *work, curvopt_error *error) {
    const int32_t n = m->patches->wide.n_discs;
    size_t n_entries = 0, at = 0;
    for (int32_t i = 0; i < m->dofs->n_nodes; i++)
        work[i] = -1;
    for (int32_t k = 0; k < n; k++)
        m->node_start[k + 1] = m->node_start[k] + find_nodes(m, k, work, NULL);
    m->node = CO_NEW(int32_t, m->node_start[n]);
    if (!m->node)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < m->dofs->n_nodes; i++)
        work[i] = -1;
    for (int32_t k = 0; k < n; k++)
        find_nodes(m, k, work, m->node + m->node_start[k]);
    for (int32_t k = 0; k < n; k++)
        n_entries += fill_entries(m, k, work, NULL);
    m->entry = CO_NEW(co_blend_disc_entry, n_entries);
    if (!m->entry)
        return co_status_no_memory(error);
    for (int32_t k = 0; k < n; k++)
        at += fill_entries(m, k, work, m->entry + at);
    return CURVOPT_OK;
}

static int32_t create_variables(co_blend_disc_hessian *m, curvopt_error *error) {
    const co_blend_discs *w = &m->patches->wide;
    size_t most = 0;
    int32_t *work = CO_NEW(int32_t, m->dofs->n_nodes);
    m->node_start = CO_NEW(size_t, w->n_discs + 1);
    m->entry_start = CO_NEW(size_t, w->n_columns + 1);
    int32_t status =
        work && m->node_start && m->entry_start ? create_nodes(m, work, error) : co_status_no_memory(error);
    free(work);
    for (int32_t k = 0; status == CURVOPT_OK && k < w->n_discs; k++) {
        size_t n = co_blend_disc_hessian_n_variables(m, k);
        most = n > most ? n : most;
    }
    m->fit = CO_NEW(double, ROWS *most);
    m->sums = CO_NEW(double, ROWS *most);
    return status != CURVOPT_OK ? status : m->fit && m->sums ? CURVOPT_OK : co_status_no_memory(error);
}

size_t co_blend_disc_hessian_n_variables(const co_blend_disc_hessian *m, int32_t disc) {
    size_t n = 0;
    for (size_t e = m->node_start[disc]; e < m->node_start[disc + 1]; e++)
        n += (size_t)co_dof_map_dimension(m->dofs, m->node[e]);
    return n;
}

/* A point of a disc, and its number there. */
typedef struct numbered_point {
    int32_t point, number;
} numbered_point;

static int compare_points(const void *a, const void *b) {
    const numbered_point *x = a, *y = b;
    if (x->point != y->point)
        return (x->point > y->point) - (x->point < y->point);
    return (x->number > y->number) - (x->number < y->number);
}

static int32_t create_sums(co_blend_disc_hessian *m, curvopt_error *error) {
    const co_blend_discs *w = &m->patches->wide;
    numbered_point *list = CO_NEW(numbered_point, w->n_columns);
    m->start = CO_NEW(size_t, w->n_discs + 1);
    m->sorted = CO_NEW(int32_t, w->n_columns);
    for (int32_t k = 0; list && m->start && m->sorted && k < w->n_discs; k++) {
        const disc_points d = points_of(w, k);
        m->start[k + 1] = m->start[k] + (d.n ? ROWS * row_length(co_blend_disc_fit_of(w, &w->disc[k])) : 0);
        for (size_t i = 0; i < d.n; i++)
            list[i] = (numbered_point){d.point[i], (int32_t)i};
        qsort(list, d.n, sizeof *list, compare_points);
        for (size_t i = 0; i < d.n; i++)
            m->sorted[d.column + i] = list[i].number;
    }
    int done = list && m->start && m->sorted;
    free(list);
    m->value = done ? CO_NEW(double, m->start[w->n_discs]) : NULL;
    return m->value ? CURVOPT_OK : co_status_no_memory(error);
}

/* The number of a point among a disc's; -1 if it is none. */
static int32_t number_of(const co_blend_disc_hessian *m, int32_t disc, int32_t point) {
    const disc_points d = points_of(&m->patches->wide, disc);
    const int32_t *sorted = m->sorted + d.column;
    size_t low = 0, high = d.n;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (d.point[sorted[middle]] <= point)
            low = middle;
        else
            high = middle;
    }
    return d.n > 0 && d.point[sorted[low]] == point ? sorted[low] : -1;
}

int32_t co_blend_disc_hessian_create(const co_patches *patches, const co_dof_map *dofs, co_blend_disc_hessian *m,
                                     curvopt_error *error) {
    *m = (co_blend_disc_hessian){.patches = patches, .dofs = dofs};
    int32_t status = create_sums(m, error);
    if (status == CURVOPT_OK)
        status = create_variables(m, error);
    if (status != CURVOPT_OK)
        co_blend_disc_hessian_free(m);
    return status;
}

void co_blend_disc_hessian_clear(co_blend_disc_hessian *m) {
    memset(m->value, 0, m->start[m->patches->wide.n_discs] * sizeof *m->value);
}

/* The disc that has a coefficient: discs stand in the order of their coefficients. */
static int32_t disc_of_point(const co_blend_discs *w, int32_t point) {
    int32_t low = 0, high = w->n_discs;
    while (high - low > 1) {
        int32_t middle = low + (high - low) / 2;
        if (w->disc[middle].first_point <= point)
            low = middle;
        else
            high = middle;
    }
    return low;
}

int32_t co_blend_disc_hessian_disc_of(const co_patches *p, int32_t patch) {
    return co_fan_is_wide(p->kind[patch]) ? disc_of_point(&p->wide, p->points[p->start[patch + 1] - 1]) : -1;
}

/* Some coefficients of one face's sector in terms of sector 0's: term[k] = sum over b of turn[k][b] q_b. */
typedef struct turned_terms {
    int32_t n;
    const double *turn[TERMS]; /* [n] rows [TERMS] */
    int32_t term[TERMS];
} turned_terms;

static turned_terms terms_of(const co_blend_discs *w, int32_t disc, const co_blend_disc_face_matrix *s) {
    const co_blend_disc_fit *f = co_blend_disc_fit_of(w, &w->disc[disc]);
    turned_terms t = {.n = s->n_terms};
    for (int32_t k = 0; k < t.n; k++) {
        int32_t at = s->points[(size_t)(s->n_own + k) * s->stride] - w->disc[disc].first_point;
        t.term[k] = at % TERMS;
        t.turn[k] = f->turn + ((size_t)(at / TERMS) * TERMS + (size_t)t.term[k]) * TERMS;
    }
    return t;
}

/* Adds the rows of coefficients against own point p, weight times: sum [ROWS][length], from a column on. */
static void add_own(const co_blend_disc_face_matrix *s, const turned_terms *t, int32_t p, double weight, size_t length,
                    double *sum) {
    for (int32_t k = 0; k < t->n; k++)
        for (size_t r = 0; r < 3; r++) {
            const size_t row = 3 * (size_t)(s->n_own + k) + r;
            const double *from = s->face + (row * (row + 1) / 2 + 3 * (size_t)p) * s->stride;
            const double factor = weight * s->weight,
                         value[3] = {factor * from[0], factor * from[s->stride], factor * from[2 * s->stride]};
            for (size_t b = 0; b < TERMS; b++)
                for (size_t c = 0; t->turn[k][b] != 0 && c < 3; c++)
                    sum[(3 * b + r) * length + c] += t->turn[k][b] * value[c];
        }
}

/* Entry of the face's matrix: its lower triangle stands for both. */
static double entry_of(const co_blend_disc_face_matrix *s, size_t i, size_t j) {
    return s->weight * s->face[(i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i) * s->stride];
}

/* Adds the coefficients among themselves: T^T D T, sum [ROWS][length]. */
static void add_among(const co_blend_disc_face_matrix *s, const turned_terms *t, size_t length, double *sum) {
    for (int32_t k = 0; k < t->n; k++)
        for (size_t r = 0; r < 3; r++) {
            double row[ROWS] = {0}; /* of D T */
            for (int32_t l = 0; l < t->n; l++)
                for (size_t c = 0; c < 3; c++) {
                    const double value = entry_of(s, 3 * (size_t)(s->n_own + k) + r, 3 * (size_t)(s->n_own + l) + c);
                    for (size_t b = 0; b < TERMS; b++)
                        row[3 * b + c] += value * t->turn[l][b];
                }
            for (size_t b = 0; b < TERMS; b++)
                for (size_t i = 0; t->turn[k][b] != 0 && i < ROWS; i++)
                    sum[(3 * b + r) * length + i] += t->turn[k][b] * row[i];
        }
}

void co_blend_disc_hessian_add(co_blend_disc_hessian *m, const co_blend_disc_face_matrix *s) {
    const co_blend_discs *w = &m->patches->wide;
    const int32_t disc = co_blend_disc_hessian_disc_of(m->patches, s->patch);
    const co_blend_disc_fit *f = co_blend_disc_fit_of(w, &w->disc[disc]);
    const turned_terms t = terms_of(w, disc, s);
    const size_t length = row_length(f);
    double *sum = m->value + m->start[disc];
    for (int32_t p = 0; p < s->n_own; p++) {
        const int32_t *point = &s->points[(size_t)p * s->stride], number = number_of(m, disc, *point);
        if (number >= 0)
            add_own(s, &t, p, 1, length, sum + 3 * (size_t)number);
        if (number >= 0)
            continue;
        const co_point_row row = co_patches_row(m->patches, point); /* a phantom beyond a half disc's curve */
        for (size_t e = 0; e < row.n; e++)
            add_own(s, &t, p, row.weight[e], length, sum + 3 * (size_t)number_of(m, disc, row.vertex[e]));
    }
    add_among(s, &t, length, sum + 3 * (size_t)f->n_points);
}

/* Fills m->fit and m->sums: the coefficients, and the rows `sum` over the disc's points, in terms of its variables. */
static void reduce_to_variables(co_blend_disc_hessian *m, int32_t disc, size_t n_variables, const double *sum) {
    const co_blend_disc_fit *f = co_blend_disc_fit_of(&m->patches->wide, &m->patches->wide.disc[disc]);
    const disc_points d = points_of(&m->patches->wide, disc);
    const size_t length = row_length(f);
    memset(m->fit, 0, ROWS * n_variables * sizeof *m->fit);
    memset(m->sums, 0, ROWS * n_variables * sizeof *m->sums);
    for (size_t i = 0; i < d.n; i++)
        for (size_t e = m->entry_start[d.column + i]; e < m->entry_start[d.column + i + 1]; e++) {
            const co_blend_disc_entry *at = &m->entry[e];
            const double *basis = m->dofs->basis + 9 * (size_t)at->vertex;
            const int32_t dimensions = co_dof_map_dimension(m->dofs, m->dofs->node[at->vertex]);
            for (int32_t k = 0; k < dimensions; k++)
                for (size_t r = 0; r < ROWS; r++) {
                    const double *from = sum + r * length + 3 * i;
                    const size_t to = r * n_variables + (size_t)(at->first + k);
                    m->fit[to] += at->weight * f->matrix[r / 3 * d.n + i] * basis[3 * (r % 3) + (size_t)k];
                    for (size_t c = 0; c < 3; c++)
                        m->sums[to] += at->weight * from[c] * basis[3 * c + (size_t)k];
                }
        }
}

/* With z the variables, p = F z the coefficients and x = X z the disc's own, the sums stand for the second
 * derivative p^T D p + 2 p^T E x = z^T (F^T D F + F^T E X + X^T E^T F) z. `fit` is F^T and `sums` is (E X)^T; after
 * dgemm sums is (E X + D F / 2)^T =: Y^T, and dsyr2k makes F^T Y + Y^T F, whose two halves of F^T D F add up. */
void co_blend_disc_hessian_collect(co_blend_disc_hessian *m, int32_t disc, double *out) {
    const co_blend_disc_fit *f = co_blend_disc_fit_of(&m->patches->wide, &m->patches->wide.disc[disc]);
    const double zero = 0, half = 0.5, one = 1;
    size_t length = row_length(f), n_variables = co_blend_disc_hessian_n_variables(m, disc);
    double *sum = m->value + m->start[disc], *among = sum + 3 * (size_t)f->n_points;
    const int n = (int)n_variables, rows = ROWS, stride = (int)length;
    if (n == 0)
        return;
    reduce_to_variables(m, disc, n_variables, sum);
    dgemm_("N", "N", &n, &rows, &rows, &half, m->fit, &n, among, &stride, &one, m->sums, &n, 1, 1);
    dsyr2k_("L", "N", &n, &rows, &one, m->fit, &n, m->sums, &n, &zero, out, &n, 1, 1);
}

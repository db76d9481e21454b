/* Second derivatives with respect to the points of wide blends. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/blend_disc_hessian.h"

#include "base/memory.h"
#include "linalg/blas.h"

#include <stdlib.h>
#include <string.h>

enum { TERMS = CO_BLEND_DISC_TERMS, ROWS = 3 * TERMS };

void co_blend_disc_hessian_free(co_blend_disc_hessian *m) {
    free(m->local);
    free(m->start);
    free(m->value);
    free(m->node_start);
    free(m->node);
    free(m->first);
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

/* Fills `node` and `first` of one disc k: its nodes, and its points' places among their variables. at [n_nodes] is work
 * space. */
static void find_nodes(co_blend_disc_hessian *m, int32_t k, int32_t *at) {
    const co_blend_discs *w = &m->patches->wide;
    const co_dof_map *r = m->dofs;
    const size_t column = w->disc[k].column, n = (size_t)co_blend_disc_fit_of(w, &w->disc[k])->n_points;
    int32_t *node = m->node + m->node_start[k], variables = 0;
    size_t found = 0, kept = 0;
    for (size_t i = 0; w->disc[k].is_used && i < n; i++)
        if (r->node[w->column[column + i]] >= 0)
            node[found++] = r->node[w->column[column + i]];
    qsort(node, found, sizeof *node, compare_nodes);
    for (size_t i = 0; i < found; i++) {
        if (kept && node[kept - 1] == node[i])
            continue;
        at[node[i]] = variables;
        variables += co_dof_map_dimension(r, node[i]);
        node[kept++] = node[i];
    }
    for (size_t i = 0; i < n; i++) {
        int32_t moves_with = w->disc[k].is_used ? r->node[w->column[column + i]] : -1;
        m->first[column + i] = moves_with >= 0 ? at[moves_with] : -1;
    }
    m->node_start[k + 1] = m->node_start[k] + kept;
}

size_t co_blend_disc_hessian_n_variables(const co_blend_disc_hessian *m, int32_t disc) {
    size_t n = 0;
    for (size_t e = m->node_start[disc]; e < m->node_start[disc + 1]; e++)
        n += (size_t)co_dof_map_dimension(m->dofs, m->node[e]);
    return n;
}

/* Makes `node` and `first` of all discs, and work space of their size. */
static int32_t create_nodes(co_blend_disc_hessian *m, curvopt_error *error) {
    const co_blend_discs *w = &m->patches->wide;
    size_t all = 0, most = 0;
    for (int32_t k = 0; k < w->n_discs; k++)
        all += (size_t)co_blend_disc_fit_of(w, &w->disc[k])->n_points;
    int32_t *at = CO_NEW(int32_t, m->dofs->n_nodes);
    m->node_start = CO_NEW(size_t, w->n_discs + 1);
    m->node = CO_NEW(int32_t, all);
    m->first = CO_NEW(int32_t, all);
    if (at && m->node_start && m->node && m->first)
        for (int32_t k = 0; k < w->n_discs; k++) {
            find_nodes(m, k, at);
            size_t n = co_blend_disc_hessian_n_variables(m, k);
            most = n > most ? n : most;
        }
    m->fit = CO_NEW(double, ROWS *most);
    m->sums = CO_NEW(double, ROWS *most);
    int done = at && m->node_start && m->node && m->first && m->fit && m->sums;
    free(at);
    return done ? CURVOPT_OK : co_status_no_memory(error);
}

static int32_t create_sums(co_blend_disc_hessian *m, curvopt_error *error) {
    const co_blend_discs *w = &m->patches->wide;
    m->start = CO_NEW(size_t, w->n_discs + 1);
    m->local = CO_NEW(int32_t, w->n_discs ? m->patches->n_cage : 0);
    if (!m->start || !m->local)
        return co_status_no_memory(error);
    for (int32_t i = 0; w->n_discs && i < m->patches->n_cage; i++)
        m->local[i] = -1;
    for (int32_t k = 0; k < w->n_discs; k++) {
        const co_blend_disc_fit *f = co_blend_disc_fit_of(w, &w->disc[k]);
        size_t size = w->disc[k].is_used ? (size_t)f->valence * ROWS * row_length(f) : 0;
        m->start[k + 1] = m->start[k] + size;
        for (int32_t i = 0; i < f->n_points; i++)
            m->local[w->column[w->disc[k].column + (size_t)i]] = i;
    }
    m->value = CO_NEW(double, m->start[w->n_discs]);
    return m->value ? CURVOPT_OK : co_status_no_memory(error);
}

int32_t co_blend_disc_hessian_create(const co_patches *patches, const co_dof_map *dofs, co_blend_disc_hessian *m,
                                     curvopt_error *error) {
    *m = (co_blend_disc_hessian){.patches = patches, .dofs = dofs};
    int32_t status = create_sums(m, error);
    if (status == CURVOPT_OK)
        status = create_nodes(m, error);
    if (status != CURVOPT_OK)
        co_blend_disc_hessian_free(m);
    return status;
}

void co_blend_disc_hessian_clear(co_blend_disc_hessian *m) {
    memset(m->value, 0, m->start[m->patches->wide.n_discs] * sizeof *m->value);
}

/* The disc that has a point of a polynomial: they stand in the order of these points. */
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

void co_blend_disc_hessian_add(co_blend_disc_hessian *m, const co_blend_disc_face_matrix *s) {
    const co_blend_discs *w = &m->patches->wide;
    int32_t disc = co_blend_disc_hessian_disc_of(m->patches, s->patch), n_own = s->n_own;
    const co_blend_disc_fit *f = co_blend_disc_fit_of(w, &w->disc[disc]);
    int32_t sector = (s->points[(size_t)n_own * s->stride] - w->disc[disc].first_point) / TERMS;
    size_t length = row_length(f);
    double *sum = m->value + m->start[disc] + (size_t)sector * ROWS * length;
    for (size_t r = 0; r < ROWS; r++, sum += length) {
        size_t row = 3 * (size_t)n_own + r;
        const double *from = s->face + row * (row + 1) / 2 * s->stride;
        for (int32_t p = 0; p < n_own; p++) {
            double *to = sum + 3 * m->local[s->points[(size_t)p * s->stride]];
            for (size_t c = 0; c < 3; c++)
                to[c] += s->weight * from[(3 * (size_t)p + c) * s->stride];
        }
        double *to = sum + 3 * f->n_points;
        for (size_t c = 0; c < ROWS; c++) { /* the lower triangle stands for both */
            size_t at = 3 * (size_t)n_own + c;
            to[c] += s->weight * (c <= r ? from[at * s->stride] : s->face[(at * (at + 1) / 2 + row) * s->stride]);
        }
    }
}

/* to [n] += factor * from [n] */
static void add_row(size_t n, double factor, const double *from, double *to) {
    for (size_t i = 0; i < n; i++)
        to[i] += factor * from[i];
}

/* Adds a sector's sums to sector 0's, in terms of sector 0's points. With T = `turn`, by which the sector's points of
 * the polynomial are made from sector 0's, p = T p0, a sum D over pairs of them becomes T^T D T, and a sum E over them
 * and the disc's points T^T E:
 *
 *     from:  ( E | D )  --columns-->  ( E | D T )  --rows-->  ( T^T E | T^T D T )  added to `to` */
static void turn_sums(const double *turn, size_t n_columns, double *from, double *to) {
    const size_t length = n_columns + ROWS;
    for (size_t r = 0; r < ROWS; r++) { /* D becomes D T */
        double turned[ROWS] = {0}, *row = from + r * length + n_columns;
        for (size_t a = 0; a < TERMS; a++)
            for (size_t b = 0; b < TERMS; b++)
                for (size_t c = 0; c < 3; c++)
                    turned[3 * b + c] += turn[a * TERMS + b] * row[3 * a + c];
        memcpy(row, turned, sizeof turned);
    }
    for (size_t a = 0; a < TERMS; a++) /* T^T of both */
        for (size_t b = 0; b < TERMS; b++)
            for (size_t c = 0; turn[a * TERMS + b] != 0 && c < 3; c++)
                add_row(length, turn[a * TERMS + b], from + (3 * a + c) * length, to + (3 * b + c) * length);
}

/* Fills m->fit and m->sums: the polynomial's points, and the rows `sum` over the disc's points, in terms of the disc's
 * variables. */
static void reduce_to_variables(co_blend_disc_hessian *m, int32_t disc, size_t n_variables, const double *sum) {
    const co_blend_discs *w = &m->patches->wide;
    const co_blend_disc_fit *f = co_blend_disc_fit_of(w, &w->disc[disc]);
    size_t n = (size_t)f->n_points, length = row_length(f);
    memset(m->fit, 0, ROWS * n_variables * sizeof *m->fit);
    memset(m->sums, 0, ROWS * n_variables * sizeof *m->sums);
    for (size_t i = 0; i < n; i++) {
        size_t at = w->disc[disc].column + i;
        if (m->first[at] < 0)
            continue;
        const double *basis = m->dofs->basis + 9 * (size_t)w->column[at];
        size_t dimensions = (size_t)co_dof_map_dimension(m->dofs, m->dofs->node[w->column[at]]);
        for (size_t k = 0; k < dimensions; k++)
            for (size_t r = 0; r < ROWS; r++) {
                size_t to = r * n_variables + (size_t)m->first[at] + k;
                m->fit[to] += f->matrix[r / 3 * n + i] * basis[3 * (r % 3) + k];
                for (size_t c = 0; c < 3; c++)
                    m->sums[to] += sum[r * length + 3 * i + c] * basis[3 * c + k];
            }
    }
}

/* With z the variables, p = F z the polynomial's points and x = X z the disc's own, the sums stand for the second
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
    for (size_t s = 1; s < (size_t)f->valence; s++)
        turn_sums(f->turn + s * TERMS * TERMS, 3 * (size_t)f->n_points, sum + s * ROWS * length, sum);
    reduce_to_variables(m, disc, n_variables, sum);
    dgemm_("N", "N", &n, &rows, &rows, &half, m->fit, &n, among, &stride, &one, m->sums, &n, 1, 1);
    dsyr2k_("L", "N", &n, &rows, &one, m->fit, &n, m->sums, &n, &zero, out, &n, 1, 1);
}

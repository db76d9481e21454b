/* Second derivatives with respect to the points of wide blends. SPDX-License-Identifier: GPL-3.0-or-later */
#include "wide_matrix.h"

#include "memory.h"

#include <stdlib.h>
#include <string.h>

enum { TERMS = CO_WIDE_TERMS, ROWS = 3 * TERMS };

void co_wide_matrix_free(co_wide_matrix *m) {
    free(m->local);
    free(m->start);
    free(m->value);
    *m = (co_wide_matrix){0};
}

static size_t row_length(const co_wide_fit *f) {
    return 3 * (size_t)f->n_points + ROWS;
}

int32_t co_wide_matrix_create(const co_patches *patches, co_wide_matrix *m, curvopt_error *error) {
    const co_wide *w = &patches->wide;
    *m = (co_wide_matrix){.patches = patches};
    m->start = CO_NEW(size_t, w->n_discs + 1);
    m->local = CO_NEW(int32_t, w->n_discs ? patches->n_cage : 0);
    for (int32_t i = 0; m->local && w->n_discs && i < patches->n_cage; i++)
        m->local[i] = -1;
    for (int32_t k = 0; m->start && m->local && k < w->n_discs; k++) {
        const co_wide_fit *f = co_wide_fit_of(w, &w->disc[k]);
        size_t size = w->disc[k].is_used ? (size_t)f->valence * ROWS * row_length(f) : 0;
        m->start[k + 1] = m->start[k] + size;
        for (int32_t i = 0; i < f->n_points; i++)
            m->local[w->column[w->disc[k].column + (size_t)i]] = i;
    }
    m->value = m->start ? CO_NEW(double, m->start[w->n_discs]) : NULL;
    if (m->local && m->value)
        return CURVOPT_OK;
    co_wide_matrix_free(m);
    return co_status_no_memory(error);
}

void co_wide_matrix_clear(co_wide_matrix *m) {
    memset(m->value, 0, m->start[m->patches->wide.n_discs] * sizeof *m->value);
}

/* Discs stand in the order of their points. */
static int32_t disc_of_point(const co_wide *w, int32_t point) {
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

int32_t co_wide_matrix_disc_of(const co_patches *p, int32_t patch) {
    return co_fan_is_wide(p->valence[patch]) ? disc_of_point(&p->wide, p->points[p->start[patch + 1] - 1]) : -1;
}

void co_wide_matrix_add(co_wide_matrix *m, const co_wide_share *s) {
    const co_wide *w = &m->patches->wide;
    int32_t disc = co_wide_matrix_disc_of(m->patches, s->patch), n_own = s->n_own;
    const co_wide_fit *f = co_wide_fit_of(w, &w->disc[disc]);
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

/* A sector's sums in terms of sector 0's points, added to those. */
static void turn_sums(const double *turn, size_t n_columns, double *from, double *to) {
    const size_t length = n_columns + ROWS;
    for (size_t r = 0; r < ROWS; r++) { /* columns */
        double turned[ROWS] = {0}, *row = from + r * length + n_columns;
        for (size_t a = 0; a < TERMS; a++)
            for (size_t b = 0; b < TERMS; b++)
                for (size_t c = 0; c < 3; c++)
                    turned[3 * b + c] += turn[a * TERMS + b] * row[3 * a + c];
        memcpy(row, turned, sizeof turned);
    }
    for (size_t a = 0; a < TERMS; a++) /* rows */
        for (size_t b = 0; b < TERMS; b++)
            for (size_t c = 0; turn[a * TERMS + b] != 0 && c < 3; c++)
                add_row(length, turn[a * TERMS + b], from + (3 * a + c) * length, to + (3 * b + c) * length);
}

void co_wide_matrix_pull(co_wide_matrix *m, int32_t disc, double *half) {
    const co_wide_fit *f = co_wide_fit_of(&m->patches->wide, &m->patches->wide.disc[disc]);
    size_t n = (size_t)f->n_points, length = row_length(f);
    double *sum = m->value + m->start[disc];
    for (size_t s = 1; s < (size_t)f->valence; s++)
        turn_sums(f->turn + s * TERMS * TERMS, 3 * n, sum + s * ROWS * length, sum);
    for (size_t r = 0; r < ROWS; r++) { /* half of what the polynomial's points have among themselves */
        double *row = sum + r * length;
        for (size_t b = 0; b < TERMS; b++)
            for (size_t i = 0; i < n; i++)
                for (size_t c = 0; c < 3; c++)
                    row[3 * i + c] += 0.5 * row[3 * n + 3 * b + c] * f->matrix[b * n + i];
    }
    memset(half, 0, 9 * n * n * sizeof *half);
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < TERMS; a++)
            for (size_t c = 0; c < 3; c++)
                add_row(3 * n, f->matrix[a * n + i], sum + (3 * a + c) * length, half + (3 * i + c) * 3 * n);
}

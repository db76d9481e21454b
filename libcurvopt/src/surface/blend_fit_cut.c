/* Fits at vertices where sharp edges cut the fan (method: blend_fit_cut.h). SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "surface/blend_fit_cut.h"

#include "base/elementary.h"
#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

enum {
    TERMS = CO_BLEND_FIT_TERMS,
    SECTORS = 32 /* so many of them at most have samples: P is of degree 5, more would tell nothing new */
};

void co_blend_fit_natural(int32_t fan, int32_t sector, int x, int y, double at[2]) {
    const double sector_angle = (co_fan_is_open(fan) ? 1.0 : 2.0) / co_fan_sectors(fan); /* over pi, as angle */
    const double angle = sector_angle * (sector + 2 * co_angle_over_pi(y, x));
    const int one_face = co_fan_is_open(fan) && co_fan_sectors(fan) == 1;
    at[0] = one_face ? x - y : co_length(x, y) * co_cos_pi(angle);
    at[1] = one_face ? x * y : co_length(x, y) * co_sin_pi(angle);
}

static void fill_map(int32_t fan, double *map) {
    for (int32_t s = 0; s < co_fan_sectors(fan); s++)
        for (int x = 0; x <= 2; x++)
            for (int y = 0; y <= 2; y++)
                co_blend_fit_natural(fan, s, x, y, map + 2 * (size_t)co_fan_index(fan, s, x, y));
}

const double co_blend_fit_curve_weight[CO_BLEND_FIT_CURVE][CO_BLEND_FIT_CURVE] = {
    {0, 1 / 6.0, 4 / 6.0, 1 / 6.0, 0},
    {0, -0.5, 0, 0.5, 0},
    {0, 0.5, -1, 0.5, 0},
    {-1 / 12.0, 1 / 6.0, 0, -1 / 6.0, 1 / 12.0},
    {1 / 12.0, -1 / 3.0, 0.5, -1 / 3.0, 1 / 12.0}};

void co_blend_fit_curve_points(int32_t fan, int32_t point[CO_BLEND_FIT_CURVE]) {
    const int32_t n = co_fan_sectors(fan);
    point[0] = co_fan_index(fan, n, 2, 0);
    point[1] = co_fan_index(fan, n, 1, 0);
    point[2] = 0;
    point[3] = co_fan_index(fan, 0, 1, 0);
    point[4] = co_fan_index(fan, 0, 2, 0);
}

/* Coefficients of the curve, q and j, in p->fit: those of a B-spline's segments either side of the vertex. */
static void prescribe_curve(int32_t fan, co_blend_fit *p) {
    int32_t point[CO_BLEND_FIT_CURVE];
    co_blend_fit_curve_points(fan, point);
    for (int a = 0; a < CO_BLEND_FIT_CURVE; a++)
        for (int i = 0; i < CO_BLEND_FIT_CURVE; i++) {
            int function = a < 4 ? co_blend_fit_term(a, 0) : CO_BLEND_FIT_CUSP;
            p->fit[function * p->n_points + point[i]] = co_blend_fit_curve_weight[a][i];
        }
    p->has_cusp = 1;
}

/* A fit that is being made. */
typedef struct cut_fit {
    const co_blend_fit *p;
    int n_terms;                            /* monomials that are fitted, */
    int term[TERMS];                        /* and which */
    co_double_double normal[TERMS * TERMS]; /* lower triangle [n_terms][n_terms] */
    co_double_double *right;                /* [n_terms][n_points] */
} cut_fit;

static void choose_terms(int with_curve, cut_fit *f) {
    for (int degree = 0; degree <= CO_BLEND_FIT_DEGREE; degree++)
        for (int b = with_curve; b <= degree; b++) /* with a factor y */
            f->term[f->n_terms++] = co_blend_fit_term(degree - b, b);
}

/* Adds a sample, less what the curve alone gives there. */
static void add_sample(void *user, const double *row, double weight) {
    cut_fit *f = user;
    const co_blend_fit *p = f->p;
    const double root = sqrt(weight);
    double x = 0, y = 0, value[CO_BLEND_FIT_FUNCTIONS], scaled[TERMS];
    for (int32_t i = 0; i < p->n_points; i++) {
        x += row[i] * p->map[2 * i];
        y += row[i] * p->map[2 * i + 1];
    }
    co_blend_fit_values(x, y, value);
    value[CO_BLEND_FIT_CUSP] = co_power(co_length(x, y), 3);
    for (int a = 0; a < f->n_terms; a++) {
        scaled[a] = root * value[f->term[a]];
        for (int b = 0; b <= a; b++)
            f->normal[a * f->n_terms + b] =
                co_double_double_add_product(f->normal[a * f->n_terms + b], scaled[a], scaled[b]);
    }
    for (int32_t i = 0; i < p->n_points; i++) {
        double rest = row[i];
        for (int k = 0; k < CO_BLEND_FIT_FUNCTIONS && p->has_cusp; k++)
            rest -= p->fit[k * p->n_points + i] * value[k];
        for (int a = 0; a < f->n_terms && rest != 0; a++)
            f->right[a * p->n_points + i] =
                co_double_double_add_product(f->right[a * p->n_points + i], root * rest, scaled[a]);
    }
}

static int32_t add_sector(int32_t fan, int32_t sector, double *work, cut_fit *f, curvopt_error *error) {
    co_stam_disc disc;
    int32_t kind = co_fan_make(co_fan_type_of(fan), co_fan_sectors(fan), sector);
    int32_t status = co_stam_disc_create(kind, &disc, error);
    if (status == CURVOPT_OK) {
        co_blend_fit_sample_rings(&disc, 1, work, add_sample, f);
        co_stam_disc_free(&disc);
    }
    return status;
}

/* Sector number i of the m that have samples, out of n: evenly spread, and a set that a mirror leaves as it is. */
static int32_t sampled_sector(int32_t i, int32_t m, int32_t n) {
    const int32_t k = i < m - 1 - i ? i : m - 1 - i, s = (2 * k + 1) * n / (2 * m);
    return k == i ? s : n - 1 - s;
}

int32_t co_blend_fit_create_cut(int32_t fan, co_blend_fit *p, curvopt_error *error) {
    const int32_t n = co_fan_sectors(fan), m = n < SECTORS ? n : SECTORS;
    cut_fit f = {.p = p};
    *p = (co_blend_fit){.valence = n, .width = 1, .n_points = co_fan_n_points(fan)};
    const size_t n_points = (size_t)p->n_points;
    double *work = CO_NEW(double, 18 * n_points);
    p->map = CO_NEW(double, 2 * n_points);
    p->fit = CO_NEW(double, CO_BLEND_FIT_FUNCTIONS *n_points);
    f.right = CO_NEW(co_double_double, TERMS * n_points);
    int32_t status = work && p->map && p->fit && f.right ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        fill_map(fan, p->map);
        if (co_fan_is_open(fan))
            prescribe_curve(fan, p);
        choose_terms(co_fan_is_open(fan), &f);
    }
    for (int32_t i = 0; status == CURVOPT_OK && i < m; i++)
        status = add_sector(fan, sampled_sector(i, m, n), work, &f, error);
    if (status == CURVOPT_OK)
        co_blend_fit_solve(f.n_terms, f.normal, p->n_points, p->n_points, f.right);
    for (int a = 0; status == CURVOPT_OK && a < f.n_terms; a++)
        for (int32_t i = 0; i < p->n_points; i++)
            p->fit[f.term[a] * p->n_points + i] = f.right[a * p->n_points + i].high;
    free(work);
    free(f.right);
    if (status != CURVOPT_OK)
        co_blend_fit_free(p);
    return status;
}

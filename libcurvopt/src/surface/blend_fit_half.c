/* Fits on half discs (method: blend_fit_half.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_fit_half.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "surface/blend_fit_cut.h"
#include "surface/gauss_legendre.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    TERMS = CO_BLEND_FIT_TERMS,
    FUNCTIONS = CO_BLEND_FIT_FUNCTIONS,
    CURVE = CO_BLEND_FIT_DEGREE + 2 /* functions of the curve: 1, x, .. x^5, and the cusp */
};

static size_t function_of_curve(int k) {
    return k < CURVE - 1 ? (size_t)co_blend_fit_term(k, 0) : CO_BLEND_FIT_CUSP;
}

int co_blend_fit_half_point(int32_t n, int width, int32_t sector, int x, int y, int32_t index[2], double weight[2]) {
    const int below = y < 0 && sector == 0, beside = x < 0 && sector == n - 1;
    weight[0] = 1;
    if (below || beside) {
        index[0] = co_blend_fit_half_index(width, sector, beside ? 0 : x, below ? 0 : y);
        index[1] = co_blend_fit_half_index(width, sector, beside ? 1 : x, below ? 1 : y);
        weight[0] = 2;
        weight[1] = -1;
        return 2;
    }
    index[0] = y < 0   ? co_blend_fit_half_index(width, sector - 1, -y, x)
               : x < 0 ? co_blend_fit_half_index(width, sector + 1, y, -x)
                       : co_blend_fit_half_index(width, sector, x, y);
    return 1;
}

/* The cubic B-spline's subdivision along one line: how many of the coarse points, from *first on, a refined one is
 * made of. */
static int subdivision_mask(int refined, int *first, double weight[3]) {
    const int is_odd = refined % 2;
    *first = is_odd ? refined / 2 : refined / 2 - 1;
    weight[0] = is_odd ? 0.5 : 0.125;
    weight[1] = is_odd ? 0.5 : 0.75;
    weight[2] = 0.125;
    return is_odd ? 2 : 3;
}

/* Place (x, y) of a sector in the coarse net, of `width`, subdivided; not the vertex. */
static void refined_place(int32_t n, int width, const double *coarse, int32_t sector, int x, int y, double to[2]) {
    int first[2];
    double along_x[3], along_y[3];
    const int n_x = subdivision_mask(x, &first[0], along_x), n_y = subdivision_mask(y, &first[1], along_y);
    to[0] = to[1] = 0;
    for (int k = 0; k < n_x * n_y; k++) {
        int32_t index[2];
        double part[2];
        const int n_parts =
            co_blend_fit_half_point(n, width, sector, first[0] + k % n_x, first[1] + k / n_x, index, part);
        for (int i = 0; i < n_parts; i++)
            for (int c = 0; c < 2; c++)
                to[c] += along_x[k % n_x] * along_y[k / n_x] * part[i] * coarse[2 * index[i] + c];
    }
}

/* The control points of a map [2 n_points], in units of a face along the curve. room: for a coarser net of as many. */
static void fill_map(int32_t n, int width, int steps, double *map, double *room) {
    const int32_t fan = co_fan_make(CO_FAN_CREASE, n, 0), n_points = co_blend_fit_half_n_points(n, width);
    const int coarse = (width + 1) / 2; /* places up to (width + 1) / 2 + 1 are needed, and as many */
    if (steps > 0)
        fill_map(n, coarse, steps - 1, room, room + 2 * n_points);
    for (int32_t s = 0; s < n; s++)
        for (int x = 0; x <= width + 1; x++)
            for (int y = x == 0; y <= width + 1; y++) {
                double *to = map + 2 * (size_t)co_blend_fit_half_index(width, s, x, y);
                if (steps == 0) {
                    co_blend_fit_natural(fan, s, x, y, to);
                    continue;
                }
                refined_place(n, coarse, room, s, x, y, to);
                to[0] *= 2;
                to[1] *= 2;
            }
    map[0] = map[1] = 0;
}

int32_t co_blend_fit_create_half_map(const co_blend_fit_half_kind *kind, co_blend_fit *p, curvopt_error *error) {
    *p = (co_blend_fit){.valence = kind->n_sectors,
                        .width = kind->width,
                        .is_half = 1,
                        .has_cusp = 1,
                        .steps = kind->steps,
                        .n_points = co_blend_fit_half_n_points(kind->n_sectors, kind->width)};
    const size_t n = 2 * (size_t)p->n_points;
    double *room = CO_NEW(double, n *(size_t)(kind->steps + 1)), largest = 0;
    p->map = CO_NEW(double, n);
    if (!p->map || !room) {
        free(room);
        co_blend_fit_free(p);
        return co_status_no_memory(error);
    }
    fill_map(kind->n_sectors, kind->width, kind->steps, p->map, room);
    free(room);
    for (size_t i = 0; i < n; i += 2)
        largest = fmax(largest, co_length(p->map[i], p->map[i + 1]));
    p->unit = 1 / largest; /* or high powers, as their coefficients, lose digits */
    for (size_t i = 0; i < n; i++)
        p->map[i] *= p->unit;
    return CURVOPT_OK;
}

/* A fit that is being made. Rows of samples are over some points; each of the n entries says that as much of the row's
 * number `part` belongs to the disc's point `index`. */
typedef struct half_fit {
    co_blend_fit *p;
    int32_t n, *part, *index;                       /* [n] */
    double *weight;                                 /* [n] */
    co_double_double normal[FUNCTIONS * FUNCTIONS]; /* lower triangle */
    co_double_double *right;                        /* [FUNCTIONS][n_points] */
} half_fit;

static void add_sample(void *user, const double *row, double weight) {
    half_fit *f = user;
    const co_blend_fit *p = f->p;
    const double root = sqrt(weight);
    double x = 0, y = 0, value[FUNCTIONS];
    for (int32_t k = 0; k < f->n; k++) {
        x += row[f->part[k]] * f->weight[k] * p->map[2 * f->index[k]];
        y += row[f->part[k]] * f->weight[k] * p->map[2 * f->index[k] + 1];
    }
    co_blend_fit_values(x, y, value);
    value[CO_BLEND_FIT_CUSP] = co_power(co_length(x, y), 3);
    for (int a = 0; a < FUNCTIONS; a++) {
        value[a] *= root;
        for (int b = 0; b <= a; b++)
            f->normal[a * FUNCTIONS + b] =
                co_double_double_add_product(f->normal[a * FUNCTIONS + b], value[a], value[b]);
        for (int32_t k = 0; k < f->n; k++) { /* the weights are 1, 2 and -1: no rounding */
            co_double_double *to = f->right + a * p->n_points + f->index[k];
            *to = co_double_double_add_product(*to, root * row[f->part[k]] * f->weight[k], value[a]);
        }
    }
}

/* The curve's point at x = -(width + 1) .. width + 1. */
static int32_t point_of_curve(const co_blend_fit *p, int x) {
    return x == 0 ? 0 : co_blend_fit_half_index(p->width, x > 0 ? 0 : p->valence, abs(x), 0);
}

/* Fits the curve alone, into the rows of p's coefficients: as many samples as a face has a side. */
static void fit_curve(half_fit *f) {
    const co_blend_fit *p = f->p;
    co_double_double normal[CURVE * CURVE] = {{0}}, *right = f->right;
    double node[CO_BLEND_FIT_GAUSS], gauss[CO_BLEND_FIT_GAUSS];
    co_gauss_legendre(CO_BLEND_FIT_GAUSS, node, gauss);
    for (int segment = -p->width; segment < p->width; segment++)
        for (int i = 0; i < CO_BLEND_FIT_GAUSS; i++) {
            const double x = segment + node[i];
            double weight = gauss[i], basis[4][4], value[CURVE] = {1}, w[CO_JET];
            co_bspline_cubic(node[i], basis);
            co_blend_weight(CO_BLEND_POLYNOMIAL, fabs(x) / p->width, 0, w);
            weight *= w[0] + co_blend_fit_far_weight;
            const double root = sqrt(weight);
            for (int a = 1; a < CURVE - 1; a++)
                value[a] = value[a - 1] * x * p->unit;
            value[CURVE - 1] = co_power(fabs(x) * p->unit, 3);
            for (int a = 0; a < CURVE; a++) {
                value[a] *= root;
                for (int b = 0; b <= a; b++)
                    normal[a * CURVE + b] = co_double_double_add_product(normal[a * CURVE + b], value[a], value[b]);
                for (int k = 0; k < 4; k++) {
                    co_double_double *to = right + a * p->n_points + point_of_curve(p, segment + k - 1);
                    *to = co_double_double_add_product(*to, root * basis[k][0], value[a]);
                }
            }
        }
    co_blend_fit_solve(CURVE, normal, p->n_points, p->n_points, right);
    for (int a = 0; a < CURVE; a++)
        for (int32_t i = 0; i < p->n_points; i++)
            p->fit[function_of_curve(a) * (size_t)p->n_points + (size_t)i] = right[a * p->n_points + i].high;
    memset(right, 0, CURVE * (size_t)p->n_points * sizeof *right);
}

/* The face at the vertex: rows over the two-ring. work: co_blend_fit_sample_rings */
static int32_t add_vertex_face(half_fit *f, int32_t sector, double *work, curvopt_error *error) {
    co_stam_disc disc;
    int32_t status = co_stam_disc_create(co_fan_make(CO_FAN_CREASE, f->p->valence, sector), &disc, error);
    if (status != CURVOPT_OK)
        return status;
    f->n = disc.n_points;
    for (int32_t k = 0; k < f->n; k++) {
        f->part[k] = k;
        f->index[k] = co_blend_fit_index_of_two_ring(f->p, k);
        f->weight[k] = 1;
    }
    co_blend_fit_sample_rings(&disc, f->p->width, work, add_sample, f);
    co_stam_disc_free(&disc);
    return CURVOPT_OK;
}

/* Any other face: rows over its 16 points. */
static void add_face(half_fit *f, int32_t sector, int i, int j) {
    f->n = 0;
    for (int k = 0; k < 16; k++) {
        int n = co_blend_fit_half_point(f->p->valence, f->p->width, sector, i + k % 4 - 1, j + k / 4 - 1,
                                        f->index + f->n, f->weight + f->n);
        for (; n > 0; n--)
            f->part[f->n++] = k;
    }
    co_blend_fit_sample_face(f->p->width, i, j, add_sample, f);
}

/* Fits y Q to what the curve's part leaves. */
static void fit_rest(half_fit *f) {
    co_blend_fit *p = f->p;
    const size_t n = (size_t)p->n_points;
    int term[TERMS], n_terms = 0;
    co_double_double normal[TERMS * TERMS] = {{0}};
    for (int degree = 1; degree <= CO_BLEND_FIT_DEGREE; degree++)
        for (int b = 1; b <= degree; b++)
            term[n_terms++] = co_blend_fit_term(degree - b, b);
    for (int a = 0; a < n_terms; a++) {
        co_double_double *right = f->right + (size_t)term[a] * n;
        for (int c = 0; c < CURVE; c++) {
            const size_t other = function_of_curve(c), own = (size_t)term[a];
            const co_double_double both = f->normal[other > own ? other * FUNCTIONS + own : own * FUNCTIONS + other];
            for (size_t i = 0; i < n; i++)
                right[i] =
                    co_double_double_subtract_product(right[i], both, (co_double_double){p->fit[other * n + i], 0});
        }
        for (int b = 0; b <= a; b++)
            normal[a * n_terms + b] = f->normal[term[a] * FUNCTIONS + term[b]];
    }
    for (int a = 0; a < n_terms; a++) /* terms ascend, so that none is overwritten before it is moved */
        memmove(f->right + (size_t)a * n, f->right + (size_t)term[a] * n, n * sizeof *f->right);
    co_blend_fit_solve(n_terms, normal, p->n_points, p->n_points, f->right);
    for (int a = 0; a < n_terms; a++)
        for (size_t i = 0; i < n; i++)
            p->fit[(size_t)term[a] * n + i] = f->right[(size_t)a * n + i].high;
}

int32_t co_blend_fit_create_half(const co_blend_fit_half_kind *kind, co_blend_fit *p, curvopt_error *error) {
    const int32_t n = kind->n_sectors, width = kind->width;
    const size_t two_ring = (size_t)co_fan_n_points(co_fan_make(CO_FAN_CREASE, n, 0)), most = two_ring + 32;
    int32_t status = co_blend_fit_create_half_map(kind, p, error);
    if (status != CURVOPT_OK)
        return status;
    half_fit f = {.p = p,
                  .part = CO_NEW(int32_t, most),
                  .index = CO_NEW(int32_t, most),
                  .weight = CO_NEW(double, most),
                  .right = CO_NEW(co_double_double, FUNCTIONS * (size_t)p->n_points)};
    double *work = CO_NEW(double, 18 * two_ring);
    p->fit = CO_NEW(double, FUNCTIONS *(size_t)p->n_points);
    if (!f.part || !f.index || !f.weight || !f.right || !work || !p->fit)
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        fit_curve(&f);
    for (int32_t s = 0; status == CURVOPT_OK && s < n; s++) {
        status = add_vertex_face(&f, s, work, error);
        for (int j = 0; status == CURVOPT_OK && j < width; j++)
            for (int i = j == 0; i < width; i++)
                add_face(&f, s, i, j);
    }
    if (status == CURVOPT_OK)
        fit_rest(&f);
    else
        co_blend_fit_free(p);
    free(f.part);
    free(f.index);
    free(f.weight);
    free(f.right);
    free(work);
    return status;
}

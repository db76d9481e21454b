/* The fit of the surface `polynomial` (method: blend_fit.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_fit.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "surface/gauss_legendre.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FIT_GAUSS = CO_BLEND_FIT_GAUSS,
    FIT_RINGS = 5 /* rings of cells of the face at the vertex (notes/10-blend-degree-and-weight.md) */
};

enum { TERMS = CO_BLEND_FIT_TERMS };

void co_blend_fit_free(co_blend_fit *p) {
    free(p->map);
    free(p->fit);
    *p = (co_blend_fit){0};
}

void co_blend_fit_monomials(const double x[CO_JET], const double y[CO_JET], double out[TERMS][CO_JET]) {
    memset(out[0], 0, sizeof out[0]);
    out[0][0] = 1;
    /* degree after degree: x times those of the degree before, then y times the last of them */
    for (int degree = 1, at = 1; degree <= CO_BLEND_FIT_DEGREE; degree++) {
        int before = at - degree;
        for (int i = 0; i < degree; i++)
            co_jet_multiply(x, out[before + i], out[at + i]);
        co_jet_multiply(y, out[at - 1], out[at + degree]);
        at += degree + 1;
    }
}

void co_blend_fit_values(double x, double y, double out[TERMS]) {
    out[0] = 1;
    for (int degree = 1, at = 1; degree <= CO_BLEND_FIT_DEGREE; degree++) {
        for (int i = 0; i < degree; i++)
            out[at + i] = x * out[at - degree + i];
        out[at + degree] = y * out[at - 1];
        at += degree + 1;
    }
}

/* Jet of s^(3/2), s = x^2 + y^2, by the chain rule. */
void co_blend_fit_cusp(const double x[CO_JET], const double y[CO_JET], double out[CO_JET]) {
    double xx[CO_JET], yy[CO_JET], s[CO_JET];
    co_jet_multiply(x, x, xx);
    co_jet_multiply(y, y, yy);
    for (int k = 0; k < CO_JET; k++)
        s[k] = xx[k] + yy[k];
    const double r = sqrt(s[0]), g1 = 1.5 * r, g2 = 0.75 / r, g3 = -0.375 / (r * s[0]);
    const double u = s[1], v = s[2], uu = s[3], uv = s[4], vv = s[5];
    out[0] = r * s[0];
    out[1] = g1 * u;
    out[2] = g1 * v;
    out[3] = g1 * uu + g2 * u * u;
    out[4] = g1 * uv + g2 * u * v;
    out[5] = g1 * vv + g2 * v * v;
    out[6] = g1 * s[6] + 3 * g2 * u * uu + g3 * u * u * u;
    out[7] = g1 * s[7] + g2 * (v * uu + 2 * u * uv) + g3 * u * u * v;
    out[8] = g1 * s[8] + g2 * (u * vv + 2 * v * uv) + g3 * u * v * v;
    out[9] = g1 * s[9] + 3 * g2 * v * vv + g3 * v * v * v;
}

int32_t co_blend_fit_surface(int32_t surface, int32_t kind) {
    int32_t n = co_fan_sectors(kind);
    switch (co_fan_type_of(kind)) {
    case CO_FAN_CLOSED:
        if (n == 2 || (n >= CO_BLEND_FIT_UNRESOLVED && surface == CURVOPT_SURFACE_LIMIT))
            return CURVOPT_SURFACE_POLYNOMIAL;
        return n == CO_FAN_REGULAR ? CURVOPT_SURFACE_LIMIT : surface;
    case CO_FAN_CREASE:
    case CO_FAN_DART:
        return surface == CURVOPT_SURFACE_LIMIT && co_fan_is_integrable(kind) ? surface : CURVOPT_SURFACE_POLYNOMIAL;
    case CO_FAN_WIDE:
    case CO_FAN_HALF:
        return CURVOPT_SURFACE_POLYNOMIAL;
    default: /* corners of several faces, and cones, have no tangent plane that a polynomial could have */
        return CURVOPT_SURFACE_LIMIT;
    }
}

int32_t co_blend_fit_index(int32_t valence, int width, int32_t sector, int x, int y) {
    if (y < 0)
        return co_blend_fit_index(valence, width, sector + valence - 1, -y, x);
    if (x < 0)
        return co_blend_fit_index(valence, width, sector + 1, y, -x);
    if (x == 0 && y == 0)
        return 0;
    if (x == 0)
        return co_blend_fit_index(valence, width, sector + 1, y, 0);
    return 1 + (width + 1) * ((width + 2) * (sector % valence) + y) + x - 1;
}

int32_t co_blend_fit_half_index(int width, int32_t sector, int x, int y) {
    if (x == 0 && y == 0)
        return 0;
    if (x == 0) /* on the next sector's first edge */
        return co_blend_fit_half_index(width, sector + 1, y, 0);
    return 1 + (width + 1) * ((width + 2) * sector + y) + x - 1;
}

int32_t co_blend_fit_index_of_two_ring(const co_blend_fit *p, int32_t i) {
    int32_t sector = (i - 1) / CO_RING_SECTOR, place = (i - 1) % CO_RING_SECTOR;
    if (i == 0 || p->width == 1)
        return i;
    return p->is_half ? co_blend_fit_half_index(p->width, sector, 1 + place % 2, place / 2)
                      : co_blend_fit_index(p->valence, p->width, sector, 1 + place % 2, place / 2);
}

void co_blend_fit_turn(int32_t valence, int32_t sector, double turn[TERMS][TERMS]) {
    const double angle = 2.0 * sector / valence, c = co_cos_pi(angle), d = co_sin_pi(angle);
    double image[TERMS][TERMS] = {{1}}; /* monomials of c x - d y, d x + c y, by those of x, y */
    for (int degree = 1, at = 1; degree <= CO_BLEND_FIT_DEGREE; degree++) {
        int before = at - degree;
        for (int i = 0; i <= degree; i++) {
            const double *from = image[i < degree ? before + i : at - 1] + before;
            double along_x = i < degree ? c : d, along_y = i < degree ? -d : c;
            for (int k = 0; k < degree; k++) {
                image[at + i][at + k] += along_x * from[k];
                image[at + i][at + k + 1] += along_y * from[k];
            }
        }
        at += degree + 1;
    }
    for (int a = 0; a < TERMS; a++)
        for (int b = 0; b < TERMS; b++)
            turn[a][b] = image[b][a];
}

/* A point of the surface: the sum of row[i] times point index[i] of the disc. */
typedef struct sample {
    int32_t n;            /* number of points */
    const int32_t *index; /* [n] numbers of the disc's points */
    const double *row;    /* [n] their weights */
} sample;

/* A fit that is being made, for samples over n of the disc's points. */
typedef struct disc_fit {
    co_blend_fit *p;
    int32_t n, *index;        /* [n] */
    double (*value)[TERMS];   /* [valence] work space */
    co_double_double *normal; /* [TERMS][TERMS] lower triangle */
    co_double_double *right;  /* [TERMS][n_points] */
} disc_fit;

/* Adds a sample of sector 0, weighted, and its images in the other sectors to the normal equations: `normal`, lower
 * triangle, and `right`; those of sector 0's points and the vertex
 * alone, because each of these meets one image of every point of the sample. */
static void add_sample(const disc_fit *f, const sample *at, double weight) {
    const co_blend_fit *p = f->p;
    const double root = sqrt(weight);
    double x = 0, y = 0, (*value)[TERMS] = f->value;
    co_double_double sum[TERMS] = {{0}};
    int32_t per_sector = (p->n_points - 1) / p->valence;
    for (int32_t i = 0; i < at->n; i++) {
        x += at->row[i] * p->map[2 * at->index[i]];
        y += at->row[i] * p->map[2 * at->index[i] + 1];
    }
    for (int32_t s = 0; s < p->valence; s++) {
        double c = co_cos_pi(2.0 * s / p->valence), d = co_sin_pi(2.0 * s / p->valence);
        co_blend_fit_values(c * x - d * y, c * y + d * x, value[s]);
        for (int a = 0; a < TERMS; a++) {
            value[s][a] *= root;
            sum[a] = co_double_double_add(sum[a], (co_double_double){value[s][a], 0});
            for (int b = 0; b <= a; b++)
                f->normal[a * TERMS + b] =
                    co_double_double_add_product(f->normal[a * TERMS + b], value[s][a], value[s][b]);
        }
    }
    for (int32_t i = 0; i < at->n; i++) {
        const int32_t sector = at->index[i] ? (at->index[i] - 1) / per_sector : 0; /* turned back by so many */
        const int32_t point = at->index[i] ? 1 + (at->index[i] - 1) % per_sector : 0;
        const double *image = value[(p->valence - sector) % p->valence], row = root * at->row[i];
        for (int a = 0; a < TERMS; a++) {
            co_double_double *to = f->right + a * p->n_points + point;
            *to = at->index[i]
                      ? co_double_double_add_product(*to, row, image[a])
                      : co_double_double_add(*to, co_double_double_multiply(sum[a], (co_double_double){row, 0}));
        }
    }
}

/* The other sectors' columns of p->fit: with the points turned by some sectors, P is turned by as many. */
static void turn_columns(co_blend_fit *p) {
    const int32_t per_sector = (p->n_points - 1) / p->valence;
    for (int32_t s = 1; s < p->valence; s++) {
        double turn[TERMS][TERMS];
        co_blend_fit_turn(p->valence, p->valence - s, turn);
        for (int32_t i = 1; i <= per_sector; i++)
            for (int a = 0; a < TERMS; a++) {
                double sum = 0;
                for (int b = 0; b < TERMS; b++)
                    sum += turn[a][b] * p->fit[b * p->n_points + i];
                p->fit[a * p->n_points + i + s * per_sector] = sum;
            }
    }
}

/* right = L^-T L^-1 right, L the lower triangle `factor`; right has steps of `stride`. */
static void solve_column(int n_terms, const co_double_double *factor, int32_t stride, co_double_double *right) {
    for (int pass = 0; pass < 2; pass++)
        for (int m = 0; m < n_terms; m++) {
            const int i = pass == 0 ? m : n_terms - 1 - m, first = pass == 0 ? 0 : i + 1, end = pass == 0 ? i : n_terms;
            co_double_double sum = right[i * stride];
            for (int k = first; k < end; k++)
                sum = co_double_double_subtract_product(sum, factor[pass == 0 ? i * n_terms + k : k * n_terms + i],
                                                        right[k * stride]);
            right[i * stride] = co_double_double_divide(sum, factor[i * n_terms + i]);
        }
}

void co_blend_fit_solve(int n_terms, co_double_double *normal, int32_t n, int32_t stride, co_double_double *right) {
    for (int j = 0; j < n_terms; j++)
        for (int i = j; i < n_terms; i++) {
            co_double_double sum = normal[i * n_terms + j];
            for (int k = 0; k < j; k++)
                sum = co_double_double_subtract_product(sum, normal[i * n_terms + k], normal[j * n_terms + k]);
            normal[i * n_terms + j] =
                i == j ? co_double_double_sqrt(sum) : co_double_double_divide(sum, normal[j * n_terms + j]);
        }
    for (int32_t c = 0; c < n; c++)
        solve_column(n_terms, normal, stride, right + c);
}

/* The samples of one cell of the disc's present ring. */
static void sample_cell(const co_stam_disc *d, int c, int width, double *work, co_blend_fit_add *add, void *user) {
    double node[FIT_GAUSS], gauss[FIT_GAUSS], basis[16][CO_JET], w[CO_JET];
    double *point = work, *vertex = work + 16 * (size_t)d->n_points, *row = vertex + d->n_points;
    const double side = ldexp(1, -d->ring);
    co_gauss_legendre(FIT_GAUSS, node, gauss);
    co_stam_disc_cell(d, c, vertex, point);
    for (int j = 0; j < FIT_GAUSS; j++)
        for (int i = 0; i < FIT_GAUSS; i++) {
            co_bspline_bicubic(node[i], node[j], basis);
            co_blend_weight(CO_BLEND_POLYNOMIAL, side * (co_stam_cell_place[c][0] + node[i]) / width,
                            side * (co_stam_cell_place[c][1] + node[j]) / width, w);
            for (int32_t q = 0; q < d->n_points; q++) {
                row[q] = vertex[q];
                for (int k = 0; k < 16; k++)
                    row[q] += basis[k][0] * point[k * d->n_points + q];
            }
            add(user, row, gauss[i] * gauss[j] * side * side * (w[0] + co_blend_fit_far_weight));
        }
}

void co_blend_fit_sample_rings(co_stam_disc *disc, int width, double *work, co_blend_fit_add *add, void *user) {
    for (int ring = 1; ring <= FIT_RINGS; ring++) {
        for (int c = 0; c < CO_RING_CELLS; c++)
            sample_cell(disc, c, width, work, add, user);
        co_stam_disc_advance(disc);
    }
}

void co_blend_fit_sample_face(int width, int i, int j, co_blend_fit_add *add, void *user) {
    double node[FIT_GAUSS], gauss[FIT_GAUSS], basis[16][CO_JET], w[CO_JET], row[16];
    co_gauss_legendre(FIT_GAUSS, node, gauss);
    for (int n = 0; n < FIT_GAUSS * FIT_GAUSS; n++) {
        double s = node[n % FIT_GAUSS], t = node[n / FIT_GAUSS];
        co_bspline_bicubic(s, t, basis);
        co_blend_weight(CO_BLEND_POLYNOMIAL, (i + s) / width, (j + t) / width, w);
        for (int k = 0; k < 16; k++)
            row[k] = basis[k][0];
        add(user, row, gauss[n % FIT_GAUSS] * gauss[n / FIT_GAUSS] * (w[0] + co_blend_fit_far_weight));
    }
}

static void add_row(void *user, const double *row, double weight) {
    const disc_fit *f = user;
    const sample at = {f->n, f->index, row};
    add_sample(f, &at, weight);
}

/* The cubic B-spline's subdivision along one line: how many of the coarse points, from *first on, a refined one is
 * made of. */
static int subdivision_mask(int refined, int *first, double *weight) {
    static const double even[3] = {0.125, 0.75, 0.125}, odd[2] = {0.5, 0.5};
    *first = refined % 2 ? refined / 2 : refined / 2 - 1;
    memcpy(weight, refined % 2 ? odd : even, refined % 2 ? sizeof odd : sizeof even);
    return refined % 2 ? 2 : 3;
}

/* The characteristic map from the two-ring outwards: subdivided once it is itself, smaller by lambda, and what is new
 * at places beyond the second is made of nearer ones by the regular rules. */
static void extend_map(co_blend_fit *p, double lambda) {
    for (int ring = 3; ring <= p->width + 1; ring++)
        for (int32_t s = 0; s < p->valence; s++)
            for (int k = 0; k <= 2 * ring; k++) {
                int x = k <= ring ? ring : 2 * ring - k, y = k <= ring ? k : ring, first[2], n[2];
                double along_x[3], along_y[3];
                double *to = p->map + 2 * co_blend_fit_index(p->valence, p->width, s, x, y);
                to[0] = to[1] = 0;
                n[0] = subdivision_mask(x, &first[0], along_x);
                n[1] = subdivision_mask(y, &first[1], along_y);
                for (int i = 0; i < n[0] * n[1]; i++) {
                    int32_t from =
                        co_blend_fit_index(p->valence, p->width, s, first[0] + i % n[0], first[1] + i / n[0]);
                    double weight = along_x[i % n[0]] * along_y[i / n[0]] / lambda;
                    to[0] += weight * p->map[2 * from];
                    to[1] += weight * p->map[2 * from + 1];
                }
            }
}

int32_t co_blend_fit_create_map(const co_stam_disc *disc, int width, co_blend_fit *p, curvopt_error *error) {
    *p = (co_blend_fit){
        .valence = disc->valence, .width = width, .n_points = co_blend_fit_n_points(disc->valence, width)};
    p->map = CO_NEW(double, 2 * (size_t)p->n_points);
    double *core = CO_NEW(double, 2 * (size_t)disc->n_points), largest = 0;
    if (!p->map || !core) {
        free(core);
        co_blend_fit_free(p);
        return co_status_no_memory(error);
    }
    co_stam_characteristic_map(disc, core);
    for (int32_t i = 0; i < disc->n_points; i++)
        memcpy(p->map + 2 * co_blend_fit_index_of_two_ring(p, i), core + 2 * i, 2 * sizeof *core);
    free(core);
    extend_map(p, disc->lambda);
    for (int32_t i = 0; i < p->n_points; i++)
        largest = fmax(largest, co_length(p->map[2 * i], p->map[2 * i + 1]));
    for (int32_t i = 0; width > 1 && i < 2 * p->n_points; i++) /* or high powers, as their coefficients, lose digits */
        p->map[i] /= largest;
    return CURVOPT_OK;
}

/* Fills p->fit from the disc's rows. work [18 n_points of the disc]: room. */
static void fit(disc_fit *f, co_stam_disc *deeper, double *work) {
    co_blend_fit *p = f->p;
    f->n = deeper->n_points;
    for (int32_t i = 0; i < deeper->n_points; i++)
        f->index[i] = co_blend_fit_index_of_two_ring(p, i);
    co_blend_fit_sample_rings(deeper, p->width, work, add_row, f);
    f->n = 16;
    for (int face = 1; face < p->width * p->width; face++) {
        const int i = face % p->width, j = face / p->width;
        for (int k = 0; k < 16; k++)
            f->index[k] = co_blend_fit_index(p->valence, p->width, 0, i + k % 4 - 1, j + k / 4 - 1);
        co_blend_fit_sample_face(p->width, i, j, add_row, f);
    }
    co_blend_fit_solve(TERMS, f->normal, 1 + (p->n_points - 1) / p->valence, p->n_points, f->right);
    for (size_t i = 0; i < TERMS * (size_t)p->n_points; i++)
        p->fit[i] = f->right[i].high;
    turn_columns(p);
}

int32_t co_blend_fit_create(const co_stam_disc *disc, int width, co_blend_fit *p, curvopt_error *error) {
    size_t n = (size_t)disc->n_points;
    co_stam_disc deeper = {0};
    co_double_double normal[TERMS * TERMS] = {{0}};
    int32_t status = co_blend_fit_create_map(disc, width, p, error);
    if (status != CURVOPT_OK)
        return status;
    disc_fit f = {.p = p,
                  .index = CO_NEW(int32_t, n + 16),
                  .value = co_memory_zeroed((size_t)p->valence, sizeof *f.value),
                  .normal = normal,
                  .right = CO_NEW(co_double_double, TERMS * (size_t)p->n_points)};
    double *work = CO_NEW(double, 18 * n);
    p->fit = CO_NEW(double, CO_BLEND_FIT_FUNCTIONS *(size_t)p->n_points);
    status = f.index && work && f.value && f.right && p->fit ? co_stam_disc_create(disc->valence, &deeper, error)
                                                             : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        fit(&f, &deeper, work);
    else
        co_blend_fit_free(p);
    free(f.index);
    free(f.value);
    free(f.right);
    free(work);
    co_stam_disc_free(&deeper);
    return status;
}

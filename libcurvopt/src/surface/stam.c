/* The limit surface near an extraordinary vertex, as rows over its two-ring (sources: stam.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/stam.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "mesh/crease.h"
#include "mesh/subdivide.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const int co_stam_cell_place[CO_RING_CELLS][2] = {{1, 0}, {1, 1}, {0, 1}};

/* The sharp edges and vertices that make the fan what it is; open ones need no creases, being cut out. */
static int32_t sharpen(curvopt_mesh *mesh, int32_t fan, curvopt_error *error) {
    const int32_t along = co_fan_index(fan, 0, 1, 0), far = co_fan_index(fan, 0, 2, 0), vertex = 0;
    const int32_t dart[4] = {vertex, along, along, far};
    const double sharpness[2] = {CURVOPT_SHARPNESS_INFINITE, CURVOPT_SHARPNESS_INFINITE};
    co_fan_type type = co_fan_type_of(fan);
    curvopt_creases creases = {.crease_vertices = dart,
                               .crease_sharpness = sharpness,
                               .corner_vertices = &vertex,
                               .corner_sharpness = sharpness,
                               .n_creases = type == CO_FAN_DART ? 2 : 0,
                               .n_corners = type == CO_FAN_CORNER || type == CO_FAN_CONE};
    return creases.n_creases || creases.n_corners ? co_crease_set(mesh, &creases, error) : CURVOPT_OK;
}

/* The two-ring as an open mesh: four quads a sector, vertices numbered as in fan.h. */
static int32_t disc_mesh(int32_t fan, curvopt_mesh **mesh, curvopt_error *error) {
    int32_t n_faces = 4 * co_fan_sectors(fan), status;
    int32_t *sizes = CO_NEW(int32_t, n_faces), *vertices = CO_NEW(int32_t, 4 * (size_t)n_faces);
    if (!sizes || !vertices) {
        status = co_status_no_memory(error);
        goto done;
    }
    for (int32_t f = 0; f < n_faces; f++) {
        int32_t s = f / 4;
        int x = f % 2, y = f / 2 % 2;
        sizes[f] = 4;
        vertices[4 * f] = co_fan_index(fan, s, x, y);
        vertices[4 * f + 1] = co_fan_index(fan, s, x + 1, y);
        vertices[4 * f + 2] = co_fan_index(fan, s, x + 1, y + 1);
        vertices[4 * f + 3] = co_fan_index(fan, s, x, y + 1);
    }
    status = co_mesh_create(co_fan_n_points(fan), n_faces, sizes, vertices, mesh, error);
    if (status == CURVOPT_OK)
        status = sharpen(*mesh, fan, error);
done:
    free(sizes);
    free(vertices);
    return status;
}

/* Index of the refined point at place (x, y) of sector s in half units; -1 <= x, y <= 3, not both negative. */
static int32_t refined_index(const curvopt_mesh *m, int32_t valence, int32_t s, int x, int y) {
    if (y < 0)
        return refined_index(m, valence, s + valence - 1, -y, x);
    if (x < 0)
        return refined_index(m, valence, s + 1, y, -x);
    int cell_x = x > 1, cell_y = y > 1, odd_x = x % 2, odd_y = y % 2;
    int32_t f = 4 * (s % valence) + 2 * cell_y + cell_x, h = m->face_start[f], n_v = m->info.n_vertices;
    if (odd_x && odd_y)
        return n_v + m->info.n_edges + f;
    if (odd_x)
        return n_v + m->edge[h];
    if (odd_y)
        return n_v + m->edge[h + 3];
    return m->corner_vertex[h];
}

/* The number among the rows of a refined point; refined [CO_STAM_MOST_ROWS] lists those that there are. */
static int32_t row_of(co_stam_disc *d, int32_t point, int32_t *refined) {
    for (int32_t k = 0; k < d->n_rows; k++)
        if (refined[k] == point)
            return k;
    refined[d->n_rows] = point;
    return d->n_rows++;
}

/* The 16 points of a cell; beyond the fan's sharp edges they are phantoms (ring.h). */
static void place_cell(co_stam_disc *d, const curvopt_mesh *m, int which, int32_t *refined) {
    int32_t n = d->valence, s = co_fan_sector(d->fan);
    for (int k = 0; k < 16; k++) {
        int x = co_stam_cell_place[which][0] + k % 4 - 1, y = co_stam_cell_place[which][1] + k / 4 - 1;
        int below = y < 0 && s == 0 && co_fan_is_cut(d->fan), beside = x < 0 && s == n - 1 && co_fan_is_cut(d->fan);
        d->cell[which][k] = row_of(d, refined_index(m, n, s, beside ? 0 : x, below ? 0 : y), refined);
        d->mirrored[which][k] = -1;
        if (below || beside)
            d->mirrored[which][k] = row_of(d, refined_index(m, n, s, beside ? 1 : x, below ? 1 : y), refined);
    }
}

/* The larger eigenvalue of the one-ring's subdivision for waves that change by an angle from sector to sector, c its
 * cosine (Stam 1998; Ball and Storry 1988). */
static double eigenvalue_of_wave(double c) {
    return (5 + c + sqrt((c + 9) * (c + 1))) / 16;
}

/* lambda and mu from the eigenvalues a >= b >= c. */
static void from_plane_and_height(double a, double b, double c, double *lambda, double *mu) {
    *lambda = sqrt(a * b);
    *mu = *lambda * fmin(sqrt(a * b) * c / (b * b), 0.9995);
}

/* Between two sharp edges: the curve has 1, 1/2 and 1/4, and waves that vanish on both have angles pi k / n. */
static void crease_eigenvalues(int32_t n, double *lambda, double *mu) {
    double largest[3] = {0.5, 0.25, 0.25};
    for (int32_t k = 1; k <= 3 && k < n; k++) {
        double value = eigenvalue_of_wave(co_cos_pi((double)k / n));
        for (int i = 0; i < 3; i++)
            if (value > largest[i]) {
                double smaller = largest[i];
                largest[i] = value;
                value = smaller;
            }
    }
    from_plane_and_height(largest[0], largest[1], largest[2], lambda, mu);
}

/* By frequency: those of waves, and for frequency 0, besides 1, the roots of a quadratic. */
static void eigenvalues(int32_t valence, double *lambda, double *mu) {
    double n = valence, alpha = 1 - 7 / (4 * n), beta = 3 / (2 * n), gamma = 1 / (4 * n);
    double half_sum = (alpha - 0.25) / 2, product = (alpha - beta + gamma) / 16;
    double discriminant = half_sum * half_sum - product;
    *lambda = eigenvalue_of_wave(co_cos_pi(2 / n));
    *mu = discriminant > 0 ? half_sum + sqrt(discriminant) : sqrt(product);
    if (valence > 3) {
        double second = eigenvalue_of_wave(co_cos_pi(4 / n));
        *mu = second > *mu ? second : *mu;
    }
}

/* out [n] = in [n] subdivided once. */
static void subdivide_vector(const co_stam_disc *d, const double *in, double *out) {
    for (int32_t i = 0; i < d->n_points; i++) {
        int32_t r = d->inner[i];
        out[i] = 0;
        for (size_t e = d->refine.start[r]; e < d->refine.start[r + 1]; e++)
            out[i] += d->refine.value[e] * in[d->refine.column[e]];
    }
}

/* The largest eigenvalues of a fan for which no formula is at hand, all real: orthogonal iteration. vectors [2][4][n]
 * is work space. */
static void iterate_eigenvalues(const co_stam_disc *d, double *vectors, double *lambda, double *mu) {
    enum { N_EIGEN = 4, STEPS = 1500 }; /* high valences have theirs close together */
    size_t n = (size_t)d->n_points;
    double value[N_EIGEN] = {0}, *image = vectors + N_EIGEN * n, change = 1;
    for (size_t i = 0; i < N_EIGEN * n; i++) /* of no symmetry */
        vectors[i] = i < n ? 1 : co_sin_pi((double)(i * i % 1009) / 1009);
    for (int step = 0; step < STEPS && change > 1e-14; step++) {
        change = 0;
        for (size_t k = 0; k < N_EIGEN; k++) {
            double *x = vectors + k * n, square = 0;
            subdivide_vector(d, x, image);
            for (size_t j = 0; j < k; j++) {
                double dot = 0;
                for (size_t i = 0; i < n; i++)
                    dot += image[i] * vectors[j * n + i];
                for (size_t i = 0; i < n; i++)
                    image[i] -= dot * vectors[j * n + i];
            }
            for (size_t i = 0; i < n; i++)
                square += image[i] * image[i];
            change = fmax(change, fabs(sqrt(square) - value[k]));
            value[k] = sqrt(square);
            for (size_t i = 0; i < n; i++)
                x[i] = image[i] / value[k];
        }
    }
    from_plane_and_height(value[1], value[2], value[3], lambda, mu);
}

/* Tables of indices, from the disc's mesh; refined [CO_STAM_MOST_ROWS]: the refined points that cells are made of. */
static void place_points(co_stam_disc *d, const curvopt_mesh *mesh, int32_t *refined) {
    for (int32_t s = 0; s < d->valence; s++)
        for (int x = 0; x <= 2; x++)
            for (int y = 0; y <= 2; y++)
                d->inner[co_fan_index(d->fan, s, x, y)] = refined_index(mesh, d->valence, s, x, y);
    row_of(d, d->inner[0], refined);
    for (int c = 0; c < CO_RING_CELLS; c++)
        place_cell(d, mesh, c, refined);
}

/* Takes the vertex' row off the others. */
static void subtract_vertex(const co_stam_disc *d) {
    for (size_t i = 0; i < (size_t)d->n_points; i++)
        for (size_t k = 1, at = i * (size_t)d->n_rows; k < (size_t)d->n_rows; k++)
            d->rows[at + k] -= d->rows[at];
}

/* The vertex' row sums to 1, and a difference of rows to 0. What rounding adds to that sum would stay, while the
 * difference itself shrinks from ring to ring: it is taken back by so much of the vertex' row. */
static void restore_sums(const co_stam_disc *d) {
    const size_t n_rows = (size_t)d->n_rows;
    double sum[CO_STAM_MOST_ROWS] = {0};
    for (size_t i = 0; i < (size_t)d->n_points; i++)
        for (size_t k = 0; k < n_rows; k++)
            sum[k] += d->rows[i * n_rows + k];
    for (size_t i = 0; i < (size_t)d->n_points; i++) {
        double *row = d->rows + i * n_rows;
        row[0] /= sum[0];
        for (size_t k = 1; k < n_rows; k++)
            row[k] -= sum[k] * row[0];
    }
}

/* The rows of ring 1, which one subdivision makes. */
static void fill_rows(const co_stam_disc *d, const int32_t *refined) {
    for (size_t k = 0; k < (size_t)d->n_rows; k++)
        for (size_t e = d->refine.start[refined[k]]; e < d->refine.start[refined[k] + 1]; e++)
            d->rows[(size_t)d->refine.column[e] * (size_t)d->n_rows + k] = d->refine.value[e];
    subtract_vertex(d);
    restore_sums(d);
}

int32_t co_stam_disc_create(int32_t fan, co_stam_disc *d, curvopt_error *error) {
    curvopt_mesh *mesh = NULL, *fine = NULL;
    size_t n = (size_t)co_fan_n_points(fan);
    int32_t refined[CO_STAM_MOST_ROWS] = {0};
    *d = (co_stam_disc){.fan = fan, .valence = co_fan_sectors(fan), .n_points = (int32_t)n, .ring = 1};
    int32_t status = disc_mesh(fan, &mesh, error);
    if (status == CURVOPT_OK)
        status = co_subdivide(mesh, &fine, &d->refine, error);
    if (status != CURVOPT_OK)
        goto done;
    d->inner = CO_NEW(int32_t, n);
    d->rows = CO_NEW(double, n *CO_STAM_MOST_ROWS);
    d->next_rows = CO_NEW(double, n *CO_STAM_MOST_ROWS);
    if (!d->inner || !d->rows || !d->next_rows) {
        status = co_status_no_memory(error);
        goto done;
    }
    place_points(d, mesh, refined);
    fill_rows(d, refined);
    if (co_fan_is_smooth(fan))
        eigenvalues(d->valence, &d->lambda, &d->mu);
    else if (co_fan_type_of(fan) == CO_FAN_CREASE)
        crease_eigenvalues(d->valence, &d->lambda, &d->mu);
    else /* the five vectors of work space fit */
        iterate_eigenvalues(d, d->next_rows, &d->lambda, &d->mu);
done:
    co_mesh_destroy(mesh);
    co_mesh_destroy(fine);
    if (status != CURVOPT_OK)
        co_stam_disc_free(d);
    return status;
}

void co_stam_disc_free(co_stam_disc *d) {
    co_sparse_rows_free(&d->refine);
    free(d->inner);
    free(d->rows);
    free(d->next_rows);
    *d = (co_stam_disc){0};
}

void co_stam_disc_advance(co_stam_disc *d) {
    const size_t n = (size_t)d->n_points, n_rows = (size_t)d->n_rows;
    memset(d->next_rows, 0, n * n_rows * sizeof *d->next_rows);
    for (size_t i = 0; i < n; i++) {
        const double *from = d->rows + i * n_rows;
        const size_t row = (size_t)d->inner[i];
        for (size_t e = d->refine.start[row]; e < d->refine.start[row + 1]; e++) {
            const double value = d->refine.value[e];
            double *to = d->next_rows + (size_t)d->refine.column[e] * n_rows;
            for (size_t k = 0; k < n_rows; k++)
                to[k] += value * from[k];
        }
    }
    double *swap = d->rows;
    d->rows = d->next_rows;
    d->next_rows = swap;
    d->ring++;
    restore_sums(d);
}

void co_stam_disc_cell(const co_stam_disc *d, int cell, double *vertex, double *out) {
    const size_t n = (size_t)d->n_points;
    for (size_t i = 0; i < n; i++) {
        const double *row = d->rows + i * (size_t)d->n_rows;
        vertex[i] = row[0];
        for (size_t k = 0; k < 16; k++) {
            const int32_t point = d->cell[cell][k], mirrored = d->mirrored[cell][k];
            out[k * n + i] = (mirrored < 0 ? 1 : 2) * (point ? row[point] : 0);
            if (mirrored > 0)
                out[k * n + i] -= row[mirrored];
        }
    }
}

void co_stam_disc_limit_mask(co_stam_disc *d, double *mask) {
    enum { DEEP = 120 }; /* the slowest vertices converge like 0.66^n */
    while (d->ring < DEEP)
        co_stam_disc_advance(d);
    for (int32_t i = 0; i < d->n_points; i++) /* the first row is the vertex's */
        mask[i] = d->rows[(size_t)i * (size_t)d->n_rows];
}

void co_stam_limit_masks(int32_t valence, double *masks) {
    int32_t n_points = co_ring_two_ring_size(valence);
    double n = valence, *position = masks, *cosine = masks + n_points, *sine = cosine + n_points;
    double edge = 1 + co_cos_pi(2 / n) + co_cos_pi(1 / n) * sqrt(2 * (9 + co_cos_pi(2 / n)));
    memset(masks, 0, sizeof *masks * 3 * (size_t)n_points);
    position[0] = n / (n + 5);
    for (int32_t s = 0; s < valence; s++) {
        int32_t e = co_ring_two_ring_index(valence, s, 1, 0), f = co_ring_two_ring_index(valence, s, 1, 1);
        double here = 2 * s / n, there = 2 * (s + 1) / n; /* over pi */
        position[e] = 4 / (n * (n + 5));
        position[f] = 1 / (n * (n + 5));
        cosine[e] = edge * co_cos_pi(here);
        cosine[f] = co_cos_pi(here) + co_cos_pi(there);
        sine[e] = edge * co_sin_pi(here);
        sine[f] = co_sin_pi(here) + co_sin_pi(there);
    }
}

int co_stam_in_support(int32_t fan, int32_t i) {
    int32_t n = co_fan_sectors(fan), here = co_fan_sector(fan), next = here + 1, before = here - 1;
    if (i == 0)
        return 1;
    if (!co_fan_is_open(fan)) {
        next %= n;
        before = (before + n) % n;
    }
    int32_t sector = (i - 1) / CO_RING_SECTOR, place = (i - 1) % CO_RING_SECTOR;
    if (place == 0 || place == 2 || sector == here) /* the one-ring, and this sector */
        return 1;
    if (sector == next)
        return place == 1 || place == 3;   /* (0,2) and (-1,2) of this sector */
    return sector == before && place == 4; /* (2,-1) */
}

int co_stam_in_window(int32_t fan, int32_t window, int32_t i) {
    int32_t n = co_fan_sectors(fan), sector = (i - 1) / CO_RING_SECTOR, place = (i - 1) % CO_RING_SECTOR;
    if (i == 0 || n < 2 * window + 4 || (place != 0 && place != 2))
        return 1;
    return sector <= window + (place == 0) || sector >= n - window; /* sector 0 lies between two edges */
}

/* Rotates the average of all sectors, turned back, into each: keeps frequency 1, in which the map lives, and nothing
 * else; rounding would otherwise let the constant, whose eigenvalue is 1, take over. */
static void keep_frequency_one(int32_t valence, double *xy) {
    double mean[CO_RING_SECTOR][2] = {{0}};
    for (int turn = 0; turn < 2; turn++)
        for (int32_t s = 0; s < valence; s++) {
            double c = co_cos_pi(2.0 * s / valence), d = co_sin_pi(2.0 * s / valence);
            for (int i = 0; i < CO_RING_SECTOR; i++) {
                double *p = xy + 2 * (1 + CO_RING_SECTOR * s + i), *m = mean[i];
                if (turn == 0) {
                    m[0] += (c * p[0] + d * p[1]) / valence;
                    m[1] += (c * p[1] - d * p[0]) / valence;
                } else {
                    p[0] = c * m[0] - d * m[1];
                    p[1] = c * m[1] + d * m[0];
                }
            }
        }
    xy[0] = xy[1] = 0;
}

void co_stam_characteristic_map(const co_stam_disc *d, double *xy) {
    enum { STEPS = 100 }; /* other eigenvalues of frequency 1 are below lambda / 1.6 */
    int32_t n = d->n_points;
    for (int32_t i = 0; i < n; i++)
        xy[2 * i] = xy[2 * i + 1] = 0;
    for (int32_t s = 0; s < d->valence; s++)
        for (int x = 0; x <= 2; x++)
            for (int y = 0; y <= 2; y++) {
                double angle = 2 * (s + (x + y > 0 ? (double)y / (x + y) : 0)) / d->valence; /* over pi */
                int32_t i = co_ring_two_ring_index(d->valence, s, x, y);
                xy[2 * i] = (x + y) * co_cos_pi(angle);
                xy[2 * i + 1] = (x + y) * co_sin_pi(angle);
            }
    for (int step = 0; step < STEPS && d->valence > 2; step++) {
        double *image = d->next_rows; /* work space of at least 2 n */
        for (int32_t i = 0; i < n; i++) {
            int32_t r = d->inner[i];
            image[2 * i] = image[2 * i + 1] = 0;
            for (size_t e = d->refine.start[r]; e < d->refine.start[r + 1]; e++) {
                image[2 * i] += d->refine.value[e] * xy[2 * d->refine.column[e]];
                image[2 * i + 1] += d->refine.value[e] * xy[2 * d->refine.column[e] + 1];
            }
        }
        double scale = 1 / co_length(image[2], image[3]); /* point 1 is the first edge point */
        for (int32_t i = 0; i < 2 * n; i++)
            xy[i] = image[i] * scale;
        keep_frequency_one(d->valence, xy);
    }
}

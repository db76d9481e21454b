/* The limit surface near an extraordinary vertex, as rows over its two-ring. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "irregular.h"

#include "memory.h"
#include "refine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const int co_irregular_cell_place[CO_RING_CELLS][2] = {{1, 0}, {1, 1}, {0, 1}};

static const co_real pi = 3.14159265358979323846264338327950288L;

/* The two-ring as an open mesh: four quads a sector, vertices numbered as in ring.h. */
static int32_t disc_mesh(int32_t valence, curvopt_mesh **mesh, curvopt_error *error) {
    int32_t n_faces = 4 * valence, status;
    int32_t *sizes = CO_NEW(int32_t, n_faces), *vertices = CO_NEW(int32_t, 4 * (size_t)n_faces);
    if (!sizes || !vertices) {
        status = co_status_no_memory(error);
        goto done;
    }
    for (int32_t f = 0; f < n_faces; f++) {
        int32_t s = f / 4;
        int x = f % 2, y = f / 2 % 2;
        sizes[f] = 4;
        vertices[4 * f] = co_ring_two_ring_index(valence, s, x, y);
        vertices[4 * f + 1] = co_ring_two_ring_index(valence, s, x + 1, y);
        vertices[4 * f + 2] = co_ring_two_ring_index(valence, s, x + 1, y + 1);
        vertices[4 * f + 3] = co_ring_two_ring_index(valence, s, x, y + 1);
    }
    status = co_mesh_create(co_ring_two_ring_size(valence), n_faces, sizes, vertices, mesh, error);
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

/* Eigenvalues of the one-ring's subdivision, by frequency (Stam 1998; Ball and Storry 1988): for frequency k > 0
 * (5 + c +- sqrt((c + 9)(c + 1))) / 16 with c = cos(2 pi k / N); for k = 0, besides 1, the roots of a quadratic. */
static void eigenvalues(int32_t valence, co_real *lambda, co_real *mu) {
    co_real n = valence, alpha = 1 - 7 / (4 * n), beta = 3 / (2 * n), gamma = 1 / (4 * n);
    co_real half_sum = (alpha - 0.25L) / 2, product = (alpha - beta + gamma) / 16;
    co_real c = cosl(2 * pi / n), discriminant = half_sum * half_sum - product;
    *lambda = (5 + c + sqrtl((c + 9) * (c + 1))) / 16;
    *mu = discriminant > 0 ? half_sum + sqrtl(discriminant) : sqrtl(product);
    if (valence > 3) {
        c = cosl(4 * pi / n);
        co_real second = (5 + c + sqrtl((c + 9) * (c + 1))) / 16;
        *mu = second > *mu ? second : *mu;
    }
}

int32_t co_disc_create(int32_t valence, co_disc *d, curvopt_error *error) {
    curvopt_mesh *mesh = NULL, *fine = NULL;
    size_t n = (size_t)co_ring_two_ring_size(valence);
    *d = (co_disc){.valence = valence, .n_points = (int32_t)n, .ring = 1};
    int32_t status = disc_mesh(valence, &mesh, error);
    if (status == CURVOPT_OK)
        status = co_refine(mesh, &fine, &d->refine, error);
    if (status != CURVOPT_OK)
        goto done;
    d->inner = CO_NEW(int32_t, n);
    d->power = CO_NEW(co_real, n * n);
    d->next_power = CO_NEW(co_real, n * n);
    if (!d->inner || !d->power || !d->next_power) {
        status = co_status_no_memory(error);
        goto done;
    }
    for (int32_t s = 0; s < valence; s++)
        for (int x = 0; x <= 2; x++)
            for (int y = 0; y <= 2; y++)
                d->inner[co_ring_two_ring_index(valence, s, x, y)] = refined_index(mesh, valence, s, x, y);
    for (int c = 0; c < CO_RING_CELLS; c++)
        for (int j = 0; j < 4; j++)
            for (int i = 0; i < 4; i++)
                d->cell[c][4 * j + i] = refined_index(mesh, valence, 0, co_irregular_cell_place[c][0] + i - 1,
                                                      co_irregular_cell_place[c][1] + j - 1);
    for (size_t i = 0; i < n; i++)
        d->power[i * n + i] = 1;
    eigenvalues(valence, &d->lambda, &d->mu);
done:
    co_mesh_destroy(mesh);
    co_mesh_destroy(fine);
    if (status != CURVOPT_OK)
        co_disc_free(d);
    return status;
}

void co_disc_free(co_disc *d) {
    co_rows_free(&d->refine);
    free(d->inner);
    free(d->power);
    free(d->next_power);
    *d = (co_disc){0};
}

/* out [n] = row r of the refinement times the current power. */
static void refined_row(const co_disc *d, int32_t r, co_real *out) {
    size_t n = (size_t)d->n_points;
    memset(out, 0, n * sizeof *out);
    for (size_t e = d->refine.start[r]; e < d->refine.start[r + 1]; e++) {
        const co_real *from = d->power + n * (size_t)d->refine.column[e];
        for (size_t i = 0; i < n; i++)
            out[i] += d->refine.value[e] * from[i];
    }
}

void co_disc_advance(co_disc *d) {
    size_t n = (size_t)d->n_points;
    for (size_t i = 0; i < n; i++)
        refined_row(d, d->inner[i], d->next_power + n * i);
    co_real *swap = d->power;
    d->power = d->next_power;
    d->next_power = swap;
    d->ring++;
}

void co_disc_cell(const co_disc *d, int cell, co_real *out) {
    for (int i = 0; i < 16; i++)
        refined_row(d, d->cell[cell][i], out + (size_t)i * (size_t)d->n_points);
}

void co_irregular_limit_masks(int32_t valence, co_real *masks) {
    int32_t n_points = co_ring_two_ring_size(valence);
    co_real n = valence, *position = masks, *cosine = masks + n_points, *sine = cosine + n_points;
    co_real edge = 1 + cosl(2 * pi / n) + cosl(pi / n) * sqrtl(2 * (9 + cosl(2 * pi / n)));
    memset(masks, 0, sizeof *masks * 3 * (size_t)n_points);
    position[0] = n / (n + 5);
    for (int32_t s = 0; s < valence; s++) {
        int32_t e = co_ring_two_ring_index(valence, s, 1, 0), f = co_ring_two_ring_index(valence, s, 1, 1);
        co_real here = 2 * pi * s / n, there = 2 * pi * (s + 1) / n;
        position[e] = 4 / (n * (n + 5));
        position[f] = 1 / (n * (n + 5));
        cosine[e] = edge * cosl(here);
        cosine[f] = cosl(here) + cosl(there);
        sine[e] = edge * sinl(here);
        sine[f] = sinl(here) + sinl(there);
    }
}

int co_irregular_in_support(int32_t valence, int32_t i) {
    if (i == 0)
        return 1;
    int32_t sector = (i - 1) / CO_RING_SECTOR, place = (i - 1) % CO_RING_SECTOR;
    if (place == 0 || place == 2 || sector == 0) /* the one-ring, and this sector */
        return 1;
    if (sector == 1)
        return place == 1 || place == 3;        /* (0,2) and (-1,2) of sector 0 */
    return sector == valence - 1 && place == 4; /* (2,-1) */
}

/* Rotates the average of all sectors, turned back, into each: keeps frequency 1, in which the map lives, and nothing
 * else; rounding would otherwise let the constant, whose eigenvalue is 1, take over. */
static void keep_frequency_one(int32_t valence, co_real *xy) {
    co_real mean[CO_RING_SECTOR][2] = {{0}};
    for (int turn = 0; turn < 2; turn++)
        for (int32_t s = 0; s < valence; s++) {
            co_real c = cosl(2 * pi * s / valence), d = sinl(2 * pi * s / valence);
            for (int i = 0; i < CO_RING_SECTOR; i++) {
                co_real *p = xy + 2 * (1 + CO_RING_SECTOR * s + i), *m = mean[i];
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

void co_irregular_characteristic_map(const co_disc *d, co_real *xy) {
    enum { STEPS = 100 }; /* other eigenvalues of frequency 1 are below lambda / 1.6 */
    int32_t n = d->n_points;
    for (int32_t i = 0; i < n; i++)
        xy[2 * i] = xy[2 * i + 1] = 0;
    for (int32_t s = 0; s < d->valence; s++)
        for (int x = 0; x <= 2; x++)
            for (int y = 0; y <= 2; y++) {
                co_real angle = 2 * pi * (s + (x + y > 0 ? (co_real)y / (x + y) : 0)) / d->valence;
                int32_t i = co_ring_two_ring_index(d->valence, s, x, y);
                xy[2 * i] = (x + y) * cosl(angle);
                xy[2 * i + 1] = (x + y) * sinl(angle);
            }
    for (int step = 0; step < STEPS; step++) {
        co_real *image = d->next_power; /* work space of at least 2 n */
        for (int32_t i = 0; i < n; i++) {
            int32_t r = d->inner[i];
            image[2 * i] = image[2 * i + 1] = 0;
            for (size_t e = d->refine.start[r]; e < d->refine.start[r + 1]; e++) {
                image[2 * i] += d->refine.value[e] * xy[2 * d->refine.column[e]];
                image[2 * i + 1] += d->refine.value[e] * xy[2 * d->refine.column[e] + 1];
            }
        }
        co_real scale = 1 / hypotl(image[2], image[3]); /* point 1 is the first edge point */
        for (int32_t i = 0; i < 2 * n; i++)
            xy[i] = image[i] * scale;
        keep_frequency_one(d->valence, xy);
    }
}

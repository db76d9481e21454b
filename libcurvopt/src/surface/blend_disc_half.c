/* Wide half discs: where there is room, and where P fits (method: blend_disc_half.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_disc_half.h"

#include "base/elementary.h"
#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/crease.h"
#include "mesh/ring.h"
#include "surface/blend_fit_half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    DISTANCE_PER_WIDTH = 4, /* notes/11-blend-width.md */
    MOST_PARTS = 18         /* points that a limit position is made of: 9, twice with phantoms */
};
/* notes/16-blends-at-boundaries.md. The billionth is for ties of curves whose lengths are round numbers: mirrored half
 * discs differ by rounding. */
static const double LARGEST_MISFIT = 8;               /* in units of the shorter edge at a vertex */
static const double LARGEST_RATIO = 1.8 * (1 + 1e-9); /* longest to shortest edge of the curve */

/* A half disc that is tried. */
typedef struct half_disc {
    int32_t pole; /* half-edge that begins its fan */
    int32_t n_sectors;
    int width;
} half_disc;

typedef struct finder {
    const curvopt_mesh *mesh;
    const uint8_t *kind;
    const double *xyz;
    int32_t *seen;      /* [n_corners] the last pole from whose half-edge each corner was reached */
    int32_t *curve;     /* [n_corners] the last pole on whose curve each corner was found, */
    int32_t *ring;      /* [n_corners] and how many edges from it */
    int32_t *queue;     /* [n_corners] half-edges, one a fan, in the order in which they were reached */
    int32_t *column;    /* [n_points] vertices of the half disc that is tried */
    double (*place)[3]; /* [n_points] their positions */
} finder;

/* --------------------------------------------------------------------------------------- room on the mesh -- */

/* The number of sectors of the fan that h begins, if its vertex is a pole on a curve that can have a half disc; else 0.
 */
static int32_t sectors_of_pole(const finder *f, int32_t h) {
    int32_t first;
    if (f->kind[h] != CO_CORNER_EXTRAORDINARY || !co_crease_is_infinite(co_crease_edge(f->mesh, h)))
        return 0;
    const int32_t fan = co_ring_fan(f->mesh, h, &first), n = co_fan_sectors(fan);
    return first == h && co_fan_type_of(fan) == CO_FAN_CREASE && n > 2 && n <= CO_FAN_MOST_HALF ? n : 0;
}

/* The half-edge of the fan's sector that is `turns` further. */
static int32_t turned(const curvopt_mesh *m, int32_t h, int32_t turns) {
    while (turns-- > 0)
        h = co_mesh_rotate(m, h);
    return h;
}

/* Marks the corners along the curve on either side of the pole, as far as `limit` and as long as it is regular. */
static void mark_curve(finder *f, int32_t pole, int32_t n_sectors, int limit) {
    const curvopt_mesh *m = f->mesh;
    int32_t ahead = pole, back = co_mesh_prev(m, turned(m, pole, n_sectors - 1));
    for (int ring = 1; ring <= limit; ring++) { /* both corners of each vertex */
        const int32_t inner = co_mesh_next(m, ahead);
        if (f->kind[inner] != CO_CORNER_CREASE)
            break;
        ahead = co_blend_disc_further(m, ahead);
        f->curve[inner] = f->curve[ahead] = pole;
        f->ring[inner] = f->ring[ahead] = ring;
    }
    for (int ring = 1; ring <= limit; ring++) {
        if (f->kind[back] != CO_CORNER_CREASE || f->curve[back] == pole)
            break;
        const int32_t outer = m->twin[co_mesh_prev(m, back)];
        f->curve[back] = f->curve[outer] = pole;
        f->ring[back] = f->ring[outer] = ring;
        back = co_mesh_prev(m, outer);
    }
}

/* Reaches the fan of corner g, `ring` rings from the pole; 0 if it is not regular. */
static int reach(finder *f, int32_t g, int32_t pole, int ring, int32_t *n) {
    const curvopt_mesh *m = f->mesh;
    int32_t first = g, sectors = CO_FAN_REGULAR;
    if (f->seen[g] == pole)
        return 1;
    if (f->kind[g] == CO_CORNER_CREASE && f->curve[g] == pole && f->ring[g] == ring)
        sectors = co_fan_sectors(co_ring_fan(m, g, &first));
    else if (f->kind[g] != CO_CORNER_REGULAR)
        return 0;
    f->queue[(*n)++] = first;
    for (int32_t s = 0, h = first; s < sectors; s++, h = co_mesh_rotate(m, h))
        f->seen[h] = pole;
    return 1;
}

/* Rings of faces on the pole's side to the nearest vertex that is not regular, as far as `limit`. */
static int distance_to_others(finder *f, int32_t pole, int32_t n_sectors, int limit) {
    const curvopt_mesh *m = f->mesh;
    int32_t head = 0, n = 0, sectors = n_sectors;
    mark_curve(f, pole, n_sectors, limit);
    f->queue[n++] = pole;
    for (int32_t s = 0, h = pole; s < n_sectors; s++, h = co_mesh_rotate(m, h))
        f->seen[h] = pole;
    for (int ring = 1; ring <= limit; ring++)
        for (int32_t end = n; head < end; head++) {
            int32_t h = f->queue[head];
            if (ring > 1)
                sectors = f->kind[h] == CO_CORNER_CREASE ? 2 : CO_FAN_REGULAR;
            for (int32_t s = 0; s < sectors; s++, h = co_mesh_rotate(m, h))
                for (int32_t k = 0, g = co_mesh_next(m, h); k < 3; k++, g = co_mesh_next(m, g))
                    if (!reach(f, g, pole, ring, &n))
                        return ring;
        }
    return limit;
}

/* Sets the disc of the half disc's faces to `to` where it is `from`; whether it was that on all of them, no face twice.
 */
static int set_faces(const curvopt_mesh *m, const half_disc *d, int32_t from, int32_t to, co_blend_disc_face *face) {
    int all = 1;
    for (int32_t s = 0, h = d->pole; s < d->n_sectors; s++, h = co_mesh_rotate(m, h))
        for (int32_t j = 0, row = h; j < d->width; j++, row = co_blend_disc_beside(m, row))
            for (int32_t i = 0, g = row; i < d->width; i++, g = co_blend_disc_further(m, g)) {
                co_blend_disc_face *at = &face[m->corner_face[g]];
                all &= at->disc == from;
                if (at->disc == from)
                    *at = (co_blend_disc_face){to, g, s, i, j};
            }
    return all;
}

static void list_points(const curvopt_mesh *m, const half_disc *d, int32_t *column) {
    for (int32_t s = 0, h = d->pole; s < d->n_sectors; s++, h = co_mesh_rotate(m, h))
        for (int32_t y = 0, row = h; y <= d->width + 1; y++, row = co_blend_disc_beside(m, row))
            for (int32_t x = 0, g = row; x <= d->width + 1; x++, g = co_blend_disc_further(m, g))
                column[co_blend_fit_half_index(d->width, s, x, y)] = m->corner_vertex[g];
}

/* ---------------------------------------------------------------------------------------- fit of positions -- */

/* A point of the limit surface over a half disc's points. */
typedef struct limit_row {
    int32_t n, index[MOST_PARTS];
    double weight[MOST_PARTS];
} limit_row;

/* The row of the vertex at place (x, y), not both 0. */
static limit_row row_of_vertex(const co_blend_disc_fit *fit, int32_t s, int x, int y) {
    static const double mask[3] = {1 / 6.0, 4 / 6.0, 1 / 6.0};
    limit_row row = {0};
    for (int k = 0; k < 9; k++) {
        double part[2];
        int n =
            co_blend_fit_half_point(fit->valence, fit->width, s, x + k % 3 - 1, y + k / 3 - 1, row.index + row.n, part);
        for (int i = 0; i < n; i++)
            row.weight[row.n++] = mask[k % 3] * mask[k / 3] * part[i];
    }
    return row;
}

static void point_of(const limit_row *row, const double (*place)[3], double at[3]) {
    at[0] = at[1] = at[2] = 0;
    for (int32_t k = 0; k < row->n; k++)
        for (int c = 0; c < 3; c++)
            at[c] += row->weight[k] * place[row->index[k]][c];
}

/* The coefficients of P at the positions, each as it multiplies its function. */
static void coefficients(const finder *f, const co_blend_disc_fit *fit, double p[CO_BLEND_FIT_FUNCTIONS][3]) {
    memset(p, 0, CO_BLEND_FIT_FUNCTIONS * sizeof *p);
    for (int32_t i = 0; i < fit->n_points; i++)
        for (int a = 0; a < CO_BLEND_FIT_FUNCTIONS; a++) {
            const double weight = fit->matrix[a * fit->n_points + i] - (a > 0 ? fit->matrix[i] : 0);
            for (int c = 0; c < 3; c++)
                p[a][c] += weight * f->place[i][c];
        }
}

/* Distance of P from the limit surface at the vertex at place (x, y), in units of its shorter edge further on. */
static double misfit_at(const finder *f, const co_blend_disc_fit *fit, double p[CO_BLEND_FIT_FUNCTIONS][3], int32_t s,
                        int x, int y) {
    const limit_row row = row_of_vertex(fit, s, x, y);
    const double(*place)[3] = (const double(*)[3])f->place;
    double value[CO_BLEND_FIT_FUNCTIONS];
    double chi[2] = {0}, at[3], image[3] = {0};
    for (int32_t k = 0; k < row.n; k++)
        for (int c = 0; c < 2; c++)
            chi[c] += row.weight[k] * fit->map[2 * row.index[k] + c];
    point_of(&row, place, at);
    co_blend_fit_values(chi[0], chi[1], value);
    value[CO_BLEND_FIT_CUSP] = co_power(co_length(chi[0], chi[1]), 3);
    for (int a = 0; a < CO_BLEND_FIT_FUNCTIONS; a++)
        for (int c = 0; c < 3; c++)
            image[c] += value[a] * p[a][c];
    const double *here = place[co_blend_fit_half_index(fit->width, s, x, y)],
                 *right = place[co_blend_fit_half_index(fit->width, s, x + 1, y)],
                 *above = place[co_blend_fit_half_index(fit->width, s, x, y + 1)];
    return co_distance3(image, at) / fmin(co_distance3(here, right), co_distance3(here, above));
}

/* The largest of these, the vertex itself left out, which stays where it is. */
static double misfit(const finder *f, const co_blend_disc_fit *fit) {
    double worst = 0, p[CO_BLEND_FIT_FUNCTIONS][3];
    for (int32_t i = 0; i < fit->n_points; i++)
        memcpy(f->place[i], f->xyz + 3 * (size_t)f->column[i], sizeof *f->place);
    coefficients(f, fit, p);
    for (int32_t s = 0; s < fit->valence; s++)
        for (int y = 0; y <= fit->width; y++)
            for (int x = y == 0; x <= fit->width; x++) {
                const double found = misfit_at(f, fit, p, s, x, y);
                worst = found > worst || isnan(found) ? found : worst; /* NAN, of edges of length 0, stays */
            }
    return worst;
}

/* Whether the edges along the curve are about as long as each other: x is uniform along the curve in every map. */
static int is_even(const finder *f, const half_disc *d) {
    double shortest = INFINITY, longest = 0;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k <= d->width; k++) {
            const int32_t sector = side ? d->n_sectors : 0;
            const int32_t a = f->column[co_blend_fit_half_index(d->width, k ? sector : 0, k, 0)];
            const int32_t b = f->column[co_blend_fit_half_index(d->width, sector, k + 1, 0)];
            const double length = co_distance3(f->xyz + 3 * (size_t)a, f->xyz + 3 * (size_t)b);
            shortest = fmin(shortest, length);
            longest = fmax(longest, length);
        }
    return longest <= LARGEST_RATIO * shortest;
}

/* ------------------------------------------------------------------------------------------------ finding -- */

/* Chooses the steps of the map, and makes the fit: *fit in discs->fit, -1 if none is good enough. Steps are tried from
 * 0 on, as long as they make it better. */
static int32_t choose_fit(finder *f, const half_disc *d, co_blend_discs *discs, int32_t *fit, curvopt_error *error) {
    double best = INFINITY;
    *fit = -1;
    list_points(f->mesh, d, f->column);
    if (!is_even(f, d))
        return CURVOPT_OK;
    for (int steps = 0; steps <= CO_FAN_MOST_STEPS; steps++) {
        const co_blend_disc_fit wanted = {.is_half = 1, .valence = d->n_sectors, .width = d->width, .steps = steps};
        int32_t index, status = co_blend_discs_fit(&wanted, discs, &index, error);
        if (status != CURVOPT_OK)
            return status;
        const double found = misfit(f, &discs->fit[index]);
        if (!(found < best))
            break;
        best = found;
        *fit = best <= LARGEST_MISFIT ? index : -1;
    }
    return CURVOPT_OK;
}

/* Adds the half disc at a pole, of width d->width or the largest power of 2 below that is good. */
static int32_t add_half(finder *f, half_disc *d, co_blend_discs *discs, curvopt_error *error) {
    int32_t fit = -1, status = co_blend_discs_start_faces(f->mesh, discs, error);
    for (; status == CURVOPT_OK && fit < 0 && d->width > 1; d->width /= fit < 0 ? 2 : 1) {
        if (set_faces(f->mesh, d, -1, discs->n_discs, discs->face))
            status = choose_fit(f, d, discs, &fit, error);
        if (fit < 0)
            set_faces(f->mesh, d, discs->n_discs, -1, discs->face);
    }
    if (status != CURVOPT_OK || fit < 0)
        return status;
    status = co_blend_discs_add_of_fit(fit, discs, error);
    if (status == CURVOPT_OK)
        list_points(f->mesh, d, discs->column + discs->disc[discs->n_discs - 1].column);
    return status;
}

/* The largest power of 2 that is not above. */
static int power_of_2(int width) {
    int power = 1;
    while (2 * power <= width)
        power *= 2;
    return power;
}

static int32_t find(finder *f, int widest, co_blend_discs *discs, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    for (int32_t h = 0; h < f->mesh->info.n_corners; h++)
        f->seen[h] = f->curve[h] = -1;
    for (int32_t h = 0; status == CURVOPT_OK && h < f->mesh->info.n_corners; h++) {
        half_disc d = {.pole = h, .n_sectors = sectors_of_pole(f, h)};
        if (d.n_sectors == 0)
            continue;
        d.width = power_of_2(distance_to_others(f, h, d.n_sectors, DISTANCE_PER_WIDTH * widest) / DISTANCE_PER_WIDTH);
        if (d.width > 1)
            status = add_half(f, &d, discs, error);
    }
    return status;
}

int32_t co_blend_disc_half_find(const curvopt_mesh *m, const uint8_t *kind, const double *xyz, int widest,
                                co_blend_discs *discs, curvopt_error *error) {
    const size_t n = (size_t)m->info.n_corners,
                 n_points = (size_t)co_blend_fit_half_n_points(CO_FAN_MOST_HALF, CO_BLEND_DISC_LARGEST);
    finder f = {.mesh = m,
                .kind = kind,
                .xyz = xyz,
                .seen = CO_NEW(int32_t, n),
                .curve = CO_NEW(int32_t, n),
                .ring = CO_NEW(int32_t, n),
                .queue = CO_NEW(int32_t, n),
                .column = CO_NEW(int32_t, n_points),
                .place = co_memory_zeroed(n_points, sizeof *f.place)};
    int32_t status = f.seen && f.curve && f.ring && f.queue && f.column && f.place ? find(&f, widest, discs, error)
                                                                                   : co_status_no_memory(error);
    free(f.seen);
    free(f.curve);
    free(f.ring);
    free(f.queue);
    free(f.column);
    free(f.place);
    if (status != CURVOPT_OK)
        co_blend_discs_free(discs);
    return status;
}

/* The number of the next half disc from k on. */
static int32_t next_half(const co_blend_discs *discs, int32_t k) {
    while (k < discs->n_discs && !co_blend_disc_fit_of(discs, &discs->disc[k])->is_half)
        k++;
    return k;
}

int co_blend_disc_half_are_same(const co_blend_discs *a, const co_blend_discs *b) {
    int32_t i = next_half(a, 0), j = next_half(b, 0);
    for (; i < a->n_discs && j < b->n_discs; i = next_half(a, i + 1), j = next_half(b, j + 1)) {
        const co_blend_disc_fit *f = co_blend_disc_fit_of(a, &a->disc[i]), *g = co_blend_disc_fit_of(b, &b->disc[j]);
        if (f->width != g->width || f->steps != g->steps ||
            a->column[a->disc[i].column] != b->column[b->disc[j].column])
            return 0;
    }
    return i == a->n_discs && j == b->n_discs;
}

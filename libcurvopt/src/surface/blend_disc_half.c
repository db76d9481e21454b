/* Wide half discs: where there is room, and where P fits (method: blend_disc_half.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_disc_half.h"

#include "base/memory.h"
#include "mesh/ring.h"
#include "surface/blend_fit_half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DISTANCE_PER_WIDTH = 4 /* notes/11-blend-width.md */ };
static double LARGEST_MISFIT = 0.1; /* notes/16-blends-at-boundaries.md */

typedef struct finder {
    const curvopt_mesh *mesh;
    const uint8_t *kind;
    const double *xyz;
    int32_t *seen;  /* [n_corners] the last pole from whose half-edge each corner was reached */
    int32_t *curve; /* [n_corners] the last pole on whose curve each corner was found, */
    int32_t *ring;  /* [n_corners] and how many edges from it */
    int32_t *queue; /* [n_corners] half-edges, one a fan, in the order in which they were reached */
    int32_t *column;
    double (*place)[3]; /* [n_points] of a disc */
} finder;

/* --------------------------------------------------------------------------------------- room on the mesh -- */

/* Whether h begins the fan of a pole on a curve that can have a half disc. */
static int32_t sectors_of_pole(const finder *f, int32_t h) {
    int32_t first;
    if (f->kind[h] != CO_CORNER_EXTRAORDINARY)
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

/* Marks the half disc's faces; 0, and none marked, if it would meet itself. */
static int mark_faces(const curvopt_mesh *m, int32_t pole, int32_t n_sectors, int width, int32_t disc,
                      co_blend_disc_face *face) {
    int fits = 1;
    for (int pass = 0; pass < 2 && (pass == 0 || !fits); pass++)
        for (int32_t s = 0, h = pole; s < n_sectors; s++, h = co_mesh_rotate(m, h))
            for (int32_t j = 0, row = h; j < width; j++, row = co_blend_disc_beside(m, row))
                for (int32_t i = 0, g = row; i < width; i++, g = co_blend_disc_further(m, g)) {
                    co_blend_disc_face *at = &face[m->corner_face[g]];
                    fits &= pass > 0 || at->disc < 0;
                    if (pass == 0 && at->disc < 0)
                        *at = (co_blend_disc_face){disc, g, s, i, j};
                    else if (pass > 0 && at->disc == disc)
                        at->disc = -1;
                }
    return fits;
}

static void list_points(const curvopt_mesh *m, int32_t pole, int32_t n_sectors, int width, int32_t *column) {
    for (int32_t s = 0, h = pole; s < n_sectors; s++, h = co_mesh_rotate(m, h))
        for (int32_t y = 0, row = h; y <= width + 1; y++, row = co_blend_disc_beside(m, row))
            for (int32_t x = 0, g = row; x <= width + 1; x++, g = co_blend_disc_further(m, g))
                column[co_blend_fit_half_index(width, s, x, y)] = m->corner_vertex[g];
}

/* ----------------------------------------------------------------------------------------- fit of positions -- */

/* Point (x, y) of the limit surface, of points with dim coordinates each. */
static void limit_point(const co_blend_disc_fit *fit, int32_t s, int x, int y, const double (*place)[3], double at[3]) {
    static const double mask[3] = {1 / 6.0, 4 / 6.0, 1 / 6.0};
    const int on_curve = (s == 0 && y == 0) || (s == fit->valence - 1 && x == 0);
    at[0] = at[1] = at[2] = 0;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            int32_t index[2];
            co_real part[2];
            double weight = mask[i + 1] * mask[j + 1];
            if (x == 0 && y == 0) { /* along the curve */
                if (i && j)
                    continue;
                const int end = i ? i : j;
                weight = i == 0 && j == 0 ? mask[1] : i == 0 ? 0 : mask[0];
                index[0] = end == 0 ? 0 : co_blend_fit_half_index(fit->width, end > 0 ? 0 : fit->valence, 1, 0);
                for (int c = 0; c < 3; c++)
                    at[c] += weight * place[index[0]][c];
                continue;
            }
            const int n = co_blend_fit_half_point(fit->valence, fit->width, s, x + i, y + j, index, part);
            for (int k = 0; k < n; k++)
                for (int c = 0; c < 3; c++)
                    at[c] += weight * (double)part[k] * place[index[k]][c];
        }
    (void)on_curve;
}

static double distance(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* The largest distance of P from the limit surface at the disc's vertices, in units of the shortest edge there. */
static double misfit(const finder *f, const co_blend_disc_fit *fit, const co_real *map) {
    double worst = 0, p[CO_BLEND_FIT_FUNCTIONS][3] = {{0}};
    for (int32_t i = 0; i < fit->n_points; i++)
        for (int c = 0; c < 3; c++) {
            f->place[i][c] = f->xyz[3 * (size_t)f->column[i] + (size_t)c];
            for (int a = 0; a < CO_BLEND_FIT_FUNCTIONS; a++)
                p[a][c] += (fit->matrix[a * fit->n_points + i] - (a ? fit->matrix[i] : 0)) * f->place[i][c];
        }
    double(*flat)[3] = f->place + fit->n_points;
    for (int32_t i = 0; i < fit->n_points; i++)
        for (int c = 0; c < 3; c++)
            flat[i][c] = c < 2 ? (double)map[2 * i + c] : 0;
    const double(*place)[3] = (const double(*)[3])f->place, (*chi)[3] = (const double(*)[3])flat;
    for (int32_t s = 0; s < fit->valence; s++)
        for (int y = 0; y <= fit->width; y++)
            for (int x = 0; x <= fit->width; x++) {
                double at[3], over[3], image[3] = {0}, edge = INFINITY;
                co_real value[CO_BLEND_FIT_FUNCTIONS];
                limit_point(fit, s, x, y, place, at);
                limit_point(fit, s, x, y, chi, over);
                co_blend_fit_values(over[0], over[1], value);
                value[CO_BLEND_FIT_CUSP] = pow(hypot(over[0], over[1]), 3);
                for (int a = 0; a < CO_BLEND_FIT_FUNCTIONS; a++)
                    for (int c = 0; c < 3; c++)
                        image[c] += (double)value[a] * p[a][c];
                const int32_t here = co_blend_fit_half_index(fit->width, s, x, y);
                const int32_t right = co_blend_fit_half_index(fit->width, s, x + 1, y);
                const int32_t above = co_blend_fit_half_index(fit->width, s, x, y + 1);
                edge = fmin(distance(place[here], place[right]), distance(place[here], place[above]));
                worst = fmax(worst, distance(image, at) / edge);
            }
    return worst;
}

/* ---------------------------------------------------------------------------------------------------- finding -- */

static void unmark_faces(const finder *f, int32_t disc, co_blend_disc_face *face) {
    for (int32_t i = 0; i < f->mesh->info.n_faces; i++)
        face[i].disc = face[i].disc == disc ? -1 : face[i].disc;
}

/* Adds the half disc at a pole, as wide as it can be. */
static int32_t add_half(finder *f, int32_t pole, int32_t n, int width, co_blend_discs *discs, curvopt_error *error) {
    int32_t best_fit = -1, status = co_blend_discs_start_faces(f->mesh, discs, error);
    for (; status == CURVOPT_OK && width > 1; width /= 2) {
        double best = INFINITY;
        if (!mark_faces(f->mesh, pole, n, width, discs->n_discs, discs->face))
            continue;
        list_points(f->mesh, pole, n, width, f->column);
        for (int steps = 0; status == CURVOPT_OK && steps <= CO_FAN_MOST_STEPS; steps++) {
            int32_t fit;
            co_blend_fit map;
            const co_blend_disc_fit wanted = {.is_half = 1, .valence = n, .width = width, .steps = steps};
            const co_blend_fit_half_kind half = {n, width, steps};
            status = co_blend_discs_fit(&wanted, discs, &fit, error);
            if (status == CURVOPT_OK)
                status = co_blend_fit_create_half_map(&half, &map, error);
            if (status != CURVOPT_OK)
                return status;
            double found = misfit(f, &discs->fit[fit], map.map);
            co_blend_fit_free(&map);
            if (getenv("CO_MISFIT")) {
                LARGEST_MISFIT = atof(getenv("CO_MISFIT"));
                extern int printf(const char *, ...);
                printf("pole %d n %d width %d steps %d misfit %g\n", f->mesh->corner_vertex[pole], n, width, steps, found);
            }
            if (getenv("CO_STEPS") && atoi(getenv("CO_STEPS")) != steps)
                continue;
            if (found < best) {
                best = found;
                best_fit = fit;
            }
        }
        if (best <= LARGEST_MISFIT)
            break;
        unmark_faces(f, discs->n_discs, discs->face);
    }
    if (status != CURVOPT_OK || width < 2)
        return status;
    status = co_blend_discs_add_of_fit(best_fit, discs, error);
    if (status == CURVOPT_OK)
        list_points(f->mesh, pole, n, width, discs->column + discs->disc[discs->n_discs - 1].column);
    return status;
}

/* The largest power of 2 that is not above. */
static int power_of_2(int width) {
    int power = 1;
    while (2 * power <= width)
        power *= 2;
    return power;
}

int32_t co_blend_disc_half_find(const curvopt_mesh *m, const uint8_t *kind, const double *xyz, int widest,
                                co_blend_discs *discs, curvopt_error *error) {
    const int32_t n = m->info.n_corners;
    finder f = {m,
                kind,
                xyz,
                CO_NEW(int32_t, n),
                CO_NEW(int32_t, n),
                CO_NEW(int32_t, n),
                CO_NEW(int32_t, n),
                CO_NEW(int32_t, 10000),
                co_memory_zeroed(20000, sizeof *f.place)};
    int32_t status =
        f.seen && f.curve && f.ring && f.queue && f.column && f.place ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t h = 0; status == CURVOPT_OK && h < n; h++)
        f.seen[h] = f.curve[h] = -1;
    for (int32_t h = 0; status == CURVOPT_OK && h < n; h++) {
        const int32_t sectors = sectors_of_pole(&f, h);
        if (sectors == 0)
            continue;
        const int width = distance_to_others(&f, h, sectors, DISTANCE_PER_WIDTH * widest) / DISTANCE_PER_WIDTH;
        if (width > 1)
            status = add_half(&f, h, sectors, power_of_2(width), discs, error);
    }
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

/* Wide blends round extraordinary vertices: where there is room, and their coefficients (method: blend_disc.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/blend_disc.h"

#include "base/memory.h"
#include "mesh/ring.h"
#include "surface/blend_fit_half.h"

#include <stdlib.h>
#include <string.h>

enum {
    TERMS = CO_BLEND_DISC_TERMS,
    FIT = CO_BLEND_FIT_TERMS,
    DISTANCE_PER_WIDTH = 4, /* notes/11-blend-width.md */
    LEAST_VALENCE = 8       /* 2 N + 8 and 21 coefficients are fewer points than 6 N + 1 */
};

int32_t co_blend_disc_least_valence(int32_t surface) {
    return surface == CURVOPT_SURFACE_POLYNOMIAL ? LEAST_VALENCE
           : surface == CURVOPT_SURFACE_LIMIT    ? CO_BLEND_FIT_UNRESOLVED
                                                 : CO_FAN_MAX;
}

void co_blend_discs_free(co_blend_discs *discs) {
    for (int32_t i = 0; i < discs->n_fits; i++) {
        free(discs->fit[i].map);
        free(discs->fit[i].matrix);
        free(discs->fit[i].turn);
    }
    free(discs->fit);
    free(discs->disc);
    free(discs->column);
    free(discs->face);
    *discs = (co_blend_discs){0};
}

/* ----------------------------------------------------------------------------------------------- finding -- */

typedef struct finder {
    const curvopt_mesh *mesh;
    const uint8_t *kind;
    int32_t *seen;  /* [n_vertices] the last vertex from which each was reached */
    int32_t *queue; /* [n_vertices] vertices in the order in which they were reached */
} finder;

/* Whether v is the smooth vertex of a closed fan of quads, but not of four; two have no characteristic map. */
static int is_extraordinary(const finder *f, int32_t v) {
    int32_t h = f->mesh->vertex_corner[v], first;
    return h >= 0 && f->kind[h] == CO_CORNER_EXTRAORDINARY && f->mesh->valence[v] > 2 &&
           co_fan_type_of(co_ring_fan(f->mesh, h, &first)) == CO_FAN_CLOSED;
}

/* Rings of faces from v to the nearest other vertex that is not regular, as far as `limit`. */
static int distance_to_others(const finder *f, int32_t v, int limit) {
    const curvopt_mesh *m = f->mesh;
    int32_t head = 0, n = 0;
    f->seen[v] = v;
    f->queue[n++] = v;
    for (int ring = 1; ring <= limit; ring++)
        for (int32_t end = n; head < end; head++) {
            int32_t first = m->vertex_corner[f->queue[head]], h = first;
            do { /* round a vertex with a closed fan of quads */
                for (int32_t k = 0, g = co_mesh_next(m, h); k < 3; k++, g = co_mesh_next(m, g)) {
                    int32_t to = m->corner_vertex[g];
                    if (f->seen[to] == v)
                        continue;
                    if (f->kind[m->vertex_corner[to]] != CO_CORNER_REGULAR)
                        return ring;
                    f->seen[to] = v;
                    f->queue[n++] = to;
                }
                h = co_mesh_rotate(m, h);
            } while (h != first);
        }
    return limit;
}

/* Marks the disc's faces; 0, and none marked, if it would meet itself, as round a thin tube. */
static int mark_faces(const curvopt_mesh *m, int32_t v, int width, int32_t disc, co_blend_disc_face *face) {
    int32_t h = m->vertex_corner[v];
    int fits = 1;
    for (int pass = 0; pass < 2 && (pass == 0 || !fits); pass++)
        for (int32_t s = 0; s < m->valence[v]; s++, h = co_mesh_rotate(m, h))
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

static void list_points(const curvopt_mesh *m, int32_t v, int width, int32_t *column) {
    int32_t h = m->vertex_corner[v], valence = m->valence[v];
    column[0] = v;
    for (int32_t s = 0; s < valence; s++, h = co_mesh_rotate(m, h))
        for (int32_t y = 0, row = h; y <= width + 1; y++, row = co_blend_disc_beside(m, row))
            for (int32_t x = 1, g = co_blend_disc_further(m, row); x <= width + 1; x++, g = co_blend_disc_further(m, g))
                column[co_blend_fit_index(valence, width, s, x, y)] = m->corner_vertex[g];
}

/* ------------------------------------------------------------------------------------------------- fits -- */

static void fill_turns(co_blend_disc_fit *f) {
    double turn[FIT][FIT];
    for (int32_t s = 0; s < f->n_sets; s++) {
        double *to = f->turn + (size_t)s * TERMS * TERMS;
        co_blend_fit_turn(f->valence, s, turn);
        to[0] = 1;
        for (int a = 1; a < FIT; a++) { /* q_a = c_0 + c_a, and c_0 does not turn */
            double sum = 0;
            for (int b = 1; b < FIT; b++) {
                to[a * TERMS + b] = turn[a][b];
                sum += turn[a][b];
            }
            to[a * TERMS] = (1 - sum);
        }
        for (int a = FIT; a < TERMS; a++)
            to[a * TERMS + a] = 1;
    }
}

static int32_t create_polynomial(const co_blend_disc_fit *f, co_blend_fit *out, curvopt_error *error) {
    co_stam_disc disc = {0};
    const co_blend_fit_half_kind half = {f->valence, f->width, f->steps};
    if (f->is_half)
        return co_blend_fit_create_half(&half, out, error);
    int32_t status = co_stam_disc_create(f->valence, &disc, error);
    if (status == CURVOPT_OK)
        status = co_blend_fit_create(&disc, f->width, out, error);
    co_stam_disc_free(&disc);
    return status;
}

/* The rows of P's coefficients. */
static int32_t fill_polynomial(co_blend_disc_fit *f, curvopt_error *error) {
    co_blend_fit polynomial = {0};
    int32_t status = create_polynomial(f, &polynomial, error);
    const int n_terms = f->is_half ? CO_BLEND_FIT_FUNCTIONS : FIT;
    for (int32_t i = 0; status == CURVOPT_OK && i < f->n_points; i++)
        for (int a = 0; a < n_terms; a++)
            f->matrix[a * f->n_points + i] = (polynomial.fit[a * f->n_points + i] + (a > 0 ? polynomial.fit[i] : 0));
    for (int32_t i = 0; status == CURVOPT_OK && f->map && i < 2 * f->n_points; i++)
        f->map[i] = polynomial.map[i];
    co_blend_fit_free(&polynomial);
    return status;
}

/* The rows of the means of width 1, whose points are those of the two-ring (fan.h). */
static void fill_means(co_blend_disc_fit *f) {
    for (int32_t s = 0; f->width == 1 && s < f->valence; s++) {
        const int32_t edge = co_fan_index(f->valence, s, 1, 0), face = co_fan_index(f->valence, s, 1, 1);
        f->matrix[CO_BLEND_DISC_EDGE_MEAN * f->n_points + edge] = 1.0 / f->valence;
        f->matrix[CO_BLEND_DISC_FACE_MEAN * f->n_points + face] = 1.0 / f->valence;
    }
}

static int32_t fill_fit(co_blend_disc_fit *f, curvopt_error *error) {
    f->n_points =
        f->is_half ? co_blend_fit_half_n_points(f->valence, f->width) : co_blend_fit_n_points(f->valence, f->width);
    f->n_sets = f->is_half ? 1 : f->valence;
    f->map = f->is_half ? CO_NEW(double, 2 * (size_t)f->n_points) : NULL;
    f->matrix = CO_NEW(double, TERMS *(size_t)f->n_points);
    f->turn = CO_NEW(double, (size_t)f->n_sets *TERMS *TERMS);
    if (!f->matrix || !f->turn || (f->is_half && !f->map))
        return co_status_no_memory(error);
    fill_means(f);
    fill_turns(f);
    return fill_polynomial(f, error);
}

int32_t co_blend_discs_fit(const co_blend_disc_fit *wanted, co_blend_discs *discs, int32_t *index,
                           curvopt_error *error) {
    for (*index = 0; *index < discs->n_fits; ++*index) {
        const co_blend_disc_fit *at = &discs->fit[*index];
        if (at->is_half == wanted->is_half && at->steps == wanted->steps && at->valence == wanted->valence &&
            at->width == wanted->width)
            return CURVOPT_OK;
    }
    co_blend_disc_fit *fit = CO_RESIZED(discs->fit, (size_t)discs->n_fits + 1);
    if (!fit)
        return co_status_no_memory(error);
    discs->fit = fit;
    fit[discs->n_fits] = (co_blend_disc_fit){
        .is_half = wanted->is_half, .steps = wanted->steps, .valence = wanted->valence, .width = wanted->width};
    return fill_fit(&fit[discs->n_fits++], error);
}

int32_t co_blend_discs_add_of_fit(int32_t fit, co_blend_discs *discs, curvopt_error *error) {
    co_blend_disc *disc = CO_RESIZED(discs->disc, (size_t)discs->n_discs + 1);
    if (disc)
        discs->disc = disc;
    const size_t more = discs->n_columns + (size_t)discs->fit[fit].n_points;
    int32_t *column = CO_RESIZED(discs->column, more);
    if (column)
        discs->column = column;
    if (!disc || !column)
        return co_status_no_memory(error);
    disc[discs->n_discs++] =
        (co_blend_disc){.fit = fit, .first_point = discs->n_points, .column = discs->n_columns, .is_used = 1};
    discs->n_points += TERMS * discs->fit[fit].n_sets;
    discs->n_columns = more;
    return CURVOPT_OK;
}

int32_t co_blend_discs_add(int32_t valence, int width, co_blend_discs *discs, curvopt_error *error) {
    const co_blend_disc_fit wanted = {.valence = valence, .width = width};
    int32_t fit, status = co_blend_discs_fit(&wanted, discs, &fit, error);
    return status == CURVOPT_OK ? co_blend_discs_add_of_fit(fit, discs, error) : status;
}

int32_t co_blend_discs_start_faces(const curvopt_mesh *m, co_blend_discs *discs, curvopt_error *error) {
    if (discs->face)
        return CURVOPT_OK;
    discs->face = CO_NEW(co_blend_disc_face, m->info.n_faces);
    if (!discs->face)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < m->info.n_faces; i++)
        discs->face[i].disc = -1;
    return CURVOPT_OK;
}

/* Adds the disc round v, of that width or as wide as it can be without meeting itself. */
static int32_t add_wide(const curvopt_mesh *m, int32_t v, int width, co_blend_discs *discs, curvopt_error *error) {
    int32_t status = co_blend_discs_start_faces(m, discs, error);
    while (status == CURVOPT_OK && width > 1 && !mark_faces(m, v, width, discs->n_discs, discs->face))
        width--;
    if (status != CURVOPT_OK || width == 1)
        return status;
    status = co_blend_discs_add(m->valence[v], width, discs, error);
    if (status == CURVOPT_OK)
        list_points(m, v, width, discs->column + discs->disc[discs->n_discs - 1].column);
    return status;
}

int32_t co_blend_discs_find(const curvopt_mesh *m, const uint8_t *kind, int widest, co_blend_discs *discs,
                            curvopt_error *error) {
    int32_t n = m->info.n_vertices, status = CURVOPT_OK;
    finder f = {m, kind, CO_NEW(int32_t, n), CO_NEW(int32_t, n)};
    *discs = (co_blend_discs){0};
    if (!f.seen || !f.queue)
        status = co_status_no_memory(error);
    for (int32_t v = 0; status == CURVOPT_OK && v < n; v++)
        f.seen[v] = -1;
    for (int32_t v = 0; status == CURVOPT_OK && v < n; v++) {
        int width =
            is_extraordinary(&f, v) ? distance_to_others(&f, v, DISTANCE_PER_WIDTH * widest) / DISTANCE_PER_WIDTH : 1;
        if (width > 1)
            status = add_wide(m, v, width, discs, error);
    }
    free(f.seen);
    free(f.queue);
    if (status != CURVOPT_OK)
        co_blend_discs_free(discs);
    return status;
}

/* ----------------------------------------------------------------------------------------------- points -- */

/* out += the coefficients of a sector from those of sector 0; with `back` the transpose, for gradients. */
static void turn_points(const double *turn, int back, double in[TERMS][3], double out[TERMS][3]) {
    for (int a = 0; a < TERMS; a++)
        for (int b = 0; b < TERMS; b++)
            for (int c = 0; c < 3; c++)
                out[a][c] += (back ? turn[b * TERMS + a] : turn[a * TERMS + b]) * in[b][c];
}

void co_blend_discs_apply(const co_blend_discs *discs, double *points) {
    for (int32_t k = 0; k < discs->n_discs; k++) {
        const co_blend_disc *d = &discs->disc[k];
        const co_blend_disc_fit *f = co_blend_disc_fit_of(discs, d);
        double first[TERMS][3] = {{0}};
        if (!d->is_used)
            continue;
        for (int a = 0; a < TERMS; a++)
            for (int32_t i = 0; i < f->n_points; i++) {
                const double *x = points + 3 * (size_t)discs->column[d->column + (size_t)i];
                for (int c = 0; c < 3; c++)
                    first[a][c] += f->matrix[a * f->n_points + i] * x[c];
            }
        for (int32_t s = 0; s < f->n_sets; s++) {
            double sector[TERMS][3] = {{0}};
            turn_points(f->turn + (size_t)s * TERMS * TERMS, 0, first, sector);
            memcpy(points + 3 * (size_t)(d->first_point + TERMS * s), sector, sizeof sector);
        }
    }
}

void co_blend_discs_add_transposed(const co_blend_discs *discs, int32_t n_cage, double *point_gradient,
                                   double *gradient) {
    for (int32_t k = 0; k < discs->n_discs; k++) {
        const co_blend_disc *d = &discs->disc[k];
        const co_blend_disc_fit *f = co_blend_disc_fit_of(discs, d);
        double first[TERMS][3] = {{0}}, sector[TERMS][3];
        if (!d->is_used)
            continue;
        for (int32_t s = 0; s < f->n_sets; s++) {
            memcpy(sector, point_gradient + 3 * (size_t)(d->first_point + TERMS * s), sizeof sector);
            turn_points(f->turn + (size_t)s * TERMS * TERMS, 1, sector, first);
        }
        for (int32_t i = 0; i < f->n_points; i++) {
            int32_t point = discs->column[d->column + (size_t)i];
            double *to = (point < n_cage ? gradient : point_gradient) + 3 * (size_t)point;
            for (int a = 0; a < TERMS; a++)
                for (int c = 0; c < 3; c++)
                    to[c] += f->matrix[a * f->n_points + i] * first[a][c];
        }
    }
}

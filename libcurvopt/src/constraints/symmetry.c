/* Search for a cage's symmetries.
 *
 * An automorphism of a connected cage is given by where it takes one corner, and whether it mirrors: the rest follows
 * from edge to edge. So all of them are found by trying the images of one corner that has few candidates. What remains
 * is geometry: the motion that fits best, and how well.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/symmetry.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/value_images.h"
#include "linalg/small_dense.h"
#include "mesh/crease.h"
#include "mesh/similarity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LARGEST_ORDER = CURVOPT_MAX_SYMMETRIES,
    UNSET = -1
}; /* elements of the largest group that is kept; no other number was tried */
/* Tolerance down to which a group is looked for: rounding of positions leaves some 1e-15 of the radius. */
static const double LEAST_TOLERANCE = 1e-12;

/* The search. */
typedef struct search {
    const curvopt_mesh *mesh;
    double centroid[3], radius; /* the frame of x */
    const co_constraints *constraints;
    co_value_index held, drawn; /* of the constraints' values */
    double *x;                  /* [3 n_vertices] centroid 0, radius 1 */
    double *length;             /* [n_vertices] |x| */
    int32_t *queue;             /* [n_corners] */
    uint8_t *taken;             /* [n_corners] whether the map that is made has it as an image */
    int with_mirrors;
    int32_t seed;   /* corner whose images are tried */
    int32_t *start; /* [n_starts] a corner of each part that hangs together by edges; room for n_corners */
    int32_t n_starts;
    double tolerance;  /* length, at radius 1 */
    co_symmetry found; /* room for LARGEST_ORDER elements, one more than is used */
    int32_t room;      /* elements that there is room for; maps of those that were not found are UNSET */
    co_cancel *cancel; /* may be NULL */
} search;

static int32_t *map_of(const search *s, int32_t g) {
    return s->found.corner + (size_t)g * (size_t)s->found.n_corners;
}

static void forget_map(const search *s, int32_t g) {
    for (int32_t h = 0; h < s->found.n_corners; h++)
        map_of(s, g)[h] = UNSET;
    memset(s->taken, 0, (size_t)s->found.n_corners);
}

static int32_t grow(search *s, curvopt_error *error) {
    co_symmetry *f = &s->found;
    int32_t room = s->room ? 2 * s->room : 4;
    size_t n = (size_t)f->n_corners, used = (size_t)f->order;
    co_symmetry next = {.order = f->order,
                        .n_corners = f->n_corners,
                        .corner = CO_NEW(int32_t, (size_t)room * n),
                        .mirrored = CO_NEW(uint8_t, room),
                        .matrix = CO_NEW(double, 9 * (size_t)room)};
    if (!next.corner || !next.mirrored || !next.matrix) {
        co_symmetry_free(&next);
        return co_status_no_memory(error);
    }
    if (used) {
        memcpy(next.corner, f->corner, used * n * sizeof(int32_t));
        memcpy(next.mirrored, f->mirrored, used);
        memcpy(next.matrix, f->matrix, used * 9 * sizeof(double));
    }
    co_symmetry_free(f);
    *f = next;
    s->room = room;
    for (int32_t g = f->order; g < room; g++)
        forget_map(s, g);
    return CURVOPT_OK;
}

/* ------------------------------------------------------------------------------------------- combinatorics -- */

/* Whether the motion takes vertex v to vertex w. */
static int goes_to(const search *s, const double matrix[9], int32_t v, int32_t w) {
    double at[3];
    co_small_dense_apply_3(matrix, s->x + 3 * (size_t)v, at);
    return co_distance3(at, s->x + 3 * (size_t)w) <= s->tolerance;
}

/* The image of a half-edge whose corner goes to `to`. A mirrored face runs the other way round, so that the edge that
 * left the corner is the one that arrives there:
 *
 *     corner h, edge h --->      not mirrored: to, edge to --->      mirrored: <--- edge prev(to), to */
static int32_t image_of_edge(const curvopt_mesh *m, int32_t to, int mirrored) {
    return mirrored ? co_mesh_prev(m, to) : to;
}

static int leaves_out(const search *s, int32_t h) {
    return s->constraints->left_out ? s->constraints->left_out[s->mesh->corner_face[h]] : 0;
}

/* Whether corner h could go to `to`, by valence, lengths, creases and constraints there. */
static int may_go(const search *s, int32_t h, int32_t to, int mirrored) {
    const curvopt_mesh *m = s->mesh;
    int32_t v = m->corner_vertex[h], w = m->corner_vertex[to], edge = image_of_edge(m, to, mirrored);
    int32_t v_next = co_mesh_destination(m, h), w_next = m->corner_vertex[mirrored ? edge : co_mesh_next(m, to)];
    return m->valence[v] == m->valence[w] &&
           co_mesh_face_size(m, m->corner_face[h]) == co_mesh_face_size(m, m->corner_face[to]) &&
           (m->twin[h] < 0) == (m->twin[edge] < 0) && leaves_out(s, h) == leaves_out(s, to) &&
           fabs(s->length[v] - s->length[w]) <= s->tolerance &&
           fabs(co_distance3(s->x + 3 * (size_t)v, s->x + 3 * (size_t)v_next) -
                co_distance3(s->x + 3 * (size_t)w, s->x + 3 * (size_t)w_next)) <= 2 * s->tolerance &&
           co_crease_alike(co_crease_edge(m, h), co_crease_edge(m, edge)) &&
           co_crease_alike(co_crease_vertex(m, v), co_crease_vertex(m, w)) &&
           (!s->constraints->freedom || (s->constraints->freedom[v] == s->constraints->freedom[w] &&
                                         s->constraints->of_limit[v] == s->constraints->of_limit[w])) &&
           co_soft_constraints_alike(&s->constraints->springs, v, w);
}

/* Maps corner h to a corner that is no image yet, if it may go there; whether it does. */
static int map_corner(search *s, int32_t h, int32_t to, int mirrored, int32_t *map, int32_t *n) {
    if (s->taken[to] || !may_go(s, h, to, mirrored))
        return 0;
    map[h] = to;
    s->taken[to] = 1;
    s->queue[(*n)++] = h;
    return 1;
}

/* Follows corner h -> to over its component; s->queue [the number returned] has the corners that were mapped, *fits
 * whether that went well. */
static int32_t follow(search *s, int32_t h, int32_t to, int mirrored, int32_t *map, int *fits) {
    const curvopt_mesh *m = s->mesh;
    int32_t n = 0;
    *fits = map_corner(s, h, to, mirrored, map, &n);
    for (int32_t head = 0; head < n; head++) {
        int32_t at = s->queue[head], image = map[at], edge = image_of_edge(m, image, mirrored);
        int32_t next[2] = {co_mesh_next(m, at), m->twin[at]};
        int32_t next_image[2] = {mirrored ? co_mesh_prev(m, image) : co_mesh_next(m, image), UNSET};
        if (next[1] >= 0) /* the corner at the head of `at`, in the face across; its image likewise */
            next_image[1] = mirrored ? co_mesh_next(m, m->twin[edge]) : m->twin[edge];
        for (int k = 0; k < 2; k++) {
            if (next[k] < 0)
                continue;
            if (map[next[k]] == UNSET) {
                *fits = map_corner(s, next[k], next_image[k], mirrored, map, &n);
                if (!*fits)
                    return n;
            } else if (map[next[k]] != next_image[k]) {
                *fits = 0;
                return n;
            }
        }
    }
    return n;
}

/* Fills `map` [n_corners], UNSET where unknown, over the component of h; 0, and nothing changed, if it cannot be. With
 * a motion, vertices must go where that takes them. */
static int propagate(search *s, int32_t h, int32_t to, int mirrored, const double *motion, int32_t *map) {
    int fits;
    int32_t n = follow(s, h, to, mirrored, map, &fits);
    for (int32_t i = 0; motion && fits && i < n; i++)
        fits = goes_to(s, motion, s->mesh->corner_vertex[s->queue[i]], s->mesh->corner_vertex[map[s->queue[i]]]);
    for (int32_t i = 0; !fits && i < n; i++) {
        s->taken[map[s->queue[i]]] = 0;
        map[s->queue[i]] = UNSET;
    }
    return fits;
}

/* ------------------------------------------------------------------------------------------------ geometry -- */

/* The motion that takes mapped corners' vertices closest to their images; 0 if they do not determine one. */
static int fit_motion(const search *s, const int32_t *map, double matrix[9]) {
    const curvopt_mesh *m = s->mesh;
    double sum[3][3] = {{0}};
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        if (map[h] == UNSET)
            continue;
        const double *from = s->x + 3 * (size_t)m->corner_vertex[h], *to = s->x + 3 * (size_t)m->corner_vertex[map[h]];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                sum[i][j] += to[i] * from[j] / m->info.n_corners;
    }
    if (!co_similarity_orthogonal_factor(sum))
        return 0;
    memcpy(matrix, sum, sizeof sum);
    return 1;
}

/* Whether the motion takes the direction of a constraint at v, of this freedom, to that at w. */
static int keeps_direction(const search *s, const double *direction, int freedom, int32_t v, int32_t w,
                           const double matrix[9]) {
    double at[3];
    if (freedom != CO_FREEDOM_LINE && freedom != CO_FREEDOM_PLANE)
        return 1;
    const double *to = direction + 3 * (size_t)w;
    co_small_dense_apply_3(matrix, direction + 3 * (size_t)v, at);
    return co_freedom_sine(at, to) <= s->tolerance;
}

/* Whether the motion takes the place that the spring of v draws it to to that of w. */
static int keeps_anchor(const search *s, int32_t v, int32_t w, const double matrix[9]) {
    const double *from = s->constraints->springs.anchor + 3 * (size_t)v,
                 *to = s->constraints->springs.anchor + 3 * (size_t)w;
    double at[3], image[3], wanted[3];
    for (int c = 0; c < 3; c++) {
        at[c] = (from[c] - s->centroid[c]) / s->radius;
        wanted[c] = (to[c] - s->centroid[c]) / s->radius;
    }
    co_small_dense_apply_3(matrix, at, image);
    return co_distance3(image, wanted) <= s->tolerance;
}

/* Whether `map` is the motion, and keeps the constraints' directions and places, and entries. */
static int is_motion(const search *s, const int32_t *map, const double matrix[9]) {
    const curvopt_mesh *m = s->mesh;
    const co_soft_constraints *springs = &s->constraints->springs;
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t v = m->corner_vertex[h], w = m->corner_vertex[map[h]];
        if (!goes_to(s, matrix, v, w))
            return 0;
        if (s->constraints->freedom &&
            !keeps_direction(s, s->constraints->direction, s->constraints->freedom[v], v, w, matrix))
            return 0;
        if (springs->stiffness && springs->stiffness[v] > 0 &&
            !(keeps_direction(s, springs->direction, springs->freedom[v], v, w, matrix) &&
              keeps_anchor(s, v, w, matrix)))
            return 0;
    }
    const co_value_motion motion = {map, matrix, s->centroid, s->radius, s->tolerance};
    return co_value_index_keeps(&s->held, &motion) && co_value_index_keeps(&s->drawn, &motion);
}

/* Another component, from its corner h on. Where several lie in the same place, one that stays where it is does so:
 * the identity is one. */
static int map_component(search *s, int32_t h, const double matrix[9], int mirrored, int32_t *map) {
    const curvopt_mesh *m = s->mesh;
    for (int32_t k = -1; k < m->info.n_corners; k++) {
        int32_t to = k < 0 ? h : k;
        if (goes_to(s, matrix, m->corner_vertex[h], m->corner_vertex[to]) && propagate(s, h, to, mirrored, matrix, map))
            return 1;
    }
    return 0;
}

/* The other components, once the first has told the motion. The identity, which comes first, finds where they start. */
static int map_components(search *s, const double matrix[9], int mirrored, int32_t *map) {
    const int is_identity = s->found.order == 0;
    for (int32_t h = 0; h < s->mesh->info.n_corners; h++)
        if (map[h] == UNSET) {
            if (!map_component(s, h, matrix, mirrored, map))
                return 0;
            if (is_identity)
                s->start[s->n_starts++] = h;
        }
    return 1;
}

/* One candidate; kept if it is a symmetry. Most fail near the seed, and then cost no more than what was mapped. */
static int32_t try_image(search *s, int32_t to, int mirrored, curvopt_error *error) {
    if (co_cancel_is_due(s->cancel))
        return CO_CANCELLED;
    if (s->found.order == s->room) {
        int32_t status = grow(s, error);
        if (status != CURVOPT_OK)
            return status;
    }
    int32_t *map = map_of(s, s->found.order);
    double *matrix = s->found.matrix + 9 * (size_t)s->found.order;
    if (!propagate(s, s->seed, to, mirrored, NULL, map))
        return CURVOPT_OK;
    if (fit_motion(s, map, matrix) && map_components(s, matrix, mirrored, map) && is_motion(s, map, matrix)) {
        s->found.mirrored[s->found.order++] = (uint8_t)mirrored;
        memset(s->taken, 0, (size_t)s->found.n_corners);
    } else {
        forget_map(s, s->found.order);
    }
    return CURVOPT_OK;
}

/* A corner at a vertex whose distance from the centre few others have. */
typedef struct ranked {
    double length;
    int32_t vertex;
} ranked;

static int by_length(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->length != y->length)
        return x->length > y->length ? 1 : -1;
    return (x->vertex > y->vertex) - (x->vertex < y->vertex); /* C libraries differ in what they do with ties */
}

static int32_t choose_seed(search *s, curvopt_error *error) {
    int32_t n = s->mesh->info.n_vertices - s->mesh->info.n_isolated, fewest = n + 1;
    ranked *order = CO_NEW(ranked, n);
    if (!order)
        return co_status_no_memory(error);
    for (int32_t v = 0, at = 0; v < s->mesh->info.n_vertices; v++)
        if (s->mesh->vertex_corner[v] >= 0)
            order[at++] = (ranked){s->length[v], v};
    qsort(order, (size_t)n, sizeof *order, by_length);
    for (int32_t first = 0, end; first < n; first = end) {
        for (end = first + 1; end < n && order[end].length - order[end - 1].length <= s->tolerance;)
            end++;
        if (end - first < fewest) {
            fewest = end - first;
            s->seed = s->mesh->vertex_corner[order[first].vertex];
        }
    }
    free(order);
    return CURVOPT_OK;
}

static int32_t find_all(search *s, curvopt_error *error) {
    int32_t status = choose_seed(s, error);
    while (s->found.order > 0)
        forget_map(s, --s->found.order);
    s->n_starts = 0;
    if (status == CURVOPT_OK)
        status = try_image(s, s->seed, 0, error); /* the identity comes first */
    for (int32_t to = 0; status == CURVOPT_OK && to < s->found.n_corners && s->found.order <= LARGEST_ORDER; to++)
        for (int mirrored = 0; status == CURVOPT_OK && mirrored <= s->with_mirrors; mirrored++)
            if (to != s->seed || mirrored)
                status = try_image(s, to, mirrored, error);
    return status;
}

/* --------------------------------------------------------------------------------------------------- group -- */

/* Whether element k takes corner h where b and then a take it. A component follows from one corner. */
static int is_product_at(const search *s, int32_t h, int32_t k, int32_t a, int32_t b) {
    return map_of(s, k)[h] == map_of(s, a)[map_of(s, b)[h]];
}

/* The element that is b, then a, or the order if there is none. */
static int32_t product_of(const search *s, int32_t a, int32_t b) {
    const co_symmetry *f = &s->found;
    int32_t k = 0;
    while (k < f->order && !(is_product_at(s, s->seed, k, a, b) && f->mirrored[k] == (f->mirrored[a] ^ f->mirrored[b])))
        k++;
    for (int32_t i = 0; k < f->order && i < s->n_starts; i++)
        if (!is_product_at(s, s->start[i], k, a,
                           b)) /* components that lie in the same place are told apart by chance */
            return f->order;
    return k;
}

/* Fills the table of products; 0 if the elements are no group. */
static int multiply(search *s) {
    co_symmetry *f = &s->found;
    for (int32_t a = 0; a < f->order; a++)
        for (int32_t b = 0; b < f->order; b++) {
            int32_t k = product_of(s, a, b);
            if (k == f->order)
                return 0;
            f->product[a * f->order + b] = k;
        }
    return 1;
}

/* Matrices were fitted one by one, to positions that are symmetric up to the tolerance. Q_g <- the orthogonal matrix
 * nearest to the mean over h of Q_gh Q_h^T, a few times, makes them multiply like the group's elements: the centre of
 * mass of what a near-homomorphism offers (Grove, Karcher, Ruh, "Jacobi fields and Finsler metrics on compact Lie
 * groups", 1974); the defect squares in each pass. */
static void make_representation(co_symmetry *f, double *next) {
    for (int pass = 0; pass < 4; pass++) {
        for (int32_t g = 0; g < f->order; g++) {
            double mean[3][3] = {{0}};
            for (int32_t h = 0; h < f->order; h++) {
                const double *gh = f->matrix + 9 * (size_t)f->product[g * f->order + h], *q = f->matrix + 9 * (size_t)h;
                for (int i = 0; i < 3; i++)
                    for (int j = 0; j < 3; j++)
                        for (int k = 0; k < 3; k++)
                            mean[i][j] += gh[3 * i + k] * q[3 * j + k] / f->order;
            }
            co_similarity_orthogonal_factor(mean);
            memcpy(next + 9 * (size_t)g, mean, sizeof mean);
        }
        memcpy(f->matrix, next, 9 * sizeof(double) * (size_t)f->order);
    }
}

/* 1 if what was found is a group, whose matrices are then exact; 0 if not; -1 if memory is out. */
static int complete(search *s) {
    size_t order = (size_t)s->found.order;
    free(s->found.product);
    s->found.product = CO_NEW(int32_t, order * order);
    double *next = CO_NEW(double, 9 * order);
    int result = s->found.product && next ? multiply(s) : -1;
    if (result > 0)
        make_representation(&s->found, next);
    free(next);
    return result;
}

/* The trivial group instead of what was found. */
static int32_t find_none(search *s, curvopt_error *error) {
    co_symmetry_free(&s->found);
    return co_symmetry_none(s->mesh, &s->found, error);
}

static int32_t run(search *s, curvopt_error *error) {
    for (s->tolerance = CO_SYMMETRY_TOLERANCE; s->tolerance > LEAST_TOLERANCE; s->tolerance /= 10) {
        int32_t status = find_all(s, error);
        if (status != CURVOPT_OK)
            return status;
        if (s->found.order == 0 || s->found.order > LARGEST_ORDER) /* 0: flat or on a line, no motion to be had */
            return find_none(s, error);
        int group = complete(s);
        if (group > 0)
            return CURVOPT_OK;
        if (group < 0)
            return co_status_no_memory(error);
    }
    return find_none(s, error);
}

static void end_search(search *s) {
    free(s->x);
    free(s->length);
    free(s->queue);
    free(s->taken);
    free(s->start);
    co_value_index_free(&s->held);
    co_value_index_free(&s->drawn);
}

static int32_t begin_search(const curvopt_mesh *m, const double *xyz, const co_constraints *constraints,
                            int with_mirrors, search *s, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    double centroid[3], radius = co_similarity_mesh_frame(m, xyz, centroid);
    *s = (search){.mesh = m,
                  .radius = radius,
                  .constraints = constraints,
                  .with_mirrors = with_mirrors,
                  .tolerance = CO_SYMMETRY_TOLERANCE,
                  .x = CO_NEW(double, 3 * n),
                  .length = CO_NEW(double, n),
                  .queue = CO_NEW(int32_t, m->info.n_corners),
                  .taken = CO_NEW(uint8_t, m->info.n_corners),
                  .start = CO_NEW(int32_t, m->info.n_corners),
                  .found = {.n_corners = m->info.n_corners}};
    if (!s->x || !s->length || !s->queue || !s->taken || !s->start)
        return co_status_no_memory(error);
    memcpy(s->centroid, centroid, sizeof centroid);
    for (size_t i = 0; i < 3 * n; i++)
        s->x[i] = (xyz[i] - centroid[i % 3]) / radius;
    for (size_t v = 0; v < n; v++)
        s->length[v] = co_length3(s->x + 3 * v);
    int32_t status = co_value_index_create(m, &constraints->values, &s->held, error);
    return status == CURVOPT_OK ? co_value_index_create(m, &constraints->drawn, &s->drawn, error) : status;
}

int32_t co_symmetry_create(const curvopt_mesh *m, const double *xyz, const co_constraints *constraints,
                           int with_mirrors, co_cancel *cancel, co_symmetry *out, curvopt_error *error) {
    search s;
    int32_t status = begin_search(m, xyz, constraints, with_mirrors, &s, error);
    s.cancel = cancel;
    if (status == CURVOPT_OK)
        status = run(&s, error);
    end_search(&s);
    if (status != CURVOPT_OK)
        co_symmetry_free(&s.found);
    *out = s.found;
    return status;
}

/* --------------------------------------------------------------------------------------------------- planes -- */

/* The mirror image across the plane of this axis, as element g; whether the cage has it. */
static int find_mirror(search *s, int axis, int32_t g) {
    double *matrix = s->found.matrix + 9 * (size_t)g;
    int32_t *map = map_of(s, g);
    for (int k = 0; k < 3; k++)
        matrix[4 * k] = k == axis ? -1 : 1;
    s->found.mirrored[g] = 1;
    memset(s->taken, 0, (size_t)s->found.n_corners);
    return map_components(s, matrix, 1, map) && is_motion(s, map, matrix);
}

/* Whether the elements of single planes are their own inverses and commute. */
static int are_independent(const search *s) {
    for (int32_t a = 1; a < s->found.order; a *= 2)
        for (int32_t b = 1; b <= a; b *= 2)
            for (int32_t h = 0; h < s->found.n_corners; h++) {
                int32_t one = map_of(s, a)[map_of(s, b)[h]], other = map_of(s, b)[map_of(s, a)[h]];
                if (one != (a == b ? h : other))
                    return 0;
            }
    return 1;
}

/* Element g, the binary number of the planes that it is made of, of two that are there. */
static void compose(search *s, int32_t g, int32_t a, int32_t b) {
    co_symmetry *f = &s->found;
    for (int32_t h = 0; h < f->n_corners; h++)
        map_of(s, g)[h] = map_of(s, a)[map_of(s, b)[h]];
    for (size_t k = 0; k < 9; k += 4)
        f->matrix[9 * (size_t)g + k] = f->matrix[9 * (size_t)a + k] * f->matrix[9 * (size_t)b + k];
    f->mirrored[g] = f->mirrored[a] ^ f->mirrored[b];
}

static int32_t find_planes(search *s, int32_t planes, int *missing, curvopt_error *error) {
    co_symmetry *f = &s->found;
    int32_t g = 1, status = CURVOPT_OK;
    int32_t order = 1 << ((planes & 1) + (planes >> 1 & 1) + (planes >> 2 & 1));
    do
        status = grow(s, error);
    while (status == CURVOPT_OK && s->room < order);
    f->product = CO_NEW(int32_t, order * order);
    if (status != CURVOPT_OK || !f->product || !f->matrix)
        return status == CURVOPT_OK ? co_status_no_memory(error) : status;
    f->order = order;
    for (int32_t h = 0; h < f->n_corners; h++)
        map_of(s, 0)[h] = h;
    for (int k = 0; k < 3; k++)
        f->matrix[4 * k] = 1;
    for (*missing = 0; *missing < 3; ++*missing)
        if (planes >> *missing & 1) {
            if (!find_mirror(s, *missing, g))
                return CURVOPT_OK;
            for (int32_t a = 1; a < g; a++)
                compose(s, g + a, g, a);
            g *= 2;
        }
    *missing = are_independent(s) ? -1 : planes & 1 ? 0 : planes & 2 ? 1 : 2;
    for (int32_t k = 0; k < order * order; k++)
        f->product[k] = (k / order) ^ (k % order);
    return CURVOPT_OK;
}

int32_t co_symmetry_of_planes(const curvopt_mesh *m, const double *xyz, const co_constraints *constraints,
                              int32_t planes, co_symmetry *out, int *missing, curvopt_error *error) {
    search s;
    int32_t status = begin_search(m, xyz, constraints, 1, &s, error);
    if (status == CURVOPT_OK)
        status = find_planes(&s, planes, missing, error);
    end_search(&s);
    if (status != CURVOPT_OK || *missing >= 0)
        co_symmetry_free(&s.found);
    *out = s.found;
    return status;
}

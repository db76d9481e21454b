/* A cage as a list of patches: local subdivision where a face cannot be evaluated as it is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/patches.h"

#include "base/memory.h"
#include "mesh/crease.h"
#include "mesh/subdivide.h"
#include "mesh/submesh.h"
#include "surface/blend_disc_half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One subdivision separates n-gons, the second one extraordinary vertices; creases take as many as they need to fade,
 * 10 at most, and then leave the same vertices behind. */
enum { MAX_LEVEL = 2 };

/* The part of the cage that is still being subdivided, at one level. */
typedef struct level {
    const curvopt_mesh *mesh;
    curvopt_mesh *owned;         /* the mesh again, if the level frees it; NULL on level 0 */
    co_sparse_rows rows;         /* the mesh's vertices over the cage's; empty on level 0, where they are the same */
    uint8_t *active;             /* [n_faces] 1: to be covered by patches; 2: must be split */
    co_place *place;             /* [n_faces] place of each face on the cage */
    uint8_t *kind;               /* [n_corners] co_corner_kind */
    int32_t *point_of;           /* [co_ring_n_numbers] number in co_patches of each vertex and phantom; -1: none yet */
    const co_blend_discs *discs; /* wide discs of level 0; NULL: none, as on all other levels */
    int32_t *disc_at;            /* [n_vertices] the disc of width 1 round each vertex; -1: none yet */
    int32_t surface;             /* curvopt_surface */
    co_cancel *cancel;
} level;

static void level_free(level *l) {
    co_mesh_destroy(l->owned);
    co_sparse_rows_free(&l->rows);
    free(l->active);
    free(l->place);
    free(l->kind);
    free(l->point_of);
    free(l->disc_at);
    *l = (level){0};
}

static int32_t level_allocate(level *l, curvopt_error *error) {
    l->active = CO_NEW(uint8_t, l->mesh->info.n_faces);
    l->place = CO_NEW(co_place, l->mesh->info.n_faces);
    l->kind = CO_NEW(uint8_t, l->mesh->info.n_corners);
    l->point_of = CO_NEW(int32_t, co_ring_n_numbers(l->mesh));
    l->disc_at = CO_NEW(int32_t, l->mesh->info.n_vertices);
    if (!l->active || !l->place || !l->kind || !l->point_of || !l->disc_at)
        return co_status_no_memory(error);
    for (int32_t v = 0; v < l->mesh->info.n_vertices; v++)
        l->disc_at[v] = -1;
    for (int32_t i = 0; i < co_ring_n_numbers(l->mesh); i++)
        l->point_of[i] = -1;
    co_ring_classify(l->mesh, l->kind);
    return CURVOPT_OK;
}

/* Moves a place's frame to the corner of its square: origin there, s along the edge that leaves it. */
static co_place at_corner(co_place p, int corner) {
    static const double corner_at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double scale = 1.0 / (1 << p.level), x = corner_at[corner][0], y = corner_at[corner][1];
    for (int turn = 0; turn < p.rotation; turn++) {
        double old_x = x;
        x = -y;
        y = old_x;
    }
    p.origin[0] += scale * x;
    p.origin[1] += scale * y;
    p.rotation = (p.rotation + corner) % 4;
    return p;
}

/* Where a face lies on a wide blend, or NULL. */
static const co_blend_disc_face *place_on_disc(const level *l, int32_t f) {
    return l->discs && l->discs->face[f].disc >= 0 ? &l->discs->face[f] : NULL;
}

/* The corner of a face from which it can be evaluated: its extraordinary one, else 0; -1 if it must be split first. */
static int evaluable_corner(const level *l, int32_t f) {
    int corner = 0;
    if (co_mesh_face_size(l->mesh, f) != 4)
        return -1;
    if (place_on_disc(l, f))
        return place_on_disc(l, f)->first - l->mesh->face_start[f];
    for (int k = 0; k < 4; k++) {
        uint8_t at = l->kind[l->mesh->face_start[f] + k];
        if (at == CO_CORNER_UNREADY)
            return -1;
        if (at == CO_CORNER_EXTRAORDINARY)
            corner = k;
    }
    return corner;
}

/* What kind of patch a face is, seen from that corner, where half-edge h leaves; *first begins its fan. */
static int32_t patch_kind(const level *l, int32_t f, int32_t h, int32_t *first) {
    const co_blend_disc_face *on = place_on_disc(l, f);
    *first = h;
    if (on) {
        const co_blend_disc_fit *fit = co_blend_disc_fit_of(l->discs, &l->discs->disc[on->disc]);
        if (fit->is_half && on->i == 0 && on->j == 0)
            co_ring_fan(l->mesh, h, first);
        return fit->is_half ? co_fan_make_half(fit->valence, on->sector, fit->width, fit->steps, on->i, on->j)
                            : co_fan_make_wide(fit->valence, fit->width, on->i, on->j);
    }
    int32_t kind = l->kind[h] == CO_CORNER_EXTRAORDINARY ? co_ring_fan(l->mesh, h, first) : CO_FAN_REGULAR;
    int is_disc = co_fan_type_of(kind) == CO_FAN_CLOSED && kind >= co_blend_disc_least_valence(l->surface);
    return is_disc ? co_fan_make_wide(kind, 1, 0, 0) : kind;
}

/* Adds vertex v of the level over the cage, `weight` times, to the row of n entries; how many it has then. */
static size_t add_to_row(const level *l, int32_t v, double weight, int32_t *column, double *value, size_t n) {
    size_t begin = l->rows.n_rows ? l->rows.start[v] : 0, end = l->rows.n_rows ? l->rows.start[v + 1] : 1, old = n;
    for (size_t e = begin; e < end; e++) {
        int32_t c = l->rows.n_rows ? l->rows.column[e] : v;
        size_t at = 0;
        while (at < old && column[at] != c)
            at++;
        at = at < old ? at : n++;
        value[at] = (at < old ? value[at] : 0) + (l->rows.n_rows ? weight * l->rows.value[e] : weight);
        column[at] = c;
    }
    return n;
}

/* At least the entries of a number's row over the cage. */
static size_t row_length(const level *l, int32_t number) {
    int32_t vertex[4];
    double weight[4];
    size_t length = 0;
    int n = co_ring_resolve(l->mesh, number, vertex, weight);
    for (int k = 0; k < n; k++)
        length += l->rows.n_rows ? l->rows.start[vertex[k] + 1] - l->rows.start[vertex[k]] : 1;
    return length;
}

/* Appends the rows of the points that got numbers from `first_new` on. */
static int32_t append_derived(const level *l, co_patches *out, int32_t first_new, curvopt_error *error) {
    size_t n_entries = 0;
    int32_t n_old = out->derived.n_rows, n_rows = out->n_points - out->n_cage;
    co_sparse_rows bigger;
    if (n_rows == n_old)
        return CURVOPT_OK;
    int32_t *number = CO_NEW(int32_t, out->n_points - first_new);
    if (!number)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < co_ring_n_numbers(l->mesh); i++)
        if (l->point_of[i] >= first_new) {
            number[l->point_of[i] - first_new] = i;
            n_entries += row_length(l, i);
        }
    size_t old_entries = n_old ? out->derived.start[n_old] : 0;
    int32_t status = co_sparse_rows_allocate(&bigger, n_rows, out->n_cage, old_entries + n_entries, error);
    if (status == CURVOPT_OK) {
        if (n_old) {
            memcpy(bigger.start, out->derived.start, sizeof(size_t) * ((size_t)n_old + 1));
            memcpy(bigger.column, out->derived.column, sizeof(int32_t) * old_entries);
            memcpy(bigger.value, out->derived.value, sizeof(double) * old_entries);
        }
        for (int32_t r = n_old; r < n_rows; r++) {
            int32_t vertex[4];
            double weight[4];
            size_t begin = bigger.start[r], length = 0;
            int n = co_ring_resolve(l->mesh, number[r - n_old], vertex, weight);
            for (int k = 0; k < n; k++)
                length = add_to_row(l, vertex[k], weight[k], bigger.column + begin, bigger.value + begin, length);
            bigger.start[r + 1] = begin + length;
        }
        co_sparse_rows_free(&out->derived);
        out->derived = bigger;
    }
    free(number);
    return status;
}

int32_t co_patches_kind(const co_patches *p, int32_t kind) {
    int32_t low = 0, high = p->n_kinds;
    while (high > low) {
        int32_t middle = low + (high - low) / 2;
        if (p->kinds[middle] < kind)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static int32_t add_kind(co_patches *p, int32_t kind, curvopt_error *error) {
    int32_t at = co_patches_kind(p, kind);
    if (at < p->n_kinds && p->kinds[at] == kind)
        return CURVOPT_OK;
    int32_t *kinds = CO_RESIZED(p->kinds, (size_t)p->n_kinds + 1);
    if (!kinds)
        return co_status_no_memory(error);
    memmove(kinds + at + 1, kinds + at, sizeof(int32_t) * (size_t)(p->n_kinds - at));
    kinds[at] = kind;
    p->kinds = kinds;
    p->n_kinds++;
    return CURVOPT_OK;
}

static int32_t grow(co_patches *out, int32_t n_patches, size_t n_points, curvopt_error *error) {
    int32_t *kind = CO_RESIZED(out->kind, (size_t)n_patches + 1);
    if (kind)
        out->kind = kind;
    size_t *start = CO_RESIZED(out->start, (size_t)n_patches + 1);
    if (start)
        out->start = start;
    int32_t *points = CO_RESIZED(out->points, n_points + 1);
    if (points)
        out->points = points;
    co_place *place = CO_RESIZED(out->place, (size_t)n_patches + 1);
    if (place)
        out->place = place;
    uint8_t *cuts = CO_RESIZED(out->cuts, (size_t)n_patches + 1);
    if (cuts)
        out->cuts = cuts;
    return kind && start && points && place && cuts ? CURVOPT_OK : co_status_no_memory(error);
}

/* co_patches.cuts of the face whose first corner h is. */
static uint8_t cuts_of(const level *l, int32_t h) {
    unsigned cuts = 0;
    for (int k = 0; co_ring_has_phantoms(l->mesh) && k < 4; k++, h = co_mesh_next(l->mesh, h)) {
        cuts |= (unsigned)co_crease_is_infinite(co_crease_edge(l->mesh, h)) << k;
        cuts |= (unsigned)(l->kind[h] == CO_CORNER_SHARP) << (4 + k);
    }
    return (uint8_t)cuts;
}

/* Coefficients of discs get their final numbers when all other points have theirs (number_coefficients); until
 * then they are negative. */
static int32_t provisional(int32_t point) {
    return -1 - point;
}

/* The sector of a disc of width 1 from which on its points, n of them, are numbered in `points`. */
static int32_t sector_from(const int32_t *column, int32_t n, const int32_t *points) {
    const int32_t valence = (n - 1) / CO_RING_SECTOR;
    for (int32_t s = 0; s < valence; s++) {
        const size_t before = CO_RING_SECTOR * (size_t)s, after = (size_t)n - 1 - before;
        if (memcmp(points + 1, column + 1 + before, after * sizeof *points) == 0 &&
            memcmp(points + 1 + after, column + 1, before * sizeof *points) == 0)
            return s;
    }
    return 0; /* not reached */
}

/* Finds the first coefficient of a face's sector of the disc of width 1 round vertex v. The first face of a disc, which
 * becomes its sector 0, makes it of its points, n of them. */
static int32_t find_coefficients(level *l, co_patches *out, int32_t v, int32_t n, const int32_t *points,
                                 int32_t *coefficient, curvopt_error *error) {
    if (l->disc_at[v] < 0) {
        int32_t status = co_blend_discs_add((n - 1) / CO_RING_SECTOR, 1, &out->wide, error);
        if (status != CURVOPT_OK)
            return status;
        l->disc_at[v] = out->wide.n_discs - 1;
        memcpy(out->wide.column + out->wide.disc[l->disc_at[v]].column, points, (size_t)n * sizeof *points);
    }
    const co_blend_disc *disc = &out->wide.disc[l->disc_at[v]];
    *coefficient = disc->first_point + CO_BLEND_DISC_TERMS * sector_from(out->wide.column + disc->column, n, points);
    return CURVOPT_OK;
}

static int32_t emit_patch(level *l, co_patches *out, int32_t f, int corner, curvopt_error *error) {
    const curvopt_mesh *m = l->mesh;
    int32_t h = m->face_start[f] + corner, first, p = out->n_patches++, kind = patch_kind(l, f, h, &first);
    int32_t *points = out->points + out->start[p], n_own = co_patches_own_size(kind);
    if (l->kind[h] == CO_CORNER_EXTRAORDINARY)
        co_ring_two_ring(m, co_fan_at_vertex(kind), first, points);
    else
        co_ring_regular(m, h, l->kind, points);
    out->kind[p] = kind;
    out->cuts[p] = cuts_of(l, h);
    out->place[p] = at_corner(l->place[f], corner);
    out->start[p + 1] = out->start[p] + (size_t)co_patches_size(kind);
    for (int32_t i = 0; i < n_own; i++) {
        int32_t *number = &l->point_of[points[i]];
        if (*number < 0)
            *number = out->n_points++;
        points[i] = *number;
    }
    const co_blend_disc_face *on = place_on_disc(l, f);
    int32_t coefficient = on ? co_blend_discs_coefficient(l->discs, on) : 0;
    int32_t status = CURVOPT_OK;
    if (!on && co_fan_is_wide(kind))
        status = find_coefficients(l, out, m->corner_vertex[h], n_own, points, &coefficient, error);
    for (int32_t i = n_own; i < co_patches_size(kind); i++)
        points[i] = provisional(coefficient + i - n_own);
    return status == CURVOPT_OK ? add_kind(out, kind, error) : status;
}

/* Turns the active faces that can be evaluated into patches and marks the others 2; *n_split counts those. */
static int32_t emit_patches(level *l, co_patches *out, int32_t *n_split, curvopt_error *error) {
    const curvopt_mesh *m = l->mesh;
    int32_t n_patches = out->n_patches, first_new = out->n_points;
    size_t n_points = out->start ? out->start[n_patches] : 0;
    *n_split = 0;
    for (int32_t f = 0; f < m->info.n_faces; f++) {
        int corner = l->active[f] ? evaluable_corner(l, f) : -1;
        if (corner >= 0) {
            int32_t first;
            n_patches++;
            n_points += (size_t)co_patches_size(patch_kind(l, f, m->face_start[f] + corner, &first));
        }
    }
    int32_t status = grow(out, n_patches, n_points, error);
    if (status == CURVOPT_OK && out->n_patches == 0)
        out->start[0] = 0;
    for (int32_t f = 0; status == CURVOPT_OK && f < m->info.n_faces; f++) {
        if (co_cancel_is_due(l->cancel))
            return CO_CANCELLED;
        if (!l->active[f])
            continue;
        int corner = evaluable_corner(l, f);
        if (corner >= 0) {
            status = emit_patch(l, out, f, corner, error);
        } else {
            l->active[f] = 2;
            ++*n_split;
        }
    }
    return status == CURVOPT_OK ? append_derived(l, out, first_new, error) : status;
}

/* keep [n_faces]: the faces to be split and what decides about them. */
static int32_t faces_to_refine(const level *l, uint8_t *keep, curvopt_error *error) {
    const curvopt_mesh *m = l->mesh;
    for (int32_t f = 0; f < m->info.n_faces; f++)
        keep[f] = l->active[f] == 2;
    return co_submesh_grow(m, CO_PATCHES_HALO, keep, error);
}

/* Places of the children, from their parents'. Kept faces and their corners keep their order. */
static void place_children(const level *l, const uint8_t *keep, level *next) {
    int32_t child = 0;
    for (int32_t f = 0; f < l->mesh->info.n_faces; f++) {
        if (!keep[f])
            continue;
        int32_t size = co_mesh_face_size(l->mesh, f);
        for (int32_t k = 0; k < size; k++, child++) {
            next->active[child] = l->active[f] == 2;
            if (size == 4) {
                next->place[child] = at_corner(l->place[f], k);
                next->place[child].level++;
            } else { /* only cage faces are not quads: their quarters are where (u, v) start anew */
                next->place[child] = (co_place){.face = l->place[f].face, .quarter = k};
            }
        }
    }
}

static int32_t subdivide(const level *l, level *next, curvopt_error *error) {
    next->surface = l->surface;
    next->cancel = l->cancel;
    curvopt_mesh *part = NULL;
    int32_t *vertex_of = NULL, status = CURVOPT_ERROR_MEMORY;
    co_sparse_rows rows = {0};
    uint8_t *keep = CO_NEW(uint8_t, l->mesh->info.n_faces);
    if (!keep) {
        co_status_no_memory(error);
        goto done;
    }
    status = CO_CANCELLED;
    if (co_cancel_is_due(l->cancel) || (status = faces_to_refine(l, keep, error)) != CURVOPT_OK ||
        (status = co_submesh_extract(l->mesh, keep, &part, &vertex_of, error)) != CURVOPT_OK ||
        (status = co_subdivide(part, &next->owned, &rows, error)) != CURVOPT_OK)
        goto done;
    next->mesh = next->owned;
    for (size_t e = 0; e < rows.start[rows.n_rows]; e++)
        rows.column[e] = vertex_of[rows.column[e]];
    rows.n_columns = l->mesh->info.n_vertices;
    if (l->rows.n_rows) {
        status = co_sparse_rows_multiply(&rows, &l->rows, &next->rows, error);
    } else {
        next->rows = rows;
        rows = (co_sparse_rows){0};
    }
    if (status == CURVOPT_OK)
        status = level_allocate(next, error);
    if (status == CURVOPT_OK)
        place_children(l, keep, next);
done:
    co_mesh_destroy(part);
    co_sparse_rows_free(&rows);
    free(vertex_of);
    free(keep);
    return status;
}

/* Gives the coefficients of discs their numbers, after all other points.
 *
 * Example: 10 vertices, 3 derived points, one disc whose sector 2 begins at its coefficient 42. Patches of that sector
 * name -43, -44, .. in emit_patch; here -43 becomes 13 + 42 = 55. */
static void number_coefficients(co_patches *p) {
    for (size_t i = 0; p->wide.n_discs && i < p->start[p->n_patches]; i++)
        if (p->points[i] < 0)
            p->points[i] = p->n_points + provisional(p->points[i]);
    for (int32_t k = 0; k < p->wide.n_discs; k++)
        p->wide.disc[k].first_point += p->n_points;
    p->n_points += p->wide.n_points;
    free(p->wide.face); /* only patches were made from that */
    p->wide.face = NULL;
}

int32_t co_patches_create(const curvopt_mesh *mesh, const double *xyz, const double *face_weight, int32_t surface,
                          int widest, co_cancel *cancel, co_patches *out, curvopt_error *error) {
    level l = {.mesh = mesh, .surface = surface, .cancel = cancel}, next = {0};
    *out = (co_patches){.surface = surface, .n_cage = mesh->info.n_vertices, .n_points = mesh->info.n_vertices};
    int32_t status = level_allocate(&l, error), n_split = 0;
    int max_level = MAX_LEVEL + (int)ceil(co_crease_largest_fading(mesh));
    if (status == CURVOPT_OK && surface == CURVOPT_SURFACE_POLYNOMIAL && widest > 1)
        status = co_blend_discs_find(mesh, l.kind, widest, &out->wide, error);
    if (status == CURVOPT_OK && surface == CURVOPT_SURFACE_POLYNOMIAL && widest > 1 && xyz)
        status = co_blend_disc_half_find(mesh, l.kind, xyz, widest, &out->wide, error);
    if (status == CURVOPT_OK) {
        l.discs = out->wide.n_discs ? &out->wide : NULL;
        for (int32_t f = 0; f < mesh->info.n_faces; f++) {
            l.active[f] = !face_weight || face_weight[f] != 0;
            l.place[f].face = f;
        }
        for (int32_t v = 0; v < mesh->info.n_vertices; v++)
            l.point_of[v] = v;
        status = emit_patches(&l, out, &n_split, error);
    }
    for (int depth = 0; status == CURVOPT_OK && n_split > 0; depth++) {
        if (depth == max_level) {
            status = co_status_fail(error, CURVOPT_ERROR_TOPOLOGY, -1,
                                    "%d faces cannot be evaluated after %d "
                                    "subdivisions",
                                    n_split, max_level);
            break;
        }
        status = subdivide(&l, &next, error);
        level_free(&l);
        l = next;
        next = (level){0};
        if (status == CURVOPT_OK)
            status = emit_patches(&l, out, &n_split, error);
    }
    level_free(&l);
    if (status == CURVOPT_OK)
        number_coefficients(out);
    else
        co_patches_free(out);
    return status;
}

co_point_row co_patches_row(const co_patches *p, const int32_t *point) {
    static const double one = 1;
    if (*point < p->n_cage)
        return (co_point_row){point, &one, 1};
    size_t begin = p->derived.start[*point - p->n_cage];
    return (co_point_row){p->derived.column + begin, p->derived.value + begin,
                          p->derived.start[*point - p->n_cage + 1] - begin};
}

int co_patches_own_has_row(int32_t fitted, int32_t kind, int32_t window, int32_t i) {
    const int32_t fan = co_fan_at_vertex(kind);
    const int is_fit = fitted == CURVOPT_SURFACE_POLYNOMIAL && !co_fan_is_wide(kind);
    if (is_fit || co_patches_is_one_piece(kind) || co_patches_is_of_curve(kind, i)) /* a fit is of all the fan */
        return 1;
    return co_stam_in_support(fan, i) && (!window || co_stam_in_window(fan, window, i));
}

int co_patches_own_is_used(int32_t surface, int32_t kind, int32_t i) {
    const int has_window = co_fan_is_wide(kind) && !co_fan_is_half(kind);
    return co_patches_own_has_row(co_blend_fit_surface(surface, kind), kind, has_window ? CO_STAM_WINDOW : 0, i);
}

void co_patches_derive(const co_patches *p, double *points) {
    if (p->derived.n_rows)
        co_sparse_rows_apply(&p->derived, points, points + 3 * (size_t)p->n_cage);
    co_blend_discs_apply(&p->wide, points);
}

void co_patches_add_derived(const co_patches *p, double *point_gradient, double *gradient) {
    co_blend_discs_add_transposed(&p->wide, p->n_cage, point_gradient, gradient);
    if (p->derived.n_rows)
        co_sparse_rows_add_transposed(&p->derived, point_gradient + 3 * (size_t)p->n_cage, gradient);
}

void co_patches_free(co_patches *p) {
    co_sparse_rows_free(&p->derived);
    co_blend_discs_free(&p->wide);
    free(p->kind);
    free(p->start);
    free(p->points);
    free(p->place);
    free(p->cuts);
    free(p->kinds);
    *p = (co_patches){0};
}

/* Which energies are finite on which surface of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/admissibility.h"

#include "base/memory.h"
#include "mesh/degenerate.h"

#include <stdlib.h>

/* ------------------------------------------------------------------------------------------- exceptions -- */

enum { FINE = -1 };

static int reason_of_flaw(co_mesh_flaw flaw) {
    return flaw == CO_MESH_CURVE || flaw == CO_MESH_CROWDED ? CURVOPT_EXCEPTION_CROWDED_EDGE
           : flaw == CO_MESH_FLIPPED                        ? CURVOPT_EXCEPTION_FLIPPED
           : flaw == CO_MESH_PINCHED                        ? CURVOPT_EXCEPTION_PINCHED
                                                            : CURVOPT_EXCEPTION_ISOLATED;
}

/* Why the faces of a fan (ring.h) are left out; FINE: they are not. */
static int reason_of_fan(int32_t fan) {
    if (co_blend_fit_surface(CURVOPT_SURFACE_LIMIT, fan) != CURVOPT_SURFACE_LIMIT || co_fan_is_integrable(fan))
        return FINE;
    return co_fan_type_of(fan) == CO_FAN_CONE ? CURVOPT_EXCEPTION_CONE : CURVOPT_EXCEPTION_CORNER;
}

static void add_reason(int32_t *at, int32_t reason) {
    if (*at == FINE || reason < *at)
        *at = reason;
}

/* Only the fan that has no finite energy is left out, not what lies across a crease. Holes count for nothing. fan,
 * degenerate: [n_corners] */
static void find_by_corners(const curvopt_mesh *m, const int32_t *fan, const uint8_t *degenerate, co_exceptions *e) {
    for (int32_t h = 0; h < m->info.n_corners; h++) {
        int32_t v = m->corner_vertex[h];
        co_mesh_flaw flaw = co_mesh_flaw_of(m, v);
        if (e->face[m->corner_face[h]] == CURVOPT_EXCEPTION_HOLE)
            continue;
        int reason = flaw ? reason_of_flaw(flaw) : reason_of_fan(fan[h]);
        if (reason == FINE && degenerate[h])
            reason = CURVOPT_EXCEPTION_DEGENERATE;
        if (reason == FINE)
            continue;
        add_reason(&e->vertex[v], reason);
        add_reason(&e->face[m->corner_face[h]], reason);
    }
}

static int32_t add_holes(const curvopt_mesh *m, const curvopt_options *o, co_exceptions *e, curvopt_error *error) {
    for (int32_t i = 0; i < o->n_holes; i++) {
        if (o->holes[i] < 0 || o->holes[i] >= m->info.n_faces)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "hole %d is face %d; the cage has faces 0 to %d", i,
                                  o->holes[i], m->info.n_faces - 1);
        e->face[o->holes[i]] = CURVOPT_EXCEPTION_HOLE;
    }
    return CURVOPT_OK;
}

static void add_neighbours(const curvopt_mesh *m, co_exceptions *e) {
    for (int32_t i = 0; i < m->info.n_isolated; i++)
        e->vertex[m->isolated[i]] = CURVOPT_EXCEPTION_ISOLATED;
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (e->face[m->corner_face[h]] != FINE)
            add_reason(&e->vertex[m->corner_vertex[h]], CURVOPT_EXCEPTION_BESIDE);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        e->n_held += e->vertex[v] != FINE;
    for (int32_t f = 0; f < m->info.n_faces; f++)
        e->n_left_out += e->face[f] != FINE;
}

void co_exceptions_free(co_exceptions *e) {
    free(e->vertex);
    free(e->face);
    *e = (co_exceptions){0};
}

/* Faces of infinite energy. */
static int32_t add_infinite(const curvopt_mesh *m, const double *xyz, co_exceptions *e, curvopt_error *error) {
    int32_t *fan = CO_NEW(int32_t, m->info.n_corners);
    uint8_t *degenerate = CO_NEW(uint8_t, m->info.n_corners);
    int32_t status = fan && degenerate ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK && xyz)
        status = co_degenerate_mark(m, xyz, degenerate, error);
    if (status == CURVOPT_OK) {
        co_ring_fans(m, fan);
        find_by_corners(m, fan, degenerate, e);
    }
    free(fan);
    free(degenerate);
    return status;
}

/* has_limits: faces of infinite energy are left out. To be freed whatever is returned. */
static int32_t find(const curvopt_mesh *m, const double *xyz, const curvopt_options *o, int has_limits,
                    co_exceptions *e, curvopt_error *error) {
    *e = (co_exceptions){.vertex = CO_NEW(int32_t, m->info.n_vertices), .face = CO_NEW(int32_t, m->info.n_faces)};
    int32_t status = e->vertex && e->face ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        e->vertex[v] = FINE;
    for (int32_t f = 0; status == CURVOPT_OK && f < m->info.n_faces; f++)
        e->face[f] = FINE;
    if (status == CURVOPT_OK)
        status = add_holes(m, o, e, error);
    if (status == CURVOPT_OK && has_limits)
        status = add_infinite(m, xyz, e, error);
    if (status == CURVOPT_OK)
        add_neighbours(m, e);
    return status;
}

int32_t co_exceptions_find(const curvopt_mesh *m, const double *xyz, const curvopt_options *o, co_exceptions *e,
                           curvopt_error *error) {
    int32_t status = find(m, xyz, o, 1, e, error);
    if (status != CURVOPT_OK)
        co_exceptions_free(e);
    return status;
}

/* Names the vertex that most likely is to be looked at: the first with a reason of its own. */
static int32_t refuse_all(const curvopt_mesh *m, const co_exceptions *e, curvopt_error *error) {
    int32_t v = 0;
    while (v + 1 < m->info.n_vertices && (e->vertex[v] == FINE || e->vertex[v] == CURVOPT_EXCEPTION_ISOLATED ||
                                          e->vertex[v] == CURVOPT_EXCEPTION_BESIDE))
        v++;
    if (e->vertex[v] == CURVOPT_EXCEPTION_BESIDE || e->vertex[v] == FINE)
        return co_status_fail(error, CURVOPT_ERROR_SURFACE, -1, "no face is left in the energy: all %d are holes",
                              m->info.n_faces);
    return co_status_fail(
        error, CURVOPT_ERROR_SURFACE, v,
        "no face is left in the energy: all %d are held as they are, the first at vertex %d, where %s", m->info.n_faces,
        v, curvopt_exception_text(e->vertex[v]));
}

/* ERROR_GEOMETRY where edges of length 0 leave no tangent plane to a face that is no hole; xyz may be NULL. */
static int32_t check_degenerate(const curvopt_mesh *m, const double *xyz, const co_exceptions *e,
                                curvopt_error *error) {
    uint8_t *degenerate = CO_NEW(uint8_t, m->info.n_corners);
    int32_t status = degenerate ? CURVOPT_OK : co_status_no_memory(error), v = -1;
    if (status == CURVOPT_OK && xyz)
        status = co_degenerate_mark(m, xyz, degenerate, error);
    for (int32_t h = m->info.n_corners - 1; status == CURVOPT_OK && h >= 0; h--)
        v = degenerate[h] && e->face[m->corner_face[h]] == FINE ? m->corner_vertex[h] : v;
    free(degenerate);
    if (v >= 0)
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, v,
                              "edges of length 0 leave the surface no tangent plane at vertex %d, and energies of "
                              "curvature are infinite",
                              v);
    return status;
}

int32_t co_exceptions_of_run(const curvopt_mesh *m, const double *xyz, const curvopt_options *o, co_exceptions *e,
                             curvopt_error *error) {
    *e = (co_exceptions){0};
    int32_t status = o->strict ? co_mesh_check_manifold(m, error) : CURVOPT_OK;
    if (status == CURVOPT_OK)
        status = find(m, xyz, o, !o->strict, e, error);
    if (status == CURVOPT_OK && o->strict)
        status = check_degenerate(m, xyz, e, error);
    if (status == CURVOPT_OK && e->n_left_out == m->info.n_faces)
        status = refuse_all(m, e, error);
    if (status != CURVOPT_OK)
        co_exceptions_free(e);
    return status;
}

/* -------------------------------------------------------------------------------------------- refusals -- */

/* The cage's vertex at (0, 0) of a patch with an irregular fan, or -1 where that is the centre of a face that is no
 * quad: subdivision makes no others. */
static int32_t vertex_of(const curvopt_mesh *m, const co_place *place) {
    int32_t first = m->face_start[place->face];
    int right = place->origin[0] > 0.5, up = place->origin[1] > 0.5;
    if (co_mesh_face_size(m, place->face) != 4)
        return right && up ? -1 : m->corner_vertex[first + place->quarter];
    return m->corner_vertex[first + (up ? 3 - right : right)];
}

static int32_t first_patch_of(const co_patches *p, int32_t fan) {
    int32_t i = 0;
    while (p->kind[i] != fan)
        i++;
    return i;
}

/* Names the extraordinary vertex of the least number, or the first face that has one at its centre. */
static int32_t refuse_limit(const curvopt_mesh *m, const co_patches *p, curvopt_error *error) {
    int32_t vertex = -1, face = -1;
    for (int32_t i = 0; i < p->n_patches; i++) {
        if (p->kind[i] == CO_FAN_REGULAR)
            continue;
        int32_t v = vertex_of(m, &p->place[i]), f = p->place[i].face;
        if (v >= 0 && (vertex < 0 || v < vertex))
            vertex = v;
        if (v < 0 && (face < 0 || f < face))
            face = f;
    }
    if (vertex >= 0)
        return co_status_fail(error, CURVOPT_ERROR_SURFACE, vertex,
                              "the `limit` surface has no finite third-order energy at extraordinary vertices, and "
                              "vertex %d is one; use another surface",
                              vertex);
    return co_status_fail(error, CURVOPT_ERROR_SURFACE, -1,
                          "the `limit` surface has no finite third-order energy at the centre of face %d, which has %d "
                          "sides; use another surface",
                          face, co_mesh_face_size(m, face));
}

static int32_t refuse_infinite(int32_t v, int32_t fan, curvopt_error *error) {
    if (co_fan_type_of(fan) == CO_FAN_CONE)
        return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                              "vertex %d is infinitely sharp: the surface has a cone there, and energies of curvature "
                              "are infinite",
                              v);
    return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                          "vertex %d is a corner of %d faces: the surface has a cone there, and energies of "
                          "curvature are infinite; one face between two sharp edges is what a corner can have",
                          v, co_fan_sectors(fan));
}

int32_t co_admissibility_check(const curvopt_mesh *mesh, const co_patches *p, const co_functional *f, int32_t surface,
                               int *third_allowed, curvopt_error *error) {
    *third_allowed = 1;
    for (int32_t k = 0; k < p->n_kinds; k++) {
        int32_t fan = p->kinds[k];
        if (fan == CO_FAN_REGULAR || co_blend_fit_surface(surface, fan) != CURVOPT_SURFACE_LIMIT)
            continue;
        if (!co_fan_is_integrable(fan))
            return refuse_infinite(vertex_of(mesh, &p->place[first_patch_of(p, fan)]), fan, error);
        if (f->has_third)
            return refuse_limit(mesh, p, error);
        *third_allowed = 0;
    }
    return CURVOPT_OK;
}

/* Which energies are finite on which surface of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/admissibility.h"

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
    int32_t n = co_fan_sectors(fan);
    if (co_fan_type_of(fan) == CO_FAN_CONE)
        return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                              "vertex %d is infinitely sharp: the surface has a cone there, and energies of curvature "
                              "are infinite",
                              v);
    if (co_fan_type_of(fan) == CO_FAN_CORNER)
        return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                              "vertex %d is a corner of %d faces: the surface has a cone there, and energies of "
                              "curvature are infinite; one face between two sharp edges is what a corner can have",
                              v, n);
    if (n == 1)
        return co_status_fail(
            error, CURVOPT_ERROR_SURFACE, v,
            "vertex %d has one face where boundary or crease run smoothly through it: energies of "
            "curvature are infinite there; make it an infinitely sharp vertex (on boundaries the rule `corners` does)",
            v);
    return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                          "vertex %d has %d faces on one side of boundary or crease: the surface has no tangent plane "
                          "there, and energies of curvature are infinite; it can have 2 or 3",
                          v, n);
}

int32_t co_admissibility_check(const curvopt_mesh *mesh, const co_patches *p, const co_functional *f, int32_t surface,
                               int *third_allowed, curvopt_error *error) {
    *third_allowed = 1;
    for (int32_t k = 0; k < p->n_kinds; k++) {
        int32_t fan = p->kinds[k];
        int smooth = co_fan_is_smooth(fan);
        if (fan == CO_FAN_REGULAR)
            continue;
        int32_t v = smooth ? -1 : vertex_of(mesh, &p->place[first_patch_of(p, fan)]);
        if (!co_fan_is_integrable(fan))
            return refuse_infinite(v, fan, error);
        if (f->has_third && !smooth)
            return co_status_fail(error, CURVOPT_ERROR_SURFACE, v,
                                  "vertex %d is extraordinary and lies on a boundary or an infinitely sharp crease: no "
                                  "surface of this build has a finite third-order energy there",
                                  v);
        if (f->has_third && surface == CURVOPT_SURFACE_LIMIT)
            return refuse_limit(mesh, p, error);
        *third_allowed &= smooth && surface != CURVOPT_SURFACE_LIMIT;
    }
    return CURVOPT_OK;
}

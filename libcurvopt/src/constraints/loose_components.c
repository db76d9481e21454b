/* Components in which nothing is held. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/loose_components.h"

#include "base/memory.h"
#include "mesh/components.h"

#include <stdlib.h>

/* Sets is_held [n components] of those that have a vertex that is held or drawn; returns their number. */
static int32_t mark_held(const curvopt_mesh *m, const co_constraints *all, const co_components *parts,
                         uint8_t *is_held) {
    int32_t n = 0;
    for (int32_t v = 0; all->freedom && v < m->info.n_vertices; v++) {
        const int32_t c = parts->of_vertex[v];
        const int is_drawn = all->springs.stiffness && all->springs.stiffness[v] > 0;
        if (c < 0 || is_held[c] || (all->freedom[v] == CO_FREEDOM_ALL && !is_drawn))
            continue;
        is_held[c] = 1;
        n++;
    }
    return n;
}

int32_t co_loose_components_leave_out(const curvopt_mesh *m, int32_t boundary, co_constraints *constraints,
                                      curvopt_error *error) {
    co_constraints all = {0};
    co_components parts;
    uint8_t *is_held = NULL;
    int32_t n = 0;
    if (m->info.n_components < 2)
        return CURVOPT_OK;
    int32_t status = co_components_find(m, &parts, error);
    if (status != CURVOPT_OK)
        return status;
    if (parts.n > 1)
        status = co_constraints_all(m, constraints, boundary, &all, error);
    if (status == CURVOPT_OK) {
        is_held = CO_NEW(uint8_t, parts.n);
        status = is_held ? CURVOPT_OK : co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        n = mark_held(m, &all, &parts, is_held);
    const int leaves_out = n > 0 && n < parts.n;
    if (leaves_out && !constraints->left_out) {
        constraints->left_out = CO_NEW(uint8_t, m->info.n_faces);
        status = constraints->left_out ? CURVOPT_OK : co_status_no_memory(error);
    }
    for (int32_t f = 0; leaves_out && status == CURVOPT_OK && f < m->info.n_faces; f++)
        if (!is_held[parts.of_face[f]])
            constraints->left_out[f] = 1;
    free(is_held);
    co_constraints_free(&all);
    co_components_free(&parts);
    return status;
}

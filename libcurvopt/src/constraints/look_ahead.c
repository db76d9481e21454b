/* Vertices of the last level's cage, held on coarser levels. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/look_ahead.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct mask {
    const co_constraints *constraints;
    int32_t of;         /* whose mask it is */
    int reaches_others; /* whether a point of the surface is held in the place of another one */
} mask;

static void see_entry(int32_t v, double weight, void *context) {
    mask *to = context;
    (void)weight;
    to->reaches_others |= v != to->of && to->constraints->of_limit[v];
}

static mask mask_of(const curvopt_mesh *m, const co_constraints *c, int32_t v) {
    mask out = {.constraints = c, .of = v};
    co_vertex_mask_visit(m, v, see_entry, &out);
    return out;
}

void co_look_ahead(const curvopt_mesh *m, int32_t subdivisions, co_constraints *c) {
    for (int32_t v = 0; c->freedom && !c->springs.stiffness && subdivisions > 0 && v < m->info.n_vertices; v++) {
        if (c->freedom[v] == CO_FREEDOM_ALL || c->of_limit[v] || !co_vertex_mask_exists(m, v) ||
            co_constraints_are_of_face(m, c, v))
            continue;
        c->of_limit[v] = CO_OF_OWN_POINT;
        c->subdivisions[v] = (uint8_t)subdivisions;
    }
}

int32_t co_look_ahead_leave_overlapping(const curvopt_mesh *m, co_constraints *c, curvopt_error *error) {
    uint8_t *overlaps = CO_NEW(uint8_t, m->info.n_vertices);
    if (!overlaps)
        return co_status_no_memory(error);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        overlaps[v] = co_looks_ahead_at(c, v) && mask_of(m, c, v).reaches_others;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        if (overlaps[v]) {
            c->of_limit[v] = CO_OF_VERTEX;
            c->subdivisions[v] = 0;
        }
    free(overlaps);
    return CURVOPT_OK;
}

int co_looks_ahead(const curvopt_mesh *m, const co_constraints *c) {
    for (int32_t v = 0; c->freedom && v < m->info.n_vertices; v++)
        if (co_looks_ahead_at(c, v))
            return 1;
    return 0;
}

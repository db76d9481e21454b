/* Connected components by flooding. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/components.h"

#include "base/memory.h"

#include <stdlib.h>

/* Corners of each vertex: those of v are corner[first[v]] to corner[first[v + 1] - 1]. first [n_vertices + 2]: the last
 * one is work space. */
static void list_corners(const curvopt_mesh *m, int32_t *first, int32_t *corner) {
    for (int32_t h = 0; h < m->info.n_corners; h++)
        first[m->corner_vertex[h] + 2]++;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        first[v + 2] += first[v + 1];
    for (int32_t h = 0; h < m->info.n_corners; h++)
        corner[first[m->corner_vertex[h] + 1]++] = h;
}

/* Gives the component's number to all faces and vertices that hang together with face `seed`. */
static void flood(const curvopt_mesh *m, const int32_t *first, const int32_t *corner, int32_t seed, int32_t number,
                  int32_t *stack, co_components *out) {
    int32_t depth = 0;
    out->of_face[seed] = number;
    stack[depth++] = seed;
    while (depth > 0) {
        const int32_t f = stack[--depth];
        for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++) {
            const int32_t v = m->corner_vertex[h];
            if (out->of_vertex[v] >= 0)
                continue;
            out->of_vertex[v] = number;
            for (int32_t k = first[v]; k < first[v + 1]; k++) {
                const int32_t g = m->corner_face[corner[k]];
                if (out->of_face[g] >= 0)
                    continue;
                out->of_face[g] = number;
                stack[depth++] = g;
            }
        }
    }
}

/* number[i]: how many of the items before i are of the same component as i. count [n_components], 0. */
static void number_within(int32_t n, const int32_t *component, int32_t *count, int32_t *number) {
    for (int32_t i = 0; i < n; i++)
        if (component[i] >= 0)
            number[i] = count[component[i]]++;
}

int32_t co_components_find(const curvopt_mesh *m, co_components *out, curvopt_error *error) {
    const int32_t n_vertices = m->info.n_vertices, n_faces = m->info.n_faces;
    *out = (co_components){.of_face = CO_NEW(int32_t, n_faces),
                           .of_vertex = CO_NEW(int32_t, n_vertices),
                           .face = CO_NEW(int32_t, n_faces),
                           .vertex = CO_NEW(int32_t, n_vertices)};
    int32_t *first = CO_NEW(int32_t, (size_t)n_vertices + 2), *corner = CO_NEW(int32_t, m->info.n_corners);
    int32_t *stack = CO_NEW(int32_t, n_faces), *count = CO_NEW(int32_t, 2 * (size_t)n_faces), status = CURVOPT_OK;
    if (!out->of_face || !out->of_vertex || !out->face || !out->vertex || !first || !corner || !stack || !count) {
        co_components_free(out);
        status = co_status_no_memory(error);
        goto done;
    }
    for (int32_t f = 0; f < n_faces; f++)
        out->of_face[f] = -1;
    for (int32_t v = 0; v < n_vertices; v++)
        out->of_vertex[v] = -1;
    list_corners(m, first, corner);
    for (int32_t f = 0; f < n_faces; f++)
        if (out->of_face[f] < 0)
            flood(m, first, corner, f, out->n++, stack, out);
    number_within(n_faces, out->of_face, count, out->face);
    number_within(n_vertices, out->of_vertex, count + out->n, out->vertex);
done:
    free(first);
    free(corner);
    free(stack);
    free(count);
    return status;
}

void co_components_free(co_components *c) {
    free(c->of_face);
    free(c->of_vertex);
    free(c->face);
    free(c->vertex);
    *c = (co_components){0};
}

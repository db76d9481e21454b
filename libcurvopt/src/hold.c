/* Vertices that a minimization leaves where they are. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hold.h"

#include "crease.h"
#include "memory.h"

#include <stdlib.h>
#include <string.h>

/* The next row: vertices of faces with a held one. face [n_faces] is work space. */
static void add_row(const curvopt_mesh *m, uint8_t *held, uint8_t *face) {
    memset(face, 0, (size_t)m->info.n_faces);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        face[m->corner_face[h]] |= held[m->corner_vertex[h]];
    for (int32_t h = 0; h < m->info.n_corners; h++)
        held[m->corner_vertex[h]] |= face[m->corner_face[h]];
}

int32_t co_hold_create(const curvopt_mesh *m, int32_t boundary, uint8_t **held, curvopt_error *error) {
    int any = 0, rows = boundary == CURVOPT_BOUNDARY_CURVATURE ? 2 : boundary == CURVOPT_BOUNDARY_TANGENT;
    *held = NULL;
    if (boundary == CURVOPT_BOUNDARY_FREE || !(m->info.n_boundary_edges || m->edge_sharpness || m->vertex_sharpness))
        return CURVOPT_OK;
    uint8_t *mark = CO_NEW(uint8_t, m->info.n_vertices), *face = CO_NEW(uint8_t, m->info.n_faces);
    if (!mark || !face) {
        free(mark);
        free(face);
        return co_status_no_memory(error);
    }
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        mark[v] = co_mesh_is_boundary_vertex(m, v);
    for (int row = 0; row < rows; row++)
        add_row(m, mark, face);
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        mark[v] |= co_crease_is_infinite(co_crease_vertex(m, v));
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (co_crease_is_infinite(co_crease_edge(m, h)))
            mark[m->corner_vertex[h]] = mark[co_mesh_destination(m, h)] = 1;
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        any |= mark[v];
    free(face);
    if (any)
        *held = mark;
    else
        free(mark);
    return CURVOPT_OK;
}

void co_hold_clear(const uint8_t *held, int32_t n_vertices, double *xyz) {
    for (int32_t v = 0; held && v < n_vertices; v++)
        if (held[v])
            memset(xyz + 3 * (size_t)v, 0, 3 * sizeof *xyz);
}

void co_hold_copy(const uint8_t *held, int32_t n_vertices, const double *from, double *to) {
    for (int32_t v = 0; held && v < n_vertices; v++)
        if (held[v])
            memcpy(to + 3 * (size_t)v, from + 3 * (size_t)v, 3 * sizeof *to);
}

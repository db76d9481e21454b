/* A group of symmetries of a cage. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SYMMETRY_GROUP_H
#define CO_CONSTRAINTS_SYMMETRY_GROUP_H

#include "mesh/mesh.h"

#include <stddef.h>

/* Distance from a vertex's image to a vertex up to which they count as one, in units of the cage's radius. Single
 * precision, in which Blender keeps cages, leaves some 1e-7 (libcurvopt/notes/60-keeping-symmetry.md). */
#define CO_SYMMETRY_TOLERANCE 1e-5

/* A group; element 0 is the identity. Motions are about the centroid of the vertices. */
typedef struct co_symmetry {
    int32_t order;     /* number of elements */
    int32_t n_corners; /* corners of the mesh */
    int32_t *corner;   /* [order][n_corners] image of each corner of the mesh */
    uint8_t *mirrored; /* [order] whether faces come to run the other way round */
    double *matrix;    /* [order][9] orthogonal, by rows; an exact representation of the group but for rounding */
    int32_t *product;  /* [order][order] index of "the second, then the first" */
} co_symmetry;

/* The trivial group. ERROR_MEMORY. */
int32_t co_symmetry_none(const curvopt_mesh *mesh, co_symmetry *out, curvopt_error *error);
void co_symmetry_free(co_symmetry *symmetry);
/* From a cage to its subdivision (subdivide.h). ERROR_MEMORY. */
int32_t co_symmetry_subdivide(co_symmetry *symmetry, curvopt_error *error);

/* Where element g takes a vertex; an isolated one stays. */
static inline int32_t co_symmetry_vertex(const co_symmetry *s, const curvopt_mesh *m, int32_t g, int32_t v) {
    if (m->vertex_corner[v] < 0)
        return v;
    return m->corner_vertex[s->corner[(size_t)g * (size_t)s->n_corners + (size_t)m->vertex_corner[v]]];
}

#endif

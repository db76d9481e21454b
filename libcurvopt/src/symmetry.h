/* A cage's symmetries: automorphisms of its connectivity that are rigid motions of its vertices.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SYMMETRY_H
#define CO_SYMMETRY_H

#include "hold.h"

#include <stddef.h>

/* A group; element 0 is the identity. Motions are about the centroid of the vertices. */
typedef struct co_symmetry {
    int32_t order;
    int32_t n_corners;
    int32_t *corner;   /* [order][n_corners] where each corner of the mesh goes */
    uint8_t *mirrored; /* [order] whether faces come to run the other way round */
    double *matrix;    /* [order][9] orthogonal, by rows; an exact representation of the group but for rounding */
    int32_t *product;  /* [order][order] index of "the second, then the first" */
} co_symmetry;

/* The group of `mesh` at xyz [3 n_vertices], in which every vertex comes within SYMMETRY_TOLERANCE of the cage's size
 * to its image, sharpness is kept, and so are constraints; `with_mirrors`: also those that mirror faces. More than
 * LARGEST_ORDER elements count as none. ERROR_MEMORY.
 */
int32_t co_symmetry_create(const curvopt_mesh *mesh, const double *xyz, const co_hold *hold, int with_mirrors,
                           co_symmetry *out, curvopt_error *error);
/* The trivial group. ERROR_MEMORY. */
int32_t co_symmetry_none(const curvopt_mesh *mesh, co_symmetry *out, curvopt_error *error);
/* The subgroup of the elements marked in member [order], which must be one. ERROR_MEMORY. */
int32_t co_symmetry_select(const co_symmetry *symmetry, const uint8_t *member, co_symmetry *out, curvopt_error *error);
void co_symmetry_free(co_symmetry *symmetry);
/* From a cage to its subdivision (refine.h). ERROR_MEMORY. */
int32_t co_symmetry_refine(co_symmetry *symmetry, curvopt_error *error);

/* Where element g takes a vertex. */
static inline int32_t co_symmetry_vertex(const co_symmetry *s, const curvopt_mesh *m, int32_t g, int32_t v) {
    return m->corner_vertex[s->corner[(size_t)g * (size_t)s->n_corners + (size_t)m->vertex_corner[v]]];
}

#endif

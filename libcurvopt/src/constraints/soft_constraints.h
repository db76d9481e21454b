/* Soft constraints: vertices that springs pull back to where they were. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SOFT_CONSTRAINTS_H
#define CO_CONSTRAINTS_SOFT_CONSTRAINTS_H

#include "constraints/freedom.h"
#include "linalg/sparse_rows.h"
#include "mesh/mesh.h"

#include <math.h>

/* Springs that pull vertices back. The term that they add to the objective, with R the radius of the input cage and K
 * the stiffness of the objective (penalty.h), is
 *
 *     K / (2 R^2)  sum over vertices  k_v |Q_v (x_v - a_v)|^2 ,      k_v = m_v w_v / (1 - w_v) ,
 *
 * Q_v the projector onto the directions that the constraint takes away, a_v where the vertex was. The weight w_v comes
 * from the user: no force at 0, firmer without bound towards 1, and at w the vertex goes back by the part w of the way
 * against the surface's stiffness K. The mass m_v makes a painted patch one handle, however many vertices it has: over
 * each connected patch of vertices with a weight it is max w / sum w. That is 1 for a single vertex, 1/n for n of one
 * weight, and does not jump when a weight at the edge of the patch goes to 0 (unless that tears the patch in two).
 * Exact constraints, w = 1, count in their patch. */
typedef struct co_soft_constraints {
    double *stiffness; /* [n_vertices] k_v; NULL: no vertex has a spring */
    uint8_t *freedom;  /* [n_vertices] dimensions in which there is no force, as in co_constraints */
    double *direction; /* [3 n_vertices] unit: along the line, or normal to the plane */
    double *anchor;    /* [3 n_vertices] a_v, in the user's units */
    double *original;  /* [3 n_vertices] the input cage, subdivided as often as this one */
    double reach;      /* how far from a_v a vertex gets whose spring leaves no direction free, in the user's units */
    double weighed_by; /* objective of which springs are to be worth a part, whatever it becomes; 0: they are as they
                          are */
} co_soft_constraints;

/* Makes springs where 0 < weight [n_vertices] < 1, of these freedoms and directions, at xyz [3 n_vertices].
 * ERROR_MEMORY. */
int32_t co_soft_constraints_create(const curvopt_mesh *mesh, const double *xyz, const double *weight,
                                   const uint8_t *freedom, const double *direction, co_soft_constraints *out,
                                   curvopt_error *error);
/* Adds springs of stiffnesses k_v [n_vertices] that pull every vertex back to xyz [3 n_vertices] from anywhere, and end
 * at `reach`. Springs that leave a vertex directions to move freely in stay what they are. ERROR_MEMORY. */
int32_t co_soft_constraints_add_all(const curvopt_mesh *mesh, const double *xyz, const double *stiffness, double reach,
                                    co_soft_constraints *springs, curvopt_error *error);
/* ERROR_MEMORY. */
int32_t co_soft_constraints_copy(const curvopt_mesh *mesh, const co_soft_constraints *from, co_soft_constraints *to,
                                 curvopt_error *error);
void co_soft_constraints_free(co_soft_constraints *springs);

/* From a cage to its subdivision `fine` by `rows` (subdivide.h). As with exact constraints (constraints.h), faces all
 * of whose vertices have springs of one kind are constrained as pieces of the surface: their children have springs to
 * the places where subdividing the input puts them, and the stiffness is distributed over them, so that a patch is as
 * stiff as it was. Any other vertex keeps its spring and its first place, or where springs end the place where
 * subdividing the input puts it. ERROR_MEMORY. */
int32_t co_soft_constraints_subdivide(const curvopt_mesh *mesh, const curvopt_mesh *fine, const co_sparse_rows *rows,
                                      co_soft_constraints *springs, curvopt_error *error);

/* Takes the spring of vertex v away if its end is not twice as far as v is, at x. */
void co_soft_constraints_drop_beyond(co_soft_constraints *springs, int32_t v, const double x[3]);

/* Whether vertex v has a spring that ends at springs->reach. */
static inline int co_soft_constraints_has_end(const co_soft_constraints *springs, int32_t v) {
    return springs->freedom && springs->freedom[v] == CO_FREEDOM_NONE && springs->reach < (double)INFINITY;
}

/* Whether the springs of vertices v and w are alike, directions aside. */
int co_soft_constraints_alike(const co_soft_constraints *springs, int32_t v, int32_t w);

#endif

/* Whether constraints leave a cage its size. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/constraints.h"
#include "constraints/held_curvatures.h"

#include "base/vec3.h"
#include "linalg/small_dense.h"
#include "mesh/similarity.h"

/* How far off places may be, in radii of the input. */
static const double SAME_PLACE = 1e-6;
/* Of the trace, added to the matrix: a point may lie anywhere where nothing says where it is. */
static const double SMALL = 1e-12;

/* Places a_k that are held in the directions of projectors Q_k: an enlargement from c leaves them where Q_k (a_k - c)
 * is 0. The sums of least squares for c. */
typedef struct places {
    const double *centre; /* from which places count: c, where it is known */
    double matrix[9];     /* sum of Q_k */
    double right[3];      /* sum of Q_k a_k */
    double farthest;      /* largest |Q_k (a_k - c)|^2 */
} places;

static void add(places *p, int freedom, const double *direction, const double at[3]) {
    double left[9], from[3], held[3];
    if (freedom == CO_FREEDOM_ALL)
        return;
    co_freedom_projector(freedom, direction, left);
    for (int c = 0; c < 3; c++)
        from[c] = at[c] - p->centre[c];
    co_small_dense_apply_3(left, from, held);
    for (int c = 0; c < 3; c++) {
        held[c] = from[c] - held[c];
        p->right[c] += held[c];
        for (int d = 0; d < 3; d++)
            p->matrix[3 * c + d] += (c == d) - left[3 * c + d];
    }
    const double square = co_dot3(held, held);
    p->farthest = square > p->farthest ? square : p->farthest;
}

static void add_values(places *p, const co_surface_values *values) {
    for (int32_t i = 0; i < values->n; i++)
        if (!values->item[i].order)
            add(p, values->item[i].freedom, values->item[i].direction, values->item[i].anchor);
}

static void add_all(places *p, const curvopt_mesh *m, const double *xyz, const co_constraints *all) {
    const co_soft_constraints *springs = &all->springs;
    for (size_t v = 0; v < (size_t)m->info.n_vertices; v++) {
        if (m->vertex_corner[v] < 0) /* held, but of no surface */
            continue;
        if (all->of_limit[v] <= CO_OF_OWN_POINT) /* the others are values */
            add(p, all->freedom[v], all->direction + 3 * v, (all->of_limit[v] ? all->anchor : xyz) + 3 * v);
        if (springs->stiffness && springs->stiffness[v] > 0)
            add(p, springs->freedom[v], springs->direction + 3 * v, springs->anchor + 3 * v);
    }
    add_values(p, &all->values);
    add_values(p, &all->drawn);
}

int co_constraints_allow_dilation(const curvopt_mesh *m, const double *xyz, const co_constraints *all, double radius) {
    double inverse[9], centre[3], origin[3];
    if (!all->freedom)
        return 1;
    if (all->chains.n || co_held_curvatures_exist(&all->values) || co_held_curvatures_exist(&all->drawn))
        return 0;
    co_similarity_mesh_frame(m, xyz, origin);
    places found = {.centre = origin}, left = {.centre = centre};
    add_all(&found, m, xyz, all);
    const double trace = found.matrix[0] + found.matrix[4] + found.matrix[8];
    if (trace == 0)
        return 1;
    for (int c = 0; c < 3; c++)
        found.matrix[4 * c] += SMALL * trace;
    co_small_dense_invert(3, 3, found.matrix, inverse);
    co_small_dense_apply_3(inverse, found.right, centre);
    for (int c = 0; c < 3; c++)
        centre[c] += origin[c];
    add_all(&left, m, xyz, all);
    return left.farthest <= SAME_PLACE * SAME_PLACE * radius * radius;
}

/* Motions that leave an objective as it is. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/gauge.h"

#include "base/constants.h"
#include "linalg/vector.h"

enum { N_SIMILARITIES = 7 };

co_gauge co_gauge_of(const double weights[CURVOPT_N_TERMS], const co_constraints *constraints, int sees_numbers) {
    if (constraints->freedom)
        return CO_GAUGE_NONE;
    if (sees_numbers)
        return CO_GAUGE_SIMILARITY;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (weights[t] > 0 && t != CURVOPT_TERM_WILLMORE && t != CURVOPT_TERM_MEAN)
            return CO_GAUGE_SIMILARITY;
    return CO_GAUGE_MOEBIUS;
}

/* Motion k at x: scaling, translations, rotations, then 2 (b.x) x - |x|^2 b for the axes b. */
static void motion(int k, const double *x, double out[3]) {
    int axis = (k + 2) % 3;
    double square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    for (int c = 0; c < 3; c++)
        out[c] = k == 0 ? x[c] : k >= N_SIMILARITIES ? 2 * x[axis] * x[c] : 0;
    if (k == 0)
        return;
    if (k <= 3)
        out[axis] = 1;
    else if (k < N_SIMILARITIES) {
        out[(axis + 1) % 3] = -x[(axis + 2) % 3];
        out[(axis + 2) % 3] = x[(axis + 1) % 3];
    } else {
        out[axis] -= square;
    }
}

/* Makes a column orthogonal to the n_before ones in front of it, and of length 1; 0 if it depends on them. */
static int make_orthonormal(size_t n, size_t n_before, const double *before, double *column) {
    double whole = co_vector_norm(n, column);
    for (int pass = 0; pass < 2; pass++) /* twice, against rounding */
        co_vector_remove(n, n_before, before, column);
    double norm = co_vector_norm(n, column);
    if (!(norm > CO_INDEPENDENT_MOTION * whole) || whole == 0)
        return 0;
    for (size_t i = 0; i < n; i++)
        column[i] /= norm;
    return 1;
}

int co_gauge_columns(const co_dof_map *dofs, const double *x, co_gauge gauge, double *full, double *out) {
    const size_t n = (size_t)dofs->n_variables, n_vertices = (size_t)dofs->n_vertices;
    const int n_motions = gauge == CO_GAUGE_NONE ? 0 : gauge == CO_GAUGE_SIMILARITY ? N_SIMILARITIES : CO_GAUGE_MOTIONS;
    const double least = CO_ALLOWED_MOTION;
    int count = 0;
    for (int k = 0; k < n_motions; k++) {
        double *column = out + (size_t)count * n;
        for (size_t v = 0; v < n_vertices; v++)
            motion(k, x + 3 * v, full + 3 * v);
        double whole = co_vector_norm(3 * n_vertices, full);
        co_dof_map_gradient(dofs, full, column);
        if (co_vector_norm(n, column) > least * whole) /* else it breaks the symmetry, or slides */
            count += make_orthonormal(n, (size_t)count, out, column);
    }
    return count;
}

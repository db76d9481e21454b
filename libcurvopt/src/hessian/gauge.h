/* Motions that leave an objective as it is: similarities, and for Willmore's energy Moebius maps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_GAUGE_H
#define CO_HESSIAN_GAUGE_H

#include "constraints/dof_map.h"

typedef enum co_gauge {
    CO_GAUGE_NONE,       /* none: vertices are constrained */
    CO_GAUGE_SIMILARITY, /* translations, rotations, scaling */
    CO_GAUGE_MOEBIUS     /* also infinitesimal inversions: of Willmore's energy, up to discretization */
} co_gauge;

enum { CO_GAUGE_MOTIONS = 10 }; /* most of any gauge */

/* The motions of an objective with these weights (curvopt_term) and these constraints; `sees_numbers`: numbers of the
 * whole surface are held, or there is spontaneous curvature; they see Moebius maps. */
co_gauge co_gauge_of(const double weights[CURVOPT_N_TERMS], const co_constraints *constraints, int sees_numbers);
/* The motions among `gauge` along which the discrete gradient vanishes, too. */
static inline co_gauge co_gauge_exact(co_gauge gauge) {
    return gauge == CO_GAUGE_MOEBIUS ? CO_GAUGE_SIMILARITY : gauge;
}

/* The motions at x [3 n_vertices], as far as the variables allow them: orthonormal columns out [CO_GAUGE_MOTIONS + 1]
 * [n_variables], the last of them work. Returns their number. full [3 n_vertices] is work.
 *
 * A motion counts if CO_ALLOWED_MOTION of it is within the variables. With every vertex on its normal a rotation of a
 * torus about its axis keeps next to nothing, and that only because the torus is discrete: to make that stiff would
 * decide the decrement (libcurvopt/notes/72-invariances.md). */
int co_gauge_columns(const co_dof_map *dofs, const double *x, co_gauge gauge, double *full, double *out);

#endif

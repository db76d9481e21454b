/* A cage moved so that values of its surface are what they are to be. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_PLACEMENT_H
#define CO_CONSTRAINTS_PLACEMENT_H

#include "constraints/interpolation.h"

/* Moves vertices of xyz [3 n_vertices] so that the rows of map->limit have the values wanted [3 n_rows], as far as they
 * are held: of a tangent that has a normal, the part along it, and not its length. Those that nothing holds, or in
 * whose place a value is, move, and all of them together as little as can be, by
 *
 *     dx = M^T (H M M^T H)^-1 H (wanted - M x) ,
 *
 * H: the projector onto what is held.
 * The vertices in whose place values are would be enough (interpolation.h), but would fold the cage more often. By
 * conjugate gradients, and what these leave by those vertices. ERROR_MEMORY. */
int32_t co_placement_move(const co_interpolation *map, const co_constraints *constraints, const double *wanted,
                          double *xyz, curvopt_error *error);

#endif

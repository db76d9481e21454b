/* Surfaces of cages with the same faces. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_CORRESPONDENCE_H
#define CO_MEASURE_CORRESPONDENCE_H

#include "mesh/mesh.h"

/* *farthest: the largest distance between a vertex of one cage and its partner of the other, where one of them, xyz [2]
 * [3 n_vertices] each, has the other's faces and creases, or would have after subdivision; else INFINITY. Points of the
 * limit surfaces are the same means of vertices, with weights of 0 and more: none is farther from its partner.
 * ERROR_SIZE, ERROR_MEMORY. */
int32_t co_correspondence_farthest(const curvopt_mesh *const mesh[2], const double *const xyz[2], double *farthest,
                                   curvopt_error *error);

#endif

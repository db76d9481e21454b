/* Vertices put between others, as a thin plate would lie. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_FILL_H
#define CO_MESH_FILL_H

#include "base/cancel.h"
#include "base/thread_pool.h"
#include "mesh/mesh.h"

/* Moves the vertices of is_free [n_vertices] to where the sum of |x - mean of its neighbours|^2 over all vertices is
 * least; the others stay, and so does what none of them holds. xyz [3 n_vertices], or displacements as many. This is
 * the discrete thin plate of M. Botsch, L. Kobbelt, "An intuitive framework for real-time freeform modeling", ACM TOG
 * 23(3), 2004, with uniform weights: those by lengths or angles are none where a cage is folded. By a Cholesky factor.
 * threads and cancel may be NULL. ERROR_MEMORY; CO_CANCELLED, and nothing has moved. */
int32_t co_mesh_fill(const curvopt_mesh *mesh, const uint8_t *is_free, co_thread_pool *threads, co_cancel *cancel,
                     double *xyz, curvopt_error *error);

#endif

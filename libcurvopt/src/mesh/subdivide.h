/* Catmull-Clark subdivision: connectivity, and the refined points as sparse rows over the coarse ones. Sources, and how
 * creases are treated: subdivide.c. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SUBDIVIDE_H
#define CO_MESH_SUBDIVIDE_H

#include "linalg/sparse_rows.h"
#include "mesh/mesh.h"

/* One subdivision of polygons into quads. The result's vertices are the cage's vertices, then one for each edge, then
 * one for each face. Its face number h is the child at corner h of the cage; its corners are that vertex, the edge
 * leaving it, the face, the edge arriving. Its creases are the cage's, one less sharp. rows [result's vertices over the
 * cage's] may be NULL. Linear time. ERROR_SIZE from INT32_MAX / 32 face corners on, ERROR_MEMORY. */
int32_t co_subdivide(const curvopt_mesh *mesh, curvopt_mesh **fine, co_sparse_rows *rows, curvopt_error *error);
/* The same with positions xyz [3 n_vertices], into *fine_xyz, which the caller frees; nothing is left on failure. */
int32_t co_subdivide_cage(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **fine, co_sparse_rows *rows,
                          double **fine_xyz, curvopt_error *error);

#endif

/* Catmull-Clark subdivision as rows over the coarse points. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SUBDIVIDE_H
#define CO_MESH_SUBDIVIDE_H

#include "linalg/sparse_rows.h"
#include "mesh/mesh.h"

/* One subdivision of polygons into quads: connectivity and the rows that give its points. Vertices of the result are
 * the cage's vertices, then its edges, then its faces; face number h is the child at corner h: vertex, edge
 * leaving it, face, edge arriving. Creases go with it, one softer. `rows` may be NULL. */
int32_t co_subdivide(const curvopt_mesh *mesh, curvopt_mesh **fine, co_sparse_rows *rows, curvopt_error *error);

#endif

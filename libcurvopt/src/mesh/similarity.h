/* Similarity motions of a cage: its centroid, scale and rotation, on which energies do not depend. Rotations are polar
 * factors: Higham, "Computing the polar decomposition, with applications", SIAM J. Sci. Stat. Comput. 7, 1986.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MESH_SIMILARITY_H
#define CO_MESH_SIMILARITY_H

#include "mesh/mesh.h"

#include <stddef.h>

/* Fills centroid with the mean of n points xyz [3 n] and returns their root mean square distance from it. */
double co_similarity_frame(size_t n, const double *xyz, double centroid[3]);
/* The same without the n_skipped points skipped [n_skipped], ascending. */
double co_similarity_frame_without(size_t n, const double *xyz, size_t n_skipped, const int32_t *skipped,
                                   double centroid[3]);
/* The same of a mesh's vertices xyz [3 n_vertices], isolated ones not counted: energies do not depend on these. */
double co_similarity_mesh_frame(const curvopt_mesh *mesh, const double *xyz, double centroid[3]);
/* Largest distance of a place from the middle of a cage, in its sizes: doubles have no digits for both. */
#define CO_SIMILARITY_FARTHEST 1e9
/* Whether a place is no farther away than that from the centroid of a frame of this radius. */
int co_similarity_reaches(const double centroid[3], double radius, const double place[3]);
/* Replaces m by the orthogonal matrix nearest to it. Returns 0 if m is singular, and m is undefined then. */
int co_similarity_orthogonal_factor(double m[3][3]);
/* Moves xyz [3 n] rigidly to where it lies closest to `reference` [3 n] in the sum of squared distances (Kabsch 1976).
 */
void co_similarity_align(size_t n, const double *reference, double *xyz);

/* ERROR_GEOMETRY, naming the vertex, unless xyz [3 n_vertices] is finite and of some extent: energies may
 * only be evaluated at such positions. */
int32_t co_similarity_check(int32_t n_vertices, const double *xyz, curvopt_error *error);

#endif

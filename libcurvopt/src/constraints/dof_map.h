/* The variables of a minimization: the cage's positions as a linear function of fewer numbers.
 *
 * Pins, sliding along lines and planes, and symmetry are one thing: x_v = offset_v + B_v z_node(v), with the columns of
 * the whole matrix orthonormal, so that lengths of gradients and steps are those of the cage.
 *
 * A node is an orbit of the symmetry that can move: the vertices that symmetries take to each other, which therefore
 * move together, and have 1 to 3 variables together. Without symmetry every vertex that can move is a node. For example
 * on a cube with the mirror plane x = 0 the vertices v at (1, 1, 1) and w at (-1, 1, 1) are one node of three
 * variables:
 *
 *     B_v = 1 / sqrt(2) ( 1 0 0 )      B_w = 1 / sqrt(2) ( -1 0 0 )      a vertex on the plane: its own node, of two
 *                       ( 0 1 0 )                        (  0 1 0 )      variables, along y and z
 *                       ( 0 0 1 )                        (  0 0 1 )
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_DOF_MAP_H
#define CO_CONSTRAINTS_DOF_MAP_H

#include "constraints/symmetry.h"

typedef struct co_dof_map {
    int32_t n_vertices, n_nodes, n_variables;
    int32_t *node;   /* [n_vertices] node that a vertex belongs to; -1: it cannot move */
    int32_t *first;  /* [n_nodes + 1] first variable of each node */
    double *basis;   /* [n_vertices][3][3] B_v: by rows x, y, z, as many columns as the node has variables */
    double *offset;  /* [3 n_vertices]; NULL: 0, as where nothing is constrained */
    double *stretch; /* [n_nodes] length of B_v's columns: 1 / sqrt(vertices of the node); NULL where `plain`: 1 */
    int plain;       /* every vertex is a node, and every B_v the identity */
    double
        *translation; /* [3][n_variables] unit translations of the cage along x, y, z, as far as they keep symmetry, by
                         which centroid and size are removed; NULL where there is an offset, and in the identity */
} co_dof_map;

/* Number of variables of a node. */
static inline int32_t co_dof_map_dimension(const co_dof_map *dofs, int32_t node) {
    return dofs->first[node + 1] - dofs->first[node];
}

/* Variables for a cage at x [3 n_vertices], whose centroid is the symmetry's centre. Where nothing is constrained,
 * positions that are not symmetric are not in reach, and offset is NULL. ERROR_MEMORY. */
int32_t co_dof_map_create(const curvopt_mesh *mesh, const co_symmetry *symmetry, const co_constraints *constraints,
                          const double *x, co_dof_map *out, curvopt_error *error);
/* Every vertex is free, and positions themselves are the variables. Has no `stretch` and no `translation`.
 * ERROR_MEMORY. */
int32_t co_dof_map_identity(int32_t n_vertices, co_dof_map *out, curvopt_error *error);
void co_dof_map_free(co_dof_map *dofs);

/* x [3 n_vertices] = offset + B z */
void co_dof_map_expand(const co_dof_map *dofs, const double *z, double *x);
/* As co_dof_map_expand() for the vertices listed, ascending; NULL: all. */
void co_dof_map_expand_some(const co_dof_map *dofs, const int32_t *vertices, int32_t n, const double *z, double *x);
/* Where offset is NULL: the variables of the cage moved to centroid 0 and scaled to root mean square radius 1, into
 * `normalized`; returns the radius that it had. */
double co_dof_map_normalize(const co_dof_map *dofs, const double *z, double *normalized);
/* gz, a gradient with respect to normalized variables, becomes that with respect to the variables that they were made
 * from. With t_k the translations (orthonormal), n vertices and radius r:
 *     gz <- (g - z (g.z) / n) / r,   g = gz - sum t_k (t_k.gz) .
 * co_assembly_evaluate() has the same formula in the coordinates of the cage. */
void co_dof_map_normalized_gradient(const co_dof_map *dofs, const double *normalized, double radius, double *gz);
/* z [n_variables] = B^T (x - offset): the variables of positions x, or of the closest ones in reach. */
void co_dof_map_variables(const co_dof_map *dofs, const double *x, double *z);
/* gz [n_variables] = B^T gx: the gradient with respect to the variables. */
void co_dof_map_gradient(const co_dof_map *dofs, const double *gx, double *gz);
/* As co_dof_map_gradient() where gx is 0 except at the vertices listed; NULL: all. */
void co_dof_map_gradient_of(const co_dof_map *dofs, const int32_t *vertices, int32_t n, const double *gx, double *gz);
/* Length of the longest displacement of a vertex that dz brings. */
double co_dof_map_longest(const co_dof_map *dofs, const double *dz);

/* weight [n_faces]: how many faces of its orbit each face stands for; 0 for all but one of them. ERROR_MEMORY. */
int32_t co_dof_map_face_weights(const curvopt_mesh *mesh, const co_symmetry *symmetry, double **weight,
                                curvopt_error *error);

#endif

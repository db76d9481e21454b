/* The variables of a minimization: the cage's positions as a linear function of fewer numbers.
 *
 * Pins, sliding along lines and planes, and symmetry are one thing: x_v = offset_v + B_v z_node(v), with the columns of
 * the whole matrix orthonormal, so that lengths of gradients and steps are those of the cage.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_DOF_MAP_H
#define CO_CONSTRAINTS_DOF_MAP_H

#include "constraints/symmetry.h"

typedef struct co_dof_map {
    int32_t n_vertices, n_nodes, n_variables;
    int32_t *node;   /* [n_vertices] node that a vertex moves with, -1: it does not move */
    int32_t *first;  /* [n_nodes + 1] its first variable; at most three each */
    double *basis;   /* [n_vertices][3][3] B_v: by rows x, y, z, as many columns as the node has variables */
    double *offset;  /* [3 n_vertices], or NULL for 0 */
    double *stretch; /* [n_nodes] length of B_v's columns: 1 / sqrt(vertices of the node) */
    int plain;       /* every vertex is a node, every B_v the identity */
    /* where offset is NULL, for centroid and size: */
    double
        *translation; /* [3][n_variables] unit translations of the cage along x, y, z, as far as they keep symmetry */
} co_dof_map;

/* How many variables a node has. */
static inline int32_t co_dof_map_dimension(const co_dof_map *reduction, int32_t node) {
    return reduction->first[node + 1] - reduction->first[node];
}

/* Variables for a cage at x [3 n_vertices], whose centroid is the symmetry's centre. Where nothing is constrained,
 * positions that are not symmetric are not in reach, and offset is NULL. ERROR_MEMORY. */
int32_t co_dof_map_create(const curvopt_mesh *mesh, const co_symmetry *symmetry, const co_constraints *hold,
                          const double *x, co_dof_map *out, curvopt_error *error);
/* Every vertex free, positions themselves the variables. ERROR_MEMORY. */
int32_t co_dof_map_identity(int32_t n_vertices, co_dof_map *out, curvopt_error *error);
void co_dof_map_free(co_dof_map *reduction);

/* x [3 n_vertices] = offset + B z */
void co_dof_map_expand(const co_dof_map *reduction, const double *z, double *x);
/* The same for the vertices listed, ascending; NULL: all. */
void co_dof_map_expand_some(const co_dof_map *reduction, const int32_t *vertices, int32_t n, const double *z,
                            double *x);
/* Where offset is NULL: the variables of the cage moved to centroid 0 and scaled to root mean square radius 1, into
 * `normalized`; returns the radius that it had. */
double co_dof_map_normalize(const co_dof_map *reduction, const double *z, double *normalized);
/* gz, a gradient with respect to normalized variables, becomes that with respect to those they were made from. */
void co_dof_map_normalized_gradient(const co_dof_map *reduction, const double *normalized, double radius, double *gz);
/* z [n_variables] = B^T (x - offset): of positions in reach, their variables. */
void co_dof_map_variables(const co_dof_map *reduction, const double *x, double *z);
/* gz [n_variables] = B^T gx: a gradient. */
void co_dof_map_gradient(const co_dof_map *reduction, const double *gx, double *gz);
/* The same where gx is 0 but at the vertices listed; NULL: all. */
void co_dof_map_gradient_of(const co_dof_map *reduction, const int32_t *vertices, int32_t n, const double *gx,
                            double *gz);
/* Length of the longest displacement of a vertex that dz brings. */
double co_dof_map_longest(const co_dof_map *reduction, const double *dz);

/* weight [n_faces]: how many faces of its orbit each face stands for; 0 for all but one of them. ERROR_MEMORY. */
int32_t co_dof_map_face_weights(const curvopt_mesh *mesh, const co_symmetry *symmetry, double **weight,
                                curvopt_error *error);

#endif

/* curvopt_experimental.h - parts of a surface and their second derivatives.
 *
 * Experimental: anything here may change or go with any release, also between patch releases, and its structs have no
 * struct_size. curvopt-tao, which distributes a cage over processes, is built on it. The conventions are curvopt.h's.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef CURVOPT_EXPERIMENTAL_H
#define CURVOPT_EXPERIMENTAL_H

#include "curvopt.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------ parts of a surface -- */

/* A part is a weighted subset of a cage's faces. With the same quadrature rules the sums of the parts add up to those
 * of the whole surface, to rounding. curvopt-tao distributes a surface over processes in this way.
 *
 * An energy is second + area * third, each a sum over faces: `second` the weighted terms without third order, `third`
 * the weighted third-order terms, which lack their factor, the area of the whole surface. So the whole's energy needs
 * three sums of each part, and its gradient is grad second + area * grad third + third * grad area.
 *
 * Positions here are normalized by the caller: the root mean square distance of all of the whole's vertices from their
 * centroid is 1. (Third-order energies are regularized at umbilics on that scale; the centroid should be near 0.)
 * Gradients are with respect to these positions, and do not know of the normalization. */

/* Of the faces whose face_weight [n_faces of mesh] is not 0 the mesh that their surface depends on: they, and those
 * round them, two rings or more. Creases go with it. Faces and vertices keep their order.
 *   vertex_of [n_vertices of mesh], face_of [n_faces of mesh]: number in `mesh` of each vertex and face of the part;
 *   as many are written as the part has.
 * At the rim of a part edges have one face, and that is no boundary of the surface: it is for
 * curvopt_problem_create_part alone. ERROR_ARGUMENT (NULL, or no face counts), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_mesh_part(const curvopt_mesh *mesh, const double *face_weight, curvopt_mesh **out,
                                      int32_t *vertex_of, int32_t *face_of, curvopt_error *error);
/* As curvopt_mesh_create_creased, of what a part consists of: vertices that join two fans of faces are let pass, as
 * rims have them. The result may be refined, and a part be taken of that. */
CURVOPT_API int32_t curvopt_mesh_create_part(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                             const int32_t *face_vertices, const curvopt_creases *creases,
                                             curvopt_mesh **out, curvopt_error *error);

/* As curvopt_problem_create, for the faces of `mesh` whose face_weight [n_faces] is not 0, each counted as often as
 * that says; the others are there for these faces' neighbourhoods only. curvopt_problem_evaluate refuses such a
 * problem: an error over some faces is not one of the surface. The functions below take problems of either kind.
 * Besides its errors ERROR_ARGUMENT: a weight is negative or not finite (`element` is the face), or all are 0. */
CURVOPT_API int32_t curvopt_problem_create_part(const curvopt_mesh *mesh, const double *face_weight,
                                                const curvopt_options *options, curvopt_problem **out,
                                                curvopt_error *error);

/* Sums over the faces that count, each as often as it does. Those of parts add up; of min_jacobian the least counts. */
typedef struct curvopt_sums {
    double area;
    double second;  /* weighted terms without third order */
    double third;   /* weighted third-order terms, without their factor area */
    double gauss;   /* int K dA */
    double turning; /* int kappa_g ds along boundaries and infinitely sharp creases, and the angles there: on a closed
                       surface without those 0, and gauss is 2 pi chi */
    double term[CURVOPT_MAX_TERMS]; /* every term by curvopt_term: third-order ones without their factor, and NAN where
                       they were not asked for or the surface cannot give them; AREA's is the area */
    double samples;                 /* quadrature points */
    double min_jacobian;            /* least |S_u x S_v| over its face's mean */
} curvopt_sums;

/* By the present rules, which this does not change.
 *   xyz [3 n_vertices]        normalized
 *   all_terms                 nonzero: third-order terms even if the objective has none
 *   gradients [3][3 n_vertices] of second, third and area, 0 where the objective has no such terms (area's too, then);
 *                             NULL: not wanted
 * A degenerate surface gives sums that are not finite, and no error. ERROR_ARGUMENT. */
CURVOPT_API int32_t curvopt_problem_sum(curvopt_problem *problem, const double *xyz, int32_t all_terms,
                                        double *gradients, curvopt_sums *out, curvopt_error *error);

/* Quadrature rules, 0 to CURVOPT_FINEST_RULE, by face. Where a face is evaluated in pieces
 * they can have different rules once curvopt_problem_evaluate has refined them; the finest is returned. Faces that do
 * not count: -1, and what is set for them means nothing. rules [n_faces]. ERROR_ARGUMENT, ERROR_MEMORY. */
#define CURVOPT_FINEST_RULE 6
CURVOPT_API void curvopt_problem_get_rules(const curvopt_problem *problem, int32_t *rules);
CURVOPT_API int32_t curvopt_problem_set_rules(curvopt_problem *problem, const int32_t *rules, curvopt_error *error);
/* Signed estimate of the quadrature error of each face: its contribution to the objective by the present rule minus
 * that by the next finer rule, times the face's weight; 0 for faces that do not count. area, third: of the whole
 * surface, on which a contribution depends. errors [n_faces]. ERROR_ARGUMENT, ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_problem_face_errors(curvopt_problem *problem, const double *xyz, double area, double third,
                                                double *errors, curvopt_error *error);

/* Second derivatives of the faces that count, sparse. Alive as long as its problem. */
typedef struct curvopt_hessian curvopt_hessian;

/* The lower triangle of a symmetric matrix, by columns; the arrays are the hessian's. */
typedef struct curvopt_matrix {
    const int32_t *column_start; /* [n + 1] */
    const int32_t *row;          /* [column_start[n]] ascending in each column, the diagonal's first */
    const double *value;         /* [column_start[n]] */
    int32_t n;                   /* 3 n_vertices */
    int32_t reserved;
} curvopt_matrix;

/* The pattern, with values 0. ERROR_SIZE (more entries than 32-bit indices count), ERROR_ARGUMENT, ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_hessian_create(curvopt_problem *problem, curvopt_hessian **out, curvopt_error *error);
CURVOPT_API void curvopt_hessian_destroy(curvopt_hessian *hessian);
CURVOPT_API void curvopt_hessian_get(const curvopt_hessian *hessian, curvopt_matrix *out);
/* At normalized xyz [3 n_vertices]: hess second + area * hess third + third * hess area, `area` and `third` the whole
 * surface's. The whole's Hessian has besides grad area (x) grad third + grad third (x) grad area, which is dense: add
 * it from the sums of the parts' gradients. exact == 0: the Gauss-Newton matrix instead, which is never indefinite and
 * leaves third * hess area out; by the coarsest rules. On irregular faces of `plane` it is that matrix in any case.
 * ERROR_ARGUMENT, ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_hessian_assemble(curvopt_hessian *hessian, const double *xyz, int32_t exact, double area,
                                             double third, curvopt_error *error);

#ifdef __cplusplus
}
#endif
#endif

/* Subdomains: weighted subsets of a cage's faces, and their contributions to the whole's energies.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_SUBDOMAIN_H
#define CO_HESSIAN_SUBDOMAIN_H

#include "energy/adaptive_quadrature.h"
#include "hessian/sparse_hessian.h"

#include "curvopt_experimental.h"

/* As curvopt_mesh_part. */
int32_t co_subdomain_extract(const curvopt_mesh *mesh, const double *face_weight, curvopt_mesh **part,
                             int32_t *vertex_of, int32_t *face_of, curvopt_error *error);
/* As curvopt_problem_sum. */
void co_subdomain_sum(co_assembly *assembly, const double *x, int all_terms, double *gradients, curvopt_sums *out);
/* As curvopt_problem_face_errors. */
int32_t co_subdomain_errors(co_assembly *assembly, const double *x, const co_whole *whole, double *errors,
                            curvopt_error *error);
/* Rules by face: the finest among its patches. */
void co_subdomain_get_rules(const co_assembly *assembly, int32_t n_faces, int32_t *rules);
/* Gives every patch its face's rule. ERROR_ARGUMENT naming the face, ERROR_MEMORY. */
int32_t co_subdomain_set_rules(co_assembly *assembly, const int32_t *rules, curvopt_error *error);

#endif

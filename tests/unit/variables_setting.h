/* A normalized cage and its variables, for tests of functions of these. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_VARIABLES_SETTING_H
#define TEST_VARIABLES_SETTING_H

#include "cages.h"

#include "hessian/sparse_hessian.h"

typedef struct variables_setting {
    cage c;
    curvopt_mesh *mesh;
    co_constraints held;
    co_symmetry symmetry;
    co_dof_map dofs;
    double centroid[3], radius;
    double *x, *z; /* [3 n_vertices] each: positions in the normalized frame, and the variables */
} variables_setting;

/* Takes the cage over. `symmetric`: with all its symmetries, else with none. */
variables_setting variables_setting_of(cage c, const curvopt_constraints *pins, int symmetric);
void variables_setting_free(variables_setting *s);

/* A Hessian of the variables, 0. */
co_sparse_hessian variables_hessian(const variables_setting *s);
/* A column of it [n_variables]. */
void variables_hessian_column(const co_sparse_hessian *hessian, int column, double *out);

#endif

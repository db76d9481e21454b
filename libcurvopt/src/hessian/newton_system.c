/* The linear system of Newton's method. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/newton_system.h"

#include "base/memory.h"
#include "linalg/small_dense.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef double small_matrix[CO_NEWTON_SYSTEM_DENSE][CO_NEWTON_SYSTEM_DENSE];

static size_t n_variables(const co_newton_system *m) {
    return (size_t)m->hessian.dofs->n_variables;
}

int32_t co_newton_system_create(co_assembly *assembly, const co_dof_map *dofs, co_newton_system *m,
                                curvopt_error *error) {
    size_t n = (size_t)dofs->n_variables;
    *m = (co_newton_system){.assembly = assembly};
    int32_t status = co_sparse_hessian_create(assembly, dofs, &m->hessian, error);
    if (status == CURVOPT_OK)
        status = co_sparse_cholesky_create((int32_t)n, m->hessian.pattern.column_start, m->hessian.pattern.row,
                                           m->hessian.value, &m->factor, error);
    if (status == CURVOPT_OK) {
        m->dense = CO_NEW(double, (CO_NEWTON_SYSTEM_DENSE + 1) * n);
        m->solved = CO_NEW(double, (CO_NEWTON_SYSTEM_DENSE + 1) * n);
        m->full = CO_NEW(double, 6 * (size_t)dofs->n_vertices);
        if (!m->dense || !m->solved || !m->full)
            status = co_status_no_memory(error);
    }
    if (status != CURVOPT_OK)
        co_newton_system_free(m);
    return status;
}

void co_newton_system_free(co_newton_system *m) {
    co_sparse_cholesky_destroy(m->factor);
    co_sparse_hessian_free(&m->hessian);
    free(m->dense);
    free(m->solved);
    free(m->full);
    free(m->exact);
    free(m->gauss_newton);
    *m = (co_newton_system){0};
}

int32_t co_newton_system_assemble(co_newton_system *m, const double *x, const co_second_kind *kind, co_gauge gauge,
                                  curvopt_error *error) {
    const co_dof_map *r = m->hessian.dofs;
    m->mix = 0;
    m->n_dense = m->n_pair = kind->exact && m->assembly->functional.has_third ? 2 : 0;
    if (m->n_pair) {
        double *area = m->full, *third = m->full + 3 * (size_t)r->n_vertices;
        co_values values;
        co_assembly_pieces(m->assembly, x, 0, &(co_pieces){.third = third, .area = area}, &values);
        const co_assembly *a = m->assembly;
        co_dof_map_gradient_of(r, a->active, a->n_active_cage, area, m->dense);
        co_dof_map_gradient_of(r, a->active, a->n_active_cage, third, m->dense + n_variables(m));
    }
    m->n_dense += co_gauge_columns(r, x, gauge, m->full, m->dense + (size_t)m->n_pair * n_variables(m));
    int32_t status = co_sparse_hessian_assemble(m->assembly, x, kind, &m->hessian, error);
    m->stiffness = co_newton_system_mean_diagonal(m);
    return status;
}

int32_t co_newton_system_begin_gauss_newton(co_newton_system *m, const double *x, curvopt_error *error) {
    const co_sparse_hessian *h = &m->hessian;
    if (!m->exact)
        m->exact = CO_NEW(double, h->pattern.n_entries);
    if (!m->gauss_newton)
        m->gauss_newton = CO_NEW(double, h->pattern.n_entries);
    if (!m->exact || !m->gauss_newton)
        return co_status_no_memory(error);
    memcpy(m->exact, h->value, h->pattern.n_entries * sizeof *h->value);
    const co_second_kind kind = {.own_rules = 1};
    return co_sparse_hessian_assemble(m->assembly, x, &kind, &m->hessian, error);
}

void co_newton_system_end_gauss_newton(co_newton_system *m) {
    memcpy(m->gauss_newton, m->hessian.value, m->hessian.pattern.n_entries * sizeof *m->gauss_newton);
    m->mix = 1;
}

void co_newton_system_mix(co_newton_system *m, double mix) {
    for (size_t e = 0; e < m->hessian.pattern.n_entries; e++)
        m->hessian.value[e] = (1 - mix) * m->exact[e] + mix * m->gauss_newton[e];
    m->mix = mix;
}

double co_newton_system_mean_diagonal(const co_newton_system *m) {
    return co_sparse_hessian_mean_diagonal(&m->hessian);
}

/* --------------------------------------------------------------------------------------------- capacity matrix -- */

/* Inverts C^-1 + U^T H^-1 U, the capacitance matrix; returns the number of its positive eigenvalues. */
static int invert_capacitance(co_newton_system *m) {
    size_t n = n_variables(m);
    small_matrix a = {{0}}, v = {{0}};
    double value[CO_NEWTON_SYSTEM_DENSE];
    int positive = 0;
    for (int i = 0; i < m->n_dense; i++)
        for (int j = 0; j < m->n_dense; j++)
            a[i][j] = co_vector_dot(n, m->dense + (size_t)i * n, m->solved + (size_t)j * n);
    if (m->n_pair) /* C is (0 1; 1 0) there, its own inverse */
        a[0][1] += 1, a[1][0] += 1;
    for (int i = m->n_pair; i < m->n_dense; i++)
        a[i][i] += 1 / m->stiffness;
    co_small_dense_eigen(m->n_dense, CO_NEWTON_SYSTEM_DENSE, a[0], value, v[0]);
    memset(m->inverse, 0, sizeof m->inverse);
    for (int k = 0; k < m->n_dense; k++) {
        positive += value[k] > 0;
        for (int i = 0; i < m->n_dense; i++)
            for (int j = 0; j < m->n_dense; j++)
                m->inverse[i][j] += v[i][k] * v[j][k] / value[k];
    }
    return positive;
}

/* Number of positive eigenvalues of C^-1. */
static int positive_of_weights(const co_newton_system *m) {
    return m->n_dense - m->n_pair / 2;
}

/* --------------------------------------------------------------------------------------------------- solving -- */

int32_t co_newton_system_factorize(co_newton_system *m, double shift, int *positive, curvopt_error *error) {
    size_t n = n_variables(m);
    int32_t status = co_sparse_cholesky_factorize(m->factor, shift, positive, error);
    for (size_t k = 0; k < (size_t)m->n_dense && *positive && status == CURVOPT_OK; k++)
        status = co_sparse_cholesky_solve(m->factor, m->dense + k * n, m->solved + k * n, error);
    if (status == CURVOPT_OK && *positive)
        *positive = invert_capacitance(m) == positive_of_weights(m);
    return status;
}

/* x = H^-1 b becomes M^-1 b. */
static void add_dense(const co_newton_system *m, double *x) {
    size_t n = n_variables(m);
    double along[CO_NEWTON_SYSTEM_DENSE];
    for (size_t k = 0; k < (size_t)m->n_dense; k++)
        along[k] = co_vector_dot(n, m->dense + k * n, x);
    for (size_t i = 0; i < (size_t)m->n_dense; i++) {
        double sum = 0;
        for (int j = 0; j < m->n_dense; j++)
            sum += m->inverse[i][j] * along[j];
        co_vector_add(n, -sum, m->solved + i * n, x);
    }
}

int32_t co_newton_system_solve(co_newton_system *m, const double *b, double *x, curvopt_error *error) {
    int32_t status = co_sparse_cholesky_solve(m->factor, b, x, error);
    if (status == CURVOPT_OK)
        add_dense(m, x);
    return status;
}

void co_newton_system_add_stiffness(const co_newton_system *m, const double *v, double *out) {
    size_t n = n_variables(m);
    for (size_t k = (size_t)m->n_pair; k < (size_t)m->n_dense; k++)
        co_vector_add(n, m->stiffness * co_vector_dot(n, m->dense + k * n, v), m->dense + k * n, out);
}

int32_t co_newton_system_count_negative(co_newton_system *m, double shift, const double *b, double *x,
                                        int32_t *n_negative, curvopt_error *error) {
    size_t n = n_variables(m), last = (size_t)m->n_dense * n;
    memcpy(m->dense + last, b, n * sizeof *b);
    int32_t status =
        co_sparse_cholesky_count_negative(m->factor, shift, m->n_dense + 1, m->dense, m->solved, n_negative, error);
    if (status != CURVOPT_OK || *n_negative < 0)
        return status;
    *n_negative += invert_capacitance(m) - positive_of_weights(m);
    memcpy(x, m->solved + last, n * sizeof *x);
    add_dense(m, x);
    return CURVOPT_OK;
}

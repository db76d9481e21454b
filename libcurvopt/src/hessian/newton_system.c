/* The linear system of Newton's method. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/newton_system.h"

#include "base/memory.h"
#include "energy/assembly_sums.h"
#include "linalg/small_dense.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest eigenvalue. */
static const double NEGLIGIBLE = 1e-14;
/* What is left of a motion that others make up. */
static const double SAME_MOTION = 1e-6;

typedef double small_matrix[CO_NEWTON_SYSTEM_DENSE][CO_NEWTON_SYSTEM_DENSE];

static size_t n_variables(const co_newton_system *m) {
    return (size_t)m->hessian.dofs->n_variables;
}

int32_t co_newton_system_create(co_assembly *assembly, const co_dof_map *dofs, const co_couplings *couplings,
                                co_newton_system *m, curvopt_error *error) {
    size_t n = (size_t)dofs->n_variables;
    *m = (co_newton_system){.assembly = assembly};
    int32_t status = co_sparse_hessian_create(assembly, dofs, couplings, &m->hessian, error);
    if (status == CURVOPT_OK) {
        m->damped = CO_NEW(double, m->hessian.pattern.n_entries);
        if (!m->damped)
            status = co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        status = co_sparse_cholesky_create((int32_t)n, m->hessian.pattern.column_start, m->hessian.pattern.row,
                                           m->damped, assembly->threads, assembly->cancel, &m->factor, error);
    if (status == CURVOPT_OK) {
        m->dense = CO_NEW(double, (CO_NEWTON_SYSTEM_DENSE + 1) * n);
        m->solved = CO_NEW(double, (CO_NEWTON_SYSTEM_DENSE + 1) * n);
        m->full = CO_NEW(double, 6 * (size_t)dofs->n_vertices);
        m->part = CO_NEW(double, CO_NEWTON_SYSTEM_PARTS *n);
        m->motion = CO_NEW(double, (CO_NEWTON_SYSTEM_MOTIONS + 1) * n);
        if (!m->dense || !m->solved || !m->full || !m->part || !m->motion)
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
    free(m->part);
    free(m->motion);
    free(m->exact);
    free(m->gauss_newton);
    free(m->damped);
    *m = (co_newton_system){0};
}

/* ------------------------------------------------------------------------------------- the dense columns -- */

static int n_held(const co_newton_system *m) {
    return m->held ? m->held->numbers->n : 0;
}

static int has_spontaneous(const co_newton_system *m) {
    return m->assembly->spontaneous.curvature != 0;
}

/* Columns at most by which numbers of the surface take negative directions of the sparse part away. */
static int n_softened(const co_newton_system *m) {
    return n_held(m) + (has_spontaneous(m) ? CURVOPT_N_SCALARS - 1 : 0);
}

/* Adds what spontaneous curvature adds to D, and to the sparse matrix. */
static void add_spontaneous(co_newton_system *m, const co_held_residual *added, co_integrand *more) {
    for (int i = 0; i < CURVOPT_N_SCALARS; i++) {
        co_held_numbers_add(i, added->slope[i], more);
        for (int j = 0; j < CURVOPT_N_SCALARS; j++) {
            m->second[i][j] += added->second[i][j];
            m->has_part[i] |= added->second[i][j] != 0;
        }
    }
}

/* D, the constraints' slopes, and what the constraints add to the sparse matrix. */
static void find_second(co_newton_system *m, const co_held_residual *residual, int exact, co_integrand *more) {
    memset(m->second, 0, sizeof m->second);
    memset(m->has_part, 0, sizeof m->has_part);
    *more = (co_integrand){0};
    if (exact && m->assembly->functional.has_third) {
        m->second[CURVOPT_SCALAR_AREA][CO_NEWTON_SYSTEM_THIRD] = 1;
        m->second[CO_NEWTON_SYSTEM_THIRD][CURVOPT_SCALAR_AREA] = 1;
        m->has_part[CURVOPT_SCALAR_AREA] = m->has_part[CO_NEWTON_SYSTEM_THIRD] = 1;
    }
    for (int k = 0; k < n_held(m); k++)
        for (int i = 0; i < CURVOPT_N_SCALARS; i++) {
            m->slope[k][i] = residual[k].slope[i];
            m->has_part[i] |= residual[k].slope[i] != 0;
            if (!exact)
                continue;
            co_held_numbers_add(i, m->held->multiplier[k] * residual[k].slope[i], more);
            for (int j = 0; j < CURVOPT_N_SCALARS; j++)
                m->second[i][j] += m->held->multiplier[k] * residual[k].second[i][j];
        }
}

/* G, at positions x. */
static void find_gradients(co_newton_system *m, const double *x) {
    const co_dof_map *r = m->hessian.dofs;
    co_assembly *a = m->assembly;
    const size_t n = n_variables(m);
    double *area = m->full, *third = m->full + 3 * (size_t)r->n_vertices;
    if (m->has_part[CO_NEWTON_SYSTEM_THIRD]) {
        co_values values;
        co_assembly_pieces(a, x, 0, &(co_pieces){.third = third, .area = area}, &values);
        co_dof_map_gradient_of(r, a->active, a->n_active_cage, area, m->part + CURVOPT_SCALAR_AREA * n);
        co_dof_map_gradient_of(r, a->active, a->n_active_cage, third, m->part + CO_NEWTON_SYSTEM_THIRD * n);
    }
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        if (m->has_part[s] && !(s == CURVOPT_SCALAR_AREA && m->has_part[CO_NEWTON_SYSTEM_THIRD])) {
            co_assembly_number_gradient(a, s, area);
            co_dof_map_gradient_of(r, a->active, a->n_active_cage, area, m->part + (size_t)s * n);
        }
}

static void find_motions(co_newton_system *m, const double *x, co_gauge gauge) {
    if (!m->left_out) {
        m->n_motions = co_gauge_columns(m->hessian.dofs, x, gauge, m->full, m->motion);
        return;
    }
    m->n_motions = m->n_left_out;
    memcpy(m->motion, m->left_out, (size_t)m->n_left_out * n_variables(m) * sizeof *m->motion);
}

/* Adds the ways to the motions, orthogonal to these and to each other. */
static void add_ways(co_newton_system *m) {
    const size_t n = n_variables(m);
    for (int k = 0; k < n_held(m); k++) {
        double *column = m->motion + (size_t)m->n_motions * n;
        memcpy(column, m->held->way + (size_t)k * n, n * sizeof *column);
        const double before = co_vector_norm(n, column);
        for (int pass = 0; pass < 2; pass++)
            co_vector_remove(n, (size_t)m->n_motions, m->motion, column);
        const double after = co_vector_norm(n, column);
        if (!(after > SAME_MOTION * before))
            continue;
        for (size_t i = 0; i < n; i++)
            column[i] /= after;
        m->n_motions++;
    }
}

/* H W behind G, with (A^T W)^-1 and W^T H W, both [n_held][CURVOPT_N_SCALARS]. */
static void push_ways(co_newton_system *m, double inverse[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS],
                      double pushed[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS]) {
    const size_t n = n_variables(m);
    double along[CO_NEWTON_SYSTEM_INTEGRALS][CURVOPT_N_SCALARS] = {{0}}, cross[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS];
    for (int k = 0; k < n_held(m); k++) {
        const double *way = m->held->way + (size_t)k * n;
        double *to = m->part + (size_t)(CO_NEWTON_SYSTEM_INTEGRALS + k) * n;
        co_sparse_hessian_multiply(&m->hessian, way, to);
        for (int i = 0; i < CO_NEWTON_SYSTEM_INTEGRALS; i++)
            along[i][k] = m->has_part[i] ? co_vector_dot(n, m->part + (size_t)i * n, way) : 0;
        for (int i = 0; i < CO_NEWTON_SYSTEM_INTEGRALS; i++) {
            double sum = 0;
            for (int j = 0; j < CO_NEWTON_SYSTEM_INTEGRALS; j++)
                sum += m->second[i][j] * along[j][k];
            if (sum != 0)
                co_vector_add(n, sum, m->part + (size_t)i * n, to);
        }
    }
    for (int k = 0; k < n_held(m); k++)
        for (int l = 0; l < n_held(m); l++) {
            cross[k][l] = 0;
            for (int i = 0; i < CURVOPT_N_SCALARS; i++)
                cross[k][l] += m->slope[k][i] * along[i][l];
            pushed[k][l] =
                co_vector_dot(n, m->held->way + (size_t)k * n, m->part + (size_t)(CO_NEWTON_SYSTEM_INTEGRALS + l) * n);
        }
    co_small_dense_invert(n_held(m), CURVOPT_N_SCALARS, cross[0], inverse[0]);
}

typedef double part_matrix[CO_NEWTON_SYSTEM_PARTS][CO_NEWTON_SYSTEM_PARTS];

/* What stands between the parts: D, and with N = (A^T W)^-1, A = G B^T of the slopes B and Q = H W
 *     Z^T H Z - H = - G B^T N^T Q^T - Q N B G^T + G B^T N^T (W^T Q) N B G^T . */
static void find_core(co_newton_system *m, part_matrix core) {
    double inverse[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS], pushed[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS];
    double reduced[CURVOPT_N_SCALARS][CURVOPT_N_SCALARS] = {{0}}; /* N B */
    memset(core, 0, sizeof(part_matrix));
    for (int i = 0; i < CO_NEWTON_SYSTEM_INTEGRALS; i++)
        for (int j = 0; j < CO_NEWTON_SYSTEM_INTEGRALS; j++)
            core[i][j] = m->second[i][j];
    if (!n_held(m))
        return;
    push_ways(m, inverse, pushed);
    for (int k = 0; k < n_held(m); k++)
        for (int i = 0; i < CURVOPT_N_SCALARS; i++) {
            for (int l = 0; l < n_held(m); l++)
                reduced[k][i] += inverse[k][l] * m->slope[l][i];
            core[i][CO_NEWTON_SYSTEM_INTEGRALS + k] = core[CO_NEWTON_SYSTEM_INTEGRALS + k][i] = -reduced[k][i];
        }
    for (int i = 0; i < CURVOPT_N_SCALARS; i++)
        for (int j = 0; j < CURVOPT_N_SCALARS; j++)
            for (int k = 0; k < n_held(m); k++)
                for (int l = 0; l < n_held(m); l++)
                    core[i][j] += reduced[k][i] * pushed[k][l] * reduced[l][j];
}

/* U and C: of the parts P and what stands between them, by the eigenvalues of that between columns of length 1; those
 * that are nothing beside the largest have no column. Then the motions. */
static void make_columns(co_newton_system *m) {
    const size_t n = n_variables(m);
    part_matrix core, vector = {{0}};
    double length[CO_NEWTON_SYSTEM_PARTS], value[CO_NEWTON_SYSTEM_PARTS], largest = 0;
    find_core(m, core);
    for (int i = 0; i < CO_NEWTON_SYSTEM_PARTS; i++) {
        const int counts = i < CO_NEWTON_SYSTEM_INTEGRALS ? m->has_part[i] : i - CO_NEWTON_SYSTEM_INTEGRALS < n_held(m);
        length[i] = counts ? co_vector_norm(n, m->part + (size_t)i * n) : 0;
    }
    for (int i = 0; i < CO_NEWTON_SYSTEM_PARTS; i++)
        for (int j = 0; j < CO_NEWTON_SYSTEM_PARTS; j++)
            core[i][j] *= length[i] * length[j];
    co_small_dense_eigen(CO_NEWTON_SYSTEM_PARTS, CO_NEWTON_SYSTEM_PARTS, core[0], value, vector[0]);
    for (int k = 0; k < CO_NEWTON_SYSTEM_PARTS; k++)
        largest = fmax(largest, fabs(value[k]));
    m->n_dense = 0;
    for (int k = 0; k < CO_NEWTON_SYSTEM_PARTS; k++) {
        double *column = m->dense + (size_t)m->n_dense * n;
        if (!(fabs(value[k]) > NEGLIGIBLE * largest))
            continue;
        memset(column, 0, n * sizeof *column);
        for (int i = 0; i < CO_NEWTON_SYSTEM_PARTS; i++)
            if (length[i] > 0)
                co_vector_add(n, vector[i][k] / length[i], m->part + (size_t)i * n, column);
        m->weight[m->n_dense++] = value[k];
    }
    memcpy(m->dense + (size_t)m->n_dense * n, m->motion, (size_t)m->n_motions * n * sizeof *m->motion);
    for (int k = 0; k < m->n_motions; k++)
        m->weight[m->n_dense++] = m->leaves_motions_out ? (double)INFINITY : m->stiffness;
}

void co_newton_system_change_gauge(co_newton_system *m, const double *x, co_gauge gauge) {
    find_motions(m, x, gauge);
    add_ways(m);
    make_columns(m);
}

int32_t co_newton_system_assemble(co_newton_system *m, const double *x, const co_second_kind *kind, co_gauge gauge,
                                  curvopt_error *error) {
    co_held_residual residual[CURVOPT_N_SCALARS];
    co_second_kind wanted = *kind;
    co_integrand more;
    double integral[CO_N_INTEGRALS];
    m->mix = 0;
    m->coarser = kind->coarser;
    if (n_held(m) || has_spontaneous(m))
        co_assembly_numbers(m->assembly, x, has_spontaneous(m) || co_held_numbers_has_mean(m->held->numbers), integral);
    for (int k = 0; k < n_held(m); k++)
        residual[k] = co_held_numbers_residual(m->held->numbers, k, integral);
    find_second(m, residual, kind->exact, &more);
    if (has_spontaneous(m) && kind->exact) {
        const co_spontaneous_part part = co_spontaneous_curvature_add(&m->assembly->spontaneous, 1, integral);
        add_spontaneous(m, &part.added, &more);
    }
    find_gradients(m, x);
    wanted.more = &more;
    int32_t status = co_sparse_hessian_assemble(m->assembly, x, &wanted, &m->hessian, error);
    m->stiffness = co_newton_system_mean_diagonal(m);
    co_newton_system_change_gauge(m, x, gauge);
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
    const co_second_kind kind = {.coarser = m->coarser};
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
    for (int i = 0; i < m->n_dense; i++)
        a[i][i] += 1 / m->weight[i];
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

/* Number of positive entries of C. */
static int positive_of_weights(const co_newton_system *m) {
    int positive = 0;
    for (int k = 0; k < m->n_dense; k++)
        positive += m->weight[k] > 0;
    return positive;
}

/* --------------------------------------------------------------------------------------------------- solving -- */

/* H + shift metric, or H where there is none. */
typedef struct damping {
    const double *value, *metric;
    double shift, *out;
} damping;

static void damp_entries(void *context, size_t begin, size_t end) {
    const damping *d = context;
    memcpy(d->out + begin, d->value + begin, (end - begin) * sizeof *d->out);
    if (d->metric)
        co_vector_add(end - begin, d->shift, d->metric + begin, d->out + begin);
}

/* What is to be factored, but for a multiple of the unit matrix; returns that. */
static double damp(co_newton_system *m, const double *metric, double shift) {
    damping d = {.value = m->hessian.value, .metric = metric, .shift = shift, .out = m->damped};
    const size_t n = m->hessian.pattern.n_entries;
    co_thread_pool_for(co_thread_pool_if_worth(m->assembly->threads, n), n, damp_entries, &d);
    return metric ? m->unit_shift : shift;
}

int32_t co_newton_system_factorize(co_newton_system *m, double shift, int *positive, curvopt_error *error) {
    size_t n = n_variables(m);
    const double unit = damp(m, m->metric, shift);
    int32_t n_negative = 0, status = co_sparse_cholesky_factorize(m->factor, unit, positive, error);
    if (n_held(m)) /* springs, a mixture: the sparse matrix may be another one since */
        make_columns(m);
    if (status == CURVOPT_OK && !*positive && n_softened(m)) {
        status = co_sparse_cholesky_factorize_indefinite(m->factor, unit, &n_negative, error);
        *positive = n_negative >= 0 && n_negative <= n_softened(m);
    }
    for (size_t k = 0; k < (size_t)m->n_dense && *positive && status == CURVOPT_OK; k++)
        status = co_sparse_cholesky_solve(m->factor, m->dense + k * n, m->solved + k * n, error);
    if (status == CURVOPT_OK && *positive)
        *positive = n_negative + invert_capacitance(m) == positive_of_weights(m);
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

void co_newton_system_remove_motions(const co_newton_system *m, double *v) {
    co_vector_remove(n_variables(m), (size_t)m->n_motions, m->motion, v);
}

int32_t co_newton_system_count_negative(co_newton_system *m, double shift, const double *b, double *x,
                                        int32_t *n_negative, curvopt_error *error) {
    if (n_held(m))
        make_columns(m);
    size_t n = n_variables(m), last = (size_t)m->n_dense * n;
    memcpy(m->dense + last, b, n * sizeof *b);
    shift = damp(m, NULL, shift);
    int32_t status =
        co_sparse_cholesky_count_negative(m->factor, shift, m->n_dense + 1, m->dense, m->solved, n_negative, error);
    if (status != CURVOPT_OK || *n_negative < 0)
        return status;
    *n_negative += invert_capacitance(m) - positive_of_weights(m);
    memcpy(x, m->solved + last, n * sizeof *x);
    add_dense(m, x);
    return CURVOPT_OK;
}

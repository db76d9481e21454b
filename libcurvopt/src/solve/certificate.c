/* Whether a cage is a stationary point, and of what kind. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/certificate.h"

#include "base/memory.h"
#include "linalg/vector.h"
#include "mesh/similarity.h"
#include "solve/newton_decrement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_ITERATIONS = 60 };
static const double RESIDUAL = 1e-3;        /* in the preconditioner's norm, of the first one */
static const double DIFFERENCE_STEP = 1e-3; /* longest displacement, in mean edges */

/* out = Hessian v, by a central difference; rigid motions and scaling made stiff as in the model. work [2 n] */
static void difference_product(co_level *l, const double *z, const double *v, double *work, double *out) {
    size_t n = (size_t)l->reduction.n_variables;
    double step = DIFFERENCE_STEP * l->edge / co_dof_map_longest(&l->reduction, v);
    memcpy(work, z, n * sizeof *work);
    co_vector_add(n, step, v, work);
    co_level_evaluate(l, work, out);
    co_vector_add(n, -2 * step, v, work);
    co_level_evaluate(l, work, work + n);
    for (size_t i = 0; i < n; i++)
        out[i] = (out[i] - work[n + i]) / (2 * step);
    co_newton_system_add_stiffness(&l->model, v, out);
}

/* Preconditioned conjugate gradients for H x = g: the decrement is half of g.x, and grows with every step. */
static int32_t conjugate_gradients(co_level *l, const co_iterate *now, double *vectors, double *decrement,
                                   curvopt_error *error) {
    size_t n = (size_t)l->reduction.n_variables;
    double *r = vectors, *s = r + n, *d = s + n, *h = d + n, *work = h + n, first = 0, sum = 0;
    memcpy(r, now->gradient, n * sizeof *r);
    int32_t status = co_newton_system_solve(&l->model, r, s, error);
    double rs = co_vector_dot(n, r, s);
    memcpy(d, s, n * sizeof *d);
    first = rs;
    for (int k = 0; status == CURVOPT_OK && k < LARGEST_ITERATIONS && rs > RESIDUAL * RESIDUAL * first; k++) {
        difference_product(l, now->x, d, work, h);
        double curvature = co_vector_dot(n, d, h);
        if (!(curvature > 0)) {
            *decrement = (double)NAN;
            return CURVOPT_OK;
        }
        double step = rs / curvature, before = rs;
        sum += 0.5 * step * rs; /* of g.x: conjugate directions add up */
        co_vector_add(n, -step, h, r);
        status = co_newton_system_solve(&l->model, r, s, error);
        rs = co_vector_dot(n, r, s);
        for (size_t i = 0; i < n; i++)
            d[i] = s[i] + rs / before * d[i];
    }
    *decrement = sum;
    return status;
}

static int32_t difference_decrement(co_level *l, const co_iterate *now, double *decrement, curvopt_error *error) {
    double *vectors = CO_NEW(double, 6 * (size_t)l->reduction.n_variables);
    if (!vectors)
        return co_status_no_memory(error);
    int32_t status = conjugate_gradients(l, now, vectors, decrement, error);
    free(vectors);
    return status;
}

/* A level of its own at a cage. */
typedef struct probe {
    co_level level;
    co_iterate now;
} probe;

static void probe_free(probe *p) {
    co_level_free(&p->level);
    free(p->now.x);
    free(p->now.gradient);
    *p = (probe){0};
}

static int32_t probe_create(const co_run_context *frame, const curvopt_mesh *m, const co_symmetry *symmetry,
                            const co_constraints *constraints, const double *xyz, const co_level *solved, probe *p,
                            curvopt_error *error) {
    size_t n = 3 * (size_t)m->info.n_vertices;
    *p = (probe){.now = {.x = CO_NEW(double, n), .gradient = CO_NEW(double, n)}};
    int32_t status = p->now.x && p->now.gradient ? CURVOPT_OK : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status =
            co_level_create(frame, m, symmetry, constraints, xyz, frame->options->levels, &p->level, p->now.x, error);
    if (status == CURVOPT_OK && solved)
        status = co_assembly_copy_rules(&p->level.assembly, &solved->assembly, error);
    else if (status == CURVOPT_OK)
        status = co_level_begin(&p->level, &p->now, error);
    if (status == CURVOPT_OK)
        p->now.value = co_level_evaluate(&p->level, p->now.x, p->now.gradient);
    else
        probe_free(p);
    return status;
}

static int32_t check_shape(probe *p, int differences, co_certificate_shape *out, curvopt_error *error) {
    int positive;
    co_level *l = &p->level;
    *out = (co_certificate_shape){.negative_directions = 0};
    if (l->reduction.n_variables == 0)
        return CURVOPT_OK;
    int32_t status = co_newton_decrement_factorize(l, &p->now, 1, &positive, error);
    if (status != CURVOPT_OK)
        return status;
    out->decrement = out->difference_decrement = (double)NAN;
    if (!positive)
        return co_level_count_negative(l, &p->now, &out->negative_directions, error);
    status = co_newton_decrement_by_factor(l, &p->now, &out->decrement, error);
    if (status == CURVOPT_OK && differences)
        status = difference_decrement(l, &p->now, &out->difference_decrement, error);
    return status;
}

int32_t co_certificate_check_shape(const co_run_context *frame, const curvopt_mesh *m, const co_symmetry *symmetry,
                                   const co_constraints *constraints, const double *xyz, const co_level *solved,
                                   int differences, co_certificate_shape *out, curvopt_error *error) {
    co_constraints held = {0}, lines = {0};
    co_run_context own = *frame;
    probe p = {0};
    int32_t status = co_constraints_all(m, constraints, frame->options->boundary, &held, error);
    if (!held.freedom) /* then the cage was normalized by what it is now, not by what it was at first */
        own.radius = co_similarity_frame((size_t)m->info.n_vertices, xyz, own.centroid);
    if (status == CURVOPT_OK)
        status = co_constraints_to_normals(m, &held, xyz, &lines, error);
    if (status == CURVOPT_OK)
        status = probe_create(&own, m, symmetry, &lines, xyz, solved, &p, error);
    if (status == CURVOPT_OK)
        p.level.gauge = co_gauge_of(frame->options->weights, &held); /* motion along normals does not see them either */
    if (status == CURVOPT_OK)
        status = check_shape(&p, differences, out, error);
    probe_free(&p);
    co_constraints_free(&held);
    co_constraints_free(&lines);
    return status;
}

int32_t co_certificate_decrement(co_level *l, co_iterate *now, double *decrement, curvopt_error *error) {
    if (l->reduction.n_variables) /* by the rules that co_level_finish() has settled on */
        now->value = co_level_evaluate(l, now->x, now->gradient);
    return co_newton_decrement(l, now, decrement, NULL, error);
}

int32_t co_certificate_count_negative(const co_run_context *frame, const curvopt_mesh *m,
                                      const co_constraints *constraints, const double *xyz, int32_t *n_negative,
                                      curvopt_error *error) {
    co_symmetry none = {0};
    probe p = {0};
    int32_t status = co_symmetry_none(m, &none, error);
    if (status == CURVOPT_OK)
        status = probe_create(frame, m, &none, constraints, xyz, NULL, &p, error);
    if (status == CURVOPT_OK)
        status = co_level_count_negative(&p.level, &p.now, n_negative, error);
    probe_free(&p);
    co_symmetry_free(&none);
    return status;
}

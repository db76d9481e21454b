/* Subdomains: weighted subsets of a cage's faces. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/subdomain.h"

#include "base/memory.h"
#include "mesh/submesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int32_t co_subdomain_extract(const curvopt_mesh *m, const double *face_weight, curvopt_mesh **part, int32_t *vertex_of,
                             int32_t *face_of, curvopt_error *error) {
    int32_t *vertices = NULL, n = 0, any = 0, status = CURVOPT_ERROR_MEMORY;
    uint8_t *keep = CO_NEW(uint8_t, m->info.n_faces);
    *part = NULL;
    if (!keep)
        return co_status_no_memory(error);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        any |= keep[f] = face_weight[f] != 0;
    if (any)
        status = co_submesh_grow(m, CO_PATCHES_HALO, keep, error);
    else
        status = co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "no face counts: all weights are 0");
    if (status == CURVOPT_OK)
        status = co_submesh_extract(m, keep, part, &vertices, error);
    if (status == CURVOPT_OK) {
        memcpy(vertex_of, vertices, sizeof(int32_t) * (size_t)(*part)->info.n_vertices);
        for (int32_t f = 0; f < m->info.n_faces; f++)
            if (keep[f])
                face_of[n++] = f;
    }
    free(vertices);
    free(keep);
    return status;
}

void co_subdomain_sum(co_assembly *a, const double *x, int all_terms, double *gradients, curvopt_sums *out) {
    const co_functional *f = &a->functional;
    size_t n = 3 * (size_t)a->patches.n_cage;
    co_pieces pieces = {0};
    co_values values;
    if (gradients) {
        memset(gradients, 0, 3 * n * sizeof *gradients);
        pieces = (co_pieces){.second = gradients, .third = gradients + n, .area = gradients + 2 * n};
    }
    co_assembly_pieces(a, x, all_terms, &pieces, &values);
    *out = (curvopt_sums){.area = values.integral[CO_INT_AREA],
                          .second = f->has_second ? co_functional_integrate(&f->second, values.integral) : 0,
                          .third = f->has_third ? co_functional_integrate(&f->third, values.integral) : 0,
                          .gauss = values.integral[CO_INT_K],
                          .turning = co_assembly_turning(a),
                          .samples = (double)a->batches.n_samples,
                          .min_jacobian = values.min_jacobian};
    values.integral[CO_INT_AREA] = 1; /* the factor of third-order terms */
    co_functional_terms(values.integral, f->has_third || (all_terms && a->third_allowed), out->term);
    out->term[CURVOPT_TERM_AREA] = out->area;
}

/* Adds sign * each patch's contribution to the objective to its face, to first order in the whole's area. */
static void add_contributions(const co_assembly *a, const co_element_batches *l, const co_whole *whole, double sign,
                              double *errors) {
    co_integrand integrand = a->functional.second;
    co_integrand_add(&integrand, whole->area, &a->functional.third);
    integrand.area += whole->third;
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t lane = 0; lane < l->block[b].n_used; lane++) {
            double integral[CO_N_INTEGRALS];
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                integral[i] = co_element_batches_sum(l, b, lane, i);
            errors[a->patches.place[co_element_batches_patch(l, b, lane)].face] +=
                sign * co_functional_integrate(&integrand, integral);
        }
}

int32_t co_subdomain_errors(co_assembly *a, const double *x, const co_whole *whole, double *errors,
                            curvopt_error *error) {
    co_values values;
    int third = a->functional.has_third;
    co_whole used = {whole->area, third ? whole->third : 0};
    co_assembly_pieces(a, x, 0, &(co_pieces){0}, &values);
    int32_t status = co_adaptive_quadrature_evaluate_finer(a, third, &values, error);
    if (status != CURVOPT_OK)
        return status;
    add_contributions(a, &a->batches, &used, 1, errors);
    add_contributions(a, &a->finer_batches, &used, -1, errors);
    return CURVOPT_OK;
}

void co_subdomain_get_rules(const co_assembly *a, int32_t n_faces, int32_t *rules) {
    for (int32_t f = 0; f < n_faces; f++)
        rules[f] = -1;
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        int32_t *rule = &rules[a->patches.place[p].face];
        *rule = a->rule[p] > *rule ? a->rule[p] : *rule;
    }
}

int32_t co_subdomain_set_rules(co_assembly *a, const int32_t *rules, curvopt_error *error) {
    for (int32_t p = 0; p < a->patches.n_patches; p++) {
        int32_t f = a->patches.place[p].face;
        if (rules[f] < 0 || rules[f] > CO_FINEST_RULE)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f, "rules[%d] is %d; it must be 0 to %d", f, rules[f],
                                  CO_FINEST_RULE);
    }
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        a->rule[p] = (int8_t)rules[a->patches.place[p].face];
    return co_assembly_update_batches(a, error);
}

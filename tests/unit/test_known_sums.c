/* Sums that are known are not evaluated again, and are those that another evaluation would find.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "energy/adaptive_quadrature.h"

#include <stdlib.h>

typedef struct problem {
    cage c;
    curvopt_mesh *mesh;
    curvopt_cancel *flag;
    co_basis_table_cache tables;
    co_cancel cancel;
    co_assembly *assembly; /* on the heap: it must stay where it is */
} problem;

static problem *problem_of(int term) {
    problem *p = calloc(1, sizeof *p);
    curvopt_options o;
    curvopt_error error;
    CHECK_TRUE(p != NULL);
    p->c = cage_refined(cage_cube(), 1);
    cage_perturb(&p->c, 0.2, 7);
    p->mesh = cage_mesh(&p->c);
    curvopt_options_init(&o, sizeof o);
    memset(o.weights, 0, sizeof o.weights);
    o.weights[term] = 1;
    o.surface = CURVOPT_SURFACE_POLYNOMIAL;
    o.threads = 1;
    co_basis_table_cache_create(o.surface, &p->tables);
    CHECK_OK(curvopt_cancel_create(&p->flag, &error), &error);
    co_cancel_start_at_once(&p->cancel, p->flag);
    p->tables.cancel = &p->cancel;
    p->assembly = calloc(1, sizeof *p->assembly);
    CHECK_TRUE(p->flag && p->assembly);
    CHECK_OK(co_assembly_create(p->mesh, NULL, NULL, &o, &p->tables, NULL, p->assembly, &error), &error);
    return p;
}

static void problem_free(problem *p) {
    co_assembly_free(p->assembly);
    free(p->assembly);
    co_basis_table_cache_free(&p->tables);
    curvopt_cancel_destroy(p->flag);
    curvopt_mesh_destroy(p->mesh);
    cage_free(&p->c);
    free(p);
}

static curvopt_energies resolve(problem *p, double tolerance, co_terms terms, int *changed) {
    const co_quadrature_goal goal = {.tolerance = tolerance, .terms = terms};
    curvopt_energies e;
    curvopt_error error;
    int resolved;
    CHECK_OK(co_adaptive_quadrature_resolve(p->assembly, p->c.xyz, &goal, &e, &resolved, changed, &error), &error);
    return e;
}

static co_values evaluate(problem *p, int volume) {
    co_values values;
    co_assembly_evaluate(p->assembly, p->c.xyz, &(co_request){.volume = volume}, &values);
    return values;
}

static void check_same(const co_values *x, const co_values *y) {
    CHECK_TRUE(x->objective == y->objective && x->min_jacobian == y->min_jacobian && x->worst_face == y->worst_face);
    for (int i = 0; i < CO_N_INTEGRALS; i++)
        CHECK_TRUE(x->integral[i] == y->integral[i]);
}

/* After several passes figures and their claims have the bits of an assembly that has its rules from the first. */
static void test_figures_are_those_of_a_fresh_evaluation(void **state) {
    (void)state;
    static const int terms[] = {CURVOPT_TERM_WILLMORE, CURVOPT_TERM_MVS};
    for (size_t i = 0; i < sizeof terms / sizeof *terms; i++) {
        problem *p = problem_of(terms[i]), *fresh = problem_of(terms[i]);
        curvopt_error error;
        int changed;
        const curvopt_energies first = resolve(p, 1e-5, CO_TERMS_REPORT, &changed);
        CHECK_TRUE(changed);
        CHECK_OK(co_assembly_copy_rules(fresh->assembly, p->assembly, &error), &error);
        const curvopt_energies again = resolve(p, 1e-5, CO_TERMS_REPORT, &changed);
        CHECK_TRUE(!changed);
        const curvopt_energies alone = resolve(fresh, 1e-5, CO_TERMS_REPORT, &changed);
        CHECK_TRUE(!changed);
        CHECK_TRUE(memcmp(&first, &alone, sizeof first) == 0);
        CHECK_TRUE(memcmp(&again, &alone, sizeof first) == 0);
        problem_free(p);
        problem_free(fresh);
    }
}

/* When rules are raised every patch's sums by its new rule are known, and by a third rule none are. */
static void test_sums_outlive_their_batches(void **state) {
    (void)state;
    problem *p = problem_of(CURVOPT_TERM_MVS);
    co_assembly *a = p->assembly;
    curvopt_error error;
    int changed;
    resolve(p, 1e-1, CO_TERMS_OBJECTIVE, &changed);
    const int32_t n = a->batches.n_blocks;
    const co_sums_of wanted = {.placement = a->placement, .third = 1};
    CHECK_BETWEEN(n, 2, 1000);
    CHECK_INT(a->batches.n_known, n);
    for (int32_t i = 0; i < a->patches.n_patches; i++)
        a->rule[i]++;
    CHECK_OK(co_assembly_update_batches(a, &error), &error);
    CHECK_INT(a->batches.n_known, 0);
    co_known_sums_give(&a->known, &wanted, &a->batches);
    CHECK_INT(a->batches.n_known, a->batches.n_blocks);
    for (int32_t i = 0; i < a->patches.n_patches; i++)
        a->rule[i]++;
    CHECK_OK(co_assembly_update_batches(a, &error), &error);
    co_known_sums_give(&a->known, &wanted, &a->batches);
    CHECK_INT(a->batches.n_known, 0);
    problem_free(p);
}

/* At other positions, and of another kind, nothing is known; back at the first ones values are the same. */
static void test_other_positions_are_evaluated(void **state) {
    (void)state;
    problem *p = problem_of(CURVOPT_TERM_MVS);
    const co_values first = evaluate(p, 0), same = evaluate(p, 0);
    const double was = p->c.xyz[4];
    check_same(&first, &same);
    p->c.xyz[4] = was * (1 + 1e-12);
    const co_values other = evaluate(p, 0);
    CHECK_TRUE(other.integral[CO_INT_F1] != first.integral[CO_INT_F1]);
    CHECK_NEAR(other.objective, first.objective, 1e-6 * first.objective);
    p->c.xyz[4] = was;
    const co_values back = evaluate(p, 0);
    check_same(&first, &back);
    const co_values with_volume = evaluate(p, 1);
    CHECK_TRUE(first.integral[CO_INT_VOLUME] == 0 && with_volume.integral[CO_INT_VOLUME] > 0);
    double integral[CO_N_INTEGRALS];
    co_assembly_numbers(p->assembly, p->assembly->points, 0, integral); /* area and volume alone */
    CHECK_NEAR(integral[CO_INT_VOLUME], with_volume.integral[CO_INT_VOLUME], 1e-14);
    const co_values after = evaluate(p, 1);
    check_same(&with_volume, &after);
    problem_free(p);
}

/* What was cancelled is not known. */
static void test_what_was_cancelled_is_evaluated_again(void **state) {
    (void)state;
    problem *p = problem_of(CURVOPT_TERM_MVS);
    const co_values first = evaluate(p, 0);
    p->c.xyz[4] *= 1.25;
    curvopt_cancel_request(p->flag);
    const co_values none = evaluate(p, 0);
    CHECK_TRUE(isnan(none.objective));
    CHECK_INT(p->assembly->batches.n_known, 0);
    atomic_store(&p->flag->requested, 0);
    const co_values second = evaluate(p, 0);
    CHECK_TRUE(isfinite(second.objective) && second.objective != first.objective);
    problem_free(p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_figures_are_those_of_a_fresh_evaluation),
        cmocka_unit_test(test_sums_outlive_their_batches),
        cmocka_unit_test(test_other_positions_are_evaluated),
        cmocka_unit_test(test_what_was_cancelled_is_evaluated_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

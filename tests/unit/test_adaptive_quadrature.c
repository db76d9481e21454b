/* Adaptive quadrature: the marking on toy numbers, claimed errors by hand, rules of small cages against finer ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "base/constants.h"
#include "energy/adaptive_quadrature.h"

/* ------------------------------------------------------------------------------------------------- marking -- */

static double threshold_of(const double (*pair)[2], int32_t n, double unmarked, double tie) {
    co_marking_candidate candidates[8];
    for (int32_t i = 0; i < n; i++)
        candidates[i] = (co_marking_candidate){.error_per_cost = pair[i][0], .error = pair[i][1]};
    return co_marking_threshold(candidates, n, unmarked, tie);
}

static void test_unmarked_candidates_stay_below_the_bound(void **state) {
    (void)state;
    const double pair[4][2] = {{1, 1}, {2, 8}, {3, 3}, {0.5, 2}}; /* the example of marking.h */
    CHECK_NEAR(threshold_of(pair, 4, 1.9, 0), 0.5, 0);
    CHECK_NEAR(threshold_of(pair, 4, 2, 0), 1, 0);
    CHECK_NEAR(threshold_of(pair, 4, 4, 0), 2, 0);
    CHECK_NEAR(threshold_of(pair, 4, 11, 0), 3, 0);
    CHECK_NEAR(threshold_of(pair, 4, 13.9, 0), 3, 0);
    CHECK_TRUE(isinf(threshold_of(pair, 4, 14, 0)));
    CHECK_TRUE(isinf(threshold_of(pair, 0, 0, 0)));
}

static void test_like_candidates_are_marked_alike(void **state) {
    (void)state;
    const double pair[3][2] = {{2, 2}, {2 * (1 + 1e-9), 2}, {2 * (1 - 1e-9), 2}};
    double threshold = threshold_of(pair, 3, 3, 1e-6);
    for (int i = 0; i < 3; i++)
        CHECK_TRUE(pair[i][0] >= threshold);
    threshold = threshold_of(pair, 3, 3, 0);
    CHECK_TRUE(pair[2][0] < threshold && pair[0][0] >= threshold && pair[1][0] >= threshold);
}

/* An error that is no number comes last, and no threshold lies behind it. */
static void test_errors_that_are_no_numbers_come_last(void **state) {
    (void)state;
    CHECK_NEAR(co_marking_error_per_cost(6, 3), 2, 0);
    CHECK_TRUE(isinf(co_marking_error_per_cost(NAN, 3)));
    const double pair[2][2] = {{INFINITY, NAN}, {1, 1}};
    CHECK_TRUE(isinf(threshold_of(pair, 2, 5, 1e-6)));
    CHECK_NEAR(threshold_of(pair, 2, 0.5, 0), 1, 0);
}

/* ---------------------------------------------------------------------------------------------- errors -- */

static void test_claimed_errors_cancel_and_their_doubts_add(void **state) {
    (void)state;
    co_quadrature_error a = {0}, b = {0};
    co_tuning tuning = co_tuning_defaults;
    tuning.quadrature_reference = 0.2;
    co_quadrature_error_add(&a, &tuning, &(co_quadrature_change){.all = 3, .first = 3.5, .last = -0.5});
    co_quadrature_error_add(&a, &tuning, &(co_quadrature_change){.all = -5, .first = -5.25, .last = 0.25});
    CHECK_NEAR(co_quadrature_error_claimed(&a), 2 + 0.2 * 0.75, 1e-15);
    co_quadrature_error_add(&b, &tuning, &(co_quadrature_change){.all = 1, .last = 1});
    co_quadrature_error_join(&a, &b);
    CHECK_NEAR(co_quadrature_error_claimed(&a), 1 + 0.2 * 1.75, 1e-15);
}

/* The part of a jump counts if it is more than that of the last change, but within the largest change's multiple. */
static void test_claimed_errors_have_what_rules_miss_at_umbilics(void **state) {
    (void)state;
    co_tuning tuning = co_tuning_defaults;
    tuning.quadrature_reference = 0.5;
    tuning.quadrature_jump = 0.25;
    tuning.quadrature_agreement = 4;
    static const struct {
        co_quadrature_change change;
        double claimed;
    } cases[] = {{{.first = 1, .last = -1, .jump = 1}, 0.5}, {{.first = 1, .last = -1, .jump = 4}, 1},
                 {{.first = -2, .last = 1, .jump = 12}, 3},  {{.first = 1, .last = -2, .jump = 12}, 3},
                 {{.first = 1, .last = 0.5, .jump = 20}, 4}, {{.first = 0, .last = 0, .jump = 20}, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        co_quadrature_error e = {0};
        co_quadrature_error_add(&e, &tuning, &cases[i].change);
        CHECK_NEAR(co_quadrature_error_claimed(&e), cases[i].claimed, 1e-15);
    }
}

static void test_differences_are_of_the_objective_or_of_the_worst_term(void **state) {
    (void)state;
    double weights[CURVOPT_N_TERMS] = {0};
    co_patch_terms x = {.term = {0}}, y = {.term = {0}};
    co_quadrature_error_measure measure = {.weights.term = weights};
    weights[CURVOPT_TERM_WILLMORE] = 2;
    weights[CURVOPT_TERM_MVS] = 1;
    x.term[CURVOPT_TERM_WILLMORE] = 3;
    y.term[CURVOPT_TERM_WILLMORE] = 2;
    x.term[CURVOPT_TERM_MVS] = 1;
    y.term[CURVOPT_TERM_MVS] = 2;
    x.term[CURVOPT_TERM_AREA] = 1;
    y.term[CURVOPT_TERM_AREA] = 3;
    x.term[CURVOPT_TERM_MEAN] = NAN; /* a term without a weight is not read */
    CHECK_NEAR(co_quadrature_error_difference(&measure.weights, &x, &y), 1, 0);
    measure.whole.term[CURVOPT_TERM_WILLMORE] = 10;
    measure.whole.term[CURVOPT_TERM_MVS] = 20;
    measure.whole.term[CURVOPT_TERM_AREA] = 4;
    CHECK_NEAR(co_quadrature_error_relative(&measure, &x, &y), 1.0 / 40, 1e-16);
    measure.every_term = 1;
    CHECK_NEAR(co_quadrature_error_relative(&measure, &x, &y), 0.5, 1e-16);
}

/* ------------------------------------------------------------------------------------------------- rules -- */

static curvopt_options options_of(int term) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    memset(o.weights, 0, sizeof o.weights);
    o.weights[term] = 1;
    o.surface = CURVOPT_SURFACE_POLYNOMIAL;
    o.threads = 1;
    return o;
}

typedef struct problem {
    cage c;
    curvopt_mesh *mesh;
    co_assembly *assembly; /* on the heap: it must stay where it is */
} problem;

static problem problem_on(int32_t surface, cage c, int term) {
    problem p = {.c = c, .mesh = cage_mesh(&c), .assembly = calloc(1, sizeof(co_assembly))};
    curvopt_options o = options_of(term);
    curvopt_error error;
    CHECK_TRUE(p.assembly != NULL);
    o.surface = surface;
    CHECK_OK(co_assembly_create(p.mesh, NULL, NULL, &o, NULL, NULL, p.assembly, &error), &error);
    return p;
}

static problem problem_of(cage c, int term) {
    return problem_on(CURVOPT_SURFACE_POLYNOMIAL, c, term);
}

static void problem_free(problem *p) {
    co_assembly_free(p->assembly);
    free(p->assembly);
    curvopt_mesh_destroy(p->mesh);
    cage_free(&p->c);
}

static curvopt_energies resolve(problem *p, double tolerance, co_terms terms, int *resolved, int *changed) {
    co_quadrature_goal goal = {.tolerance = tolerance, .terms = terms};
    curvopt_energies e;
    curvopt_error error;
    CHECK_OK(co_adaptive_quadrature_resolve(p->assembly, p->c.xyz, &goal, &e, resolved, changed, &error), &error);
    return e;
}

static int64_t sum_of_rules(const problem *p) {
    int64_t sum = 0;
    for (int32_t i = 0; i < p->assembly->patches.n_patches; i++)
        sum += p->assembly->rule[i];
    return sum;
}

static cage bumpy_cube(double amount) {
    cage c = cage_refined(cage_cube(), 1);
    cage_perturb(&c, amount, 7);
    return c;
}

/* The error against a tolerance a thousand times as fine is below the tolerance, and not hundreds of times below. */
static void test_the_tolerance_is_met_and_not_missed_by_far(void **state) {
    (void)state;
    static const int terms[] = {CURVOPT_TERM_WILLMORE, CURVOPT_TERM_MVS};
    for (int k = 0; k < 2; k++) {
        problem rough = problem_of(bumpy_cube(0.1), terms[k]), fine = problem_of(bumpy_cube(0.1), terms[k]);
        int resolved, changed;
        curvopt_energies e = resolve(&rough, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed);
        CHECK_TRUE(resolved);
        curvopt_energies best = resolve(&fine, 1e-6, CO_TERMS_OBJECTIVE, &resolved, &changed);
        CHECK_TRUE(resolved && changed);
        double off = fabs(e.objective / best.objective - 1);
        CHECK_BETWEEN(off, 0, 1e-3);
        CHECK_TRUE(rough.assembly->estimates.sum > 1e-5);
        CHECK_TRUE(e.n_samples < best.n_samples);
        resolve(&rough, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed);
        CHECK_TRUE(resolved && !changed);
        problem_free(&rough);
        problem_free(&fine);
    }
}

/* The faces of a torus with a ridge fall into N_V orbits of its symmetries, and errors differ from orbit to orbit. */
static void test_symmetric_patches_get_the_same_rules(void **state) {
    (void)state;
    enum { N_U = 6, N_V = 5 };
    cage c = cage_torus(N_U, N_V, 1, 0.6);
    for (int32_t i = 0; i < 3 * N_U; i++)
        c.xyz[3 * N_V * (i / 3) + i % 3] *= i % 3 == 2 ? 1 : 1.3;
    problem p = problem_of(c, CURVOPT_TERM_MVS);
    int resolved, changed, differ = 0;
    resolve(&p, 1e-5, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(resolved && changed);
    CHECK_INT(p.assembly->patches.n_patches, N_U * N_V);
    uint8_t of_face[N_U * N_V];
    for (int32_t i = 0; i < N_U * N_V; i++)
        of_face[p.assembly->patches.place[i].face] = p.assembly->rule[i];
    for (int32_t f = 0; f < N_U * N_V; f++) {
        CHECK_INT(of_face[f], of_face[f % N_V]);
        differ |= of_face[f] != of_face[0];
    }
    CHECK_TRUE(differ); /* else the cage is no test */
    problem_free(&p);
}

/* Rules that met 1e-3 stay while the error is below `hysteresis` times the tolerance. */
static void test_rules_that_met_the_tolerance_are_kept_for_a_while(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    co_tuning tuning = *p.assembly->tuning;
    int resolved, changed;
    p.assembly->tuning = &tuning;
    resolve(&p, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed);
    double tolerance = p.assembly->estimates.sum / 2;
    CHECK_TRUE(p.assembly->met);
    resolve(&p, tolerance, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(resolved && !changed);
    tuning.quadrature_hysteresis = 1.5;
    resolve(&p, tolerance, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(resolved && changed);
    CHECK_BETWEEN(p.assembly->estimates.sum, 0, tolerance);
    problem_free(&p);
}

/* Rules at their finest that miss the tolerance: resolved up to an error of 1e-2. */
static void test_a_missed_tolerance_may_be_acceptable(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    int resolved, changed;
    resolve(&p, 1e-30, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(resolved && changed && !p.assembly->met);
    CHECK_BETWEEN(p.assembly->estimates.sum, 1e-20, CO_ACCEPTABLE_ERROR);
    problem_free(&p);
}

/* With all terms, the third-order ones have to meet the tolerance, too, which takes finer rules. */
static void test_all_terms_take_finer_rules_than_the_objective(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_AREA);
    int resolved, changed;
    curvopt_energies e = resolve(&p, 1e-4, CO_TERMS_OBJECTIVE, &resolved, &changed);
    int64_t rules = sum_of_rules(&p);
    CHECK_TRUE(isnan(e.term[CURVOPT_TERM_MVS]));
    e = resolve(&p, 1e-4, CO_TERMS_REPORT, &resolved, &changed);
    CHECK_TRUE(isfinite(e.term[CURVOPT_TERM_MVS]) && isfinite(e.term_error[CURVOPT_TERM_MVS]));
    CHECK_INT(sum_of_rules(&p), rules);
    double error = e.term_error[CURVOPT_TERM_MVS] / e.term[CURVOPT_TERM_MVS];
    e = resolve(&p, 1e-4, CO_TERMS_ALL, &resolved, &changed);
    CHECK_TRUE(changed && sum_of_rules(&p) > rules);
    CHECK_TRUE(e.term_error[CURVOPT_TERM_MVS] / e.term[CURVOPT_TERM_MVS] < error / 2);
    problem_free(&p);
}

/* A third rule where errors are largest, unless they are negligible. */
static void test_a_third_rule_is_compared_where_errors_are_largest(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    co_tuning tuning = *p.assembly->tuning;
    const co_quadrature_estimates *e = &p.assembly->estimates;
    int32_t n = p.assembly->patches.n_patches, n_third = 0;
    int resolved, changed;
    double unseen = 0, least = INFINITY, largest = 0;
    p.assembly->tuning = &tuning;
    resolve(&p, 1e-3, CO_TERMS_REPORT, &resolved, &changed);
    for (int32_t i = 0; i < n; i++) {
        n_third += e->has_third_rule[i];
        unseen += e->has_third_rule[i] ? 0 : e->error[i];
        if (e->has_third_rule[i])
            least = fmin(least, e->error_per_cost[i]);
        else
            largest = fmax(largest, e->error_per_cost[i]);
    }
    CHECK_BETWEEN(n_third, 1, n - 1);
    CHECK_BETWEEN(unseen, 0, tuning.quadrature_two_rules * e->sum);
    CHECK_TRUE(least > largest);
    tuning.quadrature_negligible = 1;
    resolve(&p, 1e-3, CO_TERMS_REPORT, &resolved, &changed);
    for (int32_t i = 0; i < n; i++)
        CHECK_INT(e->has_third_rule[i], 0);
    problem_free(&p);
}

/* Sums of each patch that is in some batches; counts how often each is in. */
static void sums_of(co_assembly *a, co_element_batches *l, double (*sums)[CO_N_SUMS], int *times) {
    co_values values;
    curvopt_error error;
    CHECK_OK(co_assembly_evaluate_batches(a, l, 1, &values, &error), &error);
    for (int32_t b = 0; b < l->n_blocks; b++)
        for (int32_t k = 0; k < l->block[b].n_used; k++) {
            const int32_t patch = co_element_batches_patch(l, b, k);
            times[patch]++;
            for (int i = 0; i < CO_N_SUMS; i++)
                sums[patch][i] = co_element_batches_sum(l, b, k, i);
        }
}

/* Blocks of some patches have these alone, whatever rules the others have, and the same bits for each as blocks of all.
 */
static void test_blocks_can_be_of_some_patches(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_MVS);
    enum { MOST = 64 };
    co_assembly *a = p.assembly;
    const int32_t n = a->patches.n_patches;
    int8_t rule[MOST];
    uint8_t only[MOST];
    double all_sums[MOST][CO_N_SUMS], some_sums[MOST][CO_N_SUMS];
    int in_all[MOST] = {0}, in_some[MOST] = {0}, resolved, changed;
    co_element_batches all, some;
    co_element_batches_spec spec = {
        .patches = &a->patches, .cache = a->cache, .lanes = a->kernel->lanes, .rule = rule, .step = 2};
    curvopt_error error;
    CHECK_BETWEEN(n, 12, MOST);
    resolve(&p, 1e-1, CO_TERMS_OBJECTIVE, &resolved, &changed);
    for (int32_t i = 0; i < n; i++)
        rule[i] = (int8_t)(i % 2), only[i] = i % 3 == 0;
    CHECK_OK(co_element_batches_create(&spec, &all, &error), &error);
    for (int32_t i = 0; i < n; i++)
        if (!only[i] && i % 2)
            rule[i] = CO_FINEST_RULE; /* two steps from it there are no tables */
    spec.only = only;
    CHECK_OK(co_element_batches_create(&spec, &some, &error), &error);
    sums_of(a, &all, all_sums, in_all);
    sums_of(a, &some, some_sums, in_some);
    for (int32_t i = 0; i < n; i++) {
        CHECK_INT(in_all[i], 1);
        CHECK_INT(in_some[i], only[i]);
        for (int s = 0; only[i] && s < CO_N_SUMS; s++)
            CHECK_TRUE(all_sums[i][s] == some_sums[i][s]);
    }
    co_element_batches_free(&all);
    co_element_batches_free(&some);
    problem_free(&p);
}

/* The term `area` is off by the same part as the area, not by as many times that as there are patches; and third-order
 * terms, which have the area for a factor, have its finest rule's part in their claim. */
static void test_errors_of_the_area_are_in_all_that_has_it(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.3), CURVOPT_TERM_AREA);
    co_tuning tuning = *p.assembly->tuning;
    int resolved, changed;
    p.assembly->tuning = &tuning;
    p.assembly->weights[CURVOPT_TERM_VARIATION] = 1e-3;
    const curvopt_energies e = resolve(&p, 1e-2, CO_TERMS_ALL, &resolved, &changed);
    const double part = e.area_error / e.area;
    CHECK_TRUE(part > 1e-9);
    CHECK_NEAR(e.term_error[CURVOPT_TERM_AREA] / e.term[CURVOPT_TERM_AREA], part, 1e-9 * part);
    CHECK_BETWEEN(e.objective_error,
                  fabs(1e-3 * e.term_error[CURVOPT_TERM_VARIATION] - e.term_error[CURVOPT_TERM_AREA]),
                  1e-3 * e.term_error[CURVOPT_TERM_VARIATION] + e.term_error[CURVOPT_TERM_AREA]);
    tuning.quadrature_reference = 0; /* what is seen alone */
    const curvopt_energies seen = resolve(&p, 1e-2, CO_TERMS_ALL, &resolved, &changed);
    tuning.quadrature_reference = 1;
    const curvopt_energies all = resolve(&p, 1e-2, CO_TERMS_ALL, &resolved, &changed);
    const double area_part = (all.area_error - seen.area_error) / all.area;
    CHECK_TRUE(area_part > 0);
    CHECK_BETWEEN(all.term_error[CURVOPT_TERM_VARIATION] - seen.term_error[CURVOPT_TERM_VARIATION],
                  area_part * all.term[CURVOPT_TERM_VARIATION], INFINITY);
    problem_free(&p);
}

/* Terms of two patches, one with a third rule: whatever is multiplied by the area gets the finest rules' sum of it. */
static void test_third_order_terms_get_the_best_area(void **state) {
    (void)state;
    co_patch_terms finer[2] = {{.term = {[CURVOPT_TERM_WILLMORE] = 1, [CURVOPT_TERM_MVS] = 2}, .jump = 4},
                               {.term = {[CURVOPT_TERM_VARIATION] = 6}}};
    co_patch_terms finest[2] = {{.term = {[CURVOPT_TERM_MVS] = 8}}, {.term = {[CURVOPT_TERM_MVS] = 8}}};
    uint8_t has_third_rule[2] = {0, 1};
    co_quadrature_estimates e = {.finer = finer, .finest = finest, .has_third_rule = has_third_rule};
    finer[0].number[CURVOPT_SCALAR_AREA] = 1;
    finer[1].number[CURVOPT_SCALAR_AREA] = 1;
    finest[0].number[CURVOPT_SCALAR_AREA] = 100;
    finest[1].number[CURVOPT_SCALAR_AREA] = 2;
    co_quadrature_estimates_use_best_area(&e, 2, 2);
    CHECK_NEAR(finer[0].term[CURVOPT_TERM_WILLMORE], 1, 0);
    CHECK_NEAR(finer[0].term[CURVOPT_TERM_MVS], 3, 1e-15);
    CHECK_NEAR(finer[0].jump, 6, 1e-15);
    CHECK_NEAR(finer[1].term[CURVOPT_TERM_VARIATION], 9, 1e-15);
    CHECK_NEAR(finest[0].term[CURVOPT_TERM_MVS], 8, 0);
    CHECK_NEAR(finest[1].term[CURVOPT_TERM_MVS], 12, 1e-15);
}

/* Rules that a bad shape has made fine are taken back on a good one, up to half of the tolerance. */
static void test_rules_become_coarser_again(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.3), CURVOPT_TERM_WILLMORE);
    int resolved, changed, rounds = 0;
    curvopt_error error;
    resolve(&p, 1e-6, CO_TERMS_OBJECTIVE, &resolved, &changed);
    int64_t rules = sum_of_rules(&p);
    CHECK_OK(co_adaptive_quadrature_coarsen(p.assembly, INFINITY, &changed, &error), &error);
    CHECK_TRUE(!changed && sum_of_rules(&p) == rules);
    do {
        curvopt_energies before = resolve(&p, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed);
        CHECK_TRUE(resolved && !changed);
        CHECK_OK(co_adaptive_quadrature_coarsen(p.assembly, 1e-3, &changed, &error), &error);
        curvopt_energies after = resolve(&p, 1, CO_TERMS_OBJECTIVE, &resolved, &(int){0});
        if (changed) {
            CHECK_TRUE(after.n_samples < 0.9 * before.n_samples);
            CHECK_BETWEEN(fabs(after.objective / before.objective - 1), 0, 0.5e-3);
        } else {
            CHECK_INT(after.n_samples, before.n_samples);
        }
    } while (changed && ++rounds < 20);
    CHECK_BETWEEN(rounds, 1, 19);
    CHECK_TRUE(sum_of_rules(&p) < rules);
    problem_free(&p);
}

static int is_regular(const problem *p, int32_t i) {
    return p->assembly->patches.kind[i] == CO_FAN_REGULAR;
}

/* Where they are allowed, faces at extraordinary vertices of the limit surface begin with them, and nothing else does;
 * where they are not any more, all is as if they never had been. */
static void test_rough_rules_are_for_a_while(void **state) {
    (void)state;
    problem p = problem_on(CURVOPT_SURFACE_LIMIT, bumpy_cube(0.1), CURVOPT_TERM_WILLMORE),
            other = problem_on(CURVOPT_SURFACE_LIMIT, bumpy_cube(0.1), CURVOPT_TERM_WILLMORE),
            blended = problem_of(bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    int resolved, changed, n_rough = 0;
    curvopt_error error;
    const curvopt_energies plain = resolve(&p, 1, CO_TERMS_OBJECTIVE, &resolved, &changed),
                           best = resolve(&other, 1e-6, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_OK(co_assembly_set_coarsest(p.assembly, CO_ROUGH_RULE, &error), &error);
    for (int32_t i = 0; i < p.assembly->patches.n_patches; i++) {
        CHECK_INT(p.assembly->rule[i], is_regular(&p, i) ? 0 : CO_ROUGH_RULE);
        n_rough += !is_regular(&p, i);
    }
    CHECK_BETWEEN(n_rough, 1, p.assembly->patches.n_patches);
    const curvopt_energies rough = resolve(&p, 1, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(!changed && rough.n_samples < 0.7 * plain.n_samples);
    CHECK_BETWEEN(fabs(rough.objective / best.objective - 1), 1e-5, 0.1);
    CHECK_BETWEEN(rough.objective_error / fabs(rough.objective - best.objective), 0.3, 10);
    CHECK_OK(co_assembly_copy_rules(other.assembly, p.assembly, &error), &error); /* which has none of them */
    for (int32_t i = 0; i < p.assembly->patches.n_patches; i++)
        CHECK_INT(other.assembly->rule[i], 0);
    CHECK_OK(co_assembly_set_coarsest(p.assembly, 0, &error), &error);
    const curvopt_energies again = resolve(&p, 1, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(!changed && again.n_samples == plain.n_samples && again.objective == plain.objective);
    CHECK_OK(co_adaptive_quadrature_coarsen(p.assembly, 1, &changed, &error), &error);
    CHECK_TRUE(!changed && sum_of_rules(&p) == 0);
    CHECK_OK(co_assembly_set_coarsest(blended.assembly, CO_ROUGH_RULE, &error), &error);
    CHECK_TRUE(sum_of_rules(&blended) == 0); /* blends have no such rule */
    problem_free(&p);
    problem_free(&other);
    problem_free(&blended);
}

/* A rule that was raised may become a rough one again. */
static void test_rules_become_rough_again(void **state) {
    (void)state;
    problem p = problem_on(CURVOPT_SURFACE_LIMIT, bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    int resolved, changed = 1, n_rough = 0;
    curvopt_error error;
    CHECK_OK(co_assembly_set_coarsest(p.assembly, CO_ROUGH_RULE, &error), &error);
    resolve(&p, 1e-5, CO_TERMS_OBJECTIVE, &resolved, &changed);
    CHECK_TRUE(sum_of_rules(&p) > 0);
    for (int rounds = 0; changed && rounds < 20; rounds++) {
        resolve(&p, 1, CO_TERMS_OBJECTIVE, &resolved, &changed);
        CHECK_OK(co_adaptive_quadrature_coarsen(p.assembly, 1, &changed, &error), &error);
    }
    for (int32_t i = 0; i < p.assembly->patches.n_patches; i++) {
        CHECK_BETWEEN(p.assembly->rule[i], is_regular(&p, i) ? 0 : CO_ROUGH_RULE, CO_FINEST_RULE);
        n_rough += p.assembly->rule[i] == CO_ROUGH_RULE;
    }
    CHECK_BETWEEN(n_rough, 1, p.assembly->patches.n_patches);
    problem_free(&p);
}

/* ------------------------------------------------------------------------------------------------- check -- */

static void test_what_is_no_surface_is_refused(void **state) {
    (void)state;
    problem p = problem_of(bumpy_cube(0.1), CURVOPT_TERM_WILLMORE);
    int resolved, changed;
    curvopt_error error;
    const curvopt_energies good = resolve(&p, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed);
    curvopt_energies e = good;
    CHECK_OK(co_adaptive_quadrature_check(p.assembly, &e, &error), &error);
    e.area = 0.9e-9 * p.assembly->radius * p.assembly->radius;
    CHECK_REFUSED(co_adaptive_quadrature_check(p.assembly, &e, &error), &error, CURVOPT_ERROR_GEOMETRY, -1,
                  "zero area");
    e = good;
    e.objective = NAN;
    CHECK_REFUSED(co_adaptive_quadrature_check(p.assembly, &e, &error), &error, CURVOPT_ERROR_GEOMETRY,
                  p.assembly->worst_face, "the energy is not finite");
    e = good;
    e.gauss_bonnet_defect = 0.99 + 0.01 * good.term[CURVOPT_TERM_WILLMORE];
    CHECK_OK(co_adaptive_quadrature_check(p.assembly, &e, &error), &error);
    e.gauss_bonnet_defect += 0.02;
    CHECK_REFUSED(co_adaptive_quadrature_check(p.assembly, &e, &error), &error, CURVOPT_ERROR_RESOLUTION,
                  p.assembly->worst_face, "cannot be resolved");
    e = good;
    e.h2 = 0.91 * 4 * CO_PI;
    CHECK_OK(co_adaptive_quadrature_check(p.assembly, &e, &error), &error);
    e.h2 = 0.89 * 4 * CO_PI;
    CHECK_REFUSED(co_adaptive_quadrature_check(p.assembly, &e, &error), &error, CURVOPT_ERROR_RESOLUTION,
                  p.assembly->worst_face, "integral of H^2 comes out 11.2, and no such surface has less than 12.57");
    p.assembly->leaves_out = 1; /* of a part nothing is known */
    CHECK_OK(co_adaptive_quadrature_check(p.assembly, &e, &error), &error);
    problem_free(&p);
}

/* Of spheres, tori, and two pieces; not with a boundary. A torus in a plane has none by all rules. */
static void test_least_integral_of_h2(void **state) {
    (void)state;
    int resolved, changed;
    const struct {
        cage c;
        double least;
    } cases[] = {{cage_cube(), 4 * CO_PI},
                 {cage_torus(6, 4, 1, 0.4), 2 * CO_PI * CO_PI},
                 {cage_both(cage_cube(), cage_torus(6, 4, 1, 0.4), 5), 8 * CO_PI},
                 {cage_half_star(4, 4), 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        problem p = problem_on(CURVOPT_SURFACE_LIMIT, cases[k].c, CURVOPT_TERM_WILLMORE);
        CHECK_NEAR(p.assembly->least_h2, cases[k].least, 1e-12);
        problem_free(&p);
    }
    cage flat = cage_torus(8, 5, 1, 0.4);
    for (int32_t v = 0; v < flat.n_vertices; v++)
        flat.xyz[3 * v + 2] = 0;
    problem p = problem_on(CURVOPT_SURFACE_LIMIT, flat, CURVOPT_TERM_WILLMORE);
    CHECK_NEAR(resolve(&p, 1e-3, CO_TERMS_OBJECTIVE, &resolved, &changed).objective, 0, 1e-12);
    CHECK_INT(resolved, 0);
    problem_free(&p);
}

/* The gradient [3 n_vertices] by one rule on all patches. */
static void gradient_by(problem *p, int8_t rule, double *gradient) {
    const co_request request = {.gradient = gradient};
    co_values values;
    curvopt_error error;
    memset(p->assembly->rule, rule, (size_t)p->assembly->patches.n_patches);
    CHECK_OK(co_assembly_update_batches(p->assembly, &error), &error);
    co_assembly_evaluate(p->assembly, p->c.xyz, &request, &values);
}

/* Rules of a pole differ in the points that they need: points of the coarse ones that fine ones have not count no more
 * after a change of rules. */
static void test_gradients_are_those_of_the_present_rules(void **state) {
    (void)state;
    enum { POLE = 35, N_VERTICES = 3 * POLE + 2, COARSE = 0, FINE = 4 };
    static const int terms[] = {CURVOPT_TERM_WILLMORE, CURVOPT_TERM_MVS};
    static double before[3 * N_VERTICES], after[3 * N_VERTICES], fresh[3 * N_VERTICES];
    for (int k = 0; k < 2; k++) {
        problem changed = problem_of(cage_shaken(cage_trapezohedron(POLE), 0.01), terms[k]);
        problem other = problem_of(cage_shaken(cage_trapezohedron(POLE), 0.01), terms[k]);
        CHECK_TRUE(changed.c.n_vertices <= N_VERTICES);
        gradient_by(&changed, COARSE, before);
        gradient_by(&changed, FINE, after);
        gradient_by(&other, FINE, fresh);
        CHECK_TRUE(memcmp(after, before, sizeof after) != 0);
        CHECK_TRUE(memcmp(after, fresh, sizeof after) == 0);
        problem_free(&changed);
        problem_free(&other);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradients_are_those_of_the_present_rules),
        cmocka_unit_test(test_unmarked_candidates_stay_below_the_bound),
        cmocka_unit_test(test_like_candidates_are_marked_alike),
        cmocka_unit_test(test_errors_that_are_no_numbers_come_last),
        cmocka_unit_test(test_claimed_errors_cancel_and_their_doubts_add),
        cmocka_unit_test(test_claimed_errors_have_what_rules_miss_at_umbilics),
        cmocka_unit_test(test_differences_are_of_the_objective_or_of_the_worst_term),
        cmocka_unit_test(test_the_tolerance_is_met_and_not_missed_by_far),
        cmocka_unit_test(test_symmetric_patches_get_the_same_rules),
        cmocka_unit_test(test_rules_that_met_the_tolerance_are_kept_for_a_while),
        cmocka_unit_test(test_a_missed_tolerance_may_be_acceptable),
        cmocka_unit_test(test_all_terms_take_finer_rules_than_the_objective),
        cmocka_unit_test(test_a_third_rule_is_compared_where_errors_are_largest),
        cmocka_unit_test(test_blocks_can_be_of_some_patches),
        cmocka_unit_test(test_errors_of_the_area_are_in_all_that_has_it),
        cmocka_unit_test(test_third_order_terms_get_the_best_area),
        cmocka_unit_test(test_rules_become_coarser_again),
        cmocka_unit_test(test_rough_rules_are_for_a_while),
        cmocka_unit_test(test_rules_become_rough_again),
        cmocka_unit_test(test_what_is_no_surface_is_refused),
        cmocka_unit_test(test_least_integral_of_h2),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

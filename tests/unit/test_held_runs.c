/* Runs that hold numbers of the whole surface: that the result has them, that their multipliers are what the least
 * energy changes by, by differences of runs, and how many evaluations that takes. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

enum { VOLUME = CURVOPT_SCALAR_VOLUME, AREA = CURVOPT_SCALAR_AREA, MEAN = CURVOPT_SCALAR_MEAN_CURVATURE };

/* A run's end, and its numbers by another rule. */
typedef struct finished {
    curvopt_summary summary;
    curvopt_level_report level;
    curvopt_energies end, again;
    double xyz[3 * 24];
} finished;

static curvopt_options options_of(void) {
    curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    o.tolerance = 1e-8;
    o.decrement_tolerance = 1e-11;
    return o;
}

static cage torus(void) {
    return cage_shaken(cage_torus(6, 4, 1, 0.45), 0.05);
}

/* From another one's end, so that it ends in the same minimum, or from the torus where that is NULL. */
static finished run(const curvopt_options *o, const finished *from) {
    finished f;
    cage c = torus();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_result *result;
    curvopt_problem *problem;
    curvopt_error error;
    curvopt_options plain = *o;
    if (from)
        memcpy(c.xyz, from->xyz, sizeof from->xyz);
    CHECK_OK(curvopt_minimize(mesh, c.xyz, o, NULL, NULL, NULL, &result, &error), &error);
    curvopt_result_get_summary(result, &f.summary, sizeof f.summary);
    curvopt_result_get_energies(result, NULL, &f.end, sizeof f.end);
    CHECK_OK(curvopt_result_get_level(result, 0, &f.level, sizeof f.level, &error), &error);
    curvopt_result_get_positions(result, f.xyz);
    plain.tolerance = 1e-10;
    plain.constraints = NULL;
    CHECK_OK(curvopt_problem_create(mesh, NULL, &plain, &problem, &error), &error);
    CHECK_OK(curvopt_problem_evaluate(problem, f.xyz, &f.again, sizeof f.again, NULL, &error), &error);
    curvopt_problem_destroy(problem);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
    CHECK_INT(f.summary.verdict, CURVOPT_VERDICT_MINIMUM);
    CHECK_NEAR(f.end.objective, f.again.objective, 1e-7 * fabs(f.again.objective));
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        CHECK_NEAR(f.summary.scalar_residual[s], 0, 1e-8);
    return f;
}

static double number_of(const curvopt_energies *e, int scalar) {
    return scalar == VOLUME ? e->volume : scalar == AREA ? e->area : e->total_mean_curvature;
}

/* With each held number a little more and a little less: the least energy follows its multiplier. `o` has values. */
static void check_multipliers(const curvopt_options *o, int32_t most_evaluations) {
    const finished f = run(o, NULL);
    CHECK_BETWEEN(f.level.evaluations, 1, most_evaluations);
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        double energy[2];
        if (o->scalar_rule[s] == CURVOPT_SCALAR_RULE_FREE) {
            CHECK_NEAR(f.summary.multiplier[s], 0, 0);
            continue;
        }
        if (o->scalar_rule[s] == CURVOPT_SCALAR_RULE_VALUE)
            CHECK_NEAR(number_of(&f.again, s), o->scalar_value[s], 1e-6 * o->scalar_value[s]);
        else
            CHECK_NEAR(f.again.volume / (pow(f.again.area, 1.5) / 10.6347231054330961), o->scalar_value[s], 1e-6);
        const double h = 1e-3 * o->scalar_value[s];
        for (int k = 0; k < 2; k++) {
            curvopt_options beside = *o;
            beside.scalar_value[s] += k ? h : -h;
            energy[k] = run(&beside, &f).again.objective;
        }
        CHECK_NEAR(f.summary.multiplier[s], (energy[1] - energy[0]) / (2 * h),
                   2e-3 * (fabs(f.summary.multiplier[s]) + f.again.objective / o->scalar_value[s] * 1e-2));
    }
}

static void hold(curvopt_options *o, int scalar, double value) {
    o->scalar_rule[scalar] = CURVOPT_SCALAR_RULE_VALUE;
    o->scalar_value[scalar] = value;
}

/* In a frame each number counts as it is. */
static void test_beside_pins(void **state) {
    (void)state;
    static const int32_t vertex[3] = {0, 9, 14};
    const curvopt_constraints pins = {.vertices = vertex, .n = 3};
    curvopt_options o = options_of();
    o.constraints = &pins;
    hold(&o, VOLUME, 2.4);
    hold(&o, AREA, 12.5);
    check_multipliers(&o, 170);
}

/* Free: one number only gives the size, of which bending energy does not depend, and the others are ratios. */
static void test_where_nothing_else_is_held(void **state) {
    (void)state;
    curvopt_options o = options_of();
    hold(&o, AREA, 12.5);
    hold(&o, VOLUME, 2.6);
    check_multipliers(&o, 90);
    o.scalar_rule[VOLUME] = CURVOPT_SCALAR_RULE_REDUCED;
    o.scalar_value[VOLUME] = 0.62;
    check_multipliers(&o, 90);
    o = options_of();
    hold(&o, MEAN, 20);
    check_multipliers(&o, 135);
}

/* With spontaneous curvature the size matters: its number has a multiplier, too. */
static void test_with_spontaneous_curvature(void **state) {
    (void)state;
    curvopt_options o = options_of();
    o.spontaneous_curvature = 0.5;
    hold(&o, AREA, 12.5);
    check_multipliers(&o, 135);
    hold(&o, VOLUME, 2.6);
    check_multipliers(&o, 100);
    o.scalar_rule[AREA] = CURVOPT_SCALAR_RULE_FREE;
    o.scalar_value[AREA] = 0;
    check_multipliers(&o, 135);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_beside_pins),
        cmocka_unit_test(test_where_nothing_else_is_held),
        cmocka_unit_test(test_with_spontaneous_curvature),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

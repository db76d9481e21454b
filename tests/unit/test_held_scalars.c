/* What a run holds of the whole surface: that what is kept is the input's, and a part of a sphere's is one; sizes; what
 * is refused. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "solve_setting.h"

#include "solve/held_scalars.h"

static const double pi = 3.14159265358979323846;

enum { VOLUME = CURVOPT_SCALAR_VOLUME, AREA = CURVOPT_SCALAR_AREA, MEAN = CURVOPT_SCALAR_MEAN_CURVATURE };

/* A surface, evaluated, and its numbers in units of the cage, with their signs. */
typedef struct fixture {
    solve_setting *s;
    co_assembly assembly;
    co_values values;
    double number[CURVOPT_N_SCALARS];
    co_held_numbers held;
    co_run_size size;
    curvopt_error error;
} fixture;

static void fixture_of(cage c, fixture *f) {
    const curvopt_options o = solve_options(CURVOPT_SURFACE_LIMIT, CURVOPT_TERM_WILLMORE);
    f->s = solve_setting_of(c, &o);
    CHECK_OK(
        co_assembly_create(f->s->mesh, NULL, NULL, &f->s->options, f->s->run.tables, NULL, &f->assembly, &f->error),
        &f->error);
    co_assembly_evaluate(&f->assembly, f->s->c.xyz, &(co_request){.volume = 1}, &f->values);
    const double r = f->values.radius;
    f->number[VOLUME] = r * r * r * f->values.integral[CO_INT_VOLUME];
    f->number[AREA] = r * r * f->values.integral[CO_INT_AREA];
    f->number[MEAN] = r * f->values.integral[CO_INT_MEAN];
}

static void fixture_free(fixture *f) {
    co_assembly_free(&f->assembly);
    solve_setting_free(f->s);
}

static int32_t create(fixture *f, int is_framed) {
    return co_held_scalars_create(&f->s->options, &f->assembly, &f->values, is_framed, &f->held, &f->size, &f->error);
}

static void set(fixture *f, int scalar, int32_t rule, double value) {
    f->s->options.scalar_rule[scalar] = rule;
    f->s->options.scalar_value[scalar] = value;
}

/* Integrals of a surface with these numbers in units of the cage, its positions divided by a length. */
static void integrals_of(const double number[CURVOPT_N_SCALARS], double length, double *integral) {
    memset(integral, 0, CO_N_INTEGRALS * sizeof *integral);
    integral[CO_INT_VOLUME] = number[VOLUME] / (length * length * length);
    integral[CO_INT_AREA] = number[AREA] / (length * length);
    integral[CO_INT_MEAN] = number[MEAN] / length;
}

/* All that is held stands at a surface with these numbers: of any size where nothing else is held, else of the frame's.
 */
static void check_stands(const fixture *f, int is_framed, const double number[CURVOPT_N_SCALARS], double off) {
    for (double part = 0.5; part < 3; part *= 2) {
        double integral[CO_N_INTEGRALS];
        integrals_of(number, is_framed ? f->values.radius : f->values.radius * part, integral);
        for (int k = 0; k < f->held.n; k++)
            CHECK_NEAR(co_held_numbers_residual(&f->held, k, integral).value, off, 1e-12);
    }
}

/* A cage, also inside out: faces as they are, and places across a plane. */
static cage torus(int is_inside_out) {
    cage c = cage_shaken(cage_torus(7, 5, 2, 0.8), 0.1);
    for (int32_t v = 0; v < c.n_vertices && is_inside_out; v++)
        c.xyz[3 * v] = -c.xyz[3 * v];
    return c;
}

/* Any of the numbers, kept, or given as it is, in a frame or not. */
static void test_what_is_kept_is_the_inputs(void **state) {
    (void)state;
    for (int inside_out = 0; inside_out < 2; inside_out++) {
        fixture f;
        fixture_of(torus(inside_out), &f);
        CHECK_INT(f.number[VOLUME] < 0, inside_out);
        CHECK_INT(f.number[MEAN] < 0, inside_out);
        for (int which = 1; which < 16; which++)
            for (int framed = 0; framed < 2; framed++) {
                const int32_t rule = which & 8 ? CURVOPT_SCALAR_RULE_VALUE : CURVOPT_SCALAR_RULE_KEEP;
                int n = 0;
                for (int s = 0; s < CURVOPT_N_SCALARS; n += which >> s++ & 1)
                    set(&f, s, which >> s & 1 ? rule : CURVOPT_SCALAR_RULE_FREE, fabs(f.number[s]));
                CHECK_OK(create(&f, framed), &f.error);
                CHECK_NEAR(f.held.orientation, inside_out ? -1 : 1, 0);
                CHECK_INT(f.held.n, framed || n == 0 ? n : n - 1); /* one gives the size */
                check_stands(&f, framed, f.number, 0);
                CHECK_NEAR(f.size.value, fabs(f.number[f.size.measure]), 1e-12 * f.size.value);
                CHECK_INT(f.size.measure, which & 1 << AREA || !n ? AREA : which & 1 << VOLUME ? VOLUME : MEAN);
                for (int k = 0; k < f.held.n; k++) {
                    CHECK_TRUE(which >> f.held.held[k].scalar & 1);
                    CHECK_INT(f.held.held[k].measure, framed ? -1 : f.size.measure);
                }
            }
        fixture_free(&f);
    }
}

/* Half and all of the sphere's volume, or of its mean curvature, over the area; whatever gives the size. */
static void test_reduced_numbers_are_parts_of_the_spheres(void **state) {
    (void)state;
    const double sphere[CURVOPT_N_SCALARS] = {[VOLUME] = 4 * pi / 3, [AREA] = 4 * pi, [MEAN] = 4 * pi};
    fixture f;
    fixture_of(torus(0), &f);
    for (int framed = 0; framed < 2; framed++)
        for (double part = 0.5; part <= 1; part += 0.5) {
            double number[CURVOPT_N_SCALARS] = {[VOLUME] = part * sphere[VOLUME], [AREA] = sphere[AREA], [MEAN] = 7};
            set(&f, VOLUME, CURVOPT_SCALAR_RULE_REDUCED, part);
            CHECK_OK(create(&f, framed), &f.error);
            CHECK_INT(f.held.n, 1);
            CHECK_INT(f.held.held[0].measure, AREA);
            check_stands(&f, 0, number, 0);
            CHECK_NEAR(f.size.value, f.number[AREA], 1e-12 * f.size.value);
            CHECK_INT(f.size.measure, AREA);
            number[VOLUME] *= 1.5; /* relative to what is wanted */
            check_stands(&f, 0, number, 0.5);
        }
    fixture_free(&f);
}

/* Residuals are relative to the number, but to no less than a hundredth of the volume of the sphere with the area; mean
 * curvature, which may be 0, to the sphere's. A wanted number moves the target by `rate` a unit. */
static void test_units(void **state) {
    (void)state;
    fixture f;
    fixture_of(torus(0), &f);
    const double radius = sqrt(f.number[AREA] / (4 * pi));
    const double other[CURVOPT_N_SCALARS] = {f.number[0] * 1.01, f.number[1] * 1.01, f.number[2] * 1.01};
    double integral[CO_N_INTEGRALS];
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        set(&f, s, CURVOPT_SCALAR_RULE_KEEP, 0);
    CHECK_OK(create(&f, 1), &f.error);
    integrals_of(other, f.values.radius, integral);
    for (int k = 0; k < 3; k++) {
        const int s = f.held.held[k].scalar;
        CHECK_NEAR(co_held_numbers_residual(&f.held, k, integral).value,
                   s == MEAN ? 0.01 * f.number[MEAN] / (4 * pi * radius) : 0.01, 1e-12);
        CHECK_NEAR(f.held.held[k].rate * f.number[s], f.held.held[k].target, 1e-12);
    }
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_VALUE, 0);
    set(&f, AREA, CURVOPT_SCALAR_RULE_FREE, 0);
    set(&f, MEAN, CURVOPT_SCALAR_RULE_FREE, 0);
    CHECK_OK(create(&f, 1), &f.error);
    integrals_of(f.number, f.values.radius, integral);
    CHECK_NEAR(co_held_numbers_residual(&f.held, 0, integral).value,
               f.number[VOLUME] / (0.01 * 4 * pi / 3 * radius * radius * radius), 1e-9);
    fixture_free(&f);
}

/* A surface is as large as it says when it is scaled by the unit of its number. */
static void test_size(void **state) {
    (void)state;
    static const int degree[CURVOPT_N_SCALARS] = {[VOLUME] = 3, [AREA] = 2, [MEAN] = 1};
    for (int s = 0; s < CURVOPT_N_SCALARS; s++) {
        const co_run_size size = {.measure = s, .value = 5};
        const double now = co_run_size_number(&size, s == AREA ? 1.7 : 9, s == VOLUME ? -1.7 : 8, s == MEAN ? -1.7 : 7);
        CHECK_NEAR(now, 1.7, 0);
        CHECK_NEAR(pow(co_run_size_unit(&size, now), degree[s]) * now, 5, 1e-13);
    }
}

static void test_what_is_refused(void **state) {
    (void)state;
    fixture f;
    fixture_of(torus(0), &f);
    const double most = f.number[AREA] * sqrt(f.number[AREA] / pi) / 6;
    set(&f, AREA, CURVOPT_SCALAR_RULE_KEEP, 0);
    for (int k = 0; k < 2; k++) { /* a sphere of that area */
        set(&f, VOLUME, CURVOPT_SCALAR_RULE_VALUE, most * (k ? 1 + 1e-6 : 1 - 1e-6));
        CHECK_INT(create(&f, 1), k ? CURVOPT_ERROR_ARGUMENT : CURVOPT_OK);
    }
    CHECK_TEXT(f.error.message, "does not fit");
    CHECK_INT(f.error.element, VOLUME);
    set(&f, AREA, CURVOPT_SCALAR_RULE_FREE, 0);
    CHECK_OK(create(&f, 1), &f.error);
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_REDUCED, 1.01);
    CHECK_REFUSED(create(&f, 0), &f.error, CURVOPT_ERROR_ARGUMENT, VOLUME, "more than the sphere's");
    f.assembly.leaves_out = 1;
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_REDUCED, 0.5);
    CHECK_REFUSED(create(&f, 0), &f.error, CURVOPT_ERROR_ARGUMENT, VOLUME, "it can be kept");
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_KEEP, 0);
    CHECK_OK(create(&f, 0), &f.error);
    fixture_free(&f);
}

static void test_open_surfaces(void **state) {
    (void)state;
    fixture f;
    fixture_of(cage_band(6, 4, 1, 0.8, 1.5), &f);
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_VALUE, 1);
    CHECK_REFUSED(create(&f, 1), &f.error, CURVOPT_ERROR_ARGUMENT, VOLUME, "not closed");
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_KEEP, 0);
    CHECK_OK(create(&f, 1), &f.error);
    CHECK_NEAR(f.held.orientation, 1, 0);
    check_stands(&f, 1, f.number, 0);
    f.s->options.boundary = CURVOPT_BOUNDARY_FREE;
    CHECK_REFUSED(create(&f, 0), &f.error, CURVOPT_ERROR_ARGUMENT, VOLUME, "hold the boundary");
    set(&f, VOLUME, CURVOPT_SCALAR_RULE_FREE, 0);
    set(&f, AREA, CURVOPT_SCALAR_RULE_VALUE, 3);
    CHECK_OK(create(&f, 0), &f.error);
    CHECK_NEAR(f.size.value, 3, 0);
    fixture_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_kept_is_the_inputs),
        cmocka_unit_test(test_reduced_numbers_are_parts_of_the_spheres),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_size),
        cmocka_unit_test(test_what_is_refused),
        cmocka_unit_test(test_open_surfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

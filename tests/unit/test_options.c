/* Options, texts, version. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <stdlib.h>

static curvopt_options usual(void) {
    curvopt_options o;
    curvopt_options_init(&o);
    return o;
}

static void test_init_writes_every_byte(void **state) {
    (void)state;
    curvopt_options a, b;
    memset(&a, 0xa5, sizeof a);
    memset(&b, 0x5a, sizeof b);
    curvopt_options_init(&a);
    curvopt_options_init(&b);
    assert_memory_equal(&a, &b, sizeof a);
}

static void test_defaults_are_those_of_the_header_and_valid(void **state) {
    (void)state;
    curvopt_options o = usual();
    curvopt_error error;
    CHECK_INT(o.struct_size, sizeof o);
    CHECK_INT(o.surface, CURVOPT_SURFACE_AUTO);
    CHECK_INT(o.method, CURVOPT_METHOD_AUTO);
    CHECK_INT(o.levels, 4);
    CHECK_INT(o.max_iterations, 3000);
    CHECK_INT(o.threads, 0);
    CHECK_INT(o.as_report, 0);
    CHECK_NEAR(o.weights[CURVOPT_TERM_WILLMORE], 1, 0);
    CHECK_NEAR(o.tolerance, 1e-4, 0);
    CHECK_NEAR(o.gradient_tolerance, 1e-6, 0);
    CHECK_NEAR(o.decrement_tolerance, 2e-7, 0);
    CHECK_NEAR(o.max_step, 0.5, 0);
    for (int t = 1; t < 8; t++)
        CHECK_NEAR(o.weights[t], 0, 0);
    CHECK_OK(curvopt_options_validate(&o, &error), &error);
}

typedef struct integer_field {
    const char *name;
    size_t offset;
    int32_t low, high; /* what is just accepted */
} integer_field;

static const integer_field integers[] = {
    {"struct_size", offsetof(curvopt_options, struct_size), sizeof(curvopt_options), sizeof(curvopt_options)},
    {"surface", offsetof(curvopt_options, surface), 0, 3},
    {"method", offsetof(curvopt_options, method), 0, 2},
    {"levels", offsetof(curvopt_options, levels), 1, 12},
    {"max_iterations", offsetof(curvopt_options, max_iterations), 0, INT32_MAX},
    {"threads", offsetof(curvopt_options, threads), 0, 1024},
    {"as_report", offsetof(curvopt_options, as_report), 0, 1},
    {"boundary", offsetof(curvopt_options, boundary), 0, 3}};

static int32_t validate_integer(const integer_field *f, int32_t value, curvopt_error *error) {
    curvopt_options o = usual();
    memcpy((char *)&o + f->offset, &value, sizeof value);
    return curvopt_options_validate(&o, error);
}

static void test_integers_out_of_range_are_refused_by_name(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof integers / sizeof *integers; i++) {
        const integer_field *f = &integers[i];
        curvopt_error error;
        char text[64];
        CHECK_OK(validate_integer(f, f->low, &error), &error);
        CHECK_OK(validate_integer(f, f->high, &error), &error);
        snprintf(text, sizeof text, "%s is %d", f->name, f->low - 1);
        CHECK_REFUSED(validate_integer(f, f->low - 1, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, text);
        if (f->high == INT32_MAX)
            continue;
        snprintf(text, sizeof text, "%s is %d", f->name, f->high + 1);
        CHECK_REFUSED(validate_integer(f, f->high + 1, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, text);
        CHECK_INT(validate_integer(f, INT32_MIN, NULL), CURVOPT_ERROR_ARGUMENT);
    }
}

typedef struct real_field {
    const char *name;
    size_t offset;
    double low, high;
} real_field;

static const real_field reals[] = {{"tolerance", offsetof(curvopt_options, tolerance), 1e-12, 0.5},
                                   {"gradient_tolerance", offsetof(curvopt_options, gradient_tolerance), 1e-15, 1},
                                   {"decrement_tolerance", offsetof(curvopt_options, decrement_tolerance), 1e-15, 1},
                                   {"max_step", offsetof(curvopt_options, max_step), 1e-6, 100}};

static int32_t validate_real(const real_field *f, double value, curvopt_error *error) {
    curvopt_options o = usual();
    memcpy((char *)&o + f->offset, &value, sizeof value);
    return curvopt_options_validate(&o, error);
}

static void test_reals_out_of_range_are_refused_by_name(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof reals / sizeof *reals; i++) {
        const real_field *f = &reals[i];
        const double refused[] = {f->low * 0.99, f->high * 1.01, 0, -1, (double)NAN, INFINITY, -INFINITY};
        curvopt_error error;
        CHECK_OK(validate_real(f, f->low, &error), &error);
        CHECK_OK(validate_real(f, f->high, &error), &error);
        for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
            char text[64];
            snprintf(text, sizeof text, "%s is %g", f->name, refused[k]);
            CHECK_REFUSED(validate_real(f, refused[k], &error), &error, CURVOPT_ERROR_ARGUMENT, -1, text);
        }
    }
}

static void test_planes_go_with_their_symmetry(void **state) {
    (void)state;
    for (int32_t symmetry = CURVOPT_SYMMETRY_AUTO; symmetry <= CURVOPT_SYMMETRY_PLANES + 1; symmetry++)
        for (int32_t planes = -1; planes <= 8; planes++) {
            int chosen = symmetry == CURVOPT_SYMMETRY_PLANES, good = chosen ? planes >= 1 && planes <= 7 : planes == 0;
            curvopt_options o = usual();
            curvopt_error error;
            o.symmetry = symmetry;
            o.symmetry_planes = planes;
            if (symmetry > CURVOPT_SYMMETRY_PLANES)
                CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                              "symmetry is 5; it must be 0 to 4");
            else if (good)
                CHECK_OK(curvopt_options_validate(&o, &error), &error);
            else
                CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                              "symmetry_planes is");
            o.as_report = 1;
            if (chosen && good)
                CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                              "as_report keeps no symmetries");
        }
}

static void test_weights_are_refused_by_index(void **state) {
    (void)state;
    static const double refused[] = {-1, -1e-300, (double)NAN, INFINITY};
    for (int t = 0; t < 8; t++)
        for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
            curvopt_options o = usual();
            curvopt_error error;
            char text[64];
            o.weights[t] = refused[k];
            snprintf(text, sizeof text, "weights[%d] is %g", t, refused[k]);
            CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, t, text);
        }
}

static void test_weights_of_no_term_must_be_zero(void **state) {
    (void)state;
    for (int t = CURVOPT_N_TERMS; t < 8; t++) {
        curvopt_options o = usual();
        curvopt_error error;
        o.weights[t] = 1;
        CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, t, "there is no such term");
    }
}

static void test_weights_must_not_vanish_or_overflow_together(void **state) {
    (void)state;
    curvopt_options o = usual();
    curvopt_error error;
    o.weights[CURVOPT_TERM_WILLMORE] = 0;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "weights add up to 0");
    o.weights[CURVOPT_TERM_WILLMORE] = o.weights[CURVOPT_TERM_MVS] = 1.5e308;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "weights add up to inf");
}

static void test_no_options_are_refused(void **state) {
    (void)state;
    curvopt_error error;
    CHECK_REFUSED(curvopt_options_validate(NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "options is NULL");
}

static void test_every_status_has_its_own_text(void **state) {
    (void)state;
#define CHECK_STATUS_TEXT(name, value, text) assert_string_equal(curvopt_status_text(CURVOPT_##name), text);
    CURVOPT_STATUS_LIST(CHECK_STATUS_TEXT)
#undef CHECK_STATUS_TEXT
    CHECK_TEXT(curvopt_status_text(-1), "unknown");
    CHECK_TEXT(curvopt_status_text(999), "unknown");
    CHECK_TEXT(curvopt_status_text(INT32_MIN), "unknown");
}

static void test_every_stop_has_its_text(void **state) {
    (void)state;
    assert_string_equal(curvopt_stop_text(CURVOPT_STOP_CONVERGED), "converged");
    assert_string_equal(curvopt_stop_text(CURVOPT_STOP_STALLED), "stalled");
    assert_string_equal(curvopt_stop_text(CURVOPT_STOP_LIMIT), "limit");
    assert_string_equal(curvopt_stop_text(CURVOPT_STOP_CANCELLED), "cancelled");
    assert_string_equal(curvopt_stop_text(CURVOPT_STOP_UNRESOLVED), "unresolved");
    CHECK_TEXT(curvopt_stop_text(-1), "unknown");
    CHECK_TEXT(curvopt_stop_text(INT32_MAX), "unknown");
}

static void test_version_is_the_headers(void **state) {
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", CURVOPT_VERSION_MAJOR, CURVOPT_VERSION_MINOR, CURVOPT_VERSION_PATCH);
    assert_string_equal(curvopt_version(), text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_init_writes_every_byte),
        cmocka_unit_test(test_defaults_are_those_of_the_header_and_valid),
        cmocka_unit_test(test_integers_out_of_range_are_refused_by_name),
        cmocka_unit_test(test_reals_out_of_range_are_refused_by_name),
        cmocka_unit_test(test_planes_go_with_their_symmetry),
        cmocka_unit_test(test_weights_are_refused_by_index),
        cmocka_unit_test(test_weights_of_no_term_must_be_zero),
        cmocka_unit_test(test_weights_must_not_vanish_or_overflow_together),
        cmocka_unit_test(test_no_options_are_refused),
        cmocka_unit_test(test_every_status_has_its_own_text),
        cmocka_unit_test(test_every_stop_has_its_text),
        cmocka_unit_test(test_version_is_the_headers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

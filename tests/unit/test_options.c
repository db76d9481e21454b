/* Options, texts, version. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include <stdlib.h>

static curvopt_options usual(void) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    return o;
}

static void test_init_writes_every_byte(void **state) {
    (void)state;
    curvopt_options a, b;
    memset(&a, 0xa5, sizeof a);
    memset(&b, 0x5a, sizeof b);
    curvopt_options_init(&a, sizeof a);
    curvopt_options_init(&b, sizeof b);
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
    CHECK_INT(o.max_iterations, 10000);
    CHECK_INT(o.threads, 0);
    CHECK_INT(o.joshi_sequin, 0);
    CHECK_NEAR(o.weights[CURVOPT_TERM_WILLMORE], 1, 0);
    CHECK_NEAR(o.tolerance, 1e-4, 0);
    CHECK_NEAR(o.gradient_tolerance, 1e-6, 0);
    CHECK_NEAR(o.decrement_tolerance, 2e-7, 0);
    CHECK_NEAR(o.max_step, 0.5, 0);
    for (int t = 1; t < CURVOPT_MAX_TERMS; t++)
        CHECK_NEAR(o.weights[t], 0, 0);
    CHECK_OK(curvopt_options_validate(&o, &error), &error);
}

typedef struct integer_field {
    const char *name;
    size_t offset;
    int32_t low, high; /* what is just accepted */
} integer_field;

static const integer_field integers[] = {{"surface", offsetof(curvopt_options, surface), 0, 3},
                                         {"method", offsetof(curvopt_options, method), 0, 2},
                                         {"levels", offsetof(curvopt_options, levels), 1, CURVOPT_MAX_LEVELS},
                                         {"max_iterations", offsetof(curvopt_options, max_iterations), 0, INT32_MAX},
                                         {"threads", offsetof(curvopt_options, threads), 0, 1024},
                                         {"joshi_sequin", offsetof(curvopt_options, joshi_sequin), 0, 1},
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
            o.joshi_sequin = 1;
            if (chosen && good)
                CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                              "joshi_sequin keeps no symmetries");
        }
}

static void test_an_even_spacing_is_refused_without_second_derivatives(void **state) {
    (void)state;
    for (int32_t method = CURVOPT_METHOD_AUTO; method <= CURVOPT_METHOD_GAUSS_NEWTON; method++)
        for (int32_t classic = 0; classic < 2; classic++) {
            curvopt_options o = usual();
            curvopt_error error;
            o.method = method;
            o.joshi_sequin = classic;
            CHECK_OK(curvopt_options_validate(&o, &error), &error);
            o.spacing = CURVOPT_SPACING_EVEN;
            if (method == CURVOPT_METHOD_LMVM || (method == CURVOPT_METHOD_AUTO && classic))
                CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                              "an even spacing needs second derivatives");
            else
                CHECK_OK(curvopt_options_validate(&o, &error), &error);
        }
}

static void test_strength_is_above_0_and_up_to_1(void **state) {
    (void)state;
    static const double refused[] = {0, -0.5, 1.001, (double)NAN, INFINITY};
    curvopt_error error;
    curvopt_options o = usual();
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        o.strength = refused[i];
        CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "strength is");
    }
    for (o.strength = 1e-3; o.strength < 1; o.strength += 0.1)
        CHECK_OK(curvopt_options_validate(&o, &error), &error);
}

static void test_spontaneous_curvature_is_finite_and_of_a_bending_energy(void **state) {
    (void)state;
    static const double refused[] = {-1.1e100, 1e200, (double)NAN, -INFINITY};
    curvopt_error error;
    curvopt_options o = usual();
    CHECK_NEAR(o.spontaneous_curvature, 0, 0);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        o.spontaneous_curvature = refused[i];
        CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                      "spontaneous_curvature is");
    }
    o.spontaneous_curvature = -3;
    for (int t = 0; t < CURVOPT_N_TERMS; t++) {
        memset(o.weights, 0, sizeof o.weights);
        o.weights[t] = 1;
        if (t == CURVOPT_TERM_WILLMORE || t == CURVOPT_TERM_MEAN)
            CHECK_OK(curvopt_options_validate(&o, &error), &error);
        else
            CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                          "neither willmore nor mean_curvature");
    }
}

static void test_slide_is_0_or_1(void **state) {
    (void)state;
    curvopt_error error;
    curvopt_options o = usual();
    assert_int_equal(o.slide, 0);
    for (o.slide = 0; o.slide < 2; o.slide++)
        CHECK_OK(curvopt_options_validate(&o, &error), &error);
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "slide is 2");
}

static void test_no_crossings_is_0_or_1(void **state) {
    (void)state;
    curvopt_error error;
    curvopt_options o = usual();
    assert_int_equal(o.no_crossings, 0);
    for (o.no_crossings = 0; o.no_crossings < 2; o.no_crossings++)
        CHECK_OK(curvopt_options_validate(&o, &error), &error);
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "no_crossings is 2");
    o.no_crossings = o.slide = 1;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "no_crossings and slide exclude each other");
    o.slide = 0;
    o.joshi_sequin = 1;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                  "no_crossings and joshi_sequin exclude each other");
    o = usual();
    o.reserved = 1;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "reserved is 1");
}

static void test_weights_are_refused_by_index(void **state) {
    (void)state;
    static const double refused[] = {-1, -1e-300, (double)NAN, INFINITY, CURVOPT_WEIGHT_MAX * 1.01, 1e300};
    for (int t = 0; t < CURVOPT_MAX_TERMS; t++)
        for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
            curvopt_options o = usual();
            curvopt_error error;
            char text[64];
            o.weights[t] = refused[k];
            if (t < CURVOPT_N_TERMS)
                snprintf(text, sizeof text, "weights[%d] is %g, of %s;", t, refused[k], curvopt_term_name(t));
            else
                snprintf(text, sizeof text, "weights[%d] is %g;", t, refused[k]);
            CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, t, text);
        }
}

static void test_weights_of_no_term_must_be_zero(void **state) {
    (void)state;
    for (int t = CURVOPT_N_TERMS; t < CURVOPT_MAX_TERMS; t++) {
        curvopt_options o = usual();
        curvopt_error error;
        o.weights[t] = 1;
        CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, t, "there is no such term");
    }
}

static void test_weights_must_not_vanish_together(void **state) {
    (void)state;
    curvopt_options o = usual();
    curvopt_error error;
    o.weights[CURVOPT_TERM_WILLMORE] = 0;
    CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "weights add up to 0");
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        o.weights[t] = CURVOPT_WEIGHT_MAX;
    CHECK_OK(curvopt_options_validate(&o, &error), &error);
}

static void test_no_options_are_refused(void **state) {
    (void)state;
    curvopt_error error;
    CHECK_REFUSED(curvopt_options_validate(NULL, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "options is NULL");
}

static void test_every_status_has_its_own_text(void **state) {
    (void)state;
#define CHECK_STATUS_TEXT(name, value, short_name, text) assert_string_equal(curvopt_status_text(CURVOPT_##name), text);
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

typedef const char *(*name_function)(int32_t);
typedef int32_t (*find_function)(const char *);

/* n values in order, or 1, 2, 4 if they are flags; no other value has a name, and no other name a value. */
static void check_names(name_function name_of, find_function find, const char *const *names, int32_t n, int flags) {
    for (int32_t i = 0; i < n; i++) {
        int32_t value = flags ? 1 << i : i;
        assert_string_equal(name_of(value), names[i]);
        CHECK_INT(find(names[i]), value);
    }
    assert_null(name_of(flags ? 1 << n : n));
    assert_null(name_of(-1));
    assert_null(name_of(INT32_MAX));
    CHECK_INT(find(NULL), -1);
    CHECK_INT(find(""), -1);
    CHECK_INT(find("Limit"), -1);
    CHECK_INT(find("auto "), -1);
}

#define CHECK_NAMES(type, flags, ...)                                                                                  \
    do {                                                                                                               \
        static const char *const names[] = {__VA_ARGS__};                                                              \
        check_names(curvopt_##type##_name, curvopt_##type##_from_name, names, (int32_t)(sizeof names / sizeof *names), \
                    flags);                                                                                            \
    } while (0)

static void test_names_and_values_find_each_other(void **state) {
    (void)state;
    CHECK_NAMES(status, 0, "ok", "argument", "memory", "size", "topology", "geometry", "surface", "unsupported",
                "resolution", "cancelled");
    CHECK_NAMES(boundary_rule, 0, "smooth", "corners");
    CHECK_NAMES(surface, 0, "auto", "limit", "plane", "polynomial");
    CHECK_NAMES(term, 0, "willmore", "mvs", "mvs_cross", "variation", "mehlum_tarrou", "area", "mean_curvature");
    CHECK_NAMES(method, 0, "auto", "lmvm", "gauss_newton");
    CHECK_NAMES(boundary, 0, "position", "tangent", "curvature", "free");
    CHECK_NAMES(symmetry, 0, "auto", "none", "rotations", "keep", "planes");
    CHECK_NAMES(plane, 1, "x", "y", "z");
    CHECK_NAMES(stop, 0, "converged", "stalled", "limit", "cancelled", "unresolved", "settled", "grown");
    CHECK_NAMES(step, 0, "none", "lbfgs", "newton");
    CHECK_NAMES(verdict, 0, "unknown", "minimum", "saddle", "not_stationary");
    assert_string_equal(curvopt_verdict_text(CURVOPT_VERDICT_NOT_STATIONARY), "not stationary");
    CHECK_INT(CURVOPT_N_TERMS, curvopt_term_from_name("mean_curvature") + 1);
}

/* A caller's struct, by an older or newer header: `extra` bytes more than the library knows, or fewer. */
static int32_t validate_sized(long extra, long set_byte, curvopt_options *o, curvopt_error *error) {
    union {
        curvopt_options options;
        unsigned char byte[sizeof(curvopt_options) + 64];
    } theirs;
    size_t size = (size_t)((long)sizeof theirs.options + extra);
    memset(&theirs, 0x5a, sizeof theirs);
    curvopt_options_init(&theirs.options, size);
    CHECK_INT(theirs.options.struct_size, size);
    for (size_t i = size; i < sizeof theirs; i++) /* what does not belong to the caller's struct is left alone */
        CHECK_INT(theirs.byte[i], 0x5a);
    if (set_byte >= 0)
        theirs.byte[set_byte] = 1;
    memcpy(o, &theirs, sizeof *o);
    return curvopt_options_validate(&theirs.options, error);
}

static void test_options_of_older_and_newer_headers(void **state) {
    (void)state;
    curvopt_options o;
    curvopt_error error;
    for (size_t size = 8; size <= sizeof o; size += 8) /* older: what is behind is not read, here 0x5a5a5a5a */
        CHECK_OK(validate_sized((long)size - (long)sizeof o, -1, &o, &error), &error);
    CHECK_OK(validate_sized(16, -1, &o, &error), &error);
    CHECK_INT(o.levels, 4);
    for (long byte = 0; byte < 16; byte++)
        CHECK_REFUSED(validate_sized(16, (long)sizeof o + byte, &o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1,
                      "struct_size is");
    static const int32_t refused[] = {0, 4, -8, 12, (int32_t)sizeof o + 1, 1 << 20, INT32_MAX};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        curvopt_options_init(&o, sizeof o);
        o.struct_size = refused[i];
        CHECK_REFUSED(curvopt_options_validate(&o, &error), &error, CURVOPT_ERROR_ARGUMENT, -1, "struct_size is");
    }
}

/* Members that an older caller does not know have their defaults: weights from the second on, here. */
static void test_older_options_run_with_defaults(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_energies energies[2];
    for (int old = 0; old < 2; old++) {
        curvopt_options o = usual();
        curvopt_problem *problem;
        curvopt_error error;
        if (old) {
            memset((char *)&o + offsetof(curvopt_options, tolerance), 0xff,
                   sizeof o - offsetof(curvopt_options, tolerance));
            o.struct_size = offsetof(curvopt_options, tolerance);
        }
        CHECK_OK(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error);
        CHECK_OK(curvopt_problem_evaluate(problem, c.xyz, &energies[old], sizeof *energies, NULL, &error), &error);
        curvopt_problem_destroy(problem);
    }
    CHECK_TRUE(memcmp(&energies[0], &energies[1], sizeof *energies) == 0);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Every function that fills in a struct: a shorter one gets its first bytes, a longer one 0 behind what is known. */
static void test_results_of_older_and_newer_headers(void **state) {
    (void)state;
    cage c = cage_cube();
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o = usual();
    curvopt_problem *problem;
    curvopt_result *result;
    curvopt_error error;
    enum { ROOM = 512 };
    o.levels = 1;
    o.max_iterations = 2;
    CHECK_OK(curvopt_problem_create(mesh, NULL, &o, &problem, &error), &error);
    CHECK_OK(curvopt_minimize(mesh, c.xyz, &o, NULL, NULL, NULL, &result, &error), &error);
    for (int kind = 0; kind < 6; kind++) {
        static const size_t known[] = {sizeof(curvopt_mesh_info),    sizeof(curvopt_energies),
                                       sizeof(curvopt_summary),      sizeof(curvopt_energies),
                                       sizeof(curvopt_level_report), sizeof(curvopt_energies)};
        double whole[ROOM / sizeof(double)];
        for (size_t size = ROOM - 8;; size = size > known[kind] ? known[kind] : size - 8) {
            double room[ROOM / sizeof(double)];
            const unsigned char *byte = (const unsigned char *)room;
            memset(room, 0x5a, sizeof room);
            if (kind == 0)
                curvopt_mesh_get_info(mesh, (curvopt_mesh_info *)room, size);
            else if (kind == 1)
                CHECK_OK(curvopt_problem_evaluate(problem, c.xyz, (curvopt_energies *)room, size, NULL, &error),
                         &error);
            else if (kind == 2)
                curvopt_result_get_summary(result, (curvopt_summary *)room, size);
            else if (kind == 4)
                CHECK_OK(curvopt_result_get_level(result, 0, (curvopt_level_report *)room, size, &error), &error);
            else
                curvopt_result_get_energies(result, kind == 3 ? (curvopt_energies *)room : NULL,
                                            kind == 3 ? NULL : (curvopt_energies *)room, size);
            if (size > known[kind])
                memcpy(whole, room, sizeof whole);
            CHECK_TRUE(memcmp(room, whole, size < known[kind] ? size : known[kind]) == 0);
            for (size_t i = known[kind]; i < size; i++)
                CHECK_INT(byte[i], 0);
            for (size_t i = size; i < ROOM; i++)
                CHECK_INT(byte[i], 0x5a);
            if (size == 0)
                break;
        }
    }
    curvopt_result_destroy(result);
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

static void test_version_is_the_headers(void **state) {
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", CURVOPT_VERSION_MAJOR, CURVOPT_VERSION_MINOR, CURVOPT_VERSION_PATCH);
    assert_string_equal(curvopt_version(), text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_strength_is_above_0_and_up_to_1),
        cmocka_unit_test(test_spontaneous_curvature_is_finite_and_of_a_bending_energy),
        cmocka_unit_test(test_slide_is_0_or_1),
        cmocka_unit_test(test_no_crossings_is_0_or_1),
        cmocka_unit_test(test_init_writes_every_byte),
        cmocka_unit_test(test_defaults_are_those_of_the_header_and_valid),
        cmocka_unit_test(test_integers_out_of_range_are_refused_by_name),
        cmocka_unit_test(test_reals_out_of_range_are_refused_by_name),
        cmocka_unit_test(test_planes_go_with_their_symmetry),
        cmocka_unit_test(test_an_even_spacing_is_refused_without_second_derivatives),
        cmocka_unit_test(test_weights_are_refused_by_index),
        cmocka_unit_test(test_weights_of_no_term_must_be_zero),
        cmocka_unit_test(test_weights_must_not_vanish_together),
        cmocka_unit_test(test_no_options_are_refused),
        cmocka_unit_test(test_every_status_has_its_own_text),
        cmocka_unit_test(test_every_stop_has_its_text),
        cmocka_unit_test(test_names_and_values_find_each_other),
        cmocka_unit_test(test_options_of_older_and_newer_headers),
        cmocka_unit_test(test_older_options_run_with_defaults),
        cmocka_unit_test(test_results_of_older_and_newer_headers),
        cmocka_unit_test(test_version_is_the_headers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

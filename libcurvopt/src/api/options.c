/* Options: defaults, ranges, and structs of other versions. SPDX-License-Identifier: GPL-3.0-or-later */
#include "api/api.h"

#include "mesh/similarity.h"
#include "solve/strength.h"

#include <float.h>
#include <math.h>
#include <string.h>

int32_t co_api_null(curvopt_error *error, const char *name) {
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is NULL", name);
}

void co_api_copy_out(void *to, size_t to_size, const void *from, size_t from_size) {
    size_t both = to_size < from_size ? to_size : from_size;
    memcpy(to, from, both);
    memset((char *)to + both, 0, to_size - both);
}

void curvopt_options_init(curvopt_options *options, size_t size) {
    curvopt_options defaults = {.struct_size = (int32_t)size,
                                .levels = 4,
                                .max_iterations = 10000,
                                .weights[CURVOPT_TERM_WILLMORE] = 1,
                                .tolerance = 1e-4,
                                .gradient_tolerance = 1e-6,
                                .decrement_tolerance = 2e-7,
                                .max_step = 0.5,
                                .strength = 1,
                                .blend_width = CURVOPT_MAX_BLEND_WIDTH};
    co_api_copy_out(options, size, &defaults, sizeof defaults);
}

static int32_t check_integer(const char *name, int32_t value, int32_t low, int32_t high, curvopt_error *error) {
    if (value >= low && value <= high)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is %d; it must be %d to %d", name, value, low, high);
}

static int32_t check_real(const char *name, double value, double low, double high, curvopt_error *error) {
    if (value >= low && value <= high)
        return CURVOPT_OK;
    if (high == DBL_MAX)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is %g; it must be finite, %g or more", name, value,
                              low);
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "%s is %g; it must be %g to %g", name, value, low, high);
}

static int32_t check_weights(const double *weights, curvopt_error *error) {
    double sum = 0;
    for (int t = 0; t < CURVOPT_MAX_TERMS; t++) {
        if (t >= CURVOPT_N_TERMS && weights[t] != 0)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, t,
                                  "weights[%d] is %g; it must be 0: there is no such term", t, weights[t]);
        if (!(weights[t] >= 0 && weights[t] <= CURVOPT_WEIGHT_MAX))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, t, "weights[%d] is %g, of %s; it must be 0 to %g", t,
                                  weights[t], curvopt_term_name(t), CURVOPT_WEIGHT_MAX);
        sum += weights[t];
    }
    if (!(sum > 0))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "weights add up to %g: nothing to minimize", sum);
    return CURVOPT_OK;
}

static int32_t check_planes(const curvopt_options *o, curvopt_error *error) {
    int chosen = o->symmetry == CURVOPT_SYMMETRY_PLANES;
    int32_t status = check_integer("symmetry_planes", o->symmetry_planes, chosen, chosen ? 7 : 0, error);
    if (status == CURVOPT_OK && chosen && o->joshi_sequin)
        status =
            co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "joshi_sequin keeps no symmetries: there are no planes");
    return status;
}

/* Below it springs are so stiff that rounding hides the energy. */
static const double LEAST_STRENGTH = 1e-3;

static int32_t check_scalars(const curvopt_options *o, curvopt_error *error) {
    for (int s = 0; s < CURVOPT_MAX_SCALARS; s++) {
        const int32_t rule = o->scalar_rule[s];
        const double value = o->scalar_value[s];
        const int takes_value = rule == CURVOPT_SCALAR_RULE_VALUE || rule == CURVOPT_SCALAR_RULE_REDUCED;
        const int most = s >= CURVOPT_N_SCALARS     ? CURVOPT_SCALAR_RULE_FREE
                         : s == CURVOPT_SCALAR_AREA ? CURVOPT_SCALAR_RULE_VALUE
                                                    : CURVOPT_SCALAR_RULE_REDUCED;
        if (rule < 0 || rule > most)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, s, "scalar_rule[%d] is %d; it must be 0 to %d", s,
                                  rule, most);
        if (takes_value && !(value > 0 && isfinite(value)))
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, s, "%s%s is %g; it must be positive and finite",
                                  rule == CURVOPT_SCALAR_RULE_REDUCED ? "reduced " : "", curvopt_scalar_name(s), value);
        if (!takes_value && value != 0)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, s,
                                  "scalar_value[%d] is %g; it must be 0 where the rule takes none", s, value);
        if (rule != CURVOPT_SCALAR_RULE_FREE && o->joshi_sequin)
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, s, "joshi_sequin holds no scalar");
    }
    return CURVOPT_OK;
}

static int32_t check_spontaneous(const curvopt_options *o, curvopt_error *error) {
    const double c0 = o->spontaneous_curvature;
    int32_t status = check_real("spontaneous_curvature", c0, -CURVOPT_WEIGHT_MAX, CURVOPT_WEIGHT_MAX, error);
    if (status == CURVOPT_OK && c0 != 0 && !co_spontaneous_curvature_is_seen(o->weights))
        status = co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                                "spontaneous_curvature is %g, but neither willmore nor mean_curvature has a weight: no "
                                "other energy has one",
                                c0);
    return status;
}

static int32_t check_crossings(const curvopt_options *o, curvopt_error *error) {
    int32_t status = check_integer("no_crossings", o->no_crossings, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("reserved", o->reserved, 0, 0, error);
    if (status == CURVOPT_OK && o->no_crossings && (o->slide || o->joshi_sequin))
        status = co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                                "no_crossings and %s exclude each other: that looks for no crossings",
                                o->slide ? "slide" : "joshi_sequin");
    return status;
}

static int32_t check_options(const curvopt_options *o, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    if (status == CURVOPT_OK)
        status = check_integer("surface", o->surface, CURVOPT_SURFACE_AUTO, CURVOPT_SURFACE_POLYNOMIAL, error);
    if (status == CURVOPT_OK)
        status = check_integer("method", o->method, CURVOPT_METHOD_AUTO, CURVOPT_METHOD_GAUSS_NEWTON, error);
    if (status == CURVOPT_OK)
        status = check_integer("levels", o->levels, 1, CURVOPT_MAX_LEVELS, error);
    if (status == CURVOPT_OK)
        status = check_integer("max_iterations", o->max_iterations, 0, INT32_MAX, error);
    if (status == CURVOPT_OK)
        status = check_integer("threads", o->threads, 0, 1024, error);
    if (status == CURVOPT_OK)
        status = check_integer("joshi_sequin", o->joshi_sequin, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("boundary", o->boundary, CURVOPT_BOUNDARY_POSITION, CURVOPT_BOUNDARY_FREE, error);
    if (status == CURVOPT_OK)
        status = check_weights(o->weights, error);
    if (status == CURVOPT_OK)
        status = check_real("tolerance", o->tolerance, 1e-12, 0.5, error);
    if (status == CURVOPT_OK)
        status = check_real("gradient_tolerance", o->gradient_tolerance, 1e-15, 1, error);
    if (status == CURVOPT_OK)
        status = check_real("decrement_tolerance", o->decrement_tolerance, 1e-15, 1, error);
    if (status == CURVOPT_OK)
        status = check_real("max_step", o->max_step, 1e-6, 100, error);
    if (status == CURVOPT_OK)
        status = check_integer("symmetry", o->symmetry, CURVOPT_SYMMETRY_AUTO, CURVOPT_SYMMETRY_PLANES, error);
    if (status == CURVOPT_OK)
        status = check_integer("verify", o->verify, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("escape", o->escape, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("blend_width", o->blend_width, 1, CURVOPT_MAX_BLEND_WIDTH, error);
    if (status == CURVOPT_OK)
        status = check_integer("spacing", o->spacing, CURVOPT_SPACING_AUTO, CURVOPT_SPACING_FREE, error);
    if (status == CURVOPT_OK)
        status = check_real("strength", o->strength, LEAST_STRENGTH, 1, error);
    if (status == CURVOPT_OK)
        status = check_real("within", o->within, 0, DBL_MAX, error);
    if (status == CURVOPT_OK)
        status = check_integer("n_holes", o->n_holes, 0, INT32_MAX, error);
    if (status == CURVOPT_OK && o->n_holes > 0 && !o->holes)
        status = co_api_null(error, "holes");
    if (status == CURVOPT_OK)
        status = check_integer("strict", o->strict, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_integer("slide", o->slide, 0, 1, error);
    if (status == CURVOPT_OK)
        status = check_planes(o, error);
    if (status == CURVOPT_OK)
        status = check_scalars(o, error);
    if (status == CURVOPT_OK)
        status = check_spontaneous(o, error);
    if (status == CURVOPT_OK)
        status = check_crossings(o, error);
    return status;
}

/* Of options that nothing is left to choose in. */
static int32_t check_resolved(const curvopt_options *o, curvopt_error *error) {
    if (o->spacing != CURVOPT_SPACING_EVEN || o->method != CURVOPT_METHOD_LMVM)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                          "an even spacing needs second derivatives, and the method LMVM%s has none",
                          o->joshi_sequin ? ", which joshi_sequin chooses," : "");
}

/* Sizes of structs with doubles in them are multiples of 8, so no member is cut in two. A larger one than the limit is
 * no size, but memory that was never set. */
enum { SIZE_STEP = 8, LARGEST_SIZE = 4096 };

static void resolve_auto(curvopt_options *o) {
    int third = co_functional_of_weights(o->weights).has_third;
    if (o->surface == CURVOPT_SURFACE_AUTO)
        o->surface = !third            ? CURVOPT_SURFACE_LIMIT
                     : o->joshi_sequin ? CURVOPT_SURFACE_PLANE
                                       : CURVOPT_SURFACE_POLYNOMIAL;
    if (o->method == CURVOPT_METHOD_AUTO)
        o->method = o->joshi_sequin ? CURVOPT_METHOD_LMVM : CURVOPT_METHOD_GAUSS_NEWTON;
    if (o->spacing == CURVOPT_SPACING_AUTO)
        o->spacing = o->method == CURVOPT_METHOD_LMVM || o->joshi_sequin || o->strength < 1 ? CURVOPT_SPACING_FREE
                                                                                            : CURVOPT_SPACING_EVEN;
    if (o->method == CURVOPT_METHOD_LMVM && o->symmetry == CURVOPT_SYMMETRY_AUTO)
        o->symmetry = CURVOPT_SYMMETRY_NONE;
    if (co_strength_stays_near(o) && o->symmetry == CURVOPT_SYMMETRY_AUTO)
        o->symmetry = CURVOPT_SYMMETRY_KEEP;
}

int32_t co_api_take_options(const curvopt_options *theirs, curvopt_options *own, curvopt_error *error) {
    if (!theirs)
        return co_api_null(error, "options");
    const int32_t size = theirs->struct_size;
    if (size < SIZE_STEP || size > LARGEST_SIZE || size % SIZE_STEP)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                              "struct_size is %d; it must be sizeof(curvopt_options), as curvopt_options_init sets it",
                              size);
    const unsigned char *bytes = (const unsigned char *)theirs;
    for (size_t i = sizeof *own; i < (size_t)size; i++)
        if (bytes[i])
            return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1,
                                  "struct_size is %d, and an option beyond the %zu bytes that version %s knows is set",
                                  size, sizeof *own, curvopt_version());
    curvopt_options_init(own, sizeof *own);
    memcpy(own, theirs, (size_t)size < sizeof *own ? (size_t)size : sizeof *own);
    own->struct_size = (int32_t)sizeof *own;
    int32_t status = check_options(own, error);
    if (status != CURVOPT_OK)
        return status;
    resolve_auto(own);
    return check_resolved(own, error);
}

int32_t co_api_take_cage(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *theirs,
                         curvopt_options *own, curvopt_error *error) {
    if (!mesh || !xyz)
        return co_api_null(error, mesh ? "xyz" : "mesh");
    int32_t status = co_api_take_options(theirs, own, error);
    return status == CURVOPT_OK ? co_similarity_check(mesh->info.n_vertices, xyz, error) : status;
}

int32_t curvopt_options_validate(const curvopt_options *options, curvopt_error *error) {
    curvopt_options own;
    return co_api_take_options(options, &own, error);
}

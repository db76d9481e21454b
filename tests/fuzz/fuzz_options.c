/* Any bytes as options, and as names and values of enumerations: validated or refused with a message.
 * SPDX-License-Identifier: GPL-3.0-or-later
 *
 * Byte 0: struct_size, 255 for the right one; 1: how many members are changed; then for each its place and eight bytes.
 * All bytes are a name besides. */
#include "fuzz.h"

#include "curvopt.h"

#include <math.h>
#include <string.h>

const char fuzz_name[] = "options";

typedef struct enumeration {
    const char *(*name)(int32_t);
    int32_t (*from_name)(const char *);
} enumeration;

static const enumeration all[] = {
    {curvopt_status_name, curvopt_status_from_name},
    {curvopt_boundary_rule_name, curvopt_boundary_rule_from_name},
    {curvopt_surface_name, curvopt_surface_from_name},
    {curvopt_term_name, curvopt_term_from_name},
    {curvopt_method_name, curvopt_method_from_name},
    {curvopt_boundary_name, curvopt_boundary_from_name},
    {curvopt_spacing_name, curvopt_spacing_from_name},
    {curvopt_symmetry_name, curvopt_symmetry_from_name},
    {curvopt_plane_name, curvopt_plane_from_name},
    {curvopt_scalar_name, curvopt_scalar_from_name},
    {curvopt_scalar_rule_name, curvopt_scalar_rule_from_name},
    {curvopt_exception_name, curvopt_exception_from_name},
    {curvopt_stop_name, curvopt_stop_from_name},
    {curvopt_step_name, curvopt_step_from_name},
    {curvopt_verdict_name, curvopt_verdict_from_name},
};

/* A name gives a value only if that has this name, and a value's name gives it back. */
static void check_names(const char *text, int32_t value) {
    FUZZ_CHECK(curvopt_status_text(value)[0] && curvopt_exception_text(value)[0]);
    FUZZ_CHECK(curvopt_stop_text(value)[0] && curvopt_verdict_text(value)[0] && curvopt_version()[0]);
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        const char *name = all[k].name(value);
        const int32_t found = all[k].from_name(text);
        FUZZ_CHECK(!name || all[k].from_name(name) == value);
        FUZZ_CHECK(found == -1 || strcmp(all[k].name(found), text) == 0);
        FUZZ_CHECK(all[k].from_name(NULL) == -1);
    }
}

/* What is accepted is in its range. */
static void check_accepted(const curvopt_options *o) {
    double sum = 0;
    for (int t = 0; t < CURVOPT_MAX_TERMS; t++) {
        FUZZ_CHECK(o->weights[t] >= 0 && o->weights[t] <= CURVOPT_WEIGHT_MAX);
        FUZZ_CHECK(t < CURVOPT_N_TERMS || o->weights[t] == 0);
        sum += o->weights[t];
    }
    FUZZ_CHECK(sum > 0 && o->tolerance > 0 && o->tolerance < 1 && o->max_step > 0 && isfinite(o->max_step));
    FUZZ_CHECK(o->levels >= 1 && o->levels <= CURVOPT_MAX_LEVELS && o->max_iterations >= 0 && o->threads >= 0);
    FUZZ_CHECK(o->surface >= 0 && o->surface <= 3 && o->strength > 0 && o->strength <= 1);
    FUZZ_CHECK(o->blend_width >= 1 && o->blend_width <= CURVOPT_MAX_BLEND_WIDTH);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    enum { MEMBER = 8 };
    curvopt_options o;
    curvopt_error error = {.code = -7};
    char text[64] = {0};
    int32_t value = -1;
    curvopt_options_init(&o, sizeof o);
    for (size_t at = 2; size > 1 && at + MEMBER < size && at < 2 + (size_t)(MEMBER + 1) * data[1]; at += MEMBER + 1)
        memcpy((char *)&o + data[at] % (sizeof o / 4 - 1) * 4, data + at + 1, MEMBER);
    o.constraints = NULL; /* pointers would have to be valid */
    o.holes = NULL;
    o.struct_size = size && data[0] < 255 ? (int32_t)(data[0] % (sizeof o / 4 + 1)) * 4 : (int32_t)sizeof o;
    const int32_t status = curvopt_options_validate(&o, &error);
    if (status == CURVOPT_OK && o.struct_size == (int32_t)sizeof o)
        check_accepted(&o);
    else if (status != CURVOPT_OK)
        FUZZ_CHECK(error.code == status && error.message[0] && memchr(error.message, 0, sizeof error.message));
    memcpy(text, data, size < sizeof text ? size : sizeof text - 1);
    memcpy(&value, data, size < sizeof value ? size : sizeof value);
    check_names(text, value);
    check_names(text, size ? data[0] % 16 : 0);
    return 0;
}

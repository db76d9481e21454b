/* Texts and names of enumerators, both ways, from the lists in curvopt.h. SPDX-License-Identifier: GPL-3.0-or-later */
#include "curvopt.h"

#include <string.h>

#define STRING_(x) #x
#define STRING(x)  STRING_(x)

const char *curvopt_version(void) {
    return STRING(CURVOPT_VERSION_MAJOR) "." STRING(CURVOPT_VERSION_MINOR) "." STRING(CURVOPT_VERSION_PATCH);
}

#define TEXT_CASE(id, value, name, text)                                                                               \
    case value:                                                                                                        \
        return text;

/* curvopt_<type>_text() */
#define DEFINE_TEXT(type, LIST, UNKNOWN)                                                                               \
    const char *curvopt_##type##_text(int32_t value) {                                                                 \
        switch (value) {                                                                                               \
            LIST(TEXT_CASE)                                                                                            \
        default:                                                                                                       \
            return UNKNOWN;                                                                                            \
        }                                                                                                              \
    }

DEFINE_TEXT(status, CURVOPT_STATUS_LIST, "unknown status")
DEFINE_TEXT(exception, CURVOPT_EXCEPTION_LIST, "unknown exception")

#define NAME_CASE(id, value, name)                                                                                     \
    case value:                                                                                                        \
        return name;
#define FIND_NAME(id, value, name)                                                                                     \
    if (strcmp(text, name) == 0)                                                                                       \
        return value;
#define TEXTED_NAME_CASE(id, value, name, text) NAME_CASE(id, value, name)
#define TEXTED_FIND(id, value, name, long_text) FIND_NAME(id, value, name)

/* curvopt_<type>_name() and curvopt_<type>_from_name(). */
#define DEFINE_NAMES(type, LIST, CASE, FIND)                                                                           \
    const char *curvopt_##type##_name(int32_t value) {                                                                 \
        switch (value) {                                                                                               \
            LIST(CASE)                                                                                                 \
        default:                                                                                                       \
            return NULL;                                                                                               \
        }                                                                                                              \
    }                                                                                                                  \
    int32_t curvopt_##type##_from_name(const char *text) {                                                             \
        if (!text)                                                                                                     \
            return -1;                                                                                                 \
        LIST(FIND)                                                                                                     \
        return -1;                                                                                                     \
    }

DEFINE_NAMES(status, CURVOPT_STATUS_LIST, TEXTED_NAME_CASE, TEXTED_FIND)
DEFINE_NAMES(exception, CURVOPT_EXCEPTION_LIST, TEXTED_NAME_CASE, TEXTED_FIND)
DEFINE_NAMES(boundary_rule, CURVOPT_BOUNDARY_RULE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(surface, CURVOPT_SURFACE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(term, CURVOPT_TERM_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(method, CURVOPT_METHOD_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(boundary, CURVOPT_BOUNDARY_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(symmetry, CURVOPT_SYMMETRY_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(spacing, CURVOPT_SPACING_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(scalar, CURVOPT_SCALAR_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(scalar_rule, CURVOPT_SCALAR_RULE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(plane, CURVOPT_PLANE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(stop, CURVOPT_STOP_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(step, CURVOPT_STEP_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(verdict, CURVOPT_VERDICT_LIST, NAME_CASE, FIND_NAME)

const char *curvopt_stop_text(int32_t stop) {
    const char *name = curvopt_stop_name(stop);
    return name ? name : "unknown";
}

const char *curvopt_verdict_text(int32_t verdict) {
    if (verdict == CURVOPT_VERDICT_NOT_STATIONARY)
        return "not stationary";
    const char *name = curvopt_verdict_name(verdict);
    return name ? name : "unknown";
}

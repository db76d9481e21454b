/* Texts and names of enumerators, both ways, from the lists in curvopt.h. SPDX-License-Identifier: GPL-3.0-or-later */
#include "curvopt.h"

#include <string.h>

#define STRING_(x) #x
#define STRING(x)  STRING_(x)

const char *curvopt_version(void) {
    return STRING(CURVOPT_VERSION_MAJOR) "." STRING(CURVOPT_VERSION_MINOR) "." STRING(CURVOPT_VERSION_PATCH);
}

const char *curvopt_status_text(int32_t status) {
    switch (status) {
#define STATUS_CASE(name, value, short_name, text)                                                                     \
    case value:                                                                                                        \
        return text;
        CURVOPT_STATUS_LIST(STATUS_CASE)
    default:
        return "unknown status";
    }
}

const char *curvopt_exception_text(int32_t exception) {
    switch (exception) {
#define EXCEPTION_CASE(name, value, short_name, text)                                                                  \
    case value:                                                                                                        \
        return text;
        CURVOPT_EXCEPTION_LIST(EXCEPTION_CASE)
    default:
        return "unknown exception";
    }
}

#define NAME_CASE(id, value, name)                                                                                     \
    case value:                                                                                                        \
        return name;
#define FIND_NAME(id, value, name)                                                                                     \
    if (strcmp(text, name) == 0)                                                                                       \
        return value;
#define STATUS_NAME_CASE(id, value, name, text) NAME_CASE(id, value, name)
#define STATUS_FIND(id, value, name, long_text) FIND_NAME(id, value, name)

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

DEFINE_NAMES(status, CURVOPT_STATUS_LIST, STATUS_NAME_CASE, STATUS_FIND)
DEFINE_NAMES(exception, CURVOPT_EXCEPTION_LIST, STATUS_NAME_CASE, STATUS_FIND)
DEFINE_NAMES(boundary_rule, CURVOPT_BOUNDARY_RULE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(surface, CURVOPT_SURFACE_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(term, CURVOPT_TERM_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(method, CURVOPT_METHOD_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(boundary, CURVOPT_BOUNDARY_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(symmetry, CURVOPT_SYMMETRY_LIST, NAME_CASE, FIND_NAME)
DEFINE_NAMES(spacing, CURVOPT_SPACING_LIST, NAME_CASE, FIND_NAME)
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

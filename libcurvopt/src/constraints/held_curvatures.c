/* Curvatures of the surface at points. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/held_curvatures.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "linalg/small_dense.h"

#include <stdlib.h>
#include <string.h>

/* Least sine of the angle between tangents, by rounding. */
static const double LEAST_SINE = 1e-9;

/* Values of an entry: tangents, then second derivatives. */
enum { N_TANGENTS = 2, N_SECOND = 3 };

int co_held_curvatures_exist(const co_surface_values *fs) {
    int any = 0;
    for (int32_t i = 0; i < fs->n; i++)
        any |= fs->item[i].order == 2;
    return any;
}

/* Holds tangent f at `value`, without what rounding leaves of it along the normal. */
static void fix_tangent(co_surface_value *f, const double normal[3], const double value[3]) {
    const double part = co_dot3(value, normal);
    f->freedom = CO_FREEDOM_NONE;
    memcpy(f->direction, normal, sizeof f->direction);
    for (int c = 0; c < 3; c++)
        f->anchor[c] = value[c] - part * normal[c];
}

/* Holds second derivative f, by parameters whose tangents are a and b. `side`: 1 where the entry's normal is on the
 * faces' side, else -1. */
static void fix_second(co_surface_value *f, const double a[3], const double b[3], double side) {
    double form[3];
    co_small_dense_apply_3(f->curvature, b, form);
    f->freedom = CO_FREEDOM_PLANE;
    for (int c = 0; c < 3; c++)
        f->anchor[c] = -side * co_dot3(a, form) * f->direction[c];
}

/* The values of one entry from f on, at value [5][3]. */
static int32_t fix_entry(co_surface_value *f, const double *value, curvopt_error *error) {
    co_surface_value *second = f + N_TANGENTS;
    double across[3];
    for (int k = 0; k < N_TANGENTS; k++)
        fix_tangent(&f[k], second->direction, value + 3 * k);
    const double *a = f[0].anchor, *b = f[1].anchor;
    co_cross3(a, b, across);
    if (!(co_length3(across) > LEAST_SINE * co_length3(a) * co_length3(b)))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                              "entry %d: the surface has no tangent plane there to begin with", f->number);
    const double side = co_dot3(across, second->direction) > 0 ? 1 : -1;
    fix_second(&second[0], a, a, side);
    fix_second(&second[1], a, b, side);
    fix_second(&second[2], b, b, side);
    return CURVOPT_OK;
}

int32_t co_held_curvatures_fix(const curvopt_mesh *m, const double *xyz, co_surface_values *fs, curvopt_error *error) {
    double *value = CO_NEW(double, 3 * (size_t)fs->n);
    int32_t status = value ? co_surface_values_make_rows(m, fs, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        co_sparse_rows_apply(&fs->rows, xyz, value);
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        if (fs->item[i].order != 2)
            continue;
        status = fix_entry(&fs->item[i - N_TANGENTS], value + 3 * (size_t)(i - N_TANGENTS), error);
        i += N_SECOND - 1;
    }
    free(value);
    return status;
}

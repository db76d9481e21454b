/* What of a symmetry can be kept. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/kept_symmetry.h"

#include "constraints/interpolation.h"
#include "constraints/pivots.h"
#include "constraints/subgroups.h"

/* Whether pivots can be chosen by the symmetry's orbits. */
static int32_t try_group(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                         const co_symmetry *symmetry, int *fits, curvopt_error *error) {
    co_constraints all = {0};
    co_interpolation map = {0};
    int32_t status = co_constraints_all(m, constraints, boundary, &all, error);
    if (status == CURVOPT_OK)
        status = co_pivots_choose(m, symmetry, &all, error);
    if (status == CURVOPT_OK)
        status = co_interpolation_create(m, &all, &map, error);
    co_interpolation_free(&map);
    co_constraints_free(&all);
    *fits = status == CURVOPT_OK;
    return status == CURVOPT_ERROR_ARGUMENT ? CURVOPT_OK : status;
}

static int32_t try_subgroups(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                             co_symmetry *symmetry, curvopt_error *error) {
    co_subgroups groups = {0};
    int fits = 0;
    int32_t status = co_subgroups_create(symmetry, &groups, error);
    for (int32_t k = 0; status == CURVOPT_OK && !fits && k < groups.n; k++) {
        co_symmetry sub = {0};
        if (groups.order[k] == symmetry->order)
            continue;
        status = co_subgroup_select(symmetry, groups.member + (size_t)k * (size_t)groups.n_elements, &sub, error);
        fits = groups.order[k] == 1; /* what cannot be chosen freely then is refused where it is asked for */
        if (status == CURVOPT_OK && !fits)
            status = try_group(m, constraints, boundary, &sub, &fits, error);
        if (status == CURVOPT_OK && fits) {
            co_symmetry_free(symmetry);
            *symmetry = sub;
            sub = (co_symmetry){0};
        }
        co_symmetry_free(&sub);
    }
    co_subgroups_free(&groups);
    return status;
}

int32_t co_kept_symmetry_restrict(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                                  co_symmetry *symmetry, curvopt_error *error) {
    int fits;
    if (symmetry->order == 1 || !constraints->values.n)
        return CURVOPT_OK;
    int32_t status = try_group(m, constraints, boundary, symmetry, &fits, error);
    if (status != CURVOPT_OK || fits)
        return status;
    return try_subgroups(m, constraints, boundary, symmetry, error);
}

/* How a cage's faces fold or pinch. SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh/jacobian.h"

#include "base/vec3.h"
#include "mesh/subdivide.h"

#include <math.h>
#include <stdlib.h>

static int has_quads_alone(const curvopt_mesh *m) {
    for (int32_t f = 0; f < m->info.n_faces; f++)
        if (m->face_start[f + 1] - m->face_start[f] != 4)
            return 0;
    return 1;
}

static double area_at(const int32_t vertex[4], int c, const double *xyz) {
    double e[3], f[3], area[3];
    for (size_t i = 0; i < 3; i++) {
        const double at = xyz[3 * (size_t)vertex[c] + i];
        e[i] = xyz[3 * (size_t)vertex[(c + 1) % 4] + i] - at;
        f[i] = xyz[3 * (size_t)vertex[(c + 3) % 4] + i] - at;
    }
    co_cross3(e, f, area);
    return sqrt(co_dot3(area, area));
}

/* The least over the mean of `count` quads, from `first` on. */
static double least_part(const curvopt_mesh *m, const double *xyz, int32_t first, int32_t count) {
    double low = INFINITY, sum = 0;
    for (int32_t k = 0; k < 4 * count; k++) {
        const double area = area_at(m->corner_vertex + 4 * (size_t)(first + k / 4), k % 4, xyz);
        low = fmin(low, area);
        sum += area;
    }
    return sum > 0 ? 4 * count * low / sum : 0;
}

/* Of the mesh, subdivided twice: a corner of a face has four quads of these, in the order of corners. */
static double least_of(const curvopt_mesh *mesh, const uint8_t *left_out, const curvopt_mesh *fine, const double *xyz) {
    const int32_t corners = has_quads_alone(mesh) ? 4 : 1;
    double least = INFINITY;
    for (int32_t f = 0; f < mesh->info.n_faces; f++)
        for (int32_t c = mesh->face_start[f]; !(left_out && left_out[f]) && c < mesh->face_start[f + 1]; c += corners)
            least = fmin(least, least_part(fine, xyz, 4 * c, 4 * corners));
    return least;
}

int32_t co_jacobian_least(const curvopt_mesh *mesh, const uint8_t *left_out, const double *xyz, double *out,
                          curvopt_error *error) {
    curvopt_mesh *fine[2] = {NULL, NULL};
    double *at[2] = {NULL, NULL};
    int32_t status = CURVOPT_OK;
    for (int k = 0; k < 2 && status == CURVOPT_OK; k++) {
        co_sparse_rows rows = {0};
        status = co_subdivide_cage(k ? fine[0] : mesh, k ? at[0] : xyz, &fine[k], &rows, &at[k], error);
        co_sparse_rows_free(&rows);
    }
    if (status == CURVOPT_OK)
        *out = least_of(mesh, left_out, fine[1], at[1]);
    for (int k = 0; k < 2; k++) {
        co_mesh_destroy(fine[k]);
        free(at[k]);
    }
    return status;
}

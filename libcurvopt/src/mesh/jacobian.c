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

/* Over groups of so many quads that follow each other. */
static double least_of(const curvopt_mesh *m, const double *xyz, int32_t group) {
    double least = INFINITY;
    for (int32_t first = 0; first < m->info.n_faces; first += group) {
        double low = INFINITY, sum = 0;
        for (int32_t k = 0; k < 4 * group; k++) {
            const double area = area_at(m->corner_vertex + 4 * (size_t)(first + k / 4), k % 4, xyz);
            low = fmin(low, area);
            sum += area;
        }
        least = fmin(least, sum > 0 ? 4 * group * low / sum : 0);
    }
    return least;
}

int32_t co_jacobian_least(const curvopt_mesh *mesh, const double *xyz, double *out, curvopt_error *error) {
    curvopt_mesh *fine[2] = {NULL, NULL};
    double *at[2] = {NULL, NULL};
    int32_t status = CURVOPT_OK;
    for (int k = 0; k < 2 && status == CURVOPT_OK; k++) {
        co_sparse_rows rows = {0};
        status = co_subdivide_cage(k ? fine[0] : mesh, k ? at[0] : xyz, &fine[k], &rows, &at[k], error);
        co_sparse_rows_free(&rows);
    }
    if (status == CURVOPT_OK)
        *out = least_of(fine[1], at[1], has_quads_alone(mesh) ? 16 : 4);
    for (int k = 0; k < 2; k++) {
        co_mesh_destroy(fine[k]);
        free(at[k]);
    }
    return status;
}

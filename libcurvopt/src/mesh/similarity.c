/* Similarity motions of a cage: centroid, scale, rotation (sources: similarity.h). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "mesh/similarity.h"

#include "base/vec3.h"
#include "linalg/small_dense.h"

#include <math.h>

static const double LARGEST = 1e100; /* coordinates beyond this could overflow when squared */

int co_similarity_reaches(const double centroid[3], double radius, const double place[3]) {
    return co_distance3(centroid, place) <= CO_SIMILARITY_FARTHEST * radius;
}

double co_similarity_frame_without(size_t n, const double *xyz, size_t n_skipped, const int32_t *skipped,
                                   double centroid[3]) {
    double squares[3] = {0, 0, 0}, part = 1 / (double)(n - n_skipped); /* times that: sums might be too large */
    centroid[0] = centroid[1] = centroid[2] = 0;
    for (size_t v = 0, k = 0; v < n; v++) {
        if (skipped && k < n_skipped && (size_t)skipped[k] == v) {
            k++;
            continue;
        }
        for (int c = 0; c < 3; c++)
            centroid[c] += part * xyz[3 * v + (size_t)c];
    }
    for (size_t v = 0, k = 0; v < n; v++) {
        if (skipped && k < n_skipped && (size_t)skipped[k] == v) {
            k++;
            continue;
        }
        for (int c = 0; c < 3; c++) {
            double x = xyz[3 * v + (size_t)c] - centroid[c];
            squares[c] += part * x * x;
        }
    }
    return sqrt(squares[0] + squares[1] + squares[2]);
}

double co_similarity_frame(size_t n, const double *xyz, double centroid[3]) {
    return co_similarity_frame_without(n, xyz, 0, NULL, centroid);
}

double co_similarity_mesh_frame(const curvopt_mesh *m, const double *xyz, double centroid[3]) {
    return co_similarity_frame_without((size_t)m->info.n_vertices, xyz, (size_t)m->info.n_isolated, m->isolated,
                                       centroid);
}

/* Newton's iteration for the polar factor, X <- (X + X^-T) / 2 (Higham 1986), without his scaling: what comes in
 * is nearly orthogonal. */
int co_similarity_orthogonal_factor(double m[3][3]) {
    for (int step = 0; step < 60; step++) {
        double next[3][3], change = 0, det = co_small_dense_determinant_3(m);
        if (!(fabs(det) > 1e-12))
            return 0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                next[i][j] = (m[i][j] + co_small_dense_cofactor_3(m, i, j) / det) / 2;
                change = fmax(change, fabs(next[i][j] - m[i][j]));
            }
        for (int i = 0; i < 9; i++)
            m[i / 3][i % 3] = next[i / 3][i % 3];
        if (change < 1e-15)
            break;
    }
    return 1;
}

void co_similarity_align(size_t n, const double *reference, double *xyz) {
    double to[3], from[3], m[3][3] = {{0}};
    double scale = co_similarity_frame(n, reference, to) * co_similarity_frame(n, xyz, from);
    for (size_t p = 0; p < n; p++)
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++)
                m[i][j] += (reference[3 * p + i] - to[i]) * (xyz[3 * p + j] - from[j]) / (scale * (double)n);
    int turn = co_small_dense_determinant_3(m) > 0 && co_similarity_orthogonal_factor(m);
    for (size_t p = 0; p < n; p++) {
        double x[3] = {xyz[3 * p] - from[0], xyz[3 * p + 1] - from[1], xyz[3 * p + 2] - from[2]};
        for (size_t i = 0; i < 3; i++)
            xyz[3 * p + i] = to[i] + (turn ? m[i][0] * x[0] + m[i][1] * x[1] + m[i][2] * x[2] : x[i]);
    }
}

int32_t co_similarity_check(int32_t n_vertices, const double *xyz, curvopt_error *error) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, extent = 0, far = 0;
    for (int32_t v = 0; v < n_vertices; v++)
        for (int c = 0; c < 3; c++) {
            double x = xyz[3 * (size_t)v + (size_t)c];
            if (!(fabs(x) <= LARGEST)) /* NAN, too */
                return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, v,
                                      "vertex %d has coordinate %c = %g; it must be finite and at most %g", v, "xyz"[c],
                                      x, LARGEST);
            low[c] = x < low[c] ? x : low[c]; /* fmin would be a call */
            high[c] = x > high[c] ? x : high[c];
        }
    for (int c = 0; c < 3; c++) {
        extent = fmax(extent, high[c] - low[c]);
        far = fmax(far, fmax(fabs(low[c]), fabs(high[c])));
    }
    if (extent < 1 / LARGEST || extent < 1e-10 * far)
        return co_status_fail(error, CURVOPT_ERROR_GEOMETRY, -1,
                              "the cage has zero area: its vertices all lie within %g of %g %g %g", extent, low[0],
                              low[1], low[2]);
    return CURVOPT_OK;
}

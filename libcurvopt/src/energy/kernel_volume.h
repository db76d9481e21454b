/* The volume int x.n dA / 3 under a face, x from the origin: det(S, S_u, S_v) / 3, trilinear in a face's points; its
 * value and derivatives. Included by element_kernel.c only, as kernel_gradient.h is.
 *
 * With s = (S, S_u, S_v) and r_p = (R, R_u, R_v) a point's entries in the rows, the block of points p and q (components
 * i and j) is eps_ijk w_k / 3, with w the sum over m of (r_p x r_q)_m s_m: it is 0 for p = q.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_KERNEL_VOLUME_H
#define CO_ENERGY_KERNEL_VOLUME_H

#include "base/simd.h"
#include "surface/bspline.h"

#include <string.h>

/* Each face's first point, from which its points are counted (gather in kernel_rows.h). */
CO_SIMD_INLINE void volume_offset(const int32_t *points, const double *xyz, lane offset[3]) {
    double place[3][CO_LANES];
    for (int l = 0; l < CO_LANES; l++)
        for (int c = 0; c < 3; c++)
            place[c][l] = xyz[3 * (size_t)points[l] + (size_t)c];
    memcpy(offset, place, sizeof place);
}

CO_SIMD_INLINE void from_origin(const lane relative[3], const lane offset[3], lane place[3]) {
    for (int c = 0; c < 3; c++)
        place[c] = relative[c] + offset[c];
}

/* weight * det(S, S_u, S_v) / 3; place: S from the origin; normal: S_u x S_v. */
CO_SIMD_INLINE lane volume_value(const lane place[3], const lane normal[3], lane weight) {
    return weight * (1.0 / 3) * lane_dot(place, normal);
}

/* S_bar [0..2] += those of that. */
CO_SIMD_INLINE void add_volume_adjoint(const lane place[3], lane S[CO_JET][3], double weight, lane S_bar[CO_JET][3]) {
    lane turned[3];
    const lane third_of_weight = lane_all(weight * (1.0 / 3));
    lane_cross(S[1], S[2], turned);
    lane_add_scaled(S_bar[0], third_of_weight, turned);
    lane_cross(S[2], place, turned);
    lane_add_scaled(S_bar[1], third_of_weight, turned);
    lane_cross(place, S[1], turned);
    lane_add_scaled(S_bar[2], third_of_weight, turned);
}

/* matrix += the block of points p and q < p, r the entries in the rows. */
CO_SIMD_INLINE void volume_add_block(lane S[CO_JET][3], double weight, const lane r_p[3], const lane r_q[3], int p,
                                     int q, lane *matrix) {
    lane both[3], w[3];
    lane_cross(r_p, r_q, both);
    for (int c = 0; c < 3; c++)
        w[c] = weight * (1.0 / 3) * (both[0] * S[0][c] + both[1] * S[1][c] + both[2] * S[2][c]);
    lane *row[3];
    for (int i = 0; i < 3; i++)
        row[i] = matrix + (3 * p + i) * (3 * p + i + 1) / 2 + 3 * q;
    row[0][1] += w[2];
    row[0][2] -= w[1];
    row[1][0] -= w[2];
    row[1][2] += w[0];
    row[2][0] += w[1];
    row[2][1] -= w[0];
}

#endif

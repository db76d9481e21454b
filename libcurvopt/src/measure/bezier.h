/* Bicubic Bezier pieces of surface: points, parts, and bounds by their control nets' convex hulls.
 *
 * A piece is 48 numbers: control point 4 j + i (i along u, j along v), three coordinates each. (u, v) run from 0 to 1.
 * Farin, "Curves and surfaces for CAGD", 5th edition, 2002, chapters 5 and 14.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_BEZIER_H
#define CO_MEASURE_BEZIER_H

#include "base/vec3.h"

enum { CO_BEZIER = 48 };

/* Position and derivatives at a point. */
typedef struct co_bezier_jet {
    double s[3], u[3], v[3], uu[3], uv[3], vv[3];
} co_bezier_jet;

/* A box with sides along the axes. */
typedef struct co_box {
    double low[3], high[3];
} co_box;

/* A box with sides along three orthonormal axes. */
typedef struct co_oriented_box {
    double centre[3], axis[3][3], half[3];
} co_oriented_box;

/* A cone of directions: unit axis, and the largest angle from it in radians; pi if the directions have no mean. */
typedef struct co_cone {
    double axis[3];
    double angle;
} co_cone;

/* From a uniform bicubic B-spline's 16 points (ring.h) to the same piece's Bezier points. */
void co_bezier_from_bspline(const double spline[CO_BEZIER], double out[CO_BEZIER]);
void co_bezier_at(const double piece[CO_BEZIER], double u, double v, co_bezier_jet *out);
/* Position alone. */
void co_bezier_point(const double piece[CO_BEZIER], double u, double v, double out[3]);
/* The part u in [u[0], u[1]], v in [v[0], v[1]] of a piece, by its blossom; out may be the piece. A range that runs
 * backwards turns the part round. */
void co_bezier_part(const double piece[CO_BEZIER], const double u[2], const double v[2], double out[CO_BEZIER]);
/* Largest lengths of the second derivatives uu, uv, vv: not more than these bounds anywhere on the piece. */
void co_bezier_second(const double piece[CO_BEZIER], double bound[3]);
/* Cones of the derivatives by u and by v of n pieces [n][CO_BEZIER]. */
void co_bezier_cones(const double *pieces, int n, co_cone *u, co_cone *v);
/* A cone that holds a piece's normals: round the control net of S_u x S_v; angle pi if that is not within 90 degrees.
 */
co_cone co_bezier_normals(const double piece[CO_BEZIER]);
/* A cone that holds the cross products of directions of two cones (Sederberg and Meyers, "Loop detection in surface
 * patch intersections", CAGD 5, 1988, section 4); angle pi where there is none. */
co_cone co_cone_product(const co_cone *u, const co_cone *v);

/* Twice the mean directions by u and by v of the corners (0, 0), (1, 0), (0, 1) and (1, 1), and their cross product. */
void co_bezier_mean_directions(const double *const corner[4], double u[3], double v[3], double normal[3]);
/* The box round the first corner and n points, along the mean direction by u of the corners (0, 0), (1, 0), (0, 1) and
 * (1, 1) and their normal; where these are 0, or the mean directions by u and v nearly the same, along x, y and z. */
co_oriented_box co_oriented_box_round(const double *const corner[4], const double *points, int n);
/* The box round a piece's control points. */
co_oriented_box co_oriented_box_of(const double piece[CO_BEZIER]);
static inline double co_oriented_box_distance_squared(const co_oriented_box *box, const double x[3]) {
    const double r[3] = {x[0] - box->centre[0], x[1] - box->centre[1], x[2] - box->centre[2]};
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double along = co_dot3(r, box->axis[k]), d = (along > 0 ? along : -along) - box->half[k];
        sum += d > 0 ? d * d : 0;
    }
    return sum;
}
/* The box of n points. */
co_box co_box_of(const double *points, int n);
/* Makes a box hold another one, too. Comparisons instead of fmin and fmax, which are calls. */
static inline void co_box_add(co_box *box, const double low[3], const double high[3]) {
    for (int c = 0; c < 3; c++) {
        box->low[c] = low[c] < box->low[c] ? low[c] : box->low[c];
        box->high[c] = high[c] > box->high[c] ? high[c] : box->high[c];
    }
}
static inline int co_box_overlap(const co_box *a, const co_box *b) {
    for (int c = 0; c < 3; c++)
        if (a->low[c] > b->high[c] || b->low[c] > a->high[c])
            return 0;
    return 1;
}
/* Square of the distance from a point to a box. */
static inline double co_box_distance_squared(const co_box *box, const double x[3]) {
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double below = box->low[c] - x[c], above = x[c] - box->high[c];
        const double d = below > above ? below : above;
        sum += d > 0 ? d * d : 0;
    }
    return sum;
}

#endif

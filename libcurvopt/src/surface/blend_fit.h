/* The `polynomial` surface: near an extraordinary vertex S is blended into one polynomial over the characteristic map,
 *     S' = (1 - w(u / m) w(v / m)) S + w(u / m) w(v / m) P(chi(u, v)),
 * P the least-squares fit of S on the m x m faces of each sector round the vertex. Linear in the cage, so that the
 * surface is as exact a function of it as the limit surface is; third derivatives are square integrable.
 *
 * Follows: Levin, "Modified subdivision surfaces with continuous curvature", SIGGRAPH 2006 (blending a subdivision
 * surface into a polynomial over the characteristic map); Ying, Zorin 2004. Differs: blended over whole faces and by a
 * product of one-dimensional weights, so that three rings of parameters stay as they are; over a disc that stays as
 * large while the cage is refined, where the cage has room for one (blend_disc.h); degree and weights by experiment
 * (notes/10-blend-degree-and-weight.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BLEND_FIT_H
#define CO_SURFACE_BLEND_FIT_H

#include "base/double_double.h"
#include "surface/blend_weight.h"
#include "surface/stam.h"

enum {
    CO_BLEND_FIT_DEGREE = 5 /* of P */,
    CO_BLEND_FIT_TERMS = (CO_BLEND_FIT_DEGREE + 1) * (CO_BLEND_FIT_DEGREE + 2) / 2,
    CO_BLEND_FIT_CUSP = CO_BLEND_FIT_TERMS, /* after the monomials, in fits of fans that are cut: |chi|^3 */
    CO_BLEND_FIT_FUNCTIONS
};

/* Valence from which on squared curvature of the limit surface is not resolved. Its integral over ring r falls as
 * (mu / lambda)^2r (stam.h), and from 12 on more than 5e-4 of it is in rings beyond 40, whose size is below 1e-7 of a
 * face: .36 at 32, .94 at 128 (notes/35-tables-of-high-valence.md). */
enum { CO_BLEND_FIT_UNRESOLVED = 12 };

/* Points of a disc of width m, whose faces need those at places 0 <= x, y <= m + 1 of each sector: numbered as a fan's
 * two-ring (fan.h), which is that of m = 1; each sector owns those with x > 0, row by row. */
typedef struct co_blend_fit {
    int32_t valence, width;
    int is_half;      /* of a half disc (blend_fit_half.h), */
    int steps;        /* whose map has so many steps, and */
    double unit;      /* so long a face along the curve */
    int32_t n_points; /* of the disc */
    int has_cusp;     /* whether the fit has coefficients of CO_BLEND_FIT_CUSP, not 0 */
    double *map;      /* [2 n_points] control points of chi; if width > 1 the farthest is at 1 */
    double *fit;      /* [CO_BLEND_FIT_FUNCTIONS][n_points] coefficients of P as rows, in the order of
                          co_blend_fit_monomials, the cusp's at the end; NULL: the map alone */
} co_blend_fit;

/* Makes the map alone, without fit, round the vertex of `disc`. ERROR_MEMORY. */
int32_t co_blend_fit_create_map(const co_stam_disc *disc, int width, co_blend_fit *out, curvopt_error *error);
/* Makes map and fit: normal equations of 16 samples a face, and of 5 rings of 48 in the face at the vertex.
 * ERROR_MEMORY. */
int32_t co_blend_fit_create(const co_stam_disc *disc, int width, co_blend_fit *out, curvopt_error *error);
void co_blend_fit_free(co_blend_fit *polynomial);

/* The surface (curvopt_surface) of a kind of patch where `surface` is asked for: LIMIT, where that is all there is;
 * POLYNOMIAL instead of LIMIT, where the limit has no finite integral of squared curvature, or one that cannot be
 * resolved, and a blend has. */
int32_t co_blend_fit_surface(int32_t surface, int32_t kind);

static inline int32_t co_blend_fit_n_points(int32_t valence, int width) {
    return 1 + valence * (width + 1) * (width + 2);
}
/* Index of the point at place (x, y) of a sector, -1 <= x, y <= width + 1, not both negative; sectors count modulo the
 * valence. */
int32_t co_blend_fit_index(int32_t valence, int width, int32_t sector, int x, int y);
/* The same on a half disc (blend_fit_half.h), 0 <= x, y <= width + 1. */
int32_t co_blend_fit_half_index(int width, int32_t sector, int x, int y);
/* Index among the disc's points of point i of the two-ring (fan.h). */
int32_t co_blend_fit_index_of_two_ring(const co_blend_fit *polynomial, int32_t i);

/* Jets of all monomials of chi, 1, x, y, x^2, x y, y^2, x^3, .., from the jets x, y of its coordinates. */
void co_blend_fit_monomials(const double x[CO_JET], const double y[CO_JET], double out[CO_BLEND_FIT_TERMS][CO_JET]);
/* Their values at (x, y). */
void co_blend_fit_values(double x, double y, double out[CO_BLEND_FIT_TERMS]);
/* Number of the monomial x^a y^b. */
static inline int co_blend_fit_term(int a, int b) {
    return (a + b) * (a + b + 1) / 2 + b;
}
/* Jet of |chi|^3 from the jets x, y, not both of value 0. */
void co_blend_fit_cusp(const double x[CO_JET], const double y[CO_JET], double out[CO_JET]);

/* Samples and weights of the fit (notes/10-blend-degree-and-weight.md). */
enum { CO_BLEND_FIT_GAUSS = 4 /* Gauss points a side of each cell or face */ };
static const double co_blend_fit_far_weight = 1e-3; /* added to the weight w, which is 0 at the far sides */

/* The steps of a fit, for blend_fit_cut.c and blend_fit_half.c. One: calls `add` for the samples of the face at the
 * disc's vertex, with the row [n_points] of the surface over the two-ring and the weight. work [18 n_points] */
typedef void co_blend_fit_add(void *user, const double *row, double weight);
void co_blend_fit_sample_rings(co_stam_disc *disc, int width, double *work, co_blend_fit_add *add, void *user);
/* Another: the same for face (i, j), not the one at the vertex, with rows over its 16 points. */
void co_blend_fit_sample_face(int width, int i, int j, co_blend_fit_add *add, void *user);
/* Another: solves normal X = right in place of the first n columns of `right` [n_terms][stride], by Cholesky's
 * factorization of the lower triangle of normal [n_terms][n_terms]. */
void co_blend_fit_solve(int n_terms, co_double_double *normal, int32_t n, int32_t stride, co_double_double *right);
/* turn [TERMS][TERMS]: the coefficients of P(R_s (x, y)) from those of P, R_s a turn by `sector` sectors. */
void co_blend_fit_turn(int32_t valence, int32_t sector, double turn[CO_BLEND_FIT_TERMS][CO_BLEND_FIT_TERMS]);

#endif

/* Vertices that slide along boundaries and creases.
 *
 * A boundary or an infinitely sharp crease has a limit curve, a uniform cubic B-spline of the vertices on it. Vertices
 * slide on the curve of the input cage: each has a place on it, a parameter t, where its limit point is. The cage's
 * vertices are the control points of the spline that interpolates these points, (1, 4, 1) / 6 P = C(t). So the limit
 * points are exactly on the input's curve; between them the curve is another one, of third order in the spacing.
 *
 * Curves are those between ends: corners, infinitely sharp vertices, vertices where the cage is no manifold. An end
 * stays. A curve through a fading edge or vertex, or that ends inside the surface, is no such spline, and is none of
 * these: its vertices are held.
 *
 * Other vertices may be held as well. Their control points stay, so beside them the spline does not interpolate. Let
 * the vertices at distance k slide by s_k along the curve. Then the limit point at a held vertex leaves the curve in
 * proportion to sum (-q)^k k s_k, q = 2 - sqrt 3, to first order. The vertex beside a held one therefore does not slide
 * by itself: it follows, by the s_1 for which this is 0 (libcurvopt/notes/85-sliding-along-curves.md).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_SLIDING_H
#define CO_CONSTRAINTS_SLIDING_H

#include "constraints/constraints.h"
#include "constraints/spline_curve.h"

typedef enum co_slide_role {
    CO_SLIDE_STAYS,   /* its control point stays */
    CO_SLIDE_FOLLOWS, /* it is beside one that stays, which is no end */
    CO_SLIDE_SLIDES
} co_slide_role;

typedef struct co_slide_curve {
    co_spline_curve track; /* on which vertices slide: of the input cage, or, where vertices are held, of the level's */
    int32_t n;             /* vertices of the present cage on the curve, both ends included */
    int32_t *vertex;       /* [n] in order */
    double *place;         /* [n] parameter on the track */
    double *next;          /* [n] the places that co_sliding_put_back() found */
    double *point;         /* [3 n] work: limit points */
    double *control;       /* [3 n] work: control points */
    uint8_t *role;         /* [n] co_slide_role */
    int slides;            /* whether any vertex does */
    double deviation;      /* from the input's curve, as it was measured last */
    double deviation_before; /* of the track from the input's curve */
} co_slide_curve;

typedef struct co_sliding {
    int32_t n_curves;
    co_slide_curve *curves;
    int32_t n_sliding; /* vertices that slide or follow */
} co_sliding;

/* The curves of a cage at xyz [3 n_vertices]; nothing slides before co_sliding_begin_level(). ERROR_MEMORY. */
int32_t co_sliding_create(const curvopt_mesh *mesh, const double *xyz, co_sliding *out, curvopt_error *error);
void co_sliding_free(co_sliding *sliding);
/* From a cage to its subdivision (subdivide.h). ERROR_MEMORY. */
int32_t co_sliding_subdivide(const curvopt_mesh *mesh, co_sliding *sliding, curvopt_error *error);

/* What slides on a level that begins at xyz [3 n_vertices]: vertices of the curves that `boundary` (curvopt_boundary)
 * holds for the sake of the curve only. xyz is put on the tracks again. ERROR_MEMORY. */
int32_t co_sliding_begin_level(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary,
                               co_sliding *sliding, double *xyz, curvopt_error *error);
/* tangent [3 n_vertices]: unit tangents of the tracks where vertices slide, else 0. */
void co_sliding_tangents(const co_sliding *sliding, int32_t n_vertices, double *tangent);
/* Vertices that slid along their tangents, at xyz [3 n_vertices], onto their curves: their next places are where limit
 * points are closest to the track. Returns the longest slide, in parts of the distance to the next vertex. */
double co_sliding_put_back(co_sliding *sliding, double *xyz);
/* The next places become the present ones. */
void co_sliding_accept(co_sliding *sliding);
/* Measures how far curves at xyz are from the input's. */
void co_sliding_measure(co_sliding *sliding, const double *xyz);
/* The longest such distance. */
double co_sliding_deviation(const co_sliding *sliding);

/* Vertices with a tangent [3 n_vertices] move along it. */
void co_sliding_free_along(int32_t n_vertices, const double *tangent, co_constraints *all);

#endif

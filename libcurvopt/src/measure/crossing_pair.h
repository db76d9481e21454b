/* Whether two pieces of a limit surface cross.
 *
 * Parts are cut in four until one of these is known:
 *   - Their boxes are apart, or the convex hulls of their control nets are, along the line between their middles or a
 *     mean normal: they do not cross.
 *   - Their heights over a paraboloid that osculates one of them are apart (quadric.h): sheets along each other.
 *   - They are neighbours, and directions say that they do not cross. Let all derivatives along one parameter be in
 *     cone U and those along the other in cone V, also across a common edge. If no line is parallel to a direction of
 *     each, differences of points, which are positive means of derivatives along a way through the common parameter
 *     plane that never turns back, are never 0: parts that share an edge or a part of one, and each part by itself, do
 *     not cross. Of others that share a
 *     vertex all normals must be within 75 degrees of one direction (Volino and Magnenat-Thalmann, "Efficient
 *     self-collision detection on smoothly discretized surface animations using geometrical shape regularity", Computer
 *     Graphics Forum 13(3), 1994; Grinspun and Schroeder, "Normal bounds for subdivision-surface interference
 *     detection", IEEE Visualization 2001); the outline of their projection is not looked at.
 *   - They are no neighbours, and Newton's method finds a common point with transversal tangent planes: they cross.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_CROSSING_PAIR_H
#define CO_MEASURE_CROSSING_PAIR_H

#include "measure/location.h"

/* In ascending order of what matters more. */
typedef enum co_crossing {
    CO_CROSSING_NONE,
    CO_CROSSING_UNRESOLVED, /* parts may meet, but no common point was found */
    CO_CROSSING_CONTACT,    /* common points, but none with transversal tangent planes inside both surfaces */
    CO_CROSSING_PROVEN
} co_crossing;

/* Cones of derivatives and of normals. */
typedef struct co_directions {
    co_cone u, v, normal;
    int are_apart; /* no line is parallel to a direction of u and one of v: the part or patch does not cross itself */
} co_directions;

typedef struct co_crossing_search {
    const curvopt_mesh *mesh;
    const co_surface_pieces *pieces;
    const co_directions *directions; /* [n_pieces]; NULL: made where they are asked for */
    const co_box *box;               /* [n_pieces] */
} co_crossing_search;

/* Of n pieces [n][CO_BEZIER]. */
co_directions co_directions_of(const double *pieces, int n);
/* Whether directions prove that two parts or patches that share an edge, or a part of one, do not cross. */
int co_directions_edge_is_clear(const co_directions *a, const co_directions *b);
/* Most pairs of parts with overlapping boxes for one pair of pieces, of which more are unresolved if these are few:
 * thoroughly; on the way; where pieces round these two were unresolved already, which are hardly cut. */
enum { CO_CROSSING_PARTS = 800, CO_CROSSING_FEW_PARTS = 80, CO_CROSSING_FEWEST_PARTS = 6 };

/* Of pieces a and b, which may be the same. */
co_crossing co_crossing_of(const co_crossing_search *search, int32_t a, int32_t b, int most_parts);

#endif

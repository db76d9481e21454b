/* Paraboloids that osculate pieces of a surface, as walls between sheets that lie along each other: where both bend
 * alike their convex hulls overlap, but their distances from a paraboloid that bends as they do are apart.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_MEASURE_QUADRIC_H
#define CO_MEASURE_QUADRIC_H

#include "measure/bezier.h"

/* With x, y, z the coordinates along `axis` from the origin, heights over it are
 * z - (c[0] x^2 + c[1] x y + c[2] y^2). */
typedef struct co_quadric {
    double origin[3], axis[3][3]; /* the third is the normal */
    double c[3];
} co_quadric;

/* That of a piece at its middle, where it has the piece's tangent plane and curvatures; 0 if the piece has no normal
 * there. */
int co_quadric_at_middle(const double piece[CO_BEZIER], co_quadric *out);
/* The heights of a piece's points are within range: those of the coefficients of degree 6 by 6 (Farin, chapter 6,
 * products of Bernstein polynomials). */
void co_quadric_heights(const co_quadric *quadric, const double piece[CO_BEZIER], double range[2]);

#endif

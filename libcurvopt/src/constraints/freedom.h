/* The directions in which a constraint lets a vertex move. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_FREEDOM_H
#define CO_CONSTRAINTS_FREEDOM_H

/* Dimensions in which a vertex may move: at a point, on a line, in a plane, anywhere. */
enum { CO_FREEDOM_NONE = 0, CO_FREEDOM_LINE = 1, CO_FREEDOM_PLANE = 2, CO_FREEDOM_ALL = 3 };

/* Sine of the angle between the lines that two unit vectors span. Unlike the cosine it tells small angles apart. */
double co_freedom_sine(const double a[3], const double b[3]);
/* Whether unit vectors span the same line, to rounding. */
int co_freedom_same_direction(const double a[3], const double b[3]);
/* Projector onto the directions that a constraint leaves, by rows. `direction`: unit, along the line or normal to the
 * plane; not read where there is neither. */
void co_freedom_projector(int freedom, const double *direction, double projector[9]);

#endif

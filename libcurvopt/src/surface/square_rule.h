/* Cubature on the square 0..1 x 0..1, as symmetric as the square itself, exact for polynomials of a total degree. From
 * degree 5 on it takes fewer points than Gauss's product rule of that degree.
 * Rules of 8 to 85 points have the orbits of F. D. Witherden, P. E. Vincent, "On the identification of symmetric
 * quadrature rules for finite element methods", Comput. Math. Appl. 69(10), 2015 (of 12 points already G. W.
 * Tyler, 1953). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_SQUARE_RULE_H
#define CO_SURFACE_SQUARE_RULE_H

enum { CO_SQUARE_RULE_GAUSS = 12, CO_SQUARE_RULE_MOST = CO_SQUARE_RULE_GAUSS * CO_SQUARE_RULE_GAUSS };

typedef struct co_square_rule {
    int n;                                /* points, all inside */
    double point[CO_SQUARE_RULE_MOST][2]; /* [n] u and v */
    double weight[CO_SQUARE_RULE_MOST];   /* [n] positive; they sum to 1 */
} co_square_rule;

/* Number of points of the rule of degree 2 gauss - 1, as exact as Gauss's rule of so many points a side; gauss is 1 ..
 * CO_SQUARE_RULE_GAUSS. */
int co_square_rule_size(int gauss);
/* That rule. */
void co_square_rule_make(int gauss, co_square_rule *rule);

#endif

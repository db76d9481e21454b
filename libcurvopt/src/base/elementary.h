/* Elementary functions with the same bits on every platform: those of C libraries differ in their last digits, and with
 * them tables, and minimizers (libcurvopt/notes/98-other-platforms.md). Additions, products,
 * quotients and roots alone, which IEEE 754 defines; errors are below 2 units in the last place. Finite arguments.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_ELEMENTARY_H
#define CO_BASE_ELEMENTARY_H

/* cos(pi x) and sin(pi x), exact at multiples of a half. */
double co_cos_pi(double x);
double co_sin_pi(double x);
/* The angle of (x, y) from the first axis over pi, -1 to 1; 0 at the origin. */
double co_angle_over_pi(double y, double x);
/* The angle between 0 and pi that has this cosine, -1 to 1. */
double co_arc_cosine(double x);
double co_exp(double x);
/* x > 0 */
double co_log(double x);
/* log(1 + x), x > -1 */
double co_log_1_plus(double x);
/* x^n */
double co_power(double x, int n);
/* The length of (x, y), whose squares neither overflow nor vanish. */
double co_length(double x, double y);

#endif

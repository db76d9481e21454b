/* Vectors of doubles. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_VECTOR_H
#define CO_LINALG_VECTOR_H

#include <stddef.h>

/* a . b, by four partial sums: the same value on every machine, and vectorized. */
double co_vector_dot(size_t n, const double *a, const double *b);
/* Euclidean norm. */
double co_vector_norm(size_t n, const double *a);
/* y += s x */
void co_vector_add(size_t n, double s, const double *x, double *y);
/* x -= its components along `count` orthonormal columns q [count][n], one after the other. */
void co_vector_remove(size_t n, size_t count, const double *q, double *x);

#endif

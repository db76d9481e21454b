/* Small dense matrices of doubles, by rows. The 21 x 21 least-squares system of blend_fit.c is solved there, in long
 * double: in double its coefficients would lose what third derivatives are made of.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_SMALL_DENSE_H
#define CO_LINALG_SMALL_DENSE_H

/* out [3] = a [3][3] x [3]; out may not be x. */
static inline void co_small_dense_apply_3(const double a[9], const double *x, double *out) {
    for (int i = 0; i < 3; i++)
        out[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
}
/* out [3][3] = a [3][3] b [3][3]; out may be neither. */
static inline void co_small_dense_multiply_3(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}
/* Entry (i, j) of the matrix of cofactors, whose transpose over the determinant is the inverse. (Not const: C11 would
 * want a cast at each call.) */
static inline double co_small_dense_cofactor_3(double a[3][3], int i, int j) {
    int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
    return a[p][r] * a[q][s] - a[p][s] * a[q][r];
}
static inline double co_small_dense_determinant_3(double a[3][3]) {
    return a[0][0] * co_small_dense_cofactor_3(a, 0, 0) + a[0][1] * co_small_dense_cofactor_3(a, 0, 1) +
           a[0][2] * co_small_dense_cofactor_3(a, 0, 2);
}

/* out = a^-1, both [n] rows of `stride` numbers, by Gauss's and Jordan's elimination with row pivots. Destroys a; of a
 * singular matrix the inverse is not finite. 2 n^3 operations. */
void co_small_dense_invert(int n, int stride, double *a, double *out);

/* Eigenvalues value [n] of a symmetric matrix, in no order, and orthonormal eigenvectors in the columns of v: Jacobi's
 * cyclic rotations (1846), to the last bit. a and v [n] rows of `stride` numbers; destroys a. O(n^3) a sweep, and about
 * ten of these. */
void co_small_dense_eigen(int n, int stride, double *a, double *value, double *v);

#endif

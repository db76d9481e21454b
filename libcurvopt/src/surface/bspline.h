/* Jets of functions of (u, v) to third order, and the uniform bicubic B-spline basis.
 *
 * A jet holds a value and its nine derivatives, in this order everywhere in the library:
 *   0: f   1: f_u   2: f_v   3: f_uu   4: f_uv   5: f_vv   6: f_uuu   7: f_uuv   8: f_uvv   9: f_vvv
 * Tables are built in double; fits to them in double-double, where nearly equal numbers are subtracted
 * (notes/33-precision-of-the-tables.md). B-splines: de Boor, "A practical guide to splines", 1978, chapter IX.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_BSPLINE_H
#define CO_SURFACE_BSPLINE_H

enum { CO_JET = 10, CO_JET_SECOND = 6 /* of these, up to second order */ };

/* Order of differentiation of each jet entry with respect to u and v. Not extern: element_kernel.c's loops over them
 * are unrolled by the compiler, which must see the numbers. */
static const int co_jet_order_u[CO_JET] = {0, 1, 0, 2, 1, 0, 3, 2, 1, 0};
static const int co_jet_order_v[CO_JET] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3};

/* Where a derivative stands in a jet. */
static inline int co_jet_index(int order_u, int order_v) {
    return (order_u + order_v) * (order_u + order_v + 1) / 2 + order_v;
}

/* Jet of f(u) g(v) from the derivatives f[0..3], g[0..3]. */
void co_jet_of_product(const double f[4], const double g[4], double jet[CO_JET]);
/* out = a b, by Leibniz' rule; out may be neither. */
void co_jet_multiply(const double a[CO_JET], const double b[CO_JET], double out[CO_JET]);

/* Uniform cubic B-splines on one segment, t in 0..1: basis[i][k] is the k-th derivative of the i-th of the four. */
void co_bspline_cubic(double t, double basis[4][4]);
/* rows[4 j + i]: jet of the basis function of control point i along u, j along v. */
void co_bspline_bicubic(double u, double v, double rows[16][CO_JET]);

#endif

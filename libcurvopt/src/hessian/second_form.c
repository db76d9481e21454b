/* How far a second fundamental form is from a wanted one. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/second_form.h"

#include <math.h>
#include <string.h>

enum { N = CO_SECOND_FORM_VALUES };

/* A number with its derivatives by the values: forward differentiation, up to `order`. */
typedef struct number {
    int order;
    double is;
    double slope[N];
    double bend[N][N];
} number;

static void set_constant(number *x, int order, double value) {
    *x = (number){.order = order, .is = value};
}

/* x += factor y */
static void add(number *x, double factor, const number *y) {
    x->is += factor * y->is;
    for (int i = 0; i < N && x->order > 0; i++)
        x->slope[i] += factor * y->slope[i];
    for (int i = 0; i < N && x->order > 1; i++)
        for (int j = 0; j < N; j++)
            x->bend[i][j] += factor * y->bend[i][j];
}

/* x += factor y z */
static void add_product(number *x, double factor, const number *y, const number *z) {
    x->is += factor * y->is * z->is;
    for (int i = 0; i < N && x->order > 0; i++)
        x->slope[i] += factor * (y->is * z->slope[i] + z->is * y->slope[i]);
    for (int i = 0; i < N && x->order > 1; i++)
        for (int j = 0; j < N; j++)
            x->bend[i][j] += factor * (y->is * z->bend[i][j] + z->is * y->bend[i][j] + y->slope[i] * z->slope[j] +
                                       z->slope[i] * y->slope[j]);
}

/* out = factor y z */
static void multiply(number *out, double factor, const number *y, const number *z) {
    set_constant(out, y->order, 0);
    add_product(out, factor, y, z);
}

/* out = y^power, whose value is given */
static void raise(number *out, const number *y, double power, double value) {
    const double first = power * value / y->is, second = (power - 1) * first / y->is;
    set_constant(out, y->order, value);
    for (int i = 0; i < N && y->order > 0; i++)
        out->slope[i] = first * y->slope[i];
    for (int i = 0; i < N && y->order > 1; i++)
        for (int j = 0; j < N; j++)
            out->bend[i][j] = first * y->bend[i][j] + second * y->slope[i] * y->slope[j];
}

static void dot(number *out, double factor, const number y[3], const number z[3]) {
    set_constant(out, y->order, 0);
    for (int c = 0; c < 3; c++)
        add_product(out, factor, &y[c], &z[c]);
}

/* out = v . y */
static void dot_constant(number *out, const double v[3], const number y[3]) {
    set_constant(out, y->order, 0);
    for (int c = 0; c < 3; c++)
        add(out, v[c], &y[c]);
}

/* What the surface is there. */
typedef struct point {
    number tangent[2][3], second[3][3]; /* T_a; S_11, S_12, S_22 */
    number over_area;                   /* 1 / |T_1 x T_2| */
    number normal[3];
} point;

static void set_point(point *p, int order, const double values[N]) {
    for (int i = 0; i < N; i++) {
        number *x = i < 6 ? &p->tangent[i / 3][i % 3] : &p->second[i / 3 - 2][i % 3];
        set_constant(x, order, values[i]);
        x->slope[i] = 1;
    }
    number across[3], square;
    for (int c = 0; c < 3; c++) {
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        multiply(&across[c], 1, &p->tangent[0][a], &p->tangent[1][b]);
        add_product(&across[c], -1, &p->tangent[0][b], &p->tangent[1][a]);
    }
    dot(&square, 1, across, across);
    raise(&p->over_area, &square, -0.5, 1 / sqrt(square.is));
    for (int c = 0; c < 3; c++)
        multiply(&p->normal[c], 1, &across[c], &p->over_area);
}

/* turned = Q T_a = T_a - (m . T_a) / (1 + m . n) (m + n), m or -m being the nearer to n. */
static void turn_tangents(const co_second_form *wanted, const point *p, number turned[2][3]) {
    number part, cosine, over, along;
    double m[3];
    dot_constant(&cosine, wanted->normal, p->normal);
    const double side = cosine.is < 0 ? -1 : 1;
    for (int c = 0; c < 3; c++)
        m[c] = side * wanted->normal[c];
    set_constant(&part, cosine.order, 1);
    add(&part, side, &cosine);
    raise(&over, &part, -1, 1 / part.is);
    for (int a = 0; a < 2; a++) {
        dot_constant(&along, m, p->tangent[a]);
        multiply(&part, 1, &along, &over);
        for (int c = 0; c < 3; c++) {
            turned[a][c] = p->tangent[a][c];
            add(&turned[a][c], -m[c], &part);
            add_product(&turned[a][c], -1, &part, &p->normal[c]);
        }
    }
}

/* Which two tangents a second derivative is by. */
static const int of_second[3][2] = {{0, 0}, {0, 1}, {1, 1}};

/* D_11, D_12, D_22 */
static void find_difference(const co_second_form *wanted, const point *p, number difference[3]) {
    number turned[2][3], form[2][3];
    turn_tangents(wanted, p, turned);
    for (int b = 0; b < 2; b++)
        for (int c = 0; c < 3; c++)
            dot_constant(&form[b][c], wanted->tensor + 3 * c, turned[b]);
    for (int k = 0; k < 3; k++) {
        dot(&difference[k], -1, p->normal, p->second[k]);
        for (int c = 0; c < 3; c++)
            add_product(&difference[k], -1, &turned[of_second[k][0]][c], &form[of_second[k][1]][c]);
    }
}

/* r with r . r = |D|^2: D of the unit vector along T_1 and of that across it; of both, times the square root of 2. */
static void find_residuals(const co_second_form *wanted, int order, const double values[N], number r[3]) {
    point p;
    number difference[3], square, over, slant, rest, part;
    set_point(&p, order, values);
    find_difference(wanted, &p, difference);
    dot(&square, 1, p.tangent[0], p.tangent[0]);
    raise(&over, &square, -1, 1 / square.is);
    dot(&part, 1, p.tangent[0], p.tangent[1]);
    multiply(&slant, 1, &part, &over); /* T_2 - slant T_1 is across T_1 */
    multiply(&r[0], 1, &difference[0], &over);
    rest = difference[1];
    add_product(&rest, -1, &slant, &difference[0]);
    multiply(&r[1], sqrt(2), &rest, &p.over_area);
    add(&rest, 1, &difference[1]);
    part = difference[2];
    add_product(&part, -1, &slant, &rest);
    multiply(&rest, 1, &part, &square);
    multiply(&part, 1, &rest, &p.over_area);
    multiply(&r[2], 1, &part, &p.over_area);
}

double co_second_form_off(const co_second_form *wanted, const double values[N], double *gradient, double *hessian,
                          int exact) {
    number r[3];
    double sum = 0;
    find_residuals(wanted, !hessian ? gradient != NULL : exact ? 2 : 1, values, r);
    if (gradient)
        memset(gradient, 0, N * sizeof *gradient);
    if (hessian)
        memset(hessian, 0, N * sizeof r->slope);
    for (int k = 0; k < 3; k++) {
        sum += r[k].is * r[k].is / 2;
        for (int i = 0; gradient && i < N; i++)
            gradient[i] += r[k].is * r[k].slope[i];
        for (int i = 0; hessian && i < N; i++)
            for (int j = 0; j < N; j++)
                hessian[N * i + j] += r[k].slope[i] * r[k].slope[j] + (exact ? r[k].is * r[k].bend[i][j] : 0);
    }
    return sum;
}

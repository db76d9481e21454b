/* Dense products, triangular solutions and Cholesky factors. Compiled once per instruction set, with CO_LANES and
 * CO_INSTRUCTION_SET set.
 *
 * All of the work of matrices is in one product, whose tile of sums stays in registers: Van Zee, van de Geijn, "BLIS: a
 * framework for rapidly instantiating BLAS functionality", ACM TOMS 41(3), 2015, on Goto, van de Geijn, "Anatomy of
 * high-performance matrix multiplication", ACM TOMS 34(3), 2008. The triangular routines halve themselves until they
 * are small: Elmroth, Gustavson, Jonsson, Kågström, "Recursive blocked algorithms and hybrid data structures for dense
 * matrix library software", SIAM Review 46(1), 2004. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/blas_routines.h"

#include "base/instruction_set.h"
#include "base/simd.h"

#include <math.h>
#include <string.h>

typedef co_blas_operand operand;

enum {
    VECTORS = 2, /* a tile of sums: 2 vectors by 6 columns, beside 2 vectors of A and an element of B; our matrices' */
    COLUMNS = 6, /* sizes are multiples of 3, mostly */
    ROWS = VECTORS * CO_LANES,
    DEPTH = 256, /* of packed blocks: a panel of A [ROWS][DEPTH] stays in the first cache */
    WIDTH = 48,  /* of a packed block of B: 96 KiB, in the second cache */
    SMALL = 12,  /* unknowns up to which triangles are not halved */
    STRIP = 16   /* rows of a solution from the right at a time */
};

static operand from(operand x, ptrdiff_t i, ptrdiff_t j) {
    return (operand){x.a + i * x.row + j * x.column, x.row, x.column};
}

static operand transpose(operand x) {
    return (operand){x.a, x.column, x.row};
}

static int least(int a, int b) {
    return a < b ? a : b;
}

/* ----------------------------------------------------------------------------------------------- products -- */

/* A part of C, at row `i` and column `j` of the whole; of a lower triangle the elements above it are left alone. */
typedef struct target {
    double *c;
    ptrdiff_t ld;
    int i, j, is_lower;
} target;

static target part_of(target x, int i, int j) {
    return (target){x.c + i + j * x.ld, x.ld, x.i + i, x.j + j, x.is_lower};
}

/* Columns of `to` whose first `rows` rows are not all above the triangle. */
static int columns_within(target to, int rows, int columns) {
    return to.is_lower ? least(columns, to.i + rows - to.j) : columns;
}

/* C [rows][columns] += alpha A B: A [k] columns of `vectors` vectors, a_column apart; B's first `width` columns, of
 * which there are as many in memory. vectors and width are constants where this is called. */
CO_SIMD_INLINE void tile(int vectors, int width, int k, double alpha, const double *a, ptrdiff_t a_column, operand b,
                         target to, int rows, int columns) {
    lane sum[COLUMNS][VECTORS];
    for (int j = 0; j < width; j++)
        for (int v = 0; v < vectors; v++)
            sum[j][v] = lane_all(0);
    for (int p = 0; p < k; p++) {
        const double *b_p = b.a + p * b.row, *a_p = a + p * a_column;
        lane x[VECTORS];
        for (int v = 0; v < vectors; v++)
            x[v] = *(const unaligned_lane *)(a_p + (ptrdiff_t)v * CO_LANES);
        for (int j = 0; j < width; j++)
            for (int v = 0; v < vectors; v++)
                sum[j][v] += x[v] * b_p[j * b.column];
    }
    if (rows == vectors * CO_LANES && columns == width && (!to.is_lower || to.i >= to.j + columns - 1)) {
        for (int j = 0; j < width; j++)
            for (int v = 0; v < vectors; v++) {
                unaligned_lane *at = (unaligned_lane *)(to.c + j * to.ld + (ptrdiff_t)v * CO_LANES);
                *at += alpha * sum[j][v];
            }
        return;
    }
    for (int j = 0; j < columns; j++) {
        const int above = to.is_lower ? to.j + j - to.i : 0;
        double column[ROWS];
        memcpy(column, sum[j], sizeof(lane) * (size_t)vectors);
        for (int i = above > 0 ? above : 0; i < rows; i++)
            to.c[i + j * to.ld] += alpha * column[i];
    }
}

/* Panels of A and B that tiles are made of. Their rows and columns are those of C, up to ROWS and COLUMNS; B may be
 * read up to the next multiple of 3 columns, A up to the next multiple of CO_LANES rows. */
static void run_tile(int k, double alpha, const double *a, ptrdiff_t a_column, operand b, target to, int rows,
                     int columns) {
    if (rows > CO_LANES && columns > 3)
        tile(2, 6, k, alpha, a, a_column, b, to, rows, columns);
    else if (rows > CO_LANES)
        tile(2, 3, k, alpha, a, a_column, b, to, rows, columns);
    else if (columns > 3)
        tile(1, 6, k, alpha, a, a_column, b, to, rows, columns);
    else
        tile(1, 3, k, alpha, a, a_column, b, to, rows, columns);
}

/* Up to `width` rows of X [m][k], zeros after the last: to [k][width]. width is a constant where this is called. */
CO_SIMD_INLINE void pack(operand x, int m, int k, int width, double *to) {
    if (m == width && x.row == 1) {
        for (int p = 0; p < k; p++)
            memcpy(to + p * width, x.a + p * x.column, sizeof *to * (size_t)width);
        return;
    }
    for (int p = 0; p < k; p++)
        for (int r = 0; r < width; r++)
            to[p * width + r] = r < m ? x.a[r * x.row + p * x.column] : 0;
}

/* One panel of rows of C, [rows][n], k <= DEPTH. is_packed: B is [n / COLUMNS][k][COLUMNS]. */
static void multiply_rows(int rows, int n, int k, double alpha, operand a, operand b, int is_packed, target to) {
    double packed_a[ROWS * DEPTH], packed_b[COLUMNS * DEPTH];
    const double *panel = a.a;
    ptrdiff_t a_column = a.column;
    n = columns_within(to, rows, n);
    if (a.row != 1 || rows % CO_LANES || n > 4 * COLUMNS) {
        pack(a, rows, k, ROWS, packed_a);
        panel = packed_a;
        a_column = ROWS;
    }
    for (int j = 0; j < n; j += COLUMNS) {
        const int columns = least(n - j, COLUMNS);
        operand right = is_packed ? (operand){b.a + (ptrdiff_t)j * k, COLUMNS, 1} : from(b, 0, j);
        if (!is_packed && columns % 3) {
            pack(transpose(right), columns, k, COLUMNS, packed_b);
            right = (operand){packed_b, COLUMNS, 1};
        }
        run_tile(k, alpha, panel, a_column, right, part_of(to, 0, j), rows, columns);
    }
}

/* k <= DEPTH and n <= WIDTH; B is used often enough to be packed. */
static __attribute__((noinline)) void multiply_block(int m, int n, int k, double alpha, operand a, operand b,
                                                     target to) {
    double packed[WIDTH * DEPTH];
    for (int j = 0; j < n; j += COLUMNS)
        pack(transpose(from(b, 0, j)), least(n - j, COLUMNS), k, COLUMNS, packed + (ptrdiff_t)j * k);
    for (int i = to.is_lower ? to.j / ROWS * ROWS : 0; i < m; i += ROWS)
        multiply_rows(least(m - i, ROWS), n, k, alpha, from(a, i, 0), (operand){packed, 0, 0}, 1, part_of(to, i, 0));
}

static void multiply(int m, int n, int k, double alpha, operand a, operand b, target to) {
    for (int p = 0; p < k; p += DEPTH) {
        const int depth = least(k - p, DEPTH);
        if (m <= 2 * ROWS) {
            for (int i = 0; i < m; i += ROWS)
                multiply_rows(least(m - i, ROWS), n, depth, alpha, from(a, i, p), from(b, p, 0), 0, part_of(to, i, 0));
            continue;
        }
        for (int j = 0; j < n; j += WIDTH)
            multiply_block(m, least(n - j, WIDTH), depth, alpha, from(a, 0, p), from(b, p, j), part_of(to, 0, j));
    }
}

static void multiply_add(int m, int n, int k, double alpha, operand a, operand b, double *c, ptrdiff_t ld) {
    multiply(m, n, k, alpha, a, b, (target){.c = c, .ld = ld});
}

static void multiply_add_lower(int n, int k, double alpha, operand a, operand b, double *c, ptrdiff_t ld) {
    multiply(n, n, k, alpha, a, b, (target){.c = c, .ld = ld, .is_lower = 1});
}

/* ----------------------------------------------------------------------------------------------- vectors -- */

/* A sum of products: sixteen sums, then these one after the other. */
static double dot(int n, const double *x, const double *y) {
    enum { SUMS = 16 };
    lane sum[SUMS / CO_LANES];
    double total = 0;
    int i = 0;
    for (int k = 0; k < SUMS / CO_LANES; k++)
        sum[k] = lane_all(0);
    for (; i + SUMS <= n; i += SUMS)
        for (int k = 0; k < SUMS / CO_LANES; k++)
            sum[k] += *(const unaligned_lane *)(x + i + (ptrdiff_t)k * CO_LANES) *
                      *(const unaligned_lane *)(y + i + (ptrdiff_t)k * CO_LANES);
    for (int k = 0; k < SUMS; k++)
        total += sum[k / CO_LANES][k % CO_LANES];
    for (; i < n; i++)
        total += x[i] * y[i];
    return total;
}

static void multiply_vector(int transposed, int m, int n, double alpha, const double *restrict a, ptrdiff_t ld,
                            const double *restrict x, double *restrict y) {
    int j = 0;
    for (; !transposed && j + 4 <= n; j += 4) {
        const double *column = a + j * ld, *x_j = x + j;
        const double by[4] = {alpha * x_j[0], alpha * x_j[1], alpha * x_j[2], alpha * x_j[3]};
        for (int i = 0; i < m; i++) {
            double sum = y[i];
            for (int k = 0; k < 4; k++)
                sum += by[k] * column[i + k * ld];
            y[i] = sum;
        }
    }
    for (; j < n; j++)
        if (transposed) {
            y[j] += alpha * dot(m, a + j * ld, x);
        } else {
            const double by = alpha * x[j];
            for (int i = 0; i < m; i++)
                y[i] += by * a[i + j * ld];
        }
}

static void solve_vector(int transposed, int n, const double *l, ptrdiff_t ld, double *x) {
    const int half = n / 2;
    if (n > SMALL) {
        const double *below = l + half, *last = l + half + half * ld;
        solve_vector(transposed, transposed ? n - half : half, transposed ? last : l, ld, transposed ? x + half : x);
        if (transposed)
            multiply_vector(1, n - half, half, -1, below, ld, x + half, x);
        else
            multiply_vector(0, n - half, half, -1, below, ld, x, x + half);
        solve_vector(transposed, transposed ? half : n - half, transposed ? l : last, ld, transposed ? x : x + half);
    } else if (transposed) {
        for (int j = n - 1; j >= 0; j--) {
            for (int i = j + 1; i < n; i++)
                x[j] -= l[i + j * ld] * x[i];
            x[j] /= l[j + j * ld];
        }
    } else {
        for (int j = 0; j < n; j++) {
            x[j] /= l[j + j * ld];
            for (int i = j + 1; i < n; i++)
                x[i] -= l[i + j * ld] * x[j];
        }
    }
}

/* ---------------------------------------------------------------------------------------------- triangles -- */

static void solve_left(int transposed, int n, int m, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    const int half = n / 2;
    if (n <= SMALL) {
        for (int j = 0; j < m; j++)
            solve_vector(transposed, n, l, ld, b + j * ldb);
        return;
    }
    const double *below = l + half, *last = l + half + half * ld;
    if (transposed) {
        solve_left(1, n - half, m, last, ld, b + half, ldb);
        multiply_add(half, m, n - half, -1, (operand){below, ld, 1}, (operand){b + half, 1, ldb}, b, ldb);
        solve_left(1, half, m, l, ld, b, ldb);
    } else {
        solve_left(0, half, m, l, ld, b, ldb);
        multiply_add(n - half, m, half, -1, (operand){below, 1, ld}, (operand){b, 1, ldb}, b + half, ldb);
        solve_left(0, n - half, m, last, ld, b + half, ldb);
    }
}

/* B [STRIP][n] := B L^-T for n <= SMALL */
static void solve_strip(int n, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    for (int j = 0; j < n; j++) {
        const lane inverse = lane_all(1 / l[j + j * ld]);
        lane at[STRIP / CO_LANES];
        for (int v = 0; v < STRIP / CO_LANES; v++)
            at[v] = *(const unaligned_lane *)(b + v * CO_LANES + j * ldb);
        for (int p = 0; p < j; p++)
            for (int v = 0; v < STRIP / CO_LANES; v++)
                at[v] -= l[j + p * ld] * *(const unaligned_lane *)(b + v * CO_LANES + p * ldb);
        for (int v = 0; v < STRIP / CO_LANES; v++)
            *(unaligned_lane *)(b + v * CO_LANES + j * ldb) = at[v] * inverse;
    }
}

/* The same for one row. */
static void solve_row(int n, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    for (int j = 0; j < n; j++) {
        double at = b[j * ldb];
        for (int p = 0; p < j; p++)
            at -= l[j + p * ld] * b[p * ldb];
        b[j * ldb] = at * (1 / l[j + j * ld]);
    }
}

static void solve_right(int m, int n, const double *l, ptrdiff_t ld, double *b, ptrdiff_t ldb) {
    if (n <= SMALL) {
        int i = 0;
        for (; i + STRIP <= m; i += STRIP)
            solve_strip(n, l, ld, b + i, ldb);
        for (; i < m; i++)
            solve_row(n, l, ld, b + i, ldb);
        return;
    }
    const int half = (n / 2 + 2) / 3 * 3;
    solve_right(m, half, l, ld, b, ldb);
    multiply_add(m, n - half, half, -1, (operand){b, 1, ldb}, (operand){l + half, ld, 1}, b + half * ldb, ldb);
    solve_right(m, n - half, l + half + half * ld, ld, b + half * ldb, ldb);
}

static int factor(int n, double *a, ptrdiff_t ld) {
    const int half = (n / 2 + 2) / 3 * 3;
    if (n > SMALL) {
        double *below = a + half, *last = a + half + half * ld;
        int failed = factor(half, a, ld);
        if (failed)
            return failed;
        solve_right(n - half, half, a, ld, below, ld);
        multiply_add_lower(n - half, half, -1, (operand){below, 1, ld}, (operand){below, ld, 1}, last, ld);
        failed = factor(n - half, last, ld);
        return failed ? failed + half : 0;
    }
    for (int j = 0; j < n; j++) {
        if (!(a[j + j * ld] > 0))
            return j + 1;
        const double pivot = sqrt(a[j + j * ld]), inverse = 1 / pivot;
        a[j + j * ld] = pivot;
        for (int i = j + 1; i < n; i++)
            a[i + j * ld] *= inverse;
        for (int k = j + 1; k < n; k++)
            for (int i = k; i < n; i++)
                a[i + k * ld] -= a[i + j * ld] * a[k + j * ld];
    }
    return 0;
}

const co_blas_routines CO_NAME_OF_SET(co_blas_routines) = {.multiply_add = multiply_add,
                                                           .multiply_add_lower = multiply_add_lower,
                                                           .solve_left = solve_left,
                                                           .solve_right = solve_right,
                                                           .factor = factor,
                                                           .multiply_vector = multiply_vector,
                                                           .solve_vector = solve_vector};

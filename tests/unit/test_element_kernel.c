/* One element kernel, several instruction sets, the same results. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/memory.h"
#include "check.h"
#include "energy/element_kernel.h"
#include "surface/basis_table_cache.h"
#include "surface/stam.h"

#include <stdlib.h>

enum { N_FACES = 11, MOST_POINTS = 31 };

static const char *const names[] = {"portable", "avx2", "avx512"};
enum { N_KERNELS = sizeof names / sizeof *names };

/* Faces of one kind, each with points of its own; face number N_FACES has NAN for points. */
typedef struct faces {
    co_basis_table *table;
    double eps4;
    double xyz[(N_FACES + 1) * MOST_POINTS * 3];
} faces;

typedef struct results {
    double sums[N_FACES][CO_N_SUMS];
    double gradients[N_FACES][MOST_POINTS][2][3];
} results;

static void make_faces(int32_t surface, int32_t valence, int32_t rule, faces *out) {
    curvopt_error error;
    co_stam_disc disc;
    double xy[2 * (6 * 8 + 1)];
    uint64_t seed = 4711;
    CHECK_OK(co_basis_table_create(surface, valence, rule, &out->table, &error), &error);
    out->eps4 = 1e-6;
    CHECK_OK(co_stam_disc_create(valence, &disc, &error), &error);
    co_stam_characteristic_map(&disc, xy);
    co_stam_disc_free(&disc);
    int32_t n = out->table->n_points;
    CHECK_TRUE(n <= MOST_POINTS);
    for (int32_t f = 0; f <= N_FACES; f++)
        for (int32_t p = 0; p < n; p++) {
            double *x = out->xyz + 3 * (f * n + p), at[2];
            int32_t point = out->table->support[p];
            at[0] = valence == 4 ? point % 4 : (double)xy[2 * point];
            at[1] = valence == 4 ? point / 4 : (double)xy[2 * point + 1];
            x[0] = 50 + at[0] + 0.1 * check_random(&seed);
            x[1] = -20 + at[1] + 0.1 * check_random(&seed);
            x[2] = 0.3 * at[0] * at[0] - 0.1 * at[1] * at[1] + 0.1 * check_random(&seed);
            for (int c = 0; c < 3 && f == N_FACES; c++)
                x[c] = (double)NAN;
        }
}

/* All faces through one kernel: energies up to third order or not, or area and volume alone, if `order` is 3, 2 or 1.
 * n_gradients: none, the energy's, or the area's, too. Lanes left over take the block's first face, or the one of
 * NANs. */
static void run_order(const co_element_kernel *kernel, const faces *in, int order, int n_gradients, int bad_padding,
                      results *out) {
    const int32_t n = in->table->n_points;
    const size_t lanes = (size_t)kernel->lanes, work_size = sizeof(double) * 9 * (size_t)n * lanes;
    int32_t points[MOST_POINTS * CO_BLOCK_FACES];
    double sums[CO_N_SUMS * CO_BLOCK_FACES], gradients[MOST_POINTS * 6 * CO_BLOCK_FACES];
    double *work = co_memory_aligned(work_size, 1);
    CHECK_TRUE(work != NULL);
    memset(out, 0, sizeof *out);
    for (int32_t first = 0; first < N_FACES; first += CO_BLOCK_FACES) {
        const int32_t n_used = N_FACES - first < CO_BLOCK_FACES ? N_FACES - first : CO_BLOCK_FACES;
        for (int32_t l = 0; l < CO_BLOCK_FACES; l++) {
            int32_t f = l < n_used ? first + l : bad_padding ? N_FACES : first;
            for (int32_t p = 0; p < n; p++)
                points[co_lane_place((size_t)l, (size_t)n, lanes) + (size_t)p * lanes] = f * n + p;
        }
        co_element_block block = {
            .table = in->table,
            .n_used = n_used,
            .points = points,
            .xyz = in->xyz,
            .eps4 = in->eps4,
            .integrand = {.area = 0.2, .h2 = 0.3, .f1 = 0.5, .f3 = 0.7, .x = 0.4, .mean = 0.1, .volume = 0.05},
            .third = order == 3,
            .first_order = order == 1,
            .volume = 1,
            .jump = 1,
            .gradient = n_gradients > 0,
            .area_gradient = n_gradients > 1,
            .sums = sums,
            .gradients = gradients,
            .work = work};
        kernel->run(&block);
        for (int32_t l = 0; l < n_used; l++) {
            const double *sum = sums + co_lane_place((size_t)l, CO_N_SUMS, lanes);
            const size_t own = 3 * (size_t)n_gradients; /* numbers of a point */
            const double *gradient = gradients + co_lane_place((size_t)l, own * (size_t)n, lanes);
            for (size_t i = 0; i < CO_N_SUMS; i++)
                out->sums[first + l][i] = sum[i * lanes];
            for (size_t i = 0; i < own * (size_t)n; i++)
                out->gradients[first + l][i / own][i % own / 3][i % 3] = gradient[i * lanes];
        }
    }
    free(work);
}

static void run(const co_element_kernel *kernel, const faces *in, int third, int bad_padding, results *out) {
    run_order(kernel, in, third ? 3 : 2, 2, bad_padding, out);
}

static double largest(const double *x, int n) {
    double most = 0;
    for (int i = 0; i < n; i++) {
        CHECK_TRUE(isfinite(x[i]));
        most = fmax(most, fabs(x[i]));
    }
    return most;
}

static void check_same(const results *a, const results *b) {
    for (int f = 0; f < N_FACES; f++) {
        CHECK_TRUE(b->sums[f][CO_INT_AREA] > 0.05);
        for (int i = 0; i < CO_N_SUMS; i++)
            CHECK_TRUE(a->sums[f][i] == b->sums[f][i]);
        for (int i = 0; i < MOST_POINTS * 6; i++)
            CHECK_TRUE((&a->gradients[f][0][0][0])[i] == (&b->gradients[f][0][0][0])[i]);
    }
}

typedef struct kind {
    int32_t surface, valence, rule;
    int third;
} kind;

static const kind kinds[] = {{CURVOPT_SURFACE_LIMIT, 4, 1, 1}, {CURVOPT_SURFACE_LIMIT, 4, 0, 0},
                             {CURVOPT_SURFACE_LIMIT, 5, 0, 0}, {CURVOPT_SURFACE_PLANE, 3, 0, 1},
                             {CURVOPT_SURFACE_PLANE, 7, 0, 1}, {CURVOPT_SURFACE_POLYNOMIAL, 5, 0, 1}};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

static void check_kernels(const faces *in, int order) {
    static results portable, other;
    const int n_gradients = order > 1 ? 2 : 1;
    run_order(co_element_kernel_select("portable"), in, order, n_gradients, 0, &portable);
    for (int i = 0; i < N_KERNELS; i++) {
        const co_element_kernel *kernel = co_element_kernel_select(names[i]);
        if (!kernel) /* this processor has not got it */
            continue;
        assert_string_equal(kernel->name, names[i]);
        run_order(kernel, in, order, n_gradients, 0, &other);
        check_same(&other, &portable);
    }
}

static void test_all_kernels_have_the_same_bits(void **state) {
    (void)state;
    static faces in;
    for (int k = 0; k < N_KINDS; k++) {
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        check_kernels(&in, 1);
        check_kernels(&in, kinds[k].third ? 3 : 2);
        co_basis_table_destroy(in.table);
    }
}

static void check_strips(const results *strips, const results *samples, int n_gradients) {
    for (int f = 0; f < N_FACES; f++) {
        const double *of_strips = &strips->gradients[f][0][0][0], *of_samples = &samples->gradients[f][0][0][0];
        const double most = largest(of_samples, MOST_POINTS * 6);
        CHECK_TRUE((most > 0) == (n_gradients > 0) && samples->sums[f][CO_INT_AREA] > 0.05);
        for (int i = 0; i < CO_N_SUMS; i++)
            CHECK_NEAR(strips->sums[f][i], samples->sums[f][i], 1e-12 * (1 + fabs(samples->sums[f][i])));
        for (int i = 0; i < MOST_POINTS * 6; i++)
            CHECK_NEAR(of_strips[i], of_samples[i], 1e-12 * most);
    }
}

/* On regular faces: a strip after the other, or each sample with its own sixteen points. */
static void test_strips_are_the_samples_by_themselves(void **state) {
    static const int32_t rules[] = {0, 1, 3, 5}; /* the last one has sub-cells */
    static faces in, by_itself;
    static results strips, samples;
    (void)state;
    for (size_t k = 0; k < 3 * sizeof rules / sizeof *rules; k++) {
        const int order = 1 + (int)k % 3;
        make_faces(CURVOPT_SURFACE_LIMIT, 4, rules[k / 3], &in);
        co_basis_table table = *in.table;
        CHECK_TRUE(table.side && table.n_side * table.n_side == table.n_samples);
        table.side = NULL;
        by_itself = in;
        by_itself.table = &table;
        for (int n_gradients = 0; n_gradients <= (order > 1 ? 2 : 1); n_gradients++) {
            run_order(co_element_kernel_select(NULL), &in, order, n_gradients, 0, &strips);
            run_order(co_element_kernel_select(NULL), &by_itself, order, n_gradients, 0, &samples);
            check_strips(&strips, &samples, n_gradients);
        }
        co_basis_table_destroy(in.table);
    }
}

enum { MOST_ENTRIES = 3 * MOST_POINTS * (3 * MOST_POINTS + 1) / 2 };

/* Matrices of all faces: the Hessian or the Gauss-Newton matrix, after a step from `before` unless that is NULL. */
static void run_second(const co_element_kernel *kernel, const faces *in, int third, int exact, const double *before,
                       double (*out)[MOST_ENTRIES]) {
    const int32_t n = in->table->n_points;
    const size_t lanes = (size_t)kernel->lanes, entries = co_element_hessian_size(n);
    int32_t points[MOST_POINTS * CO_BLOCK_FACES];
    const size_t work_size = sizeof(double) * co_element_hessian_work(n) * lanes;
    const size_t matrix_size = sizeof(double) * entries * CO_BLOCK_FACES;
    double *work = co_memory_aligned(work_size, 1), *matrix = co_memory_aligned(matrix_size, 1);
    CHECK_TRUE(work && matrix);
    for (int32_t first = 0; first < N_FACES; first += CO_BLOCK_FACES) {
        const int32_t n_used = N_FACES - first < CO_BLOCK_FACES ? N_FACES - first : CO_BLOCK_FACES;
        for (int32_t l = 0; l < CO_BLOCK_FACES; l++)
            for (int32_t p = 0; p < n; p++)
                points[co_lane_place((size_t)l, (size_t)n, lanes) + (size_t)p * lanes] =
                    (l < n_used ? first + l : first) * n + p;
        co_element_hessian block = {.table = in->table,
                                    .n_used = n_used,
                                    .points = points,
                                    .xyz = in->xyz,
                                    .before = before,
                                    .eps4 = in->eps4,
                                    .integrand = {.area = 0.2,
                                                  .h2 = 0.3,
                                                  .f1 = 0.5,
                                                  .f3 = 0.7,
                                                  .x = 0.4,
                                                  .mean = exact ? 0.1 : 0,
                                                  .volume = exact ? 0.05 : 0},
                                    .third = third,
                                    .exact = exact,
                                    .matrix = matrix,
                                    .work = work};
        kernel->run_second(&block);
        for (int32_t l = 0; l < n_used; l++)
            for (size_t e = 0; e < entries; e++)
                out[first + l][e] = matrix[co_lane_place((size_t)l, entries, lanes) + e * lanes];
    }
    free(work);
    free(matrix);
}

static void test_second_derivatives_of_all_kernels_have_the_same_bits(void **state) {
    (void)state;
    static faces in, moved;
    static double portable[N_FACES][MOST_ENTRIES], other[N_FACES][MOST_ENTRIES];
    for (int k = 0; k < N_KINDS; k++) {
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        uint64_t seed = 5;
        for (size_t i = 0; i < sizeof in.xyz / sizeof *in.xyz; i++)
            moved.xyz[i] = in.xyz[i] + 1e-3 * check_random(&seed);
        for (int way = 0; way < 3; way++) { /* Gauss-Newton, Hessian, lifted Hessian */
            const double *before = way == 2 ? moved.xyz : NULL;
            int32_t n = 3 * in.table->n_points;
            run_second(co_element_kernel_select("portable"), &in, kinds[k].third, way > 0, before, portable);
            for (int i = 0; i < N_KERNELS; i++) {
                const co_element_kernel *kernel = co_element_kernel_select(names[i]);
                if (!kernel)
                    continue;
                run_second(kernel, &in, kinds[k].third, way > 0, before, other);
                for (int f = 0; f < N_FACES; f++) {
                    CHECK_TRUE(largest(portable[f], n * (n + 1) / 2) > 0);
                    for (int32_t e = 0; e < n * (n + 1) / 2; e++)
                        CHECK_TRUE(other[f][e] == portable[f][e]);
                    for (int32_t j = 0; way == 0 && j < n; j++)
                        CHECK_TRUE(portable[f][j * (j + 1) / 2 + j] >= 0);
                }
            }
        }
        co_basis_table_destroy(in.table);
    }
}

/* Gradients of all faces' integrals of the integrand that run_second() has, at the points moved by h along `along`. */
static void run_moved(const faces *in, int third, const double *along, double h, results *out) {
    static faces moved;
    moved = *in;
    for (size_t i = 0; i < sizeof moved.xyz / sizeof *moved.xyz; i++)
        moved.xyz[i] += h * along[i];
    run(co_element_kernel_select(NULL), &moved, third, 0, out);
}

/* Times a vector, the Hessian is the slope of the gradient. Central differences with steps h and 2 h leave h^4. */
static void test_hessian_is_the_slope_of_the_gradient(void **state) {
    (void)state;
    static faces in;
    static results at[4];
    static double matrix[N_FACES][MOST_ENTRIES], along[(N_FACES + 1) * MOST_POINTS * 3];
    const double h = 2e-4, steps[4] = {-2 * h, -h, h, 2 * h},
                 weight[4] = {1 / (12 * h), -8 / (12 * h), 8 / (12 * h), -1 / (12 * h)};
    uint64_t seed = 12;
    for (size_t i = 0; i < sizeof along / sizeof *along; i++)
        along[i] = check_random(&seed) - 0.5;
    for (int k = 0; k < N_KINDS; k++) {
        if (kinds[k].surface == CURVOPT_SURFACE_PLANE) /* which has the Gauss-Newton matrix */
            continue;
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        int32_t n = in.table->n_points;
        run_second(co_element_kernel_select(NULL), &in, kinds[k].third, 1, NULL, matrix);
        for (int i = 0; i < 4; i++)
            run_moved(&in, kinds[k].third, along, steps[i], &at[i]);
        for (int f = 0; f < N_FACES; f++) {
            double scale = largest(matrix[f], 3 * n * (3 * n + 1) / 2);
            for (int32_t i = 0; i < 3 * n; i++) {
                double slope = 0, product = 0;
                for (int s = 0; s < 4; s++)
                    slope += weight[s] * at[s].gradients[f][i / 3][0][i % 3];
                for (int32_t j = 0; j < 3 * n; j++)
                    product += matrix[f][i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i] * along[3 * f * n + j];
                CHECK_NEAR(product, slope, 2e-10 * scale);
            }
        }
        co_basis_table_destroy(in.table);
    }
}

/* Residuals of second order do not change with the size of a face, those of third order are as its inverse (but for
 * eps4). So their slopes along the positions are 0 and -r (Euler), and x M x is twice the sum of the latters' squares,
 * which is the integrand. */
static void test_gauss_newton_residuals_add_up_to_the_integrand(void **state) {
    (void)state;
    static faces in;
    static results at;
    static double matrix[N_FACES][MOST_ENTRIES];
    for (int k = 0; k < N_KINDS; k++) {
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        const int32_t n = 3 * in.table->n_points;
        in.eps4 = 1e-12;
        run_second(co_element_kernel_select(NULL), &in, kinds[k].third, 0, NULL, matrix);
        run(co_element_kernel_select(NULL), &in, kinds[k].third, 0, &at);
        for (int f = 0; f < N_FACES; f++) {
            const double *sum = at.sums[f], *x = in.xyz + n * f;
            const double third = kinds[k].third ? 0.5 * sum[CO_INT_F1] + 0.7 * sum[CO_INT_F3] + 0.4 * sum[CO_INT_X] : 0;
            double product = 0, centred[3 * MOST_POINTS];
            for (int32_t i = 0; i < n; i++)
                centred[i] = x[i] - (i % 3 == 0   ? 50
                                     : i % 3 == 1 ? -20
                                                  : 0); /* a motion of the whole changes nothing */
            for (int32_t i = 0; i < n; i++)
                for (int32_t j = 0; j < n; j++)
                    product += centred[i] * centred[j] * matrix[f][i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i];
            CHECK_NEAR(product, 2 * third, 1e-2 * third + 1e-9 * largest(matrix[f], n * (n + 1) / 2));
        }
        co_basis_table_destroy(in.table);
    }
}

static void test_padding_lanes_do_not_matter(void **state) {
    (void)state;
    static faces in;
    static results good, bad;
    for (int k = 0; k < N_KINDS; k++) {
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        for (int i = 0; i < N_KERNELS; i++) {
            const co_element_kernel *kernel = co_element_kernel_select(names[i]);
            if (!kernel)
                continue;
            CHECK_TRUE(N_FACES % kernel->lanes != 0); /* so that there is padding */
            run(kernel, &in, kinds[k].third, 0, &good);
            run(kernel, &in, kinds[k].third, 1, &bad);
            check_same(&bad, &good);
        }
        co_basis_table_destroy(in.table);
    }
}

static void test_gradient_is_the_slope_of_the_sums(void **state) {
    (void)state;
    static faces in;
    static results at, plus, minus;
    const double h = 1e-4;
    for (int k = 0; k < N_KINDS; k++) {
        make_faces(kinds[k].surface, kinds[k].valence, kinds[k].rule, &in);
        run(co_element_kernel_select(NULL), &in, kinds[k].third, 0, &at);
        for (int i = 0; i < 9; i++) {
            int32_t point = i * 7 % in.table->n_points;
            double scale = largest(&at.gradients[3][0][0][0], MOST_POINTS * 6);
            double *x = &in.xyz[3 * (3 * in.table->n_points + point) + i % 3], slope[2] = {0, 0};
            static const double weight[CO_N_SUMS] = {
                [CO_INT_AREA] = 0.2, [CO_INT_H2] = 0.3,   [CO_INT_F1] = 0.5,     [CO_INT_F3] = 0.7,
                [CO_INT_X] = 0.4,    [CO_INT_MEAN] = 0.1, [CO_INT_VOLUME] = 0.05};
            *x += h;
            run(co_element_kernel_select(NULL), &in, kinds[k].third, 0, &plus);
            *x -= 2 * h;
            run(co_element_kernel_select(NULL), &in, kinds[k].third, 0, &minus);
            *x += h;
            for (int s = 0; s < CO_N_INTEGRALS; s++)
                slope[0] += weight[s] * (plus.sums[3][s] - minus.sums[3][s]) / (2 * h);
            slope[1] = (plus.sums[3][CO_INT_AREA] - minus.sums[3][CO_INT_AREA]) / (2 * h);
            for (int g = 0; g < 2; g++)
                CHECK_NEAR(at.gradients[3][point][g][i % 3], slope[g], 1e-5 * scale);
        }
        co_basis_table_destroy(in.table);
    }
}

/* A cubic over the plane: h and q are linear, and C is constant, to the square of its height. q is 0 at (x, y) alone.
 */
static const double height = 1e-5;

typedef struct cubic {
    double x, y; /* X, Y: from there */
    double s, t; /* z = X^3 / 6 + s X Y^2 / 2 + t Y^3 / 6 */
    double eps;  /* over the height */
} cubic;

/* Control points of a regular patch of uniform cubic B-splines, which have polynomials exactly. */
static void put_cubic(const cubic *c, const co_basis_table *t, double *xyz) {
    for (int32_t p = 0; p < t->n_points; p++) {
        const double i = t->support[p] % 4 - 1, j = t->support[p] / 4 - 1, X = i - c->x, Y = j - c->y;
        xyz[3 * p] = i;
        xyz[3 * p + 1] = j;
        xyz[3 * p + 2] = height * ((X * X * X - X) / 6 + c->s * X * (Y * Y - 1.0 / 3) / 2 + c->t * (Y * Y * Y - Y) / 6);
    }
}

/* The jump by its definition, d the distance from where q is 0. */
static double jump_of_cubic(const cubic *c, const co_basis_table *t, const double *xyz) {
    const double A1 = 0.75 * (1 + c->s), B1 = 0.75 * c->t, A3 = 0.25 - 0.75 * c->s, B3 = -0.25 * c->t;
    const double f1 = A1 * A1 + B1 * B1, f3 = A3 * A3 + B3 * B3, g = f1 / 9 + f3;
    double sum = 0;
    for (int32_t i = 0; i < t->n_samples; i++) {
        double at[2] = {-c->x, -c->y}, w = t->weight[i];
        for (int32_t p = 0; p < t->n_points; p++)
            for (int k = 0; k < 2; k++)
                at[k] += t->rows[(i * t->n_points + p) * CO_JET] * xyz[3 * p + k];
        const double re = ((1 - c->s) * at[0] - c->t * at[1]) / 2, im = c->s * at[1];
        const double d2 = at[0] * at[0] + at[1] * at[1], q2 = re * re + im * im;
        sum += w * sqrt(f1 * f3) / (1 + (q2 * q2 + pow(c->eps, 4)) / (g * g * w * w)) / (1 + d2 * d2 / (w * w));
    }
    return height * height * sum;
}

/* Sum of a kernel over the first of its lanes. */
static double jump_by(const co_element_kernel *kernel, const co_basis_table *t, const double *xyz, double eps, int jump,
                      int gradient) {
    const size_t lanes = (size_t)kernel->lanes, n = (size_t)t->n_points;
    double sums[CO_N_SUMS * CO_BLOCK_FACES], gradients[MOST_POINTS * 3 * CO_BLOCK_FACES];
    double *work = co_memory_aligned(sizeof(double) * 9 * n * lanes, 1);
    int32_t points[MOST_POINTS * CO_BLOCK_FACES];
    CHECK_TRUE(work != NULL);
    for (size_t i = 0; i < n * CO_BLOCK_FACES; i++)
        points[i] = (int32_t)(i / lanes % n);
    kernel->run(&(co_element_block){.table = t,
                                    .n_used = 1,
                                    .points = points,
                                    .xyz = xyz,
                                    .eps4 = pow(height * eps, 4),
                                    .integrand = {.x = 1},
                                    .third = 1,
                                    .jump = jump,
                                    .gradient = gradient,
                                    .sums = sums,
                                    .gradients = gradients,
                                    .work = work});
    free(work);
    return sums[CO_SUM_JUMP * lanes];
}

/* Where q is 0 within the face, X jumps by what a cell there weighs, unless eps smooths it; where that is far away, it
 * does not. */
static void test_jumps_at_umbilics_are_their_definition(void **state) {
    (void)state;
    static const cubic cubics[] = {{.x = 0.37, .y = 0.6, .s = 0.7, .t = -0.4},
                                   {.x = 0.8, .y = 0.1, .s = -1.5, .t = 0.3},
                                   {.x = 0.37, .y = 0.6, .s = 0.7, .t = -0.4, .eps = 0.3},
                                   {.x = 3.4, .y = -2, .s = 0.7, .t = -0.4}};
    curvopt_error error;
    co_basis_table *t;
    double inside = 0;
    CHECK_OK(co_basis_table_create(CURVOPT_SURFACE_LIMIT, 4, 2, &t, &error), &error);
    for (int k = 0; k < 4; k++) {
        double xyz[3 * MOST_POINTS];
        put_cubic(&cubics[k], t, xyz);
        const double wanted = jump_of_cubic(&cubics[k], t, xyz);
        for (int i = 0; i < N_KERNELS; i++) {
            const co_element_kernel *kernel = co_element_kernel_select(names[i]);
            if (!kernel)
                continue;
            CHECK_NEAR(jump_by(kernel, t, xyz, cubics[k].eps, 1, 0), wanted, 1e-6 * wanted);
            CHECK_NEAR(jump_by(kernel, t, xyz, cubics[k].eps, 1, 1), wanted, 1e-6 * wanted);
            CHECK_NEAR(jump_by(kernel, t, xyz, cubics[k].eps, 0, 0), 0, 0);
        }
        if (k == 0)
            inside = wanted;
        else if (k > 1)
            CHECK_TRUE(wanted < 0.1 * inside);
    }
    co_basis_table_destroy(t);
}

static void test_unknown_kernel_is_not_found(void **state) {
    (void)state;
    CHECK_TRUE(co_element_kernel_select("abacus") == NULL);
    CHECK_TRUE(co_element_kernel_select("portable") != NULL);
    CHECK_TRUE(co_element_kernel_select(NULL) != NULL);
    CHECK_BETWEEN(co_element_kernel_select(NULL)->lanes, 1, CO_BLOCK_FACES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_kernels_have_the_same_bits),
        cmocka_unit_test(test_strips_are_the_samples_by_themselves),
        cmocka_unit_test(test_second_derivatives_of_all_kernels_have_the_same_bits),
        cmocka_unit_test(test_hessian_is_the_slope_of_the_gradient),
        cmocka_unit_test(test_gauss_newton_residuals_add_up_to_the_integrand),
        cmocka_unit_test(test_padding_lanes_do_not_matter),
        cmocka_unit_test(test_gradient_is_the_slope_of_the_sums),
        cmocka_unit_test(test_jumps_at_umbilics_are_their_definition),
        cmocka_unit_test(test_unknown_kernel_is_not_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

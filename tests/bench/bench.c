/* What the library costs, as JSON on standard output; run.py makes tables of it.
 *
 *   curvopt_bench [--quick] [--largest FACES]
 *
 * Every figure is the least of several runs, a kernel's between two measurements of the peak: what else the machine
 * does makes times longer, never shorter. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 199309L /* NOLINT: for clock_gettime */
#include "cages.h"
#include "peak.h"

#include "base/memory.h"
#include "hessian/newton_system.h"
#include "mesh/similarity.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int flops_forward(int third);
int flops_adjoint(int third);

typedef struct settings {
    double seconds; /* for each figure */
    int32_t largest;
} settings;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void stop(const char *what) {
    fprintf(stderr, "curvopt_bench: %s\n", what);
    exit(1);
}

static void must(int32_t status, const curvopt_error *error) {
    if (status != CURVOPT_OK)
        stop(error->message);
}

/* ---------------------------------------------------------------------------------------------- kernels -- */

static double peak_rate(const char *kernel) {
    peak_function *run = peak_portable;
#ifdef CO_HAVE_AVX
    run = !strcmp(kernel, "avx512") ? peak_avx512 : !strcmp(kernel, "avx2") ? peak_avx2 : run;
#else
    (void)kernel;
#endif
    double best = 0, sink = 0;
    for (int k = 0; k < 20; k++) {
        double start = now(), flops = run(100000, &sink), rate = flops / (now() - start);
        best = rate > best ? rate : best;
    }
    return sink == 0.5 ? 0 : best;
}

/* A patch in every lane: its points on a wavy plane, as they lie round a vertex. */
static void place_points(double *xyz, int32_t n) {
    for (int32_t i = 0; i < n; i++) {
        double x = 0.1 * (i % 7), y = 0.1 * (i / 7);
        xyz[3 * i] = x + 0.01 * (i % 3);
        xyz[3 * i + 1] = y;
        xyz[3 * i + 2] = 0.3 * x * x - 0.2 * y * y + 0.1 * x * y + 0.05 * x * x * y;
    }
}

/* Least time of one sweep. */
static double time_sweep(const co_element_kernel *kernel, const co_element_block *sweep, double seconds) {
    double best = 1e9, end = now() + seconds;
    do {
        double start = now();
        for (int k = 0; k < 8; k++)
            kernel->run(sweep);
        double t = (now() - start) / 8;
        best = t < best ? t : best;
    } while (now() < end);
    return best;
}

/* Multiplications a sample of rows and points, on regular faces by sum factorization (kernel_strip.h). */
static double products_of(const co_basis_table *t, int order, int rows) {
    return t->side ? 3.0 * (16.0 * (order + 1) / t->n_side + 4.0 * rows) : 3.0 * rows * t->n_points;
}

/* Operations a sample: rows times points and back, and the formula; the area's gradient has two more rows. */
static double flops_of(const co_element_block *s) {
    const double products = products_of(s->table, s->third ? 3 : 2, s->third ? 9 : 5);
    double flops = 2 * products + flops_forward(s->third);
    if (s->gradient)
        flops += 2 * products + flops_adjoint(s->third) + (s->area_gradient ? 2 * products_of(s->table, 1, 2) : 0);
    return flops;
}

static void bench_kernel(const char *name, int32_t surface, int32_t valence, int third, const settings *set) {
    const co_element_kernel *kernel = co_element_kernel_select(name);
    curvopt_error error;
    co_basis_table *table;
    if (!kernel)
        return;
    must(co_basis_table_create(surface, valence, 1, &table, &error), &error);
    size_t lanes = (size_t)kernel->lanes, n = (size_t)table->n_points;
    double *xyz = calloc(3 * n, sizeof *xyz), *sums = calloc(CO_N_SUMS * CO_BLOCK_FACES, sizeof *sums),
           *gradients = calloc(6 * n * CO_BLOCK_FACES, sizeof *gradients),
           *work = CO_NEW_ALIGNED(double, 9 * n * lanes);
    int32_t *points = calloc(n * CO_BLOCK_FACES, sizeof *points);
    if (!xyz || !sums || !gradients || !work || !points)
        stop("out of memory");
    place_points(xyz, table->n_points);
    for (size_t i = 0; i < n * CO_BLOCK_FACES; i++)
        points[i] = (int32_t)(i / lanes % n);
    co_element_block sweep = {.table = table,
                              .n_used = CO_BLOCK_FACES,
                              .points = points,
                              .xyz = xyz,
                              .eps4 = 1e-8,
                              .third = third,
                              .sums = sums,
                              .gradients = gradients,
                              .work = work};
    if (third)
        sweep.integrand.f1 = 0.625, sweep.integrand.f3 = 0.625, sweep.integrand.x = 0.75;
    else
        sweep.integrand.h2 = 1;
    for (int gradient = 0; gradient < 2; gradient++) {
        sweep.gradient = gradient;
        sweep.area_gradient = gradient && third;
        double peak = peak_rate(name), t = time_sweep(kernel, &sweep, set->seconds);
        double again = peak_rate(name), samples = (double)CO_BLOCK_FACES * table->n_samples;
        peak = again > peak ? again : peak;
        printf(" {\"kind\": \"kernel\", \"kernel\": \"%s\", \"surface\": %d, \"valence\": %d, \"third\": %d, "
               "\"gradient\": %d, \"points\": %d, \"samples\": %d, \"ns_per_sample\": %.2f, \"flops\": %.0f, "
               "\"gflops\": %.2f, \"peak_gflops\": %.2f},\n",
               name, surface, valence, third, gradient, table->n_points, table->n_samples, 1e9 * t / samples,
               flops_of(&sweep), 1e-9 * flops_of(&sweep) * samples / t, 1e-9 * peak);
    }
    co_basis_table_destroy(table);
    free(xyz);
    free(sums);
    free(gradients);
    free(work);
    free(points);
}

/* ---------------------------------------------------------------------------------------- whole surfaces -- */

static curvopt_options options_of(int third, int threads) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    o.weights[CURVOPT_TERM_WILLMORE] = !third;
    o.weights[CURVOPT_TERM_MVS] = third;
    o.threads = threads;
    o.tolerance = 1e-3;
    return o;
}

/* What the process has at most since the last call with `reset`. */
static double peak_megabytes(int reset) {
    char line[256];
    double kilobytes = 0;
    if (reset) {
        malloc_trim(0);
        FILE *clear = fopen("/proc/self/clear_refs", "w");
        if (clear) {
            fputs("5", clear); /* proc(5): resets VmHWM */
            fclose(clear);
        }
        return 0;
    }
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %lf", &kilobytes) == 1)
            break;
    if (status)
        fclose(status);
    return kilobytes / 1024;
}

static double median(double *x, int n) {
    for (int i = 1; i < n; i++)
        for (int k = i; k > 0 && x[k] < x[k - 1]; k--) {
            double t = x[k];
            x[k] = x[k - 1], x[k - 1] = t;
        }
    return n % 2 ? x[n / 2] : (x[n / 2 - 1] + x[n / 2]) / 2;
}

enum { MOST_PAIRS = 1000 };

/* Energy and gradient of a torus net on one thread and on two, by turns, because the machine's speed drifts by more
 * than what two threads lose: the least time of each, and the median of the pairs' ratios. Creating the problem and its
 * first evaluation, which settles the rules, count as set-up; memory is that of one problem. */
static void bench_faces(int32_t n_u, int32_t n_v, int third, const settings *set) {
    curvopt_error error;
    curvopt_energies e;
    curvopt_problem *problem[2];
    peak_megabytes(1);
    cage c = cage_torus(n_u, n_v, 1, 0.5);
    double *gradient = calloc(3 * (size_t)c.n_vertices, sizeof *gradient), *ratio = calloc(MOST_PAIRS, sizeof *ratio);
    double set_up[2], best[2] = {1e9, 1e9}, megabytes = 0;
    int pairs = 0;
    if (!gradient || !ratio)
        stop("out of memory");
    double start = now();
    curvopt_mesh *mesh = cage_mesh(&c);
    double mesh_time = now() - start;
    for (int k = 0; k < 2; k++) {
        curvopt_options o = options_of(third, k + 1);
        start = now();
        must(curvopt_problem_create(mesh, NULL, &o, &problem[k], &error), &error);
        must(curvopt_problem_evaluate(problem[k], c.xyz, &e, sizeof e, gradient, &error), &error);
        set_up[k] = mesh_time + now() - start;
        megabytes = k ? megabytes : peak_megabytes(0);
    }
    for (double end = now() + 16 * set->seconds; pairs < MOST_PAIRS && (pairs < 3 || now() < end); pairs++) {
        double t[2];
        for (int k = 0; k < 2; k++) {
            start = now();
            must(curvopt_problem_evaluate(problem[k], c.xyz, &e, sizeof e, gradient, &error), &error);
            t[k] = now() - start;
            best[k] = t[k] < best[k] ? t[k] : best[k];
        }
        ratio[pairs] = t[0] / t[1];
    }
    printf(" {\"kind\": \"faces\", \"faces\": %d, \"third\": %d, \"samples\": %d, \"ns_per_face\": %.1f, "
           "\"ns_per_face_2\": %.1f, \"speed_up\": %.3f, \"pairs\": %d, \"set_up_s\": %.3f, \"set_up_2_s\": %.3f, "
           "\"peak_mb\": %.0f},\n",
           c.n_faces, third, e.n_samples, 1e9 * best[0] / c.n_faces, 1e9 * best[1] / c.n_faces, median(ratio, pairs),
           pairs, set_up[0], set_up[1], megabytes);
    free(gradient);
    free(ratio);
    for (int k = 0; k < 2; k++)
        curvopt_problem_destroy(problem[k]);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
}

/* Matrix of a cage: assembly of both kinds, analysis with the first factor, another factor, a solution. */
static void bench_matrix(int32_t n_u, int32_t n_v, int third, int threads) {
    curvopt_error error;
    cage c = cage_torus(n_u, n_v, 1, 0.5);
    curvopt_mesh *mesh = cage_mesh(&c);
    curvopt_options o = options_of(third, threads);
    co_constraints hold = {0};
    co_symmetry none = {0};
    co_dof_map reduction;
    co_basis_table_cache tables;
    co_assembly assembly;
    co_newton_system model;
    size_t n = 3 * (size_t)c.n_vertices;
    double centroid[3], radius = co_similarity_frame(n / 3, c.xyz, centroid), times[5], *b = calloc(n, sizeof *b);
    int positive;
    o.surface = third ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT;
    if (!b)
        stop("out of memory");
    for (size_t i = 0; i < n; i++)
        c.xyz[i] = (c.xyz[i] - centroid[i % 3]) / radius;
    co_basis_table_cache_create(o.surface, &tables);
    must(co_symmetry_none(mesh, &none, &error), &error);
    must(co_dof_map_create(mesh, &none, &hold, c.xyz, &reduction, &error), &error);
    must(co_assembly_create(mesh, NULL, NULL, &o, &tables, NULL, &assembly, &error), &error);
    times[0] = now();
    must(co_newton_system_create(&assembly, &reduction, NULL, &model, &error), &error);
    times[0] = now() - times[0];
    for (int exact = 0; exact < 2; exact++) {
        must(co_newton_system_assemble(&model, c.xyz, &(co_second_kind){.exact = exact}, CO_GAUGE_SIMILARITY, &error),
             &error);
        times[1 + exact] = now();
        must(co_newton_system_assemble(&model, c.xyz, &(co_second_kind){.exact = exact}, CO_GAUGE_SIMILARITY, &error),
             &error);
        times[1 + exact] = now() - times[1 + exact];
    }
    must(co_newton_system_assemble(&model, c.xyz, &(co_second_kind){0}, CO_GAUGE_SIMILARITY, &error), &error);
    double shift = 1e-3 * co_newton_system_mean_diagonal(&model);
    for (int k = 0; k < 2; k++) { /* the second one is what a run pays */
        times[3] = now();
        must(co_newton_system_factorize(&model, shift, &positive, &error), &error);
        times[3] = now() - times[3];
    }
    b[0] = 1;
    times[4] = now();
    must(co_newton_system_solve(&model, b, b, &error), &error);
    times[4] = now() - times[4];
    printf(" {\"kind\": \"matrix\", \"vertices\": %d, \"third\": %d, \"threads\": %d, \"create_s\": %.4f, "
           "\"gauss_newton_s\": %.4f, \"hessian_s\": %.4f, \"factor_s\": %.4f, \"solve_s\": %.5f},\n",
           c.n_vertices, third, threads, times[0], times[1], times[2], times[3], times[4]);
    co_newton_system_free(&model);
    co_assembly_free(&assembly);
    co_basis_table_cache_free(&tables);
    co_dof_map_free(&reduction);
    co_symmetry_free(&none);
    curvopt_mesh_destroy(mesh);
    cage_free(&c);
    free(b);
}

int main(int argc, char **argv) {
    static const char *const kernels[3] = {"portable", "avx2", "avx512"};
    settings set = {.seconds = 0.5, .largest = 1000000};
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick"))
            set = (settings){.seconds = 0.01, .largest = 2000};
        else if (!strcmp(argv[i], "--largest") && i + 1 < argc)
            set.largest = atoi(argv[++i]);
        else
            stop("usage: curvopt_bench [--quick] [--largest FACES]");
    }
    printf("[\n");
    for (int k = 0; k < 3; k++)
        for (int third = 0; third < 2; third++) {
            bench_kernel(kernels[k], CURVOPT_SURFACE_LIMIT, 4, third, &set);
            for (int32_t valence = 3; valence <= 6; valence += valence == 3 ? 2 : 1) {
                bench_kernel(kernels[k], CURVOPT_SURFACE_POLYNOMIAL, valence, third, &set);
                bench_kernel(kernels[k], CURVOPT_SURFACE_PLANE, valence, third, &set);
            }
        }
    for (int32_t n_v = 22; 2 * n_v * n_v <= set.largest; n_v = n_v * 1000 / 316) /* 10^3, 10^4, ... faces */
        for (int third = 0; third < 2; third++)
            bench_faces(2 * n_v, n_v, third, &set);
    for (int32_t n_v = 16; n_v <= (set.largest < 10000 ? 16 : 64); n_v *= 2)
        for (int third = 0; third < 2; third++)
            for (int threads = 1; threads <= 2; threads++)
                bench_matrix(2 * n_v, n_v, third, threads);
    printf(" {\"kind\": \"end\"}\n]\n");
    return 0;
}

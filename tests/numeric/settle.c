/* Energies of cages by ever finer rules on all faces, for test_certificates.py:
 *
 *   curvopt_settle willmore|mvs < CAGES
 *
 * Willmore on `limit`, MVS on `polynomial`. CAGES: of each cage the numbers of vertices and faces, x y z of all
 * vertices, and of each face its size and vertices. A line a cage: its energy by the three finest rules, and by how
 * much its faces' shares change from the last rule but one to the last, all added up. Tables, which take longest to
 * make, are shared by all cages; a problem of the API would have its own. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/memory.h"
#include "energy/assembly_sums.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST = CO_LADDER_RULES - 3 };

typedef struct cage {
    int32_t n_vertices, n_faces;
    double *xyz;
    int32_t *sizes, *corners;
} cage;

static void stop(const char *what) {
    fprintf(stderr, "curvopt_settle: %s\n", what);
    exit(1);
}

static void must(int32_t status, const curvopt_error *error) {
    if (status != CURVOPT_OK)
        stop(error->message);
}

static int read_integer(int32_t *out) {
    return scanf("%d", out) == 1;
}

/* 0 at the end of input. */
static int read_cage(cage *c) {
    int32_t n_corners = 0, room = 0;
    *c = (cage){0};
    if (!read_integer(&c->n_vertices))
        return 0;
    if (!read_integer(&c->n_faces) || c->n_vertices < 1 || c->n_faces < 1)
        stop("no cage");
    c->xyz = CO_NEW(double, 3 * (size_t)c->n_vertices);
    c->sizes = CO_NEW(int32_t, c->n_faces);
    if (!c->xyz || !c->sizes)
        stop("no memory");
    for (size_t i = 0; i < 3 * (size_t)c->n_vertices; i++)
        if (scanf("%lf", &c->xyz[i]) != 1)
            stop("too few positions");
    for (int32_t f = 0; f < c->n_faces; f++) {
        if (!read_integer(&c->sizes[f]) || c->sizes[f] < 3)
            stop("no face");
        if (n_corners + c->sizes[f] > room) {
            room = 2 * (n_corners + c->sizes[f]);
            int32_t *more = realloc(c->corners, sizeof *more * (size_t)room);
            if (!more)
                stop("no memory");
            c->corners = more;
        }
        for (int32_t k = 0; k < c->sizes[f]; k++)
            if (!read_integer(&c->corners[n_corners++]))
                stop("too few corners");
    }
    return 1;
}

/* Shares [n_patches] in the energy by one rule; their sum. */
static double evaluate(co_assembly *a, int rule, int term, double *share) {
    int third = term == CURVOPT_TERM_MVS;
    double sum = 0;
    int8_t *rules = CO_NEW(int8_t, a->patches.n_patches);
    co_element_batches l;
    co_values values;
    curvopt_error error;
    if (!rules)
        stop("no memory");
    memset(rules, rule, (size_t)a->patches.n_patches);
    co_element_batches_spec spec = {
        .patches = &a->patches, .cache = a->cache, .lanes = a->kernel->lanes, .rule = rules};
    must(co_element_batches_create(&spec, &l, &error), &error);
    must(co_assembly_evaluate_batches(a, &l, third, &values, &error), &error);
    for (int32_t b = 0; b < l.n_blocks; b++)
        for (int32_t lane = 0; lane < l.block[b].n_used; lane++) {
            double integral[CO_N_INTEGRALS], terms[8];
            for (int i = 0; i < CO_N_INTEGRALS; i++)
                integral[i] = co_element_batches_sum(&l, b, lane, i);
            integral[CO_INT_AREA] = values.integral[CO_INT_AREA];
            co_functional_terms(integral, third, terms);
            share[l.patch[b * l.lanes + lane]] = terms[term];
            sum += terms[term];
        }
    co_element_batches_free(&l);
    free(rules);
    return sum;
}

static void settle(const cage *c, const curvopt_options *options, co_basis_table_cache *tables, int term) {
    curvopt_mesh *mesh;
    curvopt_error error;
    co_assembly a;
    co_values values;
    double change = 0;
    must(curvopt_mesh_create(c->n_vertices, c->n_faces, c->sizes, c->corners, &mesh, &error), &error);
    must(co_assembly_create(mesh, NULL, NULL, options, tables, NULL, &a, &error), &error);
    co_assembly_evaluate(&a, c->xyz, &(co_request){.all_terms = 0}, &values); /* sets positions */
    double *share = CO_NEW(double, 2 * (size_t)a.patches.n_patches);
    if (!share)
        stop("no memory");
    for (int rule = FIRST; rule < CO_LADDER_RULES; rule++)
        printf("%.17g ", evaluate(&a, rule, term, share + rule % 2 * a.patches.n_patches));
    for (int32_t p = 0; p < a.patches.n_patches; p++)
        change += fabs(share[p] - share[a.patches.n_patches + p]);
    printf("%.17g\n", change);
    fflush(stdout);
    free(share);
    co_assembly_free(&a);
    curvopt_mesh_destroy(mesh);
}

int main(int argc, char **argv) {
    curvopt_options options;
    co_basis_table_cache tables;
    cage c;
    if (argc != 2 || (strcmp(argv[1], "willmore") && strcmp(argv[1], "mvs")))
        stop("usage: curvopt_settle willmore|mvs < CAGES");
    int mvs = !strcmp(argv[1], "mvs"), term = mvs ? CURVOPT_TERM_MVS : CURVOPT_TERM_WILLMORE;
    curvopt_options_init(&options, sizeof options);
    memset(options.weights, 0, sizeof options.weights);
    options.weights[term] = 1;
    options.surface = mvs ? CURVOPT_SURFACE_POLYNOMIAL : CURVOPT_SURFACE_LIMIT;
    options.threads = 1;
    co_basis_table_cache_create(options.surface, &tables);
    while (read_cage(&c)) {
        settle(&c, &options, &tables, term);
        free(c.xyz);
        free(c.sizes);
        free(c.corners);
    }
    co_basis_table_cache_free(&tables);
    return 0;
}

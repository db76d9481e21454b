/* Cages that tests work on. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_CAGES_H
#define TEST_CAGES_H

#include "curvopt.h"

typedef struct cage {
    int32_t n_vertices, n_faces;
    int32_t *sizes;    /* [n_faces] */
    int32_t *vertices; /* [sum of sizes] */
    double *xyz;       /* [3 n_vertices] */
} cage;

/* Arrays given (copied), counts too. */
cage cage_of(int32_t n_vertices, int32_t n_faces, const int32_t *sizes, const int32_t *vertices, const double *xyz);
cage cage_tetrahedron(void);
cage cage_cube(void); /* vertices +-1; vertex number = 4 (x > 0) + 2 (y > 0) + (z > 0) */
/* n_u x n_v quads, n_u round the axis. */
cage cage_torus(int32_t n_u, int32_t n_v, double big_radius, double small_radius);
/* n kites round each of two poles: poles of valence n, the 2 n other vertices of valence 3. */
cage cage_trapezohedron(int32_t n);
/* Half a disc, open: n sectors of m x m quads round vertex 0 on its boundary, at the places of the natural net
 * (blend_fit_half.h), z a little bent. */
cage cage_half_star(int32_t n, int32_t m);
/* Two n-gons and n quads. */
cage cage_prism(int32_t n);
/* Two cages in one, the second one moved along x; frees both. */
cage cage_both(cage a, cage b, double shift);
/* Subdivided a few times; frees it. */
cage cage_refined(cage c, int times);
/* Every coordinate moved by up to `amount`, the same for the same seed. */
void cage_perturb(cage *c, double amount, uint64_t seed);
/* c, perturbed by seed 5. */
cage cage_shaken(cage c, double amount);
void cage_free(cage *c);

/* The library's mesh of a cage; fails the test if it is refused. */
curvopt_mesh *cage_mesh(const cage *c);

#endif

/* What the tests of libcurvopt/src/solve work on: a cage, and all that a run shares. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef TEST_SOLVE_SETTING_H
#define TEST_SOLVE_SETTING_H

#include "cages.h"

#include "solve/certificate.h"
#include "solve/run.h"

typedef struct solve_setting {
    cage c;
    curvopt_mesh *mesh;
    curvopt_options options;
    co_tuning tuning; /* a test may change it */
    curvopt_cancel cancel;
    co_basis_table_cache tables;
    co_constraints constraints;
    co_symmetry symmetry;
    co_run_context run; /* points into this struct, which therefore stays where it is */
} solve_setting;

/* Options of one thread for this surface, with the weight of one term 1 and of the others 0, spacing free. */
curvopt_options solve_options(int32_t surface, int term);
/* Takes the cage over. options->symmetry NONE: the trivial group, else all symmetries that the cage has. */
solve_setting *solve_setting_of(cage c, const curvopt_options *options);
void solve_setting_free(solve_setting *s);

/* Area of the surface at xyz, by the rules that an assembly starts with. */
double solve_area(const solve_setting *s, const double *xyz);
/* Objective at xyz, resolved to 1e-8. */
double solve_energy(const solve_setting *s, const double *xyz);
/* A level of this motion, begun. */
co_level *solve_level_of(solve_setting *s, co_motion motion);
/* The same, of everything that may move. */
co_level *solve_level(solve_setting *s);
/* What is found of the shape xyz [3 n_vertices] with this symmetry, by the rules of `solved`, which may be NULL. */
co_certificate_shape solve_shape(solve_setting *s, const co_symmetry *symmetry, const double *xyz,
                                 const co_level *solved, int differences);
/* A run about to start; its mesh is a copy. To be freed by solve_run_free. */
co_run *solve_run(solve_setting *s, curvopt_progress_fn progress, void *user);
void solve_run_free(co_run *r);
/* The cage becomes the minimum of one level, by co_multilevel_minimize; its stop reason is returned. */
int32_t solve_minimized(solve_setting *s);

/* An open band of n_u x n_v quads, n_u round the z axis, from radius r0 at z = 0 to radius r1 at z = height. It has no
 * corners. */
cage cage_band(int32_t n_u, int32_t n_v, double r0, double r1, double height);

#endif

/* Evaluates a cube cage with the installed library, as a stranger would. SPDX-License-Identifier: GPL-3.0-or-later */
#include <curvopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double cube[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const int32_t sizes[6] = {4, 4, 4, 4, 4, 4};
static const int32_t corners[24] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};

int main(void) {
    char expected[32];
    snprintf(expected, sizeof expected, "%d.%d.%d", CURVOPT_VERSION_MAJOR, CURVOPT_VERSION_MINOR,
             CURVOPT_VERSION_PATCH);
    if (strcmp(curvopt_version(), expected) != 0) {
        fprintf(stderr, "consumer: the header is version %s, the library %s\n", expected, curvopt_version());
        return 1;
    }
    curvopt_error error;
    curvopt_options options;
    curvopt_energies energies;
    curvopt_mesh *mesh = NULL;
    curvopt_problem *problem = NULL;
    curvopt_options_init(&options, sizeof options);
    int failed = curvopt_mesh_create(8, 6, sizes, corners, &mesh, &error) ||
                 curvopt_problem_create(mesh, NULL, &options, &problem, &error) ||
                 curvopt_problem_evaluate(problem, cube, &energies, sizeof energies, NULL, &error);
    if (failed) {
        fprintf(stderr, "consumer: %s\n", error.message);
    } else {
        /* Any sphere costs at least the round one, and a cube's limit surface is not far from it. */
        const double round = 8 * acos(-1.0);
        const double willmore = energies.term[CURVOPT_TERM_WILLMORE];
        printf("curvopt %s: the cube's limit surface has Willmore energy %.6f\n", curvopt_version(), willmore);
        failed = !(willmore > round && willmore < 2 * round);
    }
    curvopt_problem_destroy(problem);
    curvopt_mesh_destroy(mesh);
    return failed != 0;
}

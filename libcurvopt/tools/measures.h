/* What is measured of a surface, for reports: where it crosses itself, and how far it is from another one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_MEASURES_H
#define CURVOPT_TOOL_MEASURES_H

#include "curvopt.h"

#include <stdio.h>

enum { MEASURES_MOST_PAIRS = 1000 /* that are listed; all are counted */ };

typedef struct measures {
    curvopt_crossings crossings;
    int32_t *pairs;              /* [2 crossings.n_listed] faces of the input cage */
    curvopt_deviation deviation; /* if has_deviation */
    int has_deviation;
    int has_crossings;
    double clearance;   /* if has_touching: NAN if nothing touches */
    int32_t n_touching; /* pairs of faces of the input by which a result without crossings is held */
    int32_t *touching;  /* [2 n_touching] */
    int32_t n_before;   /* pairs of faces that cross in the input */
    int32_t n_before_listed;
    int32_t *before; /* [2 n_before_listed] */
    int32_t n_refused;
    int has_touching;
    int32_t n_folded;   /* faces of the input that are folded, if has_folds */
    int32_t *folded;    /* [n_folded] */
    int32_t n_unfolded; /* vertices of the input that a run put into place for that; -1: there was no run */
    int has_folds;
} measures;

/* Measures a cage, and its deviation from another one (NULL: none). `input` is the cage that it is a subdivision of, or
 * itself: pairs are its faces. cancel may be NULL; what it cuts off is not there. An error, and nothing to be freed, or
 * CURVOPT_OK. */
int32_t measures_take(const curvopt_mesh *mesh, const double *xyz, const curvopt_mesh *input, const curvopt_mesh *from,
                      const double *from_xyz, int32_t threads, const curvopt_cancel *cancel, measures *out,
                      curvopt_error *error);
/* Of a run with options.no_crossings, what holds its result, and what its input `input`, xyz, does already. As
 * measures_take(), after which it is called. */
int32_t measures_take_touching(const curvopt_result *result, const curvopt_mesh *input, const double *xyz,
                               int32_t threads, const curvopt_cancel *cancel, measures *m, curvopt_error *error);
/* Where the input is folded; n_unfolded is -1. As measures_take(), after which it is called. */
int32_t measures_take_folds(const curvopt_mesh *input, const double *xyz, const curvopt_options *options,
                            const curvopt_cancel *cancel, measures *m, curvopt_error *error);
void measures_free(measures *m);
/* For people: the deviation, if there is one; crossings, if there are any or `always`. */
void measures_print(FILE *file, const measures *m, int always);
/* Members of a JSON object, each with a comma behind it. */
void measures_write_json(FILE *file, const measures *m);

#endif

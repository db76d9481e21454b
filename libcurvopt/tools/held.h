/* What of a cage is held and left out of the energy, for reports. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_HELD_H
#define CURVOPT_TOOL_HELD_H

#include "curvopt.h"

#include <stdio.h>

typedef struct held_list {
    int32_t n_vertices, n_faces; /* of the cage */
    int32_t n_held, n_left_out;  /* vertices that are held, faces that are left out */
    int32_t *vertex_reason;      /* [n_vertices] curvopt_exception, -1: not held */
    int32_t *face_reason;        /* [n_faces] curvopt_exception, -1: counts */
    const char *passed_over;     /* tags that the reader did not understand; the cage's */
} held_list;

/* As curvopt_mesh_find_exceptions. */
int32_t held_find(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options, held_list *out,
                  curvopt_error *error);
void held_free(held_list *held);
/* For people: nothing where nothing is held; else how many, why, and the first few. */
void held_print(FILE *file, const held_list *held);
/* Members of a JSON object, each with a comma behind it. */
void held_write_json(FILE *file, const held_list *held);

#endif

/* Wavefront OBJ cages: vertices, polygons and, as tags, creases. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_OBJ_H
#define CURVOPT_TOOL_OBJ_H

#include "curvopt.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct obj_cage {
    int32_t n_vertices, n_faces;
    double *xyz;            /* [3 n_vertices] */
    int32_t *face_sizes;    /* [n_faces] */
    int32_t *face_vertices; /* [sum of sizes] */
    int32_t n_creases, n_corners;
    int32_t *crease_vertices; /* [2 n_creases] */
    double *crease_sharpness; /* [n_creases] */
    int32_t *corner_vertices; /* [n_corners] */
    double *corner_sharpness; /* [n_corners] */
    int32_t n_holes, n_lines;
    int32_t *holes;        /* [n_holes] faces that are not drawn */
    int32_t *line_sizes;   /* [n_lines] vertices of each line element */
    int32_t *line_ends;    /* [sum of sizes] vertices of line elements; they may not exist */
    int32_t boundary_rule; /* curvopt_boundary_rule of the tag interpolateboundary; -1: there is none */
    char passed_over[96];  /* names of tags that were not understood, with commas; zero-terminated */
} obj_cage;

/* Parses `length` bytes of text (no zero needed at the end). 0, or nonzero with one sentence in message [size] that
 * names the line. Texture and normal indices, groups and materials are passed over.
 *
 * Creases are the tags that OpenSubdiv's shapes have, vertices counted from 0: "t crease 2/1/0 a b sharpness", or a
 * chain of n vertices with one sharpness or n - 1 of them; "t corner 1/1/0 v sharpness", or n vertices with 1 or n.
 * "t hole n/0/0 f .." names faces that are not drawn, "t interpolateboundary 1/0/0 r" the boundary rule: 2 smooth, 1
 * corners, 0 that faces with a vertex on a boundary are not drawn. Other tags are passed over. */
int obj_parse(const char *text, size_t length, obj_cage *cage, char *message, size_t size);
/* Reads a file; `-` is standard input. */
int obj_read(const char *path, obj_cage *cage, char *message, size_t size);
/* Coordinates to 17 digits, so that they read back bit for bit. Nonzero if writing failed. */
int obj_write(FILE *file, const obj_cage *cage);
void obj_free(obj_cage *cage);
/* What curvopt_mesh_create_creased() takes; points into the cage. boundary_rule -1: the cage's, else smooth. */
curvopt_creases obj_creases(const obj_cage *cage, int32_t boundary_rule);

#endif

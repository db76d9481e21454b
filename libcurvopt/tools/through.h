/* Files of what the surface goes through. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THROUGH_H
#define THROUGH_H

#include "curvopt.h"

#include <stddef.h>
#include <stdio.h>

typedef struct through_list {
    curvopt_through given; /* whose arrays are these */
    int32_t *integers;
    double *reals;
    curvopt_chain *chains;
} through_list;

/* Reads a JSON list of entries, each an object with
 *     "vertex": V                      or "face": F, "uv": [U, V] and, of a face that is no quad, "corner": C
 *     "at": [X, Y, Z]                  the point is there; or "at": "here", where it is
 *     "line": [X, Y, Z]                it is on the line through that place, or where it is, with this direction
 *     "plane": [X, Y, Z]               the same of the plane with this normal
 *     "normal": [X, Y, Z]              the surface's normal there
 *     "tangent": {"to": W, "along": [X, Y, Z]}   the tangent toward vertex W; inside a face W is "u" or "v"
 *     "curvatures": [K1, K2]           principal curvatures there, with a normal
 *     "curvature_direction": [X, Y, Z] that of K1; without it that of the tangent, or none where K1 = K2
 *     "weight": W                      0 to 1, how firmly; 1: exactly, as without it
 * or an object {"points": [entries], "chains": [chains]} with one of them or both, a chain being an object with
 *     "vertices": [V, ...]             each joined to the next by an edge
 *     "closed": true                   and the last one to the first
 *     "curve": [[X, Y, Z], ...]        points of the curve that its limit curve follows
 *     "curve_closed": true             the curve goes on from the last one to the first
 *     "parameters": [T, ...]           where on it each vertex is, in numbers of these points; without: at the nearest
 *     "weight": W                      as of entries
 * Numbers of vertices, faces, corners, entries and chains count from 0. Nonzero with a sentence in message [size],
 * which names the entry or chain, if that cannot be done, or if there is none. */
int through_parse(FILE *file, through_list *out, char *message, size_t size);
/* The same from a file by name; "-": from standard input. */
int through_read(const char *path, through_list *out, char *message, size_t size);
void through_free(through_list *list);

#endif

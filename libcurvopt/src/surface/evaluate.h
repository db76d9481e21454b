/* Points of a cage's surface and their derivatives, anywhere on it. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_EVALUATE_H
#define CO_SURFACE_EVALUATE_H

#include "surface/basis_table_cache.h"
#include "surface/patches.h"

/* A surface made ready to be sampled: its patches are made once, linear in the cage. */
typedef struct co_sampler {
    co_patches patches;
    int32_t n_faces;
    int32_t surface; /* curvopt_surface, not AUTO */
    double *points;  /* [3 n_points] of the patches: the cage's vertices, then derived points */
    int32_t *first;  /* [n_faces] first patch of each face; -1: none */
    int32_t *next;   /* [n_patches] next patch of the same face; -1: none */
    double *rows;    /* rows of one point, room for the largest patch */
    co_basis_table_cache tables;
} co_sampler;

/* surface is not AUTO. ERROR_TOPOLOGY, ERROR_MEMORY. */
int32_t co_sampler_create(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int blend_width,
                          co_sampler *out, curvopt_error *error);
void co_sampler_free(co_sampler *sampler);
/* Implements curvopt_sampler_jets, whose arguments have been checked. Searches among the face's patches for each point.
 */
int32_t co_sampler_jets(co_sampler *sampler, int32_t n, const int32_t *face, const int32_t *corner, const double *uv,
                        double *jets, curvopt_error *error);

/* (u, v) of the face in the patch's own coordinates st; nonzero if inside. */
int co_evaluate_to_patch(const co_place *place, const double uv[2], double st[2]);
/* The first n numbers of a jet, 3, 6 or 10, along the face's u, v from those along the patch's s, t. */
void co_evaluate_to_face(const co_place *place, int n, const double *along_st, double *along_uv);

#endif

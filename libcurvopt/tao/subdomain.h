/* A rank's portion of a cage: its own faces, and the halo that their surface depends on.
 *
 * Faces are shared out once, where the cage is read; from then on every rank subdivides its own portion, and no rank
 * ever sees the whole. Vertices and faces keep the numbers that the library would give them ("natural" ones: of a
 * subdivision first the vertices, then the edges in order of their smaller and larger end, then the faces), so that
 * what is written does not depend on the number of ranks. In PETSc's vectors each rank's own vertices stand together.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_PORTION_H
#define CURVOPT_TAO_PORTION_H

#include "curvopt_experimental.h"

#include <petscsf.h>
#include <petscvec.h>

typedef struct portion {
    MPI_Comm comm;
    curvopt_mesh *mesh; /* own faces and halo */
    PetscInt n_vertices, n_faces;
    PetscInt whole_vertices, whole_edges, whole_faces, whole_corners;
    PetscInt *vertex;        /* [n_vertices] natural number */
    PetscInt *face;          /* [n_faces] natural number, */
    PetscInt *face_corner;   /* [n_faces] and that of its first corner */
    double *counts;          /* [n_faces] 1: one of this rank's own faces; 0: halo */
    unsigned char *boundary; /* [n_vertices] 1: on the surface's boundary */
    PetscInt n_rim;
    PetscInt *rim; /* [2 n_rim] edges on the surface's boundary, from where to where in their face, ascending */
    /* in vectors: */
    PetscInt n_own, first_own; /* own vertices, and where they begin */
    PetscInt *global;          /* [n_vertices] place */
    PetscInt *own;             /* [n_own] number in the mesh */
    PetscSF ghosts;            /* leaves are the mesh's vertices, roots the own ones of all ranks */
    MPI_Datatype point;        /* three reals */
} portion;

/* A cage as one rank has read it. */
typedef struct portion_source {
    const curvopt_mesh *mesh;
    const double *xyz; /* [3 n_vertices] */
} portion_source;

/* Collective; `source` matters on rank 0 only, which shares the faces out by halving the cage along its longest extent,
 * again and again. own_xyz [3 n_own] is the caller's to free(). At least as many faces as ranks. */
PetscErrorCode portion_share(MPI_Comm comm, const portion_source *source, portion *out, double **own_xyz);
/* The subdivision of a portion at own_xyz; fine_xyz as above. */
PetscErrorCode portion_refine(const portion *coarse, const double *own_xyz, portion *out, double **fine_xyz);
/* Gives the vertices of a portion that has all but these their places in vectors. */
PetscErrorCode portion_place(portion *p);
PetscErrorCode portion_free(portion *p);

/* xyz [3 n_vertices] from what the owners have: own_xyz [3 n_own]. */
PetscErrorCode portion_fetch(const portion *p, const double *own_xyz, double *xyz);
/* own [3 n_own] = sums over ranks of each vertex's share [3 n_vertices]. */
PetscErrorCode portion_sum(const portion *p, const double *shares, double *own);
/* A vector of three reals for each own vertex. */
PetscErrorCode portion_vector(const portion *p, Vec *out);

#endif

/* A rank's subdomain of a cage: its own faces, and the halo that their surface depends on.
 *
 * Faces are distributed once, where the cage is read; from then on every rank subdivides its own subdomain, and no rank
 * ever sees the whole. Vertices and faces keep the numbers that the library would give them ("natural" ones: of a
 * subdivision first the vertices, then the edges in order of their smaller and larger end, then the faces), so that
 * what is written does not depend on the number of ranks. In PETSc's vectors each rank's own vertices stand together.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_SUBDOMAIN_H
#define CURVOPT_TAO_SUBDOMAIN_H

#include "curvopt_experimental.h"

#include <petscsf.h>
#include <petscvec.h>

typedef struct subdomain {
    MPI_Comm comm;
    curvopt_mesh *mesh; /* own faces and halo */
    PetscInt n_vertices, n_faces;
    PetscInt whole_vertices, whole_edges, whole_faces, whole_corners;
    PetscInt *vertex;        /* [n_vertices] natural number */
    PetscInt *face;          /* [n_faces] natural number, */
    PetscInt *face_corner;   /* [n_faces] and that of its first corner */
    double *counts;          /* [n_faces] 1: one of this rank's own faces; 0: halo */
    unsigned char *boundary; /* [n_vertices] 1: on the surface's boundary */
    PetscInt n_boundary_edges;
    PetscInt *boundary_edges; /* [2 n_boundary_edges] edges on the surface's boundary, from where to where in their
                                 face, ascending */
    /* in vectors: */
    PetscInt n_own, first_own; /* own vertices, and where they begin */
    PetscInt *global;          /* [n_vertices] place */
    PetscInt *own;             /* [n_own] number in the mesh */
    PetscSF ghosts;            /* leaves are the mesh's vertices, roots the own ones of all ranks */
    MPI_Datatype point;        /* three reals */
} subdomain;

/* The subdivision of a subdomain at own_xyz; fine_xyz [3 n_own of `out`] is the caller's to free(). */
PetscErrorCode subdomain_subdivide(const subdomain *coarse, const double *own_xyz, subdomain *out, double **fine_xyz);
/* Gives the vertices their places in vectors: the last step of making a subdomain. */
PetscErrorCode subdomain_place(subdomain *p);
PetscErrorCode subdomain_free(subdomain *p);

/* xyz [3 n_vertices] from what the owners have: own_xyz [3 n_own]. */
PetscErrorCode subdomain_fetch(const subdomain *p, const double *own_xyz, double *xyz);
/* own [3 n_own] = sums over ranks of each vertex's contributions [3 n_vertices]. */
PetscErrorCode subdomain_sum(const subdomain *p, const double *contributions, double *own);
/* A vector of three reals for each own vertex. */
PetscErrorCode subdomain_vector(const subdomain *p, Vec *out);

#endif

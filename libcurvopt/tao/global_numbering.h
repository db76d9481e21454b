/* Numbers of things that several ranks know, by directories that are distributed over the ranks.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_GLOBAL_NUMBERING_H
#define CURVOPT_TAO_GLOBAL_NUMBERING_H

#include <petscsf.h>

/* A directory of numbers 0 .. n_whole - 1, equally many of them on every rank, n_roots on this one; its leaves are
 * the n numbers that this rank knows. */
PetscErrorCode global_numbering_directory(MPI_Comm comm, PetscInt n_whole, PetscInt n, const PetscInt *numbers,
                                          PetscSF *out, PetscInt *n_roots);
/* Numbers edges, each known to one or several ranks by its ends [2 n], the smaller first: in the order of these. */
PetscErrorCode global_numbering_edges(MPI_Comm comm, PetscInt n_vertices, PetscInt n, const PetscInt *ends,
                                      PetscInt *numbers);

#endif

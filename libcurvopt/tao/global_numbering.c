/* Numbers of things that several ranks know. SPDX-License-Identifier: GPL-3.0-or-later */
#include "global_numbering.h"

#include "collective.h"

#include <stdlib.h>
#include <string.h>

PetscErrorCode global_numbering_directory(MPI_Comm comm, PetscInt n_whole, PetscInt n, const PetscInt *numbers,
                                          PetscSF *out, PetscInt *n_roots) {
    PetscLayout layout;
    PetscFunctionBeginUser;
    PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, n_whole, 1, &layout));
    PetscCall(PetscLayoutGetLocalSize(layout, n_roots));
    PetscCall(PetscSFCreate(comm, out));
    PetscCall(PetscSFSetGraphLayout(*out, layout, n, NULL, PETSC_COPY_VALUES, numbers));
    PetscCall(PetscLayoutDestroy(&layout));
    PetscFunctionReturn(0);
}

static int compare_numbers(const void *a, const void *b) {
    PetscInt x = *(const PetscInt *)a, y = *(const PetscInt *)b;
    return (x > y) - (x < y);
}

/* Larger ends at each smaller one, as they came in, become numbers of edges. sorted: room for as many */
static PetscErrorCode number_larger_ends(MPI_Comm comm, PetscInt n_roots, const PetscInt *degree, PetscInt *larger,
                                         PetscInt *sorted) {
    PetscInt n = 0, first, at = 0;
    PetscInt *start = COLLECTIVE_NEW(comm, PetscInt, n_roots + 1);
    PetscFunctionBeginUser;
    for (PetscInt r = 0; r < n_roots; at += degree[r++]) {
        start[r] = n;
        if (!degree[r])
            continue;
        memcpy(sorted + at, larger + at, sizeof *larger * (size_t)degree[r]);
        qsort(sorted + at, (size_t)degree[r], sizeof *sorted, compare_numbers);
        for (PetscInt i = 0; i < degree[r]; i++)
            if (i == 0 || sorted[at + i] != sorted[at + i - 1])
                sorted[at + n++ - start[r]] = sorted[at + i];
    }
    start[n_roots] = n;
    PetscCallMPI(MPI_Scan(&n, &first, 1, MPIU_INT, MPI_SUM, comm));
    first -= n;
    at = 0;
    for (PetscInt r = 0; r < n_roots; at += degree[r++])
        for (PetscInt i = 0; i < degree[r]; i++) {
            const PetscInt *found = bsearch(&larger[at + i], sorted + at, (size_t)(start[r + 1] - start[r]),
                                            sizeof *sorted, compare_numbers);
            larger[at + i] = first + start[r] + (PetscInt)(found - (sorted + at));
        }
    free(start);
    PetscFunctionReturn(0);
}

PetscErrorCode global_numbering_edges(MPI_Comm comm, PetscInt n_vertices, PetscInt n, const PetscInt *ends,
                                      PetscInt *numbers) {
    PetscSF by_smaller;
    PetscInt n_roots, n_entries = 0;
    const PetscInt *degree;
    PetscFunctionBeginUser;
    PetscInt *smaller = COLLECTIVE_NEW(comm, PetscInt, n);
    for (PetscInt e = 0; e < n; e++) {
        smaller[e] = ends[2 * e];
        numbers[e] = ends[2 * e + 1];
    }
    PetscCall(global_numbering_directory(comm, n_vertices, n, smaller, &by_smaller, &n_roots));
    PetscCall(PetscSFComputeDegreeBegin(by_smaller, &degree));
    PetscCall(PetscSFComputeDegreeEnd(by_smaller, &degree));
    for (PetscInt r = 0; r < n_roots; r++)
        n_entries += degree[r];
    PetscInt *larger = COLLECTIVE_NEW(comm, PetscInt, n_entries), *sorted = COLLECTIVE_NEW(comm, PetscInt, n_entries);
    PetscCall(PetscSFGatherBegin(by_smaller, MPIU_INT, numbers, larger));
    PetscCall(PetscSFGatherEnd(by_smaller, MPIU_INT, numbers, larger));
    PetscCall(number_larger_ends(comm, n_roots, degree, larger, sorted));
    PetscCall(PetscSFScatterBegin(by_smaller, MPIU_INT, larger, numbers));
    PetscCall(PetscSFScatterEnd(by_smaller, MPIU_INT, larger, numbers));
    PetscCall(PetscSFDestroy(&by_smaller));
    free(smaller);
    free(larger);
    free(sorted);
    PetscFunctionReturn(0);
}

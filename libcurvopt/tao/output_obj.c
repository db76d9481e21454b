/* A distributed cage, into a file. SPDX-License-Identifier: GPL-3.0-or-later */
#include "output_obj.h"

#include "collective.h"
#include "global_numbering.h"

#include <stdlib.h>
#include <string.h>

enum { TAG_COUNT = 11, TAG_BLOCK };

/* A block of equal size on every rank, in natural order, of what ranks have: n items of one unit each, by number. */
static PetscErrorCode to_blocks(MPI_Comm comm, PetscInt n_whole, PetscInt n, const PetscInt *numbers, MPI_Datatype unit,
                                size_t bytes, const void *items, PetscInt *n_block, void **block) {
    PetscSF directory;
    PetscFunctionBeginUser;
    PetscCall(global_numbering_directory(comm, n_whole, n, numbers, &directory, n_block));
    *block = COLLECTIVE_NEW(comm, char, bytes *(size_t)*n_block);
    PetscCall(PetscSFReduceBegin(directory, unit, items, *block, MPI_REPLACE));
    PetscCall(PetscSFReduceEnd(directory, unit, items, *block, MPI_REPLACE));
    PetscCall(PetscSFDestroy(&directory));
    PetscFunctionReturn(0);
}

/* Rank 0 gets the block of `rank`: *n items of so many bytes, which it frees. */
static PetscErrorCode fetch_block(MPI_Comm comm, int rank, size_t bytes, PetscInt *n, void **block) {
    PetscMPIInt me;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(comm, &me));
    if (me == rank && rank != 0) {
        PetscCallMPI(MPI_Send(n, 1, MPIU_INT, 0, TAG_COUNT, comm));
        PetscCallMPI(MPI_Send(*block, (int)(bytes * (size_t)*n), MPI_BYTE, 0, TAG_BLOCK, comm));
    } else if (me == 0 && rank != 0) {
        PetscCallMPI(MPI_Recv(n, 1, MPIU_INT, rank, TAG_COUNT, comm, MPI_STATUS_IGNORE));
        *block = COLLECTIVE_NEW(comm, char, bytes *(size_t)*n);
        PetscCallMPI(MPI_Recv(*block, (int)(bytes * (size_t)*n), MPI_BYTE, rank, TAG_BLOCK, comm, MPI_STATUS_IGNORE));
    }
    PetscFunctionReturn(0);
}

static PetscErrorCode write_points(const subdomain *p, const double *own, const char *format, FILE *file) {
    PetscMPIInt me, n_ranks;
    PetscInt n_block;
    void *block;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(p->comm, &me));
    PetscCallMPI(MPI_Comm_size(p->comm, &n_ranks));
    PetscInt *numbers = COLLECTIVE_NEW(p->comm, PetscInt, p->n_own);
    for (PetscInt i = 0; i < p->n_own; i++)
        numbers[i] = p->vertex[p->own[i]];
    PetscCall(
        to_blocks(p->comm, p->whole_vertices, p->n_own, numbers, p->point, 3 * sizeof(double), own, &n_block, &block));
    for (int rank = 0; rank < n_ranks; rank++) {
        PetscInt n = n_block;
        void *theirs = block;
        PetscCall(fetch_block(p->comm, rank, 3 * sizeof(double), &n, &theirs));
        for (PetscInt v = 0; me == 0 && v < n; v++) {
            const double *x = (const double *)theirs + 3 * (size_t)v;
            fprintf(file, format, x[0], x[1], x[2]);
        }
        if (theirs != block)
            free(theirs);
    }
    free(block);
    free(numbers);
    PetscFunctionReturn(0);
}

/* What faces consist of, by natural number of faces and corners. */
typedef struct polygons {
    PetscInt n_faces, n_corners;
    PetscInt *face, *size, *corner, *vertex;
} polygons;

static polygons own_polygons(const subdomain *p) {
    polygons out = {0};
    curvopt_mesh_info info;
    curvopt_mesh_get_info(p->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(p->comm, int32_t, info.n_faces),
            *vertices = COLLECTIVE_NEW(p->comm, int32_t, info.n_corners);
    out.face = COLLECTIVE_NEW(p->comm, PetscInt, info.n_faces);
    out.size = COLLECTIVE_NEW(p->comm, PetscInt, info.n_faces);
    out.corner = COLLECTIVE_NEW(p->comm, PetscInt, info.n_corners);
    out.vertex = COLLECTIVE_NEW(p->comm, PetscInt, info.n_corners);
    curvopt_mesh_get_faces(p->mesh, sizes, vertices);
    for (int32_t f = 0, c = 0; f < info.n_faces; c += sizes[f++]) {
        if (p->counts[f] == 0)
            continue;
        out.face[out.n_faces] = p->face[f];
        out.size[out.n_faces++] = sizes[f];
        for (int32_t k = 0; k < sizes[f]; k++) {
            out.corner[out.n_corners] = p->face_corner[f] + k;
            out.vertex[out.n_corners++] = p->vertex[vertices[c + k]];
        }
    }
    free(sizes);
    free(vertices);
    return out;
}

static PetscErrorCode write_faces(const subdomain *p, FILE *file) {
    PetscMPIInt me, n_ranks;
    PetscInt n_sizes, n_corners, left = 0;
    void *sizes, *corners;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(p->comm, &me));
    PetscCallMPI(MPI_Comm_size(p->comm, &n_ranks));
    polygons own = own_polygons(p);
    PetscCall(to_blocks(p->comm, p->whole_faces, own.n_faces, own.face, MPIU_INT, sizeof(PetscInt), own.size, &n_sizes,
                        &sizes));
    PetscCall(to_blocks(p->comm, p->whole_corners, own.n_corners, own.corner, MPIU_INT, sizeof(PetscInt), own.vertex,
                        &n_corners, &corners));
    /* sizes are gathered: one number a face, against a dozen and more that the solve has */
    PetscInt *all_sizes = NULL, face = 0;
    PetscInt n_all = 0;
    for (int rank = 0; rank < n_ranks; rank++) {
        PetscInt n = n_sizes;
        void *theirs = sizes;
        PetscCall(fetch_block(p->comm, rank, sizeof(PetscInt), &n, &theirs));
        if (me == 0) {
            all_sizes = collective_allocated(p->comm, realloc(all_sizes, sizeof(PetscInt) * (size_t)(n_all + n + 1)));
            memcpy(all_sizes + n_all, theirs, sizeof(PetscInt) * (size_t)n);
            n_all += n;
        }
        if (theirs != sizes)
            free(theirs);
    }
    for (int rank = 0; rank < n_ranks; rank++) {
        PetscInt n = n_corners;
        void *theirs = corners;
        PetscCall(fetch_block(p->comm, rank, sizeof(PetscInt), &n, &theirs));
        for (PetscInt c = 0; me == 0 && c < n; c++) {
            if (left == 0) {
                left = all_sizes[face++];
                fputc('f', file);
            }
            fprintf(file, " %d", (int)((const PetscInt *)theirs)[c] + 1);
            if (--left == 0)
                fputc('\n', file);
        }
        if (theirs != corners)
            free(theirs);
    }
    free(all_sizes);
    free(sizes);
    free(corners);
    free(own.face);
    free(own.size);
    free(own.corner);
    free(own.vertex);
    PetscFunctionReturn(0);
}

/* A sharp edge, or a sharp vertex if both ends are one. */
typedef struct crease {
    double sharpness;
    PetscInt ends[2];
} crease;

static int compare_creases(const void *a, const void *b) {
    const crease *x = a, *y = b;
    int k = x->ends[0] == y->ends[0];
    return (x->ends[k] > y->ends[k]) - (x->ends[k] < y->ends[k]);
}

/* Those whose smaller end this rank owns; their number. */
static int own_creases(const subdomain *p, crease **out) {
    int32_t n_creases, n_corners;
    int n = 0;
    curvopt_mesh_count_creases(p->mesh, &n_creases, &n_corners);
    int32_t *ends = COLLECTIVE_NEW(p->comm, int32_t, 2 * (size_t)n_creases),
            *corners = COLLECTIVE_NEW(p->comm, int32_t, n_corners);
    double *sharpness = COLLECTIVE_NEW(p->comm, double, n_creases),
           *corner = COLLECTIVE_NEW(p->comm, double, n_corners);
    curvopt_mesh_get_creases(p->mesh, ends, sharpness, corners, corner);
    *out = COLLECTIVE_NEW(p->comm, crease, (size_t)n_creases + (size_t)n_corners);
    for (int32_t i = 0; i < n_creases + n_corners; i++) {
        int32_t a = i < n_creases ? ends[2 * i] : corners[i - n_creases],
                b = i < n_creases ? ends[2 * i + 1] : corners[i - n_creases];
        int32_t first = p->vertex[a] < p->vertex[b] ? a : b, second = first == a ? b : a;
        if (p->global[first] >= p->first_own && p->global[first] < p->first_own + p->n_own)
            (*out)[n++] = (crease){.sharpness = i < n_creases ? sharpness[i] : corner[i - n_creases],
                                   .ends = {p->vertex[first], p->vertex[second]}};
    }
    free(ends);
    free(corners);
    free(sharpness);
    free(corner);
    return n;
}

/* Creases are few: rank 0 gets all of them. */
static PetscErrorCode write_creases(const subdomain *p, FILE *file) {
    PetscMPIInt me, n_ranks, n_all = 0;
    crease *mine, *all;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(p->comm, &me));
    PetscCallMPI(MPI_Comm_size(p->comm, &n_ranks));
    int n = own_creases(p, &mine) * (int)sizeof(crease);
    int *counts = COLLECTIVE_NEW(p->comm, int, n_ranks), *starts = COLLECTIVE_NEW(p->comm, int, n_ranks);
    PetscCallMPI(MPI_Gather(&n, 1, MPI_INT, counts, 1, MPI_INT, 0, p->comm));
    for (int r = 0; r < n_ranks; n_all += counts[r++])
        starts[r] = n_all;
    all = COLLECTIVE_NEW(p->comm, crease, n_all / (int)sizeof(crease));
    PetscCallMPI(MPI_Gatherv(mine, n, MPI_BYTE, all, counts, starts, MPI_BYTE, 0, p->comm));
    n_all = me == 0 ? n_all / (int)sizeof(crease) : 0;
    qsort(all, (size_t)n_all, sizeof *all, compare_creases);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < n_all; i++) {
            const crease *c = &all[i];
            if (k == 0 && c->ends[0] != c->ends[1])
                fprintf(file, "t crease 2/1/0 %d %d %.17g\n", (int)c->ends[0], (int)c->ends[1], c->sharpness);
            if (k == 1 && c->ends[0] == c->ends[1])
                fprintf(file, "t corner 1/1/0 %d %.17g\n", (int)c->ends[0], c->sharpness);
        }
    free(mine);
    free(all);
    free(counts);
    free(starts);
    PetscFunctionReturn(0);
}

PetscErrorCode output_obj_cage(const subdomain *p, const double *own_xyz, FILE *file, int *failed) {
    PetscFunctionBeginUser;
    PetscCall(write_points(p, own_xyz, "v %.17g %.17g %.17g\n", file));
    PetscCall(write_faces(p, file));
    PetscCall(write_creases(p, file));
    *failed = file && ferror(file);
    PetscFunctionReturn(0);
}

PetscErrorCode output_obj_vectors(const subdomain *p, const double *own_vectors, FILE *file, int *failed) {
    PetscFunctionBeginUser;
    PetscCall(write_points(p, own_vectors, "%.17g %.17g %.17g\n", file));
    *failed = file && ferror(file);
    PetscFunctionReturn(0);
}

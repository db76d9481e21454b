/* A rank's subdomain of a cage: places in vectors, and subdivision. SPDX-License-Identifier: GPL-3.0-or-later */
#include "subdomain.h"

#include "collective.h"
#include "global_numbering.h"

#include <stdlib.h>
#include <string.h>

PetscErrorCode subdomain_free(subdomain *p) {
    PetscFunctionBeginUser;
    curvopt_mesh_destroy(p->mesh);
    free(p->vertex);
    free(p->face);
    free(p->face_corner);
    free(p->counts);
    free(p->boundary);
    free(p->boundary_edges);
    free(p->global);
    free(p->own);
    PetscCall(PetscSFDestroy(&p->ghosts));
    if (p->point)
        PetscCallMPI(MPI_Type_free(&p->point));
    *p = (subdomain){0};
    PetscFunctionReturn(0);
}

PetscErrorCode subdomain_fetch(const subdomain *p, const double *own_xyz, double *xyz) {
    PetscFunctionBeginUser;
    PetscCall(PetscSFBcastBegin(p->ghosts, p->point, own_xyz, xyz, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(p->ghosts, p->point, own_xyz, xyz, MPI_REPLACE));
    PetscFunctionReturn(0);
}

PetscErrorCode subdomain_sum(const subdomain *p, const double *contributions, double *own) {
    PetscFunctionBeginUser;
    PetscCall(PetscArrayzero(own, 3 * (size_t)p->n_own));
    PetscCall(PetscSFReduceBegin(p->ghosts, p->point, contributions, own, MPIU_SUM));
    PetscCall(PetscSFReduceEnd(p->ghosts, p->point, contributions, own, MPIU_SUM));
    PetscFunctionReturn(0);
}

PetscErrorCode subdomain_vector(const subdomain *p, Vec *out) {
    PetscFunctionBeginUser;
    PetscCall(VecCreate(p->comm, out));
    PetscCall(VecSetSizes(*out, 3 * p->n_own, 3 * p->whole_vertices));
    PetscCall(VecSetBlockSize(*out, 3));
    PetscCall(VecSetFromOptions(*out));
    PetscFunctionReturn(0);
}

/* Which vertices are those of own faces. */
static void mark_touched(const subdomain *p, const int32_t *sizes, const int32_t *vertices, unsigned char *touched) {
    for (PetscInt f = 0, c = 0; f < p->n_faces; c += sizes[f++])
        for (int32_t k = 0; p->counts[f] != 0 && k < sizes[f]; k++)
            touched[vertices[c + k]] = 1;
}

/* Who owns each vertex: the first rank that has a face at it. owner [n_vertices] */
static PetscErrorCode find_owners(const subdomain *p, PetscSF by_number, PetscInt n_roots, PetscInt *owner) {
    curvopt_mesh_info info;
    PetscMPIInt rank, size;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
    PetscCallMPI(MPI_Comm_size(p->comm, &size));
    curvopt_mesh_get_info(p->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(p->comm, int32_t, info.n_faces),
            *vertices = COLLECTIVE_NEW(p->comm, int32_t, info.n_corners);
    unsigned char *touched = COLLECTIVE_NEW(p->comm, unsigned char, p->n_vertices);
    PetscInt *root = COLLECTIVE_NEW(p->comm, PetscInt, n_roots);
    curvopt_mesh_get_faces(p->mesh, sizes, vertices);
    mark_touched(p, sizes, vertices, touched);
    for (PetscInt v = 0; v < p->n_vertices; v++)
        owner[v] = touched[v] ? rank : size;
    for (PetscInt i = 0; i < n_roots; i++)
        root[i] = size;
    PetscCall(PetscSFReduceBegin(by_number, MPIU_INT, owner, root, MPI_MIN));
    PetscCall(PetscSFReduceEnd(by_number, MPIU_INT, owner, root, MPI_MIN));
    PetscCall(PetscSFBcastBegin(by_number, MPIU_INT, root, owner, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(by_number, MPIU_INT, root, owner, MPI_REPLACE));
    free(sizes);
    free(vertices);
    free(touched);
    free(root);
    PetscFunctionReturn(0);
}

/* Places in vectors: by rank, own vertices in the order of the mesh. */
static PetscErrorCode find_places(subdomain *p) {
    PetscSF by_number;
    PetscInt n_roots, *root, n = 0;
    PetscMPIInt rank;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(p->comm, &rank));
    PetscCall(global_numbering_directory(p->comm, p->whole_vertices, p->n_vertices, p->vertex, &by_number, &n_roots));
    PetscInt *owner = COLLECTIVE_NEW(p->comm, PetscInt, p->n_vertices);
    p->global = COLLECTIVE_NEW(p->comm, PetscInt, p->n_vertices);
    p->own = COLLECTIVE_NEW(p->comm, PetscInt, p->n_vertices);
    root = COLLECTIVE_NEW(p->comm, PetscInt, n_roots);
    PetscCall(find_owners(p, by_number, n_roots, owner));
    for (PetscInt v = 0; v < p->n_vertices; v++)
        if (owner[v] == rank)
            p->own[n++] = v;
    p->n_own = n;
    PetscCallMPI(MPI_Scan(&n, &p->first_own, 1, MPIU_INT, MPI_SUM, p->comm));
    p->first_own -= n;
    for (PetscInt v = 0; v < p->n_vertices; v++)
        p->global[v] = -1;
    for (PetscInt i = 0; i < n; i++)
        p->global[p->own[i]] = p->first_own + i;
    for (PetscInt i = 0; i < n_roots; i++)
        root[i] = -1;
    PetscCall(PetscSFReduceBegin(by_number, MPIU_INT, p->global, root, MPI_MAX));
    PetscCall(PetscSFReduceEnd(by_number, MPIU_INT, p->global, root, MPI_MAX));
    PetscCall(PetscSFBcastBegin(by_number, MPIU_INT, root, p->global, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(by_number, MPIU_INT, root, p->global, MPI_REPLACE));
    PetscCall(PetscSFDestroy(&by_number));
    free(owner);
    free(root);
    PetscFunctionReturn(0);
}

PetscErrorCode subdomain_place(subdomain *p) {
    PetscLayout layout;
    PetscFunctionBeginUser;
    PetscCall(find_places(p));
    PetscCallMPI(MPI_Type_contiguous(3, MPIU_REAL, &p->point));
    PetscCallMPI(MPI_Type_commit(&p->point));
    PetscCall(PetscLayoutCreateFromSizes(p->comm, p->n_own, p->whole_vertices, 1, &layout));
    PetscCall(PetscSFCreate(p->comm, &p->ghosts));
    PetscCall(PetscSFSetGraphLayout(p->ghosts, layout, p->n_vertices, NULL, PETSC_COPY_VALUES, p->global));
    PetscCall(PetscLayoutDestroy(&layout));
    PetscFunctionReturn(0);
}

/* ------------------------------------------------------------------------------------------- subdivision -- */

/* A subdomain, and its mesh subdivided: child k of face f begins at that corner. */
typedef struct subdivision {
    const subdomain *from;
    curvopt_mesh *fine;
    curvopt_mesh_info coarse_info, info;
    int32_t *children;       /* [4 n_corners] vertices of the fine faces: corner, edge after it, face, edge before */
    PetscInt *vertex;        /* [fine vertices] natural number */
    unsigned char *boundary; /* [fine vertices] */
    double *xyz;             /* [3 fine vertices]; at the edge of the halo they are wrong, and not used */
} subdivision;

static void subdivision_free(subdivision *s) {
    curvopt_mesh_destroy(s->fine);
    free(s->children);
    free(s->vertex);
    free(s->boundary);
    free(s->xyz);
}

static int compare_pairs(const void *a, const void *b) {
    const PetscInt *x = a, *y = b;
    return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

static int is_boundary_edge(const subdomain *p, PetscInt from, PetscInt to) {
    const PetscInt pair[2] = {from, to};
    return p->n_boundary_edges &&
           bsearch(pair, p->boundary_edges, (size_t)p->n_boundary_edges, sizeof pair, compare_pairs) != NULL;
}

/* The natural numbers of the fine vertices, and which are on the boundary. sizes [n_faces of the coarse mesh] */
static PetscErrorCode number_vertices(subdivision *s, const int32_t *sizes) {
    const subdomain *p = s->from;
    PetscInt n_edges = s->coarse_info.n_edges, n = p->n_vertices;
    PetscFunctionBeginUser;
    PetscInt *ends = COLLECTIVE_NEW(p->comm, PetscInt, 2 * (size_t)n_edges);
    for (PetscInt v = 0; v < n; v++) {
        s->vertex[v] = p->vertex[v];
        s->boundary[v] = p->boundary[v];
    }
    for (PetscInt f = 0, c = 0; f < p->n_faces; c += sizes[f++]) {
        s->vertex[s->children[4 * (size_t)c + 2]] = p->whole_vertices + p->whole_edges + p->face[f];
        for (int32_t k = 0; k < sizes[f]; k++) {
            const int32_t *here = s->children + 4 * (size_t)(c + k),
                          *next = s->children + 4 * (size_t)(c + (k + 1) % sizes[f]);
            PetscInt a = p->vertex[here[0]], b = p->vertex[next[0]], e = here[1] - n;
            ends[2 * e] = PetscMin(a, b);
            ends[2 * e + 1] = PetscMax(a, b);
            s->boundary[here[1]] |= (unsigned char)is_boundary_edge(p, here[0], next[0]);
        }
    }
    PetscCall(global_numbering_edges(p->comm, p->whole_vertices, n_edges, ends, s->vertex + n));
    for (PetscInt e = 0; e < n_edges; e++)
        s->vertex[n + e] += p->whole_vertices;
    free(ends);
    PetscFunctionReturn(0);
}

static PetscErrorCode subdivide(const subdomain *p, const double *own_xyz, const int32_t *sizes, subdivision *s) {
    curvopt_error error;
    PetscFunctionBeginUser;
    *s = (subdivision){.from = p};
    curvopt_mesh_get_info(p->mesh, &s->coarse_info, sizeof s->coarse_info);
    const curvopt_mesh_info *c = &s->coarse_info;
    size_t n_fine = (size_t)c->n_vertices + (size_t)c->n_edges + (size_t)c->n_faces;
    double *xyz = COLLECTIVE_NEW(p->comm, double, 3 * (size_t)p->n_vertices);
    int32_t *fine_sizes = COLLECTIVE_NEW(p->comm, int32_t, c->n_corners);
    s->xyz = COLLECTIVE_NEW(p->comm, double, 3 * n_fine);
    s->vertex = COLLECTIVE_NEW(p->comm, PetscInt, n_fine);
    s->boundary = COLLECTIVE_NEW(p->comm, unsigned char, n_fine);
    s->children = COLLECTIVE_NEW(p->comm, int32_t, 4 * (size_t)c->n_corners);
    PetscCall(subdomain_fetch(p, own_xyz, xyz));
    collective_check(p->comm, curvopt_mesh_refine(p->mesh, xyz, &s->fine, s->xyz, &error), &error);
    curvopt_mesh_get_info(s->fine, &s->info, sizeof s->info);
    curvopt_mesh_get_faces(s->fine, fine_sizes, s->children);
    PetscCall(number_vertices(s, sizes));
    free(fine_sizes);
    free(xyz);
    PetscFunctionReturn(0);
}

/* Boundary edges: halves of those before, as far as the new halo has them. place [fine vertices]: in the subdomain, or
 * -1 */
static void subdivide_boundary(const subdivision *s, const int32_t *sizes, const PetscInt *place, subdomain *out) {
    const subdomain *p = s->from;
    out->boundary_edges = COLLECTIVE_NEW(p->comm, PetscInt, 4 * (size_t)p->n_boundary_edges);
    for (PetscInt f = 0, c = 0; f < p->n_faces; c += sizes[f++])
        for (int32_t k = 0; p->n_boundary_edges && k < sizes[f]; k++) {
            const int32_t *here = s->children + 4 * (size_t)(c + k),
                          *next = s->children + 4 * (size_t)(c + (k + 1) % sizes[f]);
            PetscInt ends[3] = {place[here[0]], place[here[1]], place[next[0]]};
            for (int half = 0; half < 2 && is_boundary_edge(p, here[0], next[0]); half++)
                if (ends[half] >= 0 && ends[half + 1] >= 0) {
                    out->boundary_edges[2 * out->n_boundary_edges] = ends[half];
                    out->boundary_edges[2 * out->n_boundary_edges++ + 1] = ends[half + 1];
                }
        }
    qsort(out->boundary_edges, (size_t)out->n_boundary_edges, 2 * sizeof(PetscInt), compare_pairs);
}

/* The faces of a subdivision that the rank needs. */
static PetscErrorCode extract_subdomain(const subdivision *s, const int32_t *sizes, subdomain *out,
                                        int32_t *vertex_of) {
    const subdomain *p = s->from;
    curvopt_mesh_info info;
    curvopt_error error;
    PetscInt n_fine = s->info.n_faces, child = 0;
    PetscFunctionBeginUser;
    double *counts = COLLECTIVE_NEW(p->comm, double, n_fine);
    PetscInt *number = COLLECTIVE_NEW(p->comm, PetscInt, n_fine),
             *place = COLLECTIVE_NEW(p->comm, PetscInt, s->info.n_vertices);
    int32_t *face_of = COLLECTIVE_NEW(p->comm, int32_t, n_fine);
    for (PetscInt f = 0; f < p->n_faces; f++)
        for (int32_t k = 0; k < sizes[f]; k++, child++) {
            counts[child] = p->counts[f];
            number[child] = p->face_corner[f] + k;
        }
    collective_check(p->comm, curvopt_mesh_part(s->fine, counts, &out->mesh, vertex_of, face_of, &error), &error);
    curvopt_mesh_get_info(out->mesh, &info, sizeof info);
    out->n_vertices = info.n_vertices;
    out->n_faces = info.n_faces;
    out->vertex = COLLECTIVE_NEW(p->comm, PetscInt, info.n_vertices);
    out->boundary = COLLECTIVE_NEW(p->comm, unsigned char, info.n_vertices);
    out->face = COLLECTIVE_NEW(p->comm, PetscInt, info.n_faces);
    out->face_corner = COLLECTIVE_NEW(p->comm, PetscInt, info.n_faces);
    out->counts = COLLECTIVE_NEW(p->comm, double, info.n_faces);
    for (PetscInt v = 0; v < s->info.n_vertices; v++)
        place[v] = -1;
    for (PetscInt v = 0; v < info.n_vertices; v++) {
        place[vertex_of[v]] = v;
        out->vertex[v] = s->vertex[vertex_of[v]];
        out->boundary[v] = s->boundary[vertex_of[v]];
    }
    for (PetscInt f = 0; f < info.n_faces; f++) {
        out->face[f] = number[face_of[f]];
        out->face_corner[f] = 4 * out->face[f];
        out->counts[f] = counts[face_of[f]];
    }
    subdivide_boundary(s, sizes, place, out);
    free(counts);
    free(number);
    free(place);
    free(face_of);
    PetscFunctionReturn(0);
}

PetscErrorCode subdomain_subdivide(const subdomain *p, const double *own_xyz, subdomain *out, double **fine_xyz) {
    subdivision s;
    PetscFunctionBeginUser;
    *out = (subdomain){.comm = p->comm,
                       .whole_vertices = p->whole_vertices + p->whole_edges + p->whole_faces,
                       .whole_edges = 2 * p->whole_edges + p->whole_corners,
                       .whole_faces = p->whole_corners,
                       .whole_corners = 4 * p->whole_corners};
    curvopt_mesh_info info;
    curvopt_mesh_get_info(p->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(p->comm, int32_t, info.n_faces),
            *corners = COLLECTIVE_NEW(p->comm, int32_t, info.n_corners);
    curvopt_mesh_get_faces(p->mesh, sizes, corners);
    PetscCall(subdivide(p, own_xyz, sizes, &s));
    int32_t *vertex_of = COLLECTIVE_NEW(p->comm, int32_t, s.info.n_vertices);
    PetscCall(extract_subdomain(&s, sizes, out, vertex_of));
    PetscCall(subdomain_place(out));
    *fine_xyz = COLLECTIVE_NEW(p->comm, double, 3 * (size_t)out->n_own);
    for (PetscInt i = 0; i < out->n_own; i++)
        memcpy(*fine_xyz + 3 * (size_t)i, s.xyz + 3 * (size_t)vertex_of[out->own[i]], 3 * sizeof(double));
    subdivision_free(&s);
    free(vertex_of);
    free(sizes);
    free(corners);
    PetscFunctionReturn(0);
}

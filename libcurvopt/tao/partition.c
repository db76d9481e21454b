/* Distribution of a cage: the rank that has read it sends every rank its subdomain.
 *
 * Recursive bisection of the faces' centres (Berger, Bokhari 1987), by number of faces: subdomains differ by one
 * face at most, and their halos short where the cage's faces are about equally large.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "partition.h"

#include "collective.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the reading rank knows of the whole. */
typedef struct whole {
    const partition_source *source;
    MPI_Comm comm;
    curvopt_mesh_info info;
    int32_t *sizes, *vertices, *face_start;
    int32_t *rank_of;           /* [n_faces] */
    unsigned char *on_boundary; /* [n_corners] the edge after this corner is on the boundary */
    unsigned char *boundary;    /* [n_vertices] */
} whole;

static void whole_free(whole *w) {
    free(w->sizes);
    free(w->vertices);
    free(w->face_start);
    free(w->rank_of);
    free(w->on_boundary);
    free(w->boundary);
}

/* ------------------------------------------------------------------------------------------------ bisection -- */

typedef struct centre {
    double at[3];
    double key;
    int32_t face;
} centre;

static int compare_centres(const void *a, const void *b) {
    const centre *x = a, *y = b;
    return x->key != y->key ? (x->key > y->key) - (x->key < y->key) : (x->face > y->face) - (x->face < y->face);
}

/* Faces c [n] go to ranks first .. first + n_ranks - 1. */
static void bisect(centre *c, int32_t n, int first, int n_ranks, int32_t *rank_of) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    int axis = 0, left = n_ranks / 2;
    if (n_ranks == 1) {
        for (int32_t i = 0; i < n; i++)
            rank_of[c[i].face] = first;
        return;
    }
    for (int32_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], c[i].at[k]);
            high[k] = fmax(high[k], c[i].at[k]);
        }
    for (int k = 1; k < 3; k++)
        axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
    for (int32_t i = 0; i < n; i++)
        c[i].key = c[i].at[axis];
    qsort(c, (size_t)n, sizeof *c, compare_centres);
    int32_t n_left = (int32_t)((int64_t)n * left / n_ranks);
    bisect(c, n_left, first, left, rank_of);
    bisect(c + n_left, n - n_left, first + left, n_ranks - left, rank_of);
}

static void assign_faces(whole *w, int n_ranks) {
    centre *c = COLLECTIVE_NEW(w->comm, centre, w->info.n_faces);
    for (int32_t f = 0; f < w->info.n_faces; f++) {
        c[f].face = f;
        for (int32_t k = 0; k < w->sizes[f]; k++)
            for (int i = 0; i < 3; i++)
                c[f].at[i] += w->source->xyz[3 * (size_t)w->vertices[w->face_start[f] + k] + (size_t)i] / w->sizes[f];
    }
    bisect(c, w->info.n_faces, 0, n_ranks, w->rank_of);
    free(c);
}

/* Edges that one face has. The subdivision numbers edges for us: child k of a face has the edge after it second. */
static void find_boundary(whole *w) {
    curvopt_mesh *fine;
    curvopt_mesh_info info;
    curvopt_error error;
    if (!w->info.n_boundary_edges)
        return;
    collective_check(w->comm, curvopt_mesh_refine(w->source->mesh, NULL, &fine, NULL, &error), &error);
    curvopt_mesh_get_info(fine, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(w->comm, int32_t, info.n_faces),
            *children = COLLECTIVE_NEW(w->comm, int32_t, info.n_corners);
    unsigned char *seen = COLLECTIVE_NEW(w->comm, unsigned char, info.n_vertices);
    curvopt_mesh_get_faces(fine, sizes, children);
    for (int32_t c = 0; c < w->info.n_corners; c++)
        seen[children[4 * (size_t)c + 1]]++;
    for (int32_t f = 0; f < w->info.n_faces; f++)
        for (int32_t k = 0; k < w->sizes[f]; k++) {
            int32_t c = w->face_start[f] + k;
            w->on_boundary[c] = seen[children[4 * (size_t)c + 1]] == 1;
            if (w->on_boundary[c])
                w->boundary[w->vertices[c]] = w->boundary[w->vertices[w->face_start[f] + (k + 1) % w->sizes[f]]] = 1;
        }
    free(sizes);
    free(children);
    free(seen);
    curvopt_mesh_destroy(fine);
}

static whole look_at(MPI_Comm comm, const partition_source *source, int n_ranks) {
    whole w = {.source = source, .comm = comm};
    curvopt_mesh_get_info(source->mesh, &w.info, sizeof w.info);
    w.sizes = COLLECTIVE_NEW(comm, int32_t, w.info.n_faces);
    w.vertices = COLLECTIVE_NEW(comm, int32_t, w.info.n_corners);
    w.face_start = COLLECTIVE_NEW(comm, int32_t, w.info.n_faces);
    w.rank_of = COLLECTIVE_NEW(comm, int32_t, w.info.n_faces);
    w.on_boundary = COLLECTIVE_NEW(comm, unsigned char, w.info.n_corners);
    w.boundary = COLLECTIVE_NEW(comm, unsigned char, w.info.n_vertices);
    curvopt_mesh_get_faces(source->mesh, w.sizes, w.vertices);
    for (int32_t f = 1; f < w.info.n_faces; f++)
        w.face_start[f] = w.face_start[f - 1] + w.sizes[f - 1];
    assign_faces(&w, n_ranks);
    find_boundary(&w);
    return w;
}

/* -------------------------------------------------------------------------------------------------- packets -- */

/* Counts, then arrays one after the other. */
enum {
    N_VERTICES,
    N_FACES,
    N_CORNERS,
    N_CREASES,
    N_SHARP,
    N_BOUNDARY_EDGES,
    WHOLE_VERTICES,
    WHOLE_EDGES,
    WHOLE_FACES,
    WHOLE_CORNERS,
    N_COUNTS
};

typedef struct packet {
    int32_t count[N_COUNTS];
    int32_t *integers;
    double *reals;
    int32_t *vertex, *boundary, *face, *face_corner, *is_own, *sizes, *corners, *creases, *sharp,
        *boundary_edges;                               /* integers */
    double *xyz, *crease_sharpness, *corner_sharpness; /* reals */
} packet;

static size_t count_integers(const int32_t *n) {
    return 2 * (size_t)n[N_VERTICES] + 4 * (size_t)n[N_FACES] + (size_t)n[N_CORNERS] + 2 * (size_t)n[N_CREASES] +
           (size_t)n[N_SHARP] + 2 * (size_t)n[N_BOUNDARY_EDGES];
}

static size_t count_reals(const int32_t *n) {
    return 3 * (size_t)n[N_VERTICES] + (size_t)n[N_CREASES] + (size_t)n[N_SHARP];
}

/* Room for what the counts say. */
static void packet_allocate(MPI_Comm comm, packet *p) {
    const int32_t *n = p->count;
    p->integers = COLLECTIVE_NEW(comm, int32_t, count_integers(n));
    p->reals = COLLECTIVE_NEW(comm, double, count_reals(n));
    p->vertex = p->integers;
    p->boundary = p->vertex + n[N_VERTICES];
    p->face = p->boundary + n[N_VERTICES];
    p->face_corner = p->face + n[N_FACES];
    p->is_own = p->face_corner + n[N_FACES];
    p->sizes = p->is_own + n[N_FACES];
    p->corners = p->sizes + n[N_FACES];
    p->creases = p->corners + n[N_CORNERS];
    p->sharp = p->creases + 2 * (size_t)n[N_CREASES];
    p->boundary_edges = p->sharp + n[N_SHARP];
    p->xyz = p->reals;
    p->crease_sharpness = p->xyz + 3 * (size_t)n[N_VERTICES];
    p->corner_sharpness = p->crease_sharpness + n[N_CREASES];
}

static void packet_free(packet *p) {
    free(p->integers);
    free(p->reals);
}

static int compare_pairs(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* What stands in the whole's arrays, for the faces of a subdomain. */
static void fill_packet(const whole *w, int rank, const int32_t *vertex_of, const int32_t *face_of, packet *p) {
    int32_t n_boundary_edges = 0, at = 0;
    for (int32_t v = 0; v < p->count[N_VERTICES]; v++) {
        p->vertex[v] = vertex_of[v];
        p->boundary[v] = w->boundary[vertex_of[v]];
        memcpy(p->xyz + 3 * (size_t)v, w->source->xyz + 3 * (size_t)vertex_of[v], 3 * sizeof(double));
    }
    for (int32_t f = 0; f < p->count[N_FACES]; at += p->sizes[f++]) {
        p->face[f] = face_of[f];
        p->face_corner[f] = w->face_start[face_of[f]];
        p->is_own[f] = w->rank_of[face_of[f]] == rank;
        for (int32_t k = 0; k < p->sizes[f]; k++)
            if (w->on_boundary[p->face_corner[f] + k]) {
                p->boundary_edges[2 * n_boundary_edges] = p->corners[at + k];
                p->boundary_edges[2 * n_boundary_edges++ + 1] = p->corners[at + (k + 1) % p->sizes[f]];
            }
    }
    qsort(p->boundary_edges, (size_t)n_boundary_edges, 2 * sizeof *p->boundary_edges, compare_pairs);
}

static packet packet_for(const whole *w, int rank) {
    packet p = {.integers = NULL};
    curvopt_mesh *mesh;
    curvopt_mesh_info info;
    curvopt_error error;
    double *weight = COLLECTIVE_NEW(w->comm, double, w->info.n_faces);
    int32_t *vertex_of = COLLECTIVE_NEW(w->comm, int32_t, w->info.n_vertices),
            *face_of = COLLECTIVE_NEW(w->comm, int32_t, w->info.n_faces);
    for (int32_t f = 0; f < w->info.n_faces; f++)
        weight[f] = w->rank_of[f] == rank;
    collective_check(w->comm, curvopt_mesh_part(w->source->mesh, weight, &mesh, vertex_of, face_of, &error), &error);
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    p.count[N_VERTICES] = info.n_vertices;
    p.count[N_FACES] = info.n_faces;
    p.count[N_CORNERS] = info.n_corners;
    curvopt_mesh_count_creases(mesh, &p.count[N_CREASES], &p.count[N_SHARP]);
    for (int32_t f = 0; f < info.n_faces; f++)
        for (int32_t k = 0; k < w->sizes[face_of[f]]; k++)
            p.count[N_BOUNDARY_EDGES] += w->on_boundary[w->face_start[face_of[f]] + k];
    p.count[WHOLE_VERTICES] = w->info.n_vertices;
    p.count[WHOLE_EDGES] = w->info.n_edges;
    p.count[WHOLE_FACES] = w->info.n_faces;
    p.count[WHOLE_CORNERS] = w->info.n_corners;
    packet_allocate(w->comm, &p);
    curvopt_mesh_get_faces(mesh, p.sizes, p.corners);
    curvopt_mesh_get_creases(mesh, p.creases, p.crease_sharpness, p.sharp, p.corner_sharpness);
    fill_packet(w, rank, vertex_of, face_of, &p);
    curvopt_mesh_destroy(mesh);
    free(weight);
    free(vertex_of);
    free(face_of);
    return p;
}

enum { TAG_COUNTS = 1, TAG_INTEGERS, TAG_REALS };

static PetscErrorCode packet_send(MPI_Comm comm, const packet *p, int rank) {
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Send(p->count, N_COUNTS, MPI_INT32_T, rank, TAG_COUNTS, comm));
    PetscCallMPI(MPI_Send(p->integers, (int)count_integers(p->count), MPI_INT32_T, rank, TAG_INTEGERS, comm));
    PetscCallMPI(MPI_Send(p->reals, (int)count_reals(p->count), MPI_DOUBLE, rank, TAG_REALS, comm));
    PetscFunctionReturn(0);
}

static PetscErrorCode packet_receive(MPI_Comm comm, packet *p) {
    PetscFunctionBeginUser;
    *p = (packet){.integers = NULL};
    PetscCallMPI(MPI_Recv(p->count, N_COUNTS, MPI_INT32_T, 0, TAG_COUNTS, comm, MPI_STATUS_IGNORE));
    packet_allocate(comm, p);
    PetscCallMPI(
        MPI_Recv(p->integers, (int)count_integers(p->count), MPI_INT32_T, 0, TAG_INTEGERS, comm, MPI_STATUS_IGNORE));
    PetscCallMPI(MPI_Recv(p->reals, (int)count_reals(p->count), MPI_DOUBLE, 0, TAG_REALS, comm, MPI_STATUS_IGNORE));
    PetscFunctionReturn(0);
}

/* -------------------------------------------------------------------------------------------------- subdomain -- */

static PetscInt *as_indices(MPI_Comm comm, const int32_t *from, size_t n) {
    PetscInt *out = COLLECTIVE_NEW(comm, PetscInt, n);
    for (size_t i = 0; i < n; i++)
        out[i] = from[i];
    return out;
}

static PetscErrorCode unpack(MPI_Comm comm, const packet *p, subdomain *out, double **own_xyz) {
    const int32_t *n = p->count;
    curvopt_creases creases = {.crease_vertices = p->creases,
                               .crease_sharpness = p->crease_sharpness,
                               .corner_vertices = p->sharp,
                               .corner_sharpness = p->corner_sharpness,
                               .n_creases = n[N_CREASES],
                               .n_corners = n[N_SHARP]};
    curvopt_error error;
    PetscFunctionBeginUser;
    *out = (subdomain){.comm = comm,
                       .n_vertices = n[N_VERTICES],
                       .n_faces = n[N_FACES],
                       .n_boundary_edges = n[N_BOUNDARY_EDGES],
                       .whole_vertices = n[WHOLE_VERTICES],
                       .whole_edges = n[WHOLE_EDGES],
                       .whole_faces = n[WHOLE_FACES],
                       .whole_corners = n[WHOLE_CORNERS]};
    collective_check(
        comm, curvopt_mesh_create_part(n[N_VERTICES], n[N_FACES], p->sizes, p->corners, &creases, &out->mesh, &error),
        &error);
    out->vertex = as_indices(comm, p->vertex, (size_t)n[N_VERTICES]);
    out->face = as_indices(comm, p->face, (size_t)n[N_FACES]);
    out->face_corner = as_indices(comm, p->face_corner, (size_t)n[N_FACES]);
    out->boundary_edges = as_indices(comm, p->boundary_edges, 2 * (size_t)n[N_BOUNDARY_EDGES]);
    out->boundary = COLLECTIVE_NEW(comm, unsigned char, n[N_VERTICES]);
    out->counts = COLLECTIVE_NEW(comm, double, n[N_FACES]);
    for (int32_t v = 0; v < n[N_VERTICES]; v++)
        out->boundary[v] = (unsigned char)p->boundary[v];
    for (int32_t f = 0; f < n[N_FACES]; f++)
        out->counts[f] = p->is_own[f];
    PetscCall(subdomain_place(out));
    *own_xyz = COLLECTIVE_NEW(comm, double, 3 * (size_t)out->n_own);
    for (PetscInt i = 0; i < out->n_own; i++)
        memcpy(*own_xyz + 3 * (size_t)i, p->xyz + 3 * (size_t)out->own[i], 3 * sizeof(double));
    PetscFunctionReturn(0);
}

PetscErrorCode partition_cage(MPI_Comm comm, const partition_source *source, subdomain *out, double **own_xyz) {
    PetscMPIInt rank, n_ranks;
    packet mine;
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Comm_rank(comm, &rank));
    PetscCallMPI(MPI_Comm_size(comm, &n_ranks));
    if (rank == 0) {
        whole w = look_at(comm, source, n_ranks);
        for (int r = 1; r < n_ranks; r++) {
            packet p = packet_for(&w, r);
            PetscCall(packet_send(comm, &p, r));
            packet_free(&p);
        }
        mine = packet_for(&w, 0);
        whole_free(&w);
    } else {
        PetscCall(packet_receive(comm, &mine));
    }
    PetscCall(unpack(comm, &mine, out, own_xyz));
    packet_free(&mine);
    PetscFunctionReturn(0);
}

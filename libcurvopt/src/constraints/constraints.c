/* Vertices that a minimization does not move freely. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/constraints.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "mesh/crease.h"
#include "mesh/similarity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int32_t co_constraints_allocate(int32_t n_vertices, co_constraints *constraints, curvopt_error *error) {
    if (constraints->freedom)
        return CURVOPT_OK;
    constraints->freedom = CO_NEW(uint8_t, n_vertices);
    constraints->direction = CO_NEW(double, 3 * (size_t)n_vertices);
    constraints->anchor = CO_NEW(double, 3 * (size_t)n_vertices);
    constraints->of_limit = CO_NEW(uint8_t, n_vertices);
    constraints->subdivisions = CO_NEW(uint8_t, n_vertices);
    if (!constraints->freedom || !constraints->direction || !constraints->anchor || !constraints->of_limit ||
        !constraints->subdivisions) {
        co_constraints_free(constraints);
        return co_status_no_memory(error);
    }
    memset(constraints->freedom, CO_FREEDOM_ALL, (size_t)n_vertices);
    return CURVOPT_OK;
}

void co_constraints_free(co_constraints *constraints) {
    free(constraints->freedom);
    free(constraints->direction);
    free(constraints->anchor);
    free(constraints->of_limit);
    free(constraints->subdivisions);
    co_soft_constraints_free(&constraints->springs);
    co_surface_values_free(&constraints->values);
    co_surface_values_free(&constraints->drawn);
    co_chains_free(&constraints->chains);
    free(constraints->left_out);
    *constraints = (co_constraints){0};
}

int32_t co_constraints_leave_out(const curvopt_mesh *m, const int32_t *face, co_constraints *constraints,
                                 curvopt_error *error) {
    constraints->left_out = CO_NEW(uint8_t, m->info.n_faces);
    if (!constraints->left_out)
        return co_status_no_memory(error);
    for (int32_t f = 0; f < m->info.n_faces; f++)
        constraints->left_out[f] = face[f] >= 0;
    return CURVOPT_OK;
}

/* The vertex itself, whatever else was constrained. */
static void hold_vertex(co_constraints *constraints, int32_t v) {
    constraints->freedom[v] = CO_FREEDOM_NONE;
    constraints->of_limit[v] = CO_OF_VERTEX;
}

int32_t co_constraints_copy_left_out(const curvopt_mesh *m, const co_constraints *from, co_constraints *to,
                                     curvopt_error *error) {
    if (!from->left_out)
        return CURVOPT_OK;
    to->left_out = CO_NEW(uint8_t, m->info.n_faces);
    if (!to->left_out)
        return co_status_no_memory(error);
    memcpy(to->left_out, from->left_out, (size_t)m->info.n_faces);
    return CURVOPT_OK;
}

int32_t co_constraints_copy(const curvopt_mesh *m, const co_constraints *from, co_constraints *to,
                            curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    *to = (co_constraints){0};
    int32_t status = co_constraints_copy_left_out(m, from, to, error);
    if (!from->freedom || status != CURVOPT_OK)
        return status;
    status = co_constraints_allocate(m->info.n_vertices, to, error);
    if (status != CURVOPT_OK)
        return status;
    memcpy(to->freedom, from->freedom, n);
    memcpy(to->direction, from->direction, 3 * n * sizeof(double));
    memcpy(to->anchor, from->anchor, 3 * n * sizeof(double));
    memcpy(to->of_limit, from->of_limit, n);
    memcpy(to->subdivisions, from->subdivisions, n);
    status = co_soft_constraints_copy(m, &from->springs, &to->springs, error);
    if (status == CURVOPT_OK)
        status = co_surface_values_copy(&from->values, &to->values, error);
    if (status == CURVOPT_OK)
        status = co_surface_values_copy(&from->drawn, &to->drawn, error);
    if (status != CURVOPT_OK)
        co_constraints_free(to);
    return status;
}

static int same_constraint(const co_constraints *constraints, int32_t v, int32_t w) {
    int freedom = constraints->freedom[v];
    if (freedom != constraints->freedom[w] || constraints->of_limit[v] != constraints->of_limit[w])
        return 0;
    return freedom == CO_FREEDOM_NONE || freedom == CO_FREEDOM_ALL ||
           co_freedom_same_direction(constraints->direction + 3 * (size_t)v, constraints->direction + 3 * (size_t)w);
}

int32_t co_constraints_pull_back(const curvopt_mesh *m, const double *xyz, const double *stiffness, double reach,
                                 co_constraints *constraints, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    if (!constraints->freedom) {
        status = co_constraints_allocate(m->info.n_vertices, constraints, error);
        if (status == CURVOPT_OK)
            memcpy(constraints->anchor, xyz, 3 * (size_t)m->info.n_vertices * sizeof *xyz);
    }
    if (status == CURVOPT_OK)
        status = co_soft_constraints_add_all(m, xyz, stiffness, reach, &constraints->springs, error);
    if (status != CURVOPT_OK)
        co_constraints_free(constraints);
    return status;
}

/* Vertex `to` of the finer cage, at xyz, inherits the constraint of vertex `from` of the coarser one. */
static void inherit(const co_constraints *coarse, int32_t from, const double *xyz, co_constraints *fine, int32_t to) {
    fine->freedom[to] = coarse->freedom[from];
    fine->of_limit[to] = coarse->of_limit[from];
    fine->subdivisions[to] = coarse->subdivisions[from];
    memcpy(fine->direction + 3 * (size_t)to, coarse->direction + 3 * (size_t)from, 3 * sizeof(double));
    memcpy(fine->anchor + 3 * (size_t)to, xyz + 3 * (size_t)to, 3 * sizeof(double));
}

static int is_constrained_face(const curvopt_mesh *m, const co_constraints *constraints, int32_t f) {
    int32_t first = m->corner_vertex[m->face_start[f]];
    if (constraints->freedom[first] == CO_FREEDOM_ALL || constraints->of_limit[first])
        return 0;
    for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++)
        if (!same_constraint(constraints, first, m->corner_vertex[h]))
            return 0;
    return 1;
}

int co_constraints_are_of_face(const curvopt_mesh *m, const co_constraints *constraints, int32_t v) {
    const int32_t first = m->vertex_corner[v];
    for (int32_t h = first; h >= 0; h = co_mesh_rotate(m, h)) {
        if (is_constrained_face(m, constraints, m->corner_face[h]))
            return 1;
        if (co_mesh_rotate(m, h) == first)
            break;
    }
    return 0;
}

/* A subdivision fewer follows; after the last the vertex is where it was to be. */
static void come_nearer(co_constraints *constraints, int32_t v) {
    if (constraints->subdivisions[v] && !--constraints->subdivisions[v])
        constraints->of_limit[v] = CO_OF_VERTEX;
}

void co_constraints_visit_own_point(const curvopt_mesh *m, const co_constraints *constraints, int32_t v,
                                    co_vertex_mask_fn visit, void *context) {
    const int32_t subdivisions = constraints->subdivisions[v];
    co_vertex_mask_visit_after(m, v, subdivisions ? subdivisions : CO_VERTEX_MASK_LIMIT, visit, context);
}

void co_constraints_put_back(const co_constraints *constraints, int32_t v, double x[3]) {
    const double *anchor = constraints->anchor + 3 * (size_t)v, *d = constraints->direction + 3 * (size_t)v;
    double off[3] = {x[0] - anchor[0], x[1] - anchor[1], x[2] - anchor[2]};
    double along = co_dot3(off, d);
    for (int c = 0; c < 3; c++) {
        if (constraints->freedom[v] == CO_FREEDOM_NONE)
            x[c] = anchor[c];
        else if (constraints->freedom[v] == CO_FREEDOM_LINE)
            x[c] = anchor[c] + along * d[c];
        else if (constraints->freedom[v] == CO_FREEDOM_PLANE)
            x[c] -= along * d[c];
    }
}

/* Where chains share a vertex the first one counts. */
int32_t co_constraints_hold_chains(const curvopt_mesh *m, co_constraints *constraints, curvopt_error *error) {
    for (int32_t k = constraints->chains.n - 1; k >= 0; k--) {
        const co_chain *chain = &constraints->chains.item[k];
        for (int32_t i = 0; chain->stiffness == 0 && i < chain->n; i++) {
            const int32_t v = chain->vertex[i];
            constraints->freedom[v] = CO_FREEDOM_NONE;
            constraints->of_limit[v] = CO_OF_OWN_POINT;
            co_chain_place(chain, i, constraints->anchor + 3 * (size_t)v);
        }
    }
    if (!constraints->chains.n)
        return CURVOPT_OK;
    co_chains_hold_middles(m, &constraints->chains, &constraints->values);
    return co_chains_draw(m, &constraints->chains, &constraints->drawn, error);
}

/* Child h of the finer cage comes from the face that corner h is in. */
int32_t co_constraints_subdivide_left_out(const curvopt_mesh *m, co_constraints *constraints, curvopt_error *error) {
    if (!constraints->left_out)
        return CURVOPT_OK;
    uint8_t *fine = CO_NEW(uint8_t, m->info.n_corners);
    if (!fine)
        return co_status_no_memory(error);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        fine[h] = constraints->left_out[m->corner_face[h]];
    free(constraints->left_out);
    constraints->left_out = fine;
    return CURVOPT_OK;
}

int32_t co_constraints_subdivide(const curvopt_mesh *m, const curvopt_mesh *fine, const co_sparse_rows *rows,
                                 double *xyz, co_constraints *constraints, curvopt_error *error) {
    co_constraints out = {0};
    int32_t n = m->info.n_vertices, n_edges = m->info.n_edges;
    int32_t status = co_constraints_subdivide_left_out(m, constraints, error);
    if (!constraints->freedom || status != CURVOPT_OK)
        return status;
    status = co_chains_subdivide(m, &constraints->chains, error);
    if (status == CURVOPT_OK)
        status = co_constraints_allocate(fine->info.n_vertices, &out, error);
    if (status == CURVOPT_OK)
        status = co_soft_constraints_subdivide(m, fine, rows, &constraints->springs, error);
    if (status != CURVOPT_OK) {
        co_constraints_free(&out);
        return status;
    }
    out.springs = constraints->springs;
    out.left_out = constraints->left_out;
    out.values = constraints->values;
    out.drawn = constraints->drawn;
    out.chains = constraints->chains;
    co_surface_values_subdivide(m, &out.values);
    co_surface_values_subdivide(m, &out.drawn);
    constraints->values = constraints->drawn = (co_surface_values){0};
    constraints->chains = (co_chains){0};
    constraints->springs = (co_soft_constraints){0};
    constraints->left_out = NULL;
    for (int32_t f = 0; f < m->info.n_faces; f++) {
        if (!is_constrained_face(m, constraints, f))
            continue;
        inherit(constraints, m->corner_vertex[m->face_start[f]], xyz, &out, n + n_edges + f);
        for (int32_t h = m->face_start[f]; h < m->face_start[f + 1]; h++) {
            inherit(constraints, m->corner_vertex[h], xyz, &out, m->corner_vertex[h]);
            inherit(constraints, m->corner_vertex[h], xyz, &out, n + m->edge[h]);
        }
    }
    for (int32_t v = 0; v < n; v++)
        if (out.freedom[v] == CO_FREEDOM_ALL && constraints->freedom[v] != CO_FREEDOM_ALL) {
            inherit(constraints, v, constraints->anchor, &out, v);
            come_nearer(&out, v);
            if (out.of_limit[v])
                continue;
            co_constraints_put_back(&out, v, xyz + 3 * (size_t)v);
            co_soft_constraints_drop_beyond(&out.springs, v, xyz + 3 * (size_t)v);
        }
    status = co_constraints_hold_chains(fine, &out, error);
    co_constraints_free(constraints);
    *constraints = out;
    if (status != CURVOPT_OK)
        co_constraints_free(constraints);
    return status;
}

/* Adds the next row: vertices of faces with a marked one. face [n_faces] is work space. */
static void add_row(const curvopt_mesh *m, uint8_t *mark, uint8_t *face) {
    memset(face, 0, (size_t)m->info.n_faces);
    for (int32_t h = 0; h < m->info.n_corners; h++)
        face[m->corner_face[h]] |= mark[m->corner_vertex[h]];
    for (int32_t h = 0; h < m->info.n_corners; h++)
        mark[m->corner_vertex[h]] |= face[m->corner_face[h]];
}

int32_t co_constraints_mark_rows(const curvopt_mesh *m, int32_t boundary, uint8_t *mark, curvopt_error *error) {
    int rows = boundary == CURVOPT_BOUNDARY_CURVATURE ? 2 : boundary == CURVOPT_BOUNDARY_TANGENT;
    uint8_t *face = CO_NEW(uint8_t, m->info.n_faces), *row = CO_NEW(uint8_t, m->info.n_vertices);
    int32_t status = face && row ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        row[v] = (uint8_t)co_mesh_is_boundary_vertex(m, v);
    for (int k = 0; status == CURVOPT_OK && k < rows; k++)
        add_row(m, row, face);
    for (int32_t v = 0; status == CURVOPT_OK && v < m->info.n_vertices; v++)
        mark[v] |= row[v];
    free(face);
    free(row);
    return status;
}

static void mark_sharp(const curvopt_mesh *m, uint8_t *mark) {
    for (int32_t v = 0; v < m->info.n_vertices; v++)
        mark[v] |= co_crease_is_infinite(co_crease_vertex(m, v));
    for (int32_t h = 0; h < m->info.n_corners; h++)
        if (co_crease_is_infinite(co_crease_edge(m, h)))
            mark[m->corner_vertex[h]] = mark[co_mesh_destination(m, h)] = 1;
}

int32_t co_constraints_boundary(const curvopt_mesh *m, int32_t boundary, co_constraints *constraints,
                                curvopt_error *error) {
    int any = 0;
    if (boundary == CURVOPT_BOUNDARY_FREE || !(m->info.n_boundary_edges || m->edge_sharpness || m->vertex_sharpness))
        return CURVOPT_OK;
    uint8_t *mark = CO_NEW(uint8_t, m->info.n_vertices);
    int32_t status = mark ? co_constraints_mark_rows(m, boundary, mark, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        mark_sharp(m, mark);
        for (int32_t v = 0; v < m->info.n_vertices; v++)
            any |= mark[v];
        if (any)
            status = co_constraints_allocate(m->info.n_vertices, constraints, error);
        for (int32_t v = 0; any && status == CURVOPT_OK && v < m->info.n_vertices; v++)
            if (mark[v])
                hold_vertex(constraints, v);
    }
    free(mark);
    return status;
}

static int32_t hold_exceptions(const curvopt_mesh *m, co_constraints *all, curvopt_error *error) {
    if (!all->left_out && !m->info.n_isolated)
        return CURVOPT_OK;
    int32_t status = co_constraints_allocate(m->info.n_vertices, all, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < m->info.n_isolated; i++)
        hold_vertex(all, m->isolated[i]);
    for (int32_t h = 0; status == CURVOPT_OK && all->left_out && h < m->info.n_corners; h++)
        if (all->left_out[m->corner_face[h]])
            hold_vertex(all, m->corner_vertex[h]);
    return status;
}

int32_t co_constraints_all(const curvopt_mesh *m, const co_constraints *constraints, int32_t boundary,
                           co_constraints *out, curvopt_error *error) {
    int32_t status = co_constraints_copy(m, constraints, out, error);
    if (status == CURVOPT_OK)
        status = co_constraints_boundary(m, boundary, out, error);
    return status == CURVOPT_OK ? hold_exceptions(m, out, error) : status;
}

/* ------------------------------------------------------------------------------------ motion of the shape -- */

/* The frame of motion at a vertex: a shape's vertex moves along the normal; on a boundary or an infinitely sharp crease
 * across the curve, and at its corners anywhere. Whatever else it does it slides in the surface. */
typedef struct vertex_frame {
    double normal[3];  /* sum over the corners, not of unit length */
    double tangent[3]; /* of the curve, if there is one: difference of the two neighbours on it */
    int n_sharp;       /* edges of the curve that end here */
} vertex_frame;

/* In units of `radius`, without which squares of 1e99 would overflow. */
static void add_corner(const curvopt_mesh *m, const double *xyz, double radius, int32_t h, vertex_frame *frame) {
    const double *p = xyz + 3 * (size_t)m->corner_vertex[h], *a = xyz + 3 * (size_t)co_mesh_destination(m, h),
                 *b = xyz + 3 * (size_t)m->corner_vertex[co_mesh_prev(m, h)];
    double u[3], v[3];
    for (int c = 0; c < 3; c++) {
        u[c] = (a[c] - p[c]) / radius;
        v[c] = (b[c] - p[c]) / radius;
    }
    vertex_frame *at = &frame[m->corner_vertex[h]], *to = &frame[co_mesh_destination(m, h)];
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        at->normal[c] += u[d] * v[e] - u[e] * v[d];
    }
    if (!co_crease_is_infinite(co_crease_edge(m, h)) || (m->twin[h] >= 0 && m->twin[h] < h))
        return;
    for (int c = 0; c < 3; c++) { /* the second edge has the other sign */
        at->tangent[c] += at->n_sharp % 2 ? -u[c] : u[c];
        to->tangent[c] += to->n_sharp % 2 ? u[c] : -u[c];
    }
    at->n_sharp++;
    to->n_sharp++;
}

static double make_unit(double d[3]) {
    double length = co_length3(d);
    for (int c = 0; c < 3 && length > 0; c++)
        d[c] /= length;
    return length;
}

/* How a vertex moves that changes the shape, were it free: freedom and direction as in co_constraints. */
static int shape_freedom(const curvopt_mesh *m, int32_t v, vertex_frame *frame, double direction[3]) {
    int on_curve = frame->n_sharp == 2 && make_unit(frame->tangent) > 0;
    int is_corner = frame->n_sharp > 2 || co_crease_is_infinite(co_crease_vertex(m, v));
    if (is_corner)
        return CO_FREEDOM_ALL;
    memcpy(direction, on_curve ? frame->tangent : frame->normal, 3 * sizeof *direction);
    return on_curve ? CO_FREEDOM_PLANE : make_unit(direction) > 0 ? CO_FREEDOM_LINE : CO_FREEDOM_NONE;
}

/* Sine of the angle from which on a constraint lets a vertex change the shape and not only slide. */
static const double TRANSVERSAL = 0.1;

/* What a constraint leaves of the shape's motion, into *freedom and direction, which begin as that motion: the
 * constraint's directions that are nearest to it. */
static void restrict_motion(int held, const double along[3], int *freedom, double direction[3]) {
    double other[3];
    if (held == CO_FREEDOM_ALL || *freedom == CO_FREEDOM_NONE)
        return;
    if (*freedom == CO_FREEDOM_ALL || held == CO_FREEDOM_NONE) {
        *freedom = held;
        memcpy(direction, along, 3 * sizeof *direction);
        return;
    }
    double cosine = co_dot3(direction, along);
    double sine = co_freedom_sine(direction, along);
    if (held == CO_FREEDOM_LINE) {
        double part = *freedom == CO_FREEDOM_LINE ? fabs(cosine) : sine;
        *freedom = part > TRANSVERSAL ? CO_FREEDOM_LINE : CO_FREEDOM_NONE;
        memcpy(direction, along, 3 * sizeof *direction);
    } else if (*freedom == CO_FREEDOM_LINE) { /* in the plane across `along` */
        for (int c = 0; c < 3; c++)
            direction[c] -= cosine * along[c];
        *freedom = make_unit(direction) > TRANSVERSAL ? CO_FREEDOM_LINE : CO_FREEDOM_NONE;
    } else if (sine > TRANSVERSAL) { /* where two planes meet */
        co_cross3(direction, along, other);
        make_unit(other);
        memcpy(direction, other, sizeof other);
        *freedom = CO_FREEDOM_LINE;
    } else {
        memcpy(direction, along, 3 * sizeof *direction);
    }
}

int32_t co_constraints_to_normals(const curvopt_mesh *m, const co_constraints *all, const double *xyz,
                                  co_constraints *out, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    double centroid[3], radius = co_similarity_mesh_frame(m, xyz, centroid);
    vertex_frame *frame = CO_NEW(vertex_frame, n);
    *out = (co_constraints){0};
    int32_t status = frame ? co_constraints_allocate(m->info.n_vertices, out, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_constraints_copy_left_out(m, all, out, error);
    if (status == CURVOPT_OK)
        status = co_soft_constraints_copy(m, &all->springs, &out->springs, error);
    for (int32_t h = 0; status == CURVOPT_OK && h < m->info.n_corners; h++)
        add_corner(m, xyz, radius, h, frame);
    for (size_t v = 0; status == CURVOPT_OK && v < n; v++) {
        int freedom = shape_freedom(m, (int32_t)v, &frame[v], out->direction + 3 * v);
        if (all->freedom)
            restrict_motion(all->freedom[v], all->direction + 3 * v, &freedom, out->direction + 3 * v);
        out->freedom[v] = (uint8_t)freedom;
    }
    if (status == CURVOPT_OK && all->freedom) {
        memcpy(out->of_limit, all->of_limit, n);
        memcpy(out->subdivisions, all->subdivisions, n);
    }
    if (status != CURVOPT_OK)
        co_constraints_free(out);
    free(frame);
    return status;
}

int co_constraints_allow_motion(const curvopt_mesh *m, const co_constraints *constraints) {
    for (int32_t v = 0; constraints->freedom && v < m->info.n_vertices; v++)
        if (constraints->freedom[v] != CO_FREEDOM_NONE)
            return 1;
    return !constraints->freedom;
}

int32_t co_constraints_refuse(const curvopt_mesh *m, curvopt_error *error) {
    return co_status_fail(
        error, CURVOPT_ERROR_ARGUMENT, -1,
        "nothing may move: all %d vertices are held by pins, boundary, creases or as exceptions; hold "
        "less, or use more levels",
        m->info.n_vertices);
}

/* The variables of a minimization. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/dof_map.h"

#include "base/memory.h"
#include "linalg/small_dense.h"
#include "linalg/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of a unit translation that must keep the symmetry for it to count as one: what keeps it does so wholly, or not
 * at all. */
static const double TRANSLATES = 1e-6;
enum { FIXED = -1, UNSEEN = -2 };
/* Length from which on a projector's column counts as in its range, at first. One of the columns of a projector onto k
 * dimensions has a length of at least sqrt(k / 3). */
static const double IN_PLANE = 0.5;

void co_dof_map_free(co_dof_map *r) {
    free(r->node);
    free(r->first);
    free(r->basis);
    free(r->offset);
    free(r->stretch);
    free(r->translation);
    *r = (co_dof_map){0};
}

int32_t co_dof_map_identity(int32_t n, co_dof_map *r, curvopt_error *error) {
    *r = (co_dof_map){.n_vertices = n, .n_nodes = n, .n_variables = 3 * n, .plain = 1};
    r->node = CO_NEW(int32_t, n);
    r->first = CO_NEW(int32_t, (size_t)n + 1);
    r->basis = CO_NEW(double, 9 * (size_t)n);
    if (!r->node || !r->first || !r->basis) {
        co_dof_map_free(r);
        return co_status_no_memory(error);
    }
    for (int32_t v = 0; v < n; v++) {
        r->node[v] = v;
        r->first[v + 1] = 3 * (v + 1);
        for (int c = 0; c < 3; c++)
            r->basis[9 * (size_t)v + 4 * (size_t)c] = 1;
    }
    return CURVOPT_OK;
}

/* Orthonormal columns that span a projector's range, by Gram and Schmidt; their number. Axes are tried first, so that
 * the identity's basis is the identity. */
static int range_of(const double projector[9], double basis[9]) {
    int n = 0;
    memset(basis, 0, 9 * sizeof(double));
    for (double least = IN_PLANE; least > 1e-3 && n < 3; least *= 0.3)
        for (int j = 0; j < 3 && n < 3; j++) {
            double column[3] = {projector[j], projector[3 + j], projector[6 + j]}, square = 0;
            for (int k = 0; k < n; k++) {
                double along = column[0] * basis[k] + column[1] * basis[3 + k] + column[2] * basis[6 + k];
                for (int i = 0; i < 3; i++)
                    column[i] -= along * basis[3 * i + k];
            }
            for (int i = 0; i < 3; i++)
                square += column[i] * column[i];
            if (square < least * least)
                continue;
            for (int i = 0; i < 3; i++)
                basis[3 * i + n] = column[i] / sqrt(square);
            n++;
        }
    return n;
}

/* Directions in which vertex v may move so that its orbit keeps the symmetry: those that its stabilizer fixes. *size is
 * the orbit's. */
static void free_directions(const curvopt_mesh *m, const co_symmetry *s, const co_constraints *constraints, int32_t v,
                            double projector[9], int32_t *size) {
    double mean[9] = {0}, own[9];
    int32_t stabilizer = 0;
    for (int32_t g = 0; g < s->order; g++)
        if (co_symmetry_vertex(s, m, g, v) == v) {
            for (int k = 0; k < 9; k++)
                mean[k] += s->matrix[9 * (size_t)g + (size_t)k];
            stabilizer++;
        }
    for (int k = 0; k < 9; k++)
        mean[k] /= stabilizer;
    co_freedom_projector(constraints->freedom ? constraints->freedom[v] : CO_FREEDOM_ALL,
                         constraints->freedom ? constraints->direction + 3 * (size_t)v : NULL, own);
    co_small_dense_multiply_3(mean, own, projector);
    *size = s->order / stabilizer;
}

/* The orbit of v becomes a node, unless it cannot move. */
static void add_orbit(const curvopt_mesh *m, const co_symmetry *s, const co_constraints *constraints, int32_t v,
                      co_dof_map *r) {
    double projector[9], basis[9];
    int32_t size;
    free_directions(m, s, constraints, v, projector, &size);
    int n = range_of(projector, basis);
    double stretch = 1 / sqrt((double)size);
    for (int32_t g = 0; g < s->order; g++) {
        int32_t w = co_symmetry_vertex(s, m, g, v);
        double *to = r->basis + 9 * (size_t)w;
        if (r->node[w] != UNSEEN)
            continue;
        r->node[w] = n ? r->n_nodes : FIXED;
        co_small_dense_multiply_3(s->matrix + 9 * (size_t)g, basis, to);
        for (int k = 0; k < 9; k++)
            to[k] *= stretch;
    }
    if (!n)
        return;
    r->stretch[r->n_nodes++] = stretch;
    r->n_variables += n;
    r->first[r->n_nodes] = r->n_variables;
}

/* Offset of constrained vertices: the part of x that no variables reach. z is work space. */
static void find_offset(co_dof_map *r, const co_constraints *constraints, const double *x, double *z) {
    size_t n = 3 * (size_t)r->n_vertices;
    double *offset = r->offset;
    r->offset = NULL;
    co_dof_map_variables(r, x, z);
    co_dof_map_expand(r, z, offset);
    for (size_t i = 0; i < n; i++)
        offset[i] = constraints->freedom[i / 3] == CO_FREEDOM_ALL ? 0 : x[i] - offset[i];
    r->offset = offset;
}

/* z += B_v^T x */
static void project_vertex(const co_dof_map *r, int32_t v, const double x[3], double *z) {
    const double *basis = r->basis + 9 * (size_t)v;
    if (r->node[v] == FIXED)
        return;
    int32_t first = r->first[r->node[v]], n = r->first[r->node[v] + 1] - first;
    for (int c = 0; c < 3; c++)
        for (int32_t k = 0; k < n; k++)
            z[first + k] += basis[3 * c + k] * x[c];
}

/* Every translation t has columns of length sqrt(n_vertices), or is 0: what of it keeps the symmetry is a translation
 * again, and B^T of it. */
static int32_t find_translations(co_dof_map *r, curvopt_error *error) {
    size_t n = (size_t)r->n_variables;
    r->translation = CO_NEW(double, 3 * n);
    if (!r->translation)
        return co_status_no_memory(error);
    for (size_t axis = 0; axis < 3; axis++) {
        double *t = r->translation + axis * n, unit[3] = {axis == 0, axis == 1, axis == 2}, whole = sqrt(r->n_vertices);
        for (int32_t v = 0; v < r->n_vertices; v++)
            project_vertex(r, v, unit, t);
        co_vector_remove(n, axis, r->translation, t); /* a symmetry's axis may be askew */
        double norm = co_vector_norm(n, t);
        for (size_t k = 0; k < n; k++)
            t[k] = norm > TRANSLATES * whole ? t[k] / norm : 0;
    }
    return CURVOPT_OK;
}

int32_t co_dof_map_create(const curvopt_mesh *m, const co_symmetry *s, const co_constraints *constraints,
                          const double *x, co_dof_map *r, curvopt_error *error) {
    size_t n = (size_t)m->info.n_vertices;
    double *z = constraints->freedom ? CO_NEW(double, 3 * n) : NULL;
    *r = (co_dof_map){.n_vertices = m->info.n_vertices,
                      .node = CO_NEW(int32_t, n),
                      .first = CO_NEW(int32_t, n + 1),
                      .basis = CO_NEW(double, 9 * n),
                      .offset = constraints->freedom ? CO_NEW(double, 3 * n) : NULL,
                      .stretch = CO_NEW(double, n),
                      .plain = s->order == 1 && !constraints->freedom};
    if (!r->node || !r->first || !r->basis || !r->stretch || (constraints->freedom && (!z || !r->offset))) {
        free(z);
        co_dof_map_free(r);
        return co_status_no_memory(error);
    }
    for (size_t v = 0; v < n; v++)
        r->node[v] = UNSEEN;
    for (int32_t v = 0; v < r->n_vertices; v++)
        if (r->node[v] == UNSEEN)
            add_orbit(m, s, constraints, v, r);
    int32_t status = CURVOPT_OK;
    if (constraints->freedom)
        find_offset(r, constraints, x, z);
    else
        status = find_translations(r, error);
    free(z);
    if (status != CURVOPT_OK)
        co_dof_map_free(r);
    return status;
}

static void expand_vertex(const co_dof_map *r, int32_t v, const double *z, double *x) {
    const double *basis = r->basis + 9 * (size_t)v;
    for (int c = 0; c < 3; c++)
        x[c] = r->offset ? r->offset[3 * (size_t)v + (size_t)c] : 0;
    if (r->node[v] == FIXED)
        return;
    int32_t first = r->first[r->node[v]], n = r->first[r->node[v] + 1] - first;
    for (int c = 0; c < 3; c++)
        for (int32_t k = 0; k < n; k++)
            x[c] += basis[3 * c + k] * z[first + k];
}

void co_dof_map_expand_some(const co_dof_map *r, const int32_t *vertices, int32_t n, const double *z, double *x) {
    if (!vertices) {
        co_dof_map_expand(r, z, x);
        return;
    }
    for (int32_t i = 0; i < n; i++)
        expand_vertex(r, vertices[i], z, x + 3 * (size_t)vertices[i]);
}

void co_dof_map_expand(const co_dof_map *r, const double *z, double *x) {
    if (r->plain) {
        memcpy(x, z, sizeof *x * 3 * (size_t)r->n_vertices);
        return;
    }
    for (int32_t v = 0; v < r->n_vertices; v++)
        expand_vertex(r, v, z, x + 3 * (size_t)v);
}

void co_dof_map_variables(const co_dof_map *r, const double *x, double *z) {
    memset(z, 0, sizeof *z * (size_t)r->n_variables);
    for (int32_t v = 0; v < r->n_vertices; v++, x += 3) {
        double at[3] = {x[0], x[1], x[2]};
        for (int c = 0; c < 3 && r->offset; c++)
            at[c] -= r->offset[3 * (size_t)v + (size_t)c];
        project_vertex(r, v, at, z);
    }
}

void co_dof_map_gradient_of(const co_dof_map *r, const int32_t *vertices, int32_t n, const double *gx, double *gz) {
    if (r->plain && !vertices) {
        memcpy(gz, gx, sizeof *gz * 3 * (size_t)r->n_vertices);
        return;
    }
    memset(gz, 0, sizeof *gz * (size_t)r->n_variables);
    n = vertices ? n : r->n_vertices;
    for (int32_t i = 0; i < n; i++) {
        int32_t v = vertices ? vertices[i] : i;
        project_vertex(r, v, gx + 3 * (size_t)v, gz);
    }
}

void co_dof_map_gradient(const co_dof_map *r, const double *gx, double *gz) {
    co_dof_map_gradient_of(r, NULL, 0, gx, gz);
}

/* ------------------------------------------------------------------------------------- centroid and size -- */

/* v -= its part along translations. */
static void remove_translations(const co_dof_map *r, double *v) {
    co_vector_remove((size_t)r->n_variables, 3, r->translation, v);
}

double co_dof_map_normalize(const co_dof_map *r, const double *z, double *normalized) {
    size_t n = (size_t)r->n_variables;
    memcpy(normalized, z, n * sizeof *z);
    remove_translations(r, normalized);
    double radius = co_vector_norm(n, normalized) / sqrt(r->n_vertices);
    for (size_t k = 0; k < n; k++)
        normalized[k] /= radius;
    return radius;
}

void co_dof_map_normalized_gradient(const co_dof_map *r, const double *normalized, double radius, double *gz) {
    size_t n = (size_t)r->n_variables;
    remove_translations(r, gz);
    co_vector_add(n, -co_vector_dot(n, gz, normalized) / r->n_vertices, normalized, gz);
    for (size_t k = 0; k < n; k++)
        gz[k] /= radius;
}

double co_dof_map_longest(const co_dof_map *r, const double *dz) {
    double longest = 0;
    for (int32_t node = 0; node < r->n_nodes; node++) {
        double square = 0;
        for (int32_t k = r->first[node]; k < r->first[node + 1]; k++)
            square += dz[k] * dz[k];
        longest = fmax(longest, r->stretch[node] * sqrt(square));
    }
    return longest;
}

int32_t co_dof_map_face_weights(const curvopt_mesh *m, const co_symmetry *s, double **weight, curvopt_error *error) {
    uint8_t *seen = CO_NEW(uint8_t, m->info.n_faces);
    *weight = CO_NEW(double, m->info.n_faces);
    if (!seen || !*weight) {
        free(seen);
        free(*weight);
        *weight = NULL;
        return co_status_no_memory(error);
    }
    for (int32_t f = 0; f < m->info.n_faces; f++) {
        for (int32_t g = 0; !seen[f] && g < s->order; g++) {
            int32_t image = m->corner_face[s->corner[(size_t)g * (size_t)s->n_corners + (size_t)m->face_start[f]]];
            if (image > f && !seen[image]) {
                seen[image] = 1;
                (*weight)[f]++;
            }
        }
        (*weight)[f] += !seen[f]; /* itself */
    }
    free(seen);
    return CURVOPT_OK;
}

/* The penalty that soft constraints add to the objective. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/penalty.h"

#include "base/constants.h"
#include "base/elementary.h"
#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

double co_penalty_stiffness(const double weights[CURVOPT_N_TERMS]) {
    static const double stiffness[CURVOPT_N_TERMS] = {
        [CURVOPT_TERM_WILLMORE] = 24 * CO_PI,
        [CURVOPT_TERM_MVS] = 2979.1973808604575,
        [CURVOPT_TERM_MVS_CROSS] = 3332.0428103998247,
        [CURVOPT_TERM_VARIATION] = 4033.476572667407,
        [CURVOPT_TERM_MEHLUM_TARROU] = 2979.1973808604575,
        [CURVOPT_TERM_AREA] = 24 * CO_PI / 5,
        [CURVOPT_TERM_MEAN] = 6 * CO_PI,
    };
    double sum = 0;
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        sum += weights[t] * stiffness[t];
    return sum;
}

void co_penalty_free(co_penalty *p) {
    free(p->first);
    free(p->size);
    free(p->rest);
    free(p->slope);
    free(p->matrix);
    free(p->constant);
    free(p->most);
    co_surface_springs_free(&p->surface);
    *p = (co_penalty){0};
}

/* Numbers the nodes of vertices with springs: index [n_nodes], -1 for the others; makes room for them. */
static int32_t number_nodes(const co_soft_constraints *s, const co_dof_map *r, int32_t *index, co_penalty *p,
                            curvopt_error *error) {
    for (int32_t node = 0; node < r->n_nodes; node++)
        index[node] = -1;
    for (int32_t v = 0; v < r->n_vertices; v++)
        if (s->stiffness[v] > 0 && r->node[v] >= 0 && index[r->node[v]] < 0)
            index[r->node[v]] = p->n++;
    size_t n = (size_t)p->n;
    p->first = CO_NEW(int32_t, n);
    p->size = CO_NEW(int32_t, n);
    p->rest = CO_NEW(double, 3 * n);
    p->slope = CO_NEW(double, 3 * n);
    p->matrix = CO_NEW(double, 9 * n);
    p->constant = CO_NEW(double, n);
    p->most = CO_NEW(double, n);
    if (!p->first || !p->size || !p->rest || !p->slope || !p->matrix || !p->constant || !p->most)
        return co_status_no_memory(error);
    for (int32_t node = 0; node < r->n_nodes; node++)
        if (index[node] >= 0) {
            p->first[index[node]] = r->first[node];
            p->size[index[node]] = r->first[node + 1] - r->first[node];
        }
    return CURVOPT_OK;
}

/* A vertex's anchor less what no variable moves, normalized. */
static void find_target(const co_soft_constraints *s, const co_dof_map *r, int32_t v, const double centroid[3],
                        double radius, double target[3]) {
    for (size_t c = 0; c < 3; c++) {
        size_t i = 3 * (size_t)v + c;
        target[c] = (s->anchor[i] - centroid[c]) / radius - (r->offset ? r->offset[i] : 0);
    }
}

/* Adds the energy of the spring of vertex v, in node k: with r = B rest - target, stiffness |Q (B y + r)|^2 / 2. */
static void add_vertex(const co_soft_constraints *s, const co_dof_map *r, int32_t v, const double target[3],
                       double stiffness, co_penalty *p, int32_t k) {
    const double *basis = r->basis + 9 * (size_t)v, *rest = p->rest + 3 * (size_t)k;
    double free[9], off[3], taken[3][4] = {{0}}; /* Q B, and Q r in the last column */
    co_freedom_projector(s->freedom[v], s->direction + 3 * (size_t)v, free);
    for (int c = 0; c < 3; c++) {
        off[c] = -target[c];
        for (int j = 0; j < p->size[k]; j++)
            off[c] += basis[3 * c + j] * rest[j];
    }
    for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++) {
            double q = (c == d) - free[3 * c + d];
            for (int j = 0; j < p->size[k]; j++)
                taken[c][j] += q * basis[3 * d + j];
            taken[c][3] += q * off[d];
        }
    for (int c = 0; c < 3; c++) {
        p->constant[k] += stiffness / 2 * taken[c][3] * taken[c][3];
        for (int i = 0; i < p->size[k]; i++) {
            p->slope[3 * k + i] += stiffness * taken[c][i] * taken[c][3];
            for (int j = 0; j < p->size[k]; j++)
                p->matrix[9 * k + 3 * i + j] += stiffness * taken[c][i] * taken[c][j];
        }
    }
}

/* What the spring of vertex v is worth at its end. */
static double most_of(const co_soft_constraints *s, int32_t v, double radius, double stiffness) {
    double reach = s->reach / radius;
    return co_soft_constraints_has_end(s, v) ? stiffness / 2 * reach * reach : (double)INFINITY;
}

int32_t co_penalty_create(const co_soft_constraints *s, const co_dof_map *r, const double centroid[3], double radius,
                          double scale, co_penalty *p, curvopt_error *error) {
    double target[3];
    *p = (co_penalty){.weight = 1};
    if (!s->stiffness)
        return CURVOPT_OK;
    int32_t *index = CO_NEW(int32_t, r->n_nodes);
    int32_t status = index ? number_nodes(s, r, index, p, error) : co_status_no_memory(error);
    for (int pass = 0; status == CURVOPT_OK && pass < 2; pass++) /* the columns of all B_v of a node are orthonormal */
        for (int32_t v = 0; v < r->n_vertices; v++) {
            if (r->node[v] < 0 || index[r->node[v]] < 0)
                continue;
            int32_t k = index[r->node[v]];
            find_target(s, r, v, centroid, radius, target);
            for (int j = 0; pass == 0 && j < p->size[k]; j++)
                for (int c = 0; c < 3; c++)
                    p->rest[3 * k + j] += r->basis[9 * (size_t)v + (size_t)(3 * c + j)] * target[c];
            if (pass == 1) {
                add_vertex(s, r, v, target, scale * s->stiffness[v], p, k);
                p->most[k] += most_of(s, v, radius, scale * s->stiffness[v]);
            }
        }
    free(index);
    if (status != CURVOPT_OK)
        co_penalty_free(p);
    return status;
}

/* q of node k at z; `force` [3] gets its gradient. */
static double quadratic(const co_penalty *p, int32_t k, const double *z, double *force) {
    const double *matrix = p->matrix + 9 * (size_t)k, *slope = p->slope + 3 * (size_t)k;
    double y[3] = {0, 0, 0}, q = p->constant[k];
    for (int i = 0; i < p->size[k]; i++)
        y[i] = z[p->first[k] + i] - p->rest[3 * (size_t)k + (size_t)i];
    for (int i = 0; i < p->size[k]; i++) {
        double turned = matrix[3 * i] * y[0] + matrix[3 * i + 1] * y[1] + matrix[3 * i + 2] * y[2];
        q += (slope[i] + turned / 2) * y[i];
        force[i] = slope[i] + turned;
    }
    return q;
}

double co_penalty_value(const co_penalty *p, const double *z, double *gradient) {
    double value = 0, force[3];
    for (int32_t k = 0; k < p->n; k++) {
        double q = quadratic(p, k, z, force), left = 1 - q / p->most[k];
        if (!(left > 0))
            return (double)INFINITY;
        value += isfinite(p->most[k]) ? -p->most[k] * co_log_1_plus(-q / p->most[k]) : q;
        for (int i = 0; gradient && i < p->size[k]; i++)
            gradient[p->first[k] + i] += p->weight * force[i] / left;
    }
    return p->weight * (value + co_surface_springs_value(&p->surface, z, p->weight, gradient));
}

void co_penalty_add_hessian(const co_penalty *p, const double *z, int exact, co_sparse_hessian *h) {
    co_surface_springs_add_hessian(&p->surface, z, exact, p->weight, h);
    for (int32_t k = 0; k < p->n; k++) {
        double force[3], left = 1 - quadratic(p, k, z, force) / p->most[k];
        for (int j = 0; j < p->size[k]; j++) /* a column begins with its own block, from the diagonal on */
            for (int i = j; i < p->size[k]; i++)
                h->value[h->pattern.column_start[p->first[k] + j] + i - j] +=
                    p->weight * (p->matrix[9 * (size_t)k + (size_t)(3 * i + j)] / left +
                                 force[i] * force[j] / (p->most[k] * left * left));
    }
}

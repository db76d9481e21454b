/* Where a sparse Hessian has entries. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/sparsity.h"

#include "base/memory.h"

#include <stdlib.h>

void co_couplings_free(co_couplings *c) {
    free(c->start);
    free(c->vertex);
    *c = (co_couplings){0};
}

/* Points all pairs of which have entries in the matrix: those that the surface on a patch can depend on, or, numbered
 * after the patches, those of a blend disc, whose patches then have none, and after these those of a coupling. */
typedef struct clique {
    const int32_t *point;
    size_t n;
    int32_t kind; /* of the patch, of whose points some are not in it; CO_FAN_REGULAR: all are */
} clique;

/* All that has cliques. */
typedef struct source {
    const co_patches *patches;
    const co_couplings *couplings; /* NULL: none */
} source;

static int32_t number_of_cliques(const source *s) {
    return s->patches->n_patches + s->patches->wide.n_discs + (s->couplings ? s->couplings->n : 0);
}

static clique clique_of(const source *s, int32_t k) {
    const co_patches *patches = s->patches;
    const int32_t coupling = k - patches->n_patches - patches->wide.n_discs;
    if (coupling >= 0)
        return (clique){s->couplings->vertex + s->couplings->start[coupling],
                        s->couplings->start[coupling + 1] - s->couplings->start[coupling], CO_FAN_REGULAR};
    if (k >= patches->n_patches) {
        const co_blend_disc *disc = &patches->wide.disc[k - patches->n_patches];
        int32_t n = disc->is_used ? co_blend_disc_fit_of(&patches->wide, disc)->n_points : 0;
        return (clique){patches->wide.column + disc->column, (size_t)n, CO_FAN_REGULAR};
    }
    size_t n = co_fan_is_wide(patches->kind[k]) ? 0 : patches->start[k + 1] - patches->start[k];
    return (clique){patches->points + patches->start[k], n, patches->kind[k]};
}

/* Which nodes are in which cliques, both ways round. Each pair is there once: a node of a pole is in a clique by many
 * of its points, and to go through these again for each node took 24 s at a pole of 180 faces. */
typedef struct incidence {
    size_t *start, *member_start; /* [n_nodes + 1], [n_cliques + 1] */
    int32_t *clique, *member;     /* [start[n_nodes]] cliques of a node, nodes of a clique */
} incidence;

/* Visits every pair of a clique and a node in it once. Moves count [n_nodes] on, and if there are lists puts the clique
 * there and the node at the end of its clique's: once with count all 0 to count the cliques of each node, once with the
 * places of each node's first. mark [n_nodes] is work space. It is not done where it is cancelled. */
static void visit_nodes_of_cliques(const source *s, const co_dof_map *r, co_cancel *cancel, int32_t *mark,
                                   size_t *count, incidence *in) {
    size_t n_members = 0;
    for (int32_t n = 0; n < r->n_nodes; n++)
        mark[n] = -1;
    for (int32_t p = 0; p < number_of_cliques(s) && !co_cancel_is_due(cancel); p++) {
        clique points = clique_of(s, p);
        for (size_t i = 0; i < points.n; i++) {
            if (!co_patches_own_is_used(s->patches->surface, points.kind, (int32_t)i))
                continue;
            co_point_row row = co_patches_row(s->patches, &points.point[i]);
            for (size_t k = 0; k < row.n; k++) {
                int32_t node = r->node[row.vertex[k]];
                if (node < 0 || mark[node] == p)
                    continue;
                mark[node] = p;
                if (in->clique) {
                    in->clique[count[node]] = p;
                    in->member[n_members++] = node;
                }
                count[node]++;
            }
        }
        in->member_start[p + 1] = n_members;
    }
}

static int compare_indices(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Larger nodes that share a clique with `node`, ascending, into `out`; NULL: they are only counted. Returns their
 * number. */
static size_t neighbours_of(const incidence *in, int32_t node, int32_t *mark, int32_t *out) {
    size_t n = 0;
    for (size_t e = in->start[node]; e < in->start[node + 1]; e++) {
        int32_t clique = in->clique[e];
        for (size_t i = in->member_start[clique]; i < in->member_start[clique + 1]; i++) {
            int32_t other = in->member[i];
            if (other <= node || mark[other] == node)
                continue;
            mark[other] = node;
            if (out)
                out[n] = other;
            n++;
        }
    }
    if (out)
        qsort(out, n, sizeof *out, compare_indices);
    return n;
}

static int32_t incidence_create(const source *s, const co_dof_map *r, co_cancel *cancel, int32_t *mark, incidence *in) {
    size_t n = (size_t)r->n_nodes, n_cliques = (size_t)number_of_cliques(s);
    *in = (incidence){.start = CO_NEW(size_t, n + 1), .member_start = CO_NEW(size_t, n_cliques + 1)};
    if (!in->start || !in->member_start)
        return CURVOPT_ERROR_MEMORY;
    visit_nodes_of_cliques(s, r, cancel, mark, in->start + 1, in);
    if (co_cancel_is_due(cancel)) /* there is less room than the next visit needs if it goes on */
        return CO_CANCELLED;
    for (size_t v = 0; v < n; v++)
        in->start[v + 1] += in->start[v];
    in->clique = CO_NEW(int32_t, in->start[n]);
    in->member = CO_NEW(int32_t, in->start[n]);
    if (!in->clique || !in->member)
        return CURVOPT_ERROR_MEMORY;
    visit_nodes_of_cliques(s, r, cancel, mark, in->start, in);
    if (co_cancel_is_due(cancel))
        return CO_CANCELLED;
    for (size_t v = n; v > 0; v--)
        in->start[v] = in->start[v - 1];
    in->start[0] = 0;
    return CURVOPT_OK;
}

static void incidence_free(incidence *in) {
    free(in->start);
    free(in->member_start);
    free(in->clique);
    free(in->member);
}

static int32_t find_neighbours(const source *cliques, const co_dof_map *r, co_cancel *cancel, co_sparsity *s,
                               curvopt_error *error) {
    size_t n = (size_t)r->n_nodes;
    int32_t status = CURVOPT_ERROR_MEMORY, *mark = CO_NEW(int32_t, n);
    incidence in = {0};
    s->neighbour_start = CO_NEW(size_t, n + 1);
    if (mark && s->neighbour_start)
        status = incidence_create(cliques, r, cancel, mark, &in);
    if (status != CURVOPT_OK)
        goto done;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t v = 0; v < n; v++)
            mark[v] = -1;
        for (int32_t v = 0; v < r->n_nodes; v++) {
            if (co_cancel_is_due(cancel)) {
                status = CO_CANCELLED;
                goto done;
            }
            int32_t *out = pass ? s->neighbour + s->neighbour_start[v] : NULL;
            size_t found = neighbours_of(&in, v, mark, out);
            s->neighbour_start[v + 1] = s->neighbour_start[v] + found;
        }
        status = CURVOPT_ERROR_MEMORY;
        if (pass == 0 && !(s->neighbour = CO_NEW(int32_t, s->neighbour_start[n])))
            goto done;
        status = CURVOPT_OK;
    }
done:
    free(mark);
    incidence_free(&in);
    return status == CURVOPT_ERROR_MEMORY ? co_status_no_memory(error) : status;
}

/* Fills neighbour_row: where each neighbour's rows begin below a node's own block, the same in all its columns. */
static int32_t count_rows(const co_dof_map *r, co_sparsity *s, curvopt_error *error) {
    s->n_entries = 0;
    s->neighbour_row = CO_NEW(int32_t, s->neighbour_start[r->n_nodes]);
    if (!s->neighbour_row)
        return co_status_no_memory(error);
    for (int32_t node = 0; node < r->n_nodes; node++) {
        int32_t rows = 0, n = co_dof_map_dimension(r, node);
        for (size_t e = s->neighbour_start[node]; e < s->neighbour_start[node + 1]; e++) {
            s->neighbour_row[e] = rows;
            rows += co_dof_map_dimension(r, s->neighbour[e]);
        }
        s->n_entries += (size_t)(n * (n + 1) / 2 + n * rows);
    }
    if (s->n_entries > INT32_MAX)
        return co_status_fail(error, CURVOPT_ERROR_SIZE, -1, "a cage of %d vertices is too large for this method",
                              r->n_vertices);
    return CURVOPT_OK;
}

static int32_t build_columns(const co_dof_map *r, co_sparsity *s, curvopt_error *error) {
    int32_t at = 0, status = count_rows(r, s, error);
    if (status != CURVOPT_OK)
        return status;
    s->column_start = CO_NEW(int32_t, (size_t)r->n_variables + 1);
    s->row = CO_NEW(int32_t, s->n_entries);
    if (!s->column_start || !s->row)
        return co_status_no_memory(error);
    for (int32_t node = 0; node < r->n_nodes; node++)
        for (int32_t column = r->first[node]; column < r->first[node + 1]; column++) {
            s->column_start[column] = at;
            for (int32_t row = column; row < r->first[node + 1]; row++)
                s->row[at++] = row;
            for (size_t e = s->neighbour_start[node]; e < s->neighbour_start[node + 1]; e++)
                for (int32_t row = r->first[s->neighbour[e]]; row < r->first[s->neighbour[e] + 1]; row++)
                    s->row[at++] = row;
        }
    s->column_start[r->n_variables] = at;
    return CURVOPT_OK;
}

int32_t co_sparsity_create(const co_patches *patches, const co_dof_map *dofs, const co_couplings *couplings,
                           co_cancel *cancel, co_sparsity *s, curvopt_error *error) {
    const source cliques = {patches, couplings};
    *s = (co_sparsity){0};
    int32_t status = find_neighbours(&cliques, dofs, cancel, s, error);
    if (status == CURVOPT_OK)
        status = build_columns(dofs, s, error);
    if (status != CURVOPT_OK)
        co_sparsity_free(s);
    return status;
}

void co_sparsity_free(co_sparsity *s) {
    free(s->neighbour_start);
    free(s->neighbour);
    free(s->neighbour_row);
    free(s->column_start);
    free(s->row);
    *s = (co_sparsity){0};
}

int co_sparsity_has(const co_sparsity *s, int32_t one, int32_t other) {
    const int32_t low = one < other ? one : other, high = one < other ? other : one;
    if (low < 0 || low == high)
        return 1;
    return bsearch(&high, s->neighbour + s->neighbour_start[low], s->neighbour_start[low + 1] - s->neighbour_start[low],
                   sizeof *s->neighbour, compare_indices) != NULL;
}

/* Second derivatives of an objective over the cage's coordinates, sparse. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/sparse_hessian.h"

#include "base/memory.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_BLOCKS = 32, NO_RULES = -1 };

void co_sparse_hessian_free(co_sparse_hessian *h) {
    free(h->neighbour_start);
    free(h->neighbour);
    free(h->neighbour_row);
    free(h->column_start);
    free(h->row);
    free(h->value);
    free(h->chunk);
    free(h->work);
    free(h->whole);
    free(h->before);
    co_blend_disc_hessian_free(&h->wide);
    co_element_batches_free(&h->batches);
    *h = (co_sparse_hessian){0};
}

/* ---------------------------------------------------------------------------------------------- pattern -- */

/* The cage vertices that a point is made of: itself, or a derived point's row. */
typedef struct point_row {
    const int32_t *vertex;
    const double *weight;
    size_t n;
} point_row;

static point_row row_of_point(const co_patches *patches, const int32_t *point) {
    static const double one = 1;
    if (*point < patches->n_cage)
        return (point_row){point, &one, 1};
    size_t begin = patches->derived.start[*point - patches->n_cage];
    return (point_row){patches->derived.column + begin, patches->derived.value + begin,
                       patches->derived.start[*point - patches->n_cage + 1] - begin};
}

/* Points that all have to do with each other: of a patch, or, numbered after the patches, of a wide blend, whose
 * patches then have none. */
typedef struct clique {
    const int32_t *point;
    size_t n;
} clique;

static clique clique_of(const co_patches *patches, int32_t k) {
    if (k >= patches->n_patches) {
        const co_blend_disc *disc = &patches->wide.disc[k - patches->n_patches];
        int32_t n = disc->is_used ? co_blend_disc_fit_of(&patches->wide, disc)->n_points : 0;
        return (clique){patches->wide.column + disc->column, (size_t)n};
    }
    size_t n = co_fan_is_wide(patches->valence[k]) ? 0 : patches->start[k + 1] - patches->start[k];
    return (clique){patches->points + patches->start[k], n};
}

/* Calls for every (clique, node) once: count only, or fill `list` (cliques of each node). mark [n_nodes]. */
static void visit_nodes_of_cliques(const co_assembly *a, const co_dof_map *r, int32_t *mark, size_t *count,
                                   int32_t *list) {
    const co_patches *patches = &a->patches;
    for (int32_t n = 0; n < r->n_nodes; n++)
        mark[n] = -1;
    for (int32_t p = 0; p < patches->n_patches + patches->wide.n_discs; p++) {
        clique points = clique_of(patches, p);
        for (size_t i = 0; i < points.n; i++) {
            point_row row = row_of_point(patches, &points.point[i]);
            for (size_t k = 0; k < row.n; k++) {
                int32_t node = r->node[row.vertex[k]];
                if (node < 0 || mark[node] == p)
                    continue;
                mark[node] = p;
                if (list)
                    list[count[node]] = p;
                count[node]++;
            }
        }
    }
}

static int compare_indices(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Larger nodes that share a clique with `node`, into out (may be NULL: only counted). */
static size_t neighbours_of(const co_patches *patches, const co_dof_map *r, const size_t *start, const int32_t *list,
                            int32_t node, int32_t *mark, int32_t *out) {
    size_t n = 0;
    for (size_t e = start[node]; e < start[node + 1]; e++) {
        clique points = clique_of(patches, list[e]);
        for (size_t i = 0; i < points.n; i++) {
            point_row row = row_of_point(patches, &points.point[i]);
            for (size_t k = 0; k < row.n; k++) {
                int32_t other = r->node[row.vertex[k]];
                if (other <= node || mark[other] == node)
                    continue;
                mark[other] = node;
                if (out)
                    out[n] = other;
                n++;
            }
        }
    }
    if (out)
        qsort(out, n, sizeof *out, compare_indices);
    return n;
}

static int32_t find_neighbours(const co_assembly *a, co_sparse_hessian *h, curvopt_error *error) {
    const co_dof_map *r = h->reduction;
    size_t n = (size_t)r->n_nodes;
    int32_t status = CURVOPT_ERROR_MEMORY, *list = NULL, *mark = CO_NEW(int32_t, n);
    size_t *start = CO_NEW(size_t, n + 1);
    h->neighbour_start = CO_NEW(size_t, n + 1);
    if (!mark || !start || !h->neighbour_start)
        goto done;
    visit_nodes_of_cliques(a, r, mark, start + 1, NULL);
    for (size_t v = 0; v < n; v++)
        start[v + 1] += start[v];
    list = CO_NEW(int32_t, start[n]);
    if (!list)
        goto done;
    visit_nodes_of_cliques(a, r, mark, start, list);
    for (size_t v = n; v > 0; v--)
        start[v] = start[v - 1];
    start[0] = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t v = 0; v < n; v++)
            mark[v] = -1;
        for (int32_t v = 0; v < r->n_nodes; v++) {
            int32_t *out = pass ? h->neighbour + h->neighbour_start[v] : NULL;
            size_t found = neighbours_of(&a->patches, r, start, list, v, mark, out);
            h->neighbour_start[v + 1] = h->neighbour_start[v] + found;
        }
        if (pass == 0 && !(h->neighbour = CO_NEW(int32_t, h->neighbour_start[n])))
            goto done;
    }
    status = CURVOPT_OK;
done:
    free(mark);
    free(start);
    free(list);
    return status == CURVOPT_OK ? status : co_status_no_memory(error);
}

/* Rows below a node's own block, in all columns of the node alike: where each neighbour's begin. */
static int32_t count_rows(co_sparse_hessian *h, curvopt_error *error) {
    const co_dof_map *r = h->reduction;
    h->n_entries = 0;
    h->neighbour_row = CO_NEW(int32_t, h->neighbour_start[r->n_nodes]);
    if (!h->neighbour_row)
        return co_status_no_memory(error);
    for (int32_t node = 0; node < r->n_nodes; node++) {
        int32_t rows = 0, n = co_dof_map_dimension(r, node);
        for (size_t e = h->neighbour_start[node]; e < h->neighbour_start[node + 1]; e++) {
            h->neighbour_row[e] = rows;
            rows += co_dof_map_dimension(r, h->neighbour[e]);
        }
        h->n_entries += (size_t)(n * (n + 1) / 2 + n * rows);
    }
    if (h->n_entries > INT32_MAX)
        return co_status_fail(error, CURVOPT_ERROR_SIZE, -1, "a cage of %d vertices is too large for this method",
                              r->n_vertices);
    return CURVOPT_OK;
}

static int32_t build_columns(co_sparse_hessian *h, curvopt_error *error) {
    const co_dof_map *r = h->reduction;
    int32_t at = 0, status = count_rows(h, error);
    if (status != CURVOPT_OK)
        return status;
    h->column_start = CO_NEW(int32_t, (size_t)r->n_variables + 1);
    h->row = CO_NEW(int32_t, h->n_entries);
    h->value = CO_NEW(double, h->n_entries);
    if (!h->column_start || !h->row || !h->value)
        return co_status_no_memory(error);
    for (int32_t node = 0; node < r->n_nodes; node++)
        for (int32_t column = r->first[node]; column < r->first[node + 1]; column++) {
            h->column_start[column] = at;
            for (int32_t row = column; row < r->first[node + 1]; row++)
                h->row[at++] = row;
            for (size_t e = h->neighbour_start[node]; e < h->neighbour_start[node + 1]; e++)
                for (int32_t row = r->first[h->neighbour[e]]; row < r->first[h->neighbour[e] + 1]; row++)
                    h->row[at++] = row;
        }
    h->column_start[r->n_variables] = at;
    return CURVOPT_OK;
}

/* The Hessian is to be that of the function that is minimized, by the rules that the assembly has now. The Gauss-Newton
 * matrix guides steps only, and is positive with any rules: the coarsest will do. */
static int steps_coarser(const co_second_kind *kind) {
    if (kind->rules == CO_SECOND_USUAL)
        return kind->exact ? 0 : CO_N_RULES;
    return kind->rules == CO_SECOND_COARSER;
}

/* Batches with the same key have the same rules. */
static int32_t key_of(const co_assembly *a, int coarser) {
    return coarser == CO_N_RULES ? CO_N_RULES : a->rules_version * (CO_N_RULES + 1) + coarser;
}

/* Makes the batches by rules so many steps coarser than the assembly's, and room for them. */
static int32_t update_batches(co_assembly *a, co_sparse_hessian *h, int coarser, curvopt_error *error) {
    size_t lanes = (size_t)a->kernel->lanes;
    uint8_t *rule = CO_NEW(uint8_t, a->patches.n_patches);
    co_element_batches_free(&h->batches);
    free(h->chunk);
    free(h->work);
    h->chunk = h->work = NULL;
    h->rules_key = NO_RULES;
    if (!rule)
        return co_status_no_memory(error);
    for (int32_t p = 0; p < a->patches.n_patches; p++)
        rule[p] = (uint8_t)(a->rule[p] > coarser ? a->rule[p] - coarser : 0);
    co_element_batches_spec spec = {.patches = &a->patches, .cache = a->cache, .lanes = a->kernel->lanes, .rule = rule};
    int32_t status = co_element_batches_create(&spec, &h->batches, error);
    free(rule);
    if (status != CURVOPT_OK)
        return status;
    size_t size = 3 * (size_t)h->batches.max_points;
    h->matrix_stride = size * (size + 1) / 2 * lanes;
    h->work_stride = co_element_hessian_work(h->batches.max_points) * lanes;
    h->chunk = CO_NEW_ALIGNED(double, CHUNK_BLOCKS * h->matrix_stride);
    h->work = CO_NEW_ALIGNED(double, (size_t)a->n_threads * h->work_stride);
    if (!h->chunk || !h->work)
        return co_status_no_memory(error);
    h->rules_key = key_of(a, coarser);
    return CURVOPT_OK;
}

static int32_t allocate_wide(const co_assembly *a, co_sparse_hessian *h, curvopt_error *error) {
    size_t largest = 0;
    int32_t status = co_blend_disc_hessian_create(&a->patches, h->reduction, &h->wide, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < a->patches.wide.n_discs; k++) {
        size_t n = co_blend_disc_hessian_n_variables(&h->wide, k);
        largest = n > largest ? n : largest;
    }
    h->whole = CO_NEW(double, largest *largest);
    return status == CURVOPT_OK && !h->whole ? co_status_no_memory(error) : status;
}

int32_t co_sparse_hessian_create(const co_assembly *a, const co_dof_map *reduction, co_sparse_hessian *h,
                                 curvopt_error *error) {
    *h = (co_sparse_hessian){.reduction = reduction, .rules_key = NO_RULES};
    int32_t status = find_neighbours(a, h, error);
    if (status == CURVOPT_OK)
        status = build_columns(h, error);
    if (status == CURVOPT_OK)
        status = allocate_wide(a, h, error);
    if (status != CURVOPT_OK)
        co_sparse_hessian_free(h);
    return status;
}

/* ----------------------------------------------------------------------------------------------- values -- */

/* Where the rows of node `high` begin below the own block of node `low`, which is smaller. */
static int32_t rows_of(const co_sparse_hessian *h, int32_t high, int32_t low) {
    size_t begin = h->neighbour_start[low], end = h->neighbour_start[low + 1];
    while (end - begin > 1) {
        size_t middle = (begin + end) / 2;
        if (h->neighbour[middle] <= high)
            begin = middle;
        else
            end = middle;
    }
    return h->neighbour_row[begin];
}

/* Adds B_v^T block B_w, block [3][3], to the rows of v's node and the columns of w's; where they are one node, also the
 * transpose if `twice`. */
static void add_block(co_sparse_hessian *h, int32_t v, int32_t w, double weight, double block[3][3], int twice) {
    const co_dof_map *r = h->reduction;
    const double *left = r->basis + 9 * (size_t)v, *right = r->basis + 9 * (size_t)w;
    int32_t a = r->node[v], b = r->node[w], n_a = co_dof_map_dimension(r, a), n_b = co_dof_map_dimension(r, b);
    double half[3][3] = {{0}}, full[3][3] = {{0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < n_b; k++)
            half[i][k] = r->plain ? block[i][k]
                                  : block[i][0] * right[k] + block[i][1] * right[3 + k] + block[i][2] * right[6 + k];
    for (int i = 0; i < n_a; i++)
        for (int k = 0; k < n_b; k++)
            full[i][k] =
                weight *
                (r->plain ? half[i][k] : left[i] * half[0][k] + left[3 + i] * half[1][k] + left[6 + i] * half[2][k]);
    if (a == b) {
        for (int k = 0; k < n_a; k++)
            for (int i = k; i < n_a; i++)
                h->value[h->column_start[r->first[a] + k] + i - k] += full[i][k] + (twice ? full[k][i] : 0);
        return;
    }
    int32_t high = a > b ? a : b, low = a > b ? b : a, n_high = co_dof_map_dimension(r, high),
            n_low = co_dof_map_dimension(r, low);
    int32_t rows = rows_of(h, high, low);
    for (int32_t k = 0; k < n_low; k++) {
        double *to = h->value + h->column_start[r->first[low] + k] + n_low - k + rows;
        for (int32_t i = 0; i < n_high; i++)
            to[i] += a > b ? full[i][k] : full[k][i];
    }
}

/* The 3 x 3 block of points p >= q of one face's matrix, of one lane. */
static void face_block(const double *matrix, size_t lanes, size_t lane, int32_t p, int32_t q, double block[3][3]) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            size_t i = 3 * (size_t)p + (size_t)r, j = 3 * (size_t)q + (size_t)c;
            size_t at = i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
            block[r][c] = matrix[at * lanes + lane];
        }
}

/* What the points p >= q of one face's matrix contribute to columns of the nodes first <= node < end. */
static void scatter_pair(const co_patches *patches, co_sparse_hessian *h, const co_block *b, const double *matrix,
                         size_t lane, int32_t p, int32_t q, double weight, int32_t first, int32_t end) {
    size_t lanes = (size_t)h->batches.lanes;
    const int32_t *points = h->batches.points + b->points, *node = h->reduction->node;
    point_row x = row_of_point(patches, &points[(size_t)p * lanes + lane]);
    point_row y = row_of_point(patches, &points[(size_t)q * lanes + lane]);
    double block[3][3];
    int read = 0;
    for (size_t i = 0; i < x.n; i++)
        for (size_t j = 0; j < (p == q ? i + 1 : y.n); j++) {
            int32_t v = node[x.vertex[i]], w = node[y.vertex[j]], column = v < w ? v : w;
            if (v < 0 || w < 0 || column < first || column >= end)
                continue;
            if (!read)
                face_block(matrix, lanes, lane, p, q, block);
            read = 1;
            /* (p, q) and (q, p) both stand for entries of the whole; on a node's own block both are added */
            add_block(h, x.vertex[i], y.vertex[j], weight * x.weight[i] * y.weight[j], block, p != q || i != j);
        }
}

static void scatter_face(const co_assembly *a, co_sparse_hessian *h, int32_t block, int32_t lane, const double *matrix,
                         int32_t first, int32_t end) {
    const co_block *b = &h->batches.block[block];
    int32_t patch = h->batches.patch[block * h->batches.lanes + lane];
    int32_t n_own = b->table->n_points - (co_fan_is_wide(b->table->valence) ? CO_BLEND_DISC_TERMS : 0);
    double weight = a->weight ? a->weight[patch] : 1;
    for (int32_t p = 0; p < n_own; p++)
        for (int32_t q = 0; q <= p; q++)
            scatter_pair(&a->patches, h, b, matrix, (size_t)lane, p, q, weight, first, end);
}

static void sweep_chunk(co_assembly *a, co_sparse_hessian *h, int32_t first, int32_t n, const co_integrand *integrand,
                        int exact, const double *before) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(a->n_threads)
    for (int32_t k = 0; k < n; k++) {
        const co_block *b = &h->batches.block[first + k];
        co_element_hessian sweep = {.table = b->table,
                                    .points = h->batches.points + b->points,
                                    .xyz = a->points,
                                    .before = before,
                                    .eps4 = co_functional_eps4(),
                                    .integrand = *integrand,
                                    .third = a->functional.has_third,
                                    .exact = exact,
                                    .matrix = h->chunk + (size_t)k * h->matrix_stride,
                                    .work = h->work + (size_t)omp_get_thread_num() * h->work_stride};
        a->kernel->run_second(&sweep);
    }
}

/* The same of one thread's discs: what faces of wide blends say of the polynomials' points. */
static void scatter_wide(const co_assembly *a, co_sparse_hessian *h, int32_t block, const double *matrix,
                         int32_t thread) {
    const co_block *b = &h->batches.block[block];
    if (!co_fan_is_wide(b->table->valence))
        return;
    for (int32_t lane = 0; lane < b->n_used; lane++) {
        co_blend_disc_face_matrix share = {.patch = h->batches.patch[block * h->batches.lanes + lane],
                                           .n_own = b->table->n_points - CO_BLEND_DISC_TERMS,
                                           .points = h->batches.points + b->points + lane,
                                           .face = matrix + lane,
                                           .stride = (size_t)h->batches.lanes};
        share.weight = a->weight ? a->weight[share.patch] : 1;
        if (co_blend_disc_hessian_disc_of(&a->patches, share.patch) % a->n_threads == thread)
            co_blend_disc_hessian_add(&h->wide, &share);
    }
}

/* Adds what a disc of a wide blend has gathered, `whole`, of n variables. All of its nodes are each other's neighbours.
 */
static void add_disc(co_sparse_hessian *h, int32_t disc, size_t n) {
    const co_dof_map *r = h->reduction;
    const int32_t *node = h->wide.node + h->wide.node_start[disc], *end = h->wide.node + h->wide.node_start[disc + 1];
    for (const double *column = h->whole; node < end; node++) {
        int32_t n_own = co_dof_map_dimension(r, *node);
        for (int32_t k = 0; k < n_own; k++, column += n + 1) { /* from the diagonal on */
            const double *from = column;
            double *to = h->value + h->column_start[r->first[*node] + k], *below = to + n_own - k;
            for (int32_t i = k; i < n_own; i++)
                *to++ += *from++;
            size_t e = h->neighbour_start[*node];
            for (const int32_t *high = node + 1; high < end; high++) {
                while (h->neighbour[e] < *high)
                    e++;
                for (int32_t i = 0; i < co_dof_map_dimension(r, *high); i++)
                    below[h->neighbour_row[e] + i] += *from++;
            }
        }
    }
}

static void pull_wide(const co_assembly *a, co_sparse_hessian *h) {
    for (int32_t k = 0; k < a->patches.wide.n_discs; k++)
        if (a->patches.wide.disc[k].is_used) {
            co_blend_disc_hessian_collect(&h->wide, k, h->whole);
            add_disc(h, k, co_blend_disc_hessian_n_variables(&h->wide, k));
        }
}

/* Each thread owns some columns, and some discs, so that sums come in the same order for any number of threads. */
static void scatter_chunk(const co_assembly *a, co_sparse_hessian *h, int32_t first, int32_t n) {
    int32_t n_nodes = h->reduction->n_nodes;
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t t = 0; t < a->n_threads; t++) {
        int32_t begin = (int32_t)((int64_t)n_nodes * t / a->n_threads);
        int32_t end = (int32_t)((int64_t)n_nodes * (t + 1) / a->n_threads);
        for (int32_t k = 0; k < n; k++)
            for (int32_t lane = 0; lane < h->batches.block[first + k].n_used; lane++)
                scatter_face(a, h, first + k, lane, h->chunk + (size_t)k * h->matrix_stride, begin, end);
        for (int32_t k = 0; k < n; k++)
            scatter_wide(a, h, first + k, h->chunk + (size_t)k * h->matrix_stride, t);
    }
}

/* h->before from positions. */
static int32_t place_before(co_assembly *a, const double *x, co_sparse_hessian *h, curvopt_error *error) {
    size_t n = 3 * (size_t)a->patches.n_points;
    h->before = h->before ? h->before : CO_NEW(double, n);
    if (!h->before)
        return co_status_no_memory(error);
    co_assembly_place(a, x, 1);
    memcpy(h->before, a->points, n * sizeof *h->before);
    return CURVOPT_OK;
}

int32_t co_sparse_hessian_assemble(co_assembly *a, const double *x, const co_second_kind *kind, co_sparse_hessian *h,
                                   curvopt_error *error) {
    const int exact = kind->exact, coarser = steps_coarser(kind);
    const co_whole *whole = kind->whole;
    int32_t status = h->rules_key == key_of(a, coarser) ? CURVOPT_OK : update_batches(a, h, coarser, error);
    if (status == CURVOPT_OK && kind->before)
        status = place_before(a, kind->before, h, error);
    if (status != CURVOPT_OK)
        return status;
    co_values values;
    const co_functional *f = &a->functional;
    memset(h->value, 0, h->n_entries * sizeof(double));
    co_blend_disc_hessian_clear(&h->wide);
    co_assembly_evaluate(a, x, &(co_request){.is_normalized = 1}, &values); /* sets the points, gives the integrals */
    double area = whole ? whole->area : values.integral[CO_INT_AREA];
    double third = whole ? whole->third : co_functional_integrate(&f->third, values.integral);
    co_integrand integrand = f->second;
    co_integrand_add(&integrand, area, &f->third);
    integrand.area += f->has_third ? third : 0;
    for (int32_t first = 0; first < h->batches.n_blocks; first += CHUNK_BLOCKS) {
        int32_t n = h->batches.n_blocks - first;
        n = n > CHUNK_BLOCKS ? CHUNK_BLOCKS : n;
        sweep_chunk(a, h, first, n, &integrand, exact, kind->before ? h->before : NULL);
        scatter_chunk(a, h, first, n);
    }
    pull_wide(a, h);
    return CURVOPT_OK;
}

double co_sparse_hessian_mean_diagonal(const co_sparse_hessian *h) {
    double sum = 0;
    for (int32_t i = 0; i < h->reduction->n_variables; i++)
        sum += h->value[h->column_start[i]];
    return sum / h->reduction->n_variables;
}

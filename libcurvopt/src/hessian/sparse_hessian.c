/* Second derivatives of an objective over the cage's coordinates, sparse. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/sparse_hessian.h"

#include "base/memory.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* Blocks whose matrices are held at a time: a few for each thread, some 10 MB. No other number was tried
 * (libcurvopt/notes/44-second-derivatives-of-wide-blends.md). */
enum { CHUNK_BLOCKS = 32 };
enum { NO_RULES = -1 };

void co_sparse_hessian_free(co_sparse_hessian *h) {
    free(h->value);
    free(h->chunk);
    free(h->work);
    free(h->disc_matrix);
    free(h->before);
    co_sparsity_free(&h->pattern);
    co_blend_disc_hessian_free(&h->discs);
    co_element_batches_free(&h->batches);
    *h = (co_sparse_hessian){0};
}

/* How much coarser rules are than the assembly's. The Hessian is to be that of the function that is minimized, by the
 * rules that the assembly has now. The Gauss-Newton matrix preconditions only, and is positive with any rules: the
 * coarsest will do. */
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

static int32_t allocate_discs(const co_assembly *a, co_sparse_hessian *h, curvopt_error *error) {
    size_t largest = 0;
    int32_t status = co_blend_disc_hessian_create(&a->patches, h->dofs, &h->discs, error);
    for (int32_t k = 0; status == CURVOPT_OK && k < a->patches.wide.n_discs; k++) {
        size_t n = co_blend_disc_hessian_n_variables(&h->discs, k);
        largest = n > largest ? n : largest;
    }
    h->disc_matrix = CO_NEW(double, largest *largest);
    return status == CURVOPT_OK && !h->disc_matrix ? co_status_no_memory(error) : status;
}

int32_t co_sparse_hessian_create(const co_assembly *a, const co_dof_map *dofs, co_sparse_hessian *h,
                                 curvopt_error *error) {
    *h = (co_sparse_hessian){.dofs = dofs, .rules_key = NO_RULES};
    int32_t status = co_sparsity_create(&a->patches, dofs, &h->pattern, error);
    if (status == CURVOPT_OK && !(h->value = CO_NEW(double, h->pattern.n_entries)))
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = allocate_discs(a, h, error);
    if (status != CURVOPT_OK)
        co_sparse_hessian_free(h);
    return status;
}

/* ----------------------------------------------------------------------------------------------- values -- */

/* Where the rows of node `high` begin below the own block of node `low`, which is smaller: by bisection. */
static int32_t rows_of(const co_sparse_hessian *h, int32_t high, int32_t low) {
    size_t begin = h->pattern.neighbour_start[low], end = h->pattern.neighbour_start[low + 1];
    while (end - begin > 1) {
        size_t middle = (begin + end) / 2;
        if (h->pattern.neighbour[middle] <= high)
            begin = middle;
        else
            end = middle;
    }
    return h->pattern.neighbour_row[begin];
}

/* A 3 x 3 block of second derivatives with respect to two vertices of the cage: rows by v, columns by w. */
typedef struct vertex_block {
    int32_t v, w;
    double weight;         /* factor of the block */
    const double (*at)[3]; /* [3][3] */
} vertex_block;

/* full = weight B_v^T block B_w, by the variables of v's node and w's. */
static void project_block(const co_dof_map *r, const vertex_block *b, double full[3][3]) {
    const double *left = r->basis + 9 * (size_t)b->v, *right = r->basis + 9 * (size_t)b->w;
    const double(*block)[3] = b->at;
    int32_t n_v = co_dof_map_dimension(r, r->node[b->v]), n_w = co_dof_map_dimension(r, r->node[b->w]);
    double half[3][3] = {{0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < n_w; k++)
            half[i][k] = r->plain ? block[i][k]
                                  : block[i][0] * right[k] + block[i][1] * right[3 + k] + block[i][2] * right[6 + k];
    for (int i = 0; i < n_v; i++)
        for (int k = 0; k < n_w; k++)
            full[i][k] =
                b->weight *
                (r->plain ? half[i][k] : left[i] * half[0][k] + left[3 + i] * half[1][k] + left[6 + i] * half[2][k]);
}

/* Adds a block to the lower triangle. Indices on the way: point (of a patch) -> vertex (of the cage) -> node (vertices
 * that move together) -> variable.
 *
 *     nodes of v and w    what is added                              why
 *     different           the block, or its transpose: the rows      the upper triangle is not stored; the pair (w, v)
 *                         are the larger node's                      is never given as well
 *     one, `twice`        block + transpose                          both (v, w) and (w, v) are entries of the own
 * block one, not `twice`    block                                      v and w are the same pair seen once */
static void add_block(co_sparse_hessian *h, const vertex_block *block, int twice) {
    const co_dof_map *r = h->dofs;
    int32_t a = r->node[block->v], b = r->node[block->w];
    double full[3][3] = {{0}};
    project_block(r, block, full);
    if (a == b) {
        int32_t n = co_dof_map_dimension(r, a);
        for (int k = 0; k < n; k++)
            for (int i = k; i < n; i++)
                h->value[h->pattern.column_start[r->first[a] + k] + i - k] += full[i][k] + (twice ? full[k][i] : 0);
        return;
    }
    int32_t high = a > b ? a : b, low = a > b ? b : a, n_high = co_dof_map_dimension(r, high),
            n_low = co_dof_map_dimension(r, low);
    int32_t rows = rows_of(h, high, low);
    for (int32_t k = 0; k < n_low; k++) {
        double *to = h->value + h->pattern.column_start[r->first[low] + k] + n_low - k + rows;
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

/* One face's matrix, in its lane of a block's, and the columns that are to be filled from it. */
typedef struct face_matrix {
    const co_patches *patches;
    const int32_t *points; /* [n_points] with stride `lanes` */
    const double *matrix;  /* lower triangle by rows, with stride `lanes` */
    size_t lanes, lane;
    double weight;                /* factor of the face */
    int32_t begin_node, end_node; /* nodes whose columns are filled */
} face_matrix;

/* Adds the second derivatives with respect to the points p >= q of a face.
 *
 * Where p is a vertex v and q a derived point (w0 + w1) / 2, the block of (p, q) is added to the pairs (v, w0) and
 * (v, w1), by half each. Where p = q is that derived point, it is added to (w0, w0), (w1, w0) and (w1, w1), by a
 * quarter each, and to (w0, w1) as the transpose: hence j <= i, and `twice` unless i = j. */
static void scatter_pair(co_sparse_hessian *h, const face_matrix *f, int32_t p, int32_t q) {
    const int32_t *node = h->dofs->node;
    co_point_row x = co_sparsity_point(f->patches, &f->points[(size_t)p * f->lanes + f->lane]);
    co_point_row y = co_sparsity_point(f->patches, &f->points[(size_t)q * f->lanes + f->lane]);
    double block[3][3];
    int read = 0;
    for (size_t i = 0; i < x.n; i++)
        for (size_t j = 0; j < (p == q ? i + 1 : y.n); j++) {
            int32_t v = node[x.vertex[i]], w = node[y.vertex[j]], column = v < w ? v : w;
            if (v < 0 || w < 0 || column < f->begin_node || column >= f->end_node)
                continue;
            if (!read)
                face_block(f->matrix, f->lanes, f->lane, p, q, block);
            read = 1;
            vertex_block pair = {x.vertex[i], y.vertex[j], f->weight * x.weight[i] * y.weight[j],
                                 (const double(*)[3])block};
            add_block(h, &pair, p != q || i != j);
        }
}

static void scatter_face(const co_assembly *a, co_sparse_hessian *h, int32_t block, int32_t lane, const double *matrix,
                         int32_t begin_node, int32_t end_node) {
    const co_block *b = &h->batches.block[block];
    int32_t patch = h->batches.patch[block * h->batches.lanes + lane];
    int32_t n_own = b->table->n_points - (co_fan_is_wide(b->table->kind) ? CO_BLEND_DISC_TERMS : 0);
    const face_matrix f = {.patches = &a->patches,
                           .points = h->batches.points + b->points,
                           .matrix = matrix,
                           .lanes = (size_t)h->batches.lanes,
                           .lane = (size_t)lane,
                           .weight = a->weight ? a->weight[patch] : 1,
                           .begin_node = begin_node,
                           .end_node = end_node};
    for (int32_t p = 0; p < n_own && !co_cancel_is_due(a->cancel); p++)
        for (int32_t q = 0; q <= p; q++)
            scatter_pair(h, &f, p, q);
}

/* Evaluates the matrices of n blocks into h->chunk. before [3 n_points] or NULL. */
static void run_chunk(co_assembly *a, co_sparse_hessian *h, int32_t first, int32_t n, const co_integrand *integrand,
                      int exact, const double *before) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(a->n_threads)
    for (int32_t k = 0; k < n; k++) {
        const co_block *b = &h->batches.block[first + k];
        co_element_hessian element = {.table = b->table,
                                      .points = h->batches.points + b->points,
                                      .xyz = a->points,
                                      .before = before,
                                      .eps4 = co_functional_eps4(),
                                      .integrand = *integrand,
                                      .third = a->functional.has_third,
                                      .cancel = a->cancel,
                                      .exact = exact,
                                      .matrix = h->chunk + (size_t)k * h->matrix_stride,
                                      .work = h->work + (size_t)omp_get_thread_num() * h->work_stride};
        a->kernel->run_second(&element);
    }
}

/* Adds a block's second derivatives with respect to the points of wide blends to the discs of one thread. */
static void scatter_discs(const co_assembly *a, co_sparse_hessian *h, int32_t block, const double *matrix,
                          int32_t thread) {
    const co_block *b = &h->batches.block[block];
    if (!co_fan_is_wide(b->table->kind))
        return;
    for (int32_t lane = 0; lane < b->n_used; lane++) {
        co_blend_disc_face_matrix face = {.patch = h->batches.patch[block * h->batches.lanes + lane],
                                          .n_own = b->table->n_points - CO_BLEND_DISC_TERMS,
                                          .points = h->batches.points + b->points + lane,
                                          .face = matrix + lane,
                                          .stride = (size_t)h->batches.lanes};
        face.weight = a->weight ? a->weight[face.patch] : 1;
        if (co_blend_disc_hessian_disc_of(&a->patches, face.patch) % a->n_threads == thread)
            co_blend_disc_hessian_add(&h->discs, &face);
    }
}

/* Adds h->disc_matrix, of the n variables of a blend disc. All of its nodes are each other's neighbours. */
static void add_disc(co_sparse_hessian *h, int32_t disc, size_t n) {
    const co_dof_map *r = h->dofs;
    const int32_t *node = h->discs.node + h->discs.node_start[disc],
                  *end = h->discs.node + h->discs.node_start[disc + 1];
    for (const double *column = h->disc_matrix; node < end; node++) {
        int32_t n_own = co_dof_map_dimension(r, *node);
        for (int32_t k = 0; k < n_own; k++, column += n + 1) { /* from the diagonal on */
            const double *from = column;
            double *to = h->value + h->pattern.column_start[r->first[*node] + k], *below = to + n_own - k;
            for (int32_t i = k; i < n_own; i++)
                *to++ += *from++;
            size_t e = h->pattern.neighbour_start[*node];
            for (const int32_t *high = node + 1; high < end; high++) {
                while (h->pattern.neighbour[e] < *high)
                    e++;
                for (int32_t i = 0; i < co_dof_map_dimension(r, *high); i++)
                    below[h->pattern.neighbour_row[e] + i] += *from++;
            }
        }
    }
}

static void collect_discs(const co_assembly *a, co_sparse_hessian *h) {
    for (int32_t k = 0; k < a->patches.wide.n_discs; k++)
        if (a->patches.wide.disc[k].is_used) {
            co_blend_disc_hessian_collect(&h->discs, k, h->disc_matrix);
            add_disc(h, k, co_blend_disc_hessian_n_variables(&h->discs, k));
        }
}

/* Each thread owns some columns, and some discs, so that sums come in the same order for any number of threads. */
static void scatter_chunk(const co_assembly *a, co_sparse_hessian *h, int32_t first, int32_t n) {
    int32_t n_nodes = h->dofs->n_nodes;
#pragma omp parallel for schedule(static) num_threads(a->n_threads)
    for (int32_t t = 0; t < a->n_threads; t++) {
        int32_t begin = (int32_t)((int64_t)n_nodes * t / a->n_threads);
        int32_t end = (int32_t)((int64_t)n_nodes * (t + 1) / a->n_threads);
        for (int32_t k = 0; k < n; k++)
            for (int32_t lane = 0; lane < h->batches.block[first + k].n_used; lane++)
                scatter_face(a, h, first + k, lane, h->chunk + (size_t)k * h->matrix_stride, begin, end);
        for (int32_t k = 0; k < n; k++)
            scatter_discs(a, h, first + k, h->chunk + (size_t)k * h->matrix_stride, t);
    }
}

/* Sets h->before from positions. */
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
    memset(h->value, 0, h->pattern.n_entries * sizeof(double));
    co_blend_disc_hessian_clear(&h->discs);
    co_assembly_evaluate(a, x, &(co_request){.is_normalized = 1}, &values); /* sets the points, gives the integrals */
    double area = whole ? whole->area : values.integral[CO_INT_AREA];
    double third = whole ? whole->third : co_functional_integrate(&f->third, values.integral);
    co_integrand integrand = f->second;
    co_integrand_add(&integrand, area, &f->third);
    integrand.area += f->has_third ? third : 0;
    for (int32_t first = 0; first < h->batches.n_blocks; first += CHUNK_BLOCKS) {
        int32_t n = h->batches.n_blocks - first;
        n = n > CHUNK_BLOCKS ? CHUNK_BLOCKS : n;
        run_chunk(a, h, first, n, &integrand, exact, kind->before ? h->before : NULL);
        scatter_chunk(a, h, first, n);
        if (co_cancel_is_due(a->cancel)) /* something may be missing */
            return CO_CANCELLED;
    }
    collect_discs(a, h);
    return CURVOPT_OK;
}

double co_sparse_hessian_mean_diagonal(const co_sparse_hessian *h) {
    double sum = 0;
    for (int32_t i = 0; i < h->dofs->n_variables; i++)
        sum += h->value[h->pattern.column_start[i]];
    return sum / h->dofs->n_variables;
}

/* Second derivatives of an objective over the cage's coordinates, sparse. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/sparse_hessian.h"

#include "base/memory.h"
#include "energy/assembly_sums.h"

#include <stdatomic.h>
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
    free(h->fold);
    free(h->panel);
    co_stencils_free(&h->stencils);
    co_sparsity_free(&h->pattern);
    co_blend_disc_hessian_free(&h->discs);
    co_element_batches_free(&h->batches);
    *h = (co_sparse_hessian){0};
}

enum { KEY_OF_COARSEST = -2 };

/* Batches with the same key have the same rules. */
static int64_t key_of(const co_assembly *a, int coarser) {
    return coarser == CO_COARSEST_RULES ? KEY_OF_COARSEST : (int64_t)a->rules_version * CO_N_RULES + coarser;
}

/* Makes the batches, by rules so many steps coarser than the assembly's, or the coarsest, and room for them. */
static int32_t update_batches(co_assembly *a, co_sparse_hessian *h, int coarser, curvopt_error *error) {
    size_t lanes = (size_t)a->kernel->lanes;
    co_element_batches_free(&h->batches);
    free(h->chunk);
    free(h->work);
    h->chunk = h->work = NULL;
    h->rules_key = NO_RULES;
    const co_element_batches_spec spec = {.patches = &a->patches,
                                          .cache = a->cache,
                                          .lanes = a->kernel->lanes,
                                          .rule = a->rule,
                                          .step = -coarser,
                                          .coarsest = CO_ROUGH_RULE};
    int32_t status = co_element_batches_create(&spec, &h->batches, error);
    if (status != CURVOPT_OK)
        return status;
    h->matrix_stride = co_element_hessian_size(h->batches.max_points) * CO_BLOCK_FACES;
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

int32_t co_sparse_hessian_create(const co_assembly *a, const co_dof_map *dofs, const co_couplings *couplings,
                                 co_sparse_hessian *h, curvopt_error *error) {
    *h = (co_sparse_hessian){.dofs = dofs, .rules_key = NO_RULES, .sums = co_row_sums_of(co_best_instruction_set())};
    int32_t status = co_sparsity_create(&a->patches, dofs, couplings, a->cancel, &h->pattern, error);
    if (status == CURVOPT_OK && !(h->value = CO_NEW(double, h->pattern.n_entries)))
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = co_stencils_create(&a->patches, dofs, &h->pattern, a->cancel, &h->stencils, error);
    if (status == CURVOPT_OK) {
        size_t n = (size_t)h->stencils.most_used;
        h->fold_stride = 9 * n * (n + 1);
        h->fold = CO_NEW(double, (size_t)a->n_threads * h->fold_stride);
        h->panel = CO_NEW(int32_t, (size_t)a->n_threads * (size_t)h->stencils.most_points);
        status = h->fold && h->panel ? CURVOPT_OK : co_status_no_memory(error);
    }
    if (status == CURVOPT_OK)
        status = allocate_discs(a, h, error);
    if (status != CURVOPT_OK)
        co_sparse_hessian_free(h);
    return status;
}

/* ----------------------------------------------------------------------------------------------- values -- */

/* One face's matrix, and where it goes. */
typedef struct face_matrix {
    const co_dof_map *dofs;
    const co_sparsity *pattern;
    const co_stencils *stencils;
    size_t first, n_vertices; /* the face's vertices in `stencils` */
    const int32_t *place;     /* of its pairs of vertices */
    size_t n_points;          /* own points of the patch that its table has */
    const int32_t *panel;     /* place of each own point of the patch among them; -1: none */
    const double *panels;     /* [n_points][n_points][3][3] second derivatives: those of point q's coordinates (columns)
                                 with all points' (rows) stand together */
    double *sum;              /* [n_points][3][3] work space */
    double *value;            /* entries of the sparse matrix */
    const co_row_sums *sums;
} face_matrix;

/* Fills panels [n_own][n_own][3][3] with a face's matrix (lower triangle by rows, with stride `lanes`), times `weight`,
 * and panel with the places of the n_all own points of the patch; those that the table does not have have no
 * derivatives. */
static void unpack(const co_basis_table *t, const double *matrix, size_t lanes, double weight, int32_t n_all,
                   double *panels, int32_t *panel) {
    const size_t n = (size_t)t->n_own;
    for (int32_t i = 0; i < n_all; i++)
        panel[i] = -1;
    for (size_t p = 0; p < n; p++) {
        panel[t->support[p]] = (int32_t)p;
        for (size_t r = 0; r < 3; r++) {
            const double *from = matrix + (3 * p + r) * (3 * p + r + 1) / 2 * lanes;
            for (size_t q = 0; q <= p; q++) {
                size_t n_c = q < p ? 3 : r + 1;
                double *to = panels + 9 * (q * n + p) + 3 * r;
                double *mirrored = panels + 9 * (p * n + q) + r;
                for (size_t c = 0; c < n_c; c++, from += lanes)
                    to[c] = mirrored[3 * c] = weight * *from;
            }
        }
    }
}

/* to [n] = sum of weight * from [point][n], or `from` itself where that is the sum. */
static const double *sum_of_points(const face_matrix *f, size_t vertex, size_t n, const double *from, double *to) {
    const co_stencils *s = f->stencils;
    const size_t e = s->column[vertex], end = s->column[vertex + 1];
    if (end - e == 1 && s->weight[e] == 1 && f->panel[s->point[e]] >= 0)
        return from + n * (size_t)f->panel[s->point[e]];
    f->sums->add_up(&(co_row_sum){end - e, s->weight + e, s->point + e, f->panel}, n, from, to);
    return to;
}

/* full = B_v^T block B_w, by the variables of v's node and w's. */
static void project_block(const co_dof_map *r, int32_t v, int32_t w, const double *block, double full[3][3]) {
    const double *left = r->basis + 9 * (size_t)v, *right = r->basis + 9 * (size_t)w;
    int32_t n_v = co_dof_map_dimension(r, r->node[v]), n_w = co_dof_map_dimension(r, r->node[w]);
    double half[3][3] = {{0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < n_w; k++)
            half[i][k] = block[3 * i] * right[k] + block[3 * i + 1] * right[3 + k] + block[3 * i + 2] * right[6 + k];
    for (int i = 0; i < n_v; i++)
        for (int k = 0; k < n_w; k++)
            full[i][k] = left[i] * half[0][k] + left[3 + i] * half[1][k] + left[6 + i] * half[2][k];
}

/* Adds the 3 x 3 block of the face's vertices i (rows) and j (columns), of different nodes, j's the smaller one. */
static void add_block(const face_matrix *f, size_t i, size_t j, const double *block) {
    const co_dof_map *r = f->dofs;
    int32_t v = f->stencils->vertex[f->first + i], w = f->stencils->vertex[f->first + j], low = r->node[w];
    const int32_t *column = f->pattern->column_start + r->first[low];
    size_t rows = (size_t)f->place[i * (i - 1) / 2 + j];
    if (r->plain) {
        for (size_t k = 0; k < 3; k++) {
            double *to = f->value + (size_t)column[k] + 3 - k + rows;
            for (size_t c = 0; c < 3; c++)
                to[c] += block[3 * c + k];
        }
        return;
    }
    double full[3][3] = {{0}};
    project_block(r, v, w, block, full);
    int32_t n_rows = co_dof_map_dimension(r, r->node[v]), n_columns = co_dof_map_dimension(r, low);
    for (int32_t k = 0; k < n_columns; k++) {
        double *to = f->value + column[k] + n_columns - k + rows;
        for (int32_t c = 0; c < n_rows; c++)
            to[c] += full[c][k];
    }
}

/* Adds the block of vertices i and j of one node, whose lower triangle is stored. For i not j the block of j and i is
 * added, too: both are entries of the node. */
static void add_own_block(const face_matrix *f, size_t i, size_t j, const double *block) {
    const co_dof_map *r = f->dofs;
    int32_t v = f->stencils->vertex[f->first + i], w = f->stencils->vertex[f->first + j], node = r->node[w];
    double full[3][3] = {{0}};
    project_block(r, v, w, block, full);
    for (int32_t k = 0; k < co_dof_map_dimension(r, node); k++)
        for (int32_t c = k; c < co_dof_map_dimension(r, node); c++)
            f->value[f->pattern->column_start[r->first[node] + k] + c - k] += full[c][k];
}

/* out = weight * block B_v, as many columns as v's node has variables. */
static void project_columns(const co_dof_map *r, const co_weighted_vertex *v, const double block[9], double out[3][3]) {
    const double *basis = r->basis + 9 * (size_t)v->at.vertex;
    const int32_t n = co_dof_map_dimension(r, v->at.node);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < n; k++)
            out[i][k] = v->weight *
                        (block[3 * i] * basis[k] + block[3 * i + 1] * basis[3 + k] + block[3 * i + 2] * basis[6 + k]);
}

/* Adds weight * B_v^T half to the rows of v's node, from to[k] on in column k; for a `twin` its transpose, too, and of
 * the node's own block the lower triangle alone. */
static void add_rows(const co_dof_map *r, const co_weighted_vertex *v, double half[3][3], int32_t n_columns, int is_own,
                     int is_twin, double *const to[3]) {
    const double *basis = r->basis + 9 * (size_t)v->at.vertex;
    const int32_t n_rows = co_dof_map_dimension(r, v->at.node);
    double full[3][3] = {{0}};
    for (int c = 0; c < n_rows; c++)
        for (int k = 0; k < n_columns; k++)
            full[c][k] = v->weight * (basis[c] * half[0][k] + basis[3 + c] * half[1][k] + basis[6 + c] * half[2][k]);
    for (int k = 0; k < n_columns; k++)
        for (int c = is_own ? k : 0; c < n_rows; c++)
            to[k][c] += full[c][k] + (is_twin ? full[k][c] : 0);
}

/* Nodes and the neighbours of each ascend: every pattern's column is gone through once. */
void co_sparse_hessian_add_sum(co_sparse_hessian *h, size_t n, const co_weighted_vertex *sum, const double block[9]) {
    const co_dof_map *r = h->dofs;
    const co_sparsity *p = &h->pattern;
    for (size_t j = 0; j < n; j++) {
        const int32_t low = sum[j].at.node, n_columns = co_dof_map_dimension(r, low);
        size_t at = p->neighbour_start[low];
        double half[3][3], *own[3], *to[3];
        project_columns(r, &sum[j], block, half);
        for (int32_t k = 0; k < n_columns; k++)
            own[k] = h->value + p->column_start[r->first[low] + k] - k;
        for (size_t i = j; i < n; i++) {
            const int is_own = sum[i].at.node == low;
            while (!is_own && p->neighbour[at] < sum[i].at.node)
                at++;
            for (int32_t k = 0; k < n_columns; k++)
                to[k] = own[k] + (is_own ? 0 : n_columns + p->neighbour_row[at]);
            add_rows(r, &sum[i], half, n_columns, is_own, is_own && i > j, to);
        }
    }
}

/* Nodes and the neighbours of each ascend: every pattern's column is gone through once. */
void co_sparse_hessian_add_square(co_sparse_hessian *h, int32_t n, const co_node_derivative *d, double factor) {
    const co_dof_map *r = h->dofs;
    const co_sparsity *p = &h->pattern;
    for (int32_t i = 0; i < n; i++) {
        const int32_t low = d[i].node, n_columns = co_dof_map_dimension(r, low);
        double *column[3], times[3];
        for (int32_t k = 0; k < n_columns; k++) {
            column[k] = h->value + p->column_start[r->first[low] + k] + n_columns - k; /* below the node's own rows */
            times[k] = factor * d[i].by[k];
            for (int32_t c = k; c < n_columns; c++)
                column[k][c - n_columns] += times[k] * d[i].by[c];
        }
        size_t at = p->neighbour_start[low];
        for (int32_t j = i + 1; j < n; j++) {
            while (p->neighbour[at] < d[j].node)
                at++;
            const int32_t rows = p->neighbour_row[at], n_rows = co_dof_map_dimension(r, d[j].node);
            for (int32_t k = 0; k < n_columns; k++)
                for (int32_t c = 0; c < n_rows; c++)
                    column[k][rows + c] += times[k] * d[j].by[c];
        }
    }
}

/* Adds the columns of the face's vertex j (libcurvopt/notes/49-from-points-to-vertices.md). With M the face's matrix
 * over its points and T the stencil's, the matrix over the vertices is T^T M T: M T_j first, then the rows of each
 * vertex. */
static void add_vertex(const face_matrix *f, size_t j) {
    const int32_t *node = f->dofs->node, *vertex = f->stencils->vertex + f->first;
    const double *column = sum_of_points(f, f->first + j, 9 * f->n_points, f->panels, f->sum);
    size_t i = j;
    while (i > 0 && node[vertex[i - 1]] == node[vertex[j]])
        i--;
    for (; i < f->n_vertices; i++) {
        double sum[9];
        const double *block = sum_of_points(f, f->first + i, 9, column, sum);
        if (node[vertex[i]] == node[vertex[j]])
            add_own_block(f, i, j, block);
        else
            add_block(f, i, j, block);
    }
}

/* Some nodes, by number, and room for one face's matrix: what a thread adds to. */
typedef struct share {
    int32_t begin, end;
    double *fold;   /* [fold_stride] */
    int32_t *panel; /* [stencils.most_points] */
} share;

/* The matrix of a block's face among the block's; its entries have a distance of h->batches.lanes. */
static const double *matrix_of(const co_sparse_hessian *h, int32_t block, int32_t lane, const double *matrices) {
    const size_t n = co_element_hessian_size(h->batches.block[block].table->n_points);
    return matrices + co_lane_place((size_t)lane, n, (size_t)h->batches.lanes);
}

/* Adds one face's matrix, in its lane of a block's, to the columns of some nodes. */
static void scatter_face(const co_assembly *a, co_sparse_hessian *h, int32_t block, int32_t lane, const double *matrix,
                         const share *mine) {
    const co_block *b = &h->batches.block[block];
    const int32_t *node = h->dofs->node;
    const int32_t patch = co_element_batches_patch(&h->batches, block, lane);
    const co_stencils *s = &h->stencils;
    const size_t n_own = (size_t)b->table->n_own;
    const face_matrix f = {.dofs = h->dofs,
                           .pattern = &h->pattern,
                           .stencils = s,
                           .first = s->start[patch],
                           .n_vertices = s->start[patch + 1] - s->start[patch],
                           .place = s->place + s->pair[patch],
                           .n_points = n_own,
                           .panel = mine->panel,
                           .panels = mine->fold,
                           .sum = mine->fold + 9 * n_own * n_own,
                           .value = h->value,
                           .sums = h->sums};
    const int32_t *vertex = s->vertex + f.first;
    if (f.n_vertices == 0 || node[vertex[0]] >= mine->end || node[vertex[f.n_vertices - 1]] < mine->begin)
        return;
    unpack(b->table, matrix_of(h, block, lane, matrix), (size_t)h->batches.lanes, a->weight ? a->weight[patch] : 1,
           co_patches_own_size(a->patches.kind[patch]), mine->fold, mine->panel);
    for (size_t j = 0; j < f.n_vertices && !co_cancel_is_due(a->cancel); j++)
        if (node[vertex[j]] >= mine->begin && node[vertex[j]] < mine->end)
            add_vertex(&f, j);
}

/* Blocks whose matrices are evaluated together. */
typedef struct chunk_run {
    co_assembly *assembly;
    co_sparse_hessian *hessian;
    int32_t first, n;
    const co_integrand *integrand;
    int exact;
    const double *before;      /* [3 n_points] or NULL */
    _Atomic int32_t next_free; /* number of blocks that some thread has taken */
} chunk_run;

/* Threads take the blocks one by one: costs differ, and each matrix is written by its own thread only. */
static void run_blocks_of_chunk(void *context, int32_t thread, int32_t n_threads) {
    chunk_run *r = context;
    const co_assembly *a = r->assembly;
    co_sparse_hessian *h = r->hessian;
    int32_t k;
    (void)n_threads;
    while ((k = atomic_fetch_add_explicit(&r->next_free, 1, memory_order_relaxed)) < r->n) {
        const co_block *b = &h->batches.block[r->first + k];
        co_element_hessian element = {.table = b->table,
                                      .n_used = b->n_used,
                                      .points = h->batches.points + b->points,
                                      .xyz = a->points,
                                      .before = r->before,
                                      .eps4 = a->eps4,
                                      .integrand = *r->integrand,
                                      .third = a->functional.has_third,
                                      .cancel = a->cancel,
                                      .exact = r->exact,
                                      .matrix = h->chunk + (size_t)k * h->matrix_stride,
                                      .work = h->work + (size_t)thread * h->work_stride};
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
        co_blend_disc_face_matrix face = {.patch = co_element_batches_patch(&h->batches, block, lane),
                                          .n_own = b->table->n_own,
                                          .n_terms = b->table->n_points - b->table->n_own,
                                          .points =
                                              h->batches.points + co_element_batches_point(&h->batches, block, lane, 0),
                                          .face = matrix_of(h, block, lane, matrix),
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

/* A disc of hundreds of faces takes tenths of a second. */
static void collect_discs(const co_assembly *a, co_sparse_hessian *h) {
    for (int32_t k = 0; k < a->patches.wide.n_discs && !co_cancel_is_due(a->cancel); k++)
        if (a->patches.wide.disc[k].is_used) {
            co_blend_disc_hessian_collect(&h->discs, k, h->disc_matrix);
            add_disc(h, k, co_blend_disc_hessian_n_variables(&h->discs, k));
        }
}

/* Each thread owns some columns, and some discs, so that sums come in the same order for any number of threads. */
static void scatter_chunk(void *context, size_t begin, size_t end) {
    const chunk_run *r = context;
    const co_assembly *a = r->assembly;
    co_sparse_hessian *h = r->hessian;
    const int32_t n_nodes = h->dofs->n_nodes, first = r->first, n = r->n;
    for (int32_t t = (int32_t)begin; t < (int32_t)end; t++) {
        const share mine = {.begin = (int32_t)((int64_t)n_nodes * t / a->n_threads),
                            .end = (int32_t)((int64_t)n_nodes * (t + 1) / a->n_threads),
                            .fold = h->fold + (size_t)t * h->fold_stride,
                            .panel = h->panel + (size_t)t * (size_t)h->stencils.most_points};
        for (int32_t k = 0; k < n; k++)
            for (int32_t lane = 0; lane < h->batches.block[first + k].n_used; lane++)
                scatter_face(a, h, first + k, lane, h->chunk + (size_t)k * h->matrix_stride, &mine);
        for (int32_t k = 0; k < n; k++)
            scatter_discs(a, h, first + k, h->chunk + (size_t)k * h->matrix_stride, t);
    }
}

/* Sets h->before from positions. */
static int32_t place_before(const co_assembly *a, const double *x, co_sparse_hessian *h, curvopt_error *error) {
    h->before = h->before ? h->before : CO_NEW(double, 3 * (size_t)a->patches.n_points);
    if (!h->before)
        return co_status_no_memory(error);
    co_assembly_place_normalized(a, x, h->before);
    return CURVOPT_OK;
}

static void clear_entries(void *value, size_t begin, size_t end) {
    memset((double *)value + begin, 0, (end - begin) * sizeof(double));
}

int32_t co_sparse_hessian_assemble(co_assembly *a, const double *x, const co_second_kind *kind, co_sparse_hessian *h,
                                   curvopt_error *error) {
    const int exact = kind->exact;
    const co_whole *whole = kind->whole;
    int32_t status = h->rules_key == key_of(a, kind->coarser) ? CURVOPT_OK : update_batches(a, h, kind->coarser, error);
    if (status == CURVOPT_OK && kind->before)
        status = place_before(a, kind->before, h, error);
    if (status != CURVOPT_OK)
        return status;
    co_values values;
    const co_functional *f = &a->functional;
    co_thread_pool_for(co_thread_pool_if_worth(a->threads, h->pattern.n_entries), h->pattern.n_entries, clear_entries,
                       h->value);
    co_blend_disc_hessian_clear(&h->discs);
    co_assembly_evaluate(a, x, &(co_request){.is_normalized = 1}, &values); /* sets the points, gives the integrals */
    double area = whole ? whole->area : values.integral[CO_INT_AREA];
    double third = whole ? whole->third : co_functional_integrate(&f->third, values.integral);
    co_integrand integrand = f->second;
    co_integrand_add(&integrand, area, &f->third);
    integrand.area += f->has_third ? third : 0;
    if (exact && kind->more)
        co_integrand_add(&integrand, 1, kind->more);
    for (int32_t first = 0; first < h->batches.n_blocks; first += CHUNK_BLOCKS) {
        int32_t n = h->batches.n_blocks - first;
        n = n > CHUNK_BLOCKS ? CHUNK_BLOCKS : n;
        chunk_run r = {.assembly = a,
                       .hessian = h,
                       .first = first,
                       .n = n,
                       .integrand = &integrand,
                       .exact = exact,
                       .before = kind->before ? h->before : NULL};
        co_thread_pool_run(a->threads, run_blocks_of_chunk, &r);
        co_thread_pool_for(a->threads, (size_t)a->n_threads, scatter_chunk, &r);
        if (co_cancel_is_due(a->cancel)) /* something may be missing */
            return CO_CANCELLED;
    }
    collect_discs(a, h);
    return co_cancel_is_due(a->cancel) ? CO_CANCELLED : CURVOPT_OK;
}

void co_sparse_hessian_multiply(const co_sparse_hessian *h, const double *v, double *out) {
    const co_sparsity *p = &h->pattern;
    memset(out, 0, (size_t)h->dofs->n_variables * sizeof *out);
    for (int32_t j = 0; j < h->dofs->n_variables; j++)
        for (int32_t e = p->column_start[j]; e < p->column_start[j + 1]; e++) {
            out[p->row[e]] += h->value[e] * v[j];
            if (p->row[e] != j)
                out[j] += h->value[e] * v[p->row[e]];
        }
}

double co_sparse_hessian_mean_diagonal(const co_sparse_hessian *h) {
    double sum = 0;
    for (int32_t i = 0; i < h->dofs->n_variables; i++)
        sum += h->value[h->pattern.column_start[i]];
    return sum / h->dofs->n_variables;
}

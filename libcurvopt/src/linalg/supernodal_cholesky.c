/* Numbers of a supernodal Cholesky factor. SPDX-License-Identifier: GPL-3.0-or-later */
#include "linalg/supernodal_cholesky.h"

#include "base/memory.h"
#include "linalg/blas.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { WIDEST = 192 };                            /* columns of a panel; wider supernodes are cut into equal ones */
static const double WORTH_THREADS = 4e6;          /* operations from which a second thread is woken */
static const double BETWEEN_LOOKS = 1e8;          /* operations between two looks at the flag, at most: some ms */
static const double ONE = 1, ZERO = 0, LESS = -1; /* for the BLAS */

/* Columns begin .. end - 1 of a supernode, counted from its first. */
typedef struct panel {
    int supernode, begin, end;
} panel;

/* What supernode `from` subtracts from another one begins with its row `at`. */
typedef struct update {
    int from, at;
} update;

/* An entry of A goes to a place in its supernode's block. */
typedef struct entry {
    int index, place;
} entry;

/* What one thread works with. */
typedef struct work {
    int *local;    /* [n] rows of L: which of the block's rows; set for those of the present block alone */
    int *relative; /* [most_rows] likewise, of an update's rows */
    double *sum;   /* [most_sums] an update */
} work;

struct co_supernodal_cholesky {
    const co_supernodes *s;
    co_thread_pool *threads;
    co_cancel *cancel;
    int n_panels;
    panel *panel;        /* [n_panels] by columns */
    int *first_panel;    /* [n_supernodes + 1] */
    int *order;          /* [n_panels] in which threads take panels: none comes before what it needs */
    int *update_start;   /* [n_supernodes + 2], the last for making it */
    update *update;      /* of each supernode, in the order in which they are subtracted */
    size_t *entry_start; /* [n_panels + 1] */
    entry *entry;        /* of each panel */
    int32_t n_works;
    work *work; /* [n_works] */
    int most_rows;
    size_t most_sums;
    double *x, *gathered; /* [n], [most_rows] of a solution */
    /* a factor that is being made */
    atomic_int *is_done; /* [n_panels] */
    atomic_int next, has_failed, is_cancelled;
    const double *value;
    double shift, *l;
};

/* ------------------------------------------------------------------------------------------------------- plan -- */

/* The end of the rows of supernode k, from row `at` on, that are columns of the supernode that has row `at`. */
static int end_of_run(const co_supernodes *s, const int *supernode_of, int k, int at) {
    const int *row = co_supernodes_rows(s, k), to = supernode_of[row[at]];
    int end = at;
    while (end < co_supernodes_n_rows(s, k) && row[end] < s->column[to + 1])
        end++;
    return end;
}

/* The updates of each supernode, by the supernodes that they come from. */
static int32_t list_updates(co_supernodal_cholesky *p, const int *supernode_of, curvopt_error *error) {
    const co_supernodes *s = p->s;
    const size_t n = (size_t)s->n_supernodes;
    p->update_start = CO_NEW(int, n + 2);
    if (!p->update_start)
        return co_status_no_memory(error);
    /* of those that are listed so far; while they are counted, each number stands one further on */
    int *end = p->update_start + 1;
    for (int k = 0; k < s->n_supernodes; k++)
        for (int i = co_supernodes_width(s, k); i < co_supernodes_n_rows(s, k); i = end_of_run(s, supernode_of, k, i))
            end[supernode_of[co_supernodes_rows(s, k)[i]] + 1]++;
    for (size_t k = 0; k < n; k++)
        end[k + 1] += end[k];
    p->update = CO_NEW(update, end[n]);
    if (!p->update)
        return co_status_no_memory(error);
    for (int k = 0; k < s->n_supernodes; k++)
        for (int i = co_supernodes_width(s, k); i < co_supernodes_n_rows(s, k); i = end_of_run(s, supernode_of, k, i))
            p->update[end[supernode_of[co_supernodes_rows(s, k)[i]]]++] = (update){k, i};
    return CURVOPT_OK;
}

static int32_t cut_into_panels(co_supernodal_cholesky *p, curvopt_error *error) {
    const co_supernodes *s = p->s;
    p->first_panel = CO_NEW(int, s->n_supernodes + 1);
    if (!p->first_panel)
        return co_status_no_memory(error);
    for (int k = 0; k < s->n_supernodes; k++)
        p->first_panel[k + 1] = p->first_panel[k] + (co_supernodes_width(s, k) + WIDEST - 1) / WIDEST;
    p->n_panels = p->first_panel[s->n_supernodes];
    p->panel = CO_NEW(panel, p->n_panels);
    p->order = CO_NEW(int, p->n_panels);
    p->is_done = CO_NEW(atomic_int, p->n_panels);
    if (!p->panel || !p->order || !p->is_done)
        return co_status_no_memory(error);
    for (int k = 0; k < s->n_supernodes; k++) {
        const int n = p->first_panel[k + 1] - p->first_panel[k];
        for (int i = 0; i < n; i++)
            p->panel[p->first_panel[k] + i] = (panel){.supernode = k,
                                                      .begin = (int)((int64_t)co_supernodes_width(s, k) * i / n),
                                                      .end = (int)((int64_t)co_supernodes_width(s, k) * (i + 1) / n)};
    }
    return CURVOPT_OK;
}

/* Rank of a panel: panels of lower rank do not need it. Those of one supernode follow each other; a supernode comes
 * after all that updates it. */
static int32_t order_panels(co_supernodal_cholesky *p, const int *supernode_of, curvopt_error *error) {
    const co_supernodes *s = p->s;
    int *rank = CO_NEW(int, s->n_supernodes + 1), highest = 0;
    if (!rank)
        return co_status_no_memory(error);
    for (int k = 0; k < s->n_supernodes; k++) { /* rank[k] is that of its first panel, final when it is its turn */
        const int after = rank[k] + p->first_panel[k + 1] - p->first_panel[k];
        highest = after > highest ? after : highest;
        if (co_supernodes_n_rows(s, k) > co_supernodes_width(s, k)) {
            int *parent = rank + supernode_of[co_supernodes_rows(s, k)[co_supernodes_width(s, k)]];
            *parent = after > *parent ? after : *parent;
        }
    }
    int *start = CO_NEW(int, highest + 1);
    if (start) {
        for (int i = 0; i < p->n_panels; i++)
            start[rank[p->panel[i].supernode] + i - p->first_panel[p->panel[i].supernode] + 1]++;
        for (int r = 0; r < highest; r++)
            start[r + 1] += start[r];
        for (int i = 0; i < p->n_panels; i++)
            p->order[start[rank[p->panel[i].supernode] + i - p->first_panel[p->panel[i].supernode]]++] = i;
    }
    free(start);
    free(rank);
    return start ? CURVOPT_OK : co_status_no_memory(error);
}

/* Which row of supernode k is row i of L. */
static int find_row(const co_supernodes *s, int k, int i) {
    const int *row = co_supernodes_rows(s, k);
    int low = co_supernodes_width(s, k), high = co_supernodes_n_rows(s, k);
    if (i < s->column[k + 1])
        return i - s->column[k];
    while (low + 1 < high) {
        const int middle = low + (high - low) / 2;
        if (row[middle] <= i)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Where entries of the matrix go. */
static int32_t place_entries(co_supernodal_cholesky *p, const int *supernode_of, const int *column_start,
                             const int *row, curvopt_error *error) {
    const co_supernodes *s = p->s;
    int *inverse = CO_NEW(int, s->n), *panel_of = CO_NEW(int, s->n);
    int32_t status = CURVOPT_OK;
    p->entry_start = CO_NEW(size_t, p->n_panels + 1);
    p->entry = CO_NEW(entry, column_start[s->n]);
    if (!inverse || !panel_of || !p->entry_start || !p->entry) {
        status = co_status_no_memory(error);
        goto done;
    }
    for (int k = 0; k < s->n; k++)
        inverse[s->permutation[k]] = k;
    for (int i = 0; i < p->n_panels; i++)
        for (int k = p->panel[i].begin; k < p->panel[i].end; k++)
            panel_of[s->column[p->panel[i].supernode] + k] = i;
    for (int pass = 0; pass < 2 && status == CURVOPT_OK; pass++) { /* counted, placed */
        for (int j = 0; j < s->n && status == CURVOPT_OK; j++) {
            if (co_cancel_is_due(p->cancel))
                status = CO_CANCELLED;
            for (int e = column_start[j]; e < column_start[j + 1]; e++) {
                const int a = inverse[j], b = inverse[row[e]], column = a < b ? a : b, i = panel_of[column];
                if (pass) {
                    const int k = supernode_of[column];
                    p->entry[p->entry_start[i]++] = (entry){
                        e, find_row(s, k, a < b ? b : a) + (column - s->column[k]) * co_supernodes_n_rows(s, k)};
                } else {
                    p->entry_start[i + 1]++;
                }
            }
        }
        for (int i = 0; !pass && i < p->n_panels; i++)
            p->entry_start[i + 1] += p->entry_start[i];
    }
    for (int i = p->n_panels; i > 0; i--)
        p->entry_start[i] = p->entry_start[i - 1];
    p->entry_start[0] = 0;
done:
    free(inverse);
    free(panel_of);
    return status;
}

/* The largest update. */
static void measure(co_supernodal_cholesky *p, const int *supernode_of) {
    const co_supernodes *s = p->s;
    for (int k = 0; k < s->n_supernodes; k++) {
        const int n_rows = co_supernodes_n_rows(s, k);
        p->most_rows = n_rows > p->most_rows ? n_rows : p->most_rows;
        for (int i = co_supernodes_width(s, k), end; i < n_rows; i = end) {
            end = end_of_run(s, supernode_of, k, i);
            const int widest = end - i < WIDEST ? end - i : WIDEST;
            const size_t size = (size_t)(n_rows - i) * (size_t)widest;
            p->most_sums = size > p->most_sums ? size : p->most_sums;
        }
    }
}

static int32_t create_works(co_supernodal_cholesky *p, curvopt_error *error) {
    p->n_works = p->s->operations < WORTH_THREADS ? 1 : co_thread_pool_size(p->threads);
    p->work = CO_NEW(work, p->n_works);
    p->x = CO_NEW(double, p->s->n);
    p->gathered = CO_NEW(double, p->most_rows);
    if (!p->work || !p->x || !p->gathered)
        return co_status_no_memory(error);
    for (int32_t t = 0; t < p->n_works; t++) {
        p->work[t] = (work){.local = CO_NEW(int, p->s->n),
                            .relative = CO_NEW(int, p->most_rows),
                            .sum = CO_NEW_ALIGNED(double, p->most_sums)};
        if (!p->work[t].local || !p->work[t].relative || !p->work[t].sum)
            return co_status_no_memory(error);
    }
    return CURVOPT_OK;
}

int32_t co_supernodal_cholesky_create(const co_supernodes *structure, const int *column_start, const int *row,
                                      co_thread_pool *threads, co_cancel *cancel, co_supernodal_cholesky **out,
                                      curvopt_error *error) {
    co_supernodal_cholesky *p = *out = CO_NEW(co_supernodal_cholesky, 1);
    int *supernode_of = CO_NEW(int, structure->n);
    int32_t status = p && supernode_of ? CURVOPT_OK : co_status_no_memory(error);
    if (status != CURVOPT_OK)
        goto done;
    p->s = structure;
    p->threads = threads;
    p->cancel = cancel;
    for (int k = 0; k < p->s->n_supernodes; k++)
        for (int j = p->s->column[k]; j < p->s->column[k + 1]; j++)
            supernode_of[j] = k;
    status = cut_into_panels(p, error);
    if (status == CURVOPT_OK)
        status = list_updates(p, supernode_of, error);
    if (status == CURVOPT_OK)
        status = order_panels(p, supernode_of, error);
    if (status == CURVOPT_OK)
        status = place_entries(p, supernode_of, column_start, row, error);
    if (status == CURVOPT_OK) {
        measure(p, supernode_of);
        status = create_works(p, error);
    }
done:
    free(supernode_of);
    if (status != CURVOPT_OK) {
        co_supernodal_cholesky_destroy(p);
        *out = NULL;
    }
    return status;
}

void co_supernodal_cholesky_destroy(co_supernodal_cholesky *p) {
    if (!p)
        return;
    for (int32_t t = 0; p->work && t < p->n_works; t++) {
        free(p->work[t].local);
        free(p->work[t].relative);
        free(p->work[t].sum);
    }
    free(p->work);
    free(p->panel);
    free(p->first_panel);
    free(p->order);
    free(p->update_start);
    free(p->update);
    free(p->entry_start);
    free(p->entry);
    free(p->x);
    free(p->gathered);
    free(p->is_done);
    free(p);
}

/* ----------------------------------------------------------------------------------------------------- factor -- */

/* Whether the factor is to be given up, by the flag. */
static int is_over(co_supernodal_cholesky *p) {
    if (!co_cancel_is_due(p->cancel))
        return 0;
    atomic_store(&p->is_cancelled, 1);
    return 1;
}

/* Waits for a panel; 0 if the factor is given up meanwhile. */
static int wait_for(co_supernodal_cholesky *p, int i) {
    for (int looks = 0; !atomic_load_explicit(p->is_done + i, memory_order_acquire); looks++) {
        if (atomic_load_explicit(&p->has_failed, memory_order_relaxed))
            return 0;
        co_thread_pool_pause(looks);
    }
    return 1;
}

/* The panel's part of A + shift. */
static void begin_panel(const co_supernodal_cholesky *p, int i, double *block) {
    const panel *at = p->panel + i;
    const size_t n_rows = (size_t)co_supernodes_n_rows(p->s, at->supernode);
    memset(block + (size_t)at->begin * n_rows, 0, sizeof(double) * (size_t)(at->end - at->begin) * n_rows);
    for (size_t e = p->entry_start[i]; e < p->entry_start[i + 1]; e++)
        block[p->entry[e].place] = p->value[p->entry[e].index];
    for (size_t j = (size_t)at->begin; p->shift != 0 && j < (size_t)at->end; j++)
        block[j + j * n_rows] += p->shift;
}

/* C [rows][columns] = alpha A A^T[columns] + beta C, of which the lower part counts: A is [rows][width], and its first
 * rows are those of the columns. So many rows at a time that the flag is looked at between; 0 if it is raised. */
static int multiply(co_supernodal_cholesky *p, int rows, int columns, int width, const double *alpha, const double *a,
                    int stride, const double *beta, double *c, int c_stride) {
    const double at_a_time = BETWEEN_LOOKS / (2 * (double)columns * width);
    const int most = at_a_time < rows ? (int)at_a_time + 1 : rows;
    dsyrk_("L", "N", &columns, &width, alpha, a, &stride, beta, c, &c_stride, 1, 1);
    for (int i = columns; i < rows; i += most) {
        const int some = rows - i < most ? rows - i : most;
        if (is_over(p))
            return 0;
        dgemm_("N", "C", &some, &columns, &width, alpha, a + i, &stride, a, &stride, beta, c + i, &c_stride, 1, 1);
    }
    return 1;
}

/* Subtracts what an earlier supernode has for the panel's columns: with its rows `begin` .. `end` - 1 there, and those
 * below, L [rows] L [begin .. end]^T. 0 if the flag is raised. */
static int subtract(co_supernodal_cholesky *p, const panel *to, const update *u, const work *w, double *block) {
    const co_supernodes *s = p->s;
    const int *row = co_supernodes_rows(s, u->from), stride = co_supernodes_n_rows(s, u->from),
              width = co_supernodes_width(s, u->from);
    const int first = s->column[to->supernode] + to->begin, last = s->column[to->supernode] + to->end;
    int begin = u->at, end;
    while (begin < stride && row[begin] < first)
        begin++;
    for (end = begin; end < stride && row[end] < last;)
        end++;
    const int columns = end - begin, rows = stride - begin;
    if (columns == 0)
        return 1;
    const double *a = p->l + s->value_start[u->from] + begin;
    if (!multiply(p, rows, columns, width, &ONE, a, stride, &ZERO, w->sum, rows))
        return 0;
    for (int i = 0; i < rows; i++)
        w->relative[i] = w->local[row[begin + i]];
    const size_t n_rows = (size_t)co_supernodes_n_rows(s, to->supernode);
    for (int j = 0; j < columns; j++) {
        double *out = block + (size_t)w->relative[j] * n_rows;
        const double *in = w->sum + (size_t)j * (size_t)rows;
        for (int i = j; i < rows; i++)
            out[w->relative[i]] -= in[i];
    }
    return 1;
}

/* The same of an earlier panel of the same supernode, whose rows are the same. */
static int subtract_panel(co_supernodal_cholesky *p, const panel *to, const panel *from, int stride, double *block) {
    return multiply(p, stride - to->begin, to->end - to->begin, from->end - from->begin, &LESS,
                    block + (size_t)from->begin * (size_t)stride + to->begin, stride, &ONE,
                    block + (size_t)to->begin * (size_t)stride + to->begin, stride);
}

/* Makes panel i; 0 if it has no factor, or the factor is given up. */
static int make_panel(co_supernodal_cholesky *p, int i, const work *w) {
    const co_supernodes *s = p->s;
    const panel *at = p->panel + i;
    const int k = at->supernode, stride = co_supernodes_n_rows(s, k), columns = at->end - at->begin,
              below = stride - at->end;
    double *block = p->l + s->value_start[k];
    if (is_over(p)) /* before updates, too, for leaves of the tree have none */
        return 0;
    begin_panel(p, i, block);
    for (int r = 0; r < stride; r++)
        w->local[co_supernodes_rows(s, k)[r]] = r;
    for (int u = p->update_start[k]; u < p->update_start[k + 1]; u++) {
        if (is_over(p) || !wait_for(p, p->first_panel[p->update[u].from + 1] - 1) ||
            !subtract(p, at, p->update + u, w, block))
            return 0;
    }
    for (int earlier = p->first_panel[k]; earlier < i; earlier++) {
        if (is_over(p) || !wait_for(p, earlier) || !subtract_panel(p, at, p->panel + earlier, stride, block))
            return 0;
    }
    int info;
    double *diagonal = block + (size_t)at->begin * (size_t)stride + at->begin;
    dpotrf_("L", &columns, diagonal, &stride, &info, 1);
    if (info != 0)
        return 0;
    if (below)
        dtrsm_("R", "L", "C", "N", &below, &columns, &ONE, diagonal, &stride, diagonal + columns, &stride, 1, 1, 1, 1);
    return 1;
}

static void make_panels(void *context, int32_t thread, int32_t n_threads) {
    co_supernodal_cholesky *p = context;
    for (int taken; (taken = atomic_fetch_add(&p->next, 1)) < p->n_panels;) {
        const int i = n_threads > 1 ? p->order[taken] : taken; /* alone, what was made last is still in the cache */
        if (atomic_load(&p->has_failed))
            return;
        if (!make_panel(p, i, p->work + thread)) {
            atomic_store(&p->has_failed, 1);
            return;
        }
        atomic_store_explicit(p->is_done + i, 1, memory_order_release);
    }
}

int32_t co_supernodal_cholesky_factorize(co_supernodal_cholesky *p, const double *value, double shift, double *l,
                                         int *positive) {
    p->value = value;
    p->shift = shift;
    p->l = l;
    atomic_store(&p->next, 0);
    atomic_store(&p->has_failed, 0);
    atomic_store(&p->is_cancelled, 0);
    for (int i = 0; i < p->n_panels; i++)
        atomic_store_explicit(p->is_done + i, 0, memory_order_relaxed);
    co_thread_pool_run(p->n_works > 1 ? p->threads : NULL, make_panels, p);
    *positive = !atomic_load(&p->has_failed);
    return atomic_load(&p->is_cancelled) ? CO_CANCELLED : CURVOPT_OK;
}

/* --------------------------------------------------------------------------------------------------- solution -- */

static void gather(const co_supernodes *s, int k, const double *x, double *out) {
    const int *row = co_supernodes_rows(s, k);
    for (int i = co_supernodes_width(s, k); i < co_supernodes_n_rows(s, k); i++)
        out[i - co_supernodes_width(s, k)] = x[row[i]];
}

/* x := L^-1 x */
static void solve_forward(const co_supernodal_cholesky *p, const double *l, int k) {
    const co_supernodes *s = p->s;
    const int width = co_supernodes_width(s, k), stride = co_supernodes_n_rows(s, k), below = stride - width, step = 1;
    const double *block = l + s->value_start[k];
    double *x = p->x + s->column[k];
    dtrsv_("L", "N", "N", &width, block, &stride, x, &step, 1, 1, 1);
    if (!below)
        return;
    gather(s, k, p->x, p->gathered);
    dgemv_("N", &below, &width, &LESS, block + width, &stride, x, &step, &ONE, p->gathered, &step, 1);
    for (int i = 0; i < below; i++)
        p->x[co_supernodes_rows(s, k)[width + i]] = p->gathered[i];
}

/* x := L^-T x */
static void solve_backward(const co_supernodal_cholesky *p, const double *l, int k) {
    const co_supernodes *s = p->s;
    const int width = co_supernodes_width(s, k), stride = co_supernodes_n_rows(s, k), below = stride - width, step = 1;
    const double *block = l + s->value_start[k];
    double *x = p->x + s->column[k];
    if (below) {
        gather(s, k, p->x, p->gathered);
        dgemv_("C", &below, &width, &LESS, block + width, &stride, p->gathered, &step, &ONE, x, &step, 1);
    }
    dtrsv_("L", "C", "N", &width, block, &stride, x, &step, 1, 1, 1);
}

int32_t co_supernodal_cholesky_solve(co_supernodal_cholesky *p, const double *l, const double *b, double *x) {
    const co_supernodes *s = p->s;
    for (int k = 0; k < s->n; k++)
        p->x[k] = b[s->permutation[k]];
    for (int k = 0; k < s->n_supernodes; k++) {
        if (co_cancel_is_due(p->cancel))
            return CO_CANCELLED;
        solve_forward(p, l, k);
    }
    for (int k = s->n_supernodes; k-- > 0;) {
        if (co_cancel_is_due(p->cancel))
            return CO_CANCELLED;
        solve_backward(p, l, k);
    }
    for (int k = 0; k < s->n; k++)
        x[s->permutation[k]] = p->x[k];
    return CURVOPT_OK;
}

/* The subgroups of a cage's symmetries.
 *
 * Any subgroup is the trivial one with elements added one after the other. Trying every element on one of each class
 * of conjugates that is known gives one of each class (Neubueser, "Untersuchungen des Untergruppenverbandes endlicher
 * Gruppen auf einer programmgesteuerten elektronischen Dualmaschine", Numer. Math. 2, 1960, adds them more cleverly).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/subgroups.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { LARGEST_COUNT = 512 };

void co_subgroups_free(co_subgroups *s) {
    free(s->member);
    free(s->order);
    *s = (co_subgroups){0};
}

static int32_t product(const co_symmetry *s, int32_t a, int32_t b) {
    return s->product[a * s->order + b];
}

static int32_t inverse(const co_symmetry *s, int32_t g) {
    int32_t k = 0;
    while (product(s, g, k) != 0)
        k++;
    return k;
}

/* member [order] gains what a subgroup and one more element generate; returns how many there are. queue [order] */
static int32_t extend(const co_symmetry *s, int32_t element, uint8_t *member, int32_t *queue) {
    int32_t n = 0;
    for (int32_t g = 0; g < s->order; g++)
        if (member[g])
            queue[n++] = g;
    int32_t old = n;
    for (int32_t head = 0; head < n; head++) { /* times the old ones and the new one, from the right */
        for (int32_t k = 0; k <= old; k++) {
            int32_t next = product(s, queue[head], k < old ? queue[k] : element);
            if (!member[next]) {
                member[next] = 1;
                queue[n++] = next;
            }
        }
    }
    return n;
}

static int is_conjugate(const co_symmetry *s, const uint8_t *a, const uint8_t *b) {
    for (int32_t g = 0; g < s->order; g++) {
        int32_t back = inverse(s, g), h = 0;
        while (h < s->order && (!a[h] || b[product(s, product(s, g, h), back)]))
            h++;
        if (h == s->order)
            return 1;
    }
    return 0;
}

static int is_known(const co_symmetry *s, const co_subgroups *known, const uint8_t *member, int32_t order) {
    for (int32_t k = 0; k < known->n; k++)
        if (known->order[k] == order && is_conjugate(s, known->member + (size_t)k * (size_t)s->order, member))
            return 1;
    return 0;
}

static void find(const co_symmetry *s, co_subgroups *found, int32_t *queue) {
    size_t n = (size_t)s->order;
    found->member[0] = 1;
    found->order[0] = 1;
    found->n = 1;
    for (int32_t k = 0; k < found->n; k++)
        for (int32_t g = 0; g < s->order && found->n < LARGEST_COUNT; g++) {
            const uint8_t *from = found->member + (size_t)k * n;
            uint8_t *to = found->member + (size_t)found->n * n;
            if (from[g])
                continue;
            memcpy(to, from, n);
            found->order[found->n] = extend(s, g, to, queue);
            if (!is_known(s, found, to, found->order[found->n]))
                found->n++;
        }
}

/* The largest first; of the same order, the one found first. */
static void sort(const co_subgroups *found, co_subgroups *out) {
    size_t n = (size_t)found->n_elements;
    for (int32_t order = found->n_elements; order > 0; order--)
        for (int32_t k = 0; k < found->n; k++)
            if (found->order[k] == order) {
                memcpy(out->member + (size_t)out->n * n, found->member + (size_t)k * n, n);
                out->order[out->n++] = order;
            }
}

static int32_t allocate(const co_symmetry *s, co_subgroups *g, curvopt_error *error) {
    *g = (co_subgroups){.n_elements = s->order,
                        .member = CO_NEW(uint8_t, (LARGEST_COUNT + 1) * (size_t)s->order),
                        .order = CO_NEW(int32_t, LARGEST_COUNT + 1)};
    return g->member && g->order ? CURVOPT_OK : co_status_no_memory(error);
}

int32_t co_subgroups_create(const co_symmetry *s, co_subgroups *out, curvopt_error *error) {
    co_subgroups found = {0};
    int32_t *queue = CO_NEW(int32_t, s->order);
    int32_t status = allocate(s, out, error);
    if (status == CURVOPT_OK)
        status = allocate(s, &found, error);
    if (status == CURVOPT_OK && !queue)
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        find(s, &found, queue);
        sort(&found, out);
    }
    free(queue);
    co_subgroups_free(&found);
    if (status != CURVOPT_OK)
        co_subgroups_free(out);
    return status;
}

int32_t co_subgroup_select(const co_symmetry *s, const uint8_t *member, co_symmetry *out, curvopt_error *error) {
    size_t n = (size_t)s->n_corners, order = 0, a = 0;
    for (int32_t g = 0; g < s->order; g++)
        order += member[g];
    *out = (co_symmetry){.order = (int32_t)order,
                         .n_corners = s->n_corners,
                         .corner = CO_NEW(int32_t, order * n),
                         .mirrored = CO_NEW(uint8_t, order),
                         .matrix = CO_NEW(double, 9 * order),
                         .product = CO_NEW(int32_t, order * order)};
    int32_t *index = CO_NEW(int32_t, s->order); /* in the subgroup */
    int32_t status =
        index && out->corner && out->mirrored && out->matrix && out->product ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t g = 0, k = 0; status == CURVOPT_OK && g < s->order; g++)
        index[g] = member[g] ? k++ : -1;
    for (size_t g = 0; status == CURVOPT_OK && g < (size_t)s->order; g++) {
        if (!member[g])
            continue;
        memcpy(out->corner + a * n, s->corner + g * n, n * sizeof *s->corner);
        memcpy(out->matrix + 9 * a, s->matrix + 9 * g, 9 * sizeof *s->matrix);
        out->mirrored[a] = s->mirrored[g];
        for (size_t h = 0; h < (size_t)s->order; h++)
            if (member[h])
                out->product[a * order + (size_t)index[h]] = index[s->product[g * (size_t)s->order + h]];
        a++;
    }
    free(index);
    if (status != CURVOPT_OK)
        co_symmetry_free(out);
    return status;
}

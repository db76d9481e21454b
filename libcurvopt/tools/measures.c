/* What is measured of a surface, for reports. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measures.h"

#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b) {
    const int32_t *x = a, *y = b;
    for (int k = 0; k < 2; k++)
        if (x[k] != y[k])
            return x[k] < y[k] ? -1 : 1;
    return 0;
}

/* The input's face that a face of the subdivided cage comes from: child h of a cage is that of its corner h. */
static int32_t ancestor(const int32_t *sizes, int32_t n_faces, int32_t n_fine, int32_t face) {
    int64_t n_corners = 0;
    if (n_fine == n_faces)
        return face;
    for (int32_t f = 0; f < n_faces; f++)
        n_corners += sizes[f];
    for (int64_t n = n_fine; n > n_corners; n /= 4)
        face /= 4;
    int32_t f = 0;
    while (face >= sizes[f])
        face -= sizes[f++];
    return f;
}

/* Pairs of the input's faces instead of the subdivided cage's, each once. */
static int to_input(const curvopt_mesh *mesh, const curvopt_mesh *input, measures *m) {
    curvopt_mesh_info fine, coarse;
    curvopt_mesh_get_info(mesh, &fine, sizeof fine);
    curvopt_mesh_get_info(input, &coarse, sizeof coarse);
    int32_t *sizes = malloc(sizeof *sizes * (size_t)coarse.n_faces);
    int32_t *vertices = malloc(sizeof *vertices * (size_t)coarse.n_corners);
    int32_t n = m->crossings.n_listed, kept = 0;
    if (sizes && vertices) {
        curvopt_mesh_get_faces(input, sizes, vertices);
        for (int32_t k = 0; k < n; k++) {
            const int32_t a = ancestor(sizes, coarse.n_faces, fine.n_faces, m->pairs[2 * k]);
            const int32_t b = ancestor(sizes, coarse.n_faces, fine.n_faces, m->pairs[2 * k + 1]);
            m->pairs[2 * k] = a < b ? a : b;
            m->pairs[2 * k + 1] = a < b ? b : a;
        }
        qsort(m->pairs, (size_t)n, 2 * sizeof *m->pairs, compare);
        for (int32_t k = 0; k < n; k++)
            if (!kept || compare(m->pairs + 2 * (size_t)kept - 2, m->pairs + 2 * (size_t)k) != 0) {
                m->pairs[2 * kept] = m->pairs[2 * k];
                m->pairs[2 * kept++ + 1] = m->pairs[2 * k + 1];
            }
        if (n == m->crossings.n_pairs) /* else the pairs beyond are not known */
            m->crossings.n_pairs = kept;
        m->crossings.n_listed = kept;
    }
    const int fits = sizes && vertices;
    free(sizes);
    free(vertices);
    return fits;
}

int32_t measures_take(const curvopt_mesh *mesh, const double *xyz, const curvopt_mesh *input, const curvopt_mesh *from,
                      const double *from_xyz, int32_t threads, const curvopt_cancel *cancel, measures *m,
                      curvopt_error *error) {
    *m = (measures){.pairs = NULL};
    int32_t status = CURVOPT_ERROR_MEMORY;
    m->pairs = malloc(sizeof *m->pairs * 2 * MEASURES_MOST_PAIRS);
    if (m->pairs)
        status = curvopt_find_crossings(mesh, xyz, threads, cancel, MEASURES_MOST_PAIRS, m->pairs, &m->crossings,
                                        sizeof m->crossings, error);
    if (status == CURVOPT_OK && from)
        status = curvopt_measure_deviation(from, from_xyz, mesh, xyz, threads, cancel, &m->deviation,
                                           sizeof m->deviation, NULL, error);
    m->has_crossings = m->crossings.is_complete;
    m->has_deviation = from && isfinite(m->deviation.rms); /* NAN if it was cancelled */
    if (!m->pairs || (status == CURVOPT_OK && !to_input(mesh, input, m))) {
        status = CURVOPT_ERROR_MEMORY;
        snprintf(error->message, sizeof error->message, "%s", curvopt_status_text(status));
    }
    if (status != CURVOPT_OK)
        measures_free(m);
    return status;
}

void measures_free(measures *m) {
    free(m->pairs);
    *m = (measures){.pairs = NULL};
}

static void print_crossings(FILE *f, const measures *m) {
    enum { MOST_PRINTED = 8 };
    const curvopt_crossings *c = &m->crossings;
    fprintf(f, "%-22s %d pair%s of faces", "crosses itself", c->n_pairs, c->n_pairs == 1 ? "" : "s");
    for (int32_t k = 0; k < c->n_listed && k < MOST_PRINTED; k++)
        fprintf(f, "%s%d-%d", k ? " " : ": ", m->pairs[2 * (size_t)k], m->pairs[2 * (size_t)k + 1]);
    fprintf(f, "%s\n", c->n_listed > MOST_PRINTED ? " .." : "");
}

void measures_print(FILE *f, const measures *m, int always) {
    const curvopt_crossings *c = &m->crossings;
    const curvopt_deviation *d = &m->deviation;
    if (m->has_deviation)
        fprintf(f, "%-22s %.6g largest (at most %.6g), %.6g root mean square; %.3g and %.3g of the size\n", "deviation",
                d->max, d->bound, d->rms, d->max / d->size, d->rms / d->size);
    if (!m->has_crossings)
        return;
    if (c->n_pairs)
        print_crossings(f, m);
    else if (always)
        fprintf(f, "%-22s nowhere found\n", "crosses itself");
    if (c->n_contacts)
        fprintf(f, "%-22s %d pairs of faces, without a crossing that could be proven\n", "touches itself",
                c->n_contacts);
    if (c->n_unresolved && !c->n_pairs)
        fprintf(f, "%-22s %d pairs of faces come too close to tell\n", "may touch itself", c->n_unresolved);
}

void measures_write_json(FILE *f, const measures *m) {
    const curvopt_crossings *c = &m->crossings;
    const curvopt_deviation *d = &m->deviation;
    if (m->has_deviation)
        fprintf(f, "  \"deviation\": {\"max\": %.17g, \"rms\": %.17g, \"bound\": %.17g, \"size\": %.17g},\n", d->max,
                d->rms, d->bound, d->size);
    if (!m->has_crossings)
        return;
    fprintf(f, "  \"n_crossings\": %d, \"n_contacts\": %d, \"n_unresolved\": %d,\n  \"crossings\": [", c->n_pairs,
            c->n_contacts, c->n_unresolved);
    for (int32_t k = 0; k < c->n_listed; k++)
        fprintf(f, "%s[%d, %d]", k ? ", " : "", m->pairs[2 * (size_t)k], m->pairs[2 * (size_t)k + 1]);
    fprintf(f, "],\n");
}

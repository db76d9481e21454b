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

static int32_t out_of_memory(measures *m, curvopt_error *error) {
    snprintf(error->message, sizeof error->message, "%s", curvopt_status_text(CURVOPT_ERROR_MEMORY));
    measures_free(m);
    return CURVOPT_ERROR_MEMORY;
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
    if (!m->pairs || (status == CURVOPT_OK && !to_input(mesh, input, m)))
        return out_of_memory(m, error);
    if (status != CURVOPT_OK)
        measures_free(m);
    return status;
}

int32_t measures_take_touching(const curvopt_result *result, const curvopt_mesh *input, const double *xyz,
                               int32_t threads, const curvopt_cancel *cancel, measures *m, curvopt_error *error) {
    curvopt_summary summary;
    curvopt_crossings before = {.n_pairs = 0};
    curvopt_result_get_summary(result, &summary, sizeof summary);
    const int32_t room =
        summary.n_crossing_before < MEASURES_MOST_PAIRS ? summary.n_crossing_before : MEASURES_MOST_PAIRS;
    m->touching = malloc(sizeof *m->touching * 2 * (size_t)(summary.n_touching + 1));
    m->before = malloc(sizeof *m->before * 2 * (size_t)(room + 1));
    if (!m->touching || !m->before)
        return out_of_memory(m, error);
    curvopt_result_get_touching(result, m->touching);
    if (room) {
        const int32_t status =
            curvopt_find_crossings(input, xyz, threads, cancel, room, m->before, &before, sizeof before, error);
        if (status != CURVOPT_OK) {
            measures_free(m);
            return status;
        }
    }
    m->n_touching = summary.n_touching;
    m->clearance = summary.clearance;
    m->n_before = summary.n_crossing_before;
    m->n_before_listed = before.n_listed;
    m->n_refused = summary.n_refused;
    m->has_touching = 1;
    return CURVOPT_OK;
}

int32_t measures_take_folds(const curvopt_mesh *input, const double *xyz, const curvopt_options *options,
                            const curvopt_cancel *cancel, measures *m, curvopt_error *error) {
    curvopt_mesh_info info;
    curvopt_mesh_get_info(input, &info, sizeof info);
    m->folded = malloc(sizeof *m->folded * (size_t)(info.n_faces + 1));
    if (!m->folded)
        return out_of_memory(m, error);
    const int32_t status = curvopt_find_folds(input, xyz, options, cancel, m->folded, NULL, error);
    if (status != CURVOPT_OK) {
        measures_free(m);
        return status;
    }
    for (int32_t f = 0; f < info.n_faces; f++)
        if (m->folded[f])
            m->folded[m->n_folded++] = f;
    m->n_unfolded = -1;
    m->has_folds = 1;
    return CURVOPT_OK;
}

void measures_free(measures *m) {
    free(m->pairs);
    free(m->touching);
    free(m->before);
    free(m->folded);
    *m = (measures){.pairs = NULL};
}

static void print_pairs(FILE *f, const char *what, int32_t n, int32_t n_listed, const int32_t *pairs) {
    enum { MOST_PRINTED = 8 };
    fprintf(f, "%-22s %d pair%s of faces", what, n, n == 1 ? "" : "s");
    for (int32_t k = 0; k < n_listed && k < MOST_PRINTED; k++)
        fprintf(f, "%s%d-%d", k ? " " : ": ", pairs[2 * (size_t)k], pairs[2 * (size_t)k + 1]);
    fprintf(f, "%s", n_listed > MOST_PRINTED ? " .." : "");
}

static void print_touching(FILE *f, const measures *m) {
    if (m->n_touching) {
        print_pairs(f, "held by contact", m->n_touching, m->n_touching, m->touching);
        fprintf(f, "; least distance %.3g\n", m->clearance);
    }
    if (m->n_before) {
        print_pairs(f, "crossed before", m->n_before, m->n_before_listed, m->before);
        fprintf(f, "; these may go on crossing\n");
    }
}

/* What was done, or is to be done, about folds. */
static void print_folds(FILE *f, const measures *m) {
    enum { MOST_PRINTED = 8 };
    if (!m->n_folded)
        return;
    fprintf(f, "%-22s %d face%s:", m->n_unfolded < 0 ? "folded" : "folded before", m->n_folded,
            m->n_folded == 1 ? "" : "s");
    for (int32_t k = 0; k < m->n_folded && k < MOST_PRINTED; k++)
        fprintf(f, " %d", m->folded[k]);
    fprintf(f, "%s", m->n_folded > MOST_PRINTED ? " .." : "");
    if (m->n_unfolded > 0)
        fprintf(f, "; first %d vert%s put between their neighbours\n", m->n_unfolded,
                m->n_unfolded == 1 ? "ex was" : "ices were");
    else
        fprintf(f, "; the surface has a point without a tangent plane there, and energies of curvature are infinite: "
                   "move vertices back that lie beyond others\n");
}

void measures_print(FILE *f, const measures *m, int always) {
    const curvopt_crossings *c = &m->crossings;
    const curvopt_deviation *d = &m->deviation;
    if (m->has_deviation)
        fprintf(f, "%-22s %.6g largest (at most %.6g), %.6g root mean square; %.3g and %.3g of the size\n", "deviation",
                d->max, d->bound, d->rms, d->max / d->size, d->rms / d->size);
    if (m->has_touching)
        print_touching(f, m);
    print_folds(f, m);
    if (!m->has_crossings)
        return;
    if (c->n_pairs) {
        print_pairs(f, "crosses itself", c->n_pairs, c->n_listed, m->pairs);
        fprintf(f, "\n");
    } else if (always)
        fprintf(f, "%-22s nowhere found\n", "crosses itself");
    if (c->n_contacts)
        fprintf(f, "%-22s %d pairs of faces, without a crossing that could be proven\n", "touches itself",
                c->n_contacts);
    if (c->n_unresolved && !c->n_pairs)
        fprintf(f, "%-22s %d pairs of faces come too close to tell\n", "may touch itself", c->n_unresolved);
}

static void write_pairs(FILE *f, const char *key, int32_t n, const int32_t *pairs) {
    fprintf(f, "\"%s\": [", key);
    for (int32_t k = 0; k < n; k++)
        fprintf(f, "%s[%d, %d]", k ? ", " : "", pairs[2 * (size_t)k], pairs[2 * (size_t)k + 1]);
    fprintf(f, "]");
}

static void write_touching(FILE *f, const measures *m) {
    fprintf(f, "  \"no_crossings\": {\"clearance\": ");
    fprintf(f, isfinite(m->clearance) ? "%.17g" : "null", m->clearance);
    fprintf(f, ", \"n_refused\": %d,\n    ", m->n_refused);
    write_pairs(f, "touching", m->n_touching, m->touching);
    fprintf(f, ",\n    \"n_crossings_before\": %d, ", m->n_before);
    write_pairs(f, "crossings_before", m->n_before_listed, m->before);
    fprintf(f, "},\n");
}

static void write_folds(FILE *f, const measures *m) {
    fprintf(f, "  \"n_folded\": %d, ", m->n_folded);
    if (m->n_unfolded >= 0)
        fprintf(f, "\"n_unfolded\": %d, ", m->n_unfolded);
    fprintf(f, "\"folded\": [");
    for (int32_t k = 0; k < m->n_folded; k++)
        fprintf(f, "%s%d", k ? ", " : "", m->folded[k]);
    fprintf(f, "],\n");
}

void measures_write_json(FILE *f, const measures *m) {
    const curvopt_crossings *c = &m->crossings;
    const curvopt_deviation *d = &m->deviation;
    if (m->has_deviation)
        fprintf(f, "  \"deviation\": {\"max\": %.17g, \"rms\": %.17g, \"bound\": %.17g, \"size\": %.17g},\n", d->max,
                d->rms, d->bound, d->size);
    if (m->has_touching)
        write_touching(f, m);
    if (m->has_folds)
        write_folds(f, m);
    if (!m->has_crossings)
        return;
    fprintf(f, "  \"n_crossings\": %d, \"n_contacts\": %d, \"n_unresolved\": %d,\n  ", c->n_pairs, c->n_contacts,
            c->n_unresolved);
    write_pairs(f, "crossings", c->n_listed, m->pairs);
    fprintf(f, ",\n");
}

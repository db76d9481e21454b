/* What steps strain edges by. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/strain_metric.h"

#include <math.h>
#include <string.h>

/* Of a mean edge; shorter ones count as so long. */
static const double SHORTEST = 1e-3;

static void strain(const void *context, const co_cage_edge *e, double block[9]) {
    const double *edge = context, unit = *edge * *edge;
    for (int i = 0; i < 9; i++)
        block[i] = i % 4 == 0 ? unit / (4 * fmax(e->square, SHORTEST * SHORTEST * unit)) : 0;
}

int32_t co_strain_metric(const co_cage_edges *edges, const double *x, double edge, co_sparse_hessian *hessian,
                         double *out, curvopt_error *error) {
    double *value = hessian->value;
    memset(out, 0, hessian->pattern.n_entries * sizeof *out);
    hessian->value = out;
    const int32_t status = co_cage_edges_add_hessian(edges, x, strain, &edge, hessian, error);
    hessian->value = value;
    return status;
}

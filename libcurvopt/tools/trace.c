/* The record of a run's iterations as a table. SPDX-License-Identifier: GPL-3.0-or-later */
#include "trace.h"

#include <math.h>
#include <stdlib.h>

void trace_add(trace *t, const curvopt_progress *progress) {
    if (t->n == t->room) {
        size_t room = t->room ? 2 * t->room : 256;
        curvopt_progress *row = room < SIZE_MAX / sizeof *row ? realloc(t->row, room * sizeof *row) : NULL;
        t->failed |= !row;
        if (!row)
            return;
        t->row = row;
        t->room = room;
    }
    t->row[t->n++] = *progress;
}

static void put(FILE *f, double x) {
    if (isfinite(x))
        fprintf(f, "%.17g,", x);
    else
        fputc(',', f);
}

void trace_write(FILE *f, const trace *t) {
    fputs("level,iteration,energy,gradient_norm,predicted,shift,gain_ratio,step,samples,method,rejected,seconds\n", f);
    for (size_t i = 0; i < t->n; i++) {
        const curvopt_progress *p = &t->row[i];
        fprintf(f, "%d,%d,", p->level, p->iteration);
        put(f, p->energy);
        put(f, p->gradient_norm);
        put(f, p->predicted);
        put(f, p->shift);
        put(f, p->gain_ratio);
        put(f, p->step);
        fprintf(f, "%d,%s,%d,%.6f\n", p->samples, curvopt_step_name(p->method), p->rejected, p->seconds);
    }
}

void trace_free(trace *t) {
    free(t->row);
    *t = (trace){0};
}

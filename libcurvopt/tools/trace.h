/* The record of a run's iterations as a table. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_TRACE_H
#define CURVOPT_TOOL_TRACE_H

#include "curvopt.h"

#include <stddef.h>
#include <stdio.h>

/* The records so far; all 0 is none. */
typedef struct trace {
    curvopt_progress *row; /* [n] their pointers are void */
    size_t n, room;
    int failed; /* memory was out: rows are missing */
} trace;

void trace_add(trace *t, const curvopt_progress *progress);
/* CSV: a header line, then one line for each record. A number that is not known is an empty field. */
void trace_write(FILE *file, const trace *t);
void trace_free(trace *t);

#endif

/* Results as JSON. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_JSON_H
#define CURVOPT_TOOL_JSON_H

#include "curvopt.h"

#include "held.h"
#include "measures.h"

#include <stdio.h>

/* What a report is made of; `summary` is NULL for an evaluation. */
typedef struct json_report {
    const curvopt_mesh_info *info;
    const curvopt_energies *energies;
    const curvopt_energies *start; /* of the input cage; with a summary */
    const curvopt_summary *summary;
    const curvopt_level_report *levels; /* [summary->n_levels] */
    const char *energy;                 /* as asked for */
    double spontaneous_curvature;       /* the same */
    const char *method;
    const held_list *held;    /* or NULL */
    const measures *measures; /* or NULL */
    const char *more;         /* further members, each ending in a comma and a line's end; or NULL */
} json_report;

/* One object, keys as the README lists them; numbers that do not exist are null. Nonzero if writing failed. */
int json_write(FILE *file, const json_report *report);

#endif

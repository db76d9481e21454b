/* The command line's arguments. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_ARGUMENTS_H
#define CURVOPT_TOOL_ARGUMENTS_H

#include "curvopt.h"

#include <stddef.h>

/* Exit codes of the programs. */
enum { ARGUMENTS_DONE = 0, ARGUMENTS_COULD_NOT = 1, ARGUMENTS_USAGE = 2 };

typedef struct arguments {
    const char *command, *input, *output, *json, *energy, *pins, *through, *trace, *deviation_from;
    curvopt_options options;
    curvopt_constraints constraints;
    curvopt_through points; /* of `through` */
    int boundary_rule;      /* -1: not named, the cage's */
    int quiet;
    int has_blend_width, has_volume, has_reduced_volume; /* they were named */
} arguments;

/* argv[1] is a command, the rest its options. ARGUMENTS_DONE, or an exit code with one sentence in message [size]. */
int arguments_parse(int argc, char **argv, arguments *out, char *message, size_t size);

#endif

/* Values of options, from text. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARSE_H
#define PARSE_H

#include "curvopt.h"

#include <stddef.h>

/* Each returns nonzero, or an index below 0, for text that is none. */
int parse_integer(const char *text, int32_t *out);
int parse_real(const char *text, double *out);
/* Index of the name that is text [length], or -1. */
int parse_name(const char *const *names, int n, const char *text, size_t length);
/* "mvs" or "mvs:1,willmore:0.1" into weights [CURVOPT_MAX_TERMS]. */
int parse_energy(const char *text, double *weights);
/* "keep", or planes such as "x,y". */
int parse_symmetry(const char *text, curvopt_options *options);
/* "keep", or a number, for a scalar (curvopt_scalar). */
int parse_scalar(const char *text, int scalar, curvopt_options *options);

#endif

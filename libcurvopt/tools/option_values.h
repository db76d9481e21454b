/* Values of options, from text. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARSE_H
#define PARSE_H

#include "curvopt.h"

/* Each returns nonzero for text that is none. */
int parse_integer(const char *text, int32_t *out);
int parse_real(const char *text, double *out);
/* "mvs" or "mvs:1,willmore:0.1" into weights [CURVOPT_MAX_TERMS]. */
int parse_energy(const char *text, double *weights);
/* "keep", or planes such as "x,y". */
int parse_symmetry(const char *text, curvopt_options *options);
/* "keep", or a number, for a scalar (curvopt_scalar). */
int parse_scalar(const char *text, int scalar, curvopt_options *options);
/* Least number of letters that are put in, left out or changed between texts; `to` is no longer than 63 letters. */
int edit_distance(const char *from, const char *to);

#endif

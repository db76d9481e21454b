/* curvopt-tao: input, solve, report.
 *
 * Every rank parses the arguments; rank 0 alone reads, prints and writes. Whatever is refused is refused by all: what
 * one rank finds wrong the others are told, and all end with the same code.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TAO_MAIN_H
#define CURVOPT_TAO_MAIN_H

#include "arguments.h"
#include "level.h"

/* On this rank. */
typedef struct program {
    MPI_Comm comm;
    PetscMPIInt rank, n_ranks;
    arguments args;
    run run;
    subdomain on;
    double *xyz; /* [3 n_own] */
    constraints_pins pins;
    double memory; /* of this rank, in bytes, at the end of the last level */
} program;

/* Said once; `code` is every rank's. */
int program_say(const program *p, int code, const char *what, const char *message);
/* Rank 0's failure, or success, is everybody's. */
int program_follow(const program *p, int code);

/* All collective, and the same code of arguments.h on every rank; what is wrong has been said. */

/* The cage, distributed: p->on and p->xyz. */
int input_cage(program *p);
/* p->pins, of the distributed cage. */
int input_pins(program *p);
/* The library's sentence on why it does not take the cage; `message` [COLLECTIVE_MESSAGE] if it has none. */
int input_refuse(const program *p, char *message);

/* -curvopt_gradient; a cage that is refused will be so again. */
int report_gradient(program *p);
/* Cage and report: both are complete before either is put in its place. */
int report_result(const program *p);

#endif

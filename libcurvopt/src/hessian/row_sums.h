/* Weighted sums of rows of numbers, compiled once per instruction set: what brings matrices of faces from points to
 * vertices (libcurvopt/notes/49-from-points-to-vertices.md). SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_HESSIAN_ROW_SUMS_H
#define CO_HESSIAN_ROW_SUMS_H

#include "base/instruction_set.h"

#include <stddef.h>
#include <stdint.h>

enum { CO_LEAST_ROW = 8 /* numbers */ };

/* A sum of some rows. */
typedef struct co_row_sum {
    size_t n;             /* terms */
    const double *weight; /* [n] */
    const int32_t *point; /* [n] */
    const int32_t *row;   /* the row of each point; below 0: none, and the term is left out */
} co_row_sum;

typedef struct co_row_sums {
    /* to [length] = the sum of rows [][length], from 0 on in the order of its terms. length >= CO_LEAST_ROW. */
    void (*add_up)(const co_row_sum *sum, size_t length, const double *rows, double *to);
} co_row_sums;

/* Those of an instruction set; NULL where it was not compiled. Bits are the same by all. */
const co_row_sums *co_row_sums_of(co_instruction_set set);

#endif

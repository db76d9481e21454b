/* Weighted sums of rows of numbers, by instruction set. SPDX-License-Identifier: GPL-3.0-or-later */
#include "hessian/row_sums.h"

CO_DECLARE_SETS(co_row_sums, co_row_sums);

const co_row_sums *co_row_sums_of(co_instruction_set set) {
    static const co_row_sums *const sets[CO_N_INSTRUCTION_SETS] = CO_OBJECTS_OF_SETS(co_row_sums);
    return sets[set];
}

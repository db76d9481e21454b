/* Energies, gradients and second derivatives of a block of faces, for each instruction set and in two precisions.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ELEMENT_KERNEL_H
#define CO_ENERGY_ELEMENT_KERNEL_H

#include "energy/element_block.h"

typedef struct co_element_kernel {
    int lanes;
    int is_single; /* in single precision */
    const char *name;
    void (*run)(const co_element_block *block);
    void (*run_second)(const co_element_hessian *block); /* NULL in single precision */
} co_element_kernel;

/* The widest kernel that this processor can run, in double or single precision; `wanted` (may be NULL) names one
 * instead. NULL if there is none such. */
const co_element_kernel *co_element_kernel_select(const char *wanted, int is_single);

#endif

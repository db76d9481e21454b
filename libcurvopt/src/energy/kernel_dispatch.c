/* Choice of the element kernel for this processor. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_kernel.h"

#include "base/instruction_set.h"

#include <string.h>

CO_DECLARE_SETS(co_element_kernel, co_element_kernel);

const co_element_kernel *co_element_kernel_select(const char *wanted) {
    static const co_element_kernel *const kernels[CO_N_INSTRUCTION_SETS] = CO_OBJECTS_OF_SETS(co_element_kernel);
    for (int set = CO_N_INSTRUCTION_SETS - 1; set >= 0; set--)
        if (co_has_instruction_set(set) && (!wanted || strcmp(wanted, kernels[set]->name) == 0))
            return kernels[set];
    return NULL;
}
